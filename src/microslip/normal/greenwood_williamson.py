"""Greenwood and Williamson's rough surface, of round summits and of elliptic ones.

Ellipses are the lay of a machined surface; what they bear depends on the direction of motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, plain
from microslip._core.frozen import assign
from microslip._core.parameters import parameter
from microslip.heights import (
    Discrete,
    Exponential,
    Gaussian,
    HeightDistribution,
    TabulatedHeights,
    as_heights,
)
from microslip.materials import MaterialPair
from microslip.normal.base import (
    ANISOTROPY,
    NormalLaw,
    aluminium,
    plasticity_index,
    sparse_contacts,
)
from microslip.normal.spheres import DERIVATIVES, Spheres
from microslip.normal.tightened import ElasticSummits


@dataclass(frozen=True, eq=False)
class GreenwoodWilliamson(ElasticSummits):
    """A nominally flat surface of spherical summits of one radius and random heights (19.5)-(19.8).

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    heights : HeightDistribution, frozen scipy.stats distribution or array_like
        Summit heights y [m]; an array stands for equal atoms of probability.
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
        """N_a (4/3) E* sqrt(rho) [N/m^1.5]."""
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
        """The summits themselves where the heights were given one by one."""
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

    def _as_spheres(self) -> dict[str, Any]:
        return {
            "heights": self._heights,
            "radius": self.radius,
            "summit_count": self.summit_count,
            "area": self.area,
        }

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Gaussian, exponential and given heights; the first is this project's worked example."""
        gaussian = cls(aluminium(), Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4)
        exponential = cls(aluminium(), Exponential(scale=8e-7), radius=1e-4, density=2e9, area=5e-4)
        summits = cls(
            aluminium(), [0.0, 2e-7, -3e-7, 5e-7, 1e-7], radius=1e-3, density=1e6, area=1e-4
        )
        return gaussian, exponential, summits


class HertzEllipse(NamedTuple):
    """An elliptic Hertz contact, by the ratio of its summit's curvatures."""

    axis_ratio: float
    """Short over long half axis b/a [-]."""
    load: float
    """Load over that of a sphere of the radius 1/sqrt(k1 k2), at equal indentation [-]."""
    area: float
    """Contact area over that of this sphere, at equal indentation [-]."""
    along: float
    """Mean of cos^2 of the angle to the long axis, over directions weighted by the radius [-]."""


@lru_cache(maxsize=4096)
def hertz_ellipse(curvature_ratio: float) -> HertzEllipse:
    """The ellipse of a summit whose smaller curvature is so much of the larger.

    Johnson, Contact Mechanics (1985), DOI 10.1017/CBO9781139171731, (4.26)-(4.33), written in
    Carlson's integrals, which do not cancel where the ellipse is a circle.
    """
    from scipy.optimize import brentq
    from scipy.special import elliprd, elliprf

    def miss(log_t: float) -> float:
        t2 = math.exp(2.0 * log_t)
        ratio = float(elliprd(0.0, t2, 1.0)) / float(elliprd(0.0, 1.0, t2))
        return math.log(ratio / curvature_ratio)

    # b/a lies between the ratio itself and one.
    low = math.log(curvature_ratio) - 1e-3
    t = 1.0 if curvature_ratio == 1.0 else math.exp(brentq(miss, low, 0.0, xtol=1e-15, rtol=1e-15))
    wide, narrow = float(elliprd(0.0, 1.0, t * t)), float(elliprd(0.0, t * t, 1.0))
    integral = float(elliprf(0.0, t * t, 1.0))  # K
    size = (4.0 / (3.0 * math.pi) * t**1.5 * math.sqrt(wide * narrow)) ** (1.0 / 3.0)  # F1
    depth = 2.0 / math.pi * math.sqrt(t) * integral / size  # F2
    return HertzEllipse(t, depth**-1.5, size * size / depth, narrow / (3.0 * integral))


def stiffness_ratio(pair: MaterialPair, along_motion: float) -> float:
    """Normal over tangential stiffness of an elliptic contact [-].

    By the mean of cos^2 of the angle to the motion, over directions weighted by the ellipse's
    radius; one half is a circle and gives E*/4G*. Displacements of the middle under a traction of
    Hertz's form (Cerruti): 1 - nu + nu <cos^2> against 1 - nu, each over G and summed.
    """
    bodies = [body for body in (pair.first, pair.second) if not body.is_rigid]
    shear = math.fsum(
        (1.0 - b.poisson_ratio + b.poisson_ratio * along_motion) / b.shear_modulus for b in bodies
    )
    return shear / math.fsum((1.0 - b.poisson_ratio) / b.shear_modulus for b in bodies)


@dataclass(frozen=True, eq=False)
class EllipticSummits(GreenwoodWilliamson):
    """Summits of random heights, all longer along the lay than across, moved at an angle to it.

    Parameters
    ----------
    pair, heights, density, area : as of :class:`GreenwoodWilliamson`
        The materials, heights [m] of summits, how many [1/m^2] there are, and where [m^2].
    radius : float
        Equivalent radius of the summits, 1/sqrt(k1 k2) [m].
    curvature_ratio : float
        Curvature along the lay over that across it, k2/k1 [-], at most 1.
    direction : float
        Angle between the motion and the lay [rad]: 0 along it, pi/2 across.

    Notes
    -----
    The contacts are Hertz's ellipses with the long axis along the lay. Cattaneo's superposition
    holds for them as for circles, only the ratio of compliances is another: lambda = 1 +
    nu/(1 - nu) <cos^2 theta> for equal bodies, the mean over directions weighted by the radius of
    the ellipse, theta from the direction of motion (Johnson 1985, section 7.4, DOI
    10.1017/CBO9781139171731). So all that is tangential follows with it in place of E*/4G*.
    """

    key = "elliptic-summits"

    curvature_ratio: float = field(
        metadata=parameter(
            "k2/k1", meaning="curvature along the lay over that across", above=1e-9, most=1.0,
            example=0.1,
        )
    )  # fmt: skip
    direction: float = field(
        metadata=parameter(
            "beta", "rad", "angle between the motion and the lay", least=-math.pi, most=math.pi,
            example=0.5 * math.pi,
        )
    )  # fmt: skip

    @cached_property
    def ellipse(self) -> HertzEllipse:
        """Shape of the contacts: axis ratio, load and area beside those of a sphere."""
        return hertz_ellipse(self.curvature_ratio)

    @cached_property
    def stiffness_ratio(self) -> float:
        """Normal over tangential stiffness of the contacts in the direction of motion [-]."""
        cos2 = math.cos(self.direction) ** 2
        along = self.ellipse.along
        return stiffness_ratio(self.pair, along * cos2 + (1.0 - along) * (1.0 - cos2))

    @cached_property
    def _constant(self) -> float:
        return super()._constant * self.ellipse.load

    def contact_area(self, separation: ArrayLike) -> Any:
        """Mean real contact area [m^2] of the ellipses, for separations [m] of any shape."""
        return self.ellipse.area * super().contact_area(separation)

    def _as_spheres(self) -> dict[str, Any]:
        """Spheres that stand for the ellipses, for what is known of summits that yield.

        They have the load, the area and the mean pressure of an ellipse at any indentation, R
        (A/P)^2 their radius and P^2/A their number, by the ratios :attr:`ellipse` of area and load.
        Ellipses yield at a pressure up to 12 % higher (Johnson 1985, section 6.2).
        """
        ellipse = self.ellipse
        count = ellipse.load**2 / ellipse.area
        return {
            "heights": self._heights,
            "radius": self.radius * (ellipse.area / ellipse.load) ** 2,
            "summit_count": self.density * count * self.area,
            "area": self.area,
            "compliance_ratio": self.stiffness_ratio,
            "spheres_per_summit": count,
        }

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        longer = math.log(max(1.0 / self.curvature_ratio, 1.0)) / math.log(36.0)
        return {**super()._assumptions(separation), ANISOTROPY: 1.0 - 0.05 * longer}

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """The worked example with a lay, moved across it."""
        lay = {"curvature_ratio": 0.1, "direction": 0.5 * math.pi}
        return (cls(aluminium(), Gaussian(std=5e-7), 1e-3, 1e8, 2e-4, **lay),)
