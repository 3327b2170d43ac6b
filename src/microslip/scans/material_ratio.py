"""The material ratio curve, and what ISO 21920-2 and ISO 25178-2 read from it."""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import parameter

_SECANT_SHARE = 0.4
"""Share of the points over which the secant of the core is drawn."""
_PEAKS, _DALES = 0.1, 0.8
"""Material ratios that bound the core of the volume parameters (ISO 25178-3)."""


def of(symbol: str, unit: str, meaning: str) -> Any:
    """A field that says what its parameter is."""
    return field(metadata=parameter(symbol, unit, meaning))


def core_of(heights: Floats) -> tuple[float, float, float, float, float]:
    """Sk, Spk, Svk, Smr1, Smr2 by the flattest secant over 40 % of the material ratio curve."""
    curve = np.sort(heights)[::-1]  # heights against the share of points that are higher
    count = curve.size
    width = min(max(round(_SECANT_SHARE * count), 1), count - 1)
    drop = curve[:-width] - curve[width:]
    # Of secants that are as flat the middle one, as of a straight curve.
    flat = np.flatnonzero(drop <= drop.min() * (1.0 + 1e-12))
    start = int(flat[flat.size // 2])
    # The equivalent straight line: least squares through the points of that part.
    places = np.arange(start, start + width + 1)
    part = curve[places]
    mean_place, mean = places.mean(), part.mean()
    spread = places - mean_place
    slope = float(spread @ (part - mean) / (spread @ spread))
    top = mean - slope * (mean_place + 0.5)
    bottom = mean + slope * (count - 0.5 - mean_place)
    core = top - bottom
    above, below = curve > top, curve < bottom
    first, last = np.count_nonzero(above) / count, 1.0 - np.count_nonzero(below) / count
    # Triangles of the same area as what sticks out, on the same share of points.
    peaks = 2.0 * float((curve[above] - top).sum()) / count / first if first > 0.0 else 0.0
    dales = 2.0 * float((bottom - curve[below]).sum()) / count / (1.0 - last) if last < 1.0 else 0.0
    return float(core), float(peaks), float(dales), float(first), float(last)


def volumes_of(heights: Floats) -> tuple[float, float, float, float]:
    """Vmp, Vmc, Vvc, Vvv [m^3/m^2]: material above and voids below heights of 10 and 80 %."""
    at = [float(np.quantile(heights, 1.0 - ratio)) for ratio in (_PEAKS, _DALES)]
    material = [float(np.maximum(heights - height, 0.0).mean()) for height in at]
    voids = [float(np.maximum(height - heights, 0.0).mean()) for height in at]
    return material[0], material[1] - material[0], voids[0] - voids[1], voids[1]
