"""Options of commands made from declared ones; their wording; output, progress, interruption."""

from __future__ import annotations

import logging
import os
import shlex
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from threading import Timer
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import click

from microslip._core.parameters import Parameter
from microslip._core.units import Kind, QuantityError, Sign, ends_of, to_si
from microslip.cli.group import OneOf, echo_json
from microslip.errors import UNSAID, Argument, InputError, Spelling

if TYPE_CHECKING:
    from types import FrameType

    from microslip.report.document import Document

    _ParamType = click.ParamType[Any]
else:  # which takes no type before click 8.2
    _ParamType = click.ParamType

Command = Callable[..., Any]
Decorator = Callable[[Command], Command]

ANY_PATH = click.Path(path_type=Path, readable=False)
"""A path as it is given; what is wrong with it the house says itself."""


class _Value(_ParamType):
    """Reads one value of an option, with its unit."""

    def __init__(self, option: Parameter) -> None:
        self.option = option
        self.name = option.name

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value in SI units, or an error that names the option."""
        if not isinstance(value, str):
            return value
        try:
            return self.option.read_text(value)
        except ValueError as error:
            flag = param.opts[-1] if param is not None else self.option.name
            raise click.UsageError(f"{flag}: {error}", ctx) from None


class CommandOption(click.Option):
    """An option of a command that knows for which arguments of Python it stands."""

    def __init__(self, *args: Any, option: Parameter, **extra: Any) -> None:
        super().__init__(*args, **extra)
        self.option = option


class NamedOption(click.Option):
    """An option that stands for arguments of other names, with some values in words of its own."""

    def __init__(
        self,
        *args: Any,
        answers_for: tuple[str, ...] = (),
        words: Mapping[str, str] | None = None,
        **extra: Any,
    ) -> None:
        super().__init__(*args, **extra)
        self.answers_for = answers_for
        self.words = words or {}


def option(flag: str, value: str, text: str, name: str = "", **settings: Any) -> Decorator:
    """An option of one command: its flag, what stands for its value, its help."""
    names = [flag, name] if name else [flag]
    return click.option(*names, cls=NamedOption, metavar=value, help=text, **settings)


def switch(flag: str, text: str, name: str = "") -> Decorator:
    """An option without a value."""
    return click.option(*[flag, name] if name else [flag], is_flag=True, help=text)


def output_option(
    text: str, value: str = "DIR", name: str = "folder", **settings: Any
) -> Decorator:
    """The option that says where the files go."""
    names = ("-o", "--output", name)
    return click.option(*names, type=ANY_PATH, metavar=value, help=text, **settings)


def quantity(flag: str, text: str, kind: Kind, example: str, sign: Sign = "positive") -> float:
    """A value with its unit, in SI units, or an error that names the option."""
    try:
        return to_si(text, kind, example, sign)
    except QuantityError as error:
        raise click.UsageError(f"{flag}: {error}") from None


def ends_in(flag: str, text: str, form: str) -> tuple[str, str]:
    """The ends of LOW..HIGH, or an error that names the option."""
    ends = ends_of(text)
    if ends is None:
        raise click.UsageError(f'{flag} wants {form}, got "{text}"')
    return ends


JSON = switch("--json", "Print the summary as JSON, no tables.", "as_json")


def offers(*options: Parameter, **changes: Any) -> Decorator:
    """Give a command some options, in their order."""

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


def flag(option: Parameter) -> str:
    """Name of an option on the command line, without its dashes."""
    return option.flag or option.name.replace("_", "-")


def _settings(option: Parameter) -> dict[str, Any]:
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


def spelling(context: click.Context | None) -> Spelling:
    """Spell arguments as a command does: as its options; without an option, as Python."""
    options: dict[str, click.Option] = {}
    for param in context.command.params if context is not None else ():
        if not isinstance(param, click.Option):
            continue
        names = [param.name]
        if isinstance(param, CommandOption):
            names += param.option.answers_for
        elif isinstance(param, NamedOption):
            names += param.answers_for
        options |= {name: param for name in names if name}

    def say(argument: Argument) -> str:
        param = options.get(argument.name)
        if param is None:
            # A name alone is the subject of a sentence, which may be no keyword at all.
            return f"in Python {argument}" if argument.has_value else argument.name
        name = param.opts[-1]
        if not argument.has_value:
            # Of a column that was read, its values are wrong and not its name.
            return argument.name if param.metavar == "COLUMN" else name
        if param.is_flag:
            return name
        if isinstance(param, NamedOption) and str(argument.value) in param.words:
            return f"{name} {param.words[str(argument.value)]}"
        return f"{name} {_words(argument.value, param, name)}"

    return say


def _words(value: Any, param: click.Option, name: str) -> str:
    """Metavariable of an option."""
    if value is UNSAID:
        return param.metavar or "VALUE"
    if value is False:
        return "none"
    if value is None and isinstance(param, CommandOption) and param.option.none:
        return param.option.none
    if isinstance(value, Mapping):
        pairs = (f"{key}={_range(item)}" for key, item in value.items())
        return f" {name} ".join(pairs)
    if isinstance(value, (list, tuple)):
        return (" " if param.nargs > 1 else f" {name} ").join(map(_word, value))
    return _word(value)


def _range(value: Any) -> str:
    if value is UNSAID:
        return "LOW..HIGH"
    return "..".join(map(_word, value)) if isinstance(value, (list, tuple)) else _word(value)


def _word(value: Any) -> str:
    if isinstance(value, slice):
        first = value.start if isinstance(value.start, str) else (value.start or 0) + 1
        value = f"{first}..{value.stop or ''}"
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if shlex.quote(text) == text else f'"{text}"'


# -- output ----------------------------------------------------------------------------------------


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


PATIENCE = 1.0
"""Time without a sign of life that needs no explanation [s]."""

Report = Callable[[float], None]
"""Takes the share of the work that is done, 0 … 1."""

_begin = time.monotonic()


@contextmanager
def stoppable() -> Iterator[None]:
    """Let a polite kill unwind like Ctrl-C does, so that the temporary folder is removed.

    What the package objects to is said in the options of the command that runs.
    """
    # Its remarks on fonts and caches are not for the reader of a result, and nothing is shown in
    # a window, so the wish for a certain one must not fail.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    os.environ.pop("MPLBACKEND", None)

    def stop(number: int, frame: FrameType | None) -> NoReturn:
        raise SystemExit(128 + number)

    polite = [signal.SIGTERM]
    if hasattr(signal, "SIGHUP"):  # the terminal was closed
        polite.append(signal.SIGHUP)
    previous = {}
    try:
        for number in polite:
            # Whoever started this may have had a reason to ignore it, such as nohup.
            if signal.getsignal(number) is signal.SIG_DFL:
                previous[number] = signal.signal(number, stop)
    except ValueError:  # not in the main thread
        pass
    try:
        yield
    except InputError as error:
        context = click.get_current_context(silent=True)
        words = error.said(spelling(context))
        if words == str(error):
            raise
        raise InputError(words) from error
    finally:
        for number, before in previous.items():
            signal.signal(number, before)


@contextmanager
def progress(name: str) -> Iterator[Report]:
    """A bar with the time left on the terminal after the first second; nothing in a pipe.

    A program that runs the command asks for lines with MICROSLIP_PROGRESS=lines.
    """
    if os.environ.get("MICROSLIP_PROGRESS") == "lines":
        yield lambda share: click.echo(f"progress {share:.4f}", err=True)
        return
    if not _is_live(sys.stderr):
        yield lambda share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TimeRemainingColumn

    bar = Progress(
        "{task.description}",
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True, color_system=None if os.environ.get("NO_COLOR") else "auto"),
        transient=True,
    )
    # Without a total until it is known, so that the bar moves all the same.
    task = bar.add_task(name, total=None)
    # A timer instead of checks of the clock, since a single step may take long.
    timer = Timer(max(PATIENCE - (time.monotonic() - _begin), 0.0), bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield lambda share: bar.update(task, completed=share, total=1.0)
    finally:
        timer.cancel()
        timer.join()
        if bar.live.is_started:
            bar.stop()


def _is_live(stream: object) -> bool:
    """Whether a stream is a terminal on which a line can be drawn again."""
    try:
        return bool(stream.isatty()) and os.environ.get("TERM") != "dumb"  # type: ignore[attr-defined]
    except (AttributeError, ValueError):
        return False
