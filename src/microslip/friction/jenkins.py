"""Jenkins cell: a spring and a slider in series."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip._core.parameters import parameter
from microslip.friction.base import BackboneLaw
from microslip.friction.sliders import Sliders


@dataclass(frozen=True)
class Jenkins(BackboneLaw):
    """Spring and Coulomb slider in series: elastic, perfectly plastic.

    Parameters
    ----------
    stiffness : float
        Stiffness of the spring [N/m], above zero.
    force_limit : float
        Force at which the slider slips [N], above zero.

    Notes
    -----
    One cell of Iwan (1966, DOI 10.1115/1.3625199). With force limit F, stiffness k and yield
    displacement y = F/k, a cycle of amplitude a dissipates 4 F (a - y) for a > y, else nothing.
    """

    stiffness: float = field(metadata=parameter("k", "N/m", "stiffness of the spring", above=0.0))
    force_limit: float = field(
        metadata=parameter("F", "N", "force at which the slider slips", above=0.0)
    )

    @property
    def yield_displacement(self) -> float:
        """Displacement from rest at which the slider begins to slip [m]."""
        return self.force_limit / self.stiffness

    def _backbone(self, u: Floats) -> Floats:
        end = self.yield_displacement
        elastic = np.minimum(self.stiffness * np.minimum(u, end), self.force_limit)
        return np.where(u < end, elastic, self.force_limit)  # the exact limit, without rounding

    def _slope(self, u: Floats) -> Floats:
        return np.where(u < self.yield_displacement, self.stiffness, 0.0)

    def _backbone_at(self, u: float) -> tuple[float, float]:
        if u < self.yield_displacement:
            return min(self.stiffness * u, self.force_limit), self.stiffness
        return self.force_limit, 0.0

    def _inverse(self, force: Floats) -> Floats:
        return force / self.stiffness

    def _energy(self, amplitude: Floats) -> Floats:
        return 4.0 * self.force_limit * np.maximum(amplitude - self.yield_displacement, 0.0)

    def _energy_slope(self, amplitude: Floats) -> Floats:
        return np.where(amplitude < self.yield_displacement, 0.0, 4.0 * self.force_limit)

    def sliders(self) -> Sliders:
        """Return the slider of the cell: yield displacement [m] and stiffness [N/m]."""
        yields, stiffnesses = np.array([self.yield_displacement]), np.array([self.stiffness])
        return Sliders(lock(yields), lock(stiffnesses), None)

    @classmethod
    def examples(cls) -> tuple[Jenkins, ...]:
        """Return a stiff cell and a compliant cell."""
        return cls(stiffness=5e7, force_limit=100.0), cls(stiffness=1e3, force_limit=2e-3)
