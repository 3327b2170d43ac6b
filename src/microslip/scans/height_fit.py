"""The density of heights, and which distributions describe it.

A million points reject every distribution: no surface is exactly Gaussian. So fits are judged by
the size of what they miss, in shares of the points and in parts of the rms, and not by p-values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, plain, show
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering
from microslip._core.verdicts import Verdict, Word
from microslip.errors import InputError
from microslip.scans.height_map import HeightMap
from microslip.scans.moments import Statistics, statistics_of
from microslip.scans.scan_rules import judged

RANGE = (0.01, 0.99)
"""Quantiles beyond are of few places, however many points: neighbours are alike."""
TAIL = (0.9, 0.999)
"""The upper tail: what touches first."""

# Name, SciPy's name, shapes to start from with the place and scale of mean 0 and variance 1.
_FAMILIES: tuple[tuple[str, str, tuple[float, ...], float, float], ...] = (
    ("gaussian", "norm", (), 0.0, 1.0),
    ("skew-normal", "skewnorm", (1.0,), -0.7, 1.2),
    ("lognormal", "lognorm", (0.2,), -5.0, 4.9),
    ("weibull", "weibull_min", (3.0,), -2.7, 3.0),
    ("student t", "t", (6.0,), 0.0, 0.8),
    ("exponential", "expon", (), -1.0, 1.0),
)


@dataclass(frozen=True)
class Fit:
    """A distribution fitted to heights."""

    name: str
    """"gaussian", "skew-normal", "lognormal", "weibull", "student t" or "exponential"."""
    shapes: tuple[float, ...]
    """Shape parameters [-], as in scipy.stats."""
    place: float
    scale: float
    """Location and scale [m], as in scipy.stats; of the mirrored heights if `mirrored`."""
    mirrored: bool
    """Whether it is the distribution of minus the height: the long tail is downwards."""
    share: float = math.nan
    """Largest difference of the distribution functions [-]: at most so many of the points are on
    the wrong side of any height."""
    shift: float = math.nan
    """Largest difference of the quantiles from 1 % to 99 %, in units of the rms [-]."""
    tail: float = math.nan
    """The same from 90 % to 99.9 %: of the heights that touch first."""

    def distribution(self) -> Any:
        """The same as a frozen distribution of scipy.stats, of the mirrored heights if so."""
        from scipy import stats

        family = next(family[1] for family in _FAMILIES if family[0] == self.name)
        return getattr(stats, family)(*self.shapes, loc=self.place, scale=self.scale)

    def density(self, height: ArrayLike) -> Any:
        """Probability density of the fit."""
        z = floats("height", height, "m")
        return plain(np.asarray(self.distribution().pdf(-z if self.mirrored else z)))

    def share_below(self, height: ArrayLike) -> Any:
        """Distribution function of the fit."""
        z, law = floats("height", height, "m"), self.distribution()
        return plain(np.asarray(law.sf(-z) if self.mirrored else law.cdf(z)))

    @property
    def effect(self) -> float:
        """Size of what the fit misses [-]: 1 for 2 % of the points or a tenth of the rms."""
        return max(self.share / 0.02, self.shift / 0.1)

    @property
    def word(self) -> Word:
        """``ok``: misses 2 % of the points and 0.1 rms at most; ``watch``: 5 %, 0.5 rms."""
        if self.effect <= 1.0:
            return "ok"
        return "watch" if self.share <= 0.05 and self.shift <= 0.5 else "outside"


def fits_of(levels: Floats, quantiles: Floats, numbers: Statistics) -> tuple[Fit, ...]:
    """Every law fitted to standardised quantiles, in metres; the one that misses least first."""
    fits = []
    for family in _FAMILIES:
        for mirrored in (False, True) if family[0] not in ("gaussian", "student t") else (False,):
            fit = _fitted(family, levels, quantiles, mirrored)
            if fit is not None:
                fits.append(_in_metres(fit, numbers))
    best: dict[str, Fit] = {}
    for fit in sorted(fits, key=lambda fit: fit.effect):
        best.setdefault(fit.name, fit)  # of a pair, the side that fits
    return tuple(best.values())


def _fitted(
    family: tuple[str, str, tuple[float, ...], float, float],
    levels: Floats,
    quantiles: Floats,
    mirrored: bool,
) -> Fit | None:
    from scipy import optimize, stats

    name, kind, shapes, place, scale = family
    law = getattr(stats, kind)
    x = -quantiles[::-1] if mirrored else quantiles
    p = 1.0 - levels[::-1] if mirrored else levels

    if name != "gaussian":
        # Half the distance of the middle quartiles is a scale that extreme points do not move.
        width = float(np.interp(0.75, p, x) - np.interp(0.25, p, x)) / 1.349
        middle = float(np.interp(0.5, p, x))
        if not width > 0.0:
            return None
        start = [middle + place * width, math.log(scale * width), *np.log(shapes)]

        def miss(at: Floats) -> Floats:
            return _share(name, (x - at[0]) * math.exp(-at[1]), np.exp(at[2:])) - p

        bounds = (
            [-np.inf, start[1] - 8.0, *(-5.0 for _ in shapes)],
            [np.inf, start[1] + 8.0, *(6.0 for _ in shapes)],
        )
        with np.errstate(all="ignore"):
            search = optimize.least_squares(miss, start, bounds=bounds, x_scale="jac", max_nfev=100)
        if not np.isfinite(search.x).all():
            return None
        place, scale = float(search.x[0]), math.exp(search.x[1])
        shapes = tuple(float(value) for value in np.exp(search.x[2:]))
    frozen = law(*shapes, loc=place, scale=scale)
    with np.errstate(all="ignore"):
        share = float(np.max(np.abs(frozen.cdf(x) - p)))
        # A few quantiles do: some laws have to search for them one by one.
        sample = np.unique(np.append(np.linspace(0, p.size - 1, 60).astype(int), _ends(p)))
        off = np.abs(frozen.ppf(p[sample]) - x[sample])
    ranks = 1.0 - p[sample] if mirrored else p[sample]
    middle, upper = (
        float(off[(ranks > low - 1e-9) & (ranks < high + 1e-9)].max())
        for low, high in (RANGE, TAIL)
    )
    if not math.isfinite(middle + upper):
        return None
    return Fit(name, shapes, place, scale, mirrored, share, middle, upper)


def _ends(levels: Floats) -> NDArray[np.intp]:
    """Levels between which the quantiles are judged, from either side."""
    ends = np.array([*RANGE, *TAIL])
    return np.asarray(np.abs(levels[:, None] - np.append(ends, 1.0 - ends)).argmin(axis=0))


def _share(name: str, x: Floats, shapes: Floats) -> Floats:
    """Distribution functions as in scipy.stats, but fast enough to search with."""
    from scipy.special import ndtr, owens_t, stdtr

    if name == "skew-normal":
        return np.asarray(ndtr(x) - 2.0 * owens_t(x, shapes[0]))
    if name == "student t":
        return np.asarray(stdtr(shapes[0], x))
    # The others begin at their place.
    above = np.maximum(x, 1e-300)
    if name == "lognormal":
        share = ndtr(np.log(above) / shapes[0])
    else:
        share = -np.expm1(-(above ** (shapes[0] if shapes.size else 1.0)))
    return np.where(x > 0.0, share, 0.0)


def _in_metres(fit: Fit, numbers: Statistics) -> Fit:
    sign = -1.0 if fit.mirrored else 1.0
    place = sign * numbers.mean + numbers.rms * fit.place
    return replace(fit, place=place, scale=numbers.rms * fit.scale)


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
    """Density of the heights in some bins, and how well the usual distributions fit them.

    In ``bins`` bins; errors as :meth:`measurable`.
    """
    return height_distribution_of(scan.measurable().heights, bins=bins)


def height_distribution_of(heights: Floats, *, bins: int = 200) -> HeightFit:
    """The same, of an array of heights, those of summits for example."""
    numbers = statistics_of(heights)
    if numbers.count < 20:
        raise InputError(f"a height distribution needs 20 heights or more, got {numbers.count}")
    if not isinstance(bins, int) or not 2 <= bins <= 100_000:
        raise InputError(f"`bins` must be a whole number from 2 to 100000, got {show(bins)}")
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
