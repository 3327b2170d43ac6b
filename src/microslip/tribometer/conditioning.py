"""Conditioning of a record before it is evaluated, and the delay of its force."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats, exact, number, positive, show
from microslip.errors import InputError
from microslip.tribometer.blocks import gaps_of
from microslip.tribometer.cuts import Cuts, split
from microslip.tribometer.delays import lag_of
from microslip.tribometer.estimates import Estimate, trend
from microslip.tribometer.record import Record

LEAST_CUTOFF = 10.0
"""Lowest cutoff of the low-pass, over the frequency of the cycles."""
EVEN_STEPS = 1e-6
"""Steps of the time that differ by less, of their mean, are even."""


def condition(
    record: Record,
    *,
    delay: float = 0.0,
    drift: bool = False,
    cutoff: float | None = None,
    rig_stiffness: float | None = None,
) -> Record:
    """A record as the contact saw it; what was done is in its notes, the given one is not changed.

    Parameters
    ----------
    record : Record
        Record to condition.
    delay : float, optional
        Time [s] by which the force lags behind the displacement, such as :func:`delay_of` found.
    drift : bool
        Whether the straight trend of the middles of the cycles is taken off both channels.
    cutoff : float, optional
        Frequency [Hz] of a low-pass of displacement, force and load alike: a Butterworth filter of
        the fourth order, forth and back, so of no phase. At least 10 times the frequency of the
        cycles, where it changes the area of their loops by less than 1e-6.
    rig_stiffness : float, optional
        Stiffness of the rig in series [N/m], above zero: its deflection is taken off.

    Returns
    -------
    Record
        With steps of even time, one-dimensional, in SI units.

    Notes
    -----
    Uneven time is evened by straight lines first. The area of a loop is that of the harmonics which
    displacement and force share (19.29), so a filter without phase keeps it.
    """
    _check(record)
    channels = {
        key: values
        for key in ("displacement", "force", "normal_load", "commanded", "cycle_number")
        if isinstance(values := getattr(record, key), np.ndarray)
    }
    notes, rate = list(record.notes), record.sample_rate
    delay = number("delay", delay, "s", 1e-4)
    if record.time is not None:
        steps = np.diff(record.time)
        _without_gaps(record)
        jitter = float(steps.std() / steps.mean())
        rate = 1.0 / float(steps.mean())
        if jitter > EVEN_STEPS:
            even_time = np.linspace(record.time[0], record.time[-1], len(record))
            for key, values in channels.items():
                channels[key] = np.interp(even_time, record.time, values)
            notes.append(f"uneven time steps, {jitter:.2g} of their mean, were resampled evenly")
    if delay != 0.0:
        shift, size = delay * _rate(rate, "delay"), len(record)
        if abs(shift) > 0.25 * (size - 1):
            raise InputError(f"`delay` must be less than a quarter of the record, got {delay:g} s")
        place = np.arange(size)
        channels["force"] = np.interp(place + shift, place, channels["force"])
        # Channels without a force of their own are dropped.
        lost = math.ceil(abs(shift))
        inner = slice(0, size - lost) if shift > 0.0 else slice(lost, None)
        channels = {key: values[inner] for key, values in channels.items()}
        notes.append(f"the force was shifted forward by {delay:.6g} s")
    if drift:
        cycles, slopes = split(channels["displacement"], channels["force"]), []
        for key in ("displacement", "force"):
            channels[key], slope = _without_trend(channels[key], cycles)
            slopes.append(slope)
        notes.append(f"drift of {slopes[0]:.3g} m and {slopes[1]:.3g} N a cycle was removed")
    if cutoff is not None:
        cutoff = positive("cutoff", cutoff, "Hz", 100.0)
        sampled = _rate(rate, "cutoff")
        period = split(channels["displacement"], channels["force"]).period
        low = LEAST_CUTOFF * sampled / period
        if not low <= cutoff < 0.5 * sampled:
            raise InputError(
                f"`cutoff` must be from {LEAST_CUTOFF:g} times the frequency of the cycles, "
                f"{low:.6g} Hz, to below half the sample rate, {0.5 * sampled:.6g} Hz, got "
                f"{exact(cutoff)} Hz"
            )
        for key in channels.keys() - {"commanded", "cycle_number"}:
            channels[key] = _low_pass(channels[key], cutoff / sampled)
        notes.append(f"low-pass at {cutoff:g} Hz, forward and backward")
    if rig_stiffness is not None:
        rig_stiffness = positive("rig_stiffness", rig_stiffness, "N/m", 1e8)
        channels["displacement"] = channels["displacement"] - channels["force"] / rig_stiffness
        notes.append(f"deflection of a rig of {rig_stiffness:g} N/m was subtracted")
    changes: dict[str, Any] = {**channels, "time": None, "sample_rate": rate, "notes": tuple(notes)}
    return replace(record, **changes)


def _check(record: Any) -> None:
    if not isinstance(record, Record):
        raise InputError(f"`record` must be a Record, got {show(record)}")


def _rate(rate: float | None, name: str) -> float:
    if rate is None:
        raise InputError(f"{name} needs a record with time or sample_rate")
    return rate


def _without_trend(values: Floats, cycles: Cuts) -> tuple[Floats, float]:
    """Values without the trend of the means of their cycles, and that trend a cycle."""
    first, last = cycles.cuts[:-1], cycles.cuts[1:]
    if first.size < 2:
        raise InputError("drift needs at least two cycles, got 1")
    means = np.add.reduceat(values[: cycles.cuts[-1]], first) / (last - first)
    middle: Floats = 0.5 * (first + last - 1).astype(np.float64)
    slope = trend(middle, means, 0.95).value
    return values - slope * (np.arange(values.size) - middle.mean()), slope * cycles.period


def _without_gaps(record: Record) -> None:
    """Refuse a record whose time has gaps: nothing is filtered or moved across them."""
    gaps = gaps_of(record)
    if gaps.size and record.time is not None:
        raise InputError(
            f"{record.name}: the time has a gap after {exact(record.time[gaps[0]])} s, and nothing "
            "can be resampled, filtered or shifted across it; take the samples of one block"
        )


def _low_pass(values: Floats, cutoff: float) -> Floats:
    from scipy.signal import butter, sosfiltfilt

    sections = butter(4, cutoff, fs=1.0, output="sos")
    length = min(values.size - 1, math.ceil(6.0 / cutoff))
    return np.asarray(sosfiltfilt(sections, values, padlen=length), dtype=float)


def delay_of(record: Record, *, confidence: float = 0.95) -> Estimate:
    """Delay of the force behind the displacement, from the kinks at the reversals.

    Parameters
    ----------
    record : Record
        With time or sample rate and at least two cycles.
    confidence : float, optional
        Level of the interval [-].

    Returns
    -------
    Estimate
        Time [s], positive where the force is late, for ``condition(record, delay=...)``.

    Notes
    -----
    Near a reversal the force is a function of the way of the displacement, one before it and one
    after it, both of low order (19.15, 19.20). The shift with which that fits best is the delay.
    Groups of cycles give the interval, and how far other orders move it. A first-order filter of
    the force's channel looks like a delay of about its time constant.
    """
    _check(record)
    rate = record.sample_rate
    if record.time is not None:
        _without_gaps(record)
        rate = (len(record) - 1) / float(record.time[-1] - record.time[0])
    rate = _rate(rate, "delay_of")
    cuts = split(record.displacement, record.force)
    if cuts.peaks.size < 2:
        raise InputError("delay_of needs at least two cycles, got 1")
    lag = lag_of(record.displacement, record.force, cuts, confidence)
    low, value, high = ((lag.value + way * lag.half) / rate for way in (-1.0, 0.0, 1.0))
    return Estimate(value, low, high, lag.error / rate, lag.number)
