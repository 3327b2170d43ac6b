"""Floor 8: the JSON Schema of study files, by which editors complete, explain and check them.

It is read off the models of a study; ``python -m microslip.study.json_schema`` prints it. A copy of
it is shipped as ``study.schema.json``.
"""

from __future__ import annotations

import json
import tomllib
from collections import Counter
from collections.abc import Callable
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from microslip.materials import Metal, metals
from microslip.study.columns import Column, FromFile
from microslip.study.part import Check, JsonSchema, Part
from microslip.study.schema import StudyTables
from microslip.study.surfaces import Elastic
from microslip.study.uncertain import Uncertain

DRAFT = "http://json-schema.org/draft-07/schema#"

_PLAIN: dict[Any, JsonSchema] = {
    str: {"type": "string"},
    float: {"type": "number"},
    int: {"type": "integer"},
    bool: {"type": "boolean"},
}


def json_schema() -> JsonSchema:
    """JSON Schema (draft 7) of a study file; what it says more than once stands there once."""
    return {"$schema": DRAFT, **_folded(schema_tree())}


def schema_tree() -> JsonSchema:
    """The same without references: every key with its whole schema."""
    schema = _table(StudyTables)
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


def _table(model: type[Part]) -> JsonSchema:
    fields = {field.alias or name: field for name, field in model.model_fields.items()}
    # The alternatives of a union are told apart, and named, by their law or kind.
    names = [_type(fields[key].annotation)["const"] for key in ("law", "kind") if key in fields]
    schema: JsonSchema = {
        "type": "object",
        **({"title": names[0]} if names else {}),
        "description": (model.__doc__ or "").split("\n")[0],
        "properties": {key: _key(key, field) for key, field in fields.items()},
        "required": [key for key, field in fields.items() if field.is_required()],
        "additionalProperties": False,
    }
    extra = model.model_config.get("json_schema_extra")
    return {**schema, **extra} if isinstance(extra, dict) else schema


def _key(key: str, field: FieldInfo) -> JsonSchema:
    schema = _value(field.annotation, field.metadata)
    schema["title"] = key.replace("_", " ").capitalize()
    usage = schema.get("description", "") if schema.get("type") == "string" else ""
    schema["description"] = f"{field.description} {usage}".strip()
    examples = [tomllib.loads(f"x = {text}")["x"] for text in field.examples or () if text]
    if examples:
        schema["examples"] = examples
    if isinstance(field.default, tuple) and field.default:
        schema["default"] = list(field.default)
    elif isinstance(field.default, (bool, int, str)) and field.default != "":
        schema["default"] = field.default
    return schema


def _value(annotation: Any, metadata: list[Any]) -> JsonSchema:
    """Schema of a type with what is annotated to it."""
    if get_origin(annotation) is Annotated:
        annotation, *annotated = get_args(annotation)
        return _value(annotation, [*annotated, *metadata])
    schema = _type(annotation)
    for item in metadata:
        if isinstance(item, (Check, Uncertain)):
            schema = item.describe(schema)
        elif isinstance(item, FromFile):
            schema = {"anyOf": [*schema.get("anyOf", [schema]), _table(Column)]}
    return schema


def _type(annotation: Any) -> JsonSchema:
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        return {"const": arguments[0]} if len(arguments) == 1 else {"enum": list(arguments)}
    if origin in (Union, UnionType):
        choices = [_value(choice, []) for choice in arguments if choice is not type(None)]
        return choices[0] if len(choices) == 1 else {"oneOf": choices}
    if origin is tuple:
        return {"type": "array", "items": _value(arguments[0], [])}
    if origin is dict:
        return {"type": "object", "additionalProperties": _value(arguments[1], [])}
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return _table(annotation)
    return dict(_PLAIN[annotation])


def _metal(metal: Metal) -> JsonSchema:
    remark = "what is left out is taken from the table of metals"
    schema = _table(Elastic)
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
