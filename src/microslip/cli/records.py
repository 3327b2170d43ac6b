"""Floor 9: options that commands share: how records are read, and what is written."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

if TYPE_CHECKING:
    from microslip.tribometer import Record

Command = Callable[..., Any]

_KEYS = "displacement, force, normal_load, time or commanded"


class Reading(NamedTuple):
    """What the options say of the files."""

    displacement: str | None
    force: str | None
    normal_load: tuple[str, ...]
    """One for all files, or one for each."""
    time: str | None
    sample_rate: float | None
    turn: bool
    units: tuple[str, ...]
    factors: tuple[str, ...]
    zeros: tuple[str, ...]

    def read(self, path: str, index: int = 0) -> Record:
        """Read one file, the so many-th."""
        from microslip.tribometer import Record

        loads = self.normal_load
        return Record.read(
            path,
            displacement=self.displacement,
            force=self.force,
            normal_load=loads[index if len(loads) > 1 else 0] if loads else None,
            time=self.time,
            sample_rate=self.sample_rate,
            sign=-1 if self.turn else None,
            units=pairs("unit", self.units) or None,
            calibration=pairs("calibration", self.factors) or None,
            zero=pairs("zero", self.zeros) or None,
        )


def writes(files: str, earlier: str) -> Callable[[Command], Command]:
    """Give a command the options of what it writes: `folder`, `overwrite` and `as_json`.

    Parameters
    ----------
    files : str
        What the folder is for.
    earlier : str
        What in it may be replaced.

    Returns
    -------
    callable
        A decorator.
    """
    options = (
        click.option(
            "-o",
            "--output",
            "folder",
            type=click.Path(path_type=Path),
            metavar="DIR",
            help=f"Folder for {files}; without it nothing is written.",
        ),
        click.option(
            "--overwrite", is_flag=True, help=f"Replace an earlier {earlier} in that folder."
        ),
        click.option(
            "--json", "as_json", is_flag=True, help="Print the summary as JSON, no tables."
        ),
    )

    def give(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return give


def reads(many_loads: bool = False) -> Callable[[Command], Command]:
    """Give a command the options of reading, as one argument, `reading`.

    Parameters
    ----------
    many_loads : bool
        Whether there may be a normal load for each record.

    Returns
    -------
    callable
        A decorator.
    """
    several = "; one for all records, or one for each" if many_loads else ""
    options = (
        click.option("--displacement", metavar="COLUMN", help="Column of the displacement."),
        click.option("--force", metavar="COLUMN", help="Column of the tangential force."),
        click.option(
            "--normal-load",
            metavar="COLUMN",
            multiple=many_loads,
            help=f'Column of the normal load, or "500 N"{several}.',
        ),
        click.option("--time", metavar="COLUMN", help="Column of the time."),
        click.option(
            "--sample-rate", type=float, metavar="HZ", help="Samples a second, without a time."
        ),
        click.option("--turn", is_flag=True, help="Turn the sign of the force."),
        click.option(
            "--unit",
            "units",
            multiple=True,
            metavar="WHAT=UNIT",
            help=f"Unit of {_KEYS}; may be repeated.",
        ),
        click.option(
            "--calibration",
            "factors",
            multiple=True,
            metavar="WHAT=FACTOR",
            help='Factor of a sensor, such as force="12.5 N/V"; may be repeated.',
        ),
        click.option(
            "--zero",
            "zeros",
            multiple=True,
            metavar="WHAT=ZERO",
            help='What counts as zero, such as force="0.3 N" or force=middle; may be repeated.',
        ),
    )

    def decorate(command: Command) -> Command:
        @wraps(command)
        def read(**given: Any) -> Any:
            how = {name: given.pop(name) for name in Reading._fields}
            load = how["normal_load"]
            if not isinstance(load, tuple):
                how["normal_load"] = () if load is None else (load,)
            return command(reading=Reading(**how), **given)

        wrapped: Command = read
        for option in reversed(options):
            wrapped = option(wrapped)
        return wrapped

    return decorate


def pairs(option: str, given: tuple[str, ...]) -> dict[str, str]:
    """What an option that may be repeated was given as WHAT=..., by WHAT."""
    found = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals or not key or not value:
            raise click.UsageError(f'--{option} wants WHAT=..., such as force=..., got "{text}"')
        found[key.strip()] = value.strip()
    return found


def stiffness(text: str) -> float:
    """A stiffness with its unit; a plain number is in N/m.

    Parameters
    ----------
    text : str
        Such as "200 N/um".

    Returns
    -------
    float
        The stiffness [N/m].

    Raises
    ------
    click.UsageError
        Not a stiffness, or none above zero.
    """
    from microslip._core.units import STIFFNESS, QuantityError, to_si

    try:
        float(text)
    except ValueError:
        pass
    else:
        text = f"{text.strip()} N/m"
    try:
        return to_si(text, STIFFNESS, "200 N/um")
    except QuantityError as error:
        raise click.UsageError(f"--rig-stiffness: {error}") from None
