"""What slip loses over given summits while the normal load varies."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip.normal.spheres import CACHED, Spheres
from microslip.numerics.quadrature import gauss_legendre

_NODES, _WEIGHTS = gauss_legendre(10)
_CLOSE_SHARE = 0.05  # of the indentation: nearer than that, differences of powers lose digits


def means(spheres: Spheres, gap: Floats, until: Floats, first: Floats, last: Floats) -> Floats:
    """Mean over each run of half the integral of v N''(d + v) over 0 <= v <= q - d.

    The distance q - d of the front from the separation goes from ``gap`` to ``until``, both not
    negative, while d goes from ``first`` to ``last``, in straight lines. Each summit is integrated
    by itself, from where it is touched to where it parts, so its roots are at the ends of what is
    integrated.
    """
    result = np.zeros(gap.size)
    closest = np.minimum(first, last)
    # Runs of like reach together: a block takes the summits that its first run touches, the most.
    order = np.argsort(closest)
    begin = 0
    while begin < order.size:
        count = spheres.count(float(closest[order[begin]]))
        step = max(1, CACHED // max(1, count))
        rows = order[begin : begin + step]
        y, k = spheres.heights[:count], spheres.constants[:count]
        parts = (column[rows, None] for column in (gap, until, first, last))
        result[rows] = _summits(y, *parts) @ k
        begin += step
    return result


def _summits(y: Floats, gap: Floats, until: Floats, first: Floats, last: Floats) -> Floats:
    """The same for each run and each summit of height y, over its load constant."""
    deep, low = y - first, y - last
    before = deep - gap  # what the front leaves of the indentation; it falls
    after = np.minimum(low - until, before)
    span = before - after
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(span > 0.0, before / span, np.where(before > 0.0, 1.0, 0.0))
    share = np.clip(share, 0.0, 1.0)  # of the run, until the summit slips wholly
    middle = np.where(share < 1.0, gap + (until - gap) * share, 0.0)
    # From there on the whole load of the summit slips: to the power of 3/2 while there is any.
    here = np.where(before > 0.0, middle, deep)
    a, b = np.sqrt(np.maximum(here, 0.0)), np.sqrt(np.maximum(low, 0.0))
    parts = here - low
    touched = np.divide(
        a * a - b * b, parts, out=np.ones_like(parts), where=(a * b == 0.0) & (parts != 0.0)
    )
    total: Floats = 0.5 * (1.0 - share) * touched * _mean_cube(a, b)
    at = np.nonzero(share > 0.0)
    if at[0].size:
        rows = at[0]
        inside = share[at]
        partly = inside < 1.0
        remaining = before[at], np.where(partly, 0.0, after[at])
        ahead = gap[rows, 0], np.where(partly, middle[at], until[rows, 0])
        under = deep[at], np.where(partly, middle[at], low[at])
        total[at] += 0.25 * inside * _partly_slipped(*under, *remaining, *ahead)
    return total


def _mean_cube(a: Floats, b: Floats) -> Floats:
    """Mean of x^(3/2) for x from a^2 to b^2, by their roots."""
    total = a + b
    squares, product = a * a + b * b, a * b
    # (a^5 - b^5)/(a^2 - b^2) without cancellation.
    top = squares * squares - product * product + product * squares
    return np.asarray(0.4 * np.divide(top, total, out=np.zeros_like(total), where=total > 0.0))


def _partly_slipped(
    a0: Floats, a1: Floats, b0: Floats, b1: Floats, g0: Floats, g1: Floats
) -> Floats:
    """Mean of (A - B)^2 (2 A + B) for A^2 from a0 to a1 and B^2 from b0 down to b1 >= 0.

    A^2 - B^2 goes from g0 to g1.
    """
    result = np.zeros(a0.size)
    at = np.arange(a0.size)
    weight = np.ones(a0.size)
    # Where the front is near in terms of the indentation, the powers are nearly equal: a rule is
    # good there, as long as the indentation does not change by much. So runs are halved.
    for _ in range(200):
        close = np.maximum(g0, g1) < _CLOSE_SHARE * np.maximum(a0, a1)
        far = np.flatnonzero(~close)
        result[at[far]] += weight[far] * _closed(a0[far], a1[far], b0[far], b1[far])
        near = np.flatnonzero(close)
        if not near.size:
            break
        at, weight = at[near], weight[near]
        a0, a1, b0, b1, g0, g1 = (v[near] for v in (a0, a1, b0, b1, g0, g1))
        half = np.maximum(b1, 0.5 * b0)
        cut = np.divide(b0 - half, b0 - b1, out=np.ones_like(b0), where=half > b1)
        g = g0 + (g1 - g0) * cut
        a = half + g
        result[at] += weight * cut * _rule(b0, half, g0, g)
        open_runs = np.flatnonzero(cut < 1.0)
        at, weight = at[open_runs], (weight * (1.0 - cut))[open_runs]
        a0, b0, g0 = a[open_runs], half[open_runs], g[open_runs]
        a1, b1, g1 = a1[open_runs], b1[open_runs], g1[open_runs]
    return result


def _closed(a0: Floats, a1: Floats, b0: Floats, b1: Floats) -> Floats:
    """The mean in closed form, with ends that differ by enough."""
    p, r = np.sqrt(b0), np.sqrt(b1)
    total = p + r
    with np.errstate(divide="ignore", invalid="ignore"):
        root = 2.0 / 3.0 * (p * p + p * r + r * r) / total
        # The mean of B times how far the run is.
        late = (p * p * (4.0 * p + 8.0 * r) + r * r * (12.0 * p + 6.0 * r)) / (15.0 * total * total)
    root, late = np.where(total > 0.0, root, 0.0), np.where(total > 0.0, late, 0.0)
    product = a0 * root + (a1 - a0) * late
    return 2.0 * _mean_cube(np.sqrt(a0), np.sqrt(a1)) - 3.0 * product + _mean_cube(p, r)


def _rule(b0: Floats, b1: Floats, g0: Floats, g1: Floats) -> Floats:
    """The mean by a rule, where nothing changes by more than a factor of about two."""
    u = _NODES[:, None]
    b, g = b0 + (b1 - b0) * u, g0 + (g1 - g0) * u
    first, second = np.sqrt(b + g), np.sqrt(b)
    ahead = g / (first + second)
    return np.asarray(_WEIGHTS @ (ahead * ahead * (2.0 * first + second)))
