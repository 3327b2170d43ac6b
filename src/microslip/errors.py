"""The errors that wrong input meets, and the arguments that their messages speak of.

A message is plain text in which the arguments of a function stand between backticks, alone or with
the value to write: "`normal_load` must be above zero", "give `start=...`". So every edge of the
house says it in its own way: ``normal_load=500`` in Python, ``--normal-load 500`` on a command
line, ``normal_load = 500`` in a study.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from typing import Any, Final, NamedTuple, Self

UNSAID: Final = ...
"""Stands for the value that the reader has to give: "`key=...`"."""

_NO_VALUE: Final = object()
_SLICE = re.compile(r"slice\((\w+), (\w+)\)")
_MARKED = re.compile(r"`(?P<name>[^`=]+)(?:=(?P<value>[^`]*))?`")


class Argument(NamedTuple):
    """An argument in a message: by its name alone, or with a value to write."""

    name: str
    value: Any = _NO_VALUE

    @property
    def has_value(self) -> bool:
        """Whether the message says what to write, :data:`UNSAID` included."""
        return self.value is not _NO_VALUE

    def __str__(self) -> str:
        return f"{self.name}={in_python(self.value)}" if self.has_value else self.name


Spelling = Callable[[Argument], str]
"""Spelling of an argument, as the Python interface or the command writes it."""


def in_python(value: object) -> str:
    """A value as it is written in Python, text in double quotes."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"({', '.join(map(in_python, value))}{',' * (len(value) == 1)})"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{in_python(k)}: {in_python(v)}' for k, v in value.items())}}}"
    if isinstance(value, slice):
        return f"slice({value.start}, {value.stop})"
    return "..." if value is UNSAID else repr(value)


def said(text: str, spelling: Spelling = str) -> str:
    """A text in the spelling of an edge, of Python by default."""
    return _MARKED.sub(lambda match: _spelt(match, spelling), text)


class InputError(ValueError):
    """Something given is not usable; the message says what came and what was wanted.

    Parameters
    ----------
    text : str
        The message, arguments between backticks; `str` of the error writes them as in Python.
    """

    @property
    def text(self) -> str:
        """The message with its arguments marked."""
        return "".join(map(str, self.args))

    @property
    def argument(self) -> str | None:
        """Name of the argument that is wrong, if the message begins with one."""
        match = _MARKED.match(self.text)
        return match["name"] if match else None

    @property
    def statement(self) -> str:
        """The message without the argument that it begins with."""
        return _MARKED.sub("", self.text, count=1).strip() if self.argument else self.text

    def said(self, spelling: Spelling) -> str:
        """The message in the spelling of an edge."""
        return said(self.text, spelling)

    def within(self, place: str) -> Self:
        """The same error with the place where it arose before it, such as a file and ": "."""
        return type(self)(place + self.text)

    def __str__(self) -> str:
        return said(self.text)


class StudyError(InputError):
    """A study file is not usable; the message names the file and the key."""


def _spelt(match: re.Match[str], spelling: Spelling) -> str:
    name, value = match["name"], match["value"]
    if value is None:
        return spelling(Argument(name))
    if rows := _SLICE.fullmatch(value):
        ends = (int(end) if end.isdecimal() else end for end in rows.groups())
        return spelling(Argument(name, slice(*(None if end == "None" else end for end in ends))))
    try:
        return spelling(Argument(name, ast.literal_eval(value)))
    except (SyntaxError, ValueError):
        return match[0]  # backticks that somebody else wrote
