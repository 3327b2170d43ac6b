"""Rough surface of Greenwood and Williamson: summits of one radius and random heights.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, plain
from microslip._core.frozen import assign
from microslip._core.parameters import parameter
from microslip.contact.base import NormalLaw, aluminium, plasticity_index, sparse_contacts
from microslip.contact.heights import (
    Discrete,
    Exponential,
    Gaussian,
    HeightDistribution,
    TabulatedHeights,
    as_heights,
)
from microslip.contact.materials import MaterialPair
from microslip.contact.spheres import DERIVATIVES, Spheres


@dataclass(frozen=True, eq=False)
class GreenwoodWilliamson(NormalLaw):
    """A nominally flat surface of spherical summits of one radius and random heights (19.5)-(19.8).

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    heights : HeightDistribution, frozen scipy.stats distribution or array_like
        Distribution of the summit heights y [m]; the values of an array are equally probable.
    radius : float
        Summit radius rho [m].
    density : float
        Summits per apparent area rho_a [1/m^2].
    area : float
        Apparent area S_a [m^2].

    Notes
    -----
    N(d) = N_a (4/3) E* sqrt(rho) times the partial moment of order 3/2 of the heights above d
    (Greenwood and Williamson 1966, DOI 10.1098/rspa.1966.0242).
    """

    pair: MaterialPair
    heights: Any
    radius: float = field(
        metadata=parameter("rho", "m", "radius of the summits", above=0.0, example=1e-3)
    )
    density: float = field(
        metadata=parameter("rho_a", "1/m^2", "summits per apparent area", above=0.0)
    )
    area: float = field(metadata=parameter("S_a", "m^2", "apparent area", above=0.0))

    def __post_init__(self) -> None:
        super().__post_init__()
        assign(self, heights=as_heights(self.heights))

    @property
    def summit_count(self) -> float:
        """Number of all summits N_a = density * area."""
        return self.density * self.area

    @cached_property
    def _constant(self) -> float:
        stiff = 4.0 / 3.0 * self.pair.composite_modulus * math.sqrt(self.radius)
        return self.summit_count * stiff

    @property
    def _scales(self) -> dict[str, tuple[float, float, float]]:
        spread = self.heights.spread
        return ({"std": (spread, 1.5, 1.0)} if spread > 0.0 else {}) | {
            "radius": (self.radius, 0.5, 0.0),
            "density": (self.density, 1.0, 0.0),
            "area": (self.area, 1.0, 0.0),
        }

    @cached_property
    def _spheres(self) -> Spheres | None:
        if not isinstance(self.heights, Discrete):
            return None
        values = np.asarray(self.heights.values)
        return Spheres(values, np.full(values.size, self._constant / values.size))

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        spread = self.heights.spread
        values = sparse_contacts(self, self.area, spread, self.radius, separation)
        return {**values, **plasticity_index(self.pair, spread, self.radius)}

    def _slip_measure(self) -> tuple[float, str] | None:
        name = self.heights._spread_name
        return (self.heights.spread, name) if name else None

    def _standardised(self, separation: float) -> float | None:
        return self._heights._standardised(separation)

    @property
    def _span(self) -> tuple[float, float]:
        return self._heights.span

    @property
    def _edge(self) -> float:
        return self._heights.edge

    @property
    def _top(self) -> float:
        return self._heights.top

    @property
    def _breaks(self) -> Floats:
        return self._heights._breaks

    @property
    def _small_kinks(self) -> Floats:
        if isinstance(self.heights, TabulatedHeights):
            return self.heights._small_kinks
        return super()._small_kinks

    def _derivative(self, separation: Floats, order: int) -> Floats:
        if self._spheres is not None:
            return self._spheres.derivative(separation, order)
        return (DERIVATIVES[order] * self._constant) * self._heights._moment(
            3 - 2 * order, separation
        )

    def _derivative_at(self, separation: float, order: int) -> float:
        if self._spheres is not None:
            return super()._derivative_at(separation, order)
        moment = self._heights._moment_at(3 - 2 * order, separation)
        return DERIVATIVES[order] * self._constant * moment

    @property
    def _heights(self) -> HeightDistribution:
        heights: HeightDistribution = self.heights
        return heights

    @property
    def _kinks(self) -> Floats:
        if self._small_kinks.size:
            return np.asarray(self.heights._pieces[0])
        return super()._kinks

    def contact_probability(self, separation: ArrayLike) -> Any:
        """Probability that a summit is in contact (19.5), for separations [m] of any shape."""
        return plain(self._heights._moment(0, self._separations(separation)))

    def contact_count(self, separation: ArrayLike) -> Any:
        """Mean number of summits in contact (19.6), for separations [m] of any shape."""
        share = self._heights._moment(0, self._separations(separation))
        return plain(self.summit_count * share)

    def contact_area(self, separation: ArrayLike) -> Any:
        """Mean real contact area [m^2] (19.7), for separations [m] of any shape."""
        depth = self._heights._moment(2, self._separations(separation))
        return plain(math.pi * self.summit_count * self.radius * depth)

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Return surfaces with Gaussian, exponential and given heights."""
        gaussian = cls(aluminium(), Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4)
        exponential = cls(aluminium(), Exponential(scale=8e-7), radius=1e-4, density=2e9, area=5e-4)
        summits = cls(
            aluminium(), [0.0, 2e-7, -3e-7, 5e-7, 1e-7], radius=1e-3, density=1e6, area=1e-4
        )
        return gaussian, exponential, summits
