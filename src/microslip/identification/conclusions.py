"""From a fit and its profiles to what is said of each number."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip.errors import InputError
from microslip.identification import fit_quality
from microslip.identification.bound_sensitivity import with_doubts
from microslip.identification.coordinates import SUMMIT_DATA, Coordinate
from microslip.identification.fit import Fit, at_bounds
from microslip.identification.intervals import Profiled, is_at_stake
from microslip.identification.load_levels import levels_of
from microslip.identification.nuisances import delays_of
from microslip.identification.prior_data import compare_data
from microslip.identification.problem import Problem
from microslip.identification.profiles import derived_interval
from microslip.identification.quantities import Quantity, of_coordinate
from microslip.identification.reservations import (
    BY_AREA,
    REACHED,
    far_area,
    mark,
    mark_apparent,
    mark_extrapolated,
    with_remedy,
)
from microslip.identification.result import (
    AT_BOUND,
    CONVERGED,
    DIFFER,
    NOT_CONVERGED,
    Identification,
)
from microslip.identification.rules import WRONG_FROM
from microslip.identification.verdicts import (
    ABOVE,
    FIXED,
    IDENTIFIED,
    IN_DOUBT,
    NOT,
    Design,
    Direction,
    Fitted,
    design_of,
    direction_of,
    fixed_number,
    is_parallel,
    judge,
    number_text,
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
    data_names: Iterable[str] | None = None,
) -> Identification:
    """All that is said of a fit; ``data_names`` are those of its data."""
    best, coordinates = answer.best, problem.coordinates
    if not best.finite:
        raise InputError(
            f"the law {problem.model.name!r} has no finite answer near the first guess "
            f"({best.message}); give another `start=...` or narrower `bounds=...`"
        )
    records = fit_quality.record_fits(problem, best.q)
    loads = [record.normal_load for record in problem.folded]
    slips, levels = [record.slip_share for record in records], len(set(levels_of(loads)))
    design = design_of(slips, coordinates, levels, problem.model.scales_with_load)
    parameters, directions = _parameters(problem, answer, design, level)
    derived = _derived(problem, answer, quantities, parameters, level)
    parameters, derived = with_doubts(
        problem, best, answer.open_ends, quantities, parameters, derived
    )
    errors = np.sqrt(np.diag(answer.covariance))
    correlation = answer.covariance / np.outer(errors, errors)
    free = [coordinates[int(j)].name for j in problem.free]
    unfit, stake = "", answer.stake
    if is_at_stake(stake) or (stake is None and best.cost > WRONG_FROM * freedom):
        unfit = fit_quality.misfit(records, best.cost / freedom)
        parameters, derived = (
            mark_apparent(numbers, problem.folded, stake) for numbers in (parameters, derived)
        )
    if max(slips) < REACHED:
        parameters, derived = (mark_extrapolated(n, max(slips)) for n in (parameters, derived))
    for reason in dict.fromkeys(record.doubt for record in problem.folded if record.doubt):
        parameters, derived = (mark(n, IN_DOUBT, reason) for n in (parameters, derived))
        parameters = with_remedy(parameters, "take settled cycles within the range of the sensors")
    data, contradicted = compare_data(problem, best, freedom, list(data_names or ()), quantities)
    if contradicted is not None:
        reason = f"what was given for {' and '.join(contradicted.names)} and the loops disagree"
        functions = {coordinates[int(j)].name: of_coordinate(problem, int(j)) for j in problem.free}
        names = {name for name, f in functions.items() if contradicted.reaches(f)}
        parameters = mark(parameters, IN_DOUBT, reason, names=names)
        remedy = "check what was given, or leave it out"
        parameters = with_remedy(parameters, remedy, names=names)
        names = {q.name for q in quantities if contradicted.reaches(q.function)}
        derived = mark(derived, IN_DOUBT, reason, names=names)
    far = far_area(coordinates, loads)
    if far is not None:
        notes = [*notes, far]
        parameters, derived = (mark(n, IN_DOUBT, far, names=BY_AREA) for n in (parameters, derived))
    status, message = _status(problem, best, freedom, parameters)
    if status == DIFFER:
        reason = "found as if all records had one rig, which the loops speak against"
        parameters, derived = (mark(n, IN_DOUBT, reason) for n in (parameters, derived))
        parameters = with_remedy(parameters, f"name the rig of each record: {_NAME_RIGS}")
    objections = [unfit] if unfit else []
    objections += [] if contradicted is None else [contradicted.text]
    for objection in objections:
        message = f"{message}; {objection}"
    # Each law makes its own covariance of the noise of the displacement: its determinant counts.
    deviance, fitted_count = best.cost + problem.log_determinant, problem.free.size + problem.flat
    lost = any(fitted.verdict == NOT for fitted in parameters.values())
    notes = [*notes, *_notes(best.cost / freedom, answer.widen, design, loads, lost)]
    notes += objections
    # What a record says of its own folding; that all cycles are there needs no word.
    notes += [f"{record.name}: {note}" for record in problem.folded for note in record.said]
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
        aic=deviance + 2.0 * fitted_count,
        bic=deviance + fitted_count * math.log(count),
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
        given=data,
        stake=stake,
        delays=MappingProxyType(delays_of(problem, answer)),
    )


_NAME_RIGS = "`rigs=...`"


def _status(
    problem: Problem, best: Fit, freedom: int, parameters: Mapping[str, Fitted]
) -> tuple[str, str]:
    if not best.converged:
        return (
            NOT_CONVERGED,
            f"the fit did not end at a minimum: {_minimiser_message(best.message)}",
        )
    difference = fit_quality.rigs_differ(problem, best, freedom)
    if difference is not None and difference.explain:
        return DIFFER, f"{difference.text}: {_NAME_RIGS}"
    rig_note = "" if difference is None else f"; {difference.text}: {_NAME_RIGS}"
    at = [problem.coordinates[int(problem.free[i])].name for i in at_bounds(problem, best.q)]
    if at:
        of = " and ".join(
            f"the best value of {name} lies at a bound of the search, "
            f"{number_text(parameters[name].value, parameters[name].unit)}"
            for name in at[:3]
        )
        of += f" (and {len(at) - 3} more)" if len(at) > 3 else ""
        identified_names = [
            name for name, fitted in parameters.items() if fitted.verdict == IDENTIFIED
        ]
        identified = (
            f"identified all the same: {', '.join(identified_names)}"
            if identified_names
            else "nothing is identified"
        )
        return AT_BOUND, f"{of}; {identified}{rig_note}"
    return CONVERGED, f"the fit ended at a minimum within the bounds{rig_note}"


def _minimiser_message(message: str) -> str:
    """What a minimiser says, in words for those who do not know it."""
    if "termination condition" in message:
        return "its last steps change hardly anything, and yet it comes to rest nowhere"
    if "maximum number of function evaluations" in message:
        return "its evaluations were used up while the sum of squares still fell"
    return message


def _parameters(
    problem: Problem, answer: Profiled, design: Design, level: float
) -> tuple[dict[str, Fitted], list[Direction]]:
    free = [problem.coordinates[int(j)] for j in problem.free]
    outer = problem.physical(answer.best.q)
    rank = {int(j): r for r, j in enumerate(problem.free)}
    natural = {p.name for p in problem.model.parameters if p.natural}
    parameters: dict[str, Fitted] = {}
    directions: list[Direction] = []
    for j, coordinate in enumerate(problem.coordinates):
        value = outer[j]
        if coordinate.fixed:
            parameters[coordinate.name] = fixed_number(coordinate, value)
            continue
        row = rank[j]
        interval = answer.intervals[row]
        judged = judge(coordinate, value, interval)
        verdict = judged.verdict
        remedy = remedy_for(coordinate, verdict, design)
        is_none = verdict == ABOVE and judged.at_bound and coordinate.parameter in natural
        if is_none:
            remedy = ""  # a cell that is none leaves nothing to settle
        points = [
            (coordinate.outer(q), rise / float(answer.widen[row])) for q, rise in interval.points
        ]
        error = _standard_error(coordinate, value, float(answer.best.q[row]), answer, row)
        reason = reason_for(coordinate, judged, level)
        profile = tuple(sorted(point for point in points if math.isfinite(point[0])))
        parameters[coordinate.name] = judged.number(
            coordinate, value, error, reason, remedy, profile
        )
        if (
            verdict not in (IDENTIFIED, FIXED)
            and coordinate.parameter not in SUMMIT_DATA
            and not is_none
        ):
            way = direction_of(coordinate, free, interval.at_low, interval.at_high, remedy)
            if way is not None and not any(is_parallel(way, direction) for direction in directions):
                directions.append(way)
    return parameters, directions


def _standard_error(
    coordinate: Coordinate, value: float, q: float, answer: Profiled, row: int
) -> float:
    error = math.sqrt(float(answer.covariance[row, row] * answer.widen[row]))
    if coordinate.kind == "inverse":
        return value**2 * coordinate.slope(q) * error if math.isfinite(value) else math.inf
    return coordinate.slope(q) * error


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
    derived = {}
    for quantity in quantities:
        value, gradient = quantity.function(answer.best.q)
        if not gradient.any():
            derived[quantity.name] = fixed_number(quantity, value)
            continue
        is_shape = value <= 0.0 or (quantity.unit == "" and "separation" in quantity.name)
        ends = derived_interval(
            problem,
            answer.best,
            quantity.function,
            threshold,
            answer.covariance,
            answer.intervals,
            answer.open_ends,
            is_shape,
        )
        name, unit = quantity.name, quantity.unit
        shape = Coordinate(name, name, unit, -math.inf, math.inf, "linear", value, shape=is_shape)
        judged = judge(shape, value, ends)
        reason = reason_for(shape, judged, level)
        if quantity.parent is not None and judged.verdict != parameters[quantity.parent].verdict:
            # The same number at another load.
            judged = judged._replace(verdict=parameters[quantity.parent].verdict)
            reason = parameters[quantity.parent].reason
        variance = float(gradient @ answer.covariance @ gradient) * widest
        remedy = ""
        if judged.verdict == NOT:
            remedy = next((p.remedy for p in parameters.values() if p.remedy), "")
        error = math.sqrt(max(variance, 0.0))
        derived[name] = judged.number(quantity, value, error, reason, remedy)
    return derived


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
