"""Likelihood profiles: how far each number can go before the data contradict it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.identification.fit import Fit, bounds_of, covariance_of, settle
from microslip.identification.problem import Problem
from microslip.tribometer.estimates import dependence_of, quantile

_CLOSE = 0.01  # of the threshold, within which an end of an interval is found
_TRIES, _CREEPS = 14, 2
_FEELS = 1e-9  # of its value: what a quantity changes with a unit of a coordinate that it feels
MOVED = math.log(1.25)
"""Change of a logarithm below which a number is told though a coordinate it goes with is open."""
_AT_END = 1e-6  # of an interval, or of one: what is as near to its end is at it
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

    def shift(self, function: Callable[[Floats], tuple[float, Floats]], best: Floats) -> float:
        """By how much a quantity would move with the end of the search."""
        try:
            return self.ratio * (function(self.place)[0] - function(best)[0])
        except (ArithmeticError, ValueError):  # no number out there
            return math.inf


@dataclass(frozen=True)
class Interval:
    """Ends of a profile in a fitted coordinate; an end that is open is a bound."""

    low: float
    high: float
    low_open: bool
    high_open: bool
    at_low: Floats
    """All coordinates where the low end was found."""
    at_high: Floats
    points: tuple[tuple[float, float], ...] = field(default=())
    """Where the profile has been: coordinate, and rise of the sum of squares."""


def information(problem: Problem, q: Floats) -> Floats:
    """Half the second derivatives of the sum of squares, after Gauss and Newton."""
    _, by = problem.residuals(q)
    return by.T @ by


def curvature(
    problem: Problem, best: Fit, i: int, threshold: float, covariance: Floats
) -> Interval:
    """The interval of coordinate ``i`` if all were linear; open where that is beyond a bound."""
    low, high = bounds_of(problem)
    error = math.sqrt(max(float(covariance[i, i]), 1e-300))
    along = covariance[:, i] / max(float(covariance[i, i]), 1e-300)
    reach = math.sqrt(threshold) * error
    down, up = float(best.q[i]) - reach, float(best.q[i]) + reach
    at_low, at_high = (
        np.clip(best.q + along * (min(max(end, low[i]), high[i]) - best.q[i]), low, high)
        for end in (down, up)
    )
    return Interval(
        max(down, float(low[i])),
        min(up, float(high[i])),
        bool(down <= low[i]),
        bool(up >= high[i]),
        at_low,
        at_high,
    )


class Walk:
    """The way along the profile of a coordinate, the ``conditional`` ones fitted again."""

    def __init__(
        self,
        problem: Problem,
        best: Fit,
        i: int,
        threshold: float,
        covariance: Floats,
        conditional: NDArray[np.intp],
        is_last: bool,
    ) -> None:
        self._problem, self._best, self._i, self._conditional = problem, best, i, conditional
        self._threshold, self._goal, self._is_last = threshold, math.sqrt(threshold), is_last
        variance = max(float(covariance[i, i]), 1e-300)
        self._error, self._along = math.sqrt(variance), covariance[:, i] / variance
        self._bounds = bounds_of(problem)
        self.points = [(float(best.q[i]), 0.0)]
        self.lowest: Fit | None = None
        """A better minimum, if the way came upon one."""

    def profile(self) -> Interval:
        """Both ends of the interval."""
        low, low_open, at_low = self.end(-1.0)
        high, high_open, at_high = self.end(1.0)
        points = tuple(sorted(self.points))
        return Interval(low, high, low_open, high_open, at_low, at_high, points)

    def further(self, interval: Interval, places: Sequence[Floats]) -> Interval:
        """The interval, moved out where the ``places`` of other ends show a lower way to its own.

        Where the loops do not feel a coordinate at the best value, such as a force limit above all
        forces, no derivative tells the way on which it begins to count.
        """
        best = float(self._best.q[self._i])
        for direction, end, is_open, at_end in (
            (-1.0, interval.low, interval.low_open, interval.at_low),
            (1.0, interval.high, interval.high_open, interval.at_high),
        ):
            distance = abs(end - best)
            if is_open or distance == 0.0:
                continue
            for place in places:
                if place is at_end or self.is_over:
                    continue
                reached, answer = self.rise(direction, distance, place)
                if reached * _FURTHER < self._goal:
                    end, is_open, at_end = self.end(direction, (distance, reached, answer))
                    distance = abs(end - best)
                    if is_open:
                        break
            if direction < 0.0:
                interval = replace(interval, low=end, low_open=is_open, at_low=at_end)
            else:
                interval = replace(interval, high=end, high_open=is_open, at_high=at_end)
        return interval

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
        fit = settle(self._problem, start, self._conditional, good_enough=5e-3 * self._threshold)
        if fit.cost < best.cost - 0.02 * self._threshold and (
            self.lowest is None or fit.cost < self.lowest.cost
        ):
            self.lowest = fit
        if not fit.finite:
            return math.inf, fit.q
        self.points.append((float(here), max(fit.cost - best.cost, 0.0)))
        return math.sqrt(max(fit.cost - best.cost, 0.0)), fit.q

    def end(
        self, direction: float, begin: tuple[float, float, Floats] | None = None
    ) -> tuple[float, bool, Floats]:
        """The end of the interval on one side, whether it is open, and all coordinates there."""
        i, best, goal = self._i, self._best, self._goal
        bound = self._bound(direction)
        room = abs(bound - float(best.q[i]))
        if room == 0.0:
            return bound, True, best.q
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
                return float(best.q[i] + direction * last), last >= room, answer
            if reached < goal:
                if distance >= room:
                    return bound, True, answer
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
        return float(best.q[i] + direction * last), last >= room, place


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


def derived_interval(
    problem: Problem,
    best: Fit,
    function: Callable[[Floats], tuple[float, Floats]],
    threshold: float,
    covariance: Floats,
    intervals: Sequence[Interval],
    beyond: Sequence[OpenEnd] = (),
    shape: bool = False,
) -> Interval:
    """Ends of a quantity that follows from the coordinates, and whether they are open.

    Along the direction in which the quantity moves most for a rise of the sum of squares, within
    the intervals of the coordinates, where the quantity is taken as it is and not as a straight
    line; and wherever an interval that is open has led. An end is open where a coordinate that the
    quantity feels stands at an open end of its own, and where the end of a search, taken further,
    takes the quantity along (``beyond``). Of a ``shape``, a plain number, differences count.
    """
    value, gradient = function(best.q)
    low, high = (
        np.array([getattr(interval, end) for interval in intervals]) for end in ("low", "high")
    )
    low_open = np.array([interval.low_open for interval in intervals])
    high_open = np.array([interval.high_open for interval in intervals])
    near = _AT_END * np.minimum(high - low, 1.0)
    along = covariance @ gradient
    variance = float(gradient @ along)
    places = [best.q]
    if variance > 0.0:
        move = math.sqrt(threshold / variance) * along
        places += [np.clip(best.q + way * move, low, high) for way in (-1.0, 1.0)]
    if low_open.any() or high_open.any():
        places += [place for interval in intervals for place in (interval.at_low, interval.at_high)]
    ends = []
    for place in places:
        there, by = function(place)
        at_open = (low_open & (place <= low + near)) | (high_open & (place >= high - near))
        feels = np.maximum(np.abs(by), np.abs(gradient)) > _FEELS * abs(value)
        # A quantity that ends at 0 or without end is as open as what it follows from.
        ends.append((there, bool(np.any(at_open & feels))))
    (first, first_open), (last, last_open) = (
        pick(ends, key=lambda end: end[0]) for pick in (min, max)
    )
    # What is open at a bound of its own; ends of searches are judged by what they take along.
    bounds = bounds_of(problem)
    opened = (low_open & (low <= bounds[0] + near)) | (high_open & (high >= bounds[1] - near))
    opened[[open_end.row for open_end in beyond]] = False
    width = min(1.0, float((high - low)[opened].min(initial=1.0)))
    size = 1.0 if shape else abs(value) or 1.0
    moves = [open_end.shift(function, best.q) / size for open_end in beyond]
    if shape:
        narrow = last - first < MOVED * width
    else:
        narrow = first * last > 0.0 and abs(math.log(last / first)) < MOVED * width
    if narrow and all(abs(open_end) < MOVED for open_end in moves):
        # What an open coordinate hardly moves is told all the same.
        first_open = last_open = False
    far = [move for open_end, move in zip(beyond, moves, strict=True) if open_end.rests]
    first_open = first_open or any(open_end <= -MOVED for open_end in far)
    last_open = last_open or any(open_end >= MOVED for open_end in far)
    # An end that is the best value itself and open says that the best value lies at a bound.
    return Interval(first, last, first_open, last_open, best.q, best.q)


def cycle_ratio(problem: Problem, q: Floats, confidence: float = 0.999) -> Floats:
    """By how much the scatter of whole cycles makes the variance of each coordinate larger.

    By what the sandwich of the scores of single cycles (Huber 1967) exceeds its expectation under
    white noise, where it does so significantly; and where the loops grow by half of that, for it
    may be the last cycles that are meant and not their mean.
    """
    from scipy.special import chdtri

    _, by = problem.residuals(q)
    inverse = covariance_of(by.T @ by)
    influences = problem.whitened(by[: problem.weight.size].T)
    measured = np.zeros(q.size)
    expected = np.zeros(q.size)
    square = np.zeros(q.size)
    grown = np.zeros(q.size)
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
    ratio = np.divide(measured, expected, out=np.ones(q.size), where=expected > 0.0)
    # Records with little weight add few degrees of freedom (Satterthwaite).
    freedom = np.divide(expected**2, square, out=np.ones(q.size), where=square > 0.0)
    largest = chdtri(freedom, 1.0 - confidence) / freedom
    # What the nuisances bring to the variance is no noise of the cycles.
    excess = np.where(ratio > largest, measured - expected, 0.0) + grown
    return np.asarray(1.0 + excess / np.maximum(np.diag(inverse), 1e-300))
