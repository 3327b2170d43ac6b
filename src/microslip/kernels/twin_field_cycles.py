"""Settled cycles of many nodes on one load curve, in NumPy: part of :mod:`microslip.kernels.twin`.

Nodes, rows and marks are those of :mod:`microslip.kernels.twin_field`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from microslip.kernels.layout import Floats, Integers
from microslip.kernels.twin_field import ArrayCurve, Bools, curve_of, make_moves, take_moves


class Entries(NamedTuple):
    """How each move of a cycle depends on what came before it, arrays (nodes, entries)."""

    sample: Integers
    sticks: Bools
    parent: Integers  # entry of the row that was cut, -1 for none
    density: Floats
    fall: Floats  # -N' at the front
    here: Floats  # -N' at the step
    share: Floats  # where the front lies in a parent that stuck
    gain: Floats  # the mean -N' of that parent beyond the front, times what is left of it
    width: Floats


def walk_cycles(
    curve: ArrayCurve, rest: Floats, place: Floats, step: Floats | None
) -> tuple[Entries, Floats, Floats]:
    """The settled cycles of nodes that all need as many passes: entries, values and loads.

    A cycle begins where step + |place| is largest, its *root*, with a straight path from rest. All
    memory is gone there, unless the root lies within what that path pressed down sticking: then a
    second pass settles it. Values and loads are those of the last pass, in the order of samples.
    """
    nodes, samples = place.shape
    d = np.zeros_like(place) if step is None else step
    at = np.arange(nodes)
    root = np.argmax(d + np.abs(place), axis=1)
    passes = 2 if np.any(np.abs(place[at, root]) <= -d[at, root]) and step is not None else 1
    count = passes * samples
    rows, marks = np.zeros((nodes * (count + 1), 3)), np.zeros((nodes * (count + 1), 2))
    begin = at * (count + 1)
    ids = np.full((nodes, count + 1), -1)
    depth = np.zeros(nodes, dtype=np.int64)
    entries = Entries(
        *(np.zeros((nodes, count), dtype=kind) for kind in (np.int64, np.bool_, np.int64)),
        *(np.zeros((nodes, count)) for _ in range(6)),
    )
    last = np.zeros(nodes), np.zeros(nodes), np.zeros(nodes)
    values, loads_ = np.empty_like(place), np.empty_like(place)
    rest_load = curve.load(rest)
    for i in range(count):
        t = (root + i) % samples
        current, x = d[at, t], place[at, t]
        before = depth
        moves = make_moves(curve, rest, rows, marks, begin, depth, last, current, x)
        load, here = rest_load if step is None else curve.load(rest + current)
        sticks = (moves.kind == 0) & (moves.front > current)
        resting = (moves.kind == 0) & ~sticks
        top = rows[begin + np.maximum(before - 1, 0)]
        slid = resting & (before > 0) & (np.abs(top[:, 1]) == 1.0)
        under = moves.depth - slid
        density = np.where(
            slid, top[:, 1], np.where(resting | (moves.kind == 2), 1.0, moves.density)
        )
        front = np.where(slid, top[:, 0], np.where(resting, current, moves.front))
        parent = np.where(sticks | (under == 0), -1, ids[at, under - 1])
        entries.sample[:, i], entries.sticks[:, i], entries.parent[:, i] = t, sticks, parent
        entries.density[:, i], entries.fall[:, i], entries.here[:, i] = density, moves.fall, here
        entries.width[:, i] = moves.front - current
        old = np.flatnonzero((parent >= 0) & entries.sticks[at, np.maximum(parent, 0)])
        if old.size:
            remaining = rows[begin[old] + under[old] - 1, 0] - front[old]
            width = entries.width[old, parent[old]]
            entries.share[old, i] = remaining / width
            entries.gain[old, i] = curve.drop(rest[old] + front[old], remaining) / width
        depth = take_moves(rows, marks, begin, last[1], current, moves)
        pushed = np.flatnonzero(depth > moves.depth)
        ids[pushed, depth[pushed] - 1] = i
        values[at, t], loads_[at, t] = moves.value, load
        last = current, x, moves.value
    return entries, values, loads_


def derive_cycles(entries: Entries, by_place: Floats, by_step: Floats) -> tuple[Floats, Floats]:
    """Derivatives of all values and loads along directions (nodes or 1, samples, directions).

    With A of a row the derivative of what it holds beyond a fixed separation, a slip from a parent
    row k to the front q has A = A[k] - N'(q) (dp - dp[k]) for places p and, for separations d,
    A = A[k] - N'(q) (s dd - s[k] dd[k]), and dT = A + s N'(d) dd; THEORY, section 15. A parent that
    stuck shifts with both of its ends.
    """
    nodes, count = entries.sample.shape
    at = np.arange(nodes)
    owner = at if by_place.shape[0] > 1 else np.zeros(nodes, dtype=np.int64)
    places, steps = by_place.shape[2], by_step.shape[2]
    ahead = np.zeros((nodes, count + 1, places + steps))  # the last one is nothing
    slopes = np.zeros_like(ahead)
    turns = np.concatenate((by_place, by_step), axis=2)
    nothing = np.zeros((nodes, places + steps))
    split = np.arange(places + steps) < places

    def along(entry: Integers) -> Floats:
        at_entry = turns[owner, entries.sample[at, np.maximum(entry, 0)]]
        return np.where((entry >= 0)[:, None], at_entry, nothing)

    for i in range(count):
        current = turns[owner, entries.sample[:, i]]
        density, fall = entries.density[:, i, None], entries.fall[:, i, None]
        here, sticks = entries.here[:, i, None], entries.sticks[:, i, None]
        factor = np.where(split, 1.0, density)  # of a row: dp, or D dd
        # New contact that sticks.
        previous = np.full(nodes, i - 1)
        was = along(previous)
        there = entries.here[:, i - 1, None] if i else np.zeros((nodes, 1))
        sticking = slopes[at, previous] + np.where(split, 0.0, density * there * was)
        stuck = sticking + factor * fall * (current - was)
        # A slip.
        parent = entries.parent[:, i]
        old = np.where(parent >= 0, entries.density[at, parent], 0.0)[:, None]
        before = np.where((parent >= 0) & entries.sticks[at, parent], parent - 1, parent)
        outer, inner = along(parent), along(before)
        share = np.where(before < parent, entries.share[:, i], 1.0)[:, None]
        grip = np.where(before < parent, entries.gain[:, i], 0.0)[:, None]
        scale = np.where(split, 1.0, old)
        at_front = (1.0 - share) * inner + share * outer
        slid = ahead[at, parent] + scale * grip * (outer - inner)
        slid = slid + fall * (factor * current - scale * at_front)
        ahead[:, i] = np.where(sticks, sticking, slid)
        slopes[:, i] = np.where(sticks, stuck, slid) - np.where(
            split, 0.0, density * here * current
        )
    load_slopes = -entries.here[:, :, None] * by_step[owner[:, None], entries.sample]
    return slopes[:, :count], load_slopes


def two_groups(place: Floats, step: Floats | None) -> list[Integers]:
    """Nodes that need one pass, and those that need two."""
    if step is None:
        return [np.arange(len(place))]
    at = np.arange(len(place))
    root = np.argmax(step + np.abs(place), axis=1)
    sticks = np.abs(place[at, root]) <= -step[at, root]
    sticks &= step[at, root] < 0.0
    return [group for group in (at[~sticks], at[sticks]) if group.size]


def field_cycle(
    place: Floats,
    step: Floats | None,
    rest: Floats,
    samples: int,
    value: Floats,
    load: Floats,
    slope: Floats,
    *profile: Any,
) -> None:
    """Settled cycles of nodes: T/mu, N and d(T/mu)/d(place) at every sample.

    Arrays are (nodes, samples); ``step`` is None where all nodes stay at ``rest``.
    """
    curve = curve_of(*profile)
    x, d = place.reshape(-1, samples), None if step is None else step.reshape(-1, samples)
    value, load, slope = (array.reshape(x.shape) for array in (value, load, slope))
    for group in two_groups(x, d):
        part = None if d is None else d[group]
        entries, value[group], load[group] = walk_cycles(curve, rest[group], x[group], part)
        last, slopes = entries.sample[:, -samples:], np.empty((group.size, samples))
        np.put_along_axis(slopes, last, entries.fall[:, -samples:], axis=1)
        slope[group] = slopes


def field_slopes(
    place: Floats,
    step: Floats | None,
    rest: Floats,
    samples: int,
    by_place: Floats,
    places: int,
    by_step: Floats,
    steps: int,
    stride: int,
    weights: Floats,
    rows: int,
    spectrum: Floats,
    jacobian: Floats,
    load_spectrum: Floats,
    load_jacobian: Floats,
    *profile: Any,
) -> None:
    """Derivatives of settled cycles along directions of place and step.

    ``by_place`` and ``by_step`` hold the directions (samples, places) and (samples, steps), with a
    ``stride`` of 1 for each node its own. With ``weights`` (samples, rows) what comes back are sums
    over the samples: of T/mu, its derivatives (rows, places + steps), of N and its derivatives
    (rows, steps). Without rows the derivatives at all samples do.
    """
    curve = curve_of(*profile)
    x, d = place.reshape(-1, samples), None if step is None else step.reshape(-1, samples)
    sets = rest.size if stride else 1
    u, v = by_place.reshape(sets, samples, places), by_step.reshape(sets, samples, steps)
    height = rows or samples
    J = jacobian.reshape(rest.size, height, places + steps)
    K = load_jacobian.reshape(rest.size, height, steps)
    w = weights.reshape(samples, rows)
    for group in two_groups(x, d):
        part = None if d is None else d[group]
        entries, value, load = walk_cycles(curve, rest[group], x[group], part)
        directions = (u[group], v[group]) if stride else (u, v)
        slope, fall = derive_cycles(entries, *directions)
        order = np.argsort(entries.sample[:, -samples:], axis=1)[:, :, None]
        slope = np.take_along_axis(slope[:, -samples:], order, axis=1)
        fall = np.take_along_axis(fall[:, -samples:], order, axis=1)
        if not rows:
            J[group], K[group] = slope, fall
            continue
        spectrum.reshape(-1, rows)[group] = value @ w
        load_spectrum.reshape(-1, rows)[group] = load @ w
        J[group], K[group] = w.T @ slope, w.T @ fall
