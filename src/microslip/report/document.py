"""Document of a result: every renderer writes the same content."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from microslip._core.checks import Progress
from microslip._core.verdicts import Verdict, worst
from microslip.figures.picture import Picture


class Judged(NamedTuple):
    """A cell that is a verdict: its word, and what is said of it."""

    word: str
    text: str


Value = float | int | str | bool | Judged | None
Write = Callable[[Any], str]


@dataclass(frozen=True)
class Column:
    """One column of a table: values in SI, each told with the prefix that suits it."""

    key: str  # name for programs, such as "dissipated_energy"
    label: str  # heading on a page, such as "Energy per cycle"
    unit: str | None = None  # SI unit of the values; "" for a number without one, None for text
    digits: int = 4  # significant digits for people; files hold all of them
    # How a value is written for people where unit and digits do not say it; see
    # :mod:`microslip.report.cells`.
    write: Write | None = None
    short: str = ""  # heading on a terminal; by default the label
    brief: bool = True  # whether a terminal shows it


@dataclass(frozen=True)
class Table:
    """Rows of plain values under columns; columns of which nothing is known are not shown."""

    title: str  # what stands above it; a section's only table needs none on a page
    columns: tuple[Column, ...]  # its columns; the first ``keys`` of them say what a row is about
    rows: tuple[tuple[Value, ...], ...]  # plain values in SI, None where something is not known
    keys: int = 1  # how many of the first columns are repeated where a terminal is too narrow
    most: int = 60
    """Rows for people, spread evenly with the first and the last; files hold all of them."""
    caption: str = ""  # a paragraph below it on a page
    brief: bool = True  # whether a terminal shows it
    noun: str = "rows"  # what a row is about, in the plural, where rows are left out
    few: tuple[int, ...] = ()  # places of the rows that a terminal shows, if not all


@dataclass(frozen=True)
class Facts:
    """Facts of one thing, name by name: a material, a file, a rig."""

    title: str
    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Verdicts:
    """Assumptions held to their limits, and where."""

    verdicts: tuple[Verdict, ...]  # in the order of reading; several of one name are told as one
    places: tuple[str, ...] = ()
    """Conditions under which each holds, such as "5 kN"; empty for all."""
    percent: frozenset[str] = frozenset()  # names whose values stand in percent
    caption: str = ""  # a paragraph below them on a page
    none: str = "No limits are known for this law."
    """Text where there are no verdicts."""
    short: bool = False
    """Whether a terminal counts those that are ok, and leaves out what the others assume."""


@dataclass(frozen=True)
class Note:
    """A paragraph of text, such as a caveat or a remedy; ``brief`` ones are for a terminal, too."""

    text: str
    small: bool = False
    brief: bool = True


@dataclass(frozen=True)
class Items:
    """Sentences below each other."""

    texts: tuple[str, ...]


@dataclass(frozen=True)
class Listing:
    """Text of a file, as it stands there."""

    text: str
    most: int = 20_000


@dataclass(frozen=True)
class Markup:
    """HTML that the program itself has made, such as equations in MathML; never a user's words."""

    html: str


Block = Table | Facts | Picture | Verdicts | Note | Items | Listing | Markup


@dataclass(frozen=True)
class Section:
    """A part of a document; ``brief`` ones are what a terminal prints."""

    title: str
    blocks: tuple[Block, ...]
    brief: bool = True


@dataclass(frozen=True)
class File:
    """One file of a result."""

    name: str  # in the folder
    write: Callable[[Path, Progress], object]
    """Writes it, given its path and what takes the share that is done."""
    cost: float = 1e-3  # seconds that it takes, more or less


class Headline(NamedTuple):
    """The number of a result: what it is, its value and its band, as people read them."""

    name: str
    value: str
    band: str = ""


@dataclass(frozen=True)
class Document:
    """A whole result for people and for programs."""

    kind: str  # what summary.json says it is, such as "microslip-measurement"
    title: str  # its name
    answer: str  # the result in one sentence with its number
    sections: tuple[Section, ...]  # what follows, in the order of reading
    data: Mapping[str, Any] = field(default_factory=dict)
    """The plain values of summary.json in SI units: what :func:`header` begins, and the numbers."""
    remarks: tuple[str, ...] = ()  # what must be read with the answer
    number: Headline | None = None  # the one that a page shows first
    figure: str = ""  # name of the picture that a page shows first
    files: tuple[File, ...] = ()  # tables, arrays and texts that go with it into a folder

    def blocks(self) -> Iterator[Block]:
        """All blocks, in the order of reading."""
        for section in self.sections:
            yield from section.blocks

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """Its figures."""
        return tuple(block for block in self.blocks() if isinstance(block, Picture))

    @property
    def verdicts(self) -> tuple[Verdicts, ...]:
        """Verdicts in the document."""
        return tuple(block for block in self.blocks() if isinstance(block, Verdicts))

    @property
    def word(self) -> str:
        """The worst word of its verdicts; "not judged" where nothing is, and "" without rules."""
        if not self.verdicts:
            return ""
        return worst(verdict for block in self.verdicts for verdict in block.verdicts)
