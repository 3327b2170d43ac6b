"""Studies whose summit heights are a table of their density."""

from __future__ import annotations

from pathlib import Path

import pytest
from jsonschema import Draft7Validator
from studies import GAUSSIAN, edited

import microslip as ms
from microslip.report.predicted.preview import preview
from microslip.study.json_schema import json_schema

TABLE = (
    '{ kind = "table", height = { file = "h.csv", column = "y" }, '
    'density = ["0 1/um", "2 1/um", "0 1/um"] }'
)
VALIDATOR = Draft7Validator(json_schema())


@pytest.fixture(name="home")
def _home(tmp_path: Path) -> Path:
    (tmp_path / "h.csv").write_text("y [um]\n-1\n0\n1\n")
    return tmp_path


@pytest.mark.slow
def test_heights_by_a_table_of_their_density(home: Path) -> None:
    text = edited((GAUSSIAN, TABLE))
    study = ms.Study.from_toml(text, folder=home)
    VALIDATOR.validate(study._tables)
    surface = study.run().joints[0].surface
    assert isinstance(surface, ms.GreenwoodWilliamson)
    wanted = ms.TabulatedHeights([-1e-6, 0.0, 1e-6], [0.0, 2e6, 0.0])
    assert surface.heights.partial_moment(1.5, 2e-7) == wanted.partial_moment(1.5, 2e-7)
    units = {item["key"]: item["unit"] for item in preview(study).data["quantities"]}
    assert units["surface.heights.height"] == "m"
    assert units["surface.heights.density"] == "1/m"
    assert units["surface.density"] == "1/m^2"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"2 1/um", "0 1/um"', '"2 1/um"', "surface.heights.density: must have one value for each"),
        (
            '"2 1/um"',
            '"-2 1/um"',
            "surface.heights.density, item 2: wanted a number per length of zero",
        ),
        ('"2 1/um"', '"2"', "surface.heights.density, item 2: wanted a number per length such as"),
        ("height =", "hight =", 'surface.heights.hight: unknown key; did you mean "height"?'),
    ],
)
def test_wrong_tables_are_one_line(home: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(edited((GAUSSIAN, TABLE.replace(old, new, 1))), folder=home)
    assert str(caught.value).startswith(f"study: {message}")
