"""What slip loses along a varying load, for laws that no profile gives.

While the front runs by dq over D, with s behind it, mu kappa (1 - s D) [N(d) - N(q) +
N'(q) (q - d)] dq is lost: twice half the integral of v N''(d + v), of which every part is positive.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.kernels import Integers
from microslip.memory import Slips
from microslip.normal.base import NormalLaw
from microslip.normal.grids import sum_over_pairs
from microslip.normal.spheres import Spheres
from microslip.normal.varying_load_losses import means
from microslip.numerics.quadrature import gauss_legendre

Rule = tuple[Floats, Floats]

_RUNS = 1 << 12  # at a time
_PIECES = 1 << 13  # of them
_NODES, _WEIGHTS = gauss_legendre(24)
# Towards both ends of a run the nodes lie as of a cosine: what has a root there is smooth then.
_ANGLES = 0.5 * math.pi * _NODES
_ROOTS: Rule = (
    np.sin(_ANGLES) ** 2,
    0.5 * math.pi * _WEIGHTS * np.sin(2.0 * _ANGLES),
)
_NO_LOSS = 1e-32  # of the largest load: no loss is left
_MOST_RUNGS = 4096  # and kinks, each small
_PARABOLAS: Rule = gauss_legendre(2)


class Losses:
    """The losses of one law; separations count from ``origin``."""

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

    def of(self, slips: Slips, samples: int) -> Floats:
        """What each step of a record loses, over mu kappa."""
        total = np.zeros(samples)
        for begin in range(0, slips.sample.size, _RUNS):
            part = Slips._make(column[begin : begin + _RUNS] for column in slips)
            _, ahead, gap, until, density, sign, first, last = part
            if self._spheres is not None:
                mean = means(self._spheres, gap, until, first, last)
            else:
                mean = self._means(gap, until, first, last)
            lost = 2.0 * ahead * (1.0 - sign * density) * mean
            total += np.bincount(part.sample, lost, minlength=samples)
        return total

    def _means(self, gap: Floats, until: Floats, first: Floats, last: Floats) -> Floats:
        """Means over runs, piece by piece where the front or the separation passes a mark."""
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
                values = self._slope(d.ravel(), v.ravel()).reshape(u.shape)
                result += np.bincount(of, share * (values @ weights), minlength=gap.size)
        return result

    def _marks_from(self, low: float) -> Floats:
        """The law's own marks and, where it fades smoothly, one each decay length from ``low`` on.

        A long step may lift an interface off: one rule over many decay lengths would not see where
        the load is.
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

    def _rules(self, front: Floats) -> list[tuple[Rule, NDArray[np.bool_]]]:
        """Which rule serves which pieces: between the knots of a table all is a parabola."""
        spline = self._law._spline
        if spline is None:
            return [(_ROOTS, np.ones(front.size, dtype=bool))]
        tail = (front > self._kinks[-1]) & spline.has_tail
        return [(_PARABOLAS, ~tail), (_ROOTS, tail)]

    def _slope(self, separation: Floats, gap: Floats) -> Floats:
        return sum_over_pairs(self._law, "excess_slope", separation + self._origin, gap)


def _pieces(
    marks: Floats, start: Floats, end: Floats, first: Floats, last: Floats
) -> tuple[Integers, Floats, Floats]:
    """The runs cut where one of their two places passes a mark: run, begin and share of each."""
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
