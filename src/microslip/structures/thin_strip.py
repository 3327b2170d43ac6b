"""A thin, curved strip between two clamps: its forces in bending and stretching."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.materials import Material

_MIDDLE = 15.0 / 8.0  # of the mean deflection under an even load: that of the middle
_STEPS = (-1.0, -2.0 / 3.0, -1.0 / 3.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0)
_ROUNDS = 40
_BENDING = np.array([[12.0, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
_SLOPES = np.array([[36.0, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]])
_POINTS = 5  # along, by Gauss: exact for the polynomials that strips bend in
Sensors = dict[str, tuple[tuple[float, float, float], str]]


class Sizes(NamedTuple):
    """Dimensions of a strip between two clamps [m]."""

    length: float
    width: float
    thickness: float
    rise: float


class Bending(NamedTuple):
    """Bending of a drawn, thin part, as :meth:`ReducedJoint.with_geometry` takes it."""

    sensors: Sensors
    """Places [m] and directions by name, for ``sensors=`` of :meth:`BoltedBeam.reduce`."""
    cases: tuple[Floats, Floats]
    """Mean deflections and elongations [m], and the forces that hold them [N]."""
    weights: Floats
    """Weights of each sensor in the two coordinates, (sensors, 2)."""


def strip_sensors(sizes: Sizes, start: float, height: float) -> tuple[Sensors, Floats]:
    """Sensors of a strip that begins at x and whose ends' middle lies at z [m], and weights."""
    sensors: Sensors = {}
    weights = []
    along, shares = np.polynomial.legendre.leggauss(_POINTS)
    places, parts = np.polynomial.legendre.leggauss(3)
    for y, part in zip(0.5 * sizes.width * places, 0.5 * parts, strict=True):
        for t, share in zip(0.5 + 0.5 * along, 0.5 * shares, strict=True):
            z = height + 0.5 * sizes.rise * (1.0 - math.cos(2.0 * math.pi * t))
            sensors[f"bend {len(sensors) + 1}"] = (start + t * sizes.length, float(y), z), "z"
            weights.append((part * share, 0.0))
        for end, sign in ((0.0, -1.0), (1.0, 1.0)):
            place = (start + end * sizes.length, float(y), height)
            sensors[f"bend {len(sensors) + 1}"] = place, "x"
            weights.append((0.0, sign * part))
    return sensors, np.array(weights)


@lru_cache(maxsize=8)
def strip_cases(sizes: Sizes, material: Material, reach: float) -> tuple[Floats, Floats]:
    """Cases of a strip up to a reach of its middle [m]."""
    return Strip(sizes, material).cases(reach)


class Strip:
    """Von Karman elements of a shallow strip, both ends clamped, the right one free to move along.

    Its shape is a raised cosine; it bends as a cylinder, with the modulus E/(1 - nu^2) of wide
    plates. Degrees of freedom: u, w and the slope w' of each node, without those that are held.
    """

    def __init__(self, sizes: Sizes, material: Material, count: int = 32) -> None:
        length, width, thickness, rise = sizes
        self._sizes, self._step = sizes, length / count
        h, size = self._step, 3 * (count + 1)
        modulus = material.young_modulus / (1.0 - material.poisson_ratio**2)
        self._tension = modulus * width * thickness
        bent = modulus * width * thickness**3 / 12.0 / h**3
        scale = np.array([1.0, h, 1.0, h])
        scale = scale[:, None] * scale
        block = bent * scale * _BENDING
        self._slope = scale * _SLOPES / (30.0 * h * h)
        first = 3 * np.arange(count)[:, None]
        self._along, self._across = first + np.array([0, 3]), first + np.array([1, 2, 4, 5])
        self.bending = np.zeros((size, size))
        even: Floats = np.zeros(size)
        for cells in self._across:
            self.bending[np.ix_(cells, cells)] += block
            even[cells] += np.array([0.5, h / 12.0, 0.5, -h / 12.0]) / count
        self.free = np.setdiff1d(np.arange(size), [0, 1, 2, size - 2, size - 1])
        phase = 2.0 * math.pi * np.arange(count + 1) / count
        self._shape: Floats = np.zeros(size)
        self._shape[1::3] = 0.5 * rise * (1.0 - np.cos(phase))
        self._shape[2::3] = math.pi * rise / length * np.sin(phase)
        stretch: Floats = np.zeros(size)
        stretch[size - 3] = 1.0
        self.coordinates = np.stack([even, stretch], axis=1)[self.free]
        """Mean deflection and elongation, (degrees of freedom, 2)."""

    def forces(self, x: Floats) -> tuple[Floats, Floats]:
        """Forces [N, N m] that hold a motion, and their tangent."""
        d: Floats = np.zeros(self._shape.size)
        d[self.free] = x
        moved, shape = d[self._across], self._shape[self._across]
        turned = (shape + moved) @ self._slope
        strain = (d[self._along[:, 1]] - d[self._along[:, 0]]) / self._step
        strain += np.einsum("ei,ei->e", (shape + 0.5 * moved) @ self._slope, moved)
        pull = self._tension * self._step * strain
        force, tangent = self.bending @ d, self.bending.copy()
        ends = np.broadcast_to(np.array([-1.0, 1.0]) / self._step, (len(pull), 2))
        index = np.concatenate([self._along, self._across], axis=1)
        gradient = np.concatenate([ends, turned], axis=1)
        np.add.at(force, index, pull[:, None] * gradient)
        blocks = self._tension * self._step * gradient[:, :, None] * gradient[:, None, :]
        blocks[:, 2:, 2:] += pull[:, None, None] * self._slope
        np.add.at(tangent, (index[:, :, None], index[:, None, :]), blocks)
        return force[self.free], tangent[np.ix_(self.free, self.free)]

    def forces_at(self, places: Floats) -> Floats:
        """Forces [N] at which the coordinates are at some places, all else in balance."""
        size, p = self.coordinates.shape
        x, force = np.zeros(size), np.zeros(p)
        for share in (0.25, 0.5, 0.75, 1.0):
            for _ in range(_ROUNDS):
                bearing, tangent = self.forces(x)
                gap = np.concatenate(
                    [bearing - self.coordinates @ force, self.coordinates.T @ x - share * places]
                )
                sides = self.coordinates
                matrix = np.block([[tangent, -sides], [sides.T, np.zeros((p, p))]])
                scale = 1.0 / np.sqrt(np.abs(np.diag(tangent)))
                scale = np.append(scale, 1.0 / np.abs(sides * scale[:, None]).max(axis=0))
                step = scale * np.linalg.solve(scale[:, None] * matrix * scale, -scale * gap)
                x, force = x + step[:size], force + step[size:]
                if np.abs(step[:size]).max() <= 1e-10 * np.abs(x).max():
                    break
            else:
                raise InputError("the strip was not found in balance; ask for a smaller reach")
        return force

    def cases(self, reach: float) -> tuple[Floats, Floats]:
        """Deflections up to a reach of the middle [m] with elongations, and their forces [N]."""
        # Half of what the ends would come closer if nothing held them.
        shortening = 4.9 / self._sizes.length * reach * (self._sizes.rise + 0.5 * reach)
        places = np.array([z for z in product(_STEPS, _STEPS) if any(z)])
        places = places * [reach / _MIDDLE, 0.5 * shortening]
        return places, np.array([self.forces_at(row) for row in places])
