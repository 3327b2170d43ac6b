"""The report: a page that is whole, safe, small, and says what the result says."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from html_pages import Page
from studies import AMPLITUDES, GAUSSIAN, LOADS, MATERIAL, SURFACE, SURFACES, edited

import microslip as ms
from microslip.figures.picture import PictureCache
from microslip.figures.plot import Plot
from microslip.report.cells import quantity, signed
from microslip.report.html import page as html_page
from microslip.report.predicted import document as predicted_document
from microslip.report.predicted import tables
from microslip.report.predicted.document import document
from microslip.report.predicted.figures import _CAPTIONS, FIGURES, names
from microslip.study import surfaces

EXAMPLE = Path(__file__).parents[2] / "examples" / "al2017.toml"


def study(*edits: tuple[str, str], folder: Path = Path()) -> ms.Study:
    return ms.Study.from_toml(edited(*edits), folder=folder)


def page(*edits: tuple[str, str], folder: Path = Path()) -> Page:
    return Page(told(study(*edits, folder=folder).run()))


def told(result: ms.Result) -> str:
    return html_page(document(result), PictureCache())


# -- the page -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def demo() -> ms.Result:
    return ms.Study.load(EXAMPLE).run()


@pytest.fixture(scope="module")
def text(demo: ms.Result) -> str:
    shares: list[float] = []
    page = html_page(document(demo), PictureCache(), shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    return page


def test_the_page_is_whole_and_mails_well(text: str) -> None:
    found = Page(text)
    assert text.startswith("<!DOCTYPE html>")
    assert text.count("<!DOCTYPE") == 1
    assert len(text) < 700_000
    tags = [tag for tag, _ in found.tags]
    assert tags.count("html") == tags.count("head") == tags.count("body") == tags.count("main") == 1
    assert tags.count("title") == tags.count("h1") == 1
    assert ("meta", {"charset": "utf-8"}) in found.tags
    assert any(attrs.get("name") == "viewport" for tag, attrs in found.tags if tag == "meta")
    assert "@media print" in text


def test_names_on_the_page_are_unique_and_links_lead_somewhere(text: str) -> None:
    found = Page(text)
    names = [attrs["id"] for _, attrs in found.tags if "id" in attrs]
    assert len(set(names)) == len(names)
    links = [(attrs.get("href") or "")[1:] for tag, attrs in found.tags if tag == "a"]
    assert {link for link in links if "/" not in link} <= set(names)


def test_every_figure_is_on_the_page(text: str, demo: ms.Result) -> None:
    images = [attrs for tag, attrs in Page(text).tags if tag == "img"]
    assert len(images) == len(names(demo)) == text.count("<figcaption>")
    for attrs in images:
        kind, data = (attrs["src"] or "").split(",")
        assert kind == "data:image/svg+xml;base64"
        root = ET.fromstring(base64.b64decode(data, validate=True))
        paths = list(root.iter("{http://www.w3.org/2000/svg}path"))
        assert len(paths) > 10
        assert len(attrs["alt"] or "") > 20
    assert set(_CAPTIONS) == set(FIGURES)


def test_the_same_result_gives_the_same_page(demo: ms.Result, text: str) -> None:
    assert told(ms.Study.load(EXAMPLE).run()) == text


def test_a_figure_is_made_once_for_its_file_and_the_page(demo: ms.Result) -> None:
    drawn, calls = PictureCache(), []
    picture = document(demo).pictures[0]

    def plot() -> Plot:
        calls.append(picture.name)
        return picture.plot()

    counted = replace(picture, plot=plot)
    assert drawn.as_bytes(counted) is drawn.as_bytes(counted)
    assert drawn.as_bytes(counted, "png").startswith(b"\x89PNG\r\n\x1a\n")
    assert calls == ["loops"]


# -- what others wrote --------------------------------------------------------------------------


# -- numbers ------------------------------------------------------------------------------------


def test_the_slip_scale_is_said_in_words() -> None:
    heights = (
        '{ kind = "scipy", distribution = "weibull_max", parameters = { c = 2.5 }, scale = "1 um" }'
    )
    found = told(study((GAUSSIAN, heights)).run())
    assert "The slip scale is κ times the spread of the heights (the standard deviation," in found
    assert "slip_per_indentation *" not in found


def test_the_tables_say_what_the_joint_says(demo: ms.Result) -> None:
    found = Page(told(demo))
    head, *rows = found.table("Contacts")
    assert head == [
        "Load",
        "Contacts",
        "Real area",
        "Mean pressure",
        "kₙ",
        "kₜ",
        "μN",
        "Slip scale",
        "h",
    ]
    # The project's worked numbers, computed independently with 30 digits.
    assert rows[1] == [
        *(
            "2 kN",
            "5700",
            "2.79 %",
            "358 MPa",
            "7.10 GN/m",
            "5.70 GN/m",
            "1.10 kN",
            "343 nm",
            "0.568",
        )
    ]
    assert rows[2][-1] == "−0.005"
    head, *rows = found.table("Amplitude")
    assert len(rows) == 12
    joint = demo.joints[1]
    assert rows[5] == [
        *("2 kN", "300 nm", f"{joint.backbone(3e-7):.1f} N"),
        f"{joint.backbone(3e-7) / joint.force_limit:.3f}",
        f"{1e6 * joint.dissipated_energy(3e-7):.0f} µJ",
        f"{joint.loss_factor(3e-7):.3f}",
        f"{joint.damping_ratio(3e-7):.3f}",
        f"{joint.secant_stiffness(3e-7) / 1e9:.2f} GN/m",
        f"{joint.dissipation_exponent(3e-7):.2f}",
        f"{100.0 * joint.stick_area(3e-7) / joint.contact_area:.1f} %",
    ]
    assert rows[7][3] == "1.000"
    assert rows[7][-1] == "<0.01 %"


def test_what_is_not_known_has_no_column() -> None:
    found = page((SURFACE, SURFACES["table"]), (LOADS, '"50 N"'))
    assert found.table("kₙ")[0] == ["Load", "kₙ", "kₜ", "μN", "Slip scale"]
    assert "Sticking share" not in found.table("Amplitude")[0]
    assert "sticking share" not in found.words["p"]


def test_force_amplitudes_come_first_where_they_were_chosen() -> None:
    found = page((f"amplitudes = {AMPLITUDES}", 'force_amplitudes = ["50 N", "100 N"]'))
    head, *rows = found.table("Force amplitude")
    assert head[:3] == ["Load", "Force amplitude", "Amplitude"]
    assert [row[1] for row in rows] == ["50 N", "100 N"] * 2
    assert "cycled at 2 force amplitudes, 50 N to 100 N." in found.words["p"]


def test_a_history_has_its_table(tmp_path: Path) -> None:
    (tmp_path / "record.csv").write_text("x [um]\n0\n1\n-1\n0.5\n")
    history = 'history = { file = "record.csv", column = "x" }'
    result = study(("[excitation]", f"[excitation]\n{history}"), folder=tmp_path).run()
    found = Page(told(result))
    row = found.table("Largest displacement")[1]
    assert row[:2] == ["500 N", "1.00 µm"]
    energy = result.histories[0].dissipated_energy[-1]
    assert row[3] == f"{1e6 * energy:.0f} µJ"
    assert "along a history of 4 samples." in found.words["p"]
    assert '4 displacements, column "x" of record.csv' in found.words["td"]
    assert 'excitation.history: 4 values from record.csv, column "x [um]"' in found.words["li"]


def test_long_tables_say_what_they_leave_out() -> None:
    loads = str([f"{i} N" for i in range(1, 101)]).replace("'", '"')
    amplitudes = str([f"{i} um" for i in range(1, 20)]).replace("'", '"')
    found = page((LOADS, loads), (AMPLITUDES, amplitudes))
    joints, cycles = found.table("Contacts")[1:], found.table("Amplitude")[1:]
    assert len(joints) == tables.MOST_JOINTS
    assert (joints[0][0], joints[-1][0]) == ("1 N", "100 N")
    assert len(cycles) <= tables.MOST_CYCLES
    assert (cycles[0][:2], cycles[-1][:2]) == (["1 N", "1 µm"], ["100 N", "19 µm"])
    left = 100 - len(joints), 1900 - len(cycles)
    for count in left:
        assert f"{count} more rows: all are in summary.json." in found.words["p"]
    assert "100 values, 1 N to 100 N" in found.words["td"]


# -- validity -----------------------------------------------------------------------------------


def test_the_verdict_comes_first(text: str) -> None:
    found = Page(text)
    verdict = text[text.index('<div class="verdict') : text.index("</div>")]
    assert verdict.startswith('<div class="verdict watch">')
    assert "Read with care:" in verdict
    assert "plasticity index 0.721 (ok up to 0.6): watch" in verdict
    assert text.index("verdict watch") < text.index("<h2>")
    rows = found.table("What is judged")[1:]
    assert [row[1:4] for row in rows] == [
        ["real over apparent area", "0.780 % to 6.31 %", "up to 1 %"],
        ["plasticity index", "0.721", "up to 0.6"],
        ["density × radius × std", "0.0500", "up to 0.1"],
        ["contact radius over summit spacing", "0.154 to 0.200", "up to 0.25"],
        ["contacts", "2081 to 10041", "from 30"],
    ]
    assert rows[0][0] == "! watch at 2 kN and 5 kN"
    assert rows[1][0] == "! watch"
    assert {row[0] for row in rows[2:]} == {"✓ ok"}


def test_the_worst_verdict_counts_and_its_loads_are_named() -> None:
    found = page((LOADS, '["1 mN", "500 N", "50 kN", "200 kN"]'))
    assert "✗ Outside the model’s range:" in found.words["strong"]


def test_no_doubts_and_no_limits_are_said_as_well() -> None:
    hard = (MATERIAL, f'{MATERIAL}hardness = "12 GPa"\n')
    light = (LOADS, '"500 N"')
    assert "✓ All assumptions of the model hold." in page(hard, light).words["strong"]
    unjudged = page(light)
    assert "? All that could be judged holds; not judged:" in unjudged.words["strong"]
    assert "plasticity index not known (ok up to 0.6): not judged" in unjudged.words["li"]
    table = (SURFACE, SURFACES["table"])
    unknown = page(table, (LOADS, '"500 N"'))
    assert "? No limits are known for this law" in unknown.words["strong"]
    assert "No limits are known for this law." in unknown.words["p"]


# -- study --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SURFACES)
def test_every_surface_has_a_page_with_its_law(name: str) -> None:
    found = page((SURFACE, SURFACES[name]), (LOADS, '"50 N"'))
    law = re.search(r'law = "([\w-]+)"', SURFACES[name])
    assert law
    assert predicted_document.LAWS[law[1]][0] in found.words["td"]
    equations = found.words["span"]
    numbers = {
        "greenwood-williamson": "(19.8)",
        "population": "(19.3), (19.27)",
        "sphere": "(19.3)",
        "table": "",
    }
    assert f"(19.12){numbers[law[1]]}(19.15)" in equations
    assert ("is the table of the study" in found.words["p"]) == (law[1] == "table")
    assert ("(19.7), (19.9)" in equations) == (law[1] != "table")


def test_the_study_is_there_in_words_and_as_a_file(demo: ms.Result) -> None:
    found = Page(told(demo))
    rows = {row[0]: row[1] for rows in found.cells for row in rows if len(row) == 2}
    assert rows["Young's modulus E"] == "69 GPa"
    assert rows["Summits per apparent area"] == "100 per mm²"
    assert rows["Apparent area"] == "2 cm²"
    assert rows["Normal load"] == "500 N, 2 kN, 5 kN"
    assert rows["Amplitudes of the curves"] == "1 nm to 100 µm, 200 points"
    assert rows["Coefficient of friction"] == "0.55"
    assert found.words["pre"] == demo.study.text


def test_where_values_are_from_is_noted() -> None:
    found = page((MATERIAL, ""), ('["al", "al"]', '["steel", "steel"]'))
    result = study((MATERIAL, ""), ('["al", "al"]', '["steel", "steel"]'))
    assert result.notes
    for note in result.notes:
        assert note in found.words["li"]


def test_a_long_study_is_cut() -> None:
    values = ", ".join(f'"{i} nm"' for i in np.random.default_rng(0).integers(1, 999, 5000))
    found = page((GAUSSIAN, f'{{ kind = "values", values = [{values}] }}'))
    assert len(found.words["pre"]) == 20_001
    assert found.words["pre"].endswith("…")
    assert "The rest is in the file beside this page." in found.words["p"]
    assert "5000 values, 1 nm to 998 nm" in found.words["td"]


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (5e-7, "m", "500 nm"), (2e-4, "m^2", "2 cm²"), (1e-15, "m^2", "0.001 µm²"),
        (3e-6, "m^2", "3 mm²"), (1e8, "1/m^2", "100 per mm²"), (20.0, "1/m^2", "20 per m²"),
        (0.33, "", "0.33"), ("exponential", "", "exponential"),
        ({"c": 2.0, "a": 1.5}, "", "c = 2, a = 1.5"), ({}, "", "none"),
        ((1.0, 2.0), "N", "1 N, 2 N"), (tuple(range(1, 12)), "N", "11 values, 1 N to 11 N"),
    ],
)  # fmt: skip
def test_quantities_are_written_for_readers(value: Any, unit: str, text: str) -> None:
    assert quantity(value, unit) == text


# -- equations, provenance ----------------------------------------------------------------------


def test_minus_signs() -> None:
    """Of all numbers in a cell, but not of exponents, names and ranges of words."""
    assert signed("2.7e-16 m²") == "2.7e-16 m²"
    assert signed("half-space-2") == "half-space-2"


def test_equations_are_well_formed_mathml(text: str) -> None:
    formulas = re.findall(r"<math.*?</math>", text, flags=re.DOTALL)
    assert len(formulas) > 20
    arity = {"mfrac": 2, "msub": 2, "msup": 2, "msubsup": 3, "munder": 2}
    core = {"math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "msqrt", *arity}
    for formula in formulas:
        for node in ET.fromstring(formula).iter():
            assert node.tag in core
            assert len(node) == arity.get(node.tag, len(node)), formula
            if node.tag in ("mi", "mn", "mo", "mtext"):
                assert not len(node)
                assert (node.text or "").strip()


def test_provenance_and_files(text: str, demo: ms.Result) -> None:
    found = Page(text)
    kernel = demo.summary["generator"]["kernel"]
    assert f"Made by microslip {ms.__version__} ({kernel} kernel)." in found.words["p"]
    listed = found.words["li"]
    for name in demo.summary["files"]:
        stem, _, kind = name.partition(".")
        if name != "report.html":
            assert (stem if kind in ("svg", "png") else name) in listed


def test_no_law_is_without_its_words() -> None:
    laws = {model.tag_value("law") for model in surfaces.SURFACE_TABLES.values()}
    assert laws == set(predicted_document.LAWS)
