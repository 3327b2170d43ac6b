"""True cycle numbers of the cycles of a record, and the energy of those not logged.

Rigs log ten cycles at the first, the hundredth, the thousandth. What was dissipated is then not the
sum of what was logged. The number of a cycle is told by the rig's counter, or by time and frequency
where the phase goes on across the gaps; where neither tells it, nothing cumulative is known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import significant
from microslip.tribometer.blocks import Block, gaps_of
from microslip.tribometer.record import Record

_PHASE, _ERRORS = 0.04, 4.0
"""Share of a cycle, and standard errors, by which a block may begin off the expected phase."""
_UNSURE = 0.15
"""Share of a cycle: where the rate is known no better, any phase would do."""
_CHANCE = 0.01
"""Probability that phases agree by chance up to which they tell that the rig ran on."""
_ENDS = 5
"""Cycles at the ends of a block whose mean energy stands for those beside."""


class Count(NamedTuple):
    """Numbers of the cycles of a record in the life of the contact."""

    numbers: Floats | None
    """The first cycle being 1; None where they are not known."""
    source: str
    """Source of the cycle numbers, or why they are not known."""
    is_of_contact: bool = False
    """Whether the rig counted them, from the first of the contact, not of the record."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on cycles that were not logged."""
        if self.numbers is None:
            return (
                f"no cumulative energy: {self.source}; give the rig's counter, "
                "`cycle_number=...`, or the `frequency=...` at which it ran on",
            )
        missing = int(self.numbers[-1] - self.numbers[0]) + 1 - self.numbers.size
        if missing < 1:
            return ()
        first, last = (f"{edge:.12g}" for edge in (self.numbers[0], self.numbers[-1]))
        return (
            f"{self.numbers.size} of the cycles {first} to {last} were logged, {self.source}; "
            "cumulative energies count those between",
        )


def count_of(record: Record, blocks: Sequence[Block]) -> Count:
    """The numbers of the whole cycles of a record, block by block."""
    sizes = [block.cycle_count for block in blocks]
    if record.cycle_number is not None:
        return _by_counter(record.cycle_number, blocks)
    if len(blocks) < 2 or record.time is None or not gaps_of(record).size:
        return Count(1.0 + np.arange(float(sum(sizes))), "")
    starts = [record.time[block.first + block.cycles.cuts] for block in blocks]
    return _by_time(starts, record.frequency)


def _by_counter(counter: Floats, blocks: Sequence[Block]) -> Count:
    numbers = []
    for block in blocks:
        cuts = block.first + block.cycles.cuts
        counted = counter[(cuts[:-1] + cuts[1:]) // 2]
        along = np.arange(float(counted.size))
        if (
            counted.size > 2 and counted[-1] == counted[0]
        ):  # of the block, not of each of its cycles
            numbers.append(counted[0] + along)
        else:
            numbers.append(float(np.median(np.round(counted - along))) + along)
    joined = np.concatenate(numbers)
    if np.any(np.diff(joined) <= 0.0):
        return Count(None, "the rig's counter does not count each cycle that was logged")
    return Count(joined, "by the rig's counter", is_of_contact=True)


def _by_time(starts: Sequence[Floats], frequency: float | None) -> Count:
    """By the rate of the blocks so far; where each next one begins must agree with it."""
    edges = starts[0]
    places = np.arange(float(edges.size))
    parts, chance = [places[:-1]], 1.0
    for times in starts[1:]:
        middle = edges.mean()
        away = edges - middle
        square = float(away @ away)
        rate = float(away @ places) / square
        scatter = places - places.mean() - rate * away
        noise = math.sqrt(max(float(scatter @ scatter) / max(edges.size - 2, 1), 1e-8))
        expected = places.mean() + rate * (times - middle)
        shift = expected - np.arange(float(times.size))
        error = noise * math.sqrt(1.0 / edges.size + (times[0] - middle) ** 2 / square)
        first = round(float(shift.mean()))
        if frequency is not None:
            first = round(float(places[-1] + (times[0] - edges[-1]) * frequency))
        else:
            if error > _UNSURE:
                return Count(
                    None,
                    "between blocks of the record the frequency is not known well enough to count "
                    f"cycles (to {significant(error, 2)} of one)",
                )
            allowed = _PHASE + _ERRORS * error
            if abs(float(shift.mean()) - first) > allowed:
                return Count(
                    None,
                    "the phase of the motion is not continuous across the gaps of the time: the "
                    "rig stopped, or its frequency drifted",
                )
            chance *= min(2.0 * allowed, 1.0)
        first = max(first, round(float(places[-1])))
        parts.append(first + np.arange(float(times.size - 1)))
        edges = np.concatenate((edges, times))
        places = np.concatenate((places, first + np.arange(float(times.size))))
    if frequency is None and chance > _CHANCE:
        return Count(
            None,
            "too few blocks show whether the rig kept running in the gaps of the time",
        )
    return Count(1.0 + np.concatenate(parts), "by time and frequency across the gaps of the time")


class Dissipated(NamedTuple):
    """Energy up to each cycle."""

    energy: Floats
    """[J], that cycle included."""
    errors: Floats
    """By how much it may be off [J], if between the logged cycles nothing goes up and down."""

    @property
    def error(self) -> float:
        """Error of the energy of the last cycle [J]."""
        return float(self.errors[-1])


def dissipated(numbers: Floats, energies: Floats) -> Dissipated:
    """Energy [J] up to each of the logged cycles, those between them included.

    These are taken half on a straight line over cycles, half on one over their logarithm. Any
    course that only rises, or only falls, from one block to the next stays within the error.
    """
    energy_of_each = np.nan_to_num(energies)
    total, errors = np.cumsum(energy_of_each), np.zeros(energies.size)
    for gap in (np.flatnonzero(np.diff(numbers) > 1.5) + 1).tolist():
        before, behind = (
            _block_end(numbers, energy_of_each, gap, -1),
            _block_end(numbers, energy_of_each, gap, 1),
        )
        first, last = float(numbers[gap - 1]), float(numbers[gap])
        missing = last - first - 1.0
        ratio = math.log(last / first) if first > 0.0 else math.inf
        # Mean of a + b ln(n) from the first to the last cycle, and of a + b n.
        share = 0.5 * (last / (last - first) - 1.0 / ratio + 0.5)
        total[gap:] += missing * (before + (behind - before) * share)
        errors[gap:] += missing * abs(behind - before) * max(share, 1.0 - share)
    return Dissipated(total, errors)


def _block_end(numbers: Floats, energies: Floats, gap: int, way: int) -> float:
    """Mean energy of a few cycles before (-1) a gap or behind it (1)."""
    rows = range(gap, min(gap + _ENDS, numbers.size)) if way > 0 else range(gap - 1, -1, -1)
    values: list[float] = []
    for row in rows:
        if values and abs(numbers[row] - numbers[row - way]) > 1.5:
            break
        values.append(float(energies[row]))
        if len(values) == _ENDS:
            break
    return float(np.mean(values))
