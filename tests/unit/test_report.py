"""The report: a page that is whole, safe, small, and says what the result says."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
from html_pages import Page
from studies import AMPLITUDES, LOADS, MATERIAL, SURFACE, SURFACES, edited

import microslip as ms
from microslip.figures.picture import PictureCache
from microslip.report.cells import quantity_text
from microslip.report.html import html_page as html_page
from microslip.report.predicted import document as predicted_document
from microslip.report.predicted.document import prediction_document
from microslip.report.predicted.figures import _CAPTIONS, PREDICTION_FIGURES, figure_names_of
from microslip.study import surfaces

EXAMPLE = Path(__file__).parents[2] / "examples" / "al2017.toml"


def study(*edits: tuple[str, str], folder: Path = Path()) -> ms.Study:
    return ms.Study.from_toml(edited(*edits), folder=folder)


def page(*edits: tuple[str, str], folder: Path = Path()) -> Page:
    return Page(told(study(*edits, folder=folder).run()))


def told(result: ms.Result) -> str:
    return html_page(prediction_document(result), PictureCache())


# -- the page -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def demo() -> ms.Result:
    return ms.Study.load(EXAMPLE).run()


@pytest.fixture(scope="module")
def text(demo: ms.Result) -> str:
    shares: list[float] = []
    page = html_page(prediction_document(demo), PictureCache(), shares.append)
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
    assert len(images) == len(figure_names_of(demo)) == text.count("<figcaption>")
    for attrs in images:
        kind, data = (attrs["src"] or "").split(",")
        assert kind == "data:image/svg+xml;base64"
        root = ET.fromstring(base64.b64decode(data, validate=True))
        paths = list(root.iter("{http://www.w3.org/2000/svg}path"))
        assert len(paths) > 10
        assert len(attrs["alt"] or "") > 20
    assert set(_CAPTIONS) == set(PREDICTION_FIGURES)


def test_the_same_result_gives_the_same_page(demo: ms.Result, text: str) -> None:
    assert told(ms.Study.load(EXAMPLE).run()) == text


# -- what others wrote --------------------------------------------------------------------------


# -- numbers ------------------------------------------------------------------------------------


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
        "kₜ at a rig",
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
            "456 MN/m",
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


# -- validity -----------------------------------------------------------------------------------


def test_the_verdict_comes_first(text: str) -> None:
    found = Page(text)
    verdict = text[text.index('<div class="verdict') : text.index("</div>")]
    assert verdict.startswith('<div class="verdict watch">')
    assert "Interpret with care:" in verdict
    assert "plasticity index 0.841 (ok up to 0.6): watch" in verdict
    assert text.index("verdict watch") < text.index("<h2>")
    rows = found.table("Judged quantity")[1:]
    assert [row[1:4] for row in rows] == [
        ["real over apparent area", "0.780 % to 6.31 %", "up to 1 %"],
        ["plasticity index", "0.841", "up to 0.6"],
        ["density × radius × std", "0.0500", "up to 0.1"],
        ["contact radius over summit spacing", "0.154 to 0.200", "up to 0.25"],
        ["contacts", "2081 to 10041", "from 30"],
    ]
    assert rows[0][0] == "! watch at 2 kN and 5 kN"
    assert rows[1][0] == "! watch"
    assert {row[0] for row in rows[2:]} == {"✓ ok"}


def test_no_doubts_and_no_limits_are_said_as_well() -> None:
    hard = (MATERIAL, f'{MATERIAL}hardness = "6 GPa"\n')
    light = (LOADS, '"500 N"')
    assert "✓ All assumptions of the model hold." in page(hard, light).words["strong"]
    unjudged = page(light)
    assert "? All judged assumptions hold; not judged:" in unjudged.words["strong"]
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
    assert predicted_document.LAW_WORDS[law[1]][0] in found.words["td"]
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
    assert quantity_text(value, unit) == text


# -- equations, provenance ----------------------------------------------------------------------


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


def test_no_law_is_without_its_words() -> None:
    laws = {model.tag_value("law") for model in surfaces.SURFACE_TABLES.values()}
    assert laws == set(predicted_document.LAW_WORDS)
