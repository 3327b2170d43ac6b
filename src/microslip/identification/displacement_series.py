"""The displacement of a record as a Fourier series, with the harmonics that stand out of noise."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.identification.mean_cycle import stretches

MOST_HARMONICS = 120
_FINE = 4096  # bins of the displacement: their width is nothing to a hundred harmonics
_ROUNDS, _LARGE = 100, 0.3
QUIET = 1e-9
"""Of the amplitude: below it noise is rounding."""


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
    harmonic_count = int(min(MOST_HARMONICS, max(1, math.floor(0.4 * places))))
    all_of = np.arange(1, harmonic_count + 1)
    angle = np.outer(place, all_of)
    design = np.hstack((np.ones((place.size, 1)), np.cos(angle), np.sin(angle)))
    floor = QUIET * 0.5 * float(np.ptp(mean))
    price = 2.0 * math.log(x.size) + 2.0 * math.log(harmonic_count)
    harmonics = np.array([1])
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
        if new.size == 0:
            break
        harmonics = np.sort(np.concatenate((harmonics, new)))
    return harmonics, coefficients, noise**2 * np.linalg.inv(normal), noise


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
