"""Faces that remember how they were assembled, where a motion in time begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats
from microslip.friction import JointField
from microslip.friction.two_directions import IsotropicField
from microslip.memory.vector_state import VectorState
from microslip.structures.joint_groups import FieldAttachment, FieldGroup


@dataclass(frozen=True, eq=False)
class AssembledFaces(FieldAttachment):
    """Nodes of a field that remember how they were pressed."""

    nodes: IsotropicField
    memory: dict[str, Floats]

    def group(self, motion: Floats, line: Floats) -> AssembledGroup:
        """The nodes about the assembled state, along their lines in a mode."""
        field = self.field.at(separations=self.separations(motion))
        return AssembledGroup(field, self.directions, line.reshape(-1, 3)[:, :2], self)


class AssembledGroup(FieldGroup):
    """Nodes whose settled cycle has forgotten the assembly, and whose motion in time begins so."""

    def __init__(
        self, field: JointField, directions: Floats, line: Floats, faces: AssembledFaces
    ) -> None:
        super().__init__(field, directions, line)
        self._faces = faces

    def resumed(self) -> AssembledState:
        """The state that the assembly left."""
        return AssembledState(self, self._faces.nodes.start(arrays=self._faces.memory))


class AssembledState:
    """The nodes in two directions, in the coordinates of their group; else as FieldState."""

    def __init__(self, group: AssembledGroup, state: VectorState) -> None:
        self._field, self._state = group.field, state
        self._origin, self._held = state.displacement, state.force
        self._turn = np.stack([group.along, group.across], axis=1)

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Forces and tangents of a trial."""
        moved = np.einsum("nij,ni->nj", self._turn, displacement[:, :2])
        separation = self._field.separations + displacement[:, 2]
        answer = self._state.try_(self._origin + moved, separations=separation)
        turn = np.zeros((len(separation), 3, 3))
        turn[:, :2, :2], turn[:, 2, 2] = self._turn, 1.0
        forces = np.column_stack(
            [answer.force - self._held, self._field.normal_loads - answer.load]
        )
        tangent = answer.tangent * np.array([1.0, 1.0, -1.0])[:, None]
        forces = np.einsum("nij,nj->ni", turn, forces)
        return forces, np.einsum("nij,njk,nlk->nil", turn, tangent, turn)

    def commit(self) -> None:
        """Make the last trial the state."""
        self._state.commit()

    @property
    def lost(self) -> Floats:
        """Energies lost so far [J], those of the assembly included."""
        return np.asarray(self._state.dissipated_energy)
