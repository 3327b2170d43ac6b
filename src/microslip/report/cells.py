"""Formatting of numbers, tables and verdicts, for the terminal and the HTML page."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, Quantity
from microslip._core.units import engineering, significant
from microslip._core.verdicts import WORDS, Verdict
from microslip._core.wording import joined, one_line
from microslip.figures.kit import evenly
from microslip.report.document import Column, Judged, Table, Value, Verdicts

UNKNOWN = "–"
Wording = Callable[[str], str]  # adapts argument names in a message, such as to options


def trimmed(unit: str, digits: int = 4) -> Callable[[float], str]:
    """Return a function that formats values with a unit, without trailing zeros."""
    return partial(engineering, unit=unit, digits=digits, trim=True)


def value(number: float | None, unit: str, digits: int = 4) -> str:
    """Format a number with its unit, or without one if the unit is ""."""
    if number is None or not math.isfinite(number):
        return UNKNOWN
    return significant(number, digits) if unit in ("", "-") else engineering(number, unit, digits)


def ratio(value: float | None) -> str:
    """Format a dimensionless ratio: three decimals from 0.1 on, three significant digits below."""
    return f"{value:.3f}" if value is not None and value >= 0.0995 else significant(value)


def saturating(value: float) -> str:
    """Format a ratio that tends to one; "1" is shown only if it equals one."""
    return ">0.999" if 0.9995 <= value < 1.0 - 1e-12 else ratio(value)


def percent(share: float) -> str:
    """Format a fraction in percent."""
    if 0.0 < share < 1e-4:
        return "<0.01 %"
    return "0 %" if share == 0.0 else f"{significant(100.0 * share)} %"


def expected(count: float) -> str:
    """Format an expected count: a whole number from 100 on, three significant digits below."""
    return f"{count:.0f}" if count >= 100.0 else significant(count)


def counted(count: float) -> str:
    """Format a count, such as a number of contacts, as a whole number."""
    return f"{count:.0f}"


def decimals(value: float) -> str:
    """Format a number of any sign with three decimals; from 1000 on three significant digits."""
    return f"{value:.3f}" if abs(value) < 1000.0 else f"{value:.3g}"


def signed(text: str) -> str:
    """Replace hyphens before numbers by minus signs, except in exponents."""
    return re.sub(r"(?<![^\s(])-(?=\d)", "−", text)


def area(value: float) -> str:
    """Format an area [m²] in a suitable unit."""
    if value >= 1e-9:
        return f"{significant(1e6 * value)} mm²"
    return f"{1e12 * float(f'{value:.2e}'):.6g} µm²"


def si(value: float) -> str:
    """Format an SI value with all digits and a short exponent, such as "6.9e10" or "0.0002"."""
    text = f"{value:.10g}"
    if abs(value) >= 1e6 and "e" not in text:
        mantissa, _, exponent = f"{value:.9e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{exponent}"
    return re.sub(r"e([+-])0*", lambda match: f"e{match[1].strip('+')}", text)


FORMS: dict[str, Callable[[Any], str]] = {
    "ratio": ratio,
    "saturating": saturating,
    "percent": percent,
    "expected": expected,
    "decimals": decimals,
    "area": area,
    "general": significant,
    "counted": counted,
}
"""Number formats by name, as quantities declare them."""


def column(name: str, quantity: Quantity | None = None, **changes: Any) -> Column:
    """Return a table column for a quantity, with its label, unit and number format.

    The quantity is by default that of :data:`microslip._core.quantities.QUANTITIES`.
    """
    quantity = quantity or QUANTITIES[name]
    unit, form, digits, write = quantity.unit.replace("-", ""), quantity.form, 4, None
    if form.isdigit():
        digits = int(form)
    elif form == "chosen":
        write = trimmed(unit)
    else:
        write = FORMS.get(form) or partial(_formatted, form)
    of_quantity = Column(
        name, quantity.label, unit if quantity.unit else None, digits, write, quantity.symbol
    )
    return replace(of_quantity, **changes)


def _formatted(form: str, value: Any) -> str:
    return format(value, form).replace("%", " %")


def table(title: str, data: DataSet, names: Sequence[str] = (), **settings: Any) -> Table:
    """Return the table of the named columns of a data set along "row", all by default.

    ``settings`` are fields of :class:`~microslip.report.document.Table`.
    """
    columns = tuple(column(name, data[name].quantity) for name in names or data)
    return Table(title, columns, tuple(data.rows(names)), **settings)


class TextTable(NamedTuple):
    """Table with formatted cells."""

    columns: tuple[Column, ...]
    rows: list[list[str]]
    words: list[list[str]]
    """Verdict word of each cell, or an empty string."""
    left_out: int
    """Number of omitted rows."""


def as_text(table: Table, limit: int | None = None, *, brief: bool = False) -> TextTable:
    """Format the cells of a table, omitting columns without values.

    At most ``limit`` rows are kept, evenly spaced. With ``brief``, only the columns marked as brief
    are kept and, if ``table.few`` lists any row indices, exactly these rows.
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
    """Format the value of a table cell with a suitable unit prefix."""
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
    """Return whether a column contains text, which is left-aligned."""
    place = table.columns.index(column)
    return column.unit is None and any(isinstance(row[place], (str, Judged)) for row in table.rows)


def _rows_shown(table: Table, limit: int) -> list[int]:
    """Return the indices of ``limit`` rows or fewer, evenly spaced.

    If the table has two or more key columns, equally many rows are kept for each value of the
    first one.
    """
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


HEADLINES = {
    "ok": "All assumptions of the model hold.",
    "not judged": "All judged assumptions hold; not judged:",
    "watch": "Interpret with care:",
    "outside": "Outside the model’s range:",
}


class Judgement(NamedTuple):
    """Worst verdict on one assumption over all loads of a result."""

    word: str
    """Worst verdict."""
    name: str
    """Name of the judged quantity."""
    value: str
    """Value, or smallest and largest value; "not known" if it is not judged."""
    bound: str
    """Limit up to which the verdict is ok."""
    where: str
    """Loads of the worst verdict, such as "at 2 kN and 5 kN"; empty for everywhere."""
    meaning: str
    """Assumption."""
    reason: str
    """Source of the limits or, if not judged, the missing input."""
    remedy: str
    """Remedy."""

    @property
    def sentence(self) -> str:
        """Sentence that describes the verdict, for a headline."""
        where = f" {self.where}" if self.where else ""
        if self.word == "not judged":
            missing = f"; {self.reason}" if self.reason else ""
            return f"{self.name} {self.value} (ok {self.bound}){where}: not judged{missing}"
        return f"{self.name} {self.value} (ok {self.bound}){where}: {self.word}"


def judgements(block: Verdicts) -> list[Judgement]:
    """Return one judgement for each judged quantity, the worst first."""
    places = block.places or ("",) * len(block.verdicts)
    groups: dict[str, list[tuple[Verdict, str]]] = {}
    for verdict, place in zip(block.verdicts, places, strict=True):
        groups.setdefault(verdict.name, []).append((verdict, place))
    judged = [_judged(name, pairs, block) for name, pairs in groups.items()]
    return sorted(judged, key=lambda judgement: -WORDS.index(judgement.word))


def value_text(block: Verdicts, name: str, value: float) -> str:
    """Format the value of a judged quantity, in percent if its name is in ``block.percent``."""
    return f"{significant(100.0 * value)} %" if name in block.percent else significant(value)


def _judged(name: str, pairs: list[tuple[Verdict, str]], block: Verdicts) -> Judgement:
    verdicts = [verdict for verdict, _ in pairs]
    worst = max((verdict.word for verdict in verdicts), key=WORDS.index)
    bad = [verdict for verdict in verdicts if verdict.word == worst]
    at = list(dict.fromkeys(place for v, place in pairs if v.word == worst and place))
    limit = verdicts[0].limit
    bound = f"{100.0 * limit:.3g} %" if name in block.percent else f"{limit:.3g}"
    values = [verdict.value for verdict in verdicts if verdict.value is not None]
    ends = (min(values), max(values)) if values else ()
    texts = list(dict.fromkeys(value_text(block, name, end) for end in ends))
    rising = any(v.word not in ("ok", "not judged") and (v.value or 0.0) < limit for v in verdicts)
    if worst == "ok":
        rising = bool(values) and min(values) >= limit
    everywhere = len(bad) == len(verdicts) and len(set(at)) == len({place for _, place in pairs})
    moving = any("," in place for place in at)
    return Judgement(
        worst,
        name.replace(" * ", " × "),
        " to ".join(texts) or "not known",
        f"{'from' if rising else 'up to'} {bound}",
        "" if everywhere and not moving else _listed(at),
        bad[0].meaning,
        getattr(bad[0], "reason", ""),
        getattr(bad[0], "remedy", ""),
    )


def _listed(places: list[str]) -> str:
    if not places:
        return ""
    if len(places) <= 3:
        return f"at {joined(places)}"
    return f"at {len(places)} loads, {places[0]} to {places[-1]}"
