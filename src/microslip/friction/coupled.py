"""Interface under a varying normal load, computed by the routines for fields of contact nodes.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, check_one_of, exact, floats, record
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip.contact.base import NormalLaw
from microslip.contact.load_curve import LoadCurve
from microslip.friction.base import BackboneLaw
from microslip.friction.coupled_cycles import coupled_cycle, coupled_harmonics
from microslip.friction.cycles import Rest
from microslip.friction.memory import Diagram, Nodes, steps_along


@dataclass(frozen=True, eq=False)
class CoupledResponse(Locked):
    """Response of an interface to a history of displacement and normal load, one entry per sample.

    Result of :meth:`microslip.Interface.coupled_response`, after Jaeger (1998),
    DOI 10.1115/1.2833765.
    """

    displacement: Floats
    """Displacements [m]."""
    force: Floats
    """Tangential forces [N]; 0 where the load is negligible.

    Unbounded heights carry some load at any separation. A load below about 1e-30 of the largest
    load of the history is treated as zero.
    """
    normal_load: Floats
    """Normal loads [N]."""
    separation: Floats
    """Separations [m]."""
    _curve: LoadCurve
    _steps: Floats
    """Separations relative to that of the joint [m]."""

    @cached_property
    def energy_per_step(self) -> Floats:
        """Energy dissipated in each step [J]; the first step is from rest."""
        return lock(Diagram().losses(self._steps, self.displacement, self._curve))

    @cached_property
    def dissipated_energy(self) -> Floats:
        """Energy dissipated from rest up to each sample [J], nondecreasing.

        In a settled periodic history the increase over a cycle is the area of its loop. In the
        first cycles the area of the loop also includes stored energy.
        """
        return lock(np.cumsum(self.energy_per_step))


class CoupledLaw(BackboneLaw):
    """Base class of :class:`Interface`: laws with a load curve N(d), whose normal load may vary."""

    # Fields of the interface.
    surface: NormalLaw
    friction_coefficient: float
    normal_load: float
    separation: float

    @cached_property
    def slip_per_indentation(self) -> float:
        """Slip per indentation kappa = mu E*/(4 G*) [-]: slip limit over indentation (19.12)."""
        return self.friction_coefficient * self.surface.stiffness_ratio

    @cached_property
    def _friction(self) -> float:
        """Coefficient of friction mu N0/N(d) [-], with the given load N0 and its separation d.

        With it the force limit is exactly mu N0. Close to the highest summit N(d) differs from N0,
        since the separation d has too few digits to represent a light load.
        """
        return self.force_limit / self.surface._derivative_at(self.separation, 0)

    @cached_property
    def _load_curve(self) -> LoadCurve:
        return LoadCurve(
            self.surface,
            self.separation,
            self.normal_load,
            friction=self._friction,
            slip=self.slip_per_indentation,
        )

    @cached_property
    def _nodes(self) -> Nodes:
        curve, scale = self._load_curve, np.ones(1)
        return Nodes(curve, curve.friction * scale, scale, curve.slip * scale, np.zeros(1))

    def coupled_force(
        self,
        displacement: ArrayLike,
        *,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> Any:
        """Compute the force for a record of displacement and normal load.

        Exact within the theory of Cattaneo and Mindlin. The record starts from rest, at
        displacement 0 under the ``normal_load`` of the joint. Between samples the path of
        (separation, displacement) is straight, so a curved path needs enough samples. Contact may
        be lost and regained.

        Parameters
        ----------
        displacement : array_like
            Displacements [m] in time order, one-dimensional.
        normal_load : array_like, optional
            Normal loads [N], not negative: a number or one per sample.
        separation : array_like, optional
            Separations [m], given instead of the loads.

        Returns
        -------
        ndarray or float
            Forces [N], one for each sample.

        Notes
        -----
        The superposition of Jaeger (1998), DOI 10.1115/1.2833765, and Ciavarella (1998) is applied
        along the history by the method of memory diagrams (DOI 10.3389/fmech.2020.00030). Normal
        and tangential load are coupled only through the contact area. Results are approximate for
        dissimilar materials, and tractions across the direction of motion are neglected. The cost
        is amortised O(1) per sample. For unbounded heights a load below about 1e-30 of the largest
        load of the history is treated as zero, and the force is then 0.
        """
        x = record("displacement", displacement, "m").reshape(-1)
        force = self._forces_along(x, self._steps_along(x.size, normal_load, separation))
        return float(force[0]) if np.ndim(displacement) == 0 else force

    def coupled_response(
        self,
        displacement: ArrayLike | None = None,
        *,
        force: ArrayLike | None = None,
        normal_load: ArrayLike | None = None,
        separation: ArrayLike | None = None,
    ) -> CoupledResponse:
        """Compute forces or displacements, loads, separations and dissipated energies of a record.

        Either displacements [m] or forces [N] must be given. Forces must be below mu N at each
        sample, otherwise InputError is raised. A periodic history of forces settles in its first
        cycle unless the joint reaches gross slip; then it may ratchet, that is, advance in each
        cycle. Other parameters, shapes and errors are as for :meth:`coupled_force`. The result is a
        :class:`microslip.friction.CoupledResponse`.
        """
        check_one_of("displacement [m] or force=... [N]", displacement, force)
        if force is not None:
            return self._respond_to_force(force, normal_load, separation)
        x = record("displacement", displacement, "m").reshape(-1)  # type: ignore[arg-type]
        steps = self._steps_along(x.size, normal_load, separation)
        return self._response(x, self._forces_along(x, steps), steps)

    def _steps_along(self, size: int, normal_load: Any, separation: Any) -> Floats:
        check_one_of("normal_load=... [N] or separation=... [m]", normal_load, separation)
        return steps_along(self._load_curve, size, normal_load, separation)

    def _forces_along(self, x: Floats, steps: Floats) -> Floats:
        with np.errstate(over="ignore"):  # full slip long before the clipping limit
            places = x / self._load_curve.slip
        np.clip(places, -1e200, 1e200, out=places)
        values = Diagram().respond(steps, places, self._load_curve)
        values *= self._load_curve.friction
        return values

    def _respond_to_force(
        self, force: ArrayLike, normal_load: Any, separation: Any
    ) -> CoupledResponse:
        f, curve = record("force", force, "N").reshape(-1), self._load_curve
        steps = self._steps_along(f.size, normal_load, separation)
        # Use the given loads: those computed from the separations differ by rounding.
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
                "`force` must be below the force limit mu N in magnitude, got "
                f"{exact(f[i])} N at sample {i}, where the limit is {limit[i]:.10g} N"
            )
        places = Diagram().hold(steps, f / curve.friction, curve)
        return self._response(curve.slip * places, f, steps)

    def _response(self, x: Floats, force: Floats, steps: Floats) -> CoupledResponse:
        curve = self._load_curve
        arrays = x.copy(), np.array(force), curve.derivative(steps, 0), steps + curve.origin
        displacement, forces, load, separation = map(lock, arrays)
        return CoupledResponse(displacement, forces, load, separation, curve, lock(steps))

    def periodic(
        self,
        displacement_cycle: ArrayLike,
        rest: Rest = 0.0,
        *,
        separation: ArrayLike | None = None,
    ) -> Any:
        """Compute the settled cycle of a periodic displacement, with a constant or periodic load.

        Parameters
        ----------
        displacement_cycle, rest
            See :meth:`BackboneLaw.periodic`. The load at rest is that of the joint.
        separation : array_like, optional
            Separations [m] of the cycle, a number or one per sample, constant by default; those of
            given loads are ``surface.separation(normal_load)``.

        Returns
        -------
        PeriodicResponse or CoupledCycle
            PeriodicResponse with ``force`` [N], ``stiffness`` [N/m], ``parent`` and ``root`` for a
            constant load, otherwise CoupledCycle, which also has loads and separations. Both have
            ``derivative``. For a curved path the error is of second order in the sample spacing.
        """
        if separation is None:
            return super().periodic(displacement_cycle, rest)
        return coupled_cycle(self._nodes, displacement_cycle, rest, separation)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        rest: Rest = 0.0,
        *,
        rtol: float = 1e-10,
        separation: ArrayLike | None = None,
    ) -> Any:
        """Compute Fourier coefficients of force and load in the settled cycle, with their Jacobian.

        Parameters
        ----------
        coefficients, harmonics, rest, rtol
            See :meth:`BackboneLaw.harmonics`.
        separation : array_like, optional
            Coefficients of the separation [m] in the same order, constant by default. Without
            harmonic 0 the mean is 0.

        Returns
        -------
        HarmonicForce or CoupledHarmonics
            HarmonicForce with ``force`` [N] and ``jacobian`` [N/m] for a constant load, otherwise
            CoupledHarmonics with ``force`` and ``normal_load`` [N] and ``jacobian`` of shape (2, 2,
            coefficients, coefficients). ``jacobian[i, j, m, n]`` is the derivative of coefficient m
            of the force or the load (i = 0, 1) with respect to coefficient n of the displacement or
            the separation (j = 0, 1).

        Notes
        -----
        Contacts that first touch at separations between the current one and a larger one, the slip
        front, are slipping. The cycle is not sampled: it is cut at turning points and where the
        separation or the slip front passes a kink of the load curve (a summit, a knot of a table or
        the upper end of the heights), and integrated piece by piece.
        """
        if separation is None:
            return super().harmonics(coefficients, harmonics, rest, rtol=rtol)
        return coupled_harmonics(self._nodes, coefficients, harmonics, rest, separation, rtol)
