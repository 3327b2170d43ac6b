"""Floor 9: what there is to look up."""

from __future__ import annotations

import sys

import click

from microslip.cli.frame import echo_json
from microslip.cli.options import switch
from microslip.cli.shell import complete_metal


@click.command(short_help="List the metals that a study can name.")
@click.argument("name", required=False, shell_complete=complete_metal)
@switch("--json", "Print them as JSON, in SI units.", "as_json")
def materials(name: str | None, as_json: bool) -> None:
    """List the metals that a study can name, or tell all of the metal NAME.

    Each value has its document and year. Own values in a study win.
    """
    from microslip.materials import metal, metals
    from microslip.study.metal_tables import as_dict, show_all, show_one

    selection = list(metals().values()) if name is None else [metal(name)]
    if as_json:
        echo_json({entry.name: as_dict(entry) for entry in selection})
    elif name is None:
        show_all(selection, sys.stdout)
    else:
        show_one(selection[0], sys.stdout)


@click.command(short_help="Print the JSON Schema of the study file.")
def schema() -> None:
    """Print the JSON Schema of the study file, with which editors check and complete it.

    For example: microslip schema > study.schema.json, and as the first line of a study
    "#:schema study.schema.json" (Even Better TOML, Taplo, Tombi).
    """
    from microslip.study.json_schema import json_schema

    echo_json(json_schema())
