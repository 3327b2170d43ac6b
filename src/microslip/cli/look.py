"""A look into a file before anything is computed: a process of its own, which answers in JSON.

It reads as the commands do, by the same options: ``python -m microslip.cli.look record FILE``.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import click

from microslip.cli.options import offers, spelling
from microslip.cli.records import Reading, reads
from microslip.errors import InputError
from microslip.scans import options as offered


@click.group()
def look() -> None:
    """Look into a file; the part to keep of it, if any, stands in the standard input."""


@look.command()
@click.argument("path")
@reads()
def record(path: str, reading: Reading) -> None:
    """Show the content of a record."""
    from microslip.app.preview import record_view, save_record

    read, part = reading.read(path), _part()
    _answer(record_view(read, _said) if part is None else save_record(read, **part))


@look.command()
@click.argument("path")
@offers(offered.LEVEL, *offered.READING)
def scan(path: str, level: str | None, valid: tuple[float, float] | None, **options: Any) -> None:
    """Show the content of a scan."""
    from microslip.app.preview import save_scan, scan_view
    from microslip.scans import Scan

    single = {
        name: value[0] if isinstance(value, tuple) and len(value) == 1 else value
        for name, value in options.items()
    }
    read, part = Scan.read(path, valid=valid, **single), _part()
    _answer(scan_view(read, level) if part is None else save_scan(read, **part))


def _part() -> dict[str, Any] | None:
    """The part to keep, and the file to write it into."""
    text = sys.stdin.read()
    question: dict[str, Any] | None = json.loads(text) if text.strip() else None
    return question


def _answer(values: dict[str, Any]) -> None:
    json.dump(values, sys.stdout)


def main() -> None:
    """Answer one question."""
    try:
        look(standalone_mode=False)
    except click.ClickException as error:
        _answer({"error": error.format_message()})
    except InputError as error:
        _answer({"error": _said(error)})
    except (OSError, ValueError, TypeError, KeyError, MemoryError) as error:
        _answer({"error": f"{type(error).__name__}: {error}"[:500]})


def _said(error: InputError) -> str:
    """An error as the command that was asked for spells its arguments."""
    command = look.commands[sys.argv[1]]
    return error.said(spelling(click.Context(command, info_name=command.name)))


if __name__ == "__main__":
    main()
