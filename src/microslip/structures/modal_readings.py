"""Frequency and damping against amplitude from the signals of a modal test."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, record, show, whole_number
from microslip._core.errors import InputError
from microslip._core.frozen import LockedArrays
from microslip.structures.periodic_motion import power_of

_LEAST_FALL, _STEADY = 1e-3, 0.05
"""Least decrease of ln(amplitude) over a decay [-], and largest relative difference of both halves
of a steady signal [-]."""


@dataclass(frozen=True, eq=False, repr=False)
class FreeDecay(LockedArrays):
    """Amplitude, frequency and damping ratio of a decaying signal, from ``read_decay``.

    From zero crossings and peaks (Feldman 2011, DOI 10.1016/j.ymssp.2010.07.018).
    """

    time: Floats
    """Middle of each cycle [s]."""
    amplitude: Floats
    """Amplitudes in the unit of the signal: half of peak to peak."""
    frequency: Floats
    """Frequencies [Hz]."""
    damping_ratio: Floats
    """Damping ratios [-]."""

    def __repr__(self) -> str:
        return (
            f"FreeDecay({self.time.size} cycles, {self.frequency[0]:.4g} to "
            f"{self.frequency[-1]:.4g} Hz)"
        )


def read_decay(time: ArrayLike, signal: ArrayLike) -> FreeDecay:
    """Compute amplitude, frequency and damping of a free decay, cycle by cycle.

    Parameters
    ----------
    time : array_like
        Times [s] in even steps, one-dimensional.
    signal : array_like
        Sensor signal [m, m/s or any unit], of one mode alone (filter others out before).

    Returns
    -------
    FreeDecay
        ModeReadings for each cycle except the first and the last one.

    Notes
    -----
    Periods are from zero crossings (cubic through four samples), amplitudes from peaks (parabola
    through three samples; Feldman 2011, DOI 10.1016/j.ymssp.2010.07.018).
    """
    t, x = _signal(time, signal)
    if t.size < 48:
        raise InputError(
            "signal must have at least six cycles of eight samples or more, got "
            f"{t.size} sample{'s' * (t.size > 1)}"
        )
    steps = np.diff(t)
    if steps.min() <= 0.0 or np.ptp(steps) > 1e-6 * steps.mean():
        raise InputError("time must increase in equal steps")
    rising = _crossings(t, x)
    if rising.size < 7 or (rising[-1] - rising[0]) / (rising.size - 1) < 8.0 * steps.mean():
        raise InputError(
            f"signal must have at least six cycles of eight samples or more, got {rising.size} "
            "rising zero crossings"
        )
    peaks = _peaks(t, x, rising)
    amplitude = 0.5 * (peaks[:, 0] - peaks[:, 1])
    if amplitude.min() <= 0.0:
        at = float(rising[int(np.argmin(amplitude))])
        raise InputError(f"signal must change sign in each cycle, which it does not at {at:.6g} s")
    period = np.diff(rising)
    # Over two cycles around each: a decrement between neighbours sits between them.
    decrement = 0.5 * np.log(amplitude[:-2] / amplitude[2:])
    damping = decrement / np.sqrt(4.0 * math.pi**2 + decrement**2)
    middle = 0.5 * (rising[:-1] + rising[1:])[1:-1]
    return FreeDecay(middle, amplitude[1:-1], 1.0 / period[1:-1], damping)


def _signal(time: ArrayLike, signal: ArrayLike) -> tuple[Floats, Floats]:
    t, x = np.atleast_1d(record("time", time, "s")), np.atleast_1d(record("signal", signal))
    if t.size != x.size:
        raise InputError(f"signal must have one value for each of the {t.size} times, got {x.size}")
    largest = float(np.abs(x).max(initial=0.0))
    if largest > 1e100:
        raise InputError(f"signal must have plausible values, got a value of {largest:.4g}")
    return t, x


def _crossings(t: Floats, x: Floats) -> Floats:
    low = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    low = low[(low > 0) & (low < x.size - 2)]
    share = -x[low] / (x[low + 1] - x[low])
    for _ in range(4):  # Newton's method on the cubic
        value, slope = _cubic(x, low, share)
        share = np.clip(share - value / slope, 0.0, 1.0)
    return np.asarray(t[low] + share * (t[1] - t[0]))


def _cubic(x: Floats, i: np.ndarray, s: Floats) -> tuple[Floats, Floats]:
    """Return Lagrange's cubic through samples i - 1 ... i + 2 at i + s, and its derivative by s."""
    a, b, c, d = x[i - 1], x[i], x[i + 1], x[i + 2]
    third = (d - 3.0 * c + 3.0 * b - a) / 6.0
    second = 0.5 * (a - 2.0 * b + c)
    first = c - 0.5 * b - a / 3.0 - d / 6.0
    value = b + s * (first + s * (second + s * third))
    return value, first + s * (2.0 * second + 3.0 * s * third)


def _peaks(t: Floats, x: Floats, rising: Floats) -> Floats:
    """Return maximum and minimum (cycles, 2) between ``rising`` zero crossings, by parabolas."""
    result = np.empty((rising.size - 1, 2))
    for k, (begin, end) in enumerate(pairwise(rising)):
        i, j = np.searchsorted(t, (begin, end))
        for side, sign in enumerate((1.0, -1.0)):
            m = int(np.argmax(sign * x[i:j])) + int(i)
            before, here, after = x[m - 1], x[m], x[min(m + 1, x.size - 1)]
            bend = before - 2.0 * here + after
            result[k, side] = here - (after - before) ** 2 / (8.0 * bend) if bend else here
    return result


_SHARE = 0.1  # of the energy outside of half an octave, from which another mode rings along
_ABOVE_NOISE = 8.0
_UNFILTERED = 4.0  # times that without a filter: the largest sample of a cycle has noise on top
_SETTLING = 4.0  # times one over its width, over which the ends of a record disturb a filter

ModeReadings = tuple[Floats, Floats, Floats]
"""Amplitudes [m], frequencies [Hz], damping ratios [-]."""


def read_ring_down(
    time: ArrayLike, signal: ArrayLike, points: Any, quantity: Any, band: Any
) -> ModeReadings:
    """Read a ring-down; see :meth:`microslip.ModalTest.from_ring_down`."""
    points, power = whole_number("points", points, 1, 1000), power_of(quantity)
    t, x = _signal(time, signal)
    if t.size > 16:
        x = x - x.mean()
        step = float(t[-1] - t[0]) / (t.size - 1)
        even_times = np.linspace(t[0], t[-1], t.size)
        if not step > 0.0 or float(np.abs(t - even_times).max()) > 0.5 * step:
            raise InputError("time must increase in equal steps")
        t = even_times  # what differs by less than half a step is rounding of the file
        if band is None:
            noise, peak = _noise(x, step, 0.5 / step), float(np.abs(x).max())
            noise = max(noise, min(_UNFILTERED * noise, 0.25 * peak / _ABOVE_NOISE))
            part = _above_noise(_single_mode(x, step), 0, noise)
        else:
            ends = floats("band", band, "Hz")
            if ends.shape != (2,):
                raise InputError(
                    f"`band` must be two frequencies [Hz], (150.0, 220.0), got {show(band)}"
                )
            low, high = ends.tolist()
            raw, x, width = x, _filtered(x, step, low, high), high - low
            room = int(_SETTLING / (width * step))
            part = _above_noise(x[: max(x.size - room, 1)], room, _noise(raw, step, width))
        first, last = (math.sqrt(2.0) * float(np.std(half)) for half in np.array_split(x, 2))
        if 2 * x[part].size < x.size and abs(last - first) < _STEADY * first:
            raise _no_decay(first, last)
        t, x = t[part], x[part]
    decay = read_decay(t, x)
    _check_decay(decay.amplitude)
    amplitude = decay.amplitude / (2.0 * math.pi * decay.frequency) ** power
    values = _means_in_time(decay.time, amplitude, decay.frequency, decay.damping_ratio, points)
    if values[0].size == 0:
        raise InputError("signal must decay, got one without any decay")
    return values


def _check_decay(amplitude: Floats) -> None:
    logarithm, place = np.log(amplitude), np.linspace(-0.5, 0.5, amplitude.size)
    fall = -float(place @ logarithm) / float(place @ place)
    beside = logarithm - logarithm.mean() + fall * place
    error = float(beside.std()) / math.sqrt(float(place @ place))
    if not fall > max(_LEAST_FALL, 3.0 * error):
        raise _no_decay(amplitude[0], amplitude[-1])


def _no_decay(first: float, last: float) -> InputError:
    return InputError(
        f"the signal must decay, got {first:.4g} at first and {last:.4g} at last; if this is a "
        "record of loops, name its column of the force, `force=...`"
    )


def _means_in_time(
    time: Floats, amplitude: Floats, frequency: Floats, damping: Floats, points: int
) -> ModeReadings:
    """Return means over time intervals in which the amplitude decreases by a common factor.

    The damping of an interval is the slope of the logarithm of the amplitude over its cycles, which
    is more accurate than the ratio of two neighbouring amplitudes.
    """
    level = np.log(amplitude)
    lowest = np.minimum.accumulate(level)
    edges = np.linspace(lowest[-1], lowest[0], points + 1)
    place = np.clip(np.searchsorted(edges, lowest, side="right") - 1, 0, points - 1)
    rows = []
    for k in np.unique(place):
        stretch = place == k
        f, zeta = float(frequency[stretch].mean()), float(damping[stretch].mean())
        if stretch.sum() > 2:
            rate = -float(np.polyfit(time[stretch], level[stretch], 1)[0]) / (2.0 * math.pi * f)
            zeta = rate / math.sqrt(1.0 + rate * rate)
        if zeta > 0.0:
            rows.append((math.exp(float(level[stretch].mean())), f, zeta))
    amplitudes, frequencies, dampings = np.array(rows).reshape(-1, 3).T
    return amplitudes, frequencies, dampings


def _filtered(x: Floats, step: float, low: float, high: float) -> Floats:
    from scipy.signal import butter, sosfiltfilt

    if not 0.0 < low < high < 0.5 / step:
        raise InputError(
            f"`band` must increase from above 0 to below half the sample rate, {0.5 / step:g} "
            f"Hz, got {low:g} to {high:g} Hz"
        )
    longest = x.size * step
    if (high - low) * longest < _SETTLING:
        raise InputError(
            f"`band` must be wide enough to settle within the {longest:g} s of the signal, "
            f"{_SETTLING / longest:g} Hz or more, got {low:g} to {high:g} Hz"
        )
    parts = butter(4, [low, high], "bandpass", fs=1.0 / step, output="sos")
    room = min(x.size - 1, int(3.0 / ((high - low) * step)))
    return np.asarray(sosfiltfilt(parts, x, padlen=room))


def _single_mode(x: Floats, step: float) -> Floats:
    """Return the signal if one mode rings; otherwise raise an error with the modes found."""
    fade = 0.5 + 0.5 * np.cos(np.linspace(0.0, math.pi, x.size))  # a ring-down begins with its most
    power = np.abs(np.fft.rfft(x * fade)) ** 2
    places = np.fft.rfftfreq(x.size, step)
    peak = int(np.argmax(power))
    inside = (places > places[peak] / 1.4) & (places < places[peak] * 1.4)
    share = 1.0 - float(power[inside].sum()) / float(power.sum())
    first = float(places[peak])
    if share > _SHARE:
        outside = np.where(inside, 0.0, power)
        second = float(places[int(np.argmax(outside))])
        raise InputError(
            f"signal must be of one mode, got {100.0 * share:.0f} % of its energy elsewhere: it "
            f"rings at {first:.5g} Hz and at {second:.5g} Hz; give "
            f"`band={round(0.85 * first, 1), round(1.15 * first, 1)}` around "
            "the mode that is meant [Hz]"
        )
    return x


def _noise(x: Floats, step: float, width: float) -> float:
    """Return the standard deviation of noise in a bandwidth [Hz], from the last third of x."""
    tail = x[2 * x.size // 3 :]
    window = np.hanning(tail.size)
    power = 2.0 * step * np.abs(np.fft.rfft(tail * window)) ** 2 / float(np.sum(window**2))
    # The median, which modes do not lift; of powers of noise it is ln 2 of their mean.
    return math.sqrt(float(np.median(power)) / math.log(2.0) * width)


def _above_noise(x: Floats, skipped: int, noise: float) -> slice:
    """Return the slice of x from ``skipped`` samples after its peak to the last one above noise."""
    begin = min(int(np.argmax(np.abs(x))) + skipped, x.size - 1)
    loud = np.flatnonzero(np.abs(x[begin:]) > _ABOVE_NOISE * noise)
    return slice(begin, begin + (int(loud[-1]) + 1 if loud.size else x.size))
