"""Tables read by other libraries: TDMS and Excel; spreadsheet cells as text."""

from __future__ import annotations

import csv
import logging
import math
import re
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip._core.wording import quote
from microslip.readers.child import parsed
from microslip.readers.dialect import NUMBER, TextLine, find_layout, is_missing
from microslip.readers.files import decoded, refuse_beyond
from microslip.readers.tables import RawColumn, RawTable, refuse_long
from microslip.readers.text import whole_text


def tdms_table(path: Path) -> RawTable:
    """Return the channels of a TDMS file, such as "Log/Force", with unit and sampling rate."""
    with needed_for("TDMS files are read by", "tdms"):
        import nptdms
        from nptdms.log import log_manager
    log_manager.set_level(logging.CRITICAL)  # messages on damaged files duplicate its exceptions
    with decoded("TDMS file"), path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:
        channels = [
            (channel.group_name, channel.name, column)
            for group in file.groups()
            for channel in group.channels()
            if (column := _of_channel(channel)) is not None
        ]
    if not channels:
        raise ValueError("wanted channels of numbers, got none in this TDMS file")

    def load(places: Sequence[int]) -> list[Floats]:
        selection = [channels[place] for place in places]
        refuse_long(column for _, _, column in selection)
        with decoded("TDMS file"), path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:
            return [np.array(file[g][c][:], dtype=float) for g, c, _ in selection]

    return RawTable("TDMS file", tuple(column for _, _, column in channels), load)


def _of_channel(channel: Any) -> RawColumn | None:
    if len(channel) < 2 or np.dtype(channel.dtype).kind not in "iuf":
        return None
    step = channel.properties.get("wf_increment")
    rate = None
    if isinstance(step, (int, float)) and 0.0 < step < math.inf:
        rate = 1.0 / float(step)
    unit = str(channel.properties.get("unit_string", "")).strip() or None
    return RawColumn(f"{channel.group_name}/{channel.name}", unit, len(channel), rate, channel.name)


_BYTES = 64
"""Unpacked bytes of a workbook per allowed number: cells are stored as XML."""
_BYTES_A_SECOND = 3e5  # openpyxl reads cell by cell
_HEAD = 400
"""Number of rows that determine the layout of a sheet."""
_SEPARATORS = "\t;,"


def read_rows(path: Path, kind: str | None) -> list[list[str]]:
    """Return the cells of a text file or of the first sheet of a workbook, empty rows included."""
    if kind == "excel":
        return next(iter(_sheets(path).values()), [])
    text = whole_text(path)
    lines = [line for line in text.splitlines() if line.strip()]
    # A title has no separators, and commas may be decimal signs.
    usual = (s for s in _SEPARATORS if 2 * sum(s in line for line in lines) >= len(lines))
    separator = next(usual, ",")
    rows = csv.reader(text.splitlines(), delimiter=separator)
    with decoded("sheet of cells"):
        return [[cell.strip() for cell in row] for row in rows]


def excel_table(path: Path) -> RawTable:
    """Return the numeric columns of a workbook.

    Their names begin with the sheet's name if more than one sheet has numeric columns.
    """
    parts = []
    for title, rows in _sheets(path).items():
        lines = [TextLine(at, "\t".join(row)) for at, row in enumerate(rows[:_HEAD]) if any(row)]
        if (layout := find_layout(lines)) is not None:
            parts.append((title, layout, rows))
    if not parts:
        raise ValueError("wanted rows of numbers, got none in this Excel workbook")
    columns, places = [], []
    for title, layout, rows in parts:
        units = (*layout.units, *(None,) * len(layout.names))
        for place, (name, unit) in enumerate(zip(layout.names, units, strict=False)):
            heading = f"{title}/{name}" if len(parts) > 1 and name else name
            columns.append(RawColumn(heading, unit, len(rows) - layout.first, None, name))
            places.append((rows, layout.first, place))

    def load(selection: Sequence[int]) -> list[Floats]:
        refuse_beyond(sum(columns[at].size or 0 for at in selection))
        return [_numbers(*places[at], columns[at].heading) for at in selection]

    first = parts[0][1].first
    words = f"Excel workbook, sheet {quote(parts[0][0])}"
    if len(parts) > 1:
        words = f"Excel workbook, {len(parts)} sheets"
    return RawTable(words, tuple(columns), load, lambda row: f"row {row + first + 1}")


def _numbers(rows: list[list[str]], first: int, place: int, heading: str) -> Floats:
    values = np.full(len(rows) - first, math.nan)
    for at, row in enumerate(rows[first:]):
        cell = row[place] if place < len(row) else ""
        if NUMBER["."].fullmatch(cell):
            values[at] = float(cell)
        elif not is_missing(cell):
            raise ValueError(
                f'row {at + first + 1}, column "{heading}": wanted a number, got {quote(cell)}'
            )
    return values


def _sheets(path: Path) -> dict[str, list[list[str]]]:
    sheets: dict[str, list[list[str]]] = parsed(
        "Excel workbook", path, read_sheets, libraries=["openpyxl"], bytes_a_second=_BYTES_A_SECOND
    )
    return sheets


# ------------------------------------------------------------------ what runs in the child


def read_sheets(path: Path) -> dict[str, list[list[str]]]:
    """Return the cells of each visible sheet, by sheet name; runs in the child process."""
    with needed_for("Excel files are read by", "excel"):
        import openpyxl
    # Declared sizes can be trusted: a longer member fails its checksum.
    with zipfile.ZipFile(path) as archive:
        declared = sum(member.file_size for member in archive.infolist())
    refuse_beyond(declared // _BYTES)
    book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    visible = [sheet for sheet in book.worksheets if sheet.sheet_state == "visible"]
    with zipfile.ZipFile(path) as archive:
        return {sheet.title: _cells(sheet, archive) for sheet in visible}


_NO_VALUE = re.compile(
    rb'<c r="([A-Z]+\d+)"[^>]*><f[^>]*?(?:/>|>[^<]*</f>)(?:<v\s*/>|<v></v>)?</c>'
)
_MERGED = re.compile(rb'<mergeCell\b[^>]*\bref="([A-Z]+\d+:[A-Z]+\d+)"')


def _cells(sheet: Any, archive: zipfile.ZipFile) -> list[list[str]]:
    from openpyxl.utils import range_boundaries

    content = archive.read(sheet._worksheet_path)
    if (formula := _NO_VALUE.search(content)) is not None:
        raise InputError(
            f"sheet {quote(sheet.title)}, cell {formula[1].decode()}: a formula without its value; "
            "open the workbook in a spreadsheet program and save it"
        )
    sheet.reset_dimensions()  # declared dimensions may be wrong
    rows = [list(map(_text, row)) for row in sheet.iter_rows(values_only=True)]
    for place in _MERGED.findall(content):
        left, first, end, last = range_boundaries(place.decode())
        begin, top = left - 1, first - 1
        # A title over several columns stays a title.
        if first == last or top >= len(rows) or begin >= len(rows[top]):
            continue
        end = min(end, max(map(len, rows)))
        for row in rows[top:last]:
            row += [""] * (end - len(row))
            row[begin:end] = [rows[top][begin]] * (end - begin)
    while rows and not any(rows[-1]):
        rows.pop()
    return rows


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value) if not value.is_integer() or abs(value) > 1e15 else str(int(value))
    return " ".join(str(value).split())
