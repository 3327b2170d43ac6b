"""Values, materials and derived quantities of a physical law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from microslip.contact.materials import MaterialPair

Values = Mapping[str, float]
"""Values of the parameters of a law, by their names."""


class Materials(NamedTuple):
    """Materials and area of a surface, which loops do not determine."""

    pair: MaterialPair | None = None
    area: float | None = None
    """Apparent area [m^2]."""
    radius: float | None = None
    """Radius of the summits [m]."""


UNKNOWN = Materials()


class Derived(NamedTuple):
    """A quantity that follows from the parameters."""

    name: str
    unit: str
    value: float
