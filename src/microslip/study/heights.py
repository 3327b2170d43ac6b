"""Floor 10: the summit heights that a study may describe, SciPy's distributions among them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, ValidationInfo, model_validator

from microslip._core.parameters import key_of
from microslip._core.units import LENGTH
from microslip._core.wording import did_you_mean, quoted, shorten, show
from microslip.errors import InputError
from microslip.heights import HEIGHTS, Statistical
from microslip.study.columns import Column, ColumnName, FileName, UnitName, text
from microslip.study.fields import Height, Heights, Roughness, ShapeParameter
from microslip.study.parametric import DescribedAlone, can_be_described, table_of
from microslip.study.part import KeyedError, Part, optional, required

DistributionName = Annotated[str, text('the name of a distribution such as "weibull_min"')]


_KEY = "surface.heights"
_ALSO_CALLED = {
    "gaussian": "norm",
    "normal": "norm",
    "exponential": "expon",
    "lognormal": "lognorm",
    "weibull": "weibull_min",
}


def distribution_names() -> list[str]:
    """Names of the continuous distributions of scipy.stats."""
    from scipy import stats

    return [name for name in dir(stats) if isinstance(getattr(stats, name), stats.rv_continuous)]


def _frozen(name: str, parameters: Mapping[str, float], location: float, scale: float) -> Any:
    """The frozen distribution of scipy.stats, heights in metres."""
    from scipy import stats

    return getattr(stats, name)(**parameters, loc=location, scale=scale)


def _check_scipy(name: str, parameters: Mapping[str, float], location: float, scale: float) -> None:
    """Raise a KeyedError about heights of kind "scipy" that are none, or have no finite load."""
    from scipy import stats

    distribution = getattr(stats, name, None)
    if not isinstance(distribution, stats.rv_continuous):
        raise KeyedError(f"{_KEY}.distribution", f"wanted {_expected_name(name, distribution)}")
    shapes = distribution.shapes.replace(",", " ").split() if distribution.shapes else []
    _check_names(name, shapes, parameters)
    of = f"{name} with {_values(parameters)}" if parameters else name
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            heights = _frozen(name, parameters, location, scale)
            # SciPy says no by a support that is no number.
            if any(map(math.isnan, heights.support())):
                raise ValueError("out of their range")
        except Exception as error:  # whatever its functions meet
            fault = f"wanted values that scipy.stats.{name} takes, got {_values(parameters)}"
            raise KeyedError(f"{_KEY}.parameters", f"{fault} ({_reason(error)})") from None
        try:
            Statistical(heights)
        except InputError as error:
            message = str(error).removeprefix("heights must have ")
            raise KeyedError(_KEY, f"wanted {message} ({of})") from None
        except Exception as error:
            raise KeyedError(_KEY, f"SciPy fails for {of}: {_reason(error)}") from None


def _expected_name(name: str, candidate: Any) -> str:
    from scipy import stats

    example = 'a continuous distribution of scipy.stats such as "weibull_min"'
    if isinstance(candidate, stats.rv_discrete):
        return f"{example}, got {show(name)} (a discrete one)"
    synonym = _ALSO_CALLED.get(name.casefold())
    return f"{example}, got {show(name)}{did_you_mean(synonym or name, distribution_names())}"


def _check_names(name: str, shapes: list[str], parameters: Mapping[str, float]) -> None:
    has = f'"{name}" has no shape parameters'
    if shapes:
        has = f'"{name}" has the shape parameter{"s" * (len(shapes) > 1)} {quoted(shapes, "and")}'
    for key in parameters:
        if key in ("loc", "scale"):
            study_key = "location" if key == "loc" else "scale"
            raise KeyedError(
                f"{_KEY}.parameters.{key}",
                f'wanted {study_key} = "1 um" beside distribution instead',
            )
        if key not in shapes:
            hint = did_you_mean(key, shapes) or f"; {has}"
            raise KeyedError(f"{_KEY}.parameters.{shorten(key, 40)}", f"unknown parameter{hint}")
    for key in shapes:
        if key not in parameters:
            raise KeyedError(f"{_KEY}.parameters.{key}", f"missing; {has}")


def _values(parameters: Mapping[str, float]) -> str:
    return ", ".join(f"{key} = {value:g}" for key, value in parameters.items())


def _reason(error: Exception) -> str:
    return shorten(" ".join(str(error).split()) or type(error).__name__, 120)


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
        return _frozen(self.distribution, self.parameters, self.location, self.scale)

    @model_validator(mode="after")
    def _check_distribution(self) -> Self:
        _check_scipy(self.distribution, self.parameters, self.location, self.scale)
        return self


_OWN_TABLES: dict[str, type[Part]] = {"values": GivenHeights, "scipy": ScipyHeights}

HEIGHTS_TABLES: dict[str, type[Any]] = {
    name: _OWN_TABLES[name]
    if name in _OWN_TABLES
    else table_of(kind, "kind", "surface.heights", __name__)
    for kind in HEIGHTS
    if (name := key_of(kind)) in _OWN_TABLES or can_be_described(kind)
}
"""Tables of all exported heights by their kind."""

globals().update({table.__name__: table for table in HEIGHTS_TABLES.values()})

if TYPE_CHECKING:
    AnyHeights = GivenHeights | ScipyHeights | DescribedAlone
else:
    AnyHeights = Annotated[reduce(or_, HEIGHTS_TABLES.values()), Field(discriminator="kind")]
