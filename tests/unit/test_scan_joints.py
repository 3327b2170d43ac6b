"""From scans to joints: combined surfaces, profiles, areas and words that are refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import run

import microslip as ms

AL = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(AL, AL)
STUDY = """\
schema = 1
{surface}
[joint]
friction_coefficient = 0.3
normal_load = "1 N"
"""
AS_IS = ("--unit", "um", "--pixel", "1 um", "--cutoff", "8 um")


@pytest.fixture(name="home")
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(1)
    trace = np.convolve(rng.standard_normal(660), np.hanning(61), mode="valid") * 1e-2
    np.save("trace.npy", trace)
    return tmp_path


def test_a_profile_makes_a_joint_of_its_moments(home: Path) -> None:
    outcome = run("surface", "trace.npy", *AS_IS, "--area", "2 cm^2", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    text = (home / "out/surface.toml").read_text("utf-8")
    result = ms.Study.from_toml(STUDY.format(surface=text), folder=home / "out").run()
    scan = ms.Scan.read("trace.npy", unit="um", pixel=1e-6).condition(level="plane")
    wanted = scan.condition(cutoff=8e-6).moments().mccool()
    surface: Any = result.joints[0].surface
    assert surface.radius == pytest.approx(wanted.radius, rel=1e-5)
    assert surface.density == pytest.approx(wanted.density, rel=1e-5)
    assert surface.heights.std == pytest.approx(wanted.std, rel=1e-5)
    assert surface.area == pytest.approx(2e-4)
