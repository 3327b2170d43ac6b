"""JSON Schema of study files, used by editors for completion, help and validation.

It is generated from the tables of a study and printed by ``python -m microslip.study.json_schema``.
A copy is shipped as ``study.schema.json``.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable

from microslip._core.parameters import JsonSchema
from microslip.contact.materials import Metal, metals
from microslip.study.schema import StudyTables
from microslip.study.surfaces import Elastic

DRAFT = "http://json-schema.org/draft-07/schema#"
_SHORTEST = 120
"""Length of the text from which a repeated schema is written once, under "definitions"."""


def json_schema() -> JsonSchema:
    """Return the JSON Schema (draft 7) of a study file."""
    schema = with_definitions(complete_schema())
    return {"$schema": DRAFT, **schema, "title": "A study of microslip"}


def complete_schema() -> JsonSchema:
    """Return the schema of a study file without references, each key in its place."""
    schema = StudyTables.schema()
    material = schema["properties"]["material"]
    # Values of a metal of the table are optional.
    material["properties"] = {name: _metal(metal) for name, metal in metals().items()}
    return schema


def _metal(metal: Metal) -> JsonSchema:
    remark = "omitted values are taken from the table of metals"
    schema = Elastic.schema()
    schema["properties"]["rigid"] |= {"type": "boolean"}
    del schema["properties"]["rigid"]["const"]
    return {
        **schema,
        "title": metal.name,
        "description": f"{metal.description}; {remark}.",
        "required": [],
    }


def with_definitions(schema: JsonSchema) -> JsonSchema:
    """Return an equivalent schema in which repeated parts are references to "definitions"."""
    counts: Counter[str] = Counter()

    def count(part: JsonSchema) -> JsonSchema:
        text = json.dumps(part)
        counts[text] += 1
        return _with_parts(part, count) if counts[text] == 1 else part

    count(schema)
    numbers: dict[str, int] = {}
    definitions: JsonSchema = {}

    def share(part: JsonSchema) -> JsonSchema:
        text = json.dumps(part)
        if counts[text] == 1 or len(text) < _SHORTEST:
            return _with_parts(part, share)
        name = str(numbers.setdefault(text, len(numbers) + 1))
        if name not in definitions:
            definitions[name] = None  # keeps the order in which the definitions are met
            definitions[name] = _with_parts(part, share)
        return {"$ref": f"#/definitions/{name}"}

    return {**share(schema), "definitions": definitions}


def _with_parts(schema: JsonSchema, change: Callable[[JsonSchema], JsonSchema]) -> JsonSchema:
    """Return a schema with a function applied to each schema that it contains."""
    changed = dict(schema)
    for key, value in schema.items():
        if key == "properties":
            changed[key] = {name: change(part) for name, part in value.items()}
        elif key in ("anyOf", "oneOf"):
            changed[key] = [change(part) for part in value]
        elif key in ("items", "additionalProperties") and isinstance(value, dict):
            changed[key] = change(value)
    return changed


if __name__ == "__main__":
    print(json.dumps(json_schema(), indent=1))
