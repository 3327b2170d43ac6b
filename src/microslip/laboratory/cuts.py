"""Sample indices at which the cycles of a record start, reverse and end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.errors import InputError

Places = NDArray[np.int64]

BAND = 0.25
"""Half-width, over the amplitude, of the band that a half cycle must cross to count."""
WIDEST = 0.35
"""Largest half width [rad] of the windows around the turning points."""
FEWEST_SAMPLES = 8
_SLACK = 0.01  # of a cycle: as much may be missing at an end of the record


class Cuts(NamedTuple):
    """Sample indices of the cycles of a record; each cycle ends where the next one begins.

    Cycles run between successive peaks, troughs, up-crossings or down-crossings of the
    displacement, whichever gives the most cycles. If ``flipped``, "peaks" are minima: displacement
    and force must be negated, which leaves a loop unchanged.
    """

    cuts: Places
    """Samples at which cycles begin, and the end of the last: one more than there are cycles."""
    peaks: Places
    """First reversal of each cycle, not before its beginning."""
    troughs: Places
    """Second reversal of each cycle."""
    flipped: bool
    """Whether peaks are minima and troughs maxima of the displacement."""
    window: int
    """Half-width of the windows around the turning points, chosen by the noise [samples]."""
    period: float
    """Samples per cycle."""
    noise: float
    """Standard error of half the range of a cycle due to noise [m]."""

    def selected(self, begin: int, end: int, origin: int = 0) -> Cuts:
        """Return the cycles ``begin`` to ``end`` (exclusive), with places counted from a sample."""
        return self._replace(
            cuts=self.cuts[begin : end + 1] - origin,
            peaks=self.peaks[begin:end] - origin,
            troughs=self.troughs[begin:end] - origin,
        )


def runs_of(mask: NDArray[Any]) -> NDArray[np.intp]:
    """Return first index and end (exclusive) of each run of true values (runs, 2)."""
    return np.flatnonzero(np.diff(mask, prepend=False, append=False)).reshape(-1, 2)


def noise_of(values: Floats) -> float:
    """Estimate the standard deviation of white noise on a smooth signal from its differences.

    A difference of order k has comb(2 k, k) times the variance of the noise. The smallest estimate
    of orders 3 to 7 is used, since the signal adds to each; medians are insensitive to kinks.
    """
    piece = values[: 1 << 17]
    if piece.size < 16:
        return 0.0
    return min(
        float(np.median(np.abs(np.diff(piece, k)))) / 0.6745 / math.sqrt(math.comb(2 * k, k))
        for k in range(3, 8)
    )


class Swing(NamedTuple):
    """Middle, amplitude (half the range) and noise of a displacement [m], and period [samples]."""

    middle: float
    amplitude: float
    noise: float
    period: float
    relative_noise: float
    """Noise of the displacement or of the force, the larger over half its range [-]."""


def swing_of(displacement: Floats, force: Floats, gaps: Sequence[int] = ()) -> Swing:
    """Estimate middle, amplitude, noise and period of a displacement between ``gaps`` [samples]."""
    sampled = displacement[:: max(1, displacement.size >> 17)]
    low, high = (float(value) for value in np.percentile(sampled, (1.0, 99.0)))
    middle, amplitude = 0.5 * (low + high), 0.5 * (high - low)
    if amplitude == 0.0:
        raise InputError(f"`displacement` must vary, got {displacement[0]:g} m nearly throughout")
    x = displacement - middle
    edges = [0, *(gap + 1 for gap in gaps), x.size]
    crossings = [_crossings(x[a:b], BAND * amplitude)[0] for a, b in pairwise(edges)]
    halves = np.concatenate([np.diff(places) for places in crossings])
    if halves.size == 0:
        number = sum(len(places) for places in crossings)
        times = ("never", "once")[number] if number < 2 else f"{number} times"
        raise InputError(
            f"no full cycle: the displacement crosses its middle {middle:g} m {times}; a cycle "
            "needs at least two crossings"
        )
    wholes = np.concatenate([places[2:] - places[:-2] for places in crossings])
    period = float(np.median(wholes)) if wholes.size else 2.0 * float(np.median(halves))
    if period < FEWEST_SAMPLES:
        raise InputError(
            f"a cycle must have at least {FEWEST_SAMPLES} samples, got {period:.3g}: "
            "this is noise, or sampled too coarsely"
        )
    noise = noise_of(x)
    spread = float(np.ptp(force[:: max(1, force.size >> 17)]))
    noise_in_force = 2.0 * noise_of(force) / spread if spread > 0.0 else 0.0
    return Swing(middle, amplitude, noise, period, max(noise / amplitude, noise_in_force))


_REPEATED, _CLOSED = 0.3, 4.0
"""Distance of both ends of a loop, in steps between samples, up to which they are the same sample,
or neighbours."""


def one_loop(x: Floats, force: Floats) -> tuple[int, bool, bool]:
    """Return the number of samples of a loop, whether it is one cycle, and whether it closes.

    A last sample that repeats the first one is not counted.
    """
    spans = [float(np.ptp(values)) or 1.0 for values in (x, force)]
    way = np.hypot(np.diff(x) / spans[0], np.diff(force) / spans[1])
    gap = math.hypot((x[-1] - x[0]) / spans[0], (force[-1] - force[0]) / spans[1])
    usual, near = (float(np.median(one)) for one in (way, way[[0, 1, -2, -1]]))  # short at turns
    size = x.size - 1 if gap < _REPEATED * near else x.size
    low, high = np.percentile(x, (1.0, 99.0)).tolist()  # without spikes
    turns, _ = _crossings(np.tile(x[:size] - 0.5 * (low + high), 3), BAND * 0.5 * (high - low))
    return size, 5 <= turns.size <= 6, gap <= _CLOSED * usual


def candidates(displacement: Floats, motion: Swing) -> tuple[Cuts | None, ...]:
    """Cut cycles at peaks, troughs, up-crossings and down-crossings; None if there are none.

    A half cycle counts if it crosses a band around the middle of the displacement, so that noise
    and plateaus are not counted. A turning point is midway between two crossings if the
    displacement is extreme there within its noise, otherwise at the extreme sample.
    """
    x, period = displacement - motion.middle, motion.period
    window = window_of(motion.relative_noise, period)
    crossings, upwards = _crossings(x, BAND * motion.amplitude)
    if crossings.size < 2:
        return (None,) * 4
    turns = _turns(x, crossings, upwards, window, 6.0 * motion.noise)
    slack = max(1.5, _SLACK * period)
    near = 2.0 * BAND * motion.amplitude
    # Of two heights, each from a parabola through the window.
    noise = motion.noise * math.sqrt(0.5 * min(1.0, 2.25 / (2 * window + 1)))
    # Up-crossings, peaks, down-crossings and troughs, each with what may lie beyond the first and
    # the last that are seen: the record may begin or end on one.
    ups = _extended(crossings[upwards], period, x, 0.0, near, slack)
    downs = _extended(crossings[~upwards], period, x, 0.0, near, slack)
    tops = _extended_turns(turns, upwards[:-1], period, x, near, slack)
    bottoms = _extended_turns(turns, ~upwards[:-1], period, x, near, slack)
    return tuple(
        None
        if (places := _whole(cuts, peaks, troughs)) is None
        else Cuts(*places, flipped, window, period, noise)
        for cuts, peaks, troughs, flipped in (
            (tops, tops, bottoms, False),
            (bottoms, bottoms, tops, True),
            (ups, tops, bottoms, False),
            (downs, bottoms, tops, True),
        )
    )


def len_of(cycles: Cuts | None) -> int:
    """Return the number of cycles; 0 for None."""
    return 0 if cycles is None else cycles.cuts.size - 1


def _crossings(x: Floats, band: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Return zero crossings [samples], and a mask of the upward ones.

    Each is between two successive values outside the range from -``band`` to ``band``.
    """
    outside = np.flatnonzero(np.abs(x) > band)
    if outside.size == 0:
        return np.zeros(0), np.zeros(0, dtype=bool)
    above = x[outside] > 0.0
    last = np.flatnonzero(above[1:] != above[:-1])
    begin, end = outside[last], outside[last + 1]
    upwards = above[last + 1]
    # Noise crosses the middle several times: their mean. All changes of sign are in these gaps,
    # or in the bands of half cycles that did not count.
    changes = np.flatnonzero((x[1:] > 0.0) != (x[:-1] > 0.0))
    gap = np.searchsorted(end, changes, side="right")
    gap_ok = gap < end.size
    gap_ok[gap_ok] &= changes[gap_ok] >= begin[gap[gap_ok]]
    changes, gap = changes[gap_ok], gap[gap_ok]
    place = changes + x[changes] / (x[changes] - x[changes + 1])
    count = np.bincount(gap, minlength=end.size)
    return np.bincount(gap, place, minlength=end.size) / count, upwards


def window_of(noise: float, period: float) -> int:
    """Return the half-width [samples] of windows for parabolas fitted to the peaks of a sine.

    With this width the bias of the fitted peak equals its standard error. ``noise`` is relative to
    the amplitude [-], ``period`` is in [samples].
    """
    angle: float = (420.0 * noise / math.sqrt(period / math.pi)) ** (2.0 / 9.0)
    return math.floor(min(angle, WIDEST) * period / (2.0 * math.pi))


def _turns(
    x: Floats, crossings: Floats, upwards: NDArray[np.bool_], window: int, tolerance: float
) -> Places:
    smooth = x
    if window > 0:
        sums = np.concatenate((np.zeros(1), np.cumsum(x)))
        first = np.clip(np.arange(x.size) - window, 0, None)
        last = np.clip(np.arange(x.size) + window + 1, None, x.size)
        smooth = (sums[last] - sums[first]) / (last - first)
    edges = np.ceil(crossings).astype(np.int64)
    middle = np.rint(0.5 * (crossings[1:] + crossings[:-1])).astype(np.int64)
    turned = smooth[: edges[-1]]
    highest = np.maximum.reduceat(turned, edges[:-1])
    lowest = np.minimum.reduceat(turned, edges[:-1])
    sign = np.where(upwards[:-1], 1.0, -1.0)
    extreme = np.where(upwards[:-1], highest, lowest)
    short = sign * (extreme - smooth[middle])
    for i in np.flatnonzero(short > tolerance / math.sqrt(2 * window + 1)):
        half = sign[i] * smooth[edges[i] : edges[i + 1]]
        middle[i] = edges[i] + int(np.argmax(half))
    return middle


def _extended(
    places: Floats, period: float, x: Floats, value: float, near: float, slack: float
) -> Floats:
    """Add a cut one period before the first and after the last one if x is near ``value`` there.

    ``near`` [m] is the tolerance of x, ``slack`` [samples] that of the end of the record.
    """
    for step in (-period, period):
        if places.size == 0:
            break
        if places.size > 1:  # the frequency may be another one elsewhere
            own = float(places[1] - places[0] if step < 0.0 else places[-1] - places[-2])
            step = math.copysign(own, step)
        end = float(places[0] if step < 0.0 else places[-1]) + step
        if not -slack <= end <= x.size - 1 + slack:
            continue
        end = min(max(end, 0.0), x.size - 1.0)
        if abs(x[round(end)] - value) <= near:
            places = np.insert(places, 0 if step < 0.0 else places.size, end)
    return places


def _extended_turns(
    turns: Places, is_kind: NDArray[np.bool_], period: float, x: Floats, near: float, slack: float
) -> Floats:
    places = turns[is_kind].astype(float)
    if places.size == 0:
        turn = float(turns[0])
        places = np.array([turn - 0.5 * period, turn + 0.5 * period])
        inside = (places >= -slack) & (places <= x.size - 1 + slack)
        places = np.clip(places[inside], 0.0, x.size - 1.0)
        extreme = -x[turns[0]]
        return np.asarray(places[np.abs(x[np.rint(places).astype(int)] - extreme) <= near])
    extreme = float(np.median(x[np.rint(places).astype(int)]))
    return _extended(places, period, x, extreme, near, slack)


def _whole(cuts: Floats, peaks: Floats, troughs: Floats) -> tuple[Places, Places, Places] | None:
    """Round to samples if each cycle has a peak followed by a trough; otherwise return None."""
    cut = np.rint(cuts).astype(np.int64)
    if cut.size < 2:
        return None
    peak, trough = (np.rint(turns).astype(np.int64) for turns in (peaks, troughs))
    first = np.searchsorted(peak, cut[:-1])
    second = np.searchsorted(trough, cut[:-1], side="right")
    if first.max() >= peak.size or second.max() >= trough.size:
        return None
    top, bottom = peak[first], trough[second]
    if not np.all((cut[:-1] <= top) & (top < bottom) & (bottom <= cut[1:])):
        return None
    return cut, top, bottom
