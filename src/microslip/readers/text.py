"""Numeric text files: CSV, TSV, TXT and other laboratory formats."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.wording import quote, shorten
from microslip.readers.dialect import (
    NUMBER,
    SEPARATORS,
    Layout,
    TextLine,
    find_layout,
    is_comment,
    is_missing,
    split_line,
    with_hyphen,
    with_nan,
)
from microslip.readers.files import refuse_beyond
from microslip.readers.tables import RawColumn, RawTable, Stated

_MAX_BYTES = 4_000_000_000
_HEAD = 1 << 18  # bytes within which names and rows must begin
_SHORT_TEXT = 32_000_000  # largest text that is read at once [bytes]
_LINE = 1 << 21  # characters of the longest line, some 100 000 numbers
_BLOCK = 1 << 22  # characters per block: an error costs a cell-by-cell parse of its block

_ENCODINGS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_CALLED = {"utf-8-sig": "UTF-8", "latin-1": "Latin-1", "cp932": "Shift-JIS"}
_JAPANESE = re.compile(rb"(?:[\x81-\x9f][\x40-\x7e\x80-\xfc]){2}")  # in Latin-1 control characters
_STATED = re.compile(r"# (sample_rate|normal_load) = (\S+) (Hz|N)\s*")
_QUOTED = r'(?:(?<={0})|^)"([^"\n{0}]*)"(?={0}|$)'  # a cell
_DIGITS = re.compile(r"\d+")
_REMARK = re.compile(r"\s(?:#|%|//).*")  # after the numbers of a row


class TextFile(NamedTuple):
    """Text file with its encoding, layout and decimal sign; numbers are loaded on demand."""

    path: Path
    encoding: str
    layout: Layout
    decimal: str
    counts: Counter[str]
    """Numbers of points, commas and line ends in the rows."""
    above: tuple[TextLine, ...]
    """Lines above the rows."""
    may_end_short: bool = False
    """Whether the last row may be cut off, for example by a power failure of the rig."""

    @property
    def columns(self) -> tuple[RawColumn, ...]:
        """Columns with the names and units in the lines above the numbers."""
        units = self.layout.units + (None,) * len(self.layout.names)
        return tuple(map(RawColumn, self.layout.names, units))

    @property
    def most_rows(self) -> int:
        """Number of lines from the first row of numbers on, an upper bound of the rows."""
        return self.counts["\n"] + 1

    @property
    def kind(self) -> str:
        """Description of the file and its layout for the notes."""
        layout = self.layout
        parts = [
            f"text ({_CALLED.get(self.encoding, self.encoding.upper())})",
            f"columns separated by {SEPARATORS[layout.separator]}",
        ]
        if self.decimal == ",":
            parts.append("decimal commas")
        if layout.names_line is None:
            parts.append("no names")
        else:
            parts.append(f"names in line {layout.names_line + 1}")
        if layout.units_line is not None:
            parts.append(f"units in line {layout.units_line + 1}")
        return ", ".join([*parts, f"rows from line {layout.first + 1} on"])

    def load(self, places: Sequence[int]) -> list[Floats]:
        """Load the columns at these indices as separate arrays; missing numbers become NaN."""
        refuse_beyond(self.most_rows, len(set(places)))
        sorted_places = sorted(set(places))
        values = self.matrix(sorted_places)
        return [np.ascontiguousarray(values[:, sorted_places.index(place)]) for place in places]

    def matrix(self, places: list[int] | None = None) -> Floats:
        """Load columns as one matrix (rows of the file, columns); all columns by default."""
        places = list(range(len(self.layout.names))) if places is None else places
        values = np.empty((self.most_rows, len(places)))
        count = 0
        for block in self._blocks():
            rows = _as_numbers(self, block, places)
            if rows is None:
                rows = _cell_by_cell(self, block, places)
            values[count : count + len(rows)] = rows
            count += len(rows)
        return values[:count]

    def cells(self, place: int) -> Iterator[tuple[int, str]]:
        """Yield line number and text of each cell in a column, for numbers that must stay exact."""
        for block in self._blocks():
            for index, row in _cells(self, block):
                if row is not None:
                    yield index + 1, row[place]

    def no_number(self, line: int, place: int, cell: str) -> ValueError:
        """Return the error for a cell that is not a number, with its position."""
        name = shorten(self.layout.names[place], 40) or f"#{place + 1}"
        hint = ""
        other_sign = "," if self.decimal == "." else "."
        if other_sign in cell and NUMBER[other_sign].fullmatch(cell):
            hint = f' (the decimal sign of the lines above is "{self.decimal}")'
        elif re.fullmatch(r"[+-]?\d{1,3}([,.' ]\d{3})+([.,]\d+)?", cell):
            hint = " (write numbers without thousands separators)"
        elif re.fullmatch(r"[\d/. -]*\d{1,2}:\d\d(:\d\d([.,]\d+)?)?", cell):
            hint = "; for times of day write `time=False` and `sample_rate=...`"
        return InputError(f'line {line}, column "{name}": wanted a number, got {quote(cell)}{hint}')

    def line_of(self, row: int) -> int:
        """Return the line number in the file (from 1) of a row of numbers (from 0)."""
        rows = (line for block in self._blocks() for line in _rows(self, block))
        return next(islice(rows, row, None))[0] + 1

    def _blocks(self) -> Iterator[_Block]:
        with _opened(self.path, self.encoding, self.layout.first) as file:
            first, text = self.layout.first, file.read(_BLOCK)
            while text:
                text += _line(file)
                ahead = file.read(_BLOCK)
                yield _Block(first, text, not ahead)
                first, text = first + text.count("\n"), ahead


class _Block(NamedTuple):
    first: int
    """Index of the first line."""
    text: str
    is_last: bool


def open_text(path: Path, limit: int = _MAX_BYTES) -> TextFile:
    """Detect encoding, decimal sign and layout (separator, names, units) of a text file.

    Numbers are not loaded. A file of more than ``limit`` bytes (by default 4 GB), or without rows
    of numbers, raises ValueError.
    """
    size = path.stat().st_size
    if size > limit:
        raise ValueError(
            f"wanted text of at most {limit // 1_000_000} MB, got {size // 1_000_000} MB; "
            "save it as HDF5"
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
    above = tuple(line for line in lines if line.above < layout.first)
    return TextFile(path, encoding, layout, decimal, counts, above)


def text_table(path: Path) -> RawTable:
    """Return the columns of a text file, and the settings that it states above them."""
    file = open_text(path)._replace(may_end_short=True)
    stated = {
        match[1]: Stated(float(match[2]), f"line {line.above + 1}")
        for line in file.above
        if (match := _STATED.fullmatch(line.text))
    }
    columns = file.columns
    if file.above and file.above[0].text.startswith("LabVIEW Measurement"):
        columns = _of_labview(file, stated)
    return RawTable(file.kind, columns, file.load, lambda row: f"line {file.line_of(row)}", stated)


def _of_labview(file: TextFile, stated: dict[str, Stated]) -> tuple[RawColumn, ...]:
    """Return the columns of a LabVIEW .lvm file, with units and time step from its header.

    Each cell of the header stands in the column that it describes. If there is no time column "X",
    the sampling rate is the inverse of the header's time step.
    """
    header = {line.text.split("\t", 1)[0].strip(): line for line in file.above}

    def cells(name: str) -> list[str]:
        return split_line(header[name].text, "\t") if name in header else []

    units, dimensions = cells("Y_Unit_Label"), cells("X_Dimension")
    has_x = cells("X_Columns")[1:2] != ["No"]
    if "Time" in dimensions and not has_x:
        texts = [cell.replace(",", ".") for cell in cells("Delta_X")[1:]]
        steps = [float(text) for text in texts if NUMBER["."].fullmatch(text)]
        if steps and steps[0] > 0.0:
            stated.setdefault("sample_rate", Stated(1.0 / steps[0], "Delta_X"))
    columns = []
    for place, column in enumerate(file.columns):
        unit = units[place] if place and place < len(units) else ""
        if column.heading != "X_Value":
            column = column._replace(unit=column.unit or unit or None)
        elif has_x and "Time" in dimensions:
            column = RawColumn("time", "s")
        columns.append(column)
    return tuple(columns)


def whole_text(path: Path) -> str:
    """Read a text of at most 32 MB, in any supported encoding."""
    with path.open("rb") as file:
        content = file.read(_SHORT_TEXT + 1)
    if len(content) > _SHORT_TEXT:
        raise ValueError(f"wanted text of at most {_SHORT_TEXT // 1_000_000} MB, got more")
    encoding = _encoding(content[:_HEAD])
    text = content.decode("utf-8-sig" if encoding == "utf-8" else encoding, "replace")
    if "\0" in text:
        raise ValueError("wanted text, got binary data")
    return text


def _encoding(head: bytes) -> str:
    for mark, encoding in _ENCODINGS:
        if head.startswith(mark):
            return encoding
    try:
        head.decode("utf-8")
    except UnicodeDecodeError as error:
        # The end of the head may cut a multi-byte character.
        if error.start < len(head) - 4 or len(head) < _HEAD:
            with suppress(UnicodeDecodeError):
                if _JAPANESE.search(head) and head[: head.rfind(b"\n") + 1].decode("cp932"):
                    return "cp932"
            return "latin-1"
    return "utf-8"


def _lines(path: Path, encoding: str, cut: bool) -> list[TextLine]:
    lines: list[TextLine] = []
    size = 0
    with _opened(path, encoding) as file:
        while size < _HEAD // 2 and (text := _line(file)):
            lines.append(TextLine(len(lines), text))
            size += len(text)
    return lines[:-1] if cut and len(lines) > 1 else lines


@contextmanager
def _opened(path: Path, encoding: str, first: int = 0) -> Iterator[IO[str]]:
    # Undecodable bytes are never part of a number: the parser reports them.
    with path.open(encoding=encoding, errors="replace") as file:
        for _ in range(first):
            _line(file)
        yield file


def _line(file: IO[str]) -> str:
    text = file.readline(_LINE)
    if len(text) >= _LINE:
        raise ValueError(
            f"wanted lines of numbers, got one of more than {_LINE // 1_000_000} million characters"
        )
    return text


def _count(path: Path, encoding: str, layout: Layout) -> Counter[str]:
    counts = Counter[str]()
    with _opened(path, encoding, layout.first) as file:
        while text := file.read(_BLOCK):
            for sign in ",.\n":
                counts[sign] += text.count(sign)
    return counts


def _as_numbers(file: TextFile, block: _Block, places: list[int]) -> Floats | None:
    """Parse a block of lines with NumPy; return None if each cell must be parsed separately."""
    separator, text = file.layout.separator, block.text
    if '"' in text:
        # Quotation marks around cells without separators are redundant.
        quoted = '"' if separator is None else _QUOTED.format(re.escape(separator))
        text = re.sub(quoted, "" if separator is None else r"\1", text, flags=re.MULTILINE)
    if not text.isascii() or any(sign in text for sign in '"#'):
        return None
    if file.decimal == ",":
        if "." in text:
            return None
        text = text.replace(",", ".")
    lines = [line for line in text.split("\n") if line.strip()]
    if not lines:
        return np.empty((0, len(places)))
    width = file.layout.width
    if separator is not None and any(line.count(separator) != width - 1 for line in lines):
        return None
    # Without separators to count, all columns are read, so that NumPy detects overlong rows.
    columns = None if separator is None else places
    values = _loaded(lines, separator, columns)
    if separator is not None:
        if values is None:
            lines = with_nan("\n".join(lines), separator).split("\n")
            values = _loaded(lines, separator, columns)
        return values
    return None if values is None or values.shape[1] != width else values[:, places]


def _loaded(lines: list[str], separator: str | None, columns: list[int] | None) -> Floats | None:
    try:
        return np.loadtxt(lines, delimiter=separator, comments=None, usecols=columns, ndmin=2)
    except ValueError:
        return None


def _cell_by_cell(file: TextFile, block: _Block, places: list[int]) -> Floats:
    is_number = NUMBER[file.decimal].fullmatch
    missing = {""}  # known cells that denote missing numbers
    rows = []
    for index, row in _cells(file, block):
        values = []
        for place in places:
            cell = "" if row is None else with_hyphen(row[place])
            if is_number(cell):
                values.append(float(cell.replace(",", ".")))
                continue
            if cell not in missing and not is_missing(cell):
                raise file.no_number(index + 1, place, cell)
            missing.add(cell)
            values.append(math.nan)
        rows.append(values)
    return np.array(rows, dtype=float).reshape(len(rows), len(places))


def _cells(file: TextFile, block: _Block) -> Iterator[tuple[int, list[str] | None]]:
    """Yield line index and cells of each row of a block; None for the cells of an empty row."""
    layout = file.layout
    width = len(layout.names)
    short: ValueError | None = None
    last = 0
    for index, text in _rows(file, block):
        if short is not None:  # the short row was not the last one
            raise short
        cells = split_line(text, layout.separator)
        if not any(cells):
            yield index, None
            continue
        if len(cells) < width or any(cells[width:]):
            content = ""
            if len(cells) == 1:
                content = f", {quote(text.strip())}"
                if not NUMBER[file.decimal].fullmatch(text.strip()):
                    content += "; put what follows there into a file of its own"
            short = ValueError(
                f"line {index + 1}: wanted {width} cells as in line {layout.first + 1}, "
                f"got {len(cells)}{content}"
            )
            if len(cells) >= width or not (file.may_end_short and _is_cut(file, cells)):
                raise short
            last = index
            continue
        yield index, cells
    if short is not None:
        if not block.is_last:
            raise short
        yield last, None


def _is_cut(file: TextFile, cells: Sequence[str]) -> bool:
    number = NUMBER[file.decimal].fullmatch
    complete = (number(with_hyphen(cell)) or is_missing(cell) for cell in cells[:-1])
    last = with_hyphen(cells[-1]).rstrip("eE+-.,")
    return all(complete) and (not last or number(last) is not None)


def _rows(file: TextFile, block: _Block) -> Iterator[tuple[int, str]]:
    """Yield line index and text of each row of a block, without remarks and repeated headings."""
    separator, number = file.layout.separator, NUMBER[file.decimal].fullmatch
    remarks = separator is None and any(sign in block.text for sign in "#%/")
    heads = [line.text.strip() for line in file.above]
    # Headings of later steps may have other digits, such as "Step No. 2".
    heads = [_DIGITS.sub("0", h) for h in heads if not any(map(number, split_line(h, separator)))]
    for index, text in enumerate(block.text.split("\n"), start=block.first):
        if not is_comment(text) and _DIGITS.sub("0", text.strip()) not in ("", *heads):
            yield index, _REMARK.sub("", text) if remarks else text
