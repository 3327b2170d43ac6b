"""Parameters after ISO 25178-2:2021 and ISO 21920-2:2021 that go beyond heights and moments.

Each is checked against closed forms: a sine, a plane with steps, a field of paraboloids, Gaussian
heights. Nothing is levelled or filtered but for the mean height of each line: give the scan as it
is to be judged, a profile with its long-wave cut-off applied; of areas the parameters of profiles
are the means over their lines.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.frozen import Locked, lock
from microslip._core.parameters import parameter
from microslip.errors import InputError
from microslip.scans.checks import length_of
from microslip.scans.height_map import HeightMap, present
from microslip.scans.peaks import find_peaks, fitted

_SECANT_SHARE = 0.4
"""Share of the points over which the secant of the core is drawn."""
_PEAKS, _DALES = 0.1, 0.8
"""Material ratios that bound the core of the volume parameters (ISO 25178-3)."""


def of(symbol: str, unit: str, meaning: str) -> Any:
    """A field that says what its parameter is."""
    return field(metadata=parameter(symbol, unit, meaning))


def core_of(heights: Floats) -> tuple[float, float, float, float, float]:
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


def volumes_of(heights: Floats) -> tuple[float, float, float, float]:
    """Vmp, Vmc, Vvc, Vvv [m^3/m^2]: material above and voids below heights of 10 and 80 %."""
    at = [float(np.quantile(heights, 1.0 - ratio)) for ratio in (_PEAKS, _DALES)]
    material = [float(np.maximum(heights - height, 0.0).mean()) for height in at]
    voids = [float(np.maximum(height - heights, 0.0).mean()) for height in at]
    return material[0], material[1] - material[0], voids[0] - voids[1], voids[1]


PRUNING = 0.05
"""Prominence of a hill, over the height of the surface, below which Wolf pruning removes it."""

_DECAY = 0.2
"""Correlation at which the autocorrelation length is read."""
_FIVE = 5
"""Hills and dales of S10z."""
_SHORTEST_WAVE = 3.0
_WEDGE = 5
"""Waves in the scan from which one has a direction, and the wedge [deg] that Std is read from."""


@dataclass(frozen=True)
class ArealParameters:
    """Functional, spatial, hybrid and feature parameters after ISO 25178-2:2021, in SI units."""

    maximum_peak_height: float = of("Sp", "m", "maximum peak height above the mean")
    maximum_pit_depth: float = of("Sv", "m", "maximum pit depth below the mean")
    maximum_height: float = of("Sz", "m", "maximum height")
    ten_point_height: float = of("S10z", "m", "five highest hills over five deepest dales")
    core_height: float = of("Sk", "m", "core height")
    peak_height: float = of("Spk", "m", "reduced peak height")
    valley_depth: float = of("Svk", "m", "reduced dale depth")
    peak_material_ratio: float = of("Smr1", "", "material ratio of peaks")
    valley_material_ratio: float = of("Smr2", "", "material ratio of dales")
    peak_material_volume: float = of("Vmp", "m", "material volume of peaks by area")
    core_material_volume: float = of("Vmc", "m", "material volume of the core by area")
    core_void_volume: float = of("Vvc", "m", "void volume of the core by area")
    dale_void_volume: float = of("Vvv", "m", "void volume of dales by area")
    autocorrelation_length: float = of("Sal", "m", "autocorrelation length")
    """The shortest distance at which the autocorrelation has fallen to 0.2; not a number where it
    does not within half of the scan."""
    texture_aspect_ratio: float = of("Str", "", "texture aspect ratio")
    """Sal over the longest such distance: 1 if isotropic, near 0 with a lay."""
    texture_direction: float = of("Std", "rad", "direction of the lay from x towards y")
    """Direction of the largest angular spectrum, 0 to pi; not meaningful where Str is above 0.5."""
    developed_area_ratio: float = of("Sdr", "", "developed area ratio")
    rms_gradient: float = of("Sdq", "", "rms gradient")
    peak_density: float = of("Spd", "1/m^2", "density of hills")
    """Hills of 5 % of the height and more."""
    peak_curvature: float = of("Spc", "1/m", "curvature of hills")
    """Arithmetic mean of their principal curvatures."""


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
    """Normalised autocorrelation of the heights [-] against lags [m], of pairs there are.

    Errors as :meth:`measurable`; a profile has none.
    """
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
    """Parameters of ISO 25178-2:2021 beyond heights and moments, in SI units.

    Sp, Sv, Sz, S10z; Sk, Spk, Svk, Smr1, Smr2; Vmp, Vmc, Vvc, Vvv (at 10 and 80 %); Sal, Str,
    Std; Sdr, Sdq; Spd and Spc.

    Of the scan as it is: level and filter it first, and say its cut-offs with them. Errors as
    :meth:`measurable`; a profile has none.
    """
    if scan.is_profile:
        raise InputError("a profile has no areal parameters; its heights and moments are known")
    scan = scan.measurable()
    shortest, longest = autocorrelation(scan).decay_lengths()
    area_ratio, gradient = _gradients(scan)
    ten, density, curvature = _hills(scan)
    heights = scan.heights[~np.isnan(scan.heights)]
    mean = float(heights.mean())
    high, low = float(heights.max()) - mean, mean - float(heights.min())
    return ArealParameters(
        *(high, low, high + low, ten),
        *core_of(heights),
        *volumes_of(heights),
        shortest if math.isfinite(shortest) else math.nan,
        shortest / longest if math.isfinite(shortest) else math.nan,
        _direction(scan),
        area_ratio,
        gradient,
        density,
        curvature,
    )


def _direction(scan: HeightMap) -> float:
    """Std: the lay runs across the waves at which the angular spectrum is largest."""
    there = ~np.isnan(scan.heights)
    z = np.where(there, scan.heights - np.nanmean(scan.heights), 0.0)
    for axis, count in enumerate(z.shape):  # no cross of leakage along the axes
        z = z * np.expand_dims(np.hanning(count + 2)[1:-1], 1 - axis)
    power = np.abs(np.fft.rfft2(z)) ** 2
    rows, columns = z.shape
    kx = np.fft.rfftfreq(columns, scan.pixel[0])
    ky = np.fft.fftfreq(rows, scan.pixel[1])[:, None]
    # Waves with few periods in the scan have no well-defined direction.
    power[np.hypot(kx * scan.size[0], ky * scan.size[1]) < _SHORTEST_WAVE] = 0.0
    across = np.arctan2(ky, kx)
    lay = np.broadcast_to(np.mod(across + 0.5 * math.pi, math.pi), power.shape)
    bins = np.minimum((lay * (180 / math.pi)).astype(int), 179)
    angular = np.bincount(bins.reshape(-1), power.reshape(-1), 180)
    around = np.convolve(np.tile(angular, 3), np.hanning(2 * _WEDGE + 3)[1:-1], "same")[180:360]
    best = math.radians(float(around.argmax()) + 0.5)
    off = np.mod(lay - best + 0.5 * math.pi, math.pi) - 0.5 * math.pi
    near = np.where(np.abs(off) <= math.radians(_WEDGE), power, 0.0)
    return float(np.mod(best + (near * off).sum() / near.sum(), math.pi))


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


def _hills(scan: HeightMap) -> tuple[float, float, float]:
    """S10z, Spd and Spc of the hills, and dales, that Wolf pruning leaves."""
    heights = scan.heights
    inner = present(heights, 1).reshape(-1)
    height = float(np.nanmax(heights) - np.nanmin(heights))

    def left(surface: Floats) -> np.ndarray:
        peaks = find_peaks(surface)
        return peaks.places[(peaks.prominences >= PRUNING * height) & inner[peaks.places]]

    hills, dales = left(heights), left(-heights)
    flat, ten = heights.reshape(-1), math.nan
    if min(hills.size, dales.size) >= _FIVE:  # from the highest, and from the deepest
        ten = float(flat[hills[:_FIVE]].mean() - flat[dales[:_FIVE]].mean())
    if not hills.size:
        return ten, 0.0, math.nan
    area = np.count_nonzero(inner) * math.prod(scan.pixel)
    tops = fitted(heights, hills, scan.pixel, 3)
    return ten, hills.size / area, float(tops.curvatures.mean())


def slope_over_distance(scan: HeightMap) -> tuple[Floats, Floats]:
    """Rms slope between points, against their distance; errors as :meth:`measurable`.

    Returns
    -------
    tuple of ndarray
        Distances [m], doubling from one pixel to a quarter of the scan, and the root mean
        square of the difference in height over the distance [-], in the mean over the axes;
        one-dimensional (Sanner et al. 2022, DOI 10.1016/j.apsadv.2021.100190).
    """
    heights, distances, slopes = scan.measurable().heights, [], []
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


_SECTIONS = 5
"""Sections of an evaluation length where no cut-off says how long one is (ISO 21920-3)."""
_THRESHOLD = 0.1
"""Share of Rp and Rv that the hill and the dale of a profile element must exceed."""
_SLOPE = np.array([1.0, -9.0, 45.0, 0.0, -45.0, 9.0, -1.0]) / 60.0
"""Weights of the local slope (ISO 21920-2), of heights ahead first."""


@dataclass(frozen=True)
class ProfileParameters:
    """Height, spacing, hybrid and material ratio parameters after ISO 21920-2:2021, SI units."""

    mean_deviation: float = of("Ra", "m", "arithmetic mean height")
    rms: float = of("Rq", "m", "rms height")
    skewness: float = of("Rsk", "", "skewness")
    kurtosis: float = of("Rku", "", "kurtosis")
    peak_height: float = of("Rp", "m", "mean peak height of the sections")
    pit_depth: float = of("Rv", "m", "mean pit depth of the sections")
    height: float = of("Rz", "m", "mean height of the sections")
    total_height: float = of("Rt", "m", "height over the evaluation length")
    spacing: float = of("Rsm", "m", "mean width of the profile elements")
    """Not a number without two elements: hills and dales that exceed a tenth of Rp and Rv."""
    rms_gradient: float = of("Rdq", "", "rms gradient")
    core_height: float = of("Rk", "m", "core height")
    reduced_peak_height: float = of("Rpk", "m", "reduced peak height")
    reduced_pit_depth: float = of("Rvk", "m", "reduced pit depth")
    peak_material_ratio: float = of("Rmrk1", "", "material ratio of peaks")
    pit_material_ratio: float = of("Rmrk2", "", "material ratio of pits")
    section: float = of("lsc", "m", "section length")
    sections: float = of("nsc", "", "sections")


def profile_parameters(
    scan: HeightMap, section: float | str | None = None, axis: Literal["x", "y"] = "x"
) -> ProfileParameters:
    """Parameters of ISO 21920-2:2021: Ra, Rq, Rz, Rsm, Rdq, Rk and others, in SI units.

    Of the heights as they are, each line above its mean: level them first, and apply the
    long-wave cut-off that goes with the numbers.

    Parameters
    ----------
    section : float or str, optional
        Section length [m], or such as "0.8 mm"; by default the long-wave cut-off, or a fifth
        of the profile where there is none.
    axis : {"x", "y"}
        Of an area the lines along x or along y: the parameters are the means over all lines
        without gaps.

    Returns
    -------
    ProfileParameters
        The parameters, with the section length and how many sections there are.
    """
    if not isinstance(axis, str) or axis not in ("x", "y") or (axis == "y" and scan.is_profile):
        raise InputError(f'`axis` must be "x", or "y" of an area, got {show(axis)}')
    lines = np.atleast_2d(scan.measurable().heights)
    lines = lines if axis == "x" else lines.T
    step = scan.pixel[0 if axis == "x" else -1]
    if scan.is_profile:  # ends that are missing, as a filter leaves them
        there = np.flatnonzero(~np.isnan(lines[0]))
        lines = lines[:, there[0] : there[-1] + 1]
    lines = lines[~np.isnan(lines).any(axis=1)]
    if not lines.size:
        raise InputError(
            f"{scan.name[:60]}: no line is without gaps; fill them first: "
            'scan.condition(fill="interpolate")'
        )
    length = lines.shape[1] * step
    if section is not None:
        length_asked = length_of("section", section, "0.8 mm")
    elif scan.long_cutoff is not None and scan.long_cutoff <= length:
        length_asked = scan.long_cutoff
    else:
        length_asked = length / _SECTIONS
    points = math.floor(length_asked / step + 1e-9)
    if not 4 <= points <= lines.shape[1]:
        raise InputError(
            f"`section` must be four points or more and no longer than the profile, {length:.4g} "
            f"m, got {length_asked:.4g} m"
        )
    z = lines - lines.mean(axis=1, keepdims=True)
    rms = np.sqrt((z * z).mean(axis=1))
    flat = rms <= 1e-12 * np.abs(lines).max()
    if flat.all():
        raise InputError(f"{scan.name[:60]}: the heights along {axis} must vary")
    z, rms = z[~flat], rms[~flat]
    unit = z / rms[:, None]
    count = z.shape[1] // points
    parts = z[:, : count * points].reshape(z.shape[0], count, points)
    peaks, pits = parts.max(axis=2).mean(axis=1), -parts.min(axis=2).mean(axis=1)
    slopes = (
        sum(weight * z[:, 6 - k : z.shape[1] - k] for k, weight in enumerate(_SLOPE)) / step
        if z.shape[1] > _SLOPE.size
        else np.full((1, 1), math.nan)
    )
    spacings = [_spacing(*line) * step for line in zip(z, peaks, pits, strict=True)]
    widths = [width for width in spacings if math.isfinite(width)]
    core = np.array([core_of(line) for line in z]).mean(axis=0)
    return ProfileParameters(
        float(np.abs(z).mean(axis=1).mean()),
        float(rms.mean()),
        float((unit**3).mean(axis=1).mean()),
        float((unit**4).mean(axis=1).mean()),
        float(peaks.mean()),
        float(pits.mean()),
        float((peaks + pits).mean()),
        float((z.max(axis=1) - z.min(axis=1)).mean()),
        float(np.mean(widths)) if widths else math.nan,
        float(np.sqrt((slopes * slopes).mean(axis=1)).mean()),
        *map(float, (*core, points * step, count)),
    )


def _spacing(line: Floats, peak: float, pit: float) -> float:
    """Mean width of the profile elements, in points; not a number where there are not two.

    An element is a hill and the dale after it, or a dale and its hill, each beyond its threshold;
    they are bounded by crossings of the mean line, seen from both ends (ISO 21920-2).
    """
    widths: list[Floats] = []
    for values in (line, line[::-1]):
        side = np.where(values > _THRESHOLD * peak, 1, np.where(values < -_THRESHOLD * pit, -1, 0))
        beyond = np.flatnonzero(side)
        changes = np.flatnonzero(np.diff(side[beyond]))
        # The last crossing before the next hill or dale is entered.
        sign = np.where(values > 0.0, 1, -1)
        crossings = np.flatnonzero(np.diff(sign))
        if changes.size < 3 or not crossings.size:
            continue
        last = crossings[np.searchsorted(crossings, beyond[changes + 1]) - 1]
        places = last + values[last] / (values[last] - values[last + 1])
        widths.append(places[2:] - places[:-2])
    return float(np.concatenate(widths).mean()) if widths else math.nan
