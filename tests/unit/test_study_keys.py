"""Every key of a study, from its declaration: its example is read, wrong values are refused."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest
from cases import folded

from microslip._core.options import Option
from microslip._core.parameters import Number
from microslip._core.units import Kind
from microslip.study.part import Key, Part, located_tables
from microslip.study.readers import DeclaredValue, KeyedError, Place
from microslip.study.schema import StudyTables


def declared_keys() -> Iterator[tuple[str, Key]]:
    seen: set[tuple[type[Part], str]] = set()
    for table, model in located_tables(StudyTables):
        for name, item in model.keys.items():
            if (model, name) not in seen:
                seen.add((model, name))
                yield f"{table}.{name}", item


KEYS = dict(declared_keys())
PLAIN = {
    path: item.declared
    for path, item in KEYS.items()
    if isinstance(item.reader, DeclaredValue) and item.declared is not None
}


def read(item: Key, raw: object) -> Any:
    """The value that a key reads."""
    place = Place("table.key", None, [])
    with place.located():
        return item.reader.read(raw, place)


def refused(item: Key, raw: object) -> None:
    """A value is refused at its key, in one line that says what is wanted."""
    with pytest.raises(KeyedError, match=r"^wanted") as caught:
        read(item, raw)
    assert caught.value.key == "table.key"
    assert "\n" not in str(caught.value)


def text_in_si(declared: Number, value: float) -> object:
    """A value as a study writes it."""
    return f"{value!r} {declared.unit}".strip() if isinstance(declared.kind, Kind) else value


def example(item: Key) -> object:
    """The example of a key, else a value that its kind makes one; None of a table of its own."""
    if written := item.example or item.reader.example:
        return tomllib.loads(f"x = {written}")["x"]
    declared = item.declared
    if [*item.reader.tables()] or declared is None:
        return None
    if isinstance(declared, Option) and (declared.choices or declared.none):
        return (*declared.choices, declared.none)[0]
    return {bool: True, int: 1, str: "text"}[declared.kind]  # type: ignore[index]


@folded("item", {path: item for path, item in KEYS.items() if example(item) is not None})
def test_the_example_of_a_key_is_accepted(item: Key) -> None:
    try:
        read(item, example(item))
    except KeyedError as error:
        if not str(error).endswith("no such file"):  # a table that names a file is read up to it
            raise


@folded("path", {path: path for path in PLAIN})
def test_a_wrong_kind_is_refused_at_its_key(path: str) -> None:
    item, declared = KEYS[path], PLAIN[path]
    wrong: list[object] = [{"a": 1}, math.nan]
    if isinstance(declared.kind, Kind):
        wrong += ["1 candela", "much"]  # no such quantity, no number
        if not (isinstance(declared, Option) and declared.bare):
            wrong.append(1.0)
    elif declared.kind in (float, int):
        wrong += ["much", True]
    elif declared.kind is bool:
        wrong += ["much", 1.0]
    elif isinstance(declared, Option) and declared.choices:
        wrong.append("no choice of it")
    for raw in wrong:
        refused(item, raw)


LIMITED = {
    f"{path} {value:g}": (path, value)
    for path, declared in PLAIN.items()
    if declared.kind in (float, int) or isinstance(declared.kind, Kind)
    for value in (
        declared.above,
        declared.below,
        *(math.nextafter(v, w) if declared.kind is not int else v + math.copysign(1, w)
          for v, w in ((declared.least, -math.inf), (declared.most, math.inf))
          if math.isfinite(v)),
    )
    if math.isfinite(value)
}  # fmt: skip


@folded("limited", LIMITED)
def test_a_value_past_a_limit_is_refused_at_its_key(limited: tuple[str, float]) -> None:
    path, value = limited
    item, declared = KEYS[path], PLAIN[path]
    raw = text_in_si(declared, value if declared.kind is not int else int(value))
    refused(item, raw)
