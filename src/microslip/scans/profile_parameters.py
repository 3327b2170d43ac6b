"""Parameters of profiles after ISO 21920-2:2021; of areas the means over their lines.

Nothing is levelled or filtered but for the mean height of each line: give the profile with its
long-wave cut-off applied. Each is checked against closed forms: a sine, Gaussian heights.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats, show
from microslip.errors import InputError
from microslip.scans.checks import length_of
from microslip.scans.height_map import HeightMap
from microslip.scans.material_ratio import core_of, of

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
    scan: HeightMap, section: float | str | None = None, axis: str = "x"
) -> ProfileParameters:
    """See :meth:`microslip.Scan.profile_parameters`."""
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
