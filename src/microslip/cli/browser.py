"""Commands that open a browser: the page of a joint, and the workbench."""

from __future__ import annotations

from pathlib import Path

import click

from microslip.cli.options import option, output_option, switch
from microslip.cli.work import stoppable
from microslip.errors import InputError


@click.command(short_help="Open a page on which a joint can be explored.")
@output_option("Write the page there and open nothing.", "FILE", "output")
@switch("--overwrite", "Replace FILE if it is there.")
def explore(output: Path | None, overwrite: bool) -> None:
    """Open a page with sliders for materials, roughness, friction, load and amplitude.

    Loop, backbone, energy and damping follow at once; the page computes by itself, without network
    or server, and saves what was found as a study.
    """
    import tempfile
    import webbrowser

    from microslip._core.files import whole_file
    from microslip.explorer.page import page

    if output is not None:
        with stoppable(), whole_file(output, overwrite) as stage:
            stage.write_text(page(), encoding="utf-8", newline="\n")
        click.echo(f"Written to {output}.")
        return
    path = Path(tempfile.mkdtemp(prefix="microslip-")) / "explorer.html"
    path.write_text(page(), encoding="utf-8", newline="\n")
    if not webbrowser.open(path.as_uri()):
        raise InputError(f"no browser was found here; open {path} with one")
    click.echo(f"Opened {path}.")


@click.command(short_help="Open the workbench in the browser.")
@option(
    "--port", "PORT", "Port of this machine to listen at; one that is free if absent.",
    type=click.IntRange(0, 65535), default=0,
)  # fmt: skip
@switch("--no-browser", "Print the address, and open nothing.")
def app(port: int, no_browser: bool) -> None:
    """Open the workbench: look at scans and records, choose with the mouse, run and compare.

    It serves this machine alone, under an address that only you know, until Ctrl-C.
    """
    from microslip.app.server import serve
    from microslip.cli.forms import forms

    commands = click.get_current_context().find_root().command
    assert isinstance(commands, click.Group)  # this command is one of it
    serve(forms(commands.commands), port, not no_browser, click.echo)
