"""Floor 6: how much of a scan is noise from one point to the next."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.scans.filters import weights

_BLOCK = 1 << 20  # points a pass


def noise_std(heights: Floats) -> float:
    """Standard deviation of the noise that differs from point to point, from fourth differences.

    Second differences along x of second differences along y leave nothing of a form whose height
    is a sum of a cubic in x, one in y and xy; white noise they make six times as high. Their
    median size is taken, which single spikes and scratches do not move.
    """
    if min(heights.shape) < 3:
        return 0.0
    # Whole rows in even steps: a million points tell a median well enough.
    step = max(1, heights.size // _BLOCK)
    middle = np.arange(1, heights.shape[0] - 1, step)
    across = heights[middle - 1] - 2.0 * heights[middle] + heights[middle + 1]
    both = np.abs(across[:, 2:] - 2.0 * across[:, 1:-1] + across[:, :-2])
    both = both[~np.isnan(both)]
    return float(np.median(both)) / 0.6744897501960817 / 6.0 if both.size else 0.0


def noise_passed(std: float, pixel: tuple[float, ...], cutoff: float | None) -> float:
    """Standard deviation [m] of white noise of ``std`` [m] behind the Gaussian filter."""
    if cutoff is None:
        return std
    return std * math.prod(float(np.linalg.norm(weights(cutoff / step))) for step in pixel)


def present(heights: Floats, reach: int) -> NDArray[np.bool_]:
    """Points all of whose neighbours up to ``reach`` points away are there and not missing."""
    rows, columns = heights.shape
    result = np.zeros(heights.shape, dtype=bool)
    inner = result[reach : rows - reach, reach : columns - reach]
    if inner.size == 0:
        return result
    there = ~np.isnan(heights)
    inner[:] = True
    if there.all():
        return result
    # A square is a row of columns.
    width = 2 * reach + 1
    along = np.ones((rows, columns - 2 * reach), dtype=bool)
    for k in range(width):
        along &= there[:, k : k + columns - 2 * reach]
    for k in range(width):
        inner &= along[k : k + rows - 2 * reach]
    return result
