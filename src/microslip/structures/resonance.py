"""Response of one mode to a harmonic force in closed form, from its frequency and damping."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

_STEPS = 300
_BELOW = 1e-3  # of the smallest amplitude of a curve, below which the mode is linear


def sides(amplitude: Floats, omega: Floats, damping: Floats, push: Floats) -> tuple[Floats, Floats]:
    """Squares of the angular frequencies at which a mode answers with its amplitudes [1/s^2].

    Below and above the resonance, of (omega^2 - W^2)^2 + (2 zeta omega W)^2 = (push/a)^2; not a
    number at amplitudes beyond the peak (Szemplinska-Stupnicka 1979, DOI
    10.1016/S0022-460X(79)80003-1).
    """
    middle = omega**2 * (1.0 - 2.0 * damping**2)
    inside = (push / amplitude) ** 2 - 4.0 * damping**2 * omega**4 * (1.0 - damping**2)
    half = np.sqrt(np.where(inside >= 0.0, inside, np.nan))
    return middle - half, middle + half


class Resonant(NamedTuple):
    """Answers of several samples of a mode to one force."""

    peak: Floats
    """Amplitude and frequency [Hz] of each peak, (samples, 2); beyond a curve its end."""
    beyond: NDArray[np.bool_]
    """Peaks beyond the curves, where neither they nor the amplitudes are as large as stated."""
    amplitude: Floats
    """The largest lasting amplitude at each frequency, (samples, frequencies)."""


def refined(amplitude: Floats, logs: Floats) -> tuple[Floats, Floats]:
    """Many amplitudes and values there, of columns of logarithms (samples, columns, amplitudes).

    Monotone cubics of ln(amplitude); below its smallest amplitude a mode is linear.
    """
    from scipy.interpolate import PchipInterpolator

    place = np.log(amplitude)
    grid = np.linspace(place[0] + math.log(_BELOW), place[-1], _STEPS)
    values = PchipInterpolator(place, logs, axis=2)(np.maximum(grid, place[0]))
    return np.exp(grid), np.exp(values)


def resonant(
    amplitude: Floats, frequency: Floats, damping: Floats, push: Floats, at: Floats
) -> Resonant:
    """Answers of finely spaced curves (samples, amplitudes) to a push, at frequencies [Hz].

    Where a frequency has several motions, the largest.
    """
    peaks = np.empty((len(amplitude), 2))
    answers = np.empty((len(amplitude), at.size))
    ends_below = np.zeros(len(amplitude), dtype=bool)
    omegas = 2.0 * math.pi * at
    for row, (x, f, zeta, p) in enumerate(zip(amplitude, frequency, damping, push, strict=True)):
        grid, omega = np.log(x), 2.0 * math.pi * f
        # The peak: force over amplitude falls to what damping takes.
        excess = np.log(p / x) - np.log(2.0 * zeta * omega**2 * np.sqrt(1.0 - zeta**2))
        beyond = np.flatnonzero(excess < 0.0)
        ends_below[row] = not beyond.size
        if beyond.size and beyond[0] == 0:  # so small a force moves a linear mode
            o, z = omega[0], zeta[0]
            summit = o * math.sqrt(1.0 - 2.0 * z**2)
            peaks[row] = x[0] * math.exp(excess[0]), summit / (2.0 * math.pi)
            answers[row] = p[0] / np.hypot(o**2 - omegas**2, 2.0 * z * o * omegas)
            continue
        end = int(beyond[0]) if beyond.size else grid.size - 1
        share = excess[end - 1] / (excess[end - 1] - excess[end]) if beyond.size else 1.0
        top = grid[end - 1] + share * (grid[end] - grid[end - 1])
        at_top, ratio = (np.interp(top, grid, values) for values in (omega, zeta))
        summit = at_top * math.sqrt(max(1.0 - 2.0 * ratio**2, 0.0))
        below, above = sides(x[:end], omega[:end], zeta[:end], p[:end])
        # Down from the peak on both sides; a fold is stepped over where the motion jumps.
        left = np.minimum.accumulate(np.append(summit, np.sqrt(np.maximum(below[::-1], 0.0))))
        right = np.maximum.accumulate(np.append(summit, np.sqrt(above[::-1])))
        falling = np.append(top, grid[:end][::-1])
        path, heights = np.append(left[::-1], right), np.append(falling[::-1], falling)
        peaks[row] = math.exp(top), summit / (2.0 * math.pi)
        answers[row] = np.exp(np.interp(omegas, path, heights))
        far = (omegas < path[0]) | (omegas > path[-1])  # so little moves a linear mode
        o, z = omega[0], zeta[0]
        linear = p[0] / np.hypot(o**2 - omegas**2, 2.0 * z * o * omegas)
        answers[row, far] = linear[far]
    return Resonant(peaks, ends_below, answers)


def with_phase(
    amplitude: Floats, frequency: Floats, damping: Floats, push: Floats, at: Floats
) -> NDArray[np.complex128]:
    """Motions of one finely spaced curve with their phase to the push, at frequencies [Hz].

    Not a number where they lie beyond the curve.
    """
    found = resonant(amplitude[None], frequency[None], damping[None], push[None], at)
    size, place = found.amplitude[0], np.log(amplitude)
    natural, ratio = (np.interp(np.log(size), place, values) for values in (frequency, damping))
    phase = np.arctan2(2.0 * ratio * natural * at, natural**2 - at**2)
    size = np.where(found.beyond[0] & (size >= amplitude[-2]), np.nan, size)
    return np.asarray(size * np.exp(-1j * phase))
