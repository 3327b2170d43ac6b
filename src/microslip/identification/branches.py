"""Branches of the mean cycle of a record, found by Masing's rules from the displacement alone."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.friction.harmonics import bracketed_roots
from microslip.friction.memory import Memory
from microslip.laboratory.folding import Folded

_COINCIDENT = 1e-7  # rad
_TANGENT = 1e-3
"""Distance from a turn [rad] within which the displacement does not cross the level of the turn."""


class Cycle(NamedTuple):
    """Branches of a mean cycle: its nodes in temporal order, from the largest displacement on.

    Node i has the force sign[i] B(half[i]) plus that of node parent[i], at which its branch starts;
    B is the backbone, half[i] half the distance from the start of the branch [m], and sign[i] 2 or
    -2. The largest displacement has parent -1, its own value as half[i], and sign 1.
    """

    half: Floats
    sign: Floats
    parent: NDArray[np.int64]
    basis: Floats
    """Terms of the displacement (rows) at each node."""
    phase: Floats
    """Phase of each node [rad]."""
    first: NDArray[np.int64]
    """Index of the first node of each bin."""
    begin: NDArray[np.int64]
    """Start nodes of the pieces of the bins; empty if the bins are points."""
    end: NDArray[np.int64]
    """End nodes of the pieces of the bins."""
    bin: NDArray[np.int64]
    """Bin of each piece."""
    share: Floats
    """Weight of each piece in its bin [-]."""


def cycle_of(folded: Folded) -> Cycle:
    """Return the branches of a folded record, with nodes at bins, corners and turning points.

    The nodes of a bin are its samples, if the fold has kept their phases (``folded.samples``).
    Otherwise they are two: the mean phase of the bin minus and plus sqrt(3) times the standard
    deviation of its phases, which are the ends of a bin whose phases are evenly distributed.
    """
    is_wide = bool(np.any(folded.spread > 0.0))
    width = math.sqrt(3.0) * folded.spread
    low, high = folded.phase - width, folded.phase + width
    corners = low[0] + np.mod(folded.corners - low[0], 2.0 * math.pi)
    sampled = is_wide and folded.samples.size > 0
    if sampled:
        nodes = np.append(np.mod(folded.samples[0] - low[0], 2.0 * math.pi) + low[0], corners)
    else:
        nodes = np.concatenate((low, high, corners) if is_wide else (low, corners))
    turns = low[0] + np.mod(turning_points(folded) - low[0], 2.0 * math.pi)
    # One that a bin meets is not doubled: there would be a cycle of rounding's size.
    away = np.abs((turns[:, None] - nodes + math.pi) % (2.0 * math.pi) - math.pi)
    closings = _closings(folded, turns) if is_wide and not sampled and turns.size > 2 else turns[:0]
    phase = np.concatenate((nodes, turns[away.min(axis=1) > _COINCIDENT], closings))
    phase = low[0] + np.mod(phase - low[0], 2.0 * math.pi)
    order = np.argsort(phase, kind="stable")
    phase = phase[order]
    basis = folded.basis(phase)
    x = basis @ folded.coefficients
    x -= 0.5 * (float(x.min()) + float(x.max()))
    root = int(np.argmax(x))
    place = np.empty(order.size, dtype=np.int64)
    place[order] = (np.arange(order.size) - root) % order.size
    x = np.ascontiguousarray(np.roll(x, -root))
    phase = np.roll(phase, -root)
    tree = Memory().tree(x)
    count = folded.phase.size
    first = place[:count]
    second = place[count : 2 * count] if is_wide else first
    pieces = [np.zeros(0, dtype=np.int64)] * 3
    share = np.zeros(0)
    if sampled:
        first = place[: folded.samples.shape[1]]
        bins = folded.samples[1].astype(np.int64)
        pieces, share = [first, first, bins], 1.0 / np.bincount(bins)[bins]
    elif is_wide:
        size = order.size
        number = (second - first) % size
        bins = np.repeat(np.arange(count), number)
        along = np.arange(bins.size) - np.repeat(np.cumsum(number) - number, number)
        begin = (first[bins] + along) % size
        end = (begin + 1) % size
        length = np.mod(phase[end] - phase[begin], 2.0 * math.pi)
        whole = np.bincount(bins, length, minlength=count)
        share = length / np.where(whole > 0.0, whole, 1.0)[bins]
        keep = share > 0.0
        pieces, share = [begin[keep], end[keep], bins[keep]], share[keep]
        alone = np.flatnonzero(np.bincount(pieces[2], minlength=count) == 0)
        more = (first[alone], first[alone], alone)
        pieces = [np.append(*both) for both in zip(pieces, more, strict=True)]
        share = np.append(share, np.ones(alone.size))
    return Cycle(
        tree.half,
        tree.sign,
        tree.parent,
        np.ascontiguousarray(np.roll(basis, -root, axis=0).T),
        phase,
        first,
        pieces[0],
        pieces[1],
        pieces[2],
        share,
    )


def _closings(folded: Folded, turns: Floats) -> Floats:
    """Return phases [rad] just before and after the displacement meets that of an inner turn.

    An inner loop closes there, and the stiffness jumps.
    """
    levels = folded.displacement(turns)
    inner = np.abs(levels - 0.5 * (levels.max() + levels.min())) < 0.4999999 * np.ptp(levels)
    grid = np.linspace(0.0, 2.0 * math.pi, max(512, 16 * int(folded.harmonics.max())) + 1)
    above = folded.displacement(grid) > levels[inner][:, None]
    which, at = np.nonzero(above[:, 1:] != above[:, :-1])
    level = levels[inner][which]
    low = bracketed_roots(
        lambda phase: folded.displacement(phase) - level,
        lambda phase: folded.displacement(phase, 1),
        grid[at],
        grid[at + 1],
    )
    away = np.abs((low[:, None] - turns + math.pi) % (2.0 * math.pi) - math.pi)
    low = low[away.min(axis=1) > _TANGENT]
    return np.concatenate((low - 2.0 * _COINCIDENT, low + 2.0 * _COINCIDENT))


def turning_points(folded: Folded) -> Floats:
    """Return the phases [rad] at which the displacement has a maximum or minimum."""
    size = max(512, 16 * int(folded.harmonics.max()))
    grid = np.linspace(0.0, 2.0 * math.pi, size + 1)
    slope = folded.displacement(grid, 1)
    at = np.flatnonzero((slope[1:] > 0.0) != (slope[:-1] > 0.0))
    return bracketed_roots(
        lambda phase: folded.displacement(phase, 1),
        lambda phase: folded.displacement(phase, 2),
        grid[at],
        grid[at + 1],
    )
