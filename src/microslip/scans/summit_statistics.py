"""Inputs of Greenwood and Williamson's model, and their sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from microslip._core.checks import number, positive, show
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
