"""The density of heights, and which distributions describe it.

A million points reject every distribution: no surface is exactly Gaussian. So fits are judged by
the size of what they miss, in shares of the points and in parts of the rms, and not by p-values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering
from microslip._core.verdicts import Verdict
from microslip.errors import InputError
from microslip.scans.distribution_fits import RANGE, TAIL, Fit, fits_of
from microslip.scans.height_map import HeightMap
from microslip.scans.scan_rules import judged
from microslip.scans.statistics import Statistics, statistics_of

_LEVELS = 400
"""Quantiles that fits are held against: steps of a quarter of a percent."""


@dataclass(frozen=True, eq=False)
class HeightFit(Locked):
    """The density of the heights of a scan and the distributions fitted to it."""

    height: Floats
    """Middles of the bins [m]."""
    density: Floats
    """Probability density in each [1/m]; the bins hold all points but the extreme ones."""
    fits: tuple[Fit, ...]
    """The fits, the one with the least :attr:`Fit.effect` first."""
    statistics: Statistics
    """Height parameters."""
    tail_start: float
    """Height [m] above which the highest tenth of the points is."""
    tail_scale: float
    """Mean height [m] of these above it: the scale of an exponential tail."""
    tail_share: float
    """Largest difference [-] of that exponential to the distribution of the tail's points."""

    @property
    def best(self) -> Fit:
        """The fit that misses least."""
        return self.fits[0]

    @property
    def gaussian(self) -> Fit:
        """The Gaussian with the mean and the rms of the heights."""
        return next(fit for fit in self.fits if fit.name == "gaussian")

    @property
    def verdict(self) -> str:
        """Kind of the heights, in a sentence."""
        gauss, best, rms = self.gaussian, self.best, self.statistics.rms
        text = {
            "ok": "The heights are Gaussian to practical accuracy",
            "watch": "The heights are roughly Gaussian",
            "outside": "The heights are not Gaussian",
        }[gauss.word]
        text += (
            f": a Gaussian of their mean and rms is off by at most {100.0 * gauss.share:.2g} % of "
            f"the points and {engineering(gauss.shift * rms, 'm', 2)} in quantiles"
        )
        if gauss.word != "ok" and best.share < gauss.share and best.effect < 0.8 * gauss.effect:
            mirrored = "mirrored " if best.mirrored else ""
            text += f"; {mirrored}{best.name} by {100.0 * best.share:.2g} %"
        if gauss.tail > 0.5:
            text += (
                "; the Gaussian misses the highest tenth, which touches first, by up to "
                f"{gauss.tail:.2g} rms"
            )
        return f"{text}."

    def verdicts(self) -> tuple[Verdict, ...]:
        """Deviation of the heights from a Gaussian: points, quantiles, those of the top tenth."""
        gaussian = self.gaussian
        return judged(
            {
                "points missed by a Gaussian": gaussian.share,
                "quantiles missed by a Gaussian, over rms": gaussian.shift,
                "the same of the highest tenth": gaussian.tail,
            }
        )


def height_distribution(scan: HeightMap, *, bins: int = 200) -> HeightFit:
    """Density of the heights of a scan, as it is, and how well the usual distributions fit it."""
    return height_distribution_of(scan.heights, bins=bins)


def height_distribution_of(heights: Floats, *, bins: int = 200) -> HeightFit:
    """The same, of an array of heights, those of summits for example."""
    numbers = statistics_of(heights)
    if numbers.count < 20:
        raise InputError(f"a height distribution needs 20 heights or more, got {numbers.count}")
    if not isinstance(bins, int) or not 2 <= bins <= 100_000:
        raise InputError(f"`bins` must be a whole number from 2 to 100000, got {bins!r}")
    ordered = heights.reshape(-1)
    ordered = ordered[~np.isnan(ordered)]
    ordered.sort()
    levels = (np.arange(_LEVELS) + 0.5) / _LEVELS
    every = np.unique(np.append(levels, [1.0 - TAIL[1], *RANGE, *TAIL]))
    # Standardised, so that a fit has the same numbers whatever the unit.
    x = (_quantiles(ordered, every) - numbers.mean) / numbers.rms
    fits = fits_of(every, x, numbers)
    start, scale, share = _tail(ordered)
    height, density = _histogram(ordered, bins)
    return HeightFit(height, density, fits, numbers, start, scale, share)


def _quantiles(ordered: Floats, levels: Floats) -> Floats:
    at = levels * ordered.size - 0.5
    low = np.clip(np.floor(at).astype(np.intp), 0, ordered.size - 2)
    part = np.clip(at - low, 0.0, 1.0)
    return (1.0 - part) * ordered[low] + part * ordered[low + 1]


def _tail(ordered: Floats) -> tuple[float, float, float]:
    first = min(int(TAIL[0] * ordered.size), ordered.size - 2)
    start = float(ordered[first])
    above = ordered[first:] - start
    scale = float(above.mean())
    if not scale > 0.0:
        return start, 0.0, 1.0
    part = (np.arange(above.size) + 0.5) / above.size
    return start, scale, float(np.max(np.abs(-np.expm1(-above / scale) - part)))


def _histogram(ordered: Floats, bins: int) -> tuple[Floats, Floats]:
    # A lonely pit must not leave three bins for all the rest.
    low, high = _quantiles(ordered, np.array([0.0005, 0.9995]))
    margin = 0.1 * (high - low)
    low, high = max(low - margin, float(ordered[0])), min(high + margin, float(ordered[-1]))
    if not high > low:
        low, high = float(ordered[0]), float(ordered[-1])
    edges = np.linspace(low, high, bins + 1)
    # Sorted already: counts are differences of places.
    places = np.searchsorted(ordered, edges)
    places[-1] = np.searchsorted(ordered, edges[-1], side="right")
    density = np.diff(places) / (ordered.size * np.diff(edges))
    return lock(0.5 * (edges[1:] + edges[:-1])), lock(density)
