"""Formatting of numbers, tables and verdicts, for the terminal and the HTML page."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, Quantity, count, json_value
from microslip._core.units import engineering, interval_digits, significant
from microslip._core.verdicts import WORDS, Verdict
from microslip._core.wording import joined, one_line
from microslip.figures.kit import evenly
from microslip.report.document import Table, Verdicts

UNKNOWN = "–"
Wording = Callable[[str], str]  # adapts argument names in a message, such as to options


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
    """Format a count, or an expected count with three significant digits below 100."""
    return f"{count:.0f}" if count >= 100.0 or count == round(count) else significant(count)


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


def toml_length(value: float) -> str:
    """Format a length [m] for a study file."""
    return engineering(value, "m", 6, trim=True).replace("\N{MICRO SIGN}", "u")


FORMS: dict[str, Callable[[Any], str]] = {
    "ratio": ratio,
    "saturating": saturating,
    "percent": percent,
    "expected": expected,
    "decimals": decimals,
    "area": area,
    "general": significant,
}
"""Number formats by name, as quantities declare them."""


def _formatter(quantity: Quantity) -> Callable[[Any], str]:
    unit, form = quantity.unit.replace("-", ""), quantity.form
    if form.isdigit():
        return partial(_number, unit=unit, digits=int(form))
    if form == "chosen":
        return partial(engineering, unit=unit, digits=4, trim=True)
    return FORMS.get(form) or (lambda value: format(value, form).replace("%", " %"))


def _number(value: float, unit: str, digits: int) -> str:
    if unit:
        return engineering(value, unit, digits)
    return str(value) if isinstance(value, int) else significant(value, digits)


def cell(value: float | str | None, quantity: Quantity) -> str:
    """Format a value of a quantity with a suitable unit prefix."""
    if value is None:
        return UNKNOWN
    return one_line(value) if isinstance(value, str) else _formatter(quantity)(value)


def interval_text(ends: Iterable[float | None], quantity: Quantity) -> str:
    """Format a value and the ends of its interval with the digits that distinguish the ends.

    ``ends`` are value, low end and high end; any of the three may be unknown.
    """
    value, low, high = ends
    unit = quantity.unit.replace("-", "")
    if low is None and high is None:
        return cell(value, quantity)
    if high is None:
        return f"at least {_number(low or 0.0, unit, 4)}"
    if low is None:
        return f"at most {_number(high, unit, 4)}"
    middle = 0.5 * (low + high) if value is None else value
    digits = interval_digits(low, high, middle)
    between = " to ".join(_number(end, unit, digits) for end in (low, high))
    return between if value is None else f"{_number(value, unit, digits)} ({between})"


def of_records(
    rows: Sequence[Mapping[str, Any]], names: Iterable[str], **changed: Quantity
) -> DataSet:
    """Return the data set of entries of a summary; ``changed`` are other quantities by name."""
    quantities = {**QUANTITIES, **changed}
    columns = {name: (quantities[name], [row.get(name) for row in rows]) for name in names}
    return DataSet.of_rows(columns)


def texts(title: str, rows: Iterable[tuple[str, ...]], heads: Sequence[str] = ("", "")) -> Table:
    """Return a table of texts."""
    given = list(rows)
    data = {
        str(number): (count(head), [row[number] for row in given])
        for number, head in enumerate(heads)
    }
    return Table(title, DataSet.of_rows(data))


def by_quantity(title: str, data: DataSet, heads: Sequence[str], *more: Sequence[str]) -> Table:
    """Return a table with a row for each column of a data set.

    The rows of the data set are the value and, if it has an interval, its ends. ``more`` are
    further columns of the table; ``heads`` name all of them.
    """
    rows = (
        (v.quantity.label, interval_text(json_value([*v.values, None, None][:3]), v.quantity))
        for v in data.values()
    )
    return texts(title, ((*row, *rest) for row, *rest in zip(rows, *more, strict=True)), heads)


class TextTable(NamedTuple):
    """Table with formatted cells."""

    labels: list[str]
    heads: list[str]
    """Short labels, for a terminal."""
    rows: list[list[str]]
    words: list[int]
    """Indices of the columns that contain text, which is left-aligned."""
    left_out: int
    """Number of omitted rows."""


def as_text(table: Table, limit: int | None = None, *, brief: bool = False) -> TextTable:
    """Format the cells of a table, omitting columns without values.

    At most ``limit`` rows are kept, evenly spaced. With ``brief``, columns hidden on a terminal are
    omitted and, if ``table.few`` lists any row indices, only these rows are kept.
    """
    names = table.names or tuple(table.data)
    values = table.data.rows(names)
    if brief and table.few:
        places = list(table.few)
    else:
        places = evenly(len(values), min(table.most, limit or table.most))
    shown = [
        (place, table.data[name])
        for place, name in enumerate(names)
        if not (brief and name in table.hidden)
        and (not values or any(row[place] is not None for row in values))
    ]
    rows = [[cell(values[row][i], v.quantity) for i, v in shown] for row in places]
    labels = [v.quantity.label for _, v in shown]
    heads = [v.quantity.symbol or v.quantity.label for _, v in shown]
    words = [i for i, (_, v) in enumerate(shown) if v.values.dtype.kind not in "biuf"]
    return TextTable(labels, heads, rows, words, len(values) - len(places))


NO_LIMITS = "No limits are known for this law. Check the assumptions of the model yourself."
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
    # Values of the places that are named, unless they have none.
    values = [verdict.value for verdict in bad if verdict.value is not None]
    values = values or [verdict.value for verdict in verdicts if verdict.value is not None]
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
