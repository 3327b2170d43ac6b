"""What a joint does under a normal load that varies."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import check_one_of
from microslip.friction.base import BackboneLaw
from microslip.friction.coupled import (
    CoupledResponse,
    Coupling,
    Joint,
    forces,
    respond,
    respond_to_force,
)
from microslip.friction.coupled_cycles import (
    CoupledCycle,
    CoupledHarmonics,
    coupled_cycle,
    coupled_harmonics,
)
from microslip.friction.cycles import PeriodicResponse, Rest
from microslip.friction.harmonics import HarmonicForce
from microslip.friction.straight_step import FirstLoading, loaded

if TYPE_CHECKING:  # what a joint has are fields or properties, as a law likes

    class _Law(BackboneLaw, Joint):
        @property
        def _coupling(self) -> Coupling: ...
else:
    _Law = BackboneLaw


class CoupledLaw(_Law):
    """A law whose backbone comes from a load curve, so that its load may vary: an Interface."""

    @cached_property
    def _coupling(self) -> Coupling:
        return Coupling(self)

    def coupled_force(
        self,
        displacement: ArrayLike,
        *,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> Any:
        """Force along a record of displacement and normal load, exact within Cattaneo-Mindlin.

        The record starts from rest, displacement 0 under the joint's own ``normal_load``, and moves
        between samples in straight lines of (separation, displacement); sample a curved path as
        finely as it asks for. Contact may be lost and found again.

        Parameters
        ----------
        displacement : array_like
            Displacements [m] in the order of time, one-dimensional.
        normal_load : array_like, optional
            Normal loads [N], not negative: one for each sample, or one number.
        separation : array_like, optional
            Separations [m] in their place.

        Returns
        -------
        ndarray or float
            Forces [N], one for each sample.

        Notes
        -----
        The superposition of Jaeger (1998), DOI 10.1115/1.2833765, and Ciavarella (1998) carried
        along the history: the method of memory diagrams (DOI 10.3389/fmech.2020.00030). Normal and
        tangential load are coupled through the contact area alone; dissimilar pairs and the shear
        across the direction of motion are approximate as in Cattaneo and Mindlin's theory.
        Amortised O(1) a sample. Where the heights have no end, a load of less than about 1e-30 of
        the largest of the history counts as none: the force is then 0.
        """
        force = forces(self, displacement, normal_load, separation)
        return float(force[0]) if np.ndim(displacement) == 0 else force

    def coupled_displacement(
        self,
        force: ArrayLike,
        *,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> Any:
        """Displacement along a record of force and normal load: the inverse of coupled_force.

        A load that varies moves a joint on under its force, since contacts slip when it is light.
        Below mu N a periodic history settles in its first cycle. In gross slip, where no force
        holds a displacement, a joint may ratchet, a step further each cycle: that is physical, and
        :meth:`microslip.friction.CoupledResponse.ratcheting` of a response reports it.

        Forces [N] are each below mu N at their sample, or an InputError; displacements come in [m].
        Parameters, shapes and errors are otherwise as :meth:`coupled_force` has them.
        """
        x = respond_to_force(self, force, normal_load, separation).displacement
        return float(x[0]) if np.ndim(force) == 0 else x.copy()

    def coupled_response(
        self,
        displacement: ArrayLike | None = None,
        *,
        force: ArrayLike | None = None,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> CoupledResponse:
        """All of a record of displacement [m] or force [N] and normal load, with its dissipation.

        Parameters, shapes and errors are as :meth:`coupled_force` and :meth:`coupled_displacement`
        have them; both or neither of displacement and force are an InputError.
        """
        check_one_of("displacement [m] or force=... [N]", displacement, force)
        if force is not None:
            return respond_to_force(self, force, normal_load, separation)
        return respond(self, displacement, normal_load, separation)  # type: ignore[arg-type]

    @overload
    def periodic(self, displacement_cycle: ArrayLike, rest: Rest = 0.0) -> PeriodicResponse: ...

    @overload
    def periodic(
        self,
        displacement_cycle: ArrayLike,
        rest: Rest = 0.0,
        *,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> CoupledCycle: ...

    def periodic(
        self,
        displacement_cycle: ArrayLike,
        rest: Rest = 0.0,
        *,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> PeriodicResponse | CoupledCycle:
        """The settled cycle of a periodic displacement and, if it varies, normal load.

        Parameters
        ----------
        displacement_cycle, rest
            As of :meth:`BackboneLaw.periodic`; the joint began under its own load.
        normal_load, separation : array_like, optional
            Normal loads [N] or separations [m] of the cycle, as for :meth:`coupled_force`, one of
            them; without them the load is constant.

        Returns
        -------
        PeriodicResponse or CoupledCycle
            At a constant load ``force`` [N], ``stiffness`` [N/m], ``parent`` and ``root``; under a
            varying one a :class:`microslip.CoupledCycle`, also with loads and separations. Both
            have a ``derivative`` by whatever moves the cycle.

        Notes
        -----
        Between samples the path is straight in separation and displacement: a curved one is met to
        second order in its spacing.
        """
        if normal_load is None and separation is None:
            return super().periodic(displacement_cycle, rest)
        return coupled_cycle(self, displacement_cycle, rest, normal_load, separation)

    @overload
    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        rest: Rest = 0.0,
        *,
        rtol: float = 1e-10,
    ) -> HarmonicForce: ...

    @overload
    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        rest: Rest = 0.0,
        *,
        rtol: float = 1e-10,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
        samples: int = 256,
    ) -> CoupledHarmonics: ...

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        rest: Rest = 0.0,
        *,
        rtol: float = 1e-10,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
        samples: int = 256,
    ) -> HarmonicForce | CoupledHarmonics:
        """Fourier coefficients of the settled forces with their Jacobian: balance of harmonics.

        Parameters
        ----------
        coefficients, harmonics, rest, rtol
            As of :meth:`BackboneLaw.harmonics`; the tolerance is for a constant load.
        normal_load, separation : array_like, optional
            Coefficients of the normal load [N] or the separation [m] in the same order, one of
            them; without them the load is constant. Without harmonic 0 their mean is 0.
        samples : int, optional
            Equidistant samples of the period [-] under a varying load.

        Returns
        -------
        HarmonicForce or CoupledHarmonics
            At a constant load ``force`` [N] and ``jacobian`` [N/m]; under a varying one ``force``
            and ``normal_load`` [N], and the ``jacobian`` of both by both, shape (2, 2, n, n).

        Notes
        -----
        Under a load that varies the path between samples is straight: the error falls with the
        square of their number. The Jacobian is exactly that of the sampled cycle.
        """
        if normal_load is None and separation is None:
            return super().harmonics(coefficients, harmonics, rest, rtol=rtol)
        return coupled_harmonics(
            self, coefficients, harmonics, rest, normal_load, separation, samples
        )

    def first_loading(
        self,
        displacement: ArrayLike,
        *,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> FirstLoading:
        """Force, load and tangents after one straight step from rest at the joint's own load.

        Displacements [m], and either normal loads [N] above zero or separations [m], at the end of
        the step, of any shapes that go together. What comes back is that of
        :func:`microslip.friction.first_loading`, which takes the separations before the step, too,
        one for each node.
        """
        check_one_of("normal_load [N] or separation=... [m]", normal_load, separation)
        if separation is None:
            separation = self.surface.separation(normal_load)  # type: ignore[arg-type]
        slip, start = self.slip_per_indentation, self.separation
        return loaded(self.surface, self._friction, slip, displacement, separation, start)
