"""An interface whose normal load varies while it moves: a node by itself on its load curve."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, check_one_of, exact, floats, is_whole, record, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip.contact.base import NormalLaw
from microslip.contact.load_curve import LoadCurve
from microslip.friction.base import BackboneLaw
from microslip.friction.coupled_cycles import (
    CoupledCycle,
    CoupledHarmonics,
    coupled_cycle,
    coupled_harmonics,
)
from microslip.friction.cycles import PeriodicResponse, Rest
from microslip.friction.harmonics import HarmonicForce
from microslip.friction.memory import Diagram, Nodes, steps_along
from microslip.friction.straight_step import FirstLoading, loaded


@dataclass(frozen=True, eq=False)
class CoupledResponse(Locked):
    """A history of an interface under displacement and normal load, one entry a sample.

    Made by :meth:`microslip.Interface.coupled_response`, after Jaeger (1998),
    DOI 10.1115/1.2833765.
    """

    displacement: Floats
    """Displacements [m]."""
    force: Floats
    """Tangential forces [N]; 0 where the load is so light that it cannot matter.

    Heights without an end carry some load at any separation. Less than about 1e-30 of the largest
    load of the history counts as none.
    """
    normal_load: Floats
    """Normal loads [N]."""
    separation: Floats
    """Separations [m]."""
    _curve: LoadCurve
    _steps: Floats
    """Separations from the joint's own [m]."""

    @cached_property
    def energy_per_step(self) -> Floats:
        """Energy dissipated on the way to each sample [J], from rest or from the one before."""
        return lock(Diagram().losses(self._steps, self.displacement, self._curve))

    @cached_property
    def dissipated_energy(self) -> Floats:
        """Energy dissipated up to each sample [J], from rest; it never falls.

        Once a periodic history has settled, the rise over a cycle is the area of its loop. In the
        first cycles the area also holds energy that is stored.
        """
        return lock(np.cumsum(self.energy_per_step))

    def energy_per_cycle(self, samples_per_cycle: int) -> Floats:
        """Energy dissipated [J] in each cycle of a periodic history.

        Cycles of so many samples are counted back from the last sample; those that begin at a
        sample, whole, count. Once the history has settled each entry is the area of its loop.
        """
        count, first = self._cycles(samples_per_cycle)
        return np.asarray(self.energy_per_step[first + 1 :].reshape(-1, count).sum(axis=1))

    def ratcheting(self, samples_per_cycle: int) -> Floats:
        """Net displacement [m] in each cycle of a periodic history.

        Under force control a load that varies moves a joint on: contacts slip when it is light.
        Where the entries fade to rounding the joint has settled; where they do not, it ratchets,
        which near gross slip is physical. Cycles and errors as :meth:`energy_per_cycle`; what comes
        before the first whole cycle is left out.
        """
        count, first = self._cycles(samples_per_cycle)
        return np.diff(self.displacement[first::count])

    def _cycles(self, samples_per_cycle: int) -> tuple[int, int]:
        """Samples in a cycle, checked, and the sample at which the first whole cycle begins."""
        if not is_whole(samples_per_cycle):
            raise InputError(
                f"`samples_per_cycle` must be a whole number, got {show(samples_per_cycle)}"
            )
        count, size = int(samples_per_cycle), self.displacement.size
        if not 0 < count < size:
            raise InputError(
                f"`samples_per_cycle` must be above zero and below the {size} samples there are, "
                f"got {count}"
            )
        return count, (size - 1) % count


class CoupledLaw(BackboneLaw):
    """A law whose backbone comes from a load curve, so that its load may vary: an Interface."""

    # Fields of the interface.
    surface: NormalLaw
    friction_coefficient: float
    normal_load: float
    separation: float

    @cached_property
    def slip_per_indentation(self) -> float:
        """Kappa = mu E*/4G* [-]: slip limit of a contact over its indentation (19.12)."""
        return self.friction_coefficient * self.surface.stiffness_ratio

    @cached_property
    def _friction(self) -> float:
        """The coefficient of friction, with it the limit mu N is met exactly.

        Next to the highest of given summits a separation in double precision is so coarse that the
        load it stands for is not to the last digit the one asked for.
        """
        return self.force_limit / self.surface._derivative_at(self.separation, 0)

    @cached_property
    def _coupling(self) -> LoadCurve:
        return LoadCurve(
            self.surface,
            self.separation,
            self.normal_load,
            friction=self._friction,
            slip=self.slip_per_indentation,
        )

    @cached_property
    def _nodes(self) -> Nodes:
        """The joint as a field of one."""
        curve, scale = self._coupling, np.ones(1)
        return Nodes(curve, curve.friction * scale, scale, curve.slip * scale, np.zeros(1))

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
        x = record("displacement", displacement, "m").reshape(-1)
        force = self._forces_along(x, self._steps_along(x.size, normal_load, separation))
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
        x = self._respond_to_force(force, normal_load, separation).displacement
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
            return self._respond_to_force(force, normal_load, separation)
        x = record("displacement", displacement, "m").reshape(-1)  # type: ignore[arg-type]
        steps = self._steps_along(x.size, normal_load, separation)
        return self._response(x, self._forces_along(x, steps), steps)

    def _steps_along(self, size: int, normal_load: Any, separation: Any) -> Floats:
        """Separations from the joint's own along a history."""
        check_one_of("normal_load=... [N] or separation=... [m]", normal_load, separation)
        return steps_along(self._coupling, size, normal_load, separation)

    def _forces_along(self, x: Floats, steps: Floats) -> Floats:
        with np.errstate(over="ignore"):  # beyond 1e200 slips there is no more to come
            places = x / self._coupling.slip
        np.clip(places, -1e200, 1e200, out=places)
        values = Diagram().respond(steps, places, self._coupling)
        values *= self._coupling.friction
        return values

    def _respond_to_force(
        self, force: ArrayLike, normal_load: Any, separation: Any
    ) -> CoupledResponse:
        f, curve = record("force", force, "N").reshape(-1), self._coupling
        steps = self._steps_along(f.size, normal_load, separation)
        # Of the loads as they were given: those of the separations differ from them by rounding.
        load = (
            curve.derivative(steps, 0)
            if normal_load is None
            else floats("normal_load", normal_load, "N")
        )
        limit = np.broadcast_to(self.friction_coefficient * load.reshape(-1), f.shape)
        beyond = np.flatnonzero(np.abs(f) >= limit)
        if beyond.size:
            i = int(beyond[0])
            raise InputError(
                "`force` must be below the force limit mu N in size (no displacement holds it "
                f"beyond), got {exact(f[i])} N at sample {i}, where the limit is {limit[i]:.10g} N"
            )
        places = Diagram().hold(steps, f / curve.friction, curve)
        return self._response(curve.slip * places, f, steps)

    def _response(self, x: Floats, force: Floats, steps: Floats) -> CoupledResponse:
        curve = self._coupling
        arrays = x.copy(), np.array(force), curve.derivative(steps, 0), steps + curve.origin
        displacement, forces, load, separation = map(lock, arrays)
        return CoupledResponse(displacement, forces, load, separation, curve, lock(steps))

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
        check_one_of("normal_load=... [N] or separation=... [m]", normal_load, separation)
        return coupled_cycle(self._nodes, displacement_cycle, rest, normal_load, separation)

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
        samples: int | None = None,
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
        samples: int | None = None,
    ) -> HarmonicForce | CoupledHarmonics:
        """Fourier coefficients of the settled forces with their Jacobian: harmonic balance.

        Parameters
        ----------
        coefficients, harmonics, rest, rtol
            As of :meth:`BackboneLaw.harmonics`. The tolerance is met at a constant load and for
            separations; a load that is given is sampled.
        normal_load, separation : array_like, optional
            Coefficients of the normal load [N] or the separation [m] in the same order, one of
            them; without them the load is constant. Without harmonic 0 their mean is 0.
        samples : int, optional
            Equidistant samples of the period [-] under a varying load, 256 for a ``normal_load``.
            Without it, a varying separation has none.

        Returns
        -------
        HarmonicForce or CoupledHarmonics
            At a constant load ``force`` [N] and ``jacobian`` [N/m]; under a varying one ``force``
            and ``normal_load`` [N], and the ``jacobian`` of both by both, shape (2, 2, n, n).

        Notes
        -----
        Under a ``separation`` the cycle is cut where it turns and where separation or slip front
        meet an end, a summit or a knot of a table, and integrated piece by piece. Under a
        ``normal_load`` the path between samples is straight: the error falls with the square of
        their number, some 4e-5 of the force limit with 256. The Jacobian is exactly that of the
        sampled cycle.
        """
        if normal_load is None and separation is None:
            return super().harmonics(coefficients, harmonics, rest, rtol=rtol)
        return coupled_harmonics(
            self._nodes, coefficients, harmonics, rest, normal_load, separation, samples, rtol
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
