"""Inputs of Greenwood and Williamson's model, and the summits of an isotropic Gaussian surface.

After Nayak (1971), of such a field the height z, the mean curvature s at a summit (minus half the
sum of the second derivatives) and the two differences of second derivatives are jointly normal, and
the slopes are independent of them. The number of summits weighs a curvature with the determinant
of the second derivatives. With t = s/sqrt(m4/3) and the differences integrated out, the weight is

    w(t) = sqrt 3 (t^2 - 2 + 2 exp(-t^2/2)),   t > 0, t normal with variance 2,

and given z = xi sqrt m0, t is normal with mean xi sqrt 2 r and variance 2 (1 - r^2), where
r^2 = 3/(2 alpha). So the density of summit heights is phi(xi) times the expectation of w(t), in
closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, number, plain, positive, show
from microslip._core.units import engineering, significant
from microslip._core.wording import quoted
from microslip.errors import InputError
from microslip.heights import Gaussian, HeightDistribution
from microslip.materials import MaterialPair
from microslip.normal import GreenwoodWilliamson
from microslip.scans.checks import area_of

RadiusBy = Literal["curvature", "load"]
RADII = ("curvature", "load")

BY_LOAD = 1.2768192821378979
"""Radius by load over radius by curvature [-], of the summits of an isotropic Gaussian surface."""
# (E sqrt rho)^2 times the mean curvature, where rho = 1/sqrt(k1 k2); a test computes it anew.


@dataclass(frozen=True)
class SummitStatistics:
    """Density, radius and spread of the summits of a surface.

    The three parameters of a rough surface in Greenwood and Williamson (1966),
    DOI 10.1098/rspa.1966.0242, and the height of the summits above the mean plane.

    Parameters
    ----------
    density : float
        Summits per area [1/m^2], above zero.
    radius : float
        Radius of the summits [m], above zero.
    std : float
        Standard deviation of the summit heights [m], not below zero.
    mean_height : float
        Mean height of the summits above the mean plane of the surface [m].
    estimate : str
        Source of the numbers, such as "mccool", "nayak" or "counted".
    radius_by : {"curvature", "load"}
        Meaning of the radius: one over the mean curvature of the summits, as McCool's, or that of
        equal spheres that carry at equal indentation what the summits carry.
    """

    density: float
    radius: float
    std: float
    mean_height: float = 0.0
    estimate: str = "given"
    radius_by: RadiusBy = "curvature"

    def __post_init__(self) -> None:
        for name, unit, example in (("density", "1/m^2", 1e10), ("radius", "m", 1e-5)):
            object.__setattr__(self, name, positive(name, getattr(self, name), unit, example))
        for name in ("std", "mean_height"):
            object.__setattr__(self, name, number(name, getattr(self, name), "m", 1e-7))
        if self.std < 0.0:
            raise InputError(f"`std` must not be below zero [m], got {self.std:g}")
        if self.radius_by not in RADII:
            raise InputError(
                f"`radius_by` must be one of {quoted(RADII)}, got {show(self.radius_by)}"
            )

    @property
    def mean_radius(self) -> float:
        """One over the mean curvature of the summits [m].

        From a radius by load as on an isotropic Gaussian surface, where that is 1.277 times as
        large (Nayak 1971, DOI 10.1115/1.3451608).
        """
        return self.radius / BY_LOAD if self.radius_by == "load" else self.radius

    @property
    def product(self) -> float:
        """Density times radius times std [-]: 0.03 to 0.05 on Greenwood and Williamson's beads."""
        return self.density * self.radius * self.std

    def to_surface(
        self,
        pair: MaterialPair,
        area: float | str,
        *,
        heights: Literal["gaussian"] | HeightDistribution = "gaussian",
    ) -> GreenwoodWilliamson:
        """A rough surface with these summits, against a rigid plane.

        So two rough surfaces, once they are combined, or a profile become a joint.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        area : float or str
            Apparent area of the joint [m^2], or such as "2 cm^2".
        heights : {"gaussian"} or HeightDistribution
            Law of the summit heights: Gaussian with this mean and standard deviation, or another.

        Returns
        -------
        GreenwoodWilliamson
            Heights are measured from the mean plane of the surface; Greenwood and Williamson
            (1966), DOI 10.1098/rspa.1966.0242.
        """
        area = area_of(area)
        if isinstance(heights, str) and heights == "gaussian":
            if self.std <= 0.0:
                raise InputError(
                    "std of the summit heights must be above zero for Gaussian heights; for equal "
                    'heights use heights="discrete" of Summits, or heights=ms.Discrete([z])'
                )
            heights = Gaussian(self.std, self.mean_height)
        elif not isinstance(heights, HeightDistribution):
            raise InputError(
                f'heights must be "gaussian" or a height distribution, got {show(heights)}; '
                "single heights are held by Summits only"
            )
        return GreenwoodWilliamson(pair, heights, self.radius, self.density, area)

    def __str__(self) -> str:
        return (
            f"{significant(self.density * 1e-6)} summits/mm^2, radius "
            f"{engineering(self.radius, 'm')}, std {engineering(self.std, 'm')} ({self.estimate})"
        )


LEAST_ALPHA = 1.5
"""Nayak's alpha of a surface whose waves have all one length: the least that there is."""


@dataclass(frozen=True)
class NayakSummits:
    """Summits of an isotropic Gaussian surface: Nayak (1971), DOI 10.1115/1.3451608.

    Parameters
    ----------
    m0 : float
        Variance of the heights [m^2].
    m2 : float
        Mean square slope of a profile [-].
    m4 : float
        Mean square curvature of a profile [1/m^2].
    """

    m0: float
    m2: float
    m4: float

    def __post_init__(self) -> None:
        for name, unit in (("m0", "m^2"), ("m2", ""), ("m4", "1/m^2")):
            object.__setattr__(self, name, positive(name, getattr(self, name), unit))
        if self.nayak < LEAST_ALPHA * (1.0 - 1e-9):
            raise InputError(
                "Nayak's alpha = m0 m4/m2^2 must be at least 1.5 for an isotropic Gaussian "
                f"surface, got {self.nayak:.4g}: it is none, or its scan is disturbed"
            )

    @property
    def nayak(self) -> float:
        """Nayak's alpha [-], m0 m4/m2^2."""
        return self.m0 / self.m2 * (self.m4 / self.m2)

    @property
    def density(self) -> float:
        """Summits per area [1/m^2]."""
        return self.m4 / self.m2 / (6.0 * math.pi * math.sqrt(3.0))

    @property
    def mean_height(self) -> float:
        """Mean height of the summits above the mean plane [m]."""
        return 4.0 * math.sqrt(self.m0 / (math.pi * self.nayak))

    @property
    def std(self) -> float:
        """Standard deviation of the summit heights [m]."""
        share = 1.0 - 3.0 * math.sqrt(3.0) + 16.0 / math.pi
        return math.sqrt((1.0 - share / self.nayak) * self.m0)

    @property
    def mean_curvature(self) -> float:
        """Mean over all summits of their mean curvature [1/m]."""
        return 8.0 / 3.0 * math.sqrt(self.m4 / math.pi)

    @property
    def radius(self) -> float:
        """One over the mean curvature [m]: McCool's radius."""
        return 1.0 / self.mean_curvature

    @property
    def equivalent_radius(self) -> float:
        """Radius of equal spheres that carry at equal indentation what the summits carry [m].

        The load of a summit goes with the root of its equivalent radius 1/sqrt(k1 k2), so this is
        the square of the mean root: 1.277 times McCool's radius, whatever the moments.
        """
        return BY_LOAD * self.radius

    def height_density(self, height: ArrayLike) -> Any:
        """Probability density of the summit heights.

        Parameters
        ----------
        height : array_like
            Heights above the mean plane of the surface [m], of any shape.

        Returns
        -------
        float or ndarray
            Density [1/m], of the shape of `height`; Nayak (1971), DOI 10.1115/1.3451608.
        """
        z = floats("height", height, "m")
        return plain(self._parts(z)[0] / math.sqrt(self.m0))

    def share_below(self, height: ArrayLike) -> Any:
        """Share of the summits below a height [-], to 1e-9; the rest as :meth:`height_density`."""
        xi = floats("height", height, "m") / math.sqrt(self.m0)
        low, high, count = -9.0, 12.0, 2100
        step = (high - low) / count
        density = self._parts(np.linspace(low, high, 2 * count + 1) * math.sqrt(self.m0))[0]
        first, middle, last = density[:-1:2], density[1::2], density[2::2]
        # Simpson's rule, and within a step the integral of the same parabola.
        share = np.append(0.0, np.cumsum(step / 6.0 * (first + 4.0 * middle + last)))
        at = (np.clip(xi, low, high) - low) / step
        cell = np.minimum(at.astype(np.intp), count - 1)
        at = at - cell
        f, m, e = first[cell], middle[cell], last[cell]
        rise = f + at * ((4.0 * m - 3.0 * f - e) / 2.0 + at * (2.0 * f - 4.0 * m + 2.0 * e) / 3.0)
        return plain(np.clip((share[cell] + step * at * rise) / share[-1], 0.0, 1.0))

    def curvature_at(self, height: ArrayLike) -> Any:
        """Mean curvature [1/m] of the summits of a height: the high ones are the sharp ones.

        The rest as :meth:`height_density`.
        """
        weight, first = self._parts(floats("height", height, "m"))
        mean = np.divide(first, weight, out=np.zeros_like(weight), where=weight > 0.0)
        return plain(mean * math.sqrt(self.m4 / 3.0))

    def statistics(self) -> SummitStatistics:
        """Greenwood and Williamson's parameters: McCool's, with :attr:`equivalent_radius`."""
        return SummitStatistics(
            self.density, self.equivalent_radius, self.std, self.mean_height, "nayak", "load"
        )

    def _parts(self, z: Floats) -> tuple[Floats, Floats]:
        """Density of xi = z/sqrt m0, and the same times the mean of t."""
        from scipy.special import ndtr

        xi = z / math.sqrt(self.m0)
        r2 = min(1.5 / self.nayak, 1.0)
        mean, s = xi * math.sqrt(2.0 * r2), max(math.sqrt(2.0 * (1.0 - r2)), 1e-9)
        zeroth, first_moment, two, three = _above_zero(mean, s, ndtr)
        # exp(-t^2/2) times the normal density of t is a narrower one, times a number.
        wide = 1.0 + s * s
        factor = np.exp(-0.5 * mean * mean / wide) / math.sqrt(wide)
        tight = _above_zero(mean / wide, s / math.sqrt(wide), ndtr)
        phi = math.sqrt(3.0 / (2.0 * math.pi)) * np.exp(-0.5 * xi * xi)
        weight = phi * (two - 2.0 * zeroth + 2.0 * factor * tight[0])
        first = phi * (three - 2.0 * first_moment + 2.0 * factor * tight[1])
        # Far below the mean plane only the rounding of cancelling terms remains.
        near = xi > -9.0
        return (
            np.where(near, np.maximum(weight, 0.0), 0.0),
            np.where(near, np.maximum(first, 0.0), 0.0),
        )


def _above_zero(mean: Floats, s: float, ndtr: Any) -> tuple[Floats, Floats, Floats, Floats]:
    """Moments of orders 0 to 3 of a normal variable, from zero upwards."""
    x = mean / s
    below = ndtr(x)
    edge = s * np.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)
    first = mean * below + edge
    two = mean * first + s * s * below
    three = mean * two + 2.0 * s * s * first
    return below, first, two, three
