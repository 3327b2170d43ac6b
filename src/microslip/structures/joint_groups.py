"""Joints of a structure: as attached, linearised about a static state, and in time.

An attachment is a set of joints of one kind: a backbone law along directions, or a field of contact
nodes. About a static state it becomes a group, whose joints have one coordinate each (law) or three
(node of a field: along its line of motion, across it, opening). Displacements of a group have the
shape (joints, coordinates), Fourier coefficients (joints, coordinates, coefficients); both are
relative to the static state.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip.friction import BackboneLaw, JointField
from microslip.structures.geometry import GeometryAttachment, GeometryGroup
from microslip.structures.periodic_motion import HarmonicBasis, HarmonicForces

# -- a law along directions ------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LawAttachment:
    """Friction law along one or more directions, at rest in the undeformed structure."""

    law: BackboneLaw
    columns: Floats
    """Directions of all joints as columns, (degrees of freedom, coordinates)."""

    has_gaps = False
    """Whether gaps separate the faces before static forces close them."""
    largest_load_at_rest = 0.0
    """Largest load without static forces [N], the scale of rounding errors."""

    @property
    def representative_stiffness(self) -> Floats:
        """Stiffness at rest [N/m] of each joint coordinate; zero if it carries no static load."""
        return np.full(self.columns.shape[1], self.law.tangential_stiffness)

    def static_forces(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return forces [N] and stiffnesses [N/m] at joint displacements (coordinates,) [m]."""
        return self.law.backbone(motion), self.law.backbone_stiffness(motion)

    def stuck(self, motion: Floats) -> Floats:
        """Return stiffnesses of sticking joints [N/m] at static displacements (coordinates,)."""
        return np.full(motion.size, self.law.tangential_stiffness)

    def group(self, motion: Floats, line: Floats) -> LawGroup:
        """Return the joints linearised about a static motion [m]; ``line`` is not used by laws."""
        del line  # a law has its own
        return LawGroup(self.law, self.columns, motion)


class LawGroup:
    """Backbone law along several directions, linearised about a static state."""

    def __init__(self, law: BackboneLaw, directions: Floats, static: Floats) -> None:
        self.law = law
        self.directions = directions[:, :, None]
        """Directions of the joints, shape (degrees of freedom, joints, coordinates)."""
        self.static = static
        self._loaded = law.backbone(static)
        self.stuck = np.full((static.size, 1), law.tangential_stiffness)
        """Stiffness at rest (joints, coordinates) [N/m]."""

    def harmonic_forces(self, coefficients: Floats, basis: HarmonicBasis) -> HarmonicForces:
        """Return Fourier coefficients of the steady-state joint forces, minus forces at rest."""
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

    def start(self) -> LawStates:
        """Return joint states that begin in the static state."""
        return LawStates(self.law, self.static, self._loaded)


class LawStates:
    """Hysteresis states of the joints of a law; a trial takes effect when it is committed."""

    def __init__(self, law: BackboneLaw, static: Floats, loaded: Floats) -> None:
        self._states: list[Any] = [law.start() for _ in static]
        self._static, self._loaded = static, loaded
        for state, x in zip(self._states, static, strict=True):
            state.advance(x)

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Return forces (joints, 1) [N], minus those at rest, and tangents (joints, 1, 1) [N/m]."""
        places = self._static + displacement[:, 0]
        trials = np.array([s.try_(x) for s, x in zip(self._states, places, strict=True)])
        return (trials[:, 0] - self._loaded)[:, None], trials[:, 1, None, None]

    def commit(self) -> None:
        """Accept the last trial as the state."""
        for state in self._states:
            state.commit()

    @property
    def lost(self) -> Floats:
        """Dissipated energies (joints,) [J], including those of the path to the static state."""
        return np.array([state.dissipated_energy for state in self._states])


# -- a field of nodes ------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class FieldAttachment:
    """Nodes of a field, each with two tangential directions and an opening.

    Same interface as :class:`LawAttachment`; the directions have the shape (n, nodes, 3).
    """

    field: JointField
    directions: Floats

    def loads(self, motion: Floats) -> Floats:
        """Return the normal loads of the nodes [N] at joint displacements (coordinates,) [m]."""
        return self.field.load(self.separations(motion))[0]

    @property
    def columns(self) -> Floats:
        """Directions of all nodes as columns, (degrees of freedom, 3 nodes)."""
        return self.directions.reshape(self.directions.shape[0], -1)

    @property
    def representative_stiffness(self) -> Floats:
        """Mask of the coordinates that carry static load: 1 for openings, 0 for tangential ones.

        It takes the place of a stiffness, since only its sign is used.
        """
        result = np.zeros(self.directions.shape[1:])
        result[:, 2] = 1.0
        return result.reshape(-1)

    @property
    def has_gaps(self) -> bool:
        """Whether the field was given by gaps instead of loads."""
        return self.field.gaps is not None

    @property
    def largest_load_at_rest(self) -> float:
        """Largest normal load at rest of a node [N], a scale of residuals; 0 if gaps were given."""
        return 0.0 if self.has_gaps else float(self.field.normal_loads.max())

    def static_forces(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return frictionless forces [N] and stiffnesses [N/m], (coordinates,), at joint motions.

        Normal forces of a field with given loads are relative to these loads.
        """
        loads, slopes = self.field.load(self.separations(motion))
        force, stiffness = np.zeros((2, loads.size, 3))
        force[:, 2] = -loads if self.has_gaps else self.field.normal_loads - loads
        stiffness[:, 2] = -slopes
        return force.reshape(-1), stiffness.reshape(-1)

    def separations(self, motion: Floats) -> Floats:
        """Return the separations of the nodes [m] at joint displacements (coordinates,) [m]."""
        undeformed = self.field.separations if self.field.gaps is None else self.field.gaps
        return np.asarray(undeformed + motion.reshape(-1, 3)[:, 2])

    def stuck(self, motion: Floats) -> Floats:
        """Return the stiffnesses of each sticking node [N/m]: two tangential ones, and normal."""
        field = self.field.at(separations=self.separations(motion))
        return _stuck(field, np.tile(np.eye(2), (field.size, 1, 1))).reshape(-1)

    def group(self, motion: Floats, line: Floats) -> FieldGroup:
        """Return the nodes at the separations of the joint motions ``motion`` [m], as one group.

        Each node slides along its tangential direction in the joint motions ``line``.
        """
        field = self.field.at(separations=self.separations(motion))
        return FieldGroup(field, self.directions, line.reshape(-1, 3)[:, :2])


class FieldGroup:
    """Nodes with three coordinates each: along a tangential line, across it, and opening.

    Along its line a node follows the exact friction law with varying separation. Across the line it
    is a linear spring of the node's stiffness at rest, since the motion across the line of largest
    motion is small in a mode. On a surface with a lay the stiffness depends on the direction of the
    line; the small force component across the line is neglected. Same interface as
    :class:`LawGroup`.
    """

    def __init__(self, field: JointField, directions: Floats, line: Floats) -> None:
        along = _unit(line)
        ways = (along, np.stack([-along[:, 1], along[:, 0]], axis=1))
        tangential = [np.einsum("npt,pt->np", directions[:, :, :2], way) for way in ways]
        self.directions = np.stack([*tangential, directions[:, :, 2]], axis=2)
        self.stuck = _stuck(field, np.stack(ways, axis=1))
        self.field = field.along(along)

    def by_coordinate(
        self, motion: Floats, force: Floats, load: Floats, tangent: Floats
    ) -> HarmonicForces:
        """Return the forces in the three coordinates minus those at rest, as Fourier coefficients.

        ``force`` (along the line) and ``load`` (normal) have the shape (nodes, size), ``motion``
        (nodes, 3, size). ``tangent`` (nodes, 2, 2, size, size) are the derivatives of ``force`` and
        ``load`` with respect to motion along the line and opening.
        """
        across, size = self.stuck[:, 1, None], force.shape[1]
        forces = np.stack([force, across * motion[:, 1], -load], axis=1)
        forces[:, 2, 0] += self.field.normal_loads
        jacobian, k = np.zeros((len(force), 3, size, 3, size)), np.arange(size)
        jacobian[:, 0, :, 0], jacobian[:, 0, :, 2] = tangent[:, 0, 0], tangent[:, 0, 1]
        jacobian[:, 1, k, 1, k] = across
        jacobian[:, 2, :, 0], jacobian[:, 2, :, 2] = -tangent[:, 1, 0], -tangent[:, 1, 1]
        return HarmonicForces(forces, jacobian)

    def harmonic_forces(self, coefficients: Floats, basis: HarmonicBasis) -> HarmonicForces:
        """Return Fourier coefficients of the steady-state joint forces, minus forces at rest."""
        separations = coefficients[:, 2].copy()
        separations[:, 0] += self.field.separations
        cycle = self.field.harmonics(
            coefficients[:, 0],
            list(basis.harmonics),
            separations=separations,
            samples=basis.samples,
        )
        return self.by_coordinate(coefficients, *cycle)

    def start(self) -> FieldStates:
        """Return the state of the nodes at rest."""
        return FieldStates(self)


class FieldStates:
    """State of the nodes in time, in the coordinates of the group. Same interface as LawStates."""

    def __init__(self, group: FieldGroup) -> None:
        self._group = group
        self._state = group.field.start(energies=True)

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Return forces (nodes, 3) [N] and tangents (nodes, 3, 3) [N/m] at trial displacements."""
        separation = self._group.field.separations + displacement[:, 2]
        answer = self._state.try_(displacement[:, 0], separations=separation)
        numbers = (displacement, answer.force, answer.load, answer.tangent[..., None])
        force, jacobian = self._group.by_coordinate(*(values[..., None] for values in numbers))
        return force[..., 0], jacobian[:, :, 0, :, 0]

    def commit(self) -> None:
        """Accept the last trial as the state."""
        self._state.commit()

    @property
    def lost(self) -> Floats:
        """Energy dissipated by each node (nodes,) [J]."""
        return np.asarray(self._state.dissipated_energy)


def _stuck(field: JointField, axes: Floats) -> Floats:
    """Return stiffnesses (nodes, 3) [N/m] of sticking nodes along two ``axes``, and normal."""
    tangential = [field.along(axes[:, i]).tangential_stiffnesses for i in (0, 1)]
    return np.stack([*tangential, -field.load(field.separations)[1]], axis=1)


def _unit(line: Floats) -> Floats:
    length = np.linalg.norm(line, axis=1)
    moves = length > 1e-9 * length.max(initial=0.0)
    safe = np.where(moves, length, 1.0)[:, None]
    return np.where(moves[:, None], line / safe, np.array([1.0, 0.0]))


Attachment = LawAttachment | FieldAttachment | GeometryAttachment
JointGroup = LawGroup | FieldGroup | GeometryGroup
JointState = LawStates | FieldStates | GeometryGroup
_ROWS = ("directions", "columns", "coordinates", "rest")
"""Arrays of attachments whose first axis is the degree of freedom."""


def change_rows(attachment: Attachment, change: Callable[[Floats], Floats]) -> Attachment:
    """Return an attachment with changed rows of its arrays, such as those of fewer degrees."""
    arrays = {f.name: getattr(attachment, f.name) for f in fields(attachment) if f.name in _ROWS}
    changed: dict[str, Any] = {k: change(v) for k, v in arrays.items() if v is not None}
    return replace(attachment, **changed)


def joint_motion(attachments: Sequence[Attachment], motions: Floats) -> tuple[float, int]:
    """Return the largest relative deformation of joints by rigid motions [-], and its attachment.

    For a joint direction b and a motion r (degrees of freedom,) it is |b^T r| / (|b|^T |r|): 0 if
    both sides move alike.
    """
    worst, place = 0.0, 0
    for i, attachment in enumerate(attachments):
        columns = attachment.columns
        moved = np.abs(columns.T @ motions)
        sides = np.abs(columns).T @ np.abs(motions)
        share = float((moved / np.where(sides > 0.0, sides, 1.0)).max())
        if share > worst:
            worst, place = share, i
    return worst, place


def all_columns(attachments: Sequence[Attachment], size: int) -> Floats:
    """Return the directions of all attachments as columns (size, coordinates)."""
    return np.concatenate([np.zeros((size, 0)), *(a.columns for a in attachments)], axis=1)


def checked_law(law: BackboneLaw) -> BackboneLaw:
    """Validate that a law has a finite stiffness at rest."""
    if not math.isfinite(law.tangential_stiffness):
        raise InputError(
            f"law must have a finite stiffness at rest, {type(law).__name__} friction is rigid "
            "there; write ms.Jenkins(stiffness, force_limit)"
        )
    return law
