"""The exported elements in CalculiX (Debian's calculix-ccx), which prints seven digits."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from exported import JOINT

from microslip import export

CCX = shutil.which("ccx")
pytestmark = pytest.mark.skipif(CCX is None, reason="CalculiX (ccx) is not installed")
_RANGE = {"smallest_amplitude": 3e-8, "largest_amplitude": 6e-7}
_CELLS = 24
_DIGITS = 5e-7  # half of the last of the seven digits that it prints
_NODES = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n"


def run(folder: Path, deck: str) -> str:
    """What CalculiX prints for a deck with the joint between nodes 1 and 2."""
    file = folder / "joint.inp"
    export.write("calculix", JOINT, file, cells=_CELLS, nodes=[[1, 2]], first_number=101, **_RANGE)
    (folder / "deck.inp").write_text(deck)
    done = subprocess.run(
        [str(CCX), "deck"], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    return (folder / "deck.dat").read_text()


def amplitude(values: np.ndarray, step: float) -> str:
    rows = [f"{step * i:.10e}, {v:.13e}" for i, v in enumerate(np.append(0.0, values))]
    return "*AMPLITUDE, NAME=A\n" + "\n".join(rows) + "\n"


def static_cycle(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Forces along a history, by CalculiX and by the cells."""
    x = np.interp(np.arange(1, 51), [0, 10, 30, 40, 50], [0.0, 6e-7, -6e-7, 1e-7, -2e-7])
    deck = (
        f"{_NODES}*ELEMENT, TYPE=MASS, ELSET=M\n1, 1\n2, 2\n*MASS, ELSET=M\n1.\n"
        f"*INCLUDE, INPUT=joint.inp\n*BOUNDARY\n1, 1, 3\n2, 2, 3\n{amplitude(x, 1.0)}"
        f"*STEP, INC=1000\n*STATIC, DIRECT\n1., {x.size}.\n*BOUNDARY, AMPLITUDE=A\n2, 1, 1, 1.\n"
        "*NODE PRINT, NSET=JOINT_1, TOTALS=ONLY\nRF\n*END STEP\n"
    )
    lines = run(folder, deck).splitlines()
    found = np.array([float(line.split()[0]) for line in lines if re.match(r"\s+-?\d\.\d+E", line)])
    return found, JOINT.to_iwan(_CELLS, **_RANGE).force(x)


def test_a_static_cycle_is_the_cells_to_its_printed_digits(tmp_path):
    found, wanted = static_cycle(tmp_path)
    assert found.shape == wanted.shape
    np.testing.assert_allclose(found, wanted, rtol=_DIGITS)


def test_a_dynamic_run_is_that_of_the_same_integrator(tmp_path):
    mass, dt, steps = 100.0, 1e-5, 120
    drive = 700.0 * np.sin(2.0 * np.pi * np.arange(1, steps + 1) / 60.0)
    deck = (
        f"{_NODES}*ELEMENT, TYPE=MASS, ELSET=M\n1, 2\n*MASS, ELSET=M\n{mass}\n"
        f"*INCLUDE, INPUT=joint.inp\n*BOUNDARY\n1, 1, 3\n2, 2, 3\n{amplitude(drive, dt)}"
        f"*STEP, INC=1000\n*DYNAMIC, DIRECT, ALPHA=0.\n{dt}, {steps * dt}\n"
        "*CLOAD, AMPLITUDE=A\n2, 1, 1.\n*NSET, NSET=MOVED\n2\n*NODE PRINT, NSET=MOVED\nU\n"
        "*END STEP\n"
    )
    lines = run(tmp_path, deck).splitlines()
    found = np.array([float(line.split()[1]) for line in lines if re.match(r"\s+2\s", line)])
    state, x, v, a, wanted = JOINT.to_iwan(_CELLS, **_RANGE).start(), 0.0, 0.0, 0.0, []
    for force in drive:
        new = x
        for _ in range(30):  # average acceleration, as HHT's rule for alpha = 0
            acceleration = 4.0 / dt**2 * (new - x) - 4.0 / dt * v - a
            held, slope = state.try_(new)
            residual = mass * acceleration + held - force
            new -= residual / (4.0 * mass / dt**2 + slope)
            if abs(residual) < 1e-9:
                break
        state.commit()
        x, v, a = new, v + 0.5 * dt * (a + acceleration), acceleration
        wanted.append(x)
    assert found.size == steps
    # Seven printed digits, and what its residual of half a per cent of a mean force leaves.
    assert np.abs(found - wanted).max() <= 2e-6 * np.abs(wanted).max()
