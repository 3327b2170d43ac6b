"""Floor 8: an identified joint as a study file."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from microslip._units import engineering
from microslip._version import __version__
from microslip.errors import InputError
from microslip.study.identified_tables import label, open_of, quantity
from microslip.study.overrides import dump

if TYPE_CHECKING:
    from microslip.identification import Identification
    from microslip.study.identified import Identified


SAME = 0.01
"""Loads and amplitudes that differ by no more than this share count as one."""


def joint_text(found: Identified) -> tuple[str | None, str]:
    """The identified joint as TOML that `microslip predict` takes as it is.

    Parameters
    ----------
    found : Identified
        What was identified.

    Returns
    -------
    text : str or None
        TOML, with remarks on what is no result; None where there can be no study.
    why : str
        Why there is none; else empty.
    """
    result = found.first
    if result.law != "interface":
        return None, f"no joint.toml: a study describes an interface, and this is {result.law}"
    if found.study is None:
        return None, "no joint.toml: the materials are not known; name a study that has them"
    try:
        given: dict[str, Any] = result.study()
    except InputError as error:
        return None, f"no joint.toml: {error}"
    source = tomllib.loads(found.study.text)
    # The materials by the names that the study has for them.
    given["surface"]["materials"] = source["surface"]["materials"]
    given.pop("material", None)
    if "material" in source:
        given["material"] = source["material"]
    title = source.get("title", "")
    given["title"] = f"{title}: identified"[:200] if title else "Identified joint"
    for key, unit in (("radius", "m"), ("area", "m^2"), ("density", "1/m^2")):
        given["surface"][key] = f"{getattr(_surface(result), key):.6g} {unit}"
    loads = [r.normal_load for r in result.records if r.normal_load is not None]
    given["joint"]["normal_load"] = _different(loads, "N")
    given["excitation"] = {"amplitudes": _different(_amplitudes(result), "m")}
    order = ("schema", "title", "material", "surface", "joint", "excitation")
    given = {key: given[key] for key in (*order, *given) if key in given}
    return f"{_remarks(found)}\n{dump(given)}", ""


def _surface(result: Identification) -> Any:
    return result.joint().surface


def _amplitudes(result: Identification) -> list[float]:
    """Displacement amplitudes of the joint itself [m]: those of the records less the rig's part."""
    found = []
    for record in result.records:
        rig = 0.0 if record.rig_stiffness is None else np.ptp(record.model) / record.rig_stiffness
        found.append(0.5 * float(np.ptp(record.displacement) - rig))
    return [amplitude for amplitude in found if amplitude > 0.0]


def _different(values: Sequence[float], unit: str) -> list[str]:
    """Different values in rising order, as a study has them."""
    kept: list[float] = []
    for value in sorted(values):
        if not kept or value > kept[-1] * (1.0 + SAME):
            kept.append(value)
    return [engineering(value, unit, 4, trim=True).replace("µ", "u") for value in kept]


def _remarks(found: Identified) -> str:
    """What is measured in the file and what is not, as comments."""
    assert found.study is not None
    summary = found.first.summary()
    lines = [f"Identified by microslip {__version__} from:"]
    lines += [
        f"  {record['name']}, N = {quantity(record['normal_load'], 'N')}, "
        f"amplitude {quantity(record['amplitude'], 'm')}, {record['cycles']} cycles"
        for record in summary["records"]
    ]
    if open_ones := [item.name for item in open_of(summary)]:
        lines.append(
            f"NOT identified, one of many values that answer the loops: {', '.join(open_ones)}."
        )
    if "radius" in summary["derived"]:
        lines.append("radius and density: told apart by the contact area that was given.")
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
