"""Text: a matrix of heights, or points in columns: x, y and z, or x and z of a profile."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from microslip._core.units import LENGTH, QuantityError, is_unit, to_si
from microslip._core.wording import shorten, show
from microslip.scans.readers.base import Raw, Reader, Wishes, few, first_line
from microslip.scans.readers.grid import on_grid
from microslip.scans.readers.header import Names, names_of

_HEAD = 1 << 16  # bytes in which the rows must begin
_BLOCK = 1 << 24
_LINES = 50  # above the rows, in which the names of columns are looked for
_LINE = 1 << 28  # bytes of the longest line, ten million numbers
_COMMENTS = ("#", "%", "//")
_NUMBER = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
_GAP = r"[+-]?nan|bad|null|none|n/?a|nodata|\*+|-{2,}|-?\d*\.?#\w+"
_FIELD = re.compile(rf"(?:{_NUMBER}|{_GAP}|[+-]?inf)?", re.IGNORECASE)
_MISSING = re.compile(rf"(?<![\w.+-])(?:{_GAP})(?![\w.])", re.IGNORECASE)
_EMPTY = re.compile(r"(?<![^;,\t])[ ]*(?=[;,\t]|$)")
# What Gwyddion writes above a matrix.
_STATED = re.compile(r"[#%/\s]*(width|height|value units)\s*:\s*(.+?)\s*", re.IGNORECASE)


class _Layout(NamedTuple):
    """How the rows of a file are written."""

    first: int
    columns: int
    trailing: bool
    separator: str | None
    decimal: str
    stated: dict[str, str]
    encoding: str
    header: str | None
    names: Names | None


class Text(Reader):
    """Rows of numbers, below whatever is written first."""

    names = ("text", "matrix", "xyz", "profile")

    def knows(self, head: bytes, suffix: str) -> bool:
        """By what it does not hold."""
        return head.startswith((b"\xff\xfe", b"\xfe\xff")) or (
            b"\0" not in head and not head.startswith(b"PK")
        )

    def read(self, path: Path, wishes: Wishes) -> Raw:
        """A matrix, or points put on their grid."""
        layout = _layout(path)
        way = wishes.format if wishes.format in self.names[1:] else None
        if way is None:
            way = _way(layout, path.suffix.lower())
        each = 1 if way == "matrix" else layout.columns
        rows = _count(path, layout)
        few((rows, layout.columns), wishes.limit * each)
        table = _numbers(path, layout)
        notes = () if layout.header is None else (f'skipped above: "{layout.header}".',)
        if way == "matrix":
            return _matrix(table, layout, notes)
        least, most, wanted = (3, layout.columns, "3") if way == "xyz" else (1, 2, "1 or 2")
        if not least <= layout.columns <= most:
            raise ValueError(f'format="{way}": wanted {wanted} columns, got {layout.columns}')
        columns: tuple[str | None, str | None] = (None, None)
        if layout.names is not None and any(layout.names.units):
            columns = _units(layout.names.units[:3])
            notes = ()
        kind = "text, columns x, y, z" if way == "xyz" else "text, a profile"
        if layout.columns == 1:
            return Raw(kind, table[:, 0], columns=columns, notes=notes)
        if wishes.pixel is not None:
            raise ValueError(
                "its coordinates say the distance of neighbours: leave out pixel, or, if it is a "
                'matrix of heights, write format="matrix"'
            )
        beyond = layout.columns - 3
        table = table[:, :3]
        try:
            heights, steps = on_grid(
                [np.ascontiguousarray(table[:, i]) for i in range(table.shape[1] - 1)],
                table[:, -1],
                wishes.limit,
            )
        except ValueError as error:
            if beyond <= 0:
                raise
            raise ValueError(
                f"of {layout.columns} columns the first three were taken for x, y and z: {error}; "
                'if it is a matrix of heights, write format="matrix"'
            ) from None
        if beyond > 0:
            other = "1 column" if beyond == 1 else f"{beyond} columns"
            notes = (*notes, f"not read: {other} beyond x, y and z.")
        return Raw(kind, heights, steps=steps, columns=columns, notes=notes)


def _way(layout: _Layout, suffix: str) -> str:
    """What is in the columns, where nobody says it."""
    if layout.columns > 3:
        named = layout.names is not None and layout.names.are_points
        return "xyz" if suffix == ".xyz" or named else "matrix"
    return "xyz" if layout.columns == 3 else "profile"


def _units(units: tuple[str | None, ...]) -> tuple[str | None, str | None]:
    """Units of coordinates and of heights by the names of their columns."""
    across = list(dict.fromkeys(unit for unit in units[:-1] if unit))
    if len({to_si(f"1 {unit}", LENGTH, "1 um") for unit in across}) > 1:
        raise ValueError(f'x is in "{across[0]}", y in "{across[1]}": wanted one unit for both')
    return across[0] if across else None, units[-1]


def _matrix(table: np.ndarray, layout: _Layout, notes: tuple[str, ...]) -> Raw:
    unit = layout.stated.get("value units")
    pixel = None
    try:
        if {"width", "height"} <= layout.stated.keys():
            sizes = [to_si(layout.stated[key], LENGTH, "1 mm") for key in ("width", "height")]
            pixel = sizes[0] / table.shape[1], sizes[1] / table.shape[0]
    except QuantityError:  # some other use of these words
        pixel = None
    return Raw(
        "text, a matrix", table, unit if unit and is_unit(unit) else None, pixel, notes=notes
    )


def _layout(path: Path) -> _Layout:
    with path.open("rb") as file:
        head = file.read(_HEAD)
    encoding = "utf-8"
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        encoding = "utf-16"
    elif head.startswith(b"\xef\xbb\xbf"):
        encoding = "utf-8-sig"
    stated: dict[str, str] = {}
    header: str | None = None
    lines: list[str] = []
    with path.open(encoding=encoding, errors="replace") as text:
        above = 0
        number = 0
        while above < _HEAD:
            line = text.readline(_LINE)
            if not line:
                break
            if len(line) >= _LINE:
                raise ValueError("wanted lines of numbers, got one of more than 250 MB")
            above += len(line)
            bare = line.strip()
            if match := _STATED.fullmatch(bare):
                stated[match[1].lower()] = match[2]
            if bare and not bare.startswith(_COMMENTS):
                found = _fields(line.rstrip("\r\n"))
                if found is not None:
                    named = (names_of(one, found[0], found[2]) for one in lines[:-_LINES:-1])
                    names = next((one for one in named if one is not None), None)
                    return _Layout(number, *found, stated, encoding, header, names)
                header = header or shorten(bare, 60)
            lines.append(bare)
            number += 1
    raise ValueError("wanted rows of numbers, got text without any at its beginning")


def _fields(line: str) -> tuple[int, bool, str | None, str] | None:
    """Numbers of a line, whether a separator ends it, separator and decimal sign; None of text."""
    for separator in (";", "\t", None, ","):
        parts = line.split(separator)
        if separator and len(parts) < 2:
            continue
        if trailing := len(parts) > 1 and not parts[-1].strip():
            parts.pop()
        parts = [part.strip() for part in parts]
        if not all(_FIELD.fullmatch(part) for part in parts) or not any(parts):
            continue
        comma = any("," in part for part in parts)
        # "1,2,3" is three numbers and "1,2" alone is two, but "1,2 3,4" are numbers with commas.
        if comma and (any("." in part for part in parts) or (separator is None and len(parts) < 2)):
            continue
        return len(parts), trailing, separator, "," if comma else "."
    return None


def _count(path: Path, layout: _Layout) -> int:
    """Lines of the file: at least as many as rows."""
    lines = 1 - layout.first
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            lines += block.count(b"\n") or block.count(b"\r")
    return max(lines, 1)


def _numbers(path: Path, layout: _Layout) -> np.ndarray:
    def load(source: Any, **options: Any) -> np.ndarray:
        with np.errstate(all="ignore"):
            table: np.ndarray = np.loadtxt(
                source,
                delimiter=layout.separator,
                comments=list(_COMMENTS),
                ndmin=2,
                encoding=layout.encoding,
                **options,
            )
        return table

    try:
        if layout.decimal == ".":
            try:  # the quick way, for numbers only
                return load(path, skiprows=layout.first)
            except ValueError:
                pass
        return load(_cleaned(path, layout))
    except (ValueError, OverflowError) as error:
        wrong = _wrong(path, layout) or first_line(error)
        raise ValueError(f"wanted rows of {layout.columns} numbers: {wrong}") from None


def _wrong(path: Path, layout: _Layout) -> str:
    """The first line that is no such row, counted from 1 as editors do; "" if all are."""
    for number, row in enumerate(_cleaned(path, layout), start=layout.first + 1):
        bare = row
        for sign in _COMMENTS:
            bare = bare.partition(sign)[0]
        if not bare.strip():
            continue
        cells = bare.split(layout.separator)
        for column, cell in enumerate(cells, start=1):
            try:
                float(cell)
            except ValueError:
                return f"line {number}, column {column}: got {show(cell.strip())}"
        if len(cells) != layout.columns:
            return f"line {number}: got {len(cells)}"
    return ""


def _cleaned(path: Path, layout: _Layout) -> Iterator[str]:
    """The rows as NumPy reads them: points for commas, "nan" for what is missing."""
    with path.open(encoding=layout.encoding, errors="replace") as file:
        for number, line in enumerate(file):
            if number < layout.first:
                continue
            row = line.strip() if layout.separator is None else line.strip("\r\n ")
            if layout.trailing and row.rstrip().endswith(layout.separator or "\n"):
                row = row.rstrip()[:-1]
            if layout.decimal == ",":
                row = row.replace(",", ".")
            if row.strip() and layout.separator is not None:
                row = _EMPTY.sub("nan", row)
            yield _MISSING.sub("nan", row)
