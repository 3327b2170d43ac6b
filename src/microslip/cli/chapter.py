"""The figures of the chapter."""

from __future__ import annotations

from pathlib import Path

import click

from microslip.cli.group import echo_json
from microslip.cli.options import option, output_option, switch
from microslip.cli.work import progress, stoppable


@click.command(short_help="Draw the figures of the chapter.")
@option(
    "--only", "NUMBER", "One figure, such as 19.13; may be repeated, or several with commas.",
    "numbers", multiple=True,
)  # fmt: skip
@output_option(
    "Folder for the figures; by default microslip-figures in the current folder.",
    default=Path("microslip-figures"),
)
@switch("--overwrite", "Replace earlier figures in that folder, all.")
@switch("--json", "Print the summary as JSON.", "as_json")
def figures(numbers: tuple[str, ...], folder: Path, overwrite: bool, as_json: bool) -> None:
    """Draw the figures of the chapter that the model comes from, each from this library.

    Each comes as SVG and PNG with its data as CSV; summary.json says what to see in them.
    """
    with stoppable():
        from microslip.chapter import KIND, select, write
        from microslip.report.folder import staged

        selection = select(numbers)
        with (
            staged(folder, overwrite, KIND, "set of figures") as stage,
            progress("Drawing") as report,
        ):
            summary = write(selection, stage, report)
    if as_json:
        echo_json(summary)
        return
    width = max(len(figure["number"]) for figure in summary["figures"])
    for figure in summary["figures"]:
        click.echo(f"{figure['number']:<{width}}  {figure['title']}")
    click.echo(f"\n{len(summary['files'])} files in {folder}")
