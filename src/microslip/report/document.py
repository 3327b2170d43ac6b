"""What a result says, once: every renderer tells the same document."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from microslip._core.verdicts import Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = float | int | str | bool | None


@dataclass(frozen=True)
class Column:
    """One column of a table: its values in SI, told with the unit that suits each of them.

    Parameters
    ----------
    key : str
        Name in JSON and CSV, such as "dissipated_energy".
    label : str
        Heading for people, such as "E_d".
    unit : str, optional
        SI unit of the values; "" for a number without one, None for text.
    digits : int, optional
        Significant digits for people; files hold all of them.
    meaning : str, optional
        What the heading stands for, where it needs a word.
    """

    key: str
    label: str
    unit: str | None = None
    digits: int = 4
    meaning: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of plain values under columns.

    Parameters
    ----------
    title : str
        What stands above it.
    columns : tuple of Column
        Its columns; the first ``keys`` of them say what a row is about.
    rows : tuple of tuple
        Plain values in SI, None where something is not known.
    keys : int, optional
        How many of the first columns are repeated where a terminal is too narrow.
    most : int, optional
        Rows for people, spread evenly with the first and the last; files hold all of them.
    """

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    keys: int = 1
    most: int = 60


@dataclass(frozen=True)
class Picture:
    """A figure that is drawn only when a renderer wants it.

    Parameters
    ----------
    name : str
        Stem of its files.
    caption : str
        What it shows, in a sentence or two.
    draw : callable
        Makes the Matplotlib figure.
    """

    name: str
    caption: str
    draw: Callable[[], Figure]


@dataclass(frozen=True)
class Verdicts:
    """Assumptions held to their limits, and where."""

    title: str
    verdicts: tuple[Verdict, ...]
    places: tuple[str, ...] = ()
    """Where each of them is so, such as "at 5 kN"; empty for everywhere."""


@dataclass(frozen=True)
class Note:
    """A paragraph of text, such as a caveat or a remedy."""

    text: str


Block = Table | Picture | Verdicts | Note


@dataclass(frozen=True)
class Section:
    """A part of a document; ``brief`` ones are what a terminal prints."""

    title: str
    blocks: tuple[Block, ...]
    brief: bool = True


@dataclass(frozen=True)
class Document:
    """A whole result for people and for programs.

    Parameters
    ----------
    kind : str
        What summary.json says it is, such as "microslip-measurement".
    title : str
        Its name.
    answer : str
        The result in one sentence with its number.
    sections : tuple of Section
        What follows, in the order of reading.
    data : mapping
        The plain values of summary.json, in SI units.
    """

    kind: str
    title: str
    answer: str
    sections: tuple[Section, ...]
    data: Mapping[str, Any] = field(default_factory=dict)
