"""Ranges in which fits search the parameters of a law."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from microslip._core.parameters import Number, parameters_of

_KEY = "microslip fit"
# Search ranges of positive values by their unit.
_SEARCHED = {"N": (1e-12, 1e12), "N/m": (1e-6, 1e15), "m": (1e-13, 1e-1)}


@dataclass(frozen=True)
class FitParameter(Number):
    """A parameter of a law with the range in which a fit searches it."""

    search: tuple[float, float] | None = None
    """Lowest and highest value of a fit; by default all that is allowed."""
    log: bool | None = None
    """Whether it is fitted as its logarithm; by default positive values with a unit are."""
    beyond: bool = False
    """Whether joints have values outside ``search``, which only limits the search."""
    natural: bool = False
    """Whether joints have the value at its lower end, so that a fit may end there."""

    @property
    def is_log(self) -> bool:
        """Whether it is fitted as its logarithm."""
        return self.is_positive and self.unit != "" if self.log is None else self.log

    @property
    def low(self) -> float:
        """Lower end of the search."""
        return self._searched[0]

    @property
    def high(self) -> float:
        """Upper end of the search."""
        return self._searched[1]

    @property
    def _searched(self) -> tuple[float, float]:
        if self.search is not None:
            return self.search
        if self.is_positive and self.unit in _SEARCHED:
            low, high = _SEARCHED[self.unit]
        elif self.is_positive:
            low, high = 1e-6, 1e6 if self.unit == "" else 1e30
        else:
            low, high = -1e6, 1e6
        # The ends of an open range are excluded by a small distance.
        step = 1e-6 * max(1.0, abs(self.above)) if math.isfinite(self.above) else 0.0
        low = max(low, self.least, self.above + step if not self.is_positive else low)
        last = 1e-6 * max(1.0, abs(self.below)) if math.isfinite(self.below) else 0.0
        return low, min(high, self.most, self.below - last)


def fit_range(low: float, high: float, *, log: bool | None = None) -> dict[str, Any]:
    """Return metadata of a field for the range in which fits search it.

    It stands beside the declared number: ``field(metadata=parameter(...) | fit_range(0.0, 1.0))``.
    """
    return {_KEY: {"search": (low, high), "log": log}}


@lru_cache(maxsize=256)
def fit_parameters_of(kind: Any) -> tuple[FitParameter, ...]:
    """Return the parameters of a class with the ranges in which fits search them."""
    ranges = {item.name: item.metadata.get(_KEY, {}) for item in dataclasses.fields(kind)}
    return tuple(FitParameter(**vars(item), **ranges[item.name]) for item in parameters_of(kind))
