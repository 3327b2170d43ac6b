"""Noise of a scan from one point to the next."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.scans.filters import weights

_BLOCK = 1 << 20  # points a pass


def noise_std(heights: Floats, step: int = 1) -> float:
    """Standard deviation of the noise that differs from point to point, from fourth differences.

    Second differences along x of second differences along y leave nothing of a form whose height
    is a sum of a cubic in x, one in y and xy; white noise they make six times as high. Their
    median size is taken, which single spikes and scratches do not move. Differences are over
    ``step`` points: of noise they are all alike.
    """
    if min(heights.shape) < 2 * step + 1:
        return 0.0
    # Whole rows in even steps: a million points are enough for a median.
    middle = np.arange(step, heights.shape[0] - step, max(1, heights.size // _BLOCK))
    across = heights[middle - step] - 2.0 * heights[middle] + heights[middle + step]
    bends = np.abs(across[:, 2 * step :] - 2.0 * across[:, step:-step] + across[:, : -2 * step])
    bends = bends[~np.isnan(bends)]
    return float(np.median(bends)) / 0.6744897501960817 / 6.0 if bends.size else 0.0


def rough_share(heights: Floats) -> float:
    """Share of the noise's variance that is roughness: it grows with the step of the differences.

    Of white noise v(1) = v(2) = v(4). What is more at longer steps is taken for a power of the
    step, and that power continued to the step of one.
    """
    first, second, fourth = (noise_std(heights, step) ** 2 for step in (1, 2, 4))
    if not second > first > 0.0:
        return 0.0
    growth = max(fourth - second, 0.0) / (second - first)
    power = min(max(growth, math.sqrt(2.0)), 256.0)  # of a rough surface to a smooth one
    return min((second - first) / (power - 1.0) / first, 1.0)


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
