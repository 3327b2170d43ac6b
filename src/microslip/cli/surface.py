"""Floor 9: what a scan of a surface says, and what joint it makes."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from microslip.cli.frame import OneOf, echo_json
from microslip.cli.records import writes
from microslip.cli.spelling import as_options
from microslip.cli.work import progress, stoppable

if TYPE_CHECKING:
    from microslip.study.scanned import Findings, Request

LEVELS = ("plane", "quadratic", "cylinder", "mean", "none")
METHODS = ("watershed", "neighbours")

_TWICE = {"units": "coordinates and heights", "pixels": "x and y"}


class _Once(click.Command):
    """A command that does not take the last of two options for granted."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click's; an option is refused where it is there more often than it may be."""
        if not ctx.resilient_parsing:
            _, _, order = self.make_parser(ctx).parse_args(args=list(args))
            for option, count in Counter(order).items():
                if not isinstance(option, click.Option) or option.is_flag:
                    continue
                twice = _TWICE.get(option.name or "")
                if count > (1 if twice is None else 2):
                    wanted = "once" if twice is None else f"once, or twice for {twice}"
                    raise click.UsageError(
                        f"{option.opts[-1]}: wanted {wanted}, got {count} times", ctx
                    )
        return super().parse_args(ctx, args)


@click.command(cls=_Once, short_help="Measure the roughness and the summits in a scan.")
@click.argument("scan", metavar="SCAN", type=click.Path(path_type=Path, readable=False))
@click.option(
    "--cutoff",
    metavar="LENGTH",
    help='Short-wave cut-off, such as "10 um", or none. It decides the result.',
)
@click.option("--long-cutoff", metavar="LENGTH", help='Long-wave cut-off, such as "0.8 mm".')
@click.option(
    "--level",
    type=OneOf(LEVELS),
    default=LEVELS[0],
    show_default=True,
    help="Form that is removed first.",
)
@click.option(
    "--outliers",
    type=float,
    metavar="X",
    help="Leave out points beyond so many robust standard deviations; 6 is usual.",
)
@click.option("--fill", is_flag=True, help="Interpolate missing points from around them.")
@click.option(
    "--method",
    type=OneOf(METHODS),
    default=METHODS[0],
    show_default=True,
    help="What counts as a summit.",
)
@click.option(
    "--prominence",
    metavar="LENGTH",
    help='Least rise of a summit above its saddle, such as "2 nm"; else from the noise.',
)
@click.option("--area", metavar="AREA", help='Apparent area of the joint, such as "2 cm^2".')
@click.option("--format", "kind", metavar="FORMAT", help="Format of the file, such as plu or npy.")
@click.option(
    "--unit",
    "units",
    metavar="UNIT",
    multiple=True,
    help="Unit of the heights, where the file has none; twice, of coordinates and of heights.",
)
@click.option(
    "--pixel",
    "pixels",
    metavar="LENGTH",
    multiple=True,
    help='Distance of neighbours, such as "1.66 um"; twice, for x and for y.',
)
@click.option(
    "--valid",
    nargs=2,
    metavar="LOW HIGH",
    help='Possible heights, such as "-1 mm" "1 mm"; points beyond are missing.',
)
@click.option("--key", metavar="NAME", help="Array of a file that holds several.")
@click.option("--channel", metavar="NAME", help="Channel of an instrument's file, or its number.")
@writes("report, tables and figures", "one")
def surface(
    scan: Path,
    cutoff: str | None,
    long_cutoff: str | None,
    level: str,
    outliers: float | None,
    fill: bool,
    method: str,
    prominence: str | None,
    area: str | None,
    kind: str | None,
    units: tuple[str, ...],
    pixels: tuple[str, ...],
    valid: tuple[str, str] | None,
    key: str | None,
    channel: str | None,
    folder: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Measure heights, spectrum and summits in SCAN, an instrument's file or an array.

    Every parameter hangs on the short-wave cut-off: it stands in each table and figure, and the
    parameters over cut-offs are always shown. The scan is only read.
    """
    with stoppable():
        from contextlib import ExitStack

        from microslip.study.scanned import Request, analyse
        from microslip.study.scanned_files import write
        from microslip.study.scanned_summary import KIND, summarise
        from microslip.study.scanned_tables import show

        unit: Any = units if len(units) > 1 else units[0] if units else None
        request: Request = Request.of(
            scan,
            cutoff=cutoff,
            long_cutoff=long_cutoff,
            level=level,
            outliers=outliers,
            fill=fill,
            method=method,
            prominence=prominence,
            area=area,
            format=kind,
            unit=unit,
            pixel=pixels,
            valid=valid,
            key=key,
            channel=channel,
        )
        with ExitStack() as stack:
            stage = None
            if folder is not None:  # first, so that nothing is read in vain
                from microslip.report.folder import staged

                stage = stack.enter_context(staged(folder, overwrite, KIND, "measured scan"))
            with progress("Measuring") as report:
                found = _spelt(analyse(request, report))
            if stage is None:
                summary = summarise(found)
            else:
                with progress("Drawing and writing") as report:
                    summary = write(found, stage, report, folder)
    if as_json:
        echo_json(summary)
        return
    show(summary, sys.stdout)
    if folder is not None:
        click.echo(f"{len(summary['files'])} files in {folder}")


def _spelt(found: Findings) -> Findings:
    """Findings that say what a reader has to know as a command does."""
    from dataclasses import replace

    from microslip.scans.file_reading import SUSPECT

    told = [note.removeprefix(SUSPECT) for note in found.raw.notes if note.startswith(SUSPECT)]
    if found.request.outliers is not None:
        told = []  # what was left out is no more to be suspected
    return replace(
        found, reasons=tuple(as_options("surface", text) for text in (*told, *found.reasons))
    )
