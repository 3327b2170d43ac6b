"""Nodes of a field that slip and open, as elements of other solvers."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip.friction import Interface, JointField
from microslip.friction.vector_cycles import SETTLED


class ContactNodes:
    """The nodes of a field under tangential displacements and the opening of the contact.

    Motions and forces of a node stand in the order tangential, [tangential,] opening. An opening of
    zero is where the field was defined: at its gaps, or else where it rests. All nodes are one
    compiled call.

    Parameters
    ----------
    field : JointField
        The nodes.
    directions : int
        Directions of a node [-]: 2, then there are no samples, or 3.
    sliders, nearest : optional
        As of :meth:`microslip.JointField.two_directions`, for three directions.
    balanced : bool
        Whether the load at an opening of zero is taken off.
    tolerance : float, optional
        Error of the settled forces over the force limit [-], for three directions.

    Attributes
    ----------
    converged : ndarray of bool
        Whether each node of the last call of :meth:`harmonics` has settled, shape (nodes,).
    residual : ndarray
        Estimated distance of its forces from those of the limit cycle [N], shape (nodes,).
    """

    def __init__(
        self, field: Any, directions: int, sliders: int, nearest: float | None, balanced: bool,
        tolerance: float = SETTLED,
    ) -> None:  # fmt: skip
        if not isinstance(field, JointField):
            raise InputError(f"`field` must be a JointField, got {show(field)}")
        self.field, self.directions = field, directions
        self._options: dict[str, Any] = {"sliders": sliders, "nearest": nearest}
        self._tolerance = positive("tolerance", tolerance, example=SETTLED)
        self.converged, self.residual = np.ones(field.size, dtype=bool), np.zeros(field.size)
        self._zero = field.separations if field.gaps is None else field.gaps
        self._taken_off = field.load(self._zero)[0] if balanced else np.zeros(field.size)
        self.rest_at(np.zeros((field.size, directions)))

    def rest_at(self, motion: Floats) -> None:
        """Put all nodes at rest, without tangential forces, at motions [m] (nodes, directions)."""
        self._begin, opened = motion[:, :-1].copy(), motion[:, -1]
        field = self.field
        if opened.any() or field.gaps is not None:
            field = field.at(separations=self._zero + opened)
        self._law: Any = field if self.directions == 2 else field.two_directions(**self._options)
        self._state = self._law.start()

    @property
    def resolution(self) -> Floats:
        """Resolution of motion in two directions [m]; zeros where there are no sliders."""
        if self.directions == 2:
            return np.zeros(self.field.size)
        return np.asarray(self._law.resolution)

    def harmonics(self, motion: Floats, numbers: list[int], samples: int) -> tuple[Floats, Floats]:
        """Coefficients of settled forces [N] (nodes, directions, coefficients), and derivatives.

        The motion [m] has that shape, the Jacobian [N/m] (nodes, directions, directions,
        coefficients, coefficients). Only three directions take samples.
        """
        if 0 not in numbers:
            raise InputError(
                f"harmonics of a contact must begin with the mean, 0, got {numbers}: "
                "it holds the separation"
            )
        separations = motion[:, -1].copy()
        separations[:, 0] += self._zero
        place = motion[:, :-1].copy()
        place[:, :, 0] -= self._begin
        if self.directions == 2:
            found = self._law.harmonics(place[:, 0], numbers, separations=separations)
            tangential = found[0][:, None]
        else:
            found = self._law.harmonics(
                place,
                numbers,
                separations=separations,
                samples=samples,
                tolerance=self._tolerance,
            )
            tangential = found[0]
        self.converged, self.residual = found.converged, found.residual
        force, jacobian = np.concatenate((tangential, -found[1][:, None]), axis=1), found[2]
        force[:, -1, 0] += self._taken_off
        jacobian[:, -1] *= -1.0
        return force, jacobian

    def step(self, motion: Floats, slides_freely: bool = False) -> tuple[Floats, Floats]:
        """Forces [N] of a trial (nodes, directions), and tangents [N/m] (nodes, directions twice).

        Without friction where they slide freely; then there is nothing to commit.
        """
        force = np.zeros(motion.shape)
        tangent = np.zeros((*motion.shape, self.directions))
        separations = self._zero + motion[:, -1]
        if slides_freely:
            load, tangent[:, -1, -1] = self.field.load(separations)
        else:
            place = motion[:, :-1] - self._begin
            if self.directions == 2:
                place = place[:, 0]
            pulled, load, slopes = self._state.try_(place, separations=separations)
            force[:, :-1], tangent = pulled.reshape(len(pulled), -1), slopes.copy()
        force[:, -1] = self._taken_off - load
        tangent[:, -1] *= -1.0
        return force, tangent

    def commit(self) -> None:
        """Make the last trial part of the history."""
        self._state.commit()


def contact_field(law: Any) -> Any:
    """A field of one node that stands where an Interface does; anything else as it is."""
    if not isinstance(law, Interface):
        return law
    options: dict[str, Any] = {"areas": [1.0], "surface_area": 1.0}
    return JointField(
        law.surface, law.friction_coefficient, separations=[law.separation], **options
    )
