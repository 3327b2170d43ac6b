"""The intervals of all coordinates of a fit: their profiles, and ends that only a search sets."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from microslip._core.checks import Floats, Progress
from microslip.identification.coordinates import GAIN, RIG, Coordinate, Function
from microslip.identification.fit import Fit, covariance_of
from microslip.identification.profiles import (
    MOVED,
    End,
    Interval,
    OpenEnd,
    Walk,
    curvature,
    cycle_ratio,
    over_separations,
)
from microslip.identification.verdicts import MISFIT, WIDEST_RATIO

_SIGNIFICANT = 1e-3
_CERTAIN = 1e12  # times the information of what is known
_TOLD_WIDTH = 0.5 * math.log(WIDEST_RATIO)
_RESTARTS = 3
_NEAR = 1e-6  # of what is searched, or of one: what is as near to its end is at it
_AT_END = 1e-6  # of an interval, or of one: what is as near to its end is at it
_FEELS = 1e-9  # of its value: what a quantity changes with a unit of a coordinate that it feels
_BACK = 0.02  # of what is searched
_FURTHEST = 12.0
"""By how much an end of a search is moved at most: what is searched for Gaussian heights."""
_MOST_WORK = 1e8
"""Evaluations times places times derivatives after which intervals are those of the curvature."""
_MOST_EVALUATIONS = 3000
"""The same for laws of which a single evaluation takes long."""
_MOST_CROSSED = 12
"""Free coordinates up to which ends of one profile are tried as ways of the others."""


class Profiled:
    """A fit with the profiles of its coordinates, by "profile" or "curvature"."""

    def __init__(self, best: Fit, level: float, report: Progress, kind: str) -> None:
        from scipy.special import chdtri

        problem, size = best.problem, best.q.size
        self.best, self.level = best, level
        self.threshold = float(chdtri(1, 1.0 - level))
        """Rise of chi-squared at an end."""
        self.widen, self.covariance = np.ones(size), np.eye(size)
        self.stake: float | None = None
        """Largest share of a number [-] that may hide behind what the law leaves; None of none."""
        self.intervals: list[Interval] = []
        self.linear: Sequence[int] = ()
        """Coordinates whose intervals are those of the curvature."""
        self.open_ends: list[OpenEnd] = []
        """Ends at which only the search bounds a coordinate, with the values of all beyond."""
        self.lower_still = False
        """Whether even the last profiles came upon a lower minimum."""
        self._better: Fit | None = None
        self._conditional = [np.zeros(0, dtype=np.intp)] * size
        for part in problem.parts:
            for i in part:
                self._conditional[i] = part[part != i]
        work = _MOST_WORK / (problem.half.size * (4.0 + size))
        self._evaluation_limit = problem.evaluations + min(work, _MOST_EVALUATIONS)
        for attempt in range(_RESTARTS):
            if not self.best.finite:
                return
            self._weigh()
            self._is_last = attempt == _RESTARTS - 1
            self.linear = self._walked(kind, report)
            if self._better is None:
                break
            self.best, self._better = self._better.resettled(), None
        self._beyond_searches()
        self._lean()
        if problem.summits is not None:
            widths = np.array([interval.width for interval in self.intervals])
            self.intervals = over_separations(self.best, self.intervals, self.rises)
            wider = np.array([interval.width for interval in self.intervals]) / widths
            # Of what follows from them.
            self.covariance = self.covariance * np.outer(wider, wider)

    @property
    def rises(self) -> Floats:
        """Rise of the sum of squares at the ends of each coordinate."""
        return self.threshold * self.widen

    @property
    def widest(self) -> float:
        """Largest factor on a variance."""
        return float(self.widen.max(initial=1.0))

    @property
    def is_at_stake(self) -> bool:
        """Whether so much may hide that all numbers are but apparent."""
        return self.stake is not None and self.stake > MISFIT.outside

    def _weigh(self) -> None:
        """Covariance, what widens it, and what may hide behind a misfit.

        What the law lacks has a part that no value of a coordinate makes, which is what is left
        beside noise, and one that looks like a change of the coordinate, of which nothing is seen.
        Taken to be as large as the first, it moves the coordinate by as many standard errors as the
        root of the sum of squares beside noise; by none where that is no more than the noise.
        """
        from scipy.special import chdtrc

        best, threshold = self.best, self.threshold
        freedom = best.problem.freedom
        self.covariance = covariance_of(best.information)
        by_noise = self._noise_shares()
        chance = chdtrc(freedom, best.cost)
        hidden_shift = 0.0 if chance > _SIGNIFICANT else math.sqrt(best.cost - freedom)
        excess = max(best.reduced if chance < _SIGNIFICANT else 1.0, 1.0)
        widen = np.maximum(cycle_ratio(best), 1.0 + (excess - 1.0) * by_noise)
        errors = np.sqrt(np.diag(self.covariance) * by_noise)
        widths, shifts = errors * np.sqrt(threshold * widen), hidden_shift * errors
        # Of numbers that are told at all.
        told_shares = [
            abs(log_change(coordinate, q, shift))
            for coordinate, q, width, shift in zip(
                *(best.problem.free_coordinates, best.q.tolist()),
                *(widths.tolist(), shifts.tolist()),
                strict=True,
            )
            if abs(log_change(coordinate, q, width)) < _TOLD_WIDTH
        ]
        self.stake = max(told_shares, default=None)
        if not self.is_at_stake:
            widen = (np.sqrt(widen) + hidden_shift * np.sqrt(by_noise / threshold)) ** 2
        self.widen = widen

    def _noise_shares(self) -> Floats:
        """Share of the variance of each coordinate that is not of the sensors' gains."""
        problem, q = self.best.problem, self.best.q
        if not problem.gains:
            return np.ones(q.size)
        certain = problem.copy()
        certain.gains = {}
        certain.update(q)
        known = Fit(certain, q).information
        for row, coordinate in enumerate(problem.free_coordinates):
            if coordinate.parameter == GAIN:
                known[row, row] *= _CERTAIN
        return np.minimum(np.diag(covariance_of(known)) / np.diag(self.covariance), 1.0)

    # -- profiles about one minimum -------------------------------------------------------------

    def _walked(self, kind: str, report: Progress) -> list[int]:
        """Find all intervals; which of them are those of the curvature, as time was up."""
        problem, size = self.best.problem, self.best.q.size
        self.intervals = [
            curvature(self.best, i, float(self.rises[i]), self.covariance) for i in range(size)
        ]
        if kind == "curvature":
            return list(range(size))
        # The rig competes with all other parameters: it comes first.
        is_rig = [coordinate.parameter == RIG for coordinate in problem.free_coordinates]
        order = sorted(range(size), key=lambda i: not is_rig[i])
        for finished, i in enumerate(order):
            if problem.evaluations > self._evaluation_limit:
                return sorted(order[finished:])
            walk = self._walk(i)
            self.intervals[i] = walk.profile()
            self._note_lower(walk)
            report((finished + 1) / size)
            if self._better is not None:
                return []
        if size <= _MOST_CROSSED:
            self._cross()
        return []

    def _walk(self, i: int) -> Walk:
        rise, conditional = float(self.rises[i]), self._conditional[i]
        return Walk(self.best, i, rise, self.covariance, conditional, self._is_last)

    def _note_lower(self, walk: Walk) -> None:
        """A lower minimum on the way counts, and all begins again, unless it is the last time."""
        if walk.lowest is not None and self._is_last:
            self.lower_still = True
        elif walk.lowest is not None:
            self._better = walk.lowest

    def _cross(self) -> None:
        """Ends of what is open on one side only, as ways of the others."""
        for j, interval in enumerate(self.intervals):
            places = [end.place for end in interval[:2] if not end.is_open]
            if len(places) != 1:
                continue
            for i in self._conditional[j]:
                is_late = self.best.problem.evaluations > self._evaluation_limit
                if self._better is not None or is_late:
                    return
                walk = self._walk(int(i))
                self.intervals[i] = walk.further(self.intervals[i], places)
                self._note_lower(walk)

    # -- ends that only the search sets ---------------------------------------------------------

    def _beyond_searches(self) -> None:
        """Ends that only the search sets, and all coordinates with that end as far out again."""
        problem, best = self.best.problem, self.best
        searched = {parameter.name for parameter in problem.model.parameters if parameter.beyond}
        low, high = problem.bounds
        for row, coordinate in enumerate(problem.free_coordinates):
            interval = self.intervals[row]
            reach = min(float(high[row] - low[row]), _FURTHEST)
            if coordinate.parameter not in searched or not interval.width > 0.0:
                continue
            near = _NEAR * min(reach, 1.0)
            for upward, end in ((False, interval.low), (True, interval.high)):
                if not end.is_open:
                    continue
                bound = float((high if upward else low)[row])
                rests, move = abs(bound - float(best.q[row])) <= near, reach if upward else -reach
                if rests:
                    there = self._fit_beyond(best.q, row, move)
                else:
                    there = self._profile_beyond(end.place, row, move)
                ratio = 1.0
                if there is None:  # back on the way, as the curvature tells it
                    variance = max(float(self.covariance[row, row]), 1e-300)
                    along = self.covariance[:, row] / variance
                    there, ratio = best.q - _BACK * move * along, -1.0 / _BACK
                self.open_ends.append(OpenEnd(row, coordinate.name, upward, rests, there, ratio))

    def _profile_beyond(self, place: Floats, row: int, move: float) -> Floats | None:
        """The others where a coordinate is beyond the end of its search; None without an answer."""
        there = self._fit_beyond(place, row, move, is_held=True)
        if there is None:
            return None
        residuals = (self.best.problem.residuals(q)[0] for q in (place, there))
        near, far = (float(np.dot(r, r)) - self.best.cost for r in residuals)
        rise = float(self.rises[row])
        if far <= rise:
            return there
        goal, first, last = (math.sqrt(max(x, 0.0)) for x in (rise, near, far))
        part = min(max((goal - first) / max(last - first, 1e-300), 0.0), 1.0)
        return self._fit_beyond(place, row, part * move, is_held=True)

    def _fit_beyond(
        self, start: Floats, row: int, move: float, is_held: bool = False
    ) -> Floats | None:
        """Fit with one bound moved; None where the law has no answer there."""
        problem, best = self.best.problem, self.best
        j = int(problem.free[row])
        outer, (low, high) = problem.coordinates[j].outer, problem.coordinates[j].limits
        ends = sorted((outer(low + min(move, 0.0)), outer(high + max(move, 0.0))))
        moved = problem.with_coordinates({j: {"low": ends[0], "high": ends[1]}})
        q, moving = start.copy(), np.arange(start.size)
        if is_held:
            q[row] += move
            moving = np.delete(moving, row)
        fit = Fit(moved, q).settled_near(moving)
        problem.evaluations = moved.evaluations
        is_good = (
            fit is not None and np.isfinite(fit.q).all() and (is_held or fit.cost <= best.cost)
        )
        return fit.q if is_good and fit is not None else None

    def _lean(self) -> None:
        """Open the ends at which the end of another search ends an interval, not the data."""
        problem, best, intervals = self.best.problem, self.best, list(self.intervals)
        free, (low_bound, high_bound) = problem.free_coordinates, problem.bounds
        for end in self.open_ends:
            j = end.row
            bound = float((high_bound if end.upward else low_bound)[j])
            near = _NEAR * min(float(high_bound[j] - low_bound[j]), 1.0)
            ways = end.ahead(best.q)
            for i, interval in enumerate(intervals):
                if i == j:
                    continue
                ahead = log_change(free[i], float(best.q[i]), float(ways[i]))
                moves = abs(ahead) >= MOVED
                unit = 1.0 if end.rests else min(intervals[j].width, 1.0)
                if not moves and _width(free[i], interval) / unit < MOVED:
                    continue
                low, high = (abs(side.place[j] - bound) <= near for side in interval[:2])
                if end.rests and moves:
                    # All values stand there; moved, that end takes the number one way alone.
                    low, high = ahead < 0.0, ahead > 0.0
                # What follows from an end that opens is open there, too.
                opened = self.intervals[i]
                if low:
                    opened = opened._replace(low=opened.low.opened(i))
                if high:
                    opened = opened._replace(high=opened.high.opened(i))
                self.intervals[i] = opened

    # -- quantities that follow -----------------------------------------------------------------

    def derived(self, function: Function, shape: bool = False) -> Interval:
        """Ends of a quantity that follows from the coordinates, and whether they are open.

        Along the direction in which the quantity moves most for a rise of the sum of squares,
        within the intervals of the coordinates, where the quantity is taken as it is and not as a
        straight line; and wherever an interval that is open has led. An end is open where a
        coordinate that the quantity feels stands at an open end of its own, and where the end of a
        search, taken further, takes the quantity along. Of a ``shape``, a plain number, differences
        count.
        """
        best = self.best
        value, gradient = function(best.q)
        sides = [i.low for i in self.intervals], [i.high for i in self.intervals]
        low, high = (np.array([end.value for end in side]) for side in sides)
        low_open, high_open = (np.array([end.is_open for end in side]) for side in sides)
        near = _AT_END * np.minimum(high - low, 1.0)
        along = self.covariance @ gradient
        variance = float(gradient @ along)
        places = [best.q]
        if variance > 0.0:
            move = math.sqrt(self.threshold * self.widest / variance) * along
            places += [np.clip(best.q + way * move, low, high) for way in (-1.0, 1.0)]
        if low_open.any() or high_open.any():
            places += [end.place for interval in self.intervals for end in interval[:2]]
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
        bounds = best.problem.bounds
        opened = (low_open & (low <= bounds[0] + near)) | (high_open & (high >= bounds[1] - near))
        opened[[open_end.row for open_end in self.open_ends]] = False
        width = min(1.0, float((high - low)[opened].min(initial=1.0)))
        size = 1.0 if shape else abs(value) or 1.0
        moves = [open_end.shift(function, best.q) / size for open_end in self.open_ends]
        if shape:
            narrow = last - first < MOVED * width
        else:
            narrow = first * last > 0.0 and abs(math.log(last / first)) < MOVED * width
        if narrow and all(abs(open_end) < MOVED for open_end in moves):
            # What an open coordinate hardly moves is told all the same.
            first_open = last_open = False
        far = [move for open_end, move in zip(self.open_ends, moves, strict=True) if open_end.rests]
        first_open = first_open or any(open_end <= -MOVED for open_end in far)
        last_open = last_open or any(open_end >= MOVED for open_end in far)
        # An end that is the best value itself and open says that the best value lies at a bound.
        return Interval(End(first, first_open, best.q), End(last, last_open, best.q))


def log_change(coordinate: Coordinate, q: float, moved: float) -> float:
    """Change of a coordinate as that of the logarithm of its value; of a plain number itself."""
    if coordinate.kind == "log" or coordinate.shape:
        return moved
    return moved / max(abs(q), 1e-300)


def _width(coordinate: Coordinate, interval: Interval) -> float:
    """Width of an interval, of positive values in the logarithm."""
    if coordinate.kind == "log":
        return interval.width
    return math.log(max(interval.high.value, 1e-300) / max(interval.low.value, 1e-300))
