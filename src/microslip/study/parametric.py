"""Floor 10: tables of a study for classes that say their parameters, with nothing written twice.

A law, heights or a surface in an exported tuple is a table of a study at once: its key, the names,
units, limits and meanings of its parameters stand on the class.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, create_model, model_validator

from microslip._core.parameters import Parameter, key_of, parameters_of
from microslip._core.units import Kind, Sign
from microslip.errors import InputError
from microslip.study.columns import FromFile
from microslip.study.fields import MAX_VALUES, array, quantity
from microslip.study.part import Part, as_key, key, keyed
from microslip.study.uncertain import Uncertain


def labels_of(part: object) -> dict[str, tuple[str, str]]:
    """What the keys of a table that stands for a class are called in a report, and their units."""
    if not isinstance(part, Described):
        return {}
    options = parameters_of(part.describes)
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
        fields[parameter.name] = (
            _list_key(parameter, where)
            if parameter.many
            else (float, key(parameter, Uncertain(parameter.written)))
        )
    name = f"{kind.__name__}Table"
    model = create_model(name, __base__=base, __doc__=meaning, __module__=module, **fields)
    model.describes = kind
    return model


def _list_key(option: Parameter, where: str) -> tuple[Any, Any]:
    """A list of quantities, here or in a column of a file."""
    assert isinstance(option.kind, Kind)
    sign: Sign = "positive" if option.is_positive else "any"
    item = Annotated[float, quantity(option.kind, option.shown, sign)]
    example = f"[{option.written}]"
    lists = tuple[item, ...]
    read = FromFile(option.kind, f"{where}.{option.name}", sign)
    info = Field(
        description=f"{option.sentence[:-1]}: a list or a column of a CSV file.", examples=[example]
    )
    return Annotated[lists, array(example, MAX_VALUES), read], info
