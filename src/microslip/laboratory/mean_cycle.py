"""Phase of each sample in its cycle, mean cycle of a channel in phase bins, and residuals."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.laboratory.blocks import Blocks
from microslip.laboratory.cuts import Cuts

_LEAST_SHARE = 0.1  # smallest noise share of a residual that is used
_TAILS, _WITHIN = 3.0, 0.97334  # share of the variance of a normal distribution within three
_SIGNIFICANT = 1e-3
_TWO_STEPS, _LEAST_BINS = 0.25 + 1e-9, 0.05
"""Largest variance [steps^2] of samples that lie on one or two neighbouring converter steps, and
smallest fraction of such bins in a record that is evaluated by steps."""


class ChannelMean(NamedTuple):
    """Mean cycle of a channel, and deviations of its samples from the mean cycle."""

    mean: Floats
    """Mean of each bin."""
    base: Floats
    """Correction of the residual of a sample to the middle of its bin."""
    residual: Floats
    """Samples minus the mean cycle."""


class MeanCycle:
    """Mean cycle of a channel as a smooth curve through phase bins.

    If all samples of a bin have the same phase, the curve is the mean of the bin with a slope from
    the neighbouring bins, otherwise a cubic fitted to the bin and its neighbours.
    """

    def __init__(self, phase: Floats, column: NDArray[np.int64], size: int, alike: bool) -> None:
        self.column, self.size = column, size
        self.total = np.bincount(column, minlength=size).astype(float)
        self.middle = np.bincount(column, phase) / self.total
        self._alike = alike or size < 8
        self._unit = 1.0 if self._alike else 2.0 * math.pi / size
        # Phases of samples relative to the mean phase of their bin [bin widths].
        self._about: Floats = (phase - self.middle[column]) / self._unit
        squares = self._moments(np.ones(phase.size), 2)
        self.spread = self._unit * np.sqrt(squares[2] / self.total)
        self.freedom = float(phase.size - size)
        """Degrees of freedom of the residual."""
        if not self._alike:
            sums = self._with_neighbours(self._moments(np.ones(phase.size), 6))
            normal = np.stack([sums[i : i + 4].T for i in range(4)], axis=1)
            normal += 1e-9 * normal[:, :1, :1] * np.eye(4)  # too few samples for a cubic
            self._inverse = np.linalg.inv(normal)
            levers = np.zeros((7, size))
            for i in range(4):
                levers[i : i + 4] += self._inverse[:, i].T
            # Variance of each sample's residual over that of the noise of a sample [-].
            self._noise_share = 1.0 - self._curve(levers)
            self.freedom = float(self._noise_share.sum())

    def _moments(self, values: NDArray[Any], highest_power: int) -> Floats:
        rows, powers = [], values
        for _ in range(highest_power + 1):
            rows.append(np.bincount(self.column, powers, minlength=self.size))
            powers = powers * self._about
        return np.array(rows)

    def _with_neighbours(self, moments: Floats) -> Floats:
        turn, number = 2.0 * math.pi, moments.shape[0]
        sums = moments.copy()
        for way in (-1, 1):
            step = self.middle - np.roll(self.middle, way)
            shift = ((step + 0.5 * turn) % turn - 0.5 * turn) / -self._unit
            neighbour = np.roll(moments, way, axis=1)
            for k in range(number):
                for j in range(k + 1):
                    sums[k] += math.comb(k, j) * shift ** (k - j) * neighbour[j]
        return sums

    def _curve(self, factors: Floats) -> Floats:
        curve: Floats = factors[-1][self.column]
        for row in factors[-2::-1]:
            curve *= self._about
            curve += row[self.column]
        return curve

    def of(self, values: NDArray[Any]) -> ChannelMean:
        """Fit the mean cycle to the samples of a channel, in any unit."""
        moments = self._moments(values, 0 if self._alike else 3)
        mean = moments[0] / self.total
        if self._alike:
            turn = 2.0 * math.pi
            places = np.concatenate(
                ([self.middle[-1] - turn], self.middle, [self.middle[0] + turn])
            )
            around = np.concatenate(([mean[-1]], mean, [mean[0]]))
            factors = np.stack((mean, (around[2:] - around[:-2]) / (places[2:] - places[:-2])))
        else:
            sums = self._with_neighbours(moments)
            factors = np.einsum("nij,jn->in", self._inverse, sums)
        residual = values - self._curve(factors)
        return ChannelMean(mean, mean - np.bincount(self.column, residual) / self.total, residual)

    def noise(self, residual: Floats, fitted_count: int = 0) -> float:
        """Estimate the standard deviation of noise, if ``fitted_count`` more terms were fitted."""
        freedom = max(self.freedom - fitted_count, 1.0)
        total_noise = math.sqrt(float(np.dot(residual, residual)) / freedom)
        if self._alike:
            return total_noise
        # A cubic does not follow a kink: large residuals there are not noise.
        is_free = self._noise_share > _LEAST_SHARE
        share, free = self._noise_share[is_free], residual[is_free]
        scaled = np.abs(free) / np.sqrt(share)
        far = _TAILS * 1.4826 * float(np.median(scaled))
        near = scaled <= far
        near_freedom = float(share[near].sum()) - fitted_count
        if near_freedom < 0.5 * freedom or far == 0.0:
            return total_noise
        square = float(np.sum(free[near] ** 2))
        return min(total_noise, math.sqrt(square / near_freedom / _WITHIN))


def errors_of_steps(values: Floats, step: float, column: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return possible errors of the bin means due to converter steps, in units of half a step.

    The shape is (errors, bins). If the samples of a bin lie on one or two steps, the mean does not
    determine the value in between: adjacent bins on the same step can be wrong together by a
    constant, or by a linear function of the bin number, of up to half a step. Empty if noise
    spreads the samples over more steps.
    """
    number = np.rint((values - values[0]) / step)
    total = np.bincount(column)
    mean = np.bincount(column, number) / total
    is_on = np.bincount(column, number**2) / total - mean**2 <= _TWO_STEPS
    if np.mean(is_on) < _LEAST_BINS:
        return np.zeros((0, mean.size))
    rows = []
    level = np.where(is_on, np.rint(mean), np.nan)
    for bins in np.split(np.arange(mean.size), np.flatnonzero(level[1:] != level[:-1]) + 1):
        if is_on[bins[0]]:
            rows += [np.zeros(mean.size), np.zeros(mean.size)]
            rows[-2][bins], rows[-1][bins] = 1.0, np.linspace(-1.0, 1.0, bins.size)
    return np.array(rows)


# -- trends over the cycles -----------------------------------------------------------------------


def drift_of(values: Floats, cycle: NDArray[np.int64], curve: MeanCycle) -> tuple[float, float]:
    """Fit the drift per cycle of a channel; return it with its standard error.

    The error includes the scatter between cycles.
    """
    from scipy.special import chdtrc

    progress = curve.of(cycle).residual
    square = float(progress @ progress)
    if square == 0.0:
        return 0.0, 0.0
    scatter = curve.of(values).residual
    slope = float(progress @ scatter) / square
    progress *= slope
    scatter -= progress
    del progress
    noise = curve.noise(scatter, 1)
    # The means of cycles may scatter more than white noise does.
    count = np.bincount(cycle).astype(float)
    freedom, ratio = np.count_nonzero(count) - 2, 1.0
    if freedom > 0 and noise > 0.0:
        sums = np.bincount(cycle, scatter)
        total = float(np.sum(sums**2 / np.maximum(count, 1.0))) / noise**2
        ratio = total / freedom if chdtrc(freedom, total) < _SIGNIFICANT else 1.0
    return slope, noise * math.sqrt(ratio / square)


_IN_STEP, _MOST_CYCLES, _LOOKED_AT = 0.95, 32, 1 << 14
_FEWEST, _SAMPLES_A_BIN = 3, 4  # samples per phase, and per bin if no phases repeat
_HARMONICS, _STEPS, _PIECE = 5, 4, 1 << 16
_UNEVEN, _FEWEST_BENT = 0.01, 4
"""Scatter of the phases [cycles] above which the frequency varies, and fewest cycles for that."""
_SAME_RATE = 0.1
"""Largest relative difference of the rate of a short block from that of all."""
_OWN_RATE = 5  # fewest cycles of a block with a rate of its own


def turns_of(time: Floats, x: Floats, cycles: Cuts) -> tuple[Floats, float]:
    """Return the phase of each sample [cycles since the first cut], and the frequency [Hz]."""
    cuts = cycles.cuts
    first, last = time[cuts[0]], time[min(int(cuts[-1]), time.size - 1)]
    rate = (cuts.size - 1) / float(last - first)
    if cuts.size < 3:
        return (time - first) * rate, rate
    inner = slice(int(cuts[0]), int(cuts[-1]))
    mean = float(np.mean(x[inner]))
    angles = _angles(x[inner] - mean, (time[inner] - first) * rate, cuts)
    centres = np.arange(angles.size) + 0.5
    # Ends are cut to whole samples, so that the slope is that of a straight line through all.
    slope, offset = np.polyfit(centres, angles, 1) if angles.size > 2 else (0.0, angles.mean())
    if angles.size > _FEWEST_BENT and np.std(angles - offset - slope * centres) > _UNEVEN:
        return _bent_turns(time, x, mean, cycles), rate * (1.0 + float(slope))
    rate *= 1.0 + float(slope)
    rate, offset = _by_least_squares(
        time[inner], x[inner], (first, mean), rate, float(offset), cuts.size - 1
    )
    turn = time - first
    turn *= rate
    turn += offset
    return _from_first_cut(turn, cycles), rate


def _bent_turns(time: Floats, x: Floats, mean: float, cycles: Cuts) -> Floats:
    from scipy.interpolate import CubicSpline

    cuts = cycles.cuts
    inner = slice(int(cuts[0]), int(cuts[-1]))
    at = time[np.minimum(cuts, time.size - 1)]
    turn = CubicSpline(at, np.arange(float(cuts.size)))
    for _ in range(3):
        angles = _angles(x[inner] - mean, turn(time[inner]), cuts)
        middle = 0.5 * (at[1:] + at[:-1])
        turn = CubicSpline(middle, turn(middle) + angles)
    return _from_first_cut(np.asarray(turn(time), dtype=np.float64), cycles)


def _angles(x: Floats, turn: Floats, cuts: NDArray[np.int64]) -> Floats:
    """Return the phase of the fundamental of each cycle, less the phases ``turn`` [cycles]."""
    sums = np.add.reduceat(x * np.exp(-2j * math.pi * turn), cuts[:-1] - cuts[0])
    return np.unwrap(np.angle(sums) / (2.0 * math.pi), period=1.0)


def _from_first_cut(turn: Floats, cycles: Cuts) -> Floats:
    """Shift phases [cycles] to zero at the first peak (trough if ``flipped``) of a cycle."""
    if cycles.flipped:
        turn -= 0.5
    turn -= math.ceil(float(turn[cycles.cuts[0]]) - 0.02)
    return turn


def all_turns(time: Floats, x: Floats, blocks: Blocks) -> tuple[Floats, float]:
    """Return the phase of each sample of a record [cycles], and the mean samples per cycle.

    The phase is an integer at peaks and NaN outside the blocks, whose logged cycles are numbered in
    sequence.
    """
    parts = [
        turns_of(time[block.samples], x[block.samples], block.cycles)
        for block in blocks.having_cycles
    ]
    # A few cycles determine their rate less well than all blocks together.
    weight = np.array([float(block.cycle_count) ** 3 for block in blocks.having_cycles])
    rate = float(np.dot(weight, [part[1] for part in parts]) / weight.sum())
    turns = np.full(x.size, np.nan)
    before, steps, span = 0, 0, 0.0
    for block, (turn, own_rate) in zip(blocks.having_cycles, parts, strict=True):
        is_alike = abs(own_rate - rate) < _SAME_RATE * rate
        if len(parts) > 1 and block.cycle_count < _OWN_RATE and is_alike:
            turn = _at_rate(time[block.samples], x[block.samples], block.cycles, rate)
        turns[block.samples] = turn + before
        before += block.cycle_count
        steps += turn.size - 1
        span += float(turn[-1] - turn[0])
    return turns, steps / span


def _at_rate(time: Floats, x: Floats, cycles: Cuts, rate: float) -> Floats:
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
    """Refine frequency ``rate`` [Hz] and phase ``offset`` [cycles] of the fundamental.

    Some harmonics are fitted with it. ``origin`` is first time [s] and mean displacement [m].
    """
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


def places_of(phase: Floats, a_cycle: float) -> tuple[int, bool]:
    """Return the number of phase bins, and whether all samples of a bin have the same phase.

    Bins are the distinct phases of the samples, if phases repeat. ``a_cycle`` is the mean number of
    samples per cycle.
    """
    first_phases = phase[: min(phase.size, _LOOKED_AT)]
    for cycles in range(1, _MOST_CYCLES + 1):
        sample_count = round(cycles * a_cycle)
        if cycles > 1 and sample_count * _FEWEST > phase.size:
            break
        if abs(np.exp(1j * sample_count * first_phases).mean()) > _IN_STEP:
            return sample_count, True
    return max(math.floor(a_cycle), phase.size // _SAMPLES_A_BIN), False


def stretches(size: int) -> Iterator[slice]:
    """Yield slices that divide a long record into pieces, to limit memory."""
    return (slice(at, min(at + _PIECE, size)) for at in range(0, size, _PIECE))
