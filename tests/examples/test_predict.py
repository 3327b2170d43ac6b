"""The worked example, from its study file to the numbers and pictures of its result."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import microslip as ms
from microslip.cli import main

EXAMPLE = Path(__file__).parents[2] / "examples" / "al2017.toml"
LOADS = (500.0, 2000.0, 5000.0)
AMPLITUDES = (1e-7, 3e-7, 1e-6, 1e-5)
FIGURES = (
    "loops",
    "backbone",
    "energy_damping",
    "contact_state",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("example") / "result"
    outcome = CliRunner().invoke(main, ["predict", str(EXAMPLE), "-o", str(folder)])
    assert outcome.exit_code == 0, outcome.output
    return folder


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text("utf-8"))


@pytest.fixture(scope="module")
def joint() -> ms.Interface:
    al = ms.Material(young_modulus=69e9, poisson_ratio=0.33, hardness=1.03e9)
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(al, al), heights=ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
    )
    return ms.Interface(surface, friction_coefficient=0.55, normal_load=LOADS[0])


def test_everything_listed_is_there_and_nothing_else(folder: Path, summary: dict[str, Any]) -> None:
    assert summary["files"] == [
        "report.html",
        "study.toml",
        "result.nc",
        "loops.csv",
        "curves.csv",
        *(f"{name}.svg" for name in FIGURES),
        "summary.json",
    ]
    assert sorted(p.name for p in folder.iterdir()) == sorted(summary["files"])
    assert (folder / "study.toml").read_bytes() == EXAMPLE.read_bytes()


def test_the_summary_is_what_the_interface_says(
    summary: dict[str, Any], joint: ms.Interface
) -> None:
    assert summary["kind"] == "microslip-result"
    assert summary["schema"] == 1
    assert summary["generator"]["name"] == "microslip"
    assert summary["generator"]["version"] == ms.__version__
    assert summary["study"]["surface"]["heights"] == {"kind": "gaussian", "std": 5e-7, "mean": 0.0}
    assert summary["study"]["excitation"]["curve"] == {"from": 1e-9, "to": 1e-4, "points": 200}
    for load, entry in zip(LOADS, summary["joints"], strict=True):
        here = joint.at(normal_load=load)
        for name in (
            *("normal_load", "separation", "contact_count", "contact_area", "normal_stiffness"),
            *("tangential_stiffness", "force_limit", "slip_per_indentation"),
        ):
            assert entry[name] == pytest.approx(getattr(here, name), rel=1e-14, abs=0), name
            assert name in summary["units"]
        for amplitude, row in zip(AMPLITUDES, entry["amplitudes"], strict=True):
            assert row["amplitude"] == amplitude
            assert row["force_amplitude"] == pytest.approx(
                here.backbone(amplitude), rel=1e-14, abs=0
            )
            for name in ("dissipated_energy", "loss_factor", "damping_ratio", "stick_area"):
                assert row[name] == pytest.approx(getattr(here, name)(amplitude), rel=1e-12, abs=0)
        verdicts = [(v["name"], v["value"], v["limit"], v["word"]) for v in entry["validity"]]
        assert verdicts == [(v.name, v.value, v.limit, v.word) for v in here.validity]
        assert {v["name"] for v in entry["validity"]} >= {"plasticity index"}
