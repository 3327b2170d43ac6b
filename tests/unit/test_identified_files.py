"""What an identification leaves behind: tables, figures, the page, the study."""

from __future__ import annotations

import csv
import io
import json
import re
import tomllib
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.figures.plot import Words
from microslip.identification.figures import intervals, pictures
from microslip.report.document import Judged, Table
from microslip.report.files import write
from microslip.report.identified import numbers
from microslip.report.identified.document import (
    Identified,
    document,
    identified,
)
from microslip.report.identified.numbers import joint_text
from microslip.report.terminal import print_document

JOINT = ms.Interface.examples()[0]
STUDY = """
schema = 1
title = "Mine"
[material.mine]
young_modulus = "69 GPa"
poisson_ratio = 0.33
[surface]
law = "greenwood-williamson"
materials = ["mine", "mine"]
heights = { kind = "gaussian", std = "1 um" }
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"
[joint]
friction_coefficient = 0.4
normal_load = "1 kN"
"""
OPTIONS: dict[str, Any] = {
    "fixed": {}, "bounds": {}, "contact_area": None, "held_back": 0.25, "summits": np.inf,
}  # fmt: skip


def record(load: float, amplitude: float, **how: Any) -> ms.Record:
    rig = ms.VirtualTribometer(
        JOINT.at(normal_load=load),
        **{"rig_stiffness": 5e8, "noise": 0.003, "sample_rate": 2560, "seed": int(load), **how},
    )
    return rig.record(amplitude=amplitude, frequency=10.0, cycles=6)


@lru_cache
def rich() -> Identified:
    records = [record(load, top) for load in (500.0, 2000.0) for top in (1.5e-6, 6e-6)]
    return identified(
        records, ["interface"], ms.Study.from_toml(STUDY), OPTIONS, lambda share: None
    )


@lru_cache
def poor() -> Identified:
    records = [record(2000.0, 2e-5, rig_stiffness=1e8, noise=0.01)]
    return identified(
        records, ["interface"], ms.Study.from_toml(STUDY), OPTIONS, lambda share: None
    )


# -- words and numbers -----------------------------------------------------------------------------


def number(verdict: str, low: float | None = 1.0, high: float | None = 2.0) -> dict[str, Any]:
    return {
        "value": 1.5, "unit": "", "low": low, "high": high, "verdict": verdict,
        "low_open": verdict == "bounded above", "high_open": verdict == "bounded below",
        "reason": "why", "remedy": "how",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("verdict", "value", "interval"),
    [
        ("identified", "1.50", "1.00 … 2.00"),
        ("in doubt", "1.50", "1.00 … 2.00"),
        ("fixed", "1.50", "–"),
        ("bounded above", "–", "up to 2.00"),
        ("bounded below", "–", "from 1.00"),
        ("not identified", "–", "1.00 … 2.00"),
    ],
)
def test_no_value_where_none_is_known(verdict: str, value: str, interval: str) -> None:
    fitted = number(verdict)
    assert (numbers.value_text(fitted), numbers.interval_text(fitted)) == (value, interval)
    left_open = numbers.open_parameters({"parameters": {"slip_scale": fitted}})
    assert bool(left_open) == (verdict not in ("identified", "fixed"))


class Terminal(io.StringIO):
    """A terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("width", [80, 140])
def test_value_and_interval_are_beside_each_other(
    width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where a terminal is narrow: a value without its interval says little."""
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setenv("NO_COLOR", "1")
    stream = Terminal()
    print_document(document(rich()), stream)
    lines = stream.getvalue().splitlines()
    one = rich().first.parameters["slip_scale"]
    low, high = (numbers.quantity(end, "m", 3) for end in (one.low, one.high))
    (line,) = [line for line in lines if line.startswith("slip scale κσ")][:1]
    assert f"{low} … {high}" in line
    assert len(re.findall(r"\d nm", line)) == 3
    assert all(len(line.rstrip()) <= width for line in lines)


@pytest.mark.slow
def test_records_that_differ_leave_a_trace(tmp_path: Path) -> None:
    """In the study, on the page and in every verdict; in the words of who asked."""
    records = [record(500.0, 6e-6), record(2000.0, 6e-6, rig_stiffness=2e8)]
    found = identified(
        records, ["interface"], ms.Study.from_toml(STUDY), OPTIONS, lambda share: None
    )
    assert found.first.status == "records differ: rigs"
    assert not any(one.verdict == "identified" for one in found.first.parameters.values())
    assert not any(one.verdict == "identified" for one in found.first.derived.values())
    assert found.first.parameters["friction_coefficient"].verdict == "in doubt"

    def say(text: str) -> str:
        return text.replace("`rigs=...`", "--rig LABEL")

    write(document(found, say, files=True), tmp_path)
    text = (tmp_path / "joint.toml").read_text("utf-8")
    assert "# RECORDS DIFFER: RIGS" in text
    assert "# IN DOUBT: friction coefficient μ" in text
    for name in ("joint.toml", "report.html", "summary.json"):
        text = (tmp_path / name).read_text("utf-8")
        assert "--rig LABEL" in text.replace("\n# ", " "), name
        assert "rigs=" not in text, name


# -- files -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module", name="written")
def _written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("written")
    shares: list[float] = []
    told = write(document(rich(), files=True), folder, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    assert told.data == json.loads((folder / "summary.json").read_text("utf-8"))
    return folder


def test_files(written: Path) -> None:
    summary = json.loads((written / "summary.json").read_text("utf-8"))
    assert sorted(summary["files"]) == sorted(path.name for path in written.iterdir())
    with (written / "residuals.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    result = rich().first
    assert len(rows) == sum(r.residual.size for r in result.records)
    left = [float(row["measured force [N]"]) - float(row["model force [N]"]) for row in rows]
    np.testing.assert_allclose(left, [float(row["residual [N]"]) for row in rows], atol=1e-9)


def test_the_page_names_unknown_numbers(tmp_path: Path) -> None:
    write(document(poor(), files=True), tmp_path)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "Not identified</h2>" in page
    assert "To determine it:" in page
    assert "separation h = d/σ at 2 kN, not identified" in page
    assert 'class="verdict watch"' in page
    text = (tmp_path / "joint.toml").read_text("utf-8")
    assert "# NOT identified, one of many values" in text


def test_the_study_is_the_joint() -> None:
    text, why = joint_text(rich().first, rich().study)
    assert why == ""
    assert text is not None
    study = tomllib.loads(text)
    assert study["title"] == "Mine: identified"
    assert study["surface"]["materials"] == ["mine", "mine"]
    assert study["joint"]["normal_load"] == ["500 N", "2 kN"]
    result = ms.Study.from_toml(text).run()
    for joint, load in zip(result.joints, (500.0, 2000.0), strict=True):
        truth = JOINT.at(normal_load=load)
        assert joint.force_limit == pytest.approx(truth.force_limit, rel=2e-3)
        assert joint.tangential_stiffness == pytest.approx(truth.tangential_stiffness, rel=0.05)
    # Amplitudes of the joint itself: those at the transducer less what the rig gives.
    largest = 6e-6 - JOINT.at(normal_load=500.0).force_limit / 5e8
    assert max(result.study.excitation.amplitudes or ()) == pytest.approx(largest, rel=2e-3)


def test_no_study_without_materials() -> None:
    bare = Identified(rich().results, None, None)
    text, why = joint_text(bare.first, bare.study)
    assert text is None
    assert "materials are not known" in why


def test_the_study_of_another_law_names_its_file(tmp_path: Path) -> None:
    jenkins = identified([record(500.0, 6e-6)], ["jenkins"], None, OPTIONS, lambda share: None)
    write(document(jenkins), tmp_path)
    (joint,) = ms.Study.load(tmp_path / "joint.toml").run().joints
    assert isinstance(joint, ms.Jenkins)
    assert joint.stiffness == jenkins.first.joint().stiffness


# -- figures ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("which", [rich, poor], ids=["rich", "poor"])
def test_every_figure_is_of_finite_numbers(which: Any) -> None:
    names = [picture.name for picture in pictures(which().first)]
    assert names == ["loops", "intervals", "profiles"]
    for picture in pictures(which().first):
        for panel in picture.plot().panels:
            for item in panel.items:
                for values in (getattr(item, "x", 0.0), getattr(item, "y", 0.0)):
                    assert np.isfinite(values).all(), picture.name


def test_intervals_say_the_verdict() -> None:
    plot = intervals(poor().first)
    notes = [panel.note for panel in plot.panels]
    assert "separation h = d/σ at 2 kN: not identified" in notes
    assert "friction coefficient μ" in notes
    ticks = [
        text for _, text in (*(plot.panels[-1].x.ticks or ()), *(plot.panels[-1].y.ticks or ()))
    ]
    assert "h at 2 kN" in ticks
    assert any(isinstance(item, Words) for item in plot.panels[-1].items)


def test_the_same_files_each_time(written: Path, tmp_path: Path) -> None:
    write(document(rich(), files=True), tmp_path)
    for path in sorted(written.iterdir()):
        assert path.read_bytes() == (tmp_path / path.name).read_bytes(), path.name


def counted() -> Identified:
    """Of whose summits nobody knows the number."""
    records = [record(load, 6e-6) for load in (500.0, 2000.0)]
    options = {**OPTIONS, "summits": None, "held_back": 0.0}
    return identified(records, ["interface"], None, options, lambda share: None)


def misfit() -> Identified:
    records = [record(2000.0, top) for top in (1.5e-6, 6e-6)]
    options = {**OPTIONS, "summits": None, "held_back": 0.0}
    return identified(records, ["jenkins"], None, options, lambda share: None)


@pytest.mark.parametrize("which", [rich, poor, counted, misfit])
def test_page_terminal_and_python_say_the_same_of_a_fit(which: Any, tmp_path: Path) -> None:
    outcome = which()
    fitted = {**outcome.first.parameters, **outcome.first.derived}
    whole = document(outcome)
    write(whole, tmp_path)
    stream = io.StringIO()
    print_document(whole, stream, full=True)
    printed = stream.getvalue()
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    page = re.sub(r"<[^>]+>", " ", html).replace("\N{MINUS SIGN}", "-")
    rows = [row for block in whole.blocks() if isinstance(block, Table) for row in block.rows]
    of_numbers = [row for row in rows if len(row) == 3 and isinstance(row[2], Judged)]
    assert [row[2].text for row in of_numbers] == [number.verdict for number in fitted.values()]
    for name, value, judged in of_numbers:
        assert re.search(rf"{re.escape(name)} +{re.escape(value)} +.?.?{judged.text}", printed)
        assert re.search(rf"{re.escape(name)}\s+{re.escape(value)}\s+.?\s*{judged.text}", page)
    is_sure = all(number.verdict in ("identified", "fixed") for number in fitted.values())
    assert ("<strong>\N{CHECK MARK}" in html) == is_sure == (whole.word == "ok")
    assert (which is rich) == is_sure
    if which in (counted, misfit):
        assert "apparent" in {number.verdict for number in fitted.values()}
