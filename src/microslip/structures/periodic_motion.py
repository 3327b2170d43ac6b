"""Periodic motions by their Fourier coefficients, and definitions of their amplitude.

Coefficients are in the order mean, cos 1, sin 1, cos 2, sin 2 and so on. Amplitudes are those of
the fundamental harmonic: modal, or at a sensor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import (
    SMALLEST,
    Floats,
    record,
    rising_orders,
    show,
    sized,
    whole_number,
)
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.inversion import adaptive
from microslip._core.kernels import Integers
from microslip.friction import BackboneLaw
from microslip.structures.matrices import direction_matrix

HARMONICS = (0, 1, 2, 3)
"""Default harmonics of a motion; opening contacts excite the second."""
ModeMethod = Literal["harmonic-balance", "quasi-static"]
MOST_SAMPLES = 1 << 16
_MOST_ORDER = 1000


@dataclass(frozen=True)
class HarmonicBasis:
    """Basis of periodic motions: the orders of their harmonics, and the samples per period."""

    harmonics: tuple[int, ...]
    """Orders of the harmonics, increasing; always includes 0, the mean."""
    samples: int

    @property
    def size(self) -> int:
        """Number of coefficients of a motion."""
        return 2 * len(self.harmonics) - 1

    @cached_property
    def orders(self) -> Floats:
        """Order of the harmonic of each coefficient, shape (size,)."""
        return lock(np.repeat(np.array(self.harmonics, dtype=float), 2)[1:])

    def with_more_harmonics(self) -> HarmonicBasis:
        """Return a basis with up to six more harmonics, none above the highest order plus two."""
        highest = self.harmonics[-1] + 2
        left_out = [order for order in range(highest + 1) if order not in self.harmonics]
        harmonics = (*self.harmonics, *left_out[:4], *left_out[4:][-2:])
        return HarmonicBasis(tuple(sorted(harmonics)), max(self.samples, 4 * highest))

    def work(self, force: Floats, displacement: Floats) -> Floats:
        """Return the work of a force over a period [J], from coefficients in the last axis."""
        cosines, sines = slice(1, None, 2), slice(2, None, 2)
        crossed = (
            force[..., cosines] * displacement[..., sines]
            - force[..., sines] * displacement[..., cosines]
        )
        return math.pi * np.asarray(crossed @ self.orders[cosines])


def harmonic_basis(harmonics: Sequence[int], samples: Any) -> HarmonicBasis:
    """Validate harmonics and number of samples; return the basis with the mean added."""
    orders = rising_orders("harmonics", harmonics)
    if 1 not in orders:
        raise InputError(f"harmonics must include 1, got {show(harmonics)}; write harmonics=[1, 3]")
    if orders[-1] > _MOST_ORDER:
        raise InputError(f"harmonics must be at most {_MOST_ORDER}, got {orders[-1]}")
    samples = whole_number("samples", samples, 1, MOST_SAMPLES)
    if samples < 4 * orders[-1]:
        raise InputError(
            f"samples must be at least {4 * orders[-1]}, four per period of the highest harmonic, "
            f"got {samples}"
        )
    return HarmonicBasis(tuple(sorted({0, *orders})), samples)


class HarmonicForces(NamedTuple):
    """Fourier coefficients of joint forces, and their derivatives by those of displacements."""

    force: Floats
    """Fourier coefficients of the forces, (joints, coordinates, size)."""
    jacobian: Floats
    """Derivatives of the forces, (joints, coordinates, size, coordinates, size)."""

    def beyond(self, stuck: Floats) -> Floats:
        """Return the Jacobian minus that of joints of constant stiffness ``stuck`` [N/m]."""
        blocks = self.jacobian.copy()
        coordinate, k = np.ogrid[: stuck.shape[1], : blocks.shape[2]]
        blocks[:, coordinate, k, coordinate, k] -= stuck[:, :, None]
        return blocks


MotionQuantity = Literal["displacement", "velocity", "acceleration"]
_NODE = 1e-9  # of the largest motion of a mode there
POWERS = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""Order of the time derivative of the displacement, by quantity."""


@dataclass(frozen=True, eq=False)
class AmplitudeMeasure:
    """Amplitude of the fundamental harmonic: modal, sqrt(x1^H M x1), or at a sensor."""

    sensor: Floats | None
    """Sensor direction in modal coordinates (modes,); None for the modal amplitude."""
    power: int = 0
    """0, 1 or 2: displacement, velocity, acceleration."""

    def square(self, q: Floats, omega: float) -> tuple[float, Floats, float]:
        """Return the squared amplitude and its derivatives with respect to q and omega [rad/s].

        The Fourier coefficients q of the modal coordinates have the shape (modes, size).
        """
        by_q = np.zeros_like(q)
        if self.sensor is None:
            by_q[:, 1:3] = 2.0 * q[:, 1:3]
            return float(np.sum(q[:, 1:3] ** 2)), by_q, 0.0
        signal = self.sensor @ q[:, 1:3]
        factor = omega ** (2 * self.power)
        value = factor * float(signal @ signal)
        by_q[:, 1:3] = 2.0 * factor * self.sensor[:, None] * signal
        return value, by_q, 2.0 * self.power * value / omega

    def factor(self, shape: Floats, omega: float) -> float:
        """Return the measured amplitude per unit modal amplitude of a motion along a mode shape."""
        if self.sensor is None:
            return 1.0
        return abs(float(self.sensor @ shape)) * omega**self.power


def power_of(quantity: Any) -> int:
    """Return the order (0, 1 or 2) of a quantity as a time derivative of displacement."""
    if not isinstance(quantity, str) or quantity not in POWERS:
        words = ", ".join(f'"{name}"' for name in POWERS)
        raise InputError(f"`quantity` must be one of {words}, got {show(quantity)}")
    return POWERS[quantity]


def amplitude_measure(at: Any, quantity: Any, shapes: Floats, index: int) -> AmplitudeMeasure:
    """Return the amplitude measure of the sensor ``at``, or the modal one if ``at`` is None.

    Raise an InputError if mode ``index`` of the mode shapes does not move the sensor.
    """
    power = power_of(quantity)
    if at is None:
        if quantity != "displacement":
            raise InputError(
                f'quantity="{quantity}" needs a sensor: write at=direction, a vector that is 1 at '
                "the degree of freedom it measures"
            )
        return AmplitudeMeasure(None)
    sensor = direction_matrix("at", at, shapes.shape[0])
    if sensor.shape[1] != 1:
        raise InputError(f"at must be one direction, got {sensor.shape[1]}")
    readings = shapes.T @ sensor[:, 0]
    if index not in moving_modes(sensor[:, 0], shapes):
        raise InputError(f"at must be where mode {index} moves; it has a node there")
    return AmplitudeMeasure(readings, power)


def moving_modes(sensor: Floats, shapes: Floats) -> list[int]:
    """Return the indices of modes whose shapes are not zero at a sensor."""
    readings = np.abs(shapes.T @ sensor)
    return [int(i) for i in np.flatnonzero(readings >= _NODE * readings.max())]


def checked_amplitudes(value: ArrayLike) -> Floats:
    """Validate that amplitudes are above zero, and return them as a one-dimensional array."""
    a = record("amplitudes", sized("amplitudes", value))
    if a.min() < SMALLEST:
        bound = "above zero" if a.min() <= 0.0 else f"at least {SMALLEST:g}"
        raise InputError(f"amplitudes must be {bound}, got {a.min():g}")
    return a.reshape(-1)


def averaged_stiffness(joint: BackboneLaw, a: Floats) -> Floats:
    """Return the in-phase first harmonic of the force over the displacement amplitude a [N/m].

    At the displacement a cos(phi) the unloading branch has, by Masing's rule, the force
    T0(a) - 2 T0(a sin^2(phi/2)), with the backbone T0. The result is 4/(pi a) times the integral of
    [T0(a) - T0(a sin^2(phi/2))] cos(phi) over 0 <= phi <= pi: a constant added to the force does
    not contribute. The quadrature is adaptive, since a backbone may have kinks.
    """
    result = np.full_like(a, joint.tangential_stiffness)
    moved = np.flatnonzero(a > 0.0)
    if moved.size == 0:
        return result
    amplitude = a[moved]
    peak = joint._backbone(amplitude)

    # In gross slip all happens soon after the turning point.
    def integrand(phi: Floats, index: Integers) -> Floats:
        below = peak[index] - joint._backbone(amplitude[index] * np.sin(0.5 * phi) ** 2)
        return np.asarray(below * np.cos(phi))

    total = adaptive(integrand, np.full(moved.size, math.pi), 1e-13, 50)
    result[moved] = 4.0 / math.pi * total / amplitude
    return result
