"""Floor 8: the materials and surfaces that a study file may describe."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

from microslip.study.fields import (
    Area,
    Density,
    Hardness,
    Height,
    Heights,
    Modulus,
    PoissonRatio,
    Radii,
    Radius,
    Roughness,
    TabulatedLoads,
    TwoNames,
    one_of,
)


class KeyedError(ValueError):
    """Something wrong that only shows in the whole; it says at which key."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Part(BaseModel):
    """A table of a study file: frozen, and without keys that nobody reads."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Elastic(Part):
    """An elastic material [Pa, –, Pa]; its hardness only serves warnings."""

    rigid: Literal[False] = False
    young_modulus: Modulus = Field(examples=['"69 GPa"'])
    poisson_ratio: PoissonRatio = Field(examples=["0.33"])
    hardness: Hardness | None = None


class Rigid(Part):
    """A body that does not deform."""

    rigid: Literal[True]


class GaussianHeights(Part):
    """Normally distributed summit heights [m]."""

    kind: Literal["gaussian"]
    std: Roughness = Field(examples=['"0.5 um"'])
    mean: Height = 0.0


class ExponentialHeights(Part):
    """Exponentially distributed summit heights y ≥ 0 with their mean [m]."""

    kind: Literal["exponential"]
    scale: Roughness = Field(examples=['"0.8 um"'])


class GivenHeights(Part):
    """Summit heights one by one [m], all equally likely."""

    kind: Literal["values"]
    values: Heights = Field(examples=['["0.4 um", "0.7 um"]'])


class GreenwoodWilliamsonSurface(Part):
    """Many summits of one radius [m], so many per area [1/m²], over an apparent area [m²]."""

    law: Literal["greenwood-williamson"]
    materials: TwoNames = Field(examples=['["steel", "steel"]'])
    heights: Annotated[
        GaussianHeights | ExponentialHeights | GivenHeights, Field(discriminator="kind")
    ] = Field(examples=['{ kind = "gaussian", std = "0.5 um" }'])
    radius: Radius = Field(examples=['"1 mm"'])
    density: Density = Field(examples=['"100 1/mm^2"'])
    area: Area = Field(examples=['"2 cm^2"'])


class PopulationSurface(Part):
    """A finite set of summits; one radius for all or one for each [m]."""

    law: Literal["population"]
    materials: TwoNames = Field(examples=['["steel", "steel"]'])
    heights: Annotated[GivenHeights, Field(discriminator="kind")] = Field(
        examples=['{ kind = "values", values = ["0.4 um", "0.7 um"] }']
    )
    radius: Radii = Field(examples=['"1 mm"'])

    @model_validator(mode="after")
    def _radii_match(self) -> Self:
        wanted, got = len(self.heights.values), len(self.radius)
        if got not in (1, wanted):
            raise KeyedError(
                "surface.radius",
                f"wanted one radius, or one for each of the {wanted} heights, got {got}",
            )
        return self


class SphereSurface(Part):
    """One sphere of a radius [m] on a flat."""

    law: Literal["sphere"]
    materials: TwoNames = Field(examples=['["steel", "steel"]'])
    radius: Radius = Field(examples=['"5 mm"'])


class TableSurface(Part):
    """A measured or computed normal law: separations [m], their loads [N], how it goes on."""

    law: Literal["table"]
    materials: TwoNames = Field(examples=['["steel", "steel"]'])
    separation: Heights = Field(examples=['["0 um", "1 um", "2 um"]'])
    load: TabulatedLoads = Field(examples=['["2 kN", "0.5 kN", "0 N"]'])
    tail: Annotated[Literal["exponential"], one_of("exponential")] | None = None


def _material_tag(given: Any) -> str:
    rigid = isinstance(given, dict) and given.get("rigid", False) is not False
    return "rigid" if rigid or isinstance(given, Rigid) else "elastic"


AnyMaterial = Annotated[
    Annotated[Elastic, Tag("elastic")] | Annotated[Rigid, Tag("rigid")],
    Discriminator(_material_tag),
]
AnySurface = Annotated[
    GreenwoodWilliamsonSurface | PopulationSurface | SphereSurface | TableSurface,
    Field(discriminator="law"),
]
