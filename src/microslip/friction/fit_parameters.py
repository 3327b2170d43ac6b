"""Search ranges of the parameters of a law in fits."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from microslip._core.parameters import Number, parameters_of

_KEY = "microslip fit"
# Search ranges of positive parameters by unit.
_SEARCHED = {"N": (1e-12, 1e12), "N/m": (1e-6, 1e15), "m": (1e-13, 1e-1)}


@dataclass(frozen=True)
class FitParameter(Number):
    """Parameter of a law with its search range in fits."""

    search: tuple[float, float] | None = None
    """Search range (lowest, highest) of a fit; by default the allowed range."""
    log: bool | None = None
    """Fit the logarithm. By default True for positive parameters with a unit."""
    beyond: bool = False
    """True if real joints may have values outside ``search``, which only limits the search."""
    natural: bool = False
    """True if the lower end of the range is a physical value, at which a fit may end."""

    @property
    def is_log(self) -> bool:
        """True if the logarithm is fitted."""
        return self.is_positive and self.unit != "" if self.log is None else self.log

    @property
    def low(self) -> float:
        """Lower end of the search range."""
        return self._searched[0]

    @property
    def high(self) -> float:
        """Upper end of the search range."""
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
        # Keep a small distance from the ends of an open range.
        step = 1e-6 * max(1.0, abs(self.above)) if math.isfinite(self.above) else 0.0
        low = max(low, self.least, self.above + step if not self.is_positive else low)
        last = 1e-6 * max(1.0, abs(self.below)) if math.isfinite(self.below) else 0.0
        return low, min(high, self.most, self.below - last)


def fit_range(low: float, high: float, *, log: bool | None = None) -> dict[str, Any]:
    """Return field metadata with the search range of a parameter in fits.

    Combine it with the declaration: ``field(metadata=parameter(...) | fit_range(0.0, 1.0))``.
    """
    return {_KEY: {"search": (low, high), "log": log}}


@lru_cache(maxsize=256)
def fit_parameters_of(kind: Any) -> tuple[FitParameter, ...]:
    """Return the parameters of a class with their search ranges."""
    ranges = {item.name: item.metadata.get(_KEY, {}) for item in dataclasses.fields(kind)}
    return tuple(FitParameter(**vars(item), **ranges[item.name]) for item in parameters_of(kind))
