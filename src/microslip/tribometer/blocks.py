"""Floor 6: the blocks of a record between gaps of its time, and the cycles of each.

Rigs log every hundredth cycle, or pause. A cycle across a gap is none, and time within a gap says
nothing of the frequency.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.tribometer.cycles import Cycles, candidates, len_of, motion_of, no_cycle, split
from microslip.tribometer.record import Record

LONG = 10.0
"""Times as long as nine in ten steps of the time that a gap is, at least,"""
OF_CYCLE = 0.05
"""and of a cycle: what is less does it no harm."""


class Block(NamedTuple):
    """Samples of a record that follow each other without a gap, and their whole cycles."""

    first: int
    """The first sample, counted from 0."""
    stop: int
    """One past the last one."""
    cycles: Cycles
    """Their places are counted from the first sample of the block."""

    @property
    def samples(self) -> slice:
        """Where the block lies in the record."""
        return slice(self.first, self.stop)

    @property
    def whole(self) -> int:
        """How many whole cycles it has."""
        return len_of(self.cycles)


class Blocks(NamedTuple):
    """The blocks of a record that have whole cycles, all of them cut alike."""

    having_cycles: tuple[Block, ...]
    notes: tuple[str, ...]

    @property
    def flipped(self) -> bool:
        """Whether peaks are lowest places and troughs highest ones."""
        return self.having_cycles[0].cycles.flipped


def gaps_of(record: Record) -> NDArray[np.intp]:
    """Samples behind which the time of a record has a gap."""
    if record.time is None:
        return np.zeros(0, dtype=np.intp)
    steps = np.diff(record.time)
    longest = LONG * float(np.percentile(steps, 90.0))
    is_long = steps > longest
    if is_long.any():
        period = motion_of(record.displacement, record.force).period
        is_long &= steps > OF_CYCLE * period * float(steps[~is_long].mean())
    return np.flatnonzero(is_long)


def blocks_of(record: Record) -> Blocks:
    """The cycles of a record, block by block."""
    x, force = record.displacement, record.force
    gaps = gaps_of(record)
    if gaps.size == 0:
        return Blocks((Block(0, x.size, split(x, force)),), ())
    motion = motion_of(x, force, [int(gap) for gap in gaps])
    edges = [0, *(int(gap) + 1 for gap in gaps), x.size]
    pieces = list(pairwise(edges))
    found = [candidates(x[first:stop], motion) for first, stop in pieces]
    each = np.array([[len_of(cycles) for cycles in of_block] for of_block in found])
    kind = int(each.sum(axis=0).argmax())
    blocks = tuple(
        Block(first, stop, cycles)
        for (first, stop), of_block in zip(pieces, found, strict=True)
        if (cycles := of_block[kind]) is not None
    )
    if not blocks:
        raise no_cycle(motion)
    assert record.time is not None
    return Blocks(blocks, (_told(record.time, gaps, len(pieces) - len(blocks)),))


def _told(time: Floats, gaps: NDArray[np.intp], empty: int) -> str:
    """What to say of gaps, and of the blocks between them that have no cycle."""
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
