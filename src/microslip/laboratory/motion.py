"""Displacement of a mean cycle: harmonics, and corners for motions such as triangular waves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.frozen import LockedArrays
from microslip.laboratory.mean_cycle import stretches

MOST_HARMONICS, MOST_OF_CORNERS = 120, 300
"""Largest numbers of harmonics: of smooth motions, and of motions that are steep in places without
distinct corners."""
QUIET = 1e-9
"""Noise over the amplitude below which it is rounding."""
_FINE = 4096  # bins of the displacement, narrow for a hundred harmonics
_ROUNDS, _LARGE = 100, 0.3
_MANY = 5
"""Number of harmonics above which corners or all harmonics are tried."""
_MOST_CORNERS, _SHARP, _MOVES = 12, 0.25, 8
"""Most corners per cycle, smallest over largest, and iterations that find their phases."""


@dataclass(frozen=True, eq=False)
class PeriodicMotion(LockedArrays):
    """Periodic displacement as a sum of terms that are linear in the coefficients.

    Coefficients [m] are the mean, cosine and sine of each harmonic, and two for each corner at
    phase p: c K(t - p) + d K'(t - p), with K(t) = ((t - pi)^2/2 - pi^2/6)/(2 pi), the sum of
    cos(nt)/(pi n^2) over n >= 1. The slope of K decreases by 1 at t = 0; d moves the corner by
    -d/c.
    """

    harmonics: NDArray[np.int64]
    corners: Floats
    """Phases of the corners [rad]."""
    coefficients: Floats
    covariance: Floats
    """Covariance of the coefficients [m^2]."""
    noise: float
    """Standard deviation of a sample [m]."""

    def basis(self, phase: Floats, order: int = 0) -> Floats:
        """Evaluate the terms, or their derivatives, at phases [rad] (phases, coefficients)."""
        return basis(phase, self.harmonics, self.corners, order)


def basis(
    phase: Floats, harmonics: NDArray[np.int64], corners: Floats, order: int = 0
) -> NDArray[np.float64]:
    """Evaluate the terms of a motion at phases [rad], shape (phases, coefficients).

    ``order`` is the number of derivatives with respect to the phase.
    """
    shape = phase.size, int(harmonics.max(initial=0))
    powers = np.multiply.accumulate(np.broadcast_to(np.exp(1j * phase)[:, None], shape), axis=1)
    waves = np.ascontiguousarray(powers[:, harmonics - 1] * (1j * harmonics) ** order)
    mean = np.full((phase.size, 1), 1.0 if order == 0 else 0.0)
    return np.hstack((mean, waves.view(np.float64), corner_terms(phase, corners, order)))


def corner_terms(phase: Floats, corners: Floats, order: int = 0) -> NDArray[np.float64]:
    """Return K and K' of :class:`PeriodicMotion`, with columns K, K' of each corner in turn.

    They are evaluated at phases [rad], after ``order`` derivatives with respect to the phase.
    """
    turn = np.mod(phase[:, None] - corners, 2.0 * math.pi)
    away = np.where(turn > 0.0, turn - math.pi, 0.0) / (2.0 * math.pi)
    steps = [math.pi * away**2 - math.pi / 12.0, away, np.full(turn.shape, 0.5 / math.pi)]
    if order == 0 and corners.size:
        steps[0] = np.where(turn > 0.0, steps[0], math.pi / 6.0)
    steps += [np.zeros(turn.shape)] * order
    return np.stack(steps[order : order + 2], axis=2).reshape(phase.size, 2 * corners.size)


def phase_derivative(motion: PeriodicMotion) -> Floats:
    """Return the coefficients of the derivative of a motion with respect to the phase.

    A corner contributes c K' + d K'', with the kernel K and the coefficients c and d of
    :class:`PeriodicMotion`. The impulse d K'' is left out.
    """
    coefficients, n = motion.coefficients, motion.harmonics.astype(float)
    end = 1 + 2 * n.size
    moved = np.zeros_like(coefficients)
    moved[1:end:2] = n * coefficients[2:end:2]
    moved[2:end:2] = -n * coefficients[1:end:2]
    moved[end + 1 :: 2] = coefficients[end::2]
    return moved


# -- fit to samples -------------------------------------------------------------------------------


def motion_of(phase: Floats, x: Floats, places: int) -> PeriodicMotion:
    """Fit a motion to displacements ``x`` [m] at phases [rad] with ``places`` distinct values."""
    samples = _Samples(phase, x)
    most_resolved = max(1, math.floor(0.4 * places))
    smooth = _fitted(samples, min(MOST_HARMONICS, most_resolved), np.zeros(0))
    if smooth.harmonics.size < _MANY:
        return smooth
    kinked = _fitted(samples, min(MOST_HARMONICS, most_resolved), _corners_of(smooth))
    if kinked.corners.size and _information_criterion(kinked, x.size) < _information_criterion(
        smooth, x.size
    ):
        return kinked
    # Single harmonics may be below the noise and significant together. A motion that is the same
    # in both directions has odd harmonics only.
    is_odd = bool(np.all(smooth.harmonics % 2 == 1))
    most = min(MOST_OF_CORNERS if is_odd else MOST_HARMONICS, most_resolved)
    every_one = np.arange(1, most + 1, 1 + is_odd, dtype=np.int64)
    return _fitted(samples, most, np.zeros(0), np.union1d(every_one, smooth.harmonics))


def _information_criterion(motion: PeriodicMotion, count: int) -> float:
    return 2.0 * count * math.log(motion.noise) + motion.coefficients.size * math.log(count)


class _Samples:
    def __init__(self, phase: Floats, x: Floats) -> None:
        self.phase, self.x = phase, x
        self.column = np.empty(phase.size, dtype=np.int64)
        for piece in stretches(phase.size):
            bins = (phase[piece] * (_FINE / (2.0 * math.pi)) + 1e-9).astype(np.int64)
            self.column[piece] = np.minimum(bins, _FINE - 1)
        weight = np.bincount(self.column, minlength=_FINE).astype(float)
        self.full = weight > 0.0
        self.weight = weight[self.full]
        self.place, self.mean = self.sums(phase) / self.weight, self.sums(x) / self.weight

    def sums(self, values: Floats) -> Floats:
        sums = np.bincount(self.column, values, minlength=_FINE)[self.full]
        return np.asarray(sums, dtype=np.float64)

    def residual(
        self, coefficients: Floats, harmonics: NDArray[np.int64], corners: Floats
    ) -> Floats:
        end, smooth = 1 + 2 * harmonics.size, np.zeros(0)
        # Harmonics are linearised about the mean phase of each bin.
        value, slope, middle = np.zeros((3, _FINE))
        for row, order in ((value, 0), (slope, 1)):
            row[self.full] = basis(self.place, harmonics, smooth, order) @ coefficients[:end]
        middle[self.full] = self.place
        residual = self.x.copy()
        for piece in stretches(self.x.size):
            of, phase = self.column[piece], self.phase[piece]
            residual[piece] -= value[of] + slope[of] * (phase - middle[of])
            if corners.size:
                residual[piece] -= corner_terms(phase, corners) @ coefficients[end:]
        return residual


def _fitted(
    samples: _Samples, count: int, corners: Floats, given: NDArray[np.int64] | None = None
) -> PeriodicMotion:
    """Fit the mean, the significant harmonics up to order ``count``, and corners.

    ``corners`` are initial phases [rad]; ``given`` harmonics are fitted even if not significant.
    """
    x = samples.x
    all_of, smooth = np.arange(1, count + 1, dtype=np.int64), np.zeros(0)
    design = basis(samples.place, all_of, smooth)
    floor = QUIET * 0.5 * float(np.ptp(samples.mean))
    price = 2.0 * math.log(x.size) + 2.0 * math.log(count)
    harmonics = np.array([1]) if given is None else given
    for _ in range(_ROUNDS):
        columns = np.concatenate(([0], np.column_stack((2 * harmonics - 1, 2 * harmonics)).ravel()))
        part = design[:, columns]
        for _ in range(_MOVES if corners.size else 1):
            terms = np.hstack((part, corner_terms(samples.place, corners)))
            normal = terms.T @ (samples.weight[:, None] * terms)
            coefficients = np.linalg.solve(normal, terms.T @ (samples.weight * samples.mean))
            heights, shifts = coefficients[columns.size :: 2], coefficients[columns.size + 1 :: 2]
            moves = -shifts / heights
            if not np.abs(moves).max(initial=0.0) < 0.2:  # no corner there, and no fit
                return PeriodicMotion(harmonics, smooth, coefficients, normal, math.inf)
            if np.abs(moves).max(initial=0.0) < 1e-8:
                break
            corners = corners + moves
        residual = samples.residual(coefficients, harmonics, corners)
        # Harmonics are nearly orthogonal over whole cycles.
        amplitudes = design.T @ samples.sums(residual) * (2.0 / x.size)
        power = 0.5 * x.size * (amplitudes[1::2] ** 2 + amplitudes[2::2] ** 2)
        is_unused = np.ones(count, dtype=bool)
        is_unused[harmonics - 1] = False
        freedom = max(x.size - 2 * count - 1 - 2 * corners.size, 1)
        white = max(float(residual @ residual) - float(power[is_unused].sum()), 0.0) / freedom
        noise = max(math.sqrt(white), floor)
        # A harmonic has two degrees of freedom; it is added if the BIC falls. The largest come
        # first, since they leak into others if phases are uneven.
        lowest_power = max(price * noise**2, _LARGE * float(power[is_unused].max(initial=0.0)))
        new = all_of[is_unused & (power > lowest_power)]
        if new.size == 0:
            break
        harmonics = np.sort(np.concatenate((harmonics, new)))
    covariance = np.asarray(noise**2 * np.linalg.inv(normal), dtype=np.float64)
    return PeriodicMotion(harmonics, corners, coefficients, covariance, noise)


def _corners_of(motion: PeriodicMotion) -> Floats:
    """Return the phases [rad] of the largest curvatures of a motion; none if there are too many."""
    n = motion.harmonics.astype(float)
    taper = np.cos(0.5 * math.pi * n / (n[-1] + 1.0)) ** 2
    grid = np.linspace(0.0, 2.0 * math.pi, _FINE, endpoint=False)
    terms = basis(grid, motion.harmonics, np.zeros(0))
    bend = np.abs(terms[:, 1:] @ (np.repeat(taper * n**2, 2) * motion.coefficients[1:]))
    is_peak = (bend > np.roll(bend, 1)) & (bend >= np.roll(bend, -1))
    is_peak &= bend > _SHARP * bend.max()
    corners = grid[is_peak]
    return corners if corners.size <= _MOST_CORNERS else np.zeros(0)
