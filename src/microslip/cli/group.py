"""Shared base of all commands: exit codes, one-line errors, outputs that fail."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, NoReturn

import click

from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip._core.wording import shorten

if TYPE_CHECKING:
    _Choice = click.Choice[str]
else:  # which takes no type before click 8.2
    _Choice = click.Choice

_LONGEST = 1000  # letters of a message
_FORMER = {"--turn": "--flip-sign"}
"""Options by their names of before, which no help shows."""
EXIT_OK, EXIT_INTERNAL, EXIT_USER, EXIT_INTERRUPTED = 0, 1, 2, 130


class Group(click.Group):
    """A group whose errors are one line each and whose exit codes are the documented ones."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command, and exit."""
        if not standalone_mode:
            return super().main(args, prog_name, complete_var, False, **extra)
        try:
            with needed_for("this command needs"):
                code = super().main(args, prog_name, complete_var, False, **extra)
        except click.UsageError as error:
            fail(_usage(error), EXIT_USER)
        except click.ClickException as error:
            fail(error.format_message(), EXIT_USER)
        except InputError as error:
            fail(str(error), EXIT_USER)
        except (click.Abort, KeyboardInterrupt):
            fail("interrupted", EXIT_INTERRUPTED)
        except MemoryError:
            fail("not enough memory for this", EXIT_USER)
        except Exception as error:
            if os.environ.get("MICROSLIP_DEBUG"):
                raise
            if isinstance(error, FileNotFoundError) and error.filename is None:
                fail("the current folder is gone; change into another one", EXIT_USER)
            fail(
                f"internal error: {type(error).__name__}: {error} (MICROSLIP_DEBUG=1 shows where)",
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
        """Context of click; the options that print here, --help and --version, may fail to."""
        words = [_FORMER.get(word, word) for word in args]
        with _printing():
            return super().make_context(info_name, words, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Call of click; what commands print may fail."""
        with _printing():
            return super().invoke(ctx)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands, in the order of the first ten minutes."""
        return list(self.commands)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Command of click; an unknown command gets a message of its own."""
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            near = get_close_matches(args[0], self.list_commands(ctx), n=1)
            hint = f'; did you mean "{near[0]}"?' if near else ""
            commands = ", ".join(self.list_commands(ctx))
            raise click.UsageError(f'no command "{args[0]}"{hint} (commands: {commands})')
        return super().resolve_command(ctx, args)


class OneOf(_Choice):
    """One of some words; another one is asked whether it meant one of them."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The word, or an error that lists the words."""
        if value not in self.choices:
            near = get_close_matches(value, self.choices, n=1)
            hint = f'; did you mean "{near[0]}"?' if near else ""
            name = param.human_readable_name if param else "value"
            if isinstance(param, click.Option):
                name = param.opts[-1]  # --for, and not the name of its argument in Python
            raise click.UsageError(
                f'{name}: wanted {", ".join(self.choices)}, got "{value}"{hint}', ctx
            )
        return str(value)


def _usage(error: click.UsageError) -> str:
    """A mistake in the words of a command, and how it is written."""
    command = error.ctx
    if isinstance(error, click.MissingParameter) and error.param is not None:
        message = f"missing {error.param.human_readable_name}"
    elif isinstance(error, click.NoSuchOption):
        near = error.possibilities or ()
        hint = f'; did you mean "{near[0]}"?' if near else ""
        message = f'no option "{error.option_name}"{hint}'
    else:
        message = error.format_message().rstrip(".")
        if message[1:2].islower():  # not the name of an argument
            message = message[:1].lower() + message[1:]
    if command is None:
        return message
    return f"{message} (usage: {' '.join(command.get_usage().split()[1:])})"


def echo_json(values: Any) -> None:
    """Print plain values as JSON, in letters that every pipe takes."""
    import json

    click.echo(json.dumps(values, indent=1))


def fail(message: str, code: int) -> NoReturn:
    """Say in one line what went wrong, and exit."""
    with suppress(OSError):
        click.echo(f"error: {shorten(' '.join(message.split()), _LONGEST)}", err=True)
    sys.exit(code)


@contextmanager
def _printing() -> Iterator[None]:
    """Make one line of a standard output that is full, and nothing of one that nobody reads."""
    try:
        yield
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        # All files have names, and what goes wrong with them has its own messages; the current
        # folder has none, but it can only be missing.
        if error.filename is not None or isinstance(error, FileNotFoundError):
            raise
        with suppress(OSError):  # what is left in the buffer must not fail again at the exit
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            sys.exit(EXIT_OK)
        reason = (error.strerror or str(error)).lower()
        fail(f"standard output cannot be written: {reason}", EXIT_USER)
