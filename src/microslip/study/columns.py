"""Floor 8: a column of a CSV file, with its unit, as SI floats."""

from __future__ import annotations

import re
from collections.abc import Callable
from decimal import Decimal
from typing import Annotated, Any, NamedTuple

from pydantic import GetCoreSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from microslip._core.units import LARGEST, SMALLEST, Kind, Sign, factor_of, is_unit, times
from microslip._core.wording import shorten, show
from microslip.readers.dialect import with_hyphen
from microslip.readers.files import usable
from microslip.readers.tables import Named, find, understood
from microslip.readers.text import TextFile, open_text
from microslip.study.part import Check, Part, Reading, optional, required

MAX_BYTES = 256_000_000
MAX_ROWS = 1_000_000

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


def text(description: str, longest: int = 1000) -> Check:
    """Text on one line."""

    def check(raw_value: object) -> object:
        if isinstance(raw_value, str) and raw_value.isprintable() and 0 < len(raw_value) <= longest:
            return raw_value
        raise ValueError(f"wanted {description}, got {show(raw_value)}")

    return Check(check, lambda inner: {**inner, "minLength": 1, "maxLength": longest})


FileName = Annotated[str, text('the name of a CSV file such as "record.csv"')]
ColumnName = Annotated[str, text('the name of a column such as "x"')]
UnitName = Annotated[str, text('a unit such as "um"')]


class SiValues(tuple[float, ...]):
    """Values that have been read, in SI units."""

    __slots__ = ()


class Column(Part):
    """A column of a CSV file: its header says the unit, as in "x [um]", or `unit` does."""

    file: FileName = required(
        "CSV file with a line of column names; relative to the folder of the study.", '"record.csv"'
    )
    column: ColumnName = required(
        'Name of the column, with or without the unit of its header: "x" or "x [um]".', '"x"'
    )
    unit: UnitName | None = optional(
        'Unit of the column; not needed where its header has one, "[um]" or "(um)".', '"um"'
    )

    def read(self, kind: Kind, sign: Sign, info: ValidationInfo, key: str) -> SiValues:
        """Values of the column."""
        reading, name = Reading.of(info), shorten(self.file, 100)
        here = reading.path(self.file)
        try:
            with usable(here, "a CSV file"):
                file = open_text(here, MAX_BYTES)
            column = find(understood(file.columns), self.column)
            unit = _unit(column, self.unit, kind) if kind.unit else column.unit or "1"
            factor = factor_of(unit, kind, "") if kind.unit else _share(unit)
            values = _values(file, column.place, factor, sign, kind)
        except ValueError as error:
            raise ValueError(f"{name}: {reading.message(str(error), self.file)}") from None
        reading.notes.append(
            f'{key}: {len(values)} values from {name}, column "{shorten(column.heading, 60)}", '
            f"unit {unit}."
        )
        return SiValues(values)


class FromFile(NamedTuple):
    """Lets a :class:`Column` stand where a list of quantities is wanted."""

    kind: Kind
    quantity: str
    sign: Sign = "any"

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_wrap_validator_function(self._read, handler(source))

    def _read(
        self, raw_value: object, handler: Callable[[object], object], info: ValidationInfo
    ) -> object:
        if isinstance(raw_value, dict):
            raw_value = Column.model_validate(raw_value, context=info.context)
        if isinstance(raw_value, Column):
            raw_value = raw_value.read(self.kind, self.sign, info, self.quantity)
        return raw_value if isinstance(raw_value, SiValues) else handler(raw_value)


def _unit(column: Named, stated_unit: str | None, kind: Kind) -> str:
    """Unit of a column by its header or by the study, which must not differ."""
    in_head = column.unit if column.unit and is_unit(column.unit) else None
    where, usual = f'column "{shorten(column.heading, 40)}": ', kind.usual[1]
    # What is no unit, "(left)", is no harm once there is one.
    unit = stated_unit or in_head or column.unit
    if not unit:
        raise ValueError(
            f'{where}no unit; write it in the header, such as "[{usual}]", or unit = "{usual}"'
        )
    message = f'{where}wanted a unit such as "{usual}", got '
    factor = factor_of(unit, kind, message + show(unit))
    if in_head and factor != factor_of(in_head, kind, message + show(in_head)):
        raise ValueError(
            f'{where}wanted unit = "{in_head}" as in the header, or no unit, got "{unit}"'
        )
    return unit


def _share(unit: str) -> Decimal:
    """What a plain number is multiplied with: it may be in percent."""
    return Decimal("0.01") if unit.lower() in ("%", "percent") else Decimal(1)


def _values(file: TextFile, place: int, factor: Decimal, sign: Sign, kind: Kind) -> list[float]:
    """The numbers of one column [SI unit of `kind`], each the nearest double."""
    _, digits, exponent = factor.normalize().as_tuple()
    power = f"e{exponent}" if digits == (1,) else None
    values = list[float]()
    for line, cell in file.cells(place):
        value = _si(file, line, place, cell, factor, power)
        if value <= 0.0 and sign == "positive":
            name = shorten(file.layout.names[place], 40)
            raise ValueError(
                f'line {line}, column "{name}": wanted a positive {kind.name}, got {show(cell)}'
            )
        if len(values) == MAX_ROWS:
            raise ValueError(f"wanted at most {MAX_ROWS} rows, got more")
        values.append(value)
    return values


def _si(
    file: TextFile, line: int, place: int, cell: str, factor: Decimal, power: str | None
) -> float:
    """Number in a cell, in the unit of this factor, as SI float."""
    number = with_hyphen(cell)
    if file.decimal == "," and "." not in cell:
        number = number.replace(",", ".")
    if not _NUMBER.fullmatch(number) or (file.decimal == "," and "." in cell):
        hint = f' (a unit stands in the header, "x [{cell}]")' if cell and is_unit(cell) else ""
        raise ValueError(f"{file.no_number(line, place, cell)}{hint}")
    # A power of ten goes into the exponent, so that each number is the nearest double.
    if power is not None and "e" not in number and "E" not in number:
        value = float(number + power)
    else:
        value = times(number, factor)
    if not SMALLEST < abs(value) < LARGEST and value:
        raise ValueError(f"{file.no_number(line, place, cell)} (beyond all measure)")
    return value
