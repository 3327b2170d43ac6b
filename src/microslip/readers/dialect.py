"""Layout of a text file of numbers: separator, decimal sign, names, units, first row."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple

from microslip.readers.tables import is_only_unit, name_and_unit, unbracketed

_NOTHING = r"(?:[+-]?nan|#?n/?a|null|none|bad|no ?data|-+|\*+|\?|[+-]?\d*\.?#\w+)?"
_MISSING = re.compile(_NOTHING, re.ASCII | re.I)

_POINT = re.compile(
    r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf(?:inity)?", re.ASCII | re.I
)
_COMMA = re.compile(
    r"[+-]?(?:\d+(?:,\d+)?|,\d+)(?:[eE][+-]?\d+)?|[+-]?inf(?:inity)?", re.ASCII | re.I
)
NUMBER = {".": _POINT, ",": _COMMA}

COMMENTS = ("#", "%", "//")
SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", None: "spaces"}
_ENOUGH = 200  # rows that show how a file is laid out
_MARKS = "#%!/*\"' \t"  # what may stand before the names of a comment
_FAR = 50  # lines above the rows in which names with units are looked for
_BRACKETED = re.compile(r"[^][()]*(?:\[[^][]*\]|\([^()]*\))")


class Line(NamedTuple):
    """A line that is not empty, and how many are above it."""

    above: int
    text: str


class Layout(NamedTuple):
    """Layout of the rows of a file."""

    separator: str | None
    """None: any number of spaces."""

    decimal: str | None
    """None: the rows that were looked at hold whole numbers only."""

    first: int
    """Index of the line of the first row."""

    width: int
    """Cells of a row."""

    names: tuple[str, ...]
    """Names of the columns, "" where there is none; fewer than cells if rows end in separators."""

    units: tuple[str | None, ...]
    """Units of a row of units; of the names' own brackets nothing is read here."""

    names_line: int | None
    units_line: int | None


def split(text: str, separator: str | None) -> list[str]:
    """Cells of a line, without spaces and quotation marks around them."""
    if separator is None:
        return text.replace('"', "").split()
    if '"' in text:
        with suppress(csv.Error):  # no CSV: then the marks are letters like others
            (cells,) = csv.reader([text.strip("\r\n")], delimiter=separator, strict=True)
            return [cell.strip() for cell in cells]
    return [cell.strip() for cell in text.strip("\r\n").split(separator)]


def is_comment(text: str) -> bool:
    """Whether a line holds no row."""
    return text.startswith(COMMENTS) and not text.upper().startswith(("#N/A", "#NA"))


def is_missing(cell: str) -> bool:
    """Whether a cell stands for a number that is not there."""
    return _MISSING.fullmatch(cell) is not None


def with_nan(text: str, separator: str) -> str:
    """Rows of a text, "nan" in each cell that stands for a number that is not there."""
    edge = rf"[^{re.escape(separator)}\n]"
    return re.sub(rf"(?<!{edge}) *{_NOTHING} *(?!{edge})", "nan", text, flags=re.ASCII | re.I)


def find_layout(lines: Sequence[Line]) -> Layout | None:
    """The layout in which most numbers stand in rows of one kind, or None if there are no rows.

    Columns that are numbers count for it and texts against it, which tells separators from decimal
    signs: "1,5;2,5" is two numbers or, separated by commas, one with a text.
    """
    best: tuple[float, Layout] | None = None
    quoted = any('"' in line.text for line in lines)
    for separator in SEPARATORS:
        if separator is not None and not any(separator in line.text for line in lines):
            continue
        cells = [split(line.text, separator) for line in lines]
        # Between commas a number has none, unless quotation marks are around it.
        for decimal in (".",) if separator == "," and not quoted else (".", ","):
            run = _best_run(lines, cells, decimal)
            if run is None:
                continue
            start, end, mask = run
            score = _weight(start, end, mask)
            if best is not None and score <= best[0]:
                is_tie = best[1].separator == separator and score == best[0]
                if is_tie and decimal == ",":  # no decimal sign at all so far
                    best = (score, best[1]._replace(decimal=None))
                continue
            names, units, lines_of = _names(lines, start, separator, len(mask), mask)
            if not names:
                names = ("",) * _filled(mask)
            first, width = lines[start].above, len(cells[start])
            best = (score, Layout(separator, decimal, first, width, names, units, *lines_of))
    return best[1] if best else None


def _best_run(
    lines: Sequence[Line], cells: Sequence[list[str]], decimal: str
) -> tuple[int, int, list[bool | None]] | None:
    """Start, end and kinds of cells (number, text, empty) of rows of one kind that follow."""
    number = NUMBER[decimal].fullmatch
    best: tuple[int, int, list[bool | None]] | None = None
    start, mask, empty = 0, list[bool | None](), 0
    for i, row in enumerate(cells):
        kinds = [] if is_comment(lines[i].text) else _kinds(row, number)
        fits = len(kinds) == len(mask) and not any(
            a is not b for a, b in zip(kinds, mask, strict=True) if a is not None and b is not None
        )
        if fits and kinds:
            mask = [a if b is None else b for a, b in zip(kinds, mask, strict=True)]
        else:
            # Empty rows count as rows of the kind below them.
            start, mask = i, kinds
            while empty and len(cells[start - 1]) == len(row):
                start, empty = start - 1, empty - 1
        empty = empty + 1 if kinds and not any(kind is not None for kind in kinds) else 0
        run = (start, i + 1, mask)
        if True in mask and (best is None or best[0] == start or _weight(*run) > _weight(*best)):
            best = run
        if True in mask and i + 1 - start >= _ENOUGH:
            break
    if best is None:
        return None
    start, end, mask = best
    # Strokes below the names are no row.
    while all(cell.strip("-") == "" for cell in cells[start]):
        start += 1
    return _first_row(lines, cells, start, mask, number), end, mask


def _first_row(
    lines: Sequence[Line],
    cells: Sequence[list[str]],
    start: int,
    mask: Sequence[bool | None],
    number: Callable[[str], object],
) -> int:
    """First row of numbers; a wrong one among the first is reported, not skipped."""
    lead = mask.index(True)
    first = start
    for i in reversed(range(start)):
        kinds = _kinds(cells[i], number)
        if is_comment(lines[i].text) or not any(kind is not None for kind in kinds):
            continue
        if True not in kinds:
            break  # the names
        is_complete = len(kinds) == len(mask)
        sound = is_complete and not any(m and k is False for m, k in zip(mask, kinds, strict=True))
        # Settings begin with a text, rows with a number.
        if sound or (is_complete and kinds[lead] and first == i + 1):
            first = i
    return first


def _kinds(row: Sequence[str], number: Callable[[str], object]) -> list[bool | None]:
    return [
        True if number(with_hyphen(cell)) else None if is_missing(cell) else False for cell in row
    ]


def _weight(start: int, end: int, mask: Sequence[bool | None]) -> float:
    """Score of rows as those of a record: lines of settings may be of one kind, too."""
    numbers, texts = mask.count(True), mask.count(False)
    # One column is no record: "1,5" is that only where it can be nothing else.
    columns = numbers if numbers > 1 else 0.1
    return columns * numbers / (numbers + texts) * min(end - start, 50)


def with_hyphen(cell: str) -> str:
    """A cell whose minus sign is the one of programs."""
    return cell.replace("\N{MINUS SIGN}", "-")


def _filled(mask: Sequence[bool | None]) -> int:
    """Cells up to the last that is not always empty."""
    return max(i for i, kind in enumerate(mask) if kind is not None) + 1


def _names(
    lines: Sequence[Line],
    start: int,
    separator: str | None,
    width: int,
    mask: Sequence[bool | None],
) -> tuple[tuple[str, ...], tuple[str | None, ...], tuple[int | None, int | None]]:
    """Names and units above the rows, and their lines."""
    above = [line for line in reversed(lines[:start]) if re.search(r"[^\W_]|%|°", line.text)]
    heads = (_heading_cells(line, separator, width, mask) for line in above[:_FAR])
    first = next(heads, None)
    if first is None and not (above and any(map(_is_number, split(above[0].text, separator)))):
        # A remark may stand between names and rows, but no broken row: then units tell the names.
        for line, head in zip(above[1:_FAR], heads, strict=False):
            if any(map(_is_number, split(line.text, separator))):
                break
            if head and (_tells_units(head[1]) or all(map(is_only_unit, head[1]))):
                first = head
                break
    if first is None:
        return (), (), (None, None)
    line, cells = first
    if all(map(is_only_unit, cells)):
        units = tuple(None if unit in ("", "-", "–") else unit for unit in map(unbracketed, cells))
        second = next(heads, None)
        if second:
            # Of "[s]" and "s" the unit is the same; a shorter row says nothing of the others.
            return tuple(second[1]), units, (second[0].above, line.above)
        if all(cell.startswith(("[", "(")) for cell in cells):
            return ("",) * len(cells), units, (None, line.above)
    return tuple(cells), (), (line.above, None)


def _tells_units(cells: Sequence[str]) -> bool:
    return any("[" in cell or "(" in cell for cell in cells) and any(
        name_and_unit(cell)[1] for cell in cells
    )


def _heading_cells(
    line: Line, separator: str | None, width: int, mask: Sequence[bool | None]
) -> tuple[Line, list[str]] | None:
    """Cells of a line that has one for each column."""
    text = line.text.strip().lstrip(_MARKS) if line.text[:1] in "#%!/*" else line.text
    fewest = _filled(mask)
    for cells in _splits(text, separator):
        of_line = cells
        while cells and not cells[-1]:
            cells = cells[:-1]
        if len(cells) < fewest <= len(of_line) and cells and all(map(is_only_unit, cells)):
            cells = of_line[:fewest]  # columns without a unit
        if len(cells) == width + 1 and cells[-1].casefold() == "comment":
            cells = cells[:-1]  # LabVIEW has a column for comments and seldom one of them
        if fewest <= len(cells) <= width and any(cells) and not any(map(_is_number, cells)):
            return line, cells
    return None


def _is_number(cell: str) -> bool:
    """Whether a cell, without what is in brackets behind it, is a number."""
    name = re.split(r"\s*[\[(]", cell, maxsplit=1)[0]
    return bool(_POINT.fullmatch(name) or _COMMA.fullmatch(name))


def _splits(text: str, separator: str | None) -> Iterator[list[str]]:
    """Cells of a line of names, which may hold spaces where spaces separate the numbers."""
    yield split(text, separator)
    if separator is None:
        for mark in ("\t", ";", ","):
            if mark in text:
                yield split(text, mark)
        yield re.split(r"\s{2,}", text.strip())
        yield re.split(r"\s+(?![^\[(]*[\])])(?![\[(])", text.strip())
    pieces = _BRACKETED.findall(text)
    if pieces and "".join(pieces).strip() == text.strip():
        yield [piece.strip() for piece in pieces]
