"""Coulomb friction: rigid, perfectly plastic."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.kernels.table import PolynomialTable
from microslip._core.parameters import parameter
from microslip.friction.base import BackboneLaw
from microslip.friction.sliders import Sliders


@dataclass(frozen=True)
class Coulomb(BackboneLaw):
    """Rigid, perfectly plastic friction: any motion meets the full force limit.

    Parameters
    ----------
    force_limit : float
        Force at which the slider slips [N], above zero.

    Notes
    -----
    The cell of Iwan (1966, DOI 10.1115/1.3625199) without its spring. The backbone is 0 at
    displacement 0 and equals the force limit F at any other: the force is 0 until the first motion
    from rest, then it has the magnitude F and the sign of the last motion. A cycle of amplitude a
    dissipates 4 F a, and the loss factor is 4/pi at every amplitude.

    The stiffness is infinite at rest and zero after the first motion, also in trial steps. A force
    does not determine a displacement, so methods that need one raise InputError.
    """

    force_limit: float = field(metadata=parameter("F", "N", "force at which it slips", above=0.0))

    @cached_property
    def _rigid_table(self) -> PolynomialTable:
        """Polynomial table of T0 for the compiled kernels: the constant F [N] at u > 0."""
        coefficients = np.zeros((1, kernels.TERMS))
        coefficients[0, 0] = self.force_limit
        return PolynomialTable(lock(coefficients), 1.0, 0, self.force_limit, 0.0)

    def _backbone(self, u: Floats) -> Floats:
        return np.where(u > 0.0, self.force_limit, 0.0)

    def _slope(self, u: Floats) -> Floats:
        return np.where(u > 0.0, 0.0, np.inf)

    def _backbone_at(self, u: float) -> tuple[float, float]:
        return (self.force_limit, 0.0) if u > 0.0 else (0.0, np.inf)

    def _energy(self, amplitude: Floats) -> Floats:
        return 4.0 * self.force_limit * amplitude

    def _energy_slope(self, amplitude: Floats) -> Floats:
        return np.full_like(amplitude, 4.0 * self.force_limit)

    def _below_limit(self, name: str, force: Floats) -> Floats:
        # Every conversion of a force into a displacement calls this method.
        raise InputError(
            f"`{name}` does not determine a displacement: Coulomb friction is rigid below its "
            f"limit {self.force_limit:.10g} N; give displacements [m]"
        )

    def sliders(self) -> Sliders:
        """Return one slider with yield displacement 0 [m] and infinite stiffness [N/m]."""
        return Sliders(lock(np.zeros(1)), lock(np.array([np.inf])), None)

    @classmethod
    def examples(cls) -> tuple[Coulomb, ...]:
        """Return one Coulomb law."""
        return (cls(force_limit=1100.0),)
