"""The command ``measure``: evaluate tribometer records."""

from __future__ import annotations

from pathlib import Path

import click

from microslip.cli.options import (
    FORMATS,
    Output,
    in_options,
    offers,
    progress,
    stoppable,
    switch,
    writes,
)
from microslip.cli.records import (
    CYCLES,
    MANIFEST_OPTION,
    Reading,
    calibration_of,
    list_records,
    reads,
    slice_of,
)
from microslip.cli.structures import BAND_OPTION, are_modal, measure_modes
from microslip.laboratory.options import DELAY, RIG_STIFFNESS


@click.command(short_help="Measure the loops in a tribometer's records.")
@click.argument("records", metavar="RECORD...", nargs=-1, type=click.Path())
@writes(
    "Folder for report, table and figure; without it nothing is written.",
    "measurement",
    *FORMATS,
)
@MANIFEST_OPTION
@reads()
@offers(RIG_STIFFNESS, DELAY)
@CYCLES
@BAND_OPTION
@switch("--all", "Print every table.", "every_table")
def measure(
    records: tuple[str, ...],
    output: Output,
    manifest: Path | None,
    reading: Reading,
    rig_stiffness: float | None,
    delay: float | None,
    cycles: str | None,
    band: str | None,
    every_table: bool,
) -> None:
    """Measure every cycle in each RECORD: CSV, TXT, Excel, MAT, TDMS or HDF5 files, or folders.

    Reports energy, damping, friction, stiffness and regime with confidence intervals of the means;
    for several records also one row per record. Files that cannot be measured are listed and
    skipped. Columns and units are detected unless given, and reported. Files are not changed.

    A RECORD can also be a test of a mode of a structure: a ring-down (time and sensor signal), or a
    table of amplitude, frequency and damping ratio. Frequency and damping are then reported against
    amplitude.
    """
    # A named force column marks a record of loops, whatever the other columns.
    if manifest is None and reading.force is None and are_modal(records):
        measure_modes(records, output, band)
        return
    if band is not None:
        raise click.UsageError("--band requires ring-downs of modes, got other files")
    with stoppable():
        from microslip._core.errors import InputError
        from microslip.laboratory import measure as measured
        from microslip.laboratory.campaign import Campaign
        from microslip.laboratory.record import path_text
        from microslip.report.files import write_document
        from microslip.report.measured import KIND, measurement_document

        with output.staged(KIND, "measurement") as stage, progress("Measuring") as report:
            files = list_records(records, manifest)
            paths = files.paths
            _, gain_errors = calibration_of(reading.calibration)
            results, places = [], []
            skipped: list[tuple[str, str]] = []
            for index, path in enumerate(paths):
                try:
                    record = reading.read(path, index, files.manifest)
                    result = measured(
                        record,
                        rig_stiffness=rig_stiffness,
                        cycles=slice_of("--cycles", cycles),
                        delay=delay or 0.0,
                        gain_errors=gain_errors,
                    )
                except InputError as error:
                    if not str(error).startswith(path_text(path)):
                        error = error.within(f"{path}: ")
                    if len(paths) == 1:
                        raise error from None
                    skipped.append((path, in_options(error.text).removeprefix(f"{path}: ")))
                else:
                    results.append(result)
                    places.append(index)
                report((index + 1) / len(paths))
            if not results:
                name, why = skipped[0]
                raise InputError(f"none of the {len(paths)} records can be measured; {name}: {why}")
            campaign = Campaign(tuple(results), files.columns(places))
            result_document = measurement_document(campaign, in_options, skipped)
            if stage is not None:
                result_document = write_document(result_document, stage, output.kinds)
    output.show(result_document, full=every_table)
