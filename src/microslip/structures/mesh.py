"""The mesh of a bolted joint, and hexahedra for a lap from its drawing: rings around the bolts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact, show
from microslip._core.errors import InputError
from microslip.contact.materials import Material
from microslip.structures.bolts import Bolts

Indices = NDArray[np.int64]

_MOST_CELLS = 10_000  # hexahedra: some 150 000 degrees of freedom

FACETS = {
    "hexahedron": (
        (0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7),
    ),
    "tetra": ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
}  # fmt: skip
"""Corners of the facets of a cell, in VTK's order of corners."""


def facets_of(cells: Indices, kind: str) -> Indices:
    """Return the corners of all facets of cells of one kind (see ``FACETS``), cell by cell."""
    patterns = np.array(FACETS[kind])
    return np.asarray(cells[:, patterns].reshape(-1, patterns.shape[1]))


def outer(facets: Indices) -> Indices:
    """Return the facets that belong to one cell only, the surface of a mesh."""
    _, first, count = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(facets[first[count == 1]])


class Body(NamedTuple):
    """Named set of cells with one material and one density [kg/m^3]."""

    name: str
    cells: Indices
    material: Material
    density: float


class ContactFaces(NamedTuple):
    """Two faces in contact, each by the corners of its facets."""

    name: str
    lower: Indices
    upper: Indices


class Shank(NamedTuple):
    """Cells of the shank of a bolt, and the direction of its axis from lower to upper side."""

    name: str
    cells: Indices
    axis: Floats


@dataclass(frozen=True)
class JointMesh:
    """Mesh of hexahedra or tetrahedra with its bodies, contact faces and bolts.

    Corners are in VTK's order. Cells with common corners are joined; the two sides of a contact
    have no common corners.
    """

    points: Floats
    cells: Indices
    kind: str
    bodies: tuple[Body, ...]
    contacts: tuple[ContactFaces, ...]
    shanks: tuple[Shank, ...]
    ground: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Fixed corners; empty for a floating structure."""


def check_elastic(material: Material) -> None:
    """Raise InputError for a rigid or nearly incompressible material: elements would lock."""
    if not isinstance(material, Material):
        raise InputError(f"material must be a Material, got {show(material)}")
    if material.is_rigid or not -1.0 < material.poisson_ratio < 0.49:
        raise InputError(
            "finite elements need a material that is neither rigid nor incompressible "
            f"(poisson_ratio below 0.49), got {material!r}"
        )


def check_count(hexahedra: int, sizes: Iterable[float]) -> None:
    """Raise InputError for more than 10 000 hexahedra; the message states the ``sizes`` [m]."""
    if hexahedra > _MOST_CELLS:
        lengths = " x ".join(f"{size:.4g}" for size in sizes)
        raise InputError(
            f"the mesh would have {hexahedra} hexahedra or more, above the limit of "
            f"{_MOST_CELLS}; check the lengths {lengths} m, or take larger elements, such as "
            "element_size=0.01"
        )


SIDE = 4
"""Cells along each side of the square around a bolt, so 16 around its hole."""


class Plan(NamedTuple):
    """Plan of a lap: corner points [m], and cells (four indices of points) in regions."""

    points: Floats
    plate: list[tuple[int, ...]]
    """Cells of the plates, outside the pressed rings."""
    head: list[list[tuple[int, ...]]]
    """Rings between the hole and the width of the head, bolt by bolt."""
    pressed: list[list[tuple[int, ...]]]
    """Rings beyond the head where the washer is pressed, bolt by bolt; none without a washer."""
    clearance: list[list[tuple[int, ...]]]
    """Rings between shank and hole, bolt by bolt."""
    shank: list[list[tuple[int, ...]]]
    """Cells of the shanks, bolt by bolt."""


@dataclass
class _Points:
    """List of points without duplicates; a call returns the index of a point."""

    scale: float
    places: list[tuple[float, ...]] = field(default_factory=list)
    index: dict[tuple[object, ...], int] = field(default_factory=dict)

    def __call__(self, place: Iterable[float], side: object = None) -> int:
        place = tuple(float(value) for value in place)
        key = (side, *(round(value / self.scale) for value in place))
        if key not in self.index:
            self.index[key] = len(self.places)
            self.places.append(place)
        return self.index[key]


def plan(
    columns: Floats, rows: Floats, bolts: Bolts, half: float, scale: float, side: int = SIDE
) -> Plan:
    """Return the plan of a lap: cells between grid lines, and rings of cells around bolts.

    The grid lines [m] include the sides of the square block around each bolt, which has the
    half-width ``half`` [m] and ``side`` cells along each side. Points closer than ``scale`` [m] are
    merged.
    """
    at = _Points(scale)
    plate: list[tuple[int, ...]] = []
    middle = (
        0.5 * (columns[1:] + columns[:-1])[:, None, None],
        0.5 * (rows[1:] + rows[:-1])[None, :, None],
    )
    inside = np.any(
        (abs(middle[0] - bolts.positions[:, 0]) < half)
        & (abs(middle[1] - bolts.positions[:, 1]) < half),
        axis=2,
    )
    for i, j in zip(*np.nonzero(~inside), strict=True):
        xs, ys = columns[[i, i + 1, i + 1, i]], rows[[j, j, j + 1, j + 1]]
        plate.append(tuple(at(place) for place in zip(xs, ys, strict=True)))
    count = 4 * side
    # Polygons with the area of the circles: then shanks have their stiffness and plates their mass.
    swell = math.sqrt(2.0 * math.pi / count / math.sin(2.0 * math.pi / count))
    if 0.5 * swell * bolts.washer >= half:
        raise InputError(
            "rings of so few elements do not fit between the washers and the nearest edge or bolt"
        )
    angles = -0.75 * math.pi + 2.0 * math.pi * np.arange(count) / count
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    along = np.linspace(-1.0, 1.0, side + 1)[:-1]
    unit = np.ones(side)
    square = np.concatenate(
        [
            np.stack(pair, axis=1)
            for pair in ((along, -unit), (unit, along), (-along, unit), (-unit, -along))
        ]
    )
    head, pressed, clearance, shank = [], [], [], []
    for centre in bolts.positions:

        def ring(inner: Floats, outer: Floats, layers: int) -> list[tuple[int, ...]]:
            cells: list[tuple[int, ...]] = []
            for layer in range(layers):
                near, far = (
                    [
                        at(centre + p + (q - p) * k / layers)  # noqa: B023
                        for p, q in zip(inner, outer, strict=True)
                    ]
                    for k in (layer, layer + 1)
                )
                for k in range(count):
                    n = (k + 1) % count
                    cells.append((near[k], far[k], far[n], near[n]))
            return cells

        radii = {
            name: 0.5 * swell * float(getattr(bolts, name)) * circle
            for name in ("shank", "hole", "head", "pressed")
        }
        core = (0.5 * 0.55 * bolts.shank) * (0.75 * square + 0.25 * math.sqrt(2.0) * circle)
        spreads = bolts.pressed > 1.02 * bolts.head
        plate += ring(radii["pressed" if spreads else "head"], half * square, 1)
        head.append(ring(radii["hole"], radii["head"], 1))
        pressed.append(ring(radii["head"], radii["pressed"], 1) if spreads else [])
        clearance.append(ring(radii["shank"], radii["hole"], 1))
        shank.append(ring(core, radii["shank"], 1) + _core(at, centre, core, side))
    return Plan(np.array(at.places), plate, head, pressed, clearance, shank)


def _core(at: _Points, centre: Floats, border: Floats, n: int) -> list[tuple[int, ...]]:
    bottom, right = border[: n + 1], border[n : 2 * n + 1]
    top = border[2 * n : 3 * n + 1][::-1]
    left_side = np.concatenate([border[3 * n :], border[:1]])[::-1]
    u = np.linspace(0.0, 1.0, n + 1)[:, None, None]
    v = np.linspace(0.0, 1.0, n + 1)[None, :, None]
    grid = (
        (1 - v) * bottom[:, None] + v * top[:, None] + (1 - u) * left_side[None] + u * right[None]
    ) - (
        (1 - u) * (1 - v) * bottom[0]
        + u * (1 - v) * bottom[-1]
        + (1 - u) * v * top[0]
        + u * v * top[-1]
    )
    index = [[at(centre + grid[i, j]) for j in range(n + 1)] for i in range(n + 1)]
    return [
        (index[i][j], index[i + 1][j], index[i + 1][j + 1], index[i][j + 1])
        for i in range(n)
        for j in range(n)
    ]


def lines(
    start: float, stop: float, marks: Iterable[tuple[float, float]], size: float, side: int = SIDE
) -> Floats:
    """Return grid lines from start to stop [m]: ``side`` equal cells in each span of ``marks``.

    Outside these spans (from, to) [m] cells are no longer than ``size`` [m].
    """
    places = [start]
    for low, high in sorted(marks):
        places += list(_steps(places[-1], low, size)[1:])
        places += list(np.linspace(low, high, side + 1)[1:])
    places += list(_steps(places[-1], stop, size)[1:])
    return np.array(places)


def _steps(start: float, stop: float, size: float) -> Floats:
    count = max(1, math.ceil((stop - start) / size - 1e-9))
    return np.linspace(start, stop, count + 1)


def widening(start: float, stop: float, size: float, largest: float) -> Floats:
    """Return grid lines from start to stop [m], cells growing by a factor 1.4 up to a size."""
    span, cells = abs(stop - start), [size]
    while sum(cells) < span:
        cells.append(min(1.4 * cells[-1], largest))
    marks = np.concatenate([[0.0], np.cumsum(cells)]) * (span / sum(cells))
    return start + math.copysign(1.0, stop - start) * marks


def bolt_block_half_width(bolts: Bolts, lap: float, width: float) -> float:
    """Return the half-width [m] of the square mesh block that fits around each bolt and washer."""
    radius = 0.5 * bolts.washer
    # The corner of a 16-sided washer of its area lies a little outside.
    need = 1.02 * radius
    room = math.inf
    for number, (x, y) in enumerate(bolts.positions, start=1):
        if abs(x) >= 0.5 * lap or abs(y) >= 0.5 * width:
            raise InputError(
                f"bolt {number} at ({exact(float(x))}, {exact(float(y))}) m lies outside the lap, "
                f"which reaches to ±{exact(0.5 * lap)} m along and ±{exact(0.5 * width)} m across"
            )
        beside = min(0.5 * lap - abs(x), 0.5 * width - abs(y))
        if beside <= need:
            raise InputError(
                f"the washer of bolt {number} (diameter {exact(bolts.washer)} m) reaches over the "
                f"edge of the lap, {float(beside):.4g} m from its centre"
            )
        room = min(room, beside)
    for axis in (0, 1):
        gaps = np.diff(np.unique(bolts.positions[:, axis]))
        if gaps.size:
            room = min(room, 0.5 * float(gaps.min()))
    if room <= need:
        raise InputError(
            f"bolts need {2.0 * need:.4g} m between their rows and columns for washers of "
            f"{exact(bolts.washer)} m, got {2.0 * room:.4g} m"
        )
    # Rows closer to each other than to an edge still leave a cell between their squares.
    return min(need + 0.35 * (room - need), 1.5 * radius)


class Solids:
    """Hexahedra in layers over a plan; cells on different sides of the joint share no corners."""

    def __init__(self, scale: float) -> None:
        self._at = _Points(scale)
        self.cells: list[tuple[int, ...]] = []

    def extrude(
        self,
        points: Floats,
        quads: Iterable[tuple[int, ...]],
        heights: Floats,
        sides: Iterable[object],
    ) -> range:
        """Add layers of cells over a plan, between successive ``heights`` [m].

        ``sides`` labels each height: corners at equal places are shared only if labels agree.
        """
        start = len(self.cells)
        sides = list(sides)
        for quad in quads:
            rings = [
                [self._at((*points[corner], z), side) for corner in quad]
                for z, side in zip(heights, sides, strict=True)
            ]
            self.cells += [(*low, *high) for low, high in pairwise(rings)]
        return range(start, len(self.cells))

    @property
    def points(self) -> Floats:
        """Corners of the cells [m]."""
        return np.array(self._at.places)
