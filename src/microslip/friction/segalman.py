"""Segalman's four-parameter Iwan model."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip._core.inversion import invert
from microslip._core.parameters import parameter
from microslip.friction.base import BackboneLaw
from microslip.friction.sliders import Sliders


@dataclass(frozen=True)
class SegalmanIwan(BackboneLaw):
    """Iwan model with a power-law slider density and one discrete slider at its end.

    Parameters
    ----------
    force_limit : float
        Force of gross slip F_S [N], above zero.
    stiffness : float
        Stiffness at rest K_T [N/m], above zero.
    chi : float
        Exponent of the density [-], above -1: small cycles dissipate in proportion to amplitude^(3
        + chi). Segalman takes it between -1 and 0.
    beta : float
        Ratio of the stiffness of the last slider to that of all others [-], not negative. For 0 the
        transition to gross slip is smooth.

    Notes
    -----
    After Segalman (2005, DOI 10.1115/1.1989354). With p = 1 + chi and K = K_T/(1 + beta), sliders
    of density (K p/phi^p) u^chi [N/m^2] yield at displacements u up to phi, where a discrete slider
    of stiffness beta K yields too. Integration gives T0 = u [K_T - K x^p/(p + 1)] with x = u/phi <=
    1, phi = F_S/[K_T - K/(p + 1)] from T0(phi) = F_S, and E_d = 4 K a^2 x^p p/((p + 1) (p + 2))
    with x = a/phi for amplitudes a <= phi.
    """

    force_limit: float = field(metadata=parameter("F_S", "N", "force of gross slip", above=0.0))
    stiffness: float = field(metadata=parameter("K_T", "N/m", "stiffness at rest", above=0.0))
    # A joint of rough surfaces tends to chi = 0; stiffening joints may have chi above 0.
    chi: float = field(
        metadata=parameter(
            "chi",
            meaning="exponent of the density of sliders",
            above=-1.0,
            example=-0.5,
            why="at -1 or below the stiffness of the sliders is infinite",
        )
    )
    beta: float = field(
        metadata=parameter(
            "beta",
            meaning="stiffness of the last slider over that of all others",
            least=0.0,
        )
    )

    key = "segalman"

    @cached_property
    def slip_displacement(self) -> float:
        """Displacement phi at which gross slip begins [m]."""
        p = 1.0 + self.chi
        share = (self.beta + p / (p + 1.0)) / (1.0 + self.beta)
        return self.force_limit / (self.stiffness * share)

    @property
    def _spread(self) -> float:
        """Stiffness of the continuous sliders [N/m], without the last one."""
        return self.stiffness / (1.0 + self.beta)

    def _powers(self, u: Floats) -> tuple[Floats, Floats]:
        """Return (v/phi)^(1 + chi) [-] and v [m], with v = min(u, phi)."""
        phi = self.slip_displacement
        stretched = np.minimum(u, phi)
        return (stretched / phi) ** (1.0 + self.chi), stretched

    def _backbone(self, u: Floats) -> Floats:
        power, stretched = self._powers(u)
        force = stretched * (self.stiffness - self._spread * power / (2.0 + self.chi))
        below = np.minimum(force, self.force_limit)
        return np.where(u < self.slip_displacement, below, self.force_limit)

    def _slope(self, u: Floats) -> Floats:
        slope = self._spread * (self.beta + (1.0 - self._powers(u)[0]))
        return np.where(u < self.slip_displacement, slope, 0.0)

    def _backbone_at(self, u: float) -> tuple[float, float]:
        phi = self.slip_displacement
        if u >= phi:
            return self.force_limit, 0.0
        power, spread = (u / phi) ** (1.0 + self.chi), self._spread
        force = u * (self.stiffness - spread * power / (2.0 + self.chi))
        return min(force, self.force_limit), spread * (self.beta + (1.0 - power))

    @property
    def tangential_stiffness(self) -> float:
        """Stiffness at rest K_T [N/m]."""
        return self.stiffness

    def _inverse(self, force: Floats) -> Floats:
        # T0 is concave, so Newton steps from the left do not overshoot.
        end = np.full_like(force, self.slip_displacement)
        low = np.minimum(force / self.stiffness, end)
        return invert(self._backbone_and_slope, force, low, end)

    def _energy(self, amplitude: Floats) -> Floats:
        power, stretched = self._powers(amplitude)
        p = 1.0 + self.chi
        within = 4.0 * self._spread * stretched**2 * power * (p / ((p + 1.0) * (p + 2.0)))
        return within + 4.0 * self.force_limit * (amplitude - stretched)

    def _energy_slope(self, amplitude: Floats) -> Floats:
        power, stretched = self._powers(amplitude)
        p = 1.0 + self.chi
        within = 4.0 * self._spread * stretched * power * (p / (p + 1.0))
        slips = amplitude >= self.slip_displacement
        return np.where(slips, 4.0 * self.force_limit, within)

    @property
    def _small_amplitude_exponent(self) -> float:
        return 3.0 + self.chi

    def _slider_density(self, u: Floats) -> Floats:
        phi = self.slip_displacement
        with np.errstate(divide="ignore"):  # for chi < 0 the density at 0 is infinite
            power = np.minimum(u / phi, 1.0) ** self.chi
        return np.where(u < phi, self._spread * (1.0 + self.chi) / phi * power, 0.0)

    @property
    def _kinks(self) -> Floats:
        return np.array([self.slip_displacement])

    def sliders(self) -> Sliders:
        """Return sliders of a density ~ u^chi [N/m^2] up to phi [m], and for beta > 0 one at phi.

        For chi < 0 the density is infinite at 0.
        """
        last = self._spread * self.beta
        places, stiffnesses = ([self.slip_displacement], [last]) if last > 0.0 else ([], [])
        return Sliders(lock(np.array(places)), lock(np.array(stiffnesses)), self._slider_density)

    @classmethod
    def examples(cls) -> tuple[SegalmanIwan, ...]:
        """Return a lap joint, a law with beta = 0, and laws with chi near -1 and chi above 1."""
        return (
            cls(force_limit=4000.0, stiffness=1.5e8, chi=-0.5, beta=0.6),
            cls(force_limit=1100.0, stiffness=5.7e9, chi=0.0, beta=0.0),
            cls(force_limit=2e-3, stiffness=1e3, chi=-0.9, beta=5.0),
            cls(force_limit=50.0, stiffness=1e7, chi=1.5, beta=0.02),
        )
