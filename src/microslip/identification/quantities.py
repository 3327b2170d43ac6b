"""Derived quantities of a fit, the data given beside the loops, and whether they agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, exact, number, positive, show
from microslip._core.errors import InputError
from microslip._core.wording import did_you_mean
from microslip.contact import GreenwoodWilliamson
from microslip.identification.caveats import Caveat, number_text
from microslip.identification.coordinates import (
    AREA,
    DENSITY,
    RADIUS,
    SUMMIT_DATA,
    Coordinate,
    Datum,
    Function,
    Quantity,
    groups_of,
    labels_of,
    levels_of,
)
from microslip.identification.fit import Fit, covariance_of
from microslip.identification.models.base import Derived, Materials, Model
from microslip.identification.problem import Problem
from microslip.identification.profiles import cycle_ratio

_STEP = 1e-5
_NEED_MORE = ("std", "density_root_radius", "radius", "density", "summit_count", "contact_area")
_GIVE_PAIR = "; give `pair=...`, and the apparent area with it"


def quantities_of(problem: Problem) -> list[Quantity]:
    """Quantities derived from the law, for each load where they depend on it."""
    model, quantities = problem.model, []
    start = np.array([c.inner(c.start) for c in problem.free_coordinates])
    names = set(model.names)
    groups = list(dict.fromkeys(problem.columns))
    levels = levels_of(problem.loads)
    labels = labels_of(problem.folded, levels)
    level = dict(zip(problem.loads, levels, strict=True))
    for group in groups:
        members = [i for i, column in enumerate(problem.columns) if column == group]
        loads = _distinct([problem.loads[i] for i in members])
        several = len(groups) > 1 or len(loads) > 1
        values = problem.values_of(members[0], start)
        for quantity in model.derived(values, loads, problem.materials):
            load = quantity.load
            if load is None and len(groups) > 1:
                load = loads[0]
            name, parent = quantity.name, None
            if name in names:
                parent = problem.coordinates[group[model.names.index(name)]].name
                if not several or parent != name:
                    continue  # the parameter itself
            if several and load is not None:
                name = f"{quantity.name} at {labels[level[load]]} N"
            at = loads[:1] if quantity.load is None else [quantity.load]
            function = _Derivation(problem, members[0], at).of(quantity.name)
            shape = quantity.name in model.at_reference and quantity.unit == ""
            quantities.append(Quantity(name, quantity.unit, load, function, parent, shape))
    return quantities


def _distinct(loads: Sequence[float | None]) -> list[float | None]:
    """Loads in rising order, one of each level."""
    groups = groups_of({load for load in loads if load is not None})
    return [*([None] if None in loads else []), *(group[0] for group in groups)]


class _Derivation:
    """Derived quantities of a law at one load, kept for the last coordinates."""

    def __init__(self, problem: Problem, record: int, loads: Sequence[float | None]) -> None:
        self._problem, self._record, self._loads = problem, record, loads
        self._last: tuple[bytes, dict[str, Derived]] | None = None

    def of(self, name: str) -> Function:
        """One of the quantities as a function of the coordinates."""
        problem, group = self._problem, self._problem.columns[self._record]

        def function(q: Floats) -> tuple[float, Floats]:
            quantity, inner, by = self._at(q)[name], problem.full(q), np.zeros(q.size)
            for j, slope in zip(group, quantity.gradient, strict=True):
                if j in problem.row:
                    by[problem.row[j]] += slope * problem.coordinates[j].slope(float(inner[j]))
            return quantity.value, by

        return function

    def _at(self, q: Floats) -> dict[str, Derived]:
        key, problem = q.tobytes(), self._problem
        if self._last is None or self._last[0] != key:
            values = problem.values_of(self._record, q)
            derived = problem.model.derived(values, self._loads, problem.materials)
            self._last = key, {quantity.name: quantity for quantity in derived}
        return self._last[1]


def _differences(function: Callable[[Floats], float], q: Floats) -> Floats:
    """Central differences of a smooth function."""
    by = np.zeros(q.size)
    for i in range(q.size):
        step = np.zeros(q.size)
        step[i] = _STEP
        by[i] = (function(q + step) - function(q - step)) / (2.0 * _STEP)
    return by


# -- what tells radius and density apart ----------------------------------------------------------


def _measured(name: str, unit: str, value: float, error: float, load: float | None) -> Coordinate:
    """The coordinate of something that was measured, with its error as prior."""
    bounds = 1e-3 * value, 1e3 * value
    return Coordinate(name, name, unit, *bounds, "log", value, prior=(value, error), load=load)


def summit_prior(
    contact_area: Any, data: Any, model: Model, materials: Materials
) -> tuple[Coordinate | None, Any]:
    """The coordinate that tells radius and density apart: an area or one of both; other data."""
    if contact_area is not None:
        try:
            value, error, load = contact_area
        except (TypeError, ValueError):
            raise InputError(
                "`contact_area` must be (value [m^2], uncertainty [m^2], normal load [N]), got "
                f"{show(contact_area)}"
            ) from None
        value = positive(AREA, value, "m^2", 2e-5)
        error = positive(f"uncertainty of {AREA}", error, "m^2", 1e-6)
        load = positive(f"normal load of {AREA}", load, "N", 2000.0)
        if materials.area is not None and value > materials.area:
            raise InputError(
                f"`contact_area` must not be above the apparent area, {exact(materials.area)} m^2, "
                f"got {exact(value)} m^2"
            )
        return _measured(AREA, "m^2", value, error, load), data
    if isinstance(data, Mapping) and materials.pair is not None and _has_summits(model):
        for name, unit, example in ((RADIUS, "m", 1e-3), (DENSITY, "m^-2", 1e8)):
            if name in data:
                value, error = _datum(name, data[name])
                value = positive(f"known {name}", value, unit, example)
                further = {key: datum for key, datum in data.items() if key != name}
                return _measured(name, unit, value, error, None), further
    return None, data


def _has_summits(model: Model) -> bool:
    template = getattr(model, "template", None)
    return template is not None and isinstance(template.law, GreenwoodWilliamson)


def summits_of(problem: Problem, load: float | None) -> list[Quantity]:
    """Radius, density and contact area by density * sqrt(radius) and one that is given."""
    materials, area = problem.materials, problem.materials.area
    if not _has_summits(problem.model):
        raise InputError(
            '`contact_area` needs `law="interface"` with a distribution of summit heights: '
            "other laws do not model contacts"
        )
    if materials.pair is None:
        raise InputError(
            "`contact_area` needs `pair=...`, the two materials: the contact area "
            "depends on the modulus"
        )
    index, datum_name = next(
        (i, c.parameter) for i, c in enumerate(problem.coordinates) if c.parameter in SUMMIT_DATA
    )
    if datum_name == DENSITY and area is None:
        raise InputError(
            "`known`: density needs `area=...`, the apparent area [m^2]: loops give N/A"
        )
    if load is None:
        load = problem.model.reference_load  # type: ignore[attr-defined]
    assert load is not None
    loads = [known or load for known in problem.loads]
    near = min(range(len(loads)), key=lambda i: abs(math.log(loads[i] / load)))

    def all_of(q: Floats) -> dict[str, float]:
        joint = problem.model.build(problem.values_of(near, q), load, materials)
        measured, surface = problem.physical(q)[index], joint.surface
        radius, count = surface.radius, surface.density * surface.area
        # The area goes with count * radius, the loops with count * sqrt(radius).
        if datum_name == AREA:
            ratio = measured / joint.contact_area
        elif datum_name == RADIUS:
            ratio = math.sqrt(measured / radius)
        else:
            ratio = count / (measured * (area or 1.0))
        return {
            RADIUS: radius * ratio**2,
            "summit_count": count / ratio,
            DENSITY: count / ratio / (area or 1.0),
            AREA: joint.contact_area * ratio,
        }

    def of(name: str) -> Function:
        def function(q: Floats) -> tuple[float, Floats]:
            return all_of(q)[name], _differences(lambda p: all_of(p)[name], q)

        return function

    units = {RADIUS: "m", "summit_count": "", DENSITY: "m^-2", AREA: "m^2"}
    return [
        Quantity(
            f"{name} at {load:.4g} N" if name == AREA else name,
            unit,
            load if name == AREA else None,
            of(name),
        )
        for name, unit in units.items()
        if name != datum_name and (name != DENSITY or area is not None)
    ]


# -- data from elsewhere --------------------------------------------------------------------------


def known_data(problem: Problem, data_options: Any) -> list[Datum]:
    """Data on parameters or on what follows from them, as (value, standard deviation)."""
    if data_options is None:
        return []
    if not isinstance(data_options, Mapping):
        raise InputError(
            f"`known` must be a dict such as {{'std': (5e-7, 5e-8)}}, got {show(data_options)}"
        )
    by_name = {quantity.name: quantity for quantity in problem.quantities}
    free = {problem.coordinates[j].name: j for j in problem.row}
    data = []
    for name, raw_datum in data_options.items():
        if name not in by_name and name not in free:
            names = [*free, *by_name]
            hint = did_you_mean(name, names) if isinstance(name, str) else ""
            raise InputError(
                f"`known`: {show(name)} is no parameter or result of this fit, which has "
                f"{', '.join(names)}{hint}" + (_GIVE_PAIR if name in _NEED_MORE else "")
            )
        value, error = _datum(name, raw_datum)
        if name in by_name:
            unit, function = by_name[name].unit, by_name[name].function
        else:
            unit, function = (
                problem.coordinates[free[name]].unit,
                of_coordinate(problem, free[name]),
            )
        data.append(Datum(name, unit, value, error, function))
    return data


def _datum(name: str, raw_datum: Any) -> tuple[float, float]:
    """Value and standard deviation, of a pair or of what has both, such as error bars of a scan."""
    value, error = (getattr(raw_datum, key, None) for key in ("value", "standard_error"))
    if value is None or error is None:
        try:
            value, error = raw_datum
        except (TypeError, ValueError):
            raise InputError(
                f"`known`: {name} must be (value, standard deviation), got {show(raw_datum)}"
            ) from None
    return number(f"known {name}", value), positive(f"standard deviation of {name}", error)


def of_coordinate(problem: Problem, j: int) -> Function:
    """A free coordinate as a number that follows from all."""
    coordinate, row = problem.coordinates[j], problem.row[j]

    def function(q: Floats) -> tuple[float, Floats]:
        value, by = coordinate.outer(float(q[row])), np.zeros(q.size)
        by[row] = coordinate.slope(float(q[row]))
        if coordinate.kind == "inverse":
            by[row] *= -(value**2) if math.isfinite(value) else 0.0
        return value, by

    return function


# -- whether the loops agree with them ------------------------------------------------------------

DISAGREE = 3.0
"""Standard deviations beyond which a given value and the loops disagree."""
_RARE = 0.0027  # probability of more than three standard deviations
_MOVED, _SHARE = 1.0, 0.5
"""Limits of dependence on a datum: standard errors by which it moves a number, and its share of the
number's information."""


@dataclass(frozen=True)
class GivenDatum:
    """A value from elsewhere, beside what the fit made of it."""

    name: str
    unit: str
    value: float
    """Value as given."""
    uncertainty: float
    """Its standard deviation, as it was given."""
    found: float
    """Value of the fit."""
    residual: float
    """Found minus given, in standard deviations of the given value [-]."""
    without: float
    """Value of a fit without it; any value where nothing else determines it."""
    disagreement: float
    """By how many standard deviations it contradicts all the rest [-]: the root of what the sum of
    squares falls by without it, over that of the noise."""
    agrees: bool
    """Whether loops and other data bear it out."""

    @property
    def text(self) -> str:
        """The datum in a line."""
        value, error, fitted = (
            number_text(x, self.unit) for x in (self.value, self.uncertainty, self.found)
        )
        return (
            f"given {self.name} = {value} ± {error}: found {fitted}, {self.residual:+.2f} standard "
            f"deviations off, {abs(self.disagreement):.2f} from all other data"
            f"{'' if self.agrees else ': given values and the loops disagree'}"
        )

    def contradiction(self, without: float) -> Caveat:
        """Caveat that the datum is wrong, with the value found without it."""
        data = {"name": self.name, "value": self.value, "error": self.uncertainty}
        deviations = max(abs(self.residual), abs(self.disagreement))
        disagreement = {"unit": self.unit, "without": without, "deviations": deviations}
        return Caveat("datum", data | disagreement)


class _Refit(NamedTuple):
    """The fit without some of the data."""

    q: Floats
    fall: float
    """By how much the sum of squares is less, over that of the noise."""
    noise: float
    """The noise over what white noise would be, as far as these data have no part in it."""


class Contradicted(NamedTuple):
    """Data that the loops contradict."""

    caveat: Caveat
    names: tuple[str, ...]
    best: Floats
    covariance: Floats
    moves: tuple[tuple[Floats, Function], ...]
    """End of the fit without each datum, and the datum's own value as a function."""

    def reaches(self, function: Function) -> bool:
        """Whether a number depends on them."""
        value, gradient = function(self.best)
        variance = float(gradient @ self.covariance @ gradient)
        for elsewhere, datum in self.moves:
            if abs(function(elsewhere)[0] - value) > _MOVED * math.sqrt(variance):
                return True
            by = datum(self.best)[1]
            shared = float(gradient @ self.covariance @ by)
            if shared**2 > _SHARE * variance * float(by @ self.covariance @ by) > 0.0:
                return True
        return False


def compare_data(best: Fit) -> tuple[tuple[GivenDatum, ...], Contradicted | None]:
    """Each datum beside what the loops say, and those that they contradict.

    Each is left out once, and the rest fitted again: the sum of squares falls by the square of the
    deviations that part it from the rest (Cook and Weisberg 1982, Residuals and Influence in
    Regression), here without taking it for straight.
    """
    from scipy.special import chdtrc

    problem = best.problem
    every = [*_priors(problem), *problem.data]
    data, wrong = [], []
    for datum in every:
        refit = _fit_without(best, [datum])
        value = datum.function(best.q)[0]
        residual = datum.residual(value)
        disagreement = math.copysign(math.sqrt(refit.fall), residual)
        agrees = max(abs(residual), abs(disagreement)) <= DISAGREE
        alone = datum.function(refit.q)[0]
        data.append(GivenDatum(*datum[:4], value, residual, alone, disagreement, agrees))
        if not agrees:
            wrong.append((datum, refit))
    if not wrong and len(every) > 1:
        # Two data that are wrong in the same way support each other.
        refit = _fit_without(best, every)
        if chdtrc(len(every), refit.fall) < _RARE:
            wrong = [(datum, refit) for datum in every]
            data = [replace(datum, agrees=False) for datum in data]
    if not wrong:
        return tuple(data), None
    by_name = {datum.name: datum for datum in data}
    contradictions = [
        by_name[datum.name].contradiction(datum.function(refit.q)[0]) for datum, refit in wrong
    ]
    contradicted = Contradicted(
        Caveat("contradiction", {"data": contradictions}),
        tuple(datum.name for datum, _ in wrong),
        best.q,
        covariance_of(best.information) * max(refit.noise for _, refit in wrong),
        tuple((refit.q, datum.function) for datum, refit in wrong),
    )
    return tuple(data), contradicted


def _priors(problem: Problem) -> Iterator[Datum]:
    """Data that are priors of coordinates."""
    for j, c in zip(problem.row, problem.free_coordinates, strict=True):
        if c.prior is not None:
            value, error = c.prior
            inverse = c.kind == "inverse"
            if inverse:  # a compliance of what was given as a stiffness
                value, error = (float(f"{x:.14g}") for x in (1.0 / value, error / value**2))
            yield Datum(c.name, c.unit, value, error, of_coordinate(problem, j), j, inverse)


def _fit_without(best: Fit, left_out: Sequence[Datum]) -> _Refit:
    """The fit near the best one, by the same weights, without some data."""
    problem = best.problem
    remaining = problem.with_coordinates(
        {datum.coordinate: {"prior": None} for datum in left_out if datum.coordinate is not None}
    )
    remaining._last = None
    remaining.data = [datum for datum in problem.data if datum not in left_out]
    fit = Fit(remaining, best.q).settled_near()
    if fit is None:
        return _Refit(best.q, 0.0, 1.0)
    reduced = fit.cost / max(remaining.freedom, 1)
    noise = max(reduced, float(cycle_ratio(fit).max(initial=1.0)), 1.0)
    problem.evaluations = remaining.evaluations
    return _Refit(fit.q, max(best.cost - fit.cost, 0.0) / noise, noise)
