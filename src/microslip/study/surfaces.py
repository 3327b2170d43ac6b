"""Tables of materials and surfaces."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.parameters import parameter_of
from microslip._core.units import FORCE
from microslip._core.wording import nearest
from microslip.contact import (
    AsperityPopulation,
    GreenwoodWilliamson,
    NormalLaw,
    SphereOnFlat,
    TabulatedNormalLaw,
)
from microslip.contact.materials import Material, MaterialPair, metals
from microslip.study.drawn_face import DrawnSurface
from microslip.study.fields import (
    ANY_HEIGHT,
    MATERIALS,
    RADIUS,
    Numbers,
    key_for,
    one_of,
    with_unit,
)
from microslip.study.heights import ANY_HEIGHTS, GivenHeights
from microslip.study.measured_face import MeasuredFace
from microslip.study.part import Key, Part, SubTable, SurfaceTable, key, optional_key, tag
from microslip.study.readers import KeyedError, Place

_ANY_PAIR = MaterialPair(Material(1e9, 0.3), Material.rigid())
"""Placeholder pair for checks of a surface, which do not depend on the materials."""


class Elastic(Part):
    """Elastic material: modulus, Poisson's ratio and, for yielding, hardness."""

    rigid: bool = tag(False, "Rigid body.", default=False)
    young_modulus: float = key_for(parameter_of(Material, "young_modulus"))
    poisson_ratio: float = key_for(parameter_of(Material, "poisson_ratio"))
    hardness: float | None = key_for(
        parameter_of(Material, "hardness"),
        help="Indentation hardness, for the plasticity index and for faces that yield.",
    )

    @classmethod
    def missing(cls, name: str, item: Key, place: Place) -> str:
        """Return the message for a missing key; it names a metal of similar name, if any."""
        called = place.key.rpartition(".")[2]
        near = nearest(called, metals())
        hint = f' (the table of metals has no "{called}"; did you mean "{near}"?)' if near else ""
        return super().missing(name, item, place) + hint

    def build(self) -> Material:
        """Return the material."""
        return Material(self.young_modulus, self.poisson_ratio, self.hardness)

    def check(self, place: Place) -> None:
        """Raise an error for values that :class:`microslip.Material` rejects."""
        self.build()


class Rigid(Part):
    """A rigid body."""

    rigid: bool = tag(True, "Rigid body; it has no other key.")

    def build(self) -> Material:
        """Return the material."""
        return Material.rigid()

    @classmethod
    def unknown(cls, name: str) -> str:
        """Return the error message for an unknown key."""
        return "unknown key; a rigid material has no other keys"


class ContactSurface(SurfaceTable):
    """Base of the tables that describe the surface between two bodies in contact."""

    materials: tuple[str, str] = MATERIALS

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Return the normal law of the surface."""
        raise NotImplementedError

    def check(self, place: Place) -> None:
        """Raise an error for values that the normal law rejects."""
        self.build(_ANY_PAIR)


class GreenwoodWilliamsonSurface(ContactSurface):
    """Flat surface of spherical summits of one radius and random heights (19.5)-(19.8)."""

    law: str = tag("greenwood-williamson", "Summits of one radius and random heights.")
    heights: Any = key(
        ANY_HEIGHTS, "Distribution of the summit heights.", '{ kind = "gaussian", std = "0.5 um" }'
    )
    radius: float = key_for(parameter_of(GreenwoodWilliamson, "radius"))
    density: float = key_for(parameter_of(GreenwoodWilliamson, "density"))
    area: float = key_for(parameter_of(GreenwoodWilliamson, "area"))

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Return the normal law of the surface."""
        heights = self.heights.build()
        return GreenwoodWilliamson(pair, heights, self.radius, self.density, self.area)


class SphereSurface(ContactSurface):
    """Hertz's sphere on a flat (19.1)-(19.3)."""

    law: str = tag("sphere", "One sphere on a flat.")
    radius: float = key_for(parameter_of(SphereOnFlat, "radius"))

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Return the normal law of the sphere."""
        return SphereOnFlat(pair, self.radius)


class PopulationSurface(ContactSurface):
    """A finite set of summits, with one radius for all or one per summit [m]."""

    law: str = tag("population", "Given summits.")
    heights: GivenHeights = key(
        SubTable(GivenHeights, tag="kind"),
        "Heights of the summits.",
        '{ kind = "values", values = ["0.4 um", "0.7 um"] }',
    )
    radius: tuple[float, ...] = key(
        Numbers(RADIUS, '["1 mm", "2 mm"]', single=True),
        "One radius, one for each height, or a column of a CSV file.",
        '"1 mm"',
    )

    def check(self, place: Place) -> None:
        """Raise an error if the numbers of radii and heights differ."""
        heights, radii = len(self.heights.values), len(self.radius)
        if radii not in (1, heights):
            raise KeyedError(
                ".radius",
                f"wanted one radius, or one for each of the {heights} heights, got {radii}",
            )
        super().check(place)

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Return the normal law of the summits."""
        radii = self.radius[0] if len(self.radius) == 1 else np.array(self.radius)
        return AsperityPopulation(pair, heights=self.heights.build(), radii=radii)


class TableSurface(ContactSurface):
    """A measured or computed normal law: separations [m], loads [N] and extrapolation."""

    law: str = tag("table", "A measured or computed normal law.")
    separation: tuple[float, ...] = key(
        Numbers(ANY_HEIGHT, '["0 um", "1 um", "2 um"]'),
        "Separations, increasing: a list or a column of a CSV file.",
    )
    load: tuple[float, ...] = key(
        Numbers(with_unit(FORCE, "2 kN", "any"), '["2 kN", "0.5 kN", "0 N"]'),
        "Load at each separation, decreasing and convex: a list or a column of a CSV file.",
    )
    tail: str | None = optional_key(
        one_of("exponential"),
        "Extrapolation beyond the last separation, if the load there is not zero.",
    )

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Return the table as a normal law."""
        separation, load = np.array(self.separation), np.array(self.load)
        return TabulatedNormalLaw(pair, separation=separation, load=load, tail=self.tail)  # type: ignore[arg-type]


ANY_SURFACE = SubTable(
    *(GreenwoodWilliamsonSurface, PopulationSurface, SphereSurface, TableSurface),
    *(MeasuredFace, DrawnSurface),
    tag="law",
    choose=lambda raw: MeasuredFace if raw.get("law") == "face" and "scan" in raw else None,
)
ANY_MATERIAL = SubTable(
    Elastic, Rigid, choose=lambda raw: Elastic if raw.get("rigid", False) is False else Rigid
)
