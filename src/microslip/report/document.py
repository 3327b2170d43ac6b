"""Document of a result: the common content of all output formats."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from microslip._core.dataset import DataSet
from microslip._core.verdicts import Verdict, worst
from microslip.figures.picture import Picture


@dataclass(frozen=True)
class Table:
    """Table of columns of a data set along "row"; columns without any value are not shown."""

    title: str  # heading; may be empty for the only table of a section
    data: DataSet  # the first ``keys`` columns identify a row
    names: tuple[str, ...] = ()  # columns shown, all by default
    keys: int = 1  # leading columns repeated if the terminal is too narrow
    most: int = 60
    """Most rows to show, evenly spaced including first and last; files contain all rows."""
    caption: str = ""  # paragraph below the table on a page
    brief: bool = True  # shown on a terminal
    noun: str = "rows"  # plural name of the rows, for the count of omitted rows
    few: tuple[int, ...] = ()  # indices of the rows shown on a terminal; empty for all
    hidden: tuple[str, ...] = ()  # columns not shown on a terminal


@dataclass(frozen=True)
class Verdicts:
    """Verdicts on the assumptions of a result, each with the load or amplitude it applies to."""

    verdicts: tuple[Verdict, ...]  # in reading order; verdicts of one name are merged
    places: tuple[str, ...] = ()
    """Condition of each verdict, such as "5 kN"; empty if there is only one."""
    percent: frozenset[str] = frozenset()  # names of values shown in percent
    caption: str = ""  # paragraph below the verdicts on a page
    short: bool = False
    """Whether a terminal only counts ok verdicts and omits assumptions."""


@dataclass(frozen=True)
class Note:
    """Paragraph such as a warning or a remedy; ``brief`` notes are also shown on a terminal."""

    text: str
    small: bool = False
    brief: bool = True


@dataclass(frozen=True)
class Items:
    """Sentences that are shown as a bulleted list on the page, and as lines on a terminal."""

    texts: tuple[str, ...]


Block = Table | Picture | Verdicts | Note | Items


@dataclass(frozen=True)
class Section:
    """Section of a document; ``brief`` sections are printed on a terminal."""

    title: str
    blocks: tuple[Block, ...]
    brief: bool = True


class File(NamedTuple):
    """File of a result: its name in the folder and the function that writes it to a path."""

    name: str
    write: Callable[[Path], object]


@dataclass(frozen=True)
class Document:
    """Content of a result, from which the page, terminal output and files are written."""

    title: str
    answer: str  # the result in one sentence with its number
    sections: tuple[Section, ...]  # in reading order
    data: Mapping[str, Any] = field(default_factory=dict)
    """Plain values of summary.json in SI units, starting with :func:`header`."""
    remarks: tuple[str, ...] = ()  # caveats shown next to the answer
    figure: str = ""  # name of the main figure, at the top of a page
    files: tuple[File, ...] = ()  # further files of the folder: tables, arrays, texts

    def blocks(self) -> Iterator[Block]:
        """Yield the blocks (tables, figures, notes and so on) of all sections in reading order."""
        for section in self.sections:
            yield from section.blocks

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """Figures among the blocks of the document."""
        return tuple(block for block in self.blocks() if isinstance(block, Picture))

    @property
    def verdicts(self) -> tuple[Verdicts, ...]:
        """Verdicts among the blocks of the document."""
        return tuple(block for block in self.blocks() if isinstance(block, Verdicts))

    @property
    def word(self) -> str:
        """Worst verdict; "not judged" if no assumption could be judged, "" if none applies."""
        if not self.verdicts:
            return ""
        return worst(verdict for block in self.verdicts for verdict in block.verdicts)
