"""Layout of a numeric text file: separator, decimal sign, names, units, first row."""

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
_ENOUGH = 200  # rows that determine the layout
_MARKS = "#%!/*\"' \t"  # characters that may precede names in a comment
_FAR = 50  # lines above the rows that are searched for names with units
_BRACKETED = re.compile(r"[^][()]*(?:\[[^][]*\]|\([^()]*\))")


class TextLine(NamedTuple):
    """Line of text that is not empty, with the number of lines above it in the file."""

    above: int
    text: str


class Layout(NamedTuple):
    """Layout of the rows of a text file: separator, decimal sign, columns and headings."""

    separator: str | None
    """Cell separator; None for any number of spaces."""

    decimal: str | None
    """Decimal sign; None if the inspected rows contain whole numbers only."""

    first: int
    """Index of the line of the first row."""

    width: int
    """Number of cells per row."""

    names: tuple[str, ...]
    """Column names, "" for a missing name; fewer than cells if rows end in separators."""

    units: tuple[str | None, ...]
    """Units from a row of units; units in brackets after names are parsed elsewhere."""

    names_line: int | None
    units_line: int | None


def split_line(text: str, separator: str | None) -> list[str]:
    """Split a line into cells, without surrounding spaces and quotation marks."""
    if separator is None:
        return text.replace('"', "").split()
    if '"' in text:
        with suppress(csv.Error):  # not CSV: quotation marks are ordinary characters
            (cells,) = csv.reader([text.strip("\r\n")], delimiter=separator, strict=True)
            return [cell.strip() for cell in cells]
    return [cell.strip() for cell in text.strip("\r\n").split(separator)]


def is_comment(text: str) -> bool:
    """Return whether a line is a comment."""
    return text.startswith(COMMENTS) and not text.upper().startswith(("#N/A", "#NA"))


def is_missing(cell: str) -> bool:
    """Return whether a cell denotes a missing number."""
    return _MISSING.fullmatch(cell) is not None


def with_nan(text: str, separator: str) -> str:
    """Replace cells that denote missing numbers by "nan"."""
    edge = rf"[^{re.escape(separator)}\n]"
    return re.sub(rf"(?<!{edge}) *{_NOTHING} *(?!{edge})", "nan", text, flags=re.ASCII | re.I)


def find_layout(lines: Sequence[TextLine]) -> Layout | None:
    """Find the layout that gives the most numbers in consistent rows; None without such rows.

    Numeric columns raise the score and text columns lower it, which distinguishes separators from
    decimal signs: "1,5;2,5" is two numbers, or one number and one text if separated by commas.
    """
    best: tuple[float, Layout] | None = None
    quoted = any('"' in line.text for line in lines)
    for separator in SEPARATORS:
        if separator is not None and not any(separator in line.text for line in lines):
            continue
        cells = [split_line(line.text, separator) for line in lines]
        # With comma separators a decimal comma is possible only inside quotation marks.
        for decimal in (".",) if separator == "," and not quoted else (".", ","):
            run = _best_run(lines, cells, decimal)
            if run is None:
                continue
            start, end, mask = run
            score = _weight(start, end, mask)
            if best is not None and score <= best[0]:
                is_tie = best[1].separator == separator and score == best[0]
                if is_tie and decimal == ",":  # no row has a decimal sign
                    best = (score, best[1]._replace(decimal=None))
                continue
            names, units, lines_of = _names(lines, start, separator, len(mask), mask)
            if not names:
                names = ("",) * _used_width(mask)
            first, width = lines[start].above, len(cells[start])
            best = (score, Layout(separator, decimal, first, width, names, units, *lines_of))
    return best[1] if best else None


def _best_run(
    lines: Sequence[TextLine], cells: Sequence[list[str]], decimal: str
) -> tuple[int, int, list[bool | None]] | None:
    """Return first line, end (exclusive) and column kinds of the best run of consistent rows.

    The best run has the highest score by :func:`_weight`. A kind is True for a column of numbers,
    False for text and None for empty cells.
    """
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
            # Empty rows belong to the run below them.
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
    # A ruled line below the names is not a row.
    while all(cell.strip("-") == "" for cell in cells[start]):
        start += 1
    return _first_row(lines, cells, start, mask, number), end, mask


def _first_row(
    lines: Sequence[TextLine],
    cells: Sequence[list[str]],
    start: int,
    mask: Sequence[bool | None],
    number: Callable[[str], object],
) -> int:
    """Return the index of the first row of numbers, which is ``start`` or above it.

    ``number`` recognises the text of a number, and ``mask`` are the column kinds of
    :func:`_best_run`. A malformed row near the start is included, so that it is reported and not
    skipped as a heading.
    """
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
        # Lines of settings begin with a text, rows with a number.
        if sound or (is_complete and kinds[lead] and first == i + 1):
            first = i
    return first


def _kinds(row: Sequence[str], number: Callable[[str], object]) -> list[bool | None]:
    return [
        True if number(with_hyphen(cell)) else None if is_missing(cell) else False for cell in row
    ]


def _weight(start: int, end: int, mask: Sequence[bool | None]) -> float:
    """Score a run of rows by its numbers, since lines of settings can be consistent, too."""
    numbers, texts = mask.count(True), mask.count(False)
    # A single column is unlikely: "1,5" is one number only if no other reading fits.
    columns = numbers if numbers > 1 else 0.1
    return columns * numbers / (numbers + texts) * min(end - start, 50)


def with_hyphen(cell: str) -> str:
    """Replace the typographic minus sign by a hyphen."""
    return cell.replace("\N{MINUS SIGN}", "-")


def _used_width(mask: Sequence[bool | None]) -> int:
    return max(i for i, kind in enumerate(mask) if kind is not None) + 1


def _names(
    lines: Sequence[TextLine],
    start: int,
    separator: str | None,
    width: int,
    mask: Sequence[bool | None],
) -> tuple[tuple[str, ...], tuple[str | None, ...], tuple[int | None, int | None]]:
    above = [line for line in reversed(lines[:start]) if re.search(r"[^\W_]|%|°", line.text)]
    heads = (_heading_cells(line, separator, width, mask) for line in above[:_FAR])
    first = next(heads, None)
    if first is None and not (above and any(map(_is_number, split_line(above[0].text, separator)))):
        # A remark may lie between names and rows, but no malformed row: units identify the names.
        for line, head in zip(above[1:_FAR], heads, strict=False):
            if any(map(_is_number, split_line(line.text, separator))):
                break
            if head and (_has_units(head[1]) or all(map(is_only_unit, head[1]))):
                first = head
                break
    if first is None:
        return (), (), (None, None)
    line, cells = first
    if all(map(is_only_unit, cells)):
        units = tuple(None if unit in ("", "-", "–") else unit for unit in map(unbracketed, cells))
        above = above[above.index(line) + 1 : _FAR]
        if above and (second := _heading_cells(above[0], separator, width, mask, len(cells))):
            # "[s]" and "s" are the same unit; columns beyond a shorter row have no unit.
            return tuple(second[1]), units, (second[0].above, line.above)
        if all(cell.startswith(("[", "(")) for cell in cells):
            return ("",) * len(cells), units, (None, line.above)
    return tuple(cells), (), (line.above, None)


def _has_units(cells: Sequence[str]) -> bool:
    return any("[" in cell or "(" in cell for cell in cells) and any(
        name_and_unit(cell)[1] for cell in cells
    )


def _heading_cells(
    line: TextLine,
    separator: str | None,
    width: int,
    mask: Sequence[bool | None],
    size: int | None = None,
) -> tuple[TextLine, list[str]] | None:
    """Return the cells of a line of names or units; None if the line is not a heading.

    If ``size`` is given, the line is one of units below that many names, and its last cells may be
    empty.
    """
    text = line.text.strip().lstrip(_MARKS) if line.text[:1] in "#%!/*" else line.text
    fewest = _used_width(mask)
    for cells in _splits(text, separator):
        of_line = cells
        while cells and not cells[-1]:
            cells = cells[:-1]
        is_short = cells and len(cells) < fewest <= len(of_line)
        if is_short and (size == fewest or all(map(is_only_unit, cells))):
            cells = of_line[:fewest]  # columns without a name or unit
        if len(cells) == width + 1 and cells[-1].casefold() == "comment":
            cells = cells[:-1]  # LabVIEW names a comment column that is usually absent
        if fewest <= len(cells) <= width and any(cells) and not any(map(_is_number, cells)):
            return line, cells
    return None


def _is_number(cell: str) -> bool:
    name = re.split(r"\s*[\[(]", cell, maxsplit=1)[0]
    return bool(_POINT.fullmatch(name) or _COMMA.fullmatch(name))


def _splits(text: str, separator: str | None) -> Iterator[list[str]]:
    """Yield candidate splits of a line of names, which may contain spaces."""
    yield split_line(text, separator)
    if separator is None:
        for mark in ("\t", ";", ","):
            if mark in text:
                yield split_line(text, mark)
        yield re.split(r"\s{2,}", text.strip())
        yield re.split(r"\s+(?![^\[(]*[\])])(?![\[(])", text.strip())
    pieces = _BRACKETED.findall(text)
    if pieces and "".join(pieces).strip() == text.strip():
        yield [piece.strip() for piece in pieces]
