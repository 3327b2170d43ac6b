"""A table as text: which rows and columns people see, and what stands in the cells."""

from __future__ import annotations

from typing import NamedTuple

from microslip._core.units import engineering, significant
from microslip._core.wording import one_line
from microslip.report.cells import UNKNOWN
from microslip.report.document import Column, Judged, Table, Value
from microslip.report.scales import evenly


class TextTable(NamedTuple):
    """A table of text."""

    columns: tuple[Column, ...]
    rows: list[list[str]]
    words: list[list[str]]
    """For each cell that is a verdict its word, else nothing."""
    left_out: int
    """How many more rows there would be."""


def as_text(table: Table, limit: int | None = None, *, brief: bool = False) -> TextTable:
    """A table for people, without the columns of which nothing is known.

    ``brief`` shows only its brief columns, and of its rows the few that are picked.
    """
    row_places = (list(table.few) if brief else []) or _rows_shown(
        table, min(table.most, limit or table.most)
    )
    column_places = [
        place
        for place, column in enumerate(table.columns)
        if (column.brief or not brief)
        and (not table.rows or any(row[place] is not None for row in table.rows))
    ]
    columns = tuple(table.columns[place] for place in column_places)
    rows = [
        [cell(table.columns[i], table.rows[row][i]) for i in column_places] for row in row_places
    ]
    cells = [[table.rows[row][i] for i in column_places] for row in row_places]
    words = [[value.word if isinstance(value, Judged) else "" for value in row] for row in cells]
    return TextTable(columns, rows, words, len(table.rows) - len(row_places))


def cell(column: Column, value: Value) -> str:
    """One value with the unit that suits it."""
    if value is None:
        return UNKNOWN
    if isinstance(value, Judged):
        return value.text
    if column.write is not None:
        return column.write(value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return one_line(value)
    if column.unit:
        return engineering(value, column.unit, column.digits)
    return str(value) if isinstance(value, int) else significant(value, column.digits)


def is_text(table: Table, column: Column) -> bool:
    """Whether a column holds words, which stand at its left."""
    place = table.columns.index(column)
    return column.unit is None and any(isinstance(row[place], (str, Judged)) for row in table.rows)


def _rows_shown(table: Table, limit: int) -> list[int]:
    """Rows that are shown: as many of each group of the first column, spread evenly."""
    count = len(table.rows)
    if count <= limit:
        return list(range(count))
    groups: dict[Value, list[int]] = {}
    for number, row in enumerate(table.rows):
        groups.setdefault(row[0], []).append(number)
    sizes = {len(group) for group in groups.values()}
    if table.keys < 2 or len(sizes) > 1 or len(groups) == 1:
        return evenly(count, limit)
    size = sizes.pop()
    within = evenly(size, max(limit // min(len(groups), 10), 1))
    among = evenly(len(groups), max(limit // len(within), 1))
    listed = list(groups.values())
    return [listed[group][place] for group in among for place in within]
