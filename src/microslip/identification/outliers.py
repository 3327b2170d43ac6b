"""What must be right before a mean over cycles is taken: no spikes, and one load."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.errors import InputError, in_python
from microslip.identification.drift import error_of_mean
from microslip.identification.mean_cycle import MeanCycle
from microslip.numerics.runs import runs_of
from microslip.tribometer.record import Record
from microslip.tribometer.spikes import LONGEST, Spike

_FAR, _PART = 20.0, 0.1  # of the noise, and of the range of force: what is off by more is a spike
_NAMED = 3
_STEADY, _CHANGED = 0.02, 0.2  # of the load: ranges of its cycles that go without saying, or not


class Spared(NamedTuple):
    """The cycles that are left, and what to say of the others."""

    selection: NDArray[np.bool_]
    notes: tuple[str, ...]


def cycles_without_spikes(
    is_counted: NDArray[np.bool_], spikes: Sequence[Spike], cycle: NDArray[np.int64], fewest: int
) -> Spared:
    """The chosen cycles without those that have spikes, if ``fewest`` are left."""
    spoiling = []
    for found_spike in spikes:
        of = np.unique(cycle[found_spike.first : found_spike.last + 1])
        if any(0 <= i < is_counted.size and is_counted[i] for i in of):
            spoiling.append((found_spike, of))
    if not spoiling:
        return Spared(is_counted, ())
    is_spared = is_counted.copy()
    for _, of in spoiling:
        is_spared[of[(of >= 0) & (of < is_counted.size)]] = False
    names = ", ".join(str(spike) for spike, _ in spoiling[:_NAMED])
    if len(spoiling) > _NAMED:
        names += f", and {len(spoiling) - _NAMED} more"
    lost_count = int(np.count_nonzero(is_counted) - np.count_nonzero(is_spared))
    if np.count_nonzero(is_spared) < fewest:
        return Spared(is_counted, (f"straight lines stand in the place of spikes: {names}",))
    count = "1 cycle is" if lost_count == 1 else f"{lost_count} cycles are"
    return Spared(is_spared, (f"{count} left out, with spikes that no rig records: {names}",))


def jumps(
    residual: Floats, column: NDArray[np.int64], inside: NDArray[np.bool_], force: Floats
) -> list[Spike]:
    """Single forces far from those of the other cycles at their phase, no spikes by themselves."""
    noise = 1.4826 * float(np.median(np.abs(residual), overwrite_input=True))
    low, high = np.percentile(force, (5.0, 95.0))
    threshold = max(_FAR * noise, _PART * float(high - low))
    is_far = np.zeros(residual.size, dtype=bool)
    # A spike moves the mean of its bin, and with it what is left of all others there.
    for bin_ in np.unique(column[np.abs(residual) > 0.5 * threshold]):
        of_bin = np.flatnonzero(column == bin_)
        is_far[of_bin] = np.abs(residual[of_bin] - np.median(residual[of_bin])) > threshold
    spikes: list[Spike] = []
    rows, usual = np.flatnonzero(inside), 0.5 * float(high - low)
    for first, stop in runs_of(is_far).tolist():
        if stop - first <= LONGEST:
            at = first + int(np.argmax(np.abs(residual[first:stop])))
            ends = int(rows[first]), int(rows[stop - 1])
            spikes.append(Spike("force", *ends, float(force[at]), usual))
    return spikes


class Load(NamedTuple):
    """Normal load [N] of the cycles that count."""

    mean: float | None
    error: float
    """Standard error of the mean [N]; 0 of a load that was given as a number."""
    notes: tuple[str, ...]


def mean_load(
    record: Record, inside: NDArray[np.bool_], cycle: NDArray[np.int64], curve: MeanCycle
) -> Load:
    """Mean normal load of the cycles that count, and a note where it is not the same in all."""
    if not isinstance(record.normal_load, np.ndarray):
        return Load(record.normal_load, 0.0, ())
    load = record.normal_load[inside]
    mean, error = float(load.mean()), error_of_mean(load, cycle, curve)
    cycle_means = np.bincount(cycle, load) / np.bincount(cycle)
    low, high = float(cycle_means.min()), float(cycle_means.max())
    if high - low <= _STEADY * abs(mean):
        return Load(mean, error, ())
    if high - low > _CHANGED * abs(mean):
        raise InputError(
            f"{record.name}: the normal load must be the same in all cycles, got {low:.4g} "
            f"to {high:.4g} N in their means; take a record of one load, or "
            f"`cycles={in_python(slice(0, 10))}`, say"
        )
    note = (
        f"the normal load is {low:.4g} to {high:.4g} N in the means of the cycles; the law counts "
        f"with {mean:.4g} N"
    )
    return Load(mean, error, (note,))
