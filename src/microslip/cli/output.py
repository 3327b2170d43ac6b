"""Output of a command: where a result is written, and how it is printed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from microslip.cli.group import echo_json
from microslip.cli.options import JSON, Command, Decorator, output_option, switch

if TYPE_CHECKING:
    from microslip.report.document import Document

FIGURES = (
    switch("--png", "Also write PNG."),
    switch("--pdf", "Also write PDF."),
)


class Output(NamedTuple):
    """Output options of a command."""

    folder: Path | None
    overwrite: bool
    as_json: bool
    kinds: tuple[str, ...]
    """Formats of the figures."""

    @contextmanager
    def staged(self, kind: str, noun: str) -> Iterator[Path | None]:
        """The folder while it is written, None without one; entered before anything is computed."""
        if self.folder is None:
            yield None
            return
        from microslip.report.folder import staged

        with staged(self.folder, self.overwrite, kind, noun) as stage:
            yield stage

    def tell(self, document: Document, *, full: bool = False, hint: str = "") -> None:
        """Print a result: as JSON, or its tables and where its files are."""
        if self.as_json:
            echo_json(document.data)
            return
        from microslip.report.terminal import show

        show(document, sys.stdout, full=full)
        if hint:
            click.echo(hint)
        if self.folder is not None:
            click.echo(f"{len(document.data['files'])} files in {self.folder}")


def writes(folder: str, earlier: str = "result", *between: Decorator) -> Decorator:
    """Give a command the options of what it writes, as one argument, `output`.

    ``folder`` is the help of the first of them; ``between`` are options that stand before the last.
    """

    def decorate(command: Command) -> Command:
        @wraps(command)
        def write(
            folder: Path | None, overwrite: bool, as_json: bool,
            png: bool = False, pdf: bool = False, **arguments: Any,
        ) -> Any:  # fmt: skip
            kinds = ("svg", *["png"] * png, *["pdf"] * pdf)
            return command(output=Output(folder, overwrite, as_json, kinds), **arguments)

        decorated = JSON(write)
        for option in reversed(between):
            decorated = option(decorated)
        overwriting = switch("--overwrite", f"Replace an earlier {earlier} in that folder.")
        return output_option(folder)(overwriting(decorated))

    return decorate
