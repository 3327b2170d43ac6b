"""Faults that an instrument or its software leaves in a map of heights, each by its own mark.

They are looked for in the heights as they are in the file: filters and levelling hide most of them.
Missing points count nowhere. What is compared is robust (medians over whole lines), so that a
scratch or a spike is none of these faults.
"""

from __future__ import annotations

import math
import warnings

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip._core.verdicts import Remark
from microslip.surfaces.levelling import level
from microslip.surfaces.marks import (
    edge_words,
    form_words,
    interpolation_words,
    scratch_and_dust_words,
    spike_words,
)
from microslip.surfaces.repair import spikes

FAULT = "fault"
_FEWEST = 16  # points along each side
_NORMAL = 1.4826  # standard deviation over median distance

_CLIPPED = 4.0
"""Points at the very end of the heights, over those of the next height of as many digits."""
_PEAKS = 0.5
"""Mean height beside gaps, over the standard deviation, above which gaps hide peaks."""
_PEAKS_OF_FEW = 1.5
"""The same of fewer than eight gaps, one of which may lie on a hill by chance."""
_CERTAIN = 5.0
"""Correlation of both halves of lines, over what chance makes of so many."""
_WHITE = -0.4
"""Correlation of the offset of a line over its neighbours with the next: -2/3 if white."""
_LEAST = 0.02
"""Offsets, waves and steps over the standard deviation of heights, below which they do no harm."""
_PARTS = 8
"""Parts along the lines whose waves are compared."""
_COHERENT = 30.0
"""Power of the mean wave of all parts over what chance makes of it."""
_LINE = 30.0
"""Power of a wave over the median of those beside it; chance reaches it once in a billion."""
_LOWEST = 6
"""Waves over the lines from which on one is no form."""
_DIGITS = 0.1
"""Smallest difference of heights over their standard deviation."""
_STEP = 6.0
"""A jump between two lines over the usual one."""
_BOW = 1.0
"""Standard deviation of the quadratic form over that of what is left."""


def faults(heights: Floats) -> list[Remark]:
    """Faults of a map of heights [m]: kind, number, and remedy."""
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
    rms = _NORMAL * float(np.nanmedian(np.abs(flat - np.nanmedian(flat))))
    words = [*found, *_clipped(there), *_missing_peaks(heights, flat, std), *coarse]
    words += scratch_and_dust_words(flat, rms)
    of_form = [*form_words("rows", plane), *form_words("columns", plane.T)]
    words += of_form or _bow(form, std)
    for lines, across in (("rows", flat), ("columns", flat.T)):
        raw = heights if lines == "rows" else heights.T
        if coarse:  # lines may be alike by their digits
            continue
        words += _stuck(lines, raw) or [
            *edge_words(lines, across),
            *interpolation_words(lines, raw),
            *_steps(lines, across, std),
            *(_wave(lines, across, std) or _offsets(lines, across, std)),
        ]
    return [Remark(FAULT, text) for text in words]


def is_bow(note: str) -> bool:
    """Whether a note of a scan is the fault of a bowed form."""
    return isinstance(note, Remark) and note.kind == FAULT and note.words.startswith("bow:")


def _levelled(heights: Floats) -> tuple[Floats, Floats, float]:
    """Return heights without their plane, without a bow as well, and its standard deviation."""
    plane, _ = level(heights, (1.0, 1.0), "plane")
    try:
        flat, _ = level(heights, (1.0, 1.0), "quadratic")
    except ValueError:  # too few points
        return plane, plane, 0.0
    return plane, flat, float(np.nanstd(plane - flat))


def _long(length: float) -> str:
    return engineering(length, "m", 3, trim=True)


def _clipped(there: Floats) -> list[str]:
    """Points at one end that are as high as the end, far more than just below it."""
    words = []
    ordered = np.sort(there)
    for name, sign, run in (("tops", "highest", ordered[::-1]), ("dales", "lowest", ordered)):
        at_end = int(np.count_nonzero(run == run[0]))
        if at_end < max(10, 2e-5 * run.size) or at_end == run.size:
            continue
        beside = int(np.count_nonzero(run == run[at_end]))
        if at_end > _CLIPPED * beside:
            words.append(
                f"clipped {name}: {at_end} points are all of the {sign} height and {beside} of the "
                "next: the instrument's range ended there; scan again with a longer range, for "
                "summits and stiffness of a clipped scan are wrong."
            )
    return words


def _missing_peaks(heights: Floats, flat: Floats, std: float) -> list[str]:
    """Gaps on high places: the mean of what is beside each gap, over many gaps."""
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
        f"missing peaks: the points beside {count} gaps lie {height:.2g} standard deviations above "
        "the mean: steep or bright tops were not measured; scan again with other light, since "
        "interpolated points have no peaks."
    ]


def _few_digits(there: Floats, std: float) -> list[str]:
    """Heights on a few levels."""
    levels = np.unique(there[:: max(1, there.size // 200_000)])
    if levels.size < 3 or levels.size > 0.05 * there.size:
        return []
    step = float(np.median(np.diff(levels)))
    if step < _DIGITS * std:
        return []
    return [
        f"heights of few digits: they differ by {_long(step)} at least, {step / std:.2g} of their "
        "standard deviation, and curvatures are of these steps; save the scan with more digits, or "
        "filter with a cut-off of many pixels."
    ]


def _bow(form: float, std: float) -> list[str]:
    if form < _BOW * std:
        return []
    return [
        f"bow: a quadratic form of {_long(form)} (standard deviation) is in the heights, "
        f'{form / std:.2g} of all else; take it out by `level="quadratic"`, unless the parts '
        "touch with it."
    ]


def _stuck(lines: str, heights: Floats) -> list[str]:
    """Lines that repeat the one before, or hold one height."""
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
        f"stuck lines: {number} of the {lines} repeat the one before them (the first is number "
        f"{first + 1}); cut them out, or scan again."
    ]


def _halves(differences: Floats) -> tuple[Floats, Floats]:
    """Median along both halves of each line, zero where points are missing."""
    half = differences.shape[1] // 2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of lines that are missing
        first, second = (
            np.nan_to_num(np.nanmedian(part, axis=1))
            for part in (differences[:, :half], differences[:, half:])
        )
    return first, second


def _offsets(lines: str, flat: Floats, std: float) -> list[str]:
    """An offset of each line, the same along both halves of it and white from line to line.

    The offset over the mean of both neighbours' is 3/2 of the variance of offsets and -2/3
    correlated with the next one; that of waves of four lines and more is correlated above zero.
    """
    first, second = _halves(flat[1:-1] - 0.5 * (flat[:-2] + flat[2:]))
    limit = 6.0 * _NORMAL * float(np.median(np.abs(first + second)))  # no scratch, no step
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
        f"{word} noise: each {word} has an offset of its own, {_long(size)} (standard deviation), "
        f"{size / std:.2g} of that of the heights; take the median of each {word} off before, or "
        "scan again."
    ]


def _steps(lines: str, flat: Floats, std: float) -> list[str]:
    """A jump between two lines that is there along both halves of them, and stays."""
    halves = _halves(np.diff(flat, axis=0))
    jumps = 0.5 * (halves[0] + halves[1])
    usual = _NORMAL * float(np.median(np.abs(jumps)))
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
        f"{_long(abs(size))}, {abs(size) / usual:.2g} times what is usual"
        + (f", and at {len(places) - 1} more places" if len(places) > 1 else "")
        + "; stitch again with more overlap, or cut the scan there."
    ]


def _wave(lines: str, flat: Floats, std: float) -> list[str]:
    """One wave across lines, of one phase along each, of a surface whose lay it is not."""
    count = min(_PARTS, flat.shape[1] // 8)
    filled = np.where(np.isnan(flat), 0.0, flat)
    parts = np.array([part.mean(axis=1) for part in np.array_split(filled, count, axis=1)])
    if not float(np.var(parts.mean(axis=0))) < 0.5 * std**2:
        return []
    window = np.hanning(len(flat))
    waves = np.fft.rfft(parts * window, axis=1) / window.sum() * 2.0
    mean = waves.mean(axis=0)
    # Of waves that have nothing to do with each other the ratio is of Fisher's distribution.
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
        f"vibration lines: a wave of {len(flat) / top:.3g} {lines} and {_long(size)} amplitude is "
        f"the same along each, {size / std:.2g} of the heights' standard deviation; if it is no "
        "feed mark, scan again without the vibration, or filter with a longer cut-off."
    ]
