"""The example of a bracket, from the mesh of Gmsh to the damping of its first mode."""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path

import pytest

import microslip as ms

FOLDER = Path(__file__).parents[2] / "examples" / "bracket"


@pytest.mark.slow
def test_bracket_goes_from_gmsh_to_damping(here: Path) -> None:
    pytest.importorskip("gmsh", reason="the mesh of the bracket needs gmsh: pip install gmsh")
    pytest.importorskip("meshio", reason="meshes are read by meshio")
    for name in ("mesh.py", "bracket.toml"):
        shutil.copy(FOLDER / name, here)
    runpy.run_path("mesh.py")
    text = Path("bracket.toml").read_text("utf-8").replace("samples = 32", "samples = 8")
    structure = ms.Study.from_toml(text, folder=here).run().structure
    mode = structure.modes[0]
    assert mode.curve.converged.all()
    assert mode.curve.linear_frequency == pytest.approx(880.0, rel=0.02)
    (limits,) = structure.limits
    assert limits.open < mode.curve.frequency[0] < limits.tied
    assert (mode.curve.damping_ratio > mode.curve.base_damping).all()
