"""The blocks of a record between gaps of its time, and the cycles of each.

Rigs log every hundredth cycle, or pause. A cycle across a gap is none, and time within a gap says
nothing of the frequency.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.units import engineering, significant
from microslip._core.wording import plural
from microslip.errors import InputError
from microslip.numerics.runs import runs_of
from microslip.tribometer.cuts import (
    BAND,
    Cuts,
    Motion,
    candidates,
    len_of,
    motion_of,
    no_cycle,
)
from microslip.tribometer.record import Record, once_a_record
from microslip.tribometer.settling import FEWEST

LONG = 10.0
"""Times as long as nine in ten steps of the time that a gap is, at least,"""
OF_CYCLE = 0.05
"""and of a cycle: what is less does it no harm."""
_JUMP = 1.5
"""Jump of the counter of cycles beyond which some were not logged."""
_SAME_PERIOD = 0.1
"""Share by which their period may differ: what hums while the rig rests is no motion."""
_STOOD, _RESTING = 0.75, 8.0
"""Least share of a cycle for which a logged rig stands still; range then, over the noise."""
_OVER_NOISE = 10.0
"""Their amplitude over the noise, at least."""


class Block(NamedTuple):
    """Samples of a record that follow each other without a gap, and their whole cycles."""

    first: int
    """The first sample, counted from 0."""
    stop: int
    """One past the last one."""
    cycles: Cuts
    """Their places are counted from the first sample of the block."""

    @property
    def samples(self) -> slice:
        """Position of the block in the record."""
        return slice(self.first, self.stop)

    @property
    def cycle_count(self) -> int:
        """Number of whole cycles."""
        return len_of(self.cycles)


class Blocks(NamedTuple):
    """The blocks of a record that have whole cycles, all of them cut alike."""

    having_cycles: tuple[Block, ...]
    notes: tuple[str, ...]

    @property
    def flipped(self) -> bool:
        """Whether peaks are lowest places and troughs highest ones."""
        return self.having_cycles[0].cycles.flipped


@once_a_record
def _motion(record: Record) -> Motion:
    """Motion by which its cycles are counted, as if there were no gaps."""
    return motion_of(record.displacement, record.force)


@once_a_record
def gaps_of(record: Record) -> NDArray[np.intp]:
    """Samples behind which the time of a record, or its counter of cycles, has a gap."""
    is_jump = np.zeros(len(record) - 1, dtype=bool)
    if record.cycle_number is not None:
        is_jump = np.diff(record.cycle_number) > _JUMP
    if record.time is None:
        return np.flatnonzero(is_jump)
    steps = np.diff(record.time)
    longest = LONG * float(np.percentile(steps, 90.0))
    is_long = steps > longest
    if is_long.any():
        period = _motion(record).period
        is_long &= steps > OF_CYCLE * period * float(steps[~is_long].mean())
    return np.flatnonzero(is_long | is_jump)


@once_a_record
def stops_of(record: Record) -> NDArray[np.intp]:
    """First sample of each stretch in which the rig stood while it was logged, and one past it."""
    x, motion = record.displacement, _motion(record)
    size = max(int(0.25 * _STOOD * motion.period), 2)
    number = x.size // size
    # A few samples of each piece show whether it moves.
    pieces = x[: number * size].reshape(number, size)[:, :: max(size // 8, 1)]
    pieces = np.ascontiguousarray(pieces)
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
    """The cycles of a record, block by block; stretches of far smaller cycles are blocks, too."""
    x, force = record.displacement, record.force
    gaps, stops = gaps_of(record), stops_of(record)
    # The way to a stop and that from it belong to no whole cycle.
    inner_stops = stops[(stops[:, 0] > 0) & (stops[:, 1] < x.size)]
    gaps = np.unique(np.concatenate((gaps, inner_stops[:, 0] - 1, inner_stops[:, 1] - 1)))
    motion = motion_of(x, force, [int(gap) for gap in gaps]) if gaps.size else _motion(record)
    edges = [0, *(int(gap) + 1 for gap in gaps), x.size]
    pieces = list(pairwise(edges))
    piece_cycles = [candidates(x[first:stop], motion) for first, stop in pieces]
    cycle_counts = np.array([[len_of(cycles) for cycles in of_block] for of_block in piece_cycles])
    kind = int(cycle_counts.sum(axis=0).argmax())
    blocks = [
        Block(first, stop, cycles)
        for (first, stop), of_block in zip(pieces, piece_cycles, strict=True)
        if (cycles := of_block[kind]) is not None
    ]
    if not blocks:
        raise no_cycle(motion)
    notes: tuple[str, ...] = ()
    gaps = gaps_of(record)
    if gaps.size and record.time is not None:
        empty = len(pieces) - len(blocks) - len(inner_stops)
        notes = (_gap_note(record.time, gaps, max(empty, 0)),)
    elif gaps.size:
        notes = (f"the counter of cycles jumps {gaps.size} times: cycles are cut there",)
    if len(inner_stops):
        longest_stop = float(np.diff(inner_stops, axis=1).max()) / motion.period
        notes += (
            f"the rig stood still {plural(len(inner_stops), 'time')} while it was logged, for "
            f"{significant(longest_stop, 2)} cycles at most: cycles are cut there",
        )
    small = [part for block in blocks for part in _with_smaller(x, force, block, motion, kind)]
    return Blocks(tuple(small), notes)


def _with_smaller(x: Floats, force: Floats, block: Block, motion: Motion, kind: int) -> list[Block]:
    """A block, and what it has of cycles that stay within the band around its middle."""
    way, band = x[block.samples], BAND * motion.amplitude
    near = (way >= motion.middle - band) & (way <= motion.middle + band)
    smaller: list[Block] = []
    cuts = block.cycles.cuts
    is_between = np.ones(cuts.size - 1, dtype=bool)
    for begin, end in runs_of(near).tolist():
        first, stop = block.first + begin, block.first + end
        if stop - first < FEWEST * motion.period:
            continue
        try:
            stretch_motion = motion_of(x[first:stop], force[first:stop])
        except InputError:  # it rests there
            continue
        alike = abs(stretch_motion.period - motion.period) < _SAME_PERIOD * motion.period
        if not alike or stretch_motion.amplitude < _OVER_NOISE * stretch_motion.noise:
            continue
        cycles = candidates(x[first:stop], stretch_motion)[kind]
        if cycles is not None and len_of(cycles) >= FEWEST:
            smaller += _with_smaller(x, force, Block(first, stop, cycles), stretch_motion, kind)
            is_between &= (cuts[1:] <= begin) | (cuts[:-1] >= end)
    if not smaller:
        return [block]
    larger = [_cycles_between(block, begin, end) for begin, end in runs_of(is_between)]
    return sorted(larger + smaller, key=lambda part: part.first)


def _cycles_between(block: Block, begin: int, end: int) -> Block:
    """The cycles of a block from one number to another."""
    cycles = block.cycles
    origin = cycles.cuts[begin]
    return Block(
        block.first + int(origin),
        block.first + int(cycles.cuts[end]) + 1,
        cycles._replace(
            cuts=cycles.cuts[begin : end + 1] - origin,
            peaks=cycles.peaks[begin:end] - origin,
            troughs=cycles.troughs[begin:end] - origin,
        ),
    )


def _gap_note(time: Floats, gaps: NDArray[np.intp], empty: int) -> str:
    """Note on gaps, and on blocks between them without a cycle."""
    at = int(gaps[np.diff(time)[gaps].argmax()])
    longest = f"{engineering(float(time[at + 1] - time[at]), 's')}"
    after = f"{engineering(float(time[at]), 's')}"
    if gaps.size == 1:
        text = f"the time has a gap of {longest} after {after}"
    else:
        text = f"the time has {gaps.size} gaps, the longest of {longest} after {after}"
    text += ": cycles are cut there, and the frequency is that within the blocks"
    if empty:
        text += (
            f"; {empty} of {gaps.size + 1} blocks {'has' if empty == 1 else 'have'} no whole cycle"
        )
    return text
