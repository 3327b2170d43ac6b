"""Invalid points of a scan: fill values, spikes and gaps, and their replacement."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip._core.units import engineering
from microslip.surfaces.checks import far_points, repeated
from microslip.surfaces.conditioning import condition, filled
from microslip.surfaces.height_map import Map

NORMAL = 1.4826
"""Standard deviation over median absolute deviation of a Gaussian variable [-]."""
_RISE = 2.0  # smallest spike height above its surroundings over the robust rms height
_ABOVE = 6.0  # the same over the robust deviation from the local median
_RING = np.ones((5, 5), dtype=bool)
_RING[1:4, 1:4] = False


def fill_values(heights: Floats) -> NDArray[np.bool_]:
    """Return a mask of heights far from all others, such as 1e38 or a repeated -9999."""
    far = far_points(heights)
    if far.any() or (found := repeated(heights)) is None:
        return far
    return np.asarray(heights == found[0])


def spikes(heights: Floats) -> NDArray[np.bool_]:
    """Return a mask of points that stand out from the ring of 16 points around them.

    A point (or a group of up to 3 x 3) is a spike if it is higher than the highest point of the
    ring, or lower than the lowest point, by twice the robust rms height of the scan and by six
    robust standard deviations of the heights from their local medians. Summits, scratches and
    ridges resolved by the pixel continue on the ring and are kept.
    """
    from scipy import ndimage

    nothing = np.zeros(heights.shape, dtype=bool)
    if heights.ndim != 2 or min(heights.shape) < 8:
        return nothing
    gaps = np.isnan(heights)
    flat = filled(heights) if gaps.any() else heights
    away = flat - ndimage.median_filter(flat, size=5, mode="mirror")
    rms = NORMAL * float(np.median(np.abs(flat - np.median(flat))))
    least = max(_RISE * rms, _ABOVE * NORMAL * float(np.median(np.abs(away))))
    if not least > 0.0:
        return nothing
    if float(np.abs(away).max()) <= least:
        return nothing
    over = flat - ndimage.maximum_filter(flat, footprint=_RING, mode="mirror")
    under = ndimage.minimum_filter(flat, footprint=_RING, mode="mirror") - flat
    centres = (over > least) | (under > least)
    if not centres.any():
        return nothing
    group = ndimage.binary_dilation(centres, np.ones((3, 3), dtype=bool))
    return np.asarray(group & (np.abs(away) > 0.5 * least) & ~gaps)


def repaired(scan: Map) -> Map:
    """Return the scan without fill values and spikes, with missing points interpolated.

    Fill values are heights such as -9999 that many points share exactly, far from all others.
    Spikes exceed all their surroundings by twice the rms height. The notes state the number of
    each; a profile keeps its gaps.

    Returns
    -------
    Scan
        The repaired scan; :attr:`unfiltered` keeps the scan with the gaps.
    """
    heights, notes = scan.heights, list(scan.notes)
    absent = fill_values(heights)
    if count := int(np.count_nonzero(absent)):
        value = engineering(float(heights[absent][0]), "m", 4)
        notes.append(f"repair: {count} points of fill value {value} set as missing.")
        heights = np.where(absent, np.nan, heights)
    pointed = spikes(heights)
    if count := int(np.count_nonzero(pointed)):
        notes.append(f"repair: {count} points of spikes removed.")
        heights = np.where(pointed, np.nan, heights)
    if heights is not scan.heights:
        lock(heights)
    result = scan.changed(heights, notes=tuple(notes))
    if scan.is_profile or result.missing == 0.0:
        return result
    return condition(result.measurable(), fill="interpolate")
