"""Options said once: what a command, a study, its schema, a report and Python say of each of them.

An :class:`Option` is plain data. `cli.options` makes the option of a command from it,
`study.part.key` the key of a study with its reading, schema and example, a report takes its
`label`, and a function in Python calls `check` on its keyword.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, NoReturn

from microslip._core.units import Kind, Sign, to_si
from microslip._core.wording import did_you_mean, quoted, show
from microslip.errors import InputError

JsonSchema = dict[str, Any]

REQUIRED: Any = type("Required", (), {"__repr__": lambda self: "REQUIRED"})()
"""Default of an option that has to be given."""

NUMBER_PATTERN = r"(\d[\d_]*(\.\d*)?|\.\d+)([eE][+-]?\d+)?"
UNIT_PATTERN = r"(1 ?/|/)?[^\s\d.,+-][^,]*"

_JSON_TYPES = {str: "string", float: "number", int: "integer", bool: "boolean"}


@dataclass(frozen=True)
class Option:
    """One option, wherever it is given."""

    name: str  # keyword in Python and key in a study
    help: str  # what it is, in a sentence with its point
    kind: Kind | type = str
    """A kind of quantity, which edges write with its unit; else float, int, bool or str."""
    label: str = ""  # what stands for it in tables of a report; by default its name in words
    default: Any = None
    """Value where it is not given, in SI units; :data:`REQUIRED` where it has to be."""
    example: str = ""  # a value as a file or a command line has it, without quotes, such as "10 um"
    choices: tuple[str, ...] = ()  # the words that it may be
    low: float | None = None  # smallest value, itself allowed, as the largest is
    high: float | None = None
    above: float | None = None  # below all values, itself not allowed, as below is
    below: float | None = None
    sign: Sign = "positive"  # sign of a quantity
    none: str = ""  # word that stands for None at the edges, such as "none"
    bare: bool = False  # whether a plain number counts as SI at the edges
    most: int = 1  # how many values it may have; those of more than one are tuples
    least: int = 1  # how many values it must have, where it may have several
    flag: str = ""  # name on the command line without dashes, where it is another one
    metavar: str = ""  # what stands for the value in the help of a command
    answers_for: tuple[str, ...] = field(default=())
    """Other arguments in Python for which a command has this option, so that messages find it."""

    @property
    def required(self) -> bool:
        """Whether it has to be given."""
        return self.default is REQUIRED

    @property
    def unit(self) -> str:
        """SI unit of its values; "" for none."""
        return self.kind.unit if isinstance(self.kind, Kind) else ""

    @property
    def heading(self) -> str:
        """What stands for it in tables."""
        return self.label or self.name.replace("_", " ").capitalize()

    @property
    def written(self) -> str:
        """Its example as TOML."""
        if self.kind in (float, int, bool):
            return self.example
        return f'"{self.example}"' if self.example else ""

    def but(self, **changes: Any) -> Option:
        """The same option with other words or limits, where a place has its own."""
        return replace(self, **changes)

    # -- as it is written at an edge -----------------------------------------------------------

    def read(self, raw_value: object) -> Any:
        """A value as a study or a command writes it.

        Returns the value in SI units, a tuple of them where there may be several. Raises
        ValueError, which says what was wanted and what came.
        """
        if self.none and raw_value == self.none:
            return None
        if self.most == 1:
            return self._read_item(raw_value)
        items = raw_value if isinstance(raw_value, (list, tuple)) else [raw_value]
        if not self.least <= len(items) <= self.most:
            count = f"{self.least}" if self.least == self.most else f"{self.least} to {self.most}"
            raise ValueError(f"wanted {count} values, got {len(items)}")
        return tuple(self._read_item(item) for item in items)

    def read_text(self, text: str) -> Any:
        """One value on a command line, where numbers are text as well."""
        if self.none and text == self.none:
            return None
        if self.kind not in (float, int):
            return self._read_item(text)
        for reader in (int, float)[: 1 + (self.kind is float)]:
            try:
                number = reader(text)
            except ValueError:
                continue
            return self._read_item(number)
        self._refuse(text)

    @property
    def allowed_values(self) -> str:
        """What its values are, in words with an example."""
        if self.choices:
            return quoted((*self.choices, *(self.none,) * bool(self.none)))
        if isinstance(self.kind, Kind):
            noun = self.kind.with_article
        elif self.kind in (float, int):
            noun = f"a {'whole ' * (self.kind is int)}number{self._limits()}"
        else:
            return "true or false" if self.kind is bool else f"text{self._such_as()}"
        return noun + self._such_as()

    def _such_as(self) -> str:
        written = self.written
        if self.none:
            written = f'{written}, or "{self.none}"' if written else f'"{self.none}"'
        return f" such as {written}" if written else ""

    def _limits(self) -> str:
        low, high = self.low, self.high
        limits = []
        if low is not None and high is not None:
            limits.append(f"from {low:g} to {high:g}")
        elif low is not None:
            limits.append(f"of at least {low:g}")
        elif high is not None:
            limits.append(f"of at most {high:g}" if self.above is None else f"at most {high:g}")
        if self.above is not None:
            limits.insert(0, f"above {self.above:g}")
        if self.below is not None:
            limits.append(f"below {self.below:g}")
        return f" {' and '.join(limits)}" if limits else ""

    def _read_item(self, raw_value: object) -> Any:
        if isinstance(self.kind, Kind):
            if self.bare and _is_number(raw_value):
                raw_value = f"{raw_value} {self.unit}".strip()
            example = f'{self.example}", or "{self.none}' if self.none else self.example
            return to_si(raw_value, self.kind, example, self.sign)
        if self.choices:
            if raw_value not in self.choices:
                near = did_you_mean(raw_value, self.choices) if isinstance(raw_value, str) else ""
                self._refuse(raw_value, near)
            return raw_value
        if (
            self.kind is float
            and isinstance(raw_value, (int, float))
            and not isinstance(raw_value, bool)
        ):
            try:
                value = float(raw_value)
            except OverflowError:
                value = math.inf
            if math.isfinite(value) and self._inside(value):
                return value
        elif self.kind is int:
            if (
                isinstance(raw_value, int)
                and not isinstance(raw_value, bool)
                and self._inside(raw_value)
            ):
                return raw_value
        elif self.kind is bool and isinstance(raw_value, bool):
            return raw_value
        elif isinstance(raw_value, str) and raw_value.isprintable() and 0 < len(raw_value) <= 1000:
            return raw_value
        self._refuse(raw_value)

    def _refuse(self, raw_value: object, hint: str = "") -> NoReturn:
        raise ValueError(f"wanted {self.allowed_values}, got {show(raw_value)}{hint}")

    def _inside(self, value: float) -> bool:
        return (
            (self.low is None or value >= self.low)
            and (self.high is None or value <= self.high)
            and (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
        )

    # -- as Python gives it --------------------------------------------------------------------

    def check(self, value: Any) -> Any:
        """A keyword's value in SI units, or an InputError that begins with the keyword."""
        if value is None and not self.required and (self.none or self.default is None):
            return None
        if self.most > 1 and isinstance(value, (list, tuple)):
            if not self.least <= len(value) <= self.most:
                count = f"{self.least} to {self.most}" if self.least < self.most else self.most
                raise InputError(f"`{self.name}` must be {count} values, got {len(value)}")
            return tuple(self._check_item(item) for item in value)
        return self._check_item(value)

    def _check_item(self, value: Any) -> Any:
        from microslip._core import checks  # here, since the help of a command needs no NumPy

        if isinstance(self.kind, Kind):
            checked = checks.positive if self.sign == "positive" else checks.number
            return checked(self.name, value, self.unit)
        if self.kind is float:
            result = checks.number(self.name, value)
            if self._inside(result):
                return result
            value = checks.exact(result)
            raise InputError(f"`{self.name}` must be {self.allowed_values}, got {value}")
        try:
            return self._read_item(value)
        except ValueError as error:
            expected, _, came = str(error).removeprefix("wanted ").rpartition(", got ")
            raise InputError(f"`{self.name}` must be {expected}, got {came}") from None

    # -- as an editor knows it -----------------------------------------------------------------

    def schema(self) -> JsonSchema:
        """JSON Schema of its value in a study, without title and description of the key."""
        item = self._item_schema()
        if self.most > 1:
            several: JsonSchema = {"type": "array", "items": item}
            several |= {"minItems": self.least, "maxItems": self.most}
            item = several if self.least > 1 else {"anyOf": [item, several]}
        if self.none:
            examples = [self.example, self.none] if self.example else [self.none]
            return {"anyOf": [item, {"const": self.none}], "examples": examples}
        return item

    def _item_schema(self) -> JsonSchema:
        if isinstance(self.kind, Kind):
            quantity = quantity_schema(self.kind, self.example, self.sign)
            return {"anyOf": [{"type": "number"}, quantity]} if self.bare else quantity
        if self.choices:
            return {"type": "string", "enum": list(self.choices)}
        limits = {"minimum": self.low, "maximum": self.high}
        limits |= {"exclusiveMinimum": self.above, "exclusiveMaximum": self.below}
        schema: JsonSchema = {"type": _JSON_TYPES[self.kind]}
        if self.kind is str:
            return {**schema, "minLength": 1, "maxLength": 1000}
        return {**schema, **{key: limit for key, limit in limits.items() if limit is not None}}


def quantity_schema(kind: Kind, example: str, sign: Sign, unit: str = UNIT_PATTERN) -> JsonSchema:
    """JSON Schema of text with a unit."""
    signs = r"\+?" if sign == "positive" else "[+\N{MINUS SIGN}-]?"
    return {
        "type": "string",
        "pattern": rf"^\s*{signs}{NUMBER_PATTERN}\s*{unit}$",
        "description": f'{kind.with_article.capitalize()} with its unit, such as "{example}".',
        "examples": [example],
    }


def _is_number(raw_value: object) -> bool:
    if isinstance(raw_value, bool) or not isinstance(raw_value, (str, int, float)):
        return False
    try:
        float(raw_value)
    except ValueError:
        return False
    return True
