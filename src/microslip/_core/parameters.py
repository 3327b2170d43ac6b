"""Declaration of numbers as metadata of dataclass fields, used by all interfaces of the package.

A field of a frozen dataclass declares its symbol, unit, range and meaning::

    stiffness: float = field(metadata=parameter("k", "N/m", "stiffness at rest", above=0.0))

From this declaration follow the check when an object is created, the initial values of fits, the
key in studies and its schema, the option of commands and its help, the input fields of the browser
workbench, the headings of tables, and the attributes in files. Inputs that are not parameters of a
class, such as how a file is read, are options (`microslip._core.options`).
"""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, NoReturn, Self

from microslip._core.by_value import ByValue
from microslip._core.errors import InputError
from microslip._core.units import LARGEST, SMALLEST, Kind, kind_of, to_si
from microslip._core.wording import quote

JsonSchema = dict[str, Any]


class REQUIRED:
    """Marker in place of a default: the value must be given."""


_KEY = "microslip"
# Units for written examples, of which the first suitable one is used, and default examples.
_WRITTEN: dict[str, tuple[tuple[float, str], ...]] = {
    "m": ((1e-3, "mm"), (1e-6, "um"), (1e-9, "nm")),
    "m^2": ((1e-4, "cm^2"), (1e-6, "mm^2")),
    "N": ((1.0, "N"),),
    "Pa": ((1e9, "GPa"), (1e6, "MPa")),
    "1/m^2": ((1e6, "1/mm^2"),),
    "N/m": ((1e6, "N/um"), (1.0, "N/m")),
    "1/m": ((1e6, "1/um"), (1.0, "1/m")),
    "rad": ((math.pi / 180.0, "deg"),),
}
_USUAL = {"m": 5e-7, "m^2": 2e-4, "N": 100.0, "Pa": 69e9, "1/m^2": 1e8, "N/m": 5e7, "1/m": 5e5}
_NUMBER_PATTERN = r"(\d[\d_]*(\.\d*)?|\.\d+)([eE][+-]?\d+)?"
UNIT_PATTERN = r"(1 ?/|/)?[^\s\d.,+-][^,]*"


@dataclass(frozen=True)
class Number:
    """Declaration of a number, or a list of numbers, in SI units."""

    name: str  # name in Python, studies and tables
    symbol: str = ""  # symbol in formulas and tables, such as "k"
    unit: str = ""  # SI unit, "" for none
    meaning: str = ""  # short description, beginning in lower case
    # Limits: more than ``above``, at least ``least``, at most ``most``, less than ``below``.
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    below: float = math.inf
    why: str = ""  # reason for the limits, for the message
    default: Any = REQUIRED
    """Default value; :data:`REQUIRED` if there is none."""
    many: bool = False  # True for a list of numbers
    example: float | str = 1.0
    """Example in SI units, or as text in a file or command line, without quotes: "10 um"."""
    kind: Kind | type | None = None
    """Kind of quantity, written with its unit in files and commands, or float or int."""

    def __post_init__(self) -> None:
        kind = self.kind or (kind_of(self.unit) if self.unit else float)
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "unit", kind.unit if isinstance(kind, Kind) else self.unit)

    def but(self, **changes: Any) -> Self:
        """Return a copy of the declaration with changed fields."""
        return dataclasses.replace(self, **changes)

    # -- in words ------------------------------------------------------------------------------

    @property
    def required(self) -> bool:
        """True if a value must be given."""
        return self.default is REQUIRED

    @property
    def heading(self) -> str:
        """Name that heads a column of a table or labels an axis, beginning with a capital."""
        words = self.meaning or self.name.replace("_", " ")
        return words[:1].upper() + words[1:]

    @property
    def sentence(self) -> str:
        """Description as a full sentence, for help and schema."""
        return f"{self.heading}."

    @property
    def example_text(self) -> str:
        """Example value with its unit, as in a file or on a command line, without quotes."""
        value = self.example
        if isinstance(value, str):
            return value
        value = _USUAL.get(self.unit, value) if value == 1.0 else value
        factor, name = self.written_unit(value)
        return f"{value / factor:.6g} {name}".strip()

    def written_unit(self, value: float) -> tuple[float, str]:
        """Return the unit in which ``value`` [SI] is usually written: (factor to SI, name)."""
        units = _WRITTEN.get(self.unit, ())
        fit = (unit for unit in units if abs(value) >= 0.099 * unit[0])
        return next(fit, (1.0, self.unit))

    @property
    def written(self) -> str:
        """Example as written in TOML, "" if there is none."""
        text = self.example_text
        return text if self.kind in (float, int, bool) or not text else f'"{text}"'

    @property
    def allowed(self) -> str:
        """Allowed values in words: "above zero [N/m]", "in [0, 1)"."""
        in_unit = f" [{self.unit}]" if self.unit else ""
        low, high = max(self.above, self.least), min(self.most, self.below)
        if self.kind is int and math.isfinite(low) and math.isfinite(high):
            return f"from {low} to {high}"
        if math.isfinite(low) and math.isfinite(high):
            opening = "(" if self.above >= self.least else "["
            right = ")" if self.below <= self.most else "]"
            return f"in {opening}{low:g}, {high:g}{right}{in_unit}"
        if math.isfinite(low):
            if self.above >= self.least:
                return f"above {'zero' if low == 0.0 else f'{low:g}'}{in_unit}"
            return f"at least {low:g}{in_unit}" if low else f"zero or more{in_unit}"
        if math.isfinite(high):
            word = "below" if self.below <= self.most else "at most"
            return f"{word} {high:g}{in_unit}"
        return f"a finite number{in_unit}"

    @property
    def values_in_words(self) -> str:
        """Expected values in words with an example, for error messages."""
        written = self._written_values
        return f"{self._noun} such as {written}" if written else self._noun

    @property
    def _written_values(self) -> str:
        return self.written

    @property
    def _noun(self) -> str:
        if isinstance(self.kind, Kind):
            return self.kind.with_article
        return self.limited("a whole number" if self.kind is int else "a number")

    def limited(self, noun: str) -> str:
        """Return a noun followed by the limits of the values, such as "a number above zero"."""
        limits = self.allowed
        if limits.startswith("a finite"):
            return noun
        why = f" ({self.why})" if self.why else ""
        return f"{noun} {'of ' * limits.startswith(('at', 'zero'))}{limits}{why}"

    # -- as a number ---------------------------------------------------------------------------

    @property
    def is_positive(self) -> bool:
        """True if the value must be above zero."""
        return max(self.above, self.least) >= 0.0 and self.least != 0.0

    def holds(self, value: float) -> bool:
        """Return True if a value is within the limits."""
        return self.above < value < self.below and self.least <= value <= self.most

    # -- arguments of Python functions ---------------------------------------------------------

    def checked(self, value: Any) -> Any:
        """Check a keyword argument and convert it to SI units; lists become read-only arrays."""
        if value is None and self.default is None:
            return None
        return self._checked_many(value) if self.many else self._checked_item(value)

    def _checked_many(self, value: Any) -> Any:
        from microslip._core.checks import exact, record
        from microslip._core.frozen import lock

        values = record(self.name, value, self.unit).reshape(-1).copy()
        for end in (int(values.argmin()), int(values.argmax())):
            if expected := self._allowed_instead(float(values[end])):
                worst = f"{exact(float(values[end]))} at index {end}"
                raise InputError(f"`{self.name}` must be {expected}, got {worst}")
        return lock(values)

    def _checked_item(self, value: Any) -> Any:
        if self.kind is float or isinstance(self.kind, Kind):
            from microslip._core.checks import exact, number  # the help of a command needs no NumPy

            if isinstance(example := self.example or 1.0, str):
                kind = self.kind
                example = to_si(example, kind, example, "any") if isinstance(kind, Kind) else 1.0
            result = number(self.name, value, self.unit, example)
            if expected := self._allowed_instead(result):
                raise InputError(f"`{self.name}` must be {expected}, got {exact(result)}")
            return result
        try:
            return self.read_item(value)
        except WrongValue as error:
            raise InputError(f"`{self.name}` must be {error.expected}, got {error.came}") from None

    def _allowed_instead(self, value: float) -> str:
        in_unit = f" [{self.unit}]" if self.unit else ""
        if not self.holds(value):
            return self.allowed + (f" ({self.why})" if self.why else "")
        if abs(value) > LARGEST or (self.is_positive and value < SMALLEST):
            if self.is_positive:
                return f"between {SMALLEST:g} and {LARGEST:g}{in_unit}"
            end = "at most " if value > 0.0 else "at least -"
            return f"{end}{LARGEST:g}{in_unit}"
        return ""

    # -- values in files and commands ----------------------------------------------------------

    def read(self, raw_value: object) -> Any:
        """Convert a value in a study or a command to SI units.

        Raises
        ------
        ValueError
            If the value is not allowed; the message states the accepted and the received value.
        """
        return self.read_item(raw_value)

    def read_item(self, raw_value: object) -> Any:
        """Convert one value of a file or command to SI units; WrongValue if not allowed."""
        if isinstance(self.kind, Kind):
            return self._read_quantity(raw_value, self.kind, self.example_text)
        accepted = (int, float) if self.kind is float else (int,)
        if isinstance(raw_value, accepted) and not isinstance(raw_value, bool):
            try:
                value = float(raw_value)
            except OverflowError:
                value = math.inf
            if math.isfinite(value) and self.holds(value):
                return value if self.kind is float else raw_value
        self._refuse(raw_value)

    def _read_quantity(self, raw_value: object, kind: Kind, example: str) -> float:
        value = to_si(raw_value, kind, example, "positive" if self.is_positive else "any")
        if not self.holds(value):
            raise WrongValue(self.limited(kind.with_article), quote(raw_value))
        return value

    def _refuse(self, raw_value: object, hint: str = "") -> NoReturn:
        raise WrongValue(self.values_in_words, f"{quote(raw_value)}{hint}")

    def schema(self) -> JsonSchema:
        """Return the JSON Schema of the value in a study, without title and description."""
        if isinstance(self.kind, Kind):
            signs = r"\+?" if self.is_positive else "[+\N{MINUS SIGN}-]?"
            unit = self.kind.pattern or UNIT_PATTERN
            noun = f'{self.kind.with_article} with its unit, such as "{self.example_text}".'
            return {
                "type": "string",
                "pattern": rf"^\s*{signs}{_NUMBER_PATTERN}\s*{unit}$",
                "description": f"{noun[:1].upper()}{noun[1:]}",
                "examples": [self.example_text],
            }
        limits = {"minimum": self.least, "maximum": self.most}
        limits |= {"exclusiveMinimum": self.above, "exclusiveMaximum": self.below}
        finite = {key: limit for key, limit in limits.items() if math.isfinite(limit)}
        return {"type": "integer" if self.kind is int else "number", **finite}


class WrongValue(ValueError):
    """Invalid value in a file or command; the message has the expected and the received value."""

    def __init__(self, expected: str, came: str) -> None:
        super().__init__(f"wanted {expected}, got {came}")
        self.expected, self.came = expected, came


# -- on classes ------------------------------------------------------------------------------------


def parameter(
    symbol: str = "", unit: str = "", meaning: str = "", **settings: Any
) -> dict[str, Any]:
    """Return the metadata of a field, ``field(metadata=parameter(...))``; see :class:`Number`."""
    # Created here, so that a mistake raises an error where the class is defined.
    return {_KEY: Number("", symbol, unit, meaning, **settings)}


def parameters_of(kind: type) -> tuple[Number, ...]:
    """Return the declarations of the parameters of a class, in the order of its arguments."""
    return _parameters_of(kind)


@lru_cache(maxsize=256)
def _parameters_of(kind: Any) -> tuple[Number, ...]:
    if not dataclasses.is_dataclass(kind):
        return ()
    parameters = []
    for item in dataclasses.fields(kind):
        stated = item.metadata.get(_KEY)
        if isinstance(stated, Number) and item.init:
            default: Any = item.default
            if default is dataclasses.MISSING:
                default = REQUIRED if item.default_factory is dataclasses.MISSING else None
            parameters.append(dataclasses.replace(stated, name=item.name, default=default))
    return tuple(parameters)


def parameter_of(kind: type, name: str) -> Number:
    """Return the declaration of one parameter of a class by name."""
    return next(item for item in parameters_of(kind) if item.name == name)


def is_fully_declared(kind: type) -> bool:
    """Return True if every argument of a class has a declaration."""
    if not dataclasses.is_dataclass(kind):
        return False
    names = {item.name for item in dataclasses.fields(kind) if item.init}
    return bool(names) and names == {item.name for item in parameters_of(kind)}


class Parametric(ByValue):
    """Frozen dataclass whose parameters are checked at creation against their declarations."""

    key: ClassVar[str] = ""
    """Name in studies and commands, by default the class name in lower case."""

    def __post_init__(self) -> None:
        self._check_parameters()

    def _check_parameters(self) -> None:
        for item in parameters_of(type(self)):
            object.__setattr__(self, item.name, item.checked(getattr(self, item.name)))


def key_of(kind: type) -> str:
    """Return the name of a class in studies and commands: "smooth-step" for ``SmoothStep``."""
    stated: str = vars(kind).get("key", "")
    return stated or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", kind.__name__).lower()
