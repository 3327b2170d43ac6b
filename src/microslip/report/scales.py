"""Which prefix numbers that stand together share, and which of many are shown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.units import prefix


def evenly(count: int, limit: int) -> list[int]:
    """Indices of at most `limit` of `count` things, evenly, the first and the last among them."""
    size = min(count, limit)
    if size < 2:
        return list(range(size))
    return sorted({round(i * (count - 1) / (size - 1)) for i in range(size)})


def length_prefix(largest: float, smallest: float = 0.0) -> tuple[float, str]:
    """Micrometres wherever they suit lengths [m], since those of joints are read in them."""
    return (1e-6, "µ") if largest > 1e-7 and (smallest or largest) < 1e-3 else prefix(largest)


def force_prefix(values: ArrayLike) -> tuple[float, str]:
    """Prefix for values that may all be zero."""
    largest = float(np.abs(values).max(initial=0.0))
    return prefix(largest) if largest > 0.0 else (1.0, "")


def common_prefix(values: Sequence[float]) -> tuple[float, str]:
    """Prefix of the largest value, or none where the others are too far below it."""
    return (1.0, "") if far_apart(values, 1e4) else prefix(max(values))


def far_apart(values: Sequence[float], factor: float = 20.0) -> bool:
    """Whether positive values are too far apart for one linear axis."""
    return max(values) > factor * min(values)
