"""Branch tree of a folded record, which depends on its displacement alone."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.friction.memory import Memory
from microslip.laboratory.folding import Folded

_COINCIDENT = 1e-7  # rad


class Cycle(NamedTuple):
    """The branch tree of a folded record, from its largest displacement on: made once."""

    half: Floats
    sign: Floats
    parent: NDArray[np.int64]
    basis: Floats
    """Terms of the displacement (rows) at each place."""
    first: NDArray[np.int64]
    """Index of the first of the two nodes of each bin."""
    second: NDArray[np.int64]


def cycle_of(folded: Folded) -> Cycle:
    """The tree of a record: two places a bin, which integrate it, and the turning points."""
    low, high = folded.phase - folded.spread, folded.phase + folded.spread
    is_wide = bool(np.any(folded.spread > 0.0))
    corners = low[0] + np.mod(folded.corners - low[0], 2.0 * math.pi)
    nodes = np.concatenate((low, high, corners) if is_wide else (low, corners))
    turns = low[0] + np.mod(turning_points(folded) - low[0], 2.0 * math.pi)
    # One that a bin meets is not doubled: there would be a cycle of rounding's size.
    away = np.abs((turns[:, None] - nodes + math.pi) % (2.0 * math.pi) - math.pi)
    phase = np.concatenate((nodes, turns[away.min(axis=1) > _COINCIDENT]))
    order = np.argsort(phase, kind="stable")
    phase = phase[order]
    basis = folded.basis(phase)
    x = basis @ folded.coefficients
    x -= 0.5 * (float(x.min()) + float(x.max()))
    root = int(np.argmax(x))
    place = np.empty(order.size, dtype=np.int64)
    place[order] = (np.arange(order.size) - root) % order.size
    x = np.ascontiguousarray(np.roll(x, -root))
    tree = Memory().tree(x)
    count = folded.phase.size
    return Cycle(
        np.maximum(tree.half - folded.play, 0.0) if folded.play else tree.half,
        tree.sign,
        tree.parent,
        np.ascontiguousarray(np.roll(basis, -root, axis=0).T),
        place[:count],
        place[count : 2 * count] if is_wide else place[:count],
    )


def turning_points(folded: Folded) -> Floats:
    """Phases [rad] at which the displacement turns."""
    size = max(512, 16 * int(folded.harmonics.max()))
    grid = np.linspace(0.0, 2.0 * math.pi, size + 1)
    slope = folded.displacement(grid, 1)
    at = np.flatnonzero((slope[1:] > 0.0) != (slope[:-1] > 0.0))
    low, high = grid[at], grid[at + 1]
    rising = slope[at + 1] > slope[at]
    place = 0.5 * (low + high)
    for _ in range(50):
        here, bend = folded.displacement(place, 1), folded.displacement(place, 2)
        above = (here > 0.0) == rising
        low, high = np.where(above, low, place), np.where(above, place, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = here / bend
        new = place - step
        # Newton's step, where it stays in the bracket.
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        converged = np.abs(new - place) <= 1e-14 * math.pi
        place = new
        if converged.all():
            break
    return place
