"""The JSON Schema of studies: in step with the models, true to studies, shipped."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator
from studies import AMPLITUDES, GAUSSIAN, LOADS, MATERIAL, SURFACE, SURFACES, edited

import microslip as ms
from microslip.study.json_schema import complete_schema, json_schema
from microslip.study.toml_text import FILE_KEYS

ROOT = Path(__file__).parents[2]
LINE = f"amplitudes = {AMPLITUDES}"
SCHEMA = json_schema()
VALIDATOR = Draft7Validator(SCHEMA)


def shown_studies() -> Iterator[Any]:
    """Studies of the examples and of the documentation; parts replace tables of the first."""
    for path in sorted((ROOT / "examples").glob("*.toml")):
        yield pytest.param(tomllib.loads(path.read_text(encoding="utf-8")), id=path.name)
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        text = page.read_text(encoding="utf-8")
        first: dict[str, Any] = {}
        for count, block in enumerate(re.findall(r"(?ms)^```toml\n(.*?)^```", text)):
            data = tomllib.loads(block)
            first = first or data
            yield pytest.param({**first, **data}, id=f"{page.name}-{count}")


def test_it_is_a_schema() -> None:
    Draft7Validator.check_schema(SCHEMA)
    assert SCHEMA["$schema"].startswith("http://json-schema.org/draft-07/")


def test_the_build_writes_it() -> None:
    shipped = files("microslip.study").joinpath("study.schema.json").read_text(encoding="utf-8")
    assert json.loads(shipped) == SCHEMA, "make install writes it anew"
    command = [sys.executable, "-m", "microslip.study.json_schema"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert printed == shipped
    assert len(shipped) < 200_000, "repeated parts are references"


@pytest.mark.parametrize("study", list(shown_studies()))
def test_every_study_that_is_shown_is_valid(study: dict[str, Any]) -> None:
    VALIDATOR.validate(study)


@pytest.mark.parametrize("name", SURFACES)
def test_every_law_and_kind_is_valid(name: str) -> None:
    VALIDATOR.validate(tomllib.loads(edited((SURFACE, SURFACES[name]))))


VALID = [
    (LOADS, '"2 kN"'),
    (LOADS, '".5 kN"'),
    (LOADS, '"1_000 N"'),
    ('"1 mm"', '"1 µm"'),
    ('"2 cm^2"', '"2 cm²"'),
    ('"100 1/mm^2"', '"100 mm⁻²"'),
    ('"100 1/mm^2"', '"100/mm^2"'),
    (MATERIAL, MATERIAL + "[material.anvil]\nrigid = true\n"),
    (MATERIAL, MATERIAL + "[material.steel]\nrigid = true\n"),
    (MATERIAL, MATERIAL + '[material.steel]\nyoung_modulus = "205 GPa"\n'),
    (GAUSSIAN, '{ kind = "gaussian", std = "1 um", mean = "-1 um" }'),
    (GAUSSIAN, '{ kind = "gaussian", std = "1 um", mean = "\N{MINUS SIGN}1 um" }'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "norm", location = "-1 um", scale = "1 um" }'),
    (LINE, 'force_amplitudes = ["50 N"]'),
    ('["csv"]', '["netcdf", "png"]\nreport = false'),
]


@pytest.mark.parametrize(("old", "new"), VALID)
def test_what_is_read_is_valid(old: str, new: str) -> None:
    text = edited((old, new))
    ms.Study.from_toml(text)
    VALIDATOR.validate(tomllib.loads(text))


GROSS = [
    ("schema = 1", "schema = 2"),
    ('title = "A joint"', "title = 3"),
    ('title = "A joint"', 'titel = "A joint"'),
    ("[joint]", "[joints]"),
    ("0.33", "0.7"),
    ("0.33", '"0.33"'),
    ("0.55", "0"),
    ('"69 GPa"', "69e9"),
    ('"69 GPa"', '"-69 GPa"'),
    ('"69 GPa"', '"69,5 GPa"'),
    ('"69 GPa"', '"69 000 MPa"'),
    ('young_modulus = "69 GPa"\n', ""),
    (MATERIAL, MATERIAL + '[material.anvil]\nrigid = true\nhardness = "1 GPa"\n'),
    (MATERIAL, MATERIAL + '[material.steel]\nstiffness = "1 GPa"\n'),
    ('["al", "al"]', '["al"]'),
    ('"greenwood-williamson"', '"greenwood"'),
    ('"greenwood-williamson"', '"sphere"'),
    ('radius = "1 mm"\n', ""),
    ("std =", "scale ="),
    (GAUSSIAN, '{ kind = "values" }'),
    (GAUSSIAN, '{ kind = "values", values = [] }'),
    (GAUSSIAN, '{ kind = "values", values = [1e-6] }'),
    (GAUSSIAN, '{ kind = "values", values = ["1 um"], file = "x.csv", column = "x" }'),
    (GAUSSIAN, '{ kind = "scipy", scale = "1 um" }'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "expon", parameters = { c = "2" } }'),
    (LOADS, "[]"),
    (LOADS, '["2 kN", 500]'),
    (AMPLITUDES, '"1 um"'),
    (LINE, LINE + '\nforce_amplitudes = ["50 N"]'),
    (LINE, 'history = { file = "x.csv" }'),
    (LINE, 'history = { file = "x.csv", column = "x", quantity = "velocity" }'),
    ("points = 20", "points = 1"),
    ('from = "1 nm", ', ""),
    ('["csv"]', '["gif"]'),
    ('["csv"]', '["csv"]\nreport = "yes"'),
]


@pytest.mark.parametrize(("old", "new"), GROSS)
def test_gross_mistakes_are_not_valid(old: str, new: str) -> None:
    text = edited((old, new))
    assert not VALIDATOR.is_valid(tomllib.loads(text))
    with pytest.raises(ms.StudyError):
        ms.Study.from_toml(text)


def keys(schema: dict[str, Any], path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every key of every table, with its schema."""
    for name, inner in schema.get("properties", {}).items():
        yield f"{path}.{name}", inner
        yield from keys(inner, f"{path}.{name}")
    for word in ("oneOf", "anyOf"):
        for choice in schema.get(word, ()):
            yield from keys(choice, path)
    if isinstance(schema.get("additionalProperties"), dict):
        yield from keys(schema["additionalProperties"], f"{path}.NAME")


def test_every_key_is_explained_to_an_editor() -> None:
    found = dict(keys(complete_schema()))
    assert len(found) > 40
    for path, schema in found.items():
        assert schema["title"], path
        assert schema["description"].endswith("."), path
        if schema.get("type") == "string":
            assert schema.keys() & {"examples", "enum"} or path == ".title", path
        for example in schema.get("examples", ()):
            Draft7Validator(schema).validate(example)
        if "default" in schema:
            Draft7Validator(schema).validate(schema["default"])


def test_keys_that_name_files_are_known() -> None:
    """A study is moved, and refused by the workbench, by these keys."""
    found = {
        path.rpartition(".")[2]
        for path, schema in keys(complete_schema())
        if re.search(
            "[Nn]ame of (a|the) .*file|[Ff]older (that|written)",
            json.dumps(schema.get("description")),
        )
        or "relative to the folder" in schema["description"]
    }
    assert found == set(FILE_KEYS)
