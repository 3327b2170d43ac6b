"""A document on a terminal, so that it can be read at a glance."""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from pathlib import Path
from typing import TextIO

from microslip._core.wording import shorten
from microslip.report.document import (
    Block,
    Document,
    Facts,
    Items,
    Note,
    Table,
    Verdicts,
)
from microslip.report.printer import Printer
from microslip.report.tables import as_text, is_text, judgements

MOST_ROWS = 40


def show(document: Document, stream: TextIO | None, *, full: bool = False) -> None:
    """Print what is brief in a document, or all of it."""
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
    """Print what to type next."""
    out = Printer(stream)
    out.line(text)
    out.path(f"  {command}")


def show_files(names: Sequence[str], folder: Path, stream: TextIO | None) -> None:
    """Print what was written: files by what they are for; a figure once, whatever its formats."""
    out = Printer(stream)
    out.path(f"Written to {shorten(str(folder), 1000)}:")
    for head, group in file_groups(names).items():
        out.words(f"  {head}", group, 11)


def file_groups(names: Sequence[str]) -> dict[str, list[str]]:
    """Files by what they are for, in the order of interest; figures without their endings."""
    split = [name.rpartition(".") for name in names if name.endswith((".svg", ".png", ".pdf"))]
    figures = list(dict.fromkeys(stem for stem, _, _ in split))
    kinds = ", ".join(dict.fromkeys(f".{kind}" for _, _, kind in split))
    groups = {
        "report": [name for name in names if name.endswith(".html")],
        "figures": [*figures, f"({kinds})"] if figures else [],
        "tables": [name for name in names if name.endswith((".nc", ".csv"))],
        "summary": [name for name in names if name.endswith(".json")],
        "study": [name for name in names if name.endswith(".toml")],
    }
    return {head: group for head, group in groups.items() if group}


@singledispatch
def _print(block: Block, out: Printer, title: str, full: bool) -> None:
    """Pictures, listings and markup are for the page."""


@_print.register
def _(block: Table, out: Printer, title: str, full: bool) -> None:
    if not (block.brief or full) or not block.rows:
        return
    table = as_text(block, MOST_ROWS, brief=not full)
    count = len(block.rows)
    remark = ""
    if table.left_out:
        remark = f" ({count - table.left_out} of {count} {block.noun}; all are in summary.json)"
    out.table(
        (block.title or title) + remark,
        [column.short or column.label for column in table.columns],
        table.rows,
        keys=min(block.keys, len(table.columns) - 1),
        text=[i for i, column in enumerate(table.columns) if is_text(block, column)],
    )


@_print.register
def _(block: Facts, out: Printer, title: str, full: bool) -> None:
    out.table(block.title, ["", ""], block.rows, text=(0, 1))


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
            assumed = "" if short else f" – assumed: {judgement.meaning}"
            out.verdict(judgement.word, f"{judgement.name}{where}: {value}{assumed}")
    if fine:
        out.verdict("ok", f"{len(fine)} others" if short else "; ".join(fine))
    if not judged:
        out.line(f"  {block.none}")
    out.line()
