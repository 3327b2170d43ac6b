"""An identified joint as a study file."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Protocol

from microslip._core.wording import shorten
from microslip._version import __version__
from microslip.errors import InputError
from microslip.identification import Identification
from microslip.identification.caveats import HAS_VALUE
from microslip.identification.labels import label
from microslip.results.identified.numbers import (
    is_at_bound,
    knows_radius,
    open_parameters,
    quantity,
)
from microslip.study.overrides import dump

if TYPE_CHECKING:
    from microslip.study.description import StudyDescription


class _Outcome(Protocol):
    """What is said of a fit here: its result, and the study that materials are from."""

    @property
    def first(self) -> Identification: ...
    @property
    def study(self) -> StudyDescription | None: ...


def joint_text(outcome: _Outcome, say: Callable[[str], str] = str) -> tuple[str | None, str]:
    """The identified joint as TOML that `microslip predict` takes, or None and why there is none.

    Remarks say what in it is no result, as ``say`` puts it.
    """
    result = outcome.first
    if result.law != "interface":
        return None, f"no joint.toml: a study describes an interface, and this is {result.law}"
    if outcome.study is None:
        return None, "no joint.toml: the materials are not known; name a study that has them"
    try:
        study: dict[str, Any] = result.study()
    except InputError as error:
        return None, f"no joint.toml: {say(f'{error.text}')}"
    source = tomllib.loads(outcome.study.text)
    # The materials by the names that the study has for them.
    study["surface"]["materials"] = source["surface"]["materials"]
    study.pop("material", None)
    if "material" in source:
        study["material"] = source["material"]
    title = source.get("title", "")
    study["title"] = f"{title}: identified"[:200] if title else "Identified joint"
    for key, unit in (("radius", "m"), ("area", "m^2"), ("density", "1/m^2")):
        study["surface"][key] = f"{getattr(_surface(result), key):.6g} {unit}"
    if unknown := _unknown(result.summary()):
        study["not_identified"] = unknown
    order = ("schema", "title", "not_identified", "material", "surface", "joint", "excitation")
    study = {key: study[key] for key in (*order, *study) if key in study}
    return f"{_remarks(outcome, say)}\n{dump(study)}", ""


_KEYS = {
    "friction_coefficient": "joint.friction_coefficient",
    "slip_scale": "surface.heights",
    "standardised_separation": "surface.density",
}


def _unknown(summary: dict[str, Any]) -> list[str]:
    """Keys of the study whose numbers the loops do not tell, not even within an interval."""
    keys = [
        _KEYS[name]
        for name, number in summary["parameters"].items()
        if name in _KEYS
        and number["verdict"] not in ("identified", "fixed", *HAS_VALUE)
        and not is_at_bound(number)
    ]
    return keys if knows_radius(summary) else list(dict.fromkeys([*keys, "surface.radius"]))


def _surface(result: Identification) -> Any:
    return result.joint().surface


def _remarks(outcome: _Outcome, say: Callable[[str], str]) -> str:
    """What is measured in the file and what is not, as comments."""
    assert outcome.study is not None
    summary = outcome.first.summary()
    lines = [f"Identified by microslip {__version__} from:"]
    lines += [
        f"  {shorten(record['name'], 60)}, N = {quantity(record['normal_load'], 'N')}, "
        f"amplitude {quantity(record['amplitude'], 'm')}, {record['cycles']} cycles"
        for record in summary["records"]
    ]
    doubts = [item for item in open_parameters(summary) if item.verdict in HAS_VALUE]
    doubtful = [f"{item.name} ({item.verdict})" for item in doubts]
    if summary["status"] != "converged" or doubtful:
        lines += wrap(f"{summary['status'].upper()}: {say(summary['message'])}.", 96)
    if doubtful:
        lines += wrap(f"IN DOUBT: {', '.join(doubtful)}.", 96)
    if open_ones := [item.name for item in open_parameters(summary) if item not in doubts]:
        lines.append(
            f"NOT identified, one of many values that answer the loops: {', '.join(open_ones)}."
        )
    if knows_radius(summary):
        lines += [
            "radius and density: told apart by the contact area, radius or density that was given."
        ]
    else:
        lines += [
            "radius: conventional, not identified: that of the study the fit began with. Loops",
            "know density * sqrt(radius) alone; contact counts and areas hang on the radius, loops",
            "do not.",
        ]
    lines.append("amplitudes: of the joint itself, those of the records less what the rig gives.")
    for name, number in summary["parameters"].items():
        if name.startswith("rig_stiffness") and number["value"] is not None:
            lines.append(f"{label(name)}: {quantity(number['value'], 'N/m')}, not in this study.")
    return "\n".join(f"# {line}" for line in lines)
