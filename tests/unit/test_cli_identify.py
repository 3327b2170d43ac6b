"""The command that identifies a joint: what it takes, prints, writes and refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from command import STUDY, fails, run

import microslip as ms
from microslip.cli.records import calibration_of, rig_stiffness_of

JOINT = ms.Interface.examples()[0]
RIG = 5e8
GIVEN = ("--rig-stiffness", "500±10 N/um")


@pytest.fixture(scope="module", name="records")
def _records(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("records")
    for seed, (name, load) in enumerate((("light", 500.0), ("heavy", 2000.0))):
        rig = ms.VirtualTribometer(
            JOINT.at(normal_load=load), rig_stiffness=RIG, noise=0.003, sample_rate=2560, seed=seed
        )
        rig.record(amplitude=6e-6, frequency=10.0, cycles=6).to_csv(folder / f"{name}.csv")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return folder


@pytest.fixture(name="folder", autouse=True)
def _folder(records: Path, here: Path) -> Path:
    for path in records.iterdir():
        (here / path.name).write_bytes(path.read_bytes())
    return here


def summary(*words: str) -> dict[str, Any]:
    outcome = run("identify", *words, "--json")
    assert outcome.exit_code == 0, outcome.output
    found: dict[str, Any] = json.loads(outcome.stdout)
    return found


# -- what comes out --------------------------------------------------------------------------------


def test_command(folder: Path) -> None:
    """Terminal, page, JSON and CSV hold the same numbers, and predict carries their band."""
    words = ("identify", "light.csv", "heavy.csv", "--study", "study.toml", *GIVEN, "-o", "out")
    outcome = run(*words)
    assert outcome.exit_code == 0, outcome.output
    out = folder / "out"
    names = sorted(path.name for path in out.iterdir())
    assert names == [
        "curves.csv", "joint.toml", "law.json", "law.svg", "loops.svg", "report.html",
        "residuals.csv", "summary.json",
    ]  # fmt: skip
    written = json.loads((out / "summary.json").read_text("utf-8"))
    assert sorted(written["files"]) == names
    assert outcome.stdout.endswith("8 files in out\n")
    page = (out / "report.html").read_text("utf-8")
    heavy = written["curves"][-1]
    assert heavy["normal_load"] == pytest.approx(2000.0, rel=1e-3)
    for text in ("Stiffness at rest", "Force limit", "Stiffness of the rig", "Masing"):
        assert text in outcome.stdout
        assert text in page
    with (out / "curves.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(curve["amplitude"]) for curve in written["curves"])
    assert float(rows[-1]["dissipated energy high [J]"]) == heavy["dissipated_energy"]["high"][-1]


GOLDEN = {
    "kind": str,
    "schema": int,
    "generator": dict,
    "title": str,
    "version": str,
    "of": str,
    "confidence": float,
    "amplitude_range": list,
    "stiffness": dict,
    "force_limit": dict,
    "rig_stiffness": dict,
    "curves": list,
    "law": dict,
    "masing": dict,
    "interface": type(None),
    "records": list,
    "skipped": list,
    "notes": list,
    "files": list,
}
"""Keys of summary.json: programs read them."""


def test_the_summary_has_its_keys() -> None:
    found = summary("heavy.csv")
    assert {name: type(value) for name, value in found.items()} == GOLDEN
    assert found["kind"] == "microslip-identification"
    assert found["schema"] == 2
    (curve,) = found["curves"]
    assert set(curve) == {
        "normal_load", "measured_amplitudes", "amplitude", "force", "dissipated_energy",
        "damping_ratio",
    }  # fmt: skip
    for name in ("force", "dissipated_energy", "damping_ratio"):
        low, value, high = (np.array(curve[name][key]) for key in ("low", "value", "high"))
        assert (low <= value).all()
        assert (value <= high).all()
        assert value.size == len(curve["amplitude"])
    # Without a measured stiffness of the rig only its lower bound is known.
    assert found["of"] == "joint and rig in series"
    assert found["rig_stiffness"]["value"] is None
    assert found["rig_stiffness"]["high"] is None
    assert 0.8 * RIG < found["rig_stiffness"]["low"] < RIG


def test_without_a_study_and_without_a_folder(folder: Path) -> None:
    before = sorted(folder.iterdir())
    outcome = run("identify", "heavy.csv")
    assert outcome.exit_code == 0, outcome.output
    assert "--study" in outcome.stdout  # how the parameters of the interface follow
    assert "Slip scale" not in outcome.stdout
    assert sorted(folder.iterdir()) == before


# -- what it is told -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("200 N/um", (2e8, 0.0)),
        ("200±5 N/um", (2e8, 5e6)),
        ("200 N/um ± 5", (2e8, 5e6)),
        ("200 N/um +/- 5e6 N/m", (2e8, 5e6)),
    ],
)
def test_rig_stiffness(text: str, value: tuple[float, float]) -> None:
    assert rig_stiffness_of(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "factors", "error"),
    [
        ("force=1±0.01", (), 0.01),
        ("force=200±2 N/V", ("force=200 N/V",), 0.01),
        ("force=12.5 N/V +- 2 %", ("force=12.5 N/V",), 0.02),
        ("force=12.5 N/V", ("force=12.5 N/V",), None),
    ],
)
def test_calibration(text: str, factors: tuple[str, ...], error: float | None) -> None:
    """A factor of one changes no number; its deviation is a share of it."""
    found, errors = calibration_of((text,))
    assert found == factors
    assert errors == ({} if error is None else {"force": pytest.approx(error)})


@pytest.mark.parametrize("text", ["1±", "±0.1", "1±-0.1", "0±1", "1±x"])
def test_wrong_deviations_of_a_calibration_are_refused(text: str) -> None:
    with pytest.raises(click.UsageError, match="wanted force=FACTOR±DEVIATION"):
        calibration_of((f"force={text}",))


def test_a_calibration_error_is_in_the_intervals() -> None:
    limit = summary("heavy.csv", "--calibration", "force=1±0.01")["force_limit"]
    # 1.96 standard deviations of 1 %.
    assert limit["high"] / limit["value"] - 1.0 == pytest.approx(0.0196, rel=0.05)


# -- what it refuses -------------------------------------------------------------------------------

WRONG = {
    ("--rig-stiffness", "stiff"): '--rig-stiffness: wanted a stiffness such as "200 N/um"',
    ("--rig-stiffness", "1 N/um"): "--rig-stiffness must be above the stiffness of the loops",
    ("--normal-load", "1 N", "--normal-load", "2 N", "--normal-load", "3 N"):
        "--normal-load: wanted one for all records or one for each of the 2 records, got 3",
    ("--noise", "2 N"): '--noise: wanted FORCE,LENGTH, such as "2 N, 5 nm"',
    ("--law", "jenkins"): 'no option "--law"',
}  # fmt: skip


@pytest.mark.parametrize("words", WRONG, ids=" ".join)
def test_command_refuses(words: tuple[str, ...]) -> None:
    assert WRONG[words] in fails("identify", "light.csv", "heavy.csv", "-o", "out", *words)


def test_tests_of_modes_are_refused_with_the_way_to_fit_them(folder: Path) -> None:
    (folder / "modes.csv").write_text(
        "amplitude [um],frequency [Hz],damping ratio [%]\n1,200,0.1\n2,199,0.2\n"
    )
    assert "[structure.measured] with fit = [...]" in fails("identify", "modes.csv")


# -- a real record ---------------------------------------------------------------------------------

REAL = Path(__file__).parents[3] / "shared/data/reciprocating/test_data_2.txt"


@pytest.mark.slow
@pytest.mark.skipif(not REAL.exists(), reason="the record in ../shared/data is not here")
def test_real_record() -> None:
    """The rig is bounded below by the stiffness at rest; drifting cycles are reported."""
    found = summary(str(REAL), "--flip-sign")
    assert 3e4 < found["rig_stiffness"]["low"] < 6e4
    assert any("cycles drift" in note for note in found["notes"])
