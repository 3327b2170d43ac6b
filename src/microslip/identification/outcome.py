"""Floor 6: from a fit and its profiles to what is said of each number."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from microslip._checks import Floats
from microslip._frozen import lock
from microslip.errors import InputError
from microslip.identification import checks, setup
from microslip.identification.coordinates import AREA, Coordinate
from microslip.identification.fit import Fit, at_bounds
from microslip.identification.intervals import Profiled
from microslip.identification.problem import Problem
from microslip.identification.profiles import Interval, derived_interval
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
    status, message = _status(problem, best, freedom)
    aic, bic = checks.information_criteria(best.cost, count, problem.free.size + problem.flat)
    notes = [*notes, *_notes(best.cost / freedom, answer.widen, freedom, design, loads)]
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


def _status(problem: Problem, best: Fit, freedom: int) -> tuple[str, str]:
    if not best.converged:
        return NOT_CONVERGED, f"the fit did not end at a minimum: {best.message}"
    told = checks.rigs_differ(problem, best, best.cost / freedom)
    if told is not None:
        return DIFFER, told
    at = [problem.coordinates[int(problem.free[i])].name for i in at_bounds(problem, best.q)]
    if at:
        return AT_BOUND, f"the best value lies at a bound: {', '.join(at)}"
    return CONVERGED, "the fit ended at a minimum within the bounds"


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
        verdict, low, high, at_bound = judge(one, value, interval)
        reason = reason_for(one, verdict, low, high, level)
        remedy = remedy_for(one, verdict, design)
        found[one.name] = Fitted(
            one.name,
            one.unit,
            value,
            low,
            high,
            _standard_error(one, value, float(answer.best.q[row]), answer, row),
            verdict,
            reason,
            remedy,
            at_bound,
            one.load,
        )
        if verdict not in (IDENTIFIED, FIXED) and one.parameter != AREA:
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
    from scipy.special import chdtri

    widest = float(answer.widen.max(initial=1.0))
    threshold = float(chdtri(1, 1.0 - level)) * widest
    open_ones = any(not one.identified for one in parameters.values())
    found = {}
    for one in quantities:
        value, gradient = one.function(answer.best.q)
        if not gradient.any():
            found[one.name] = Fitted(
                one.name, one.unit, value, value, value, 0.0, FIXED, "", "", False, one.load
            )
            continue
        value, low, high = derived_interval(
            problem, answer.best, one.function, threshold, answer.covariance
        )
        if open_ones:
            for interval in answer.intervals:
                for place in (interval.at_low, interval.at_high):
                    there = one.function(place)[0]
                    low, high = min(low, there), max(high, there)
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
        ends = Interval(low, high, False, False, answer.best.q, answer.best.q)
        verdict, low, high, _ = judge(shape, value, ends)
        variance = float(gradient @ answer.covariance @ gradient) * widest
        reason = reason_for(shape, verdict, low, high, level)
        remedy = ""
        if verdict == NOT:
            remedy = next((p.remedy for p in parameters.values() if p.remedy), "")
        found[one.name] = Fitted(
            one.name,
            one.unit,
            value,
            low,
            high,
            math.sqrt(max(variance, 0.0)),
            verdict,
            reason,
            remedy,
            False,
            one.load,
        )
    return found


def _notes(
    reduced: float, widen: Floats, freedom: int, design: Design, loads: Sequence[float | None]
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
    if design.scales_with_load and design.loads < 2 and len(loads) > 0:
        notes.append(
            "all records have one normal load: its share of force, the length kappa sigma and, "
            "weakly, the separation are all that loops at one load hold"
        )
    return notes
