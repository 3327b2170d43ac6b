"""Summit heights of a study."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.parameters import parameter_of
from microslip.contact.heights import Exponential, Gaussian, TabulatedHeights
from microslip.study.fields import ANY_HEIGHT, Numbers, key_for
from microslip.study.part import Part, SubTable, key, tag
from microslip.study.readers import Place


class GaussianHeights(Part):
    """Gaussian (normal) summit heights (19.25)."""

    kind: str = tag("gaussian", "Gaussian (normal) summit heights (19.25).")
    std: float = key_for(parameter_of(Gaussian, "std"))
    mean: float = key_for(parameter_of(Gaussian, "mean"))

    def build(self) -> Gaussian:
        """Return the height distribution."""
        return Gaussian(self.std, self.mean)


class ExponentialHeights(Part):
    """Exponential summit heights y >= 0 with density exp(-y/scale)/scale."""

    kind: str = tag("exponential", "Exponential summit heights from zero up.")
    scale: float = key_for(parameter_of(Exponential, "scale"))

    def build(self) -> Exponential:
        """Return the height distribution."""
        return Exponential(self.scale)


class GivenHeights(Part):
    """Individual summit heights [m], all equally likely."""

    kind: str = tag("values", "Given heights, all equally likely.")
    values: tuple[float, ...] = key(
        Numbers(ANY_HEIGHT, '["0.4 um", "0.7 um"]'), "Heights: a list or a column of a CSV file."
    )

    def build(self) -> Any:
        """Return the heights as an array."""
        return np.array(self.values)


class TableHeights(Part):
    """Summit heights with a tabulated density: linear between its points, zero outside."""

    kind: str = tag("table", "A tabulated density, linear between its points.")
    height: tuple[float, ...] = key_for(parameter_of(TabulatedHeights, "height"))
    density: tuple[float, ...] = key_for(parameter_of(TabulatedHeights, "density"))

    def build(self) -> TabulatedHeights:
        """Return the height distribution."""
        return TabulatedHeights(self.height, self.density)

    def check(self, place: Place) -> None:
        """Raise an error for a table that is no density."""
        self.build()


ANY_HEIGHTS = SubTable(GaussianHeights, ExponentialHeights, GivenHeights, TableHeights, tag="kind")
