"""Output of a document as text and tables, to a terminal or a pipe."""

from __future__ import annotations

import os
from collections.abc import Container, Iterable, Sequence
from functools import singledispatch
from typing import Any, TextIO

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table as Grid
from rich.text import Text

from microslip.report.cells import NO_LIMITS, as_text, judgements
from microslip.report.document import Block, Document, Items, Note, Table, Verdicts

# ASCII replacements for terminals and encodings without these characters. The Greek mu denotes the
# friction coefficient, the micro sign a prefix.
_PLAIN = str.maketrans(
    {
        "\N{MICRO SIGN}": "u",
        "\N{GREEK SMALL LETTER MU}": "mu ",
        "α": "alpha",
        "±": "+/-",
        "η": "eta",
        "ζ": "zeta",
        "ν": "nu",
        "Σ": "sum ",
        "π": " pi ",
        "²": "^2",
        "ₜ": "_t",
        "–": "-",
        "−": "-",
        "×": "*",
        "’": "'",
        "κ": "kappa",
        "…": "...",
    }
)
# Names of files and records may contain terminal control characters.
_CONTROLS = {code: f"\\x{code:02x}" for code in (*range(32), *range(127, 160)) if code != 10}
_WORD_STYLE = {"ok": "green", "watch": "yellow", "outside": "bold red"}
_WIDE = 10_000


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Raise the error of a broken pipe to the caller; rich would exit with status 1."""
        raise  # the error that rich is handling when it calls this


class Printer:
    """Printer to one stream: in colour on a terminal, plain text in a pipe.

    A stream of None, the standard output of a process without one, discards all output.
    """

    def __init__(self, stream: TextIO | None) -> None:
        if stream is None:
            stream = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
        self._encoding = getattr(stream, "encoding", None) or "utf-8"
        # By the same rule rich draws the lines of tables in ASCII.
        self._ascii = not self._encoding.lower().startswith("utf")
        # Numbers and paths are never folded or cut, and a pipe has no width limit.
        self._wide = self._narrow = _console(stream, _WIDE)
        if _is_terminal(stream):
            self._narrow = _console(stream, None)

    @property
    def width(self) -> int:
        """Number of columns of the terminal; a large number in a pipe."""
        return self._narrow.width

    def _fit(self, text: str) -> str:
        text = text.translate(_CONTROLS)
        if self._ascii:
            text = text.translate(_PLAIN)
        return text.encode(self._encoding, "replace").decode(self._encoding)

    def line(self, text: str = "", style: str = "") -> None:
        """Print text, folded between words to the width of the terminal."""
        self._narrow.print(Text(self._fit(text), style=style))

    def path(self, text: str) -> None:
        """Print text that must not be folded, such as a path."""
        self._wide.print(Text(self._fit(text)), soft_wrap=True)

    def hanging(self, head: str, text: str, indent: int, style: str = "") -> None:
        """Print a heading and text after it, folded with a hanging indent."""
        # On a very narrow terminal the terminal itself folds the lines.
        room = self.width - indent
        block = Text(self._fit(text))
        lines = block.wrap(self._narrow, room) if room >= 20 else [block]
        for number, line in enumerate(lines):
            begun = Text(self._fit(head if number == 0 else "").ljust(indent), style=style)
            line.rstrip()
            self._narrow.print(Text.assemble(begun, line))

    def verdict(self, word: str, text: str) -> None:
        """Print one line of the validity section."""
        self.hanging(f"  {word}", text, max(10, len(word) + 3), _WORD_STYLE.get(word, ""))

    def table(
        self,
        title: str,
        head: Sequence[str],
        rows: Iterable[Sequence[str]],
        keys: int = 1,
        text: Container[int] = (),
    ) -> None:
        """Print a table; if it is too wide, in parts that repeat the first ``keys`` columns.

        ``text`` are the indices of columns that contain text.
        """
        rows = [[self._fit(cell) for cell in row] for row in rows]
        if title:
            self.line(title, style="bold")
        columns = list(range(keys, len(head)))
        while columns:
            count = len(columns)
            table = self._build(head, rows, [*range(keys), *columns], text)
            # Text may be folded, numbers may not.
            widest = max((cell_len(row[columns[-1]]) for row in rows), default=0)
            fold = columns[-1] in text and 0 < self._excess(table) < 0.4 * widest
            while count > 1 and not fold and self._excess(table) > 0:
                count -= 1
                table = self._build(head, rows, [*range(keys), *columns[:count]], text)
            if fold or (count == 1 and columns[0] in text and self._excess(table) > 0):
                table.columns[-1].no_wrap = False
                self._narrow.print(table)
            else:
                self._print_wide(table)
            self.line()
            columns = columns[count:]

    def _print_wide(self, table: Grid) -> None:
        if self._wide is not self._narrow:
            self._wide.print(table)
            return
        # No trailing blanks in a pipe.
        with self._wide.capture() as printed:
            self._wide.print(table)
        for line in printed.get().splitlines():  # colours and cells are already formatted
            self._wide.print(Text(line.rstrip()), soft_wrap=True)

    def _build(
        self,
        head: Sequence[str],
        rows: Sequence[Sequence[str]],
        columns: list[int],
        text: Container[int],
    ) -> Grid:
        table = Grid(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="")
        table.show_header = any(head)
        for column in columns:
            table.add_column(
                Text(self._fit(head[column]), style="cyan"),
                justify="left" if column in text else "right",
                no_wrap=True,
                overflow="fold",
            )
        for row in rows:
            table.add_row(*(Text(row[column]) for column in columns))
        return table

    def _excess(self, table: Grid) -> int:
        """Return the number of columns by which a table is wider than the terminal."""
        return Measurement.get(self._wide, self._wide.options, table).maximum - self.width


def _console(stream: TextIO, width: int | None) -> Console:
    # NO_COLOR disables all escape sequences, including bold text.
    plain: dict[str, Any] = {"color_system": None} if os.environ.get("NO_COLOR") else {}
    return _Console(file=stream, width=width, highlight=False, markup=False, emoji=False, **plain)


def _is_terminal(stream: TextIO) -> bool:
    try:
        return stream.isatty()
    except (AttributeError, ValueError):
        return False


MOST_ROWS = 40


def print_document(document: Document, stream: TextIO | None, *, full: bool = False) -> None:
    """Print the brief parts of a document, or all of it."""
    out = Printer(stream)
    out.line(document.title, style="bold")
    if document.answer:
        out.line(document.answer)
    for remark in document.remarks:
        out.verdict("watch", remark)
    out.line()
    for section in document.sections:
        if section.brief or full:
            for block in section.blocks:
                _print(block, out, section.title, full)


def show_command(text: str, command: str, stream: TextIO | None) -> None:
    """Print the next command to run."""
    out = Printer(stream)
    out.line(text)
    out.path(f"  {command}")


@singledispatch
def _print(block: Block, out: Printer, title: str, full: bool) -> None:
    """Print a block of a document; blocks for the page only are skipped."""


@_print.register
def _(block: Table, out: Printer, title: str, full: bool) -> None:
    count = block.data.sizes["row"]
    if not (block.brief or full) or not count:
        return
    table = as_text(block, MOST_ROWS, brief=not full)
    remark = ""
    if table.left_out:
        remark = f" ({count - table.left_out} of {count} {block.noun}; all in summary.json)"
    out.table(
        (block.title or title) + remark,
        table.heads,
        table.rows,
        keys=min(block.keys, len(table.heads) - 1),
        text=table.words,
    )


@_print.register
def _(block: Note, out: Printer, title: str, full: bool) -> None:
    if block.brief or full:
        out.line(block.text)
        out.line()


@_print.register
def _(block: Items, out: Printer, title: str, full: bool) -> None:
    for text in block.texts:
        out.line(text)
    if block.texts:
        out.line()


@_print.register
def _(block: Verdicts, out: Printer, title: str, full: bool) -> None:
    out.line(title, style="bold")
    judged, short = judgements(block), block.short and not full
    fine = [judgement.name for judgement in judged if judgement.word == "ok"]
    for judgement in judged:
        where = f" {judgement.where}" if judgement.where else ""
        if judgement.word == "not judged":
            missing = f": {judgement.reason}" if judgement.reason else ""
            out.verdict(judgement.word, f"{judgement.name}{where}{missing}")
        elif judgement.word != "ok":
            value = f"{judgement.value} (ok {judgement.bound})"
            assumed = "" if short else f" – assumption: {judgement.meaning}"
            out.verdict(judgement.word, f"{judgement.name}{where}: {value}{assumed}")
    if fine:
        out.verdict("ok", f"{len(fine)} others" if short else "; ".join(fine))
    if not judged:
        out.line(f"  {NO_LIMITS}")
    out.line()
