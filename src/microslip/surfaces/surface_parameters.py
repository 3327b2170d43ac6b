"""Spatial, hybrid and profile parameters after ISO 25178-2:2021 and ISO 21920-2:2021.

Only the mean height of each line is removed: level and filter the scan first, a profile with its
long-wave cut-off. Profile parameters of an area are means over its lines.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.parameters import parameter
from microslip.surfaces.checks import length_of
from microslip.surfaces.height_map import HeightMap


def declared(symbol: str, unit: str, meaning: str) -> Any:
    """Return a dataclass field that declares a parameter: its symbol, unit and meaning."""
    return field(metadata=parameter(symbol, unit, meaning))


_DECAY = 0.2
"""Correlation that defines the autocorrelation length."""
_BEND = 0.5
"""Range above the knee, in standard scores, where the curve changes between the two lines."""
_STRATIFIED = 0.6
"""Slope of the plateau over that of the valleys below which a face is stratified."""


@dataclass(frozen=True)
class ArealParameters:
    """Spatial and hybrid parameters after ISO 25178-2:2021, in SI units."""

    autocorrelation_length: float = declared("Sal", "m", "autocorrelation length")
    """Shortest distance at which the autocorrelation has fallen to 0.2; NaN if it does not within
    half of the scan."""
    texture_aspect_ratio: float = declared("Str", "", "texture aspect ratio")
    """Smallest over largest radius of the central lobe of the autocorrelation: 1 if isotropic, near
    0 with a lay; NaN if the lobe reaches half of the scan."""
    developed_area_ratio: float = declared("Sdr", "", "developed interfacial area ratio")
    rms_gradient: float = declared("Sdq", "", "root mean square gradient")
    plateau_rms: float = declared("Spq", "m", "plateau rms height")
    """NaN for a face without valleys below a plateau."""


def areal_parameters(scan: HeightMap) -> ArealParameters:
    """Compute Sal, Str, Sdr, Sdq and Spq of ISO 25178-2:2021, in SI units.

    :meth:`Scan.statistics` gives Sq, Sa, Ssk, Sku and Sz. The scan is not conditioned: level and
    filter it first, and state its cut-offs with the parameters. Raises InputError for a profile,
    and the errors of :meth:`measurable`.
    """
    if scan.is_profile:
        raise InputError(
            "a profile has no areal parameters; use profile_parameters(), statistics() or moments()"
        )
    scan = scan.measurable()
    shortest, longest = decay_lengths(_autocorrelation(scan), scan.pixel)
    area_ratio, gradient = _gradients(scan)
    return ArealParameters(
        shortest if math.isfinite(shortest) else math.nan,
        shortest / longest if math.isfinite(longest) else math.nan,
        area_ratio,
        gradient,
        _plateau_rms(scan.heights),
    )


def _autocorrelation(scan: HeightMap) -> Floats:
    there = ~np.isnan(scan.heights)
    z = np.where(there, scan.heights - np.nanmean(scan.heights), 0.0)
    shape = [2 * n for n in z.shape]  # zero padding prevents wrap-around

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
    return np.asarray(middle / full[rows, columns])


def decay_lengths(correlation: Floats, pixel: tuple[float, ...]) -> tuple[float, float]:
    """Return the smallest and largest radius [m] of the central lobe of an autocorrelation.

    The lobe is the connected region with a correlation above 0.2 that contains zero lag (ISO
    25178-2); its edge is interpolated linearly between lags. A radius is infinite if the lobe
    reaches half the length of the scan in its direction.
    """
    from scipy.ndimage import label

    rows, columns = correlation.shape
    above = correlation >= _DECAY
    labels, _ = label(above)
    lobe = labels == labels[rows // 2, columns // 2]
    radii = []
    # Crossings between neighbours along both axes, in both directions.
    for inside, outside, values, along, across in (
        (lobe, above, correlation, pixel[0], pixel[1]),
        (lobe.T, above.T, correlation.T, pixel[1], pixel[0]),
    ):
        middle = [n // 2 for n in values.shape]
        for way in (1, -1):
            near, far = (slice(None, -1), slice(1, None))[::way]
            row, column = np.nonzero(inside[:, near] & ~outside[:, far])
            high, low = values[:, near][row, column], values[:, far][row, column]
            place = column + (way < 0) + way * (high - _DECAY) / (high - low)
            radii.append(np.hypot((place - middle[1]) * along, (row - middle[0]) * across))
    edge = np.concatenate(radii)
    if not edge.size:
        return math.inf, math.inf
    reaches = lobe[0].any() or lobe[-1].any() or lobe[:, 0].any() or lobe[:, -1].any()
    return float(edge.min()), math.inf if reaches else float(edge.max())


def _plateau_rms(heights: Floats) -> float:
    """Return the rms height of a plateau with valleys [m]; NaN without valleys.

    The surface is taken as the lower of two Gaussian surfaces at each point. On a normal
    probability scale its material ratio curve is two straight lines (ISO 13565-3): the slope of the
    upper one is the rms height of the plateau. The lines are fitted by least squares between 0.13 %
    and 99.87 %.
    """
    from scipy.special import ndtr

    z = heights[~np.isnan(heights)]
    scores = np.linspace(-3.0, 3.0, 241)
    curve = np.quantile(z, ndtr(scores))
    best, knee, lower = math.inf, 0.0, 1.0
    for place in scores[20:-60:4]:
        basis = np.stack([np.ones(scores.size), scores - place, np.minimum(scores - place, 0.0)])
        found, error, *_ = np.linalg.lstsq(basis.T, curve, rcond=None)
        if error.size and error[0] < best:
            best, knee, lower = float(error[0]), float(place), float(found[1] + found[2])
    plateau = scores > knee + _BEND
    line = np.polyfit(scores[plateau], curve[plateau], 1)
    upper = float(line[0])
    straight = np.std(curve[plateau] - np.polyval(line, scores[plateau]))
    is_plateau = straight < 0.1 * upper * np.std(scores[plateau]) and upper < _STRATIFIED * lower
    return upper if is_plateau else math.nan


def _gradients(scan: HeightMap) -> tuple[float, float]:
    """Return Sdr and Sdq from the grid cells.

    Sdr is the mean for both divisions of a cell into triangles; Sdq is from the gradient of the
    cell.
    """
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


_SECTIONS = 5
"""Sections per evaluation length if no cut-off gives the section length (ISO 21920-3)."""
_THRESHOLD = 0.1
"""Fraction of Rp and Rv that the hill and the dale of a profile element must exceed."""
_SLOPE = np.array([1.0, -9.0, 45.0, 0.0, -45.0, 9.0, -1.0]) / 60.0
"""Weights of the local slope (ISO 21920-2), heights ahead first."""


@dataclass(frozen=True)
class ProfileParameters:
    """Height, spacing and hybrid parameters after ISO 21920-2:2021, in SI units."""

    mean_deviation: float = declared("Ra", "m", "arithmetic mean height")
    rms: float = declared("Rq", "m", "root mean square height")
    skewness: float = declared("Rsk", "", "skewness")
    kurtosis: float = declared("Rku", "", "kurtosis")
    height: float = declared("Rz", "m", "maximum height per section")
    spacing: float = declared("Rsm", "m", "mean profile element spacing")
    """NaN without two elements: hills and dales that exceed a tenth of Rp and Rv."""
    rms_gradient: float = declared("Rdq", "", "root mean square gradient")
    plateau_rms: float = declared("Rpq", "m", "plateau rms height")
    """Computed over all lines together; NaN for a face without valleys below a plateau."""
    section: float = declared("lsc", "m", "section length")
    sections: float = declared("nsc", "", "sections")


def profile_parameters(
    scan: HeightMap, section: float | str | None = None, axis: Literal["x", "y"] = "x"
) -> ProfileParameters:
    """Compute Ra, Rq, Rz, Rsk, Rku, Rsm, Rdq and Rpq of ISO 21920-2:2021, in SI units.

    Heights are taken relative to the mean of each line: level them first, and apply the long-wave
    cut-off that belongs to the parameters.

    Parameters
    ----------
    section : float or str, optional
        Section length [m], or text such as "0.8 mm"; by default the long-wave cut-off, or a fifth
        of the profile without one.
    axis : {"x", "y"}
        Direction of the lines of an area: parameters are means over all lines without gaps.

    Returns
    -------
    ProfileParameters
        The parameters, the section length and the number of sections.
    """
    if not isinstance(axis, str) or axis not in ("x", "y") or (axis == "y" and scan.is_profile):
        raise InputError(f'`axis` must be "x", or "y" of an area, got {show(axis)}')
    lines = np.atleast_2d(scan.measurable().heights)
    lines = lines if axis == "x" else lines.T
    step = scan.pixel[0 if axis == "x" else -1]
    if scan.is_profile:  # a filter may leave the ends missing
        there = np.flatnonzero(~np.isnan(lines[0]))
        lines = lines[:, there[0] : there[-1] + 1]
    lines = lines[~np.isnan(lines).any(axis=1)]
    if not lines.size:
        raise InputError(
            f"{scan.name[:60]}: every line has gaps; fill them first: "
            'scan.condition(fill="interpolate")'
        )
    length = lines.shape[1] * step
    if section is not None:
        section_length = length_of("section", section, "0.8 mm")
    elif scan.long_cutoff is not None and scan.long_cutoff <= length:
        section_length = scan.long_cutoff
    else:
        section_length = length / _SECTIONS
    points = math.floor(section_length / step + 1e-9)
    if not 4 <= points <= lines.shape[1]:
        raise InputError(
            f"`section` must be four points or more and no longer than the profile, {length:.4g} "
            f"m, got {section_length:.4g} m"
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
    return ProfileParameters(
        float(np.abs(z).mean(axis=1).mean()),
        float(rms.mean()),
        float((unit**3).mean(axis=1).mean()),
        float((unit**4).mean(axis=1).mean()),
        float((peaks + pits).mean()),
        float(np.mean(widths)) if widths else math.nan,
        float(np.sqrt((slopes * slopes).mean(axis=1)).mean()),
        _plateau_rms(z),
        float(points * step),
        float(count),
    )


def _spacing(line: Floats, peak: float, pit: float) -> float:
    """Return the mean width of the profile elements [points]; NaN with fewer than two.

    An element is a hill and the next dale, or a dale and the next hill, beyond the thresholds
    ``peak`` and ``pit``; elements end at crossings of the mean line. The profile is evaluated from
    both ends (ISO 21920-2).
    """
    widths: list[Floats] = []
    for values in (line, line[::-1]):
        side = np.where(values > _THRESHOLD * peak, 1, np.where(values < -_THRESHOLD * pit, -1, 0))
        beyond = np.flatnonzero(side)
        changes = np.flatnonzero(np.diff(side[beyond]))
        # The last crossing before the next hill or dale.
        sign = np.where(values > 0.0, 1, -1)
        crossings = np.flatnonzero(np.diff(sign))
        if changes.size < 3 or not crossings.size:
            continue
        last = crossings[np.searchsorted(crossings, beyond[changes + 1]) - 1]
        places = last + values[last] / (values[last] - values[last + 1])
        widths.append(places[2:] - places[:-2])
    return float(np.concatenate(widths).mean()) if widths else math.nan
