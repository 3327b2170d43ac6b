"""Floor 10: what pydantic found wrong with a study, as one line that says what to write instead."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, get_args

from pydantic import ValidationError

from microslip._core.wording import did_you_mean, nearest, plural, quoted, shorten, show
from microslip.materials import metals
from microslip.study.columns import Column
from microslip.study.faces import FACES
from microslip.study.heights import HEIGHTS_TABLES, GivenHeights, distribution_names
from microslip.study.joints import INTERFACE, LAW_TABLES, Joint
from microslip.study.overrides import Override
from microslip.study.part import KeyedError, Part
from microslip.study.pressure import PRESSURES
from microslip.study.schema import StudyTables
from microslip.study.surfaces import SURFACE_TABLES, Elastic, Rigid

Loc = tuple[int | str, ...]


def _tables_in(model: type[Part]) -> Iterator[tuple[str, type[Part]]]:
    """Keys below a table that hold tables of one kind, and these; not those of a law or a kind."""
    for name, field in model.model_fields.items():
        kinds = [field.annotation, *get_args(field.annotation)]
        parts = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Part)]
        if len(parts) == 1:
            yield field.alias or name, parts[0]
            yield from _tables_in(parts[0])


# The models by the last part of pydantic's location, which is the tag in a union.
_MODELS: dict[str, type[Part]] = {
    **dict(_tables_in(StudyTables)),
    "elastic": Elastic,
    "rigid": Rigid,
    INTERFACE: Joint,
}
_FACES = ("first", "second")
_TABLES_BY_KEY: dict[str, dict[str, type[Part]]] = {
    "joint": {INTERFACE: Joint, **LAW_TABLES},
    "surface": SURFACE_TABLES,
    "heights": HEIGHTS_TABLES,
    **dict.fromkeys(_FACES, FACES),
    "pressure": PRESSURES,
}
"""The tables among which a law or a kind chooses."""
_TABLES = {
    "heights": '{ kind = "gaussian", std = "0.5 um" }',
    **dict.fromkeys(_FACES, '{ ra = "0.8 um", rsm = "60 um" }'),
    "pressure": '{ kind = "cone", outer = "8 mm" }',
    "curve": '{ from = "1 nm", to = "100 um", points = 200 }',
    "history": '{ file = "record.csv", column = "x", unit = "um" }',
    "load_variation": '{ amplitude = "400 N", phase = "90 deg" }',
    "normal_load": '{ column = "load", unit = "N" }',
    "oscillator": '[oscillator] with mass = "2 kg" and stiffness = "1e6 N/m"',
    "bolts": "[structure.bolts] with positions, shank, hole, washer and tension",
    "mesh": "[structure.mesh] with file, bodies, contacts and bolts",
    "sensor": '{ at = ["0.36 m", "0 m", "0 m"], direction = "z" }',
    "form": '{ file = "form.csv", x = "x", y = "y", gap = "gap" }',
    "measured": '{ file = "test.csv" }',
    "parameters": "{ c = 2.0 }",
    "material": '[material.steel] with young_modulus = "210 GPa" and poisson_ratio = 0.3',
}
_PLAIN_HOMES = (
    *("excitation", "oscillator", "uncertainty"),
    *("structure", "structure.bolts", "structure.mesh", "output"),
)
_NOT_A_TABLE = ("model_type", "model_attributes_type", "dict_type")


def explain(error: ValidationError, data: dict[str, Any], changes: Sequence[Override] = ()) -> str:
    """First thing that is wrong, and how many more there are."""
    errors: list[dict[str, Any]] = [dict(item) for item in error.errors(include_url=False)]
    errors = [item for item in errors if not _is_echo(item, errors)]
    errors.sort(key=lambda item: _place(item["loc"]))
    key, message = _line(errors[0], data)
    extra = len(errors) - 1
    suffix = f" (and {plural(extra, 'more error')})" if extra else ""
    return f"{key}{_blamed(key, changes)}: {message}{suffix}"


def _blamed(key: str, changes: Sequence[Override]) -> str:
    """The override that gave a key its value, in brackets."""
    path = f"{key.split(', item')[0]}."
    for change in reversed(changes):
        if path.startswith(f"{change.blamed}.") or f"{change.blamed}.".startswith(path):
            return f' (override "{shorten(change.text, 80)}")'
    return ""


def _dotted(loc: Loc, data: Any) -> str:
    """Pydantic's location as the path of keys in the file."""
    words: list[str] = []
    for index, part in enumerate(loc):
        if isinstance(part, int):
            # One value may stand where a list is wanted, and then it is no item.
            words[-1] += f", item {part + 1}" if isinstance(data, (list, tuple)) else ""
        elif not _is_tag(loc, index):
            words.append(shorten(part, 40))
            data = data.get(part) if isinstance(data, dict) else getattr(data, part, None)
    return ".".join(words)


def _is_tag(loc: Loc, index: int) -> bool:
    """Whether a part of a location is pydantic's choice of a model and no key of the file."""
    if loc[0] == "material":
        return index == 2
    if loc[0] not in ("surface", "joint") or index == 0:
        return False
    return index == 1 or loc[index - 1] in (
        ("heights", *_FACES) if loc[0] == "surface" else ("pressure",)
    )


def _place(loc: Loc) -> int:
    """Rank of the top-level table, so that the first error is the first in reading order."""
    order = [field.alias or name for name, field in StudyTables.model_fields.items()]
    return order.index(str(loc[0])) if loc and loc[0] in order else -1


def _model_at(loc: Loc) -> type[Part]:
    """Table whose key is the last part of a location."""
    if len(loc) == 1:
        return StudyTables
    names = ["", *(part for part in loc if isinstance(part, str))]
    place, table = names[-3:-1]
    # What is no table of its own is a list that a column of a file stands for.
    return _TABLES_BY_KEY.get(place, {}).get(table) or _MODELS.get(table, Column)


def _keys(model: type[Part]) -> list[str]:
    return [field.alias or name for name, field in model.model_fields.items()]


def _is_echo(item: dict[str, Any], errors: list[dict[str, Any]]) -> bool:
    """Whether a key is only missing because it is there, misspelt."""
    if item["type"] != "missing":
        return False
    key = str(item["loc"][-1])
    return any(
        sibling["type"] == "extra_forbidden"
        and sibling["loc"][:-1] == item["loc"][:-1]
        and nearest(str(sibling["loc"][-1]), _keys(_model_at(item["loc"]))) == key
        for sibling in errors
    )


def _line(item: dict[str, Any], data: dict[str, Any]) -> tuple[str, str]:
    kind, loc, raw_value = item["type"], item["loc"], item["input"]
    key = _dotted(loc, data)
    if kind == "value_error":
        cause = item["ctx"]["error"]
        if isinstance(cause, KeyedError):
            key = f"{key}{cause.key}" if cause.key.startswith(".") else cause.key
        return key, str(cause)
    if kind == "missing":
        return key, _missing(loc)
    if kind == "extra_forbidden":
        return key, _unknown(loc)
    if kind == "union_tag_not_found":
        return _no_tag(key, raw_value, loc)
    if kind == "union_tag_invalid":
        tag = "law" if loc == ("joint",) else item["ctx"]["discriminator"].strip("'")
        choices = [word.strip("'") for word in item["ctx"]["expected_tags"].split(", ")]
        value = raw_value[tag]
        hint = ""
        if isinstance(value, str):
            hint = _as_scipy(value, choices) or did_you_mean(value, choices)
        return f"{key}.{tag}", f"wanted {quoted(choices)}, got {show(value)}{hint}"
    if kind in _NOT_A_TABLE:
        example = _TABLES.get(str(loc[0] if loc[0] == "material" else loc[-1]))
        if loc[-1] == "heights" and "population" in loc:
            example = '{ kind = "values", values = ["0.4 um", "0.7 um"] }'
        expected = f"such as {example}" if example else f"[{key}]"
        return key, f"wanted a table {expected}, got {show(raw_value)}"
    if kind == "literal_error":
        expected = item["ctx"]["expected"].replace("True", "true").replace("False", "false")
        return key, f"wanted {expected}, got {show(raw_value)}"
    return key, f"{item['msg'][:1].lower()}{item['msg'][1:]}, got {show(raw_value)}"


def _missing(loc: Loc) -> str:
    name = str(loc[-1])
    fields = _model_at(loc).model_fields
    field = next(field for key, field in fields.items() if (field.alias or key) == name)
    example = (field.examples or [""])[0]
    if len(loc) == 1 and name != "schema":
        return "missing; write a table " + (_TABLES.get(name) or f"[{name}]")
    hint = ""
    if loc[0] == "material" and (near := nearest(str(loc[1]), metals())):
        hint = f' (the table of metals has no "{shorten(str(loc[1]), 40)}"; did you mean "{near}"?)'
    return f"missing; write for example {name} = {example}{hint}"


def _as_scipy(kind: str, choices: Sequence[str]) -> str:
    """How to write a distribution of SciPy that was given as a kind."""
    if "scipy" not in choices or kind not in distribution_names():
        return ""
    return f'; write kind = "scipy", distribution = "{kind}"'


def _unknown(loc: Loc) -> str:
    name, model = str(loc[-1]), _model_at(loc)
    keys = _keys(model)
    hint = did_you_mean(name, keys)
    if hint:
        return f"unknown key{hint}"
    if model is Rigid:
        return "unknown key; a rigid material has no other"
    home = next((home for home, table in _homes() if name in _keys(table)), None)
    if home:
        return f"unknown key here; it belongs in {home}"
    return f"unknown key; the keys here are {', '.join(keys)}"


def _homes() -> list[tuple[str, type[Part]]]:
    """Where the keys belong, in words."""
    return [
        ("the top level", StudyTables),
        ("[material.NAME]", Elastic),
        ("[joint]", Joint),
        *((f"[{path}]", _MODELS[path.rpartition(".")[2]]) for path in _PLAIN_HOMES),
        *((f'[surface] with law = "{name}"', model) for name, model in SURFACE_TABLES.items()),
        *((f'heights with kind = "{name}"', model) for name, model in HEIGHTS_TABLES.items()),
        *((f'[joint] with law = "{name}"', model) for name, model in LAW_TABLES.items()),
    ]


def _no_tag(key: str, raw_value: Any, loc: Loc) -> tuple[str, str]:
    """A surface without a law or heights without a kind, or with that key misspelt."""
    tag, tables = "law", _TABLES_BY_KEY["surface"]
    if loc[-1] == "pressure":
        tag, tables = "kind", _TABLES_BY_KEY["pressure"]
    if loc[-1] == "heights":
        tag = "kind"
        tables = {"values": GivenHeights} if "population" in loc else HEIGHTS_TABLES
    near = nearest(tag, [name for name in raw_value if isinstance(name, str)])
    keys = {name for model in tables.values() for name in _keys(model)}
    if near is not None and near not in keys:
        return f"{key}.{near}", f'unknown key; did you mean "{tag}"?'
    return f"{key}.{tag}", f"missing; wanted {quoted(tables)}"
