"""From a fit and its intervals to what is said of each number, and of the fit as a whole."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from microslip._core.frozen import lock
from microslip.errors import InputError
from microslip.identification import fit_quality, nuisances
from microslip.identification.caveats import (
    ABOVE,
    FIXED,
    IDENTIFIED,
    NOT,
    Caveat,
)
from microslip.identification.coordinates import (
    AREA,
    DENSITY,
    GAIN,
    RADIUS,
    RIG,
    SUMMIT_DATA,
    Coordinate,
)
from microslip.identification.fit import at_bounds
from microslip.identification.intervals import Profiled, is_at_stake
from microslip.identification.labels import number_text
from microslip.identification.load_levels import levels_of
from microslip.identification.prior_data import Contradicted, GivenDatum, compare_data
from microslip.identification.problem import Problem
from microslip.identification.profiles import derived_interval
from microslip.identification.quantities import Quantity, of_coordinate
from microslip.identification.result import (
    AT_BOUND,
    CONVERGED,
    DIFFER,
    NOT_CONVERGED,
    Identification,
)
from microslip.identification.rigs import rig_contradiction
from microslip.identification.rules import WRONG_FROM
from microslip.identification.verdicts import (
    Design,
    Direction,
    Fitted,
    design_of,
    direction_of,
    is_parallel,
    judge,
    mark,
)
from microslip.materials import MaterialPair

_LIMITS = ("friction_coefficient", "force_limit")
"""Numbers that only a contact in gross slip shows."""
_OF_NO_SUMMIT = (*_LIMITS, *SUMMIT_DATA, "summit_count")
"""Numbers that which summits touch says nothing of, and those that were measured apart."""
_REACHED = 0.95
"""Share of the limit that a record has to reach for it to be evidence."""
_FAR = 10.0
"""Ratio of loads from which on the one of a contact area is far from those of the records."""
_ROUNDING_SHARE = 1e-8
"""Part of what a rig does to loops below which it is rounding that no other parameter does it."""
_BY_AREA = (RADIUS, DENSITY, "summit_count")
"""Conclusions from a contact area."""

NO_MINIMUM = Caveat("no minimum")
Numbers = Mapping[str, Fitted]
Reservation = tuple[Caveat, Sequence[str] | None]
"""A caveat, and the names of the numbers that it reaches; None for all."""


@dataclass
class _Evidence:
    """A fit with its intervals, and what its caveats are made of."""

    problem: Problem
    answer: Profiled
    quantities: list[Quantity]
    level: float
    freedom: int
    loss: str
    data_names: Sequence[str]

    @cached_property
    def records(self) -> tuple[fit_quality.RecordFit, ...]:
        return fit_quality.record_fits(self.problem, self.answer.best.q)

    @cached_property
    def loads(self) -> list[float | None]:
        return [record.normal_load for record in self.problem.folded]

    @cached_property
    def design(self) -> Design:
        slips = [record.slip_share for record in self.records]
        model, levels = self.problem.model, len(set(levels_of(self.loads)))
        return design_of(slips, self.problem.coordinates, levels, model.scales_with_load)

    @cached_property
    def free(self) -> list[Coordinate]:
        return [self.problem.coordinates[int(j)] for j in self.problem.free]

    @cached_property
    def reduced(self) -> float:
        return self.answer.best.cost / self.freedom

    @cached_property
    def is_misfit(self) -> bool:
        stake = self.answer.stake
        return is_at_stake(stake) or (stake is None and self.reduced > WRONG_FROM)

    @cached_property
    def data(self) -> tuple[tuple[GivenDatum, ...], Contradicted | None]:
        best = self.answer.best
        return compare_data(self.problem, best, self.freedom, self.data_names, self.quantities)

    @cached_property
    def rigs(self) -> Caveat | None:
        return fit_quality.rigs_differ(self.problem, self.answer.best, self.freedom)


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
    before: Sequence[Caveat],
    data_names: Sequence[str] = (),
    loss: str = "linear",
) -> Identification:
    """All that is said of a fit; ``data_names`` are those of its data."""
    best = answer.best
    if not best.finite:
        raise InputError(
            f"the law {problem.model.name!r} has no finite answer near the first guess "
            f"({best.cause}); give another `start=...` or narrower `bounds=...`"
        )
    evidence = _Evidence(problem, answer, quantities, level, freedom, loss, data_names)
    parameters, directions = _parameters(evidence)
    derived = _derived(evidence, parameters)
    parameters, derived = _leaning(evidence, parameters, derived)
    everything = [*parameters, *derived]
    for caveat, names in _reservations(evidence, everything):
        parameters, derived = (mark(n, caveat, names) for n in (parameters, derived))
    for caveat in (caveat for caveat in before if caveat.row.verdict):
        hidden = [name for name in everything if name.partition(" ")[0] not in _OF_NO_SUMMIT]
        parameters, derived = (mark(n, caveat, hidden) for n in (parameters, derived))
    status, caveats = _status(evidence, parameters)
    if status == DIFFER:
        parameters, derived = (mark(n, Caveat("as one rig")) for n in (parameters, derived))
    lost = any(fitted.verdict == NOT for fitted in parameters.values())
    parameters.pop(GAIN, None)  # of the sensor, and among what was given
    is_shown = np.array([coordinate.parameter != GAIN for coordinate in evidence.free], dtype=bool)
    covariance = answer.covariance[np.ix_(is_shown, is_shown)]
    errors = np.sqrt(np.diag(covariance))
    # Each law makes its own covariance of the noise of the displacement: its determinant counts.
    delays = nuisances.delays_of(problem, answer)
    if not best.converged:
        delays = mark(delays, NO_MINIMUM)
    deviance, fitted_count = best.cost + problem.log_determinant, problem.free.size + problem.flat
    names = [coordinate.name for coordinate in evidence.free if coordinate.parameter != GAIN]
    return Identification(
        law=problem.model.name,
        status=status,
        evaluations=problem.evaluations,
        parameters=MappingProxyType(parameters),
        derived=MappingProxyType(derived),
        names=tuple(names),
        correlation=lock(covariance / np.outer(errors, errors)),
        directions=tuple(directions),
        confidence=level,
        chi_squared=best.cost,
        degrees_of_freedom=freedom,
        widened=MappingProxyType(
            {
                name: math.sqrt(float(w))
                for name, w in zip(names, answer.widen[is_shown], strict=True)
            }
        ),
        records=evidence.records,
        aic=deviance + 2.0 * fitted_count,
        bic=deviance + fitted_count * math.log(count),
        held_back=predicted,
        columns=tuple(
            MappingProxyType(
                {
                    name: problem.coordinates[j].name
                    for name, j in zip(problem.model.names, column, strict=True)
                }
            )
            for column in problem.columns
        ),
        caveats=(*caveats, *before, *_remarks(evidence, lost)),
        _model=problem.model,
        _pair=pair,
        _area=area,
        given=evidence.data[0],
        stake=answer.stake,
        delays=MappingProxyType(delays),
    )


# -- the numbers ----------------------------------------------------------------------------------


def _fixed(source: Coordinate | Quantity, value: float) -> Fitted:
    return Fitted(*(source.name, source.unit, value, value, value, 0.0, FIXED), load=source.load)


def _parameters(evidence: _Evidence) -> tuple[dict[str, Fitted], list[Direction]]:
    problem, answer = evidence.problem, evidence.answer
    outer = problem.physical(answer.best.q)
    natural = {p.name for p in problem.model.parameters if p.natural}
    parameters: dict[str, Fitted] = {}
    directions: list[Direction] = []
    rows = {int(j): row for row, j in enumerate(problem.free)}
    for j, coordinate in enumerate(problem.coordinates):
        if coordinate.fixed:
            parameters[coordinate.name] = _fixed(coordinate, outer[j])
            continue
        row, value = rows[j], outer[j]
        interval, widened = answer.intervals[row], float(answer.widen[row])
        error = math.sqrt(float(answer.covariance[row, row]) * widened)
        error *= coordinate.slope(float(answer.best.q[row]))
        if coordinate.kind == "inverse":  # a product, for a square of it may be too large
            error = value * (value * error) if math.isfinite(value) else math.inf
        points = ((coordinate.outer(q), rise / widened) for q, rise in interval.points)
        profile = tuple(sorted(point for point in points if math.isfinite(point[0])))
        number = judge(coordinate, value, error, interval, evidence.level, evidence.design, profile)
        if number.verdict == ABOVE and number.at_bound and coordinate.parameter in natural:
            # A cell that is none leaves nothing to settle.
            assert number.caveat is not None
            number = replace(number, caveat=replace(number.caveat, remedies=()))
        elif number.verdict != IDENTIFIED and coordinate.parameter not in SUMMIT_DATA:
            remedies = () if number.caveat is None else number.caveat.remedies
            ends = interval.at_low, interval.at_high
            way = direction_of(coordinate, evidence.free, *ends, remedies)
            if way is not None and not any(is_parallel(way, other) for other in directions):
                directions.append(way)
        parameters[coordinate.name] = number
    return parameters, directions


def _derived(evidence: _Evidence, parameters: Numbers) -> dict[str, Fitted]:
    """Derived quantities with intervals: along the most sensitive direction, and by profiles."""
    answer = evidence.answer
    widest = float(answer.widen.max(initial=1.0))
    derived = {}
    for quantity in evidence.quantities:
        value, gradient = quantity.function(answer.best.q)
        if not gradient.any():
            derived[quantity.name] = _fixed(quantity, value)
            continue
        is_shape = value <= 0.0 or quantity.shape
        ends = derived_interval(
            *(evidence.problem, answer.best, quantity.function, answer.threshold * widest),
            *(answer.covariance, answer.intervals, answer.open_ends, is_shape),
        )
        coordinate = Coordinate(
            *(quantity.name, quantity.name, quantity.unit, -math.inf, math.inf, "linear", value),
            load=quantity.load,
            shape=is_shape,
        )
        variance = float(gradient @ answer.covariance @ gradient) * widest
        number = judge(coordinate, value, math.sqrt(max(variance, 0.0)), ends, evidence.level)
        parent = parameters.get(quantity.parent or "")
        if parent is not None and number.verdict != parent.verdict:  # the same at another load
            number = replace(number, verdict=parent.verdict, caveat=parent.caveat)
        if number.verdict == NOT and number.caveat is not None:
            parameter_remedies = (
                p.caveat.remedies for p in parameters.values() if p.caveat is not None
            )
            remedies = next(filter(None, parameter_remedies), ())
            number = replace(number, caveat=replace(number.caveat, remedies=remedies))
        derived[quantity.name] = number
    return derived


def _leaning(
    evidence: _Evidence, parameters: Numbers, derived: Numbers
) -> tuple[dict[str, Fitted], dict[str, Fitted]]:
    """The numbers; "in doubt" those which an end of a search, where the fit rests, would move."""
    first = {**parameters, **derived}
    numbers, best = dict(first), evidence.answer.best.q
    shapes = {c.name for c in evidence.free if c.shape} | {
        q.name for q in evidence.quantities if q.shape
    }
    for end in (end for end in evidence.answer.open_ends if end.rests):
        at = numbers[end.name]
        if at.caveat is not None:
            remedies = ("take other heights", *at.caveat.remedies)
            numbers[end.name] = replace(at, caveat=replace(at.caveat, remedies=remedies))
        there = best + end.ahead(best)
        moves = {
            coordinate.name: coordinate.outer(float(q)) - first[coordinate.name].value
            for coordinate, q in zip(evidence.free, there, strict=True)
        } | {
            quantity.name: end.shift(quantity.function, best)
            for quantity in evidence.quantities
            if first[quantity.name].verdict == IDENTIFIED
        }
        for name, moved in moves.items():
            number = first[name]
            if number.verdict == IDENTIFIED and abs(moved) > 0.5 * (number.high - number.low):
                data = {
                    "end": end.name,
                    "parameter": evidence.free[end.row].parameter,
                    "way": "higher" if moved > 0.0 else "lower",
                    "share": None if name in shapes else abs(moved / number.value),
                    "size": abs(moved) if name in shapes else None,
                }
                numbers |= mark({name: number}, Caveat("leans", data))
    return {name: numbers[name] for name in parameters}, {name: numbers[name] for name in derived}


# -- what they rest on ----------------------------------------------------------------------------


def _reservations(evidence: _Evidence, names: Sequence[str]) -> Iterator[Reservation]:
    """Reservations about the assumptions of a fit, and the numbers that depend on them."""
    records = evidence.problem.folded
    if not evidence.answer.best.converged:
        yield NO_MINIMUM, None
    if evidence.is_misfit:
        data = {
            "amplitudes": range_of([record.amplitude for record in records], "m"),
            "loads": range_of(evidence.loads, "N"),
            "stake": evidence.answer.stake,
        }
        yield Caveat("apparent", data), None
    reached = max(record.slip_share for record in evidence.records)
    if reached < _REACHED:
        limits = [name for name in names if name.partition(" ")[0] in _LIMITS]
        yield Caveat("beyond", {"reached": reached, "laws": None, "none": None}), limits
    for doubt in dict.fromkeys(record.doubt for record in records if record.doubt):
        yield Caveat("doubted record", {"doubt": doubt}), None
    contradicted = evidence.data[1]
    if contradicted is not None:
        functions = {quantity.name: quantity.function for quantity in evidence.quantities}
        for j, coordinate in zip(evidence.problem.free, evidence.free, strict=True):
            functions[coordinate.name] = of_coordinate(evidence.problem, int(j))
        reached_names = [name for name, f in functions.items() if contradicted.reaches(f)]
        yield Caveat("contradicted", {"names": contradicted.names}), reached_names
    far = _far_area(evidence)
    if far is not None:
        yield far, _BY_AREA
    yield from _same_laws(evidence)


def _same_laws(evidence: _Evidence) -> Iterator[Reservation]:
    """Rigs that change loops just as parameters of the law do, whatever the noise."""
    _, by = evidence.problem.residuals(evidence.answer.best.q)
    for row, coordinate in enumerate(evidence.free):
        own_column, other_columns = by[:, row], np.delete(by, row, axis=1)
        if coordinate.parameter != RIG or not own_column.any() or not other_columns.size:
            continue
        size = np.linalg.norm(other_columns, axis=0)
        shares = np.linalg.lstsq(
            other_columns / np.where(size > 0.0, size, 1.0), own_column, rcond=1e-12
        )[0]
        left = own_column - other_columns @ (shares / np.where(size > 0.0, size, 1.0))
        if np.linalg.norm(left) < _ROUNDING_SHARE * np.linalg.norm(own_column):
            alike = np.insert(
                np.abs(shares) > _ROUNDING_SHARE * np.linalg.norm(own_column), row, True
            )
            names = [c.name for c, is_alike in zip(evidence.free, alike, strict=True) if is_alike]
            yield Caveat("same law", {}, evidence.design.remedies(coordinate, NOT)), names


def _far_area(evidence: _Evidence) -> Caveat | None:
    """The caveat of a contact area measured at a load far from all records."""
    measured = next((c.load for c in evidence.problem.coordinates if c.parameter == AREA), None)
    loads = [load for load in evidence.loads if load]
    if measured is None or not loads:
        return None
    if min(loads) / _FAR <= measured <= _FAR * max(loads):
        return None
    return Caveat("far area", {"load": measured, "loads": range_of(loads, "N")})


def range_of(values: Sequence[float | None], unit: str) -> str | None:
    """The lowest to the highest value, one of them where they read alike; None without any."""
    known = [value for value in values if value]
    ends = (min(known), max(known)) if known else ()
    return " to ".join(dict.fromkeys(number_text(end, unit) for end in ends)) or None


# -- the fit as a whole ---------------------------------------------------------------------------


def _status(evidence: _Evidence, parameters: Numbers) -> tuple[str, list[Caveat]]:
    """Status of the fit, and its message."""
    best, rigs = evidence.answer.best, None
    if not best.converged:
        status, message_caveats = NOT_CONVERGED, [Caveat(best.cause, {"why": best.why})]
    elif (rigs := evidence.rigs) is not None and rigs.kind == "one rig":
        status, message_caveats = DIFFER, [rigs]
    else:
        at = [evidence.free[i].name for i in at_bounds(evidence.problem, best.q)]
        status, message_caveats = (
            (AT_BOUND, [_at_bounds(at, parameters)]) if at else (CONVERGED, [])
        )
        message_caveats += [] if rigs is None else [rigs]
    if evidence.is_misfit:
        message_caveats.append(fit_quality.misfit(evidence.records, evidence.reduced))
    if (contradicted := evidence.data[1]) is not None:
        message_caveats.append(contradicted.caveat)
    return status, message_caveats


def _at_bounds(at: Sequence[str], parameters: Numbers) -> Caveat:
    places = [
        Caveat("a bound", {"name": name, "value": number.value, "unit": number.unit})
        for name, number in parameters.items()
        if name in at
    ]
    identified = [name for name, number in parameters.items() if number.verdict == IDENTIFIED]
    data = {"places": places[:3], "more": len(places) - 3 if len(places) > 3 else None}
    return Caveat(
        "at a bound", data | {"names": identified or None, "none": None if identified else ""}
    )


def _remarks(evidence: _Evidence, lost: bool) -> Iterator[Caveat]:
    """Further remarks on the fit; ``lost`` is whether a parameter is not identified."""
    problem, answer, design = evidence.problem, evidence.answer, evidence.design
    yield from nuisances.noise_remarks(problem, answer.best, evidence.freedom, evidence.loss)
    yield from (causes := list(nuisances.causes(problem, answer.best, evidence.freedom)))
    if answer.best.cost > WRONG_FROM * evidence.freedom:
        loops = [record.loop for record in problem.folded]
        soft = rig_contradiction(problem.coordinates, problem.rigs, loops)
        yield from () if soft is None else (soft,)
    far = _far_area(evidence)
    yield from () if far is None else (far,)
    times = math.sqrt(float(answer.widen.max(initial=1.0)))
    if times > 1.0:
        by_law = evidence.reduced >= 0.999 * times**2
        reduced, cycles = (evidence.reduced, None) if by_law else (None, "")
        yield Caveat("widened", {"times": times, "reduced": reduced, "cycles": cycles})
    if design.scales_with_load and design.rig_is_free and lost:
        yield Caveat("in series")
    if design.scales_with_load and design.loads < 2:
        yield Caveat("one load")
    # A delay that was given, fitted, or found by the fit needs no further word.
    is_late_told = problem.free_delay or any(problem.lags)
    is_late_told = is_late_told or any(cause.kind == "delay explains" for cause in causes)
    for record in problem.folded:
        # What a record says of its own folding; that all cycles are there needs no word.
        late = (record.late,) if record.late and not is_late_told else ()
        yield from (
            Caveat("of the record", {"record": record.name, "note": n})
            for n in (*record.said, *late)
        )
    if answer.lower_still:
        yield Caveat("many minima")
    if names := [evidence.free[i].name for i in answer.linear]:
        is_whole = len(names) == len(evidence.free)
        data: dict[str, Any] = {
            "every": "" if is_whole else None,
            "names": None if is_whole else names,
        }
        yield Caveat("straight", data)
