"""Spikes in the channels of a record, caused by a sensor or its cable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.units import engineering
from microslip.laboratory.cuts import noise_of, runs_of
from microslip.laboratory.record import CHANNEL_UNITS, Record

FAR = 5.0
"""Smallest size of a spike over half the usual range, of the record and of its neighbourhood."""
LONGEST = 3
"""Largest number of consecutive samples of a spike."""
AROUND = 8
"""Number of neighbours on each side for comparison."""

_NOISES, _PART = 20.0, 0.1
"""Smallest size of a spike within the range, over the noise and over the range."""
_COARSE = 40.0
"""Samples per cycle below which a turning point of a sine stands out from its neighbours."""


class Spike(NamedTuple):
    """Sample, or up to three consecutive ones, far from the neighbouring samples."""

    channel: str
    """"displacement", "force" or "normal_load"."""
    first: int
    last: int
    value: float
    """Value of the farthest sample [m, N]."""
    usual: float
    """Usual amplitude of the record, or of the neighbours [m, N]: half the range."""

    def __str__(self) -> str:
        unit = CHANNEL_UNITS[self.channel]
        more = self.last > self.first
        where = f"samples {self.first} to {self.last}" if more else f"sample {self.first}"
        return (
            f"{self.channel} {engineering(self.value, unit)} at {where} "
            f"(±{engineering(self.usual, unit)} is usual)"
        )


def spikes_of(record: Record) -> tuple[Spike, ...]:
    """Find the spikes in a record.

    A spike is up to three consecutive samples whose distance from the median of the eight samples
    around them exceeds each of the following limits: five times half the range of these eight
    without the lowest and highest; five times half the range of the record (5th to 95th
    percentile); for a normal load, five times its median. Growing amplitudes and noise are not
    spikes. The limits are not from literature.
    """
    spikes: list[Spike] = []
    for channel, values in record.channels.items():
        if channel in ("displacement", "force", "normal_load"):
            spikes += _spikes_in(channel, values)
    return tuple(spikes)


def without_spikes(record: Record, spikes: Sequence[Spike]) -> Record:
    """Replace the spikes of a record by linear interpolation."""
    if not spikes:
        return record
    channels = {spike.channel for spike in spikes}
    changed: dict[str, Any] = {name: getattr(record, name).copy() for name in channels}
    for spike in spikes:
        changed[spike.channel][spike.first : spike.last + 1] = np.nan
    for values in changed.values():
        bad = np.isnan(values)
        values[bad] = np.interp(np.flatnonzero(bad), np.flatnonzero(~bad), values[~bad])
    return replace(record, **changed)


def _spikes_in(channel: str, values: NDArray[np.float64]) -> list[Spike]:
    sampled = values[:: max(1, values.size >> 17)]
    low, middle, high = (float(value) for value in np.percentile(sampled, (5.0, 50.0, 95.0)))
    usual = 0.5 * (high - low)
    if channel == "normal_load":  # its whole range may be noise or a slow drift
        usual = max(usual, abs(middle))
    # The median of the neighbours is not far outside the range.
    is_far = np.abs(values - middle) > (FAR - 1.0) * usual
    spikes = []
    for first, stop in runs_of(is_far).tolist():
        last = stop - 1
        if last - first >= LONGEST:
            continue
        before = values[max(first - AROUND, 0) : first]
        near = np.sort(np.concatenate((before, values[last + 1 : last + 1 + AROUND])))
        if near.size < AROUND:
            continue
        centre = float(np.median(near))
        off = np.abs(values[first : last + 1] - centre)
        scale = max(usual, 0.5 * float(near[-2] - near[1]))
        if float(off.min()) > FAR * scale:
            value = float(values[first + int(np.argmax(off))])
            spikes.append(Spike(channel, first, last, value, scale))
    return spikes or _peaks_in(channel, values, 2.0 * usual)


def _peaks_in(channel: str, values: NDArray[np.float64], span: float) -> list[Spike]:
    """Find samples that are far from all neighbours, though within the range of the channel.

    ``span`` is the usual range; the distance must be at least a tenth of it. Peaks that occur in
    many cycles, such as coarsely sampled corners, belong to the loop.
    """
    if channel == "normal_load" or values.size < 64:
        return []
    noise = noise_of(values)
    least = max(_NOISES * noise, _PART * span)
    if not least > 0.0:
        return []
    wide = np.lib.stride_tricks.sliding_window_view(values, 2 * LONGEST + 5)
    centre = LONGEST + 2
    outer = np.concatenate((wide[:, :2], wide[:, -2:]), axis=1)
    # A smooth course reaches beyond its neighbours by no more than they differ.
    reach = np.ptp(outer, axis=1)
    at = wide[:, centre]
    off = np.maximum(at - outer.max(axis=1), outer.min(axis=1) - at)
    is_far = np.zeros(values.size, dtype=bool)
    is_far[centre : centre + at.size] = off > np.maximum(least, 2.0 * reach)
    runs = [run for run in runs_of(is_far).tolist() if run[1] - run[0] <= LONGEST]
    rows = np.abs(np.diff(values - 0.5 * (values.max() + values.min()) > 0.0)).sum()
    if len(runs) > 0.5 * max(rows, 2) or 2.0 * values.size < _COARSE * rows:
        return []
    spikes = []
    for first, stop in runs:
        middle = float(np.median(values[max(first - AROUND, 0) : stop + AROUND]))
        value = float(values[first + int(np.argmax(np.abs(values[first:stop] - middle)))])
        spikes.append(Spike(channel, first, stop - 1, value, 0.5 * span))
    return spikes
