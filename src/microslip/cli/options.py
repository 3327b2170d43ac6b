"""Options of commands, made from the declarations of numbers and options in `microslip._core`.

Also their error messages, output and progress, and their interruption by signals.
"""

from __future__ import annotations

import logging
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import click

from microslip._core.errors import InputError
from microslip._core.options import Option
from microslip._core.units import Kind, QuantityError, to_si
from microslip.cli.group import OneOf, echo_json

if TYPE_CHECKING:
    from types import FrameType

    from microslip.report.document import Document

    _ParamType = click.ParamType[Any]
else:  # not generic before click 8.2
    _ParamType = click.ParamType

Command = Callable[..., Any]
Decorator = Callable[[Command], Command]

ANY_PATH = click.Path(path_type=Path, readable=False)
"""Path without checks by click; later checks give better messages."""


class _Value(_ParamType):
    """Option type for a number with a unit, converted to SI units."""

    def __init__(self, option: Option) -> None:
        self.option = option
        self.name = option.name

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        if param is not None and param.nargs > 1 and (value.startswith("--") or "," in value):
            what = self.option.metavar or "VALUE VALUE"
            raise click.UsageError(
                f"{param.opts[-1]} takes {param.nargs} values, {param.opts[-1]} {what}, separated "
                f"by a space, got {value!r} among them",
                ctx,
            )
        try:
            return self.option.read_text(value)
        except ValueError as error:
            flag = param.opts[-1] if param is not None else self.option.name
            raise click.UsageError(f"{flag}: {error}", ctx) from None


class CommandOption(click.Option):
    """Option of a click command, with the declaration that it was made from."""

    def __init__(self, *args: Any, option: Option, **extra: Any) -> None:
        super().__init__(*args, **extra)
        self.option = option


def click_option(flag: str, value: str, text: str, name: str = "", **settings: Any) -> Decorator:
    """Declare an option of one command by its flag, placeholder for the value, and help text."""
    names = [flag, name] if name else [flag]
    return click.option(*names, metavar=value, help=text, **settings)


def switch(flag: str, text: str, name: str = "") -> Decorator:
    """Declare an option of one command that takes no value."""
    return click.option(*[flag, name] if name else [flag], is_flag=True, help=text)


def output_option(
    text: str, value: str = "DIR", name: str = "folder", **settings: Any
) -> Decorator:
    """Declare the option for the path of the output."""
    names = ("-o", "--output", name)
    return click.option(*names, type=ANY_PATH, metavar=value, help=text, **settings)


def quantity(flag: str, text: str, kind: Kind, example: str) -> float:
    """Parse a value with its unit and return it in SI units; an error names the option."""
    try:
        return to_si(text, kind, example)
    except QuantityError as error:
        raise click.UsageError(f"{flag}: {error}") from None


JSON = switch("--json", "Print the summary as JSON, no tables.", "as_json")


def offers(*options: Option, **changes: Any) -> Decorator:
    """Return a decorator that adds declared options to a command, in this order."""

    def give(command: Command) -> Command:
        for option in reversed(options):
            command = click.option(
                f"--{flag(option)}",
                option.name,
                cls=CommandOption,
                option=option,
                **{**_settings(option), **changes},
            )(command)
        return command

    return give


def flag(option: Option) -> str:
    """Return the name of an option as on the command line, without the two dashes."""
    return option.flag or option.name.replace("_", "-")


def _settings(option: Option) -> dict[str, Any]:
    if option.kind is bool:
        return {"is_flag": True, "help": option.sentence}
    settings: dict[str, Any] = {"help": option.sentence}
    if option.required:
        settings["required"] = True
    elif option.default is not None:
        settings |= {"default": option.default, "show_default": True}
    if option.choices and not option.none:
        return {**settings, "type": OneOf(option.choices)}
    settings |= {"type": _Value(option), "metavar": option.metavar or "VALUE"}
    low, high = option.items
    if high > 1:
        settings |= (
            {"nargs": high}
            if low == high
            else {"multiple": True, "callback": lambda context, param, value: value or None}
        )
    return settings


_ARGUMENT = re.compile(
    r'`(\w+)(?:=(\{"\w+": )?'
    r'("[^"`]*"|\("[^`]*"\)|slice\(\w+, \w+\)|[-+.\d][^\s`}]*|True|False)\}?)?`'
)


_SLICE = re.compile(r"slice\((\w+), (\w+)\)")


def in_options(text: str, command: click.Command | None = None) -> str:
    """Replace Python arguments in backticks in a message by the options of a command.

    For example, rig_stiffness=2e8 becomes --rig-stiffness 2e8. Arguments whose value is neither a
    number nor text stay in Python form. By default the command is the one that runs.
    """
    context = click.get_current_context(silent=True)
    command = command or (context.command if context else None)
    options = {param.name: param for param in (command.params if command else ())}

    def write(match: re.Match[str]) -> str:
        name, key, value = match.groups()
        if cut := _SLICE.fullmatch(value or ""):
            first, last = cut.groups()
            value = f"{int(first) + 1 if first.isdigit() else first.upper()}..{last.upper()}"
        param = options.get(name)
        # A bare column role denotes its values, not the option that selects the column.
        if not isinstance(param, click.Option) or (not value and param.metavar == "COLUMN"):
            return match[0]
        if not value or param.is_flag:
            return param.opts[-1]
        between = " " if param.nargs > 1 else f" {param.opts[-1]} "
        words = "none" if value == "False" else value.strip("()").replace('", "', f'"{between}"')
        return f"{param.opts[-1]} {key[2:-3] + '=' if key else ''}{words}"

    return _ARGUMENT.sub(write, text).replace("`", "")


# -- output ----------------------------------------------------------------------------------------


FORMATS = (switch("--png", "Also write PNG."), switch("--pdf", "Also write PDF."))


class Output(NamedTuple):
    """Values of the options for output of a command."""

    folder: Path | None
    overwrite: bool
    as_json: bool
    kinds: tuple[str, ...]
    """Figure formats."""

    @contextmanager
    def staged(self, kind: str) -> Iterator[Path | None]:
        """Yield a temporary folder, which is renamed to the output folder when the context ends.

        Yield None if no output folder is given. Only a result of the same ``kind`` is replaced.
        Enter the context before computing, so that errors of the output folder come early.
        """
        if self.folder is None:
            yield None
            return
        from microslip.report.folder import staged

        with staged(self.folder, self.overwrite, kind) as stage:
            yield stage

    def show(self, document: Document, *, full: bool = False, hint: str = "") -> None:
        """Print a result as JSON, or as tables followed by the location of the files.

        ``full`` prints all tables; ``hint`` is a line printed after the tables.
        """
        if self.as_json:
            echo_json(document.data)
            return
        from microslip.report.terminal import print_document

        print_document(document, sys.stdout, full=full)
        if hint:
            click.echo(hint)
        if self.folder is not None:
            click.echo(f"{len(document.data['files'])} files in {self.folder}")


def writes(folder: str, earlier: str = "result", *between: Decorator) -> Decorator:
    """Return a decorator that adds the output options to a command, as one argument `output`.

    ``folder`` is the help text of the folder option, ``earlier`` the name of what --overwrite
    replaces, and ``between`` are options placed before ``--json``.
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


Report = Callable[[float], None]
"""Callback for the completed fraction of the work, 0 to 1."""


@contextmanager
def stoppable() -> Iterator[None]:
    """Return a context in which SIGTERM and SIGHUP raise SystemExit.

    Temporary folders are then removed. In messages of InputError, names of arguments are replaced
    by the options of the running command.
    """
    # Messages of Matplotlib about fonts and caches are irrelevant here, and without windows an
    # unavailable MPLBACKEND must not fail.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    os.environ.pop("MPLBACKEND", None)

    def stop(number: int, frame: FrameType | None) -> NoReturn:
        raise SystemExit(128 + number)

    signals = [signal.SIGTERM]
    if hasattr(signal, "SIGHUP"):  # the terminal was closed
        signals.append(signal.SIGHUP)
    previous = {}
    try:
        for number in signals:
            # A signal ignored by the parent, for example by nohup, stays ignored.
            if signal.getsignal(number) is signal.SIG_DFL:
                previous[number] = signal.signal(number, stop)
    except ValueError:  # not in the main thread
        pass
    try:
        yield
    except InputError as error:
        raise InputError(in_options(error.text)) from error
    finally:
        for number, before in previous.items():
            signal.signal(number, before)


@contextmanager
def progress(name: str) -> Iterator[Report]:
    """Show progress with the remaining time as a bar on a terminal.

    MICROSLIP_PROGRESS=lines prints the fraction in machine-readable lines.
    """
    if os.environ.get("MICROSLIP_PROGRESS") == "lines":
        yield lambda share: click.echo(f"progress {share:.4f}", err=True)
        return
    if not _is_live(sys.stderr):
        yield lambda share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TimeRemainingColumn

    with Progress(
        "{task.description}",
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True, color_system=None if os.environ.get("NO_COLOR") else "auto"),
        transient=True,
    ) as bar:
        task = bar.add_task(name, total=None)  # pulses until the total is known
        yield lambda share: bar.update(task, completed=share, total=1.0)


def _is_live(stream: object) -> bool:
    try:
        return bool(stream.isatty()) and os.environ.get("TERM") != "dumb"  # type: ignore[attr-defined]
    except (AttributeError, ValueError):
        return False
