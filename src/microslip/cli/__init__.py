"""Command line: parses options, calls the library and prints results.

NumPy is imported at the first computation, so that help is printed fast.
"""

from __future__ import annotations

import click

from microslip._version import __version__
from microslip.cli.export import export
from microslip.cli.group import Group
from microslip.cli.identify import identify
from microslip.cli.lists import app, explore, figures, materials, schema
from microslip.cli.measure import measure
from microslip.cli.studies import batch, check, demo, new, predict
from microslip.cli.surface import surface

__all__ = ["main"]


def _print_version(context: click.Context, option: click.Parameter, value: bool) -> None:
    if value and not context.resilient_parsing:
        click.echo(f"microslip {__version__}")
        context.exit()


@click.group(
    cls=Group,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 success, 1 internal error, 2 wrong input (explained in one line), "
    "130 interrupted, 143 terminated.",
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Show version and kernel.",
)
@click.pass_context
def main(context: click.Context) -> None:
    """Friction, hysteresis and damping of rough joints.

    Start with: microslip demo, or microslip new joint.toml.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


# Order of the commands in the help.
for _command in (
    *(demo, new, check, predict, batch, measure, identify, surface, export),
    *(materials, schema, figures, explore, app),
):
    main.add_command(_command)
