"""`microslip surface`: what it prints and writes of a scan, and that no cut-off is ever hidden."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from command import fails, run
from made_surfaces import rough

import microslip as ms

AS_IS = ("--unit", "um", "--pixel", "1 um")
FILES = [
    *("heights.png", "heights.svg", "report.html", "spectrum.csv", "spectrum.png", "spectrum.svg"),
    *("summary.json", "summits.csv"),
]


@pytest.fixture(name="folder")
def _folder(here: Path) -> Path:
    scan = rough((96, 96), 1e-6, 3.2e-7, longest=8.5e-5, shortest=1.55e-5, seed=3)
    np.save("ground.npy", scan.heights * 1e6)
    return here


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
    scan = ms.Scan.read("ground.npy", unit="um", pixel=1e-6).condition(level="plane")
    found = scan.summits(6e-6)
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
    monkeypatch.setattr("microslip.figures.matplotlib_figure.rendered", lambda plot, kind: b"")


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
    # Cycles that hang on the pixel are named, here and in the study.
    words = (
        f"not determine the damping of cycles up to {1e9 * found['unresolved_amplitude']:.3g} nm"
    )
    assert words in " ".join(outcome.stdout.split())
    assert words in (folder / "out/study.toml").read_text("utf-8")
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


@pytest.mark.slow
def test_the_figures_are_drawn(folder: Path) -> None:
    outcome = run("surface", "ground.npy", *AS_IS, "--cutoff", "6 um", "--png", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    for name in ("heights", "spectrum"):
        assert (folder / f"out/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "</svg>" in (folder / f"out/{name}.svg").read_text("utf-8")
