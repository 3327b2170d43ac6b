"""Data given beside the loops, and whether the loops agree with them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from microslip._core.checks import Floats
from microslip.identification.caveats import Caveat
from microslip.identification.coordinates import Datum, Function
from microslip.identification.fit import Fit, covariance_of
from microslip.identification.labels import number_text
from microslip.identification.problem import Problem
from microslip.identification.profiles import cycle_ratio
from microslip.identification.quantities import of_coordinate

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
