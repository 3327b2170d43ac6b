"""Share of the moments of a surface carried by few points."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.scans.height_map import HeightMap

EXTREME = 0.001
"""Share of the points that count as the most extreme ones."""

GAUSSIAN_SHARE = 0.0127
"""Share of the variance that the most extreme 0.1 % of a Gaussian variable carry."""


class ExtremeShares(NamedTuple):
    """Share [-] of each moment that the most extreme 0.1 % of its values carry."""

    m0: float
    """Share of the variance of heights; 0.013 if they are Gaussian."""
    m2: float
    """Share of the mean square slope."""
    m4: float
    """Share of the mean square curvature."""


def extreme_shares(scan: HeightMap) -> ExtremeShares:
    """Share of each moment carried by few points."""
    heights = scan.heights
    scan.moments()  # says what is wrong with heights that have none
    shares = [share_of_heights(scan)]
    for order in (1, 2):
        axes = range(heights.ndim)
        steps = [scan.pixel[heights.ndim - 1 - axis] for axis in axes]
        shares.append(
            _share(
                [np.diff(heights, order, axis=axis) / steps[axis] ** order for axis in axes],
            )
        )
    return ExtremeShares(*shares)


def share_of_heights(scan: HeightMap) -> float:
    """Share of the variance of the heights alone."""
    return _share([np.abs(scan.heights - np.nanmean(scan.heights))])


def _share(groups: list[Floats]) -> float:
    top, total = 0.0, 0.0
    for values in groups:
        square = values.reshape(-1)
        square = square[~np.isnan(square)]
        square *= square
        if not square.size:
            continue
        count = max(1, math.ceil(EXTREME * square.size))
        square.partition(square.size - count)
        top += float(square[-count:].sum())
        total += float(square.sum())
    return top / total
