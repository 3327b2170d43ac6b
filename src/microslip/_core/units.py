"""Conversion of text with units ("0.5 um") to SI numbers, and of SI numbers to text.

All numbers inside the library are floats in SI units. Text with units is read only by this module,
which imports pint only for uncommon units.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, DecimalException
from functools import lru_cache
from typing import Any, Literal

from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip._core.wording import nearest, quote, shorten

Sign = Literal["positive", "any"]

SMALLEST, LARGEST = 1e-40, 1e40
"""Range of magnitudes in SI units for which products of a few quantities are representable."""

_NUMBER = re.compile(
    r"\s*([+-]?(?:\d[\d_]*(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)(?![a-z]))\s*",
    re.IGNORECASE,
)
_UNIT = re.compile(r"[\w%°^*/·⋅().⁻⁰¹²³⁴⁵⁶⁷⁸⁹ +-]{1,60}")


# Patterns of text after a number that indicate a mistake in the number, with the mistake.
_NOT_A_UNIT = (
    (r",\d", 'the decimal sign is the point, "."'),
    (r"(?!1\s*/)\d", "write the number without spaces"),
    (r"\.", "more than one decimal point"),
    (r"/\s*\d", "write the number as a decimal"),
    (r".*[,;]\s*[\d+-]", "more than one quantity"),
)


class QuantityError(ValueError):
    """Invalid quantity; the message states the accepted and the received value."""


@dataclass(frozen=True)
class Kind:
    """Kind of quantity: name, SI unit and usual units."""

    name: str
    unit: str
    usual: tuple[str, ...]
    pattern: str = ""  # of accepted units, if not all of its dimension are

    @property
    def with_article(self) -> str:
        """Name with its article, such as "an area"."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"


LENGTH = Kind("length", "m", ("nm", "um", "µm", "mm", "cm", "m", "micron", "in", "angstrom"))
AREA = Kind("area", "m^2", ("um^2", "mm^2", "cm^2", "m^2", "in^2"))
VOLUME = Kind("volume", "m^3", ("um^3", "mm^3", "cm^3", "m^3"))
FORCE = Kind("force", "N", ("mN", "N", "kN", "MN", "lbf", "kgf"))
PRESSURE = Kind(
    "pressure", "Pa", ("Pa", "kPa", "MPa", "GPa", "TPa", "N/mm^2", "N/m^2", "psi", "ksi", "bar")
)
HARDNESS = Kind("hardness", "Pa", ("GPa", "MPa", "HB", "HBW", "HV", "kgf/mm^2"))
DENSITY = Kind("number per area", "1/m^2", ("1/um^2", "1/mm^2", "1/cm^2", "1/m^2", "mm^-2"))
# Percent and other plain numbers have the dimension of angles as well.
ANGLE = Kind("angle", "rad", ("deg", "rad", "mrad", "°"), r"(deg|degrees?|°|rad|radians?|mrad)\s*")
MASS = Kind("mass", "kg", ("mg", "g", "kg", "t", "lb"))
STIFFNESS = Kind(
    "stiffness", "N/m", ("N/m", "kN/m", "MN/m", "N/mm", "kN/mm", "N/um", "N/µm", "N/nm", "lbf/in")
)
TORQUE = Kind("torque", "N*m", ("N m", "N*m", "kN m", "lbf in", "lbf ft"))
MASS_DENSITY = Kind("mass per volume", "kg/m^3", ("kg/m^3", "g/cm^3", "t/m^3", "lb/in^3"))
TIME = Kind("time", "s", ("us", "µs", "ms", "s", "min"))
VELOCITY = Kind("velocity", "m/s", ("m/s", "mm/s", "um/s"))
ACCELERATION = Kind("acceleration", "m/s^2", ("m/s^2", "mm/s^2"))
FREQUENCY = Kind("frequency", "Hz", ("Hz", "kHz"))
PER_LENGTH = Kind("number per length", "1/m", ("1/nm", "1/um", "1/mm", "1/m", "um^-1"))
RATIO = Kind("plain number", "", ())

_KINDS = {
    kind.unit: kind
    for kind in (
        *(LENGTH, AREA, VOLUME, FORCE, PRESSURE, DENSITY, ANGLE, MASS, STIFFNESS, TORQUE),
        *(MASS_DENSITY, TIME, VELOCITY, ACCELERATION, FREQUENCY, PER_LENGTH),
    )
}


def kind_of(unit: str) -> Kind:
    """Return the kind of quantity that has a given SI unit."""
    return _KINDS.get(unit) or Kind(f"value in {unit}", unit, (unit,))


# Names of received dimensions; the first of equal dimensions is used.
_NAMED_DIMENSIONS = {
    "": "a plain number",
    "J": "an energy or a torque",
    **{unit: kind.with_article for unit, kind in _KINDS.items()},
    "K": "a temperature",
    "V": "a voltage",
}


def to_si(raw_value: object, kind: Kind, example: str, sign: Sign = "positive") -> float:
    """Convert text with a unit to a float in SI units; QuantityError states ``example``."""
    message = f'wanted {kind.with_article} such as "{example}", got '
    if isinstance(raw_value, (int, float)) and not isinstance(raw_value, bool):
        raise QuantityError(f"{message}{quote(raw_value)} (a number without a unit)")
    if not isinstance(raw_value, str):
        raise QuantityError(message + quote(raw_value))
    came = quote(raw_value)
    number = _NUMBER.match(raw_value.replace("\N{MINUS SIGN}", "-"))
    if number is None:
        raise QuantityError(
            f"{message}{came} (no number)" if raw_value.strip() else f"{message}{came}"
        )
    unit = raw_value[number.end() :].strip()
    if not unit:
        raise QuantityError(f"{message}{came} (no unit)")
    for pattern, fault in _NOT_A_UNIT:
        if re.match(pattern, unit):
            raise QuantityError(f"{message}{came} ({fault})")
    value = scaled_decimal(number[1], factor_of(unit, kind, message + came))
    article = f"a {'finite' if not math.isfinite(value) else 'positive'} {kind.name}"
    if not math.isfinite(value) or (sign == "positive" and not value > 0.0):
        raise QuantityError(f'wanted {article} such as "{example}", got {came}')
    if value and not SMALLEST < abs(value) < LARGEST:
        raise QuantityError(f"{message}{came} (outside 1e-40 … 1e40)")
    return value


def scaled_decimal(number: str, factor: Decimal) -> float:
    """Return the double nearest to a decimal number times a factor; infinite on overflow."""
    try:
        return float(Decimal(number) * factor)
    except (DecimalException, OverflowError):
        return math.inf


def units(text: str) -> float:
    """Convert a quantity with its unit to SI units: 69e9 for "69 GPa".

    Parameters
    ----------
    text : str
        A number and a unit, such as "0.5 um", "2 kN" or "100 1/mm^2".

    Returns
    -------
    float
        Value in SI units, such as [Pa], correctly rounded.
    """
    message = 'units needs a number with its unit, such as "69 GPa", got '
    came = quote(text)
    number = _NUMBER.match(text.replace("\N{MINUS SIGN}", "-")) if isinstance(text, str) else None
    if number is None:
        raise InputError(f"{message}{came}")
    unit = text[number.end() :].strip()
    parsed = _parse(unit) if unit else None
    # Temperatures have an offset and are not supported.
    if parsed is None or any(name == "[temperature]" for name, _ in parsed[1]):
        raise InputError(f"{message}{came} ({'no such unit' if unit else 'no unit'})")
    value = scaled_decimal(number[1], parsed[0])
    if not math.isfinite(value):
        raise InputError(f"{message}{came} (outside 1e-40 … 1e40)")
    return value


_NUMBER_AND_UNIT = re.compile(rf"{_NUMBER.pattern}(.*)", re.IGNORECASE)


def with_common_unit(texts: Sequence[str]) -> tuple[str, ...]:
    """Append a common unit to quantities without unit: "0.1", "1 um" to "0.1 um", "1 um"."""
    matches = [_NUMBER_AND_UNIT.fullmatch(text.strip()) for text in texts]
    units = [match[2].strip() if match else "" for match in matches]
    unit = next(filter(None, units), "")
    return tuple(
        f"{text.strip()} {unit}".strip() if match and not its_unit else text.strip()
        for text, match, its_unit in zip(texts, matches, units, strict=True)
    )


def is_unit(text: str) -> bool:
    """Return True if a text is a unit of any dimension."""
    return bool(text) and _parse(text) is not None


# Brinell and Vickers hardness, optionally with load and time, are in kgf/mm^2.
_HARDNESS = re.compile(r"H(?:BW?|V)(?:\s*[\d./]+)?", re.IGNORECASE)
_NO_STRESS = re.compile(r"H(?:R[A-C]|K|L|S|D)\w*", re.IGNORECASE)


def factor_of(unit: str, kind: Kind, message: str) -> Decimal:
    """Return the value of one ``unit`` in SI units; QuantityError begins with ``message``."""
    if kind is HARDNESS:
        if _HARDNESS.fullmatch(unit):
            return Decimal("9.80665e6")
        if _NO_STRESS.fullmatch(unit):
            raise QuantityError(
                f"{message} (not a force per area: convert it to HB or HV by ISO 18265)"
            )
    if kind is TORQUE:  # "Nm" is a yarn count in pint
        unit = unit.replace("Nm", "N m")
    usual = {text.casefold(): text for text in kind.usual}
    near = usual.get(unit.casefold().replace(" ", ""))
    parsed = _parse(unit)
    if parsed is None:
        near = near or nearest(unit, kind.usual)
        hint = f'; did you mean "{near}"?' if near else ""
        raise QuantityError(f'{message} (unknown unit "{shorten(unit, 24)}"{hint})')
    factor, dimension = parsed
    if (expected := _parse(kind.unit)) is None or dimension != expected[1]:
        # "2 kn" is a velocity in pint (knots); suggest the unit with other case.
        name = _dimension_name(dimension)
        if near is None and name.startswith("of dimension"):
            near = nearest(unit, kind.usual)
        hint = f'; did you mean "{near}"?' if near else ""
        raise QuantityError(f"{message} ({name}{hint})")
    if kind.pattern and not re.fullmatch(kind.pattern, unit):
        raise QuantityError(f"{message} (wanted in {' or '.join(kind.usual[:2])})")
    return factor


@lru_cache(maxsize=1)
def _registry() -> Any:
    with needed_for("units other than multiples of m, g, s, N, Hz and Pa need"):
        import pint

    # Decimal factors convert "0.3 um" to the correctly rounded double 3e-7.
    return pint.UnitRegistry(non_int_type=Decimal)


# Common units, with their powers of length, mass and time. Importing pint for other units takes
# longer than most commands.
_SIMPLE = {
    "m": (1, 0, 0),
    "g": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "Hz": (0, 0, -1),
    "Pa": (-1, 1, -2),
}
_BASE = {"g": -3}
_PREFIXES = {-18: "a", -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_PREFIX = {letter: power for power, letter in _PREFIXES.items() if power >= -12}
_PREFIX |= {"c": -2, "u": -6, "μ": -6}
_FACTOR = re.compile(r"(p|c|n|u|µ|μ|m|k|M|G|)(m|g|N|s|Hz|Pa)(?:\^([1-4]))?")


def _simple(unit: str) -> tuple[Decimal, tuple[tuple[str, str], ...]] | None:
    """Parse a common unit or the quotient of two: factor and dimension; None for others."""
    if unit.count("/") > 1:
        return None
    exponent, powers = 0, [0, 0, 0]
    for sign, part in zip((1, -1), unit.split("/"), strict=False):
        if sign > 0 and part.strip() in ("", "1") and "/" in unit:
            continue
        match = _FACTOR.fullmatch(part.strip())
        if match is None:
            return None
        power = sign * int(match[3] or 1)
        exponent += power * (_PREFIX[match[1]] + _BASE.get(match[2], 0))
        powers = [old + power * new for old, new in zip(powers, _SIMPLE[match[2]], strict=True)]
    names = ("[length]", "[mass]", "[time]")
    dimension = tuple((n, str(float(p))) for n, p in zip(names, powers, strict=True) if p)
    return Decimal(1).scaleb(exponent), dimension


@lru_cache(maxsize=256)
def _parse(unit: str) -> tuple[Decimal, tuple[tuple[str, str], ...]] | None:
    text = f"1{unit}" if unit.startswith("/") else unit
    if not _UNIT.fullmatch(text):
        return None
    if (simple := _simple(unit)) is not None:
        return simple
    registry = _registry()
    text = re.sub(r"\bmils?\b", "thou", text)  # "mil" is an angle in pint
    try:
        unit_value = registry.Quantity(Decimal(1), registry.parse_units(text)).to_base_units()
        powers = {str(name): str(float(power)) for name, power in unit_value.dimensionality.items()}
        return Decimal(unit_value.magnitude), tuple(sorted(powers.items()))
    except Exception:  # pint raises many types, including errors of the tokenizer and NumPy
        return None


def _dimension_name(dimension: tuple[tuple[str, str], ...]) -> str:
    # Units that need pint come last.
    known = sorted(
        _NAMED_DIMENSIONS.items(), key=lambda pair: bool(pair[0] and not _simple(pair[0]))
    )
    for unit, name in known:
        parsed = _parse(unit) if unit else (Decimal(1), ())
        if parsed is not None and parsed[1] == dimension:
            return name
    powers = " ".join(f"{name[1:-1]}^{float(power):g}" for name, power in dimension)
    return f"of dimension {powers}"


def prefix(value: float) -> tuple[float, str]:
    """Return the factor of the SI prefix for writing a number, such as 1e-6, and the prefix."""
    if value == 0.0 or not math.isfinite(value):
        return 1.0, ""
    # Round first, so that 999.96 becomes "1.00 k" instead of "1000".
    exponent = math.floor(math.log10(float(f"{abs(value):.2e}")) + 1e-12)
    exponent = min(max(3 * (exponent // 3), min(_PREFIXES)), max(_PREFIXES))
    return float(f"1e{exponent}"), _PREFIXES[exponent]


def engineering(value: float | None, unit: str, digits: int = 3, *, trim: bool = False) -> str:
    """Format a number with an SI prefix, such as "1.10 kN"; "–" for None."""
    if value is None:
        return "–"
    factor, letter = prefix(value)
    if value and not 1e-3 <= abs(value) / factor < 1e4:  # beyond the prefixes
        return f"{value:.{digits - 1}e} {unit}"
    number = significant(value / factor, digits)
    if trim and "." in number and "e" not in number:
        number = number.rstrip("0").rstrip(".")
    return f"{number} {letter}{unit}".rstrip()


def interval_digits(low: float | None, high: float | None, value: float | None = None) -> int:
    """Return the number of significant digits for writing an estimate with its interval.

    The width of the interval is then resolved to one or two digits; at least three and at most
    eight digits are returned, and four if there is no interval or it is infinite. ``value`` is the
    estimate, by default the end of the interval that is larger in magnitude.
    """
    if low is None or high is None or not 0.0 < high - low < math.inf:
        return 4
    size = abs(value) if value is not None else max(abs(low), abs(high))
    if not 0.0 < size < math.inf:
        return 4
    return min(max(1 + math.ceil(math.log10(size / (high - low))), 3), 8)


def significant(value: float | None, digits: int = 3) -> str:
    """Format a number with significant digits, without exponent for usual magnitudes."""
    if value is None:
        return "–"
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    exponent = math.floor(math.log10(float(f"{abs(value):.{digits - 1}e}")) + 1e-12)
    if not -4 <= exponent < 6:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(digits - 1 - exponent, 0)}f}"
