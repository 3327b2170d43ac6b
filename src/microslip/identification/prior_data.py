"""Data given beside the loops, and whether the loops agree with them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from microslip._core.checks import Floats
from microslip.identification.caveats import Caveat
from microslip.identification.fit import Fit, covariance_of, settle_near
from microslip.identification.labels import number_text
from microslip.identification.problem import Problem
from microslip.identification.profiles import cycle_ratio, information
from microslip.identification.quantities import Function, Quantity, of_coordinate

DISAGREE = 3.0
"""Standard deviations beyond which a given value and the loops disagree."""
_RARE = 0.0027  # probability of more than three standard deviations
_MOVED, _SHARE = 1.0, 0.5
"""What depends on a datum: what it moves by so many standard errors, or owes it so much of its
information."""


@dataclass(frozen=True)
class GivenDatum:
    """A value from elsewhere, beside what the fit made of it."""

    name: str
    unit: str
    value: float
    """As it was given."""
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
        """That it is wrong, with what is found without it."""
        data = {"name": self.name, "value": self.value, "error": self.uncertainty}
        deviations = max(abs(self.residual), abs(self.disagreement))
        disagreement = {"unit": self.unit, "without": without, "deviations": deviations}
        return Caveat("datum", data | disagreement)


class _Source(NamedTuple):
    """One datum of a problem."""

    name: str
    unit: str
    value: float
    error: float
    function: Function
    inverse: bool
    """Whether its errors are those of its inverse."""
    coordinate: int | None
    """The coordinate that has it as its prior."""
    place: int | None
    """Where it stands among the data."""

    def residual(self, fitted: float) -> float:
        """Fitted value less the given one, in standard deviations."""
        if self.inverse:
            return (1.0 - self.value / fitted) * self.value / self.error
        return (fitted - self.value) / self.error


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
    """Of each of them: where the fit without it ends, and its own value as a function."""

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


def compare_data(
    problem: Problem, best: Fit, freedom: int, names: Sequence[str], quantities: Iterable[Quantity]
) -> tuple[tuple[GivenDatum, ...], Contradicted | None]:
    """Each datum beside what the loops say, and those that they contradict.

    ``names`` are those of the problem's data. Each is left out once, and the rest fitted again:
    the sum of squares falls by the square of the deviations that part it from the rest (Cook and
    Weisberg 1982, Residuals and Influence in Regression), here without taking it for straight.
    """
    from scipy.special import chdtrc

    sources = _sources(problem, names, {quantity.name: quantity.unit for quantity in quantities})
    if not sources:
        return (), None
    data, wrong = [], []
    for datum in sources:
        refit = _fit_without(problem, best, freedom, [datum])
        value = datum.function(best.q)[0]
        residual = datum.residual(value)
        disagreement = math.copysign(math.sqrt(refit.fall), residual)
        agrees = max(abs(residual), abs(disagreement)) <= DISAGREE
        alone = datum.function(refit.q)[0]
        data.append(GivenDatum(*datum[:4], value, residual, alone, disagreement, agrees))
        if not agrees:
            wrong.append((datum, refit))
    if not wrong and len(sources) > 1:
        # Two data that are wrong in the same way support each other.
        refit = _fit_without(problem, best, freedom, sources)
        if chdtrc(len(sources), refit.fall) < _RARE:
            wrong = [(source, refit) for source in sources]
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
        covariance_of(information(problem, best.q)) * max(refit.noise for _, refit in wrong),
        tuple((refit.q, datum.function) for datum, refit in wrong),
    )
    return tuple(data), contradicted


def _sources(problem: Problem, names: Sequence[str], units: dict[str, str]) -> list[_Source]:
    sources = []
    for j in map(int, problem.free):
        c = problem.coordinates[j]
        if c.prior is None:
            continue
        value, error = c.prior
        inverse = c.kind == "inverse"
        if inverse:  # a compliance of what was given as a stiffness
            value, error = (float(f"{x:.14g}") for x in (1.0 / value, error / value**2))
        function = of_coordinate(problem, j)
        sources.append(_Source(c.name, c.unit, value, error, function, inverse, j, None))
    units = {**units, **{coordinate.name: coordinate.unit for coordinate in problem.coordinates}}
    for place, (name, datum) in enumerate(zip(names, problem.data, strict=True)):
        sources.append(
            _Source(name, units[name], datum.value, datum.error, datum.function, False, None, place)
        )
    return sources


def _fit_without(problem: Problem, best: Fit, freedom: int, left_out: Sequence[_Source]) -> _Refit:
    """The fit near the best one, by the same weights, without some data."""
    remaining = problem.copy()
    out = {source.coordinate for source in left_out}
    remaining.coordinates = tuple(
        replace(coordinate, prior=None) if j in out else coordinate
        for j, coordinate in enumerate(problem.coordinates)
    )
    places = {source.place for source in left_out}
    remaining._last = None
    remaining.data = [datum for place, datum in enumerate(problem.data) if place not in places]
    fit = settle_near(remaining, best.q)
    if fit is None:
        return _Refit(best.q, 0.0, 1.0)
    reduced = fit.cost / max(freedom - len(left_out), 1)
    noise = max(reduced, float(cycle_ratio(remaining, fit.q).max(initial=1.0)), 1.0)
    problem.evaluations = remaining.evaluations
    return _Refit(fit.q, max(best.cost - fit.cost, 0.0) / noise, noise)
