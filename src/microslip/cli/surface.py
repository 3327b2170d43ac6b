"""The command ``surface``: evaluate a scan and compute the joint of that surface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from microslip.cli.options import (
    ANY_PATH,
    FORMATS,
    Output,
    in_options,
    offers,
    progress,
    stoppable,
    switch,
    writes,
)
from microslip.surfaces import options as offered


@click.command(short_help="Measure a scan, and solve the joint of its face.")
@click.argument("scan", type=ANY_PATH)
@offers(offered.CUTOFF.but(default=None), *offered.CONDITIONING[1:])
@offers(offered.SCAN_AREA, *offered.JOINT, *offered.READING)
@switch("--all", "Print every table.", "every_table")
@writes("Folder for report, tables and figures; without it nothing is written.", "one", *FORMATS)
def surface(
    scan: Path,
    every_table: bool,
    output: Output,
    **options: Any,
) -> None:
    """Measure heights, spectrum and summits of SCAN, an instrument file or an array.

    With two metals and a load, the face is solved point by point for the normal and tangential
    stiffness and the damping of the joint, and a study for microslip predict is written.

    Every parameter depends on the short-wave cut-off, which each table and figure states. The main
    results are printed; --all and the report give all tables. The scan is not changed.
    """
    with stoppable():
        from microslip.report.files import write_document
        from microslip.report.scanned.document import scan_document
        from microslip.surfaces.findings import Request, analyse

        context = click.get_current_context()
        cutoff_given = (
            context.get_parameter_source("cutoff") is not click.core.ParameterSource.DEFAULT
        )
        request = Request.of(scan, cutoff_given=cutoff_given, **options)
        with output.staged("surface") as stage:
            with progress("Measuring") as report:
                findings = analyse(request, report)
            result = scan_document(findings, output.folder, in_options)
            if stage is not None:
                with progress("Drawing and writing") as report:
                    result = write_document(result, stage, output.kinds, report)
    hint = "" if every_table else "All tables, assumptions of the verdicts and reading notes: --all"
    output.show(result, full=every_table, hint=hint)
