"""The JSON Schema of study files, by which editors complete, explain and check them.

It is read off the models of a study; ``python -m microslip.study.json_schema`` prints it. A copy of
it is shipped as ``study.schema.json``.
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
    """JSON Schema (draft 7) of a study file; what it says more than once stands there once."""
    return {"$schema": DRAFT, **_folded(schema_tree())}


def schema_tree() -> JsonSchema:
    """The same without references: every key with its whole schema."""
    schema = StudyTables.schema()
    material = schema["properties"]["material"]
    # A metal of the table may leave its values to the table.
    material["properties"] = {name: _metal(metal) for name, metal in metals().items()}
    return {**schema, "title": "A study of microslip"}


def _folded(schema: JsonSchema) -> JsonSchema:
    """The same schema, with what it says more than once under its definitions."""
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
    """A schema whose parts, schemas themselves, are changed."""
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
    remark = "what is left out is taken from the table of metals"
    schema = Elastic.schema()
    schema["properties"]["rigid"] |= {"type": "boolean"}
    del schema["properties"]["rigid"]["const"]
    return {
        **schema,
        "title": metal.name,
        "description": f"{metal.description}; {remark}.",
        "required": [],
    }


def main() -> None:
    """Print the schema."""
    print(json.dumps(json_schema(), indent=1))


if __name__ == "__main__":
    main()
