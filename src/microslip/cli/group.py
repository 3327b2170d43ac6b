"""Base class of the commands: exit codes, one-line errors, and failures of standard output."""

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
else:  # not generic before click 8.2
    _Choice = click.Choice

_LONGEST = 1000  # characters of a message
EXIT_OK, EXIT_INTERNAL, EXIT_USER, EXIT_INTERRUPTED = 0, 1, 2, 130


class Group(click.Group):
    """Group of commands with one-line error messages and the documented exit codes."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command and exit with its exit code."""
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
            fail("not enough memory", EXIT_USER)
        except Exception as error:
            if os.environ.get("MICROSLIP_DEBUG"):
                raise
            if isinstance(error, FileNotFoundError) and error.filename is None:
                fail("the current folder no longer exists; change to another folder", EXIT_USER)
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
        """Create the click context; handle errors of output, since --help prints here."""
        with _printing():
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; handle errors of standard output."""
        with _printing():
            return super().invoke(ctx)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands in the order in which the help lists them."""
        return list(self.commands)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command of a name; an unknown name is an error with a suggestion."""
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            near = get_close_matches(args[0], self.list_commands(ctx), n=1)
            hint = f'; did you mean "{near[0]}"?' if near else ""
            commands = ", ".join(self.list_commands(ctx))
            raise click.UsageError(f'no command "{args[0]}"{hint} (commands: {commands})')
        return super().resolve_command(ctx, args)


class OneOf(_Choice):
    """Option type for one of several words; an error suggests a similar word."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the word if it is allowed, otherwise raise an error that lists the words."""
        if value not in self.choices:
            near = get_close_matches(value, self.choices, n=1)
            hint = f'; did you mean "{near[0]}"?' if near else ""
            name = param.human_readable_name if param else "value"
            if isinstance(param, click.Option):
                name = param.opts[-1]  # the flag, not the argument name in Python
            raise click.UsageError(
                f'{name}: wanted {", ".join(self.choices)}, got "{value}"{hint}', ctx
            )
        return str(value)


def _usage(error: click.UsageError) -> str:
    command = error.ctx
    if isinstance(error, click.MissingParameter) and error.param is not None:
        # An option is named as it is written: the last spelling is the long one.
        is_option = isinstance(error.param, click.Option)
        name = error.param.opts[-1] if is_option else error.param.human_readable_name
        message = f"missing {name}"
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
    """Print plain values as ASCII JSON, valid in every encoding."""
    import json

    click.echo(json.dumps(values, indent=1))


def fail(message: str, code: int) -> NoReturn:
    """Print an error message on one line and exit with ``code``."""
    with suppress(OSError):
        click.echo(f"error: {shorten(' '.join(message.split()), _LONGEST)}", err=True)
    sys.exit(code)


@contextmanager
def _printing() -> Iterator[None]:
    """Return a context that ends the program if standard output cannot be written.

    The reason is printed in one line; a closed pipe ends the program without a message.
    """
    try:
        yield
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        # Errors of files have a file name and their own messages. An error of the current folder
        # has no name, but is a FileNotFoundError.
        if error.filename is not None or isinstance(error, FileNotFoundError):
            raise
        with suppress(OSError):  # flushing the buffer at exit must not fail again
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            sys.exit(EXIT_OK)
        reason = (error.strerror or str(error)).lower()
        fail(f"standard output cannot be written: {reason}", EXIT_USER)
