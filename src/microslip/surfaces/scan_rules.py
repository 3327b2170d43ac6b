"""Rules for the verdicts on scans, summits and height distributions."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from microslip._core.checks import Floats
from microslip._core.verdicts import Rule, Verdict
from microslip.surfaces.height_map import HeightMap
from microslip.surfaces.moments import SUMMIT_SHARE, lost_to_pixel

EXTREME = 0.001
"""Fraction of the points that count as extreme."""

GAUSSIAN_SHARE = 0.0127
"""Fraction of the variance of a Gaussian variable in its most extreme 0.1 %."""


def extreme_shares(scan: HeightMap) -> dict[str, float]:
    """Return the fractions [-] of m0, m2 and m4 that are due to 0.1 % of the points.

    These are the points with the largest absolute heights, slopes and curvatures, respectively.
    """
    heights = scan.heights
    scan.moments()  # raises an error for heights without moments
    shares = {"m0": share_of_heights(scan)}
    for order, name in ((1, "m2"), (2, "m4")):
        axes = range(heights.ndim)
        steps = [scan.pixel[heights.ndim - 1 - axis] for axis in axes]
        shares[name] = _share(
            [np.diff(heights, order, axis=axis) / steps[axis] ** order for axis in axes]
        )
    return shares


def share_of_heights(scan: HeightMap) -> float:
    """Return the fraction [-] of the height variance due to the 0.1 % most extreme points."""
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


LOST_TO_PIXEL = "fraction of m4 lost to the pixel"
RADIUS_IN_PIXELS = "summit radius in pixels"

_CONVENTION = "a convention; well-resolved isotropic Gaussian surfaces are far within the limit"


def _share_rule(moment: str, values: str) -> Rule:
    return Rule(
        f"fraction of {moment} in 0.1 % of points",
        0.05,
        0.2,
        f"{values} represent the whole surface, not a few points ({GAUSSIAN_SHARE:.3f} if "
        "Gaussian)",
        _CONVENTION,
        "remove the extreme points, or scan an area without scratches",
    )


_RULES: Mapping[str, Rule] = {
    rule.name: rule
    for rule in (
        # Verdicts on the heights.
        Rule(
            "kurtosis",
            4.0,
            6.0,
            "heights are nearly Gaussian, also before any filter; far above 3, scratches, pits or "
            "spikes dominate the rms",
            _CONVENTION,
            "remove the extreme points, and use counted summits",
        ),
        _share_rule("m0", "heights"),
        _share_rule("m2", "slopes"),
        _share_rule("m4", "curvatures"),
        Rule(
            "rms slope",
            0.3,
            1.0,
            "slopes are small, as contact theory assumes; far larger slopes come from wrong "
            "units or from steps",
            _CONVENTION,
            "check the units of heights and pixel",
        ),
        Rule(
            LOST_TO_PIXEL,
            0.05,
            0.25,
            "curvatures come from waves of eight pixels or more (0.56 for point-to-point noise); "
            "otherwise m4 and the number of summits are too low by about this fraction",
            "waves of eight pixels lose 5 % of their m4 to finite differences",
            "choose a longer short-wave cut-off, or scan with a finer pixel",
        ),
        Rule(
            "0.8968 / alpha",
            SUMMIT_SHARE / 1.5,
            0.9,
            "Nayak's alpha is at least 1.5, as for an isotropic Gaussian surface",
            "Nayak (1971), DOI 10.1115/1.3451608",
            "use counted summits",
        ),
        Rule(
            "missing",
            0.005,
            0.2,
            "measured points represent the surface; filled points count as missing",
            "gaps of 0.2 % moved m2 of a scan by 4 %, filled or not: 0.5 % by a tenth",
            "scan again, or estimate the error from the parameters with and without filling",
        ),
        Rule(
            "anisotropy",
            1.5,
            3.0,
            "slopes are equal in all directions, as McCool's formulas assume",
            _CONVENTION,
            "use counted summits",
            missing="a profile has one direction only",
        ),
        # Verdicts on the summits.
        Rule(
            RADIUS_IN_PIXELS,
            5.0,
            2.0,
            "the radius is more than a few pixels, so that slopes are small and caps are resolved",
            _CONVENTION,
            "choose a longer short-wave cut-off, or scan with a finer pixel",
        ),
        Rule(
            "summit spacing in pixels",
            8.0,
            5.0,
            "summits are features of the surface and not of the pixel; the value for noise is 3",
            "white noise has a peak in every nine pixels, at a mean spacing of three",
            "choose a longer short-wave cut-off, or scan with a finer pixel",
        ),
        Rule(
            "summit spacing over cut-off",
            2.0,
            1.2,
            "summits are features of the surface and not of the filter; the value for filtered "
            "noise is 0.87",
            "summits of white noise after a Gaussian filter are 0.87 cut-offs apart",
            "choose another short-wave cut-off",
        ),
        Rule(
            "summits",
            30.0,
            10.0,
            "there are enough summits for statistics",
            "means over fewer summits scatter by 20 % and more",
            "scan a larger area",
        ),
        Rule(
            "kurtosis of the heights",
            6.0,
            20.0,
            "no scratch or spike dominates the moments; Gaussian heights have 3",
            _CONVENTION,
            "remove the extreme points",
        ),
        Rule(
            "radius by load over radius by curvature",
            1.6,
            3.0,
            "one radius represents all summits; on a Gaussian surface the ratio is 1.28",
            "Nayak (1971), DOI 10.1115/1.3451608: 1.277 on an isotropic Gaussian surface",
            "use the summits as a population",
        ),
        Rule(
            "fraction of peaks below the prominence",
            0.05,
            1.0,
            "few peaks are below the prominence; they may be noise or short waves, which a "
            "single scan cannot distinguish",
            _CONVENTION,
            "choose the prominence from the repeatability of the instrument",
        ),
        Rule(
            "peaks dropped for noise that is roughness",
            0.05,
            0.3,
            "peaks dropped as noise are noise: equally large over one, two and four pixels",
            "differences of white noise do not depend on distance, those of roughness grow",
            "set the prominence to the repeatability of the instrument",
        ),
        Rule(
            "fraction of fits dropped",
            0.1,
            0.3,
            "peaks are round enough to be summits",
            _CONVENTION,
            "choose a longer short-wave cut-off",
        ),
    )
}
"""Rules by name."""


def judged(values: Mapping[str, float | None]) -> tuple[Verdict, ...]:
    """Return the verdicts on values given by rule name; a value of None is not judged."""
    return tuple(_RULES[name].judge(value) for name, value in values.items())


def verdicts(scan: HeightMap) -> tuple[Verdict, ...]:
    """Return verdicts on whether outliers, noise or lay dominate the moments of a scan.

    Kurtosis and extreme heights are taken from the scan or from the scan before filling and
    filtering, whichever is worse. The limits are conventions.
    """
    numbers, moments = scan.statistics(), scan.moments()
    raw = scan.unfiltered
    before = raw.statistics()
    shares = extreme_shares(scan)
    # A filter spreads spikes until they cannot be detected, and filled gaps are not measured.
    shares["m0"] = max(shares["m0"], share_of_heights(raw))
    values: dict[str, float | None] = {"kurtosis": max(numbers.kurtosis, before.kurtosis)}
    values |= {f"fraction of {moment} in 0.1 % of points": part for moment, part in shares.items()}
    values |= {
        "rms slope": moments.rms_slope,
        LOST_TO_PIXEL: lost_to_pixel(scan.heights, scan.pixel),
        "0.8968 / alpha": SUMMIT_SHARE / moments.nayak,
        "missing": before.missing,
    }
    if not scan.is_profile:
        values["anisotropy"] = moments.anisotropy
    return judged(values)


def radius_in_pixels(radius: float, pixel: tuple[float, ...]) -> dict[str, float | None]:
    """Return the summit radius over the pixel, by the name of its rule.

    For pixels of different sides it is the radius over their geometric mean.
    """
    side = 1.0
    for step in pixel:
        side *= step ** (1.0 / len(pixel))
    return {RADIUS_IN_PIXELS: radius / side}
