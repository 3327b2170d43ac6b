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

from microslip.study.json_schema import complete_schema, json_schema

ROOT = Path(__file__).parents[2]
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
