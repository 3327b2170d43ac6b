"""Structure in the modal coordinates of sticking joints; base classes of solver results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip._core.frozen import LockedArrays
from microslip.structures.joint_groups import Attachment, JointGroup, all_columns
from microslip.structures.matrices import (
    fastest_rate,
    linear_modes,
    rigid_count,
    solve_linear,
    vector,
    with_springs,
)

LARGEST_WHOLE = 1200
"""Largest number of degrees of freedom for which all modes are kept."""
_MODES_KEPT = 40  # modes of a larger structure, besides its answers to each joint's force


@dataclass(frozen=True, eq=False)
class ModalModel:
    """Modal equations x = shapes q, q'' + damping q' + squares q + joint forces = modal forces.

    ``squares`` include the stiffness of sticking joints; joint forces are relative to those of
    sticking joints. Rigid-body motions that deform no joint are not among the modes.
    """

    shapes: Floats
    """Mode shapes (degrees of freedom, modes), each of modal mass 1 kg."""
    squares: Floats
    """Squares of the angular frequencies [rad^2/s^2]."""
    damping: Floats | None
    """Modal damping matrix [1/s]; None without one."""
    free: Floats
    """Rigid motions (degrees of freedom, motions), of modal mass 1 kg, which move no joint."""
    attachments: tuple[Attachment, ...]
    motions: tuple[Floats, ...]
    """Static displacements of the joints of each attachment, (coordinates,) [m]."""

    @property
    def size(self) -> int:
        """Number of modes."""
        return self.squares.size

    def joints(self, line: Floats) -> ModalJoints:
        """Return the joints; nodes of fields slide in the direction of a modal motion ``line``."""
        shape = self.shapes @ line
        pairs = zip(self.attachments, self.motions, strict=True)
        groups = [joints.group(motion, joints.columns.T @ shape) for joints, motion in pairs]
        return ModalJoints(groups, self.shapes)


class ModalJoints:
    """Groups of joints with their directions in modal coordinates."""

    def __init__(self, groups: Sequence[JointGroup], shapes: Floats) -> None:
        self.groups = list(groups)
        modes = shapes.shape[1]
        self.directions = [
            np.tensordot(shapes, group.directions, axes=(0, 0)) for group in self.groups
        ]
        """Directions of each group in modal coordinates, (modes, joints, coordinates)."""
        self.flat = np.concatenate(
            [d.reshape(modes, -1) for d in self.directions] or [np.zeros((modes, 0))], axis=1
        )
        """Directions of all groups side by side, (modes, coordinates)."""
        self.stuck = np.concatenate([g.stuck.reshape(-1) for g in self.groups] or [np.zeros(0)])

    @cached_property
    def parts(self) -> list[slice]:
        """Slice of the joint coordinates of each group."""
        ends = np.cumsum([0] + [g.stuck.size for g in self.groups])
        return [slice(int(a), int(b)) for a, b in pairwise(ends)]

    def carried(self, motion: Floats) -> Floats:
        """Return joint motions (coordinates, inputs) for displacements (n, inputs)."""
        sides = [np.tensordot(group.directions, motion, axes=(0, 0)) for group in self.groups]
        inputs = motion.shape[1]
        return np.concatenate([np.zeros((0, inputs)), *(s.reshape(-1, inputs) for s in sides)])

    def split(self, values: Floats) -> list[Floats]:
        """Split values (all coordinates, ...) into arrays (joints, coordinates, ...), by group."""
        return [
            values[part].reshape(*group.stuck.shape, *values.shape[1:])
            for part, group in zip(self.parts, self.groups, strict=True)
        ]

    def answers(
        self, displacement: Floats, laws: Sequence[Callable[[Floats], tuple[Floats, Floats]]]
    ) -> tuple[Floats, list[Floats]]:
        """Return joint forces (coordinates,) [N] at ``displacement`` [m], and tangents by group.

        ``laws`` holds one function for each group, from its displacements to forces and tangents.
        """
        force = np.zeros(self.stuck.size)
        slopes = []
        for part, law, u in zip(self.parts, laws, self.split(displacement), strict=True):
            value, slope = law(u)
            force[part] = value.reshape(-1)
            slopes.append(slope)
        return force, slopes

    def by_tangents(self, left: Floats, slopes: list[Floats]) -> Floats:
        """Return ``left`` (rows, coordinates) times the :meth:`tangent_matrix` of ``slopes``."""
        result: Floats = -left * self.stuck
        for part, slope in zip(self.parts, slopes, strict=True):
            joints, width = slope.shape[:2]
            rows = left[:, part].reshape(-1, joints, width).transpose(1, 0, 2)
            result[:, part] += (rows @ slope).transpose(1, 0, 2).reshape(-1, joints * width)
        return result

    def tangent_matrix(self, slopes: list[Floats]) -> Floats:
        """Return the tangents minus those of sticking joints (coordinates, coordinates)."""
        result = np.zeros((self.stuck.size, self.stuck.size))
        for part, slope in zip(self.parts, slopes, strict=True):
            joints, width = slope.shape[:2]
            rows = part.start + width * np.arange(joints)[:, None, None]
            rows = rows + np.arange(width)[None, :, None]
            result[rows, rows.transpose(0, 2, 1)] = slope
        result[np.diag_indices_from(result)] -= self.stuck
        return result


def modal_model(
    mass: Any,
    stiffness: Any,
    damping: Any,
    attachments: tuple[Attachment, ...],
    motions: Sequence[Floats],
) -> ModalModel:
    """Return the modal model about a static state with the joint displacements ``motions``."""
    stuck_matrix = stuck_stiffness(stiffness, attachments, motions)
    if mass.shape[0] <= LARGEST_WHOLE:
        squares, shapes = linear_modes(stuck_matrix, mass)
        rigid = rigid_count(squares, stuck_matrix, mass)
        free = np.ascontiguousarray(shapes[:, :rigid])
        squares, shapes = squares[rigid:], shapes[:, rigid:]
    else:
        squares, shapes, free = _reduced(
            stuck_matrix, mass, all_columns(attachments, mass.shape[0])
        )
    modal_damping = None if damping is None else np.asarray(shapes.T @ (damping @ shapes))
    return ModalModel(
        np.ascontiguousarray(shapes), squares, modal_damping, free, attachments, tuple(motions)
    )


def stuck_stiffness(
    stiffness: Any, attachments: tuple[Attachment, ...], motions: Sequence[Floats]
) -> Any:
    """Return the stiffness with all joints sticking about a static state."""
    springs = [a.stuck(u) for a, u in zip(attachments, motions, strict=True)]
    columns = all_columns(attachments, stiffness.shape[0])
    return with_springs(stiffness, columns, np.concatenate([*springs, np.zeros(0)]))


def _reduced(stiffness: Any, mass: Any, columns: Floats) -> tuple[Floats, Floats, Floats]:
    """Return squared frequencies, modes and rigid-body motions of a reduced model.

    Its basis is the lowest modes and the static response to each joint force (mode acceleration);
    static deflections under joint forces are exact.
    """
    from scipy.linalg import eigh

    count = _MODES_KEPT + 6
    squares, shapes = linear_modes(stiffness, mass, count)
    rigid = rigid_count(squares, stiffness, mass)
    free = shapes[:, :rigid]
    lowest = shapes[:, rigid : rigid + _MODES_KEPT]
    answers = _answers(stiffness, mass, columns)
    answers -= free @ (free.T @ (mass @ answers))
    answers -= lowest @ (lowest.T @ (mass @ answers))
    answers /= np.sqrt(np.einsum("ij,ij->j", answers, np.asarray(mass @ answers)))
    overlap = answers.T @ (mass @ answers)
    weights, vectors = np.linalg.eigh(overlap)
    sound = weights > 1e-12 * weights[-1]  # what several directions share is kept once
    basis = np.concatenate(
        [lowest, answers @ (vectors[:, sound] / np.sqrt(weights[sound]))], axis=1
    )
    small_stiffness = basis.T @ (stiffness @ basis)
    small_mass = basis.T @ (mass @ basis)
    squares, mix = eigh(small_stiffness, small_mass)
    return squares, basis @ mix, free


def _answers(stiffness: Any, mass: Any, columns: Floats) -> Floats:
    """Return the static displacements under a unit force along each column."""
    # A shift far below the first frequency makes up for rigid motions.
    shift = 1e-10 * fastest_rate(stiffness, mass)
    return solve_linear(stiffness + shift * mass, columns)


class SolverResult(LockedArrays):
    """Motion computed by a solver, complete or stopped early."""

    message: str

    @property
    def status(self) -> str:
        """``solved``, or ``stopped`` before the end."""
        return "solved" if self.message.startswith("solved") else "stopped"

    def _sizes(self, columns: Floats) -> Floats:
        """Return magnitudes of the motion along columns (n, k), at points or times (..., k) [m]."""
        raise NotImplementedError


class ModalResult(SolverResult):
    """Motion in modal coordinates on a base that may move."""

    _shapes: Floats
    _carried: Floats

    def _at(self, sensor: ArrayLike) -> Floats:
        return np.asarray(self._shapes.T @ vector("at", sensor, self._shapes.shape[0]))

    def _carried_at(self, sensor: ArrayLike) -> Any:
        """Return the motion at the sensor per unit motion of the base, or of each input [-]."""
        return vector("at", sensor, self._shapes.shape[0]) @ self._carried
