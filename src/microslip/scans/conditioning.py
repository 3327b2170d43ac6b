"""From a scan as measured to the heights to evaluate: form, gaps, band of wavelengths."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from microslip._core.frozen import lock
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quoted, show
from microslip.errors import InputError, in_python
from microslip.scans.checks import length_of
from microslip.scans.filters import smooth
from microslip.scans.height_map import HeightMap
from microslip.scans.levelling import level
from microslip.scans.mean_surfaces import robust_mean, spline_mean
from microslip.scans.noise import noise_std
from microslip.scans.options import FILTERS, LEVELS, OUTLIERS
from microslip.scans.outliers_and_gaps import fill, outliers

Map = TypeVar("Map", bound=HeightMap)

_ROUNDING = 1e-14  # of the heights: less is left of an exact plane


@dataclass(frozen=True)
class Steps:
    """Steps of conditioning, in this order; None where skipped."""

    level: Any = None
    outliers: Any = None
    fill: Any = None
    cutoff: Any = None
    long_cutoff: Any = None
    filter: Any = "gaussian"
    crop: Any = None


_MEANS = {"gaussian": smooth, "robust": robust_mean, "spline": spline_mean}
_FILTERS = dict(zip(FILTERS, ("Gaussian", "robust Gaussian regression", "spline"), strict=True))


def condition(scan: Map, steps: Steps) -> Map:
    """Crop, remove outliers, level, fill and limit the band; the notes tell each step."""
    if steps.crop is not None:
        scan = _cropped(scan, steps.crop)
    limit = _threshold(steps.outliers)
    _check_choice("level", steps.level, LEVELS)
    _check_choice("filter", steps.filter, FILTERS)
    _check_choice("fill", steps.fill, ("interpolate",))
    short, long = band(scan, steps.cutoff, steps.long_cutoff)
    heights, notes = scan.heights, list(scan.notes)
    if limit is not None:
        heights, note = _without_outliers(scan, limit)
        notes.append(note)
    else:
        scan.measurable()
    if steps.level is not None:
        before = float(np.nanmax(np.abs(heights)))
        heights, removed = level(heights, scan.pixel, steps.level)
        if float(np.nanmax(np.abs(heights))) <= _ROUNDING * before:
            raise InputError(
                f"{scan.name[:60]}: `level={in_python(steps.level)}` leaves nothing but "
                "rounding: no roughness to measure"
            )
        notes.append(f"level: {steps.level} removed, {engineering(removed, 'm')} high.")
    unfiltered = scan._unfiltered
    if unfiltered is None and (steps.fill, short, long) != (None, None, None):
        unfiltered = scan.changed(lock(heights) if heights is not scan.heights else heights)
    if steps.fill is not None:
        count = int(np.count_nonzero(np.isnan(heights)))
        if count:
            heights = fill(heights)
        notes.append(f"fill: {count} of {heights.size} points interpolated from around them.")
    cutoff, long_cutoff = scan.cutoff, scan.long_cutoff
    noise = scan._noise_before
    if short is not None:
        if scan.cutoff is None and not scan.is_profile:
            noise = scan.noise if heights is scan.heights else noise_std(heights)
        heights = smooth(heights, scan.pixel, short)
        # The exponents of two Gaussians add.
        cutoff = math.hypot(cutoff or 0.0, short)
        sum_ = "" if scan.cutoff is None else f", {engineering(cutoff, 'm')} with the one before"
        notes.append(
            f"cutoff: waves shorter than {engineering(short, 'm')} removed{sum_} (Gaussian filter, "
            "half the amplitude there)."
        )
    if long is not None:
        heights = heights - _MEANS[steps.filter or "gaussian"](heights, scan.pixel, long)
        long_cutoff = min(long, long_cutoff or math.inf)
        notes.append(
            f"long_cutoff: waves longer than {engineering(long, 'm')} removed "
            f"({_FILTERS[steps.filter or 'gaussian']} filter, half the amplitude there)."
        )
    if heights is not scan.heights:
        lock(heights)
    return scan.changed(
        heights,
        notes=tuple(notes),
        cutoff=cutoff,
        long_cutoff=long_cutoff,
        noise_before=noise,
        unfiltered=unfiltered,
    )


def _cropped(scan: Map, crop: Any) -> Map:
    """The scan without its ends; one length of all, or one along x and one along y."""
    lengths = tuple(crop) if isinstance(crop, (tuple, list)) else (crop,)
    if not 1 <= len(lengths) <= len(scan.pixel):
        raise InputError(f"`crop` must be a length, or one an axis, got {show(crop)}")
    ends = [length_of("crop", length, "0.4 mm") for length in lengths]
    ends = ends * len(scan.pixel) if len(ends) == 1 else ends
    counts = [math.ceil(end / step - 1e-9) for end, step in zip(ends, scan.pixel, strict=True)]
    if min(n - 2 * c for n, c in zip(scan.heights.shape[::-1], counts, strict=True)) < 4:
        raise InputError(
            f"`crop` must leave four points along each axis, got {show(crop)} off each end of "
            f"{' x '.join(_readable(size) for size in scan.size)}"
        )
    middle = tuple(
        slice(c, n - c) for n, c in zip(scan.heights.shape, reversed(counts), strict=True)
    )
    note = f"crop: {' x '.join(_readable(end) for end in ends)} cut off each end."
    unfiltered = scan._unfiltered
    if unfiltered is not None:
        unfiltered = unfiltered.changed(lock(np.array(unfiltered.heights[middle])))
    heights = lock(np.array(scan.heights[middle]))
    return scan.changed(heights, notes=(*scan.notes, note), unfiltered=unfiltered)


def band(scan: HeightMap, cutoff: Any, long_cutoff: Any) -> tuple[float | None, float | None]:
    """Both cut-offs [m], if this scan can be filtered so."""
    shortest, longest = 2.0 * max(scan.pixel), min(scan.size)
    cutoffs: list[float | None] = []
    for name, value in (("cutoff", cutoff), ("long_cutoff", long_cutoff)):
        if value is None:
            cutoffs.append(None)
            continue
        length = length_of(name, value, "10 um")
        if not shortest < length < longest:
            where = _beside_bounds(length, shortest, longest)
            raise InputError(
                f"`{name}` must be between two pixels ({_readable(shortest)}) and the size of "
                f"the scan ({_readable(longest)}), got {_readable(length)}: {where}"
            )
        cutoffs.append(length)
    short, long = cutoffs
    if long is not None and (before := short or scan.cutoff) is not None and long <= before:
        raise InputError(
            f"`long_cutoff` must be longer than `cutoff`, got {_readable(long)} and "
            f"{_readable(before)}"
        )
    if short is not None and scan.long_cutoff is not None and short >= scan.long_cutoff:
        raise InputError(
            f"`cutoff` must be shorter than the `long_cutoff` {_readable(scan.long_cutoff)} "
            f"that was applied before, got {_readable(short)}"
        )
    return short, long


def remaining(scan: HeightMap, cutoff: float | None) -> float | None:
    """Cut-off of the filter that takes a scan to a cut-off, whatever was filtered before."""
    before = scan.cutoff
    if cutoff is None or before is None:
        return cutoff
    if math.isclose(cutoff, before, rel_tol=1e-9):
        return None
    shortest = 2.0 * max(scan.pixel)
    length = math.sqrt(max(cutoff - before, 0.0) * (cutoff + before))
    if length > shortest:
        return length
    came, applied = (engineering(value, "m", 4, trim=True) for value in (cutoff, before))
    if cutoff < before:
        raise InputError(
            f"`cutoff` must not be shorter than the {applied} that was applied before, got "
            f"{came}: removed waves cannot be restored; write None, or filter the scan as read"
        )
    next_one = engineering(math.hypot(before, 1.01 * shortest), "m", 4, trim=True)
    raise InputError(
        f"`cutoff` must be the {applied} that was applied before, or at least "
        f"{next_one}, got {came}: what is between takes a filter of two pixels or less"
    )


def _readable(length: float) -> str:
    return engineering(length, "m", 5, trim=True)


def _beside_bounds(length: float, shortest: float, longest: float) -> str:
    if math.isclose(length, shortest, rel_tol=1e-12):
        return "exactly two pixels"
    if math.isclose(length, longest, rel_tol=1e-12):
        return "exactly the size of the scan"
    return "below two pixels" if length < shortest else "beyond the size of the scan"


def _threshold(value: Any) -> float | None:
    if value is None:
        return None
    limit: float = OUTLIERS.checked(value)
    return limit


def _check_choice(name: str, value: Any, words: tuple[str, ...]) -> None:
    if value is not None and (not isinstance(value, str) or value not in words):
        hint = did_you_mean(value, words) if isinstance(value, str) else ""
        raise InputError(f"`{name}` must be {quoted(words)} or None, got {show(value)}{hint}")


def _without_outliers(scan: HeightMap, limit: float) -> tuple[np.ndarray, str]:
    spots = outliers(scan.heights, limit)
    count = int(np.count_nonzero(spots))
    heights = np.where(spots, np.nan, scan.heights) if count else scan.heights
    minimum = 4 if scan.is_profile else 9
    if (remaining_count := int(np.count_nonzero(~np.isnan(heights)))) < minimum:
        raise InputError(
            f"`outliers`: only {remaining_count} of {heights.size} points would be left"
        )
    return heights, (
        f"outliers: {count} of {heights.size} points farther than {limit:g} robust standard "
        "deviations from the median of their neighbours are missing now."
    )
