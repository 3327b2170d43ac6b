"""One sphere on a flat."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, number, plain
from microslip._core.parameters import parameter
from microslip.materials import MaterialPair
from microslip.normal.base import YIELD, NormalLaw, aluminium
from microslip.normal.elastic_plastic import HARDNESS_RATIO, JacksonGreen
from microslip.normal.spheres import Spheres


@dataclass(frozen=True)
class SphereOnFlat(NormalLaw):
    """Hertz's sphere, its summit at height zero: N = (4/3) E* sqrt(rho) (-d)^(3/2) (19.1)-(19.3).

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    radius : float
        Radius rho [m].
    """

    key = "sphere"

    pair: MaterialPair
    radius: float = field(
        metadata=parameter("rho", "m", "radius of the sphere", above=0.0, example=5e-3)
    )

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        """The yield check of Jackson and Green (2005), DOI 10.1115/1.1866166: p0 over C S_y."""
        hardness = self.pair.hardness
        if hardness is None:
            return {YIELD: None}
        if separation is None:
            return {YIELD: 0.0}
        summit = JacksonGreen(self.pair, hardness / HARDNESS_RATIO)
        # Pressures go with the root of the indentation.
        depth = max(-separation, 0.0) / (self.radius * summit.yield_indentation)
        return {YIELD: math.sqrt(depth)}

    def hertz_pressure(self, separation: float) -> float:
        """Largest pressure p0 = (2 E*/pi) sqrt(s/rho) [Pa] at a separation -s [m] (19.2), (19.3).

        Zero where nothing touches.
        """
        depth = max(-number("separation", separation, "m", -1e-6), 0.0)
        return 2.0 / math.pi * self.pair.composite_modulus * math.sqrt(depth / self.radius)

    @cached_property
    def _constant(self) -> float:
        return 4.0 / 3.0 * self.pair.composite_modulus * math.sqrt(self.radius)

    @cached_property
    def _spheres(self) -> Spheres:
        return Spheres(np.zeros(1), np.array([self._constant]))

    @property
    def _span(self) -> tuple[float, float]:
        return -self.radius, 0.0

    def _derivative(self, separation: Floats, order: int) -> Floats:
        return self._spheres.derivative(separation, order)

    def _solve(self, loads: Floats) -> Floats:
        return np.asarray(-(np.cbrt(loads / self._constant) ** 2))

    def contact_probability(self, separation: ArrayLike) -> Any:
        """1 in contact, else 0, for separations [m] of any shape."""
        return self.contact_count(separation)

    def contact_count(self, separation: ArrayLike) -> Any:
        """1 in contact, else 0, for separations [m] of any shape."""
        return plain(np.where(self._separations(separation) < 0.0, 1.0, 0.0))

    def contact_area(self, separation: ArrayLike) -> Any:
        """Contact area pi rho (-d) [m^2] (19.2), for separations [m] of any shape."""
        depth = np.maximum(-self._separations(separation), 0.0)
        return plain(math.pi * self.radius * depth)

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """A ball of 5 mm."""
        return (cls(aluminium(), radius=5e-3),)
