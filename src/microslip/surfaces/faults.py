"""Faults of an instrument or its software in a height map, each detected by its own signature.

Faults are detected in the heights as stored in the file, since filters and levelling hide most of
them. Missing points are ignored. The compared quantities are medians over whole lines, which
scratches and spikes do not affect. In private functions the argument ``lines`` is "rows" or
"columns", for messages; columns are passed transposed, so that a line is always a row of the array.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable

import numpy as np

from microslip._core.checks import Floats
from microslip._core.verdicts import Remark
from microslip.surfaces.levelling import level
from microslip.surfaces.marks import (
    edge_words,
    form_words,
    interpolation_words,
    readable,
    scratch_and_dust_words,
    spike_words,
)
from microslip.surfaces.repair import NORMAL, spikes

FAULT = "fault"
_FEWEST = 16  # points along each side

_CLIPPED = 4.0
"""Number of points at an extreme height over the number at the next height."""
_PEAKS = 0.5
"""Mean height next to gaps, over the standard deviation, above which gaps hide peaks."""
_PEAKS_OF_FEW = 1.5
"""Limit for fewer than eight gaps, one of which may lie on a hill by chance."""
_CERTAIN = 5.0
"""Correlation of both halves of lines, over its standard deviation by chance."""
_WHITE = -0.4
"""Largest correlation of second differences of line offsets; -2/3 for independent offsets."""
_LEAST = 0.02
"""Offsets, waves and steps over the standard deviation of heights, below which they are harmless.
"""
_PARTS = 8
"""Number of parts along the lines whose waves are compared."""
_COHERENT = 30.0
"""Power of the mean wave of all parts over its expected value by chance."""
_LINE = 30.0
"""Power of a wave over the median of its neighbours; exceeded by chance once in a billion."""
_LOWEST = 6
"""Smallest number of waves over the lines that is not form."""
_DIGITS = 0.1
"""Smallest height difference over the standard deviation that counts as coarse."""
_STEP = 6.0
"""Jump between two lines over the usual jump."""
_BOW = 1.0
"""Standard deviation of the quadratic form over that of the residual."""


def faults(heights: Floats) -> list[Remark]:
    """Return remarks on the faults of a height map [m], each with the kind, extent and remedy."""
    if heights.ndim != 2 or min(heights.shape) < _FEWEST:
        return []
    there = heights[~np.isnan(heights)]
    if there.size < 0.2 * heights.size:
        return []
    pointed = spikes(heights)
    found = spike_words(heights, pointed)
    heights = np.where(pointed, np.nan, heights) if found else heights
    plane, flat, form = _levelled(heights)
    std = float(np.nanstd(flat))
    if not std > 0.0:
        return []
    coarse = _few_digits(there, std)
    rms = NORMAL * float(np.nanmedian(np.abs(flat - np.nanmedian(flat))))
    words = [*found, *_clipped(there), *_missing_peaks(heights, flat, std), *coarse]
    words += scratch_and_dust_words(flat, rms)
    of_form = [*form_words("rows", plane), *form_words("columns", plane.T)]
    words += of_form or _bow(form, std)
    for lines, across in (("rows", flat), ("columns", flat.T)):
        raw = heights if lines == "rows" else heights.T
        if coarse:  # lines may be equal because of rounding
            continue
        words += _stuck(lines, raw) or [
            *edge_words(lines, across),
            *interpolation_words(lines, raw),
            *_steps(lines, across, std),
            *(_wave(lines, across, std) or _offsets(lines, across, std)),
        ]
    return [Remark(FAULT, text) for text in words]


def automatic_level(notes: Iterable[str]) -> str:
    """Return the form to remove: quadratic if a note of the scan reports a bow, else a plane."""
    faults = (note.words for note in notes if isinstance(note, Remark) and note.kind == FAULT)
    return "quadratic" if any(words.startswith("bow:") for words in faults) else "plane"


def _levelled(heights: Floats) -> tuple[Floats, Floats, float]:
    """Return heights less a plane, heights less a quadratic form, and their rms difference [m]."""
    plane, _ = level(heights, "plane")
    try:
        flat, _ = level(heights, "quadratic")
    except ValueError:  # too few points
        return plane, plane, 0.0
    return plane, flat, float(np.nanstd(plane - flat))


def _clipped(there: Floats) -> list[str]:
    """Report clipping: too many of the heights ``there`` equal the highest or the lowest one."""
    words = []
    ordered = np.sort(there)
    for name, sign, run in (("tops", "highest", ordered[::-1]), ("dales", "lowest", ordered)):
        at_end = int(np.count_nonzero(run == run[0]))
        if at_end < max(10, 2e-5 * run.size) or at_end == run.size:
            continue
        beside = int(np.count_nonzero(run == run[at_end]))
        if at_end > _CLIPPED * beside:
            words.append(
                f"clipped {name}: {at_end} points have the {sign} height and {beside} the next, "
                "so the instrument range ended there; scan again with a larger range, because "
                "summits and stiffness of a clipped scan are wrong."
            )
    return words


def _missing_peaks(heights: Floats, flat: Floats, std: float) -> list[str]:
    """Report gaps that lie on high ground, from the mean height around each gap."""
    from scipy import ndimage

    gaps = np.isnan(heights)
    labels, count = ndimage.label(gaps)
    if not count:
        return []
    around = ndimage.grey_dilation(labels, size=(3, 3))
    border = (around > 0) & ~gaps
    if not border.any():
        return []
    sums = np.bincount(around[border], flat[border], minlength=count + 1)
    counts = np.bincount(around[border], minlength=count + 1)
    means = sums[counts > 0] / counts[counts > 0]
    height = float(means.mean()) / std
    error = float(means.std()) / std / math.sqrt(means.size)
    if height < (_PEAKS if count >= 8 else _PEAKS_OF_FEW) or height < 5.0 * error:
        return []
    return [
        f"missing peaks: the points around {count} gaps lie {height:.2g} standard deviations above "
        "the mean, so steep or bright tops were not measured; scan again with other lighting, "
        "because interpolated points have no peaks."
    ]


def _few_digits(there: Floats, std: float) -> list[str]:
    levels = np.unique(there[:: max(1, there.size // 200_000)])
    if levels.size < 3 or levels.size > 0.05 * there.size:
        return []
    step = float(np.median(np.diff(levels)))
    if step < _DIGITS * std:
        return []
    return [
        f"heights of few digits: they differ by at least {readable(step)}, {step / std:.2g} of "
        "their standard deviation, which dominates the curvatures; save the scan with more digits, "
        "or filter with a cut-off of many pixels."
    ]


def _bow(form: float, std: float) -> list[str]:
    if form < _BOW * std:
        return []
    return [
        f"bow: the heights contain a quadratic form of {readable(form)} (standard deviation), "
        f'{form / std:.2g} times the residual; remove it with `level="quadratic"`, unless the '
        "parts touch in this form."
    ]


def _stuck(lines: str, heights: Floats) -> list[str]:
    """Report lines that repeat the previous line or have constant height."""
    there = ~np.isnan(heights)
    compared = there[1:] & there[:-1]
    equal = (heights[1:] == heights[:-1]) & compared
    count = compared.sum(axis=1)
    repeated = (count >= 8) & (equal.sum(axis=1) > 0.95 * count)
    number = int(np.count_nonzero(repeated))
    if not number or number > 0.5 * repeated.size:
        return []
    first = int(np.flatnonzero(repeated)[0]) + 1
    return [
        f"stuck lines: {number} of the {lines} repeat the previous one (the first is number "
        f"{first + 1}); remove them, or scan again."
    ]


def _halves(differences: Floats) -> tuple[Floats, Floats]:
    """Return the medians of both halves of each line; 0 where a half is missing."""
    half = differences.shape[1] // 2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # missing lines
        first, second = (
            np.nan_to_num(np.nanmedian(part, axis=1))
            for part in (differences[:, :half], differences[:, half:])
        )
    return first, second


def _offsets(lines: str, flat: Floats, std: float) -> list[str]:
    """Report random offsets of the lines, equal along both halves of each line.

    The offset of a line is taken relative to the mean of both neighbouring lines. For independent
    offsets the variance of this difference is 3/2 of theirs, and its correlation between successive
    lines is -2/3; for waves longer than four lines the correlation is positive. ``flat`` are
    levelled heights with the standard deviation ``std`` [m].
    """
    first, second = _halves(flat[1:-1] - 0.5 * (flat[:-2] + flat[2:]))
    limit = 6.0 * NORMAL * float(np.median(np.abs(first + second)))  # excludes scratches and steps
    sound = np.abs(first + second) <= limit
    first, second = np.where(sound, first, 0.0), np.where(sound, second, 0.0)
    common = float(np.mean(first * second))
    spread = math.sqrt(float(np.mean(first**2) * np.mean(second**2)))
    size = math.sqrt(max(common, 0.0) / 1.5)
    if not size > _LEAST * std or common * math.sqrt(first.size) < _CERTAIN * spread:
        return []
    next_one = 0.5 * float(np.mean(first[1:] * second[:-1]) + np.mean(first[:-1] * second[1:]))
    if next_one > _WHITE * common:
        return []
    word = lines[:-1]
    return [
        f"{word} noise: the {lines} have random offsets of {readable(size)} (standard deviation), "
        f"{size / std:.2g} of that of the heights; subtract the median of each {word} first, or "
        "scan again."
    ]


def _steps(lines: str, flat: Floats, std: float) -> list[str]:
    """Report a permanent jump between two lines, present along both halves."""
    halves = _halves(np.diff(flat, axis=0))
    jumps = 0.5 * (halves[0] + halves[1])
    usual = NORMAL * float(np.median(np.abs(jumps)))
    if not usual > 0.0:
        return []
    places = []
    for at in np.flatnonzero(np.abs(jumps) > max(_STEP * usual, 2.0 * _LEAST * std)):
        around = jumps[max(int(at) - 2, 0) : int(at) + 3] / jumps[at]
        alike = min(half[at] / jumps[at] for half in halves)
        if around.sum() > 0.6 and alike > 0.5 and np.count_nonzero(around > 0.3) == 1:
            places.append((int(at), float(jumps[at])))
    if not places or len(places) > max(3, 0.02 * jumps.size):
        return []
    place, size = max(places, key=lambda found: abs(found[1]))
    return [
        f"stitching steps: between {lines} {place + 1} and {place + 2} all heights jump by "
        f"{readable(abs(size))}, {abs(size) / usual:.2g} times the usual jump"
        + (f", and at {len(places) - 1} more positions" if len(places) > 1 else "")
        + "; stitch again with more overlap, or split the scan there."
    ]


def _wave(lines: str, flat: Floats, std: float) -> list[str]:
    """Report a wave across the lines, of equal phase along them, but not the lay of machining."""
    count = min(_PARTS, flat.shape[1] // 8)
    filled = np.where(np.isnan(flat), 0.0, flat)
    parts = np.array([part.mean(axis=1) for part in np.array_split(filled, count, axis=1)])
    if not float(np.var(parts.mean(axis=0))) < 0.5 * std**2:
        return []
    window = np.hanning(len(flat))
    waves = np.fft.rfft(parts * window, axis=1) / window.sum() * 2.0
    mean = waves.mean(axis=0)
    # For independent waves the ratio follows an F distribution.
    scatter = (np.abs(waves - mean) ** 2).sum(axis=0) / (count - 1) / count
    ratio = np.abs(mean) ** 2 / np.maximum(scatter, 1e-300)
    power = np.abs(mean) ** 2
    best, top = 0.0, 0
    for at in range(_LOWEST, len(power) - 1):
        beside = np.r_[power[max(at // 2, 3) : at - 3], power[at + 4 : 2 * at + 8]]
        score = float(power[at] / np.median(beside)) if beside.size > 6 else 0.0
        best, top = max((best, top), (score, at))
    size = float(np.abs(mean[top]))
    if best < _LINE or size < 2.0 * _LEAST * std or ratio[top] < _COHERENT:
        return []
    return [
        f"vibration lines: a wave of {len(flat) / top:.3g} {lines} with {readable(size)} "
        f"amplitude, {size / std:.2g} of the standard deviation of heights, has the same phase "
        f"along all {lines}. Unless it is a feed mark, scan again without the vibration, or filter "
        "with a longer cut-off."
    ]
