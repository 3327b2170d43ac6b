"""What every reader of records gives: the columns of a file, none of them read yet."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, NamedTuple

from microslip._core.checks import Floats

MAX_SAMPLES = 500_000_000
"""Most samples of one column; four columns of them are 16 GB."""


class Column(NamedTuple):
    """One column, channel, variable or data set."""

    name: str
    """As the file says, with its unit where it stands there; "" if the file gives none."""

    unit: str | None = None
    """As the file says."""

    size: int | None = None
    """Samples, where that is known before they are read."""

    rate: float | None = None
    """Sample rate [Hz] of this column, as the file says."""

    short: str | None = None
    """Name without the groups or structs that it is in, where there are any."""


class Stated(NamedTuple):
    """A number that the file states for the whole record."""

    value: float
    """In SI units."""

    where: str
    """How the file calls it."""


@dataclass(frozen=True)
class Table:
    """The columns of one file.

    Parameters
    ----------
    kind : str
        What the file is and how it was understood, for the notes.
    columns : tuple of Column
        In the order of the file.
    load : callable
        Values of the columns at these places, as fresh arrays.
    where : callable
        What a person calls the row of this index, such as "line 12".
    stated : mapping
        Numbers that the file states besides: "sample_rate" [Hz], "frequency" [Hz],
        "normal_load" [N].
    """

    kind: str
    columns: tuple[Column, ...]
    load: Callable[[Sequence[int]], list[Floats]]
    where: Callable[[int], str] = lambda row: f"sample {row}"
    stated: Mapping[str, Stated] = field(default_factory=dict)


class Reader(ABC):
    """One kind of file."""

    name: ClassVar[str]
    """What ``format=`` calls it."""

    @abstractmethod
    def knows(self, head: bytes, suffix: str) -> bool:
        """Whether a file that begins so is of this kind."""

    @abstractmethod
    def open(self, path: Path) -> Table:
        """The columns of a file.

        Raises
        ------
        ValueError
            If it cannot be used; the message says what is wrong, and not the file.
        """


def first_line(error: BaseException) -> str:
    """What a library says, on one line."""
    from microslip._core.wording import shorten

    lines = str(error).strip().splitlines()
    return shorten(lines[0], 200) if lines else type(error).__name__
