"""Variances of the motions of a linear structure, from the spectrum of its base acceleration.

Modes far above the band respond statically; joints are springs with dashpots. The frequency grid is
refined about each pole, so that the trapezoidal rule resolves the sharpest resonance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, floats
from microslip._core.errors import InputError
from microslip.structures.base_motion import BaseMotion

_BEYOND = 4.0  # times the highest frequency of the spectrum: modes above answer statically
_ABOUT = 121  # frequencies about a pole
_EVEN = 400  # frequencies in between
_BLOCK = 200


@dataclass(frozen=True, eq=False)
class BaseSpectrum:
    """One-sided power spectral density of an acceleration, linear between its points."""

    frequency: Floats
    """Frequencies [Hz]."""
    density: Floats
    """One-sided spectral densities [(m/s^2)^2/Hz]."""

    @classmethod
    def of(cls, psd: Any) -> BaseSpectrum:
        """Validate frequencies and densities, and return the spectrum."""
        example = "psd=([20.0, 2000.0], [1.0, 1.0]), in Hz and (m/s^2)^2/Hz"
        try:
            array = floats("psd", psd)
        except InputError as error:
            raise InputError(f"psd must be frequencies and levels, such as {example}") from error
        if array.ndim == 2 and array.shape[1] == 2 and array.shape[0] > 2:
            array = array.T
        if array.ndim != 2 or array.shape[0] != 2 or array.shape[1] < 2:
            raise InputError(
                f"psd must be frequencies and levels of at least two points, such as {example}, "
                f"got shape {array.shape}"
            )
        frequency, density = array
        if frequency[0] < 0.0 or np.diff(frequency).min() <= 0.0:
            raise InputError("psd must have increasing frequencies of at least 0 Hz")
        if density.min() < 0.0 or not density.any():
            raise InputError("psd must have levels that are not below zero, and not all zero")
        return cls(frequency.copy(), density.copy())

    def at(self, frequency: Floats) -> Floats:
        """Return the density at frequencies, zero outside the points."""
        return np.asarray(np.interp(frequency, self.frequency, self.density, left=0.0, right=0.0))


class Variances(NamedTuple):
    """Variances of the motions of a linear structure in noise."""

    displacement: Floats
    """Covariance of the modal coordinates (modes, modes)."""
    velocity: Floats
    acceleration: Floats
    """Covariance of the modal accelerations and, last, the base's own (modes + 1, modes + 1)."""
    jerk: Floats
    joints: Floats
    """Variances of the joints' motions (coordinates,) [m^2]."""
    joint_rates: Floats
    """Variances of the joint velocities [m^2/s^2]."""
    outside: Floats
    """Fraction of each joint's velocity variance outside the band of its largest mode [-]."""


@dataclass(frozen=True, eq=False)
class LinearStructure:
    """Modal equations of a structure on a moving base, with springs and dashpots for joints."""

    squares: Floats
    damping: Floats
    """Modal damping matrix (modes, modes) [1/s]."""
    directions: Floats
    """Directions of the joints (modes, coordinates)."""
    push: Floats
    """Modal forces per unit acceleration (modes,)."""
    viscous_push: Floats
    """Modal forces per unit velocity (modes,)."""
    carried: Floats
    """Motions of the joints for a unit of displacement of the base (coordinates,)."""
    spectrum: BaseSpectrum

    @cached_property
    def _slow(self) -> int:
        highest = 2.0 * math.pi * _BEYOND * float(self.spectrum.frequency[-1])
        return max(1, int(np.count_nonzero(self.squares < highest**2)))

    @cached_property
    def _static(self) -> Floats:
        b = self.directions[self._slow :]
        return np.asarray(b.T @ (b / self.squares[self._slow :, None]))

    def poles(self, softer: Floats, dashpots: Floats) -> NDArray[np.complex128]:
        """Return poles of the modes that respond dynamically [rad/s], by increasing frequency.

        ``softer`` [N/m], below zero, and ``dashpots`` [N s/m] are changes from sticking joints.
        """
        n, b = self._slow, self.directions[: self._slow]
        through = np.linalg.inv(np.eye(softer.size) + self._static * softer)
        stiffness = np.diag(self.squares[:n]) + b @ (softer[:, None] * through) @ b.T
        drag = self.damping[:n, :n] + b @ (through.T * dashpots) @ through @ b.T
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -drag]])
        values = np.linalg.eigvals(state)
        values = values[values.imag > 0.0]
        return np.asarray(values[np.argsort(values.imag)])

    def _frequencies(self, poles: NDArray[np.complex128]) -> Floats:
        low, high = self.spectrum.frequency[[0, -1]]
        parts = [self.spectrum.frequency, np.linspace(low, high, _EVEN)]
        for pole in poles:
            middle, width = pole.imag, max(-pole.real, 1e-9 * pole.imag)
            if not 0.5 * low <= middle / (2.0 * math.pi) <= 2.0 * high:
                continue
            reach = math.asinh(middle / width)
            about = middle + width * np.sinh(np.linspace(-reach, reach, _ABOUT))
            parts.append(about / (2.0 * math.pi))
        f = np.unique(np.concatenate(parts))
        return np.asarray(f[(f >= low) & (f <= high) & (f > 0.0)])

    def variances(self, softer: Floats, dashpots: Floats) -> Variances:
        """Return variances of modal coordinates and joint motions; arguments as :meth:`poles`."""
        poles = self.poles(softer, dashpots)
        frequencies = self._frequencies(poles)
        weights = np.gradient(frequencies)
        weights[[0, -1]] = (
            0.5 * (frequencies[1] - frequencies[0]),
            0.5 * (frequencies[-1] - frequencies[-2]),
        )
        weights = weights * self.spectrum.at(frequencies)
        modes, coordinates = self.squares.size, softer.size
        covariances = [np.zeros((modes, modes)) for _ in range(2)]
        covariances += [np.zeros((modes + 1, modes + 1)) for _ in range(2)]
        joints = np.zeros((frequencies.size, coordinates))
        for first in range(0, frequencies.size, _BLOCK):
            part = slice(first, first + _BLOCK)
            omega = 2.0 * math.pi * frequencies[part]
            q, u = self.answer(omega, softer, dashpots)
            joints[part] = np.abs(u) ** 2
            absolute = np.concatenate(
                [-(omega[:, None] ** 2) * q, np.ones((omega.size, 1))], axis=1
            )
            for total, motion, power in zip(
                covariances, (q, q, absolute, absolute), (0, 2, 0, 2), strict=True
            ):
                weighted = (weights[part] * omega**power)[:, None] * motion
                total += (weighted.T @ motion.conj()).real
        rates = joints * (weights * (2.0 * math.pi * frequencies) ** 2)[:, None]
        return Variances(
            covariances[0], covariances[1], covariances[2], covariances[3],
            joints.T @ weights, rates.sum(axis=0), _outside(frequencies, rates, poles),
        )  # fmt: skip

    def answer(
        self, omega: Floats, softer: Floats, dashpots: Floats
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return modal coordinates (frequencies, modes) and joint motions per unit acceleration."""
        n, b = self._slow, self.directions[: self._slow]
        fast = self.directions[n:]
        push = self.push - 1j * self.viscous_push / omega[:, None]
        impedance = softer + 1j * omega[:, None] * dashpots
        carried = -self.carried / omega[:, None] ** 2
        # Motions of the joints that the slow modes do not make.
        beside = carried + (push[:, n:] / self.squares[n:]) @ fast
        identity = np.eye(softer.size)
        through = np.linalg.inv(identity + self._static * impedance[:, None, :])
        pull = impedance[:, :, None] * through  # force for the motion of slow modes
        dynamic = b @ pull @ b.T + 1j * omega[:, None, None] * self.damping[:n, :n]
        index = np.arange(n)
        dynamic[:, index, index] += self.squares[:n] - omega[:, None] ** 2
        right = push[:, :n] - (pull @ beside[:, :, None])[..., 0] @ b.T
        try:
            slow = np.linalg.solve(dynamic, right[..., None])[..., 0]
        except np.linalg.LinAlgError:
            raise InputError(
                "a mode within the frequencies of `psd` has no damping: give the structure a "
                "damping matrix, or leave that frequency out"
            ) from None
        joints = (through @ (slow @ b + beside)[..., None])[..., 0]
        rest = (push[:, n:] - (impedance * joints) @ fast.T) / self.squares[n:]
        return np.concatenate([slow, rest], axis=1), np.asarray(joints)


def linear_structure(
    base: BaseMotion, spectrum: BaseSpectrum, directions: Floats, carried: Floats
) -> LinearStructure:
    """Return the modal equations of the structure on a moving base, with sticking joints.

    ``directions`` (modes, coordinates) are the joint motions of each mode, and ``carried``
    (coordinates,) those for a unit displacement of the base. InputError is raised if the base has
    several inputs or if there is no stationary response.
    """
    if base.carried.shape[1] != 1:
        raise InputError(
            f"directions must be one motion of the base, got {base.carried.shape[1]} inputs"
        )
    if base.strains and spectrum.frequency[0] == 0.0:
        raise InputError(
            "psd must begin above 0 Hz where supports move against another: their displacement is "
            "that of the acceleration over omega^4"
        )
    if base.model.free.shape[1] and np.any(base.model.free.T @ base.inertia):
        raise InputError("directions must not move parts that are free of the base")
    if not base.push.any() and not base.strains:
        raise InputError(
            "directions must be a motion that strains the structure: no mode is excited"
        )
    model, viscous = base.model, base.viscous_push
    damping = np.zeros((model.size, model.size)) if model.damping is None else model.damping
    return LinearStructure(
        model.squares, damping, directions, base.push[:, 0],
        np.zeros(model.size) if viscous is None else viscous[:, 0], carried, spectrum,
    )  # fmt: skip


def _outside(frequencies: Floats, rates: Floats, poles: NDArray[np.complex128]) -> Floats:
    """Return the fraction of each joint's velocity variance [-] that its main mode leaves out.

    The variance is the sum of ``rates`` (frequencies, joints). It is divided into one band for each
    mode, from one geometric mean of neighbouring pole frequencies to the next; the main mode of a
    joint is that of the largest band.
    """
    total = rates.sum(axis=0)
    if poles.size < 2:
        return np.zeros(total.size)
    middle = np.sort(poles.imag) / (2.0 * math.pi)
    edges = np.sqrt(middle[1:] * middle[:-1])
    band = np.searchsorted(edges, frequencies)
    sums = np.stack([rates[band == i].sum(axis=0) for i in range(middle.size)])
    return np.asarray(1.0 - sums.max(axis=0) / np.where(total > 0.0, total, 1.0))
