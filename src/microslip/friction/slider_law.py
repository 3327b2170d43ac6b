"""Law of discrete sliders identified from measured loops, with its range of amplitudes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.parameters import parameter
from microslip.friction.iwan import CellLaw


@dataclass(frozen=True, eq=False)
class SliderLaw(CellLaw):
    """Parallel elastic-plastic sliders, identified over a range of amplitudes.

    Parameters
    ----------
    yield_displacements : array_like
        Displacement at which each slider slips [m], above zero, one-dimensional.
    stiffnesses : array_like
        Stiffness of each slider [N/m], above zero, one for each yield displacement.
    smallest_amplitude, largest_amplitude : float
        Range of amplitudes [m] in which the law was identified. Below the range it is elastic;
        above it, sliders that did not slip in the range remain elastic.

    Notes
    -----
    T0(u) is the sum of k_i min(u, y_i) (Iwan 1966, DOI 10.1115/1.3625199), a concave polygon.
    :func:`microslip.identify` identifies it from loops without assuming its shape.
    """

    yield_displacements: ArrayLike = field(
        metadata=parameter(
            "y_i", "m", "displacement at which each slider slips", above=0.0, many=True
        )
    )
    stiffnesses: ArrayLike = field(
        metadata=parameter("k_i", "N/m", "stiffness of each slider", above=0.0, many=True)
    )
    smallest_amplitude: float = field(
        metadata=parameter("a_min", "m", "smallest amplitude of the range", above=0.0)
    )
    largest_amplitude: float = field(
        metadata=parameter("a_max", "m", "largest amplitude of the range", above=0.0)
    )

    key = "sliders"

    def __post_init__(self) -> None:
        self._check_parameters()
        counts = [np.size(values) for values in (self.yield_displacements, self.stiffnesses)]
        if counts[0] != counts[1]:
            raise InputError(
                "`yield_displacements` and `stiffnesses` must have the same length, got "
                f"{counts[0]} and {counts[1]}"
            )
        if self.smallest_amplitude > self.largest_amplitude:
            raise InputError(
                "`smallest_amplitude` must not exceed `largest_amplitude`, got "
                f"{self.smallest_amplitude:g} m and {self.largest_amplitude:g} m"
            )

    @property
    def _parts(self) -> tuple[Floats, Floats]:
        stiffnesses = np.asarray(self.stiffnesses)
        return stiffnesses, stiffnesses * np.asarray(self.yield_displacements)

    def __repr__(self) -> str:
        return (
            f"SliderLaw({np.size(self.stiffnesses)} sliders, known from "
            f"{self.smallest_amplitude:.3g} to {self.largest_amplitude:.3g} m)"
        )

    @classmethod
    def examples(cls) -> tuple[SliderLaw, ...]:
        """Return a law of 3 sliders and a law of 61 sliders.

        The last slider of the second law slips only at 100 times the largest amplitude.
        """
        few = cls([1e-7, 3e-7, 2e-6], [4e8, 1e8, 5e7], 5e-8, 1e-6)
        grid = np.geomspace(1e-8, 1e-6, 60)
        many = cls(np.append(grid, 1e-4), np.append(np.full(60, 5e6), 2e7), 1e-8, 1e-6)
        return few, many
