"""Commands that list metals, schema and figures, or open pages."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from microslip._core.errors import InputError
from microslip._core.units import engineering
from microslip.cli.group import echo_json
from microslip.cli.options import click_option, output_option, progress, stoppable, switch

if TYPE_CHECKING:
    from microslip.contact.materials import Metal


_KEYS = {"young_modulus": "E", "poisson_ratio": "ν", "hardness": "hardness"}


@click.command(short_help="List the metals that a study can name.")
@click.argument("name", required=False)
def materials(name: str | None) -> None:
    """List the metals that a study can name, or show all values of the metal NAME.

    Each value is listed with its source. Values given in a study take precedence.
    """
    from microslip.contact.materials import metal, metals
    from microslip.report.terminal import Printer

    selection = list(metals().values()) if name is None else [metal(name)]
    out = Printer(sys.stdout)
    rows = [[m.name, *(_value(m, key) for key in _KEYS), m.description] for m in selection]
    out.table("", ["metal", *_KEYS.values(), "description"], rows, text=(0, 4))
    if name is None:
        out.line("`microslip materials NAME` lists the source of each value.")
        out.line('In a study: materials = ["steel", "al2017"].')
        out.line("Keys of [material.NAME] take precedence.")
        return
    (shown,) = selection
    for key in _KEYS:
        out.hanging(f"  {key}", shown.sources.get(key, "no source; give your own value"), 18)
    if shown.aliases:
        out.hanging("  also", ", ".join(shown.aliases), 18)
    out.line(f'In Python: microslip.Material.named("{shown.name}")')


def _value(metal: Metal, key: str) -> str:
    value = getattr(metal, key)
    if key == "poisson_ratio":
        return f"{value:g}"
    return engineering(value, "Pa", 4, trim=True)


@click.command(short_help="Print the JSON Schema of the study file.")
def schema() -> None:
    """Print the JSON Schema of the study file, for checks and completion in editors.

    For example: microslip schema > study.schema.json, and as the first line of a study
    "#:schema study.schema.json" (Even Better TOML, Taplo, Tombi).
    """
    from microslip.study.json_schema import json_schema

    echo_json(json_schema())


@click.command(short_help="Draw the figures of the chapter.")
@click_option(
    "--only", "NUMBER", "Figure number such as 19.13; may be repeated or separated by commas.",
    "numbers", multiple=True,
)  # fmt: skip
@output_option(
    "Folder for the figures; by default microslip-figures in the current folder.",
    default=Path("microslip-figures"),
)
@switch("--overwrite", "Replace all earlier figures in that folder.")
def figures(numbers: tuple[str, ...], folder: Path, overwrite: bool) -> None:
    """Draw the figures of the book chapter on which the model is based.

    Each figure is written as SVG and PNG with its data as CSV; summary.json has the captions.
    """
    with stoppable():
        from microslip.chapter import select, write_figures
        from microslip.report.folder import staged

        selection = select(numbers)
        with staged(folder, overwrite, "figures") as stage, progress("Drawing") as report:
            summary = write_figures(selection, stage, report)
    width = max(len(figure["number"]) for figure in summary["figures"])
    for figure in summary["figures"]:
        click.echo(f"{figure['number']:<{width}}  {figure['title']}")
    click.echo(f"\n{len(summary['files'])} files in {folder}")


@click.command(short_help="Open a page to explore a joint interactively.")
@output_option("Write the page to FILE, without opening it.", "FILE", "output")
@switch("--overwrite", "Replace FILE if it exists.")
def explore(output: Path | None, overwrite: bool) -> None:
    """Open a page with sliders for materials, roughness, friction, load and amplitude.

    Loop, backbone, energy and damping update immediately. The page computes in the browser, without
    network or server, and saves the joint as a study.
    """
    import tempfile
    import webbrowser

    from microslip._core.files import atomic_file
    from microslip.app.explorer.page import page

    if output is not None:
        with stoppable(), atomic_file(output, overwrite) as stage:
            stage.write_text(page(), encoding="utf-8", newline="\n")
        click.echo(f"Written to {output}.")
        return
    path = Path(tempfile.mkdtemp(prefix="microslip-")) / "explorer.html"
    path.write_text(page(), encoding="utf-8", newline="\n")
    if not webbrowser.open(path.as_uri()):
        raise InputError(f"no browser found; open {path} in a browser")
    click.echo(f"Opened {path}.")


@click.command(short_help="Open the workbench in the browser.")
@click_option(
    "--port", "PORT", "Local port; a free port if absent.",
    type=click.IntRange(0, 65535), default=0,
)  # fmt: skip
@switch("--no-browser", "Print the address, without opening a browser.")
def app(port: int, no_browser: bool) -> None:
    """Open the workbench in a browser: preview scans and records, run commands, compare results.

    It serves this machine only, at a private address, until Ctrl-C.
    """
    from microslip.app.server import serve
    from microslip.cli.workbench import forms

    commands = click.get_current_context().find_root().command
    assert isinstance(commands, click.Group)
    serve(forms(commands.commands), port, not no_browser, click.echo)
