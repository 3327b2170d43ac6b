"""Headings of columns: a name and its unit, in whatever brackets."""

from __future__ import annotations

import re

from microslip._core.units import is_unit

# Text that units are made of, and that is none here.
NO_UNITS = {"a.u.", "au", "a. u.", "arb. u.", "-", "–", "1", ""}
_FORMS = (
    re.compile(r"(?P<name>.*?)\s*\[(?P<unit>[^][]*)\]"),
    re.compile(r"(?P<name>.*?)\s*\((?P<unit>[^()]*)\)"),
    re.compile(r"(?P<name>.+?)\s*(?:\s/\s?|,\s*|\s+in\s+)(?P<unit>\S+)"),
    # Underscores are in names, too: "F_N" is no force in newtons.
    re.compile(r"(?P<name>.+)_(?P<unit>[nuµm]m|[umk]N|ms|us|sec|mV)"),
)


def name_and_unit(heading: str) -> tuple[str, str | None]:
    """Name and unit of a heading such as "Force [N]", "Force (N)", "Force, N" or "Force / N"."""
    heading = heading.strip()
    for form in _FORMS:
        match = form.fullmatch(heading)
        if match and match["name"].strip():
            unit = unbracketed(match["unit"])
            # What is in square brackets is a unit, even if an unknown one.
            if "[" in heading or is_unit(spelt(unit)):
                return match["name"].strip(), unit
    return heading, None


def unbracketed(cell: str) -> str:
    """A unit without the brackets around it."""
    cell = cell.strip()
    for pair in ("[]", "()", "<>"):
        if len(cell) > 1 and cell[0] == pair[0] and cell[-1] == pair[1]:
            return cell[1:-1].strip()
    return cell


def spelt(unit: str) -> str:
    """A unit as it is known: "Newtons" and "Sec" are, in small letters."""
    return unit.lower() if len(unit) > 2 and not is_unit(unit) and is_unit(unit.lower()) else unit


def is_only_unit(cell: str) -> bool:
    """Whether a cell holds a unit or nothing, as in a row of units."""
    text = unbracketed(cell)
    # Text in square brackets is meant as a unit, even if it is unknown.
    return cell.startswith("[") or text in ("", "-", "–") or is_unit(text)
