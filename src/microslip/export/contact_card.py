"""A joint as numbers per unit area that contact of general finite-element programs takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip.friction import Interface, Jenkins

_POINTS = 38  # of the table: CalculiX 2.20 takes 40 pairs of numbers and breaks off at more
_BELOW, _ABOVE = 1e-2, 10.0  # where the table begins and ends, over the pressure of the joint
_BAND = 2.0  # pressures from half to twice that of the joint: what a constant stiffness is off over
_SLIPS = (0.1, 0.3, 1.0, 3.0, 10.0)  # amplitudes over the elastic slip, at which damping is told


@dataclass(frozen=True)
class VirtualLayer:
    """A layer of elements between the faces that stands for the joint at one amplitude."""

    thickness: float
    """Thickness [m]."""
    young_modulus: float
    """Modulus along its normal [Pa], without lateral contraction."""
    shear_modulus: float
    """Modulus of transverse shear [Pa] at the amplitude."""
    density: float | None
    """Mass per volume [kg/m^3], where it was given."""
    amplitude: float
    """Amplitude of slip [m] that shear modulus and loss factor are for."""
    loss_factor: float
    """Loss factor of its shear [-] there."""


@dataclass(frozen=True)
class CardErrors:
    """Errors of a contact card against the joint; relative [-]."""

    pressure: float
    """Largest error of the pressure between the points of the table."""
    normal_stiffness: float
    """Error of a constant normal stiffness, from half to twice the pressure of the joint."""
    constant_stick: float
    """Error of a constant tangential stiffness, over the same pressures."""
    elastic_slip: float
    """Error of a tangential stiffness of mu p over the elastic slip, over the same pressures."""
    force: float
    """Error of the friction force at the elastic slip, where stick-slip is farthest above the
    joint."""
    damping: tuple[tuple[float, float, float], ...]
    """Amplitudes [m], loss factors of the joint there, and those of stick-slip."""


@dataclass(frozen=True)
class ContactCard:
    """Contact of a joint per unit area, with what it cannot hold."""

    pressure: float
    """Pressure that the joint is under [Pa]."""
    friction_coefficient: float
    """Coulomb's coefficient [-]."""
    normal_stiffness: float
    """Normal stiffness per area at that pressure [Pa/m]."""
    stick_stiffness: float
    """Tangential stiffness per area at rest [Pa/m]."""
    elastic_slip: float
    """Slip at which that stiffness meets the friction limit [m]."""
    pressures: Floats
    """Pressures of the table [Pa], rising from zero."""
    overclosures: Floats
    """Overclosures [m], zero where the faces come apart."""
    stick_stiffnesses: Floats
    """Tangential stiffness per area [Pa/m] at each pressure."""
    layer: VirtualLayer
    """The joint as a layer of elements."""
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
        """The card of a joint.

        Parameters
        ----------
        joint : Interface
            The joint at its normal load.
        area : float, optional
            Apparent area [m^2], where the surface has none.
        amplitude : float, optional
            Amplitude of slip [m] that the layer is for; half the elastic slip without it.
        thickness : float, optional
            Thickness of the layer [m].
        density : float, optional
            Mass per volume of the layer [kg/m^3].

        Returns
        -------
        ContactCard
            Its numbers, in SI units.

        Notes
        -----
        Pressure and overclosure are N(d)/A and a change of the separation; the tangential stiffness
        at rest is 4 G*/E* times the normal one (Mindlin 1949). The pressure of the joint lies in
        the middle of a segment of the table, whose slope is the normal stiffness there. The layer
        has no thickness of its own in the joint: it is to be added between the faces, not cut out.
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
                f"`area` must be given: {type(surface).__name__} has no apparent area, over which "
                "the load is spread; for example area=2e-4 [m^2]"
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
        # Below its first point the table goes straight to zero, with the stiffness there.
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
            lock(np.append(stiffnesses[0], stiffnesses) / surface.stiffness_ratio / area),
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
    constant = float(np.max(np.abs(stiffness / there - 1.0)))
    return CardErrors(
        pressure,
        constant,
        constant,
        float(np.max(np.abs(stiffness * factors / there - 1.0))),
        joint.force_limit / float(joint.backbone(slip)) - 1.0,
        tuple(
            (a, float(joint.loss_factor(a)), float(stick_slip.loss_factor(a)))
            for a in (slip * share for share in _SLIPS)
        ),
    )
