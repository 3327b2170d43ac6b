"""From the numbers of a column to SI floats: unit, calibration, zero and sign."""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Decimal, DecimalException
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import FORCE, MASS, Kind, QuantityError, engineering, factor_of, to_si
from microslip._core.wording import quoted, shorten, show
from microslip.errors import InputError, in_python
from microslip.readers.tables import Named, fits
from microslip.tribometer.roles import KINDS, is_raw

ZEROS = ("mean", "middle", "first")
"""Choices of zero, besides a value."""

_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*", re.IGNORECASE)
_FACTOR = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)\s*")


class Scale(NamedTuple):
    """Factor and offset from the numbers of a file to SI."""

    factor: Decimal
    words: str
    """Source, for the notes."""


def scale_of(column: Named, role: str, unit: object, calibration: object) -> Scale:
    """SI value of one in a column."""
    kind = KINDS[role]
    name = f'{role}: column "{shorten(column.heading, 40)}": '
    if unit is not None and (not isinstance(unit, str) or not unit.strip()):
        raise ValueError(f'{role}: wanted a unit such as "{kind.usual[1]}", got {show(unit)}')
    unit_text, where = (str(unit).strip(), "as stated") if unit else (column.unit, column.where)
    if calibration is not None:
        return _calibrated(column, role, unit_text, calibration)
    if unit_text is None:
        usual = "s" if role == "time" else kind.usual[1]
        no_time = ", or `time=False`" if role == "time" else ""
        units_wanted = f"`units={in_python({role: usual})}`"
        raise InputError(f"{name}no unit; write {units_wanted}{no_time}")
    if kind is FORCE and fits(unit_text, MASS):
        # Scales and load cells show masses for the force of their weight.
        factor = factor_of(f"{unit_text}*g_0", kind, "")
        return Scale(factor, f"{unit_text} {where}, as the weight of that mass")
    try:
        factor = factor_of(
            unit_text, kind, f'{name}wanted a unit such as "{kind.usual[1]}", got "{unit_text}"'
        )
    except QuantityError as error:
        factor_wanted = f"`calibration={in_python({role: f'10 {kind.usual[1]}/V'})}`"
        volts = f"; of a sensor write {factor_wanted}" if is_raw(unit_text) else ""
        raise InputError(f"{error}{volts}") from None
    words = f"{unit_text} {where}"
    if unit and column.unit and column.unit != unit_text:
        words += f' (against "{shorten(column.unit, 24)}" {column.where})'
    return Scale(factor, words)


def _calibrated(column: Named, role: str, unit: str | None, calibration: object) -> Scale:
    kind = KINDS[role]
    example = f'"10 {kind.usual[1]}/V"'
    if isinstance(calibration, str) and _NUMBER.fullmatch(calibration):
        calibration = float(calibration)  # on the command line all is text
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
                f"{role}: wanted a calibration such as {example}, got {show(calibration)}"
            )
        factor_text = f"{match[1]} {match[2]}"
        if unit is None:
            # What the factor is per is what the column counts in.
            unit = match[2].rpartition("/")[2].strip() if "/" in match[2] else None
        try:
            per = Decimal(1) if unit is None else _own_factor(unit)
            factor_unit = kind.unit if unit is None else f"{kind.unit}/({unit})"
            message = f"{role}: wanted a calibration such as {example}, got {show(calibration)}"
            if unit is not None:
                message += f" for a column in {unit}"
            factor = Decimal(match[1]) * per
            factor *= factor_of(match[2], Kind("calibration", factor_unit, (example,)), message)
        except DecimalException:
            raise ValueError(
                f"{role}: wanted a calibration such as {example}, got {factor_text}"
            ) from None
    if not factor or not factor.is_finite():
        raise ValueError(f"{role}: wanted a calibration that is not zero, got {show(calibration)}")
    counts = f", column in {unit}" if unit else ""
    return Scale(factor, f"by the calibration {factor_text}{counts}")


def _own_factor(unit: str) -> Decimal:
    """SI value of one of a unit, whatever its dimension."""
    return factor_of(
        unit, Kind("number", unit, (unit,)), f'wanted a unit, got "{shorten(unit, 24)}"'
    )


def zero_of(zero: object, role: str, values: Floats) -> tuple[float, str]:
    """The value that is zero, in SI units, and what the notes say of it."""
    kind = KINDS[role]
    if zero is None:
        return 0.0, ""
    if zero == "mean":
        value = float(values.mean())
    elif zero == "middle":
        value = 0.5 * (float(values.min()) + float(values.max()))
    elif zero == "first":
        value = float(values[0])
    elif isinstance(zero, (int, float)) and not isinstance(zero, bool) and np.isfinite(zero):
        value = float(zero)
    else:
        message = f"{role}: wanted a zero such as {quoted([*ZEROS, f'1 {kind.usual[1]}'])}"
        if not isinstance(zero, str):
            raise ValueError(f"{message}, got {show(zero)}")
        try:
            value = to_si(zero, kind, f"1 {kind.usual[1]}", "any")
        except QuantityError:
            raise ValueError(f"{message}, got {show(zero)}") from None
    how = f"its {zero} value, " if zero in ZEROS else ""
    return value, f"zero at {how}{engineering(value, kind.unit)}"


def sign_of(sign: object, role: str) -> int:
    """1 or -1."""
    if sign in (1, -1) and not isinstance(sign, bool):
        return int(sign)
    raise ValueError(f"{role}: wanted a sign 1 or -1, got {show(sign)}")


def by_role(name: str, option: object, example: dict[str, Any]) -> Mapping[str, Any]:
    """A mapping whose keys are parts of a record."""
    if option is None:
        return {}
    if not isinstance(option, Mapping):
        raise InputError(f"wanted `{name}={in_python(example)}`, got {show(option)}")
    for key in option:
        if key not in KINDS:
            raise InputError(f"`{name}`: wanted one of {quoted(KINDS)}, got {show(key)}")
    return option
