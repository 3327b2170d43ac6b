"""Harmonic balance: a nonlinear mode, or a forced motion, as a root of equations.

Unknowns are the Fourier coefficients Q (modes, size) of the modal coordinates and, for a mode, its
angular frequency omega and its damping ratio zeta: the *extended periodic motion* of Krack (2015),
DOI 10.1016/j.compstruc.2015.03.008, in which -2 zeta omega x' takes out what the joints lose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.modal_model import ModalJoints, ModalModel
from microslip.structures.periodic_motion import HarmonicBasis, HarmonicForces


@dataclass(frozen=True, eq=False)
class Balance:
    """The equations of a periodic motion."""

    model: ModalModel
    joints: ModalJoints
    basis: HarmonicBasis

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the coefficients."""
        return self.model.size, self.basis.size

    def joint_forces(
        self, coefficients: Floats, carried: Floats | float = 0.0
    ) -> tuple[Floats, list[HarmonicForces]]:
        """Joint forces less those of sticking joints (modes, size), and each group's answer.

        ``carried`` is what moves the joints besides the modes, (coordinates, size) [m].
        """
        motion = self.joints.flat.T @ coefficients + carried
        answers = [
            group.harmonic_forces(part, self.basis)
            for group, part in zip(self.joints.groups, self.joints.split(motion), strict=True)
        ]
        forces = [answer.force.reshape(-1, self.basis.size) for answer in answers]
        total = np.concatenate([np.zeros((0, self.basis.size)), *forces])
        return self.joints.flat @ (total - self.joints.stuck[:, None] * motion), answers

    def linear(self, coefficients: Floats, omega: float, damping: Floats | float) -> Floats:
        """Inertia, damping and sticking stiffness: forces (modes, size).

        ``damping`` is the factor of the velocities beside the damping matrix, -2 zeta omega.
        """
        orders = self.basis.orders
        square = self.model.squares[:, None] - (orders * omega) ** 2
        return square * coefficients + self.damped(self.velocity(coefficients, omega), damping)

    def velocity(self, coefficients: Floats, omega: float) -> Floats:
        """Coefficients of the velocity."""
        result = np.zeros_like(coefficients)
        rate = omega * self.basis.orders[1::2]
        result[:, 1::2] = rate * coefficients[:, 2::2]
        result[:, 2::2] = -rate * coefficients[:, 1::2]
        return result

    def by_omega(self, coefficients: Floats, omega: float) -> Floats:
        """Derivative of inertia and damping matrix' forces by the frequency."""
        inertia = -2.0 * omega * self.basis.orders**2 * coefficients
        return inertia + self.damped(self.velocity(coefficients, omega), 0.0) / omega

    def damped(self, velocity: Floats, damping: Floats | float) -> Floats:
        """Damping forces of a velocity."""
        result = damping * velocity
        if self.model.damping is not None:
            result = result + self.model.damping @ velocity
        return result

    def tangent(self, answers: list[HarmonicForces], change: Floats) -> Floats:
        """Change of the joint forces beyond sticking, for a change of modal coefficients."""
        return self.by_motion(answers, self.joints.flat.T @ change)

    def by_motion(self, answers: list[HarmonicForces], motion: Floats) -> Floats:
        """The same for a change of the joints' motions, (coordinates, size)."""
        size = self.basis.size
        moved = -self.joints.stuck[:, None] * motion
        for part, answer in zip(self.joints.parts, answers, strict=True):
            joints, width = answer.force.shape[:2]
            blocks = answer.jacobian.reshape(joints, width * size, width * size)
            local = motion[part].reshape(joints, width * size, 1)
            moved[part] += (blocks @ local).reshape(-1, size)
        return np.asarray(self.joints.flat @ moved)

    def tangent_matrix(self, answers: list[HarmonicForces]) -> Floats:
        """The same as a matrix (modes, size, modes, size)."""
        modes, size = self.shape
        result = np.zeros((modes, size, modes, size))
        for answer, directions, group in zip(
            answers, self.joints.directions, self.joints.groups, strict=True
        ):
            joints, width = group.stuck.shape
            blocks = answer.beyond(group.stuck)
            # (joints, c, k, c', l) with the directions of c' -> (joints, c, k, l, modes)
            half = np.matmul(
                blocks.transpose(0, 1, 2, 4, 3).reshape(joints, -1, width),
                directions.transpose(1, 2, 0),
            ).reshape(joints, width, size * size * modes)
            full = directions.reshape(modes, -1) @ half.reshape(joints * width, -1)
            result += full.reshape(modes, size, size, modes).transpose(0, 1, 3, 2)
        return result

    def linear_matrix(self, omega: float, damping: float) -> Floats:
        """Derivative of :meth:`linear` by the coefficients, (modes, size, modes, size)."""
        modes, size = self.shape
        result = np.zeros((modes, size, modes, size))
        index = np.arange(modes)
        for k, order in enumerate(self.basis.orders):
            result[index, k, index, k] = self.model.squares - (order * omega) ** 2
        damper = damping * np.eye(modes)
        if self.model.damping is not None:
            damper = damper + self.model.damping
        for k in range(1, size, 2):
            rate = omega * self.basis.orders[k]
            result[:, k, :, k + 1] += rate * damper
            result[:, k + 1, :, k] -= rate * damper
        return result
