"""Floor 9: what a tribometer recorded."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from microslip.cli.frame import echo_json
from microslip.cli.work import progress, stoppable

_KEYS = "displacement, force, normal_load, time or commanded"


@click.command(short_help="Measure the loops in a tribometer's records.")
@click.argument("records", metavar="RECORD...", nargs=-1, required=True, type=click.Path())
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for tables and figure; without it nothing is written.",
)
@click.option("--overwrite", is_flag=True, help="Replace an earlier measurement in that folder.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, no tables.")
@click.option("--displacement", metavar="COLUMN", help="Column of the displacement.")
@click.option("--force", metavar="COLUMN", help="Column of the tangential force.")
@click.option("--normal-load", metavar="COLUMN", help='Column of the normal load, or "500 N".')
@click.option("--time", metavar="COLUMN", help="Column of the time.")
@click.option("--sample-rate", type=float, metavar="HZ", help="Samples a second, without a time.")
@click.option("--turn", is_flag=True, help="Turn the sign of the force.")
@click.option(
    "--unit", "units", multiple=True, metavar="WHAT=UNIT", help=f"Unit of {_KEYS}; may be repeated."
)
@click.option(
    "--calibration",
    "factors",
    multiple=True,
    metavar="WHAT=FACTOR",
    help='Factor of a sensor, such as force="12.5 N/V"; may be repeated.',
)
@click.option(
    "--zero",
    "zeros",
    multiple=True,
    metavar="WHAT=ZERO",
    help='What counts as zero, such as force="0.3 N" or force=middle; may be repeated.',
)
@click.option("--rig-stiffness", type=float, metavar="N/M", help="Rig in series, to be taken off.")
@click.option("--confidence", type=float, default=0.95, show_default=True, help="Of the intervals.")
def measure(
    records: tuple[str, ...],
    folder: Path | None,
    overwrite: bool,
    as_json: bool,
    displacement: str | None,
    force: str | None,
    normal_load: str | None,
    time: str | None,
    sample_rate: float | None,
    turn: bool,
    units: tuple[str, ...],
    factors: tuple[str, ...],
    zeros: tuple[str, ...],
    rig_stiffness: float | None,
    confidence: float,
) -> None:
    """Measure every cycle in each RECORD: CSV, TXT, TSV, MAT, TDMS or HDF5.

    Energy, damping, friction, stiffness and regime, with confidence intervals of their means.
    Columns and units that are not given are found, and shown. The files are only read.
    """
    with stoppable():
        from contextlib import ExitStack

        from microslip.study.folder import staged
        from microslip.study.measured import KIND, show, summarise, write
        from microslip.tribometer import Record
        from microslip.tribometer import measure as measured

        with ExitStack() as stack:
            stage = None
            if folder is not None:  # first, so that nothing is read in vain
                stage = stack.enter_context(staged(folder, overwrite, KIND, "measurement"))
            report = stack.enter_context(progress("Measuring"))
            found = []
            for index, path in enumerate(records):
                record = Record.read(
                    path,
                    displacement=displacement,
                    force=force,
                    normal_load=normal_load,
                    time=time,
                    sample_rate=sample_rate,
                    sign=-1 if turn else None,
                    units=_pairs("unit", units) or None,
                    calibration=_pairs("calibration", factors) or None,
                    zero=_pairs("zero", zeros) or None,
                )
                try:
                    found.append(
                        measured(record, rig_stiffness=rig_stiffness, confidence=confidence)
                    )
                except ValueError as error:
                    raise type(error)(f"{path}: {error}") from None
                report((index + 1) / len(records))
            summary = summarise(found) if stage is None else write(found, stage)
    if as_json:
        echo_json(summary)
        return
    show(summary, sys.stdout)
    if folder is not None:
        click.echo(f"{len(summary['files'])} files in {folder}")


def _pairs(option: str, given: tuple[str, ...]) -> dict[str, str]:
    pairs = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals or not key or not value:
            raise click.UsageError(f'--{option} wants WHAT=..., such as force=..., got "{text}"')
        pairs[key.strip()] = value.strip()
    return pairs
