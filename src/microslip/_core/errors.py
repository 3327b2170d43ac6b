"""Errors about wrong input.

A message is plain text in which the arguments of a function stand between backticks, alone or with
a value to write: "`normal_load` must be above zero", "give `start=...`". The text of an error has
no backticks; a command writes the arguments that are options of its own as such, see
:func:`microslip.cli.options.in_options`.
"""

from __future__ import annotations

from typing import Self


class InputError(ValueError):
    """Input that cannot be used; the message says what was given and what is accepted.

    Parameters
    ----------
    text : str
        Message with its arguments between backticks, which `str` of the error leaves out.
    """

    @property
    def text(self) -> str:
        """Message with its arguments between backticks."""
        return "".join(map(str, self.args))

    @property
    def argument(self) -> str | None:
        """Name of the argument with which the message begins, or None."""
        before, *parts = self.text.split("`", 2)
        return parts[0].partition("=")[0] if len(parts) == 2 and not before else None

    @property
    def statement(self) -> str:
        """Message without the argument with which it begins."""
        return self.text.split("`", 2)[2].strip() if self.argument else self.text

    def within(self, place: str) -> Self:
        """Return the error with a place before its message, such as a file and ": "."""
        return type(self)(place + self.text)

    def __str__(self) -> str:
        return self.text.replace("`", "")


class StudyError(InputError):
    """A study file that cannot be used; the message names the file and the key."""
