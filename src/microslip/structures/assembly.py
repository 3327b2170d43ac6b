"""Bolts tightened one after the other, with friction in the faces, and the forces left in these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, number, show, whole_number
from microslip._core.frozen import LockedArrays
from microslip.errors import InputError
from microslip.structures.joint_groups import Attachment, FieldAttachment
from microslip.structures.structure import Preload

if TYPE_CHECKING:
    from microslip.friction.two_directions import IsotropicField
    from microslip.normal import NormalLaw

_SLIDERS = 512
_BALANCED = 1e-9  # of the largest tension
_ENOUGH = 1e-7
_ROUNDS, _SHORTENINGS = 40, 12


@dataclass(frozen=True, eq=False)
class Assembly(LockedArrays):
    """A joint whose bolts were tightened in turn; :meth:`ReducedJoint.assemble` makes it.

    The faces slip as they are pressed; each node remembers in both directions what it held, with
    Iwan's sliders (1966, DOI 10.1115/1.3625199). On elastic interaction of bolts see Nassar and
    Alkelani (2006), DOI 10.1115/1.2151201.
    """

    state: Preload
    """At rest, with ``modes`` and ``integrate``, which goes on from what the faces hold."""
    order: tuple[int, ...]
    """Bolts as they were tightened, counted from 1."""
    tensions: Floats
    """Tension of each bolt in the end [N]: tightening one relieves others."""
    tractions: Floats
    """Tangential force that each patch still holds, along and across [N], (patches, 2)."""
    slip_share: Floats
    """Their size over the friction limit of each patch [-]; zero where nothing presses."""
    lost: float
    """Energy that slip lost meanwhile [J]."""


def assemble(
    joint: Any,
    surface: NormalLaw,
    friction_coefficient: ArrayLike,
    order: Sequence[int] | None,
    steps: int,
    passes: int,
    snug: float,
) -> Assembly:
    """See :meth:`ReducedJoint.assemble`."""
    bolts = len(joint.bolt_tension)
    order = tuple(range(1, bolts + 1)) if order is None else tuple(order)
    turns = [whole_number("order", bolt, 1, bolts) - 1 for bolt in order]
    if sorted(turns) != list(range(bolts)):
        raise InputError(f"order must name each of the {bolts} bolts once, got {show(order)}")
    steps, passes = whole_number("steps", steps, 1, 1000), whole_number("passes", passes, 1, 20)
    snug = number("snug", snug, example=0.05)
    if not 0.0 < snug < 1.0:
        raise InputError(f"snug must be between 0 and 1, a share of the tensions, got {snug:g}")
    geometry, joint = joint.geometry, replace(joint, geometry=None)
    loose = joint.with_tension(snug * joint.bolt_tension)
    pull = loose.static_force(surface)
    start = loose.structure(surface, friction_coefficient).preload(pull)
    # Faces come nearest under all bolts; a bolt alone presses what is beside it hardly more.
    final = joint.tightened(surface, friction_coefficient)
    field = joint.field(surface, friction_coefficient)
    near = float(field.at(separations=final.gaps).two_directions(_SLIDERS).knots[0])
    nodes = field.at(separations=start.gaps).two_directions(_SLIDERS, nearest=near)
    faces = _Faces(joint, nodes, start.displacement)
    first = 3 * joint.patches
    for _ in range(passes):
        for bolt in turns:
            place, stiff = first + bolt, joint.bolt_stiffness[bolt]
            loosened = joint.stiffness.copy()
            loosened[place, place] -= stiff
            pull[place] -= stiff * faces.displacement[place]
            full_pull = pull.copy()
            full_pull[place] = -joint.bolt_tension[bolt]
            for share in 1.0 / np.arange(steps, 0, -1):  # of what is left
                following = pull + share * (full_pull - pull)
                faces.settle(loosened, pull, following)
                pull = following
            pull[place] += stiff * faces.displacement[place]
    vector = faces.state
    resumed = partial(nodes.start, arrays=vector.to_arrays())
    attachment = FieldAttachment(field, joint.directions, assembled=resumed)
    attachments: tuple[Attachment, ...] = (attachment,)
    if geometry is not None:  # whose cases are of what is tight
        attachments = (attachment, replace(geometry, rest=faces.displacement))
    state = Preload(
        joint.mass, joint.stiffness, None, attachments, pull, faces.displacement, faces.error,
        faces.rounds,
    )  # fmt: skip
    loads = state.normal_loads * np.asarray(friction_coefficient)
    size = np.linalg.norm(vector.force, axis=1)
    return Assembly(
        state,
        order,
        joint.tensions(faces.displacement, pull),
        vector.force.copy(),
        np.divide(size, loads, out=np.zeros(size.size), where=loads > 0.0),
        float(np.sum(vector.dissipated_energy)),
    )


class _Faces:
    """The displacements of a joint, and the memory of its faces, as the bolts are tightened."""

    def __init__(self, joint: Any, nodes: IsotropicField, start: Floats) -> None:
        self._joint = joint
        self._index = np.arange(3 * joint.patches).reshape(-1, 3)
        self.displacement = start.copy()
        self._origin = start[self._index]
        self._rests = nodes.field.separations
        self.state = nodes.start(energies=True)
        self.rounds, self.error = 0, 0.0
        self._scale = float(joint.bolt_tension.max())

    def _rest(self, stiffness: Floats, pull: Floats, x: Floats) -> tuple[Floats, Any]:
        moved = x[self._index] - self._origin
        answer = self.state.try_(moved[:, :2], separations=self._rests + moved[:, 2])
        rest = stiffness @ x - pull
        rest[self._index] += np.column_stack([answer.force, -answer.load])
        return rest, answer.tangent

    def settle(self, stiffness: Floats, start: Floats, pull: Floats, halvings: int = 6) -> None:
        """Go from a balance to that under other forces, half way first where that is too far."""
        size = self._balance(stiffness, pull)
        if size <= _ENOUGH:
            self.state.commit()
            self.displacement, self.error = self._found, size
            return
        if not halvings:
            raise InputError(
                f"steps must be more: as a bolt is tightened {size:.1e} of the largest tension "
                "stays unbalanced"
            )
        middle = 0.5 * (start + pull)
        self.settle(stiffness, start, middle, halvings - 1)
        self.settle(stiffness, middle, pull, halvings - 1)

    def _balance(self, stiffness: Floats, pull: Floats) -> float:
        """Newton's method with shortened steps: what is left unbalanced of the largest tension."""
        x = self.displacement
        rest, tangent = self._rest(stiffness, pull, x)
        size = float(abs(rest).max())
        for _ in range(_ROUNDS):
            if size < _BALANCED * self._scale:
                break
            matrix = stiffness.copy()
            signed = tangent * np.array([1.0, 1.0, -1.0])[:, None]
            matrix[self._index[:, :, None], self._index[:, None, :]] += signed
            step = np.linalg.lstsq(matrix, -rest, rcond=1e-15)[0]
            for share in 0.5 ** np.arange(_SHORTENINGS):
                try:
                    trial, slope = self._rest(stiffness, pull, x + share * step)
                except InputError:  # nearer than the sliders reach
                    continue
                if abs(trial).max() < size:
                    break
            else:
                break
            x, rest, tangent = x + share * step, trial, slope
            size, self.rounds = float(abs(rest).max()), self.rounds + 1
        self._rest(stiffness, pull, x)
        self._found = x
        return size / self._scale
