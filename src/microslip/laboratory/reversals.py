"""Reversal points of cycles between samples, and the energy of loops through them.

A polygon through the samples cuts the corners of a loop: with n samples per cycle of a sine its
area is too small by the fraction (2 pi/n)^2/6. So the reversal points are estimated between the
samples, and between them the force is integrated over the displacement by cubics in time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.laboratory.cuts import Cuts, noise_of

_CORNER, _CORNER_OF_MANY, _MANY, _OF_RANGE = 0.7, 0.85, 10, 1e-4
"""Largest sum of squares of a corner over that of a smooth turn, in windows of few and of many
samples, from this half-width on; smallest residual over the range of the displacement of a turn
that is not smooth."""
_EIGHTH, _OF_FLANK, _STRAIGHT = 0.125, 0.7, 1.2
"""Largest half-width of the window around a corner over the period and over the shorter flank, and
largest residual of two lines over the noise in it."""
_FLAT = 0.05
"""Smallest ratio of the slopes on both sides of a corner, or it is the end of a rest."""
_NEAR = 0.5
"""Distance from a reversal within which samples are left out of the branches [samples]."""
_UNSURE = 2.0
"""Standard errors of the position of a reversal within which forces are not used."""
_JUMP = 0.5
"""Smallest change between successive forces, over the range, that is a jump."""
_PIECE = 1 << 15
_GAUSS = np.polynomial.legendre.leggauss(3)


class Reversals(NamedTuple):
    """Reversal points in temporal order, interpolated between the samples."""

    place: Floats
    """Position between samples [samples]."""
    x: Floats
    """Displacement [m]."""
    force: Floats
    """Force at the end of the preceding branch [N]."""


def reversals_of(
    x: Floats, force: Floats, places: NDArray[np.int64], cycles: Cuts, noise: float
) -> Reversals:
    """Estimate the maxima of ``x`` [m] near the samples ``places``, and the force there.

    For minima, negate ``x`` and ``force``. ``noise`` [m] is the standard deviation of the noise of
    x; ``cycles`` gives the period and the width of the windows.
    """
    half = max(3 if cycles.period >= 40.0 else 2, cycles.window)
    t = np.arange(-half, half + 1.0)
    rows = _reflected(x, places, half)
    shift, height, smooth, unsure = _smooth_turns(rows, t, noise)
    wide = _corner_window(x, places, cycles, half, noise)
    is_corner = wide > 0
    if is_corner:
        half = max(half, 3)
        wide = max(wide, half)
        t = np.arange(-wide, wide + 1.0)
        # Smoothing moves the highest sample of a corner with unequal slopes.
        corners = _corners(_reflected(x, places, wide), t, noise)
        places = places + np.rint(corners[0]).astype(np.int64)
        rows = _reflected(x, places, wide)
        is_wide = wide > half
        shift, height, smooth = _flanks(rows, t, noise) if is_wide else _corners(rows, t, noise)
        smooth = smooth[:, wide - half : wide + half + 1]
        unsure = 0.0
    # Before the reversal the force is a smooth function of the remaining displacement. Samples that
    # may lie after the reversal are left out.
    few = half < 4
    gap = 0.0 if few else min(_UNSURE * unsure, 0.5 * half)
    number = 4 if few else max(half - int(gap), 4)
    last = np.floor(places + shift - 0.25 - gap).astype(np.int64)
    at = last[:, None] - np.arange(number)
    column = np.clip(at - places[:, None] + half, 0, 2 * half)
    inside = np.clip(at, 0, x.size - 1)
    way = height[:, None] - (x[inside] if few else np.take_along_axis(smooth, column, axis=1))
    size = np.maximum(np.abs(way).max(axis=1, keepdims=True), 1e-300)
    basis = (way / size)[:, :, None] ** np.arange(3 if few or is_corner else 2)
    normal = np.einsum("cni,cnj->cij", basis, basis) + 1e-12 * np.eye(basis.shape[2])
    right = np.einsum("cni,cn->ci", basis, force[inside])
    ends = np.linalg.solve(normal, right[..., None])[:, 0, 0]
    # A record that begins at a reversal has no branch before it.
    begins = last + 1 < basis.shape[2]
    if begins.any():
        nearest = np.clip(np.rint(places + shift), 0, x.size - 1).astype(np.int64)
        ends = np.where(begins, force[nearest], ends)
    return Reversals(places + shift, height, np.asarray(ends, dtype=np.float64))


def _corner_window(
    x: Floats, places: NDArray[np.int64], cycles: Cuts, half: int, noise: float
) -> int:
    """Return the half-width of the window in which reversals are corners; 0 if they are smooth.

    A reversal is a corner if two straight lines fit better than a quartic. A wide window detects
    corners in noisy samples, but only if the flanks are straight over its width; otherwise a narrow
    window is used.
    """
    turns = np.sort(np.concatenate((cycles.peaks, cycles.troughs)))
    flank = int(np.diff(turns).min(initial=int(cycles.period)))
    for width in (min(int(_EIGHTH * cycles.period), int(_OF_FLANK * flank)), max(half, 3)):
        if width < 3:
            continue
        t = np.arange(-width, width + 1.0)
        rows = _reflected(x, places, width)
        smooth, lines = _smooth_turns(rows, t, noise)[2], _corners(rows, t, noise)[2]
        curved, straight = (
            float(np.median(np.mean((rows - fit) ** 2, axis=1))) for fit in (smooth, lines)
        )
        limit = (_OF_RANGE * float(np.median(np.ptp(rows, axis=1)))) ** 2
        is_noise = straight < (_STRAIGHT * noise) ** 2 or width == max(half, 3)
        # Few samples agree with two lines by chance.
        corner = _CORNER if width < _MANY else _CORNER_OF_MANY
        if curved > limit and is_noise and straight < corner * curved:
            return width
    return 0


def _reflected(x: Floats, places: NDArray[np.int64], half: int) -> Floats:
    rows = np.abs(places[:, None] + np.arange(-half, half + 1))
    return np.asarray(x[np.minimum(rows, 2 * (x.size - 1) - rows)])


def _smooth_turns(rows: Floats, t: Floats, noise: float) -> tuple[Floats, Floats, Floats, float]:
    """Fit a quartic to each row of samples.

    Return the positions [samples] and heights of the maxima, the values of the quartics, and the
    typical standard error of a position [samples].
    """
    powers = t[:, None] ** np.arange(5)
    inverse = np.linalg.pinv(powers)
    c = rows @ inverse.T
    derivative = c[:, 1:] * np.arange(1, 5)
    second = derivative[:, 1:] * np.arange(1, 4)
    shift = np.zeros(rows.shape[0])
    bend = np.where(second[:, 0] < 0.0, second[:, 0], -np.abs(rows).max(axis=1) - 1e-300)
    for _ in range(4):
        s = shift[:, None] ** np.arange(4)
        bend_there = np.einsum("cn,cn->c", second, s[:, :3])
        is_fine = bend_there * bend > 0.0
        bend = np.where(is_fine, bend_there, bend)
        step = np.einsum("cn,cn->c", derivative, s) / bend
        shift = np.clip(shift - step, -0.5 * t[-1], 0.5 * t[-1])
    height = np.einsum("cn,cn->c", c, shift[:, None] ** np.arange(5))
    # The top of a noisy curve is too high, by the variance of its slope over twice its bend.
    bend = np.minimum(bend, -1e-300)
    slope_error = noise * float(np.linalg.norm(inverse[1]))
    height += 0.5 * slope_error**2 / bend
    return shift, height, c @ powers.T, slope_error / abs(float(np.median(bend)))


def _corners(rows: Floats, t: Floats, noise: float) -> tuple[Floats, Floats, Floats]:
    """Fit two straight lines to each row of samples, split where the sum of squares is smallest.

    Return the positions [samples] and heights of the corners, and the values of the lines.
    The corner is the intersection of the lines, limited to the interval between the two samples at
    the split, widened at each end by half a sample and twice the standard error of the position.
    Without this margin a split displaced by noise would make the corner too low, since its height
    is that of the lower line.
    """
    splits = np.arange(2, t.size - 1)
    powers = np.array([np.ones_like(t), t, t * t])
    sums = np.cumsum(powers, axis=1)
    value, moment, square = (np.cumsum(rows * factor, axis=1) for factor in (1.0, t, rows))
    lines, rest, each = [], square[:, -1:], (*sums[:, None], value, moment)
    left = [part[:, splits - 1] for part in each]
    right = [part[:, -1:] - part[:, splits - 1] for part in each]
    for n, st, stt, sx, sxt in (left, right):
        slope = (n * sxt - st * sx) / (n * stt - st * st)
        start = (sx - slope * st) / n
        rest = rest - start * sx - slope * sxt
        lines += [start, slope]
    best = np.argmin(rest, axis=1)[:, None]
    a, b, c, d = (np.take_along_axis(line, best, axis=1) for line in lines)
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = (c - a) / (b - d)
        is_turn = np.minimum(b, -d) > _FLAT * np.maximum(b, -d)
    with np.errstate(divide="ignore"):
        unsure = np.minimum(4.0 * noise / np.sqrt(t[-1]) / np.abs(b - d), t[-1] / 3.0)
    low, high = t[splits[best] - 1] - 0.5 - unsure, t[splits[best]] + 0.5 + unsure
    # At the end of a rest both lines say little about the place, which stays near the sample.
    near = np.clip(np.where(np.isfinite(shift), shift, 0.0), -1.5, 1.5)
    shift = np.where(is_turn, np.clip(shift, low, high), near)
    shape = np.where(t < t[splits[best]], a + b * t, c + d * t)
    height = np.minimum(a + b * shift, c + d * shift)
    return shift[:, 0], height[:, 0], shape


def _flanks(rows: Floats, t: Floats, noise: float) -> tuple[Floats, Floats, Floats]:
    """Fit straight lines on both sides of corners near the middle of rows of noisy samples.

    Samples in the range where noise may place the corner are left out. (Lines split where the sum
    of squares is smallest would follow the noise and underestimate the height of the corner.)
    """
    gap = 1.0
    for _ in range(2):
        lines = []
        for side in (t < -gap, t > gap):
            powers = t[side, None] ** np.arange(2)
            lines += [*(rows[:, side] @ np.linalg.pinv(powers).T).T[:, :, None]]
        a, b, c, d = lines
        bend = max(float(np.median(b - d)), 1e-300)
        gap = min(1.0 + 4.0 * noise / np.sqrt(t[-1]) / bend, 0.5 * t[-1])
    shift = np.clip((c - a) / (b - d), -gap, gap)
    height = 0.5 * (a + b * shift + c + d * shift)
    return shift[:, 0], height[:, 0], np.where(t < shift, a + b * t, c + d * t)


class Branches(NamedTuple):
    """Reversals, start times and energies of the cycles of a block."""

    peaks: Reversals
    troughs: Reversals
    edges: Floats
    """Beginnings of the cycles and end of the last one [samples], not integer."""
    energy: Floats
    """Energy of each cycle [J], closed by its chord."""


def branches_of(x: Floats, force: Floats, cycles: Cuts) -> Branches:
    """Find the reversals of cycles and the energy of each cycle by integration between them."""
    noise = noise_of(x)
    cuts = cycles.cuts
    is_peak_cut = bool(np.array_equal(cuts[:-1], cycles.peaks))
    tops = np.append(cycles.peaks, cuts[-1]) if is_peak_cut else cycles.peaks
    peaks = reversals_of(x, force, tops, cycles, noise)
    low = reversals_of(-x, -force, cycles.troughs, cycles, noise)
    troughs = Reversals(low.place, -low.x, -low.force)
    middle = 0.5 * (float(np.median(peaks.force)) + float(np.median(troughs.force)))
    turns = np.concatenate((peaks.place, troughs.place))
    order = np.argsort(turns, kind="stable")
    turns = turns[order]
    turned_x = np.concatenate((peaks.x, troughs.x))[order]
    turned_force = np.concatenate((peaks.force, troughs.force))[order]
    first, last = int(cuts[0]), int(cuts[-1])
    sample = np.arange(first, last + 1)
    at = np.searchsorted(turns, sample)
    padded = np.concatenate(([-np.inf], turns, [np.inf]))
    kept = sample[np.minimum(sample - padded[at], padded[at + 1] - sample) > _NEAR]
    slot = np.searchsorted(kept, turns)
    time, moved, pushed = (
        np.insert(values, slot, at_turns)
        for values, at_turns in (
            (kept.astype(float), turns),
            (x[kept], turned_x),
            (force[kept] - middle, turned_force - middle),
        )
    )
    reversal = slot + np.arange(turns.size)
    work = _work(time, moved, pushed, reversal)
    if is_peak_cut:
        ends = np.searchsorted(time, peaks.place)
    else:
        ends = np.minimum(np.searchsorted(time, cuts), time.size - 1)
    energy = np.add.reduceat(np.append(work, 0.0), ends[:-1])
    energy[-1] = work[ends[-2] : ends[-1]].sum()
    begin, end = ends[:-1], ends[1:]
    chord = 0.5 * (pushed[begin] + pushed[end]) * (moved[begin] - moved[end])
    n = cycles.peaks.size
    heads = Reversals(*(values[:n] for values in peaks))
    edges = peaks.place if is_peak_cut else cuts.astype(float)
    return Branches(heads, troughs, edges, np.asarray(energy + chord, dtype=np.float64))


def _work(time: Floats, x: Floats, force: Floats, reversal: NDArray[np.intp]) -> Floats:
    """Return the work [J] between successive nodes, which are the samples and the reversals.

    Between reversals, force and displacement are cubics of ``time``; at jumps they are linear.
    """
    number = time.size - 1
    edges = np.unique(np.concatenate(([0], reversal, [number])))
    work = np.empty(number)
    nodes, weights = 0.5 * (_GAUSS[0] + 1.0), 0.5 * _GAUSS[1]
    is_jump = np.abs(np.diff(force)) > _JUMP * np.ptp(force)
    for begin in range(0, number, _PIECE):
        i = np.arange(begin, min(begin + _PIECE, number))
        right = np.searchsorted(edges, i, side="right")
        low, high = edges[right - 1], edges[right]
        stencil = np.clip(i - 1, low, np.maximum(high - 3, low))
        # Cubics overshoot at jumps, as of dry friction.
        is_plain = high - low < 3
        for k in range(3):
            is_plain |= is_jump[np.minimum(stencil + k, number - 1)]
        s = np.minimum(stencil[:, None] + np.arange(4), number)
        t, step = time[s] - time[i][:, None], time[i + 1] - time[i]
        with np.errstate(divide="ignore", invalid="ignore"):
            total = np.zeros(i.size)
            for node, weight in zip(nodes, weights, strict=True):
                away = node * step[:, None] - t
                value, slope = np.zeros(i.size), np.zeros(i.size)
                for k in range(4):
                    others = [m for m in range(4) if m != k]
                    under = np.prod(t[:, k, None] - t[:, others], axis=1)
                    a, b, c = (away[:, m] for m in others)
                    value += force[s[:, k]] * a * b * c / under
                    slope += x[s[:, k]] * (a * b + b * c + a * c) / under
                total += weight * value * slope * step
        plain = 0.5 * (force[i] + force[i + 1]) * (x[i + 1] - x[i])
        work[i] = np.where(is_plain | ~np.isfinite(total), plain, total)
    return work
