"""The nodes of a field in a structure: friction along a line, contact that opens and closes."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip.friction import JointField
from microslip.structures.harmonic_basis import HarmonicBasis
from microslip.structures.joint_groups import HarmonicForces, JointState


class FieldGroup:
    """Nodes that move along a tangential line each, across it, and apart.

    Along its line a node follows the exact coupled law of a joint whose separation varies. Across
    it sticks: a linear spring of the node's stiffness at rest, since in a mode the motion across
    the line of largest motion is small.
    """

    def __init__(self, field: JointField, directions: Floats, line: Floats) -> None:
        self.field = field
        along = _unit(line)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        self.directions = np.stack(
            [
                np.einsum("npt,pt->np", directions[:, :, :2], along),
                np.einsum("npt,pt->np", directions[:, :, :2], across),
                directions[:, :, 2],
            ],
            axis=2,
        )
        self._across = field.tangential_stiffnesses
        normal = -field.load(field.separations)[1]
        self.stuck = np.stack([self._across, self._across, normal], axis=1)

    def forces(self, displacement: Floats) -> tuple[Floats, Floats]:
        """See :class:`microslip.structures.joint_groups.JointGroup`."""
        separation = self.field.separations + displacement[:, 2]
        answer = self.field.first_loading(displacement[:, 0], separation)
        return self._assembled(displacement, answer.force, answer.load, answer.tangent)

    def _assembled(
        self, displacement: Floats, force: Floats, load: Floats, tangent: Floats
    ) -> tuple[Floats, Floats]:
        """Forces by coordinate, from tangential and normal ones."""
        forces = np.stack(
            [force, self._across * displacement[:, 1], self.field.normal_loads - load], axis=1
        )
        tangents = np.zeros((load.size, 3, 3))
        tangents[:, 0, 0], tangents[:, 0, 2] = tangent[:, 0, 0], tangent[:, 0, 1]
        tangents[:, 1, 1] = self._across
        tangents[:, 2, 0], tangents[:, 2, 2] = -tangent[:, 1, 0], -tangent[:, 1, 1]
        return forces, tangents

    def loop_energies(self, amplitudes: Floats) -> Floats:
        """See :class:`microslip.structures.joint_groups.JointGroup`; the load is that at rest."""
        return self.field.dissipated_energy(np.abs(amplitudes[..., 0]))

    def harmonic_forces(self, coefficients: Floats, basis: HarmonicBasis) -> HarmonicForces:
        """See :class:`microslip.structures.joint_groups.JointGroup`."""
        separations = coefficients[:, 2].copy()
        separations[:, 0] += self.field.separations
        tangential, normal, tangent = self.field.harmonics(
            coefficients[:, 0],
            list(basis.harmonics),
            separations=separations,
            samples=basis.samples,
        )
        nodes, size = len(self._across), basis.size
        force = np.empty((nodes, 3, size))
        force[:, 0], force[:, 2] = tangential, -normal
        force[:, 1] = self._across[:, None] * coefficients[:, 1]
        force[:, 2, 0] += self.field.normal_loads
        jacobian = np.zeros((nodes, 3, size, 3, size))
        each = np.arange(size)
        jacobian[:, 0, :, 0], jacobian[:, 0, :, 2] = tangent[:, 0, 0], tangent[:, 0, 1]
        jacobian[:, 1, each, 1, each] = self._across[:, None]
        jacobian[:, 2, :, 0], jacobian[:, 2, :, 2] = -tangent[:, 1, 0], -tangent[:, 1, 1]
        return HarmonicForces(force, jacobian)

    def start(self) -> JointState:
        """See :class:`microslip.structures.joint_groups.JointGroup`."""
        return _FieldState(self)


class _FieldState:
    """The state of the nodes, in the coordinates of the group."""

    def __init__(self, group: FieldGroup) -> None:
        self._group = group
        self._state = group.field.start(energies=True)

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        group = self._group
        separation = group.field.separations + displacement[:, 2]
        answer = self._state.try_(displacement[:, 0], separations=separation)
        return group._assembled(displacement, answer.force, answer.load, answer.tangent)

    def commit(self) -> None:
        self._state.commit()

    @property
    def lost(self) -> Floats:
        return np.asarray(self._state.dissipated_energy)


def _unit(line: Floats) -> Floats:
    """Directions of motion in the tangential plane; the first axis where nothing moves."""
    length = np.linalg.norm(line, axis=1)
    moves = length > 1e-9 * length.max(initial=0.0)
    safe = np.where(moves, length, 1.0)[:, None]
    return np.where(moves[:, None], line / safe, np.array([1.0, 0.0]))
