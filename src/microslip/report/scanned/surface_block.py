"""The surface of a study that a scan makes, as a block of TOML."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

from microslip._core.files import seen_from
from microslip._core.units import engineering
from microslip.surfaces.findings import Findings, Request
from microslip.surfaces.joints import PointByPoint

_HEAD = """\
# The surface of a study, from a scan: put it in place of [surface] in one that
# `microslip new` writes into this folder, and name the two bodies.
"""


def block(findings: Findings, folder: Path) -> str:
    """Return the surface for a study in this folder: the solved face, else its summits."""
    contact = findings.contact
    if contact is not None and contact.law is not None:
        keys, notes = _measured(findings.request, contact, folder)
    else:
        keys, notes = _summits(findings)
    lines = [
        f"{key} = {_toml(value)}" + (f"  # {notes[key]}" if key in notes else "")
        for key, value in keys.items()
    ]
    return _HEAD + "\n".join(["[surface]", *lines]) + "\n"


def _measured(
    request: Request, contact: PointByPoint, folder: Path
) -> tuple[dict[str, Any], dict[str, str]]:
    """Return keys and remarks of the scan point by point, tightened by the given load."""
    path = request.path
    keys: dict[str, Any] = {
        "law": "measured",
        "materials": list(request.materials or ()),
        "scan": os.fspath(path) if path.is_absolute() else seen_from(folder, path),
        **({} if request.cutoff is None else {"cutoff": _length(request.cutoff)}),
        **_conditioning(request),
        "tightening_pressure": engineering(contact.pressure, "Pa", 6, trim=True),
        "piece": contact.piece or "none",
    }
    if request.direction is not None:
        keys["direction"] = f"{_number(math.degrees(request.direction))} deg"
    if request.area is not None:
        keys["area"] = f"{_number(request.area * 1e4)} cm^2"
    keys |= {key: _read(value) for key, value in request.reading.items() if value not in (None, ())}
    remark = "the load that was given has tightened it; heavier ones are refused"
    return keys, {"tightening_pressure": remark}


def _summits(findings: Findings) -> tuple[dict[str, Any], dict[str, str]]:
    """Return keys and remarks of the chapter's model of the summits, in numbers."""
    statistics, request = findings.summit_statistics, findings.request
    assert statistics is not None
    area = findings.area or 2e-4
    keys = {
        "law": "greenwood-williamson",
        "materials": list(request.materials or ("steel", "steel")),
        "heights": {
            "kind": "gaussian",
            "std": _length(statistics.std),
            "mean": _length(statistics.mean_height),
        },
        "radius": _length(statistics.radius),
        "density": f"{_number(statistics.density * 1e-6)} 1/mm^2",
        "area": f"{_number(area * 1e4)} cm^2",
    }
    notes = {"law": f"summits of {findings.raw.name}, {findings.cutoff_text()}"}
    if request.materials is None:
        notes["materials"] = "the two bodies: put yours here"
    if request.area is None:
        of_scan = "a profile has none" if findings.area is None else "that of the scan"
        notes["area"] = f"apparent area of the joint, {of_scan}: put yours here"
    return keys, notes


def _conditioning(request: Request) -> dict[str, Any]:
    """Return the keys of the conditioning that differ from their defaults."""
    usual: dict[str, Any] = {
        "long_cutoff": None,
        "filter": "gaussian" if request.long_cutoff is not None else request.filter,
        "crop": None,
        "level": "plane",
        "outliers": None,
        "fill": False,
    }
    keys = {key: value for key in usual if (value := getattr(request, key)) != usual[key]}
    return {
        key: value if key == "outliers" else "none" if value is None else _read(value)
        for key, value in keys.items()
    }


def _read(value: Any) -> Any:
    """Return an option of reading: lengths with their unit, several as a list, one by itself."""
    if isinstance(value, tuple):
        return _read(value[0]) if len(value) == 1 else [_read(item) for item in value]
    return _length(value) if isinstance(value, float) else value


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_toml(inner)}' for key, inner in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    # A basic string of TOML is written as one of JSON.
    return f"{value:g}" if isinstance(value, float) else json.dumps(value, ensure_ascii=False)


def _number(value: float) -> str:
    return f"{value:.6g}"


def _length(value: float) -> str:
    return engineering(value, "m", 6, trim=True).replace("\N{MICRO SIGN}", "u")
