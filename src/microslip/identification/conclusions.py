"""From a fit and its intervals to the verdict on each number and on the whole fit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip.identification import fit_quality, nuisances
from microslip.identification.caveats import (
    ABOVE,
    FIXED,
    IDENTIFIED,
    NOT,
    Caveat,
    number_text,
)
from microslip.identification.coordinates import (
    AREA,
    DENSITY,
    GAIN,
    RADIUS,
    RIG,
    SUMMIT_DATA,
    Coordinate,
    Quantity,
    levels_of,
)
from microslip.identification.intervals import Profiled
from microslip.identification.quantities import compare_data, of_coordinate
from microslip.identification.result import (
    AT_BOUND,
    CONVERGED,
    DIFFER,
    NOT_CONVERGED,
    Identification,
)
from microslip.identification.verdicts import (
    WRONG_FROM,
    Direction,
    Fitted,
    design_of,
    direction_of,
    is_parallel,
    judge,
    mark,
)

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


class Conclusions:
    """A fit with its intervals, and all that is said of it."""

    def __init__(self, answer: Profiled, loss: str) -> None:
        self._answer, self._best, self._loss = answer, answer.best, loss
        self._problem = problem = answer.best.problem
        if not self._best.finite:
            raise InputError(
                f"the law {problem.model.name!r} has no finite answer near the first guess "
                f"({self._best.cause}); give another `start=...` or narrower `bounds=...`"
            )
        self._free = problem.free_coordinates
        self._records = fit_quality.record_fits(self._best)
        slips = [record.slip_share for record in self._records]
        levels, scales = len(set(levels_of(problem.loads))), problem.model.scales_with_load
        self._design = design_of(slips, problem.coordinates, levels, scales)
        stake = answer.stake
        is_wrong = stake is None and self._best.reduced > WRONG_FROM
        self._is_misfit = answer.is_at_stake or is_wrong
        self._data, self._contradicted = compare_data(self._best)

    def result(self, before: Sequence[Caveat], held_back: float | None) -> Identification:
        """The result, with caveats that were there before the fit."""
        problem, answer, best = self._problem, self._answer, self._best
        parameters, directions = self._parameters()
        derived = self._derived(parameters)
        delays = nuisances.delays_of(answer)
        parameters, derived = self._leaning(parameters, derived)
        everything = [*parameters, *derived]
        hidden = [name for name in everything if name.partition(" ")[0] not in _OF_NO_SUMMIT]
        reservations = [
            *self._reservations(everything),
            *((caveat, hidden) for caveat in before if caveat.row.verdict),
        ]
        for caveat, names in reservations:
            parameters, derived = (mark(n, caveat, names) for n in (parameters, derived))
        status, caveats = self._status(parameters)
        if status == DIFFER:
            parameters, derived = (mark(n, Caveat("as one rig")) for n in (parameters, derived))
        if status == NOT_CONVERGED:
            delays = mark(delays, NO_MINIMUM)
        lost = any(fitted.verdict == NOT for fitted in parameters.values())
        parameters.pop(GAIN, None)  # of the sensor, and among what was given
        shown_rows = [row for row, c in enumerate(self._free) if c.parameter != GAIN]
        names = [self._free[row].name for row in shown_rows]
        covariance = answer.covariance[np.ix_(shown_rows, shown_rows)]
        errors = np.sqrt(np.diag(covariance))
        widened = np.sqrt(answer.widen[shown_rows]).tolist()
        # Each law makes its own covariance of the noise of the displacement: its determinant
        # counts.
        deviance, fitted_count = best.cost + problem.log_determinant, best.q.size + problem.flat
        columns = ([problem.coordinates[j].name for j in column] for column in problem.columns)
        return Identification(
            law=problem.model.name,
            status=status,
            evaluations=problem.evaluations,
            parameters=MappingProxyType(parameters),
            derived=MappingProxyType(derived),
            names=tuple(names),
            correlation=lock(covariance / np.outer(errors, errors)),
            directions=tuple(directions),
            confidence=answer.level,
            chi_squared=best.cost,
            degrees_of_freedom=problem.freedom,
            widened=MappingProxyType(dict(zip(names, widened, strict=True))),
            records=self._records,
            aic=deviance + 2.0 * fitted_count,
            bic=deviance + fitted_count * math.log(problem.count),
            held_back=held_back,
            columns=tuple(
                MappingProxyType(dict(zip(problem.model.names, full_names, strict=True)))
                for full_names in columns
            ),
            caveats=(*caveats, *before, *self._remarks(lost)),
            _model=problem.model,
            _materials=problem.materials,
            given=self._data,
            stake=answer.stake,
            delays=MappingProxyType(delays),
        )

    # -- the numbers ------------------------------------------------------------------------------

    def _parameters(self) -> tuple[dict[str, Fitted], list[Direction]]:
        problem, answer = self._problem, self._answer
        outer = problem.physical(self._best.q)
        natural = {p.name for p in problem.model.parameters if p.natural}
        parameters: dict[str, Fitted] = {}
        directions: list[Direction] = []
        for j, coordinate in enumerate(problem.coordinates):
            if coordinate.fixed:
                parameters[coordinate.name] = _fixed(coordinate, outer[j])
                continue
            row, value = problem.row[j], outer[j]
            interval, widened = answer.intervals[row], float(answer.widen[row])
            error = math.sqrt(float(answer.covariance[row, row]) * widened)
            error *= coordinate.slope(float(self._best.q[row]))
            if coordinate.kind == "inverse":  # a product, for a square of it may be too large
                error = value * (value * error) if math.isfinite(value) else math.inf
            points = ((coordinate.outer(q), rise / widened) for q, rise in interval.points)
            profile = tuple(sorted(point for point in points if math.isfinite(point[0])))
            number = judge(coordinate, value, error, interval, answer.level, self._design, profile)
            if number.verdict == ABOVE and number.at_bound and coordinate.parameter in natural:
                # A cell that is none leaves nothing to settle.
                assert number.caveat is not None
                number = replace(number, caveat=replace(number.caveat, remedies=()))
            elif number.verdict != IDENTIFIED and coordinate.parameter not in SUMMIT_DATA:
                remedies = () if number.caveat is None else number.caveat.remedies
                ends = interval.low.place, interval.high.place
                way = direction_of(coordinate, self._free, *ends, remedies)
                if way is not None and not any(is_parallel(way, other) for other in directions):
                    directions.append(way)
            parameters[coordinate.name] = number
        return parameters, directions

    def _derived(self, parameters: Numbers) -> dict[str, Fitted]:
        """Derived quantities with intervals: along the most sensitive way, and by profiles."""
        answer, q = self._answer, self._best.q
        derived = {}
        for quantity in self._problem.quantities:
            value, gradient = quantity.function(q)
            if not gradient.any():
                derived[quantity.name] = _fixed(quantity, value)
                continue
            is_shape = value <= 0.0 or quantity.shape
            ends = answer.derived(quantity.function, is_shape)
            coordinate = Coordinate(
                *(quantity.name, quantity.name, quantity.unit, -math.inf, math.inf, "linear"),
                *(value, False, None, 1.0, quantity.load, is_shape),
            )
            variance = float(gradient @ answer.covariance @ gradient) * answer.widest
            number = judge(coordinate, value, math.sqrt(max(variance, 0.0)), ends, answer.level)
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
        self, parameters: Numbers, derived: Numbers
    ) -> tuple[dict[str, Fitted], dict[str, Fitted]]:
        """The numbers; "in doubt" those which the end of a search, where it rests, would move."""
        first = {**parameters, **derived}
        numbers, best, free = dict(first), self._best.q, self._free
        quantities = self._problem.quantities
        shapes = {c.name for c in free if c.shape} | {q.name for q in quantities if q.shape}
        for end in (end for end in self._answer.open_ends if end.rests):
            at = numbers[end.name]
            if at.caveat is not None:
                remedies = ("take other heights", *at.caveat.remedies)
                numbers[end.name] = replace(at, caveat=replace(at.caveat, remedies=remedies))
            there = best + end.ahead(best)
            moves = {
                coordinate.name: coordinate.outer(float(q)) - first[coordinate.name].value
                for coordinate, q in zip(free, there, strict=True)
            } | {
                quantity.name: end.shift(quantity.function, best)
                for quantity in quantities
                if first[quantity.name].verdict == IDENTIFIED
            }
            for name, moved in moves.items():
                number = first[name]
                if number.verdict == IDENTIFIED and abs(moved) > 0.5 * (number.high - number.low):
                    data = {
                        "end": end.name,
                        "parameter": free[end.row].parameter,
                        "way": "higher" if moved > 0.0 else "lower",
                        "share": None if name in shapes else abs(moved / number.value),
                        "size": abs(moved) if name in shapes else None,
                    }
                    numbers |= mark({name: number}, Caveat("leans", data))
        return {name: numbers[name] for name in parameters}, {
            name: numbers[name] for name in derived
        }

    # -- what they rest on ------------------------------------------------------------------------

    def _reservations(self, names: Sequence[str]) -> Iterator[Reservation]:
        """Reservations about the assumptions of a fit, and the numbers that depend on them."""
        problem, records = self._problem, self._problem.folded
        if not self._best.converged:
            yield NO_MINIMUM, None
        if self._is_misfit:
            data = {
                "amplitudes": range_of([record.amplitude for record in records], "m"),
                "loads": range_of(problem.loads, "N"),
                "stake": self._answer.stake,
            }
            yield Caveat("apparent", data), None
        reached = max(record.slip_share for record in self._records)
        if reached < _REACHED:
            limits = [name for name in names if name.partition(" ")[0] in _LIMITS]
            yield Caveat("beyond", {"reached": reached, "laws": None, "none": None}), limits
        for doubt in dict.fromkeys(record.doubt for record in records if record.doubt):
            yield Caveat("doubted record", {"doubt": doubt}), None
        if self._contradicted is not None:
            functions = {quantity.name: quantity.function for quantity in problem.quantities}
            for j, coordinate in zip(problem.row, self._free, strict=True):
                functions[coordinate.name] = of_coordinate(problem, j)
            reached_names = [name for name, f in functions.items() if self._contradicted.reaches(f)]
            yield Caveat("contradicted", {"names": self._contradicted.names}), reached_names
        far = self._far_area()
        if far is not None:
            yield far, _BY_AREA
        yield from self._same_laws()

    def _same_laws(self) -> Iterator[Reservation]:
        """Rigs that change loops just as parameters of the law do, whatever the noise."""
        _, by = self._problem.residuals(self._best.q)
        for row, coordinate in enumerate(self._free):
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
                names = [c.name for c, is_alike in zip(self._free, alike, strict=True) if is_alike]
                yield Caveat("same law", {}, self._design.remedies(coordinate, NOT)), names

    def _far_area(self) -> Caveat | None:
        """The caveat of a contact area measured at a load far from all records."""
        measured = next((c.load for c in self._problem.coordinates if c.parameter == AREA), None)
        loads = [load for load in self._problem.loads if load]
        if measured is None or not loads:
            return None
        if min(loads) / _FAR <= measured <= _FAR * max(loads):
            return None
        return Caveat("far area", {"load": measured, "loads": range_of(loads, "N")})

    # -- the fit as a whole -----------------------------------------------------------------------

    def _status(self, parameters: Numbers) -> tuple[str, list[Caveat]]:
        """Status of the fit, and its message."""
        best = self._best
        at = [self._free[i].name for i in best.at_bounds]
        rigs = fit_quality.rigs_differ(best) if best.converged else None
        status, caveats = CONVERGED, [] if rigs is None else [rigs]
        if not best.converged:
            status, caveats = NOT_CONVERGED, [Caveat(best.cause, {"why": best.why})]
        elif rigs is not None and rigs.kind == "one rig":
            status = DIFFER
        elif at:
            status, caveats = AT_BOUND, [_at_bounds(at, parameters), *caveats]
        if self._is_misfit:
            caveats.append(fit_quality.misfit(self._records, best.reduced))
        if self._contradicted is not None:
            caveats.append(self._contradicted.caveat)
        return status, caveats

    def _remarks(self, lost: bool) -> Iterator[Caveat]:
        """Further remarks on the fit; ``lost`` is whether a parameter is not identified."""
        problem, answer, design, best = self._problem, self._answer, self._design, self._best
        yield from nuisances.noise_remarks(best, self._loss)
        yield from (causes := list(nuisances.causes(best)))
        is_wrong = best.cost > WRONG_FROM * problem.freedom
        soft = problem.soft_rig() if is_wrong else None
        yield from filter(None, (soft, self._far_area()))
        times = math.sqrt(answer.widest)
        if times > 1.0:
            by_law = best.reduced >= 0.999 * times**2
            reduced, cycles = (best.reduced, None) if by_law else (None, "")
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
        if names := [self._free[i].name for i in answer.linear]:
            is_whole = len(names) == len(self._free)
            data: dict[str, Any] = {
                "every": "" if is_whole else None,
                "names": None if is_whole else names,
            }
            yield Caveat("straight", data)


def _fixed(source: Coordinate | Quantity, value: float) -> Fitted:
    return Fitted(*(source.name, source.unit, value, value, value, 0.0, FIXED), load=source.load)


def _at_bounds(at: Sequence[str], parameters: Numbers) -> Caveat:
    places = [
        Caveat("a bound", {"name": name, "value": number.value, "unit": number.unit})
        for name, number in parameters.items()
        if name in at
    ]
    identified = [name for name, number in parameters.items() if number.verdict == IDENTIFIED]
    data: dict[str, Any] = {"places": places[:3], "names": identified or None}
    data |= {"more": max(len(places) - 3, 0) or None, "none": None if identified else ""}
    return Caveat("at a bound", data)


def range_of(values: Sequence[float | None], unit: str) -> str | None:
    """The lowest to the highest value, one of them where they read alike; None without any."""
    known = [value for value in values if value]
    ends = (min(known), max(known)) if known else ()
    return " to ".join(dict.fromkeys(number_text(end, unit) for end in ends)) or None
