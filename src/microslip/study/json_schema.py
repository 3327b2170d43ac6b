"""JSON Schema of study files, used by editors for completion, help and validation.

It is generated from the tables of a study and printed by ``python -m microslip.study.json_schema``.
A copy is shipped as ``study.schema.json``.
"""

from __future__ import annotations

import json

from microslip._core.parameters import JsonSchema
from microslip.contact.materials import Metal, metals
from microslip.study.schema import StudyTables
from microslip.study.surfaces import Elastic

DRAFT = "http://json-schema.org/draft-07/schema#"


def json_schema() -> JsonSchema:
    """Return the JSON Schema (draft 7) of a study file."""
    schema = StudyTables.schema()
    material = schema["properties"]["material"]
    # Values of a metal of the table are optional.
    material["properties"] = {name: _metal(metal) for name, metal in metals().items()}
    return {"$schema": DRAFT, **schema, "title": "A study of microslip"}


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
