"""The errors that wrong input meets, and the arguments that their messages speak of.

A message is built from parts: words, and an :class:`Argument` for each argument of a function
that it names. So every edge of the house says it in its own way, ``normal_load=500`` in Python,
``--normal-load 500`` on a command line, ``normal_load = 500`` in a study.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import Enum
from typing import Any, NamedTuple, Self


class _Mark(Enum):
    """Values that no argument has, the same ones after pickling."""

    UNSAID = "left to the reader"
    NO_VALUE = "only the name is said"

    def __repr__(self) -> str:
        return "..."


UNSAID: Any = _Mark.UNSAID
"""Stands for the value that the reader has to give; ``Argument("key", UNSAID)`` is ``key=...``."""


class Argument(NamedTuple):
    """An argument in a message: by its name alone, or with a value to write."""

    name: str
    value: Any = _Mark.NO_VALUE

    @property
    def has_value(self) -> bool:
        """Whether the message says what to write, :data:`UNSAID` included."""
        return self.value is not _Mark.NO_VALUE

    def __str__(self) -> str:
        return f"{self.name}={in_python(self.value)}" if self.has_value else self.name

    def __format__(self, spec: str) -> str:
        return format(str(self), spec)


Spelling = Callable[[Argument], str]
"""How an edge of the house writes an argument."""


def in_python(value: object) -> str:
    """A value as it is written in Python, text in double quotes."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"({', '.join(map(in_python, value))}{',' * (len(value) == 1)})"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{in_python(k)}: {in_python(v)}' for k, v in value.items())}}}"
    return repr(value)


class Phrase(str):
    """Text built from words and arguments: a note or a remedy that each edge says its own way.

    As a string it is spelt for Python.
    """

    parts: tuple[str | Argument, ...]

    def __new__(cls, *parts: object) -> Self:
        """Join words and arguments, those of other phrases included."""
        flat = _flat(parts)
        phrase = super().__new__(cls, "".join(map(str, flat)))
        phrase.parts = flat
        return phrase

    def __getnewargs__(self) -> tuple[Any, ...]:
        return self.parts


def said(text: str, spelling: Spelling) -> str:
    """A text in the spelling of an edge; one without arguments stays as it is."""
    return _spelt(text.parts, spelling) if isinstance(text, Phrase) else text


class InputError(ValueError):
    """Something given is not usable; the message says what came and what was wanted.

    Parameters
    ----------
    *parts : str or Argument
        The message, in parts; `str` of the error joins them as they are written in Python.
    """

    @property
    def parts(self) -> tuple[str | Argument, ...]:
        """Words and arguments of the message."""
        return _flat(self.args)

    @property
    def argument(self) -> str | None:
        """Name of the argument that is wrong, if the message begins with one."""
        first = next(iter(self.parts), None)
        return first.name if isinstance(first, Argument) else None

    def said(self, spelling: Spelling) -> str:
        """The message in the spelling of an edge."""
        return _spelt(self.parts, spelling)

    def within(self, *place: object) -> Self:
        """The same error with the place where it arose before it, such as a file and ": "."""
        return type(self)(*place, *self.args)

    def __str__(self) -> str:
        return "".join(map(str, self.args))


class StudyError(InputError):
    """A study file is not usable; the message names the file and the key."""


def _flat(parts: Iterable[object]) -> tuple[str | Argument, ...]:
    flat: list[str | Argument] = []
    for part in parts:
        if isinstance(part, Phrase):
            flat.extend(part.parts)
        elif isinstance(part, Argument):
            flat.append(part)
        else:
            flat.append(str(part))
    return tuple(flat)


def _spelt(parts: Iterable[str | Argument], spelling: Spelling) -> str:
    return "".join(spelling(part) if isinstance(part, Argument) else part for part in parts)
