"""The joints of a structure, seen by its solvers: relative motions in, forces and tangents out.

A group is a set of joints of one kind. Each joint of it moves in one or more coordinates: a law in
one, a node of a field in three (along its line, across, opening). Displacements are arrays
(joints, coordinates), Fourier coefficients (joints, coordinates, coefficients).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.friction import BackboneLaw
from microslip.structures.harmonic_basis import HarmonicBasis


class HarmonicForces(NamedTuple):
    """Fourier coefficients of forces and their derivatives by those of the displacements."""

    force: Floats
    """(joints, coordinates, size)."""
    jacobian: Floats
    """(joints, coordinates, size, coordinates, size)."""


class JointState(Protocol):
    """Joints in time: trials move nothing until they are committed."""

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Forces (joints, coordinates) and tangents (joints, coordinates, coordinates)."""

    def commit(self) -> None:
        """Make the last trial the state."""

    @property
    def lost(self) -> Floats:
        """Energies lost so far (joints,) [J], those of the way to the static state included."""


class JointGroup(Protocol):
    """Joints of one kind about a static state; displacements count from that state."""

    directions: Floats
    """(degrees of freedom, joints, coordinates)."""
    stuck: Floats
    """Stiffness at rest (joints, coordinates) [N/m]."""

    def forces(self, displacement: Floats) -> tuple[Floats, Floats]:
        """First loading along a straight path: forces and tangents (joints, c, c)."""

    def harmonic_forces(self, coefficients: Floats, basis: HarmonicBasis) -> HarmonicForces:
        """The settled cycle of a periodic motion."""

    def loop_energies(self, amplitudes: Floats) -> Floats:
        """Energies (cycles, joints) [J] of cycles of displacement amplitudes (cycles, joints, c).

        By the closed form.
        """

    def start(self) -> JointState:
        """A state at rest."""


class LawGroup:
    """One backbone law acting along several directions."""

    def __init__(self, law: BackboneLaw, directions: Floats, static: Floats) -> None:
        self.law = law
        self.directions = directions[:, :, None]
        self.static = static
        self._loaded = law.backbone(static)
        self.stuck = np.full((static.size, 1), law.tangential_stiffness)

    def forces(self, displacement: Floats) -> tuple[Floats, Floats]:
        """See :class:`JointGroup`."""
        u = displacement[:, 0]
        if not self.static.any():
            force, slope = self.law.backbone(u), self.law.backbone_stiffness(u)
        else:
            trials = [
                state.try_(x) for state, x in zip(self._states(), self.static + u, strict=True)
            ]
            force, slope = np.array(trials).T
        return (force - self._loaded)[:, None], slope[:, None, None]

    def harmonic_forces(self, coefficients: Floats, basis: HarmonicBasis) -> HarmonicForces:
        """See :class:`JointGroup`."""
        count = self.static.size
        force = np.empty((count, 1, basis.size))
        jacobian = np.empty((count, 1, basis.size, 1, basis.size))
        for joint in range(count):
            motion = coefficients[joint, 0].copy()
            motion[0] += self.static[joint]
            # Without samples: those would miss the turning points, by 1.5 % of the loss at slip.
            cycle = self.law.harmonics(motion, basis.harmonics)
            force[joint, 0], jacobian[joint, 0, :, 0] = cycle
        force[:, 0, 0] -= self._loaded
        return HarmonicForces(force, jacobian)

    def loop_energies(self, amplitudes: Floats) -> Floats:
        """See :class:`JointGroup`."""
        return np.asarray(self.law.dissipated_energy(np.abs(amplitudes[..., 0])))

    def _states(self) -> list[Any]:
        states = [self.law.start() for _ in self.static]
        for state, x in zip(states, self.static, strict=True):
            state.advance(x)
        return states

    def start(self) -> JointState:
        """See :class:`JointGroup`."""
        return _LawStates(self._states(), self.static, self._loaded)


class _LawStates:
    """States of laws, displacements counted from the static ones."""

    def __init__(self, states: list[Any], static: Floats, loaded: Floats) -> None:
        self._states, self._static, self._loaded = states, static, loaded

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        trials = np.array(
            [
                state.try_(x)
                for state, x in zip(self._states, self._static + displacement[:, 0], strict=True)
            ]
        )
        return (trials[:, 0] - self._loaded)[:, None], trials[:, 1, None, None]

    def commit(self) -> None:
        for state in self._states:
            state.commit()

    @property
    def lost(self) -> Floats:
        return np.array([state.dissipated_energy for state in self._states])


def checked_law(law: BackboneLaw) -> BackboneLaw:
    """A law that is not rigid at rest.

    Raises
    ------
    InputError
        An infinite stiffness at rest.
    """
    if not math.isfinite(law.tangential_stiffness):
        raise InputError(
            f"law must have a finite stiffness at rest, {type(law).__name__} friction is rigid "
            "there; write ms.Jenkins(stiffness, force_limit)"
        )
    return law
