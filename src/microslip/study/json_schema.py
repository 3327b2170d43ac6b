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


def json_schema() -> JsonSchema:
    """Return the JSON Schema (draft 7) of a study file, with references for repeated parts."""
    return {"$schema": DRAFT, **_folded(schema_tree())}


def schema_tree() -> JsonSchema:
    """Return the JSON Schema of a study file with every part written out, without references."""
    schema = StudyTables.schema()
    material = schema["properties"]["material"]
    # Values of a metal of the table are optional.
    material["properties"] = {name: _metal(metal) for name, metal in metals().items()}
    return {**schema, "title": "A study of microslip"}


def _folded(schema: JsonSchema) -> JsonSchema:
    uses: Counter[str] = Counter()
    definitions: dict[str, JsonSchema] = {}
    names: dict[str, str] = {}

    def count(part: JsonSchema) -> JsonSchema:
        text = json.dumps(part)
        uses[text] += 1
        return part if uses[text] > 1 else _parts(part, count)

    def fold(part: JsonSchema) -> JsonSchema:
        text = json.dumps(part)
        if uses[text] < 2 or len(text) < 100:
            return _parts(part, fold)
        if text not in names:
            stem = str(part.get("title", "value")).lower().replace(" ", "-")
            alike = sum(name.rpartition("-")[0] == stem for name in names.values())
            names[text] = f"{stem}-{alike + 1}"
            definitions[names[text]] = _parts(part, fold)
        return {"$ref": f"#/definitions/{names[text]}"}

    _parts(schema, count)
    return {**_parts(schema, fold), "definitions": definitions}


def _parts(schema: JsonSchema, change: Callable[[JsonSchema], JsonSchema]) -> JsonSchema:
    """Return a copy of a schema with ``change`` applied to its direct subschemas."""
    changed = dict(schema)
    for key in ("items", "additionalProperties"):
        if isinstance(changed.get(key), dict):
            changed[key] = change(changed[key])
    for key in ("anyOf", "oneOf"):
        if key in changed:
            changed[key] = [change(part) for part in changed[key]]
    if "properties" in changed:
        changed["properties"] = {name: change(part) for name, part in changed["properties"].items()}
    return changed


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


def print_schema() -> None:
    """Print the schema."""
    print(json.dumps(json_schema(), indent=1))


if __name__ == "__main__":
    print_schema()
