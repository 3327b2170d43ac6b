"""Exported elements and contact cards in CalculiX (Debian's calculix-ccx), of seven digits."""

from __future__ import annotations

import re
import shutil
import subprocess
from itertools import pairwise
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
    return printed(folder, deck)


def printed(folder: Path, deck: str) -> str:
    """What CalculiX prints for a deck."""
    (folder / "deck.inp").write_text(deck)
    done = subprocess.run(
        [str(CCX), "deck"], cwd=folder, capture_output=True, text=True, timeout=300
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


# -- the contact card: a block on a block, whose contact gives its stiffnesses back ---------------


def mesh(*heights: tuple[float, float], side: float = 10.0, parts: int = 2) -> str:
    """Blocks of cubes on each other, nodes of each from 1000, 2000, ...; sets B1, TOP1, LOW1."""
    text = []
    for block, (low, high) in enumerate(heights, 1):
        text.append("*NODE")
        number = {}
        for k, z in enumerate((low, high)):
            for j in range(parts + 1):
                for i in range(parts + 1):
                    number[i, j, k] = n = 1000 * block + len(number)
                    text.append(f"{n}, {i * side / parts}, {j * side / parts}, {z:.12g}")
        text.append(f"*ELEMENT, TYPE=C3D8I, ELSET=B{block}")
        corners = ((0, 0), (1, 0), (1, 1), (0, 1))
        for j in range(parts):
            for i in range(parts):
                nodes = [number[i + a, j + b, k] for k in (0, 1) for a, b in corners]
                text.append(", ".join(map(str, [1000 * block + parts * j + i, *nodes])))
        for name, k in (("LOW", 0), ("TOP", 1)):
            text.append(f"*NSET, NSET={name}{block}")
            text += [str(n) for (_, _, level), n in number.items() if level == k]
    return "\n".join(text) + "\n"


def steps(folder: Path, deck: str, stages: list[str], shown: str) -> list[np.ndarray]:
    """Mean displacement of each set and total force of TOP2 after each step, from CalculiX."""
    for stage in stages:
        deck += f"*STEP, NLGEOM=NO, INC=1000\n*STATIC\n1., 1.\n{stage}\n{shown}*END STEP\n"
    lines = printed(folder, deck).splitlines()
    return [
        np.array([[float(word) for word in line.split()] for line in table if line.strip()])
        for table in _tables(lines)
    ]


def _tables(lines: list[str]) -> list[list[str]]:
    heads = [i for i, line in enumerate(lines) if "time" in line] + [len(lines)]
    return [lines[a + 1 : b] for a, b in pairwise(heads)]


RIGID = (
    "*MATERIAL, NAME=STIFF\n*ELASTIC\n1.E9, 0.\n"
    "*SOLID SECTION, ELSET=B1, MATERIAL=STIFF\n*SOLID SECTION, ELSET=B2, MATERIAL=STIFF\n"
)


def test_a_block_on_a_block_gives_both_stiffnesses_back(tmp_path):
    card = export.write_card("calculix", JOINT, tmp_path / "card.inp", units="mm")
    closed = float(np.interp(card.pressure, card.pressures, card.overclosures)) * 1e3
    step, slip = 2e-3 * closed, 0.05 * card.elastic_slip * 1e3
    deck = (
        mesh((0.0, 5.0), (5.0, 10.0)) + RIGID +
        "*SURFACE, NAME=S1, TYPE=ELEMENT\nB1, S2\n*SURFACE, NAME=S2, TYPE=ELEMENT\nB2, S1\n"
        "*INCLUDE, INPUT=card.inp\n"
        "*CONTACT PAIR, INTERACTION=JOINT, TYPE=NODE TO SURFACE\nS2, S1\n"
        "*BOUNDARY\nLOW1, 1, 3\n"
    )  # fmt: skip
    stages = [
        f"*BOUNDARY\nTOP2, 1, 2\nTOP2, 3, 3, {-z:.12e}" for z in (closed - step, closed + step)
    ]
    stages.append(f"*BOUNDARY\nTOP2, 2, 2\nTOP2, 1, 1, {slip:.12e}")
    shown = (
        "*NODE PRINT, NSET=TOP2, TOTALS=ONLY\nRF\n"
        "*NODE PRINT, NSET=TOP1\nU\n*NODE PRINT, NSET=LOW2\nU\n"
    )
    found = steps(tmp_path, deck, stages, shown)
    force = [table[0] for table in found[0::3]]
    gap = [b[:, 1:].mean(axis=0) - a[:, 1:].mean(axis=0)
           for a, b in zip(found[1::3], found[2::3], strict=True)]  # fmt: skip
    area = 100.0
    normal = (force[1][2] - force[0][2]) / (gap[1][2] - gap[0][2]) / area
    tangential = (force[2][0] - force[1][0]) / (gap[2][0] - gap[1][0]) / area
    # 1 MPa/mm is 1e9 Pa/m.
    assert 1e9 * normal == pytest.approx(card.normal_stiffness, rel=1e-2)
    assert 1e9 * tangential == pytest.approx(card.stick_stiffness, rel=1e-2)
    assert 1e9 * normal == pytest.approx(JOINT.normal_stiffness / 2e-4, rel=1e-2)


def test_the_layer_in_their_place_has_both_stiffnesses(tmp_path):
    card = export.write_card("calculix", JOINT, tmp_path / "card.inp", units="mm")
    deck = (
        mesh((0.0, 1.0)) + "*INCLUDE, INPUT=card.inp\n"
        "*SOLID SECTION, ELSET=B1, MATERIAL=JOINT_LAYER\n*BOUNDARY\nLOW1, 1, 3\n"
    )
    stages = ["*BOUNDARY\nTOP1, 1, 2\nTOP1, 3, 3, -1.E-3",
              "*BOUNDARY\nTOP1, 2, 3\nTOP1, 1, 1, 1.E-3"]  # fmt: skip
    found = steps(tmp_path, deck, stages, "*NODE PRINT, NSET=TOP1, TOTALS=ONLY\nRF\n")
    normal, tangential = -found[0][0][2] / 0.1, found[1][0][0] / 0.1
    assert 1e9 * normal == pytest.approx(card.normal_stiffness, rel=1e-5)
    a = card.layer.amplitude
    wanted = JOINT.secant_stiffness(a) / JOINT.surface.area
    assert 1e9 * tangential == pytest.approx(wanted, rel=1e-5)
