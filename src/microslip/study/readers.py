"""Readers of single values of a study; an error names the key."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from microslip._core.errors import InputError
from microslip._core.parameters import REQUIRED, JsonSchema, Number
from microslip._core.wording import quote, shorten

_MOST_NAMES = 1000  # of a table with user-defined names


class KeyedError(ValueError):
    """Error of a value or of a check that involves several keys, attributed to one key.

    A key that starts with a dot is relative to the table that is being read.
    """

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Place(NamedTuple):
    """Location in the study: the table and key that are being read, and the folder of the file."""

    key: str
    folder: Path | None
    notes: list[str]
    """Notes on the whole study, to which readers of files add theirs."""

    def path(self, name: str) -> Path:
        """Return the path of a file named in the study."""
        return (self.folder or Path()) / name

    def message(self, error: str, name: str) -> str:
        """Return an error message for a file; it states that the study's folder was searched."""
        if self.folder is None or Path(name).is_absolute():
            return error
        return error.replace("no such file", "no such file in the folder of the study")

    def at(self, name: object) -> Place:
        """Return the location of a key of this table."""
        text = shorten(str(name), 40)
        return self._replace(key=f"{self.key}.{text}" if self.key else text)

    def item(self, index: int) -> Place:
        """Return the location of a list item, counted from 1."""
        return self._replace(key=f"{self.key}, item {index}")

    @contextmanager
    def located(self, names: Container[str] = ()) -> Iterator[None]:
        """Return a context in which each ValueError becomes a KeyedError about this location.

        An InputError about one of the arguments ``names`` is about the key of that name.
        """
        try:
            yield
        except KeyedError as error:
            if not error.key.startswith("."):
                raise
            raise KeyedError(self.key + error.key, str(error)) from None
        except InputError as error:
            raise KeyedError(*as_keyed(error, self.key, names)) from None
        except ValueError as error:
            raise KeyedError(self.key, str(error)) from None


class Reader:
    """Reader and validator of the value of a key, with a JSON Schema for editors."""

    help: str = ""
    example: str = ""  # as TOML
    default: Any = REQUIRED

    def read(self, raw_value: object, place: Place) -> Any:
        """Return the value or raise ValueError."""
        raise NotImplementedError

    def schema(self) -> JsonSchema:
        """Return the JSON Schema of valid values."""
        raise NotImplementedError

    def tables(self) -> Iterator[tuple[str, Any]]:
        """Yield the tables that the value may contain, each with the key that selects it."""
        return iter(())


class DeclaredValue(Reader):
    """Reader of a value declared by its type, unit and limits."""

    def __init__(self, declared: Number) -> None:
        self.declared = declared
        self.help, self.example = declared.sentence, declared.written
        self.default = declared.default

    def read(self, raw_value: object, place: Place) -> Any:
        """Return the value in SI units."""
        return self.declared.read(raw_value)

    def schema(self) -> JsonSchema:
        """Return the JSON Schema of the declaration."""
        return self.declared.schema()


class Constant(Reader):
    """Reader of the fixed value that identifies a variant of a table."""

    def __init__(self, value: object) -> None:
        self.value, self.example = value, quote(value)

    def read(self, raw_value: object, place: Place) -> Any:
        """Return the value."""
        if raw_value != self.value or isinstance(raw_value, bool) != isinstance(self.value, bool):
            raise ValueError(f"wanted {self.example}, got {quote(raw_value)}")
        return raw_value

    def schema(self) -> JsonSchema:
        """Return the schema of the fixed value."""
        return {"const": self.value}


class _Several(Reader):
    item: Reader

    def tables(self) -> Iterator[tuple[str, Any]]:
        return self.item.tables()


class ListOf(_Several):
    """Reader of a list; with ``single``, one item may be given without brackets."""

    def __init__(
        self, item: Number | Reader, example: str, count: tuple[int, int] = (1, 1000),
        *, single: bool = False, distinct: bool = False,
    ) -> None:  # fmt: skip
        self.item = item if isinstance(item, Reader) else DeclaredValue(item)
        self.example, self.count, self.single, self.distinct = example, count, single, distinct
        self.help = self.item.help

    def read(self, raw_value: object, place: Place) -> Any:
        """Return a tuple of the items."""
        low, high = self.count
        if self.single and type(raw_value) not in (list, tuple):
            return (self.item.read(raw_value, place),)
        if not isinstance(raw_value, (list, tuple)) or (low and not raw_value):
            raise ValueError(f"wanted a list such as {self.example}, got {quote(raw_value)}")
        if len(raw_value) > high > low:
            raise ValueError(f"wanted at most {high} items, got {len(raw_value)}")
        if not low <= len(raw_value) <= high:
            raise ValueError(f"wanted {low} items such as {self.example}, got {len(raw_value)}")
        values = self._values(raw_value, place)
        if self.distinct:
            places: dict[Any, int] = {}
            for index, value in enumerate(values, start=1):
                if value in places:
                    came = f"items {places[value]} and {index}"
                    raise ValueError(f"wanted values that differ, got the same one as {came}")
                places[value] = index
        return values

    def _values(self, raw_values: Sequence[object], place: Place) -> tuple[Any, ...]:
        read, values = self.item.read, []
        for index, raw_value in enumerate(raw_values, start=1):
            try:  # Place.located for each item would be slow for a million items
                values.append(read(raw_value, place))
            except KeyedError:
                raise
            except ValueError as error:
                raise KeyedError(place.item(index).key, str(error)) from None
        return tuple(values)

    def schema(self) -> JsonSchema:
        """Return the schema of the list."""
        item = self.item.schema()
        low, high = self.count
        several = {"type": "array", "items": item, "minItems": low, "maxItems": high}
        return {"anyOf": [item, several]} if self.single else several


class NamedValues(_Several):
    """Reader of a table with user-defined names."""

    def __init__(self, item: Number | Reader, example: str) -> None:
        self.item = item if isinstance(item, Reader) else DeclaredValue(item)
        self.example = example

    def read(self, raw_value: object, place: Place) -> Any:
        """Return the values by name."""
        if not isinstance(raw_value, Mapping):
            raise ValueError(f"wanted a table such as {self.example}, got {quote(raw_value)}")
        if len(raw_value) > _MOST_NAMES:
            raise ValueError(f"wanted at most {_MOST_NAMES} names, got {len(raw_value)}")
        values: dict[str, Any] = {}
        for name, value in raw_value.items():
            here = place.at(name)
            with here.located():
                if not isinstance(name, str):
                    raise ValueError(f"wanted a name that is text, got {quote(name)}")
                values[name] = self.item.read(value, here)
        return values

    def schema(self) -> JsonSchema:
        """Return the schema of a table with arbitrary names."""
        return {"type": "object", "additionalProperties": self.item.schema()}


def as_keyed(error: InputError, table: str, names: Container[str]) -> tuple[str, str]:
    """Return the key of a study that an InputError is about, and its message on one line.

    The key is ``table``.argument if the argument named by the error is one of ``names``, otherwise
    ``table``, which may be the key of the argument itself.
    """
    argument, text = error.argument, error.text
    if argument is not None and argument in names:
        table, text = f"{table}.{argument}" if table else argument, error.statement
    elif argument is not None and table.split(",")[0].endswith(argument):
        text = error.statement
    return table, " ".join(text.replace("`", "").split())
