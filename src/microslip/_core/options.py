"""Declaration of those inputs of commands and studies that are not parameters of a class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from microslip._core.errors import InputError
from microslip._core.parameters import JsonSchema, Number
from microslip._core.units import Kind
from microslip._core.wording import did_you_mean, quoted


@dataclass(frozen=True)
class Option(Number):
    """Declaration of an input of a command or study: numbers, text, a choice or a switch."""

    kind: Kind | type | None = str
    """Kind of quantity, written with its unit in files and commands, or float, int, bool or str."""
    example: float | str = ""
    label: str = ""  # heading in tables and axes; by default the meaning
    help: str = ""  # description as a full sentence; by default the meaning
    noun: str = ""  # name of the values in messages, such as "the name of a column"
    choices: tuple[str, ...] = ()  # accepted words
    none: str = ""  # word for None in files and commands, such as "none"
    bare: bool = False  # accept a number without a unit as SI
    items: tuple[int, int] = (1, 1)
    """Smallest and largest number of values; several values are a tuple."""
    flag: str = ""  # name on the command line without dashes, if different
    metavar: str = ""  # placeholder of the value in the help of a command

    @property
    def heading(self) -> str:
        """Name that heads a column of a table or labels an axis, beginning with a capital."""
        return self.label[:1].upper() + self.label[1:] if self.label else super().heading

    @property
    def sentence(self) -> str:
        """Description as a full sentence, for help and schema."""
        return self.help or super().sentence

    @property
    def values_in_words(self) -> str:
        """Expected values in words with an example, for error messages."""
        if self.choices:
            return quoted((*self.choices, self.none) if self.none else self.choices)
        return "true or false" if self.kind is bool else super().values_in_words

    @property
    def _written_values(self) -> str:
        if self.none:
            return f'{self.written}, or "{self.none}"' if self.written else f'"{self.none}"'
        return self.written

    @property
    def _noun(self) -> str:
        if isinstance(self.kind, Kind) or not (self.noun or self.kind is str):
            return super()._noun
        return self.noun or "text"

    @property
    def _longest(self) -> int:
        return int(min(self.most, 1000))

    def checked(self, value: Any) -> Any:
        """Check a keyword argument and convert it to SI units; several values become a tuple."""
        if value is None and self.none and not self.required:
            return None
        low, high = self.items
        if high > 1 and isinstance(value, (list, tuple)):
            if not low <= len(value) <= high:
                count = f"{low} to {high}" if low < high else high
                raise InputError(f"`{self.name}` must be {count} values, got {len(value)}")
            return tuple(self._checked_item(item) for item in value)
        return super().checked(value)

    def read(self, raw_value: object) -> Any:
        """Convert the value in a study or a command to SI units; several values become a tuple.

        Raises
        ------
        ValueError
            If the value is not allowed; the message states the accepted and the received value.
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
        """Convert one value of a command line, where numbers are given as text, to SI units."""
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

    def read_item(self, raw_value: Any) -> Any:
        """Convert one of possibly several values to SI units."""
        if isinstance(self.kind, Kind):
            if self.bare and is_number(raw_value):
                raw_value = f"{raw_value} {self.unit}".strip()
            example = f'{self.example_text}", or "{self.none}' if self.none else self.example_text
            return self._read_quantity(raw_value, self.kind, example)
        if self.choices:
            if raw_value not in self.choices:
                near = did_you_mean(raw_value, self.choices) if isinstance(raw_value, str) else ""
                self._refuse(raw_value, near)
            return raw_value
        if self.kind is bool and isinstance(raw_value, bool):
            return raw_value
        if self.kind in (float, int):
            return super().read_item(raw_value)
        is_text = self.kind is str and isinstance(raw_value, str) and raw_value.isprintable()
        if is_text and 0 < len(raw_value) <= self._longest:
            return raw_value
        self._refuse(raw_value)

    def schema(self) -> JsonSchema:
        """Return the JSON Schema of the value in a study, without title and description."""
        if self.choices:
            item: JsonSchema = {"type": "string", "enum": list(self.choices)}
        elif self.kind is str:
            item = {"type": "string", "minLength": 1, "maxLength": self._longest}
        elif self.kind is bool:
            item = {"type": "boolean"}
        else:
            item = super().schema()
        if self.bare:
            item = {"anyOf": [{"type": "number"}, item]}
        low, high = self.items
        if high > 1:
            several = {"type": "array", "items": item, "minItems": low, "maxItems": high}
            item = several if low > 1 else {"anyOf": [item, several]}
        if self.none:
            examples = [self.example_text, self.none] if self.example_text else [self.none]
            return {"anyOf": [item, {"const": self.none}], "examples": examples}
        return item


def is_number(raw_value: object) -> bool:
    """Return True for a number, or a text that is a number."""
    if isinstance(raw_value, bool) or not isinstance(raw_value, (str, int, float)):
        return False
    try:
        float(raw_value)
    except ValueError:
        return False
    return True


def option(
    name: str, help: str, kind: Kind | type = str, label: str = "", **settings: Any
) -> Option:
    """Declare an input of commands and studies that is not a parameter of a class.

    ``kind`` is a Python type, or the kind of a quantity with a unit; ``settings`` are further
    fields of :class:`Option`. By default the input may be omitted (``default=None``), and a
    quantity with a unit must be above zero unless ``sign="any"``.
    """
    settings = {"default": None, **settings}
    if isinstance(kind, Kind) and settings.pop("sign", "positive") == "positive":
        settings.setdefault("above", 0.0)
    return Option(name, help=help, kind=kind, label=label, **settings)
