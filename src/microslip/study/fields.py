"""Kinds of value that many keys of a study share, and tables for classes that declare theirs.

A law, heights or a surface in an exported tuple is a table of a study at once: its key, the names,
units, limits and meanings of its parameters stand on the class.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

from microslip._core import units
from microslip._core.parameters import (
    REQUIRED,
    Parameter,
    key_of,
    option,
    parameter_of,
    parameters_of,
)
from microslip._core.units import Kind
from microslip.study.columns import Numbers
from microslip.study.part import Part, key, tag
from microslip.study.readers import Items, Place
from microslip.study.uncertain import Unsure

# -- values ----------------------------------------------------------------------------------------


def quantity(kind: Kind, example: str, sign: str = "positive") -> Parameter:
    """A value with its unit, such as ``example``."""
    return option("", "", kind, example=example, sign=sign, default=REQUIRED)


def number(example: str = "", **limits: float) -> Parameter:
    """A plain number within limits."""
    return Parameter("", example=example, kind=float, **limits)  # type: ignore[arg-type]


def whole_number(low: int, high: int, example: str = "", noun: str = "") -> Parameter:
    """A whole number from ``low`` to ``high``."""
    return Parameter("", least=low, most=high, kind=int, example=example, noun=noun)


def text(noun: str, example: str = "", longest: int = 1000) -> Parameter:
    """Text on one line."""
    return Parameter("", kind=str, noun=noun, example=example, most=longest)


def one_of(*words: str) -> Parameter:
    """One of some words."""
    return Parameter("", choices=words, example=words[0])


YES_NO = Parameter("", kind=bool, example="")
LINE = text("one line of at most 200 characters", longest=200)
MATERIALS = key(
    Items(text("the name of a body", "steel"), '["steel", "steel"]', (2, 2)),
    "Names of the two bodies: materials of this file or metals of the table.",
)
LENGTH = quantity(units.LENGTH, "25 mm")
PLACE = quantity(units.LENGTH, "30 mm", "any")
HEIGHT = quantity(units.LENGTH, "0.5 um", "any")
ROUGHNESS = Unsure(quantity(units.LENGTH, "0.5 um"))
RADIUS = quantity(units.LENGTH, "1 mm")
AMPLITUDE = quantity(units.LENGTH, "1 um")
AREA = quantity(units.AREA, "2 cm^2")
DENSITY = quantity(units.DENSITY, "100 1/mm^2")
LOAD = quantity(units.FORCE, "2 kN")
TENSION = quantity(units.FORCE, "12 kN")
YIELD_STRESS = quantity(units.PRESSURE, "355 MPa")
MASS = quantity(units.MASS, "10 g")
TORQUE = quantity(units.TORQUE, "20 N m")
MASS_DENSITY = quantity(units.MASS_DENSITY, "7850 kg/m^3")
ANGLE = quantity(units.ANGLE, "90 deg", "any").but(
    least=-2.0 * math.pi, most=2.0 * math.pi, why="a turn at most"
)
FRICTION = number("0.55", above=0.0, most=1e6)
VISCOUS_RATIO = number("0.01", least=0.0, below=1.0)
SHARE = number("0.2", above=0.0, most=1.0)


# -- tables for classes ----------------------------------------------------------------------------


class Described(Part):
    """A table of a study that stands for a class of the library."""

    describes: ClassVar[type]
    """The class."""

    def values(self) -> dict[str, Any]:
        """Arguments of the class, in SI units."""
        return {item.name: getattr(self, item.name) for item in parameters_of(self.describes)}


class DescribedAlone(Described):
    """One whose class needs nothing but its parameters, such as heights or a friction law."""

    def build(self) -> Any:
        """An instance of the class."""
        return self.describes(**self.values())

    def check(self, place: Place) -> None:
        """Refuse here whatever the class refuses."""
        self.build()


def can_be_described(kind: type) -> bool:
    """Whether all that a class needs are declared parameters."""
    if not dataclasses.is_dataclass(kind) or not parameters_of(kind):
        return False
    names = {item.name for item in parameters_of(kind)}
    return all(
        item.name in names
        for item in dataclasses.fields(kind)
        if item.init
        and item.default is dataclasses.MISSING
        and item.default_factory is dataclasses.MISSING
    )


def key_for(declared: Parameter, **changes: Any) -> Any:
    """The key of a study for a number that a class declares; it may be uncertain, or a list."""
    return key(Numbers(declared) if declared.many else Unsure(declared), **changes)


def optional(kind: type, name: str, **changes: Any) -> Any:
    """The key for one number of a class that the study, or something beside it, may leave out."""
    return key_for(parameter_of(kind, name), default=None, **changes)


def table_of(
    kind: type,
    tag_name: str,
    module: str,
    base: type[Described] = DescribedAlone,
    extra_keys: Mapping[str, Any] = MappingProxyType({}),
) -> type[Any]:
    """The table of a study for a class."""
    meaning = (kind.__doc__ or kind.__name__).split("\n")[0]
    keys = {tag_name: tag(key_of(kind), meaning), **extra_keys}
    keys |= {declared.name: key_for(declared) for declared in parameters_of(kind)}
    body = {"__doc__": meaning, "__module__": module, "describes": kind, **keys}
    return type(f"{kind.__name__}Table", (base,), body)
