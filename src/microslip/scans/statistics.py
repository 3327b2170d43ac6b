"""Height parameters of a measured surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.scans.moments import dot, present

_BLOCK = 1 << 18


@dataclass(frozen=True)
class Statistics:
    """Height parameters of a scan, after ISO 25178-2:2021; of a profile, after ISO 21920-2:2021."""

    mean: float
    """Mean height [m]."""
    rms: float
    """Root mean square height Sq [m] about the mean."""
    mean_deviation: float
    """Mean absolute height Sa [m] about the mean."""
    skewness: float
    """Skewness Ssk [-]: 0 for a Gaussian surface, below it where plateaus prevail."""
    kurtosis: float
    """Kurtosis Sku [-]: 3 for a Gaussian surface."""
    flatness: float
    """From the lowest valley to the highest peak [m]: Sz."""
    highest: float
    """Height of the highest point above the mean [m]: Sp."""
    count: int
    """Points present."""
    missing: float
    """Share of points that are missing [-]."""


def statistics_of(heights: Floats) -> Statistics:
    """Height parameters, as they are: level the heights first."""
    flat = heights.reshape(-1)
    parts = [flat[start : start + _BLOCK] for start in range(0, flat.size, _BLOCK)]
    count, total, low, high = 0, 0.0, math.inf, -math.inf
    for part in parts:
        values = present(part)
        if values.size:
            count, total = count + values.size, total + float(values.sum())
            low, high = min(low, float(values.min())), max(high, float(values.max()))
    # No spread means one height for all: the sums below would be rounding only.
    if not high > low:
        raise InputError(f"the heights must vary, got {count} that are all the same")
    mean = total / count
    scale = high - low  # so that fourth powers stay in range
    sums = np.zeros(4)
    for part in parts:
        off = (present(part) - mean) / scale
        square = off * off
        sums += (np.abs(off).sum(), square.sum(), dot(square, off), dot(square, square))
    deviation, second, third, fourth = (float(value) / count for value in sums)
    return Statistics(
        mean=mean,
        rms=math.sqrt(second) * scale,
        mean_deviation=deviation * scale,
        skewness=third / second**1.5,
        kurtosis=fourth / (second * second),
        flatness=scale,
        highest=high - mean,
        count=count,
        missing=1.0 - count / flat.size,
    )
