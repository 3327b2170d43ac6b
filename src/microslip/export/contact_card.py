"""Contact properties of a joint per unit area, as used by finite-element programs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip.friction import Interface, Jenkins

_POINTS = 38  # of the table: CalculiX 2.20 accepts at most 40 pairs
_BELOW, _ABOVE = 1e-2, 10.0  # first and last pressure of the table over the joint's
_BAND = 2.0  # errors are computed from half to twice the joint's pressure
_SLIPS = (0.1, 0.3, 1.0, 3.0, 10.0)  # amplitudes over the elastic slip, for the damping errors


@dataclass(frozen=True)
class VirtualLayer:
    """Layer of elements between the faces, equivalent to the joint at one slip amplitude."""

    thickness: float
    """Thickness [m]."""
    young_modulus: float
    """Young's modulus [Pa] in the normal direction, for Poisson's ratio 0."""
    shear_modulus: float
    """Transverse shear modulus [Pa] at the amplitude."""
    density: float | None
    """Mass density [kg/m^3], if given."""
    amplitude: float
    """Slip amplitude [m] for which the shear modulus and the loss factor hold."""
    loss_factor: float
    """Loss factor of the shear [-] at that amplitude."""


@dataclass(frozen=True)
class CardErrors:
    """Largest relative errors [-] of a contact card with respect to the joint."""

    pressure: float
    """Error of the interpolated pressure between the points of the table."""
    normal_stiffness: float
    """Error of a constant normal stiffness, from half to twice the pressure of the joint; that of a
    constant tangential stiffness is the same."""
    elastic_slip: float
    """Error of a tangential stiffness equal to mu p over the elastic slip, over the same pressures.
    """
    force: float
    """Error of the friction force of stick-slip contact at the elastic slip, where it is
    largest."""
    damping: tuple[tuple[float, float, float], ...]
    """Rows of amplitude [m], loss factor of the joint and loss factor of stick-slip contact [-]."""


@dataclass(frozen=True)
class ContactCard:
    """Contact properties of a joint per unit area, with their errors relative to the joint."""

    pressure: float
    """Mean pressure on the joint [Pa]."""
    friction_coefficient: float
    """Coulomb friction coefficient [-]."""
    normal_stiffness: float
    """Normal stiffness per area at that pressure [Pa/m]."""
    stick_stiffness: float
    """Tangential stiffness per area at rest [Pa/m]."""
    elastic_slip: float
    """Displacement at which the tangential stiffness reaches the friction limit [m]."""
    pressures: Floats
    """Pressures of the table [Pa], rising from zero."""
    overclosures: Floats
    """Overclosures (approach of the faces) [m] at these pressures, zero at zero pressure."""
    layer: VirtualLayer
    """Equivalent layer of elements."""
    errors: CardErrors
    """Errors of the card."""

    @classmethod
    def of(
        cls,
        joint: Interface,
        *,
        area: float | None = None,
        amplitude: float | None = None,
        thickness: float = 1e-3,
        density: float | None = None,
    ) -> ContactCard:
        """Compute the contact card of a joint.

        Parameters
        ----------
        joint : Interface
            The joint at its normal load.
        area : float, optional
            Apparent area [m^2], required if the surface has none.
        amplitude : float, optional
            Slip amplitude [m] at which the layer is equivalent, by default half the displacement
            force_limit / tangential_stiffness.
        thickness : float, optional
            Thickness of the layer [m].
        density : float, optional
            Mass density of the layer [kg/m^3].

        Returns
        -------
        ContactCard
            The card, in SI units.

        Notes
        -----
        The pressure is N(d)/A with the area A, and the overclosure is the decrease of the
        separation d since contact. The tangential stiffness at rest is 4 G*/E* times the normal
        stiffness (Mindlin 1949), with the composite moduli of :class:`microslip.MaterialPair`. The
        table of pressures over overclosures is piecewise linear; the pressure of the joint is in
        the middle of a segment, so that the slope there is the normal stiffness per area. The layer
        must be added between the faces; the parts keep their thickness.
        """
        if not isinstance(joint, Interface):
            raise InputError(
                "`joint` must be an Interface, whose surface has a normal stiffness, for a "
                f"contact card, got {show(joint)}"
            )
        surface = joint.surface
        apparent = getattr(surface, "area", None)
        if apparent is None and area is None:
            raise InputError(
                f"`area` must be given: {type(surface).__name__} has no apparent area [m^2], "
                "for example area=2e-4"
            )
        if apparent is not None and area is not None and area != apparent:
            raise InputError(
                f"`area` must be that of the surface, {apparent:g} m^2, or be left out, "
                f"got {area:g}"
            )
        area = positive("area", apparent if area is None else area, "m^2", 2e-4)
        thickness = positive("thickness", thickness, "m", 1e-3)
        if density is not None:
            density = positive("density", density, "kg/m^3", 2700.0)
        stick = joint.tangential_stiffness / area
        slip = joint.force_limit / joint.tangential_stiffness
        amplitude = 0.5 * slip if amplitude is None else positive("amplitude", amplitude, "m", 1e-8)
        ratio = math.log(_ABOVE / _BELOW) / _POINTS
        first = math.floor(math.log(_BELOW) / ratio)
        loads = joint.normal_load * np.exp(ratio * (first + 0.5 + np.arange(_POINTS + 1)))
        loads = loads[loads <= surface._heaviest]
        d = np.asarray(surface.separation(loads))
        stiffnesses = np.asarray(surface.stiffness(d))
        # Below its first point the table falls linearly to zero with the stiffness of that point.
        closing = loads[0] / stiffnesses[0] + d[0] - d
        between = np.sqrt(loads[1:] * loads[:-1])
        share = (d[:-1] - np.asarray(surface.separation(between))) / -np.diff(d)
        interpolated = loads[:-1] + share * np.diff(loads)
        return cls(
            joint.normal_load / area,
            joint.friction_coefficient,
            joint.normal_stiffness / area,
            stick,
            slip,
            lock(np.append(0.0, loads / area)),
            lock(np.append(0.0, closing)),
            VirtualLayer(
                thickness,
                joint.normal_stiffness / area * thickness,
                float(joint.secant_stiffness(amplitude)) / area * thickness,
                density,
                amplitude,
                float(joint.loss_factor(amplitude)),
            ),
            _errors(joint, float(np.max(np.abs(interpolated / between - 1.0)))),
        )


def _errors(joint: Interface, pressure: float) -> CardErrors:
    surface, stiffness = joint.surface, joint.normal_stiffness
    factors = np.geomspace(1.0 / _BAND, _BAND, 21)
    factors = factors[joint.normal_load * factors <= surface._heaviest]
    there = np.asarray(surface.stiffness(surface.separation(joint.normal_load * factors)))
    stick_slip = Jenkins(joint.tangential_stiffness, joint.force_limit)
    slip = joint.force_limit / joint.tangential_stiffness
    return CardErrors(
        pressure,
        float(np.max(np.abs(stiffness / there - 1.0))),
        float(np.max(np.abs(stiffness * factors / there - 1.0))),
        joint.force_limit / float(joint.backbone(slip)) - 1.0,
        tuple(
            (a, float(joint.loss_factor(a)), float(stick_slip.loss_factor(a)))
            for a in (slip * share for share in _SLIPS)
        ),
    )
