"""Spectral moments of a measured surface, and McCool's summits.

The moments m0, m2 and m4 are the variances of heights, slopes and curvatures along a line. Slopes
and curvatures are finite differences of the sampled heights, along rows and along columns: the
slope (z[i+1] - z[i])/h in the middle between two points, and the curvature (z[i+1] - 2 z[i] +
z[i-1])/h^2 at a point.

Both are central differences, used wherever all their points are present. For a wave of wavenumber q
the amplitudes of slope and curvature are K and K^2 times that of the height instead of q and q^2
times, with K = (2/h) sin(q h/2). So m0, m2 and m4 are moments of one spectrum, and m0 m4 >= m2^2
also holds for the measured values, except for the edges. A wave of ten pixels loses 3 % of its m2
and 6 % of its m4; for waves long compared with the pixel the error decreases with the square of the
pixel. Differences over two pixels would not detect waves of two pixels and would halve the slopes
of noise, but not its curvatures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats, positive
from microslip._core.errors import InputError
from microslip.contact import GreenwoodWilliamson
from microslip.contact.heights import Gaussian
from microslip.contact.materials import MaterialPair
from microslip.surfaces.checks import area_of

SUMMIT_SHARE = 1.0 - 3.0 * math.sqrt(3.0) + 16.0 / math.pi
"""McCool's 0.8968: (m0 - variance of the summits) times alpha/m0."""

_BLOCK = 1 << 18  # points per block, so that differences stay in the cache


@dataclass(frozen=True)
class SummitStatistics:
    """Density, radius and height spread of the summits of a surface.

    Parameters of a rough surface in Greenwood and Williamson (1966), DOI 10.1098/rspa.1966.0242,
    and the mean height of the summits above the mean plane.

    Parameters
    ----------
    density : float
        Summits per unit area [1/m^2], above zero.
    radius : float
        Radius of the summits [m], above zero.
    std : float
        Standard deviation of the summit heights [m], not below zero.
    mean_height : float
        Mean height of the summits above the mean plane of the surface [m].
    """

    density: float
    radius: float
    std: float
    mean_height: float = 0.0

    def to_surface(self, pair: MaterialPair, area: float | str) -> GreenwoodWilliamson:
        """Make a rough surface with these summits and Gaussian heights, against a rigid plane.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        area : float or str
            Apparent area of the joint [m^2], or text such as "2 cm^2".

        Returns
        -------
        GreenwoodWilliamson
            Heights are measured from the mean plane of the surface; Greenwood and Williamson
            (1966), DOI 10.1098/rspa.1966.0242.
        """
        heights = Gaussian(self.std, self.mean_height)
        return GreenwoodWilliamson(pair, heights, self.radius, self.density, area_of(area))


@dataclass(frozen=True)
class Moments:
    """Spectral moments of a surface: variances of its heights, slopes and curvatures.

    m2 and m4 are moments of profiles, averaged over both axes (Nayak 1971, DOI 10.1115/1.3451608;
    McCool 1987, DOI 10.1115/1.3261349).

    Parameters
    ----------
    m0 : float
        Variance of the heights [m^2], above zero.
    m2 : float
        Mean square slope of a profile [-], above zero.
    m4 : float
        Mean square curvature of a profile [1/m^2], above zero.
    m2_axes : tuple of float
        m2 [-] along x and along y; a single value for a profile.
    m4_axes : tuple of float
        m4 [1/m^2] along x and along y; a single value for a profile.
    m11 : float
        Mean product of the slopes along x and along y [-].
    """

    m0: float
    m2: float
    m4: float
    m2_axes: tuple[float, ...] = ()
    m4_axes: tuple[float, ...] = ()
    m11: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("m0", "m^2"), ("m2", ""), ("m4", "1/m^2")):
            # Squares may exceed the range allowed for quantities.
            value = getattr(self, name)
            if not (isinstance(value, float) and 0.0 < value < math.inf):
                positive(name, value, unit)
                object.__setattr__(self, name, float(value))

    @property
    def rms(self) -> float:
        """Root mean square height [m]."""
        return math.sqrt(self.m0)

    @property
    def rms_slope(self) -> float:
        """Root mean square slope of a profile [-]."""
        return math.sqrt(self.m2)

    @property
    def nayak(self) -> float:
        """Nayak's alpha, m0 m4/m2^2 [-]: breadth of the spectrum, at least 1.5 if isotropic."""
        return self.m0 / self.m2 * (self.m4 / self.m2)

    @property
    def slopes(self) -> tuple[float, float]:
        """Largest and smallest mean square slope [-] over all directions."""
        if len(self.m2_axes) < 2:
            return self.m2, self.m2
        a, b = self.m2_axes
        middle, half = 0.5 * (a + b), math.hypot(0.5 * (a - b), self.m11)
        return middle + half, max(middle - half, 0.0)

    @property
    def anisotropy(self) -> float:
        """Ratio of largest to smallest rms slope over all directions [-]: 1 if isotropic."""
        large, small = self.slopes
        return math.sqrt(large / small) if small > 0.0 else math.inf

    @property
    def lay(self) -> float:
        """Direction of the smallest slopes [rad], measured from x towards y, in (-pi/2, pi/2]."""
        if len(self.m2_axes) < 2:
            return 0.0
        a, b = self.m2_axes
        angle = 0.5 * math.atan2(2.0 * self.m11, a - b) + 0.5 * math.pi
        return angle - math.pi if angle > 0.5 * math.pi else angle

    def mccool(self) -> SummitStatistics:
        """Return the Greenwood and Williamson parameters of McCool (1987), DOI 10.1115/1.3261349.

        These are exact means over the summits of an isotropic Gaussian surface (Nayak 1971, DOI
        10.1115/1.3451608); the radius is the inverse of the mean curvature.

        Returns
        -------
        SummitStatistics
            Density (m4/m2)/(6 pi sqrt 3), radius (3/8) sqrt(pi/m4), mean height 4 sqrt(m0/(pi
            alpha)), std sqrt((1 - 0.8968/alpha) m0).
        """
        alpha = self.nayak
        variance = (1.0 - SUMMIT_SHARE / alpha) * self.m0
        if not variance > 0.0:
            raise InputError(
                f"Nayak's alpha must be above {SUMMIT_SHARE:.4f} (1.5 or more if the surface is "
                f"isotropic and Gaussian) for summit statistics after McCool, got {alpha:.4g}"
            )
        return SummitStatistics(
            density=self.m4 / self.m2 / (6.0 * math.pi * math.sqrt(3.0)),
            radius=0.375 * math.sqrt(math.pi / self.m4),
            std=math.sqrt(variance),
            mean_height=4.0 * math.sqrt(self.m0 / (math.pi * alpha)),
        )


def moments_of(heights: Floats, pixel: tuple[float, ...]) -> Moments:
    """Return the spectral moments of heights, without levelling or filtering."""
    profile = heights.ndim == 1
    grid = heights[None, :] if profile else heights
    m0 = variance(heights)
    m2x, m4x = _Mean(), _Mean()
    m2y, m4y, m11 = _Mean(), _Mean(), _Mean()
    for rows, below in _blocks(grid):
        # The last cells reach to the row below the block.
        along = np.diff(below[: rows.shape[0] + 1], axis=1)
        step = along[: rows.shape[0]]
        m2x.add(step)
        m4x.add(np.diff(step, axis=1))
        if profile:
            continue
        # Differences reach into the rows of the next block.
        down = np.diff(below, axis=0)
        m2y.add(down[: rows.shape[0]])
        m4y.add(np.diff(down, axis=0))
        # Twice the mean slopes of a cell along x and y, if all its corners are present. Both slopes
        # use the same cells, so that the direction of gaps does not affect the lay.
        m11.add_products(
            along[1:] + along[:-1], down[: rows.shape[0], 1:] + down[: rows.shape[0], :-1]
        )
    dx = pixel[0]
    second, fourth = [m2x.value(dx, 2, "x")], [m4x.value(dx, 4, "x")]
    mixed = 0.0
    if not profile:
        dy = pixel[1]
        second.append(m2y.value(dy, 2, "y"))
        fourth.append(m4y.value(dy, 4, "y"))
        mixed = m11.total / max(m11.count, 1) / (4.0 * dx * dy)
    m2, m4 = math.fsum(second) / len(second), math.fsum(fourth) / len(fourth)
    if not (m0 > 0.0 and m2 > 0.0 and m4 > 0.0):
        raise InputError(
            "the heights must vary and not lie on a plane: variances of heights, slopes and "
            f"curvatures are {m0:g} m^2, {m2:g} and {m4:g} 1/m^2"
        )
    return Moments(m0, m2, m4, tuple(second), tuple(fourth), mixed)


def lost_to_pixel(heights: Floats, pixel: tuple[float, ...]) -> float:
    """Estimate the fraction of m4 [-] that finite differences miss, as h^2 m6/(6 m4).

    Over the pixel h they underestimate the curvature of short waves; m6 is the mean square of third
    derivatives.
    """
    profile = heights.ndim == 1
    grid = heights[None, :] if profile else heights
    thirds, fourths = [_Mean(), _Mean()], [_Mean(), _Mean()]
    for rows, below in _blocks(grid, 3):
        along = np.diff(rows, 2, axis=1)
        fourths[0].add(along)
        thirds[0].add(np.diff(along, axis=1))
        if not profile:
            down = np.diff(below, 2, axis=0)
            fourths[1].add(down[: rows.shape[0]])
            thirds[1].add(np.diff(down, axis=0))
    m6, m4 = 0.0, 0.0
    for third, fourth, step in zip(thirds, fourths, pixel, strict=False):
        m6 += third.total / max(third.count, 1) / step**4  # times pixel^2
        m4 += fourth.total / max(fourth.count, 1) / step**4
    return m6 / (6.0 * m4) if m4 > 0.0 else 0.0


def variance(heights: Floats) -> float:
    """Return the variance [m^2] of the heights, ignoring missing points."""
    flat = heights.reshape(-1)
    count, total, square = 0, 0.0, 0.0
    parts = [flat[start : start + _BLOCK] for start in range(0, flat.size, _BLOCK)]
    for part in parts:
        values = without_missing(part)
        count, total = count + values.size, total + float(values.sum())
    mean = total / max(count, 1)
    for part in parts:
        off = without_missing(part) - mean
        square += dot(off, off)
    return square / max(count, 1)


def without_missing(values: Floats) -> Floats:
    """Return the values that are not NaN; the given array if none is NaN."""
    missing = np.isnan(values)
    return values[~missing] if missing.any() else values


def dot(a: Floats, b: Floats) -> float:
    """Return the sum of products in a single thread; BLAS would start others, which then idle."""
    return float(np.einsum("i,i->", a, b))


class _Mean:
    """Accumulated mean of squares or products, ignoring missing values."""

    def __init__(self) -> None:
        self.total, self.count = 0.0, 0

    def add(self, values: Floats) -> None:
        flat = values.reshape(-1)
        self.add_products(flat, flat)

    def add_products(self, a: Floats, b: Floats) -> None:
        a, b = a.reshape(-1), b.reshape(-1)
        total, count = dot(a, b), a.size
        if math.isnan(total):
            products = a * b
            missing = np.isnan(products)
            np.copyto(products, 0.0, where=missing)
            total, count = float(products.sum()), count - int(np.count_nonzero(missing))
        self.total += total
        self.count += count

    def value(self, step: float, power: int, axis: str) -> float:
        if self.count == 0:
            raise InputError(
                f"no three neighbouring points along {axis} are present, as slopes and curvatures "
                'need; fill the scan first with `fill="interpolate"`'
            )
        return self.total / self.count / step**power


def _blocks(grid: Floats, overlap: int = 2) -> Iterator[tuple[Floats, Floats]]:
    """Yield blocks of rows, each also extended by the first ``overlap`` rows of the next block."""
    rows, columns = grid.shape
    height = max(1, _BLOCK // columns)
    for start in range(0, rows, height):
        yield grid[start : start + height], grid[start : start + height + overlap]


@dataclass(frozen=True)
class Statistics:
    """Height parameters after ISO 25178-2:2021, or ISO 21920-2:2021 for a profile."""

    mean: float
    """Mean height [m]."""
    rms: float
    """Root mean square height Sq [m] about the mean."""
    mean_deviation: float
    """Arithmetical mean height Sa [m]."""
    skewness: float
    """Skewness Ssk [-]: 0 for a Gaussian surface, negative if plateaus dominate."""
    kurtosis: float
    """Kurtosis Sku [-]: 3 for a Gaussian surface."""
    maximum_height: float
    """Maximum height Sz, from the lowest valley to the highest peak [m]."""
    count: int
    """Number of points present."""
    missing: float
    """Fraction of missing points [-]."""


def statistics_of(heights: Floats) -> Statistics:
    """Return the height parameters of heights, without levelling them first."""
    flat = heights.reshape(-1)
    parts = [flat[start : start + _BLOCK] for start in range(0, flat.size, _BLOCK)]
    count, total, low, high = 0, 0.0, math.inf, -math.inf
    for part in parts:
        values = without_missing(part)
        if values.size:
            count, total = count + values.size, total + float(values.sum())
            low, high = min(low, float(values.min())), max(high, float(values.max()))
    # For constant heights the sums below would be rounding only.
    if not high > low:
        raise InputError(f"the heights must vary, got {count} equal heights")
    mean = total / count
    scale = high - low  # keeps fourth powers in range
    sums = np.zeros(4)
    for part in parts:
        off = (without_missing(part) - mean) / scale
        square = off * off
        sums += (np.abs(off).sum(), square.sum(), dot(square, off), dot(square, square))
    deviation, second, third, fourth = (float(value) / count for value in sums)
    return Statistics(
        mean=mean,
        rms=math.sqrt(second) * scale,
        mean_deviation=deviation * scale,
        skewness=third / second**1.5,
        kurtosis=fourth / (second * second),
        maximum_height=scale,
        count=count,
        missing=1.0 - count / flat.size,
    )
