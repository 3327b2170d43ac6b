"""Exponential summit heights."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import parameter
from microslip.heights.base import HeightDistribution


@dataclass(frozen=True)
class Exponential(HeightDistribution):
    """Exponential summit heights y >= 0 with density exp(-y/scale)/scale.

    Parameters
    ----------
    scale : float
        Mean and standard deviation of the heights [m], above zero.

    Notes
    -----
    F_n(h) = Gamma(n+1) exp(-h) holds only for h >= 0, h = threshold/scale. Below, with every
    summit above the threshold, F_n = exp(x) Gamma(n+1, x), x = -h (DLMF 8.8.2): from
    sqrt(pi) erfcx(sqrt(x)) or 1 upwards by g(a+1) = a g(a) + x^a, which adds positive terms only.
    """

    scale: float = field(
        metadata=parameter("lambda", "m", "mean and standard deviation", above=0.0, example=8e-7)
    )

    edge = 0.0
    _spread_name = "heights.scale"

    def _standardised(self, height: float) -> float | None:
        return height / self.scale

    @property
    def spread(self) -> float:
        """Standard deviation of the heights [m]."""
        return self.scale

    @property
    def span(self) -> tuple[float, float]:
        """Heights [m] below and above which there is next to nothing."""
        return 0.0, 700.0 * self.scale

    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        order = 0.5 * twice_order
        h = threshold / self.scale
        result = math.gamma(order + 1.0) * np.exp(-np.maximum(h, 0.0))
        below = h < 0.0
        if below.any():
            result = np.asarray(result)
            result[below] = _incomplete(order + 1.0, -h[below])
        return np.asarray(result * self.scale**order)

    def _density(self, height: Floats) -> Floats:
        y = np.maximum(height, 0.0) / self.scale
        return np.where(height < 0.0, 0.0, np.exp(-y) / self.scale)

    def _below(self, height: Floats) -> Floats:
        return np.asarray(-np.expm1(-np.maximum(height, 0.0) / self.scale))

    @classmethod
    def examples(cls) -> tuple[HeightDistribution, ...]:
        """One scale stands for all."""
        return (cls(scale=8e-7),)


def _incomplete(a: float, x: Floats) -> Floats:
    """exp(x) Gamma(a, x) for a = 1/2, 1, 3/2 ... and x > 0."""
    if a % 1.0:
        from scipy.special import erfcx  # here, since only heavy loads need SciPy

        power, value = 0.5, math.sqrt(math.pi) * erfcx(np.sqrt(x))
    else:
        power, value = 1.0, np.ones_like(x)
    while power < a:
        value = power * value + x**power
        power += 1.0
    return np.asarray(value)
