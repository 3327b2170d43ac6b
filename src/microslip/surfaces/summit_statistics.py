"""Density, radius and spread of the summits of a surface."""

from __future__ import annotations

from dataclasses import dataclass

from microslip._core.checks import number, positive
from microslip._core.errors import InputError
from microslip._core.units import engineering, significant
from microslip.contact import GreenwoodWilliamson
from microslip.contact.heights import Gaussian
from microslip.contact.materials import MaterialPair
from microslip.surfaces.checks import area_of


@dataclass(frozen=True)
class SummitStatistics:
    """Density, radius and height spread of the summits of a surface.

    Parameters of a rough surface in Greenwood and Williamson (1966), DOI 10.1098/rspa.1966.0242,
    and the mean height of the summits above the mean plane.

    Parameters
    ----------
    density : float
        Summits per unit area [1/m^2], above zero.
    radius : float
        Radius of the summits [m], above zero.
    std : float
        Standard deviation of the summit heights [m], not below zero.
    mean_height : float
        Mean height of the summits above the mean plane of the surface [m].
    """

    density: float
    radius: float
    std: float
    mean_height: float = 0.0

    def __post_init__(self) -> None:
        for name, unit, example in (("density", "1/m^2", 1e10), ("radius", "m", 1e-5)):
            object.__setattr__(self, name, positive(name, getattr(self, name), unit, example))
        for name in ("std", "mean_height"):
            object.__setattr__(self, name, number(name, getattr(self, name), "m", 1e-7))
        if self.std < 0.0:
            raise InputError(f"`std` must not be below zero [m], got {self.std:g}")

    def to_surface(self, pair: MaterialPair, area: float | str) -> GreenwoodWilliamson:
        """Make a rough surface with these summits and Gaussian heights, against a rigid plane.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        area : float or str
            Apparent area of the joint [m^2], or text such as "2 cm^2".

        Returns
        -------
        GreenwoodWilliamson
            Heights are measured from the mean plane of the surface; Greenwood and Williamson
            (1966), DOI 10.1098/rspa.1966.0242.
        """
        if self.std <= 0.0:
            raise InputError(
                "`std` of the summit heights must be above zero for Gaussian heights, got 0; for "
                "equal heights use ms.GreenwoodWilliamson with heights=ms.Discrete([z])"
            )
        heights = Gaussian(self.std, self.mean_height)
        return GreenwoodWilliamson(pair, heights, self.radius, self.density, area_of(area))

    def __str__(self) -> str:
        return (
            f"{significant(self.density * 1e-6)} summits/mm^2, radius "
            f"{engineering(self.radius, 'm')}, std {engineering(self.std, 'm')}"
        )
