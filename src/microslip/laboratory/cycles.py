"""Cycles of a record and disturbances found in them, for measurements, fits and campaigns.

Detects spikes, open cycles, stepped amplitudes, unsettled friction, drift, delay, clipping and
varying loads.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact, show
from microslip._core.errors import InputError
from microslip._core.units import engineering, significant
from microslip._core.wording import plural
from microslip.laboratory.blocks import Blocks, CycleBlock, blocks_of
from microslip.laboratory.conditioning import lag_of
from microslip.laboratory.cuts import noise_of
from microslip.laboratory.cycle_columns import columns_of
from microslip.laboratory.estimates import trend
from microslip.laboratory.loop_shape import (
    UNDECIDED,
    Shape,
    hollow_of,
    lost_motion_of,
    shape_of,
)
from microslip.laboratory.record import CHANNEL_UNITS, Record, once_a_record
from microslip.laboratory.settling import (
    OPEN,
    Settled,
    excess_loss_notes,
    named_cycles,
    requested,
    settled,
)
from microslip.laboratory.spikes import Spike, spikes_of, without_spikes

DRIFTS = 0.005
"""Smallest drift over the cycles, relative to the range of the channel, that is reported."""
STEADY = 0.02
"""Relative range of the mean loads of the cycles above which it is reported."""
_LATE, _LOOKED_AT, _LEFT, _CONCAVE = 0.02, 40, 0.15, 0.025
"""Smallest relative effect of a lag on the energy; number of cycles it is estimated from; largest
ratio of the misfits with and without the lag, and largest depth of a hollow of the branch over the
force amplitude, for which its removal is suggested."""
_STANDARD_ERRORS, _ALIKE, _THIN = 5.0, 0.2, 1e-3
"""Standard errors of a significant energy; smallest correlation of force and displacement if
a delay has inverted a loop; energy over that of the surrounding ellipse, below which a loop is a
line."""
_CLIPPED, _STEPPED, _SLOWER = 0.005, 5.0, 2.0
"""Smallest fraction of samples exactly at an extreme; ratio to their number on the next converter
step; ratio of the numbers on the next three steps and further inside, if a plateau is approached.
"""
_ROUNDING, _ON_STEP = 1e-7, 0.01
"""Relative difference of values on the same converter step, and largest deviation from a step."""
_QUIET, _ROUGHER = 1e-4, 0.15
"""Noise over the range of a channel, and over that of every other sample, below which it has
none."""
_FROM_REST, _LESS_OPEN = 0.02, 8.0
"""Closure error of a first cycle from rest, and its least ratio to the median of the others."""
_FEW_SAMPLES = 40
"""Samples per cycle below which noise and the course of a loop are not distinguished."""
_COARSE = 0.02
"""Converter step over the force amplitude above which no delay is estimated."""
_IRREGULAR, _FEWEST_PAIRS = 0.12, 5
"""Median relative change of period and amplitude between successive cycles above which a motion is
not cyclic, and fewest cycles for that decision."""
_STEP_ERROR = 12.0**-0.5
"""Standard deviation of a rounding error over the step."""


@dataclass(frozen=True, eq=False)
class Cycles:
    """Cycles of a record with their quantities, spikes and other disturbances."""

    record: Record
    """Record with spikes replaced by straight lines."""
    spikes: tuple[Spike, ...]
    blocks: Blocks
    columns: Mapping[str, Floats]
    """Columns of :data:`~microslip.laboratory.cycle_columns.COLUMN_UNITS` and ``force_rms`` [N],
    without correction for the rig."""
    has_spike: NDArray[np.bool_]
    """Mask of cycles with a spike."""
    is_open: NDArray[np.bool_]
    """Mask of cycles whose end forces differ by over a quarter of the force range."""

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Mask of closed cycles without a spike; if no cycle closes, of all without a spike."""
        closed = ~self.has_spike & ~self.is_open
        return closed if closed.any() else ~self.has_spike

    @property
    def largest_block(self) -> CycleBlock:
        """Block of the record with the most cycles."""
        return max(self.blocks.having_cycles, key=lambda block: block.cycle_count)

    @cached_property
    def settled(self) -> Settled:
        """Cycles without a trend in amplitude, force or energy, over which means are taken."""
        noise = max(block.cycles.noise for block in self.blocks.having_cycles)
        return settled(self.columns, self.counted, noise)

    def selected(self, cycles: slice | None) -> Settled:
        """Return the settled cycles if ``cycles`` is None, otherwise the valid requested cycles."""
        if cycles is None:
            return self.settled
        if not isinstance(cycles, slice):
            raise InputError(f"`cycles` must be a slice, such as slice(2, 20), got {show(cycles)}")
        is_requested = np.zeros(self.is_open.size, dtype=bool)
        is_requested[cycles] = True
        if not (is_requested & self.counted).any():
            raise InputError(
                f"`cycles` must include some of the {np.count_nonzero(self.counted)} valid "
                f"cycles, of {self.is_open.size}, got {show(cycles)}"
            )
        return requested(self.columns, is_requested & self.counted)

    def notes(self, counting: Settled) -> list[str]:
        """Return the notes for the user on a record that is evaluated over the given cycles."""
        return [
            *self.blocks.notes,
            *self._left_out(),
            *counting.notes,
            *excess_loss_notes(self.columns["loss_factor"]),
            *self.plateaus,
            *self.coarse_steps,
            *self._load_notes(counting.selection),
            *self._drifts(counting.selection),
        ]

    def _left_out(self) -> list[str]:
        notes = []
        texts = "; ".join(map(str, self.spikes[:3])) + ("; ..." if len(self.spikes) > 3 else "")
        if self.has_spike.any():
            notes.append(
                f"left out of the means: {named_cycles(self.has_spike)} with spikes, which are "
                f"replaced by straight lines: {texts}"
            )
        elif self.spikes:
            notes.append(f"spikes beyond the whole cycles: {texts}")
        if (self.is_open | self.has_spike).all():
            notes.append(
                "no cycle closes: the end forces of each differ by over a quarter of the range"
            )
        elif self.is_open.any():
            notes.append(
                f"left out of the means: {named_cycles(self.is_open)} whose end forces differ by "
                "over a quarter of the force range, or far more than those of the others, as "
                "during running-in or after a start from rest"
            )
        return notes

    @cached_property
    def plateaus(self) -> list[str]:
        """Notes on channels with extremes at which a sensor may be clipped."""
        notes = []
        for name in ("displacement", "force"):
            values: Floats = getattr(self.record, name)
            step = self.steps.get(name)
            found = {at: _plateau(values, at, step) for at in (values.min(), values.max())}
            texts = [
                f"{engineering(at, CHANNEL_UNITS[name])} in {100.0 * n:.1f} %"
                for at, (n, _) in found.items()
                if n
            ]
            if not texts:
                continue
            words = f"the {name} is exactly {' and '.join(texts)} of its samples: "
            # With few samples per cycle, the shape of a loop resembles noise.
            is_sampled = float(np.median(self.columns["period"])) >= _FEW_SAMPLES
            if is_sampled and any(is_noisy for _, is_noisy in found.values()):
                notes.append(f"{words}a clipped sensor, since the channel has noise elsewhere")
            else:
                notes.append(
                    f"{words}{UNDECIDED} (friction of a channel without noise, or a sensor at its "
                    "limit); a record of a smaller amplitude would identify the cause"
                )
        return notes

    @cached_property
    def steps(self) -> dict[str, float]:
        """Converter steps [m, N] of the channels that lie on steps."""
        channels = {"displacement": self.record.displacement, "force": self.record.force}
        return {name: step for name, x in channels.items() if (step := step_of(x)) is not None}

    @property
    def coarse_steps(self) -> list[str]:
        """Notes on channels whose converter steps are large compared with their range."""
        notes = []
        for name, step in self.steps.items():
            share = step / float(np.ptp(getattr(self.record, name)))
            if 2.0 * share > _COARSE:
                size = engineering(step, CHANNEL_UNITS[name])
                notes.append(
                    f"the {name} lies on a converter's steps of {size}, "
                    f"{significant(100.0 * share, 2)} % of its range; use a smaller measuring range"
                )
        return notes

    @property
    def step_errors(self) -> dict[str, float]:
        """Relative standard deviation of each channel's amplitude due to converter steps [-]."""
        size = {"displacement": "amplitude", "force": "force_amplitude"}
        return {
            channel: step * _STEP_ERROR / abs(float(np.median(self.columns[size[channel]])))
            for channel, step in self.steps.items()
        }

    def _load_notes(self, selection: NDArray[np.bool_]) -> list[str]:
        if not isinstance(self.record.normal_load, np.ndarray):
            return []
        loads = self.columns["normal_load"][selection]
        low, high, mean = float(loads.min()), float(loads.max()), float(loads.mean())
        if high - low <= STEADY * abs(mean):
            return []
        return [
            f"the mean normal load of the cycles is {low:.4g} to {high:.4g} N; results are for "
            f"{mean:.4g} N"
        ]

    @cached_property
    def delay(self) -> str:
        """Note on a delay of the force that changes the energy by over 2 %; empty otherwise.

        Empty also for a clipped force, since cut-off reversals look like a delay.
        """
        block, record = self.largest_block, self.record
        x, force = record.displacement[block.samples], record.force[block.samples]
        energy, amplitude, size = (
            abs(float(np.median(self.columns[name][self.counted])))
            for name in ("dissipated_energy", "amplitude", "force_amplitude")
        )
        if self.steps.get("force", 0.0) > _COARSE * size or self.plateaus:
            return ""
        # A small lag angle of an elastic force changes the energy by pi T x times that angle.
        around = np.pi * amplitude * size
        per_sample = 2.0 * np.pi / block.cycles.period * np.sqrt(max(around**2 - energy**2, 0.0))
        if not per_sample > 0.0:
            return ""
        smallest = _LATE * max(energy, _LATE * around) / per_sample
        lag = lag_of(x, force, block.cycles, 0.97, _LOOKED_AT, smallest)
        if lag is None or abs(lag.value) < max(smallest, 0.5 * smallest + lag.half):
            return ""
        if lag.misfit_left >= _LEFT or not self._is_better(lag.value):
            return ""
        share = abs(lag.value) * per_sample / energy
        size_text = f"{significant(abs(lag.value), 2)} samples"
        remedy = "`sample_rate` converts it to a time"
        if (time := record.seconds) is not None:
            step = float(time[block.stop - 1] - time[block.first]) / (block.stop - block.first - 1)
            size_text = engineering(abs(lag.value) * step, "s")
            remedy = f"`delay={lag.value * step:.3g}` removes it"
        way = "behind" if lag.value > 0.0 else "ahead of"
        return (
            f"the force seems {size_text} {way} the displacement, by a delay or a filter of its "
            f"channel, which changes the energy by about {significant(100.0 * share, 2)} %; "
            f"{remedy}"
        )

    def shape(self, selection: NDArray[np.bool_], lag: float = 0.0) -> Shape | None:
        """Return the mean branch of the selected cycles, after removal of a lag [samples]."""
        force = self.record.force
        if lag:
            place = np.arange(force.size)
            force = np.interp(place + lag, place, force)
        rows = np.flatnonzero(selection)
        return shape_of(self.record.displacement, force, self.columns, rows)

    def _is_better(self, lag: float) -> bool:
        """Return whether removal of a lag [samples] makes the branches concave."""
        before, after = (self.shape(self.settled.selection, by) for by in (0.0, lag))
        if before is None or after is None or lost_motion_of(before) is not None:
            return False
        fine = _CONCAVE + 5.0 * after.error
        depth = hollow_of(after)[0]
        return depth < max(fine, 0.5 * hollow_of(before)[0]) and depth < 2.0 * fine

    def _drifts(self, selection: NDArray[np.bool_]) -> list[str]:
        rows = np.flatnonzero(selection)
        notes = []
        for channel, size in (("displacement", "amplitude"), ("force", "force_amplitude")):
            offsets = self.columns[f"{channel}_offset"][rows]
            line = trend(rows.astype(float), offsets, independent=False)
            total = line.slope * float(np.ptp(rows) + 1.0) if rows.size > 3 else 0.0
            share = abs(total) / (2.0 * abs(float(np.median(self.columns[size][rows]))) or 1.0)
            if line.is_certain and share > DRIFTS:
                size_text = engineering(total, CHANNEL_UNITS[channel])
                notes.append(
                    f"the {channel} drifts by {size_text} over the "
                    f"evaluated cycles, {significant(100.0 * share, 2)} % of its range; a linear "
                    "trend is removed"
                )
        return notes


@once_a_record
def cycles_of(record: Record) -> Cycles:
    """Find and evaluate the cycles of a record; the result is cached with the record."""
    spikes = spikes_of(record)
    record = without_spikes(record, spikes)
    # Split where the transducer turns: behind a compliant rig the contact stands still for long.
    blocks, force = blocks_of(record), record.force
    if force.min() == force.max():
        raise InputError(
            f"force must vary, got {exact(force[0])} N at all {force.size} samples: a dead sensor, "
            "or another column than the force"
        )
    columns = columns_of(record, 0.0)
    _refuse_noise(columns)
    first = columns["start"]
    has_spike = np.zeros(first.size, dtype=bool)
    for spike in spikes:
        has_spike |= (first <= spike.last) & (first + columns["period"] >= spike.first)
    if has_spike.all():
        texts = "; ".join(map(str, spikes[:3])) + ("; ..." if len(spikes) > 3 else "")
        raise InputError(
            f"every cycle has a spike: {plural(len(spikes), 'spike')}, {texts}; check the sensor "
            "and its cable, or select other samples"
        )
    closure = columns["closure_error"]
    is_open = ~(closure <= OPEN)
    if closure.size > 2:  # from rest, the first cycle contains first loading
        is_open[0] |= closure[0] > max(_FROM_REST, _LESS_OPEN * float(np.median(closure[1:])))
    return Cycles(record, spikes, blocks, MappingProxyType(columns), has_spike, is_open)


def _refuse_noise(columns: Mapping[str, Floats]) -> None:
    change = {
        name: float(np.median(np.abs(np.diff(np.log(np.maximum(np.abs(columns[name]), 1e-300))))))
        for name in ("period", "amplitude")
        if columns["start"].size >= _FEWEST_PAIRS
    }
    if change and min(change.values()) > _IRREGULAR:
        raise InputError(
            "the displacement is not cyclic: from one cycle to the next its period changes by "
            f"{100.0 * change['period']:.0f} % and its amplitude by "
            f"{100.0 * change['amplitude']:.0f} % in the median; take a stretch with cycles, "
            "`rows=slice(0, 5000)`, or another column as the displacement"
        )


def check_direction(
    name: str, energy: float, error: float, x: Floats, force: Floats, delay: str = ""
) -> None:
    """Raise InputError, with the likely cause, if loops have a significantly negative energy [J].

    If force and displacement are positively correlated, the cause is a delay of the force, which
    matters in thin loops. It is an error only if the advice for its message, ``delay``, is given.
    """
    away, against = x - x.mean(), force - force.mean()
    size = float(np.linalg.norm(away) * np.linalg.norm(against))
    ellipse = 2.0 * np.pi * size / x.size
    if not energy < -max(_STANDARD_ERRORS * error, _THIN * ellipse):
        return
    loss = engineering(energy, "J")
    words = f"{name}: the loops run in the wrong direction (energy {loss} per cycle)"
    if float(away @ against) < _ALIKE * size:
        cause = "the force has the opposite sign (--flip-sign, `sign=-1` in Python, reverses it)"
    elif delay:
        cause = f"the force is behind the displacement ({delay})"
    else:
        return
    raise InputError(f"{words}: {cause}, or the two columns are swapped")


def _plateau(values: Floats, extreme: float, step: float | None) -> tuple[float, bool]:
    """Return the fraction of samples on a plateau, and whether the channel is noisy elsewhere.

    ``step`` is the converter step of the channel, if it has one. The fraction is 0
    without a plateau, and if the channel approaches it gradually, as friction does.
    """
    at = np.flatnonzero(values == extreme)
    share = at.size / values.size
    if share <= _CLIPPED or at.size <= 8 or np.count_nonzero(np.diff(at) == 1) <= 0.5 * at.size:
        return 0.0, False
    if step is not None:
        # Each converter step holds many samples; a sine has about twice as many on its last step
        # as on the one before. A channel that approaches a plateau slowly has many next to it.
        number = np.rint(np.abs(values - extreme) / step)
        beside = np.bincount(number[number < 16.0].astype(int), minlength=16)
        inner = np.flatnonzero(beside[1:]) + 1
        is_neared = beside[1:4].mean() > _SLOWER * beside[8:].mean() > 0.0
        if is_neared or (inner.size and at.size < _STEPPED * beside[inner[0]]):
            return 0.0, False
    moving = np.delete(values, at)
    noise = noise_of(moving)
    # White noise is the same in every other sample; the course of a loop is rougher there.
    quiet = max(_QUIET * float(np.ptp(values)), _ROUGHER * noise_of(moving[::2]))
    return share, step is None and noise >= quiet


def step_of(values: Floats) -> float | None:
    """Return the converter step, of which all differences of values are multiples, or None."""
    first = values[: 1 << 15]
    steps = np.unique(first)
    gaps = np.diff(steps)
    gaps = gaps[gaps > _ROUNDING * (steps[-1] - steps[0])]
    if gaps.size < 2 or steps.size > 0.5 * first.size:
        return None
    number = (steps - steps[0]) / gaps.min()
    return float(gaps.min()) if np.abs(number - np.rint(number)).max() < _ON_STEP else None
