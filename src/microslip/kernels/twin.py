"""The kernels in NumPy: the readable twin of ``_compiled.c``, used where that is not built.

Arrays are C-contiguous float64 (``parent`` and ``codes``: int64) and are written in place.
A *table* is passed as ``coefficients, inverse_width, power, limit, rate``: panels of equal width,
each with ``TERMS`` coefficients in s, -1 <= s <= 1, of a shape S, so that the value at u >= 0 is
u**power * S(u); past the last panel it is limit + rate * (u - end).

A *memory* is the stack of open reversals, oldest first, with the last displacement and the
direction (-1, 0 or 1) of the last move. Empty, it stands for the first loading curve.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip.kernels.twin_diagram import coupled as coupled
from microslip.kernels.twin_diagram import coupled_step as coupled_step
from microslip.kernels.twin_diagram import diagram as diagram
from microslip.kernels.twin_diagram import step_front as step_front
from microslip.kernels.twin_hold import hold as hold
from microslip.kernels.twin_losses import losses as losses
from microslip.kernels.twin_profile import PROFILE_TERMS as PROFILE_TERMS
from microslip.kernels.twin_profile import drops as drops
from microslip.kernels.twin_profile import loads as loads
from microslip.kernels.twin_profile import separations as separations

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

TERMS = 12
MOMENT_TERMS = 30
_BLOCK = 8192  # samples a pass, so that temporaries stay in cache


def _shape(c: Any, s: Any) -> Any:
    """The polynomial of a panel: a row of coefficients and a number, or arrays for each."""
    q = s * s
    even = ((((c[10] * q + c[8]) * q + c[6]) * q + c[4]) * q + c[2]) * q + c[0]
    odd = ((((c[11] * q + c[9]) * q + c[7]) * q + c[5]) * q + c[3]) * q + c[1]
    return odd * s + even


def _shape_slope(c: Any, s: Any) -> Any:
    q = s * s
    even = ((((11 * c[11]) * q + 9 * c[9]) * q + 7 * c[7]) * q + 5 * c[5]) * q + 3 * c[3]
    odd = ((((10 * c[10]) * q + 8 * c[8]) * q + 6 * c[6]) * q + 4 * c[4]) * q + 2 * c[2]
    return (even * q + c[1]) + odd * s


def _value(u: Any, shape: Any, power: int) -> Any:
    """u^power S for a power of 0 to 3."""
    for _ in range(power):
        shape = u * shape
    return shape


def _slope(u: Any, shape: Any, grade: Any, power: int) -> Any:
    if power == 0:
        return grade
    slope = power * shape + u * grade
    for _ in range(power - 1):
        slope = u * slope
    return slope


def evaluate(
    u: Floats,
    value: Floats,
    slope: Floats | None,
    coefficients: Floats,
    inverse_width: float,
    power: int,
    limit: float,
    rate: float,
) -> None:
    """Value, and slope if an array is given for it, of a table at ``u``."""
    columns = np.ascontiguousarray(coefficients.reshape(-1, TERMS).T)
    panels = columns.shape[1]
    end = panels / inverse_width
    for start in range(0, u.size, _BLOCK):
        part = slice(start, start + _BLOCK)
        v = u[part]
        z = v * inverse_width
        outside = ~(z < panels)
        panel = np.where(outside, 0, z).astype(np.int64)
        s = 2.0 * (z - panel) - 1.0
        c = [column.take(panel) for column in columns]
        shape = _shape(c, s)
        value[part] = _value(v, shape, power)
        if slope is not None:
            slope[part] = _slope(v, shape, 2.0 * inverse_width * _shape_slope(c, s), power)
        if outside.any():
            value[part][outside] = limit + rate * (v[outside] - end) if rate else limit
            if slope is not None:
                slope[part][outside] = rate


def evaluate_one(
    u: float, coefficients: Floats, inverse_width: float, power: int, limit: float, rate: float
) -> tuple[float, float]:
    """Value and slope of a table at one place, in the order of operations of :func:`evaluate`."""
    z = u * inverse_width
    panels = coefficients.size // TERMS
    if not z < panels:
        return (limit + rate * (u - panels / inverse_width) if rate else limit), rate
    panel = int(z)
    s = 2.0 * (z - panel) - 1.0
    c: list[float] = coefficients.reshape(-1, TERMS)[panel].tolist()
    shape = _shape(c, s)
    grade = 2.0 * inverse_width * _shape_slope(c, s)
    return _value(u, shape, power), _slope(u, shape, grade, power)


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
    path = np.concatenate(([last], x))
    steps = np.sign(np.diff(path)).astype(np.int8)
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
            path[starts].tolist(),
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
    run, place, left = (np.array(column) for column in zip(*closed, strict=True))
    low, high, way = starts[run], stops[run] - 1, ways[run]
    while np.any(low < high):  # bisection for the first sample that has closed the loop
        middle = (low + high) // 2
        there = (x[middle] - place) * way >= 0.0
        low, high = np.where(there, low, middle + 1), np.where(there, middle, high)
    first = np.where(np.append(-1, run[:-1]) == run, np.append(0, low[:-1]), starts[run])
    counts = low - first
    offset = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    parent[np.repeat(first, counts) + offset] = np.repeat(left, counts)


def accumulate(parent: Integers, rise: Floats, base: Floats) -> None:
    """Turn each sample's rise over its parent into its value, in place, down the tree.

    ``base`` holds the values of the memory's entries at the start, then that of the last sample.
    """
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


def _chebyshev(c: Floats, t: Floats) -> Floats:
    b1, b2 = np.zeros_like(t), np.zeros_like(t)
    twice = 2.0 * t
    for coefficient in c[:0:-1]:
        b1, b2 = twice * b1 - b2 + coefficient, b1
    return np.asarray(t * b1 - b2 + c[0])


def _half_power(v: Floats, twice: int) -> Floats:
    if twice == -1:
        return 1.0 / np.sqrt(v)
    result = np.sqrt(v) if twice & 1 else np.ones_like(v)
    for _ in range(twice // 2):
        result = result * v
    return result


def gaussian_moment(h: Floats, out: Floats, coefficients: Floats, twice: int) -> None:
    """F_n(h) of the standard Gaussian with 2n = ``twice``; pieces as in make_gaussian_tables.py."""
    pieces = coefficients.reshape(4, MOMENT_TERMS)
    for mask, piece in (
        (h < -10.0, 0),
        ((h >= -10.0) & (h < -4.0), 1),
        ((h >= -4.0) & (h < 0.0), 2),
        ((h >= 0.0) & (h <= 1e3), 3),
    ):
        if not mask.any():
            continue
        v = h[mask]
        if piece == 0:
            z = 10.0 / v
            out[mask] = _half_power(-v, twice) * _chebyshev(pieces[0], 2.0 * z * z - 1.0)
        elif piece == 1:
            out[mask] = _chebyshev(pieces[1], (v + 7.0) / 3.0)
        elif piece == 2:
            out[mask] = _chebyshev(pieces[2], (v + 2.0) / 2.0)
        else:
            # exp(-h^2/2) with h = head + tail, head^2 exact: a rounded square would cost 1e-13.
            head = np.floor(v * 128.0 + 0.5) / 128.0
            tail = v - head
            decay = np.exp(-0.5 * head * head) * np.exp(-0.5 * tail * (v + head))
            r = 1.0 / (v + 4.0)
            out[mask] = decay * _half_power(r, twice + 2) * _chebyshev(pieces[3], (v - 4.0) * r)
    out[h > 1e3] = 0.0


def gaussian_moment_at(h: float, coefficients: Floats, twice: int) -> float:
    """F_n(h) at one h, in plain Python: arrays of one are slow."""
    if h > 1e3:
        return 0.0
    if h >= 0.0:
        r = 1.0 / (h + 4.0)
        piece, t = 3, (h - 4.0) * r
        head = math.floor(h * 128.0 + 0.5) / 128.0
        decay = math.exp(-0.5 * head * head) * math.exp(-0.5 * (h - head) * (h + head))
        scale = decay * r ** (0.5 * twice + 1.0)
    elif h >= -10.0:
        piece, t = (2, (h + 2.0) / 2.0) if h >= -4.0 else (1, (h + 7.0) / 3.0)
        scale = 1.0
    else:
        piece, t = 0, 200.0 / (h * h) - 1.0
        scale = (-h) ** (0.5 * twice)
    first = piece * MOMENT_TERMS
    b1 = b2 = 0.0
    for c in coefficients[first + MOMENT_TERMS - 1 : first : -1].tolist():
        b1, b2 = 2.0 * t * b1 - b2 + c, b1
    return float(scale * (t * b1 - b2 + coefficients[first]))
