"""Load curves N(d) of laws without a profile, and energies lost by slip on them.

A profile is a piecewise polynomial approximation of N. Laws without one, such as individually given
summits, are evaluated here for one separation at a time.

In a memory diagram (:mod:`microslip.friction.memory.diagram`) D(eta) is the increase of
displacement/kappa per decrease of separation with which the contacts that first touch at separation
eta were loaded; kappa is the slip per indentation. A row is an interval of eta with constant D.
Slip in the direction s (1 or -1) at separation d sets D to s from eta = d to the slip front eta =
q; beyond q, D keeps its earlier value. As q advances by dq into a row with the earlier value D, the
energy lost is mu kappa |s - D| [N(d) - N(q) + N'(q) (q - d)] dq, with the friction coefficient mu
and |s - D| = 1 - s D. The bracket is the integral of v N''(d + v) over 0 <= v <= q - d, which has
no negative term.
"""

from __future__ import annotations

import math
from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.kernels import Integers
from microslip._core.quadrature import gauss_legendre
from microslip.contact.base import NormalLaw
from microslip.contact.grids import sum_over_pairs
from microslip.contact.spheres import CACHED, Spheres
from microslip.contact.spline import Spline

_SMALL_DROP = 1e-3  # of the load
_CACHED_LOADS = 64
_FEW_SUMMITS = 24  # for which plain Python is quicker than arrays


def scalar_curve(
    law: NormalLaw, origin: float
) -> _TableCurve | _LawCurve | _SpheresCurve | _ManySpheresCurve:
    """Return the load curve of a law for single separations [m] relative to ``origin`` [m].

    Its methods are `drop(base, width)`, N(base) - N(base + width) [N], and `load(separation)`, the
    load N [N] and the stiffness -N' [N/m].
    """
    if law._spline is not None:
        return _TableCurve(law._spline, origin)
    spheres = law._spheres
    if spheres is None:
        return _LawCurve(law, origin)
    kind = _SpheresCurve if spheres.heights.size <= _FEW_SUMMITS else _ManySpheresCurve
    return kind(spheres, origin)


class _LawCurve:
    """Load curve of any law, evaluated by the methods of the law."""

    def __init__(self, law: NormalLaw, origin: float) -> None:
        self._law, self._origin = law, origin
        self._loads_at: dict[float, tuple[float, float]] = {}

    def drop(self, base: float, width: float) -> float:
        here, fall = self.load(base)
        if width * fall > _SMALL_DROP * here:  # the difference loses no digit that counts
            return here - self.load(base + width)[0]
        return float(self._law._drop(base + self._origin, np.array([width]))[0])

    def load(self, separation: float) -> tuple[float, float]:
        """Return N [N] and -N' [N/m]; recent values are cached, as solvers repeat them."""
        pair = self._loads_at.get(separation)
        if pair is None:
            there = separation + self._origin
            pair = self._law._derivative_at(there, 0), -self._law._derivative_at(there, 1)
            if len(self._loads_at) >= _CACHED_LOADS:
                self._loads_at = {}  # a new one: other threads may read the old
            self._loads_at[separation] = pair
        return pair


class _SpheresCurve:
    """Load curve of a few spheres in plain Python, which is faster than NumPy for so few."""

    def __init__(self, spheres: Spheres, origin: float) -> None:
        heights = (spheres.heights - origin).tolist()
        self._spheres = list(zip(heights, spheres.constants.tolist(), strict=True))

    def drop(self, base: float, width: float) -> float:
        """Return N(base) - N(base + width) [N] without cancellation, see :data:`.spheres.DROP`."""
        total = 0.0
        for height, constant in self._spheres:
            s = height - base
            if s <= 0.0:
                break
            x = min(width / s, 1.0)
            q = math.sqrt(1.0 - x)
            total += constant * s * math.sqrt(s) * (x / (1.0 + q)) * (1.0 + q * (1.0 + q))
        return total

    def load(self, separation: float) -> tuple[float, float]:
        load = fall = 0.0
        for height, constant in self._spheres:
            s = height - separation
            if s <= 0.0:
                break
            root = constant * math.sqrt(s)
            load += s * root
            fall += 1.5 * root
        return load, fall


class _ManySpheresCurve:
    """Load curve of many spheres."""

    def __init__(self, spheres: Spheres, origin: float) -> None:
        self._heights, self._constants = spheres.heights - origin, spheres.constants
        self._depths = -self._heights

    def drop(self, base: float, width: float) -> float:
        count = int(np.searchsorted(self._depths, -base, side="left"))
        s = self._heights[:count] - base
        beyond = np.maximum(s - width, 0.0)
        root, inner = np.sqrt(s), np.sqrt(beyond)
        # A^3 - B^3 for the roots A and B, without cancellation.
        terms = np.minimum(s, width) * (s + root * inner + beyond) / (root + inner)
        return float(terms @ self._constants[:count])

    def load(self, separation: float) -> tuple[float, float]:
        count = int(np.searchsorted(self._depths, -separation, side="left"))
        s = self._heights[:count] - separation
        roots = np.sqrt(s) * self._constants[:count]
        return float(s @ roots), 1.5 * float(roots.sum())


class _TableCurve:
    """Load curve of a table in plain Python: one parabola between neighbouring knots."""

    def __init__(self, spline: Spline, origin: float) -> None:
        self._knots: list[float] = (spline.knots - origin).tolist()
        self._last = len(self._knots) - 2  # the last piece
        self._curvatures: list[float] = spline.curvatures.tolist()
        self._loads: list[float] = spline.loads.tolist()
        self._slopes: list[float] = spline.slopes.tolist()
        self._ends: list[float] = spline.ends.tolist()
        # Of positive terms, so that a fall over some pieces is right to rounding.
        drops = -0.5 * np.diff(spline.knots) * (spline.slopes[:-1] + spline.ends)
        self._falls: list[float] = drops.tolist()
        self._tail = spline.decay_length if spline.has_tail else 0.0

    def drop(self, base: float, width: float) -> float:
        knots, last = self._knots, self._last
        if base >= knots[-1]:
            if not self._tail:
                return 0.0
            return -self.load(base)[0] * math.expm1(-width / self._tail)
        i = max(bisect_right(knots, base) - 1, 0)
        r, curve, slope = knots[i + 1] - base, self._curvatures[i], -self._ends[i]
        if width <= r:
            return width * (slope + curve * (r - 0.5 * width))
        total = r * (slope + 0.5 * curve * r)
        j = max(bisect_right(knots, base + width) - 1, i + 1)
        total += sum(self._falls[i + 1 : j])
        h = max(width - (knots[j] - base), 0.0)
        if j <= last:
            return total + h * (-self._slopes[j] - 0.5 * self._curvatures[j] * h)
        return total - (self._loads[-1] * math.expm1(-h / self._tail) if self._tail else 0.0)

    def load(self, separation: float) -> tuple[float, float]:
        past = separation - self._knots[-1]
        if past >= 0.0:
            if not self._tail:
                return 0.0, 0.0
            load = self._loads[-1] * math.exp(-past / self._tail)
            return load, load / self._tail
        i = max(bisect_right(self._knots, separation) - 1, 0)
        r, curve, slope = self._knots[i + 1] - separation, self._curvatures[i], -self._ends[i]
        return self._loads[i + 1] + r * (0.5 * r * curve + slope), slope + r * curve


QuadratureRule = tuple[Floats, Floats]

_RUNS = 1 << 12  # at a time
_PIECES = 1 << 13  # of them
_NODES, _WEIGHTS = gauss_legendre(24)
# Towards both ends of a run the nodes lie as of a cosine: what has a root there is smooth then.
_ANGLES = 0.5 * math.pi * _NODES
_ROOTS: QuadratureRule = (
    np.sin(_ANGLES) ** 2,
    0.5 * math.pi * _WEIGHTS * np.sin(2.0 * _ANGLES),
)
_NO_LOSS = 1e-32  # of the largest load: no loss is left
_MOST_RUNGS = 4096  # and kinks, each small
_PARABOLAS: QuadratureRule = gauss_legendre(2)
_SUMMIT_NODES, _SUMMIT_WEIGHTS = gauss_legendre(10)
_CLOSE_SHARE = 0.05  # of the indentation: nearer than that, differences of powers lose digits


class SlipLosses:
    """Energy dissipated by slip in an interface; separations are relative to ``origin`` [m]."""

    def __init__(self, law: NormalLaw, origin: float) -> None:
        self._law, self._origin = law, origin
        small = law._small_kinks
        # Very many make a curve that a rule takes for smooth.
        kinks = np.union1d(law._kinks, small) if small.size <= _MOST_RUNGS else law._kinks
        self._kinks = kinks - origin
        self._marks, self._low, self._top = self._kinks, math.inf, math.inf
        spheres = law._spheres
        self._spheres: Spheres | None = None
        if spheres is not None:
            self._spheres = Spheres(spheres.heights - origin, spheres.constants)

    def of(self, runs: Floats, samples: int) -> Floats:
        """Return the energy dissipated in each sample of a record, divided by mu kappa [N m].

        A column of ``runs`` is one advance of the slip front q into a row of the memory diagram, in
        order of time. Its eight entries, with the symbols of the module docstring, are the sample,
        the distance of the advance [m], q - d before and after it [m], the earlier value D of the
        row, the direction s, and d before and after it [m]. The record has ``samples`` samples.
        """
        total = np.zeros(samples)
        for begin in range(0, runs.shape[1], _RUNS):
            sample, ahead, gap, until, density, sign, first, last = runs[:, begin : begin + _RUNS]
            if self._spheres is not None:
                mean = _summit_means(self._spheres, gap, until, first, last)
            else:
                mean = self._means(gap, until, first, last)
            lost = 2.0 * ahead * (1.0 - sign * density) * mean
            total += np.bincount(sample.astype(np.int64), lost, minlength=samples)
        return total

    def _means(self, gap: Floats, until: Floats, first: Floats, last: Floats) -> Floats:
        marks = self._marks_from(float(np.minimum(first, last).min(initial=0.0)))
        runs, lows, widths = _pieces(marks, first + gap, last + until, first, last)
        growth, rise = until - gap, last - first
        result = np.zeros(gap.size)
        for begin in range(0, runs.size, _PIECES):
            run, low, width = (v[begin : begin + _PIECES] for v in (runs, lows, widths))
            middle = first[run] + (low + 0.5 * width) * rise[run]
            touching = middle < self._top
            front = middle + gap[run] + (low + 0.5 * width) * growth[run]
            for (places, weights), selection in self._rules(front):
                selection = selection & touching
                of, share = run[selection], width[selection]
                if not of.size:
                    continue
                u = low[selection, None] + share[:, None] * places
                v = gap[of, None] + u * growth[of, None]
                d = first[of, None] + u * rise[of, None]
                separations = d.ravel() + self._origin
                values = sum_over_pairs(self._law, "excess_slope", separations, v.ravel())
                result += np.bincount(
                    of, share * (values.reshape(u.shape) @ weights), minlength=gap.size
                )
        return result

    def _marks_from(self, low: float) -> Floats:
        """Return the separations above ``low`` [m] at which quadrature intervals end.

        They are the kinks of the law and, where it is smooth, points one decay length apart: a
        single rule over many decay lengths would be inaccurate if the faces move far apart.
        """
        if low >= self._low:
            return self._marks
        law, smooth = self._law, low
        if law._spline is not None:
            if not law._spline.has_tail:
                return self._marks
            smooth = float(self._kinks[-1])
        rungs: list[float] = []
        faintest, place = 0.0, smooth + self._origin
        while len(rungs) < _MOST_RUNGS:
            load, slope = law._derivative_at(place, 0), law._derivative_at(place, 1)
            faintest = faintest or _NO_LOSS * load
            if not (load > faintest and slope < 0.0):
                break
            place += load / -slope
            rungs.append(place - self._origin)
        self._low, self._marks = low, np.union1d(self._kinks, rungs)
        if len(rungs) < _MOST_RUNGS and rungs:
            self._top = rungs[-1]
        return self._marks

    def _rules(self, front: Floats) -> list[tuple[QuadratureRule, NDArray[np.bool_]]]:
        """Return quadrature rules (nodes and weights on [0, 1]), each with the mask of its pieces.

        ``front`` is the slip front [m] in the middle of each piece of :func:`_pieces`.
        """
        spline = self._law._spline
        if spline is None:
            return [(_ROOTS, np.ones(front.size, dtype=bool))]
        tail = (front > self._kinks[-1]) & spline.has_tail
        return [(_PARABOLAS, ~tail), (_ROOTS, tail)]


def _pieces(
    marks: Floats, start: Floats, end: Floats, first: Floats, last: Floats
) -> tuple[Integers, Floats, Floats]:
    """Divide runs (advances of the slip front) where the front or the separation passes a mark.

    The front moves from ``start`` to ``end``, the separation from ``first`` to ``last`` [m]. Return
    for each piece the index of its run, and its start and width as fractions of the run [-].
    """
    runs, cuts = [np.arange(start.size)] * 2, [np.zeros(start.size), np.ones(start.size)]
    for begin, stop in ((start, end), (first, last)):
        low = np.searchsorted(marks, np.minimum(begin, stop), side="right")
        count = np.maximum(np.searchsorted(marks, np.maximum(begin, stop), side="left") - low, 0)
        run = np.repeat(np.arange(start.size), count)
        index = np.arange(run.size) - np.repeat(np.cumsum(count) - count, count)
        runs.append(run)
        cuts.append((marks[low[run] + index] - begin[run]) / (stop - begin)[run])
    run, cut = np.concatenate(runs), np.concatenate(cuts)
    order = np.lexsort((cut, run))
    run, cut = run[order], cut[order]
    width = np.diff(cut)
    at = np.flatnonzero((np.diff(run) == 0) & (width > 0.0))
    return run[at], cut[at], width[at]


# -- given summits ---------------------------------------------------------------------------------


def _summit_means(
    spheres: Spheres, gap: Floats, until: Floats, first: Floats, last: Floats
) -> Floats:
    """Return the mean over each run of half the integral of v N''(d + v) over 0 <= v <= q - d.

    A run is an advance of the slip front q. During it the distance q - d changes linearly from
    ``gap`` to ``until`` [m], both not negative, and d from ``first`` to ``last`` [m]. Each summit
    is integrated from its first to its last contact, with square-root singularities there.
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
    """Return :func:`_summit_means` for single summits, shape (runs, summits).

    A summit of height y [m] has the load (y - d)^(3/2), that is a load constant of one.
    """
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
    """Return the mean of x^(3/2) for x from a^2 to b^2."""
    total = a + b
    squares, product = a * a + b * b, a * b
    # (a^5 - b^5)/(a^2 - b^2) without cancellation.
    top = squares * squares - product * product + product * squares
    return np.asarray(0.4 * np.divide(top, total, out=np.zeros_like(total), where=total > 0.0))


def _partly_slipped(
    a0: Floats, a1: Floats, b0: Floats, b1: Floats, g0: Floats, g1: Floats
) -> Floats:
    """Return the mean of (A - B)^2 (2 A + B) over each advance of the slip front q [m^(3/2)].

    A^2 is the indentation y - d of a summit of height y, and B^2 = y - q, the indentation less the
    distance q - d of the slip front from the separation. A^2 changes linearly from ``a0`` to
    ``a1``, B^2 from ``b0`` to ``b1`` and q - d from ``g0`` to ``g1`` [m]. A quarter of the result
    is the mean of :func:`_summit_means` for a partly slipped summit with the load (y - d)^(3/2).
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
    u = _SUMMIT_NODES[:, None]
    b, g = b0 + (b1 - b0) * u, g0 + (g1 - g0) * u
    first, second = np.sqrt(b + g), np.sqrt(b)
    ahead = g / (first + second)
    return np.asarray(_SUMMIT_WEIGHTS @ (ahead * ahead * (2.0 * first + second)))
