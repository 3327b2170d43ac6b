"""The small studies beside the worked example: what each of them makes, and that it is in order."""

from __future__ import annotations

import runpy
import shutil
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.study.build import build_joints

FOLDER = Path(__file__).parents[2] / "examples"
SMALL = {"bolted_joint": 12800.0, "milled": 3200.0}
"""Force limit of the last load [N]."""
LARGE = ("al2017", "bolted_beam")
"""Those that have tests of their own."""


@cache
def last_joint(name: str) -> Any:
    """The joint of a study at its last load."""
    return build_joints(ms.Study.load(FOLDER / f"{name}.toml"))[-1]


def test_every_study_is_held() -> None:
    assert {path.stem for path in FOLDER.glob("*.toml")} == {*SMALL, *LARGE}


@pytest.mark.parametrize("name", SMALL)
def test_numbers_and_verdicts(name: str) -> None:
    joint = last_joint(name)
    assert joint.force_limit == pytest.approx(SMALL[name], rel=1e-12)
    assert {verdict.word for verdict in joint.validity} == {"ok"}


@pytest.mark.parametrize("name", LARGE)
def test_no_example_leaves_what_its_law_assumes(name: str) -> None:
    joints = build_joints(ms.Study.load(FOLDER / f"{name}.toml"))
    assert {verdict.word for joint in joints for verdict in joint.validity} <= {"ok", "watch"}


def test_bolts_equal_the_same_in_python() -> None:
    bolts = last_joint("bolted_joint")
    spread = ms.Pressure.bolt("M8", [6e-3, 10e-3], count=4, rings=8)
    assert np.sum(spread.shares * 64e3) == pytest.approx(bolts.normal_load)
    assert bolts.pressure.area == spread.area


def test_the_milled_scan_is_what_its_program_makes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER.parent / "benchmarks"))
    from measured_faces import milled

    shipped = np.load(FOLDER / "milled.npy", allow_pickle=False)
    assert np.abs(shipped - milled()).max() <= 1  # nm


@pytest.mark.slow
def test_bracket_goes_from_gmsh_to_damping(here: Path) -> None:
    pytest.importorskip("gmsh", reason="the mesh of the bracket needs gmsh: pip install gmsh")
    pytest.importorskip("meshio", reason="meshes are read by meshio")
    for name in ("mesh.py", "bracket.toml"):
        shutil.copy(FOLDER / "bracket" / name, here)
    runpy.run_path("mesh.py")
    text = Path("bracket.toml").read_text("utf-8").replace("samples = 32", "samples = 8")
    structure = ms.Study.from_toml(text, folder=here).run().structure
    mode = structure.modes[0]
    assert mode.curve.converged.all()
    assert mode.curve.linear_frequency == pytest.approx(880.0, rel=0.02)
    (limits,) = structure.limits
    assert limits.open < mode.curve.frequency[0] < limits.tied
    assert (mode.curve.damping_ratio > mode.curve.base_damping).all()
