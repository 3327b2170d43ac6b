"""Matrices that Abaqus writes, against the plane element whose matrix is known in closed form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import microslip as ms

# A square plane stress element of thickness 1, E = 200 and Poisson ratio 0.3; Sigmund (2001),
# DOI 10.1007/s001580050176, appendix.
NU = 0.3
K = 200.0 / (1.0 - NU**2) * np.array(
    [0.5 - NU / 6, 0.125 + NU / 8, -0.25 - NU / 12, -0.125 + 3 * NU / 8,
     -0.25 + NU / 12, -0.125 - NU / 8, NU / 6, 0.125 - 3 * NU / 8]
)  # fmt: skip
ORDER = [
    [0, 1, 2, 3, 4, 5, 6, 7], [1, 0, 7, 6, 5, 4, 3, 2], [2, 7, 0, 5, 6, 3, 4, 1],
    [3, 6, 5, 0, 7, 2, 1, 4], [4, 5, 6, 7, 0, 1, 2, 3], [5, 4, 3, 2, 1, 0, 7, 6],
    [6, 3, 4, 1, 2, 7, 0, 5], [7, 2, 1, 4, 3, 6, 5, 0],
]  # fmt: skip
STIFFNESS = K[np.array(ORDER)]
MASS = np.kron([[4, 2, 1, 2], [2, 4, 2, 1], [1, 2, 4, 2], [2, 1, 2, 4]], np.eye(2)) / 36.0
PLACES = [(node, degree) for node in (101, 102, 103, 104) for degree in (1, 2)]


def triangle(matrix: Any) -> str:
    """Rows up to the diagonal, four numbers a line, a comma behind each but the last of a full."""
    text = ""
    for i, row in enumerate(matrix):
        for at in range(0, i + 1, 4):
            words = [f"{value:.13g}" for value in row[at : min(at + 4, i + 1)]]
            text += " " + " , ".join(words) + (" ,\n" if len(words) < 4 else "\n")
    return text


def substructure(folder: Path, stiffness: Any = STIFFNESS) -> Path:
    """As *ELEMENT MATRIX OUTPUT and *SUBSTRUCTURE MATRIX OUTPUT write with USER DEFINED."""
    path = folder / "element.mtx"
    path.write_text(
        "**\n** ELEMENT TYPE CPS4\n*USER ELEMENT, NODES=       4, LINEAR\n** ELEMENT NODES\n"
        f"**   101,  102,  103,  104\n  1,  2\n*MATRIX,TYPE=STIFFNESS\n{triangle(stiffness)}"
        f"*MATRIX,TYPE=MASS\n{triangle(MASS)}"
    )
    return path


def job(folder: Path, *, labels: bool = True, both: bool = False) -> Path:
    """As *MATRIX OUTPUT writes: one triangle with labels, or both with numbers of equations.

    A ninth degree of freedom is held as a boundary condition is, a tenth is of an internal node.
    """
    large = np.zeros((10, 10))
    large[:8, :8], large[8, 8], large[9, 9] = STIFFNESS, 1e36, 7.0
    masses = np.diag([0.0] * 8 + [1.0, 2.0])
    masses[:8, :8] = MASS
    places = [*PLACES, (105, 1), (-1, 1)]
    for name, matrix in (("STIF", large), ("MASS", masses)):
        lines = []
        for i, j in zip(*np.nonzero(matrix), strict=True):
            if i < j and not both:
                continue
            words = [*places[i], *places[j]] if labels else [i + 1, j + 1]
            lines.append(",".join([*map(str, words), f" {matrix[i, j]:.15e}"]))
        (folder / f"plate_{name}2.mtx").write_text("\n".join([*lines, ""]))
    return folder / "plate_STIF2.mtx"


def test_a_substructure(tmp_path: Path) -> None:
    found = ms.Structure.load(substructure(tmp_path))
    np.testing.assert_allclose(found.stiffness.toarray(), STIFFNESS, rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(found.mass.toarray(), MASS, rtol=1e-11)
    with pytest.raises(ms.InputError, match="more than limit=20"):
        ms.Structure.load(tmp_path / "element.mtx", limit=20)


@pytest.mark.parametrize(("labels", "both"), [(True, False), (True, True), (False, True)])
def test_files_of_a_job(tmp_path: Path, labels: bool, both: bool) -> None:
    found = ms.Structure.load(job(tmp_path, labels=labels, both=both))
    # Nodes in rising order put the internal one first, and nobody moves what is held.
    at = [*range(1, 9), 0] if labels else list(range(9))
    sound = np.zeros((9, 9))
    sound[np.ix_(at, at)] = np.block([[STIFFNESS, np.zeros((8, 1))], [np.zeros((1, 8)), 7.0]])
    np.testing.assert_allclose(found.stiffness.toarray(), sound, rtol=1e-12, atol=1e-9)
    sound[np.ix_(at, at)] = np.block([[MASS, np.zeros((8, 1))], [np.zeros((1, 8)), 2.0]])
    np.testing.assert_allclose(found.mass.toarray(), sound, rtol=1e-12, atol=1e-12)
