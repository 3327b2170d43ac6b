"""Contact nodes that slip and open, as elements of other solvers."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip.friction import Interface, JointField
from microslip.friction.vector_cycles import SETTLED


class ContactNodes:
    """Nodes of a field under tangential displacements and the opening of the contact.

    The components of motion and force of a node are one or two tangential ones, then the opening.
    At zero opening the separations are the ``gaps`` of the field, or those at rest if it has none.
    All nodes are evaluated in one call of the compiled kernel.

    Parameters
    ----------
    field : JointField
        The nodes.
    directions : int
        Number of components per node [-]: 2 (one tangential and the opening; cycles are computed
        without time samples) or 3 (two tangential and the opening; cycles are sampled in time).
    sliders, nearest : optional
        See :meth:`microslip.JointField.two_directions`; used only if ``directions`` is 3.
    balanced : bool
        Subtract the normal load at zero opening, so that forces are changes from it.
    tolerance : float, optional
        Largest estimated difference of computed forces from exactly periodic ones, relative to the
        force limit [-]; used only if ``directions`` is 3.

    Attributes
    ----------
    converged : ndarray of bool
        True for each node whose ``residual`` is within the tolerance, shape (nodes,).
    residual : ndarray
        Estimated error of the last forces [N], see :class:`microslip.FieldHarmonics`.
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
        self._preload = field.load(self._zero)[0] if balanced else np.zeros(field.size)
        self.rest_at(np.zeros((field.size, directions)))

    def rest_at(self, motion: Floats) -> None:
        """Start all nodes without tangential force at given motions [m] (nodes, directions)."""
        self._begin, opened = motion[:, :-1].copy(), motion[:, -1]
        field = self.field
        if opened.any() or field.gaps is not None:
            field = field.at(separations=self._zero + opened)
        self._law: Any = field if self.directions == 2 else field.two_directions(**self._options)
        self._state = self._law.start()

    @property
    def resolution(self) -> Floats:
        """Amplitude [m] below which nodes do not dissipate, shape (nodes,); 0 without sliders."""
        if self.directions == 2:
            return np.zeros(self.field.size)
        return np.asarray(self._law.resolution)

    def harmonics(self, motion: Floats, numbers: list[int], samples: int) -> tuple[Floats, Floats]:
        """Return Fourier coefficients of the settled forces [N] and their Jacobian [N/m].

        Motion [m] and forces have the shape (nodes, directions, coefficients), the Jacobian (nodes,
        directions, directions, coefficients, coefficients). ``numbers`` are the orders of the
        harmonics, 0 first. ``samples`` per period are used only with three directions.
        """
        if 0 not in numbers:
            raise InputError(f"harmonics of a contact must begin with the mean, 0, got {numbers}")
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
        force[:, -1, 0] += self._preload
        jacobian[:, -1] *= -1.0
        return force, jacobian

    def step(self, motion: Floats, slides_freely: bool = False) -> tuple[Floats, Floats]:
        """Return forces [N] of a trial motion, shape (nodes, directions), and their tangents [N/m].

        The tangents have the shape (nodes, directions, directions). With ``slides_freely`` there is
        no friction, and the trial cannot be committed.
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
        force[:, -1] = self._preload - load
        tangent[:, -1] *= -1.0
        return force, tangent

    def commit(self) -> None:
        """Make the last trial of :meth:`step` the state of the nodes."""
        self._state.commit()


def contact_field(law: Any) -> Any:
    """Return an Interface as a field with one node; return any other law unchanged."""
    if not isinstance(law, Interface):
        return law
    options: dict[str, Any] = {"areas": [1.0], "surface_area": 1.0}
    return JointField(
        law.surface, law.friction_coefficient, separations=[law.separation], **options
    )
