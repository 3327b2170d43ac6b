"""Completion of commands, options, studies, keys and metals in a shell."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

import click
from click.shell_completion import (
    BashComplete,
    CompletionItem,
    FishComplete,
    ZshComplete,
    split_arg_string,
)

from microslip.cli.group import OneOf

SHELLS = {
    "bash": ('eval "$(microslip completion bash)"', "~/.bashrc (bash 4.4 or newer)"),
    "zsh": ('eval "$(microslip completion zsh)"', "~/.zshrc, below compinit"),
    "fish": ("microslip completion fish | source", "~/.config/fish/config.fish"),
}
"""For each shell, the line that turns completion on, and where it goes."""

_CLASSES = {"bash": BashComplete, "zsh": ZshComplete, "fish": FishComplete}


@click.command(short_help="Print the completion script of a shell.")
@click.argument("shell", type=OneOf(tuple(SHELLS)), metavar="SHELL")
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the completion of commands, studies and metals for SHELL: bash, zsh or fish.

    The last lines say where to put it.
    """
    kind = _CLASSES[shell]
    completer = kind(context.find_root().command, {}, "microslip", "_MICROSLIP_COMPLETE")
    line, file = SHELLS[shell]
    # Not by source(), which first looks for a new enough bash here; the shell may be elsewhere.
    script = completer.source_template % completer.source_vars()
    # Last, where it is seen, and where zsh does not mind.
    click.echo(f"{script}\n# For completion in every shell, put into {file}:\n#   {line}")


def complete_study(
    context: click.Context, parameter: click.Parameter, begun: str
) -> list[CompletionItem]:
    """Study files whose names begin so; if there are none, what the shell finds itself."""
    folder, slash, start = begun.rpartition("/")
    try:
        names = sorted(
            f"{folder}{slash}{path.name}"
            for path in Path(folder + slash or ".").iterdir()
            if path.suffix == ".toml" and path.name.startswith(start)
        )
    except (OSError, ValueError):
        names = []
    return [CompletionItem(name) for name in names] or [CompletionItem(begun, type="file")]


def complete_key(
    context: click.Context, parameter: click.Parameter, begun: str
) -> list[CompletionItem]:
    """Keys of the study that the command is about."""
    if "=" in begun:
        return []
    # An option without its value leaves click with no parameters yet, but there are the words.
    words = split_arg_string(os.environ.get("COMP_WORDS", ""))
    named = [word for word in words if word.endswith(".toml")]
    try:
        if context.info_name == "demo":
            from microslip.study.new import demo_text

            text = demo_text()
        else:
            text = Path(named[0]).read_text(encoding="utf-8")
        keys = _keys(tomllib.loads(text))
    except (IndexError, OSError, ValueError, RecursionError):
        return []
    return [CompletionItem(f"{key}=") for key in keys if key.startswith(begun)]


def _keys(table: dict[str, Any], path: str = "") -> list[str]:
    keys: list[str] = []
    for key, value in table.items():
        keys += _keys(value, f"{path}{key}.") if isinstance(value, dict) else [f"{path}{key}"]
    return keys


def complete_metal(
    context: click.Context, parameter: click.Parameter, begun: str
) -> list[CompletionItem]:
    """Metals whose names begin so."""
    from microslip.materials import metals

    return [
        CompletionItem(metal.name, help=metal.description)
        for metal in metals().values()
        if metal.name.startswith(begun)
    ]
