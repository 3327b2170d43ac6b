"""A second boundary-element solver, which shares no code and no method with microslip.

Heights and separations are in pixels, pressures in units of E*. The face continues as in a mirror
at its edges, so that displacements follow from cosine transforms. The mean pressure is given, and
the pressures lie between zero and the hardness. They minimise a convex energy, which is found by
accelerated projected gradients (Nesterov 1983) with restarts (O'Donoghue and Candes 2015, DOI
10.1007/s10208-013-9150-3). These converge for any set of contacts, up to full contact, where the
mean pressure is not determined by the separation.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.interpolate import CubicHermiteSpline

Floats = NDArray[np.float64]

AMPLITUDES = (0.1, 0.3, 1.0)
"""Amplitudes of the cycles over mu N/k_t."""
_DISTANCES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.05, 1.3)
"""Separations of the unloading from the tightening, over p/k, that the loads aim at."""
_RESIDUAL = 3e-5
"""Largest residual of the gap over the rms height."""
_STEPS = 20000
_EVERY = 5
"""Steps between checks of the residual."""


class Truth(NamedTuple):
    """Unloading of a tightened face."""

    stiffness: float
    """-dp/dd at the tightening pressure [E* a pixel]."""
    energies: tuple[float, ...]
    """Energies of cycles over k_t a^2 at the amplitudes."""
    contact: float
    """Share of the area in contact."""


class Face:
    """A face of these heights [pixels], pressed against a rigid plane."""

    def __init__(self, heights: Floats) -> None:
        self.z = heights - heights.mean()
        self.rms = float(self.z.std())
        rows, columns = (np.pi * np.arange(n) / n for n in self.z.shape)
        q = np.hypot(rows[:, None], columns)
        q[0, 0] = np.inf
        self.kernel = 2.0 / q
        self.pressure = np.zeros(self.z.shape)

    def displaced(self, pressure: Floats) -> Floats:
        return np.asarray(fft.idctn(self.kernel * fft.dctn(pressure)))

    def press(self, mean: float, hardness: float = math.inf) -> float:
        """Solve the pressures of this mean, from those of the last; return the separation."""
        step = 1.0 / float(self.kernel.max())
        p = projected(self.pressure, mean, hardness)
        ahead, momentum = p, 1.0
        for count in range(_STEPS):
            new = projected(ahead - step * (self.displaced(ahead) - self.z), mean, hardness)
            if count % _EVERY == 0:
                separation, wrong = self.residual(new, hardness)
                if wrong < _RESIDUAL * self.rms:
                    self.pressure = new
                    return separation
            if float(np.sum((ahead - new) * (new - p))) > 0.0:
                momentum = 1.0  # the last step went uphill
            grown = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum**2))
            ahead = new + (momentum - 1.0) / grown * (new - p)
            p, momentum = new, grown
        raise ArithmeticError(f"no pressures of the mean {mean}")

    def residual(self, pressure: Floats, hardness: float) -> tuple[float, float]:
        """Return the separation of these pressures, and the largest error of the gap."""
        gap = self.displaced(pressure) - self.z
        free = (pressure > 0.0) & (pressure < hardness)
        separation = -float(gap[free if free.any() else pressure > 0.0].mean())
        gap += separation
        wrong = np.where(pressure <= 0.0, np.minimum(gap, 0.0), gap)
        wrong = np.where(pressure >= hardness, np.maximum(gap, 0.0), wrong)
        return separation, float(np.abs(wrong).max())

    def tighten(self, mean: float, hardness: float) -> None:
        """Press the face to a mean pressure, and give it the shape to which it yields."""
        gap = self.press(mean, hardness) + self.displaced(self.pressure) - self.z
        self.z = self.z + np.where(self.pressure >= hardness, np.minimum(gap, 0.0), 0.0)

    def stiffness(self) -> float:
        """Return -dp/dd while contacts stay the same."""
        inside = self.pressure > 0.0
        growth = np.zeros(inside.shape)
        here = inside.astype(float)
        direction, square = here, float(np.sum(here * here))
        least = 1e-8 * square
        while square > least:
            moved = np.where(inside, self.displaced(direction), 0.0)
            step = square / float(np.sum(direction * moved))
            growth += step * direction
            here = here - step * moved
            new = float(np.sum(here * here))
            direction, square = here + new / square * direction, new
        return float(growth.mean())


def projected(pressure: Floats, mean: float, hardness: float) -> Floats:
    """Return the nearest pressures of this mean from zero to the hardness: shifted and clipped."""
    low, high = mean - float(pressure.max()), mean - float(pressure.min())
    shift = min(max(0.0, low), high)
    for _ in range(100):
        found = np.clip(pressure + shift, 0.0, hardness)
        miss = mean - float(found.mean())
        if abs(miss) <= 1e-13 * mean:
            break
        low, high = (shift, high) if miss > 0.0 else (low, shift)
        free = np.count_nonzero((found > 0.0) & (found < hardness))
        new = shift + miss * found.size / free if free else math.inf
        shift = new if low < new < high else 0.5 * (low + high)
    return found


def solve(heights: Floats, pressure: float, hardness: float) -> Truth:
    """Tighten a face to a mean pressure, let it yield, and unload it elastically."""
    face = Face(heights)
    face.tighten(pressure, hardness)
    rows = [(face.press(pressure), pressure, face.stiffness())]
    contact = float(np.mean(face.pressure > 0.0))
    length = pressure / rows[0][2]
    for distance in _DISTANCES:
        d, p, k = rows[-1]
        p *= math.exp(-k / p * (rows[0][0] + distance * length - d))
        rows.append((face.press(p), p, face.stiffness()))
        if rows[-1][0] - rows[0][0] > AMPLITUDES[-1] * length:
            break
    x, p, k = np.array(rows).T
    curve = CubicHermiteSpline((x - x[0]) / length, np.log(p), -k / p * length)
    found = []
    for a in AMPLITUDES:
        u = np.linspace(0.0, a, 801)
        lost = 1.0 - np.exp(curve(u) - curve(0.0))
        found.append(8.0 * float(np.trapezoid(lost, u) - 0.5 * a * lost[-1]) / a**2)
    return Truth(float(rows[0][2]), tuple(found), contact)
