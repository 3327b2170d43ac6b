"""Extended Greenwood Model of an interface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip import contact as normal
from microslip._core.checks import (
    LARGEST,
    Floats,
    check_one_of,
    exact,
    floats,
    number,
    plain,
    positive,
)
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.kernels.table import PolynomialTable
from microslip._core.parameters import parameter
from microslip.contact.base import FAINTEST, NormalLaw
from microslip.contact.load_curve import check_surface
from microslip.contact.validity import Verdict, surface_verdicts
from microslip.friction.coupled import CoupledLaw
from microslip.friction.cycles import Rest
from microslip.friction.parameter_derivatives import derivatives_by_parameters
from microslip.friction.sliders import Sliders


@dataclass(frozen=True, eq=False)
class Interface(CoupledLaw):
    """Jointed interface: a surface, a coefficient of friction and a constant normal load.

    Parameters
    ----------
    surface : NormalLaw
        Normal load law, e.g. a :class:`microslip.GreenwoodWilliamson` surface.
    friction_coefficient : float
        Coulomb's coefficient mu [-], above zero, the same for all contacts.
    normal_load : float, optional
        Normal load N [N], above zero.
    separation : float, optional
        Separation d [m], given instead of the load. The surface must carry a load there.
    direction : float, optional
        Direction of motion [rad] from the x axis of the scan, for a measured surface. The joint
        uses ``surface.along(direction)``.

    Notes
    -----
    All summits have the same displacement. The slip limit of each summit is kappa times its
    indentation, with kappa = mu E*/(4 G*) (19.12). The sum of the backbones (19.15) of all summits,
    whatever their heights, is a difference of two normal loads, T0(delta) = mu [N(d) - N(d +
    delta/kappa)] (Jaeger 1998, DOI 10.1115/1.2833765; Ciavarella 1998, J. Appl. Mech. 65, 998), odd
    in delta. The force along any history follows by Masing's rule: (19.13)-(19.14), (19.16)-(19.17)
    and (19.19)-(19.24) of chapter 19 (DOI 10.1007/978-3-319-56818-8_19), with misprints corrected,
    for any record.
    """

    surface: NormalLaw
    friction_coefficient: float = field(
        metadata=parameter(
            "mu",
            meaning="coefficient of friction",
            above=0.0,
            example=0.55,
        )
    )
    # Both are set by __post_init__.
    normal_load: float = field(
        default=None,  # type: ignore[assignment]
        metadata=parameter("N", "N", "normal load", above=0.0),
    )
    separation: float = field(
        default=None,  # type: ignore[assignment]
        metadata=parameter("d", "m", "separation of the mean planes"),
    )

    direction: InitVar[float | None] = None

    def __post_init__(self, direction: float | None) -> None:
        check_surface(self.surface)
        if direction is not None:
            assign(self, surface=self.surface.along(direction))
        friction = positive("friction_coefficient", self.friction_coefficient)
        load, separation = self.normal_load, self.separation
        check_one_of("normal_load [N] or separation [m]", load, separation)
        if separation is None:
            load = positive("normal_load", load, "N")
            assign(self, surface=self.surface._under(load))
            separation = self.surface.separation(load)
        else:
            separation = number("separation", separation, "m")
            load = self.surface.load(separation)
            if load < FAINTEST:
                where = "there is no contact" if load <= 0.0 else f"the load is {load:g} N"
                raise InputError(
                    "`separation` must be one at which the surface carries a load, got "
                    f"{separation:g} m, where {where}"
                )
        assign(self, friction_coefficient=friction, normal_load=load, separation=separation)

    def at(self, *, normal_load: float | None = None, separation: float | None = None) -> Interface:
        """Return the same joint at another normal load [N] or separation [m]."""
        return Interface(
            self.surface,
            self.friction_coefficient,
            normal_load=normal_load,  # type: ignore[arg-type]
            separation=separation,  # type: ignore[arg-type]
        )

    @property
    def force_limit(self) -> float:
        """Force of gross slip mu N [N]."""
        return self.friction_coefficient * self.normal_load

    @cached_property
    def normal_stiffness(self) -> float:
        """Normal stiffness k_n = -N'(d) [N/m]."""
        stiffness: float = self.surface.stiffness(self.separation)
        return stiffness

    @cached_property
    def tangential_stiffness(self) -> float:
        """Tangential stiffness at rest k_t = 4 (G*/E*) k_n [N/m] (Mindlin 1949)."""
        return self.normal_stiffness / self.surface.stiffness_ratio

    @cached_property
    def contact_count(self) -> float | None:
        """Number of summits in contact (19.6), None for a surface without summits."""
        return self._surface_value("contact_count")

    @cached_property
    def contact_area(self) -> float | None:
        """Real contact area [m^2] (19.7), None for a surface that does not define it."""
        return self._surface_value("contact_area")

    def _surface_value(self, name: str) -> float | None:
        try:
            value: float = getattr(self.surface, name)(self.separation)
        except InputError:
            return None
        return value

    @property
    def slip_scale(self) -> float:
        """Displacement scale of the transition from sticking to sliding [m].

        It is the slip per indentation times the standard deviation of the heights (or another
        measure of their width, if that is infinite). For a surface without heights it is the force
        limit over the stiffness at rest.
        """
        return self._slip_scale[0]

    @property
    def _slip_scale(self) -> tuple[float, str]:
        measure = self.surface._slip_measure()
        if measure is None:
            return super()._slip_scale
        return self.slip_per_indentation * measure[0], f"slip_per_indentation * {measure[1]}"

    @property
    def standardised_separation(self) -> float | None:
        """Separation over the standard deviation of the heights [-]; None without heights."""
        return self.surface._standardised(self.separation)

    @property
    def validity(self) -> tuple[Verdict, ...]:
        """Verdicts on whether the assumptions of the model hold for this joint."""
        return surface_verdicts(self.surface, self.separation)

    def stick_area(self, displacement: ArrayLike) -> Any:
        """Compute the contact area [m^2] that still sticks on first loading.

        It is the sum of the areas pi c^2 of the stick circles (19.9), with c^2 = rho (s -
        delta/kappa). Displacements delta [m] from rest have any sign and any shape, which is that
        of the result. For the area that has not slipped since a reversal, use half the distance
        from the reversal as ``displacement``; at zero force this gives (19.18).
        """
        x = floats("displacement", displacement, "m")
        place = np.minimum(np.abs(x), LARGEST * min(self.slip_per_indentation, 1.0))
        area = self.surface.contact_area(self.separation + place / self.slip_per_indentation)
        return plain(np.asarray(area))

    def _steps(self, u: Floats) -> Floats:
        """Convert displacements u to increases u/kappa of separation [m], without overflow."""
        return np.minimum(u, 1e200) / self.slip_per_indentation

    def _exact_backbone(self, u: Floats) -> Floats:
        # (19.28), the sum of (19.15) over all asperities, as the difference of two loads (19.8).
        force = self._friction * self.surface._drop(self.separation, self._steps(u))
        return np.minimum(force, self.force_limit)  # remove rounding above the limit

    def _exact_energy(self, amplitude: Floats) -> Floats:
        kappa = self.slip_per_indentation
        excess = self.surface._excess(self.separation, amplitude / kappa)
        return 8.0 * self._friction * kappa * excess

    @cached_property
    def _full_slip(self) -> float | None:
        """Displacement [m] of gross slip, where tables of T0 and E_d end; None without tables."""
        reach = self.surface._table_reach(self.separation)
        return None if reach is None else reach * self.slip_per_indentation

    @cached_property
    def _table(self) -> PolynomialTable | None:
        if self._full_slip is None:
            return None
        return PolynomialTable.sample(
            lambda u: self._exact_backbone(u) / u, self._full_slip, 1, self.force_limit
        )

    @cached_property
    def _energy_table(self) -> PolynomialTable | None:
        if self._full_slip is None:
            return None
        last = float(self._exact_energy(np.array([self._full_slip]))[0])
        # Beyond full slip dE_d/da = 4 mu N.
        return PolynomialTable.sample(
            lambda u: self._exact_energy(u) / u**3,
            self._full_slip,
            3,
            last,
            4.0 * self.force_limit,
            tolerance=1e-12,  # at large u the energy is a small difference of large numbers
        )

    def _backbone(self, u: Floats) -> Floats:
        return self._exact_backbone(u) if self._table is None else self._table.value(u)

    def _slope(self, u: Floats) -> Floats:
        factor = self._friction / self.slip_per_indentation
        return factor * self.surface._fall(self.separation, self._steps(u))

    def _backbone_at(self, u: float) -> tuple[float, float]:
        step = min(u, 1e200) / self.slip_per_indentation
        factor = self._friction / self.slip_per_indentation
        if self._table is None:
            if self.surface._spheres is None and self.surface._spline is None:
                return super()._backbone_at(u)
            curve = self._load_curve.scalar
            force = min(self._friction * curve.drop(0.0, step), self.force_limit)
            slope = factor * curve.load(step)[1]
            if slope < 1e-3 * self.tangential_stiffness:
                # Next to full slip it depends on the last place of the step: as in `_slope`.
                slope = factor * float(self.surface._fall(self.separation, np.array([step]))[0])
            return force, slope
        slope = -self.surface._derivative_at(self.separation + step, 1)
        return self._table.at(u)[0], factor * slope

    def _energy(self, amplitude: Floats) -> Floats:
        if self._energy_table is None:
            return self._exact_energy(amplitude)
        return self._energy_table.value(amplitude)

    def _energy_slope(self, amplitude: Floats) -> Floats:
        steps = amplitude / self.slip_per_indentation
        slope = self.surface._excess_slope(self.separation, steps)
        return 8.0 * self._friction * slope

    def _slider_density(self, u: Floats) -> Floats:
        kappa = self.slip_per_indentation
        curvature = self.surface._derivative(self.separation + u / kappa, 2)
        return self._friction / kappa**2 * curvature

    @property
    def _small_amplitude_exponent(self) -> float:
        return 3.0 if float(self._slider_density(np.zeros(1))[0]) > 0.0 else math.nan

    @cached_property
    def _kinks(self) -> Floats:
        places = self.surface._kinks
        if self.surface._spheres is not None:
            places = self.surface._spheres.heights
        steps = np.unique(places) - self.separation
        return self.slip_per_indentation * steps[steps > 0.0]

    def parameter_derivatives(
        self,
        quantity: str,
        at: ArrayLike,
        names: Sequence[str] | None = None,
        *,
        harmonics: Any = (0, 1),
        rest: Rest = 0.0,
    ) -> dict[str, Any]:
        """Compute exact derivatives of a response with respect to parameters of the joint.

        Parameters
        ----------
        quantity : str
            ``backbone``, ``force`` (along a history), ``periodic`` (the settled force), or
            ``harmonics`` [N]; ``dissipated_energy`` [J] of a closed cycle.
        at : array_like
            For ``force``, ``periodic`` and ``harmonics``: displacement histories, cycles or Fourier
            coefficients [m] along the last axis. Else displacements or amplitudes [m], any shape.
        names : sequence of str, optional
            Parameters, all by default: friction_coefficient and normal_load, and with a
            Greenwood-Williamson surface std (a scale of all heights), radius, density, area,
            young_modulus and poisson_ratio. If the two materials differ, young_modulus and
            poisson_ratio are those of the first body; the second body has other_young_modulus and
            other_poisson_ratio.
        harmonics, rest
            See :meth:`harmonics`.

        Returns
        -------
        dict of str to float or ndarray
            Derivative with respect to each parameter, shape of ``at``, in the unit of the quantity
            divided by the unit of the parameter. The load is constant, so the separation changes
            with the surface parameters.

        Notes
        -----
        The branches of a response depend on the displacement alone (Masing's rules; Jaeger 1998,
        DOI 10.1115/1.2833765), and the force on each is linear in the backbone T0. Its derivative
        with respect to a parameter p is therefore the force of a law with the backbone dT0/dp.
        """
        return derivatives_by_parameters(self, quantity, at, names, harmonics, rest)

    def sliders(self) -> Sliders:
        """Return the interface as a parallel Iwan model (Iwan 1966, DOI 10.1115/1.3625199).

        The density is -T0'' = (mu/kappa^2) N''(d + u/kappa) [N/m^2]. There are discrete sliders
        only where N' jumps, as in a piecewise-linear table.
        """
        places, jumps = self.surface._corners(self.separation)
        kappa = self.slip_per_indentation
        return Sliders(kappa * places, self._friction / kappa * jumps, self._slider_density)

    def __repr__(self) -> str:
        return (
            f"Interface({type(self.surface).__name__}, "
            f"friction_coefficient={exact(self.friction_coefficient)}, "
            f"normal_load={exact(self.normal_load)}, separation={self.separation:g})"
        )

    @classmethod
    @cache
    def examples(cls) -> tuple[Interface, ...]:
        """Return joints on each kind of surface, at light and heavy loads.

        The first is the worked example, the milled Al 2017 pair at 2 kN.
        """
        joints = [cls(law, 0.55, 2000.0) for law in normal.NORMAL_LAWS[0].examples()[:1]]
        for law in normal.NORMAL_LAWS:
            for surface in law.examples():
                largest = surface.load(surface._span[0])
                # For bounded heights, include a load at which every summit is in contact.
                heavy = 3.0 if surface._edge == surface._span[0] else 0.3
                heavy = min(heavy, surface._heaviest / largest)
                joints += [cls(surface, 0.3, share * largest) for share in (heavy, 1e-3, 1e-6)]
        return tuple(joints)
