"""Studies whose surface comes from a scan, or whose heights come from a table of their density."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import run
from jsonschema import Draft7Validator
from studies import GAUSSIAN, SURFACE, edited

import microslip as ms
from microslip.report.predicted.document import equations
from microslip.report.predicted.preview import preview
from microslip.scans import random_surface
from microslip.study.build import build_surface
from microslip.study.json_schema import json_schema

SCAN = """law = "scan"
scan = "ground.npy"
unit = "um"
pixel = "1 um"
cutoff = "6 um"
"""
LOADS = ('["500 N", "2 kN"]', '["0.05 N", "0.2 N"]')
TABLE = (
    '{ kind = "table", height = { file = "h.csv", column = "y" }, '
    'density = ["0 1/um", "2 1/um", "0 1/um"] }'
)
VALIDATOR = Draft7Validator(json_schema())


def scan_study(*edits: tuple[str, str]) -> str:
    text = edited((SURFACE, SCAN), LOADS)
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


@pytest.fixture(name="home")
def _home(tmp_path: Path) -> Path:
    scan = random_surface((96, 96), 1e-6, m0=1e-13, m2=1e-3, m4=4e7, seed=3)
    np.save(tmp_path / "ground.npy", scan.heights * 1e6)
    (tmp_path / "h.csv").write_text("y [um]\n-1\n0\n1\n")
    return tmp_path


def summits(home: Path, cutoff: float | None = 6e-6) -> ms.Summits:
    scan = ms.Scan.read(home / "ground.npy", unit="um", pixel=1e-6)
    return scan.summits(cutoff, level="plane")


@pytest.mark.parametrize(
    ("line", "law"),
    [
        ("", "Load of the surface at the separation"),
        ('heights = "population"\n', "Load of the given summits"),
        ('estimate = "persson"\n', "Mean separation"),
    ],
)
def test_equations_are_those_of_the_law_of_the_scan(home: Path, line: str, law: str) -> None:
    text = scan_study(("cutoff", f'area = "1 mm^2"\n{line}cutoff')) if line else scan_study()
    shown = equations(ms.Study.from_toml(text, folder=home).run())
    laws = ("Load of the surface", "Load of the given", "Mean separation")
    assert law in shown
    assert sum(other in shown for other in laws) == 1


@pytest.mark.parametrize("estimate", ["counted", "neighbours", "mccool", "nayak"])
def test_each_estimate_is_that_of_the_library(home: Path, estimate: str) -> None:
    text = scan_study(("cutoff", f'estimate = "{estimate}"\narea = "1 mm^2"\ncutoff'))
    surface = ms.Study.from_toml(text, folder=home).run().joints[0].surface
    wanted = summits(home).statistics(estimate)  # type: ignore[arg-type]
    assert isinstance(surface, ms.GreenwoodWilliamson)
    assert surface.density == wanted.density
    assert surface.radius == wanted.radius
    assert surface.heights == ms.Gaussian(wanted.std, wanted.mean_height)
    assert surface.area == 1e-6


def test_a_population_of_the_summits_themselves(home: Path) -> None:
    text = scan_study(("cutoff", 'estimate = "population"\ncutoff'))
    study = ms.Study.from_toml(text, folder=home)
    surface = study.run().joints[0].surface
    found = summits(home)
    assert isinstance(surface, ms.AsperityPopulation)
    assert set(np.asarray(surface.heights)) == set(found.heights)
    # Of the whole scan, edges included, where no summit can be seen.
    assert surface.summit_count == pytest.approx(found.density * found.scan.area, rel=1e-14)


@pytest.mark.slow
def test_a_spectrum_is_that_of_the_library(home: Path) -> None:
    """From the scan, and from the file that the command writes."""
    wanted, area = summits(home), 'area = "1 mm^2"\n'

    def surface(text: str) -> Any:
        return build_surface(ms.Study.from_toml(text, folder=home))

    found = surface(scan_study(("cutoff", f'{area}estimate = "persson"\ncutoff')))
    curve = ms.PerssonCurve.from_spectrum(wanted.scan.spectrum(), found.pair, 1e-6)
    assert found.separation(0.2) == curve.to_surface().separation(0.2)
    share = curve.contact_share(0.2)
    assert found.contact_area(found.separation(0.2)) == pytest.approx(1e-6 * share, rel=1e-12)
    rings = zip(curve.wavenumber.tolist(), curve.spectrum.tolist(), strict=True)
    rows = [f"{q!r},{c!r}" for q, c in rings]
    (home / "s.csv").write_text("\n".join(["q [rad/m],C [m^4]", *rows, "1e9,0"]) + "\n")
    file = '{ file = "s.csv", column = '
    law = f'law = "persson"\n{area}wavenumber = {file}"q" }}\nspectrum = {file}"C" }}\n'
    assert surface(edited((SURFACE, law), LOADS)).separation(0.2) == pytest.approx(
        curve.to_surface().separation(0.2), rel=1e-12
    )
    for old, new, key in (
        ("spectrum", "rms = 3\n#", "surface.rms"),
        (area, f'{area}rms = "1 um"\n', "surface.rms"),
        ("wavenumber =", "#", "surface.wavenumber"),
    ):
        with pytest.raises(ms.StudyError, match=f"^study: {key}: "):
            surface(edited((SURFACE, law.replace(old, new, 1)), LOADS))


SAID = "surface.scan: ground.npy, cut-off 6 µm:"


def test_the_cutoff_is_in_every_result(home: Path) -> None:
    study = ms.Study.from_toml(scan_study(), folder=home)
    summary = study.run().summary
    assert summary["study"]["surface"]["cutoff"] == 6e-6
    assert summary["scan"]["cutoff"] == 6e-6
    assert summary["scan"]["count"] == summits(home).count
    assert summary["scan"]["counted"]["radius"] == summits(home).statistics().radius
    assert any(note.startswith(SAID) for note in summary["notes"])
    names = [verdict["name"] for verdict in summary["joints"][0]["validity"]]
    assert "summit radius in pixels" in names
    assert "density * radius * std" in names
    assert dict(_rows(study))["Short-wave cut-off"] == "6 µm"


@pytest.mark.slow
def test_the_cutoff_is_in_every_file(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(home)
    Path("joint.toml").write_text(scan_study(), encoding="utf-8")
    outcome = run("predict", "joint.toml", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    assert SAID in outcome.stdout
    summary = json.loads(Path("out/summary.json").read_text("utf-8"))
    assert any(note.startswith(SAID) for note in summary["notes"])
    page = Path("out/report.html").read_text("utf-8")
    assert '<th scope="row">Short-wave cut-off</th><td>6 µm</td>' in page
    assert SAID in page
    again = ms.Study.load("out/study.toml").run()
    assert again.summary["scan"] == summary["scan"]
    assert run("check", "joint.toml").exit_code == 0


def test_no_cutoff_has_to_be_said_and_is_shown(home: Path) -> None:
    study = ms.Study.from_toml(scan_study(('"6 um"', '"none"')), folder=home)
    found = preview(study)
    assert any("no cut-off: limited by the pixel" in note for note in found.data["notes"])
    surface = study.run().joints[0].surface
    assert surface.radius == summits(home, None).statistics().radius  # type: ignore[attr-defined]
    page_rows = dict(_rows(study))
    assert page_rows["Short-wave cut-off"] == "none: limited by the pixel"


def _rows(study: ms.Study) -> list[tuple[str, str]]:
    from microslip.report.predicted.document import study_facts

    return list(next(facts.rows for facts in study_facts(study) if facts.title == "Surface"))


def test_keys_are_those_of_the_reading_and_the_conditioning(home: Path) -> None:
    np.savez(home / "two.npz", z=np.load(home / "ground.npy"), other=np.eye(40))
    text = scan_study(
        ('"ground.npy"', '"two.npz"\nformat = "npz"\nkey = "z"'),
        ('"1 um"', '["1 um", "2 um"]\nvalid = ["-1 um", "0.5 um"]'),
        (
            "cutoff",
            'long_cutoff = "60 um"\noutliers = 8\nlevel = "quadratic"\nfill = true\n'
            'prominence = "30 nm"\ncutoff',
        ),
    )
    study = ms.Study.from_toml(text, folder=home)
    VALIDATOR.validate(study._tables)
    scan = ms.Scan.read(
        home / "two.npz", unit="um", pixel=(1e-6, 2e-6), key="z", valid=(-1e-6, 5e-7)
    )
    assert scan.missing > 0.0
    scan = scan.condition(level="quadratic", outliers=8.0, fill="interpolate", long_cutoff=6e-5)
    surface = study.run().joints[0].surface
    wanted = scan.summits(6e-6, prominence=3e-8)
    assert surface.density == wanted.density  # type: ignore[attr-defined]
    assert wanted.count != scan.summits(6e-6).count


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('cutoff = "6 um"\n', "", 'surface.cutoff: missing; write for example cutoff = "10 um"'),
        ('"6 um"', '"6"', 'surface.cutoff: wanted a length such as "10 um", or "none", got "6"'),
        ('"6 um"', "6", 'surface.cutoff: wanted a length such as "10 um", or "none", got 6'),
        ('"6 um"', '"no"', 'surface.cutoff: wanted a length such as "10 um", or "none", got "no"'),
        ("cutoff", "cuttoff", 'surface.cuttoff: unknown key; did you mean "cutoff"?'),
        ("ground", "groud", "surface.scan: groud.npy: no such file in the folder of the study"),
        ('unit = "um"\n', "", "surface.scan: ground.npy: the file does not say the unit"),
        ('"ground.npy"', "3", 'surface.scan: wanted the name of a scan such as "ground.plu"'),
        ("cutoff", 'level = "cubic"\ncutoff', 'surface.level: wanted "plane", "quadratic",'),
        ("cutoff", 'estimate = "mcool"\ncutoff', 'surface.estimate: wanted "counted", "neighb'),
        (
            "cutoff",
            'estimate = "persson"\nheights = "table"\ncutoff',
            "surface.heights: wanted none",
        ),
        ("cutoff", "outliers = 1\ncutoff", "surface.outliers: wanted a number of at least 2"),
        ("cutoff", "channel = true\ncutoff", "surface.channel: wanted a channel such as"),
        ("cutoff", 'prominence = "0 nm"\ncutoff', "surface.prominence: wanted a positive length"),
        ("cutoff", 'valid = ["1 um"]\ncutoff', "surface.valid: wanted 2 values, got 1"),
        ("cutoff", "fill = 1\ncutoff", "surface.fill: wanted true or false, got 1"),
        ('"1 um"', '["1 um", "1 um", "1 um"]', "surface.pixel: wanted "),
        ("cutoff", 'radius = "1 mm"\ncutoff', "surface.radius: unknown key here; it belongs in"),
    ],
)
def test_wrong_scans_are_one_line(home: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(scan_study((old, new)), folder=home)
    assert str(caught.value).startswith(f"study: {message}")
    assert "\n" not in str(caught.value)


def test_errors_that_only_the_scan_shows_are_one_line(home: Path) -> None:
    study = ms.Study.from_toml(scan_study(('"6 um"', '"1 um"')), folder=home)
    with pytest.raises(ms.StudyError, match=r"^study: surface\.cutoff: must be between two pixels"):
        study.run()


@pytest.mark.slow
def test_heights_by_a_table_of_their_density(home: Path) -> None:
    text = edited((GAUSSIAN, TABLE))
    study = ms.Study.from_toml(text, folder=home)
    VALIDATOR.validate(study._tables)
    surface = study.run().joints[0].surface
    assert isinstance(surface, ms.GreenwoodWilliamson)
    wanted = ms.TabulatedHeights([-1e-6, 0.0, 1e-6], [0.0, 2e6, 0.0])
    assert surface.heights.partial_moment(1.5, 2e-7) == wanted.partial_moment(1.5, 2e-7)
    units = {item["key"]: item["unit"] for item in preview(study).data["quantities"]}
    assert units["surface.heights.height"] == "m"
    assert units["surface.heights.density"] == "1/m"
    assert units["surface.density"] == "1/m^2"
    assert dict(_rows(study))["Density at these"] == "0 per m, 2 per µm, 0 per m"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"2 1/um", "0 1/um"', '"2 1/um"', "surface.heights.density: must have one value for each"),
        (
            '"2 1/um"',
            '"-2 1/um"',
            "surface.heights.density, item 2: wanted a number per length of zero",
        ),
        ('"2 1/um"', '"2"', "surface.heights.density, item 2: wanted a number per length such as"),
        ("height =", "hight =", 'surface.heights.hight: unknown key; did you mean "height"?'),
    ],
)
def test_wrong_tables_are_one_line(home: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(edited((GAUSSIAN, TABLE.replace(old, new, 1))), folder=home)
    assert str(caught.value).startswith(f"study: {message}")
