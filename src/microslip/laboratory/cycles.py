"""The cycles of a record, cut and judged once for all users.

Spikes, cycles that do not close, amplitudes that step, friction that moves, drift, delay, clipping
and loads that change are found here, for `measure`, for a fit and for what several records say.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact, show
from microslip._core.errors import InputError
from microslip._core.units import engineering, significant
from microslip._core.wording import plural
from microslip.laboratory.blocks import Block, Blocks, Count, blocks_of, count_of
from microslip.laboratory.conditioning import lag_of, looks_late
from microslip.laboratory.cuts import noise_of
from microslip.laboratory.cycle_columns import columns_of
from microslip.laboratory.estimates import trend
from microslip.laboratory.loop_shape import (
    NOT_CONCAVE,
    UNDECIDED,
    Shape,
    hollow_of,
    lost_motion_of,
    shape_of,
)
from microslip.laboratory.record import UNITS, Record, once_a_record
from microslip.laboratory.settling import (
    OPEN,
    Settled,
    excess_loss_notes,
    is_certain,
    named_cycles,
    requested,
    settled,
)
from microslip.laboratory.spikes import Spike, spikes_of, without_spikes

DRIFTS = 0.005
"""Drift over the cycles that count, of the range of the channel, which is worth a word."""
STEADY = 0.02
"""Range of the loads of the cycles, of their mean, that goes without saying."""
_LATE, _LOOKED_AT = 0.02, 40
"""Share of the energy of a cycle that a lag of the force must move, and cycles it is sought in."""
_BESIDE = 0.1
"""Share of a cycle beside a chosen one that is taken with it: cuts are known to a sample."""
_STANDARD_ERRORS, _ALIKE, _THIN = 5.0, 0.2, 1e-3
"""Standard errors; correlation of force and displacement of a loop that a delay may turn; energy,
of that of the ellipse around a loop, below which it is nothing but a line."""
_CLIPPED, _STEPPED, _SLOWER = 0.005, 5.0, 2.0
"""Share of the samples that are exactly at an extreme; times as many as one step of a converter
further in, where all are on such steps; times as many on the next three as on those further in."""
_ROUNDING, _ON_STEP = 1e-7, 0.01
"""Share of the range below which values that differ are one step of a converter; share of a step
by which all values may be off."""
_QUIET, _ROUGHER = 1e-4, 0.15
"""Noise over the range of a channel, and over that of every other sample, below which it has
none."""
_COARSE = 0.02
"""Step of a converter over the force amplitude from which on no delay is told."""
_IRREGULAR, _FEWEST_PAIRS = 0.12, 5
"""Median relative change of period and of amplitude from a cycle to the next beyond which a motion
is not cyclic, and cycles from which that is judged."""
_STEP_ERROR = 12.0**-0.5
"""Standard deviation of a value of which only the step is known, of that step."""


class Drift(NamedTuple):
    """A straight trend of a channel over the cycles that count."""

    channel: str
    total: float
    """Change of the channel over the cycles [m, N]."""
    share: float
    """The same over the range of the channel [-]."""

    def note(self, remedy: str) -> str:
        """Note on it."""
        total = engineering(self.total, UNITS[self.channel])
        return (
            f"the {self.channel} drifts by {total} over the evaluated cycles, "
            f"{significant(100.0 * self.share, 2)} % of its range; {remedy}"
        )


class Plateau(NamedTuple):
    """Samples of a channel that are exactly at one of its extremes."""

    channel: str
    extreme: float
    share: float
    """Share of all samples [-]."""
    step: float | None
    """Step of the converter on which all samples lie; None without one."""
    is_neared: bool
    """Whether the channel slows down before it, as friction does and a clipped sensor does not."""
    is_quiet: bool = False
    """Whether the channel has no noise where it moves."""

    def note(self) -> str:
        """Note on it."""
        words = f"{self.share:.1%} of the {self.channel} is exactly {self.extreme:g}: "
        if self.step is not None:
            step = engineering(self.step, UNITS[self.channel])
            kind = "a plateau" if self.is_neared else "a plateau or a sensor at its limit"
            return (
                f"{words}{kind} on the converter's steps of {step}, known to half of one, which is "
                "in the intervals"
            )
        if self.is_neared:
            return f"{words}a plateau"
        if self.is_quiet:
            return (
                f"{words}{UNDECIDED} (friction of a channel without noise, or a sensor at its "
                "limit); a record of a smaller amplitude would tell"
            )
        return f"{words}a clipped sensor, for elsewhere the channel has noise"


class Delay(NamedTuple):
    """Delay of the force, by a lag or a filter of its channel."""

    samples: float
    seconds: float | None
    """None without a time."""
    share: float
    """About how much of the energy of a cycle it costs or feigns [-]."""

    def note(self) -> str:
        """Note on it."""
        size = f"{significant(abs(self.samples), 2)} samples"
        remedy = "`sample_rate` makes a time of it"
        if self.seconds is not None:
            size = engineering(abs(self.seconds), "s")
            remedy = f"`delay={self.seconds:.3g}` removes it"
        way = "behind" if self.samples > 0.0 else "ahead of"
        return (
            f"the force seems {size} {way} the displacement, by a delay or a filter of its "
            f"channel, which moves the energy by about {significant(100.0 * self.share, 2)} %; "
            f"{remedy}"
        )


@dataclass(frozen=True, eq=False)
class Cycles:
    """The cycles of a record, and what is wrong with them."""

    record: Record
    """Straight lines stand where its spikes were."""
    spikes: tuple[Spike, ...]
    blocks: Blocks
    columns: Mapping[str, Floats]
    """A value for each cycle, of :data:`~microslip.laboratory.cycle_columns.UNITS` and
    ``force_rms`` [N]; no rig is taken off."""
    has_spike: NDArray[np.bool_]
    """Cycles with one."""
    is_open: NDArray[np.bool_]
    """Cycles whose ends differ by over a quarter of their force."""

    @cached_property
    def count(self) -> Count:
        """True cycle number of each."""
        return count_of(self.record, self.blocks.having_cycles)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Cycles without a spike that close; where none closes all without a spike."""
        closed = ~self.has_spike & ~self.is_open
        return closed if closed.any() else ~self.has_spike

    @property
    def largest_block(self) -> Block:
        """The block with most cycles."""
        return max(self.blocks.having_cycles, key=lambda block: block.cycle_count)

    @cached_property
    def settled(self) -> Settled:
        """Cycles that count and between which nothing changes any more."""
        noise = max(block.cycles.noise for block in self.blocks.having_cycles)
        return settled(self.columns, self.counted, noise)

    def selected(self, cycles: slice | None) -> Settled:
        """The settled cycles, or those that were asked for, judged alike."""
        if cycles is None:
            return self.settled
        if not isinstance(cycles, slice):
            raise InputError(f"`cycles` must be a slice, such as slice(2, 20), got {show(cycles)}")
        is_asked = np.zeros(self.is_open.size, dtype=bool)
        is_asked[cycles] = True
        if not (is_asked & self.counted).any():
            raise InputError(
                f"`cycles` must have some of the {np.count_nonzero(self.counted)} cycles that "
                f"count, of {self.is_open.size}, got {show(cycles)}"
            )
        return requested(self.columns, is_asked & self.counted)

    def near(self, is_wanted: NDArray[np.bool_], place: NDArray[np.int64]) -> Settled:
        """The cycles that hold most samples of others, whose number ``place`` says; judged."""
        first, last = (self.columns["start"] + edge * self.columns["period"] for edge in (0.0, 1.0))
        middle = np.rint(0.5 * (first + last)).astype(int)
        number = place[np.clip(middle, 0, place.size - 1)]
        selection = (number >= 0) & is_wanted[np.clip(number, 0, is_wanted.size - 1)]
        return requested(self.columns, selection & self.counted)

    def samples(self, selection: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Samples of some of the cycles, and a little beside each."""
        inside = np.zeros(len(self.record), dtype=bool)
        starts, periods = (self.columns[name][selection] for name in ("start", "period"))
        for start, period in zip(starts.astype(int), periods.astype(int), strict=True):
            margin = int(_BESIDE * period)
            inside[max(start - margin, 0) : start + period + margin] = True
        return inside

    # -- what is to be said ----------------------------------------------------------------------

    def notes(self, counting: Settled) -> list[str]:
        """Notes on the record, where these cycles count."""
        return [
            *self.blocks.notes,
            *self._left_out(),
            *counting.notes,
            *self.excess_loss,
            *(plateau.note() for plateau in self.plateaus),
            *self.coarse_steps,
            *self.load_notes(counting.selection),
        ]

    def _left_out(self) -> list[str]:
        notes = []
        texts = "; ".join(map(str, self.spikes[:3])) + ("; ..." if len(self.spikes) > 3 else "")
        if self.has_spike.any():
            notes.append(
                f"left out of the means: {named_cycles(self.has_spike)} with a spike, here "
                f"straight lines: {texts}"
            )
        elif self.spikes:
            notes.append(f"spikes beyond the whole cycles: {texts}")
        if (self.is_open | self.has_spike).all():
            notes.append("no cycle closes, the ends of each differ by over a quarter of the force")
        elif self.is_open.any():
            notes.append(
                f"left out of the means: {named_cycles(self.is_open)} whose ends differ by over a "
                "quarter of the force, as in running in"
            )
        return notes

    @property
    def excess_loss(self) -> list[str]:
        """A note on loops that are larger than the rectangle around them."""
        return excess_loss_notes(self.columns["loss_factor"])

    @cached_property
    def plateaus(self) -> tuple[Plateau, ...]:
        """Extremes of a channel at which many of its samples are, exactly."""
        found = []
        for name in ("displacement", "force"):
            values: Floats = getattr(self.record, name)
            found += [_plateau_at(name, values, end) for end in (values.min(), values.max())]
        return tuple(plateau for plateau in found if plateau is not None)

    @cached_property
    def coarse_steps(self) -> list[str]:
        """Notes on channels that a converter resolves only coarsely."""
        notes = []
        for name in ("displacement", "force"):
            values: Floats = getattr(self.record, name)
            step = step_of(values)
            if step is not None and 2.0 * step > _COARSE * float(np.ptp(values)):
                share = 100.0 * step / float(np.ptp(values))
                notes.append(
                    f"the {name} lies on a converter's steps of {engineering(step, UNITS[name])}, "
                    f"{significant(share, 2)} % of its range; record with a smaller range"
                )
        return notes

    @property
    def is_clipped(self) -> bool:
        """Whether a sensor may have been at its end: no plateau that was neared step by step."""
        return any(not plateau.is_neared for plateau in self.plateaus)

    @property
    def step_errors(self) -> dict[str, float]:
        """Standard deviations that steps of a converter leave of amplitudes, of these [-]."""
        size = {"displacement": "amplitude", "force": "force_amplitude"}
        return {
            p.channel: p.step * _STEP_ERROR / abs(float(np.median(self.columns[size[p.channel]])))
            for p in self.plateaus
            if p.step is not None
        }

    def load_notes(self, selection: NDArray[np.bool_]) -> list[str]:
        """A note on a normal load that is not the same in the cycles that count."""
        if not isinstance(self.record.normal_load, np.ndarray):
            return []
        loads = self.columns["normal_load"][selection]
        low, high, mean = float(loads.min()), float(loads.max()), float(loads.mean())
        if high - low <= STEADY * abs(mean):
            return []
        return [
            f"the normal load is {low:.4g} to {high:.4g} N in the means of the cycles; results "
            f"are of {mean:.4g} N"
        ]

    @cached_property
    def delay(self) -> Delay | None:
        """A lag of the force that changes energies by over 2 %; None without.

        Nor of a clipped force, whose turns are cut off as if it were late.
        """
        block, record = self.largest_block, self.record
        x, force = record.displacement[block.samples], record.force[block.samples]
        energy, amplitude, size = (
            abs(float(np.median(self.columns[name][self.counted])))
            for name in ("dissipated_energy", "amplitude", "force_amplitude")
        )
        step = step_of(record.force)
        if step is not None and step > _COARSE * size:
            return None
        if self.is_clipped:
            return None
        # Of a force in phase with the displacement, a lag by an angle costs that share of pi T x.
        around = np.pi * amplitude * size
        per_sample = 2.0 * np.pi / block.cycles.period * np.sqrt(max(around**2 - energy**2, 0.0))
        if not per_sample > 0.0:
            return None
        smallest = _LATE * max(energy, _LATE * around) / per_sample
        if not looks_late(x, force, block.cycles, smallest, _LOOKED_AT):
            return None
        lag = lag_of(x, force, block.cycles, 0.999, most=_LOOKED_AT)
        if abs(lag.value) - lag.half < 0.5 * smallest or abs(lag.value) < smallest:
            return None
        if not lag.is_remedy or not self._is_better(lag.value):
            return None
        time, share = record.time, abs(lag.value) * per_sample / energy
        rate = record.sample_rate
        if time is not None:
            rate = (block.stop - block.first - 1) / float(time[block.stop - 1] - time[block.first])
        return Delay(lag.value, None if rate is None else lag.value / rate, share)

    def shape(self, selection: NDArray[np.bool_], lag: float = 0.0) -> Shape | None:
        """Mean branch of some cycles, the force taken ``lag`` [samples] later."""
        force = self.record.force
        if lag:
            place = np.arange(force.size)
            force = np.interp(place + lag, place, force)
        rows = np.flatnonzero(selection)
        return shape_of(self.record.displacement, force, self.columns, rows)

    def _is_better(self, lag: float) -> bool:
        """Whether the branches are concave without a lag, and their ways no less alike."""
        before, after = (self.shape(self.settled.selection, by) for by in (0.0, lag))
        if before is None or after is None or lost_motion_of(before) is not None:
            return False
        fine = 0.5 * NOT_CONCAVE + 5.0 * after.error
        depth = hollow_of(after)[0]
        return depth < max(fine, 0.5 * hollow_of(before)[0]) and depth < 2.0 * fine

    def drifts(self, selection: NDArray[np.bool_]) -> tuple[Drift, ...]:
        """Drifts over some of the cycles that are more than chance, and than a little."""
        rows = np.flatnonzero(selection)
        drifts = []
        for channel, size in (("displacement", "amplitude"), ("force", "force_amplitude")):
            line = trend(
                rows.astype(float), self.columns[f"{channel}_offset"][rows], 0.95, independent=False
            )
            total = line.value * float(np.ptp(rows) + 1.0) if rows.size > 3 else 0.0
            share = abs(total) / (2.0 * abs(float(np.median(self.columns[size][rows]))) or 1.0)
            if is_certain(line) and share > DRIFTS:
                drifts.append(Drift(channel, total, share))
        return tuple(drifts)


@once_a_record
def cycles_of(record: Record) -> Cycles:
    """The cycles of a record; they are made and judged once."""
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
            f"no cycle is without a spike: {plural(len(spikes), 'spike')}, {texts}; look at the "
            "sensor and its cable, or leave these samples out"
        )
    return Cycles(
        record,
        spikes,
        blocks,
        MappingProxyType(columns),
        has_spike,
        ~(columns["closure_error"] <= OPEN),
    )


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
    """Refuse loops that give energy [J], of that error, as those of friction with a wrong sign do.

    A delay turns thin loops, too, and leaves the force alike to the displacement: ``delay`` is what
    takes it off; without it these pass.
    """
    away, against = x - x.mean(), force - force.mean()
    size = float(np.linalg.norm(away) * np.linalg.norm(against))
    ellipse = 2.0 * np.pi * size / x.size
    if not energy < -max(_STANDARD_ERRORS * error, _THIN * ellipse):
        return
    words = f"{name}: the loops run the wrong way round (energy {engineering(energy, 'J')} a cycle)"
    if float(away @ against) < _ALIKE * size:
        cause = "the force has the opposite sign (--flip-sign, `sign=-1` in Python, reverses it)"
    elif delay:
        cause = f"the force is behind the displacement ({delay})"
    else:
        return
    raise InputError(f"{words}: {cause}, or the two columns are swapped")


def _plateau_at(channel: str, values: Floats, extreme: float) -> Plateau | None:
    at = np.flatnonzero(values == extreme)
    share = at.size / values.size
    if share <= _CLIPPED or at.size <= 8 or np.count_nonzero(np.diff(at) == 1) <= 0.5 * at.size:
        return None
    step, is_neared = step_of(values), False
    if step is not None:
        # A converter has many at each of its steps; of a sine twice as many at the last as at the
        # next. What nears a plateau by itself slows down before it, what is cut off does not.
        number = np.rint(np.abs(values - extreme) / step)
        beside = np.bincount(number[number < 16.0].astype(int), minlength=16)
        inner = np.flatnonzero(beside[1:]) + 1
        if inner.size and at.size < _STEPPED * beside[inner[0]]:
            return None
        is_neared = bool(beside[1:4].mean() > _SLOWER * beside[8:].mean() > 0.0)
    moving = np.delete(values, at)
    noise = noise_of(moving)
    # White noise is the same in every other sample; the course of a loop is rougher there.
    is_quiet = noise < max(_QUIET * float(np.ptp(values)), _ROUGHER * noise_of(moving[::2]))
    return Plateau(channel, float(extreme), share, step, is_neared, is_quiet)


def step_of(values: Floats) -> float | None:
    """The step of a converter on whose steps all values are; None of values of any size."""
    first = values[: 1 << 15]
    steps = np.unique(first)
    gaps = np.diff(steps)
    gaps = gaps[gaps > _ROUNDING * (steps[-1] - steps[0])]
    if gaps.size < 2 or steps.size > 0.5 * first.size:
        return None
    number = (steps - steps[0]) / gaps.min()
    return float(gaps.min()) if np.abs(number - np.rint(number)).max() < _ON_STEP else None
