"""Phase of each sample of a record in its cycle."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.tribometer.blocks import Blocks
from microslip.tribometer.cuts import Cuts

_IN_STEP, _MOST_CYCLES, _LOOKED_AT = 0.95, 32, 1 << 14
_FEWEST, _SAMPLES_A_BIN = 3, 4  # samples of a place, and of a bin where no places are the same
_HARMONICS, _STEPS, _PIECE = 5, 4, 1 << 16
_OWN_RATE = 5  # cycles of a block from which its own rate is known well


def turns_of(time: Floats, x: Floats, cycles: Cuts) -> tuple[Floats, float]:
    """Cycles since the first cut at each sample, by the fundamental of all of it; their rate."""
    cuts = cycles.cuts
    first, last = time[cuts[0]], time[min(int(cuts[-1]), time.size - 1)]
    rate = (cuts.size - 1) / float(last - first)
    if cuts.size < 3:
        return (time - first) * rate, rate
    inner = slice(int(cuts[0]), int(cuts[-1]))
    mean = float(np.mean(x[inner]))
    offset = 0.0
    for _ in range(3):
        angles = np.angle(_fundamentals(time, x, mean, first, rate, cuts)) / (2.0 * math.pi)
        angles = np.unwrap(angles, period=1.0)
        centres = np.arange(angles.size) + 0.5
        # Ends are cut to whole samples, so that the slope is that of a straight line through all.
        slope, offset = np.polyfit(centres, angles, 1) if angles.size > 2 else (0.0, angles.mean())
        rate *= 1.0 + float(slope)
        if abs(slope) * angles.size < 1e-9:
            break
    rate, offset = _by_least_squares(
        time[inner], x[inner], (first, mean), rate, float(offset), cuts.size - 1
    )
    turn = time - first
    turn *= rate
    turn += offset
    return _from_first_cut(turn, cycles), rate


def _fundamentals(
    time: Floats, x: Floats, mean: float, first: float, rate: float, cuts: NDArray[np.int64]
) -> NDArray[np.complex128]:
    """First harmonic of each cycle, unscaled, some cycles at once."""
    harmonics = np.empty(cuts.size - 1, dtype=complex)
    at = 0
    while at < harmonics.size:
        last = int(np.searchsorted(cuts, cuts[at] + _PIECE, side="right")) - 1
        stop = min(max(last, at + 1), harmonics.size)
        piece = slice(int(cuts[at]), int(cuts[stop]))
        wave = (x[piece] - mean) * np.exp(-2j * math.pi * rate * (time[piece] - first))
        harmonics[at:stop] = np.add.reduceat(wave, cuts[at:stop] - cuts[at])
        at = stop
    return harmonics


def _from_first_cut(turn: Floats, cycles: Cuts) -> Floats:
    """Cycles since the first cut: a peak begins one, or a trough where cycles are cut there."""
    if cycles.flipped:
        turn -= 0.5
    turn -= math.ceil(float(turn[cycles.cuts[0]]) - 0.02)
    return turn


class Turns(NamedTuple):
    """Cycles since the first cut at each sample of a record."""

    turns: Floats
    """Cycles, counted on over gaps of the time; of a block no sooner and no later than it is."""
    place: NDArray[np.int64]
    """The whole cycle to which each sample belongs, counted from 0; -1 for none."""
    ends: tuple[tuple[slice, int, int], ...]
    """Samples of each block, its first cycle, and how many it has."""
    rate: float
    """Cycles a second, or a sample where there is no time."""

    @property
    def samples_a_cycle(self) -> float:
        """In the mean of the blocks."""
        edges = [(samples.start, samples.stop - 1) for samples, _, _ in self.ends]
        span = sum(float(self.turns[last] - self.turns[first]) for first, last in edges)
        return float(sum(last - first for first, last in edges)) / span

    @property
    def cycle_count(self) -> int:
        """Whole cycles of all blocks."""
        return sum(count for _, _, count in self.ends)


def all_turns(time: Floats, x: Floats, blocks: Blocks) -> Turns:
    """The phases of a record, block by block, the cycles counted on over the gaps."""
    parts = [
        turns_of(time[block.samples], x[block.samples], block.cycles)
        for block in blocks.having_cycles
    ]
    # A few cycles determine their rate less well than all blocks together.
    weight = np.array([float(block.cycle_count) ** 3 for block in blocks.having_cycles])
    rate = float(np.dot(weight, [part[1] for part in parts]) / weight.sum())
    turns = np.full(x.size, np.nan)
    place = np.full(x.size, -1, dtype=np.int64)
    ends, before = [], 0
    for block, (turn, _) in zip(blocks.having_cycles, parts, strict=True):
        if len(parts) > 1 and block.cycle_count < _OWN_RATE:
            turn = _at_rate(time[block.samples], x[block.samples], block.cycles, rate)
        cycle_count = math.floor(turn[-1] + (turn[-1] - turn[-2]) + 1e-6)
        if cycle_count < 1:
            continue
        for piece in stretches(turn.size):
            block_cycle = np.floor(turn[piece] + 1e-9).astype(np.int64)
            here = slice(block.first + piece.start, block.first + piece.stop)
            turns[here] = turn[piece] + before
            place[here] = np.where(
                (block_cycle >= 0) & (block_cycle < cycle_count), block_cycle + before, -1
            )
        ends.append((block.samples, before, cycle_count))
        before += cycle_count
    return Turns(turns, place, tuple(ends), rate)


def _at_rate(time: Floats, x: Floats, cycles: Cuts, rate: float) -> Floats:
    """Cycles since the first cut of a short block, its rate being known."""
    inner = slice(int(cycles.cuts[0]), int(cycles.cuts[-1]))
    turn = (time - time[inner.start]) * rate
    angle = 2.0 * math.pi * turn[inner]
    rows = np.stack((np.ones_like(angle), np.cos(angle), np.sin(angle)))
    series = _least_squares(rows @ rows.T, rows @ x[inner])
    offset = math.atan2(-float(series[2]), float(series[1])) / (2.0 * math.pi)
    return _from_first_cut(turn + offset, cycles)


def _by_least_squares(
    time: Floats, x: Floats, origin: tuple[float, float], rate: float, offset: float, cycles: int
) -> tuple[float, float]:
    """Rate and phase of the fundamental, some harmonics beside it, for samples uneven in time."""
    harmonic_count = max(1, min(_HARMONICS, int(0.25 * x.size / cycles)))
    size, (first, mean) = float(np.ptp(x)), origin
    whole_mean = float(time.mean()) - first
    series: Floats = np.zeros(2 * harmonic_count + 1)
    for step in range(_STEPS):
        middle = whole_mean * rate
        normal, right = (
            np.zeros((2 * harmonic_count + 2, 2 * harmonic_count + 2)),
            np.zeros(2 * harmonic_count + 2),
        )
        for at in range(0, x.size, _PIECE):
            turn = (time[at : at + _PIECE] - first) * rate
            wave = np.exp(2j * math.pi * turn)
            powers = np.cumprod(np.broadcast_to(wave, (harmonic_count, wave.size)), axis=0)
            rows = np.ones((2 * harmonic_count + 2, wave.size))
            rows[1 : harmonic_count + 1], rows[harmonic_count + 1 : -1] = powers.real, powers.imag
            n = np.arange(1, harmonic_count + 1)
            rise = (n * series[harmonic_count + 1 :]) @ powers.real - (
                n * series[1 : harmonic_count + 1]
            ) @ powers.imag
            rows[-1] = 2.0 * math.pi * (turn - middle) * rise
            normal += rows @ rows.T
            right += rows @ ((x[at : at + _PIECE] - mean) / size)
        if step == 0:  # no derivative without a series
            series = _least_squares(normal[:-1, :-1], right[:-1])
            continue
        solution = _least_squares(normal, right)
        series, slope = solution[:-1], float(solution[-1])
        if not abs(slope) * cycles < 0.5:
            return rate, offset
        offset = float(np.angle(series[1] - 1j * series[harmonic_count + 1])) / (2.0 * math.pi)
        offset -= slope * middle
        rate *= 1.0 + slope
        if abs(slope) * cycles < 1e-9:
            break
    return rate, offset


def _least_squares(normal: Floats, right: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(normal, right, rcond=None)[0], dtype=np.float64)


class Places(NamedTuple):
    """Number of bins for the samples of a record."""

    number: int
    alike: bool
    """Whether the samples of a bin have one phase; else they fill the gaps between each other."""


def places_of(phase: Floats, a_cycle: float) -> Places:
    """Different phases that the samples have, a few to each; ``a_cycle`` are those of a cycle."""
    first_phases = phase[: min(phase.size, _LOOKED_AT)]
    for cycles in range(1, _MOST_CYCLES + 1):
        sample_count = round(cycles * a_cycle)
        if cycles > 1 and sample_count * _FEWEST > phase.size:
            break
        if abs(np.exp(1j * sample_count * first_phases).mean()) > _IN_STEP:
            return Places(sample_count, True)
    return Places(max(math.floor(a_cycle), phase.size // _SAMPLES_A_BIN), False)


def stretches(size: int) -> Iterator[slice]:
    """Stretches of a long record that are worked on at once."""
    return (slice(at, min(at + _PIECE, size)) for at in range(0, size, _PIECE))
