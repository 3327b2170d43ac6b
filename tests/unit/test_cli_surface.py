"""`microslip surface`: what it prints and writes of a scan, and that no cut-off is ever hidden."""

from __future__ import annotations

import csv
import json
import os
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from command import fails, run

import microslip as ms
from microslip.report.scanned.study_file import face_study_text
from microslip.surfaces import random_surface
from microslip.surfaces.findings import Request, analyse

SHARED = Path(__file__).parents[3] / "shared" / "data" / "scans"
AS_IS = ("--unit", "um", "--pixel", "1 um")
FILES = [
    *("heights.png", "heights.svg", "report.html", "spectrum.csv", "spectrum.png", "spectrum.svg"),
    *("summary.json", "summits.csv"),
]
STUDY = """\
schema = 1
{surface}
[joint]
friction_coefficient = 0.3
normal_load = "1 N"
"""


@pytest.fixture(name="folder")
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    scan = random_surface((96, 96), 1e-6, m0=1e-13, m2=1e-3, m4=4e7, seed=3)
    np.save("ground.npy", scan.heights * 1e6)
    return tmp_path


def test_all_files_and_the_cutoff_in_each(folder: Path, undrawn: None) -> None:
    outcome = run("surface", "ground.npy", *AS_IS, "--cutoff", "6 um", "--png", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    assert outcome.stdout.startswith("ground.npy\nSummits counted: ")
    assert "96 x 96 points, pixel 1.000 µm, 96.0 µm" in outcome.stdout
    assert "Cut-off 6 µm: Sq " in outcome.stdout
    assert outcome.stdout.endswith("--all\n8 files in out\n")
    assert len(outcome.stdout.splitlines()) <= 30  # one screen
    assert sorted(path.name for path in (folder / "out").iterdir()) == FILES
    summary = json.loads((folder / "out/summary.json").read_text("utf-8"))
    assert sorted(summary["files"]) == FILES
    assert summary["cutoff"] == 6e-6
    assert summary["cutoff_given"] is True
    assert summary["warnings"] == []
    page = (folder / "out/report.html").read_text("utf-8")
    # In the head and in the captions of both figures.
    assert page.count("ut-off 6 µm") >= 3
    # The summits, from the highest down.
    found = ms.Scan.read("ground.npy", unit="um", pixel=1e-6).summits(6e-6, level="plane")
    rows = list(csv.DictReader((folder / "out/summits.csv").read_text("utf-8").splitlines()))
    assert len(rows) == found.count == summary["count"]
    assert float(rows[0]["height [m]"]) == found.heights.max()
    # The few parameters of ISO are those of Python.
    scan = found.scan
    assert summary["parameters"]["rms"] == scan.statistics().rms
    assert summary["areal"]["autocorrelation_length"] == (
        ms.surfaces.surface_parameters.areal_parameters(scan).autocorrelation_length
    )
    assert summary["profile"].keys() == {"x", "y"}
    # Never overwritten unasked.
    assert "out: exists; replace it" in run("surface", "ground.npy", *AS_IS, "-o", "out").stderr


@pytest.fixture(name="undrawn")
def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures take most of the time, and are drawn by another test."""
    monkeypatch.setattr("microslip.figures.png", lambda plot: b"")


JOINT = "--cutoff", "6 um", "--materials", "steel-c45", "steel-c45", "--load", "0.9000123 N"


def test_a_pressed_scan_is_solved_point_by_point(folder: Path, undrawn: None) -> None:
    """The table, the study and Python are the same, with gaps and spikes too."""
    heights = np.load("ground.npy")
    heights[40, 50:52] = np.nan
    heights[60, 20] += 10.0
    np.save("ground.npy", heights)
    where = "--direction", "90 deg", "--area", "0.02 mm^2", "--amplitude", "5 nm", "-o", "out"
    outcome = run("surface", "ground.npy", *AS_IS, *JOINT, *where)
    assert outcome.exit_code == 0, outcome.output
    assert "Repair: 1 points of spikes removed." in outcome.stdout
    assert "Fill: 3 of 9216 points interpolated" in outcome.stdout
    found = json.loads((folder / "out/summary.json").read_text("utf-8"))["joint"]
    (own,) = ms.Study.load(folder / "out/study.toml").run().joints
    assert isinstance(own.surface, ms.MeasuredContact)
    assert own.surface.area == pytest.approx(2e-8)
    assert own.tangential_stiffness == pytest.approx(found["tangential_stiffness"], rel=1e-6)
    steel = ms.Material.named("steel-c45")
    scan = ms.Scan.read("ground.npy", unit="um", pixel=1e-6).repaired()
    law = scan.condition(level="plane", cutoff=6e-6).to_contact(
        ms.MaterialPair(steel, steel), direction=np.pi / 2, piece=None, area=2e-8,
        tightening_pressure=found["face"]["pressure"],
    )  # fmt: skip
    by_hand = ms.Interface(law, 0.5, normal_load=0.9000123)
    assert found["tangential_stiffness"] == pytest.approx(by_hand.tangential_stiffness, rel=1e-9)
    assert found["loss_factor"] == pytest.approx(by_hand.loss_factor(5e-9), rel=1e-9)
    # Four pieces of a quarter of the scan tell its scatter.
    for name, (low, high) in found["intervals"].items():
        assert 0.1 * found[name] < low < found[name] < high < 10.0 * found[name]
    assert "contact.svg" in {path.name for path in Path("out").iterdir()}
    few = fails("surface", "ground.npy", *AS_IS, *JOINT[:-1], "0.1 mN")
    assert "at least 100 points into contact" in few


@pytest.mark.parametrize("there", [".", "below/deeper"])
def test_the_study_finds_the_scan_from_where_it_is(
    folder: Path, monkeypatch: pytest.MonkeyPatch, there: str
) -> None:
    """Wherever the command was run and the study is: by two dots, or from the root if so given."""
    (folder / "below" / "deeper").mkdir(parents=True)
    (folder / "out").mkdir()
    monkeypatch.chdir(folder / there)
    near, far = os.path.relpath(folder / "ground.npy"), str(folder / "ground.npy")
    for scan, written in ((near, "../ground.npy"), (far, far)):
        request = Request.of(
            Path(scan), cutoff_given=True, unit="um", pixel=1e-6, cutoff=6e-6,
            materials=("steel", "steel"), normal_load=0.9,
        )  # fmt: skip
        found = analyse(request)
        text = face_study_text(found, found.face, Path(os.path.relpath(folder / "out")))
        assert tomllib.loads(text)["surface"]["scan"] == written
        ms.Study.from_toml(text, folder=folder / "out")


def test_missing_points_are_reported_and_filled(folder: Path) -> None:
    heights = np.load("ground.npy")
    heights[np.random.default_rng(4).random(heights.shape) < 0.3] = np.nan
    np.save("holes.npy", heights)
    options = *AS_IS, "--cutoff", "6 um", "--json"
    found = json.loads(run("surface", "holes.npy", *options).stdout)
    assert found["missing"] == pytest.approx(0.3, abs=0.02)
    assert any(v["name"] == "missing" and v["word"] == "outside" for v in found["validity"])
    whole = json.loads(run("surface", "ground.npy", *options).stdout)
    # Interpolation rounds off waves of a few pixels, which the cut-off removes for the most part.
    for group, name, near in (("parameters", "rms", 0.02), ("areal", "rms_gradient", 0.05)):
        assert found[group][name] == pytest.approx(whole[group][name], rel=near)


def test_no_cutoff_can_be_said(folder: Path) -> None:
    summary = json.loads(run("surface", "ground.npy", *AS_IS, "--cutoff", "none", "--json").stdout)
    assert (summary["cutoff"], summary["cutoff_given"]) == (None, True)
    assert not any("was given" in text for text in summary["warnings"])
    assert summary["notes"][-3].startswith("summits: no short-wave cut-off: the pixel of 1.000 µm")


def test_a_profile(folder: Path, undrawn: None) -> None:
    x = np.arange(600)
    rng = np.random.default_rng(1)
    heights = np.convolve(rng.standard_normal(660), np.hanning(61), mode="valid")
    np.savetxt("trace.txt", np.column_stack([x, heights]), header="x [um] z [um]")
    outcome = run("surface", "trace.txt", "--unit", "um", "--cutoff", "20 um", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    assert "A profile has peaks but no summits" in outcome.stdout
    joint = "--materials", "steel", "al2017", "--load", "500 N", "--area", "2 cm^2"
    scan = "surface", "trace.txt", "--unit", "um", "--cutoff", "20 um"
    assert "--load requires the scan of an area" in fails(*scan, *joint)
    names = sorted(path.name for path in (folder / "out").iterdir())
    assert names == [name for name in FILES if name != "summits.csv" and not name.endswith(".png")]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ("--cutoff", "0.5 um"),
            "--cutoff must be between two pixels (2 µm) and the size of the scan "
            "(96 µm), got 500 nm: below two pixels",
        ),
        (
            ("--long-cutoff", "1 m"),
            "--long-cutoff must be between two pixels (2 µm) and the size of "
            "the scan (96 µm), got 1 m: beyond the size of the scan",
        ),
        (("--valid", "1 mm", "-1 mm"), "--valid: the first height must be the lower one, got 1 mm"),
        (("--pixel", "1 um", "--pixel", "1 um"), "--pixel: wanted once, or twice for x and y, got"),
    ],
)
def test_wrong_options_are_one_line(folder: Path, options: tuple[str, ...], message: str) -> None:
    line = fails("surface", "ground.npy", *AS_IS, *options, "-o", "out")
    assert message in line


def test_coordinates_and_heights_have_a_unit_each(folder: Path, undrawn: None) -> None:
    """As the usual xyz file has them; a study takes them likewise."""
    z = np.load("ground.npy")[:32, :32]
    rows = "".join(f"{x},{2 * y},{z[y, x]:.6f}\n" for y in range(32) for x in range(32))
    Path("pts.xyz").write_text(rows)
    units = "--unit", "mm", "--unit", "um"
    assert run("surface", "pts.xyz", *units, "-o", "out").exit_code == 0
    summary = json.loads((folder / "out/summary.json").read_text("utf-8"))
    assert summary["pixel"] == pytest.approx([1e-3, 2e-3], rel=1e-12)
    wanted = ms.Scan.read("pts.xyz", unit=("mm", "um")).condition(level="plane").statistics()
    assert summary["parameters"]["rms"] == wanted.rms
    text = (
        '[surface]\nlaw = "face"\nmaterials = ["steel", "steel"]\nscan = "../pts.xyz"\n'
        'unit = ["mm", "um"]\npiece = "none"\n'
    )
    ms.Study.from_toml(STUDY.format(surface=text), folder=folder / "out")
    for given, message in (
        ('["mm", "um", "nm"]', "surface.unit: wanted 1 to 2 values, got 3"),
        ('["mm", "kg"]', 'wanted a length such as "1 um", got "1 kg"'),
        ("5", 'wanted text such as "um", got 5'),
    ):
        wrong = text.replace('["mm", "um"]', given)
        with pytest.raises(ms.InputError, match=re.escape(message)):
            ms.Study.from_toml(STUDY.format(surface=wrong), folder=folder / "out")
    # The names of the columns are a second witness, and their messages are spelt alike.
    Path("pts.xyz").write_text("x,y,z [nm]\n" + rows)
    line = fails("surface", "pts.xyz", "--unit", "um")
    assert line.endswith('states heights in "nm", not "um"; write --unit "um" --unit "nm"')
    one = STUDY.format(surface=text.replace('["mm", "um"]', '"um"'))
    with pytest.raises(ms.InputError, match=re.escape('write unit=("um", "nm")')):
        ms.Study.from_toml(one, folder=folder / "out")


def test_a_number_for_nothing_measured_is_reported(folder: Path) -> None:
    heights = np.load("ground.npy")
    heights[10:12, 20:30] = -9999.0
    np.save("gaps.npy", heights)
    options = "surface", "gaps.npy", *AS_IS, "--cutoff", "6 um", "--json"
    mended = json.loads(run(*options).stdout)
    assert "Repair: 20 points of fill value -9.999 mm set as missing." in mended["warnings"]
    assert not any("clipped" in text for text in mended["warnings"])
    whole = json.loads(run("surface", "ground.npy", *options[2:]).stdout)
    rms = whole["parameters"]["rms"]
    assert mended["parameters"]["rms"] == pytest.approx(rms, rel=0.01)


def test_wrong_files_are_one_line(folder: Path) -> None:
    assert 'groud.npy: no such file; did you mean "ground.npy"?' in fails("surface", "groud.npy")
    assert "does not state the unit" in fails("surface", "ground.npy")
    np.save("flat.npy", np.ones((40, 40)))
    assert "nothing to measure" in fails("surface", "flat.npy", *AS_IS)
    np.save("tilted.npy", np.add.outer(np.arange(40.0), np.arange(40.0)))
    assert "leaves only rounding errors" in fails("surface", "tilted.npy", *AS_IS)
    np.save("rows.npy", np.load("ground.npy")[:2])
    assert "need three points along x and y, got 96 x 2" in fails("surface", "rows.npy", *AS_IS)
    spiky = np.load("ground.npy")
    spiky[3, 3] = 1e12
    np.save("spiky.npy", spiky)
    assert "1 points of fill value 1.000 Mm" in run("surface", "spiky.npy", *AS_IS).stdout
    np.save("empty.npy", np.full((40, 40), np.nan))
    assert "missing" in fails("surface", "empty.npy", *AS_IS)
    Path("cut.npy").write_bytes(Path("ground.npy").read_bytes()[:5000])
    assert fails("surface", "cut.npy", *AS_IS).startswith("error: cut.npy: ")


@pytest.mark.slow
def test_the_figures_are_drawn(folder: Path) -> None:
    outcome = run("surface", "ground.npy", *AS_IS, "--cutoff", "6 um", "--png", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    for name in ("heights", "spectrum"):
        assert (folder / f"out/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "</svg>" in (folder / f"out/{name}.svg").read_text("utf-8")


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared scans are not here")
def test_the_scan_with_a_scratch(folder: Path) -> None:
    pytest.importorskip("SurfaceTopography")
    scan, quadratic = str(SHARED / "mnt-1.mnt"), ("--level", "quadratic")
    summary = json.loads(run("surface", scan, "--cutoff", "none", *quadratic, "--json").stdout)
    assert summary["parameters"]["kurtosis"] > 300.0
    assert any(v["name"] == "kurtosis" and v["word"] == "outside" for v in summary["validity"])
