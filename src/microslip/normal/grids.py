"""What a normal law gives an interface, at many separations and many steps at once.

The sums are those of :class:`NormalLaw`: the drop N(d) - N(d + u), the fall -N'(d + u), the excess
(half the integral of v (u - v) N''(d + v) over 0 <= v <= u) and its derivative by u. An interface
asks for them at one d; here every step has its own. Where the law is smooth, whole rows (one
separation, many steps) or columns (one step, many separations) become tables, if that is quicker.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal

import numpy as np

from microslip._core.checks import Floats
from microslip.kernels import Integers
from microslip.kernels.table import Table
from microslip.normal.base import NormalLaw
from microslip.normal.table import TabulatedNormalLaw, _decayed

Kind = Literal["drop", "fall", "excess", "excess_slope"]
Progress = Callable[[float], None]

_POWERS = {"drop": 1, "excess": 3, "excess_slope": 2}
_BLOCK = 1 << 16  # points a pass
_MANY = 10_000  # loads that a table is made for

# What things cost [s], to choose the quickest way; a factor of two either way does not matter.
_POINT = 2e-6
_ROW = 4e-4
_COLUMN = 4e-3
_TERM = 8e-9
_PIECE = 6e-9


def on_grid(
    law: NormalLaw, kind: Kind, d: Floats, u: Floats, progress: Progress | None = None
) -> Floats:
    """A sum at separations d (n,) and steps u >= 0 from each, (m,) or, own ones a row, (n, m)."""
    shape = d.size, u.shape[-1]
    result = np.empty(shape)
    report = progress or _silent
    steps = np.broadcast_to(u, shape)
    own = u.ndim > 1
    if kind == "fall" and law._spheres is None:
        for part in _parts(*shape):
            result[part] = -law._derivative(d[part, None] + steps[part], 1)
            report(min(part.stop / d.size, 1.0))
        return result
    pairs = pairs_of(law)
    costs = _costs(law, *shape, own)
    way = min(costs, key=lambda name: costs[name]) if pairs else "rows"
    if way == "columns":
        if _columns(law, kind, d, u, result, report):
            return result
        way = "points"
    if way == "rows" or pairs is None:
        for i in range(d.size):
            result[i] = _row(law, kind, float(d[i]), steps[i])
            report((i + 1) / d.size)
        return result
    for part in _parts(*shape):
        flat = np.repeat(d[part], shape[1])
        value = pairs(law, kind, flat, np.ascontiguousarray(steps[part]).reshape(-1))
        result[part] = value.reshape(-1, shape[1])
        report(min(part.stop / d.size, 1.0))
    return result


def separations(law: NormalLaw, loads: Floats) -> Floats:
    """Separations of many loads, ``law.separation(loads)`` to rounding.

    Of very many on a smooth law the logarithm of the load is tabulated, and one step of Newton's
    method takes the table's rounding away.
    """
    rough = law._spheres is not None or law._breaks.size or pairs_of(law) is not _own_pairs
    if loads.size < _MANY or rough:
        return np.asarray(law.separation(loads))
    ends = np.array([loads.min(), loads.max()])
    last, first = law.separation(ends).tolist()
    start, width = np.log(ends[0]), np.log(ends[1] / ends[0])
    if first < law._edge or not width > 0.0:
        return np.asarray(law.separation(loads))
    # Measured from below the first, so that it does not pass zero.
    below = first - ends[1] / -law._derivative_at(first, 1)
    table = Table.sample(
        lambda x: np.asarray(law.separation(np.exp(start + x))) - below,
        width * (1.0 + 1e-9),
        0,
        last - below,
    )
    if table is None:
        return np.asarray(law.separation(loads))
    result = np.empty(loads.size)
    for part in _parts(loads.size, 1):
        load = loads[part]
        d = below + table.value(np.log(load) - start)
        there = law._derivative(d, 0)
        result[part] = d + np.log(there / load) * there / -law._derivative(d, 1)
    return result


def inverse_on_grid(
    law: NormalLaw, drop: Floats, d: Floats, progress: Progress | None = None
) -> Floats:
    """Steps u (n, m) at which the drops from d (n,) are ``drop`` (n, m), below N(d).

    The drop is concave: from the left Newton's method stays on the left, and rises to the answer.
    """
    fall = on_grid(law, "fall", d, np.zeros(1))
    u = drop / fall
    before = np.zeros_like(u)
    rows = np.arange(d.size)
    report = progress or _silent
    for count in range(200):
        reached = on_grid(law, "drop", d[rows], u[rows])
        slope = on_grid(law, "fall", d[rows], u[rows])
        miss = drop[rows] - reached
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.where(miss > 0.0, miss / slope, 0.0)
        # Where the law ends the slope may be none: there the answer is as near as numbers are.
        step = np.where(np.isfinite(step), step, 0.0)
        before = u[rows]
        u[rows] = before + step
        going = (step > 4e-16 * u[rows]) & (miss > 2e-16 * drop[rows])
        rows = rows[going.any(axis=1)]
        report(1.0 - 0.5 ** (count + 1.0))
        if rows.size == 0:
            break
    return u


def _silent(_: float) -> None:
    return


def _parts(rows: int, columns: int) -> Iterator[slice]:
    step = max(1, _BLOCK // max(1, columns))
    for start in range(0, rows, step):
        yield slice(start, start + step)


# -- which way -------------------------------------------------------------------------------------


def _costs(law: NormalLaw, rows: int, columns: int, own: bool) -> dict[str, float]:
    """Seconds that each way takes, roughly."""
    points = rows * columns
    spheres = law._spheres
    if spheres is not None:
        count = spheres.heights.size
        build = 4e-5 + (5e-6 * count if count > 24 else 0.0)
        return {
            "points": points * count * _TERM,
            "rows": rows * build + points * min(count * 1e-8, 8e-7),
        }
    if isinstance(law, TabulatedNormalLaw):
        pieces = law._spline.knots.size
        return {"points": points * pieces * _PIECE, "rows": rows * 9e-5 + points * 1e-7}
    costs = {"points": points * _POINT, "rows": rows * _ROW + points * 3e-8}
    if not own and not law._breaks.size:
        costs["columns"] = columns * _COLUMN + points * 3e-8
    return costs


def pairs_of(law: NormalLaw) -> Callable[[NormalLaw, Kind, Floats, Floats], Floats] | None:
    """The function that sums over pairs of separations and steps; None for a law of its own."""
    if isinstance(law, TabulatedNormalLaw):
        return _table_pairs
    general = all(
        getattr(type(law), name) is getattr(NormalLaw, name)
        for name in ("_drop", "_fall", "_excess", "_excess_slope")
    )
    return _own_pairs if general or law._spheres is not None else None


def _sum_of(law: NormalLaw, kind: Kind) -> Callable[[Floats | float, Floats], Floats]:
    sums = {
        "drop": law._drop,
        "fall": law._fall,
        "excess": law._excess,
        "excess_slope": law._excess_slope,
    }
    return sums[kind]


def _row(law: NormalLaw, kind: Kind, d: float, u: Floats) -> Floats:
    """One separation, as an interface there has it."""
    exact = _sum_of(law, kind)
    reach = law._table_reach(d) if kind != "fall" and u.size * _POINT > _ROW else None
    if reach is None:
        return exact(d, u)
    power = _POWERS[kind]
    last = float(exact(d, np.array([reach]))[0])
    load = law._derivative_at(d, 0)
    table = Table.sample(
        lambda v: exact(d, v) / v**power,
        reach,
        power,
        {"drop": load, "excess": last, "excess_slope": 0.5 * load}[kind],
        0.5 * load if kind == "excess" else 0.0,
        tolerance=1e-13 if kind == "drop" else 1e-12,
    )
    return exact(d, u) if table is None else table.value(u)


def _columns(
    law: NormalLaw, kind: Kind, d: Floats, u: Floats, result: Floats, report: Progress
) -> bool:
    """Fill the grid from one table over the separations for each step; False if that cannot be."""
    smooth = d >= law._edge
    low, high = (float(f(d[smooth])) for f in (np.min, np.max)) if smooth.any() else (0.0, 0.0)
    if not high > low:
        return False
    pairs = pairs_of(law)
    assert pairs is not None
    # A little further, so that the last separation still lies on the table.
    width = (high - low) * (1.0 + 1e-9) + 4e-16 * max(abs(low), abs(high))
    rest = np.flatnonzero(~smooth)
    inside = np.flatnonzero(smooth)
    scale = law._derivative(d[inside], 0)
    for j, step in enumerate(u.tolist()):
        # Relative to N(d) u it is of one order of magnitude, however light the load.
        def shape(place: Floats, step: float = step) -> Floats:
            at = low + place
            many = pairs(law, kind, at, np.full(at.size, step))
            return np.asarray(many / (law._derivative(at, 0) * step ** _FLAT[kind]))

        if step > 0.0:
            table = Table.sample(shape, width, 0, 0.0)
            if table is None:
                return False
            result[inside, j] = table.value(d[inside] - low) * (scale * step ** _FLAT[kind])
        else:
            result[inside, j] = 0.0
        for part in _parts(rest.size, 1):
            which = rest[part]
            result[which, j] = pairs(law, kind, d[which], np.full(which.size, step))
        report((j + 1) / u.size)
    return True


_FLAT = {"drop": 0, "fall": 0, "excess": 1, "excess_slope": 0}
"""Power of the step in the size of each sum over N(d)."""


# -- sums over pairs -------------------------------------------------------------------------------


def _own_pairs(law: NormalLaw, kind: Kind, d: Floats, u: Floats) -> Floats:
    """As the law has it, with a separation for each step."""
    return _sum_of(law, kind)(d, u)


def _table_pairs(law: NormalLaw, kind: Kind, d: Floats, u: Floats) -> Floats:
    """Piece by piece of the spline; every term is positive."""
    assert isinstance(law, TabulatedNormalLaw)
    if kind == "fall":
        return -law._derivative(d + u, 1)
    if kind == "drop":
        return _table_drop(law, d, u)
    spline = law._spline
    last = float(spline.knots[-1])
    total = np.zeros(d.size)
    pieces = zip(spline.knots[:-1], spline.knots[1:], spline.curvatures[:-1], strict=True)
    for left, right, curve in pieces:
        if curve == 0.0:
            continue
        low, high = np.maximum(left - d, 0.0), np.minimum(right - d, u)
        width, middle = high - low, 0.5 * (low + high)
        if kind == "excess":
            inner = 0.5 * curve * (middle * (u - middle) - width * width / 12.0)
        else:
            inner = 0.5 * curve * middle
        total += np.where(width > 0.0, width * inner, 0.0)
    for place, jump in zip(spline.knots, spline.jumps, strict=True):
        if jump > 0.0:
            v = place - d
            inner = v * (u - v) if kind == "excess" else v
            total += np.where((v > 0.0) & (v <= u), 0.5 * jump * inner, 0.0)
    if law.tail is not None:
        length = float(spline.loads[-1] / -spline.slopes[-1])
        begin = np.maximum(last - d, 0.0)
        past = np.flatnonzero(u > begin)
        v = begin[past]
        load = float(spline.loads[-1]) * np.exp(-np.maximum(d[past] - last, 0.0) / length)
        x = (u[past] - v) / length
        if kind == "excess":
            total[past] += 0.5 * load * (v * _decayed(x, 0, 1) + length * _decayed(x, 1, 1))
        else:
            total[past] += 0.5 * load * (v / length * _decayed(x, 0, 0) + _decayed(x, 1, 0))
    return total


def _table_drop(law: TabulatedNormalLaw, d: Floats, u: Floats) -> Floats:
    """The drops: the piece of d and, of those that reach further, what comes after it."""
    knots, _, curvatures, _, _, ends = law._spline
    i = np.clip(np.searchsorted(knots, d, side="right") - 1, 0, knots.size - 2)
    rest = knots[i + 1] - d
    first = np.clip(rest, 0.0, u)
    total = first * (curvatures[i] * (rest - 0.5 * first) - ends[i])
    further = np.flatnonzero(u > rest)
    if further.size:
        total[further] += _table_rest(law, i[further], d[further], u[further])
    return np.asarray(total)


def _table_rest(law: TabulatedNormalLaw, i: Integers, d: Floats, u: Floats) -> Floats:
    """What drops d + u have past piece i, that of d."""
    knots, slopes, curvatures, loads, _, ends = law._spline
    last = knots.size - 1
    j = np.maximum(np.searchsorted(knots, d + u, side="right") - 1, i + 1)
    h = np.maximum(u - np.maximum(knots[j] - d, 0.0), 0.0)
    falls = -0.5 * np.diff(knots) * (slopes[:-1] + ends)
    end = np.append(slopes[:-1], 0.0)  # past the last knot there is the tail, or nothing
    total = h * (-end[j] - 0.5 * curvatures[j] * h)
    between = np.flatnonzero(j > i + 1)
    if between.size:
        one, other = i[between] + 1, j[between]
        # One or two pieces by themselves; the loads at the ends of more differ by enough.
        two = falls[one] + np.where(other > one + 1, falls[np.minimum(one + 1, last - 1)], 0.0)
        total[between] += np.where(other > one + 2, loads[one] - loads[other], two)
    if law.tail is not None:
        length = float(loads[-1] / -slopes[-1])
        past = np.flatnonzero(j == last)
        load = loads[-1] * np.exp(-np.maximum(d[past] - knots[-1], 0.0) / length)
        total[past] -= load * np.expm1(-h[past] / length)
    return np.asarray(total)
