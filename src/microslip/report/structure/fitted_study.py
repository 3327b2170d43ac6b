"""Study with the fitted values, which predicts the joint that was tested."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from microslip._version import __version__
from microslip.study.description import StudyDescription
from microslip.study.runs.structure_prediction import StructurePrediction
from microslip.study.toml_text import edited_text
from microslip.study.uncertain import at_central_values

FITTED_STUDY = "fitted.toml"
"""File name of the fitted study in a result folder."""

_OF_A_TENSION = (
    "torque", "nut_factor", "thread_friction", "bearing_friction", "tightening_factor",
    "embedding", "rz", "interfaces",
)  # fmt: skip
"""Keys of bolts from which a tension follows."""
_WIDEST_NORMAL = 0.32  # coefficient of variation that a study takes
_LARGEST_CORRELATION = 0.999  # largest correlation that a study takes


def fitted_text(study: StudyDescription, result: StructurePrediction, destination: Path) -> str:
    """Return the study with the fitted values, their scatter and correlations, for ``predict``.

    The median of each distribution is the fitted value, so that the central curves are those of the
    fit.
    """
    found = result.identified
    assert found is not None  # who calls has looked
    text = study.text_for(destination)
    tables = tomllib.loads(text)
    middle = at_central_values(study)
    body = study.surface.materials[0]
    units = {"tension": (float(middle.bolted.tension[0]), "N")}
    if "young_modulus" in found.values:
        units["young_modulus"] = (float(middle.material[body].young_modulus), "Pa")
    keys = {
        "friction_coefficient": ("joint", "friction_coefficient"),
        "tension": ("structure", "bolts", "tension"),
        "form": ("structure", "form", "factor"),
        "young_modulus": ("material", body, "young_modulus"),
        "base_damping_ratio": ("structure", "base_damping_ratio"),
    }
    changes: dict[tuple[str, ...], Any] = {
        ("title",): f"{tables.get('title') or 'Structure'}: fitted"[:200],
        ("structure", "measured"): _unfitted(tables["structure"]["measured"]),
    }
    scattered = set()
    for (name, value), scatter in zip(found.values.items(), found.scatter.tolist(), strict=True):
        given, unit = units.get(name, (1.0, ""))
        written: Any = f"{given * value!r} {unit}" if unit else value
        normal = name == "form"
        cv = (
            scatter / abs(value or 1.0) if normal else math.sqrt(math.expm1(min(scatter, 9.0) ** 2))
        )
        if value != 0.0 and 1e-9 < cv <= (_WIDEST_NORMAL if normal else 1.0):
            scattered.add(name)
            written = {"mean": written, "cv": cv, **({"distribution": "normal"} if normal else {})}
        changes[keys[name]] = written
    if "tension" in found.values:
        changes |= dict.fromkeys((("structure", "bolts", key) for key in _OF_A_TENSION), None)
    names, replaced = tuple(found.values), {".".join(keys[name]) for name in found.values}
    pairs = [
        pair for pair in tables.get("uncertainty", {}).get("correlations", ())
        if not replaced & set(pair["between"])
    ]  # fmt: skip
    pairs += [
        {
            "between": [".".join(keys[names[i]]), ".".join(keys[names[j]])],
            "value": float(
                np.clip(found.correlation[i, j], -_LARGEST_CORRELATION, _LARGEST_CORRELATION)
            ),
        }
        for i in range(len(names))
        for j in range(i)
        if {names[i], names[j]} <= scattered
    ]
    if pairs or "correlations" in tables.get("uncertainty", {}):
        changes["uncertainty", "correlations"] = pairs or None
    tests = ", ".join(test.name for test in result.tests)
    lines = [f"Fitted by microslip {__version__} to {tests}; 5 to 95 % in brackets:"]
    lines += [
        f"{'.'.join(keys[name])}: {value:.4g} ({low:.4g} to {high:.4g})"
        + (" of that of the study" if name in units else "")
        for (name, value), (low, high) in zip(
            found.values.items(), found.intervals.values(), strict=True
        )
    ]
    remarks = "".join(f"# {line}\n" for line in lines)
    return f"{remarks}\n{edited_text(text, changes)}"


def _unfitted(measured: Any) -> Any:
    """Return the tests without the key ``fit``: they are plotted, but not fitted again."""
    if isinstance(measured, dict):
        return {name: value for name, value in measured.items() if name != "fit"}
    return [_unfitted(test) for test in measured]
