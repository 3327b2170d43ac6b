"""Assignment of columns to the quantities of a record, and conversion of their numbers to SI.

The role of a column, such as "force" or "time", follows from its name and unit.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from decimal import Decimal, DecimalException
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.units import (
    FORCE,
    LENGTH,
    MASS,
    Kind,
    QuantityError,
    engineering,
    factor_of,
    is_unit,
    to_si,
)
from microslip._core.wording import quote, quoted, shorten
from microslip.readers.tables import Named, fits, headings, unique_name

RECORD_TIME = Kind("time", "s", ("us", "ms", "s", "min", "h"))

ROLE_KINDS = {
    "displacement": LENGTH,
    "force": FORCE,
    "normal_load": FORCE,
    "time": RECORD_TIME,
}
"""Quantities of a record, in the order of messages."""
CYCLE_NUMBER = "cycle_number"
ROLES = (*ROLE_KINDS, CYCLE_NUMBER)
"""Column roles: these quantities, and the rig's cycle counter, which has no unit."""

_RAW = (
    Kind("voltage", "V", ("mV", "V")), Kind("current", "A", ("mA", "A")),
    Kind("number", "count", ("count",)),
)  # fmt: skip

NEEDED = ("displacement", "force")
# Words of names, in English, German, French and Japanese.
_TIME = {"time", "elapsed", "timestamp", "zeit", "temps", "時間", "時刻", "経過時間"}
_MOVED = {
    "displacement", "displacements", "disp", "position", "pos", "stroke", "slip", "travel",
    "deflection", "lvdt", "elongation", "weg", "verfahrweg", "verschiebung", "auslenkung",
    "déplacement", "deplacement", "glissement", "変位", "位置", "ストローク",
}  # fmt: skip
_ALONG = {
    "friction", "frictional", "tangential", "lateral", "shear", "traction", "reibkraft",
    "reibungskraft", "reibung", "tangentialkraft", "querkraft", "tangentielle", "tangentiel",
    "frottement", "摩擦", "接線", "せん断", "水平", "横荷重",
}  # fmt: skip
_ACROSS = {
    "normal", "normalkraft", "normale", "normallast", "clamp", "clamping", "preload", "vertical",
    "垂直", "法線", "鉛直", "押付", "締付", "軸荷重", "軸力",
}  # fmt: skip
_FORCES = {"force", "forces", "kraft", "effort", "loadcell", "力", "ロードセル"}
_LOADS = {"load", "last", "charge", "荷重"}
_NEITHER = {
    "coefficient", "coeff", "cof", "ratio", "velocity", "speed", "acceleration", "temperature",
    "temp", "torque", "energy", "moment", "power", "rate", "error", "stiffness", "stress", "wear",
    "height", "raw", "counter", "number", "cycle", "cycles", "係数", "速度", "温度",
    "応力", "摩擦距離", "仕事", "エネルギー", "トルク", "剛性", "摩耗", "圧力",
    "commanded", "command", "cmd", "setpoint", "target", "demand", "soll", "sollwert", "指令",
}  # fmt: skip

_CYCLES = {
    "cycle", "cycles", "zyklus", "zyklen", "lastwechsel", "schwingspiel", "schwingspiele",
    "サイクル",
}  # fmt: skip
_COUNTED = {
    "number", "no", "nr", "num", "nummer", "zahl", "count", "counter", "index", "id", "zykluszahl",
    "zyklenzahl", "zyklusnummer", "lastwechselzahl", "lastspielzahl", "数",
}  # fmt: skip

_COEFFICIENTS = {
    "cof", "mu", "µ", "μ", "reibwert", "reibungszahl", "reibzahl", "reibkoeffizient", "摩擦係数",
}  # fmt: skip

_TELLING = _TIME | _MOVED | _ALONG | _ACROSS | _FORCES | _LOADS | _NEITHER
# Japanese names are written without spaces; "力" alone is also the end of 圧力, pressure.
_JAPANESE = {word for word in _TELLING | _CYCLES | _COEFFICIENTS | _COUNTED if word > "぀"} - {"力"}

# Symbols that are complete names; those of _WITH_UNIT count only with a matching unit.
_SYMBOLS = {
    "x": "displacement", "X": "displacement", "δ": "displacement", "delta": "displacement",
    "F": "force", "Ft": "force", "FT": "force", "Ff": "force", "Fx": "force", "F_t": "force",
    "F_T": "force", "F_x": "force", "F_f": "force", "F_R": "force", "FR": "force",
    "Fn": "normal_load", "FN": "normal_load", "Fz": "normal_load", "F_n": "normal_load",
    "F_N": "normal_load", "F_z": "normal_load", "t": "time",
}  # fmt: skip
_WITH_UNIT = {
    "d": "displacement", "u": "displacement", "s": "displacement", "T": "force", "Q": "force",
    "P": "normal_load", "N": "normal_load", "W": "normal_load",
}  # fmt: skip


def guess(columns: Sequence[Named], role: str, by_part: Mapping[str, Named]) -> tuple[Named, str]:
    """Return the column of a role by its name, else by its unit, and the reason in words.

    Columns in ``by_part``, which already have a role, are excluded. Raises LookupError if no column
    has the role, InputError if several could have it.
    """
    free = [c for c in columns if c not in by_part.values()]
    by_name = [c for c in free if role_of(c) == role]
    how = "by its name"
    if not by_name and role in (*NEEDED, "time"):
        by_name = [c for c in free if role_of(c) is None and fits(c.unit, ROLE_KINDS[role])]
        by_name = [c for c in by_name if not _words(c.short) & _TELLING]
        how = f"by its unit, the only {ROLE_KINDS[role].name} without a known name"
    if not by_name or (role == CYCLE_NUMBER and len(by_name) > 1):
        raise LookupError(role)
    if len(by_name) > 1:
        or_false = "" if role in NEEDED else f", or `{role}=False`"
        raise InputError(
            f"`{role}`: {len(by_name)} columns could be it, {headings(by_name[:20])}; write "
            f'`{role}="{unique_name(by_name[0], columns)}"`{or_false}'
        )
    return by_name[0], how


def is_of_loop(column: Named) -> bool:
    """Return whether a column, for example a force, indicates a friction test, not a ring-down."""
    if role_of(column) in ("force", "normal_load", CYCLE_NUMBER):
        return True
    return is_coefficient(column) or fits(column.unit, FORCE)


def is_coefficient(column: Named) -> bool:
    """Return whether a column is a friction coefficient, by its name."""
    words = _words(column.short)
    named = words & _COEFFICIENTS or (words & {"coefficient", "coeff", "ratio"} and words & _ALONG)
    return bool(named) and column.unit in (None, "%", "percent")


def role_of(column: Named) -> str | None:
    """Return the role of a column by its name; None if its unit contradicts the name."""
    role = _by_words(column.short) or _by_symbol(column)
    if role == CYCLE_NUMBER:
        return role if column.unit is None or not is_unit(column.unit) else None
    if role is None or column.unit is None or fits(column.unit, ROLE_KINDS[role]):
        return role
    if ROLE_KINDS[role] is FORCE and fits(column.unit, MASS):
        return role  # the weight of the mass
    # Volts and counts may be any quantity; an unknown unit is reported later.
    return role if is_raw(column.unit) or not is_unit(column.unit) else None


def is_raw(unit: str) -> bool:
    """Return whether a unit is that of an uncalibrated signal, such as volts or counts."""
    return any(fits(unit, kind) for kind in _RAW)


def _words(name: str) -> set[str]:
    parted = re.sub(r"(?<=[a-zà-ÿ])(?=[A-Z])", " ", name)
    parted = re.sub(r"load[ _]cell", "loadcell", parted, flags=re.IGNORECASE)
    words = re.findall(r"[^\W\d_]+", parted.casefold())
    parts = ({part for part in _JAPANESE if part in word} or {word} for word in words)
    return set().union(*parts)


def _by_words(name: str) -> str | None:
    words = _words(name)
    if words & (_CYCLES | {word for word in _COUNTED if len(word) > 8}):
        return CYCLE_NUMBER if words <= _CYCLES | _COUNTED else None
    if words & _NEITHER:
        return None
    across, along, moved = words & _ACROSS, words & _ALONG, words & _MOVED
    force = words & (_FORCES | _LOADS)
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
    return role if role is not None and fits(column.unit, ROLE_KINDS[role]) else None


def with_unit_of_other_force(column: Named, other: Named) -> Named:
    """Give a force column without a unit that of the other one if both are symbols, Fx and Fz."""
    symbols = {"force", "normal_load"}
    is_pair = all(_SYMBOLS.get(one.short) in symbols for one in (column, other))
    if not is_pair or column.unit is not None or not fits(other.unit, FORCE):
        return column
    return column._replace(unit=other.unit, where=f'as "{shorten(other.heading, 40)}"')


# -- from numbers to SI ----------------------------------------------------------------------------

ZEROS = ("mean", "middle", "first")
"""Named choices of the zero, besides a value."""

_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*", re.IGNORECASE)
_FACTOR = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)\s*")


class Scale(NamedTuple):
    """Factor from the numbers of a column to SI units."""

    factor: Decimal
    words: str
    """Source of the conversion, for the notes."""


def scale_of(column: Named, role: str, unit: object, calibration: object) -> Scale:
    """Return the factor of a column to SI units, from its unit or the calibration."""
    kind = ROLE_KINDS[role]
    name = f'{role}: column "{shorten(column.heading, 40)}": '
    if unit is not None and (not isinstance(unit, str) or not unit.strip()):
        raise ValueError(f'{role}: wanted a unit such as "{kind.usual[1]}", got {quote(unit)}')
    unit_text, where = (str(unit).strip(), "as stated") if unit else (column.unit, column.where)
    if calibration is not None:
        return _calibrated(column, role, unit_text, calibration)
    if unit_text is None:
        usual = "s" if role == "time" else kind.usual[1]
        no_time = ", or `time=False`" if role == "time" else ""
        units_wanted = f'`units={{"{role}": "{usual}"}}`'
        raise InputError(f"{name}no unit; write {units_wanted}{no_time}")
    if kind is FORCE and fits(unit_text, MASS):
        # Balances and load cells display the mass for the weight force.
        factor = factor_of(f"{unit_text}*g_0", kind, "")
        return Scale(factor, f"{unit_text} {where}, as the weight of that mass")
    try:
        factor = factor_of(
            unit_text, kind, f'{name}wanted a unit such as "{kind.usual[1]}", got "{unit_text}"'
        )
    except QuantityError as error:
        factor_wanted = f'`calibration={{"{role}": "10 {kind.usual[1]}/V"}}`'
        volts = f"; of a sensor write {factor_wanted}" if is_raw(unit_text) else ""
        raise InputError(f"{error}{volts}") from None
    words = f"{unit_text} {where}"
    if unit and column.unit and column.unit != unit_text:
        words += f' (against "{shorten(column.unit, 24)}" {column.where})'
    return Scale(factor, words)


def _calibrated(column: Named, role: str, unit: str | None, calibration: object) -> Scale:
    kind = ROLE_KINDS[role]
    example = f'"10 {kind.usual[1]}/V"'
    if isinstance(calibration, str) and _NUMBER.fullmatch(calibration):
        calibration = float(calibration)  # command-line values are text
    if isinstance(calibration, (int, float)) and not isinstance(calibration, bool):
        if fits(unit, kind):
            raise ValueError(
                f'{role}: column "{shorten(column.heading, 40)}" is in {unit} already; '
                f'to correct it write "{calibration:g} {unit}/{unit}"'
            )
        factor, factor_text = Decimal(repr(float(calibration))), f"{calibration:g} {kind.unit}"
    else:
        match = _FACTOR.fullmatch(calibration) if isinstance(calibration, str) else None
        if match is None:
            raise ValueError(
                f"{role}: wanted a calibration such as {example}, got {quote(calibration)}"
            )
        factor_text = f"{match[1]} {match[2]}"
        if unit is None:
            # The denominator of the factor is the unit of the column.
            unit = match[2].rpartition("/")[2].strip() if "/" in match[2] else None
        try:
            per = Decimal(1)
            if unit is not None:
                wrong = f'wanted a unit, got "{shorten(unit, 24)}"'
                per = factor_of(unit, Kind("number", unit, (unit,)), wrong)
            factor_unit = kind.unit if unit is None else f"{kind.unit}/({unit})"
            message = f"{role}: wanted a calibration such as {example}, got {quote(calibration)}"
            if unit is not None:
                message += f" for a column in {unit}"
            factor = Decimal(match[1]) * per
            factor *= factor_of(match[2], Kind("calibration", factor_unit, (example,)), message)
        except DecimalException:
            raise ValueError(
                f"{role}: wanted a calibration such as {example}, got {factor_text}"
            ) from None
    if not factor or not factor.is_finite():
        raise ValueError(f"{role}: wanted a calibration that is not zero, got {quote(calibration)}")
    counts = f", column in {unit}" if unit else ""
    return Scale(factor, f"by the calibration {factor_text}{counts}")


def zero_of(zero: object, role: str, values: Floats) -> tuple[float, str]:
    """Return the value to subtract from a column [SI units], and its description for the notes."""
    kind = ROLE_KINDS[role]
    if zero is None:
        return 0.0, ""
    if isinstance(zero, str) and zero in ZEROS:
        middle = 0.5 * (values.min() + values.max())
        value = float((values.mean(), middle, values[0])[ZEROS.index(zero)])
    elif isinstance(zero, (int, float)) and not isinstance(zero, bool) and np.isfinite(zero):
        value = float(zero)
    else:
        message = f"{role}: wanted a zero such as {quoted([*ZEROS, f'1 {kind.usual[1]}'])}"
        if not isinstance(zero, str):
            raise ValueError(f"{message}, got {quote(zero)}")
        try:
            value = to_si(zero, kind, f"1 {kind.usual[1]}", "any")
        except QuantityError:
            raise ValueError(f"{message}, got {quote(zero)}") from None
    how = f"its {zero} value, " if zero in ZEROS else ""
    return value, f"zero at {how}{engineering(value, kind.unit)}"


def sign_of(sign: object, role: str) -> int:
    """Validate a sign: 1 or -1."""
    if sign in (1, -1) and not isinstance(sign, bool):
        return int(sign)
    raise ValueError(f"{role}: wanted a sign 1 or -1, got {quote(sign)}")


def by_role(
    name: str, option: object, example: str, roles: Collection[str] = ROLE_KINDS
) -> Mapping[str, Any]:
    """Validate an option that maps quantities of a record, such as "force", to values."""
    if option is None:
        return {}
    if not isinstance(option, Mapping):
        raise InputError(f"wanted `{name}={example}`, got {quote(option)}")
    for key in option:
        if key not in roles:
            raise InputError(f"`{name}`: wanted one of {quoted(roles)}, got {quote(key)}")
    return option
