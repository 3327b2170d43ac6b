"""Base class of the tables of a study file.

A table declares its keys by :func:`key`. The declaration of a key determines how its value is read,
the error messages, and the JSON Schema.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from microslip._core.errors import StudyError
from microslip._core.parameters import REQUIRED, JsonSchema, Number
from microslip._core.quantities import json_value
from microslip._core.wording import did_you_mean, nearest, quote, quoted
from microslip.study.readers import (
    Constant,
    DeclaredValue,
    KeyedError,
    ListOf,
    NamedValues,
    Place,
    Reader,
)
from microslip.study.removed import removed_key, removed_value


@dataclass
class Key:
    """Declaration of one key of a table."""

    reader: Reader
    help: str
    example: str
    default: Any
    name: str
    """Name in the file; empty if it equals the name of the attribute."""

    @property
    def required(self) -> bool:
        """Whether the key must be given."""
        return self.default is REQUIRED

    @property
    def declared(self) -> Number | None:
        """Declaration of the value, or of the items of a list; None if the key is a table."""
        reader = self.reader
        while isinstance(reader, (ListOf, NamedValues)):
            reader = reader.item
        return getattr(reader, "declared", None)

    @property
    def unit(self) -> str:
        """SI unit of the value; "" if it has none."""
        return "" if self.declared is None else self.declared.unit

    def schema(self, name: str) -> JsonSchema:
        """Return the JSON Schema of the value, with title and description for editors."""
        schema = self.reader.schema()
        schema["title"] = name.replace("_", " ").capitalize()
        usage = schema.get("description", "") if schema.get("type") == "string" else ""
        schema["description"] = f"{self.help} {usage}".strip()
        if self.example:
            schema["examples"] = [tomllib.loads(f"x = {self.example}")["x"]]
        if isinstance(self.default, tuple) and self.default:
            schema["default"] = list(self.default)
        elif isinstance(self.default, (bool, int, str)) and self.default != "":
            schema["default"] = self.default
        return schema


def key(
    declared: Number | Reader, help: str = "", example: str = "", *,
    default: Any = ..., alias: str = "",
) -> Any:  # fmt: skip
    """Declare a key of a table.

    Help, example and default are taken from the declaration unless given. A key with a default is
    optional. ``alias`` is the name in the file if it differs from the attribute.
    """
    reader = declared if isinstance(declared, Reader) else DeclaredValue(declared)
    return Key(
        reader,
        help or reader.help,
        example or ("" if isinstance(reader, Constant) else reader.example),
        reader.default if default is ... else default,
        alias,
    )


def optional_key(declared: Number | Reader, help: str = "", example: str = "") -> Any:
    """Declare an optional key, None if it is missing."""
    return key(declared, help, example, default=None)


def tag(value: object, help: str, *, default: Any = REQUIRED) -> Any:
    """Declare the key that identifies the variant of a table, such as ``kind`` or ``law``."""
    return key(Constant(value), help, default=default)


class SubTable(Reader):
    """Reader of a table that may have several variants.

    The function ``choose`` of the table's content returns the variant; without a function, or if it
    returns None, the value of the key ``tag`` determines it.
    """

    def __init__(
        self,
        *models: type[Part],
        tag: str = "",
        choose: Callable[[Any], type[Part] | None] = lambda raw: None,
    ) -> None:
        self.models, self.tag, self.choose = models, tag, choose
        self.by_tag = {model.tag_value(tag): model for model in models} if tag else {}
        self.help = _first_line(models[0])

    def read(self, raw_value: object, place: Place) -> Any:
        """Return the table of the chosen variant."""
        if not isinstance(raw_value, Mapping):
            raise ValueError(self.models[0].no_table(raw_value, place))
        chosen = self.choose(raw_value) or (self._by_tag(raw_value, place) if self.tag else None)
        return (chosen or self.models[0]).read(raw_value, place)

    def _by_tag(self, raw: Mapping[Any, Any], place: Place) -> type[Part]:
        if self.tag not in raw:
            near = nearest(self.tag, [name for name in raw if isinstance(name, str)])
            if near is not None and not any(near in model.keys for model in self.models):
                raise KeyedError(f".{near}", f'unknown key; did you mean "{self.tag}"?')
            raise KeyedError(f".{self.tag}", f"missing; wanted {quoted(self.by_tag)}")
        choice = raw[self.tag]
        if isinstance(choice, str) and choice in self.by_tag:
            return self.by_tag[choice]
        if removed := removed_value(place.at(self.tag).key, str(choice), raw):
            raise KeyedError(f".{self.tag}", removed)
        near = did_you_mean(choice, self.by_tag) if isinstance(choice, str) else ""
        raise KeyedError(f".{self.tag}", f"wanted {quoted(self.by_tag)}, got {quote(choice)}{near}")

    def schema(self) -> JsonSchema:
        """Return the schema of the table, or of all its variants."""
        schemas = [model.schema() for model in self.models]
        return schemas[0] if len(schemas) == 1 else {"oneOf": schemas}

    def tables(self) -> Iterator[tuple[str, type[Part]]]:
        """Yield the single table, or all variants, each with the key that selects the variant."""
        for model in self.models:
            yield f' with {self.tag} = "{model.tag_value(self.tag)}"' if self.tag else "", model


class Part:
    """Table of a study file: an immutable object; unknown keys are errors."""

    keys: ClassVar[dict[str, Key]] = {}
    """Declarations by name in the file."""
    attributes: ClassVar[dict[str, str]] = {}
    """Attribute names by key name."""
    rules: ClassVar[JsonSchema] = {}
    """Further entries of the JSON Schema, such as mutually exclusive keys."""

    def __init_subclass__(cls, **settings: Any) -> None:
        super().__init_subclass__(**settings)
        declared = {
            attribute: item
            for base in reversed(cls.__mro__)
            for attribute, item in vars(base).items()
            if isinstance(item, Key)
        }
        cls.keys = {item.name or attribute: item for attribute, item in declared.items()}
        cls.attributes = {item.name or attribute: attribute for attribute, item in declared.items()}

    _keys_in_file: frozenset[str] = frozenset()  # keys that the file has

    @classmethod
    def read(cls, raw_value: object, place: Place) -> Self:
        """Return the validated table; raise a KeyedError for the first wrong key."""
        if not isinstance(place, Place):
            raise StudyError(f"`place` must be a Place, got {quote(place)}; use Study.load(path)")
        if not isinstance(raw_value, Mapping):
            raise ValueError(cls.no_table(raw_value, place))
        for name in raw_value:
            if name not in cls.keys:
                here = place.at(name)
                raise KeyedError(here.key, removed_key(here.key) or cls.unknown(str(name)))
        values: dict[str, Any] = {}
        for name, item in cls.keys.items():
            here, value = place.at(name), raw_value.get(name, item.default)
            if name in raw_value and (value is not None or item.default is not None):
                with here.located():
                    value = item.reader.read(value, here)
            elif value is REQUIRED:
                raise KeyedError(here.key, cls.missing(name, item, place))
            values[cls.attributes[name]] = value
        part = cls.__new__(cls)
        part.__dict__.update(values, _keys_in_file=frozenset(raw_value))
        with place.located([*cls.keys]):
            part.check(place)
        return part

    def check(self, place: Place) -> None:
        """Raise an error for invalid combinations of keys; called after all keys were read."""

    @classmethod
    def tag_value(cls, tag: str) -> str:
        """Return the value of the key ``tag`` that identifies this variant of a table."""
        return str(cls.keys[tag].reader.value)  # type: ignore[attr-defined]

    @classmethod
    def no_table(cls, raw_value: object, place: Place) -> str:
        """Return the error message for a value that is not a table."""
        needed = [
            f"{name} = {item.example or item.reader.example}"
            for name, item in cls.keys.items()
            if item.required and (item.example or item.reader.example)
        ]
        form = f"such as {{ {', '.join(needed)} }}" if needed else f"[{place.key}]"
        return f"wanted a table {form}, got {quote(raw_value)}"

    @classmethod
    def missing(cls, name: str, item: Key, place: Place) -> str:
        """Return the error message for a missing key."""
        if not item.example:
            return f"missing; write a table [{place.at(name).key}]"
        return f"missing; write for example {name} = {item.example}"

    @classmethod
    def unknown(cls, name: str) -> str:
        """Return the error message for an unknown key."""
        if hint := did_you_mean(name, cls.keys):
            return f"unknown key{hint}"
        home = next((words for words, model in LOCATED_TABLES if name in model.keys), None)
        if home is not None:
            return f"unknown key here; it belongs in {home}"
        return f"unknown key; the keys here are {', '.join(cls.keys)}"

    @classmethod
    def schema(cls) -> JsonSchema:
        """Return the JSON Schema with complete schemas of all keys."""
        names = [item.reader.value for name in ("law", "kind") if (item := cls.keys.get(name))
                 and isinstance(item.reader, Constant)]  # fmt: skip
        return {
            "type": "object",
            **({"title": names[0]} if names else {}),
            "description": _first_line(cls),
            "properties": {name: item.schema(name) for name, item in cls.keys.items()},
            "required": [name for name, item in cls.keys.items() if item.required],
            "additionalProperties": False,
            **cls.rules,
        }

    def __setattr__(self, name: str, value: object) -> None:
        if not name.startswith("_"):
            raise AttributeError(f"a study is frozen; {name} cannot be set")
        self.__dict__[name] = value

    def __eq__(self, value: object) -> bool:
        if type(value) is not type(self):
            return NotImplemented
        return all(getattr(self, a) == getattr(value, a) for a in self.attributes.values())

    def __repr__(self) -> str:
        values = (f"{a}={getattr(self, a)!r}" for a in self.attributes.values())
        return f"{type(self).__name__}({', '.join(values)})"

    def written(self, names: Iterable[str]) -> list[str]:
        """Return the given key names that occur in the file."""
        return [name for name in names if name in self._keys_in_file]

    def keep(self, **values: Any) -> None:
        """Set attributes that are not keys but were derived from keys during validation."""
        self.__dict__.update(values)

    def copy(self, **changes: Any) -> Self:
        """Return a copy with some attributes replaced, in SI units and without validation."""
        copy = type(self).__new__(type(self))
        copy.__dict__.update(self.__dict__, **changes)
        return copy

    @classmethod
    def of(cls, **values: Any) -> Self:
        """Return an instance with attribute values in SI units, which are not validated."""
        part = cls.__new__(cls)
        usual = {cls.attributes[name]: item.default for name, item in cls.keys.items()}
        part.__dict__.update(usual, **values)
        return part

    def by_keys(self) -> dict[str, Any]:
        """Return values in SI units by key, without keys that are None."""
        values = {name: getattr(self, attribute) for name, attribute in self.attributes.items()}
        return {name: _by_keys(value) for name, value in values.items() if value is not None}

    def plain(self) -> dict[str, Any]:
        """Return values in SI units as plain JSON types."""
        result: dict[str, Any] = json_value(self.by_keys())
        return result


class SurfaceTable(Part):
    """Base of the tables of surfaces, with the results that they contribute to a report."""

    @property
    def apparent_area(self) -> float | None:
        """Apparent area [m^2]; None if the surface has none."""
        area: float | None = getattr(self, "area", None)
        return area

    def findings(self) -> dict[str, Any]:
        """Return numbers of the surface in SI units, for summary.json."""
        return {}

    def sentences(self) -> list[str]:
        """Return the numbers of :meth:`findings` as sentences for the report."""
        return []


LOCATED_TABLES: list[tuple[str, type[Part]]] = []
"""All tables of a study with their location as text, to find the table of a misplaced key."""


def located_tables(model: type[Part], path: str = "") -> Iterator[tuple[str, type[Part]]]:
    """Yield a table and its subtables with their location as text, such as "[joint]"."""
    yield f"[{path}]" if path else "the top level", model
    for name, item in model.keys.items():
        where = f"{path}.{name}" if path else name
        if isinstance(item.reader, NamedValues):
            where += ".NAME"
        for words, table in item.reader.tables():
            if words and "kind" in words:
                yield f"{name}{words}", table
            elif words:
                yield f"[{where}]{words}", table
            if not words:
                yield from located_tables(table, where)


def _by_keys(value: Any) -> Any:
    if isinstance(value, Part):
        return value.by_keys()
    if isinstance(value, dict):
        return {name: _by_keys(item) for name, item in value.items()}
    if isinstance(value, tuple) and any(isinstance(item, (Part, tuple)) for item in value):
        return tuple(map(_by_keys, value))
    return value


def _first_line(model: type) -> str:
    return (model.__doc__ or "").split("\n")[0]
