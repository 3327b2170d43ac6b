"""Options shared by commands on records: reading of records, and values with units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from microslip._core.options import is_number
from microslip._core.quantities import named
from microslip._core.units import (
    FORCE,
    LENGTH,
    with_common_unit,
)
from microslip._core.wording import plural, shorten
from microslip.cli.options import (
    ANY_PATH,
    Command,
    Report,
    click_option,
    in_options,
    offers,
    quantity,
)
from microslip.laboratory.options import RECORD_OPTIONS, REPEATED, RIG_STIFFNESS

if TYPE_CHECKING:
    from microslip.laboratory import Record
    from microslip.laboratory.manifest import Manifest

_Result = TypeVar("_Result")


def parse_noise(text: str | None) -> tuple[float, float] | None:
    """Parse the standard deviations of force [N] and displacement [m]; None without a text."""
    if text is None:
        return None
    force, comma, length = text.partition(",")
    if not comma:
        raise click.UsageError(f'--noise: wanted FORCE,LENGTH, such as "2 N, 5 nm", got "{text}"')
    return (
        quantity("--noise", force.strip(), FORCE, "2 N"),
        quantity("--noise", length.strip(), LENGTH, "5 nm"),
    )


def rig_stiffness_of(text: str | None) -> tuple[float, float] | None:
    """Parse the rig stiffness [N/m] and its standard deviation; None without a text."""
    if text is None:
        return None
    value, deviation = with_deviation(text.strip())
    return stiffness(value), 0.0 if deviation is None else stiffness(deviation)


def _or_none(column: str | None) -> Any:
    return False if column == "none" else column


MANIFEST_OPTION = click_option(
    "--manifest", "FILE",
    "CSV or Excel sheet with a row per record: file, and optionally specimen, load, amplitude, "
    "stage, number of the first cycle, worn volume, temperature, columns to read and other data.",
    type=ANY_PATH,
)  # fmt: skip


class Reading(NamedTuple):
    """Values of the options for reading records."""

    displacement: str | None
    force: str | None
    normal_load: tuple[str, ...]
    """Load for all files, or loads for each file."""
    time: str | None
    sample_rate: float | None
    flip_sign: bool
    units: tuple[str, ...]
    calibration: tuple[str, ...]
    zero: tuple[str, ...]
    rows: str | None

    def read(self, path: str, index: int = 0, manifest: Manifest | None = None) -> Record:
        """Read record number ``index``, with the given options.

        Columns and load that the manifest gives for this record take precedence over the options.
        If the options give several loads, the load with the same index is used.
        """
        from microslip.laboratory import Record

        loads = self.normal_load
        given = {
            **named(self, "displacement", "force", "sample_rate"),
            "normal_load": _or_none(loads[index if len(loads) > 1 else 0] if loads else None),
            "time": _or_none(self.time),
        }
        if manifest is not None:
            given |= manifest.reading(index)
        record = Record.read(
            path,
            **given,
            sign=-1 if self.flip_sign else None,
            units=pairs("unit", self.units) or None,
            calibration=pairs("calibration", calibration_of(self.calibration)[0]) or None,
            zero=pairs("zero", self.zero) or None,
            rows=slice_of("--rows", self.rows),
        )
        return record if manifest is None else manifest.loaded(record, index)


def reads(command: Command) -> Command:
    """Add the options for reading records to a command, as one argument `reading`."""

    @wraps(command)
    def read(**arguments: Any) -> Any:
        reading = Reading(**{name: arguments.pop(name) for name in Reading._fields})
        return command(reading=reading, **arguments)

    decorated: Command = read
    for option in reversed(RECORD_OPTIONS):
        repeated = {"multiple": True} if option.name in REPEATED else {}
        decorated = offers(option, **repeated)(decorated)
    return decorated


SUFFIXES = (
    *(".csv", ".tsv", ".txt", ".dat", ".mat", ".tdms", ".h5", ".hdf5", ".nc", ".npy", ".npz"),
    *(".xlsx", ".xlsm", ".lvm"),
)
"""Suffixes of files in a folder that are read as records."""


class Listed(NamedTuple):
    """Files given to a command, and the manifest that lists them, if any."""

    paths: list[str]
    manifest: Manifest | None

    def columns(self, rows: Sequence[int]) -> dict[str, list[Any]]:
        """Return the manifest columns of further data, such as "specimen", and its runs."""
        from microslip.laboratory.campaign import NUMBERS

        columns: dict[str, list[Any]] = {}
        if self.manifest is None:
            return columns
        for name, values in self.manifest.columns.items():
            unit = "" if name in NUMBERS else self.manifest.units[name]
            if name != "run":
                columns[f"{name} [{unit}]" if unit else name] = [values[i] for i in rows]
        runs = self.manifest.texts("run")
        return columns | ({"run": [runs[i] for i in rows]} if runs else {})


def list_records(names: Sequence[str], manifest: Path | None) -> Listed:
    """Return the files named on the command line, of which some may be folders, or in a manifest.

    A folder stands for the records in it and its subfolders.
    """
    if (manifest is None) == (not names):
        if names:
            raise click.UsageError("--manifest lists the records; omit RECORD arguments")
        raise click.UsageError("Missing argument 'RECORD...', or --manifest FILE")
    if manifest is not None:
        from microslip.laboratory.manifest import Manifest

        read = Manifest.read(manifest)
        return Listed(list(read.paths), read)
    paths: list[str] = []
    for name in names:
        inside = [name]
        if Path(name).is_dir():
            found = sorted(p for p in Path(name).rglob("*") if p.suffix.lower() in SUFFIXES)
            inside = [str(path) for path in found if path.is_file()]
            if not inside:
                raise click.UsageError(f"no records in the folder {shorten(name, 200)}")
        paths += inside
    seen: set[Path] = set()
    for path in paths:
        if (place := Path(path).resolve()) in seen:
            raise click.UsageError(f"{shorten(path, 200)} is named twice")
        seen.add(place)
    return Listed(paths, None)


def each_record(
    files: Listed, reading: Reading, work: Callable[[Record], _Result], report: Report
) -> tuple[list[_Result], list[int], list[tuple[str, str]]]:
    """Apply ``work`` to each record.

    Return the results with the indices of their records, and the paths of the records that cannot
    be read or evaluated with the reasons. An error of the only record, or of all, is raised.
    """
    from microslip._core.errors import InputError
    from microslip.laboratory.record import path_text

    paths, loads = files.paths, len(reading.normal_load)
    if loads not in (0, 1, len(paths)):
        records = plural(len(paths), "record")
        raise click.UsageError(
            f"--normal-load: wanted one for all records or one for each of the {records}, "
            f"got {loads}"
        )
    results, places = [], []
    skipped: list[tuple[str, str]] = []
    for index, path in enumerate(paths):
        try:
            results.append(work(reading.read(path, index, files.manifest)))
            places.append(index)
        except InputError as error:
            if not str(error).startswith(path_text(path)):
                error = error.within(f"{path}: ")
            if len(paths) == 1:
                raise error from None
            skipped.append((path, in_options(error.text).removeprefix(f"{path}: ")))
        report((index + 1) / len(paths))
    if not results:
        name, why = skipped[0]
        raise InputError(f"none of the {len(paths)} records can be used; {name}: {why}")
    return results, places, skipped


def slice_of(option: str, text: str | None) -> slice | None:
    """Parse a range FIRST..LAST, counted from 1, both ends included; either may be omitted."""
    if text is None:
        return None
    first, dots, last = (part.strip() for part in text.partition(".."))
    try:
        begin, end = int(first or 1), int(last) if last else None
    except ValueError:
        begin, end = 0, None
    if not dots or begin < 1 or (end is not None and end < begin):
        raise click.UsageError(f'{option}: wanted FIRST..LAST, such as 1..500, got "{text}"')
    return slice(begin - 1, end)


CYCLES = click_option(
    "--cycles", "FIRST..LAST",
    "Cycles to use, counted from 1, such as 100..200; the settled cycles if absent.",
)  # fmt: skip


def pairs(option: str, texts: tuple[str, ...]) -> dict[str, str]:
    """Parse a repeatable option WHAT=VALUE into a mapping."""
    values = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key or not value:
            raise click.UsageError(
                f'--{option}: wanted WHAT=VALUE, such as force=..., got "{text}"'
            )
        values[key.strip()] = value.strip()
    return values


def stiffness(text: str) -> float:
    """Parse a stiffness with its unit [N/m]; a plain number is in N/m."""
    try:
        value: float = RIG_STIFFNESS.read(text)
    except ValueError as error:
        raise click.UsageError(f"--rig-stiffness: {error}") from None
    return value


def calibration_of(texts: tuple[str, ...]) -> tuple[tuple[str, ...], dict[str, float]]:
    """Parse the options --calibration QUANTITY=FACTOR±DEVIATION.

    Return the texts QUANTITY=FACTOR to be applied, and the relative standard deviation [-] of each
    factor by quantity. A factor 1±DEVIATION only states an uncertainty: as it changes no value, its
    text is left out.
    """
    factors, errors = [], {}
    for role, text in pairs("calibration", texts).items():
        value, deviation = with_deviation(text)
        if deviation is not None:
            number = value.partition(" ")[0]
            error = deviation.removesuffix("%").partition(" ")[0]
            if not (is_number(number) and is_number(error) and float(number) and float(error) >= 0):
                raise click.UsageError(
                    f"--calibration: wanted {role}=FACTOR±DEVIATION, such as {role}=1±0.01, got "
                    f'"{text}"'
                )
            share = 0.01 if deviation.endswith("%") else 1.0 / abs(float(number))
            errors[role] = float(error) * share
        if deviation is None or not (is_number(value) and float(value) == 1.0):
            factors.append(f"{role}={value}")
    return tuple(factors), errors


def with_deviation(text: str) -> tuple[str, str | None]:
    """Split a text VALUE±DEVIATION; the deviation is None if there is none.

    A unit given once applies to both.
    """
    value, sign, deviation = (
        part.strip() for part in text.replace("+/-", "±").replace("+-", "±").partition("±")
    )
    if not sign:
        return value, None
    value, deviation = with_common_unit((value, deviation))
    return value, deviation
