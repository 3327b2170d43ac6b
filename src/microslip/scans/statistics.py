"""Floor 6: height parameters of a measured surface, and when they speak for few points only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip.errors import InputError
from microslip.friction.validity import Verdict, Word
from microslip.scans.moments import SUMMIT_SHARE, dot, lost_to_pixel, present

if TYPE_CHECKING:
    from microslip.scans.scan import Scan

Floats = NDArray[np.float64]

EXTREME = 0.001
"""Share of the points that count as the most extreme ones."""

GAUSSIAN_SHARE = 0.0127
"""Share of the variance that the most extreme 0.1 % of a Gaussian variable carry."""

LOST = 0.05
"""Share of m4 that finite differences may miss unsaid: waves of eight pixels lose as much."""

_BLOCK = 1 << 18


@dataclass(frozen=True)
class Statistics:
    """Height parameters of a scan, after ISO 25178-2:2021; of a profile, after ISO 21920-2:2021.

    Parameters
    ----------
    mean : float
        Mean height [m].
    rms : float
        Root mean square height Sq [m] about the mean.
    mean_deviation : float
        Mean absolute height Sa [m] about the mean.
    skewness : float
        Skewness Ssk [-]: 0 for a Gaussian surface, below it where plateaus prevail.
    kurtosis : float
        Kurtosis Sku [-]: 3 for a Gaussian surface.
    flatness : float
        From the lowest valley to the highest peak [m]: Sz.
    highest : float
        Height of the highest point above the mean [m]: Sp.
    count : int
        Points present.
    missing : float
        Share of points that are missing [-].
    """

    mean: float
    rms: float
    mean_deviation: float
    skewness: float
    kurtosis: float
    flatness: float
    highest: float
    count: int
    missing: float


class ExtremeShares(NamedTuple):
    """Share [-] of each moment that the most extreme 0.1 % of its values carry."""

    m0: float
    """Of the variance of heights; 0.013 if they are Gaussian."""
    m2: float
    """Of the mean square slope."""
    m4: float
    """Of the mean square curvature."""


def statistics_of(heights: Floats) -> Statistics:
    """Height parameters, as they are: level the heights first.

    Parameters
    ----------
    heights : ndarray
        Heights [m], NaN where missing.

    Returns
    -------
    Statistics
        Parameters of the points present.

    Raises
    ------
    InputError
        No heights, or heights that are all the same.
    """
    flat = heights.reshape(-1)
    parts = [flat[start : start + _BLOCK] for start in range(0, flat.size, _BLOCK)]
    count, total, low, high = 0, 0.0, math.inf, -math.inf
    for part in parts:
        own = present(part)
        if own.size:
            count, total = count + own.size, total + float(own.sum())
            low, high = min(low, float(own.min())), max(high, float(own.max()))
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


def extreme_shares(scan: Scan) -> ExtremeShares:
    """How much of each moment few points carry.

    Parameters
    ----------
    scan : Scan
        A scan, or a profile.

    Returns
    -------
    ExtremeShares
        Shares of m0, m2 and m4 in the largest 0.1 % of the heights (from their mean), slopes and
        curvatures; at least one value of each.

    Raises
    ------
    InputError
        Heights that are all the same or along a straight line; no three points in a row present.
    """
    heights = scan.heights
    scan.moments()  # says what is wrong with heights that have none
    shares = [_share([np.abs(heights - np.nanmean(heights))])]
    for order in (1, 2):
        axes = range(heights.ndim)
        steps = [scan.pixel[heights.ndim - 1 - axis] for axis in axes]
        shares.append(
            _share(
                [np.diff(heights, order, axis=axis) / steps[axis] ** order for axis in axes],
            )
        )
    return ExtremeShares(*shares)


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


def verdicts(scan: Scan) -> tuple[Verdict, ...]:
    """Whether moments describe the surface, or few points, noise or the lay of it.

    Parameters
    ----------
    scan : Scan
        A levelled scan, or a profile.

    Returns
    -------
    tuple of Verdict
        On kurtosis, on the shares of extreme points in heights, slopes and curvatures, on the
        slopes, on what the pixel takes from waves of few pixels, on Nayak's alpha (Nayak 1971,
        DOI 10.1115/1.3451608), on the lay and on missing points. The limits are conventions: a
        Gaussian isotropic surface that is well resolved is far within all of them.

    Raises
    ------
    InputError
        Heights that are all the same or along a straight line; no three points in a row present.
    """
    numbers, found = scan.statistics(), scan.moments()
    shares = extreme_shares(scan)
    result = [
        _judge(
            "kurtosis",
            numbers.kurtosis,
            4.0,
            6.0,
            "heights are near a Gaussian; far above 3, scratches, pits or spikes make the rms",
        ),
        *(
            _judge(
                f"share of {name} in 0.1 % of points",
                share,
                0.05,
                0.2,
                f"{what} are of the whole surface, not of a few points "
                f"({GAUSSIAN_SHARE:.3f} if Gaussian)",
            )
            for name, what, share in zip(
                ("m0", "m2", "m4"), ("heights", "slopes", "curvatures"), shares, strict=True
            )
        ),
        _judge(
            "rms slope",
            found.rms_slope,
            0.3,
            1.0,
            "slopes are small, as in all contact theory; far above, units are wrong or steps made "
            "them",
        ),
        pixel_verdict(scan),
        _judge(
            "0.8968 / alpha",
            SUMMIT_SHARE / found.nayak,
            SUMMIT_SHARE / 1.5,
            0.9,
            "Nayak's alpha is at least 1.5, as of an isotropic Gaussian surface",
        ),
        _judge("missing", numbers.missing, 0.02, 0.2, "the points present speak for all"),
    ]
    if not scan.is_profile:
        result.append(
            _judge(
                "anisotropy",
                found.anisotropy,
                1.5,
                3.0,
                "slopes are alike in all directions, as McCool's formulas have it",
            )
        )
    return tuple(result)


def pixel_verdict(scan: Scan) -> Verdict:
    """Whether curvatures are of waves that the pixel resolves.

    Parameters
    ----------
    scan : Scan
        A scan, or a profile, at its cut-off.

    Returns
    -------
    Verdict
        On the share of m4 that finite differences miss.
    """
    return _judge(
        "share of m4 lost to the pixel",
        lost_to_pixel(scan.heights, scan.pixel),
        LOST,
        0.25,
        "curvatures are of waves of eight pixels or more (0.56 for noise from point to point); "
        "else m4 and the number of summits come out low by about so much: choose a longer "
        "short-wave cut-off, or scan with a finer pixel",
    )


def _judge(name: str, value: float, limit: float, outside: float, meaning: str) -> Verdict:
    word: Word = "ok" if value <= limit else "watch" if value <= outside else "outside"
    return Verdict(name, value, limit, word, meaning)
