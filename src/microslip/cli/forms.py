"""Forms of the workbench, made from the options of the commands that it runs."""

from __future__ import annotations

from collections.abc import Mapping

import click

from microslip.app.jobs import LOOK, Field
from microslip.cli.look import record, scan
from microslip.cli.options import CommandOption
from microslip.cli.records import Reading

COMMANDS = ("measure", "identify", "surface", "predict")

# Where results go is the workbench's affair, and neither a study nor a manifest names a file there.
_NOT_OFFERED = {
    *("folder", "overwrite", "as_json", "overrides", "version", "help"),
    *("manifest", "group", "over"),
}
_USUAL = {
    *Reading._fields[:6], "units", "rig_stiffness", "study", "model", "laws", "accept_unconverged",
    "cutoff", "long_cutoff", "level", "outliers", "fill", "unit", "pixel",
}  # fmt: skip


def forms(commands: Mapping[str, click.Command]) -> dict[str, tuple[Field, ...]]:
    """Fields of each command that the workbench offers, and of its looks into files."""
    looks = {f"{LOOK} {command.name}": command for command in (record, scan)}
    offered = {name: commands[name] for name in COMMANDS} | looks
    looked = {
        name: {param.name for param in (scan if name == "surface" else record).params}
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
        choices = (*declared.choices, *(declared.none,) * bool(declared.none))
    kind = "flag" if param.is_flag else "choice" if choices else "text"
    if isinstance(param.type, click.Path):
        kind = "study"
    elif declared is not None and declared.names_file:
        kind = "file"
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
