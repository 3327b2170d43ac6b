"""Floor 8: the materials and surfaces that a study file may describe."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Discriminator, Field, Tag, ValidationInfo, model_validator

from microslip._core.units import LENGTH, engineering
from microslip.study.columns import Column, ColumnName, FileName, UnitName, text
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
    RisingHeights,
    Roughness,
    Separations,
    ShapeParameter,
    TabulatedDensity,
    TabulatedLoads,
    TwoNames,
    one_of,
)
from microslip.study.part import KeyedError, Part
from microslip.study.scanned_surface import ScanSurface

__all__ = [
    "AnyMaterial",
    "AnySurface",
    "Elastic",
    "ExponentialHeights",
    "GaussianHeights",
    "GivenHeights",
    "GreenwoodWilliamsonSurface",
    "KeyedError",
    "Part",
    "PopulationSurface",
    "Rigid",
    "ScanSurface",
    "ScipyHeights",
    "SphereSurface",
    "TableHeights",
    "TableSurface",
]


DistributionName = Annotated[str, text('the name of a distribution such as "weibull_min"')]


class Elastic(Part):
    """An elastic material [Pa, –, Pa]; its hardness only serves warnings."""

    rigid: Literal[False] = Field(default=False, description="Whether the body does not deform.")
    young_modulus: Modulus = Field(description="Young's modulus E.", examples=['"69 GPa"'])
    poisson_ratio: PoissonRatio = Field(description="Poisson's ratio.", examples=["0.33"])
    hardness: Hardness | None = Field(
        default=None,
        description="Indentation hardness; it changes no result, it adds the plasticity index.",
        examples=['"1.2 GPa"'],
    )


class Rigid(Part):
    """A body that does not deform."""

    rigid: Literal[True] = Field(description="A body that does not deform; it has no other key.")


class GaussianHeights(Part):
    """Normally distributed summit heights [m]."""

    kind: Literal["gaussian"] = Field(description="Normal distribution.")
    std: Roughness = Field(
        description="Standard deviation of the summit heights.", examples=['"0.5 um"']
    )
    mean: Height = Field(default=0.0, description="Mean height; 0 if absent.")


class ExponentialHeights(Part):
    """Exponentially distributed summit heights y ≥ 0 with their mean [m]."""

    kind: Literal["exponential"] = Field(description="Exponential distribution of heights >= 0.")
    scale: Roughness = Field(description="Mean height.", examples=['"0.8 um"'])


class GivenHeights(Part):
    """Summit heights one by one [m], all equally likely; here or in a CSV file."""

    model_config = ConfigDict(
        json_schema_extra={
            "required": ["kind"],
            "oneOf": [{"required": ["values"]}, {"required": ["file", "column"]}],
        }
    )

    kind: Literal["values"] = Field(description="Given heights, all equally likely.")
    values: Heights = Field(
        description="The heights, unless a file holds them.", examples=['["0.4 um", "0.7 um"]']
    )
    file: FileName | None = Field(
        default=None, description="CSV file that holds them instead.", examples=['"heights.csv"']
    )
    column: ColumnName | None = Field(
        default=None, description="Name of its column.", examples=['"y"']
    )
    unit: UnitName | None = Field(
        default=None,
        description='Unit of the column; not needed where its header has one, "[um]" or "(um)".',
        examples=['"um"'],
    )

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, given: Any, info: ValidationInfo) -> Any:
        if not isinstance(given, dict) or not given.keys() & {"file", "column", "unit"}:
            return given
        if "values" in given:
            if "file" not in given:
                key = "column" if "column" in given else "unit"
                raise KeyedError(f"surface.heights.{key}", "wanted only beside file, got values")
            raise KeyedError("surface.heights.file", "wanted values or a file, got both")
        keys = {key: value for key, value in given.items() if key != "kind"}
        column = Column.model_validate(keys, context=info.context)
        return {**given, "values": column.read(LENGTH, "any", info, "surface.heights")}


class ScipyHeights(Part):
    """Summit heights by a continuous distribution of scipy.stats, placed and scaled [m]."""

    kind: Literal["scipy"] = Field(description="A continuous distribution of scipy.stats.")
    distribution: DistributionName = Field(
        description='Name in scipy.stats, such as "weibull_min".', examples=['"weibull_min"']
    )
    parameters: dict[str, ShapeParameter] = Field(
        default_factory=dict,
        description="Shape parameters by the names that SciPy gives them; plain numbers.",
        examples=["{ c = 2.0 }"],
    )
    location: Height = Field(
        default=0.0, description="SciPy's loc, a shift of all heights; 0 if absent."
    )
    scale: Roughness = Field(description="SciPy's scale.", examples=['"1 um"'])

    def frozen(self) -> Any:
        """The frozen distribution of scipy.stats, heights in metres."""
        from scipy import stats

        distribution = getattr(stats, self.distribution)
        return distribution(**self.parameters, loc=self.location, scale=self.scale)

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        from microslip.study.distributions import check

        check(self)
        return self


class TableHeights(Part):
    """Summit heights by a table of their density: straight between its points, zero outside."""

    kind: Literal["table"] = Field(description="A density of heights as a table.")
    height: RisingHeights = Field(
        description="Heights, not falling: a list or a column of a CSV file.",
        examples=['["-1 um", "0 um", "1 um"]'],
    )
    density: TabulatedDensity = Field(
        description="Density at these, of any scale: a list or a column of a CSV file.",
        examples=['["0 1/um", "1 1/um", "0 1/um"]'],
    )

    def frozen(self) -> Any:
        """The distribution."""
        from microslip.heights import TabulatedHeights

        return TabulatedHeights(self.height, self.density)

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        from microslip.errors import InputError

        try:
            self.frozen()
        except InputError as error:
            name, _, message = str(error).partition(" ")
            raise KeyedError(f"surface.heights.{name}", message) from None
        return self


class GreenwoodWilliamsonSurface(Part):
    """Many summits of one radius [m], so many per area [1/m²], over an apparent area [m²]."""

    law: Literal["greenwood-williamson"] = Field(
        description="Summits of one radius and random heights."
    )
    materials: TwoNames = Field(
        description="Names of the two bodies: materials of this file or metals of the table.",
        examples=['["steel", "steel"]'],
    )
    heights: Annotated[
        GaussianHeights | ExponentialHeights | GivenHeights | ScipyHeights | TableHeights,
        Field(discriminator="kind"),
    ] = Field(
        description="Distribution of the summit heights.",
        examples=['{ kind = "gaussian", std = "0.5 um" }'],
    )
    radius: Radius = Field(description="Radius of the summits.", examples=['"1 mm"'])
    density: Density = Field(description="Summits per apparent area.", examples=['"100 1/mm^2"'])
    area: Area = Field(description="Apparent area.", examples=['"2 cm^2"'])


class PopulationSurface(Part):
    """A finite set of summits; one radius for all or one for each [m]."""

    law: Literal["population"] = Field(description="Given summits.")
    materials: TwoNames = Field(
        description="Names of the two bodies: materials of this file or metals of the table.",
        examples=['["steel", "steel"]'],
    )
    heights: Annotated[GivenHeights, Field(discriminator="kind")] = Field(
        description="Heights of the summits.",
        examples=['{ kind = "values", values = ["0.4 um", "0.7 um"] }'],
    )
    radius: Radii = Field(
        description="One radius, one for each height, or a column of a CSV file.",
        examples=['"1 mm"'],
    )

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

    law: Literal["sphere"] = Field(description="One sphere on a flat.")
    materials: TwoNames = Field(
        description="Names of the two bodies: materials of this file or metals of the table.",
        examples=['["steel", "steel"]'],
    )
    radius: Radius = Field(description="Radius of the sphere.", examples=['"5 mm"'])


class TableSurface(Part):
    """A measured or computed normal law: separations [m], their loads [N], how it goes on."""

    law: Literal["table"] = Field(description="A measured or computed normal law.")
    materials: TwoNames = Field(
        description="Names of the two bodies: materials of this file or metals of the table.",
        examples=['["steel", "steel"]'],
    )
    separation: Separations = Field(
        description="Separations, rising: a list or a column of a CSV file.",
        examples=['["0 um", "1 um", "2 um"]'],
    )
    load: TabulatedLoads = Field(
        description="Loads at these, falling and convex: a list or a column of a CSV file.",
        examples=['["2 kN", "0.5 kN", "0 N"]'],
    )
    tail: Annotated[Literal["exponential"], one_of("exponential")] | None = Field(
        default=None,
        description="How the law goes on where its last load is not zero.",
        examples=['"exponential"'],
    )

    @model_validator(mode="after")
    def _is_a_law(self) -> Self:
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


def _material_tag(given: Any) -> str:
    rigid = isinstance(given, dict) and given.get("rigid", False) is not False
    return "rigid" if rigid or isinstance(given, Rigid) else "elastic"


AnyMaterial = Annotated[
    Annotated[Elastic, Tag("elastic")] | Annotated[Rigid, Tag("rigid")],
    Discriminator(_material_tag),
]
AnySurface = Annotated[
    GreenwoodWilliamsonSurface | PopulationSurface | SphereSurface | TableSurface | ScanSurface,
    Field(discriminator="law"),
]
