"""Shape n of a normal law N = C n(d/s) at separations d, and its use in an identification."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.kernels import TERMS
from microslip._core.kernels.table import NODES, TO_SERIES, PolynomialTable
from microslip.contact import (
    AsperityPopulation,
    GreenwoodWilliamson,
    MeasuredContact,
    NormalLaw,
    SphereOnFlat,
    TabulatedNormalLaw,
)
from microslip.contact.base import aluminium
from microslip.contact.heights import Exponential, Gaussian, as_heights
from microslip.contact.materials import MaterialPair

CONVENTIONAL_AREA = 1e-4
"""Apparent area [m^2] if none is known; loops do not depend on it."""
_SPREAD = 0.05
"""Density times radius times standard deviation of the heights of engineering surfaces [-],
Greenwood and Williamson (1966, DOI 10.1098/rspa.1966.0242): a convention for the radius."""
_PANELS = (24, 32, 48, 64)
_LEFT_OUT = 1e-14  # of the largest value, for the terms that a panel leaves out
_MOST_CACHED = 256  # separations


@dataclass(frozen=True, eq=False)
class Template:
    """Shape n(z) of a normal law: n is load over ``norm`` [N], z is separation over ``unit`` [m].

    For heights the unit is their standard deviation and n is the standardised moment F_{3/2} of
    Greenwood and Williamson (1966, DOI 10.1098/rspa.1966.0242).
    """

    law: NormalLaw
    unit: float
    norm: float

    # -- the shape -------------------------------------------------------------------------------

    def load(self, z: float) -> float:
        """Return the normalised load n at the normalised separation z [-]."""
        return self.law._derivative_at(z * self.unit, 0) / self.norm

    def rate(self, z: float) -> float:
        """Return -n'(z)/n(z) [-], the relative decay of the load with normalised separation."""
        load = self.law._derivative_at(z * self.unit, 0)
        return -self.law._derivative_at(z * self.unit, 1) * self.unit / load

    @lru_cache(maxsize=_MOST_CACHED)  # noqa: B019  # a branch asks several times at the same values
    def separation(self, z: float, ratio: float) -> float:
        """Return the normalised separation [-] at which the load n is ``ratio`` times n(z)."""
        if ratio == 1.0:
            return z
        load = np.array([ratio * self.law._derivative_at(z * self.unit, 0)])
        try:
            return float(NormalLaw._solve(self.law, load)[0]) / self.unit
        except InputError:  # beyond the loads of the surface: as for an exponential law
            return z - math.log(ratio) / self.rate(z)

    # -- shares of the force limit ---------------------------------------------------------------

    def share(self, z: float, x: Floats) -> Floats:
        """Return the first-loading force over its limit, 1 - n(z + x)/n(z) [-].

        z and x >= 0 are separation and displacement over their scales, n the normalised load.
        """
        table = self._table(z)
        value = self._exact(z, x) if table is None else table.value(x)
        return np.minimum(value, 1.0, out=value)

    def _exact(self, z: float, x: Floats) -> Floats:
        here = z * self.unit
        return np.asarray(self.law._drop(here, x * self.unit) / self.law._derivative_at(here, 0))

    def fall(self, z: float, x: Floats) -> Floats:
        """Return the derivative of :meth:`share` by x [-]."""
        here = z * self.unit
        by_step = self.law._fall(here, x * self.unit) * self.unit
        return np.asarray(by_step / self.law._derivative_at(here, 0))

    @lru_cache(maxsize=_MOST_CACHED)  # noqa: B019
    def _table(self, z: float) -> PolynomialTable | None:
        """Return the table for :meth:`share` at separation z; None if n is not smooth."""
        reach = self.law._table_reach(z * self.unit)
        if reach is None:
            return None
        end, rate = reach / self.unit, self.rate(z)
        for panels in _PANELS:
            x = (end / panels) * (np.arange(panels)[:, None] + 0.5 * (1.0 + NODES)).reshape(-1)
            series = (self._exact(z, x) / x).reshape(panels, -1) @ TO_SERIES
            # The quotient is not larger than the rate.
            if np.abs(series[:, TERMS - 1 :]).max() <= _LEFT_OUT * rate:
                return PolynomialTable.from_series(series, end, 1, 1.0)
        return None

    # -- back to surfaces ------------------------------------------------------------------------

    def bounds(self) -> tuple[float, float]:
        """Return the smallest and largest normalised separation [-] that a fit may assume."""
        low, high = (end / self.unit for end in self.law._span)
        heights = getattr(self.law, "heights", None)
        if isinstance(heights, Gaussian):
            middle = heights.mean / self.unit
            return middle - 4.0, middle + 8.0
        # Heights that begin abruptly: also so deep that all of them touch. The moments of
        # scipy's distributions are no tables there, and too slow for a fit.
        low -= float(isinstance(heights, Exponential) or self.law._spheres is not None)
        grid = np.linspace(low, high, 4001)
        loads = self.law._derivative(grid * self.unit, 0)
        return low, float(grid[loads > _LEAST_LOAD * loads[0]][-1])

    def surface(
        self, pair: MaterialPair, length: float, constant: float, area: float, radius: float | None
    ) -> NormalLaw:
        """Return the law N(d) = constant * n(d/length) [N] for a pair of materials."""
        factor = length / self.unit
        stiff = 4.0 / 3.0 * pair.composite_modulus
        law = self.law
        if isinstance(law, GreenwoodWilliamson):
            summits = constant / (length**1.5 * stiff)  # N_a sqrt(rho)
            if radius is None:
                radius = (_SPREAD * area / (summits * length)) ** 2
            density = summits / (math.sqrt(radius) * area)
            return GreenwoodWilliamson(
                pair, law.heights._scaled(factor), radius=radius, density=density, area=area
            )
        if isinstance(law, AsperityPopulation):
            # N = (4/3) E* sqrt(radius) s^(3/2) for each summit: radii carry the constant.
            was = 4.0 / 3.0 * law.pair.composite_modulus
            root = constant / self.norm * was / stiff / factor**1.5
            heights, radii = np.asarray(law.heights), np.asarray(law.radii)
            return AsperityPopulation(pair, heights * factor, radii * root**2)
        if isinstance(law, TabulatedNormalLaw):
            d, n = np.asarray(law.separations), np.asarray(law.loads)
            return TabulatedNormalLaw(pair, d * factor, n * (constant / self.norm), law.tail)
        if isinstance(law, SphereOnFlat):
            return SphereOnFlat(pair, (constant / (length**1.5 * stiff)) ** 2)
        raise InputError(
            f"`heights` must be of a surface that can be scaled, got {type(law).__name__}"
        )


_LEAST_LOAD = 1e-16  # of the load where all touch: about what h = 8 is for Gaussian heights


def template_of(heights: Any = None) -> Template:
    """Return the normalised shape of a normal law, from a surface or heights (None: Gaussian)."""
    law = heights
    if not isinstance(law, NormalLaw):
        shape = Gaussian(std=1.0) if law is None else as_heights(law)
        law = GreenwoodWilliamson(aluminium(), shape, radius=1.0, density=1.0, area=1.0)
    unit: float
    if isinstance(law, GreenwoodWilliamson):
        unit = law.heights.spread
        norm = law._constant * unit**1.5
    elif isinstance(law, AsperityPopulation):
        unit = float(np.std(np.asarray(law.heights)))
        norm = float(law._spheres.constants.sum()) * unit**1.5
    elif isinstance(law, TabulatedNormalLaw):
        first = law._span[0]
        norm = law._derivative_at(first, 0)
        unit = norm / -law._derivative_at(first, 1)
        if isinstance(law, MeasuredContact):
            unit = law.numbers.rms
    elif isinstance(law, SphereOnFlat):  # the approach at the reference load is its unit
        unit = law.radius
        norm = law._constant * unit**1.5
    else:
        raise InputError(
            "`surface` must be one whose lengths scale: GreenwoodWilliamson, "
            f"AsperityPopulation, SphereOnFlat or TabulatedNormalLaw, got {show(law)}"
        )
    if not unit > 0.0:
        raise InputError(
            "`heights` must not all be equal, since their spread is the unit of the separation; "
            f"write a sphere as SphereOnFlat(pair, radius=5e-3), got {show(law)}"
        )
    return Template(law, unit, norm)
