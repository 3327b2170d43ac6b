"""Means and trends over the cycles of a record, with their confidence intervals.

Values of successive cycles are correlated, since friction drifts slowly. Intervals use the
effective number of independent cycles, from the autocorrelation of cycles and of block means.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, number
from microslip._core.errors import InputError

_BLOCKS = 20
"""Fewest cycles, or blocks of them, for an estimate of their correlation."""
_LIKELY, _UPPER = 2.3, 1.75
"""Standard errors from which on a correlation is significant, and those added to it: too small a
correlation does more harm than too large a one."""
_NORMAL = 100_000
"""Degrees of freedom at which Student's distribution is the normal one."""
_HIGHEST, _FARTHEST = 0.999, 2.0
CERTAIN = 5.0
"""Least slope of a significant trend over its standard error; a convention of this project."""


class Estimate(NamedTuple):
    """Mean of a measured quantity over cycles, with its confidence interval."""

    value: float
    """Mean value."""
    low: float
    """Lower end of the interval; not a number where there is only one cycle."""
    high: float
    """Upper end of the interval."""
    standard_error: float
    """Standard error of the mean; not a number for a single cycle."""
    number: int
    """Number of values in the mean."""


@lru_cache
def quantile(confidence: float, freedom: int) -> float:
    """Return the two-sided quantile of Student's t: half-width over standard error [-]."""
    from scipy.special import stdtrit

    return -float(stdtrit(freedom, 0.5 * (1.0 - confidence)))


def checked_confidence(level: Any) -> float:
    """Validate a confidence level [-]."""
    value = number("confidence", level, "", 0.95)
    if not 0.0 < value < 1.0:
        raise InputError(f"`confidence` must be between 0 and 1, such as 0.95, got {value:g}")
    return value


class Dependence(NamedTuple):
    """Effect of the correlation of successive values on the variance of their mean."""

    factor: float
    """Variance of their mean over that of independent values; 1 without correlation."""
    freedom: int
    """Degrees of freedom of the mean."""


def dependence_of(values: Floats, fitted_count: int = 1) -> Dependence:
    """Estimate the variance of the mean of a series over that for independent values [-].

    The autocorrelation of a first-order process is fitted to the values and to means of blocks of
    4, 16, ... values, since noise may hide it; the largest variance is returned. The estimate is
    corrected for its bias (Marriott and Pope 1954, DOI 10.1093/biomet/41.3-4.390). ``fitted_count``
    is the number of coefficients already fitted to the values.
    """
    size = values.size
    largest = Dependence(1.0, size - fitted_count)
    white = float(np.var(values, ddof=1)) / size if size > 1 else 0.0
    if not white > 1e-24 * float(np.mean(values**2) if size else 0.0):
        return largest
    length = 1
    while size // length >= _BLOCKS:
        number = size // length
        means = values[size - number * length :].reshape(number, length).mean(axis=1)
        away = means - means.mean()
        square = float(away @ away)
        correlation = (number * float(away[1:] @ away[:-1]) / square + fitted_count) / (
            number - 3.0
        )
        if correlation * math.sqrt(number) >= _LIKELY:
            extra = (
                _UPPER * math.sqrt(max(1.0 - correlation**2, 0.0) / number) if length == 1 else 0.0
            )
            rho = min(correlation + extra, _HIGHEST)
            tail = rho / (1.0 - rho) - rho * (1.0 - rho**number) / (number * (1.0 - rho) ** 2)
            share = (1.0 + 2.0 * tail) / number
            variance = square / number * share / max(1.0 - share, 1e-3)
            if variance > largest.factor * white:
                freedom = min(max(2, int(1.0 / share - 1.0)), size - fitted_count)
                largest = Dependence(variance / white, freedom)
        length *= 4
    return largest


def chance_below_zero(values: Floats) -> float:
    """Return the probability [-] that the true mean of a series is at most zero."""
    if values.size == 0:
        return 0.5
    mean = float(values.mean())
    if values.size == 1 or not (spread := float(values.std(ddof=1))) > 0.0:
        return float(mean <= 0.0)
    dependence = dependence_of(values)
    from scipy.special import stdtr

    errors = mean / spread / math.sqrt(dependence.factor / values.size)
    return float(stdtr(dependence.freedom, -errors))


def mean_of(values: Floats, confidence: float, moving: bool = False) -> Estimate:
    """Average finite values; the interval is Student's, or their range for a trend (``moving``)."""
    fine = values[np.isfinite(values)]
    if fine.size == 0:
        return Estimate(math.nan, math.nan, math.nan, math.nan, 0)
    value = float(fine.mean())
    if fine.size == 1:
        return Estimate(value, math.nan, math.nan, math.nan, 1)
    spread = float(fine.std(ddof=1))
    if moving:
        # Values that wander about a monotonic course may reach beyond their range.
        beside = min(
            (fine - sign * _rising(sign * fine) for sign in (1.0, -1.0)),
            key=lambda away: float(away @ away),
        )
        low, high = float(fine.min()), float(fine.max())
        if dependence_of(beside, 2).factor > 1.0:
            half = _of_mean(beside, confidence, 2)[1]
            low, high = low - half, high + half
        return Estimate(value, low, high, spread, int(fine.size))
    error, half = _of_mean(fine, confidence, 1)
    return Estimate(value, value - half, value + half, error, int(fine.size))


def _rising(values: Floats) -> Floats:
    """Return the non-decreasing series closest in least squares (pool adjacent violators)."""
    pools: list[tuple[float, int]] = []
    for value in values.tolist():
        mean, size = value, 1
        while pools and pools[-1][0] >= mean:
            before, number = pools.pop()
            mean, size = (before * number + mean * size) / (number + size), number + size
        pools.append((mean, size))
    return np.repeat([mean for mean, _ in pools], [size for _, size in pools])


def _of_mean(values: Floats, confidence: float, fitted_count: int) -> tuple[float, float]:
    dependence = dependence_of(values, fitted_count)
    error = float(values.std(ddof=1)) / math.sqrt(values.size)
    if dependence.factor == 1.0:
        return error, quantile(confidence, values.size - 1) * error
    error *= math.sqrt(dependence.factor)
    # The mean of a wandering series is hardly outside twice its range.
    half = min(quantile(confidence, dependence.freedom) * error, _FARTHEST * float(np.ptp(values)))
    return error, half


def with_gain(estimate: Estimate, relative: float, confidence: float) -> Estimate:
    """Widen the interval of a mean by a relative gain error common to all values."""
    if relative == 0.0 or not math.isfinite(estimate.value):
        return estimate
    error = relative * abs(estimate.value)
    half = quantile(confidence, _NORMAL) * error
    ends = np.nan_to_num([estimate.value - estimate.low, estimate.high - estimate.value])
    low, high = (math.hypot(end, half) for end in ends.tolist())
    total_error = math.hypot(float(np.nan_to_num(estimate.standard_error)), error)
    return estimate._replace(
        low=estimate.value - low, high=estimate.value + high, standard_error=total_error
    )


def mean_of_inverses(values: Floats, confidence: float, moving: bool = False) -> Estimate:
    """Return the harmonic mean and its interval, from those of the mean inverse.

    Both are NaN if the interval of the mean inverse includes zero.
    """
    of = mean_of(1.0 / values[values != 0.0], confidence, moving)
    if not of.value > 0.0 or of.low <= 0.0:
        return Estimate(math.nan, math.nan, math.nan, math.nan, of.number)
    error = of.standard_error / of.value**2
    return Estimate(1.0 / of.value, 1.0 / of.high, 1.0 / of.low, error, of.number)


class Trend(NamedTuple):
    """Slope of a straight line through values, with its standard error."""

    slope: float
    standard_error: float
    number: int
    """Number of values."""

    @property
    def is_certain(self) -> bool:
        """Whether the slope exceeds five standard errors and passes a t test at 99.9 %."""
        if self.number < 4:
            return False
        least = max(CERTAIN, quantile(0.999, self.number - 2))
        return abs(self.slope) > least * self.standard_error


def trend(x: Floats, y: Floats, independent: bool = True) -> Trend:
    """Fit a straight line y(x) by least squares.

    Unless ``independent``, the standard error includes the correlation of successive values.
    """
    if x.size < 2 or np.ptp(x) == 0.0:
        return Trend(math.nan, math.nan, int(x.size))
    away = x - x.mean()
    square = float(np.dot(away, away))
    slope = float(np.dot(away, y)) / square
    if x.size < 3:
        return Trend(slope, math.nan, int(x.size))
    residual = y - y.mean() - slope * away
    error = math.sqrt(float(np.dot(residual, residual)) / (x.size - 2) / square)
    if not independent:
        error *= math.sqrt(dependence_of(residual, 2).factor)
    return Trend(slope, error, int(x.size))
