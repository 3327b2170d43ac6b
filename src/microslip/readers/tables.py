"""Columns of a file: names and units, selection by name, and scaling of loaded numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import NamedTuple

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.units import Kind, QuantityError, factor_of, is_unit
from microslip._core.wording import did_you_mean, quote, quoted, shorten
from microslip.readers.files import refuse_beyond

# Text in place of a unit that denotes no unit.
NO_UNITS = {"a.u.", "au", "a. u.", "arb. u.", "-", "–", "1", ""}
_VALUES = ("data", "value", "values", "samples")
"""Field names for the values of a struct, which is then named by the struct itself."""
_FORMS = (
    re.compile(r"(?P<name>.*?)\s*\[(?P<unit>[^][]*)\]"),
    re.compile(r"(?P<name>.*?)\s*\((?P<unit>[^()]*)\)"),
    re.compile(r"(?P<name>.+?)\s*(?:\s/\s?|[,:]\s*|\s+in\s+)(?P<unit>\S+)"),
    # R writes dots in place of brackets.
    re.compile(r"(?P<name>.+)\.(?P<unit>[^\W\d_]+)\."),
    # Slashes also occur in paths.
    re.compile(r"(?P<name>[^/]+)/(?P<unit>[nuµm]?m|[umk]?N|[muµ]?s|sec|m?V)"),
    # Underscores also occur in names: "F_N" is a normal load, but "force_N" a force in newtons.
    re.compile(r"(?P<name>[^\W\d_]{3,}(?:_[^\W_]+)*)_(?P<unit>[NmsV])"),
    re.compile(r"(?P<name>.+)_(?P<unit>[nuµm]m|[umk]N|ms|us|sec|mV)"),
    re.compile(r"(?P<name>[A-Z]+(?:_[A-Z]+)*)_(?P<unit>[NUM]M|KN|MS|SEC|S)"),
    # A symbol before its unit; "F_N" remains a normal load.
    re.compile(r"(?P<name>[TQPWN]|F[A-Za-z])_(?P<unit>k?N)"),
    re.compile(r"(?P<name>[xXudsδ])_(?P<unit>m)"),
    re.compile(r"(?P<name>t)_(?P<unit>s)"),
    re.compile(r"(?P<name>.{2,})\s(?P<unit>[nuµm]m|[umk]?N|[mu]?s|sec)"),
)
_WIDE = str.maketrans("（）［］／", "()[]/")  # of Japanese headings
_CAPITALS = {"NM": "nm", "UM": "um", "MM": "mm", "KN": "kN", "S": "s", "MS": "ms", "SEC": "s"}
"""Units in files written in capital letters, where "MM" is no megametre."""


def name_and_unit(heading: str) -> tuple[str, str | None]:
    """Split a heading into name and unit: "Force [N]", "Force (N)", "Force, N" or "Force / N"."""
    heading = heading.strip().translate(_WIDE)
    for form in _FORMS:
        match = form.fullmatch(heading)
        if match and match["name"].strip():
            unit = unbracketed(match["unit"])
            # Text in square brackets is a unit, even an unknown one.
            if "[" in heading or is_unit(spelt(unit)):
                return match["name"].strip(), unit
    return heading, None


def unbracketed(cell: str) -> str:
    """Return a unit without the brackets around it."""
    cell = cell.strip()
    for pair in ("[]", "()", "<>"):
        if len(cell) > 1 and cell[0] == pair[0] and cell[-1] == pair[1]:
            return cell[1:-1].strip()
    return cell


def spelt(unit: str) -> str:
    """Return a unit in its accepted spelling, such as "newtons" for "Newtons"."""
    if unit in _CAPITALS:
        return _CAPITALS[unit]
    return unit.lower() if len(unit) > 2 and not is_unit(unit) and is_unit(unit.lower()) else unit


def is_only_unit(cell: str) -> bool:
    """Return whether a cell contains a unit or nothing, as in a row of units."""
    text = unbracketed(cell)
    # Text in square brackets is a unit, even an unknown one.
    return cell.startswith("[") or text in ("", "-", "–") or is_unit(spelt(text))


class RawColumn(NamedTuple):
    """Column, channel, variable or data set of a file."""

    heading: str
    """Name in the file, including its unit if given there; "" if there is none."""
    unit: str | None = None
    """Unit stated by the file."""
    size: int | None = None
    """Number of samples, if known before loading."""
    rate: float | None = None
    """Sample rate [Hz] of this column stated by the file."""
    short: str | None = None
    """Name without its groups or structs, if it has any."""


class Stated(NamedTuple):
    """Number that the file states for all columns, such as a sampling rate."""

    value: float
    """Value in SI units."""
    where: str
    """Name in the file."""


@dataclass(frozen=True)
class RawTable:
    """Columns of one file, with a function that loads their numbers."""

    kind: str  # kind and layout of the file, for the notes
    columns: tuple[RawColumn, ...]  # in file order
    load: Callable[[Sequence[int]], list[Floats]]
    """Load the columns at these indices as new arrays."""
    where: Callable[[int], str] = lambda row: f"sample {row}"
    """Name the row of this index, such as "line 12"."""
    stated: Mapping[str, Stated] = field(default_factory=dict)
    """Other numbers stated by the file, such as "sample_rate" [Hz]."""


def refuse_long(columns: Iterable[RawColumn]) -> None:
    """Raise an InputError if columns have more samples than the limit of numbers."""
    refuse_beyond(sum(column.size or 0 for column in columns))


class Named(NamedTuple):
    """Column with separate name and unit."""

    place: int
    heading: str
    name: str
    short: str
    """Name without its groups or structs."""
    unit: str | None
    where: str
    """Source of the unit."""


def understood(columns: Sequence[RawColumn]) -> list[Named]:
    """Return the columns with name and unit separated."""
    return [_named(place, column) for place, column in enumerate(columns)]


def _named(place: int, column: RawColumn) -> Named:
    heading, unit, where = column.heading or f"#{place + 1}", column.unit, "by the file"
    words = heading
    short, in_short = name_and_unit(column.short or heading)
    parts = re.split(r"[./]", name_and_unit(heading)[0])
    if short.casefold() in _VALUES and len(parts) > 1:
        words, short = heading[: heading.rindex(parts[-1]) - 1], parts[-2]
    name, in_heading = name_and_unit(words)
    short, in_name = name_and_unit(short)
    in_short = in_short or in_name
    if unit is None:
        unit, where = in_heading or in_short, "by its header"
    unit = spelt(unit) if unit and unit.casefold() not in NO_UNITS else None
    unit = unit and shorten(unit, 80)  # of a damaged file it may be anything
    return Named(place, heading, name, short, unit, where)


def fits(unit: str | None, kind: Kind) -> bool:
    """Return whether a unit can be converted to the unit of a kind, such as length."""
    if unit is None:
        return False
    try:
        factor_of(unit, kind, "")
    except QuantityError:
        return False
    return True


def find(columns: Sequence[Named], text: object, role: str = "") -> Named:
    """Find a column by name with or without unit, by the last part of a path, or as "#2".

    A name "A [um]" also finds a column "A", if there is no other with this heading.

    Raises InputError if no column, or more than one, has the name.
    """
    before = f"`{role}`: " if role else ""
    if not isinstance(text, str) or not text.strip():
        raise InputError(
            f'{before}wanted the name of a column, or "#2" for the second, got {quote(text)}'
        )
    query = text.strip()
    small, plain = query.casefold(), name_and_unit(query)[0]
    for alike in (
        [c for c in columns if query in (c.heading, f"#{c.place + 1}")],
        [c for c in columns if query == c.name],
        [c for c in columns if query == c.short],
        [c for c in columns if query == c.heading.partition("(")[0].strip()],
        [c for c in columns if small in (c.heading.casefold(), c.name.casefold())],
        [c for c in columns if small == c.short.casefold()],
        [c for c in columns if plain in (c.heading, c.name, f"#{c.place + 1}")],
    ):
        if len(alike) == 1:
            return alike[0]
        if alike:
            text = unique_name(alike[0], columns)
            raise InputError(
                f'{before}{len(alike)} columns have the name "{shorten(query, 40)}", '
                f"{headings(alike)}; write " + (f'`{role}="{text}"`' if role else f'"{text}"')
            )
    hint = did_you_mean(query, dict.fromkeys(n for c in columns for n in (c.name, c.heading)))
    advice = hint or f"; {listed(columns)}"
    raise InputError(f'{before}no column "{shorten(query, 40)}"{advice}')


def listed(columns: Sequence[Named]) -> str:
    """Format the headings of all columns as text for a message."""
    if all(c.heading.startswith("#") for c in columns):
        return f"the columns have no names; they are {headings(columns[:20])}"
    suffix = f" and {len(columns) - 20} more" if len(columns) > 20 else ""
    return f"the columns are {headings(columns[:20])}{suffix}"


def headings(columns: Sequence[Named]) -> str:
    """Format headings as a quoted list for a message."""
    return quoted((c.heading for c in columns), "and")


def unique_name(column: Named, columns: Sequence[Named]) -> str:
    """Return the heading of a column, or its number if other columns have the same heading."""
    alike = [c for c in columns if c.heading == column.heading]
    return f"#{column.place + 1}" if len(alike) > 1 else shorten(column.heading, 40)


def scale(values: Floats, factor: Decimal) -> None:
    """Multiply numbers in place by a factor.

    A factor 10^-n with n up to 22 is applied by division by 10^n, which is exact in binary, so that
    the results are correctly rounded.
    """
    if factor == 1:
        return
    _, digits, exponent = factor.normalize().as_tuple()
    # 1000 is exact as a double, 0.001 is not.
    if digits == (1,) and isinstance(exponent, int) and -22 <= exponent < 0:
        values /= 10.0**-exponent
    else:
        values *= float(factor)
