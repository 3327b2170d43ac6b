"""Sheets: the cells of a CSV or of an Excel workbook, and workbooks of numbers as tables."""

from __future__ import annotations

import csv
import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.wording import show
from microslip.readers.child import parsed
from microslip.readers.dialect import NUMBER, Line, find_layout, is_missing
from microslip.readers.files import decoded, refuse_beyond
from microslip.readers.laboratory import library
from microslip.readers.tables import Column, Table
from microslip.readers.text import whole_text

_BYTES = 64
"""Bytes of an unpacked workbook for each number that is allowed: cells are written out as XML."""
_BYTES_A_SECOND = 3e5  # of openpyxl, which reads cell by cell
_HEAD = 400
"""Rows by which the layout of a sheet is told."""
_SEPARATORS = "\t;,"

Rows = list[list[str]]


def rows_of(path: Path, kind: str | None) -> Rows:
    """Cells of a sheet as text, empty rows included: of a text, or of the first of a workbook."""
    if kind == "excel":
        return next(iter(_sheets(path).values()), [])
    text = whole_text(path)
    head = next((line for line in text.splitlines() if line.strip()), "")
    separator = max(_SEPARATORS, key=head.count)
    rows = csv.reader(text.splitlines(), delimiter=separator)
    with decoded("sheet of cells"):
        return [[cell.strip() for cell in row] for row in rows]


def excel_table(path: Path) -> Table:
    """Columns of numbers of a workbook; where several sheets have some, with the sheet's name."""
    parts = [
        (title, layout, rows)
        for title, rows in _sheets(path).items()
        if (layout := find_layout(_lines(rows[:_HEAD]))) is not None
    ]
    if not parts:
        raise ValueError("wanted rows of numbers, got none in this Excel workbook")
    columns, places = [], []
    for title, layout, rows in parts:
        units = (*layout.units, *(None,) * len(layout.names))
        for place, (name, unit) in enumerate(zip(layout.names, units, strict=False)):
            heading = f"{title}/{name}" if len(parts) > 1 and name else name
            columns.append(Column(heading, unit, len(rows) - layout.first, None, name))
            places.append((rows, layout.first, place))

    def load(selection: Sequence[int]) -> list[Floats]:
        refuse_beyond(sum(columns[at].size or 0 for at in selection))
        return [_numbers(*places[at], columns[at].heading) for at in selection]

    first = parts[0][1].first
    words = f"Excel workbook, sheet {show(parts[0][0])}"
    if len(parts) > 1:
        words = f"Excel workbook, {len(parts)} sheets"
    return Table(words, tuple(columns), load, lambda row: f"row {row + first + 1}")


def _lines(rows: Rows) -> list[Line]:
    lines = (Line(at, "\t".join(row)) for at, row in enumerate(rows))
    return [line for line in lines if line.text.strip()]


def _numbers(rows: Rows, first: int, place: int, heading: str) -> Floats:
    """Numbers of a column, not a number where a cell is empty."""
    values = np.full(len(rows) - first, math.nan)
    for at, row in enumerate(rows[first:]):
        cell = row[place] if place < len(row) else ""
        if NUMBER["."].fullmatch(cell):
            values[at] = float(cell)
        elif not is_missing(cell):
            raise ValueError(
                f'row {at + first + 1}, column "{heading}": wanted a number, got {show(cell)}'
            )
    return values


def _sheets(path: Path) -> dict[str, Rows]:
    """Cells of each sheet of a workbook, of the last values that Excel computed."""
    sheets: dict[str, Rows] = parsed(
        "Excel workbook", path, read_sheets, libraries=["openpyxl"], bytes_a_second=_BYTES_A_SECOND
    )
    return sheets


# ------------------------------------------------------------------ what runs in the child


def read_sheets(path: Path) -> dict[str, Rows]:
    """The same by openpyxl."""
    openpyxl = library("openpyxl", "Excel", "openpyxl", "excel")
    # What the archive declares is what is unpacked: a longer member fails by its checksum.
    with zipfile.ZipFile(path) as archive:
        declared = sum(member.file_size for member in archive.infolist())
    refuse_beyond(declared // _BYTES)
    book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    return {sheet.title: _cells(sheet) for sheet in book.worksheets}


def _cells(sheet: Any) -> Rows:
    sheet.reset_dimensions()  # which programs may write wrong
    rows = [list(map(_text, row)) for row in sheet.iter_rows(values_only=True)]
    while rows and not any(rows[-1]):
        rows.pop()
    return rows


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value) if not value.is_integer() or abs(value) > 1e15 else str(int(value))
    return " ".join(str(value).split())
