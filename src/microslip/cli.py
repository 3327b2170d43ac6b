"""Floor 9: the command line. It parses, calls and prints; NumPy loads with the first real work."""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from microslip._kernel_choice import kernel_name
from microslip._version import __version__
from microslip.errors import InputError

if TYPE_CHECKING:
    from types import FrameType

EXIT_OK, EXIT_INTERNAL, EXIT_USER, EXIT_INTERRUPTED = 0, 1, 2, 130


class _Group(click.Group):
    """A group whose errors are one line each and whose exit codes are the documented ones."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        if not standalone_mode:
            return super().main(args, prog_name, complete_var, False, **extra)
        try:
            code = super().main(args, prog_name, complete_var, False, **extra)
        except click.ClickException as error:
            _fail(" ".join(error.format_message().split()), EXIT_USER)
        except InputError as error:
            _fail(" ".join(str(error).split()), EXIT_USER)
        except click.Abort:
            _fail("interrupted", EXIT_INTERRUPTED)
        except Exception as error:
            if os.environ.get("MICROSLIP_DEBUG"):
                raise
            detail = " ".join(f"{type(error).__name__}: {error}".split())
            _fail(
                f"internal error: {detail} (MICROSLIP_DEBUG=1 shows where)",
                EXIT_INTERNAL,
            )
        sys.exit(code if isinstance(code, int) else EXIT_OK)

    def make_context(
        self,
        info_name: str | None,
        args: list[str],
        parent: click.Context | None = None,
        **extra: Any,
    ) -> click.Context:
        with _printing():  # the options --help and --version print here
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        with _printing():
            return super().invoke(ctx)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            near = get_close_matches(args[0], self.list_commands(ctx), n=1)
            hint = f'; did you mean "{near[0]}"?' if near else ""
            commands = ", ".join(self.list_commands(ctx))
            raise click.UsageError(f'no command "{args[0]}"{hint} (commands: {commands})', ctx)
        return super().resolve_command(ctx, args)


def _fail(message: str, code: int) -> NoReturn:
    with suppress(OSError):
        click.echo(f"error: {message}", err=True)
    sys.exit(code)


@contextmanager
def _printing() -> Iterator[None]:
    """Make one line of a standard output that is full, and nothing of one that nobody reads."""
    try:
        yield
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        # All files have names, and what goes wrong with them has its own messages.
        if error.filename is not None:
            raise
        with suppress(OSError):  # what is left in the buffer must not fail again at the exit
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            sys.exit(EXIT_OK)
        reason = (error.strerror or str(error)).lower()
        _fail(f"standard output cannot be written: {reason}", EXIT_USER)


def _print_version(context: click.Context, option: click.Parameter, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        click.echo(f"microslip {__version__} (kernel: {kernel_name()})")
        context.exit()


@click.group(
    cls=_Group,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 fine, 2 something to correct (one line says what), 1 internal error, "
    "130 interrupted.",
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Show version and kernel.",
)
@click.pass_context
def main(context: click.Context) -> None:
    """Friction, hysteresis and damping of rough joints."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@main.command(short_help="Predict loops, energy and damping of a joint.")
@click.argument("study", type=click.Path(path_type=Path, readable=False))
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for the result; by default STUDY-result in the current folder.",
)
@click.option("--overwrite", is_flag=True, help="Replace an earlier result in that folder.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, no tables.")
def predict(study: Path, folder: Path | None, overwrite: bool, as_json: bool) -> None:
    """Predict loops, energy and damping of the joint that STUDY (a TOML file) describes.

    Writes tables (CSV), summary.json and figures into a folder, whole or not at all.
    """
    from microslip.study.folder import staged
    from microslip.study.load import read

    # Its remarks on fonts and caches are not for the reader of a result.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    with _terminable():
        described = read(study)
        folder = folder if folder is not None else Path(f"{study.stem}-result")
        with staged(folder, overwrite) as stage:
            from microslip.study.output import write

            with _progress() as progress:
                result = described.run(lambda share: progress(0.5 * share))
                write(result, stage, lambda share: progress(0.5 + 0.5 * share))
    if as_json:
        import json

        click.echo(json.dumps(result.summary, indent=1, ensure_ascii=True))
    else:
        from microslip.study.tables import show

        show(result.summary, folder, sys.stdout)


@contextmanager
def _terminable() -> Iterator[None]:
    """Let a polite kill unwind like Ctrl-C does, so that the temporary folder is removed."""

    def stop(number: int, frame: FrameType | None) -> NoReturn:
        raise SystemExit(128 + number)

    try:
        previous = signal.signal(signal.SIGTERM, stop)
    except ValueError:  # not in the main thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


@contextmanager
def _progress() -> Iterator[Callable[[float], None]]:
    """A bar on the terminal once the work has taken a second; nothing in a pipe."""
    if not sys.stderr.isatty():
        yield lambda share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TimeRemainingColumn

    bar = Progress(
        "Working",
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    task = bar.add_task("", total=1.0)
    begin = time.monotonic()

    def update(share: float) -> None:
        if not bar.live.is_started and time.monotonic() - begin > 1.0:
            bar.start()
        bar.update(task, completed=share)

    try:
        yield update
    finally:
        if bar.live.is_started:
            bar.stop()


if __name__ == "__main__":
    main()
