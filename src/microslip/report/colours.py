"""Values on a grid as colours."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_MOST_PIXELS = 700
_MISSING = 255  # white
# Even steps of cividis (Nuñez, Anderton and Renslow 2018, DOI 10.1371/journal.pone.0199239), made
# for the colour-blind; its lightness rises evenly.
_COLOURS = np.array(
    (
        (0, 34, 78), (0, 46, 106), (26, 56, 111), (50, 67, 109), (67, 78, 108), (83, 90, 109),
        (97, 101, 111), (111, 112, 115), (125, 124, 120), (140, 136, 120), (155, 148, 118),
        (171, 160, 114), (188, 174, 108), (205, 187, 99), (222, 201, 88), (240, 216, 70),
        (254, 232, 56),
    ),
    dtype=float,
)  # fmt: skip


def coloured(heights: Floats, low: float, high: float) -> NDArray[np.uint8]:
    """Heights as colours; what is beyond the ends has their colour, what is missing is white."""
    place = np.clip((heights - low) / (high - low if high > low else 1.0), 0.0, 1.0)
    missing = np.isnan(place)
    steps = np.arange(len(_COLOURS)) / (len(_COLOURS) - 1.0)
    table = np.stack([np.interp(np.arange(256) / 255.0, steps, c) for c in _COLOURS.T], axis=1)
    result: NDArray[np.uint8] = np.rint(table).astype(np.uint8)[
        np.where(missing, 0, np.rint(255.0 * np.nan_to_num(place))).astype(np.intp)
    ]
    result[missing] = _MISSING
    return result


def coarse(heights: Floats) -> Floats:
    """Every so many points; the mean of each block would round the summits off."""
    step = max(1, math.ceil(max(heights.shape) / _MOST_PIXELS))
    return heights[::step, ::step]
