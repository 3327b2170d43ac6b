"""A page to play with: a joint explored in the browser."""

from __future__ import annotations

from pathlib import Path

import click

from microslip.cli.options import output_option, switch
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
