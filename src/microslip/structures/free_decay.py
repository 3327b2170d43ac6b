"""Frequency and damping from a signal, read as a test reads them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, record
from microslip._core.frozen import LockedArrays
from microslip.errors import InputError


@dataclass(frozen=True, eq=False, repr=False)
class FreeDecay(LockedArrays):
    """Amplitude, frequency and damping ratio along a decaying signal; made by ``read_decay``.

    By zero crossings, and by the analytic signal (Feldman 2011, DOI 10.1016/j.ymssp.2010.07.018).
    """

    time: Floats
    """Middle of each cycle [s]."""
    amplitude: Floats
    """Half the way from peak to peak, in the signal's unit."""
    frequency: Floats
    """Frequencies [Hz]."""
    damping_ratio: Floats
    """Damping ratios [-]."""
    frequency_error: Floats
    """How far two readings differ, by zero crossings and by the analytic signal [Hz]."""
    damping_error: Floats
    """The same of the damping ratio [-]."""

    def __repr__(self) -> str:
        return (
            f"FreeDecay({self.time.size} cycles, {self.frequency[0]:.4g} to "
            f"{self.frequency[-1]:.4g} Hz)"
        )


def read_decay(time: ArrayLike, signal: ArrayLike) -> FreeDecay:
    """Amplitude, frequency and damping of a free decay, cycle by cycle.

    Parameters
    ----------
    time : array_like
        Times [s] in even steps, one-dimensional.
    signal : array_like
        What a sensor shows [m, m/s or any unit], of one mode alone (filter others out before).

    Returns
    -------
    FreeDecay
        For each cycle but those at the ends.

    Notes
    -----
    By zero crossings (linear between samples of alternating sign, after a parabola for the peaks)
    and, independently, by the analytic signal of Hilbert's transform, averaged over a cycle
    (Feldman 2011, DOI 10.1016/j.ymssp.2010.07.018). The first is returned, their difference is the
    error that is told: both read a damping that changes from cycle to cycle differently.
    """
    t, x = record("time", time), record("signal", signal)
    if t.size != x.size:
        raise InputError(f"signal must have one value for each of the {t.size} times, got {x.size}")
    if t.size < 48:
        raise InputError(
            "signal must have at least six cycles of eight samples or more, got "
            f"{t.size} sample{'s' * (t.size > 1)}"
        )
    steps = np.diff(t)
    if steps.min() <= 0.0 or np.ptp(steps) > 1e-6 * steps.mean():
        raise InputError("time must rise in even steps")
    rising = _crossings(t, x)
    if rising.size < 7 or (rising[-1] - rising[0]) / (rising.size - 1) < 8.0 * steps.mean():
        raise InputError(
            f"signal must have at least six cycles of eight samples or more, got {rising.size} "
            "rising zero crossings"
        )
    peaks = _peaks(t, x, rising)
    amplitude = 0.5 * (peaks[:, 0] - peaks[:, 1])
    period = np.diff(rising)
    # Over two cycles around each: a decrement between neighbours sits between them.
    decrement = 0.5 * np.log(amplitude[:-2] / amplitude[2:])
    damping = decrement / np.sqrt(4.0 * math.pi**2 + decrement**2)
    middle = 0.5 * (rising[:-1] + rising[1:])[1:-1]
    frequency = 1.0 / period[1:-1]
    smooth_frequency, smooth_damping = _analytic(t, x, middle, period[1:-1])
    return FreeDecay(
        middle, amplitude[1:-1], frequency, damping,
        np.abs(frequency - smooth_frequency), np.abs(damping - smooth_damping),
    )  # fmt: skip


def _crossings(t: Floats, x: Floats) -> Floats:
    """Times of the rising zero crossings, by the cubic through four samples."""
    low = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    low = low[(low > 0) & (low < x.size - 2)]
    share = -x[low] / (x[low + 1] - x[low])
    for _ in range(4):  # Newton's method on the cubic
        value, slope = _cubic(x, low, share)
        share = np.clip(share - value / slope, 0.0, 1.0)
    return np.asarray(t[low] + share * (t[1] - t[0]))


def _cubic(x: Floats, i: np.ndarray, s: Floats) -> tuple[Floats, Floats]:
    """Lagrange's cubic through samples i - 1 ... i + 2 at i + s, and its slope by s."""
    a, b, c, d = x[i - 1], x[i], x[i + 1], x[i + 2]
    third = (d - 3.0 * c + 3.0 * b - a) / 6.0
    second = 0.5 * (a - 2.0 * b + c)
    first = c - 0.5 * b - a / 3.0 - d / 6.0
    value = b + s * (first + s * (second + s * third))
    return value, first + s * (2.0 * second + 3.0 * s * third)


def _peaks(t: Floats, x: Floats, rising: Floats) -> Floats:
    """Largest and smallest value of each cycle, by the parabola through three samples."""
    result = np.empty((rising.size - 1, 2))
    for k, (begin, end) in enumerate(pairwise(rising)):
        i, j = np.searchsorted(t, (begin, end))
        for side, sign in enumerate((1.0, -1.0)):
            m = int(np.argmax(sign * x[i:j])) + int(i)
            before, here, after = x[m - 1], x[m], x[min(m + 1, x.size - 1)]
            bend = before - 2.0 * here + after
            result[k, side] = here - (after - before) ** 2 / (8.0 * bend) if bend else here
    return result


def _analytic(t: Floats, x: Floats, middle: Floats, period: Floats) -> tuple[Floats, Floats]:
    """Frequency and damping by the analytic signal, each over a cycle around the middles."""
    from scipy.signal import hilbert

    signal = hilbert(x)
    phase = np.unwrap(np.angle(signal))
    height = np.log(np.abs(signal))
    # A moving mean over a cycle takes out the ripple of twice the frequency.
    width = max(1, round(float(period.mean()) / float(t[1] - t[0])))
    kernel = np.full(width, 1.0 / width)
    smooth = np.convolve(height, kernel, mode="same")
    begin, end = middle - 0.5 * period, middle + 0.5 * period
    turned = np.interp(end, t, phase) - np.interp(begin, t, phase)
    fallen = np.interp(begin, t, smooth) - np.interp(end, t, smooth)
    omega = turned / period
    rate = fallen / period
    return omega / (2.0 * math.pi), rate / np.sqrt(omega**2 + rate**2)
