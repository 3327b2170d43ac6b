"""A small lap joint and ways to solve it that are not the package's own, for the tests."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

import microslip as ms
from microslip.structures.mesh import Body, ContactFaces, JointMesh, Shank, Solids

STEEL = ms.Material(young_modulus=200e9, poisson_ratio=0.3)
DENSITY = 7800.0
STRIP = """
schema = 1
title = "A bolted strip"

[surface]
materials = ["steel", "steel"]
law = "greenwood-williamson"
heights = { kind = "gaussian", std = "1 um" }
radius = "1 mm"
density = "50 1/mm^2"
area = "2 cm^2"

[joint]
friction_coefficient = 0.35

[structure]
length = "200 mm"
width = "20 mm"
thickness = "12 mm"
lap = "30 mm"
density = "7800 kg/m^3"
element_size = "12 mm"
patches = [3, 2]
base_damping_ratio = 0.0005
samples = 32

[structure.bolts]
positions = ["0 mm"]
shank = "6 mm"
hole = "6.6 mm"
washer = "12 mm"
tension = "5 kN"
"""
"""A study of the small lap."""


def small_lap(**changes: Any) -> ms.LapJoint:
    """Two short beams with one bolt."""
    bolts = ms.Bolts([0.0], shank=0.006, hole=0.0066, washer=0.012, tension=5e3)
    sizes = {"length": 0.2, "width": 0.02, "thickness": 0.012, "lap": 0.03, "bolts": bolts}
    return ms.LapJoint(**(sizes | changes))


@lru_cache
def small_joint() -> ms.ReducedJoint:
    """It, with coarse elements and six patches."""
    return small_lap().reduce(
        STEEL, DENSITY, patches=(3, 2), element_size=0.012, sensors={"tip": ((0.1, 0, 0), "z")}
    )


LARGER = ms.LapJoint(
    length=0.3, width=0.03, thickness=0.02, lap=0.06,
    bolts=ms.Bolts([0.0], shank=8e-3, hole=9e-3, washer=16e-3, tension=10e3),
)  # fmt: skip


@lru_cache
def bolted_lap(patches: tuple[int, int] | None) -> ms.ReducedJoint:
    """A larger lap, of steel with 210 GPa, sensed at its end."""
    end = {"end": ((0.14, 0.0, 0.0), "z")}
    return LARGER.reduce(ms.Material(210e9, 0.3), 7850.0, patches, element_size=0.015, sensors=end)


def boxes(solids: Solids, lines: tuple[Any, Any, Any], side: str) -> np.ndarray[Any, Any]:
    """Hexahedra of a box by grid lines along x, y and z."""
    xs, ys, zs = (np.asarray(line, dtype=float) for line in lines)
    points = np.array(list(product(xs, ys)))
    n = len(ys)
    quads = [
        (i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1)
        for i in range(len(xs) - 1)
        for j in range(n - 1)
    ]
    return np.array(solids.extrude(points, quads, zs, [side] * len(zs)))


TETRAHEDRA = ((0, 1, 3, 7), (0, 1, 7, 4), (1, 5, 4, 7), (1, 2, 3, 7), (1, 6, 2, 7), (1, 5, 6, 7))


def beam(kind: str, elements: tuple[int, int, int], size: tuple[float, float, float]) -> JointMesh:
    """A plain beam, of hexahedra or of tetrahedra."""
    solids = Solids(1e-9)
    lines = tuple(np.linspace(0, s, n + 1) for s, n in zip(size, elements, strict=True))
    boxes(solids, (lines[0], lines[1], lines[2]), "beam")
    cells = np.array(solids.cells)
    if kind == "tetra":
        cells = np.concatenate([cells[:, corners] for corners in TETRAHEDRA])
    body = Body("beam", np.arange(len(cells)), STEEL, DENSITY)
    return JointMesh(solids.points, cells, kind, (body,), (), ())


def fork(lower: int, upper: int) -> JointMesh:
    """Two prongs that touch at z = 0, their grids not matching, and a post that holds them.

    The post is the bolt: it lies along z, beside the prongs.
    """
    solids = Solids(1e-9)
    across = np.linspace(-0.01, 0.01, 3)
    below, above = np.linspace(-0.01, 0.0, 3), np.linspace(0.0, 0.01, 3)
    # The prongs share the corners of the post at x = 0 but for those at z = 0.
    post = boxes(solids, ([-0.01, 0.0], across, [-0.01, -0.005, 0.005, 0.01]), "both")
    arms = []
    for heights, count, side in ((below, lower, "low"), (above, upper, "high")):
        name = len(solids.cells)
        grid = np.linspace(0.0, 0.05, count + 1)
        boxes(solids, (grid, across, heights), side)
        arms.append(np.arange(name, len(solids.cells)))
    points, cells = solids.points, np.array(solids.cells)
    used, cells = np.unique(_joined(points, cells, post, arms), return_inverse=True)
    points, cells = points[used], cells.reshape(-1, 8)
    faces = []
    for arm, layer in ((arms[0], slice(4, 8)), (arms[1], slice(0, 4))):
        corners = cells[arm][:, layer]
        faces.append(corners[(abs(points[corners][:, :, 2]) < 1e-12).all(axis=1)])
    bodies = (
        Body("post", post, STEEL, DENSITY),
        Body("low", arms[0], STEEL, DENSITY),
        Body("high", arms[1], STEEL, DENSITY),
    )
    return JointMesh(
        points,
        cells,
        "hexahedron",
        bodies,
        (ContactFaces("low on high", *faces),),
        (Shank("post", post, np.array([0.0, 0.0, 1.0])),),
    )


def _joined(points: Any, cells: Any, post: Any, arms: list[Any]) -> Any:
    """Cells whose corners at x = 0, outside z = 0, are those of the post."""
    held = {tuple(np.round(points[c], 9)): c for c in np.unique(cells[post])}
    cells = cells.copy()
    for arm in arms:
        for corner in np.unique(cells[arm]):
            place = tuple(np.round(points[corner], 9))
            if place in held:
                cells[arm] = np.where(cells[arm] == corner, held[place], cells[arm])
    return cells


def timoshenko(material: ms.Material, density: float, width: float, height: float, length: float,
               count: int) -> np.ndarray[Any, Any]:  # fmt: skip
    """Bending frequencies of a free beam [Hz] by Timoshenko's theory and Cowper's coefficient."""
    from scipy.linalg import expm
    from scipy.optimize import brentq

    area, inertia = width * height, width * height**3 / 12.0
    bending = material.young_modulus * inertia
    nu = material.poisson_ratio
    shear = material.shear_modulus * area * 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
    scale = np.array([1.0, 1.0 / length, bending / length**2, bending / length**3])

    def determinant(omega: float) -> float:
        slopes = np.zeros((4, 4))  # of deflection, rotation, moment and shear force
        slopes[0, 1], slopes[0, 3], slopes[1, 2], slopes[2, 3] = 1.0, 1.0 / shear, 1.0 / bending, -1
        slopes[2, 1] = -density * inertia * omega**2
        slopes[3, 0] = -density * area * omega**2
        transfer = expm(slopes * (scale[None] / scale[:, None]) * length)
        return float(np.linalg.det(transfer[2:, :2]))

    first = 22.3733 * np.sqrt(bending / (density * area)) / length**2
    grid = np.linspace(0.3, 3.0 * (count + 1) ** 1.5, 800) * first
    values = [determinant(omega) for omega in grid]
    roots = [
        brentq(determinant, grid[i], grid[i + 1])
        for i in range(len(grid) - 1)
        if values[i] * values[i + 1] < 0.0
    ]
    return np.array(roots[:count]) / (2.0 * np.pi)


def surface_of_gaps(path: Path, pair: ms.MaterialPair, area: float) -> ms.GreenwoodWilliamson:
    """Read the gap densities of the Brake-Reuss beam (DOI 10.1016/j.ymssp.2023.110210).

    A gap z is a summit of height -z, so that the separation is minus the closure.
    """
    table = {name: np.ravel(value) for name, value in io.loadmat(path).items()}
    gaps = table["normzinterp"] * table["z_max"].item()
    heights = ms.TabulatedHeights(0.0 - gaps[::-1], table["pzinterp"][::-1])
    density = table["area_density"].item()
    return ms.GreenwoodWilliamson(pair, heights, table["Re"].item(), density, area)
