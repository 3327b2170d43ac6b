"""Floor 6: means and trends over the cycles of a record, with their confidence intervals."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.numerics.quadrature import gauss_legendre

_STEPS = 100
"""Bound of Newton's steps: a confidence of 1 - 1e-15 takes some forty."""


class Estimate(NamedTuple):
    """A number that was measured, with its confidence interval."""

    value: float
    """The mean."""
    low: float
    """Lower end of the interval; not a number where there is only one cycle."""
    high: float
    """Its upper end."""
    standard_error: float
    """Of the mean; not a number where there is only one cycle."""
    number: int
    """How many values it is the mean of."""


@lru_cache
def quantile(confidence: float, freedom: int) -> float:
    """Half width of Student's interval in standard errors [-]; SciPy would cost more to load."""
    # With t = sqrt(f) tan(a), the confidence is the integral of cos^(f-1) from 0 to a, over that
    # to pi/2 (Wallis' product). It is concave in a: Newton's steps from below never overshoot.
    power = freedom - 1
    even_product, odd = math.pi / 2.0, 1.0
    factors = np.arange(power, 1, -2, dtype=np.float64)
    quarter = (odd if power % 2 else even_product) * math.exp(float(np.log1p(-1.0 / factors).sum()))
    nodes, weights = gauss_legendre(60)

    def integrand(angle: Any) -> Any:
        return np.exp(-0.5 * power * np.log1p(np.tan(angle) ** 2))

    angle = confidence * quarter
    for _ in range(_STEPS):
        inside = angle * float(weights @ integrand(angle * nodes))
        step = (confidence * quarter - inside) / float(integrand(angle))
        angle += step
        if step <= 4e-16 * angle:
            break
    return math.sqrt(freedom) * math.tan(angle)


def mean_of(values: Floats, confidence: float, moving: bool = False) -> Estimate:
    """Mean of finite values with Student's confidence interval, or their range if they move."""
    fine = values[np.isfinite(values)]
    if fine.size == 0:
        return Estimate(math.nan, math.nan, math.nan, math.nan, 0)
    value = float(fine.mean())
    if fine.size == 1:
        return Estimate(value, math.nan, math.nan, math.nan, 1)
    spread = float(fine.std(ddof=1))
    if moving:
        low, high = float(fine.min()), float(fine.max())
        return Estimate(value, low, high, spread, int(fine.size))
    error = spread / math.sqrt(fine.size)
    half = quantile(confidence, fine.size - 1) * error
    return Estimate(value, value - half, value + half, error, int(fine.size))


def mean_of_inverses(values: Floats, confidence: float, moving: bool = False) -> Estimate:
    """Inverse of the mean inverse; not a number where that may not be above zero."""
    of = mean_of(1.0 / values[values != 0.0], confidence, moving)
    if not of.value > 0.0 or of.low <= 0.0:
        return Estimate(math.nan, math.nan, math.nan, math.nan, of.number)
    error = of.standard_error / of.value**2
    return Estimate(1.0 / of.value, 1.0 / of.high, 1.0 / of.low, error, of.number)


def trend(x: Floats, y: Floats, confidence: float) -> Estimate:
    """Slope of a straight line by least squares, with Student's confidence interval."""
    if x.size < 2 or np.ptp(x) == 0.0:
        return Estimate(math.nan, math.nan, math.nan, math.nan, int(x.size))
    away = x - x.mean()
    square = float(np.dot(away, away))
    slope = float(np.dot(away, y)) / square
    if x.size < 3:
        return Estimate(slope, math.nan, math.nan, math.nan, int(x.size))
    residual = y - y.mean() - slope * away
    error = math.sqrt(float(np.dot(residual, residual)) / (x.size - 2) / square)
    half = quantile(confidence, x.size - 2) * error
    return Estimate(slope, slope - half, slope + half, error, int(x.size))
