"""Gaussian, exponential and given heights, whose moments have closed forms.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import Floats, record
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip._core.packages import needed_for
from microslip._core.parameters import parameter
from microslip.contact.heights.base import HeightDistribution


@dataclass(frozen=True)
class Gaussian(HeightDistribution):
    """Gaussian (normal) summit heights (19.25).

    Parameters
    ----------
    std : float
        Standard deviation sigma [m], above zero.
    mean : float, optional
        Mean height m [m].

    Notes
    -----
    With h = (threshold - m)/sigma, the partial moments of order n over sigma^n, F_n(h) =
    Gamma(n+1)/sqrt(2 pi) exp(-h^2/4) D_{-n-1}(h) (DLMF 12.5.1), are evaluated by Chebyshev fits
    with relative errors of 4e-15 up to h = 38, where they underflow.
    """

    std: float = field(metadata=parameter("sigma", "m", "standard deviation", above=0.0))
    mean: float = field(default=0.0, metadata=parameter("m", "m", "mean height"))

    _spread_name = "heights.std"

    def _standardised(self, height: float) -> float | None:
        return (height - self.mean) / self.std

    @property
    def spread(self) -> float:
        """Standard deviation of the heights [m]."""
        return self.std

    @property
    def span(self) -> tuple[float, float]:
        """Heights [m] between which practically all summits lie."""
        return self.mean - 10.0 * self.std, self.mean + 37.5 * self.std

    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        scaled = kernels.gaussian_moment((threshold - self.mean) / self.std, twice_order)
        return np.asarray(scaled * self.std ** (0.5 * twice_order))

    def _moment_at(self, twice_order: int, threshold: float) -> float:
        h = (threshold - self.mean) / self.std
        scale: float = self.std ** (0.5 * twice_order)
        return kernels.gaussian_moment_at(h, twice_order) * scale

    def _density(self, height: Floats) -> Floats:
        h = (height - self.mean) / self.std
        return np.asarray(np.exp(-0.5 * h * h) / (math.sqrt(2.0 * math.pi) * self.std))

    def _below(self, height: Floats) -> Floats:
        # By symmetry: the difference to one has no digits far below the mean.
        return np.asarray(kernels.gaussian_moment((self.mean - height) / self.std, 0))

    @classmethod
    def examples(cls) -> tuple[HeightDistribution, ...]:
        """Return a distribution of zero mean, and one of another mean."""
        return cls(std=5e-7), cls(std=2e-6, mean=1e-6)


@dataclass(frozen=True)
class Exponential(HeightDistribution):
    """Exponential summit heights y >= 0 with density exp(-y/scale)/scale.

    Parameters
    ----------
    scale : float
        Mean and standard deviation of the heights [m], above zero.

    Notes
    -----
    With h = threshold/scale, the partial moment of order n over scale^n is F_n = Gamma(n+1) exp(-h)
    for h >= 0. For h < 0 every summit is above the threshold, and F_n = exp(x) Gamma(n+1, x) with
    x = -h. With g(a) = exp(x) Gamma(a, x), it follows from g(1/2) = sqrt(pi) erfcx(sqrt(x)) or g(1)
    = 1 by the recurrence g(a+1) = a g(a) + x^a, whose terms are all positive (DLMF 8.8.2).
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
        """Heights [m] between which practically all summits lie."""
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
        """Return one distribution; a change of scale only scales the heights."""
        return (cls(scale=8e-7),)


def _incomplete(a: float, x: Floats) -> Floats:
    """Return exp(x) Gamma(a, x), upper incomplete, for a = 1/2, 1, 3/2 and so on, and x > 0."""
    if a % 1.0:
        with needed_for("exponential heights with all summits in contact need"):
            from scipy.special import erfcx  # here, since only heavy loads need SciPy

        power, value = 0.5, math.sqrt(math.pi) * erfcx(np.sqrt(x))
    else:
        power, value = 1.0, np.ones_like(x)
    while power < a:
        value = power * value + x**power
        power += 1.0
    return np.asarray(value)


@dataclass(frozen=True, eq=False)
class Discrete(Locked, HeightDistribution):
    """Individually given heights of equal probability: (19.5)-(19.8) become sums.

    Parameters
    ----------
    values : array_like
        Heights [m], one-dimensional, at least one.
    """

    values: ArrayLike = field(metadata=parameter("y_i", "m", "heights", many=True))

    def __post_init__(self) -> None:
        values = np.sort(record("heights", self.values, "m").reshape(-1))
        assign(self, values=lock(values))

    def __repr__(self) -> str:
        low, high = self.span
        return f"Discrete({np.size(self.values)} heights from {low:g} to {high:g})"

    # Each summit slips at its own place, whatever the others do.
    _spread_name = ""

    @property
    def spread(self) -> float:
        """Standard deviation of the heights [m]."""
        return float(np.std(np.asarray(self.values)))

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest summit [m]."""
        values = np.asarray(self.values)
        return float(values[0]), float(values[-1])

    @property
    def top(self) -> float:
        """Highest summit [m]."""
        return self.span[1]

    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        values = np.asarray(self.values)
        result = np.empty(threshold.shape)
        for index, t in np.ndenumerate(threshold):
            above = values[np.searchsorted(values, t, side="right") :] - t
            result[index] = np.sum(above ** (0.5 * twice_order)) / values.size
        return result

    def _density(self, height: Floats) -> Floats:
        raise InputError("a list of heights has no density; use its cdf")

    @classmethod
    def examples(cls) -> tuple[HeightDistribution, ...]:
        """Return a distribution of five heights."""
        return (cls([0.0, 2e-7, -3e-7, 5e-7, 1e-7]),)
