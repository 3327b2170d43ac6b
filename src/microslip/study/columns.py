"""A column of a CSV file, with its unit, as SI floats."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Any

from microslip._core.parameters import REQUIRED, JsonSchema, Parameter, option
from microslip._core.units import LARGEST, SMALLEST, Kind, factor_of, is_unit, times
from microslip._core.wording import shorten, show
from microslip.readers.dialect import with_hyphen
from microslip.readers.files import usable
from microslip.readers.tables import Named, find, understood
from microslip.readers.text import TextFile, open_text
from microslip.study.part import Part, key
from microslip.study.readers import FAILED, Items, Place

MAX_BYTES = 256_000_000
MAX_ROWS = 1_000_000
MAX_VALUES = 1_000_000

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)

FILE = option(
    "file",
    "CSV file with a line of column names; relative to the folder of the study.",
    noun="the name of a CSV file",
    example="record.csv",
)
COLUMN = option(
    "column",
    'Name of the column, with or without the unit of its header: "x" or "x [um]".',
    noun="the name of a column",
    example="x",
)
COLUMN_UNIT = option(
    "unit",
    'Unit of the column; not needed where its header has one, "[um]" or "(um)".',
    noun="a unit",
    example="um",
)


class SiValues(tuple[float, ...]):
    """Values that have been read, in SI units."""

    __slots__ = ()


class Column(Part):
    """A column of a CSV file: its header says the unit, as in "x [um]", or `unit` does."""

    file: str = key(FILE, default=REQUIRED)
    column: str = key(COLUMN, default=REQUIRED)
    unit: str | None = key(COLUMN_UNIT)

    def values(self, declared: Parameter, place: Place) -> SiValues:
        """Values of the column, of a quantity that is declared."""
        return column_values(declared, place, self.file, self.column, self.unit)


def column_values(
    declared: Parameter, place: Place, file_name: str, column_name: str, unit: str | None = None
) -> SiValues:
    """Values of a column of a file, of a quantity that is declared; where from is noted."""
    reading, name = place.reading, shorten(file_name, 100)
    here = reading.path(file_name)
    kind = declared.kind if isinstance(declared.kind, Kind) else None
    try:
        with usable(here, "a CSV file"):
            file = open_text(here, MAX_BYTES)
        column = find(understood(file.columns), column_name)
        unit = _unit(column, unit, kind) if kind else unit or column.unit or "1"
        factor = factor_of(unit, kind, "") if kind else _share(unit)
        values = _values(file, column.place, factor, declared)
    except ValueError as error:
        raise ValueError(f"{name}: {reading.message(str(error), file_name)}") from None
    reading.notes.append(
        f'{place.key}: {len(values)} values from {name}, column "{shorten(column.heading, 60)}", '
        f"unit {unit}."
    )
    return SiValues(values)


class Numbers(Items):
    """A list of declared numbers, in the study or in a column of a file."""

    def __init__(self, item: Parameter, example: str = "", *, single: bool = False) -> None:
        super().__init__(item, example or f"[{item.written}]", (1, MAX_VALUES), single=single)
        self.declared = item
        self.help = f"{item.sentence[:-1]}: a list or a column of a CSV file."

    def read(self, raw_value: object, place: Place) -> Any:
        """A tuple of SI values."""
        if isinstance(raw_value, SiValues):
            return raw_value
        if isinstance(raw_value, dict):
            column = Column.read(raw_value, place)
            return column if column is FAILED else column.values(self.declared, place)
        return super().read(raw_value, place)

    def schema(self) -> JsonSchema:
        """The list, or the column."""
        several = super().schema()
        return {"anyOf": [*several.get("anyOf", [several]), Column.schema()]}


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
    """Factor of a plain number: it may be in percent."""
    return Decimal("0.01") if unit.lower() in ("%", "percent") else Decimal(1)


def _values(file: TextFile, place: int, factor: Decimal, declared: Parameter) -> list[float]:
    """The numbers of one column [SI unit of what is declared], each the nearest double."""
    _, digits, exponent = factor.normalize().as_tuple()
    power = f"e{exponent}" if digits == (1,) else None
    values = list[float]()
    for line, cell in file.cells(place):
        value = _si(file, line, place, cell, factor, power)
        if not declared.holds(value):
            where = f'line {line}, column "{shorten(file.layout.names[place], 40)}"'
            noun = declared.kind.name if isinstance(declared.kind, Kind) else "number"
            noun = f"a positive {noun}" if declared.is_positive else declared.limited(f"a {noun}")
            raise ValueError(f"{where}: wanted {noun}, got {show(cell)}")
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
        raise ValueError(f"{file.no_number(line, place, cell)} (outside 1e-40 … 1e40)")
    return value
