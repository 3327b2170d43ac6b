"""What a result says, once: every renderer tells the same document."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from microslip._core.verdicts import Verdict, worst
from microslip.report.plot import Plot


class Judged(NamedTuple):
    """A cell that is a verdict: its word, and what is said of it."""

    word: str
    text: str


Value = float | int | str | bool | Judged | None
Write = Callable[[Any], str]


@dataclass(frozen=True)
class Column:
    """One column of a table: values in SI, each told with the prefix that suits it.

    Parameters
    ----------
    key : str
        Name for programs, such as "dissipated_energy".
    label : str
        Heading on a page, such as "Energy per cycle".
    unit : str, optional
        SI unit of the values; "" for a number without one, None for text.
    digits : int, optional
        Significant digits for people; files hold all of them.
    write : callable, optional
        How a value is written for people where unit and digits do not say it; see
        :mod:`microslip.report.cells`.
    short : str, optional
        Heading on a terminal; by default the label.
    brief : bool, optional
        Whether a terminal shows it.
    """

    key: str
    label: str
    unit: str | None = None
    digits: int = 4
    write: Write | None = None
    short: str = ""
    brief: bool = True


@dataclass(frozen=True)
class Table:
    """Rows of plain values under columns; columns of which nothing is known are not shown.

    Parameters
    ----------
    title : str
        What stands above it; a section's only table needs none on a page.
    columns : tuple of Column
        Its columns; the first ``keys`` of them say what a row is about.
    rows : tuple of tuple
        Plain values in SI, None where something is not known.
    keys : int, optional
        How many of the first columns are repeated where a terminal is too narrow.
    most : int, optional
        Rows for people, spread evenly with the first and the last; files hold all of them.
    caption : str, optional
        A paragraph below it on a page.
    brief : bool, optional
        Whether a terminal shows it.
    noun : str, optional
        What a row is about, in the plural, where rows are left out.
    few : tuple of int, optional
        Places of the rows that a terminal shows, if not all.
    """

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Value, ...], ...]
    keys: int = 1
    most: int = 60
    caption: str = ""
    brief: bool = True
    noun: str = "rows"
    few: tuple[int, ...] = ()


@dataclass(frozen=True)
class Facts:
    """What is said of one thing, name by name: a material, a file, a rig."""

    title: str
    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Picture:
    """A figure that is made only when a renderer wants it.

    Parameters
    ----------
    name : str
        Stem of its files.
    caption : str
        What to see in it, in a sentence or two.
    plot : callable
        Says the figure as data.
    alternative : str
        What it is, for those who cannot see it.
    """

    name: str
    caption: str
    plot: Callable[[], Plot]
    alternative: str = ""


@dataclass(frozen=True)
class Verdicts:
    """Assumptions held to their limits, and where.

    Parameters
    ----------
    verdicts : tuple of Verdict
        In the order of reading; several of one name are told as one.
    places : tuple of str, optional
        Where each of them is so, such as "5 kN"; empty, or an empty text, for everywhere.
    percent : frozenset of str, optional
        Names whose values stand in percent.
    noun : str, optional
        What the places are, in the plural.
    caption : str, optional
        A paragraph below them on a page.
    none : str, optional
        What to say where there are no verdicts at all.
    short : bool, optional
        Whether a terminal counts those that are ok, and leaves out what the others assume.
    """

    verdicts: tuple[Verdict, ...]
    places: tuple[str, ...] = ()
    percent: frozenset[str] = frozenset()
    noun: str = "loads"
    caption: str = ""
    none: str = "No limits are known for this law."
    short: bool = False


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


class Number(NamedTuple):
    """The number of a result: what it is, its value and its band, as people read them."""

    name: str
    value: str
    band: str = ""


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
        The plain values of summary.json in SI units: what :func:`header` begins, and the numbers.
    remarks : tuple of str, optional
        What must be read with the answer.
    number : Number, optional
        The one that a page shows first.
    figure : str, optional
        Name of the picture that a page shows first.
    """

    kind: str
    title: str
    answer: str
    sections: tuple[Section, ...]
    data: Mapping[str, Any] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    number: Number | None = None
    figure: str = ""

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
        """What is judged in it."""
        return tuple(block for block in self.blocks() if isinstance(block, Verdicts))

    @property
    def word(self) -> str:
        """The worst word of its verdicts; "not judged" where nothing is, and "" without rules."""
        if not self.verdicts:
            return ""
        return worst(verdict for block in self.verdicts for verdict in block.verdicts)
