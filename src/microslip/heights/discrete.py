"""Heights given one by one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, record
from microslip._core.frozen import Locked, assign, lock
from microslip._core.parameters import parameter
from microslip.errors import InputError
from microslip.heights.base import HeightDistribution


@dataclass(frozen=True, eq=False)
class Discrete(Locked, HeightDistribution):
    """Measured heights as a distribution of equal atoms: (19.5)-(19.8) as sums.

    Parameters
    ----------
    values : array_like
        Heights [m], one-dimensional, at least one.
    """

    key = "values"

    values: ArrayLike = field(metadata=parameter("y_i", "m", "heights", many=True))

    def __post_init__(self) -> None:
        values = np.sort(record("heights", self.values).reshape(-1))
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
        """A handful of summits."""
        return (cls([0.0, 2e-7, -3e-7, 5e-7, 1e-7]),)
