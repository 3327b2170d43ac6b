"""What changes over a record beside its cycles: a drift, and noise that is slow."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.identification.mean_cycle import MeanCycle, stretches

_CERTAIN, _SIGNIFICANT = 5.0, 1e-3


class Drift(NamedTuple):
    """A straight line over the cycles."""

    slope: float
    """Change a cycle."""
    error: float
    """Standard error of that."""

    @property
    def is_certain(self) -> bool:
        """Whether it is more than noise makes."""
        return abs(self.slope) > _CERTAIN * self.error


def drift_of(values: Floats, cycle: NDArray[np.int64], curve: MeanCycle) -> Drift:
    """Drift of a channel beside its mean cycle; slow noise counts by the scatter of the cycles."""
    progress = curve.of(cycle).residual
    square = float(progress @ progress)
    if square == 0.0:
        return Drift(0.0, 0.0)
    scatter = curve.of(values).residual
    slope = float(progress @ scatter) / square
    progress *= slope
    scatter -= progress
    del progress
    noise = curve.noise(scatter, 1)
    return Drift(slope, noise * math.sqrt(slowness(scatter, cycle, noise, 2) / square))


def slowness(residual: Floats, number: NDArray[np.int64], noise: float, fitted_count: int) -> float:
    """Variance of the means of cycles over that of white noise; 1 if not significantly more."""
    from scipy.special import chdtrc

    count = np.bincount(number).astype(float)
    freedom = np.count_nonzero(count) - fitted_count
    if freedom < 1 or noise == 0.0:
        return 1.0
    sums = np.bincount(number, residual)
    square = float(np.sum(sums**2 / np.maximum(count, 1.0))) / noise**2
    return square / freedom if chdtrc(freedom, square) < _SIGNIFICANT else 1.0


def error_of_mean(values: Floats, number: NDArray[np.int64], curve: MeanCycle) -> float:
    """Standard error of a mean, by white noise or, where larger, by the scatter of the cycles."""
    residual = curve.of(values).residual
    noise = curve.noise(residual)
    count = np.bincount(number).astype(float)
    means = np.bincount(number, residual) / count
    place = np.arange(means.size, dtype=float)
    if means.size > 2:
        line = np.polynomial.Polynomial.fit(place, means, 1, w=np.sqrt(count))
        for piece in stretches(residual.size):
            residual[piece] -= line(place)[number[piece]]
    noise = curve.noise(residual, 1)
    return noise * math.sqrt(slowness(residual, number, noise, 2) / values.size)
