"""What a scan of a surface says, and what joint it makes."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Any

import click

from microslip.cli.frame import echo_json
from microslip.cli.options import offers, spelling
from microslip.cli.records import writes
from microslip.cli.work import progress, stoppable
from microslip.scans.options import (
    AGAINST,
    CONDITIONING,
    CUTOFF,
    DRAWING,
    JOINT,
    READING,
    SCAN_AREA,
    SUMMITS,
)

_TWICE = {"unit": "coordinates and heights", "pixel": "x and y"}
_OFTEN = ("against",)


class _Once(click.Command):
    """A command that does not take the last of two options for granted."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click's; an option is refused where it is there more often than it may be."""
        if not ctx.resilient_parsing:
            _, _, order = self.make_parser(ctx).parse_args(args=list(args))
            for option, count in Counter(order).items():
                if not isinstance(option, click.Option) or option.is_flag or option.name in _OFTEN:
                    continue
                twice = _TWICE.get(option.name or "")
                if count > (1 if twice is None else 2):
                    allowance = "once" if twice is None else f"once, or twice for {twice}"
                    raise click.UsageError(
                        f"{option.opts[-1]}: wanted {allowance}, got {count} times", ctx
                    )
        return super().parse_args(ctx, args)


@click.command(cls=_Once, short_help="Measure the roughness and the summits in a scan.")
@click.argument("scans", metavar="SCAN…", nargs=-1, type=click.Path(path_type=Path, readable=False))
@offers(CUTOFF.but(default=None), *CONDITIONING[1:], *SUMMITS, SCAN_AREA, *JOINT)
@offers(AGAINST, *DRAWING, *READING)
@click.option(
    "--all", "every_table", is_flag=True, help="Print every table, not what matters most."
)
@writes("report, tables and figures", "one")
def surface(
    scans: tuple[Path, ...],
    every_table: bool,
    folder: Path | None,
    overwrite: bool,
    kinds: tuple[str, ...],
    as_json: bool,
    **options: Any,
) -> None:
    """Measure heights, spectrum and summits in SCAN, an instrument's file or an array.

    Several scans are taken for one face, and averaged. What lies on it is another, by its own
    scans or a drawing; without any SCAN the drawing is all.

    Every parameter hangs on the short-wave cut-off: it stands in each table and figure, and
    parameters over cut-offs are always shown. What matters is printed, the rest with --all and in
    the report. The scan is only read.
    """
    with stoppable():
        from contextlib import ExitStack

        from microslip.errors import said
        from microslip.report.files import write
        from microslip.report.folder import staged
        from microslip.report.terminal import show
        from microslip.results.scanned.document import document
        from microslip.results.scanned.findings import Request, analyse
        from microslip.results.scanned.numbers import FACES_KIND, KIND

        context = click.get_current_context()
        cutoff_given = (
            context.get_parameter_source("cutoff") is not click.core.ParameterSource.DEFAULT
        )
        request = Request.of(*scans, cutoff_given=cutoff_given, **options)
        if not scans and not request.drawing:
            raise click.UsageError("wanted a SCAN, or a drawing such as --ra '0.8 um'", context)
        of_faces = request.is_of_faces
        if of_faces:  # they are made into a study, whose schema takes its time to load
            from microslip.results.scanned import faces
        kind = FACES_KIND if of_faces else KIND
        with ExitStack() as stack:
            stage = None
            if folder is not None:  # first, so that nothing is read in vain
                stage = stack.enter_context(staged(folder, overwrite, kind, "measured scan"))
            with progress("Measuring") as report:
                if of_faces:
                    result = faces.document(faces.analyse(request, report), folder)
                else:
                    findings = analyse(request, report)
            if not of_faces:
                result = document(findings, folder, lambda text: said(text, spelling(context)))
            if stage is not None:
                with progress("Drawing and writing") as report:
                    result = write(result, stage, kinds, report)
    if as_json:
        echo_json(result.data)
        return
    show(result, sys.stdout, full=every_table)
    if not every_table:
        click.echo("All tables, what the verdicts assume and how it was read: --all")
    if folder is not None:
        click.echo(f"{len(result.data['files'])} files in {folder}")
