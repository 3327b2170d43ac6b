"""Long work: it can be interrupted, and shows its progress."""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Timer
from typing import TYPE_CHECKING, NoReturn

import click

from microslip.cli.options import spelling
from microslip.errors import InputError

if TYPE_CHECKING:
    from types import FrameType

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
