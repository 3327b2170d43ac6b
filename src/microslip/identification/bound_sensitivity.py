"""Numbers that lean on how far another one is searched, and not on the records."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import significant
from microslip.errors import UNSAID, in_python
from microslip.identification.coordinates import Coordinate
from microslip.identification.fit import Fit, bounds_of, settle
from microslip.identification.problem import Problem
from microslip.identification.profiles import Interval, OpenEnd
from microslip.identification.quantities import Quantity
from microslip.identification.verdicts import IDENTIFIED, IN_DOUBT, Fitted

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
    """Where the fit goes with one bound moved; None where the law has no answer out there."""
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
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            fit = settle(moved, q, moving)
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None
    problem.evaluations = moved.evaluations
    good = fit.finite and np.isfinite(fit.q).all() and (is_held or fit.cost <= best.cost)
    return fit.q if good else None


def log_change(coordinate: Coordinate, q: float, moved: float) -> float:
    """Change of a coordinate as that of the logarithm of its value; of a plain number itself."""
    if coordinate.kind == "log" or coordinate.shape:
        return moved
    return moved / max(abs(q), 1e-300)


def with_doubts(
    problem: Problem,
    best: Fit,
    ends: Sequence[OpenEnd],
    quantities: Sequence[Quantity],
    parameters: Mapping[str, Fitted],
    derived: Mapping[str, Fitted],
) -> tuple[dict[str, Fitted], dict[str, Fitted]]:
    """The numbers; "in doubt" those which an end of a search, where the fit rests, would move."""
    judged_parameters, judged_quantities = dict(parameters), dict(derived)
    rank = {problem.coordinates[int(j)].name: i for i, j in enumerate(problem.free)}
    for end in (end for end in ends if end.rests):
        parameter = problem.coordinates[int(problem.free[end.row])].parameter
        remedy = (
            f"take other heights, or records that tell {parameter}; how far that is searched say "
            f"`bounds={in_python({parameter: UNSAID})}`"
        )
        at = judged_parameters[end.name]
        judged_parameters[end.name] = replace(at, remedy=f"take other heights; {at.remedy}")
        for name, number in parameters.items():
            if number.verdict != IDENTIFIED or name not in rank:
                continue
            i = rank[name]
            coordinate = problem.coordinates[int(problem.free[i])]
            moved = coordinate.outer(float((best.q + end.ahead(best.q))[i])) - number.value
            if abs(moved) > 0.5 * (number.high - number.low):
                why = _doubt_reason(end, moved, number, coordinate.shape)
                judged_parameters[name] = replace(
                    number, verdict=IN_DOUBT, reason=why, remedy=remedy
                )
        for quantity in quantities:
            number = derived[quantity.name]
            if number.verdict != IDENTIFIED:
                continue
            moved = end.shift(quantity.function, best.q)
            if abs(moved) > 0.5 * (number.high - number.low):
                shape = number.unit == "" and "separation" in number.name
                why = _doubt_reason(end, moved, number, shape)
                judged_quantities[number.name] = replace(number, verdict=IN_DOUBT, reason=why)
    return judged_parameters, judged_quantities


def _doubt_reason(end: OpenEnd, moved: float, number: Fitted, shape: bool) -> str:
    percent = 100.0 * abs(moved / abs(number.value)) if not shape else 0.0
    by = significant(abs(moved), 2) if shape else f"{significant(percent, 2)} %"
    return (
        f"it leans on the end of the search of {end.name}: with that end as far out again it would "
        f"be {by} {'higher' if moved > 0.0 else 'lower'}"
    )
