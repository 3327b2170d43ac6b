"""The mean cycle: of the displacement a series, of forces a curve, and what is left beside it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.tribometer.phases import stretches

MOST_HARMONICS, MOST_OF_CORNERS = 120, 300
"""Of a motion whose harmonics stand out one by one; of one with corners, such as a triangle, whose
reversals a shorter series makes 0.3 % too near."""
QUIET = 1e-9
"""Of the amplitude: below it noise is rounding."""
_FINE = 4096  # bins of the displacement: their width is nothing to a hundred harmonics
_ROUNDS, _LARGE = 100, 0.3
_MANY = 5
"""Harmonics from which on a motion is no sine, so that all of them count."""
_LEAST_SHARE = 0.1  # of the noise of a sample that the curve must leave for it to count
_TAILS, _WITHIN = 3.0, 0.97334  # share of the variance of a normal distribution within three
_SIGNIFICANT = 1e-3


class Level(NamedTuple):
    """A channel beside its mean cycle."""

    mean: Floats
    """Of each bin."""
    base: Floats
    """What to add to the rest of a sample for its value in the middle of its bin."""
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


# -- the displacement as a series -----------------------------------------------------------------


def series_of(
    phase: Floats, x: Floats, places: int
) -> tuple[NDArray[np.int64], Floats, Floats, float]:
    """Fourier series of the displacement: harmonics, coefficients, covariance, noise [m]."""
    size = _FINE
    column = np.empty(phase.size, dtype=np.int64)
    for piece in stretches(phase.size):
        bins = (phase[piece] * (size / (2.0 * math.pi)) + 1e-9).astype(np.int64)
        column[piece] = np.minimum(bins, size - 1)
    weight = np.bincount(column, minlength=size).astype(float)
    full = weight > 0.0
    weight = weight[full]
    place = np.bincount(column, phase, minlength=size)[full] / weight
    mean = np.bincount(column, x, minlength=size)[full] / weight
    most_told = max(1, math.floor(0.4 * places))
    harmonic_count = min(MOST_HARMONICS, most_told)
    all_of, design = _series_design(place, harmonic_count)
    floor = QUIET * 0.5 * float(np.ptp(mean))
    price = 2.0 * math.log(x.size) + 2.0 * math.log(harmonic_count)
    harmonics, is_whole = np.array([1]), False
    for _ in range(_ROUNDS):
        columns = np.concatenate(
            ([0], np.column_stack((harmonics, harmonic_count + harmonics)).ravel())
        )
        part = design[:, columns]
        normal = part.T @ (weight[:, None] * part)
        coefficients = np.linalg.solve(normal, part.T @ (weight * mean))
        residual = _sample_residual(
            phase, x, column, full, place, part @ coefficients, coefficients, harmonics
        )
        # What is left at each harmonic; they are nearly orthogonal over whole cycles.
        amplitudes = design.T @ np.bincount(column, residual, minlength=size)[full] * (2.0 / x.size)
        power = (
            0.5
            * x.size
            * (amplitudes[1 : harmonic_count + 1] ** 2 + amplitudes[harmonic_count + 1 :] ** 2)
        )
        is_unused = np.ones(harmonic_count, dtype=bool)
        is_unused[harmonics - 1] = False
        freedom = max(x.size - 2 * harmonic_count - 1, 1)
        white = max(float(residual @ residual) - float(power[is_unused].sum()), 0.0) / freedom
        noise = max(math.sqrt(white), floor)
        # Two degrees of freedom each; one pays if it takes off more than BIC's price of two.
        # The largest first: what is left of them leaks into others where phases are not even.
        lowest_power = max(price * noise**2, _LARGE * float(power[is_unused].max(initial=0.0)))
        new = all_of[is_unused & (power > lowest_power)]
        if new.size == 0 and not is_whole and harmonics.size >= _MANY:
            # Of a triangle or a trapezoid: those that do not stand out by themselves do together.
            is_odd = bool(np.all(harmonics % 2 == 1))
            # Corners of a drive are alike there and back; other motions have no more to tell.
            harmonic_count, is_whole = min(MOST_OF_CORNERS, most_told), True
            if not is_odd:
                harmonic_count = min(MOST_HARMONICS, most_told)
            all_of, design = _series_design(place, harmonic_count)
            is_unused = ~np.isin(all_of, harmonics)
            new = all_of[is_unused & ((all_of % 2 == 1) | (not is_odd))]
        if new.size == 0:
            break
        harmonics = np.sort(np.concatenate((harmonics, new)))
    return harmonics, coefficients, noise**2 * np.linalg.inv(normal), noise


def _series_design(place: Floats, count: int) -> tuple[Any, Any]:
    """Harmonics up to a number, and the mean, cosines and sines of all of them at some phases."""
    all_of = np.arange(1, count + 1, dtype=np.int64)
    angle = np.outer(place, all_of)
    return all_of, np.hstack((np.ones((place.size, 1)), np.cos(angle), np.sin(angle)))


def _sample_residual(
    phase: Floats,
    x: Floats,
    column: NDArray[np.int64],
    full: NDArray[np.bool_],
    place: Floats,
    fitted: Floats,
    coefficients: Floats,
    harmonics: NDArray[np.int64],
) -> Floats:
    """Each sample less the series, taken along its tangent from the middle of the bin."""
    angle = np.outer(place, harmonics)
    slopes = harmonics * (-np.sin(angle) * coefficients[1::2] + np.cos(angle) * coefficients[2::2])
    value, slope, middle = np.zeros((3, full.size))
    value[full], slope[full], middle[full] = fitted, slopes.sum(axis=1), place
    residual = x.copy()
    for piece in stretches(x.size):
        of = column[piece]
        residual[piece] -= value[of] + slope[of] * (phase[piece] - middle[of])
    return residual


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
