"""Which column of a record is what: as stated, or by names and units that leave no doubt."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from microslip._core.units import FORCE, LENGTH, Kind, QuantityError, factor_of, is_unit
from microslip._core.wording import did_you_mean, quoted, shorten, show
from microslip.tribometer.readers.base import Column
from microslip.tribometer.readers.layout import bare

TIME = Kind("time", "s", ("us", "ms", "s", "min", "h"))

KINDS = {
    "displacement": LENGTH,
    "force": FORCE,
    "normal_load": FORCE,
    "time": TIME,
    "commanded": LENGTH,
}
"""What a record holds, in the order of messages."""

_RAW = (
    Kind("voltage", "V", ("mV", "V")),
    Kind("current", "A", ("mA", "A")),
    Kind("number", "count", ("count",)),
)

NEEDED = ("displacement", "force")

# Words of names, in English, German and French.
_TIME = {"time", "elapsed", "timestamp", "zeit", "temps"}
_COMMANDED = {"commanded", "command", "cmd", "setpoint", "target", "demand", "soll", "sollwert"}
_MOVED = {
    "displacement", "displacements", "disp", "position", "pos", "stroke", "slip", "travel",
    "deflection", "lvdt", "elongation", "weg", "verfahrweg", "verschiebung", "auslenkung",
    "déplacement", "deplacement", "glissement",
}  # fmt: skip
_ALONG = {
    "friction", "frictional", "tangential", "lateral", "shear", "traction", "reibkraft",
    "reibungskraft", "reibung", "tangentialkraft", "querkraft", "tangentielle", "tangentiel",
    "frottement",
}  # fmt: skip
_ACROSS = {
    "normal", "normalkraft", "normale", "normallast", "clamping", "preload", "vertical",
}  # fmt: skip
_FORCES = {"force", "forces", "kraft", "effort", "loadcell"}
_LOADS = {"load", "last", "charge"}
_NEITHER = {
    "coefficient", "coeff", "cof", "ratio", "velocity", "speed", "acceleration", "temperature",
    "temp", "torque", "energy", "moment", "power", "rate", "error", "stiffness", "stress", "wear",
    "height", "raw", "counter", "number", "cycle", "cycles",
}  # fmt: skip

_TELLING = _TIME | _COMMANDED | _MOVED | _ALONG | _ACROSS | _FORCES | _LOADS | _NEITHER

# Symbols that are whole names; those of the second line say it only with a fitting unit.
_SYMBOLS = {
    "x": "displacement", "X": "displacement", "δ": "displacement", "delta": "displacement",
    "F": "force", "Ft": "force", "FT": "force", "Ff": "force", "Fx": "force", "F_t": "force",
    "F_T": "force", "F_x": "force", "F_f": "force",
    "Fn": "normal_load", "FN": "normal_load", "Fz": "normal_load", "F_n": "normal_load",
    "F_N": "normal_load", "F_z": "normal_load", "t": "time",
}  # fmt: skip
_WITH_UNIT = {
    "d": "displacement", "u": "displacement", "s": "displacement", "T": "force", "Q": "force",
    "P": "normal_load", "N": "normal_load", "W": "normal_load",
}  # fmt: skip

# Text that units are made of, and that is none here.
_NO_UNITS = {"a.u.", "au", "a. u.", "arb. u.", "-", "–", "1", ""}
_HEADS = (
    re.compile(r"(?P<name>.*?)\s*\[(?P<unit>[^][]*)\]"),
    re.compile(r"(?P<name>.*?)\s*\((?P<unit>[^()]*)\)"),
    re.compile(r"(?P<name>.+?)\s*(?:\s/\s?|,\s*|\s+in\s+)(?P<unit>\S+)"),
    # Underscores are in names, too: "F_N" is no force in newtons.
    re.compile(r"(?P<name>.+)_(?P<unit>[nuµm]m|[umk]N|ms|us|sec|mV)"),
)


class Named(NamedTuple):
    """A column with its name and unit told apart."""

    place: int
    whole: str
    name: str
    short: str
    """Without the groups or structs that it is in."""
    unit: str | None
    where: str
    """Where the unit stands."""


def understood(columns: Sequence[Column]) -> list[Named]:
    """Names and units of columns, which many a header has in one text."""
    return [_named(i, column) for i, column in enumerate(columns)]


def _named(place: int, column: Column) -> Named:
    whole, unit, where = column.name or f"#{place + 1}", column.unit, "by the file"
    name, found = head(whole)
    if unit is None:
        unit, where = found, "by its header"
    unit = _known(unit) if unit and unit.casefold() not in _NO_UNITS else None
    return Named(place, whole, name, head(column.short or whole)[0], unit, where)


def head(text: str) -> tuple[str, str | None]:
    """Name and unit of a header such as "Force [N]", "Force (N)", "Force, N" or "Force / N"."""
    text = text.strip()
    for pattern in _HEADS:
        match = pattern.fullmatch(text)
        if match and match["name"].strip():
            unit = bare(match["unit"])
            # What is in square brackets is a unit, even if an unknown one.
            if "[" in text or is_unit(_known(unit)):
                return match["name"].strip(), unit
    return text, None


def _known(unit: str) -> str:
    """A unit as it is known: "Newtons" and "Sec" are, in small letters."""
    return unit.lower() if len(unit) > 2 and not is_unit(unit) and is_unit(unit.lower()) else unit


def fits(unit: str | None, kind: Kind) -> bool:
    """Whether a unit is of a kind."""
    if unit is None:
        return False
    try:
        factor_of(unit, kind, "")
    except QuantityError:
        return False
    return True


def find(columns: Sequence[Named], text: object, role: str) -> Named:
    """The column that somebody named.

    Parameters
    ----------
    columns : sequence of Named
        All of them.
    text : object
        Name with or without its unit, the last part of a path, or "#2" for the second column.
    role : str
        What it is to be, for messages.

    Returns
    -------
    Named
        The column.

    Raises
    ------
    ValueError
        If it is no name, or there is none or more than one of this name.
    """
    if not isinstance(text, str) or not text.strip():
        raise ValueError(
            f'{role}: wanted the name of a column, or "#2" for the second, got {show(text)}'
        )
    wanted = text.strip()
    small = wanted.casefold()
    for found in (
        [c for c in columns if wanted in (c.whole, f"#{c.place + 1}")],
        [c for c in columns if wanted == c.name],
        [c for c in columns if wanted == c.short],
        [c for c in columns if small in (c.whole.casefold(), c.name.casefold())],
        [c for c in columns if small == c.short.casefold()],
    ):
        if len(found) == 1:
            return found[0]
        if found:
            raise ValueError(
                f'{role}: {len(found)} columns are called "{shorten(wanted, 40)}", '
                f"{_these(found)}; write {role}={_sure(found[0], columns)}"
            )
    hint = did_you_mean(wanted, dict.fromkeys(n for c in columns for n in (c.name, c.whole)))
    raise ValueError(f'{role}: no column "{shorten(wanted, 40)}"{hint or f"; {listed(columns)}"}')


def listed(columns: Sequence[Named]) -> str:
    """All columns, for a message."""
    if all(c.whole.startswith("#") for c in columns):
        return f"the columns have no names; they are {_these(columns[:20])}"
    more = f" and {len(columns) - 20} more" if len(columns) > 20 else ""
    return f"the columns are {_these(columns[:20])}{more}"


def _these(columns: Sequence[Named]) -> str:
    return quoted((c.whole for c in columns), "and")


def _sure(column: Named, columns: Sequence[Named]) -> str:
    """What to write for a column so that no other is meant."""
    alike = [c for c in columns if c.whole == column.whole]
    text = f"#{column.place + 1}" if len(alike) > 1 else shorten(column.whole, 40)
    return f'"{text}"'


def guess(columns: Sequence[Named], role: str, taken: Mapping[str, Named]) -> tuple[Named, str]:
    """The column of a role by its name, else the only one of a fitting unit.

    Parameters
    ----------
    columns : sequence of Named
        All of them.
    role : str
        What is looked for.
    taken : mapping
        Columns that are something already, by their roles.

    Returns
    -------
    tuple of Named and str
        The column, and by what it was found.

    Raises
    ------
    LookupError
        If there is none.
    ValueError
        If there is more than one.
    """
    free = [c for c in columns if c not in taken.values()]
    by_name = [c for c in free if role_of(c) == role]
    how = "by its name"
    if not by_name and role in (*NEEDED, "time"):
        by_name = [c for c in free if role_of(c) is None and fits(c.unit, KINDS[role])]
        by_name = [c for c in by_name if not _words(c.short) & _TELLING]
        how = f"by its unit, the only {KINDS[role].name} that no name tells"
    if not by_name:
        raise LookupError(role)
    if len(by_name) > 1:
        none = "" if role in NEEDED else f", or {role}=False"
        raise ValueError(
            f"{role}: {len(by_name)} columns could be it, {_these(by_name[:20])}; "
            f"write {role}={_sure(by_name[0], columns)}{none}"
        )
    return by_name[0], how


def role_of(column: Named) -> str | None:
    """What a column is by its name, if its unit does not speak against it."""
    role = _by_words(column.short) or _by_symbol(column)
    if role is None or column.unit is None or fits(column.unit, KINDS[role]):
        return role
    # Volts and counts may be anything, and an unknown unit is to be complained of.
    return role if is_raw(column.unit) or not is_unit(column.unit) else None


def is_raw(unit: str) -> bool:
    """Whether a unit is one of signals that have to be calibrated."""
    return any(fits(unit, kind) for kind in _RAW)


def _words(name: str) -> set[str]:
    parted = re.sub(r"(?<=[a-zà-ÿ])(?=[A-Z])", " ", name)
    return set(re.findall(r"[^\W\d_]+", parted.casefold()))


def _by_words(name: str) -> str | None:
    words = _words(name)
    if words & _NEITHER:
        return None
    across, along, moved = words & _ACROSS, words & _ALONG, words & _MOVED
    force = words & (_FORCES | _LOADS)
    if words & _COMMANDED:
        return None if force or across else "commanded"
    if moved:
        return None if force or across else "displacement"
    if across or along:
        return None if across and along else "normal_load" if across else "force"
    if force:
        return "force" if force <= _FORCES else "normal_load" if force <= _LOADS else None
    return "time" if words & _TIME else None


def _by_symbol(column: Named) -> str | None:
    if column.short in _SYMBOLS:
        return _SYMBOLS[column.short]
    role = _WITH_UNIT.get(column.short)
    return role if role is not None and fits(column.unit, KINDS[role]) else None
