"""Likelihood profiles, and intervals with the sampling scatter of summits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.identification.coordinates import Function
from microslip.identification.fit import Fit, covariance_of
from microslip.identification.problem import Problem
from microslip.laboratory.estimates import dependence_of, quantile

_CLOSE = 0.01  # of the threshold, within which an end of an interval is found
_TRIES, _CREEPS = 14, 2
MOVED = math.log(1.25)
"""Change of a logarithm below which a number is told though a coordinate it goes with is open."""
_FURTHER = 1.02  # by how much an end must move to count as another one


class OpenEnd(NamedTuple):
    """A coordinate that only the search ends on one side, and what all do beyond that end."""

    row: int
    name: str
    upward: bool
    """Whether the open end is the upper one."""
    rests: bool
    """Whether the best values lie there, so that all of them lean on it."""
    place: Floats
    """All coordinates with that end as far out again."""
    ratio: float
    """1, or what is left to multiply with where the law has no answer out there."""

    def ahead(self, best: Floats) -> Floats:
        """Change of all coordinates when the end of the search is as far out again."""
        return self.ratio * (self.place - best)

    def shift(self, function: Function, best: Floats) -> float:
        """By how much a quantity would move with the end of the search."""
        try:
            return self.ratio * (function(self.place)[0] - function(best)[0])
        except (ArithmeticError, ValueError):  # no number out there
            return math.inf


class End(NamedTuple):
    """One end of an interval; where it is open it is that of the search."""

    value: float
    is_open: bool
    place: Floats
    """All coordinates where it was found."""

    def opened(self, i: int) -> End:
        """The same end of coordinate ``i``, open."""
        return End(self.value, True, with_value(self.place, i, self.value))


class Interval(NamedTuple):
    """Ends of a profile in a fitted coordinate."""

    low: End
    high: End
    points: tuple[tuple[float, float], ...] = ()
    """Points of the profile: coordinate, and rise of the sum of squares."""

    @property
    def width(self) -> float:
        """Distance of the ends."""
        return self.high.value - self.low.value


def with_value(q: Floats, i: int, value: float) -> Floats:
    """The coordinates, one of them with another value."""
    moved = q.copy()
    moved[i] = value
    return moved


def curvature(best: Fit, i: int, threshold: float, covariance: Floats) -> Interval:
    """The interval of coordinate ``i`` if all were linear; open where that is beyond a bound."""
    low, high = best.problem.bounds
    variance, here = max(float(covariance[i, i]), 1e-300), float(best.q[i])
    reach, along = math.sqrt(threshold) * math.sqrt(variance), covariance[:, i] / variance
    ends = []
    for way, bound in ((-1.0, float(low[i])), (1.0, float(high[i]))):
        end = here + way * reach
        is_open = way * (end - bound) >= 0.0
        end = bound if is_open else end
        place = np.clip(best.q + along * (end - here), low, high)
        ends.append(End(end, is_open, place))
    return Interval(ends[0], ends[1])


class Walk:
    """The way along the profile of a coordinate, the ``conditional`` ones fitted again."""

    def __init__(
        self,
        best: Fit,
        i: int,
        threshold: float,
        covariance: Floats,
        conditional: NDArray[np.intp],
        is_last: bool,
    ) -> None:
        self._best, self._i, self._conditional = best, i, conditional
        self._threshold, self._goal, self._is_last = threshold, math.sqrt(threshold), is_last
        variance = max(float(covariance[i, i]), 1e-300)
        self._error, self._along = math.sqrt(variance), covariance[:, i] / variance
        self._bounds = best.problem.bounds
        self.points = [(float(best.q[i]), 0.0)]
        self.lowest: Fit | None = None
        """A better minimum, if the way came upon one."""

    def profile(self) -> Interval:
        """Both ends of the interval."""
        ends = self.end(-1.0), self.end(1.0)
        return Interval(*ends, tuple(sorted(self.points)))

    def further(self, interval: Interval, places: Sequence[Floats]) -> Interval:
        """The interval, moved out where the ``places`` of other ends show a lower way to its own.

        Where the loops do not feel a coordinate at the best value, such as a force limit above all
        forces, no derivative tells the way on which it begins to count.
        """
        best, ends = float(self._best.q[self._i]), []
        for direction, end in ((-1.0, interval.low), (1.0, interval.high)):
            distance = abs(end.value - best)
            for place in places if distance > 0.0 else ():
                if end.is_open:
                    break
                if place is end.place or self.is_over:
                    continue
                reached, answer = self.rise(direction, distance, place)
                if reached * _FURTHER < self._goal:
                    end = self.end(direction, (distance, reached, answer))
                    distance = abs(end.value - best)
            ends.append(end)
        return Interval(ends[0], ends[1], interval.points)

    @property
    def is_over(self) -> bool:
        """Whether the search starts again from a better minimum."""
        return self.lowest is not None and not self._is_last

    def _bound(self, direction: float) -> float:
        return float(self._bounds[1 if direction > 0.0 else 0][self._i])

    def rise(self, direction: float, distance: float, near: Floats) -> tuple[float, Floats]:
        """Root of the rise of the sum of squares at a distance, and all coordinates there."""
        i, best = self._i, self._best
        bound = self._bound(direction)
        start = np.clip(near, *self._bounds)
        here = bound if distance >= abs(bound - best.q[i]) else best.q[i] + direction * distance
        start[i] = here
        fit = Fit(best.problem, start).settled(self._conditional, 5e-3 * self._threshold)
        if fit.cost < best.cost - 0.02 * self._threshold and (
            self.lowest is None or fit.cost < self.lowest.cost
        ):
            self.lowest = fit
        if not fit.finite:
            return math.inf, fit.q
        self.points.append((float(here), max(fit.cost - best.cost, 0.0)))
        return math.sqrt(max(fit.cost - best.cost, 0.0)), fit.q

    def end(self, direction: float, begin: tuple[float, float, Floats] | None = None) -> End:
        """The end of the interval on one side."""
        i, best, goal = self._i, self._best, self._goal
        bound = self._bound(direction)
        room = abs(bound - float(best.q[i]))
        if room == 0.0:
            return End(bound, True, best.q)
        inside, at_inside, place = 0.0, 0.0, best.q
        outside, at_outside = math.inf, math.inf
        distance = min(goal * self._error, room)
        side, run_length = 0, 0
        if begin is not None:
            inside, at_inside, place = begin
            distance = _next(inside, at_inside, outside, at_outside, goal, room)
        for _ in range(_TRIES):
            step = direction * distance - (place[i] - best.q[i])
            # On along the way from the best value, once there is one.
            gone = place[i] - best.q[i]
            along = self._along if gone == 0.0 else (place - best.q) / gone
            reached, answer = self.rise(direction, distance, place + along * step)
            if self.is_over:
                break
            if abs(reached - goal) <= _CLOSE * goal:
                # The root of the rise is nearly linear: the rest is interpolated.
                last = min(distance * goal / reached, room)
                return End(float(best.q[i] + direction * last), last >= room, answer)
            if reached < goal:
                if distance >= room:
                    return End(bound, True, answer)
                inside, at_inside, place = distance, reached, answer
            else:
                outside, at_outside = distance, reached
            run_length = run_length + 1 if side == (reached < goal) else 1
            side = int(reached < goal)
            if run_length >= _CREEPS and math.isfinite(outside):
                # A secant that always falls on one side converges slowly; bisection does not.
                distance = 0.5 * (inside + outside)
            else:
                distance = _next(inside, at_inside, outside, at_outside, goal, room)
        last = min(outside if math.isfinite(outside) else inside, room)
        # The bound of the search is none that the data set.
        return End(float(best.q[i] + direction * last), last >= room, place)


def _next(
    inside: float, below: float, outside: float, above: float, goal: float, room: float
) -> float:
    """The next value to try: secant within the bracket, or further out by up to four times."""
    if math.isinf(outside):
        guess = inside * goal / max(below, 1e-3 * goal)
        return min(max(guess * 1.02, 1.1 * inside), 4.0 * inside, room)
    if math.isinf(above):
        return 0.5 * (inside + outside)
    guess = inside + (outside - inside) * (goal - below) / (above - below)
    width = outside - inside
    return min(max(guess, inside + 0.05 * width), outside - 0.05 * width)


def cycle_ratio(best: Fit, confidence: float = 0.999) -> Floats:
    """By how much the scatter of whole cycles makes the variance of each coordinate larger.

    By what the sandwich of the scores of single cycles (Huber 1967) exceeds its expectation under
    white noise, where it does so significantly; and where the loops grow by half of that, for it
    may be the last cycles that are meant and not their mean.
    """
    from scipy.special import chdtri

    problem, size = best.problem, best.q.size
    _, by = problem.residuals(best.q)
    inverse = covariance_of(by.T @ by)
    influences = problem.whitened(by[: problem.weight.size].T)
    measured, expected, square, grown = np.zeros((4, size))
    for at, i in enumerate(problem.order):
        span, folded = problem.bins[at], problem.folded[i]
        # Each cycle's part in the weighted residuals of the mean, without what all share.
        part = (folded.cycle_force - folded.cycle_count * folded.force) / folded.count
        part = part * problem.weight[span]
        influence = influences[:, span]
        scores = part @ influence.T @ inverse
        number = part.shape[0]
        share = np.sum((inverse @ influence) ** 2, axis=1)
        expected += share
        if number < 2:  # one that was averaged has no cycles to scatter
            measured += share
            continue
        # Correlated cycles count as fewer.
        dependences = [dependence_of(score, 0) for score in scores.T]
        wider = np.array(
            [
                d.factor * (quantile(0.95, d.freedom) / quantile(0.95, number)) ** 2
                for d in dependences
            ]
        )
        measured += np.sum(scores**2, axis=0) * wider * number / (number - 1)
        away = (folded.force - folded.force.mean()) * problem.weight[span]
        grown += (0.5 * folded.growth * (inverse @ (influence @ away))) ** 2
        square += share**2 / (number - 1)
    ratio = np.divide(measured, expected, out=np.ones(size), where=expected > 0.0)
    # Records with little weight add few degrees of freedom (Satterthwaite).
    freedom = np.divide(expected**2, square, out=np.ones(size), where=square > 0.0)
    largest = chdtri(freedom, 1.0 - confidence) / freedom
    # What the nuisances bring to the variance is no noise of the cycles.
    excess = np.where(ratio > largest, measured - expected, 0.0) + grown
    return np.asarray(1.0 + excess / np.maximum(np.diag(inverse), 1e-300))


# -- the sampling scatter of summits, which itself depends on the fit -----------------------------

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
