"""Messages on local faults of a scan: spikes, scratches, dust, edges, kinks, waves.

Heights [m] have their mean plane removed. Each function returns messages on the faults that it
detects, usually none.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.units import engineering

_FAR = 5.0
"""Smallest distance of scratches and dust from the median, in robust standard deviations."""
_EDGE = 3.0
"""Rise of the outermost lines over their neighbours, relative to the usual rise inside."""
_KINK = (0.15, 0.7, 1.3)
"""Largest residual of a kink over those of a line, a parabola, and a wave (a parameter more)."""
_WAVE = 0.3
"""Residual of a wave over that of a parabola below which the form is a wave."""
_PLAIN = 4.0
"""Variance of the mean profile over that about it, above which a wave of it is waviness."""
_GRAIN = 7.0
"""Smallest height of the median grain of dust, in robust standard deviations."""
_GRAINS = 60
"""Largest number of grains of dust."""
_WINDOW = 32
"""Lines of a window in which waves and their images are compared."""
_COHERENT = 0.65
"""Squared coherence of waves and their images; at most 0.5 on faces that are not interpolated."""


def readable(length: float) -> str:
    """Format a length [m] for a message."""
    return engineering(length, "m", 3, trim=True)


def spike_words(heights: Floats, pointed: NDArray[np.bool_]) -> list[str]:
    """Report the spikes found by :func:`microslip.surfaces.repair.spikes`."""
    count = int(np.count_nonzero(pointed))
    if not count:
        return []
    size = float(np.max(np.abs(heights[pointed] - np.nanmedian(heights))))
    return [
        f"spikes: {count} points exceed all points around them by up to {readable(size)}; they "
        "are removed before a face is solved (`repaired()`)."
    ]


def scratch_and_dust_words(flat: Floats, rms: float) -> list[str]:
    """Report a few long grooves far below, or compact grains far above, all other points."""
    from scipy import ndimage

    words = []
    for deep in (True, False):
        far = (flat < -_FAR * rms) if deep else (flat > _FAR * rms)
        total = int(np.count_nonzero(far))
        if not 9 <= total <= 0.04 * flat.size:
            continue
        square = np.ones((3, 3), dtype=bool)
        labels, _ = ndimage.label(ndimage.binary_closing(far, square), square)
        large = []
        for number, part in enumerate(ndimage.find_objects(labels), 1):
            own = labels[part] == number
            y, x = np.nonzero(own)
            if y.size < 9:
                continue
            spread = np.linalg.eigvalsh(np.cov(np.stack([x, y]).astype(float)))
            length = math.sqrt(12.0 * float(spread[1]))
            slender = math.sqrt(float(spread[1]) / max(float(spread[0]), 1.0 / 12.0))
            peak = float(np.nanmax(np.abs(flat[part][own]))) / rms
            large.append((y.size, length, slender, peak))
        most = 5 if deep else _GRAINS
        if not 0 < len(large) <= most or sum(part[0] for part in large) < 0.7 * total:
            continue
        long_ones = [p for p in large if p[2] > 6.0 and p[1] > 0.15 * min(flat.shape)]
        if deep and len(long_ones) == len(large):
            words.append(
                f"scratches: {len(large)} grooves up to {max(p[1] for p in large):.0f} points long "
                f"lie more than {_FAR:g} standard deviations below all other points; if the "
                "joint has none, scan an area without scratches."
            )
        elif not deep and not long_ones and np.median([p[3] for p in large]) > _GRAIN:
            words.append(
                f"dust: grains in {len(large)} places, {total} points, rise more than {_FAR:g} "
                "standard deviations above all other points and would carry the load; clean the "
                "face and scan again, or mark the grains as missing."
            )
    return words


def edge_words(lines: str, flat: Floats) -> list[str]:
    """Report overshoots at the first or last line.

    The mean of the two lines at an edge is compared with that of two lines six lines further
    inside; their rms difference is unusual if it far exceeds that of such pairs inside the scan.
    """
    if len(flat) < 40:
        return []
    there = np.where(np.isnan(flat), 0.0, flat)
    blocks = 0.5 * (there[1:] + there[:-1])
    rises = np.sqrt(np.mean((blocks[6:] - blocks[:-6]) ** 2, axis=1))
    inside = rises[8:-8]
    limit = max(_EDGE * float(np.median(inside)), 2.0 * float(inside.max()))
    ends = [name for name, at in (("first", 0), ("last", -1)) if rises[at] > limit]
    if not ends:
        return []
    return [
        f"edge overshoots: the {' and '.join(ends)} {lines} deviate from their neighbours more "
        "than any lines inside; remove the edges with `crop`."
    ]


def form_words(lines: str, plane: Floats) -> list[str]:
    """Report a kink or a wave of the mean profile across lines."""
    profile = np.median(np.where(np.isnan(plane), 0.0, plane), axis=1)
    x = np.linspace(0.0, 1.0, profile.size)
    line = np.stack([np.ones_like(x), x])

    def residual(*columns: Floats) -> float:
        basis = np.vstack([line, *columns]).T
        found = np.linalg.lstsq(basis, profile, rcond=None)[0]
        return float(np.mean((profile - basis @ found) ** 2))

    straight = residual()
    rest = max(float(np.nanvar(plane)) - straight, 0.0)
    if straight < rest:
        return []
    parabola = residual(x * x)
    waves = {
        f: residual(np.cos(2.0 * math.pi * f * x), np.sin(2.0 * math.pi * f * x))
        for f in np.arange(0.6, 2.6, 0.1).tolist()
    }
    periods = min(waves, key=lambda f: waves[f])
    kinks = {c: residual(np.maximum(x - c, 0.0)) for c in np.arange(0.1, 0.91, 0.02).tolist()}
    place = min(kinks, key=lambda c: kinks[c])
    if kinks[place] < np.min(np.multiply(_KINK, (straight, parabola, waves[periods]))):
        return [
            f"tilted stitch: the {lines} before and after number {round(place * profile.size)} lie "
            "on two different planes; stitch again with more overlap, or split the scan there."
        ]
    if straight > _PLAIN * rest and waves[periods] < _WAVE * parabola:
        return [
            f"waviness: {periods:.2g} periods of a wave across the {lines}, "
            f"{readable(math.sqrt(2.0 * straight))} in amplitude; it remains in the face unless "
            "a `long_cutoff` removes it."
        ]
    return []


def interpolation_words(lines: str, heights: Floats) -> list[str]:
    """Report a scan that was enlarged by a factor of two, from the spectral images of its waves.

    Interpolation adds to each wave of f periods per line spacing a weaker wave of f + 1/2, its
    image. Wave and image are coherent in all windows. If both ends of the lines were kept, their
    relative phase changes by half a period over the scan.
    """
    bends = np.nan_to_num(np.diff(heights, 4, axis=0))
    half = _WINDOW // 2
    starts = range(0, len(bends) - _WINDOW + 1, half)
    if len(starts) < 4:
        return []
    window = np.hanning(_WINDOW + 1)[:-1, None]
    at = np.arange(2, 6)
    crossed, power, image_power = [], np.zeros(at.size), np.zeros(at.size)
    for start in starts:
        part = bends[start : start + _WINDOW]
        weight = 1.0 / max(float(np.mean(part**2)), 1e-300)
        spectrum = np.fft.fft(part * window, axis=0)
        waves, images = spectrum[at], spectrum[at + half]
        crossed.append(weight * np.sum(waves * images.conj(), axis=1))
        power += weight * np.sum(np.abs(waves) ** 2, axis=1)
        image_power += weight * np.sum(np.abs(images) ** 2, axis=1)
    total = power * image_power
    if not (total > 0.0).all():
        return []
    places = np.linspace(0.0, 1.0, len(crossed))[:, None]
    for turn in (-1.0, 0.0, 1.0):
        common = np.sum(np.array(crossed) * np.exp(1j * math.pi * turn * places), axis=0)
        if float(np.mean(np.abs(common) ** 2 / total)) > _COHERENT:
            return [
                f"interpolated {lines}: the heights contain spectral images, as after "
                "interpolation by a factor of two, so the true pixel is probably twice the stated "
                "one; export the scan as measured."
            ]
    return []
