"""Every option of every command, from its declaration: shown in help, wrong values are refused."""

from __future__ import annotations

import math

import click
import pytest
from command import fails, run

from microslip._core.units import Kind
from microslip.cli import main
from microslip.cli.options import CommandOption

ARGUMENTS = {
    "new": ["joint.toml"],
    "measure": ["record.csv"],
    "identify": ["record.csv"],
    "surface": ["scan.csv"],
    "check": ["joint.toml"],
    "predict": ["joint.toml"],
    "batch": ["changes.csv", "--study", "joint.toml"],
    "export": ["c", "joint.toml"],
}


# In an empty folder a value that is accepted fails at the file that is missing.
pytestmark = pytest.mark.usefixtures("here")
OPTIONS = [
    pytest.param(name, option, id=f"{name} {option.opts[-1]}")
    for name, command in main.commands.items()
    for option in command.params
    if isinstance(option, click.Option)
]


@pytest.mark.parametrize("name", main.commands)
def test_help_shows_every_option_with_its_meaning(name: str) -> None:
    text = " ".join(run(name, "--help").output.split())
    for option in main.commands[name].params:
        if isinstance(option, click.Option):
            assert option.opts[-1] in text
            assert option.help
            assert " ".join(option.help.split())[:20] in text, option.name


def wrong_values(option: click.Option) -> list[str]:
    """Values that are of another kind, of another unit, or past a limit."""
    if option.is_flag or option.nargs != 1:
        return []
    if isinstance(option.type, (click.types.IntParamType, click.types.FloatParamType)):
        return ["much"]
    if not isinstance(option, CommandOption):
        return ["no choice of it"] if type(option.type).__name__ == "OneOf" else []
    declared = option.option
    if declared.choices and not declared.none:
        return ["no choice of it"]
    values = []
    if isinstance(declared.kind, Kind):
        values = ["1 candela", "much"]
    elif declared.kind in (int, float):
        values = ["much"]
    if declared.kind in (int, float):
        for limit, past in ((declared.least, -1.0), (declared.most, 1.0)):
            if math.isfinite(limit):
                values.append(f"{limit + past * max(1.0, abs(limit)):g}")
        values += [f"{v:g}" for v in (declared.above, declared.below) if math.isfinite(v)]
    return values


WRONG = [
    pytest.param(*case.values, value, id=f"{case.id} {value}")
    for case in OPTIONS
    for value in wrong_values(case.values[1])  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("name", "option", "value"), WRONG)
def test_a_wrong_value_is_one_line_that_names_the_option(
    name: str, option: click.Option, value: str
) -> None:
    line = fails(name, *ARGUMENTS.get(name, ()), f"{option.opts[-1]}={value}")
    assert option.opts[-1] in line
