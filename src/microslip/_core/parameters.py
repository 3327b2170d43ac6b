"""Declaration of a number, a choice or a text, from which every interface of the package reads.

A field of a frozen dataclass brings its symbol, unit, range and meaning as metadata::

    stiffness: float = field(metadata=parameter("k", "N/m", "stiffness at rest", above=0.0))

Checks when it is made, `guess`, the fit, the key of a study, its schema, the option of a command
with its help, the form of the workbench, the label in tables and the attributes in files follow.
What belongs to no class, such as how a file is read, is declared by :func:`option`.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, NoReturn

from microslip._core.units import LARGEST, SMALLEST, Kind, Sign, kind_of, to_si
from microslip._core.wording import did_you_mean, quoted, show
from microslip.errors import InputError

JsonSchema = dict[str, Any]


class _Required:
    """One thing, the same after pickling."""

    def __reduce__(self) -> str:
        return "REQUIRED"

    def __repr__(self) -> str:
        return "REQUIRED"


REQUIRED: Any = _Required()
"""Default of what has to be given."""

_KEY = "microslip"
# Where a fit looks for a value above zero of a unit, unless the parameter says where.
_SEARCHED = {"N": (1e-12, 1e12), "N/m": (1e-6, 1e15), "m": (1e-13, 1e-1)}
# Units in which people write an example, the first one in which it is no small fraction, and what
# an example is where none is declared.
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
_TYPES = {str: "string", float: "number", int: "integer", bool: "boolean"}
_NUMBER_PATTERN = r"(\d[\d_]*(\.\d*)?|\.\d+)([eE][+-]?\d+)?"
UNIT_PATTERN = r"(1 ?/|/)?[^\s\d.,+-][^,]*"


@dataclass(frozen=True)
class Parameter:
    """One declaration; sizes are in SI units."""

    name: str  # as Python, a study and a table call it
    symbol: str = ""  # its sign in formulas and tables, such as "k"
    unit: str = ""  # its SI unit, "" for none
    meaning: str = ""  # what it is, in a few words that begin small
    # What it may be: more than ``above``, at least ``least``, at most ``most``, less than
    # ``below``.
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    below: float = math.inf
    search: tuple[float, float] | None = None
    """Between which values a fit looks; without it all that is allowed."""
    log: bool | None = None
    """Whether it is fitted as its logarithm; without it, whether zero lies below all it may be."""
    beyond: bool = False
    """Whether joints go on beyond ``search``, which only says how far is searched."""
    natural: bool = False
    """Whether its lower end is a value that joints have, so that a fit may well end there."""
    why: str = ""  # why it must be above ``above``, for the message
    default: Any = REQUIRED
    """Its value where none is given; :data:`REQUIRED` where one has to be."""
    many: bool = False  # whether it is a list of such numbers
    example: float | str = 1.0
    """A value in SI, or as a file or a command line has it, without quotes: "10 um"."""
    kind: Kind | type | None = None
    """A kind of quantity, which edges write with its unit; else float, int, bool or str."""
    label: str = ""  # what stands for it in tables and axes; by default its meaning
    help: str = ""  # what it is, in a sentence with its point; by default its meaning
    choices: tuple[str, ...] = ()  # the words that it may be
    none: str = ""  # word that stands for None at the edges, such as "none"
    bare: bool = False  # whether a plain number counts as SI at the edges
    items: tuple[int, int] = (1, 1)
    """Least and largest number of values; several are given as a tuple."""
    flag: str = ""  # name on the command line without dashes, where it is another one
    metavar: str = ""  # what stands for the value in the help of a command
    names_file: bool = False  # whether its text is the name of a file
    noun: str = ""  # what its values are called where they are wanted, "the name of a column"

    def __post_init__(self) -> None:
        kind: Kind | type | None = self.kind
        if kind is None:
            kind = kind_of(self.unit) if self.unit else str if self.choices else float
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "unit", kind.unit if isinstance(kind, Kind) else self.unit)

    def but(self, **changes: Any) -> Parameter:
        """The same with other words or limits, where a place has its own."""
        return dataclasses.replace(self, **changes)

    # -- in words ------------------------------------------------------------------------------

    @property
    def required(self) -> bool:
        """Whether it has to be given."""
        return self.default is REQUIRED

    @property
    def heading(self) -> str:
        """Heading in tables and axes."""
        words = self.label or self.meaning or self.name.replace("_", " ")
        return words[:1].upper() + words[1:]

    @property
    def sentence(self) -> str:
        """Meaning in a sentence, for a help or a schema."""
        return self.help or f"{self.heading}."

    @property
    def example_text(self) -> str:
        """Its example as a file or a command line has it, without quotes."""
        value = self.example
        if isinstance(value, str):
            return value
        if self.kind not in (float, int) and not isinstance(self.kind, Kind):
            return ""
        value = _USUAL.get(self.unit, value) if value == 1.0 else value
        factor, name = self.written_unit(value)
        return f"{value / factor:.6g} {name}".strip()

    def written_unit(self, value: float) -> tuple[float, str]:
        """The unit in which people write a value of this size: its size in SI, and its name."""
        units = _WRITTEN.get(self.unit, ())
        fit = (unit for unit in units if abs(value) >= 0.099 * unit[0])
        return next(fit, (1.0, self.unit))

    @property
    def written(self) -> str:
        """Its example as TOML; "" where there is none."""
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
        """Expected values in words with an example, for an error message."""
        if self.choices:
            return quoted((*self.choices, *(self.none,) * bool(self.none)))
        if self.kind is bool:
            return "true or false"
        written = self.written
        if self.none:
            written = f'{written}, or "{self.none}"' if written else f'"{self.none}"'
        if isinstance(self.kind, Kind):
            noun = self.kind.with_article
        elif self.noun or self.kind is str:
            noun = self.noun or "text"
        else:
            noun = self.limited("a whole number" if self.kind is int else "a number")
        return f"{noun} such as {written}" if written else noun

    def limited(self, noun: str) -> str:
        """A noun with what it may be."""
        limits = self.allowed
        if limits.startswith("a finite"):
            return noun
        why = f" ({self.why})" if self.why else ""
        return f"{noun} {'of ' * limits.startswith(('at', 'zero'))}{limits}{why}"

    # -- as a number ---------------------------------------------------------------------------

    @property
    def is_positive(self) -> bool:
        """Whether it must be above zero."""
        return max(self.above, self.least) >= 0.0 and self.least != 0.0

    @property
    def is_log(self) -> bool:
        """Whether it is fitted as its logarithm."""
        return self.is_positive and self.unit != "" if self.log is None else self.log

    @property
    def low(self) -> float:
        """Lower end of the search."""
        return self._searched[0]

    @property
    def high(self) -> float:
        """Upper end of the search."""
        return self._searched[1]

    @property
    def _searched(self) -> tuple[float, float]:
        if self.search is not None:
            return self.search
        if self.is_positive and self.unit in _SEARCHED:
            low, high = _SEARCHED[self.unit]
        elif self.is_positive:
            low, high = 1e-6, 1e6 if self.unit == "" else 1e30
        else:
            low, high = -1e6, 1e6
        # Just inside a range that is open.
        step = 1e-6 * max(1.0, abs(self.above)) if math.isfinite(self.above) else 0.0
        low = max(low, self.least, self.above + step if not self.is_positive else low)
        last = 1e-6 * max(1.0, abs(self.below)) if math.isfinite(self.below) else 0.0
        return low, min(high, self.most, self.below - last)

    @property
    def dimension(self) -> tuple[int, int] | None:
        """Powers of newton and metre in its unit; None where there is something else in it."""
        above, _, under = self.unit.partition("/")
        powers = {"N": 0, "m": 0}
        for part, sign in ((above, 1), (under, -1)):
            for word in part.replace("*", " ").split():
                base, _, power = word.partition("^")
                if base in ("1", "rad"):
                    continue
                if base not in powers or not re.fullmatch(r"-?\d*", power):
                    return None
                powers[base] += sign * int(power or 1)
        return powers["N"], powers["m"]

    def holds(self, value: float) -> bool:
        """Whether a value is in its range."""
        return self.above < value < self.below and self.least <= value <= self.most

    # -- as Python gives it --------------------------------------------------------------------

    def checked(self, value: Any) -> Any:
        """A keyword's value in SI units, of many a locked array; or an error that names it."""
        if value is None and not self.required and (self.none or self.default is None):
            return None
        low, high = self.items
        if high > 1 and isinstance(value, (list, tuple)):
            if not low <= len(value) <= high:
                count = f"{low} to {high}" if low < high else high
                raise InputError(f"`{self.name}` must be {count} values, got {len(value)}")
            return tuple(self._checked_item(item) for item in value)
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
        """Allowed values in words, for a value outside them; empty for one inside."""
        in_unit = f" [{self.unit}]" if self.unit else ""
        if not self.holds(value):
            return self.allowed + (f" ({self.why})" if self.why else "")
        if abs(value) > LARGEST or (self.is_positive and value < SMALLEST):
            if self.is_positive:
                return f"between {SMALLEST:g} and {LARGEST:g}{in_unit}"
            end = "at most " if value > 0.0 else "at least -"
            return f"{end}{LARGEST:g}{in_unit}"
        return ""

    # -- as it is written at an edge -----------------------------------------------------------

    def read(self, raw_value: object) -> Any:
        """A value as a study or a command writes it.

        Returns the value in SI units, a tuple of them where there may be several. Raises
        ValueError, which says what was wanted and what came.
        """
        if self.none and raw_value == self.none:
            return None
        low, high = self.items
        if high == 1:
            return self.read_item(raw_value)
        items = raw_value if isinstance(raw_value, (list, tuple)) else [raw_value]
        if not low <= len(items) <= high:
            count = f"{low}" if low == high else f"{low} to {high}"
            raise ValueError(f"wanted {count} values, got {len(items)}")
        return tuple(self.read_item(item) for item in items)

    def read_text(self, text: str) -> Any:
        """One value on a command line, where numbers are text as well."""
        if self.none and text == self.none:
            return None
        if self.kind not in (float, int):
            return self.read_item(text)
        for reader in (int, float)[: 1 + (self.kind is float)]:
            try:
                number = reader(text)
            except ValueError:
                continue
            return self.read_item(number)
        self._refuse(text)

    def read_item(self, raw_value: object) -> Any:
        """One of its values."""
        if isinstance(self.kind, Kind):
            if self.bare and is_number(raw_value):
                raw_value = f"{raw_value} {self.unit}".strip()
            example = f'{self.example_text}", or "{self.none}' if self.none else self.example_text
            sign: Sign = "positive" if self.is_positive else "any"
            value = to_si(raw_value, self.kind, example, sign)
            if not self.holds(value):
                raise WrongValue(self.limited(self.kind.with_article), show(raw_value))
            return value
        if self.choices:
            if raw_value not in self.choices:
                near = did_you_mean(raw_value, self.choices) if isinstance(raw_value, str) else ""
                self._refuse(raw_value, near)
            return raw_value
        if isinstance(raw_value, bool):
            if self.kind is bool:
                return raw_value
        elif self.kind in (float, int) and isinstance(raw_value, (int, self.kind)):
            try:
                value = float(raw_value)
            except OverflowError:
                value = math.inf
            if math.isfinite(value) and self.holds(value):
                return value if self.kind is float else raw_value
        elif (
            self.kind is str
            and isinstance(raw_value, str)
            and raw_value.isprintable()
            and 0 < len(raw_value) <= self._longest
        ):
            return raw_value
        self._refuse(raw_value)

    @property
    def _longest(self) -> int:
        """Letters that a text may have."""
        return int(min(self.most, 1000))

    def _refuse(self, raw_value: object, hint: str = "") -> NoReturn:
        raise WrongValue(self.values_in_words, f"{show(raw_value)}{hint}")

    # -- as an editor knows it -----------------------------------------------------------------

    def schema(self) -> JsonSchema:
        """JSON Schema of its value in a study, without title and description of the key."""
        item = self.item_schema()
        low, high = self.items
        if high > 1:
            several: JsonSchema = {"type": "array", "items": item}
            several |= {"minItems": low, "maxItems": high}
            item = several if low > 1 else {"anyOf": [item, several]}
        if self.none:
            examples = [self.example_text, self.none] if self.example_text else [self.none]
            return {"anyOf": [item, {"const": self.none}], "examples": examples}
        return item

    def item_schema(self) -> JsonSchema:
        """JSON Schema of one value."""
        if isinstance(self.kind, Kind):
            signs = r"\+?" if self.is_positive else "[+\N{MINUS SIGN}-]?"
            unit = self.kind.pattern or UNIT_PATTERN
            noun = f'{self.kind.with_article} with its unit, such as "{self.example_text}".'
            quantity: JsonSchema = {
                "type": "string",
                "pattern": rf"^\s*{signs}{_NUMBER_PATTERN}\s*{unit}$",
                "description": f"{noun[:1].upper()}{noun[1:]}",
                "examples": [self.example_text],
            }
            return {"anyOf": [{"type": "number"}, quantity]} if self.bare else quantity
        if self.choices:
            return {"type": "string", "enum": list(self.choices)}
        assert self.kind is not None
        if self.kind is str:
            return {"type": "string", "minLength": 1, "maxLength": self._longest}
        limits = {"minimum": self.least, "maximum": self.most}
        limits |= {"exclusiveMinimum": self.above, "exclusiveMaximum": self.below}
        finite = {key: limit for key, limit in limits.items() if math.isfinite(limit)}
        return {"type": _TYPES[self.kind], **finite}


class WrongValue(ValueError):
    """A value that an edge cannot use: what was wanted, and what came."""

    def __init__(self, expected: str, came: str) -> None:
        super().__init__(f"wanted {expected}, got {came}")
        self.expected, self.came = expected, came


def is_number(raw_value: object) -> bool:
    """Whether something is a plain number, or a text of one."""
    if isinstance(raw_value, bool) or not isinstance(raw_value, (str, int, float)):
        return False
    try:
        float(raw_value)
    except ValueError:
        return False
    return True


def option(
    name: str, help: str, kind: Kind | type = str, label: str = "", **settings: Any
) -> Parameter:
    """Declare an option of commands and studies that no class owns, by its help and kind.

    Unless something else is said it may be left out, and quantities are above zero.
    """
    settings = {"default": None, "example": "", **settings}
    if isinstance(kind, Kind) and settings.pop("sign", "positive") == "positive":
        settings.setdefault("above", 0.0)
    return Parameter(name, help=help, kind=kind, label=label, **settings)


# -- on classes ------------------------------------------------------------------------------------


def parameter(
    symbol: str = "", unit: str = "", meaning: str = "", **settings: Any
) -> dict[str, Any]:
    """Metadata of a field, ``field(metadata=parameter(...))``; see :class:`Parameter`."""
    # Checked at once, so that a mistake shows where the class is written.
    return {_KEY: Parameter("", symbol, unit, meaning, **settings)}


def parameters_of(kind: type) -> tuple[Parameter, ...]:
    """The parameters of a class, in the order in which it takes them; none if it says none."""
    return _parameters_of(kind)


@lru_cache(maxsize=256)
def _parameters_of(kind: Any) -> tuple[Parameter, ...]:
    if not dataclasses.is_dataclass(kind):
        return ()
    parameters = []
    for item in dataclasses.fields(kind):
        stated = item.metadata.get(_KEY, _COMMON.get(item.name))
        if isinstance(stated, Parameter) and item.init:
            default = item.default
            if default is dataclasses.MISSING:
                default = REQUIRED if item.default_factory is dataclasses.MISSING else None
            parameters.append(dataclasses.replace(stated, name=item.name, default=default))
    return tuple(parameters)


# Fields of these names need no words of their own.
_COMMON = {
    "stiffness": Parameter("stiffness", "k", "N/m", "stiffness at rest", above=0.0),
    "force_limit": Parameter("force_limit", "F", "N", "force of gross slip", above=0.0),
}


def parameter_of(kind: type, name: str) -> Parameter:
    """One parameter of a class."""
    return next(item for item in parameters_of(kind) if item.name == name)


def says_all(kind: type) -> bool:
    """Whether the parameters of a class are all that it takes."""
    if not dataclasses.is_dataclass(kind):
        return False
    names = {item.name for item in dataclasses.fields(kind) if item.init}
    return bool(names) and names == {item.name for item in parameters_of(kind)}


class Parametric:
    """A frozen dataclass whose numbers are checked when it is made, by what their fields say."""

    key: ClassVar[str] = ""
    """Its name in studies and commands; without it that of the class in small letters."""

    def __post_init__(self) -> None:
        self._check_parameters()

    def _check_parameters(self) -> None:
        for item in parameters_of(type(self)):
            object.__setattr__(self, item.name, item.checked(getattr(self, item.name)))


def key_of(kind: type) -> str:
    """Name of a class in studies and commands: "smooth-step" for ``SmoothStep``."""
    stated: str = vars(kind).get("key", "")
    return stated or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", kind.__name__).lower()


def values_of(item: Any) -> dict[str, Any]:
    """Values of all parameters of an instance, by their names."""
    return {entry.name: getattr(item, entry.name) for entry in parameters_of(type(item))}


def rescaled(kind: type, values: Mapping[str, Any], force: float, length: float) -> dict[str, Any]:
    """Values of a class in units of force [N] and length [m] that are so many times as large."""
    import numpy as np

    result = {}
    for item in parameters_of(kind):
        dimension = item.dimension
        if dimension is None:
            raise InputError(
                f"{kind.__name__}.{item.name} must have a unit of newtons and metres to be "
                f"scaled, got {item.unit!r}"
            )
        factor = force ** dimension[0] * length ** dimension[1]
        value = np.asarray(values[item.name]) if item.many else values[item.name]
        result[item.name] = value * factor
    return result
