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
    each_record,
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
@reads
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
        from microslip.laboratory import measure as measured
        from microslip.laboratory.campaign import Campaign
        from microslip.report.files import write_document
        from microslip.report.measured import measurement_document

        with output.staged("measurement") as stage, progress("Measuring") as report:
            files = list_records(records, manifest)
            _, gain_errors = calibration_of(reading.calibration)
            results, places, skipped = each_record(
                files,
                reading,
                lambda record: measured(
                    record,
                    rig_stiffness=rig_stiffness,
                    cycles=slice_of("--cycles", cycles),
                    delay=delay or 0.0,
                    gain_errors=gain_errors,
                ),
                report,
            )
            campaign = Campaign(tuple(results), files.columns(places))
            result_document = measurement_document(campaign, in_options, skipped)
            if stage is not None:
                result_document = write_document(result_document, stage, output.kinds)
    output.show(result_document, full=every_table)
