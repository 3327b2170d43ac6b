"""Settled cycles of the nodes of a field."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip.friction.field_cycles import FieldCycle, periodic
from microslip.friction.field_cycles import harmonics as transform
from microslip.friction.field_nodes import FieldNodes


class SettledField:
    """Settled cycles and harmonics of nodes, as :class:`microslip.JointField` has them."""

    def periodic(
        self: FieldNodes,
        displacements: ArrayLike,
        separations: ArrayLike | None = None,
        rest: ArrayLike | str = 0.0,
    ) -> FieldCycle:
        """The settled cycles of all nodes.

        Parameters
        ----------
        displacements : array_like
            One period of displacements [m], its first sample not repeated, shape (nodes, samples),
            or (samples,) for all nodes alike.
        separations : array_like, optional
            Separations [m] at the same samples; without them the nodes stay at their own. Contact
            may be lost and found again.
        rest : array_like or "mean", optional
            Displacements [m] at which the nodes rest without a force, one number or one a node,
            or the mean of each cycle. With a mean displacement the settled mean force depends on
            it.

        Returns
        -------
        FieldCycle
            ``force`` and ``load`` [N], ``stiffness`` [N/m] and ``derivative``, see there.

        Raises
        ------
        InputError
            Another shape, not finite, separations outside a table.

        Notes
        -----
        Each node goes from rest in a straight line of (separation, displacement) to the sample
        where separation + |displacement|/kappa is largest; there all other memory is gone, and the
        cycle that begins there has settled. Where that path pressed new contact down sticking, one
        more cycle follows. It does not matter with which sample a cycle begins.
        """
        return periodic(self, displacements, separations, rest)

    def harmonics(
        self: FieldNodes,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        separations: ArrayLike | None = None,
        rest: ArrayLike | str = 0.0,
        samples: int = 64,
    ) -> tuple[Floats, ...]:
        """Fourier coefficients of the settled forces with their Jacobians: balance of harmonics.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of the displacements [m], shape (nodes, coefficients), or one row for all,
            in the order of ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        harmonics : sequence of int, optional
            Numbers of the harmonics, rising; 0 is the mean.
        separations : array_like, optional
            Coefficients of the separations [m], of the same shape; without them the nodes stay at
            their own. Their mean is the mean separation, not its change.
        rest : array_like or "mean", optional
            As for :meth:`periodic`.
        samples : int, optional
            Equidistant samples of the period [-]. The coefficients are those of the sampled cycle,
            and the Jacobian is exactly theirs; what sampling costs falls with the square of their
            number: see the notes.

        Returns
        -------
        force : ndarray
            Coefficients of the forces [N], shape (nodes, coefficients).
        load : ndarray
            Those of the normal loads [N], only with ``separations``.
        jacobian : ndarray
            Derivatives [N/m] of force coefficients (rows) by displacement coefficients (columns),
            shape (nodes, coefficients, coefficients). With ``separations`` the shape is (nodes,
            2, 2, coefficients, coefficients): those of (force, load) by (displacement, separation).

        Raises
        ------
        InputError
            Another shape, not finite, harmonics that do not rise, too few samples for them,
            separations outside a table.

        Notes
        -----
        The derivative runs down the tree of reversals. Samples miss the true turning points by up
        to half a step, which is the error of second order.
        """
        return transform(self, coefficients, harmonics, separations, rest, samples)
