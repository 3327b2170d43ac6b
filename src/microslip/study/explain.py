"""Floor 8: what pydantic found wrong with a study, as one line that says what to write instead."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

from pydantic import ValidationError

from microslip._core.wording import did_you_mean, nearest, quoted, shorten, show
from microslip.materials import metals
from microslip.study import schema as s
from microslip.study import surfaces as u
from microslip.study.columns import Column
from microslip.study.distributions import names
from microslip.study.overrides import Override

Loc = tuple[int | str, ...]

_SURFACES = (
    u.GreenwoodWilliamsonSurface,
    u.PopulationSurface,
    u.SphereSurface,
    u.TableSurface,
    u.ScanSurface,
)
_HEIGHTS = (
    u.GaussianHeights,
    u.ExponentialHeights,
    u.GivenHeights,
    u.ScipyHeights,
    u.TableHeights,
)


def _tag(model: type[u.Part], key: str) -> str:
    return str(get_args(model.model_fields[key].annotation)[0])


# The models by the last part of pydantic's location, which is the tag in a union.
_MODELS: dict[str, type[u.Part]] = {
    "elastic": u.Elastic,
    "rigid": u.Rigid,
    "joint": s.Joint,
    "excitation": s.Excitation,
    "curve": s.Curve,
    "history": s.History,
    "load_variation": s.LoadVariation,
    "normal_load": s.LoadColumn,
    "oscillator": s.OscillatorPart,
    "output": s.Output,
    **dict.fromkeys(("radius", "separation", "load", "height", "density"), Column),
    **{_tag(model, "law"): model for model in _SURFACES},
    **{_tag(model, "kind"): model for model in _HEIGHTS},
}
_TABLES = {
    "heights": '{ kind = "gaussian", std = "0.5 um" }',
    "curve": '{ from = "1 nm", to = "100 um", points = 200 }',
    "history": '{ file = "record.csv", column = "x", unit = "um" }',
    "load_variation": '{ amplitude = "400 N", phase = "90 deg" }',
    "normal_load": '{ column = "load", unit = "N" }',
    "oscillator": '[oscillator] with mass = "2 kg" and stiffness = "1e6 N/m"',
    "parameters": "{ c = 2.0 }",
    "material": '[material.steel] with young_modulus = "210 GPa" and poisson_ratio = 0.3',
}
_NOT_A_TABLE = ("model_type", "model_attributes_type", "dict_type")


def explain(error: ValidationError, data: dict[str, Any], changes: Sequence[Override] = ()) -> str:
    """First thing that is wrong, and how many more there are.

    Parameters
    ----------
    error : pydantic.ValidationError
        What :class:`~microslip.study.schema.Study` raised.
    data : dict
        What it was given.
    changes : sequence of Override
        Keys that took the place of others; one that is to blame is named.

    Returns
    -------
    str
        "key: what was wanted, what came", on one line.
    """
    found: list[dict[str, Any]] = [dict(item) for item in error.errors(include_url=False)]
    found = [item for item in found if not _is_echo(item, found)]
    found.sort(key=lambda item: _place(item["loc"]))
    key, message = _line(found[0], data)
    more = len(found) - 1
    also = f" (and {more} more error{'s' if more > 1 else ''})" if more else ""
    return f"{key}{_blamed(key, changes)}: {message}{also}"


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
    return index > 0 and loc[0] == "surface" and (index == 1 or loc[index - 1] == "heights")


def _place(loc: Loc) -> int:
    """Rank of the top-level table, so that the first error is the first in reading order."""
    order = [field.alias or name for name, field in s.Study.model_fields.items()]
    return order.index(str(loc[0])) if loc and loc[0] in order else -1


def _model_at(loc: Loc) -> type[u.Part]:
    """Model whose key is the last part of a location."""
    if loc[-2:-1] == ("table",) and "heights" in loc:  # a law and a kind of this name
        return u.TableHeights
    return s.Study if len(loc) == 1 else _MODELS[str(loc[-2])]


def _keys(model: type[u.Part]) -> list[str]:
    return [field.alias or name for name, field in model.model_fields.items()]


def _is_echo(item: dict[str, Any], found: list[dict[str, Any]]) -> bool:
    """Whether a key is only missing because it is there, misspelt."""
    if item["type"] != "missing":
        return False
    key = str(item["loc"][-1])
    return any(
        other["type"] == "extra_forbidden"
        and other["loc"][:-1] == item["loc"][:-1]
        and nearest(str(other["loc"][-1]), _keys(_model_at(item["loc"]))) == key
        for other in found
    )


def _line(item: dict[str, Any], data: dict[str, Any]) -> tuple[str, str]:
    kind, loc, given = item["type"], item["loc"], item["input"]
    key = _dotted(loc, data)
    if kind == "value_error":
        cause = item["ctx"]["error"]
        if isinstance(cause, u.KeyedError):
            key = cause.key
        return key, str(cause)
    if kind == "missing":
        return key, _missing(loc)
    if kind == "extra_forbidden":
        return key, _unknown(loc)
    if kind == "union_tag_not_found":
        return _no_tag(key, given, loc)
    if kind == "union_tag_invalid":
        tag = item["ctx"]["discriminator"].strip("'")
        choices = [word.strip("'") for word in item["ctx"]["expected_tags"].split(", ")]
        value = given[tag]
        hint = ""
        if isinstance(value, str):
            hint = _as_scipy(value, choices) or did_you_mean(value, choices)
        return f"{key}.{tag}", f"wanted {quoted(choices)}, got {show(value)}{hint}"
    if kind in _NOT_A_TABLE:
        example = _TABLES.get(str(loc[0] if loc[0] == "material" else loc[-1]))
        if loc[-1] == "heights" and "population" in loc:
            example = '{ kind = "values", values = ["0.4 um", "0.7 um"] }'
        wanted = f"such as {example}" if example else f"[{key}]"
        return key, f"wanted a table {wanted}, got {show(given)}"
    if kind == "literal_error":
        wanted = item["ctx"]["expected"].replace("True", "true").replace("False", "false")
        return key, f"wanted {wanted}, got {show(given)}"
    return key, f"{item['msg'][:1].lower()}{item['msg'][1:]}, got {show(given)}"


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
    if "scipy" not in choices or kind not in names():
        return ""
    return f'; write kind = "scipy", distribution = "{kind}"'


def _unknown(loc: Loc) -> str:
    name, model = str(loc[-1]), _model_at(loc)
    keys = _keys(model)
    hint = did_you_mean(name, keys)
    if hint:
        return f"unknown key{hint}"
    if model is u.Rigid:
        return "unknown key; a rigid material has no other"
    home = next((home for home, other in _homes() if name in _keys(other)), None)
    if home:
        return f"unknown key here; it belongs in {home}"
    return f"unknown key; the keys here are {', '.join(keys)}"


def _homes() -> list[tuple[str, type[u.Part]]]:
    """Where the keys belong, in words."""
    return [
        ("the top level", s.Study),
        ("[material.NAME]", u.Elastic),
        ("[joint]", s.Joint),
        ("[excitation]", s.Excitation),
        ("[oscillator]", s.OscillatorPart),
        ("[output]", s.Output),
        *((f'[surface] with law = "{_tag(model, "law")}"', model) for model in _SURFACES),
        *((f'heights with kind = "{_tag(model, "kind")}"', model) for model in _HEIGHTS),
    ]


def _heights_at(loc: Loc) -> tuple[type[u.Part], ...]:
    return (u.GivenHeights,) if "population" in loc else _HEIGHTS


def _no_tag(key: str, given: Any, loc: Loc) -> tuple[str, str]:
    """A surface without a law or heights without a kind, or with that key misspelt."""
    tag, models = ("kind", _heights_at(loc)) if loc[-1] == "heights" else ("law", _SURFACES)
    near = nearest(tag, [name for name in given if isinstance(name, str)])
    known = {name for model in models for name in _keys(model)}
    if near is not None and near not in known:
        return f"{key}.{near}", f'unknown key; did you mean "{tag}"?'
    return f"{key}.{tag}", f"missing; wanted {quoted(_tag(model, tag) for model in models)}"
