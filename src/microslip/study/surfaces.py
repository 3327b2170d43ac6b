"""Floor 10: the materials and surfaces that a study file may describe."""

from __future__ import annotations

import dataclasses
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from microslip._core.parameters import key_of, parameters_of
from microslip._core.units import engineering
from microslip.errors import InputError
from microslip.materials import Material, MaterialPair
from microslip.normal import (
    NORMAL_LAWS,
    AsperityPopulation,
    NormalLaw,
    PerssonCurve,
    TabulatedNormalLaw,
)
from microslip.study import fields
from microslip.study.faces import DrawnSurface, FacedSurface, TwoFaces
from microslip.study.fields import one_of
from microslip.study.heights import HEIGHTS_TABLES, AnyHeights, GivenHeights, ScipyHeights
from microslip.study.parametric import Described, table_of
from microslip.study.part import KeyedError, Part, SurfaceTable, keyed, optional, required
from microslip.study.scanned_surface import ScanSurface

__all__ = [
    "SURFACE_TABLES",
    "AnyMaterial",
    "AnySurface",
    "Elastic",
    "ExponentialHeights",
    "FacedSurface",
    "GaussianHeights",
    "PopulationSurface",
    "Rigid",
    "ScanSurface",
    "ScipyHeights",
    "SpectralSurface",
    "TableHeights",
    "TableSurface",
]


class Elastic(Part):
    """An elastic material [Pa, –, Pa]; its hardness only serves warnings."""

    rigid: Literal[False] = optional("Whether the body does not deform.", default=False)
    young_modulus: fields.Modulus = required("Young's modulus E.", '"69 GPa"')
    poisson_ratio: fields.PoissonRatio = required("Poisson's ratio.", "0.33")
    hardness: fields.Hardness | None = optional(
        "Indentation hardness; it changes no result, it adds the plasticity index.", '"1.2 GPa"'
    )

    def build(self) -> Material:
        """The material."""
        return Material(self.young_modulus, self.poisson_ratio, self.hardness)


class Rigid(Part):
    """A body that does not deform."""

    rigid: Literal[True] = required("A body that does not deform; it has no other key.")

    def build(self) -> Material:
        """The material."""
        return Material.rigid()


class Surface(SurfaceTable):
    """Two bodies and how they touch."""

    law: str
    materials: fields.TwoNames = required(
        "Names of the two bodies: materials of this file or metals of the table.",
        '["steel", "steel"]',
    )


class DescribedSurface(Described, Surface):
    """A surface whose class says its parameters."""

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Normal law of the surface."""
        values = self.values()
        if "heights" in type(self).model_fields:
            values["heights"] = self.heights.build()  # type: ignore[attr-defined]
        law: NormalLaw = self.describes(pair, **values)
        return law


class PopulationSurface(Surface):
    """A finite set of summits; one radius for all or one for each [m]."""

    law: Literal["population"] = required("Given summits.")
    heights: Annotated[GivenHeights, Field(discriminator="kind")] = required(
        "Heights of the summits.", '{ kind = "values", values = ["0.4 um", "0.7 um"] }'
    )
    radius: fields.Radii = required(
        "One radius, one for each height, or a column of a CSV file.", '"1 mm"'
    )

    @model_validator(mode="after")
    def _check_radii(self) -> Self:
        heights, radii = len(self.heights.values), len(self.radius)
        if radii not in (1, heights):
            raise KeyedError(
                "surface.radius",
                f"wanted one radius, or one for each of the {heights} heights, got {radii}",
            )
        return self

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Normal law of the summits."""
        radii = self.radius[0] if len(self.radius) == 1 else np.array(self.radius)
        return AsperityPopulation(pair, heights=self.heights.build(), radii=radii)


class TableSurface(Surface):
    """A measured or computed normal law: separations [m], their loads [N], how it goes on."""

    law: Literal["table"] = required("A measured or computed normal law.")
    separation: fields.Separations = required(
        "Separations, rising: a list or a column of a CSV file.", '["0 um", "1 um", "2 um"]'
    )
    load: fields.TabulatedLoads = required(
        "Loads at these, falling and convex: a list or a column of a CSV file.",
        '["2 kN", "0.5 kN", "0 N"]',
    )
    tail: Annotated[Literal["exponential"], one_of("exponential")] | None = optional(
        "How the law goes on where its last load is not zero.", '"exponential"'
    )

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        separation, load = self.separation, self.load
        if len(load) != len(separation):
            raise KeyedError(
                "surface.load",
                f"wanted one load for each of the {len(separation)} separations, got {len(load)}",
            )
        if len(load) < 3:
            raise KeyedError(
                "surface.separation", f"wanted at least three points, got {len(separation)}"
            )
        for i in range(1, len(load)):
            if not separation[i] > separation[i - 1]:
                before, here = (engineering(separation[j], "m", 6, trim=True) for j in (i - 1, i))
                raise KeyedError(
                    f"surface.separation, item {i + 1}",
                    f"wanted separations that rise, got {here} after {before}",
                )
            if not load[i] < load[i - 1]:
                before, here = (engineering(load[j], "N", 6, trim=True) for j in (i - 1, i))
                raise KeyedError(
                    f"surface.load, item {i + 1}",
                    f"wanted loads that fall, got {here} after {before}",
                )
        last = engineering(load[-1], "N", 6, trim=True)
        if load[-1] < 0.0:
            raise KeyedError(
                f"surface.load, item {len(load)}", f"wanted a load of at least 0 N, got {last}"
            )
        if load[-1] > 0.0 and self.tail is None:
            raise KeyedError(
                "surface.load",
                f'wanted "0 N" as the last one, or tail = "exponential", got {last}',
            )
        if load[-1] == 0.0 and self.tail is not None:
            raise KeyedError("surface.tail", "wanted no tail, since the last load is zero")
        return self

    def build(self, pair: MaterialPair) -> NormalLaw:
        """The table as a normal law."""
        return TabulatedNormalLaw(
            pair,
            separation=np.array(self.separation),
            load=np.array(self.load),
            tail=self.tail,
        )


class SpectralSurface(Surface):
    """A surface by its power spectrum, pressed on a half space, by Persson's theory."""

    law: Literal["persson"] = required("A power spectrum, by Persson's theory.")
    wavenumber: fields.Wavenumbers | None = optional(
        "Wavenumbers 2 pi/wavelength, rising: a list or a column, as spectrum.csv of "
        "`microslip surface` has it.",
        '["10 1/mm", "100 1/mm", "1000 1/mm"]',
    )
    spectrum: fields.SpectralDensities | None = optional(
        "Power spectral densities C(q) of the heights there: a list or a column.",
        '["10 um^4", "2 um^4", "0.003 um^4"]',
    )
    rms: fields.Roughness | None = optional(
        "Rms height of a self-affine surface, in place of a spectrum.", '"0.5 um"'
    )
    hurst: fields.Share | None = optional("Its Hurst exponent.", "0.8")
    longest: fields.Roughness | None = optional("Its longest wave.", '"2 mm"')
    roll_off: fields.Roughness | None = optional(
        "Wavelength below which its spectrum falls; the longest if absent.", '"0.5 mm"'
    )
    shortest: fields.Roughness | None = optional(
        "Its shortest wave, which decides the slope.", '"5 um"'
    )
    area: fields.Area = required("Apparent area.", '"2 cm^2"')

    @model_validator(mode="after")
    def _check_spectrum(self) -> Self:
        spectrum = ("wavenumber", "spectrum")
        needed, excluded = (
            (spectrum, _SELF_AFFINE)
            if self.wavenumber is not None or self.spectrum is not None
            else (("rms", "hurst", "longest", "shortest"), spectrum)
        )
        for name in needed:
            if getattr(self, name) is None:
                raise KeyedError(
                    f"surface.{name}",
                    "missing; a spectrum is wavenumber and spectrum, or rms, hurst, longest and "
                    "shortest",
                )
        for name in excluded:
            if getattr(self, name) is not None:
                raise KeyedError(
                    f"surface.{name}", "wanted none beside wavenumber and spectrum; remove it"
                )
        try:
            self._curve(MaterialPair(Material(1e9, 0.3), Material.rigid()))
        except InputError as error:
            raise keyed(error, "surface", needed[-1]) from None
        return self

    def _curve(self, pair: MaterialPair) -> PerssonCurve:
        if self.wavenumber is not None:
            rings = PerssonCurve.Rings(np.array(self.wavenumber), np.array(self.spectrum))
            return PerssonCurve.from_spectrum(rings, pair, self.area)
        sizes = {name: getattr(self, name) for name in _SELF_AFFINE}
        sizes["roll_off"] = sizes["roll_off"] or sizes["longest"]
        return PerssonCurve.self_affine(pair, **sizes, area=self.area)

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Persson's law of the spectrum."""
        return self._curve(pair).to_surface()


_SELF_AFFINE = ("rms", "hurst", "longest", "roll_off", "shortest")

_OWN_TABLES: dict[str, type[Part]] = {"population": PopulationSurface, "table": TableSurface}
_HEIGHTS = Field(
    description="Distribution of the summit heights.",
    examples=['{ kind = "gaussian", std = "0.5 um" }'],
)


def _table_of_law(kind: type) -> type[Part]:
    """Table of a surface that says its parameters, beside materials and maybe heights."""
    has_heights = "heights" in {item.name for item in dataclasses.fields(kind)}
    extra_fields = {"heights": (AnyHeights, _HEIGHTS)} if has_heights else {}
    return table_of(kind, "law", "surface", __name__, DescribedSurface, extra_fields)


SURFACE_TABLES: dict[str, type[Any]] = {
    **{
        name: _OWN_TABLES[name] if name in _OWN_TABLES else _table_of_law(kind)
        for kind in NORMAL_LAWS
        if (name := key_of(kind)) in _OWN_TABLES or parameters_of(kind)
    },
    "persson": SpectralSurface,
    "scan": ScanSurface,
    "drawing": DrawnSurface,
    "two-faces": TwoFaces,
}
"""Tables of all exported normal laws by their name, and those of measured or drawn faces."""


def _material_tag(raw_value: Any) -> str:
    rigid = isinstance(raw_value, dict) and raw_value.get("rigid", False) is not False
    return "rigid" if rigid or isinstance(raw_value, Rigid) else "elastic"


AnyMaterial = Annotated[
    Annotated[Elastic, Tag("elastic")] | Annotated[Rigid, Tag("rigid")],
    Discriminator(_material_tag),
]
# Names that results still ask for.
GaussianHeights, ExponentialHeights, TableHeights = (
    HEIGHTS_TABLES[kind] for kind in ("gaussian", "exponential", "table")
)
globals().update({table.__name__: table for table in SURFACE_TABLES.values()})

if TYPE_CHECKING:
    AnySurface = PopulationSurface | TableSurface | ScanSurface | DescribedSurface | TwoFaces
else:
    AnySurface = Annotated[reduce(or_, SURFACE_TABLES.values()), Field(discriminator="law")]
