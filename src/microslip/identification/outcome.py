"""Floor 6: from a fit and its profiles to what is said of each number."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from microslip._checks import Floats
from microslip._frozen import lock
from microslip.errors import InputError
from microslip.identification import checks, setup
from microslip.identification.coordinates import APART, Coordinate
from microslip.identification.fit import Fit, at_bounds
from microslip.identification.intervals import Profiled
from microslip.identification.problem import Problem
from microslip.identification.profiles import derived_interval
from microslip.identification.quantities import Quantity
from microslip.identification.result import (
    AT_BOUND,
    CONVERGED,
    DIFFER,
    NOT_CONVERGED,
    Identification,
)
from microslip.identification.verdicts import (
    FIXED,
    IDENTIFIED,
    IN_DOUBT,
    NOT,
    Design,
    Direction,
    Fitted,
    alike,
    design_of,
    direction_of,
    judge,
    reason_for,
    remedy_for,
    shown,
)
from microslip.materials import MaterialPair


def result_of(
    problem: Problem,
    answer: Profiled,
    quantities: list[Quantity],
    level: float,
    freedom: int,
    count: int,
    predicted: float | None,
    pair: MaterialPair | None,
    area: float | None,
    notes: list[str],
) -> Identification:
    """All that is said of a fit."""
    best, coordinates = answer.best, problem.coordinates
    if not best.finite:
        raise InputError(
            f"the law {problem.model.name!r} has no finite answer near the first guess "
            f"({best.message}); give start=... or narrower bounds=..."
        )
    records = checks.record_fits(problem, best.q)
    loads = [one.normal_load for one in problem.folded]
    design = design_of(
        problem.folded,
        [one.slip_share for one in records],
        coordinates,
        len(set(setup.levels_of(loads))),
        problem.model.scales_with_load,
    )
    parameters, directions = _parameters(problem, answer, design, level)
    derived = _derived(problem, answer, quantities, parameters, level)
    errors = np.sqrt(np.diag(answer.covariance))
    correlation = answer.covariance / np.outer(errors, errors)
    free = [coordinates[int(j)].name for j in problem.free]
    unfit = checks.misfit(records, best.cost / freedom)
    if unfit is not None and unfit.doubtful:
        why = "found under a law that does not answer the records"
        parameters, derived = _doubted(parameters, why), _doubted(derived, why)
        remedy = "free or correct what is fixed, or take another law"
        parameters = {
            name: replace(one, remedy=remedy) if one.verdict == IN_DOUBT else one
            for name, one in parameters.items()
        }
    status, message = _status(problem, best, freedom, parameters)
    if status == DIFFER:
        remedy = "name the rig of each record: rigs=[one label a record]"
        why = "found as if all records had one rig, which they have not"
        parameters, derived = _doubted(parameters, why), _doubted(derived, why)
        parameters = {
            name: replace(one, remedy=remedy) if one.verdict == IN_DOUBT else one
            for name, one in parameters.items()
        }
    if unfit is not None:
        message = f"{message}; {unfit.text}"
    deviance = best.cost + problem.log_determinant
    aic, bic = checks.information_criteria(deviance, count, problem.free.size + problem.flat)
    lost = any(one.verdict == NOT for one in parameters.values())
    notes = [*notes, *_notes(best.cost / freedom, answer.widen, design, loads, lost)]
    if unfit is not None:
        notes.append(unfit.text)
    # What a record says of its own folding; that all cycles are there needs no word.
    notes += [f"{one.name}: {note}" for one in problem.folded for note in one.said]
    if answer.lower_still:
        notes.append(
            "the sum of squares has many minima, and the profiles met lower ones than that of the "
            "best values: this law does not suit these records"
        )
    if linear := [free[i] for i in answer.linear]:
        whose = "all intervals" if len(linear) == len(free) else f"intervals of {', '.join(linear)}"
        notes.append(
            f"{whose} are those of the curvature at the best value, as if the law were linear"
        )
    return Identification(
        law=problem.model.name,
        status=status,
        message=message,
        evaluations=problem.evaluations,
        parameters=MappingProxyType(parameters),
        derived=MappingProxyType(derived),
        names=tuple(free),
        correlation=lock(correlation),
        directions=tuple(directions),
        confidence=level,
        chi_squared=best.cost,
        degrees_of_freedom=freedom,
        widened=MappingProxyType(
            {name: math.sqrt(float(w)) for name, w in zip(free, answer.widen, strict=True)}
        ),
        records=records,
        aic=aic,
        bic=bic,
        held_back=predicted,
        columns=tuple(
            MappingProxyType(
                {n: coordinates[j].name for n, j in zip(problem.model.names, column, strict=True)}
            )
            for column in problem.columns
        ),
        notes=tuple(notes),
        _model=problem.model,
        _pair=pair,
        _area=area,
    )


def _status(
    problem: Problem, best: Fit, freedom: int, parameters: Mapping[str, Fitted]
) -> tuple[str, str]:
    if not best.converged:
        return NOT_CONVERGED, f"the fit did not end at a minimum: {_why(best.message)}"
    told = checks.rigs_differ(problem, best, best.cost / freedom)
    if told is not None:
        return DIFFER, f"{told}: rigs=[one label a record]"
    at = [problem.coordinates[int(problem.free[i])].name for i in at_bounds(problem, best.q)]
    if at:
        of = " and ".join(
            f"the best value of {name} lies at a bound of the search, "
            f"{shown(parameters[name].value, parameters[name].unit)}"
            for name in at[:3]
        )
        of += f" (and {len(at) - 3} more)" if len(at) > 3 else ""
        known = [name for name, one in parameters.items() if one.verdict == IDENTIFIED]
        rest = f"identified all the same: {', '.join(known)}" if known else "nothing is identified"
        return AT_BOUND, f"{of}; {rest}"
    return CONVERGED, "the fit ended at a minimum within the bounds"


def _why(message: str) -> str:
    """What a minimiser says, in words for those who do not know it."""
    if "termination condition" in message:
        return "its last steps change hardly anything, and yet it comes to rest nowhere"
    if "maximum number of function evaluations" in message:
        return "its evaluations were used up while the sum of squares still fell"
    return message


def _doubted(numbers: Mapping[str, Fitted], why: str) -> dict[str, Fitted]:
    """The same numbers, none identified: what they were found under does not hold."""
    return {
        name: replace(one, verdict=IN_DOUBT, reason=why) if one.verdict == IDENTIFIED else one
        for name, one in numbers.items()
    }


def _parameters(
    problem: Problem, answer: Profiled, design: Design, level: float
) -> tuple[dict[str, Fitted], list[Direction]]:
    free = [problem.coordinates[int(j)] for j in problem.free]
    outer = problem.physical(answer.best.q)
    rank = {int(j): r for r, j in enumerate(problem.free)}
    found: dict[str, Fitted] = {}
    directions: list[Direction] = []
    for j, one in enumerate(problem.coordinates):
        value = outer[j]
        if one.fixed:
            found[one.name] = Fitted(
                one.name, one.unit, value, value, value, 0.0, FIXED, "", "", False, one.load
            )
            continue
        row = rank[j]
        interval = answer.intervals[row]
        judged = judge(one, value, interval)
        verdict = judged.verdict
        remedy = remedy_for(one, verdict, design)
        points = [(one.outer(q), rise / float(answer.widen[row])) for q, rise in interval.points]
        found[one.name] = Fitted(
            one.name,
            one.unit,
            value,
            judged.low,
            judged.high,
            _standard_error(one, value, float(answer.best.q[row]), answer, row),
            verdict,
            reason_for(one, judged, level),
            remedy,
            judged.at_bound,
            one.load,
            judged.low_open,
            judged.high_open,
            tuple(sorted(point for point in points if math.isfinite(point[0]))),
        )
        if verdict not in (IDENTIFIED, FIXED) and one.parameter not in APART:
            way = direction_of(one, free, interval.at_low, interval.at_high, remedy)
            if way is not None and not any(alike(way, other) for other in directions):
                directions.append(way)
    return found, directions


def _standard_error(one: Coordinate, value: float, q: float, answer: Profiled, row: int) -> float:
    error = math.sqrt(float(answer.covariance[row, row] * answer.widen[row]))
    if one.kind == "inverse":
        return value**2 * one.slope(q) * error if math.isfinite(value) else math.inf
    return one.slope(q) * error


def _derived(
    problem: Problem,
    answer: Profiled,
    quantities: list[Quantity],
    parameters: Mapping[str, Fitted],
    level: float,
) -> dict[str, Fitted]:
    """What follows: along the way that moves it most, and wherever the profiles have been."""
    widest = float(answer.widen.max(initial=1.0))
    threshold = answer.threshold * widest
    found = {}
    for one in quantities:
        value, gradient = one.function(answer.best.q)
        if not gradient.any():
            found[one.name] = Fitted(
                one.name, one.unit, value, value, value, 0.0, FIXED, "", "", False, one.load
            )
            continue
        ends = derived_interval(
            problem, answer.best, one.function, threshold, answer.covariance, answer.intervals
        )
        shape = Coordinate(
            one.name,
            one.name,
            one.unit,
            -math.inf,
            math.inf,
            "linear",
            value,
            shape=value <= 0.0 or (one.unit == "" and "separation" in one.name),
        )
        judged = judge(shape, value, ends)
        variance = float(gradient @ answer.covariance @ gradient) * widest
        remedy = ""
        if judged.verdict == NOT:
            remedy = next((p.remedy for p in parameters.values() if p.remedy), "")
        found[one.name] = Fitted(
            one.name,
            one.unit,
            value,
            judged.low,
            judged.high,
            math.sqrt(max(variance, 0.0)),
            judged.verdict,
            reason_for(shape, judged, level),
            remedy,
            False,
            one.load,
            judged.low_open,
            judged.high_open,
        )
    return found


def _notes(
    reduced: float, widen: Floats, design: Design, loads: Sequence[float | None], lost: bool
) -> list[str]:
    notes = []
    largest = math.sqrt(float(widen.max(initial=1.0)))
    if largest > 1.0:
        why = (
            f"the law leaves more than the noise (reduced chi-squared {reduced:.3g})"
            if reduced >= 0.999 * largest**2
            else "whole cycles scatter more than white noise does"
        )
        notes.append(f"intervals are up to {largest:.3g} times as wide as noise makes them: {why}")
    if design.scales_with_load and design.rig_is_free and lost:
        notes.append(
            "after a reversal rig and contact give way together: a softer contact on a stiffer rig "
            "answers nearly as well, which is why the loops do not tell the contact's own part"
        )
    if design.scales_with_load and design.loads < 2 and len(loads) > 0:
        notes.append(
            "all records have one normal load: the friction coefficient, the length κσ and, "
            "weakly, the separation h are all that loops at one load hold"
        )
    return notes
