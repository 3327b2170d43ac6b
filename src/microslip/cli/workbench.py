"""Back end of the workbench: file previews in separate processes, and forms of the commands.

Previews use the options of the commands: ``python -m microslip.cli.workbench record FILE``. They
print JSON.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from microslip._core.errors import InputError
from microslip.app.jobs import LONGEST_TEXT, LOOK, MANIFEST_NAME, Field
from microslip.cli.options import CommandOption, in_options, offers
from microslip.cli.records import Reading, reads
from microslip.surfaces import options as offered

_MOST = 200
"""Columns of a file that the form lists."""


@click.group()
def look() -> None:
    """Preview a file."""


@look.command("record")
@click.argument("path")
@reads
def look_at_record(path: str, reading: Reading) -> None:
    """Preview a record."""
    from microslip.app.preview import record_view

    _print_json({**record_view(reading.read(path), _message), "columns": _columns()})


@look.command("scan")
@click.argument("path")
@offers(offered.AUTOMATIC_LEVEL, *offered.READING)
def look_at_scan(
    path: str, level: str | None, valid: tuple[float, float] | None, **options: Any
) -> None:
    """Preview a scan."""
    from microslip.app.preview import scan_view
    from microslip.surfaces import Scan

    single = {
        name: value[0] if isinstance(value, tuple) and len(value) == 1 else value
        for name, value in options.items()
    }
    _print_json(scan_view(Scan.read(path, valid=valid, **single), level))


def _print_json(values: dict[str, Any]) -> None:
    json.dump(values, sys.stdout)


def run_preview() -> None:
    """Run the command ``record`` or ``scan``, which prints a preview of a file as JSON.

    Errors are also printed as JSON, with the message under the key ``error``.
    """
    try:
        look(standalone_mode=False)
    except click.ClickException as error:
        _print_json({"error": error.format_message()})
    except InputError as error:
        _print_json({"error": _message(error), "columns": _columns()})
    except (OSError, ValueError, TypeError, KeyError, MemoryError) as error:
        _print_json({"error": f"{type(error).__name__}: {error}"[:500]})


def _columns() -> list[str]:
    from microslip.readers.files import POINTS, reading
    from microslip.readers.table_files import read_table
    from microslip.readers.tables import understood

    kind, path = sys.argv[1], Path(sys.argv[-1])
    try:
        with reading(path, "a record", POINTS, path.name):
            columns = understood(read_table(path, "a record").columns) if kind == "record" else []
    except (InputError, OSError, ValueError):
        return []
    counts = Counter(column.heading for column in columns)
    is_plain = [counts[c.heading] == 1 and len(c.heading) <= LONGEST_TEXT for c in columns[:_MOST]]
    return [c.heading if is_plain[i] else f"#{i + 1}" for i, c in enumerate(columns[:_MOST])]


def _message(error: InputError) -> str:
    """Return the message of an error, with Python arguments replaced by options of the command."""
    command = look.commands[sys.argv[1]]
    return in_options(error.text, command)


if __name__ == "__main__":
    run_preview()


COMMANDS = ("measure", "identify", "surface", "predict")

# The workbench chooses output folders, and studies and manifests must not name files there.
_NOT_OFFERED = ("folder", "overwrite", "as_json", "overrides", "version", "help")
_USUAL = {
    *Reading._fields[:6], "units", "rig_stiffness", "study", MANIFEST_NAME,
    "cutoff", "long_cutoff", "level", "unit", "pixel",
}  # fmt: skip


def forms(commands: Mapping[str, click.Command]) -> dict[str, tuple[Field, ...]]:
    """Return the fields of each command offered by the workbench, and of the file previews."""
    looks = {f"{LOOK} {command.name}": command for command in (look_at_record, look_at_scan)}
    offered = {name: commands[name] for name in COMMANDS} | looks
    looked = {
        name: {
            param.name for param in (look_at_scan if name == "surface" else look_at_record).params
        }
        for name in offered
    }
    return {
        name: tuple(
            _field(param, param.name in looked[name])
            for param in command.params
            if isinstance(param, click.Option) and param.name not in _NOT_OFFERED
        )
        for name, command in offered.items()
    }


def _field(param: click.Option, looks: bool) -> Field:
    declared = param.option if isinstance(param, CommandOption) else None
    name = next(text for text in param.opts if text.startswith("--")).removeprefix("--")
    choices: tuple[str, ...] = ()
    if isinstance(param.type, click.Choice):
        choices = tuple(map(str, param.type.choices))
    elif declared is not None and declared.choices:
        choices = (*declared.choices, declared.none) if declared.none else declared.choices
    kind = "flag" if param.is_flag else "choice" if choices else "text"
    if param.metavar == "COLUMN":
        kind, choices = "column", ("none",) if param.name in ("time", "normal_load") else ()
    if isinstance(param.type, click.Path):
        kind = "file" if param.name == MANIFEST_NAME else "study"
    usual = "" if param.default is None or callable(param.default) else str(param.default)
    example = declared.example_text if declared is not None else ""
    return Field(
        name,
        declared.heading if declared and declared.label else name.replace("-", " ").capitalize(),
        param.help or "",
        kind,
        choices,
        param.multiple,
        param.nargs,
        usual if isinstance(param.default, (str, int, float)) else example or param.metavar or "",
        looks,
        param.name in _USUAL,
    )
