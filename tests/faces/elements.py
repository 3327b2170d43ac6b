"""A second boundary-element solver, which shares no code with microslip.

Heights and separations are in pixels, pressures in units of E*. The face continues as in a mirror
at its edges: the grid is doubled in both directions and repeats. At a separation of the mean planes
the pressures lie between zero and the hardness; clipped conjugate gradients with the release rule
of Polonsky and Keer (1999, DOI 10.1016/S0043-1648(99)00113-1), with a bound on the pressure after
Almqvist et al. (2007, DOI 10.1016/j.triboint.2006.09.001).
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
_DISTANCES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.05)
"""Separations of the unloading from the tightening, over p/k."""
_RESIDUAL = 3e-5
"""Largest residual of the gap over the rms height."""
_STEPS = 4000


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
        z = heights - heights.mean()
        self.shape = z.shape
        self.rms = float(z.std())
        self.z = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
        q = (
            2.0
            * np.pi
            * np.hypot(np.fft.fftfreq(self.z.shape[0])[:, None], np.fft.rfftfreq(self.z.shape[1]))
        )
        q[0, 0] = np.inf
        self.kernel = 2.0 / q
        self.pressure = np.zeros(self.z.shape)

    def displaced(self, pressure: Floats) -> Floats:
        waves = fft.rfft2(pressure)
        return np.asarray(fft.irfft2(self.kernel * waves, s=pressure.shape))

    def press(self, separation: float, hardness: float = math.inf) -> float:
        """Solve the pressures at a separation, from those of the last; return their mean."""
        p = np.clip(self.pressure, 0.0, hardness)
        p[(p == 0.0) & (self.z > separation)] = 1e-6
        least = _RESIDUAL * self.rms
        direction, old, restart = np.zeros(p.shape), 1.0, 0.0
        gap = self.displaced(p) - self.z + separation
        for _ in range(_STEPS):
            inside = (p > 0.0) & (p < hardness)
            square = float(np.sum(gap[inside] ** 2))
            direction = np.where(inside, gap + restart * square / old * direction, 0.0)
            old = max(square, 1e-300)
            if square > 0.0:
                moved = self.displaced(direction)
                step = float(np.sum(gap[inside] * direction[inside]))
                step /= float(np.sum(moved[inside] * direction[inside]))
                p = np.clip(p - step * direction, 0.0, hardness)
            else:
                step = 1.0
            released = ((p <= 0.0) & (gap < -least)) | ((p >= hardness) & (gap > least))
            restart = 0.0 if released.any() else 1.0
            p[released] -= step * gap[released]
            np.clip(p, 0.0, hardness, out=p)
            gap = self.displaced(p) - self.z + separation
            wrong = np.where(p <= 0.0, np.minimum(gap, 0.0), gap)
            wrong = np.where(p >= hardness, np.maximum(gap, 0.0), wrong)
            if np.abs(wrong).max() < least:
                self.pressure = p
                return float(p.mean())
        raise ArithmeticError(f"no pressures at the separation {separation}")

    def tighten(self, target: float, hardness: float) -> float:
        """Return the separation at a mean pressure within 1e-4, and leave the face yielded."""
        share = min(target / min(hardness, 0.1), 0.3)
        d = float(np.quantile(self.z, 1.0 - share))
        low, high = -math.inf, math.inf
        for _ in range(60):
            found = self.press(d, hardness)
            if abs(found / target - 1.0) < 1e-4:
                break
            low, high = (d, high) if found > target else (low, d)
            rate = max(self.stiffness(hardness) / max(found, 1e-9), 0.3 / self.rms)
            step = math.log(max(found, 1e-3 * target) / target) / rate
            new = d + min(max(step, -0.5 * self.rms), 0.5 * self.rms)
            d = new if low < new < high else 0.5 * (low + high)
        else:
            raise ArithmeticError(f"no separation for the pressure {target}")
        gap = self.displaced(self.pressure) - self.z + d
        self.z = self.z + np.where(self.pressure >= hardness, np.minimum(gap, 0.0), 0.0)
        return d

    def stiffness(self, hardness: float = math.inf) -> float:
        """Return -dp/dd while contacts and points at the hardness stay the same."""
        inside = (self.pressure > 0.0) & (self.pressure < hardness)
        if not inside.any():
            return 0.0
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


def solve(heights: Floats, pressure: float, hardness: float) -> Truth:
    """Tighten a face to a mean pressure, let it yield, and unload it elastically."""
    face = Face(heights)
    d = face.tighten(pressure, hardness)
    rows = [(0.0, face.press(d), face.stiffness())]
    contact = float(np.mean(face.pressure > 0.0))
    length = rows[0][1] / rows[0][2]
    for distance in _DISTANCES:
        p = face.press(d + distance * length)
        rows.append((distance, p, face.stiffness()))
    x, p, k = np.array(rows).T
    curve = CubicHermiteSpline(x, np.log(p), -k / p * length)
    found = []
    for a in AMPLITUDES:
        u = np.linspace(0.0, a, 801)
        lost = 1.0 - np.exp(curve(u) - curve(0.0))
        found.append(8.0 * float(np.trapezoid(lost, u) - 0.5 * a * lost[-1]) / a**2)
    return Truth(float(k[0]), tuple(found), contact)
