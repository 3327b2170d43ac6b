"""Floor 6: what Greenwood and Williamson's model asks of a surface, and where it is from."""

from __future__ import annotations

from dataclasses import dataclass

from microslip._checks import number, positive
from microslip._units import engineering, significant
from microslip.errors import InputError


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
        Where the numbers are from, such as "mccool", "nayak" or "counted".

    Raises
    ------
    InputError
        A number that is not of this kind.
    """

    density: float
    radius: float
    std: float
    mean_height: float = 0.0
    estimate: str = "given"

    def __post_init__(self) -> None:
        for name, unit, example in (("density", "1/m^2", 1e10), ("radius", "m", 1e-5)):
            object.__setattr__(self, name, positive(name, getattr(self, name), unit, example))
        for name in ("std", "mean_height"):
            object.__setattr__(self, name, number(name, getattr(self, name), "m", 1e-7))
        if self.std < 0.0:
            raise InputError(f"std must not be below zero [m], got {self.std:g}")

    @property
    def product(self) -> float:
        """Density times radius times std [-]: 0.03 to 0.05 on Greenwood and Williamson's beads."""
        return self.density * self.radius * self.std

    def __str__(self) -> str:
        return (
            f"{significant(self.density * 1e-6)} summits/mm^2, radius "
            f"{engineering(self.radius, 'm')}, std {engineering(self.std, 'm')} ({self.estimate})"
        )
