"""Roles of the columns of a record: as stated, or by unambiguous names and units."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from microslip._core.units import FORCE, LENGTH, MASS, Kind, is_unit
from microslip.errors import InputError, in_python
from microslip.readers.tables import Named, fits, headings, unmistakable

TIME = Kind("time", "s", ("us", "ms", "s", "min", "h"))

KINDS = {
    "displacement": LENGTH,
    "force": FORCE,
    "normal_load": FORCE,
    "time": TIME,
    "commanded": LENGTH,
}
"""Quantities of a record, in the order of messages."""
CYCLE_NUMBER = "cycle_number"
ROLES = (*KINDS, CYCLE_NUMBER)
"""Roles of columns: these, and the rig's counter of cycles, which has no unit."""

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

_CYCLES = {
    "cycle", "cycles", "zyklus", "zyklen", "lastwechsel", "schwingspiel", "schwingspiele",
}  # fmt: skip
_COUNTED = {
    "number", "no", "nr", "num", "nummer", "zahl", "count", "counter", "index", "id", "zykluszahl",
    "zyklenzahl", "zyklusnummer", "lastwechselzahl", "lastspielzahl",
}  # fmt: skip

_COEFFICIENTS = {"cof", "mu", "µ", "μ", "reibwert", "reibungszahl", "reibzahl", "reibkoeffizient"}

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


def guess(columns: Sequence[Named], role: str, by_part: Mapping[str, Named]) -> tuple[Named, str]:
    """The column of a role by its name, else its unit, and by what; LookupError without any."""
    free = [c for c in columns if c not in by_part.values()]
    by_name = [c for c in free if role_of(c) == role]
    how = "by its name"
    if not by_name and role in (*NEEDED, "time"):
        by_name = [c for c in free if role_of(c) is None and fits(c.unit, KINDS[role])]
        by_name = [c for c in by_name if not _words(c.short) & _TELLING]
        how = f"by its unit, the only {KINDS[role].name} that no name tells"
    if not by_name or (role == CYCLE_NUMBER and len(by_name) > 1):
        raise LookupError(role)
    if len(by_name) > 1:
        or_false = "" if role in NEEDED else f", or `{role}=False`"
        raise InputError(
            f"`{role}`: {len(by_name)} columns could be it, {headings(by_name[:20])}; write "
            f"`{role}={in_python(unmistakable(by_name[0], columns))}`{or_false}"
        )
    return by_name[0], how


def is_of_loop(column: Named) -> bool:
    """Whether a column is of a contact, which no ring-down has beside its sensor."""
    if role_of(column) in ("force", "normal_load", "commanded", CYCLE_NUMBER):
        return True
    return is_coefficient(column) or fits(column.unit, FORCE)


def is_coefficient(column: Named) -> bool:
    """Whether a column is a coefficient of friction, by its name."""
    words = _words(column.short)
    named = words & _COEFFICIENTS or (words & {"coefficient", "coeff", "ratio"} and words & _ALONG)
    return bool(named) and column.unit in (None, "%", "percent")


def role_of(column: Named) -> str | None:
    """Role of a column by its name, if its unit does not speak against it."""
    role = _by_words(column.short) or _by_symbol(column)
    if role == CYCLE_NUMBER:
        return role if column.unit is None or not is_unit(column.unit) else None
    if role is None or column.unit is None or fits(column.unit, KINDS[role]):
        return role
    if KINDS[role] is FORCE and fits(column.unit, MASS):
        return role  # of which the weight is meant
    # Volts and counts may be any quantity, and an unknown unit is reported.
    return role if is_raw(column.unit) or not is_unit(column.unit) else None


def is_raw(unit: str) -> bool:
    """Whether a unit is one of signals that have to be calibrated."""
    return any(fits(unit, kind) for kind in _RAW)


def _words(name: str) -> set[str]:
    parted = re.sub(r"(?<=[a-zà-ÿ])(?=[A-Z])", " ", name)
    return set(re.findall(r"[^\W\d_]+", parted.casefold()))


def _by_words(name: str) -> str | None:
    words = _words(name)
    if words & (_CYCLES | {word for word in _COUNTED if len(word) > 8}):
        return CYCLE_NUMBER if words <= _CYCLES | _COUNTED else None
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
