"""Mesh of hexahedra for beams in a row: laps with rings of cells around bolts, parts between."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.parameters import parameter, parameters_of
from microslip.contact.materials import Material
from microslip.structures.bolts import Bolts, metres
from microslip.structures.mesh import (
    Body,
    ContactFaces,
    JointMesh,
    Shank,
    Solids,
    bolt_block_half_width,
    check_count,
    lines,
    plan,
    widening,
)

Style = Literal["half-lap", "single-lap"]
_ARC = 24  # cells along a curved part, at least


@dataclass(frozen=True, eq=False)
class Lap:
    """Overlap of two parts of a :class:`BoltedBeam`, with its bolts.

    Parameters
    ----------
    at : float
        Position of the middle of the lap along the beam, from the middle of the beam [m].
    length : float
        Length of the overlap [m].
    bolts : Bolts
        Bolts through the lap, with positions relative to its middle.

    Notes
    -----
    Its faces are reduced to patches after Craig and Bampton (1968, DOI 10.2514/3.4741).
    """

    at: float = field(metadata=parameter("x", "m", "middle of the lap", example=-0.2))
    length: float = field(metadata=metres("l", "length of the overlap", 0.1))
    bolts: Bolts

    def __post_init__(self) -> None:
        for declared in parameters_of(Lap):
            assign(self, **{declared.name: declared.checked(getattr(self, declared.name))})
        if not isinstance(self.bolts, Bolts):
            raise InputError(f"bolts must be ms.Bolts(...), got {show(self.bolts)}")

    @property
    def ends(self) -> tuple[float, float]:
        """Positions of the two ends [m]."""
        return self.at - 0.5 * self.length, self.at + 0.5 * self.length


class Stretch(NamedTuple):
    """Part of the beam: its name, its side in the laps, and its extent outside the laps."""

    name: str
    lower: bool
    """Whether the part is the lower one in its laps."""
    free: tuple[tuple[float, float, bool, bool], ...]
    """Start [m], end [m], and whether a lap is at the start and at the end."""
    rise: float = 0.0
    """Height of the middle of the part above its ends [m]."""


def beam_mesh(
    laps: Sequence[Lap],
    parts: Sequence[Stretch],
    of_parts: Mapping[str, tuple[Material, float]],
    sizes: tuple[float, float],
    style: Style,
    size: float,
    side: int,
) -> JointMesh:
    """Return the mesh of a beam with the given cell size [m] in its laps.

    ``sizes`` are width and thickness [m], ``of_parts`` has material and density [kg/m^3] of each
    part by its name. ``side`` is the number of cells along each side of the square block around a
    bolt; each part of a lap has at least side/2 layers of cells.
    """
    width, thickness = sizes
    halves = [bolt_block_half_width(lap.bolts, lap.length, width) for lap in laps]
    half, edge = min(halves), 0.5 * width
    rows_of_bolts = _rows(laps, half)
    arm = 0.5 * thickness if style == "half-lap" else thickness
    layers = max(side // 2, round(0.8 * arm / size))
    bolts = max(len(lap.bolts) for lap in laps)
    longest = max(*(lap.length for lap in laps), width, arm)
    reach = [end for part in parts for free in part.free for end in free[:2]]
    lengths = float(np.ptp(reach or [0.0, longest])), width, thickness
    check_count(math.ceil(max(longest - 2.0 * half * bolts, 0.8 * arm) / size), lengths)
    rows = lines(-edge, edge, [(y - half, y + half) for y in rows_of_bolts], size, side)
    scale = 1e-7 * min(*(lap.length for lap in laps), width, thickness)
    solids = Solids(scale)
    below, above = np.linspace(-arm, 0.0, layers + 1), np.linspace(0.0, arm, layers + 1)
    heights = {True: below, False: above}
    cells_of: dict[str, list[int]] = {part.name: [] for part in parts}
    pairs: list[tuple[Stretch, Stretch, range, range]] = []
    plans, columns_of = [], []
    count = 0
    for lap, (left, right) in zip(laps, pairwise(parts), strict=True):
        marks = [(c - half, c + half) for c in np.unique(lap.bolts.positions[:, 0])]
        columns = lines(-0.5 * lap.length, 0.5 * lap.length, marks, size, side)
        count += 4 * layers * (len(columns) - 1) * (len(rows) - 1)
        check_count(count, lengths)
        flat = plan(columns, rows, lap.bolts, half, scale, side)
        flat = flat._replace(points=flat.points + np.array([lap.at, 0.0]))
        bolted = [*flat.head, *flat.pressed]
        faces = [*flat.plate, *(quad for cells in bolted for quad in cells)]
        lower, upper = (left, right) if left.lower else (right, left)
        layered = []
        for part in (lower, upper):
            at = heights[part.lower]
            layered.append(solids.extrude(flat.points, faces, at, [part.name] * len(at)))
            cells_of[part.name] += layered[-1]
        pairs.append((lower, upper, layered[0], layered[1]))
        plans.append(flat)
        columns_of.append(columns + lap.at)
    for k, part in enumerate(parts):
        levels = np.concatenate([below, above[1:]])
        levels = levels if style == "half-lap" else heights[part.lower]
        for start, stop, after, before in part.free:
            # Their ends are the very numbers that the laps have.
            ends = (
                columns_of[k - 1][-1] if after else start,
                columns_of[k][0] if before else stop,
            )
            # A curve of straight cells wants short ones.
            largest = min(5.0 * size, (stop - start) / _ARC) if part.rise else 5.0 * size
            grid = _between(*ends, after, before, min(size, largest), largest)
            points, quads = _grid(grid, rows)
            cells_of[part.name] += solids.extrude(points, quads, levels, [part.name] * len(levels))
    material, density = next(iter(of_parts.values()))
    bodies: list[Body] = []
    shanks: list[Shank] = []
    for lap, flat, (lower, upper, _, _) in zip(laps, plans, pairs, strict=True):
        fixings: list[int] = []
        shafts: list[int] = []
        thick, tall = lap.bolts.washer_thickness, 0.75 * lap.bolts.shank
        grip = np.concatenate(
            [[-arm - thick], np.linspace(-arm, arm, 2 * layers + 1), [arm + thick]]
        )
        for k in range(len(lap.bolts)):
            washer = [*flat.head[k], *flat.pressed[k]]
            disc = [*flat.head[k], *flat.clearance[k], *flat.shank[k]]
            for sign, name in ((-1, lower.name), (1, upper.name)):
                levels = sign * (arm + np.array([0.0, thick, thick + tall]))[::sign]
                quads = (washer, disc)[::sign]
                for place, ring in enumerate(quads):
                    fixings += solids.extrude(
                        flat.points, ring, levels[place : place + 2], [name] * 2
                    )
            inside = ["shank"] * (2 * layers + 1)
            shank = solids.extrude(
                flat.points, flat.shank[k], grip, [lower.name, *inside, upper.name]
            )
            shafts += shank
            shanks.append(
                Shank(f"bolt {len(shanks) + 1}", np.array(shank), np.array([0.0, 0.0, 1.0]))
            )
        suffix = "" if len(laps) == 1 else f" {len(bodies) // 2 + 1}"
        metal, heavy = lap.bolts.material or material, lap.bolts.density or density
        volume = len(lap.bolts) * _fixing_volume(lap.bolts, tall)
        of_fixings = len(lap.bolts) * lap.bolts.fixing_mass(heavy) / volume
        bodies.append(Body(f"bolts{suffix}", np.array(shafts), metal, heavy))
        bodies.append(Body(f"heads{suffix}", np.array(fixings), metal, of_fixings))
    cells, places = np.array(solids.cells), solids.points
    for part in parts:
        for start, stop, _, _ in part.free if part.rise else ():
            corners = np.unique(cells[cells_of[part.name]])
            phase = (places[corners, 0] - start) / (stop - start)
            arched = 0.5 * part.rise * (1.0 - np.cos(2.0 * math.pi * phase))
            places[corners, 2] += np.where((phase > 0.0) & (phase < 1.0), arched, 0.0)
    contacts = []
    for k, (_, _, low, high) in enumerate(pairs, start=1):
        tops, bottoms = cells[low][layers - 1 :: layers, 4:], cells[high][::layers, :4]
        contacts.append(ContactFaces("lap" if len(laps) == 1 else f"lap {k}", tops, bottoms))
    # Rigid parts need no material.
    bodies = [
        Body(
            part.name,
            np.array(cells_of[part.name]),
            *of_parts.get(part.name, (material, density)),
        )
        for part in parts
    ] + bodies
    grounds = [body.cells for body in bodies if body.name.endswith("ground")]
    corners = np.unique(cells[np.concatenate(grounds)]) if grounds else np.zeros(0, np.int64)
    return JointMesh(
        places, cells, "hexahedron", tuple(bodies), tuple(contacts), tuple(shanks), corners
    )


def _fixing_volume(bolts: Bolts, height: float) -> float:
    """Return the volume [m^3] of washers, and of head and nut as discs of total ``height`` [m]."""
    outer = bolts.pressed if bolts.pressed > 1.02 * bolts.head else bolts.head
    rings = (outer**2 - bolts.hole**2) * bolts.washer_thickness
    return 0.5 * math.pi * (rings + bolts.head**2 * height)


def _rows(laps: Iterable[Lap], half_width: float) -> Floats:
    rows = np.unique(np.concatenate([lap.bolts.positions[:, 1] for lap in laps]))
    if rows.size > 1 and np.diff(rows).min() < 2.0 * half_width * (1.0 - 1e-9):
        raise InputError(
            "bolts of different laps must lie in the same rows across, or "
            f"{2.0 * half_width:.4g} m apart, got {float(np.diff(rows).min()):.4g} m"
        )
    return rows


def _between(
    start: float, stop: float, lap_at_start: bool, lap_at_stop: bool, size: float, largest: float
) -> Floats:
    """Return grid lines from start to stop [m]; cells grow from ``size`` beside a lap."""
    if lap_at_start and lap_at_stop:
        middle = 0.5 * (start + stop)
        left = widening(start, middle, size, largest)
        right = widening(stop, middle, size, largest)
        return np.concatenate([left, right[::-1][1:]])
    near, far = (start, stop) if lap_at_start else (stop, start)
    return np.sort(widening(near, far, size, largest))


def _grid(columns: np.ndarray[Any, Any], rows: np.ndarray[Any, Any]) -> tuple[Any, Any]:
    xs, ys = np.meshgrid(columns, rows, indexing="ij")
    index = np.arange(xs.size).reshape(xs.shape)
    corners = (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    quads = np.stack([part.ravel() for part in corners], axis=1)
    return np.stack([xs.ravel(), ys.ravel()], axis=1), [tuple(quad) for quad in quads.tolist()]
