"""Floor 6: from the summits of a scan to a rough surface, and how far to trust it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import positive, show
from microslip._core.units import AREA, QuantityError, to_si
from microslip._core.wording import quoted
from microslip.errors import InputError
from microslip.friction import Interface, Verdict
from microslip.heights import Discrete, Gaussian, HeightDistribution, TabulatedHeights
from microslip.materials import MaterialPair
from microslip.normal import AsperityPopulation, GreenwoodWilliamson
from microslip.scans.parameters import SummitStatistics
from microslip.scans.statistics import pixel_verdict
from microslip.scans.summit_set import ESTIMATES

if TYPE_CHECKING:
    from microslip.scans.scan import Scan
    from microslip.scans.summit_set import Summits

LARGEST_POPULATION = 2_000_000
"""Summits that a population is made of at most."""


def from_statistics(
    statistics: SummitStatistics, pair: MaterialPair, area: Any, heights: Any = "gaussian"
) -> GreenwoodWilliamson:
    """The surface of :meth:`SummitStatistics.to_surface`, which tells its parameters.

    Parameters
    ----------
    statistics : SummitStatistics
        Density, radius and spread.
    pair : MaterialPair
        The two materials.
    area : float or str
        Apparent area [m^2], or such as "2 cm^2".
    heights : {"gaussian"} or HeightDistribution
        Law of the summit heights.

    Returns
    -------
    GreenwoodWilliamson
        The surface; its heights are measured from the mean plane.

    Raises
    ------
    InputError
        As there.
    """
    area = area_of(area)
    if isinstance(heights, str) and heights == "gaussian":
        if statistics.std <= 0.0:
            raise InputError(
                "std of the summit heights must be above zero for Gaussian heights; for equal "
                'heights use heights="discrete" of Summits, or heights=ms.Discrete([z])'
            )
        heights = Gaussian(statistics.std, statistics.mean_height)
    elif not isinstance(heights, HeightDistribution):
        raise InputError(
            f'heights must be "gaussian" or a height distribution, got {show(heights)}; the '
            "heights one by one are known to Summits only"
        )
    return GreenwoodWilliamson(pair, heights, statistics.radius, statistics.density, area)


def surface_of(
    summits: Summits,
    pair: MaterialPair,
    area: Any = None,
    estimate: Any = "counted",
    heights: Any = "gaussian",
) -> GreenwoodWilliamson | AsperityPopulation:
    """The surface of :meth:`Summits.to_surface`, which tells its parameters.

    Parameters
    ----------
    summits : Summits
        The summits.
    pair : MaterialPair
        The two materials.
    area : float or str, optional
        Apparent area [m^2].
    estimate : str
        One of the estimates, or "population".
    heights : str or HeightDistribution
        Law of the summit heights.

    Returns
    -------
    GreenwoodWilliamson or AsperityPopulation
        The surface.

    Raises
    ------
    InputError
        As there.
    """
    area = summits.scan.area if area is None else area_of(area)
    if estimate == "population":
        if heights != "gaussian":
            raise InputError(
                f"heights must be left out for a population, which has its own, got {show(heights)}"
            )
        return _population(summits, pair, area)
    if estimate not in ESTIMATES:
        words = quoted((*ESTIMATES, "population"))
        raise InputError(f"estimate must be one of {words}, got {show(estimate)}")
    statistics = summits.statistics(estimate)
    law = heights
    if isinstance(heights, str) and heights == "discrete":
        law = Discrete(summits.heights)
    elif isinstance(heights, str) and heights == "table":
        law = TabulatedHeights.from_samples(summits.heights)
    elif not isinstance(heights, HeightDistribution) and heights != "gaussian":
        raise InputError(
            f'heights must be "gaussian", "discrete", "table" or a height distribution, got '
            f"{show(heights)}"
        )
    return from_statistics(statistics, pair, area, law)


def area_of(given: Any) -> float:
    """Apparent area [m^2], from a number in square metres or text such as "2 cm^2"."""
    if isinstance(given, str):
        try:
            return to_si(given, AREA, "2 cm^2")
        except QuantityError as error:
            raise InputError(f"area: {error}") from None
    return positive("area", given, "m^2", 1e-4)


def _population(summits: Summits, pair: MaterialPair, area: float) -> AsperityPopulation:
    wanted = summits.density * area
    if wanted > LARGEST_POPULATION:
        raise InputError(
            f"a population must be of at most {LARGEST_POPULATION} summits, got {wanted:.3g} on "
            f'{area:g} m^2: use estimate="counted" with heights="discrete", which weighs the same '
            "heights, or a smaller area"
        )
    if wanted < 0.5:
        raise InputError(
            f"area must hold at least one summit, {1.0 / summits.density:.3g} m^2, got {area:g} m^2"
        )
    chosen = resample(summits.heights, round(wanted))
    return AsperityPopulation(pair, summits.heights[chosen], summits.radii[chosen])


def resample(heights: NDArray[np.float64], count: int) -> NDArray[np.intp]:
    """Indices of ``count`` summits that have the heights of the given ones.

    Parameters
    ----------
    heights : ndarray
        Heights of the summits there are.
    count : int
        How many are wanted.

    Returns
    -------
    ndarray
        Each summit as often as it goes, and the rest at even steps of rank. No randomness: the
        same scan makes the same joint. The share of summits up to any height is kept to
        1/``count`` or better.
    """
    ranked = np.argsort(heights, kind="stable")
    whole, rest = divmod(count, heights.size)
    steps = ((np.arange(rest) + 0.5) / max(rest, 1) * heights.size).astype(np.intp)
    return np.concatenate([np.tile(ranked, whole), ranked[steps]])


def verdicts(summits: Summits, joint: Any = None) -> tuple[Verdict, ...]:
    """How far the summits bear a joint.

    Parameters
    ----------
    summits : Summits
        The summits.
    joint : Interface, optional
        A joint on them, for the verdicts of the model at its load.

    Returns
    -------
    tuple of Verdict
        Verdicts on the scan and its summits, then those on the joint.

    Raises
    ------
    InputError
        Something else for a joint.

    Notes
    -----
    The limits are this project's, with their reasons. White noise has a peak in every nine pixels,
    at a mean spacing of three; white noise behind a Gaussian filter has its summits 0.87 cut-offs
    apart. Gaussian heights have a kurtosis of three and, by McCool's estimate, summits of the same
    radius as by count, if the pixel resolves them. Where McCool's formulas have no summits the
    factor between the two radii is infinite.
    """
    if joint is not None and not isinstance(joint, Interface):
        raise InputError(f"joint must be an Interface, got {show(joint)}")
    pixel = math.sqrt(math.prod(summits.scan.pixel))
    spacing = 1.0 / math.sqrt(summits.density)
    statistics = summits.statistics()
    kurtosis = float(summits.scan.statistics().kurtosis)
    apart, told = _against_mccool(summits)
    spread = summits.equivalent_radius / summits.mean_radius
    lost = summits.dropped / (summits.dropped + summits.count)
    found = [
        radius_verdict(statistics, summits.scan),
        _least(
            "summit spacing in pixels",
            spacing / pixel,
            8.0,
            5.0,
            "summits are features of the surface and not of the pixel, at which noise has one in 3",
        ),
    ]
    if summits.cutoff is not None:
        found.append(
            _least(
                "summit spacing over cut-off",
                spacing / summits.cutoff,
                2.0,
                1.2,
                "summits are features of the surface and not of the filter, behind which noise has "
                "0.87",
            )
        )
    found += [
        pixel_verdict(summits.scan),
        _least("summits", float(summits.count), 30.0, 10.0, "summits are enough for statistics"),
        _most(
            "kurtosis of the heights",
            kurtosis,
            6.0,
            20.0,
            "no scratch or spike dominates the moments; Gaussian heights have 3",
        ),
        _most(
            "mean radius counted against McCool's",
            apart,
            1.5,
            3.0,
            "summits and spectral moments tell of the same surface, as on a Gaussian one; " + told,
        ),
        _most(
            "radius by load over radius by curvature",
            spread,
            1.6,
            3.0,
            "one radius stands for all summits; on a Gaussian surface the ratio is 1.28",
        ),
        *_below_threshold(summits),
        _most("share of fits dropped", lost, 0.1, 0.3, "peaks are round enough to be summits"),
    ]
    return (*found, *(joint.validity if joint is not None else ()))


def radius_verdict(statistics: SummitStatistics, scan: Scan) -> Verdict:
    """Whether a radius is one of the surface and not of the pixel.

    Parameters
    ----------
    statistics : SummitStatistics
        With the radius that is judged.
    scan : Scan
        The scan, or the profile, that it is from.

    Returns
    -------
    Verdict
        On the radius in pixels.
    """
    return _least(
        "summit radius in pixels",
        statistics.radius / math.prod(scan.pixel) ** (1.0 / len(scan.pixel)),
        5.0,
        2.0,
        "the radius is more than a few pixels, so that slopes are small and caps are resolved",
    )


def _below_threshold(summits: Summits) -> tuple[Verdict, ...]:
    """How many peaks the prominence drops: noise, or waves of a few pixels that are no noise."""
    if summits.threshold <= 0.0:
        return ()
    every = summits.neighbours.density * summits.area
    share = max(1.0 - (summits.count + summits.dropped) / every, 0.0)
    return (
        _most(
            "share of peaks below the prominence",
            share,
            0.05,
            1.0,
            "hardly a peak is below the prominence; those that are may be noise, or waves of a few "
            "pixels that a smaller prominence counts: nothing in a scan tells them apart",
        ),
    )


def _against_mccool(summits: Summits) -> tuple[float, str]:
    """How far the radius counted is from McCool's, as a factor, and what is to be said of it."""
    moments = summits.scan.moments()
    try:
        mccool = moments.mccool().radius
    except InputError:  # no Gaussian surface at all: no factor is too large
        told = f"there Nayak's alpha is at least 1.5, here it is {moments.nayak:.2g}"
        return math.inf, told
    counted = summits.mean_radius
    told = "moments of curvature are ruled by the few sharpest points"
    return max(mccool / counted, counted / mccool), told


def _least(name: str, value: float, limit: float, outside: float, meaning: str) -> Verdict:
    word = "ok" if value >= limit else "watch" if value >= outside else "outside"
    return Verdict(name, value, limit, word, meaning)  # type: ignore[arg-type]


def _most(name: str, value: float, limit: float, outside: float, meaning: str) -> Verdict:
    word = "ok" if value <= limit else "watch" if value <= outside else "outside"
    return Verdict(name, value, limit, word, meaning)  # type: ignore[arg-type]
