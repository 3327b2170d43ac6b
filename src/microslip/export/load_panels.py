"""Load curves as panels of polynomials, in which exported contact elements hold a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from microslip import kernels
from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.export.backbone_panels import cycle_energy
from microslip.friction import Interface, IsotropicField
from microslip.kernels.profile import Profile
from microslip.normal.load_curve import LoadCurve

_HEAVIEST = (20.0, 10.0, 5.0, 2.0)  # of the load at rest: as near as a contact may be pressed
_FAR = 1e3  # decay lengths: more than any contact reaches


@dataclass(frozen=True)
class LoadPanels:
    """N(d) over steps from an origin, in the panels of its profile."""

    profile: Profile
    origin: float
    """Separation [m] at which steps are counted from."""
    rest: float
    """Step at rest [m]."""
    nearest: float
    """Smallest opening from rest [m] that the panels hold."""
    friction: float
    """Tangential force over that of the curve, mu included [-]."""
    load_scale: float
    """Normal load over that of the curve [-]."""
    slip: float
    """Displacement per step, kappa [-]."""

    @classmethod
    def of_interface(cls, joint: Interface) -> LoadPanels:
        """The curve of an interface, from the nearest separation that it can be pressed to."""
        curve = LoadCurve(joint.surface, joint.separation, joint.normal_load)
        coupling = joint._coupling
        for factor in _HEAVIEST:
            try:
                nearest = curve.step_of(factor * joint.normal_load)
            except InputError:  # more than the surface bears
                continue
            profile = curve.profile(nearest, _FAR * curve._length)
            if profile is not None:
                rest = joint.separation
                friction, slip = coupling.friction, coupling.slip
                return cls(profile, rest, 0.0, nearest, friction, 1.0, slip)
        raise InputError(
            "contact elements hold a smooth load curve, and that of "
            f"{type(joint.surface).__name__} "
            'has kinks; element="joint" holds it at its load, and in Python '
            "state.try_(displacement, separation=...)"
        )

    @classmethod
    def of_field(cls, field: IsotropicField) -> LoadPanels:
        """The curve of the only node of a field in two directions."""
        nodes, bank = field.field._nodes, field._bank
        profile = nodes.curve.profile(bank.nearest, 0.0)
        if profile is None:
            raise InputError(
                "planar-contact elements hold a smooth load curve, and that of "
                f"{type(nodes.curve.surface).__name__} has kinks; "
                "in Python start().try_(displacement, separations) holds it"
            )
        rest, scale = float(nodes.rests[0]), float(nodes.scales[0])
        origin = float(field.field.separations[0])
        weight, slip = float(nodes.weights[0]), float(nodes.slips[0])
        return cls(profile, origin, rest, bank.nearest - rest, weight, scale, slip)

    @property
    def middles(self) -> Floats:
        """Integral of N from the middle of each panel to where nothing is left [N m]."""
        coefficients, half = self.profile.coefficients, 0.5 / self.profile.inverse_width
        k = np.arange(coefficients.shape[1])
        after = half * (coefficients / (k + 1)).sum(axis=1)
        before = -half * (coefficients / (k + 1) * (-1.0) ** (k + 1)).sum(axis=1)
        beyond = np.append(np.cumsum((after + before)[::-1])[::-1][1:], 0.0)
        return np.asarray(after + beyond)

    def force(self, u: Floats) -> Floats:
        """Backbone at rest [N] as the panels have it."""
        return self._asked(kernels.compiled.drops, u)

    def energy(self, amplitudes: Floats) -> Floats:
        """Energy of a closed cycle at rest [J], for rising amplitudes."""
        return cycle_energy(
            np.unique(np.append(0.0, amplitudes)),
            amplitudes,
            lambda u: 4.0 * self._asked(kernels.compiled.excesses, u),
        )

    def _asked(self, kernel: Any, u: Floats) -> Floats:
        result = np.empty(u.size)
        kernel(np.full(u.size, self.rest), u / self.slip, result, *self.profile.arguments)
        return np.asarray(self.friction * result)
