"""Format of numbers in tables, on the terminal and on a page alike."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import partial
from typing import Any

from microslip._core.units import engineering, significant

UNKNOWN = "–"

# Powers of a length are not written with prefixes, but in the unit that suits them.
_POWERS = {
    "m^2": ((1.0, "m²"), (1e-4, "cm²"), (1e-6, "mm²"), (1e-12, "µm²")),
    "1/m": ((1e9, "per nm"), (1e6, "per µm"), (1e3, "per mm"), (1.0, "per m")),
    "1/m^2": ((1e12, "per µm²"), (1e6, "per mm²"), (1e4, "per cm²"), (1.0, "per m²")),
}
_MOST_VALUES = 8
_PRINTED = {"^2": "²", "^3": "³", "^4": "⁴", "*": " "}


def trimmed(unit: str, digits: int = 4) -> Callable[[float], str]:
    """Writer of numbers that somebody chose: no zeros at their end."""
    return partial(engineering, unit=unit, digits=digits, trim=True)


def value(number: float | None, unit: str, digits: int = 4) -> str:
    """Write a number with its unit, if it has one."""
    if number is None or not math.isfinite(number):
        return UNKNOWN
    return significant(number, digits) if unit in ("", "-") else engineering(number, unit, digits)


def ratio(value: float | None) -> str:
    """Write a ratio; decimals below each other where they all show something."""
    return f"{value:.3f}" if value is not None and value >= 0.0995 else significant(value)


def saturating(value: float) -> str:
    """Write a ratio that tends to one, where all slides, and says so only once it is there."""
    return ">0.999" if 0.9995 <= value < 1.0 - 1e-12 else ratio(value)


def percent(share: float | None) -> str:
    """Write a share in percent."""
    if share is None:
        return UNKNOWN
    if 0.0 < share < 1e-4:
        return "<0.01 %"
    return "0 %" if share == 0.0 else f"{significant(100.0 * share)} %"


def expected(count: float | None) -> str:
    """Write how many there are on average: whole where they are many."""
    if count is None:
        return UNKNOWN
    return f"{count:.0f}" if count >= 100.0 else significant(count)


def counted(count: float | None) -> str:
    """Write how many there are."""
    return UNKNOWN if count is None else f"{count:.0f}"


def decimals(value: float | None) -> str:
    """Write a number of any sign with three decimals, as far as they say something."""
    return UNKNOWN if value is None else f"{value:.3f}" if abs(value) < 1000.0 else f"{value:.3g}"


def signed(text: str) -> str:
    """Numbers with minus signs in place of hyphens; exponents keep theirs."""
    return re.sub(r"(?<![^\s(])-(?=\d)", "−", text)


def area(value: float | None) -> str:
    """Write an area [m²] in the unit that suits it."""
    if value is None:
        return UNKNOWN
    if value >= 1e-9:
        return f"{significant(1e6 * value)} mm²"
    return quantity(float(f"{value:.2e}"), "m^2")


def quantity(value: Any, unit: str) -> str:
    """Write what a study holds: a number with its unit, or several, or how many there are.

    Such as "0.5 µm" or "20 values, 500 N to 5 kN".
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if isinstance(value, dict):
        return ", ".join(f"{key} = {number:g}" for key, number in value.items()) or "none"
    if isinstance(value, (tuple, list)):
        if len(value) <= _MOST_VALUES:
            return ", ".join(quantity(item, unit) for item in value)
        ends = " to ".join(quantity(end, unit) for end in (min(value), max(value)))
        return f"{len(value)} values, {ends}"
    if unit in _POWERS:
        factor, unit = next(
            ((f, u) for f, u in _POWERS[unit] if abs(value) >= 0.9999 * f), _POWERS[unit][-1]
        )
        return f"{value / factor:.6g} {unit}"
    for written, printed in _PRINTED.items():
        unit = unit.replace(written, printed)
    if not unit or unit.startswith("kg"):  # a prefix of its own
        return f"{value:.6g} {unit}".rstrip()
    return engineering(value, unit, 6, trim=True)


def si(value: float) -> str:
    """Write a number with all its digits and a short exponent, such as "6.9e10" or "0.0002"."""
    text = f"{value:.10g}"
    if abs(value) >= 1e6 and "e" not in text:
        mantissa, _, exponent = f"{value:.9e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{exponent}"
    return re.sub(r"e([+-])0*", lambda match: f"e{match[1].strip('+')}", text)
