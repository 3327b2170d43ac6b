"""What stands above the columns of a text: their names, and the units they are in."""

from __future__ import annotations

import re
from typing import NamedTuple

from microslip._core.units import LENGTH, QuantityError, to_si

_LONGEST = 400  # characters of a line of names
_WORD = r"[^\W\d_]{1,12}|\ufffdm"
_CELL = re.compile(
    rf"(?P<name>.*?)\s*(?:\[\s*(?P<square>{_WORD})\s*\]|\(\s*(?P<round>{_WORD})\s*\)"
    rf"|/\s*(?P<slash>{_WORD})|_(?P<low>nm|um|µm|μm|mm|cm))"
)
# A name and the unit behind it, of names that blanks or nothing but their brackets set apart.
_NAMED = re.compile(r"[^\s\[\](),;]+(?:\s*(?:\[[^\][]*\]|\([^()]*\)))?|\[[^\][]*\]|\([^()]*\)")
_BRACKETS = re.compile(rf"[\[(]\s*({_WORD})\s*[\])]")
_NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:[.,]\d+)?(?![\w.])")


class Names(NamedTuple):
    """Names of columns, and the unit of length that each is said to be in; None if it is not."""

    names: tuple[str, ...]
    units: tuple[str | None, ...]

    @property
    def tell(self) -> bool:
        """Whether anything can be learnt from them."""
        return any(self.units) or self.are_points

    @property
    def are_points(self) -> bool:
        """Whether the first three are called x, y and z."""
        return [name.strip(" \"'").lower() for name in self.names[:3]] == ["x", "y", "z"]


def names_of(line: str, columns: int, separator: str | None) -> Names | None:
    """Names in a line above the rows, if there is one for each column.

    Parameters
    ----------
    line : str
        The line.
    columns : int
        Columns of the rows.
    separator : str or None
        What stands between the numbers; None for blanks.

    Returns
    -------
    Names or None
        None of a line that is no such one.
    """
    bare = line.strip().lstrip("#%/ ")
    separated = separator is not None and separator in bare
    if len(bare) > _LONGEST or (not separated and _NUMBER.search(bare)):
        return None
    cells = bare.split(separator) if separated else _NAMED.findall(bare)
    while len(cells) > columns and not cells[-1].strip():
        cells.pop()
    if len(cells) == columns:
        found = [_cell(cell) for cell in cells]
        names = Names(tuple(name for name, _ in found), tuple(unit for _, unit in found))
        if names.tell:
            return names
    # Names of several words are not told apart, but their units are.
    units = [unit for unit in map(_length, _BRACKETS.findall(bare)) if unit]
    return Names((), tuple(units)) if len(units) == columns > 1 else None


def _cell(text: str) -> tuple[str, str | None]:
    text = text.strip().strip("\"'").strip()
    match = _CELL.fullmatch(text)
    if match is None:
        return text, None
    unit = _length(next(match[key] for key in ("square", "round", "slash", "low") if match[key]))
    return (text, None) if unit is None else (match["name"], unit)


def _length(word: str) -> str | None:
    """A word if it is a unit of length."""
    unit = word.replace("\ufffd", "µ")  # of another encoding, nothing else before m is no letter
    try:
        to_si(f"1 {unit}", LENGTH, "1 um")
    except QuantityError:
        return None
    return unit
