"""Rules by which scans, their summits and their height distributions are judged, as data."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from microslip._core.checks import Floats
from microslip._core.verdicts import Rule, Verdict
from microslip.surfaces.height_map import HeightMap
from microslip.surfaces.moments import SUMMIT_SHARE, lost_to_pixel

EXTREME = 0.001
"""Share of the points that count as the most extreme ones."""

GAUSSIAN_SHARE = 0.0127
"""Share of the variance that the most extreme 0.1 % of a Gaussian variable carry."""


def extreme_shares(scan: HeightMap) -> dict[str, float]:
    """Return the share [-] of m0, m2 and m4 that the most extreme 0.1 % of their values carry."""
    heights = scan.heights
    scan.moments()  # raises an error for heights that have no moments
    shares = {"m0": share_of_heights(scan)}
    for order, name in ((1, "m2"), (2, "m4")):
        axes = range(heights.ndim)
        steps = [scan.pixel[heights.ndim - 1 - axis] for axis in axes]
        shares[name] = _share(
            [np.diff(heights, order, axis=axis) / steps[axis] ** order for axis in axes]
        )
    return shares


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


LOST_TO_PIXEL = "share of m4 lost to the pixel"
RADIUS_IN_PIXELS = "summit radius in pixels"

_CONVENTION = "a convention of this project: a resolved Gaussian isotropic surface is far within it"


def _share_rule(moment: str, values: str) -> Rule:
    return Rule(
        f"share of {moment} in 0.1 % of points",
        0.05,
        0.2,
        f"{values} are of the whole surface, not of a few points ({GAUSSIAN_SHARE:.3f} if "
        "Gaussian)",
        _CONVENTION,
        "leave the extreme points out, or scan a place without scratches",
    )


RULES: Mapping[str, Rule] = {
    rule.name: rule
    for rule in (
        # Verdicts on the heights.
        Rule(
            "kurtosis",
            4.0,
            6.0,
            "heights are near a Gaussian, before any filter, too; far above 3, scratches, pits or "
            "spikes make the rms",
            _CONVENTION,
            "leave the extreme points out, and use counted summits",
        ),
        _share_rule("m0", "heights"),
        _share_rule("m2", "slopes"),
        _share_rule("m4", "curvatures"),
        Rule(
            "rms slope",
            0.3,
            1.0,
            "slopes are small, as in all contact theory; far above, units are wrong or steps made "
            "them",
            _CONVENTION,
            "check the units of heights and pixel",
        ),
        Rule(
            LOST_TO_PIXEL,
            0.05,
            0.25,
            "curvatures are of waves of eight pixels or more (0.56 for noise from point to point); "
            "else m4 and the number of summits come out low by about so much: choose a longer "
            "short-wave cut-off, or scan with a finer pixel",
            "waves of eight pixels lose 5 % of their m4 to finite differences",
            "choose a longer short-wave cut-off, or scan with a finer pixel",
        ),
        Rule(
            "0.8968 / alpha",
            SUMMIT_SHARE / 1.5,
            0.9,
            "Nayak's alpha is at least 1.5, as of an isotropic Gaussian surface",
            "Nayak (1971), DOI 10.1115/1.3451608",
            "use counted summits",
        ),
        Rule(
            "missing",
            0.005,
            0.2,
            "the measured points represent all; filled points count as missing",
            "gaps of 0.2 % moved m2 of a scan by 4 %, filled or not: 0.5 % by a tenth",
            "scan again, or take the parameters with and without filling for their error",
        ),
        Rule(
            "anisotropy",
            1.5,
            3.0,
            "slopes are alike in all directions, as McCool's formulas assume",
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
            "summits are features of the surface and not of the pixel, at which noise has one in 3",
            "white noise has a peak in every nine pixels, at a mean spacing of three",
            "choose a longer short-wave cut-off, or scan with a finer pixel",
        ),
        Rule(
            "summit spacing over cut-off",
            2.0,
            1.2,
            "summits are features of the surface and not of the filter, behind which noise has "
            "0.87",
            "white noise behind a Gaussian filter has its summits 0.87 cut-offs apart",
            "choose another short-wave cut-off",
        ),
        Rule(
            "summits",
            30.0,
            10.0,
            "summits are enough for statistics",
            "a mean over fewer scatters by a fifth and more",
            "scan a larger area",
        ),
        Rule(
            "kurtosis of the heights",
            6.0,
            20.0,
            "no scratch or spike dominates the moments; Gaussian heights have 3",
            _CONVENTION,
            "leave the extreme points out",
        ),
        Rule(
            "radius by load over radius by curvature",
            1.6,
            3.0,
            "one radius represents all summits; on a Gaussian surface the ratio is 1.28",
            "Nayak (1971), DOI 10.1115/1.3451608: 1.277 on an isotropic Gaussian surface",
            "take the summits one by one, as a population",
        ),
        Rule(
            "share of peaks below the prominence",
            0.05,
            1.0,
            "hardly a peak is below the prominence; those that are may be noise, or waves of a few "
            "pixels that a smaller prominence counts: a scan cannot distinguish them",
            _CONVENTION,
            "choose the prominence from what the instrument repeats",
        ),
        Rule(
            "peaks dropped for noise that is roughness",
            0.05,
            0.3,
            "what is dropped as noise is noise: as large over two and four pixels as over one",
            "differences of white noise are alike over any distance, those of roughness grow",
            "give the prominence that the instrument repeats",
        ),
        Rule(
            "share of fits dropped",
            0.1,
            0.3,
            "peaks are round enough to be summits",
            _CONVENTION,
            "choose a longer short-wave cut-off",
        ),
    )
}
"""Every rule by its name. What a limit stands on is its reason."""


def judged(values: Mapping[str, float | None]) -> tuple[Verdict, ...]:
    """Verdicts on values, by the names of their rules; None is not judged."""
    return tuple(RULES[name].judge(value) for name, value in values.items())


def verdicts(scan: HeightMap) -> tuple[Verdict, ...]:
    """Whether moments describe a levelled surface, or few points, noise or the lay of it.

    On kurtosis and extreme heights, of the scan as it is and before anything was filled or
    filtered, whichever is worse; on missing points before that; on the shares of extreme
    slopes and curvatures, on slopes, on what the pixel takes from waves of few pixels, on
    Nayak's alpha (Nayak 1971, DOI 10.1115/1.3451608) and on the lay. The limits are
    conventions: a Gaussian isotropic surface that is well resolved is far within all of them.
    """
    numbers, moments = scan.statistics(), scan.moments()
    raw = scan.unfiltered
    before = raw.statistics()
    shares = extreme_shares(scan)
    # A filter spreads spikes until they cannot be detected, and filled gaps are not measured.
    shares["m0"] = max(shares["m0"], share_of_heights(raw))
    values: dict[str, float | None] = {"kurtosis": max(numbers.kurtosis, before.kurtosis)}
    values |= {f"share of {moment} in 0.1 % of points": part for moment, part in shares.items()}
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
    """The value of that rule: how far a radius is one of the surface, not of the pixel."""
    side = 1.0
    for step in pixel:
        side *= step ** (1.0 / len(pixel))
    return {RADIUS_IN_PIXELS: radius / side}
