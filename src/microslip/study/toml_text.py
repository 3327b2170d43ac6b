"""TOML text of studies: parsing with clear errors, overrides, and writing."""

from __future__ import annotations

import copy
import json
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from microslip._core.errors import StudyError
from microslip._core.files import relative_path
from microslip._core.wording import quote, shorten
from microslip.readers.files import usable

_EXAMPLE = """joint.normal_load="3 kN\""""
_LISTS = """such as joint.normal_load=["1 kN", "3 kN"]"""

MAX_DEPTH = 200
"""Largest number of levels of a key; a study has five, and parsing time is quadratic in it."""

_LEVELS = re.compile(r"""(?:\.[ \t]*(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*)+""")


def is_too_deep(text: str) -> bool:
    """Return whether a key of a TOML text has more than :data:`MAX_DEPTH` levels."""
    return any(levels[0].count(".") >= MAX_DEPTH for levels in _LEVELS.finditer(text))


@dataclass
class Override:
    """Key of a study and its new value; None removes the key."""

    text: str
    path: tuple[str, ...]
    value: Any

    @property
    def note(self) -> str:
        """Sentence that states the new value, for the notes of a report."""
        value = self.text.partition("=")[2].strip()
        return f"{dotted(self.path)} was overridden: {shorten(value, 80)}."


def apply(
    overrides: Sequence[str], text: str, data: dict[str, Any]
) -> tuple[str, dict[str, Any], list[str]]:
    """Return text and tables of a study with overrides applied, and notes on the overrides."""
    if not isinstance(overrides, (list, tuple)):
        raise StudyError(f"overrides: wanted a list such as ['{_EXAMPLE}'], got {quote(overrides)}")
    changes = [_read(override) for override in overrides]
    data = copy.deepcopy(data)
    for change in changes:
        _set_key(data, change)
    return _with_comments(text, data, changes), data, [change.note for change in changes]


FILE_KEYS = ("file", "law_file", "scan")
"""Keys with the name of a file."""


def relocated_text(text: str, folder: Path, new_folder: Path) -> str:
    """Return the text of a study with relative paths rewritten for another folder."""

    def from_elsewhere(name: str) -> str:
        return name if Path(name).is_absolute() else relative_path(new_folder, folder / name)

    data = tomllib.loads(text)
    changes = [Override("", path, value) for path, value in _files(data, from_elsewhere)]
    for change in changes:
        _set_key(data, change)
    return _with_comments(text, data, changes) if changes else text


def _files(
    node: dict[str, Any], relocated: Callable[[str], str], above: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the path of keys and the new value of each key that names files.

    ``relocated`` rewrites a file name. If tables in a list name files, the value is the new list.
    """
    for key, value in node.items():
        if isinstance(value, dict):
            yield from _files(value, relocated, (*above, key))
        elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
            items = [
                item | {name[0]: file for name, file in _files(item, relocated)}
                if isinstance(item, dict)
                else item
                for item in value
            ]
            if items != value:
                yield (*above, key), items
        elif key in FILE_KEYS and isinstance(value, str):
            yield (*above, key), relocated(value)


def dotted(path: Sequence[str]) -> str:
    """Return a path of keys as text, such as "joint.normal_load"."""
    return ".".join(shorten(word, 40) for word in path)


def _read(text: object) -> Override:
    if not isinstance(text, str):
        raise StudyError(f"override: wanted a text such as '{_EXAMPLE}', got {quote(text)}")
    key, equals, value = text.partition("=")
    if not equals:
        raise _error(text, f"wanted KEY=VALUE such as {_EXAMPLE}")
    if not value.strip():
        raise _error(text, f"no value; wanted KEY=VALUE such as {_EXAMPLE}")
    return Override(text, _path(text, key), _value(text, value.strip()))


def _error(text: str, message: str) -> StudyError:
    return StudyError(f'override "{shorten(text, 80)}": {message}')


def _path(text: str, key: str) -> tuple[str, ...]:
    if "[" in key:
        raise _error(text, f"no item of a list can be set; give all of the list, {_LISTS}")
    if is_too_deep(key):
        raise _error(text, f"a key of more than {MAX_DEPTH} levels")
    try:
        node: Any = {} if "\n" in key or "#" in key else tomllib.loads(f"{key} = 0")
    except (ValueError, RecursionError):
        node = {}
    path: list[str] = []
    while isinstance(node, dict) and len(node) == 1:
        ((word, node),) = node.items()
        path.append(word)
    if node != 0 or not path:
        example = 'a key such as joint.normal_load before "="'
        raise _error(text, f"wanted {example}, got {quote(key.strip())}")
    return tuple(path)


def _value(override: str, text: str) -> Any:
    """Return the value of an override; text that is not valid TOML is taken as a string."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        parsed = {}
    if parsed.keys() == {"value"}:
        return parsed["value"]
    if text[0] in "[{\"'":
        quoted = "in a shell put single quotes around all of it"
        raise _error(override, f"its value is not TOML; {quoted}, {_LISTS.replace('such as ', '')}")
    return text


def _set_key(data: Any, change: Override) -> None:
    *words, last = change.path
    node = data
    for count, word in enumerate(words, start=1):
        if word not in node:
            node[word] = {}
        node = node[word]
        if not isinstance(node, dict):
            path = dotted(words[:count])
            wrong = f"{path} is {quote(node)} and has no keys; write {path}=VALUE"
            if isinstance(node, list):
                wrong = f"no item of a list can be set; give all of the list, {path}=[…]"
            raise _error(change.text, wrong)
    if change.value is None:
        node.pop(last, None)
        return
    node[last] = change.value


def _with_comments(text: str, data: dict[str, Any], changes: Sequence[Override]) -> str:
    """Return the edited text with its comments, or without them if tomlkit cannot edit it."""
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(text)
        for change in changes:
            _set_key(document, replace(change, value=_on_one_line(change.value)))
        edited = tomlkit.dumps(document)
        if _canonical(tomllib.loads(edited)) == _canonical(data):
            return edited
    except (TOMLKitError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        pass
    return dump(data)


def _canonical(data: dict[str, Any]) -> str:
    return json.dumps(data, sort_keys=True, default=str)


def dump(study: dict[str, Any]) -> str:
    """Return the tables of a study as TOML."""
    import tomlkit

    return tomlkit.dumps(study)


def _on_one_line(value: Any) -> Any:
    """Return a table, or a list of tables, as an item of tomlkit that is written on one line."""
    import tomlkit

    if isinstance(value, dict):
        table = tomlkit.inline_table()
        table.update({key: _on_one_line(item) for key, item in value.items()})
        return table
    if isinstance(value, list):
        array = tomlkit.array()
        array.extend(map(_on_one_line, value))
        return array
    return value


_MAX_BYTES = 16_000_000


def read_text(path: Path) -> str:
    """Return the UTF-8 text of a study; raise ValueError with the reason if it cannot be read."""
    with usable(path, "a study file"), path.open("rb") as file:
        content = file.read(_MAX_BYTES + 1)
    if len(content) > _MAX_BYTES:
        raise ValueError(f"wanted a study of at most {_MAX_BYTES // 1_000_000} MB")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ValueError("not UTF-8 text (it is UTF-16); save the file as UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(
            f"line {line}: not UTF-8 text (byte 0x{content[error.start]:02x}); "
            "save the file as UTF-8"
        ) from None


def tables_of(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text; raise ValueError with the reason if it is invalid."""
    if is_too_deep(text):
        raise ValueError(f"not a study: a key of more than {MAX_DEPTH} levels")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(_toml_message(str(error), text)) from None
    except RecursionError:
        raise ValueError("not TOML that can be read: nested too deeply") from None
    except ValueError:  # raised by int() for thousands of digits
        raise ValueError("not a study: an integer of thousands of digits") from None


# Replacements for technical messages of tomllib.
_CLEARER = {
    "Invalid value": "invalid value (write text and quantities in quotes)",
    "Cannot overwrite a value": "this key is given twice",
    "Illegal character '\\n'": "a text without its closing quote",
    "Unterminated string": "a text without its closing quote",
}

# Common mistakes: text before and after the position of the error, and the explanation.
_REASONS = (
    (r"\d$", r",\d", 'the decimal sign is the point, "."'),
    (r"\d\s*$", r"[^\W\d_]|[/%°]", 'write quantities in quotes, such as "2 kN"'),
    (r"[=\[,]\s*$", r"[+-]?\.\d", "write a 0 before the point"),
    (r"[=\[,]\s*$", "[“”„«»‘’´`]", 'quotes are straight, as in "2 kN"'),
)


def _toml_message(message: str, text: str) -> str:
    where = re.search(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$", message)
    fault = message[: where.start()] if where else message
    lines = text.split("\n")
    if where and where[1]:
        line, column = int(where[1]), int(where[2])
        before, after = lines[line - 1][: column - 1], lines[line - 1][column - 1 :].lstrip()
        for end, begin, explanation in _REASONS:
            if re.search(end, before[-80:]) and re.match(begin, after):
                fault = explanation
    else:
        lines = text.rstrip("\n").split("\n")
        line, column = len(lines), len(lines[-1]) + 1
    fault = _CLEARER.get(fault, fault)
    # tomllib shows the path of a table as a Python tuple.
    fault = re.sub(r"\('([^()]*)',?\)", lambda m: "[" + m[1].replace("', '", ".") + "]", fault)
    fault = shorten(fault[:1].lower() + fault[1:], 120)
    return f"line {line}, column {column}: not TOML: {fault}"
