"""What the reduction of a bolted joint asks of a mesh, from a drawing or from a file alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, show
from microslip.errors import InputError
from microslip.materials import Material

Indices = NDArray[np.int64]

_MOST_CELLS = 10_000  # hexahedra: some 150 000 degrees of freedom

FACETS = {
    "hexahedron": (
        (0, 1, 2, 3),
        (4, 5, 6, 7),
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 0, 4, 7),
    ),
    "tetra": ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
}  # fmt: skip
"""Corners of the facets of a cell, in VTK's order of corners."""


def facets_of(cells: Indices, kind: str) -> Indices:
    """Corners of all facets of cells, one cell after the other."""
    patterns = np.array(FACETS[kind])
    return np.asarray(cells[:, patterns].reshape(-1, patterns.shape[1]))


def outer(facets: Indices) -> Indices:
    """Those of one cell alone."""
    _, first, count = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(facets[first[count == 1]])


class Body(NamedTuple):
    """Cells of one material."""

    name: str
    cells: Indices
    material: Material
    density: float


class ContactFaces(NamedTuple):
    """Two faces that touch, each by the corners of its facets."""

    name: str
    lower: Indices
    upper: Indices


class Shank(NamedTuple):
    """Cells of the shank of a bolt, and the direction of its axis from the lower to the upper."""

    name: str
    cells: Indices
    axis: Floats


@dataclass(frozen=True)
class JointMesh:
    """A mesh of hexahedra or tetrahedra with its bodies, its contact faces and its bolts.

    Corners are in VTK's order. Cells that share corners are joined; the two sides of a contact
    share none.
    """

    points: Floats
    cells: Indices
    kind: str
    bodies: tuple[Body, ...]
    contacts: tuple[ContactFaces, ...]
    shanks: tuple[Shank, ...]


def check_elastic(material: Material) -> None:
    """Refuse what finite elements cannot take."""
    if not isinstance(material, Material):
        raise InputError(f"material must be a Material, got {show(material)}")
    if material.is_rigid or not -1.0 < material.poisson_ratio < 0.49:
        raise InputError(
            "finite elements want a material that is neither rigid nor incompressible "
            f"(poisson_ratio below 0.49), got {material!r}"
        )


def check_count(hexahedra: int) -> None:
    """Refuse more elements than memory is meant for."""
    if hexahedra > _MOST_CELLS:
        raise InputError(
            f"the mesh would have {hexahedra} hexahedra or more, above the {_MOST_CELLS} that "
            "memory is meant for; take larger elements, such as element_size=0.01"
        )
