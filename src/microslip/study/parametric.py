"""Floor 10: tables of a study for classes that say their parameters, with nothing written twice.

A law, heights or a surface in an exported tuple is a table of a study at once: its key, the names,
units, limits and meanings of its parameters stand on the class.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, create_model, model_validator

from microslip._core.options import REQUIRED, Option
from microslip._core.parameters import Parameter, key_of, parameters_of
from microslip._core.units import ANGLE, AREA, DENSITY, FORCE, LENGTH, PRESSURE, STIFFNESS, Kind
from microslip.errors import InputError
from microslip.study.columns import FromFile
from microslip.study.fields import MAX_VALUES, PER_LENGTH, array, quantity
from microslip.study.part import Part, as_key, key, keyed
from microslip.study.uncertain import Uncertain

_KINDS = {
    kind.unit: kind
    for kind in (LENGTH, AREA, FORCE, PRESSURE, DENSITY, STIFFNESS, PER_LENGTH, ANGLE)
}
# Units in which people write an example, the first one in which it is no small fraction.
_WRITTEN = {
    "m": ((1e-3, "mm"), (1e-6, "um"), (1e-9, "nm")),
    "m^2": ((1e-4, "cm^2"), (1e-6, "mm^2")),
    "N": ((1.0, "N"),),
    "Pa": ((1e9, "GPa"), (1e6, "MPa")),
    "1/m^2": ((1e6, "1/mm^2"),),
    "N/m": ((1e6, "N/um"), (1.0, "N/m")),
    "1/m": ((1e6, "1/um"), (1.0, "1/m")),
    "rad": ((math.pi / 180.0, "deg"),),
}
_USUAL = {"m": 5e-7, "m^2": 2e-4, "N": 100.0, "Pa": 69e9, "1/m^2": 1e8, "N/m": 5e7, "1/m": 5e5}


def _example_text(parameter: Parameter) -> str:
    """An example of a parameter as a file has it."""
    unit, value = parameter.unit, parameter.example
    value = _USUAL.get(unit, value) if value == 1.0 else value
    for factor, name in _WRITTEN.get(unit, ()):
        if abs(value) >= 0.099 * factor:
            return f"{value / factor:.6g} {name}"
    return f"{value:g} {unit}".strip()


def option_of(parameter: Parameter) -> Option:
    """The key of a study for a parameter of a class."""
    unit = parameter.unit
    kind = _KINDS.get(unit, Kind(f"value in {unit}", unit, (unit,))) if unit else float
    meaning = parameter.meaning or parameter.name.replace("_", " ")

    def limit(value: float) -> float | None:
        return value if math.isfinite(value) and not unit else None

    return Option(
        parameter.name,
        f"{meaning[:1].upper()}{meaning[1:]}.",
        kind,
        label=f"{meaning[:1].upper()}{meaning[1:]}",
        default=REQUIRED if parameter.default is None else parameter.default,
        example=_example_text(parameter),
        above=limit(parameter.above),
        low=limit(parameter.least),
        high=limit(parameter.most),
        below=limit(parameter.below),
        sign="positive" if parameter.is_positive else "any",
    )


def labels_of(part: object) -> dict[str, tuple[str, str]]:
    """What the keys of a table that stands for a class are called in a report, and their units."""
    if not isinstance(part, Described):
        return {}
    options = map(option_of, parameters_of(part.describes))
    return {option.name: (option.heading, option.unit.replace("^2", "²")) for option in options}


class Described(Part):
    """A table of a study that stands for a class of the library."""

    describes: ClassVar[type]
    """The class."""

    def values(self) -> dict[str, Any]:
        """What the class is made of, in SI units."""
        return {item.name: getattr(self, item.name) for item in parameters_of(self.describes)}


class DescribedAlone(Described):
    """One whose class needs nothing but its parameters, such as heights or a friction law."""

    def build(self) -> Any:
        """An instance of the class."""
        return self.describes(**self.values())

    @model_validator(mode="after")
    def _check_values(self) -> Self:
        try:
            self.build()
        except InputError as error:
            if error.argument in type(self).model_fields:
                raise keyed(error, "") from None
            raise ValueError(error.said(as_key)) from None
        return self


def can_be_described(kind: type) -> bool:
    """Whether all that a class needs are parameters that it says."""
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


def table_of(
    kind: type,
    tag: str,
    where: str,
    module: str,
    base: type[Described] = DescribedAlone,
    extra_fields: Mapping[str, Any] = MappingProxyType({}),
) -> type[Any]:
    """The table of a study for a class."""
    meaning = (kind.__doc__ or kind.__name__).split("\n")[0]
    fields: dict[str, Any] = {
        tag: (Literal[key_of(kind)], Field(description=meaning)),
        **extra_fields,
    }
    for parameter in parameters_of(kind):
        option = option_of(parameter)
        fields[option.name] = (
            _list_key(option, where)
            if parameter.many
            else (float, key(option, Uncertain(option.written or option.example)))
        )
    name = f"{kind.__name__}Table"
    model = create_model(name, __base__=base, __doc__=meaning, __module__=module, **fields)
    model.describes = kind
    return model


def _list_key(option: Option, where: str) -> tuple[Any, Any]:
    """A list of quantities, here or in a column of a file."""
    assert isinstance(option.kind, Kind)
    item = Annotated[float, quantity(option.kind, option.example, option.sign)]
    example = f'["{option.example}"]'
    lists = tuple[item, ...]
    read = FromFile(option.kind, f"{where}.{option.name}", option.sign)
    info = Field(
        description=f"{option.help[:-1]}: a list or a column of a CSV file.", examples=[example]
    )
    return Annotated[lists, array(example, MAX_VALUES), read], info
