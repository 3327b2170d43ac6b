"""Blocks of a record between gaps in its time, with their cycles.

Rigs log, for example, every hundredth cycle, or pause. No cycle extends across a gap, and the
frequency is computed within the blocks.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.units import engineering, significant
from microslip._core.wording import plural
from microslip.laboratory.cuts import (
    BAND,
    Cuts,
    Swing,
    candidates,
    len_of,
    runs_of,
    swing_of,
    window_of,
)
from microslip.laboratory.record import Record, once_a_record

LONG = 10.0
"""Smallest length of a gap over the 90 % quantile of the time steps."""
OF_CYCLE = 0.05
"""Smallest length of a gap over the period; shorter gaps are ignored."""
_JUMP = 1.5
"""Jump of the counter of cycles beyond which some were not logged."""
_SAME_PERIOD = 0.1
"""Largest relative difference of the periods of small and large cycles; hum of a rig at rest
differs by more."""
_ONE_FREQUENCY = 1.5
"""Largest ratio of periods of cycles that are evaluated with the same windows."""
_FEWEST_SMALLER = 2
"""Smallest number of whole cycles in a stretch of smaller cycles."""
_STOOD, _RESTING = 0.75, 8.0
"""Shortest standstill [cycles], and range of the displacement during it over the noise."""
_OVER_NOISE = 10.0
"""Smallest ratio of the amplitude to the noise."""


class CycleBlock(NamedTuple):
    """Samples ``first`` to ``stop`` (exclusive) of a record, and the whole cycles in them."""

    first: int
    stop: int
    cycles: Cuts
    """Cycles, with places counted from the first sample of the block."""

    @property
    def samples(self) -> slice:
        """Slice of the record that the block occupies."""
        return slice(self.first, self.stop)

    @property
    def cycle_count(self) -> int:
        """Number of whole cycles."""
        return len_of(self.cycles)


class Blocks(NamedTuple):
    """Blocks of a record with at least one whole cycle each; all cycles begin at the same phase."""

    having_cycles: tuple[CycleBlock, ...]
    notes: tuple[str, ...]


@once_a_record
def _swing(record: Record) -> Swing:
    return swing_of(record.displacement, record.force)


@once_a_record
def gaps_of(record: Record) -> NDArray[np.intp]:
    """Return the indices of samples after which the time or the cycle counter of a record jumps."""
    is_jump = np.zeros(len(record) - 1, dtype=bool)
    if record.cycle_number is not None:
        is_jump = np.diff(record.cycle_number) > _JUMP
    if record.time is None:
        return np.flatnonzero(is_jump)
    steps = np.diff(record.time)
    longest = LONG * float(np.percentile(steps, 90.0))
    is_long = steps > longest
    if is_long.any():
        period = _swing(record).period
        is_long &= steps > OF_CYCLE * period * float(steps[~is_long].mean())
    return np.flatnonzero(is_long | is_jump)


@once_a_record
def stops_of(record: Record) -> NDArray[np.intp]:
    """Return first sample and end (exclusive) of each standstill of a record (stops, 2)."""
    x, motion = record.displacement, _swing(record)
    size = max(int(0.25 * _STOOD * motion.period), 2)
    number = x.size // size
    # A few samples of each piece show whether it moves.
    pieces = np.ascontiguousarray(x[: number * size].reshape(number, size)[:, :: max(size // 8, 1)])
    rest_range = max(_RESTING * motion.noise, 1e-6 * motion.amplitude)
    is_still = np.ptp(pieces, axis=1) <= rest_range
    stops = []
    for begin, end in runs_of(is_still).tolist():
        # A stretch of slow creep is no stop.
        if end - begin < 3 or np.ptp(pieces[begin:end]) > 2.0 * rest_range:
            continue
        level = float(pieces[begin:end].mean())
        is_near = np.abs(x - level) <= rest_range
        first, stop = begin * size, end * size
        first -= int(np.argmin(np.append(is_near[:first][::-1], False)))
        stop += int(np.argmin(np.append(is_near[stop:], False)))
        if stop - first >= _STOOD * motion.period:
            stops.append((first, stop))
    return np.array(stops, dtype=np.intp).reshape(-1, 2)


@once_a_record
def blocks_of(record: Record) -> Blocks:
    """Cut a record at gaps and standstills; parts with much smaller cycles are separate blocks."""
    x, force = record.displacement, record.force
    gaps, stops = gaps_of(record), stops_of(record)
    # The way to a stop and that from it belong to no whole cycle.
    inner_stops = stops[(stops[:, 0] > 0) & (stops[:, 1] < x.size)]
    ends = np.unique(np.concatenate((gaps, inner_stops[:, 0] - 1, inner_stops[:, 1] - 1))).tolist()
    motion = swing_of(x, force, ends) if ends else _swing(record)
    pieces = list(pairwise([0, *(end + 1 for end in ends), x.size]))
    piece_cycles = [candidates(x[first:stop], motion) for first, stop in pieces]
    cycle_counts = np.array([[len_of(cycles) for cycles in of_block] for of_block in piece_cycles])
    kind = int(cycle_counts.sum(axis=0).argmax())
    blocks = [
        CycleBlock(first, stop, cycles)
        for (first, stop), of_block in zip(pieces, piece_cycles, strict=True)
        if (cycles := of_block[kind]) is not None
    ]
    if not blocks:
        raise InputError(
            f"no full cycle: the displacement crosses its middle {motion.middle:g} m, but no cycle "
            "is complete between turning points or crossings of one kind"
        )
    notes: tuple[str, ...] = ()
    if gaps.size and record.time is not None:
        empty = len(pieces) - len(blocks) - len(inner_stops)
        notes = (_gap_note(record.time, gaps, max(empty, 0)),)
    elif gaps.size:
        notes = (f"the counter of cycles jumps {gaps.size} times: cycles are cut there",)
    if len(inner_stops):
        longest_stop = float(np.diff(inner_stops, axis=1).max()) / motion.period
        notes += (
            f"the record contains {plural(len(inner_stops), 'pause')} of the motion, of up to "
            f"{significant(longest_stop, 2)} cycles: cycles are cut there",
        )
    small = [part for block in blocks for part in _with_smaller(x, force, block, motion, kind)]
    small = [part for block in small for part in _by_frequency(block, motion)]
    return Blocks(tuple(small), notes)


def _by_frequency(block: CycleBlock, motion: Swing) -> list[CycleBlock]:
    periods = np.diff(block.cycles.cuts).astype(float)
    if periods.max() <= _ONE_FREQUENCY * periods.min():
        return [block]
    edges = [0]
    for i, period in enumerate(periods.tolist()):
        inside = periods[edges[-1] : i + 1]
        if max(period / inside.min(), inside.max() / period) > _ONE_FREQUENCY:
            edges.append(i)
    parts = []
    for begin, end in pairwise([*edges, periods.size]):
        part = _cycles_between(block, begin, end)
        period = float(np.median(periods[begin:end]))
        window = window_of(motion.relative_noise, period)
        parts.append(part._replace(cycles=part.cycles._replace(period=period, window=window)))
    return parts


def _with_smaller(
    x: Floats, force: Floats, block: CycleBlock, motion: Swing, kind: int
) -> list[CycleBlock]:
    way, band = x[block.samples], BAND * motion.amplitude
    near = (way >= motion.middle - band) & (way <= motion.middle + band)
    smaller: list[CycleBlock] = []
    cuts = block.cycles.cuts
    is_between = np.ones(cuts.size - 1, dtype=bool)
    for begin, end in runs_of(near).tolist():
        first, stop = block.first + begin, block.first + end
        if stop - first < _FEWEST_SMALLER * motion.period:
            continue
        try:
            stretch_motion = swing_of(x[first:stop], force[first:stop])
        except InputError:  # it rests there
            continue
        alike = abs(stretch_motion.period - motion.period) < _SAME_PERIOD * motion.period
        if not alike or stretch_motion.amplitude < _OVER_NOISE * stretch_motion.noise:
            continue
        cycles = candidates(x[first:stop], stretch_motion)[kind]
        if cycles is not None and len_of(cycles) >= _FEWEST_SMALLER:
            smaller += _with_smaller(
                x, force, CycleBlock(first, stop, cycles), stretch_motion, kind
            )
            is_between &= (cuts[1:] <= begin) | (cuts[:-1] >= end)
    if not smaller:
        return [block]
    larger = [_cycles_between(block, begin, end) for begin, end in runs_of(is_between)]
    return sorted(larger + smaller, key=lambda part: part.first)


def _cycles_between(block: CycleBlock, begin: int, end: int) -> CycleBlock:
    first, last = (int(block.cycles.cuts[i]) for i in (begin, end))
    cycles = block.cycles.selected(begin, end, first)
    return CycleBlock(block.first + first, block.first + last + 1, cycles)


def _gap_note(time: Floats, gaps: NDArray[np.intp], empty: int) -> str:
    at = int(gaps[np.diff(time)[gaps].argmax()])
    longest, after = (
        engineering(s, "s") for s in (float(time[at + 1] - time[at]), float(time[at]))
    )
    gap = "a gap" if gaps.size == 1 else f"{gaps.size} gaps, the longest"
    text = f"the time has {gap} of {longest} after {after}: the record is divided there, and the "
    text += "frequency is that within the blocks"
    if empty:
        text += (
            f"; {empty} of {gaps.size + 1} blocks {'has' if empty == 1 else 'have'} no whole cycle"
        )
    return text
