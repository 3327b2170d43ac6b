"""Areal parameters after ISO 25178-2:2021 that go beyond heights and moments.

Each is checked against closed forms on surfaces made to order: a sine, a plane with steps, a field
of paraboloids. Nothing here is levelled or filtered: give the scan as it is to be judged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock
from microslip.errors import InputError
from microslip.scans.curvature import fitted
from microslip.scans.height_map import HeightMap
from microslip.scans.noise import present
from microslip.scans.prominence import find_peaks

PRUNING = 0.05
"""Prominence of a hill, over the height of the surface, below which Wolf pruning removes it."""

_DECAY = 0.2
"""Correlation at which the autocorrelation length is read."""
_SECANT_SHARE = 0.4
"""Share of the points over which the secant of the core of the material ratio curve is drawn."""


@dataclass(frozen=True)
class ArealParameters:
    """Functional, spatial, hybrid and feature parameters after ISO 25178-2:2021."""

    core_height: float
    """Sk [m], height of the core of the material ratio curve."""
    peak_height: float
    valley_depth: float
    """Spk and Svk [m], reduced heights of peaks and dales beyond the core."""
    peak_material_ratio: float
    valley_material_ratio: float
    """Smr1 and Smr2 [-], material ratios where the core begins and ends."""
    autocorrelation_length: float
    """Sal [m], the shortest distance at which the autocorrelation has fallen to 0.2; not a number
    where it does not within half of the scan."""
    texture_aspect_ratio: float
    """Str [-], Sal over the longest such distance: 1 if isotropic, near 0 with a lay."""
    developed_area_ratio: float
    """Sdr [-], area of the surface over its projection, less one."""
    rms_gradient: float
    """Sdq [-], root mean square gradient."""
    peak_density: float
    """Spd [1/m^2], hills of 5 % of the height and more."""
    peak_curvature: float
    """Spc [1/m], arithmetic mean of their principal curvatures."""


@dataclass(frozen=True, eq=False)
class Autocorrelation(Locked):
    """Normalised autocorrelation of the heights, centred, with as many lags as points."""

    values: Floats
    """Correlation [-], rows along y and columns along x; 1 in the middle."""
    pixel: tuple[float, ...]
    """Distance of neighbouring lags [m] along x and along y."""

    @property
    def lags(self) -> tuple[Floats, Floats]:
        """Lags [m] of the columns and of the rows."""
        rows, columns = self.values.shape
        x = (np.arange(columns) - columns // 2) * self.pixel[0]
        y = (np.arange(rows) - rows // 2) * self.pixel[1]
        return x, y

    def decay_lengths(self, level: float = _DECAY) -> tuple[float, float]:
        """Shortest and longest distance [m] at which the correlation falls to a level, 0 to 1.

        Along the rays from the middle, a degree apart and linear between lags; infinite where it
        does not fall so far within half of the scan. Another level is an InputError.
        """
        if not 0.0 < level < 1.0:
            raise InputError(f"`level` must be between 0 and 1, got {level:g}")
        from scipy.ndimage import map_coordinates

        rows, columns = self.values.shape
        centre = np.array([rows // 2, columns // 2])
        step = 0.5 * min(self.pixel)
        reach = min(columns // 2 * self.pixel[0], rows // 2 * self.pixel[1])
        radius = np.arange(0.0, reach, step)
        angles = np.radians(np.arange(0.0, 180.0))[:, None]
        places = np.stack(
            [
                centre[0] + radius * np.sin(angles) / self.pixel[1],
                centre[1] + radius * np.cos(angles) / self.pixel[0],
            ]
        )
        along = map_coordinates(self.values, places.reshape(2, -1), order=1, mode="nearest")
        along = along.reshape(angles.size, radius.size)
        below = along < level
        first = below.argmax(axis=1)
        lengths = np.full(angles.size, math.inf)
        for ray in np.flatnonzero(below.any(axis=1)):
            k = int(first[ray])
            high, low = along[ray, k - 1], along[ray, k]
            lengths[ray] = radius[k - 1] + step * (high - level) / (high - low)
        return float(lengths.min()), float(lengths.max())


def autocorrelation(scan: HeightMap) -> Autocorrelation:
    """Autocorrelation of an area, each lag over the pairs of points that are there."""
    if scan.is_profile:
        raise InputError("a profile has no areal autocorrelation")
    scan = scan.measurable()
    there = ~np.isnan(scan.heights)
    z = np.where(there, scan.heights - np.nanmean(scan.heights), 0.0)
    shape = [2 * n for n in z.shape]  # zeros around it, so that nothing wraps

    def correlated(a: Floats) -> Floats:
        waves = np.fft.rfft2(a, shape)
        return np.asarray(np.fft.irfft2(np.abs(waves) ** 2, shape))

    pairs = np.maximum(np.rint(correlated(there.astype(float))), 1.0)
    full = np.fft.fftshift(correlated(z) / pairs)
    rows, columns = z.shape
    middle = full[
        rows - rows // 2 : rows - rows // 2 + rows,
        columns - columns // 2 : columns - columns // 2 + columns,
    ]
    return Autocorrelation(lock(middle / full[rows, columns]), scan.pixel)


def areal_parameters(scan: HeightMap) -> ArealParameters:
    """Parameters of ISO 25178-2:2021 of an area; see :meth:`microslip.Scan.areal_parameters`."""
    if scan.is_profile:
        raise InputError("a profile has no areal parameters; its heights and moments are known")
    scan = scan.measurable()
    shortest, longest = autocorrelation(scan).decay_lengths()
    area_ratio, gradient = _gradients(scan)
    density, curvature = _hills(scan)
    return ArealParameters(
        *_core(scan.heights[~np.isnan(scan.heights)]),
        shortest if math.isfinite(shortest) else math.nan,
        shortest / longest if math.isfinite(shortest) else math.nan,
        area_ratio,
        gradient,
        density,
        curvature,
    )


def _core(heights: Floats) -> tuple[float, float, float, float, float]:
    """Sk, Spk, Svk, Smr1, Smr2 by the flattest secant over 40 % of the material ratio curve."""
    curve = np.sort(heights)[::-1]  # heights against the share of points that are higher
    count = curve.size
    width = min(max(round(_SECANT_SHARE * count), 1), count - 1)
    drop = curve[:-width] - curve[width:]
    # Of secants that are as flat the middle one, as of a straight curve.
    flat = np.flatnonzero(drop <= drop.min() * (1.0 + 1e-12))
    start = int(flat[flat.size // 2])
    # The equivalent straight line: least squares through the points of that part.
    places = np.arange(start, start + width + 1)
    part = curve[places]
    mean_place, mean = places.mean(), part.mean()
    spread = places - mean_place
    slope = float(spread @ (part - mean) / (spread @ spread))
    top = mean - slope * (mean_place + 0.5)
    bottom = mean + slope * (count - 0.5 - mean_place)
    core = top - bottom
    above, below = curve > top, curve < bottom
    first, last = np.count_nonzero(above) / count, 1.0 - np.count_nonzero(below) / count
    # Triangles of the same area as what sticks out, on the same share of points.
    peaks = 2.0 * float((curve[above] - top).sum()) / count / first if first > 0.0 else 0.0
    dales = 2.0 * float((bottom - curve[below]).sum()) / count / (1.0 - last) if last < 1.0 else 0.0
    return float(core), float(peaks), float(dales), float(first), float(last)


def _gradients(scan: HeightMap) -> tuple[float, float]:
    """Sdr from the triangles of each cell, both ways of cutting it, and Sdq from its gradient."""
    z, (dx, dy) = scan.heights, scan.pixel
    a, b, c, d = z[:-1, :-1], z[:-1, 1:], z[1:, :-1], z[1:, 1:]
    pairs = [
        *(((b - a) / dx, (c - a) / dy), ((d - c) / dx, (d - b) / dy)),
        *(((b - a) / dx, (d - b) / dy), ((d - c) / dx, (c - a) / dy)),
    ]
    areas = [np.sqrt(1.0 + p * p + q * q) for p, q in pairs]
    ratio = float(np.nanmean(sum(areas) / 4.0)) - 1.0
    square = sum(p * p + q * q for p, q in pairs) / 4.0
    return ratio, math.sqrt(float(np.nanmean(square)))


def _hills(scan: HeightMap) -> tuple[float, float]:
    """Spd and Spc of the hills that Wolf pruning leaves."""
    heights = scan.heights
    peaks = find_peaks(heights)
    inner = present(heights, 1).reshape(-1)
    height = float(np.nanmax(heights) - np.nanmin(heights))
    good = (peaks.prominences >= PRUNING * height) & inner[peaks.places]
    places = peaks.places[good]
    area = np.count_nonzero(inner) * math.prod(scan.pixel)
    if not places.size:
        return 0.0, math.nan
    tops = fitted(heights, places, scan.pixel, 3)
    return places.size / area, float(tops.curvatures.mean())


def slope_over_distance(scan: HeightMap) -> tuple[Floats, Floats]:
    """Rms slope between points against their distance; of a profile along it."""
    heights, distances, slopes = scan.heights, [], []
    lag = 1
    while lag <= min(heights.shape) // 4:
        squares = []
        for axis in range(heights.ndim):
            step = scan.pixel[heights.ndim - 1 - axis] * lag
            ahead = np.take(heights, range(lag, heights.shape[axis]), axis)
            behind = np.take(heights, range(heights.shape[axis] - lag), axis)
            squares.append(float(np.nanmean(((ahead - behind) / step) ** 2)))
        # Pixels that are not square: the distance is the geometric mean of both.
        distances.append(lag * math.prod(scan.pixel) ** (1.0 / len(scan.pixel)))
        slopes.append(math.sqrt(sum(squares) / len(squares)))
        lag *= 2
    return lock(np.array(distances)), lock(np.array(slopes))
