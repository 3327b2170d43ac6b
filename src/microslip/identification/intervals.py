"""The intervals of all coordinates of a fit: their profiles, and ends that only a search sets."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from microslip._core.checks import Floats
from microslip.identification.coordinates import GAIN, RIG, Coordinate
from microslip.identification.fit import (
    Fit,
    bounds_of,
    covariance_of,
    resettled,
    settle_near,
)
from microslip.identification.problem import Problem
from microslip.identification.profiles import (
    MOVED,
    Interval,
    OpenEnd,
    Walk,
    curvature,
    cycle_ratio,
    information,
)
from microslip.identification.rules import MISFIT
from microslip.identification.summit_chance import over_separations, with_value
from microslip.identification.verdicts import WIDEST_RATIO

Progress = Callable[[float], None]

_SIGNIFICANT = 1e-3
_CERTAIN = 1e12  # times the information of what is known
_TOLD_WIDTH = 0.5 * math.log(WIDEST_RATIO)
_RESTARTS = 3


_MOST_WORK = 1e8
"""Evaluations times places times derivatives after which intervals are those of the curvature."""
_MOST_EVALUATIONS = 3000
"""The same for laws of which a single evaluation takes long."""
_MOST_CROSSED = 12
"""Free coordinates up to which ends of one profile are tried as ways of the others."""


@dataclass
class Profiled:
    """A fit with the profiles of its coordinates."""

    best: Fit
    intervals: list[Interval]
    widen: Floats
    covariance: Floats
    threshold: float
    """Rise of chi-squared at an end."""
    linear: Sequence[int] = ()
    """Coordinates whose intervals are those of the curvature."""
    open_ends: Sequence[OpenEnd] = ()
    """Where only the search ends a coordinate, and what all do beyond."""
    stake: float | None = None
    """Largest share of a number [-] that may hide behind what the law leaves; None of none."""
    lower_still: bool = False
    """Whether even the last profiles came upon a lower minimum."""


def profiled(
    problem: Problem, best: Fit, level: float, freedom: int, report: Progress, kind: str
) -> Profiled:
    """Intervals of all free coordinates by "profile" or "curvature"."""
    from scipy.special import chdtrc, chdtri

    threshold = float(chdtri(1, 1.0 - level))
    size = best.q.size
    work = _MOST_WORK / (problem.half.size * (4.0 + size))
    evaluation_limit = problem.evaluations + min(work, _MOST_EVALUATIONS)
    for attempt in range(_RESTARTS):
        if not best.finite:
            nothing = Interval(-math.inf, math.inf, True, True, best.q, best.q)
            return Profiled(best, [nothing] * size, np.ones(size), np.eye(size), threshold)
        covariance = covariance_of(information(problem, best.q))
        by_noise = noise_shares(problem, best.q, covariance)
        reduced = best.cost / freedom
        hidden_shift = misfit_shift(best, freedom)
        excess = reduced if chdtrc(freedom, best.cost) < _SIGNIFICANT else 1.0
        widen = np.maximum(cycle_ratio(problem, best.q), 1.0 + (max(excess, 1.0) - 1.0) * by_noise)
        errors = np.sqrt(np.diag(covariance) * by_noise)
        stake = stake_of(problem, best, errors * np.sqrt(threshold * widen), hidden_shift * errors)
        if not is_at_stake(stake):
            widen = (np.sqrt(widen) + hidden_shift * np.sqrt(by_noise / threshold)) ** 2
        task = _Task(problem, best, threshold * widen, covariance, attempt == _RESTARTS - 1)
        linear = task.run(kind, evaluation_limit, report)
        if task.better is None:
            break
        best = resettled(problem, task.better.q)
    ends = open_ends(problem, best, covariance, task.intervals, threshold * widen)
    intervals = leant_on_bounds(problem, best, task.intervals, ends)
    if problem.summits is not None:
        widths = np.array([interval.high - interval.low for interval in intervals])
        intervals = over_separations(problem, best, intervals, threshold * widen)
        wider = np.array([interval.high - interval.low for interval in intervals]) / widths
        covariance = covariance * np.outer(wider, wider)  # of what follows from them
    return Profiled(
        best, intervals, widen, covariance, threshold, linear, ends, stake, task.lower_still
    )


# -- ends that only the search sets ----------------------------------------------------------------

_NEAR = 1e-6  # of what is searched, or of one: what is as near to its end is at it
_BACK = 0.02  # of what is searched
_FURTHEST = 12.0
"""By how much an end of a search is moved at most: what is searched for Gaussian heights."""


def open_ends(
    problem: Problem, best: Fit, covariance: Floats, intervals: Sequence[Interval], rises: Floats
) -> list[OpenEnd]:
    """Ends that only the search sets, and all coordinates with that end as far out again."""
    searched = {parameter.name for parameter in problem.model.parameters if parameter.beyond}
    low, high = bounds_of(problem)
    open_ends_found = []
    for row, j in enumerate(problem.free):
        coordinate, interval = problem.coordinates[int(j)], intervals[row]
        reach = min(float(high[row] - low[row]), _FURTHEST)
        if coordinate.parameter not in searched or not interval.low < interval.high:
            continue
        near = _NEAR * min(reach, 1.0)
        for upward, is_open, place in (
            (False, interval.low_open, interval.at_low),
            (True, interval.high_open, interval.at_high),
        ):
            if not is_open:
                continue
            bound = float((high if upward else low)[row])
            rests, move = abs(bound - float(best.q[row])) <= near, reach if upward else -reach
            if rests:
                there = _fit_beyond(problem, best, best.q, row, move)
            else:
                there = _profile_beyond(problem, best, place, row, move, float(rises[row]))
            ratio = 1.0
            if there is None:  # back on the way, as the curvature tells it
                along = covariance[:, row] / max(float(covariance[row, row]), 1e-300)
                there, ratio = best.q - _BACK * move * along, -1.0 / _BACK
            open_ends_found.append(OpenEnd(row, coordinate.name, upward, rests, there, ratio))
    return open_ends_found


def _profile_beyond(
    problem: Problem, best: Fit, place: Floats, row: int, move: float, rise: float
) -> Floats | None:
    """The others where a coordinate is beyond the end of its search; None without an answer."""
    there = _fit_beyond(problem, best, place, row, move, is_held=True)
    if there is None:
        return None
    near, far = (
        float(np.dot(r, r)) - best.cost for r in (problem.residuals(q)[0] for q in (place, there))
    )
    if far <= rise:
        return there
    goal, first, last = (math.sqrt(max(x, 0.0)) for x in (rise, near, far))
    part = min(max((goal - first) / max(last - first, 1e-300), 0.0), 1.0)
    return _fit_beyond(problem, best, place, row, part * move, is_held=True)


def _fit_beyond(
    problem: Problem, best: Fit, start: Floats, row: int, move: float, is_held: bool = False
) -> Floats | None:
    """Fit with one bound moved; None where the law has no answer there."""
    j = int(problem.free[row])
    coordinate = problem.coordinates[j]
    low, high = coordinate.limits
    ends = sorted((coordinate.outer(low + min(move, 0.0)), coordinate.outer(high + max(move, 0.0))))
    moved = problem.copy()
    before = (*problem.coordinates[:j], replace(coordinate, low=ends[0], high=ends[1]))
    moved.coordinates = (*before, *problem.coordinates[j + 1 :])
    q, moving = start.copy(), np.arange(start.size)
    if is_held:
        q[row] += move
        moving = np.delete(moving, row)
    fit = settle_near(moved, q, moving)
    problem.evaluations = moved.evaluations
    is_good = fit is not None and np.isfinite(fit.q).all() and (is_held or fit.cost <= best.cost)
    return fit.q if is_good and fit is not None else None


def log_change(coordinate: Coordinate, q: float, moved: float) -> float:
    """Change of a coordinate as that of the logarithm of its value; of a plain number itself."""
    if coordinate.kind == "log" or coordinate.shape:
        return moved
    return moved / max(abs(q), 1e-300)


# -- what may hide behind a misfit -----------------------------------------------------------------


def noise_shares(problem: Problem, q: Floats, covariance: Floats) -> Floats:
    """Share of the variance of each coordinate that is not of the sensors' gains."""
    if not problem.gains:
        return np.ones(q.size)
    certain = problem.copy()
    certain.gains = {}
    certain.update(q)
    known = information(certain, q)
    for row, j in enumerate(problem.free):
        if problem.coordinates[int(j)].parameter == GAIN:
            known[row, row] *= _CERTAIN
    return np.minimum(np.diag(covariance_of(known)) / np.diag(covariance), 1.0)


def misfit_shift(best: Fit, freedom: int) -> float:
    """Shift of any coordinate, in standard errors, that may hide behind what the law leaves.

    What the law lacks has a part that no value of a coordinate makes, which is what is left beside
    noise, and one that looks like a change of the coordinate, of which nothing is seen. Taken to be
    as large as the first, it moves the coordinate by the root of the sum of squares beside noise.
    0 where that is no more than the noise.
    """
    from scipy.special import chdtrc

    is_noise = chdtrc(freedom, best.cost) > _SIGNIFICANT
    return 0.0 if is_noise else math.sqrt(best.cost - freedom)


def stake_of(problem: Problem, best: Fit, widths: Floats, shifts: Floats) -> float | None:
    """The largest of the shifts, of its number, of those that half widths say are told at all."""
    shares = [
        abs(log_change(coordinate, q, shift))
        for coordinate, q, width, shift in zip(
            (problem.coordinates[int(j)] for j in problem.free),
            best.q.tolist(),
            widths.tolist(),
            shifts.tolist(),
            strict=True,
        )
        if abs(log_change(coordinate, q, width)) < _TOLD_WIDTH
    ]
    return max(shares, default=None)


def is_at_stake(stake: float | None) -> bool:
    """Whether so much may hide that all numbers are but apparent."""
    return stake is not None and stake > MISFIT.outside


def leant_on_bounds(
    problem: Problem, best: Fit, intervals: Sequence[Interval], ends: Sequence[OpenEnd]
) -> list[Interval]:
    """The intervals, those ends open at which the end of another search ends them, not the data."""
    free = [problem.coordinates[int(j)] for j in problem.free]
    low_bound, high_bound = bounds_of(problem)
    widened = list(intervals)
    for end in ends:
        j = end.row
        bound = float((high_bound if end.upward else low_bound)[j])
        near = 1e-6 * min(float(high_bound[j] - low_bound[j]), 1.0)
        ways = end.ahead(best.q)
        for i, interval in enumerate(intervals):
            if i == j:
                continue
            ahead = log_change(free[i], float(best.q[i]), float(ways[i]))
            moves = abs(ahead) >= MOVED
            unit = 1.0 if end.rests else min(intervals[j].high - intervals[j].low, 1.0)
            if not moves and _width(free[i], interval) / unit < MOVED:
                continue
            low, high = (
                abs(place[j] - bound) <= near for place in (interval.at_low, interval.at_high)
            )
            if end.rests and moves:
                # All values stand there; moved, that end takes the number one way alone.
                low, high = ahead < 0.0, ahead > 0.0
            # What follows from an end that opens is open there, too.
            if low:
                at_low = with_value(widened[i].at_low, i, interval.low)
                widened[i] = replace(widened[i], low_open=True, at_low=at_low)
            if high:
                at_high = with_value(widened[i].at_high, i, interval.high)
                widened[i] = replace(widened[i], high_open=True, at_high=at_high)
    return widened


def _width(coordinate: Coordinate, interval: Interval) -> float:
    """Width of an interval, of positive values in the logarithm."""
    if coordinate.kind == "log":
        return interval.high - interval.low
    return math.log(max(interval.high, 1e-300) / max(interval.low, 1e-300))


class _Task:
    """The profiles about one minimum."""

    def __init__(
        self, problem: Problem, best: Fit, rises: Floats, covariance: Floats, is_last: bool
    ) -> None:
        self._problem, self._best, self._rises = problem, best, rises
        self._covariance, self._is_last = covariance, is_last
        self.intervals: list[Interval] = []
        self.better: Fit | None = None
        """A lower minimum, from which all begins again."""
        self.lower_still = False
        self._conditional = [np.zeros(0, dtype=np.intp)] * best.q.size
        for part in problem.parts:
            for i in part:
                self._conditional[i] = part[part != i]

    def run(self, kind: str, evaluation_limit: float, report: Progress) -> list[int]:
        """All intervals; which of them are those of the curvature, after ``evaluation_limit``."""
        problem, size = self._problem, self._best.q.size
        results = [
            curvature(problem, self._best, i, float(self._rises[i]), self._covariance)
            for i in range(size)
        ]
        self.intervals = results
        if kind == "curvature":
            return list(range(size))
        # The rig competes with all other parameters: it comes first.
        is_rig = [problem.coordinates[int(j)].parameter == RIG for j in problem.free]
        order = sorted(range(size), key=lambda i: not is_rig[i])
        for finished, i in enumerate(order):
            if problem.evaluations > evaluation_limit:
                return sorted(order[finished:])
            walk = self._walk(i)
            results[i] = self._checked(walk, walk.profile())
            report((finished + 1) / size)
            if self.better is not None:
                return []
        if size <= _MOST_CROSSED:
            self._cross(evaluation_limit)
        return []

    def _walk(self, i: int) -> Walk:
        rise, conditional = float(self._rises[i]), self._conditional[i]
        return Walk(
            self._problem, self._best, i, rise, self._covariance, conditional, self._is_last
        )

    def _checked(self, walk: Walk, interval: Interval) -> Interval:
        """The interval; a lower minimum on the way to it counts, unless it is the last time."""
        if walk.lowest is not None and self._is_last:
            self.lower_still = True
        elif walk.lowest is not None:
            self.better = walk.lowest
        return interval

    def _cross(self, evaluation_limit: float) -> None:
        """Ends of what is open on one side only, as ways of the others."""
        for j, interval in enumerate(self.intervals):
            ends = (interval.at_low, interval.low_open), (interval.at_high, interval.high_open)
            places = [place for place, is_open in ends if not is_open]
            if len(places) != 1:
                continue
            for i in self._conditional[j]:
                if self.better is not None or self._problem.evaluations > evaluation_limit:
                    return
                walk = self._walk(int(i))
                further = walk.further(self.intervals[i], places)
                self.intervals[i] = self._checked(walk, further)
