"""Floor 10: the summit heights that a study may describe."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, ValidationInfo, model_validator

from microslip._core.parameters import key_of
from microslip._core.units import LENGTH
from microslip.heights import HEIGHTS
from microslip.study.columns import Column, ColumnName, FileName, UnitName, text
from microslip.study.distributions import check, frozen
from microslip.study.fields import Height, Heights, Roughness, ShapeParameter
from microslip.study.parametric import DescribedAlone, can_be_described, table_of
from microslip.study.part import KeyedError, Part, optional, required

DistributionName = Annotated[str, text('the name of a distribution such as "weibull_min"')]


class GivenHeights(Part):
    """Summit heights one by one [m], all equally likely; here or in a CSV file."""

    model_config = ConfigDict(
        json_schema_extra={
            "required": ["kind"],
            "oneOf": [{"required": ["values"]}, {"required": ["file", "column"]}],
        }
    )

    kind: Literal["values"] = required("Given heights, all equally likely.")
    values: Heights = required("The heights, unless a file holds them.", '["0.4 um", "0.7 um"]')
    file: FileName | None = optional("CSV file that holds them instead.", '"heights.csv"')
    column: ColumnName | None = optional("Name of its column.", '"y"')
    unit: UnitName | None = optional(
        'Unit of the column; not needed where its header has one, "[um]" or "(um)".', '"um"'
    )

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, raw_value: Any, info: ValidationInfo) -> Any:
        if not isinstance(raw_value, dict) or not raw_value.keys() & {"file", "column", "unit"}:
            return raw_value
        if "values" in raw_value:
            if "file" not in raw_value:
                key = "column" if "column" in raw_value else "unit"
                raise KeyedError(f"surface.heights.{key}", "wanted only beside file, got values")
            raise KeyedError("surface.heights.file", "wanted values or a file, got both")
        keys = {key: value for key, value in raw_value.items() if key != "kind"}
        column = Column.model_validate(keys, context=info.context)
        return {**raw_value, "values": column.read(LENGTH, "any", info, "surface.heights")}

    def build(self) -> Any:
        """The heights, one by one."""
        return np.array(self.values)


class ScipyHeights(Part):
    """Summit heights by a continuous distribution of scipy.stats, placed and scaled [m]."""

    kind: Literal["scipy"] = required("A continuous distribution of scipy.stats.")
    distribution: DistributionName = required(
        'Name in scipy.stats, such as "weibull_min".', '"weibull_min"'
    )
    parameters: dict[str, ShapeParameter] = Field(
        default_factory=dict,
        description="Shape parameters by the names that SciPy gives them; plain numbers.",
        examples=["{ c = 2.0 }"],
    )
    location: Height = optional("SciPy's loc, a shift of all heights; 0 if absent.", default=0.0)
    scale: Roughness = required("SciPy's scale.", '"1 um"')

    def build(self) -> Any:
        """The frozen distribution of scipy.stats, heights in metres."""
        return frozen(self.distribution, self.parameters, self.location, self.scale)

    @model_validator(mode="after")
    def _check_distribution(self) -> Self:
        check(self.distribution, self.parameters, self.location, self.scale)
        return self


_OWN: dict[str, type[Part]] = {"values": GivenHeights, "scipy": ScipyHeights}

HEIGHTS_TABLES: dict[str, type[Any]] = {
    name: _OWN[name] if name in _OWN else table_of(kind, "kind", "surface.heights", __name__)
    for kind in HEIGHTS
    if (name := key_of(kind)) in _OWN or can_be_described(kind)
}
"""Tables of all exported heights by their kind."""

globals().update({table.__name__: table for table in HEIGHTS_TABLES.values()})

if TYPE_CHECKING:
    AnyHeights = GivenHeights | ScipyHeights | DescribedAlone
else:
    AnyHeights = Annotated[reduce(or_, HEIGHTS_TABLES.values()), Field(discriminator="kind")]
