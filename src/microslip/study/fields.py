"""Declarations shared by many keys of a study, and columns of CSV files."""

from __future__ import annotations

import math
import re
from decimal import Decimal
from typing import Any

from microslip._core import units
from microslip._core.options import Option, option
from microslip._core.parameters import (
    REQUIRED,
    JsonSchema,
    Number,
    parameter_of,
)
from microslip._core.units import LARGEST, SMALLEST, Kind, factor_of, is_unit, scaled_decimal
from microslip._core.wording import quote, shorten
from microslip.readers.dialect import with_hyphen
from microslip.readers.files import usable
from microslip.readers.tables import Named, find, understood
from microslip.readers.text import TextFile, open_text
from microslip.study.part import Part, key
from microslip.study.readers import ListOf, Place
from microslip.study.uncertain import Uncertain

# -- values ----------------------------------------------------------------------------------------


def with_unit(kind: Kind, example: str, sign: str = "positive") -> Option:
    """Declare a quantity of a ``kind``, such as length; above zero unless ``sign`` is "any"."""
    return option("", "", kind, example=example, sign=sign, default=REQUIRED)


def scalar(example: str = "", **limits: float) -> Number:
    """Declare a dimensionless number within limits."""
    return Number("", example=example, **limits)  # type: ignore[arg-type]


def integer(low: int, high: int, example: str = "", noun: str = "") -> Option:
    """Declare a whole number from ``low`` to ``high``."""
    return Option("", least=low, most=high, kind=int, example=example, noun=noun)


def text(noun: str, example: str = "", longest: int = 1000) -> Option:
    """Declare a text of one line."""
    return Option("", noun=noun, example=example, most=longest)


def one_of(*words: str) -> Option:
    """Declare a choice of words."""
    return Option("", choices=words, example=words[0])


YES_NO = Option("", kind=bool)
LINE = text("one line of at most 200 characters", longest=200)
MATERIALS = key(
    ListOf(text("the name of a body", "steel"), '["steel", "steel"]', (2, 2)),
    "Names of the two bodies: materials of this file or metals of the table.",
)
POSITIVE_LENGTH = with_unit(units.LENGTH, "25 mm")
PLACE = with_unit(units.LENGTH, "30 mm", "any")
ANY_HEIGHT = with_unit(units.LENGTH, "0.5 um", "any")
UNCERTAIN_LENGTH = Uncertain(with_unit(units.LENGTH, "0.5 um"))
RADIUS = with_unit(units.LENGTH, "1 mm")
AMPLITUDE = with_unit(units.LENGTH, "1 um")
POSITIVE_AREA = with_unit(units.AREA, "2 cm^2")
LOAD = with_unit(units.FORCE, "2 kN")
POSITIVE_DENSITY = with_unit(units.MASS_DENSITY, "7850 kg/m^3")
ANY_ANGLE = with_unit(units.ANGLE, "90 deg", "any").but(
    least=-2.0 * math.pi, most=2.0 * math.pi, why="a turn at most"
)
_FRICTION = scalar("0.55", above=0.0, most=1e6)
VISCOUS_RATIO = scalar("0.01", least=0.0, below=1.0)
FRACTION = scalar("0.2", above=0.0, most=1.0)


# -- columns of files ------------------------------------------------------------------------------

_MAX_BYTES = 256_000_000
MAX_ROWS = 1_000_000
MAX_VALUES = 1_000_000

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)

FILE = option(
    "file",
    "CSV file with a line of column names; relative to the folder of the study.",
    noun="the name of a CSV file",
    default=REQUIRED,
    example="record.csv",
)
COLUMN = option(
    "column",
    'Name of the column, with or without the unit of its header: "x" or "x [um]".',
    noun="the name of a column",
    default=REQUIRED,
    example="x",
)
COLUMN_UNIT = option(
    "unit",
    'Unit of the column; not needed where its header has one, "[um]" or "(um)".',
    noun="a unit",
    example="um",
)


class CsvColumn(Part):
    """A column of a CSV file; its unit is in the header, as in "x [um]", or in the key ``unit``."""

    file: str = key(FILE)
    column: str = key(COLUMN)
    unit: str | None = key(COLUMN_UNIT)

    def values(self, declared: Number, place: Place) -> tuple[float, ...]:
        """Return the values of the column [SI unit of the declared quantity]."""
        return column_values(declared, place, self.file, self.column, self.unit)


def column_values(
    declared: Number, place: Place, file_name: str, column_name: str, unit: str | None = None
) -> tuple[float, ...]:
    """Return a column of a file in SI units; a note of its source is added to the study."""
    name, here = shorten(file_name, 100), place.path(file_name)
    kind = declared.kind if isinstance(declared.kind, Kind) else None
    try:
        with usable(here, "a CSV file"):
            file = open_text(here, _MAX_BYTES)
        column = find(understood(file.columns), column_name)
        unit = _unit(column, unit, kind) if kind else unit or column.unit or "1"
        percent = Decimal("0.01") if unit.lower() in ("%", "percent") else Decimal(1)
        factor = factor_of(unit, kind, "") if kind else percent
        values = _values(file, column.place, factor, declared)
    except ValueError as error:
        raise ValueError(f"{name}: {place.message(str(error), file_name)}") from None
    place.notes.append(
        f'{place.key}: {len(values)} values from {name}, column "{shorten(column.heading, 60)}", '
        f"unit {unit}."
    )
    return tuple(values)


class Numbers(ListOf):
    """Reader of a list of numbers with unit and limits, in the study or as a column of a file."""

    def __init__(self, item: Number, example: str = "", *, single: bool = False) -> None:
        super().__init__(item, example or f"[{item.written}]", (1, MAX_VALUES), single=single)
        self.declared = item
        self.help = f"{item.sentence[:-1]}: a list or a column of a CSV file."

    def read(self, raw_value: object, place: Place) -> Any:
        """Return a tuple of SI values."""
        if isinstance(raw_value, dict):
            return CsvColumn.read(raw_value, place).values(self.declared, place)
        return super().read(raw_value, place)

    def schema(self) -> JsonSchema:
        """Return the JSON Schema of a list or a column."""
        several = super().schema()
        return {"anyOf": [*several.get("anyOf", [several]), CsvColumn.schema()]}


def _unit(column: Named, stated_unit: str | None, kind: Kind) -> str:
    in_head = column.unit if column.unit and is_unit(column.unit) else None
    where, usual = f'column "{shorten(column.heading, 40)}": ', kind.usual[1]
    # A header such as "x (left)" contains no unit; this is fine if the study gives one.
    unit = stated_unit or in_head or column.unit
    if not unit:
        raise ValueError(
            f'{where}no unit; write it in the header, such as "[{usual}]", or unit = "{usual}"'
        )
    message = f'{where}wanted a unit such as "{usual}", got '
    factor = factor_of(unit, kind, message + quote(unit))
    if in_head and factor != factor_of(in_head, kind, message + quote(in_head)):
        raise ValueError(
            f'{where}wanted unit = "{in_head}" as in the header, or no unit, got "{unit}"'
        )
    return unit


def _values(file: TextFile, place: int, factor: Decimal, declared: Number) -> list[float]:
    _, digits, exponent = factor.normalize().as_tuple()
    power = f"e{exponent}" if digits == (1,) else None
    values = list[float]()
    for line, cell in file.cells(place):
        value = _si(file, line, place, cell, factor, power)
        if not declared.holds(value):
            where = f'line {line}, column "{shorten(file.layout.names[place], 40)}"'
            noun = declared.kind.name if isinstance(declared.kind, Kind) else "number"
            noun = f"a positive {noun}" if declared.is_positive else declared.limited(f"a {noun}")
            raise ValueError(f"{where}: wanted {noun}, got {quote(cell)}")
        if len(values) == MAX_ROWS:
            raise ValueError(f"wanted at most {MAX_ROWS} rows, got more")
        values.append(value)
    return values


def _si(
    file: TextFile, line: int, place: int, cell: str, factor: Decimal, power: str | None
) -> float:
    """Convert a cell to a float in SI units.

    ``factor`` is the SI value of its unit; if it is a power of ten, ``power`` is the exponent as
    text, such as "e-6", otherwise None.
    """
    number = with_hyphen(cell)
    if file.decimal == "," and "." not in cell:
        number = number.replace(",", ".")
    if not _NUMBER.fullmatch(number) or (file.decimal == "," and "." in cell):
        hint = f' (write the unit in the header, "x [{cell}]")' if cell and is_unit(cell) else ""
        raise ValueError(f"{file.no_number(line, place, cell)}{hint}")
    # A power of ten goes into the exponent, so that each number is the nearest double.
    if power is not None and "e" not in number and "E" not in number:
        value = float(number + power)
    else:
        value = scaled_decimal(number, factor)
    if not SMALLEST < abs(value) < LARGEST and value:
        raise ValueError(f"{file.no_number(line, place, cell)} (outside 1e-40 … 1e40)")
    return value


def key_for(declared: Number, **changes: Any) -> Any:
    """Return a table key for a number declared by a class; it may be uncertain, or a list."""
    return key(Numbers(declared) if declared.many else Uncertain(declared), **changes)


def optional(kind: type, name: str, **changes: Any) -> Any:
    """Return an optional key for the parameter ``name`` of ``kind``, with its unit and limits."""
    return key_for(parameter_of(kind, name), default=None, **changes)
