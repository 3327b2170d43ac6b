"""Text: CSV, TSV, TXT and whatever else laboratories write numbers in."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.tribometer.readers.base import Column, Reader, Stated, Table
from microslip.tribometer.readers.layout import (
    MISSING,
    NUMBER,
    SEPARATORS,
    Layout,
    Line,
    find_layout,
    is_comment,
    split,
)

MAX_BYTES = 4_000_000_000
_HEAD = 1 << 18  # bytes in which names and rows begin
_BLOCK = 1 << 24

_ENCODINGS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_CALLED = {"utf-8": "UTF-8", "utf-8-sig": "UTF-8", "utf-16": "UTF-16", "latin-1": "Latin-1"}
_STATED = re.compile(r"# (sample_rate|frequency|normal_load) = (\S+) (Hz|N)\s*")


class _File(NamedTuple):
    """A file of text that is understood."""

    path: Path
    encoding: str
    layout: Layout
    decimal: str
    counts: Counter[str]
    """How often signs stand in the rows; under "other" what is not ASCII."""

    def lines(self, start: int = 0) -> Iterator[str]:
        """Lines from this index on."""
        # What is not in the encoding is no number either: it is met where it is read.
        with self.path.open(encoding=self.encoding, errors="replace") as file:
            yield from islice(file, start, None)


class Text(Reader):
    """Rows of numbers below whatever a program writes first."""

    name = "text"

    def knows(self, head: bytes, suffix: str) -> bool:
        """By what it does not hold."""
        return head.startswith((b"\xff\xfe", b"\xfe\xff")) or (
            b"\0" not in head and not head.startswith(b"PK\x03\x04")
        )

    def open(self, path: Path) -> Table:
        """Columns by the line of names above the rows, if there is one."""
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise ValueError(
                f"wanted text of at most {MAX_BYTES // 1_000_000} MB, got {size // 1_000_000} MB; "
                "save the record as HDF5"
            )
        with path.open("rb") as file:
            head = file.read(_HEAD)
        encoding = _encoding(head)
        lines = _lines(path, encoding, len(head) < size)
        layout = find_layout([line for line in lines if line.text.strip()])
        if layout is None:
            raise ValueError("wanted rows of numbers, got none")
        counts = _count(path, encoding, layout)
        decimal = layout.decimal or ("," if counts[","] and not counts["."] else ".")
        if layout.separator == "," and layout.decimal is None:
            decimal = "."
        file_ = _File(path, encoding, layout, decimal, counts)
        units = layout.units + (None,) * len(layout.names)
        columns = tuple(map(Column, layout.names, units))
        stated = {
            match[1]: Stated(float(match[2]), f"line {line.above + 1}")
            for line in lines
            if line.above < layout.first and (match := _STATED.fullmatch(line.text))
        }
        return Table(
            _kind(file_),
            columns,
            lambda places: _load(file_, places),
            lambda row: f"line {_line_of(file_, row)}",
            stated,
        )


def _encoding(head: bytes) -> str:
    for mark, encoding in _ENCODINGS:
        if head.startswith(mark):
            return encoding
    try:
        head.decode("utf-8")
    except UnicodeDecodeError as error:
        # A letter of several bytes may be cut by the end of what was read.
        if error.start < len(head) - 4 or len(head) < _HEAD:
            return "latin-1"
    return "utf-8"


def _lines(path: Path, encoding: str, cut: bool) -> list[Line]:
    """The lines of the head of a file."""
    with path.open(encoding=encoding, errors="replace") as file:
        lines = [Line(i, text) for i, text in enumerate(file.readlines(_HEAD // 2))]
    return lines[:-1] if cut and len(lines) > 1 else lines


def _kind(file: _File) -> str:
    layout = file.layout
    parts = [
        f"text ({_CALLED[file.encoding]})",
        f"columns separated by {SEPARATORS[layout.separator]}",
    ]
    if file.decimal == ",":
        parts.append("decimal commas")
    if layout.names_line is None:
        parts.append("no names")
    else:
        parts.append(f"names in line {layout.names_line + 1}")
    if layout.units_line is not None:
        parts.append(f"units in line {layout.units_line + 1}")
    return ", ".join([*parts, f"rows from line {layout.first + 1} on"])


def _load(file: _File, places: Sequence[int]) -> list[Floats]:
    wanted = sorted(set(places))
    values = _quick(file, wanted)
    if values is None:
        values = _careful(file, wanted)
    return [np.ascontiguousarray(values[:, wanted.index(place)]) for place in places]


def _count(path: Path, encoding: str, layout: Layout) -> Counter[str]:
    counts = Counter[str]()
    signs = {",", ".", '"', "#", layout.separator or " "}
    with path.open(encoding=encoding, errors="replace") as stream:
        for _ in islice(stream, layout.first):
            pass
        while block := stream.read(_BLOCK):
            for sign in signs:
                counts[sign] += block.count(sign)
            counts["other"] += not block.isascii()
    return counts


def _quick(file: _File, places: list[int]) -> Floats | None:
    """By NumPy, in C; None where a look at each cell is needed."""
    layout, decimal, counts = file.layout, file.decimal, file.counts
    if counts["other"] or counts['"'] or counts["#"] or (decimal == "," and counts["."]):
        return None
    lines = file.lines(layout.first)
    if decimal == ",":
        lines = (line.replace(",", ".") for line in lines)
    # Without separators to count, all columns are read, and NumPy sees a row that is too long.
    columns = None if layout.separator is None else places
    try:
        values = np.loadtxt(
            lines, delimiter=layout.separator, comments=None, usecols=columns, ndmin=2
        )
    except ValueError:
        return None
    if layout.separator is None:
        return values[:, places] if values.shape[1] == layout.width else None
    separator, inside = layout.separator, layout.width - 1
    if counts[separator] != len(values) * inside:
        return None
    # NumPy has seen rows that are too short if it read the last column; then none is too long.
    lines = file.lines(layout.first) if max(places) < inside else iter(())
    return (
        values if all(line.count(separator) == inside for line in lines if line.strip()) else None
    )


def _careful(file: _File, places: list[int]) -> Floats:
    """Cell by cell, with an error that names line and column."""
    layout, decimal = file.layout, file.decimal
    least, number = len(layout.names), NUMBER[decimal].fullmatch
    rows: list[list[float]] = []
    for index, text in _rows(file):
        cells = split(text, layout.separator)
        if not any(cells):
            rows.append([math.nan] * len(places))
            continue
        if len(cells) < least or any(cells[least:]):
            raise ValueError(
                f"line {index + 1}: wanted {least} cells as in line {layout.first + 1}, "
                f"got {len(cells)}{_excerpt(text) if len(cells) == 1 else ''}"
            )
        row = []
        for place in places:
            cell = cells[place].replace("\N{MINUS SIGN}", "-")
            if number(cell):
                row.append(float(cell.replace(",", ".")))
            elif cell.lower() in MISSING:
                row.append(math.nan)
            else:
                raise ValueError(_wrong_cell(layout, index, place, cell, decimal))
        rows.append(row)
    return np.array(rows, dtype=float).reshape(len(rows), len(places))


def _wrong_cell(layout: Layout, index: int, place: int, cell: str, decimal: str) -> str:
    from microslip._core.wording import shorten, show

    name = shorten(layout.names[place], 40) or f"#{place + 1}"
    other = {".": ",", ",": "."}[decimal]
    hint = ""
    if NUMBER[other].fullmatch(cell):
        hint = f' (the decimal sign of the lines above is "{decimal}")'
    elif re.fullmatch(r"[+-]?\d{1,3}([,.' ]\d{3})+([.,]\d+)?", cell):
        hint = " (write numbers without signs between thousands)"
    elif re.fullmatch(r"[\d/. -]*\d{1,2}:\d\d(:\d\d([.,]\d+)?)?", cell):
        hint = "; for times of day write time=False and sample_rate="
    return f'line {index + 1}, column "{name}": wanted a number, got {show(cell)}{hint}'


def _excerpt(text: str) -> str:
    from microslip._core.wording import show

    return f", {show(text.strip())}"


def _rows(file: _File) -> Iterator[tuple[int, str]]:
    """Lines that hold a row, with their indices."""
    for index, text in enumerate(file.lines(file.layout.first), start=file.layout.first):
        if text.strip() and not is_comment(text):
            yield index, text


def _line_of(file: _File, row: int) -> int:
    return next(islice(_rows(file), row, None))[0] + 1
