"""Extended Greenwood Model for an identification, in parameters that loops determine."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.kernels import TERMS
from microslip._core.kernels.table import NODES, TO_SERIES, PolynomialTable
from microslip.contact import (
    GreenwoodWilliamson,
    MeasuredContact,
    NormalLaw,
    SphereOnFlat,
    TabulatedNormalLaw,
)
from microslip.contact.base import aluminium
from microslip.contact.heights import Exponential, Gaussian, as_heights
from microslip.contact.materials import MaterialPair
from microslip.friction.interface import Interface

FRICTION, SCALE, SEPARATION = "friction_coefficient", "slip_scale", "standardised_separation"
_HEIGHTS, _TALLEST = 192, 8.0
"""Number of height classes with random summit counts, and their range above the lowest contact."""
_CONVENTIONAL_AREA = 1e-4
"""Apparent area [m^2] if none is known; loops do not depend on it."""
_SPREAD = 0.05
"""Density times radius times standard deviation of the heights of engineering surfaces [-],
Greenwood and Williamson (1966, DOI 10.1098/rspa.1966.0242): a convention for the radius."""
_PANELS = (24, 32, 48, 64)
_LEFT_OUT = 1e-14  # of the largest value, for the terms that a panel leaves out
_MOST_CACHED = 256  # separations
_LEAST_LOAD = 1e-16  # of the load where all touch: about what h = 8 is for Gaussian heights

Values = Mapping[str, float]


class Materials(NamedTuple):
    """Materials and area of a surface, which loops do not determine."""

    pair: MaterialPair | None = None
    area: float | None = None
    """Apparent area [m^2]."""
    radius: float | None = None
    """Radius of the summits [m]."""


@dataclass(frozen=True, eq=False)
class InterfaceModel:
    """Interface whose first-loading force is T0 = mu N [1 - n(h + x)/n(h)], x = u/slip_scale.

    The normal load at separation d is N = C n(d/s), with a known shape n, a length s and a constant
    C [N]. Loops determine the friction coefficient mu, the length slip_scale = kappa s, where kappa
    = mu E*/(4 G*) depends on the materials, and, weakly, the separation h = d/s at the
    ``reference_load`` N_ref. At another load N the separation h_N solves n(h_N) = n(h) N/N_ref
    (Ciavarella 1998, J. Appl. Mech. 65, 998). For a sphere s is the approach at the reference load,
    and h is -1.

    The shape n is that of ``law``: its load over ``norm`` [N] at a separation over ``unit`` [m].
    For heights the unit is their standard deviation and n is the standardised moment F_{3/2} of
    Greenwood and Williamson (1966, DOI 10.1098/rspa.1966.0242).
    """

    law: NormalLaw
    unit: float
    norm: float
    reference_load: float

    @classmethod
    def of_shape(cls, heights: Any, loads: Sequence[float]) -> InterfaceModel:
        """Return the model of a height distribution or a surface; None means Gaussian heights.

        The reference load is the geometric mean of the ``loads`` [N].
        """
        law = heights
        if not isinstance(law, NormalLaw):
            shape = Gaussian(std=1.0) if law is None else as_heights(law)
            law = GreenwoodWilliamson(aluminium(), shape, radius=1.0, density=1.0, area=1.0)
        unit: float
        if isinstance(law, GreenwoodWilliamson):
            unit = law.heights.spread
            norm = law._constant * unit**1.5
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
                "`heights` must be a distribution, or a surface whose lengths scale: "
                f"GreenwoodWilliamson, SphereOnFlat or TabulatedNormalLaw, got {show(law)}"
            )
        if not unit > 0.0:
            raise InputError(
                "`heights` must not all be equal, since their spread is the unit of the "
                "separation; write a sphere as SphereOnFlat(pair, radius=5e-3), got "
                f"{show(law)}"
            )
        return cls(law, unit, norm, math.exp(float(np.mean(np.log(loads)))))

    @property
    def is_sphere(self) -> bool:
        """Whether the surface is a single sphere."""
        return isinstance(self.law, SphereOnFlat)

    # -- the shape -------------------------------------------------------------------------------

    def _load(self, z: float) -> float:
        """Return the normalised load n at the normalised separation z [-]."""
        return self.law._derivative_at(z * self.unit, 0) / self.norm

    def _rate(self, z: float) -> float:
        """Return -n'(z)/n(z) [-], the relative decay of the load with normalised separation."""
        load = self.law._derivative_at(z * self.unit, 0)
        return -self.law._derivative_at(z * self.unit, 1) * self.unit / load

    @lru_cache(maxsize=_MOST_CACHED)  # noqa: B019  # a branch repeats values
    def _separation(self, z: float, ratio: float) -> float:
        """Return the normalised separation [-] at which the load n is ``ratio`` times n(z)."""
        if ratio == 1.0:
            return z
        load = np.array([ratio * self.law._derivative_at(z * self.unit, 0)])
        try:
            return float(NormalLaw._solve(self.law, load)[0]) / self.unit
        except InputError:  # beyond the loads of the surface, as an exponential law
            return z - math.log(ratio) / self._rate(z)

    # -- shares of the force limit ---------------------------------------------------------------

    def _share(self, z: float, x: Floats) -> Floats:
        """Return the first-loading force over its limit, 1 - n(z + x)/n(z) [-].

        z and x >= 0 are separation and displacement over their scales, n the normalised load.
        """
        table = self._table(z)
        value = self._exact(z, x) if table is None else table.value(x)
        return np.minimum(value, 1.0, out=value)

    def _exact(self, z: float, x: Floats) -> Floats:
        here = z * self.unit
        return np.asarray(self.law._drop(here, x * self.unit) / self.law._derivative_at(here, 0))

    def _fall(self, z: float, x: Floats) -> Floats:
        """Return the derivative of :meth:`_share` by x [-]."""
        here = z * self.unit
        by_step = self.law._fall(here, x * self.unit) * self.unit
        return np.asarray(by_step / self.law._derivative_at(here, 0))

    @lru_cache(maxsize=_MOST_CACHED)  # noqa: B019
    def _table(self, z: float) -> PolynomialTable | None:
        """Return the table for :meth:`_share` at separation z; None if n is not smooth."""
        reach = self.law._table_reach(z * self.unit)
        if reach is None:
            return None
        end, rate = reach / self.unit, self._rate(z)
        for panels in _PANELS:
            x = (end / panels) * (np.arange(panels)[:, None] + 0.5 * (1.0 + NODES)).reshape(-1)
            series = (self._exact(z, x) / x).reshape(panels, -1) @ TO_SERIES
            # The quotient is not larger than the rate.
            if np.abs(series[:, TERMS - 1 :]).max() <= _LEFT_OUT * rate:
                return PolynomialTable.from_series(series, end, 1, 1.0)
        return None

    # -- the force of first loading ----------------------------------------------------------------

    def bounds(self) -> tuple[float, float]:
        """Return the smallest and largest normalised separation [-] that a fit may assume."""
        low, high = (end / self.unit for end in self.law._span)
        heights = getattr(self.law, "heights", None)
        if isinstance(heights, Gaussian):
            middle = heights.mean / self.unit
            return middle - 4.0, middle + 8.0
        # For heights with an abrupt lower end, include separations at which all summits touch.
        # Moments of distributions of SciPy are not tabulated there, and too slow for a fit.
        low -= float(isinstance(heights, Exponential) or self.law._spheres is not None)
        grid = np.linspace(low, high, 4001)
        loads = self.law._derivative(grid * self.unit, 0)
        return low, float(grid[loads > _LEAST_LOAD * loads[0]][-1])

    def _values(self, values: Values) -> tuple[float, float, float]:
        """Return friction coefficient mu, slip scale [m] and separation h at the reference load."""
        h = -1.0 if self.is_sphere else values[SEPARATION]
        return values[FRICTION], values[SCALE], h

    def _at(self, values: Values, load: float) -> tuple[float, float, float]:
        """Return the force limit [N], the slip scale [m] and the separation h at a load [N]."""
        mu, scale, h = self._values(values)
        return mu * load, scale, self._separation(h, load / self.reference_load)

    def curve(self, u: Floats, values: Values, load: float) -> Floats:
        """Return the force [N] of first loading at displacements u >= 0 [m]."""
        limit, scale, here = self._at(values, load)
        return limit * self._share(here, np.minimum(u, 1e200) / scale)

    def slope(self, u: Floats, values: Values, load: float) -> Floats:
        """Return the stiffness [N/m] of first loading at displacements u >= 0 [m]."""
        limit, scale, here = self._at(values, load)
        return limit / scale * self._fall(here, u / scale)

    def by_summits(self, u: Floats, values: Values, load: float, loads: Sequence[float]) -> Floats:
        """Return the standard deviations of the force that random summits cause, times sqrt(M) [N].

        M is the total number of summits. The result has the shape (height intervals,
        displacements); the intervals are the same for all ``loads``. The number of summits in each
        interval of heights z scatters by Poisson's distribution. If it exceeds its mean by c M, h
        rises to keep the load N, and the force of first loading changes as follows, with the
        separation h at the load N, and n and x as defined in the class:

        -mu N/n(h) c [(z - h - x)^(3/2) - (z - h)^(3/2) n'(h + x)/n'(h)].
        """
        assert isinstance(self.law, GreenwoodWilliamson)
        heights, unit = self.law.heights, self.unit
        limit, scale, here = self._at(values, load)
        lowest = min(self._at(values, one)[2] for one in loads)
        top = max(heights.span[1] / unit, lowest + 1.0)
        edges = np.linspace(lowest, min(top, lowest + _TALLEST), _HEIGHTS + 1)
        z = 0.5 * (edges[1:] + edges[:-1])[:, None]
        share = heights._density(z * unit) * unit * (edges[1] - edges[0])
        x = np.minimum(u, 1e200) / scale
        fall = self._fall(here, x) / self._rate(here)
        above = np.maximum(z - here, 0.0) ** 1.5
        change = np.maximum(z - here - x, 0.0) ** 1.5 - above * fall
        return np.asarray(-limit / self._load(here) * np.sqrt(share) * change)

    # -- what follows ----------------------------------------------------------------------------

    def build(self, values: Values, load: float, given: Materials) -> Interface:
        """Return the interface; an unknown radius or area gets a conventional value."""
        pair, area, radius = given
        if pair is None:
            raise InputError(
                "`pair` must be given, the two materials: loops determine kappa s alone, and "
                "kappa = mu E*/4G* depends on them"
            )
        area = _CONVENTIONAL_AREA if area is None else area
        mu, scale, h = self._values(values)
        length = scale / (mu * pair.stiffness_ratio)
        constant = self.reference_load / self._load(h)
        surface = self._surface(pair, length, constant, area, radius)
        return Interface(surface, mu, normal_load=load)

    def derived(self, values: Values, load: float, given: Materials) -> dict[str, float]:
        """Return force limit, stiffness and, with materials ``given``, sizes of summits (SI)."""
        pair, area, _ = given
        mu, _, h = self._values(values)
        limit, scale, here = self._at(values, load)
        stiffness = limit * self._rate(here) / scale
        found = {"force_limit": limit, "tangential_stiffness": stiffness}
        if pair is None:
            return found
        law = self.law  # a lay has a ratio of its own
        length = scale / (mu * (law if isinstance(law, MeasuredContact) else pair).stiffness_ratio)
        stiff = 4.0 / 3.0 * pair.composite_modulus
        if self.is_sphere:
            radius = (self.reference_load / (length**1.5 * stiff)) ** 2
            return found | {"radius": radius, "approach": -here * length}
        found["std"] = length
        if area is not None and isinstance(law, GreenwoodWilliamson):
            constant = self.reference_load / self._load(h)
            found["density_root_radius"] = float(np.divide(constant, length**1.5 * stiff * area))
        return found

    def _surface(
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
        if isinstance(law, TabulatedNormalLaw):
            d, n = np.asarray(law.separations), np.asarray(law.loads)
            return TabulatedNormalLaw(pair, d * factor, n * (constant / self.norm), law.tail)
        return SphereOnFlat(pair, (constant / (length**1.5 * stiff)) ** 2)
