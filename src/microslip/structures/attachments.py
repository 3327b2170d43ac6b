"""What is attached to a structure: laws along directions, fields of nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from microslip._core.checks import Floats
from microslip.friction import BackboneLaw, JointField
from microslip.structures.field_group import FieldGroup
from microslip.structures.joint_groups import JointGroup, LawGroup


class Attachment(Protocol):
    """Joints of one kind, before a static state is known."""

    @property
    def columns(self) -> Floats:
        """All directions side by side, (degrees of freedom, coordinates)."""

    @property
    def holding(self) -> Floats:
        """A stiffness for each column that is of the size of the joint's own at work [N/m].

        It tells which motions the joints hold at all; columns that hold nothing have a zero.
        """

    @property
    def held_load(self) -> float:
        """Largest load that is there without static forces [N]: what rounding stands beside."""

    def static_forces(self, motion: Floats) -> tuple[Floats, Floats]:
        """Forces [N] and stiffnesses [N/m] by column at a static motion by column [m]."""

    def stuck(self, motion: Floats) -> Floats:
        """Stiffnesses by column about a static motion by column, all joints sticking [N/m]."""

    def group(self, motion: Floats, line: Floats) -> JointGroup:
        """The joints about a static motion, their tangential lines along that of ``line``."""


@dataclass(frozen=True, eq=False)
class LawAttachment:
    """One law along one or more directions; it rests where the structure is undeformed."""

    law: BackboneLaw
    directions: Floats

    @property
    def columns(self) -> Floats:
        """See :class:`Attachment`."""
        return self.directions

    @property
    def holding(self) -> Floats:
        """See :class:`Attachment`."""
        return np.full(self.directions.shape[1], self.law.tangential_stiffness)

    @property
    def held_load(self) -> float:
        """See :class:`Attachment`."""
        return 0.0

    def static_forces(self, motion: Floats) -> tuple[Floats, Floats]:
        """See :class:`Attachment`."""
        return self.law.backbone(motion), self.law.backbone_stiffness(motion)

    def stuck(self, motion: Floats) -> Floats:
        """See :class:`Attachment`."""
        return np.full(motion.size, self.law.tangential_stiffness)

    def group(self, motion: Floats, line: Floats) -> JointGroup:
        """See :class:`Attachment`."""
        del line  # a law has its own
        return LawGroup(self.law, self.directions, motion)


@dataclass(frozen=True, eq=False)
class FieldAttachment:
    """Nodes of a field, each with two tangential directions and an opening."""

    field: JointField
    directions: Floats

    @property
    def columns(self) -> Floats:
        """See :class:`Attachment`."""
        return self.directions.reshape(self.directions.shape[0], -1)

    @property
    def holding(self) -> Floats:
        """See :class:`Attachment`."""
        result = np.zeros(self.directions.shape[1:])
        result[:, 2] = 1.0  # how stiffly it will hold is not known before it is pressed
        return result.reshape(-1)

    @property
    def held_load(self) -> float:
        """See :class:`Attachment`."""
        return 0.0 if self.field.gaps is not None else float(self.field.normal_loads.max())

    @property
    def _undeformed(self) -> Floats:
        """Separations where the structure is undeformed [m]."""
        gaps = self.field.gaps
        return self.field.separations if gaps is None else gaps

    def static_forces(self, motion: Floats) -> tuple[Floats, Floats]:
        """See :class:`Attachment`; there is no friction while a structure is put together.

        A field that was given its loads is at rest under them: only what they change by counts.
        """
        loads, slopes = self.field.load(self.separations(motion))
        force, stiffness = np.zeros((2, loads.size, 3))
        force[:, 2] = -loads if self.field.gaps is not None else self.field.normal_loads - loads
        stiffness[:, 2] = -slopes
        return force.reshape(-1), stiffness.reshape(-1)

    def separations(self, motion: Floats) -> Floats:
        """Separations of the nodes [m] at a motion by column."""
        return np.asarray(self._undeformed + motion.reshape(-1, 3)[:, 2])

    def stuck(self, motion: Floats) -> Floats:
        """See :class:`Attachment`."""
        field = self.field.at(separations=self.separations(motion))
        normal = -field.load(field.separations)[1]
        tangential = field.tangential_stiffnesses
        return np.stack([tangential, tangential, normal], axis=1).reshape(-1)

    def group(self, motion: Floats, line: Floats) -> JointGroup:
        """See :class:`Attachment`."""
        field = self.field.at(separations=self.separations(motion))
        return FieldGroup(field, self.directions, line.reshape(-1, 3)[:, :2])


def all_columns(attachments: Sequence[Attachment], size: int) -> Floats:
    """The directions of all attachments side by side."""
    if not attachments:
        return np.zeros((size, 0))
    return np.concatenate([attachment.columns for attachment in attachments], axis=1)
