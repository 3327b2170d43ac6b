"""Search for the summits of a scan: positions, heights and radii."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip._core.units import engineering, significant
from microslip.surfaces.checks import length_of
from microslip.surfaces.conditioning import band, condition, remaining
from microslip.surfaces.height_map import HeightMap, present
from microslip.surfaces.peaks import Peaks, equivalent_radii, find_peaks, fitted
from microslip.surfaces.summit_set import Summits as Summits

TIMES_NOISE = 3.0
"""Smallest prominence of a summit, in standard deviations of the noise.

One in two hundred peaks of white noise is as prominent.
"""


def find_summits(
    scan: HeightMap,
    cutoff: float | str | None,
    *,
    prominence: float | str | None = None,
) -> Summits:
    """Find the summits of a levelled scan after the short-wave cut-off.

    A quadric is fitted to three by three points at each.

    Parameters
    ----------
    cutoff : float, str or None
        Short-wave cut-off [m], or text such as "10 um"; None for no filter, so that the pixel
        limits the resolution. There is no default because the result depends on it. Filters already
        applied by :meth:`condition` are taken into account.
    prominence : float or str, optional
        Smallest rise of a summit above the saddle to a higher one [m], or text such as "2 nm"; by
        default three standard deviations of the noise that passes the cut-off.

    Returns
    -------
    Summits
        Positions, heights and radii.
    """
    if not isinstance(scan, HeightMap):
        raise InputError(f"`scan` must be a Scan, got {show(scan)}")
    scan = scan.measurable()
    if scan.is_profile:
        raise InputError(
            f"{scan.name[:60]}: a profile has peaks but no summits; use "
            "condition(cutoff=...).moments().mccool(), which has to_surface(pair, area)"
        )
    rise = prominence
    if rise is not None and not (isinstance(rise, Real) and rise == 0.0):
        rise = length_of("prominence", rise, "2 nm")
    short = remaining(scan, band(scan, cutoff, None)[0])
    noise = scan._noise_behind(short)
    scan = condition(scan, cutoff=short)
    heights = scan.heights
    peaks = find_peaks(heights)
    # A smaller rise may be a plateau tilted by levelling.
    rounding = 16.0 * np.finfo(float).eps * float(np.nanmax(np.abs(heights)))
    peaks = _selected(peaks, peaks.prominences > rounding)
    inner = present(heights, 1).reshape(-1)
    maxima = _selected(peaks, inner[peaks.places])
    if not maxima.places.size:
        raise InputError(
            f"{scan.name[:60]}: no summit, since no point is above its eight neighbours; level "
            'the scan with `level="plane"`'
        )
    flat = heights.reshape(-1)
    mean = float(np.nanmean(heights))
    threshold = TIMES_NOISE * noise if rise is None else rise
    candidates = _selected(maxima, maxima.prominences >= threshold)
    places = candidates.places
    tops = fitted(heights, places, scan.pixel)
    radii, good = equivalent_radii(tops.curvatures)
    clamped = int(np.count_nonzero(good & ~tops.inside))
    if not good.any():
        raise InputError(
            f"{scan.name[:60]}: none of {maxima.places.size} peaks rises "
            f"{engineering(threshold, 'm')} above the saddle to a higher one and is round; use a "
            "smaller prominence or another cut-off"
        )
    rows, columns = np.divmod(places, heights.shape[1])
    positions = (np.stack([columns, rows], axis=1) + tops.shifts) * np.array(scan.pixel)
    notes = (
        *scan.notes,
        *_notes(scan, threshold, rise is None, noise),
        f"summits: {np.count_nonzero(good)} counted of {maxima.places.size} points above their "
        f"eight neighbours; {np.count_nonzero(~good)} dropped as not round; {clamped} kept at the "
        "highest point, because the fitted top lies outside the fitted points.",
    )
    return Summits(
        positions=positions[good],
        heights=(flat[places] + tops.rises - mean)[good],
        radii=radii[good],
        curvatures=tops.curvatures[good],
        prominences=candidates.prominences[good],
        scan=scan,
        cutoff=scan.cutoff,
        area=float(np.count_nonzero(inner) * math.prod(scan.pixel)),
        threshold=float(threshold),
        dropped=int(np.count_nonzero(~good)),
        peaks=maxima.places.size,
        notes=notes,
    )


def _selected(peaks: Peaks, selection: NDArray[np.bool_]) -> Peaks:
    return Peaks(peaks.places[selection], peaks.prominences[selection])


def _notes(scan: HeightMap, threshold: float, by_noise: bool, noise: float) -> tuple[str, ...]:
    pixel = " x ".join(engineering(step, "m", 4) for step in dict.fromkeys(scan.pixel))
    band = (
        f"summits: no short-wave cut-off: the pixel of {pixel} determines density and radius."
        if scan.cutoff is None
        else f"summits: short-wave cut-off {engineering(scan.cutoff, 'm')}; it determines "
        "density and radius."
    )
    why = (
        f", {significant(TIMES_NOISE, 1)} times the noise of {engineering(noise, 'm')}"
        if by_noise
        else ""
    )
    return band, (
        f"summits: prominence at least {engineering(threshold, 'm')}{why}; quadric through "
        "3 x 3 points; radius 1/sqrt(k1 k2)."
    )
