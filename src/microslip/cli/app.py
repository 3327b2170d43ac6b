"""The workbench in the browser."""

from __future__ import annotations

import click

from microslip.cli.options import option, switch


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

    serve(port, not no_browser, click.echo)
