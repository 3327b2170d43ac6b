"""The kernels in NumPy: the readable twin of ``_compiled.c``, used where that is not built.

Arrays are C-contiguous float64 (``parent`` and ``codes``: int64) and are written in place.
A *table* is passed as ``coefficients, inverse_width, power, limit, rate``: panels of equal width,
each with ``TERMS`` coefficients in s, -1 <= s <= 1, of a shape S, so that the value at u >= 0 is
u**power * S(u); past the last panel it is limit + rate * (u - end).

A *memory* is the stack of open reversals, oldest first, with the last displacement and the
direction (-1, 0 or 1) of the last move. Empty, it stands for the first loading curve.
"""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

TERMS = 12
MOMENT_TERMS = 30
_BLOCK = 8192  # samples a pass, so that temporaries stay in cache


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
        q = s * s
        even = ((((c[10] * q + c[8]) * q + c[6]) * q + c[4]) * q + c[2]) * q + c[0]
        odd = ((((c[11] * q + c[9]) * q + c[7]) * q + c[5]) * q + c[3]) * q + c[1]
        shape = odd * s + even
        value[part] = v * shape if power == 1 else v * v * v * shape
        if slope is not None:
            even = ((((11 * c[11]) * q + 9 * c[9]) * q + 7 * c[7]) * q + 5 * c[5]) * q + 3 * c[3]
            odd = ((((10 * c[10]) * q + 8 * c[8]) * q + 6 * c[6]) * q + 4 * c[4]) * q + 2 * c[2]
            grade = v * (2.0 * inverse_width * ((even * q + c[1]) + odd * s))
            slope[part] = shape + grade if power == 1 else v * v * (3.0 * shape + grade)
        if outside.any():
            value[part][outside] = limit + rate * (v[outside] - end) if rate else limit
            if slope is not None:
                slope[part][outside] = rate


def evaluate_one(
    u: float, coefficients: Floats, inverse_width: float, power: int, limit: float, rate: float
) -> tuple[float, float]:
    """Value and slope of a table at one place."""
    value, slope = np.empty(1), np.empty(1)
    evaluate(np.array([u]), value, slope, coefficients, inverse_width, power, limit, rate)
    return float(value[0]), float(slope[0])


def locate(
    x: float, stack: Floats, depth: int, last: float, direction: int
) -> tuple[int, int, int]:
    """The branch that a move from ``last`` to ``x`` ends on: new depth, whether ``last`` became
    the newest reversal, new direction. ``stack`` (capacity, 2) is not changed."""
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
        starts, ways = [0], [direction]
    else:
        ahead = steps[moved]
        turns = moved[1:][ahead[1:] != ahead[:-1]]
        starts = [int(moved[0]), *turns.tolist()]
        ways = steps[starts].tolist()
        if starts[0] > 0:  # samples that rest where the record begins
            starts.insert(0, 0)
            ways.insert(0, direction)
    stops = [*starts[1:], x.size]

    open_x: list[float] = stack[:depth].tolist()
    open_code: list[int] = codes[:depth].tolist()
    last_code = -2 - depth
    seg_start: list[int] = []
    seg_way: list[int] = []
    seg_code: list[int] = []
    seg_from: list[float] = []
    first, ends = path[starts].tolist(), x[[stop - 1 for stop in stops]].tolist()
    for start, stop, way, origin, end in zip(starts, stops, ways, first, ends, strict=True):
        if way * direction < 0:
            open_x.append(origin)
            open_code.append(last_code if start == 0 else start - 1)
        direction = way or direction
        at = start
        while True:
            seg_start.append(at)
            seg_way.append(way)
            seg_code.append(open_code[-1] if open_code else -1)
            seg_from.append(open_x[-1] if open_x else math.nan)
            if way == 0 or not open_x:
                break
            close = open_x[-2] if len(open_x) > 1 else -open_x[0]
            if (end - close) * way < 0.0:
                break
            run = x[at:stop]
            at += int(np.searchsorted(run, close) if way > 0 else np.searchsorted(-run, -close))
            del open_x[-2:], open_code[-2:]
            if seg_start[-1] == at:  # the branch just left has no sample of its own
                for entries in (seg_start, seg_way, seg_code, seg_from):
                    entries.pop()
    counts = np.diff([*seg_start, x.size])
    origin = np.repeat(seg_from, counts)
    parent[:] = np.repeat(np.array(seg_code, dtype=np.int64), counts)
    virgin = parent == -1
    half[:] = np.where(virgin, np.abs(x), 0.5 * np.abs(x - origin))
    # A resting first sample has no direction of its own: it keeps the one of the memory.
    way_of = np.repeat(np.array([w or direction for w in seg_way], dtype=float), counts)
    sign[:] = np.where(virgin, np.where(x < 0.0, -1.0, 1.0), 2.0 * way_of)
    depth = len(open_x)
    stack[:depth] = open_x
    codes[:depth] = open_code
    return depth, float(x[-1]), direction


def accumulate(parent: Integers, rise: Floats, base: Floats) -> None:
    """Turn each sample's rise over its parent into its value, in place, down the tree.

    ``base`` holds the values of the memory's entries at the start, then that of the last sample.
    """
    inner = parent >= 0
    is_parent = np.zeros(parent.size + 1, dtype=bool)
    is_parent[parent[inner]] = True
    indices = np.flatnonzero(is_parent)
    bases: list[float] = base.tolist()
    known: dict[int, float] = {}
    for i, p, value in zip(
        indices.tolist(), parent[indices].tolist(), rise[indices].tolist(), strict=True
    ):
        if p >= 0:
            value += known[p]
        elif p < -1:
            value += bases[-2 - p]
        known[i] = value
    settled = np.zeros(parent.size)
    settled[indices] = list(known.values())
    early = parent < -1
    rise[inner] += settled[parent[inner]]
    rise[early] += base[-2 - parent[early]]


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
    depth, last, direction = branches(
        x, half, sign, parent, places, codes, depth, last, direction
    )
    evaluate(half, value, None, coefficients, inverse_width, power, limit, rate)
    value *= sign
    accumulate(parent, value, base)
    origin = codes[:depth]
    stack[:depth, 0] = places[:depth]
    stack[:depth, 1] = np.where(origin >= 0, value[origin], base[-2 - np.minimum(origin, -2)])
    return depth, last, float(value[-1]), direction


def _chebyshev(c: Floats, t: Floats) -> Floats:
    b1, b2 = np.zeros_like(t), np.zeros_like(t)
    twice = 2.0 * t
    for coefficient in c[:0:-1]:
        b1, b2 = twice * b1 - b2 + coefficient, b1
    return t * b1 - b2 + c[0]


def _half_power(v: Floats, twice: int) -> Floats:
    if twice == -1:
        return 1.0 / np.sqrt(v)
    result = np.sqrt(v) if twice & 1 else np.ones_like(v)
    for _ in range(twice // 2):
        result = result * v
    return result


def gaussian_moment(h: Floats, out: Floats, coefficients: Floats, twice: int) -> None:
    """F_n(h) of the standard Gaussian with 2n = ``twice``; pieces as in tools/make_gaussian_tables."""
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
