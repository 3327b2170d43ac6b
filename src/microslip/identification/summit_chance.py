"""Intervals with the sampling scatter of summits, which itself depends on the fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.identification.fit import Fit, covariance_of
from microslip.identification.problem import Problem
from microslip.identification.profiles import End, Interval, with_value

SEPARATION = "standardised_separation"
_STEP, _MOST_STEPS = 0.3, 24
"""Steps in the standardised separation, and how many each way at most."""
_HILL = 40.0
"""Rise of the likelihood across which another hollow of it is looked for."""
_ROUNDS, _PARTS = 2, 6


class _Place(NamedTuple):
    """The fit at one separation, weighed as it would have it."""

    separation: float
    q: Floats
    height: float
    """Sum of squares and logarithm of the determinant: minus twice the logarithm of likelihood."""
    variance: Floats
    """Variance of the coordinates at a given separation."""


def over_separations(best: Fit, intervals: Sequence[Interval], rises: Floats) -> list[Interval]:
    """The intervals, widened by those at other separations that are as likely.

    How many summits are in contact follows from the separation, and from that how much chance does:
    where the loops tell it poorly, weights at the best values alone make intervals too narrow. At
    each separation the rest is fitted by its own weights; its likelihood, with the determinant of
    its covariance, says what rise is left. Of laws with one free separation.
    """
    problem = best.problem
    rows = [i for i, c in enumerate(problem.free_coordinates) if c.parameter == SEPARATION]
    if problem.summits is None or len(rows) != 1:
        return list(intervals)
    row = rows[0]
    low, high = (float(bound[row]) for bound in problem.bounds)
    trial = problem.copy()
    first = _fit_at(trial, best.q, row, float(best.q[row]))
    if first is None:
        return list(intervals)
    rise_limit, places = float(rises[row]), [first]
    for way in (-1.0, 1.0):
        near, separation = first, first.separation
        for _ in range(_MOST_STEPS):
            separation = min(max(separation + way * _STEP, low), high)
            there = _fit_at(trial, near.q, row, separation)
            lowest = min(place.height for place in places)
            if there is None or there.height > lowest + rise_limit + _HILL:
                break
            places.append(there)
            near = there
            if separation in (low, high):
                break
    problem.evaluations = trial.evaluations
    lowest = min(place.height for place in places)
    widened = list(intervals)
    for place in _interpolated(sorted(places, key=lambda place: place.separation)):
        for i, interval in enumerate(widened):
            remaining = float(rises[i]) - (place.height - lowest)
            if remaining < 0.0:
                continue
            half = math.sqrt(remaining * place.variance[i])
            low, high = (float(place.q[i]) + way * half for way in (-1.0, 1.0))
            # A profile of the best weights ends before.
            if low < interval.low.value:
                moved = End(low, interval.low.is_open, with_value(place.q, i, low))
                interval = Interval(moved, interval.high)
            if high > interval.high.value:
                moved = End(high, interval.high.is_open, with_value(place.q, i, high))
                interval = Interval(interval.low, moved)
            widened[i] = interval
    return _clipped(problem, widened)


def _interpolated(places: Sequence[_Place]) -> list[_Place]:
    """The places with others on straight lines between them."""
    dense = list(places[:1])
    for a, b in pairwise(places):
        for t in np.linspace(0.0, 1.0, _PARTS + 1)[1:].tolist():
            dense.append(_Place(*((1.0 - t) * x + t * y for x, y in zip(a, b, strict=True))))
    return dense


def _fit_at(problem: Problem, q: Floats, row: int, separation: float) -> _Place | None:
    """The fit with one separation given; None where the law has no answer there."""
    conditional = np.delete(np.arange(q.size), row)
    q = with_value(q, row, separation)
    fit = Fit(problem, q)
    with np.errstate(all="ignore"):
        try:
            for _ in range(_ROUNDS):
                problem.update(fit.q)
                near = fit.settled_near(conditional)
                if near is None:
                    return None
                fit = near
            q = fit.q
            _, by = problem.residuals(q)
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None
    by_conditional = by[:, conditional]
    variance = np.zeros(q.size)
    variance[conditional] = np.diag(covariance_of(by_conditional.T @ by_conditional))
    height = fit.cost + problem.log_determinant
    return _Place(separation, q, height, variance) if math.isfinite(height) else None


def _clipped(problem: Problem, intervals: Sequence[Interval]) -> list[Interval]:
    """No end beyond what is searched; one that is there is open."""
    bounds = problem.bounds
    clipped = []
    for i, (low, high, points) in enumerate(intervals):
        (first, last), places = (float(bound[i]) for bound in bounds), (low.place, high.place)
        at_low, at_high = (np.clip(place, *bounds) for place in places)
        below = End(max(low.value, first), low.is_open or low.value <= first, at_low)
        above = End(min(high.value, last), high.is_open or high.value >= last, at_high)
        clipped.append(Interval(below, above, points))
    return clipped
