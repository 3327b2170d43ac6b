"""Laws of individually given summits: a sphere on a flat, and a population of summits.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, number, plain, positive, record
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip._core.parameters import parameter
from microslip.contact.base import (
    YIELD,
    NormalLaw,
    aluminium,
    check_pair,
    plasticity_index,
    sparse_contacts,
)
from microslip.contact.materials import MaterialPair
from microslip.contact.spheres import Spheres

_HARDNESS_RATIO = 2.84  # fully plastic pressure over yield stress (Jackson and Green 2005)


@dataclass(frozen=True)
class SphereOnFlat(NormalLaw):
    """Hertz's sphere with its summit at zero: N = (4/3) E* sqrt(rho) (-d)^(3/2) (19.1)-(19.3).

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    radius : float
        Radius rho [m].
    """

    pair: MaterialPair
    radius: float = field(
        metadata=parameter("rho", "m", "radius of the sphere", above=0.0, example=5e-3)
    )

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        """Return {rule name: p0/(C S_y)} [-], the Hertz pressure p0 over that of first yield.

        S_y = hardness/2.84 is the yield strength, and C = 1.295 exp(0.736 nu) with Poisson's ratio
        nu (Jackson and Green 2005, DOI 10.1115/1.1866166).
        """
        hardness = self.pair.hardness
        if hardness is None:
            return {YIELD: None}
        if separation is None:
            return {YIELD: 0.0}
        bodies = (self.pair.first, self.pair.second)
        poisson_ratio = min(body.poisson_ratio for body in bodies if not body.is_rigid)
        at_yield = 1.295 * math.exp(0.736 * poisson_ratio) * hardness / _HARDNESS_RATIO
        return {YIELD: self.hertz_pressure(separation) / at_yield}

    def hertz_pressure(self, separation: float) -> float:
        """Largest pressure p0 = (2 E*/pi) sqrt(s/rho) [Pa] at a separation d = -s [m] (19.2)."""
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
        """Return 1 for d < 0 (contact), else 0, for separations d [m] of any shape."""
        return self.contact_count(separation)

    def contact_count(self, separation: ArrayLike) -> Any:
        """Return 1 for d < 0 (contact), else 0, for separations d [m] of any shape."""
        return plain(np.where(self._separations(separation) < 0.0, 1.0, 0.0))

    def contact_area(self, separation: ArrayLike) -> Any:
        """Contact area pi rho (-d) [m^2] (19.2), for d <= 0 [m] of any shape; 0 for d > 0."""
        depth = np.maximum(-self._separations(separation), 0.0)
        return plain(math.pi * self.radius * depth)

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Return a ball of radius 5 mm."""
        return (cls(aluminium(), radius=5e-3),)


@dataclass(frozen=True, eq=False)
class AsperityPopulation(Locked, NormalLaw):
    """Given summits against a rigid plane: N = (4/3) E* sum of sqrt(rho_i) (y_i - d)^(3/2).

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    heights : array_like
        Summit heights y_i [m], one-dimensional.
    radii : array_like
        Summit radii rho_i [m]: one for each height, or one number for all.
    copies : float, optional
        Number of copies of each summit [-], above zero; for the summits of a scan, the ratio of
        apparent to scanned area.
    area : float, optional
        Apparent area [m^2]; used by the validity verdicts only.

    Notes
    -----
    Each summit follows (19.1)-(19.3). Contact ends at the highest summit. On first loading, the
    second derivative of the tangential force diverges where a summit begins to slip fully.
    """

    pair: MaterialPair
    heights: ArrayLike = field(metadata=parameter("y_i", "m", "heights of the summits", many=True))
    radii: ArrayLike = field(
        metadata=parameter("rho_i", "m", "radii of the summits", above=0.0, many=True)
    )
    copies: float = 1.0
    area: float | None = None

    def __post_init__(self) -> None:
        check_pair(self.pair)
        heights = record("heights", self.heights, "m").reshape(-1)
        radii = floats("radii", self.radii, "m")
        if radii.ndim > 1 or radii.size not in (1, heights.size):
            raise InputError(
                f"`radii` must be one number or one for each of the {heights.size} heights, got "
                f"shape {radii.shape}"
            )
        if radii.min() <= 0.0:
            raise InputError(f"`radii` must be above zero [m], got {radii.min():g}")
        radii = np.broadcast_to(radii.reshape(-1), heights.shape)
        assign(self, copies=positive("copies", self.copies, "", 1.0))
        if self.area is not None:
            assign(self, area=positive("area", self.area, "m^2", 2e-4))
        assign(self, heights=lock(heights.copy()), radii=lock(radii.copy()))

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        spread = float(np.std(np.asarray(self.heights)))
        radius = float(np.mean(np.asarray(self.radii)))
        plasticity = plasticity_index(self.pair, spread, radius)
        if self.area is None:
            return plasticity
        return {**sparse_contacts(self, self.area, spread, radius, separation), **plasticity}

    def __repr__(self) -> str:
        low, high = self._span
        return f"AsperityPopulation({self.summit_count:.10g} summits from {low:g} to {high:g})"

    @property
    def summit_count(self) -> float:
        """Number of all summits, including copies."""
        return np.asarray(self.heights).size * self.copies

    @cached_property
    def _spheres(self) -> Spheres:
        stiff = self.copies * (4.0 / 3.0) * self.pair.composite_modulus
        return Spheres(np.asarray(self.heights), stiff * np.sqrt(np.asarray(self.radii)))

    @property
    def _span(self) -> tuple[float, float]:
        heights = self._spheres.heights
        return float(heights[-1]), float(heights[0])

    def _derivative(self, separation: Floats, order: int) -> Floats:
        return self._spheres.derivative(separation, order)

    def contact_probability(self, separation: ArrayLike) -> Any:
        """Fraction of the summits in contact (19.5), for separations [m] of any shape."""
        return plain(self._counts(separation) / np.asarray(self.heights).size)

    def contact_count(self, separation: ArrayLike) -> Any:
        """Number of summits in contact (19.6), for separations [m] of any shape."""
        return plain(self.copies * self._counts(separation))

    def contact_area(self, separation: ArrayLike) -> Any:
        """Real contact area [m^2] (19.2): sum of pi rho_i (y_i - d), y_i > d; d of any shape."""
        d = self._separations(separation)
        heights, radii = np.asarray(self.heights), np.asarray(self.radii)
        areas = [float(np.maximum(heights - v, 0.0) @ radii) for v in d.reshape(-1)]
        return plain(math.pi * self.copies * np.array(areas).reshape(d.shape))

    def _counts(self, separation: ArrayLike) -> Any:
        d = self._separations(separation)
        return np.searchsorted(-self._spheres.heights, -d, side="left")

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Return a population of five summits of different heights and radii."""
        heights = [0.0, 2e-7, -3e-7, 5e-7, 1e-7]
        return (cls(aluminium(), heights=heights, radii=[1e-3, 2e-3, 5e-4, 1e-3, 4e-3]),)
