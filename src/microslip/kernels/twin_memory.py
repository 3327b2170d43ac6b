"""Masing's rules in NumPy: part of :mod:`microslip.kernels.twin`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from microslip.kernels.layout import Floats, Integers
from microslip.kernels.twin_table import evaluate


def locate(
    x: float, stack: Floats, depth: int, last: float, direction: int
) -> tuple[int, int, int]:
    """The branch that a move from ``last`` to ``x`` ends on; ``stack`` (capacity, 2) stays as is.

    Returns the new depth, whether ``last`` became the newest reversal, and the new direction.
    """
    if x == last:
        return depth, 0, direction
    way = 1 if x > last else -1
    if direction not in (0, way):
        # With `last` on top: does the move reach the reversal below it? It closes that loop.
        if depth == 0:
            return (0, 0, way) if abs(x) >= abs(last) else (1, 1, way)
        if (x - stack[depth - 1, 0]) * way < 0.0:
            return depth + 1, 1, way
        depth -= 1
    while depth > 1:
        if (x - stack[depth - 2, 0]) * way < 0.0:
            return depth, 0, way
        depth -= 2
    if depth == 1 and abs(x) >= abs(stack[0, 0]):
        depth = 0
    return depth, 0, way


def _steps(last: float, x: Floats) -> NDArray[np.int8]:
    """Which way each sample goes: compared, as differences of huge values overflow."""
    before = np.concatenate(([last], x[:-1]))
    return np.subtract(x > before, x < before, dtype=np.int8)


def closings(
    x: Floats, closed: Floats, stack: Floats, depth: int, last: float, direction: int
) -> int:
    """Amplitudes of the loops that a record closes, in the order of time; returns how many.

    ``stack`` holds the places of the open reversals with room for all samples, and is used up. Half
    a loop, where first loading goes on beyond its mirror, counts as a negative amplitude.
    """
    steps = _steps(last, x)
    moved = np.flatnonzero(steps)
    if not moved.size:
        return 0
    ways = steps[moved]
    ends = x[np.append(moved[np.flatnonzero(np.diff(ways))], moved[-1])]
    places, count = stack[:depth].tolist(), 0
    for end in ends.tolist():
        way = 1 if end > last else -1
        turned = direction not in (0, way)
        direction = way
        if turned:
            if not places and abs(end) >= abs(last):
                closed[count] = -abs(last)
                count, last = count + 1, end
                continue
            if not places or (end - places[-1]) * way < 0.0:
                places.append(last)
                last = end
                continue
            closed[count] = 0.5 * abs(last - places.pop())
            count += 1
        while len(places) > 1 and (end - places[-2]) * way >= 0.0:
            closed[count] = 0.5 * abs(places.pop() - places.pop())
            count += 1
        if len(places) == 1 and abs(end) >= abs(places[0]):
            # Its own side ends a branch that has come back; the other one, half a loop.
            closed[count] = -abs(places.pop())
            count += 1
        last = end
    return count


def branches(
    x: Floats,
    half: Floats,
    sign: Floats,
    parent: Integers,
    stack: Floats,
    codes: Integers,
    depth: int,
    last: float,
    direction: int,
) -> tuple[int, float, int]:
    """The branch tree of a record, a matter of geometry alone.

    Sample i lies at the distance ``half[i]`` along the backbone, entered with the factor
    ``sign[i]`` (2 or -2; 1 or -1 on the first loading curve) from the value at ``parent[i]``: a
    sample of this record, -1 for the origin, or -2 - k for entry k of the memory at the start
    (k = depth: the last displacement before the record). ``stack`` (capacity) and ``codes`` hold
    the open reversals and where they come from.
    """
    steps = _steps(last, x)
    moved = np.flatnonzero(steps)
    if moved.size == 0:
        starts, ways = np.zeros(1, dtype=np.int64), np.array([direction])
    else:
        ahead = steps[moved]
        starts = np.append(moved[0], moved[1:][ahead[1:] != ahead[:-1]])
        ways = steps[starts]
        if starts[0] > 0:  # samples that rest where the record begins
            starts, ways = np.append(0, starts), np.append(direction, ways)
    stops = np.append(starts[1:], x.size)

    # The only loop: one turn a run. Below the oldest reversal lie places that nothing reaches.
    places: list[float] = [math.nan, math.nan, *stack[:depth].tolist()]
    origins: list[int] = [-1, -1, *codes[:depth].tolist()]
    old_last = -2 - depth
    branch: list[int] = []  # of each run's last sample
    closed: list[tuple[int, float, int]] = []  # run, place, the branch that ends there
    before = np.append(direction, ways[:-1])
    for run, (code, origin, end, way, turned, several) in enumerate(
        zip(
            np.where(starts > 0, starts - 1, old_last).tolist(),
            np.concatenate(([last], x))[starts].tolist(),
            x[stops - 1].tolist(),
            ways.tolist(),
            ((before != 0) & (ways != before)).tolist(),
            (stops - starts > 1).tolist(),
            strict=True,
        )
    ):
        if turned:
            top = places[-1]
            if top != top:  # the origin is the newest "reversal": first loading turns
                if abs(end) < abs(origin):
                    places.append(origin)
                    origins.append(code)
                    branch.append(code)
                    continue
                if several:
                    closed.append((run, -origin, code))
            elif end < top if way > 0 else end > top:
                places.append(origin)
                origins.append(code)
                branch.append(code)
                continue
            else:
                # The move reaches the newest reversal: the loop between it and `origin` closes.
                if several:
                    closed.append((run, top, code))
                places.pop()
                origins.pop()
        while end >= places[-2] if way > 0 else end <= places[-2]:
            if several:
                closed.append((run, places[-2], origins[-1]))
            del places[-2:], origins[-2:]
        if len(places) == 3 and abs(end) >= abs(places[2]):
            if several:
                closed.append((run, -places[2], origins[2]))
            places.pop()
            origins.pop()
        branch.append(origins[-1])

    counts = np.diff(starts, append=x.size)
    parent[:] = np.repeat(np.array(branch, dtype=np.int64), counts)
    if closed:
        _restore_early_branches(parent, x, starts, stops, ways, closed)
    virgin = parent == -1
    # Where each sample's branch begins: a sample, or an entry of the memory at the start.
    memory = np.append(stack[: -2 - old_last], last)
    begin = np.where(parent >= 0, x[np.maximum(parent, 0)], memory[-2 - np.minimum(parent, -2)])
    half[:] = np.where(virgin, np.abs(x), 0.5 * np.abs(x - begin))
    way_of = np.repeat(2.0 * ways, counts)
    sign[:] = np.where(virgin, np.where(x < 0.0, -1.0, 1.0), way_of)
    depth = len(places) - 2
    stack[:depth] = places[2:]
    codes[:depth] = origins[2:]
    return depth, float(x[-1]), int(ways[-1])


def _restore_early_branches(
    parent: Integers,
    x: Floats,
    starts: Integers,
    stops: Integers,
    ways: NDArray[np.int8],
    closed: list[tuple[int, float, int]],
) -> None:
    """Give the samples that a run has before it closes loops the branches that end there."""
    run, place, branch = (np.array(column) for column in zip(*closed, strict=True))
    low, high, way = starts[run], stops[run] - 1, ways[run]
    while np.any(low < high):  # bisection for the first sample that has closed the loop
        middle = (low + high) // 2
        there = (x[middle] - place) * way >= 0.0
        low, high = np.where(there, low, middle + 1), np.where(there, middle, high)
    first = np.where(np.append(-1, run[:-1]) == run, np.append(0, low[:-1]), starts[run])
    counts = low - first
    offset = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    parent[np.repeat(first, counts) + offset] = np.repeat(branch, counts)


def accumulate(parent: Integers, rise: Floats, base: Floats) -> None:
    """Turn each sample's rise over its parent into its value, in place, down the tree.

    ``base`` holds the values of the memory's entries at the start, then that of the last sample.
    Rises and base may have columns, each a tree of its own.
    """
    if rise.ndim > 1:
        for column, start in zip(rise.T, base.reshape(-1, rise.shape[1]).T, strict=True):
            accumulate(parent, column, start)
        return
    inner = parent >= 0
    is_parent = np.zeros(parent.size, dtype=bool)
    is_parent[parent[inner]] = True
    nodes = np.flatnonzero(is_parent)
    rise[~inner] += np.append(base, 0.0)[np.where(parent == -1, base.size, -2 - parent)[~inner]]
    # Among the reversals each passes on twice as many rises as in the pass before.
    place = np.zeros(parent.size, dtype=np.int64)
    place[nodes] = np.arange(nodes.size)
    value, above = rise[nodes], parent[nodes]
    above = np.where(above >= 0, place[np.maximum(above, 0)], -1)
    live = np.flatnonzero(above >= 0)
    while live.size:
        value[live], above[live] = value[live] + value[above[live]], above[above[live]]
        live = live[above[live] >= 0]
    rise[inner] += value[place[parent[inner]]]


def respond(
    x: Floats,
    value: Floats,
    stack: Floats,
    depth: int,
    last: float,
    last_value: float,
    direction: int,
    coefficients: Floats,
    inverse_width: float,
    power: int,
    limit: float,
    rate: float,
) -> tuple[int, float, float, int]:
    """Masing's rules with a table as the backbone; ``stack`` (capacity, 2) of places and values.

    Returns the depth, the last place, the last value and the direction at the end.
    """
    places, codes = np.empty(depth + x.size + 1), np.empty(depth + x.size + 1, dtype=np.int64)
    places[:depth] = stack[:depth, 0]
    codes[:depth] = -2 - np.arange(depth)
    base = np.append(stack[:depth, 1], last_value)
    half, sign, parent = np.empty(x.size), np.empty(x.size), np.empty(x.size, dtype=np.int64)
    depth, last, direction = branches(x, half, sign, parent, places, codes, depth, last, direction)
    evaluate(half, value, None, coefficients, inverse_width, power, limit, rate)
    value *= sign
    accumulate(parent, value, base)
    origin = codes[:depth]
    stack[:depth, 0] = places[:depth]
    new, old = value[np.maximum(origin, 0)], base[-2 - np.minimum(origin, -2)]
    stack[:depth, 1] = np.where(origin >= 0, new, old)
    return depth, last, float(value[-1]), direction
