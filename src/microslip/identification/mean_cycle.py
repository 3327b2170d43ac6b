"""Where in its cycle each sample of a record lies, and what the others make of it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.tribometer.blocks import Blocks
from microslip.tribometer.cycles import Cycles

_IN_STEP, _MOST_CYCLES, _LOOKED_AT = 0.95, 32, 1 << 14
_FEWEST, _EACH = 3, 4  # samples of a place, and of a bin where no places are the same
_HARMONICS, _STEPS, _PIECE = 5, 4, 1 << 16
_OWN_RATE = 5  # cycles of a block from which its own rate is known well
_TAILS, _WITHIN = 3.0, 0.97334  # share of the variance of a normal distribution within three


def turns_of(time: Floats, x: Floats, cycles: Cycles) -> tuple[Floats, float]:
    """Cycles since the first cut at each sample, by the phase of the fundamental; and their rate.

    The rate is that of the whole record, so the samples of a cycle need not be a whole number, nor
    be even in time.
    """
    cuts = cycles.cuts
    first, last = time[cuts[0]], time[min(int(cuts[-1]), time.size - 1)]
    rate = (cuts.size - 1) / float(last - first)
    if cuts.size < 3:
        return (time - first) * rate, rate
    begin = (cuts[:-1]).astype(np.int64)
    inner = slice(int(cuts[0]), int(cuts[-1]))
    away = x[inner] - float(np.mean(x[inner]))
    offset = 0.0
    for _ in range(3):
        turn = (time[inner] - first) * rate
        wave = away * np.exp(-2j * math.pi * turn)
        angles = np.angle(np.add.reduceat(wave, begin - begin[0])) / (2.0 * math.pi)
        angles = np.unwrap(angles, period=1.0)
        centres = np.arange(angles.size) + 0.5
        # Ends are cut to whole samples, so that the slope is that of a straight line through all.
        slope, offset = np.polyfit(centres, angles, 1) if angles.size > 2 else (0.0, angles.mean())
        rate *= 1.0 + float(slope)
        if abs(slope) * angles.size < 1e-9:
            break
    rate, offset = _by_least_squares(time[inner] - first, away, rate, float(offset), cuts.size - 1)
    return _counted((time - first) * rate + offset, cycles), rate


def _counted(turn: Floats, cycles: Cycles) -> Floats:
    """Cycles since the first cut: a peak begins one, or a trough where cycles are cut there."""
    turn = turn - (0.5 if cycles.flipped else 0.0)
    return turn - math.ceil(float(turn[cycles.cuts[0]]) - 0.02)


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
    def whole(self) -> int:
        """Whole cycles of all blocks."""
        return sum(whole for _, _, whole in self.ends)


def all_turns(time: Floats, x: Floats, blocks: Blocks) -> Turns:
    """The phases of a record, block by block, the cycles counted on over the gaps."""
    parts = [
        turns_of(time[block.samples], x[block.samples], block.cycles)
        for block in blocks.having_cycles
    ]
    # A few cycles tell their rate less well than all blocks together.
    weight = np.array([float(block.whole) ** 3 for block in blocks.having_cycles])
    rate = float(np.dot(weight, [part[1] for part in parts]) / weight.sum())
    turns = np.full(x.size, np.nan)
    place = np.full(x.size, -1, dtype=np.int64)
    ends, before = [], 0
    for block, (turn, _) in zip(blocks.having_cycles, parts, strict=True):
        if len(parts) > 1 and block.whole < _OWN_RATE:
            turn = _at_rate(time[block.samples], x[block.samples], block.cycles, rate)
        whole = math.floor(turn[-1] + (turn[-1] - turn[-2]) + 1e-6)
        if whole < 1:
            continue
        own = np.floor(turn + 1e-9).astype(np.int64)
        turns[block.samples] = turn + before
        place[block.samples] = np.where((own >= 0) & (own < whole), own + before, -1)
        ends.append((block.samples, before, whole))
        before += whole
    return Turns(turns, place, tuple(ends), rate)


def _at_rate(time: Floats, x: Floats, cycles: Cycles, rate: float) -> Floats:
    """Cycles since the first cut of a short block, its rate being known."""
    inner = slice(int(cycles.cuts[0]), int(cycles.cuts[-1]))
    turn = (time - time[inner.start]) * rate
    angle = 2.0 * math.pi * turn[inner]
    rows = np.stack((np.ones_like(angle), np.cos(angle), np.sin(angle)))
    series = _solved(rows @ rows.T, rows @ x[inner])
    offset = math.atan2(-float(series[2]), float(series[1])) / (2.0 * math.pi)
    return _counted(turn + offset, cycles)


def _by_least_squares(
    time: Floats, x: Floats, rate: float, offset: float, cycles: int
) -> tuple[float, float]:
    """Rate and phase of the fundamental, some harmonics beside it.

    Sums over single cycles are as good only where these hold samples even in time.
    """
    most = max(1, min(_HARMONICS, int(0.25 * x.size / cycles)))
    size = float(np.ptp(x))
    series: Floats = np.zeros(2 * most + 1)
    for step in range(_STEPS):
        middle = float(time.mean()) * rate
        normal, right = np.zeros((2 * most + 2, 2 * most + 2)), np.zeros(2 * most + 2)
        for at in range(0, x.size, _PIECE):
            turn = time[at : at + _PIECE] * rate
            wave = np.exp(2j * math.pi * turn)
            powers = np.cumprod(np.broadcast_to(wave, (most, wave.size)), axis=0)
            rows = np.ones((2 * most + 2, wave.size))
            rows[1 : most + 1], rows[most + 1 : -1] = powers.real, powers.imag
            n = np.arange(1, most + 1)
            rise = (n * series[most + 1 :]) @ powers.real - (n * series[1 : most + 1]) @ powers.imag
            rows[-1] = 2.0 * math.pi * (turn - middle) * rise
            normal += rows @ rows.T
            right += rows @ (x[at : at + _PIECE] / size)
        if step == 0:  # no derivative without a series
            series = _solved(normal[:-1, :-1], right[:-1])
            continue
        whole = _solved(normal, right)
        series, slope = whole[:-1], float(whole[-1])
        if not abs(slope) * cycles < 0.5:
            return rate, offset
        offset = float(np.angle(series[1] - 1j * series[most + 1])) / (2.0 * math.pi)
        offset -= slope * middle
        rate *= 1.0 + slope
        if abs(slope) * cycles < 1e-9:
            break
    return rate, offset


def _solved(normal: Floats, right: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(normal, right, rcond=None)[0], dtype=np.float64)


class Places(NamedTuple):
    """How many bins the samples of a record want."""

    number: int
    alike: bool
    """Whether the samples of a bin have one phase; else they fill the gaps between each other."""


def places_of(phase: Floats, a_cycle: float) -> Places:
    """Different phases that the samples have, a few samples to each.

    ``a_cycle`` is the number of samples of a cycle. Where that of one cycle, or of some, is whole,
    it is the number of their samples.
    """
    few = phase[: min(phase.size, _LOOKED_AT)]
    for cycles in range(1, _MOST_CYCLES + 1):
        whole = round(cycles * a_cycle)
        if cycles > 1 and whole * _FEWEST > phase.size:
            break
        if abs(np.exp(1j * whole * few).mean()) > _IN_STEP:
            return Places(whole, True)
    return Places(max(math.floor(a_cycle), phase.size // _EACH), False)


class Level(NamedTuple):
    """A channel beside its mean cycle."""

    mean: Floats
    """Of each bin."""
    level: Floats
    """Each sample as it would be in the middle of its bin."""
    rest: Floats
    """Each sample less the mean cycle at its phase."""


class MeanCycle:
    """The mean cycle of samples in bins, as a curve through them.

    Where the samples of a bin have one phase, its mean; about it they follow the secant to its
    neighbours. Else a cubic through each bin and its neighbours.
    """

    def __init__(self, phase: Floats, column: NDArray[np.int64], size: int, alike: bool) -> None:
        self.column, self.size = column, size
        self.total = np.bincount(column, minlength=size).astype(float)
        self.middle = np.bincount(column, phase) / self.total
        self._about = phase - self.middle[column]
        self.spread = np.sqrt(np.bincount(column, self._about**2) / self.total)
        self._alike = alike or size < 8
        self.freedom = float(phase.size - size)
        """Samples less what the curve takes of them."""
        if not self._alike:
            self._prepare(phase)

    def _prepare(self, phase: Floats) -> None:
        turn, size = 2.0 * math.pi, self.size
        self._targets = [(self.column + way) % size for way in (-1, 0, 1)]
        self._places = []
        normal = np.zeros((size, 4, 4))
        for target in self._targets:
            away = (phase - self.middle[target] + 0.5 * turn) % turn - 0.5 * turn
            powers = (away * (size / turn)) ** np.arange(7)[:, None]
            self._places.append(powers[:4])
            sums = np.array([np.bincount(target, row, minlength=size) for row in powers])
            for i in range(4):
                normal[:, i] += sums[i : i + 4].T
        normal += 1e-9 * normal[:, :1, :1] * np.eye(4)  # too few samples for a cubic
        self._inverse = np.linalg.inv(normal)
        columns = self._places[1]
        self._lever = np.einsum("in,nij,jn->n", columns, self._inverse[self.column], columns)
        self.freedom = float(phase.size - self._lever.sum())

    def of(self, values: Floats) -> Level:
        """A channel [any unit] beside its mean cycle."""
        column, mean = self.column, np.bincount(self.column, values) / self.total
        if self._alike:
            level = values - _slopes(self.middle, mean)[column] * self._about
            return Level(mean, level, level - mean[column])
        right = np.zeros((4, self.size))
        for target, powers in zip(self._targets, self._places, strict=True):
            right += [np.bincount(target, row * values, minlength=self.size) for row in powers]
        factors = np.einsum("nij,jn->in", self._inverse, right)
        curve = (factors[:, column] * self._places[1]).sum(axis=0)
        level = values - curve + (np.bincount(column, curve) / self.total)[column]
        return Level(mean, level, values - curve)

    def noise(self, residual: Floats, taken: int = 0) -> float:
        """Standard deviation of white noise that leaves this, ``taken`` more numbers fitted."""
        freedom = max(self.freedom - taken, 1.0)
        whole = math.sqrt(float(np.dot(residual, residual)) / freedom)
        if self._alike:
            return whole
        # A cubic does not follow a kink: what few samples there leave is no noise.
        scaled = np.abs(residual) / np.sqrt(np.maximum(1.0 - self._lever, 1e-3))
        far = _TAILS * 1.4826 * float(np.median(scaled[self._lever < 0.9]))
        near = (scaled <= far) & (self._lever < 0.9)
        left = float(np.sum(1.0 - self._lever[near])) - taken
        if left < 0.5 * freedom or far == 0.0:
            return whole
        return min(whole, math.sqrt(float(np.sum(residual[near] ** 2)) / left / _WITHIN))


def _slopes(middle: Floats, mean: Floats) -> Floats:
    """Slope of the mean cycle in each bin, a radian, by central differences."""
    turn = 2.0 * math.pi
    places = np.concatenate(([middle[-1] - turn], middle, [middle[0] + turn]))
    values = np.concatenate(([mean[-1]], mean, [mean[0]]))
    return np.asarray((values[2:] - values[:-2]) / (places[2:] - places[:-2]))
