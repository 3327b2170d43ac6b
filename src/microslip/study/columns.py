"""Floor 8: a column of a CSV file, with its unit, as SI floats."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterator
from decimal import Decimal
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field, GetCoreSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from microslip._core.units import LARGEST, SMALLEST, Kind, Sign, factor_of, is_unit, times
from microslip._core.wording import did_you_mean, quoted, shorten, show
from microslip.study.part import Check, Part, Reading
from microslip.study.textfile import read_text

MAX_BYTES = 256_000_000
MAX_ROWS = 1_000_000

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_HEAD = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<square>[^][]*)\]|\((?P<round>[^()]*)\))")

Rows = Iterator[tuple[int, list[str]]]


def text(wanted: str) -> Check:
    """Text on one line."""

    def check(given: object) -> object:
        if not isinstance(given, str) or not given.isprintable() or not 0 < len(given) <= 1000:
            raise ValueError(f"wanted {wanted}, got {show(given)}")
        return given

    return Check(check, lambda inner: {**inner, "minLength": 1, "maxLength": 1000})


FileName = Annotated[str, text('the name of a CSV file such as "record.csv"')]
ColumnName = Annotated[str, text('the name of a column such as "x"')]
UnitName = Annotated[str, text('a unit such as "um"')]


class SiValues(tuple[float, ...]):
    """Values that have been read, in SI units."""

    __slots__ = ()


class Column(Part):
    """A column of a CSV file: its header says the unit, as in "x [um]", or `unit` does."""

    file: FileName = Field(
        description="CSV file with a line of column names; relative to the folder of the study.",
        examples=['"record.csv"'],
    )
    column: ColumnName = Field(
        description='Name of the column, with or without the unit of its header: "x" or "x [um]".',
        examples=['"x"'],
    )
    unit: UnitName | None = Field(
        default=None,
        description='Unit of the column; not needed where its header has one, "[um]" or "(um)".',
        examples=['"um"'],
    )

    def read(self, kind: Kind, sign: Sign, info: ValidationInfo, what: str) -> SiValues:
        """Values of the column.

        Parameters
        ----------
        kind : Kind
            What the column holds.
        sign : {"positive", "any"}
            Values that are allowed.
        info : pydantic.ValidationInfo
            Its context is the :class:`~microslip.study.part.Reading`, which knows the folder and
            takes a note.
        what : str
            What is read, for the note.

        Returns
        -------
        SiValues
            The value of each row [SI unit of `kind`].

        Raises
        ------
        ValueError
            If the file, the column, its unit or a cell cannot be used; the message names file,
            line and column.
        """
        reading = info.context if isinstance(info.context, Reading) else Reading()
        name = shorten(self.file, 100)
        try:
            path = Path(self.file)
            missing = "no such file" + (
                " in the folder of the study" if reading.folder and not path.is_absolute() else ""
            )
            content = read_text((reading.folder or Path()) / path, "a CSV", MAX_BYTES, missing)
            head, rows = _table(content)
            index = _find(head, self.column)
            unit = _unit(head[index], self.unit, kind)
            values = _values(rows, head, index, factor_of(unit, kind, ""), sign, kind)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        reading.notes.append(
            f'{what}: {len(values)} values from {name}, column "{shorten(head[index], 60)}", '
            f"unit {unit}."
        )
        return SiValues(values)


class FromFile(NamedTuple):
    """Lets a :class:`Column` stand where a list of quantities is wanted."""

    kind: Kind
    what: str
    sign: Sign = "any"

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_wrap_validator_function(self._read, handler(source))

    def _read(
        self, given: object, handler: Callable[[object], object], info: ValidationInfo
    ) -> object:
        if isinstance(given, dict):
            given = Column.model_validate(given, context=info.context)
        if isinstance(given, Column):
            given = given.read(self.kind, self.sign, info, self.what)
        return given if isinstance(given, SiValues) else handler(given)


def _table(text: str) -> tuple[list[str], Rows]:
    """Names of the columns, and the rows below with their lines."""
    lines = io.StringIO(text, newline=None)
    comment = ""
    for number, line in enumerate(lines, start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            return _below(line, number, lines, comment)
        comment = line.strip() or comment
    raise ValueError("wanted a line of column names and rows of numbers, got none")


def _below(line: str, number: int, lines: Iterator[str], comment: str) -> tuple[list[str], Rows]:
    """What the first line that is no comment begins: usually it holds the names."""
    delimiter = next((sign for sign in "\t;" if sign in line), ",")
    (first,) = _split(iter([line]), delimiter, number - 1)
    rows, names = _split(lines, delimiter, number), first[1]
    if all(_NUMBER.fullmatch(cell.strip().replace(",", ".")) for cell in names):
        # The way of numpy.savetxt: the names stand in the comment above.
        ((_, names),) = _split(iter([comment.lstrip("# ") or "?"]), delimiter, number - 2)
        if not comment or len(names) != len(first[1]):
            raise ValueError(
                f"line {number}: wanted the names of the columns, got {show(line.strip())}"
            )
        rows = chain([first], rows)
    names = [name.strip() for name in names]
    while len(names) > 1 and not names[-1]:
        names.pop()
    return names, rows


def _split(lines: Iterator[str], delimiter: str, before: int) -> Rows:
    """Cells of each line, with its number."""
    reader = csv.reader(lines, delimiter=delimiter, strict=True, skipinitialspace=True)
    try:
        for cells in reader:
            yield before + reader.line_num, cells
    except csv.Error as error:
        raise ValueError(f"line {before + reader.line_num}: not CSV: {error}") from None


def _find(head: list[str], column: str) -> int:
    """Place of a column, named with or without its unit."""
    plain = [match["name"] if (match := _HEAD.fullmatch(name)) else name for name in head]
    found = [i for i, name in enumerate(head) if name == column.strip()]
    found = found or [i for i, name in enumerate(plain) if name == column.strip()]
    if not found:
        hint = did_you_mean(column, dict.fromkeys([*plain, *head]))
        there = f"; the columns are {quoted(head[:20], 'and')}"
        raise ValueError(f'no column "{shorten(column, 40)}"{hint or there}')
    if len(found) > 1:
        first, second = (place + 1 for place in found[:2])
        raise ValueError(
            f'column "{shorten(column, 40)}" is there twice, as columns {first} and {second}'
        )
    return found[0]


def _unit(head: str, given: str | None, kind: Kind) -> str:
    """Unit of a column by its header or by the study, which must not differ."""
    match = _HEAD.fullmatch(head)
    in_head = (match["square"] or match["round"] or "").strip() if match else ""
    if given is not None and not is_unit(in_head):
        in_head = ""  # "(left)" is no unit, and no harm once there is one
    where, usual = f'column "{shorten(head, 40)}": ', kind.usual[1]
    unit = given or in_head
    if not unit:
        raise ValueError(
            f'{where}no unit; write it in the header, such as "[{usual}]", or unit = "{usual}"'
        )
    wanted = f'{where}wanted a unit such as "{usual}", got '
    factor = factor_of(unit, kind, wanted + show(unit))
    if in_head and factor != factor_of(in_head, kind, wanted + show(in_head)):
        raise ValueError(
            f'{where}wanted unit = "{in_head}" as in the header, or no unit, got "{unit}"'
        )
    return unit


def _values(
    rows: Rows, head: list[str], index: int, factor: Decimal, sign: Sign, kind: Kind
) -> list[float]:
    """The numbers of one column [SI unit of `kind`]."""
    # A power of ten goes into the exponent, so that each number is the nearest double.
    _, digits, exponent = factor.normalize().as_tuple()
    power = f"e{exponent}" if digits == (1,) else None
    width, values, mark = len(head), list[float](), ""
    for line, cells in rows:
        if len(cells) != width and not _is_whole(line, cells, width):
            continue
        cell = cells[index].strip()
        if not cell and not any(map(str.strip, cells)):
            continue
        try:
            value = _si(cell, factor, power)
            if value <= 0.0 and sign == "positive":
                raise ValueError(f"wanted a positive {kind.name}, got {show(cell)}")
            found = "," if "," in cell else "." if "." in cell else mark
            if found != mark:
                if mark:
                    raise ValueError(
                        f'wanted the decimal sign of the lines above, "{mark}", got {show(cell)}'
                    )
                mark = found
        except ValueError as error:
            name = shorten(head[index], 40)
            raise ValueError(f'line {line}, column "{name}": {error}') from None
        if len(values) == MAX_ROWS:
            raise ValueError(f"wanted at most {MAX_ROWS} rows, got more")
        values.append(value)
    if not values:
        raise ValueError("wanted rows of numbers below the names of the columns, got none")
    return values


def _is_whole(line: int, cells: list[str], width: int) -> bool:
    """Whether a row holds a cell for each column and only empty ones beyond; not an empty row."""
    if not any(map(str.strip, cells)):
        return False
    if len(cells) < width or any(map(str.strip, cells[width:])):
        raise ValueError(f"line {line}: wanted {width} cells as in the header, got {len(cells)}")
    return True


def _si(cell: str, factor: Decimal, power: str | None) -> float:
    """Number in a cell, in the unit of this factor, as SI float."""
    number = cell
    if not cell.isascii() or "," in cell:
        number = cell.replace(",", ".").replace("\N{MINUS SIGN}", "-")
    if not _NUMBER.fullmatch(number):
        if not cell:
            raise ValueError("wanted a number, got an empty cell")
        hint = f' (a unit stands in the header, "x [{cell}]")' if is_unit(cell) else ""
        raise ValueError(f"wanted a number, got {show(cell)}{hint}")
    if power is not None and "e" not in number and "E" not in number:
        value = float(number + power)
    else:
        value = times(number, factor)
    if not SMALLEST < abs(value) < LARGEST and value:
        raise ValueError(f"wanted a number, got {show(cell)} (beyond all measure)")
    return value
