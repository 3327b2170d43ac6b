"""The mean cycle of a channel as a curve through bins, and the residuals."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.tribometer.phases import stretches

_LEAST_SHARE = 0.1  # of the noise of a sample that the curve must leave for it to count
_TAILS, _WITHIN = 3.0, 0.97334  # share of the variance of a normal distribution within three
_SIGNIFICANT = 1e-3
_TWO_STEPS, _LEAST_BINS = 0.25 + 1e-9, 0.05
"""Variance of numbers of which half are one step further; share of the bins that counts."""


class Level(NamedTuple):
    """A channel beside its mean cycle."""

    mean: Floats
    """Mean of each bin."""
    base: Floats
    """Correction of the residual of a sample to the middle of its bin."""
    residual: Floats
    """Each sample less the mean cycle at its phase."""


class MeanCycle:
    """The mean cycle of samples in bins, as a curve through them.

    Where the samples of a bin have one phase, its mean; about it they follow the secant to its
    neighbours. Else a cubic through each bin and its neighbours. Samples go by in pieces: of long
    records few arrays are held at once.
    """

    def __init__(self, phase: Floats, column: NDArray[np.int64], size: int, alike: bool) -> None:
        self.column, self.size = column, size
        self.total = np.bincount(column, minlength=size).astype(float)
        self.middle = np.bincount(column, phase) / self.total
        self._alike = alike or size < 8
        self._unit = 1.0 if self._alike else 2.0 * math.pi / size
        self._phase = phase
        squares = self._moments(np.ones(phase.size), 2)
        self.spread = self._unit * np.sqrt(squares[2] / self.total)
        self.freedom = float(phase.size - size)
        """Samples less what the curve takes of them."""
        if not self._alike:
            self._prepare()
            self.freedom = sum(float(self._noise_share(at).sum()) for at in stretches(phase.size))

    def _offsets(self, piece: slice) -> Floats:
        """Phases of samples from the middle of their bins, in widths of a bin for cubics."""
        away: Floats = self._phase[piece] - self.middle[self.column[piece]]
        return away / self._unit

    def _moments(
        self, values: NDArray[np.float64] | NDArray[np.int64], highest_power: int
    ) -> Floats:
        """Sums over each bin of the values times powers of the places in it."""
        moments = np.zeros((highest_power + 1, self.size))
        for piece in stretches(values.size):
            column, about, powers = self.column[piece], self._offsets(piece), values[piece]
            for row in moments:
                row += np.bincount(column, powers, minlength=self.size)
                powers = powers * about
        return moments

    def _with_neighbours(self, moments: Floats) -> Floats:
        """Moments of each bin and its neighbours about its own middle."""
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

    def _curve(self, factors: Floats, piece: slice) -> Floats:
        """Polynomials of the bins, lowest power first, at the places of samples."""
        column, about = self.column[piece], self._offsets(piece)
        curve: Floats = factors[-1][column]
        for row in factors[-2::-1]:
            curve *= about
            curve += row[column]
        return curve

    def _prepare(self) -> None:
        sums = self._with_neighbours(self._moments(np.ones(self.column.size), 6))
        normal = np.stack([sums[i : i + 4].T for i in range(4)], axis=1)
        normal += 1e-9 * normal[:, :1, :1] * np.eye(4)  # too few samples for a cubic
        self._inverse = np.linalg.inv(normal)
        self._levers = np.zeros((7, self.size))
        for i in range(4):
            self._levers[i : i + 4] += self._inverse[:, i].T

    def _noise_share(self, piece: slice) -> Floats:
        """Share of the noise variance of each sample that remains in the curve."""
        return 1.0 - self._curve(self._levers, piece)

    def of(self, values: NDArray[np.float64] | NDArray[np.int64]) -> Level:
        """A channel [any unit] beside its mean cycle."""
        moments = self._moments(values, 0 if self._alike else 3)
        mean = moments[0] / self.total
        if self._alike:
            factors = np.stack((mean, _slopes(self.middle, mean)))
        else:
            sums = self._with_neighbours(moments)
            factors = np.einsum("nij,jn->in", self._inverse, sums)
        residual = values.astype(float)
        for piece in stretches(values.size):
            residual[piece] -= self._curve(factors, piece)
        if self._alike:
            return Level(mean, mean, residual)
        return Level(mean, mean - np.bincount(self.column, residual) / self.total, residual)

    def noise(self, residual: Floats, fitted_count: int = 0) -> float:
        """Standard deviation of white noise that leaves this; ``fitted_count`` more were fitted."""
        freedom = max(self.freedom - fitted_count, 1.0)
        total_noise = math.sqrt(float(np.dot(residual, residual)) / freedom)
        if self._alike:
            return total_noise
        # A cubic does not follow a kink: what few samples there leave is no noise.
        far = _TAILS * 1.4826 * float(np.median(self._scaled(residual), overwrite_input=True))
        near_freedom, square = -float(fitted_count), 0.0
        for piece in stretches(residual.size):
            share, piece_residual = self._noise_share(piece), residual[piece]
            near = (share > _LEAST_SHARE) & (
                np.abs(piece_residual) <= far * np.sqrt(np.maximum(share, _LEAST_SHARE))
            )
            near_freedom += float(share[near].sum())
            square += float(np.sum(piece_residual[near] ** 2))
        if near_freedom < 0.5 * freedom or far == 0.0:
            return total_noise
        return min(total_noise, math.sqrt(square / near_freedom / _WITHIN))

    def _scaled(self, residual: Floats) -> Floats:
        """Residuals over what the curve leaves of them, where it leaves anything."""
        scaled, end = np.empty(residual.size), 0
        for piece in stretches(residual.size):
            share, piece_residual = self._noise_share(piece), residual[piece]
            is_free = share > _LEAST_SHARE
            new = np.abs(piece_residual[is_free]) / np.sqrt(share[is_free])
            scaled[end : end + new.size] = new
            end += new.size
        return scaled[:end]


def _slopes(middle: Floats, mean: Floats) -> Floats:
    """Slope of the mean cycle in each bin, a radian, by central differences."""
    turn = 2.0 * math.pi
    places = np.concatenate(([middle[-1] - turn], middle, [middle[0] + turn]))
    values = np.concatenate(([mean[-1]], mean, [mean[0]]))
    return np.asarray((values[2:] - values[:-2]) / (places[2:] - places[:-2]))


def errors_of_steps(values: Floats, step: float, column: NDArray[np.int64]) -> NDArray[np.float64]:
    """Errors of the means of bins (rows) by steps of a converter, in halves; none if dithered.

    Where the samples of a bin lie on one step or on two, no scatter tells where between them the
    channel was: the bins of one step have an error in common, and one that grows along them.
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


# -- what changes over the cycles -----------------------------------------------------------------


class Slope(NamedTuple):
    """A straight line over the cycles."""

    slope: float
    """Change a cycle."""
    error: float
    """Standard error of that."""


def drift_of(values: Floats, cycle: NDArray[np.int64], curve: MeanCycle) -> Slope:
    """Drift of a channel beside its mean cycle; slow noise counts by the scatter of the cycles."""
    progress = curve.of(cycle).residual
    square = float(progress @ progress)
    if square == 0.0:
        return Slope(0.0, 0.0)
    scatter = curve.of(values).residual
    slope = float(progress @ scatter) / square
    progress *= slope
    scatter -= progress
    del progress
    noise = curve.noise(scatter, 1)
    return Slope(slope, noise * math.sqrt(slowness(scatter, cycle, noise, 2) / square))


def slowness(residual: Floats, number: NDArray[np.int64], noise: float, fitted_count: int) -> float:
    """Variance of the means of cycles over that of white noise; 1 if not significantly more."""
    from scipy.special import chdtrc

    count = np.bincount(number).astype(float)
    freedom = np.count_nonzero(count) - fitted_count
    if freedom < 1 or noise == 0.0:
        return 1.0
    sums = np.bincount(number, residual)
    square = float(np.sum(sums**2 / np.maximum(count, 1.0))) / noise**2
    return square / freedom if chdtrc(freedom, square) < _SIGNIFICANT else 1.0


def error_of_mean(values: Floats, number: NDArray[np.int64], curve: MeanCycle) -> float:
    """Standard error of a mean, by white noise or, where larger, by the scatter of the cycles."""
    residual = curve.of(values).residual
    noise = curve.noise(residual)
    count = np.bincount(number).astype(float)
    means = np.bincount(number, residual) / count
    place = np.arange(means.size, dtype=float)
    if means.size > 2:
        line = np.polynomial.Polynomial.fit(place, means, 1, w=np.sqrt(count))
        for piece in stretches(residual.size):
            residual[piece] -= line(place)[number[piece]]
    noise = curve.noise(residual, 1)
    return noise * math.sqrt(slowness(residual, number, noise, 2) / values.size)
