"""Errors of invalid input.

In a message, arguments of a function are in backticks, with or without a value: "`normal_load` must
be above zero", "write `start=...`". ``str(error)`` removes the backticks; a command replaces
arguments by its options, see :func:`microslip.cli.options.in_options`.
"""

from __future__ import annotations

from typing import Self


class InputError(ValueError):
    """Invalid input; the message states the value received and what is accepted.

    Parameters
    ----------
    text : str
        Message with names of arguments in backticks, which ``str(error)`` removes.
    """

    @property
    def text(self) -> str:
        """Message with names of arguments in backticks."""
        return "".join(map(str, self.args))

    @property
    def argument(self) -> str | None:
        """Name of the argument at the beginning of the message, or None."""
        before, *parts = self.text.split("`", 2)
        return parts[0].partition("=")[0] if len(parts) == 2 and not before else None

    @property
    def statement(self) -> str:
        """Message without the argument at its beginning."""
        return self.text.split("`", 2)[2].strip() if self.argument else self.text

    def within(self, place: str) -> Self:
        """Return the error with ``place`` before its message, such as a file name and ": "."""
        return type(self)(place + self.text)

    def __str__(self) -> str:
        return self.text.replace("`", "")


class StudyError(InputError):
    """Invalid study file; the message names the file and the key."""
