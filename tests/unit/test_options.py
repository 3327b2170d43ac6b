"""An option is said once: the command, the study, its schema and Python read the same of it."""

from __future__ import annotations

import click
import jsonschema
import pytest

from microslip._core.options import option
from microslip._core.parameters import REQUIRED
from microslip._core.units import LENGTH
from microslip.cli.options import offers
from microslip.study.part import Part, key
from microslip.study.readers import Place

CUTOFF = option(
    "cutoff", "Short-wave cut-off.", LENGTH, default=REQUIRED, example="10 um", none="none"
)
PIXEL = option("pixel", "Distance of neighbours.", LENGTH, example="1.66 um", items=(1, 2))
VALID = option("valid", "Heights.", LENGTH, sign="any", example="-1 mm", items=(2, 2))
OUTLIERS = option("outliers", "Left out.", float, least=2.0, example="6")
LEVEL = option("level", "Form.", default="plane", choices=("plane", "mean"))
TURN = option("sign", "Turn it.", bool, default=False, flag="turn")
ALL = (CUTOFF, PIXEL, VALID, OUTLIERS, LEVEL, TURN)


@click.command()
@offers(*ALL)
def command(**given: object) -> dict[str, object]:
    return given


class Table(Part):
    cutoff: float | None = key(CUTOFF)
    pixel: tuple[float, ...] | None = key(PIXEL)
    valid: tuple[float, ...] | None = key(VALID)
    outliers: float | None = key(OUTLIERS)
    level: str = key(LEVEL)
    sign: bool = key(TURN)


def by_study(**given: object) -> Table:
    return Table.read(given, Place("", None, []))


def by_command(*words: str) -> dict[str, object]:
    return command.main(words, standalone_mode=False)


def test_command_study_schema_and_python_agree() -> None:
    written = {"cutoff": "10 um", "pixel": "2 um", "valid": ["-1 mm", "1 mm"], "outliers": 6,
               "level": "mean", "sign": True}  # fmt: skip
    values = {"cutoff": 1e-5, "pixel": (2e-6,), "valid": (-1e-3, 1e-3), "outliers": 6.0,
              "level": "mean", "sign": True}  # fmt: skip
    words = "--cutoff|10 um|--pixel|2 um|--valid|-1 mm|1 mm|--outliers|6|--level|mean|--turn"
    from_command = by_command(*words.split("|"))
    assert from_command == values
    assert by_study(**written).by_keys() == values
    for declared in ALL:
        assert declared.checked(from_command[declared.name]) == from_command[declared.name]
    schema = Table.schema()
    jsonschema.validate(written, schema)
    assert schema["required"] == ["cutoff"]
    assert schema["properties"]["level"]["default"] == "plane"
    for name, wrong in (("cutoff", 3), ("outliers", 1), ("level", "bent"), ("valid", ["1 mm"])):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**written, name: wrong}, schema)
    # What is not given is the default.
    table = by_study(cutoff="none")
    given = by_command("--cutoff", "none")
    assert given == {name: getattr(table, name) for name in Table.keys}
