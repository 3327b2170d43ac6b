"""The surface of a scan as a block of a study file."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

from microslip._core.files import seen_from
from microslip._core.units import engineering
from microslip.errors import InputError
from microslip.scans.findings import Findings, Request
from microslip.scans.joints import PointByPoint, ProfileJoint
from microslip.scans.options import LAWS_OF_HEIGHTS

_HEAD = """\
# The surface of a study, from a scan: put it in place of [surface] in one that
# `microslip new` writes into this folder, and name the two bodies.
"""


def block(findings: Findings, folder: Path) -> str:
    """The surface as a study in this folder has it: TOML, with the same in numbers as comments."""
    request, contact = findings.request, findings.contact
    if contact is not None and contact.is_main and request.heights is None:
        return _HEAD + "\n".join(_measured(findings, contact, folder)) + "\n"
    if (profile_joint := findings.of_profile) is not None:
        return _HEAD + "\n".join(_rough(findings, profile_joint)) + "\n"
    remark = "defines a summit" if request.cutoff_given else "none was given: limited by the pixel"
    lines = [
        "[surface]",
        'law = "scan"',
        f"materials = {json.dumps(request.materials)}"
        if request.materials
        else 'materials = ["steel", "steel"]  # the two bodies: put yours here',
        f"scan = {_toml(_path(request.path, folder))}",
        f"cutoff = {_toml(_length(request.cutoff))}  # {remark}",
    ]
    profile = findings.scan.is_profile
    lines += [f"{key} = {_toml(v)}" for key, v in _conditioning(request, profile).items()]
    lines.append(
        'estimate = "mccool"  # or "nayak": a profile has no summits to count'
        if profile
        else 'estimate = "counted"  # or "neighbours", "mccool", "nayak"'
    )
    if not profile:
        law = request.heights or (
            "gaussian" if findings.laws is None else findings.laws.recommended
        )
        laws = ", ".join(f'"{name}"' for name in LAWS_OF_HEIGHTS if name != law)
        lines.append(f'heights = "{law}"  # or {laws}')
    area = request.area
    lines.append(
        '# area = "2 cm^2"  # apparent area of the joint: a profile has none, so put yours here'
        if area is None and profile
        else '# area = "2 cm^2"  # apparent area of the joint; without it that of the scan'
        if area is None
        else f"area = {_toml(f'{_number(area * 1e4)} cm^2')}"
    )
    lines += [f"{key} = {_toml(value)}" for key, value in _reading(request).items()]
    lines += _numbers(findings)
    return _HEAD + "\n".join(lines) + "\n"


def _measured(findings: Findings, contact: PointByPoint, folder: Path) -> list[str]:
    """The scan point by point, tightened by the load that was given."""
    request = findings.request
    keys: dict[str, Any] = {
        "law": "measured",
        "materials": list(request.materials or ()),
        "scan": _path(request.path, folder),
        **({} if request.cutoff is None else {"cutoff": _length(request.cutoff)}),
        **_conditioning(request, profile=True),
        "tightening_pressure": engineering(contact.pressure, "Pa", 6, trim=True),
        "piece": contact.piece or "none",
    }
    if request.direction is not None:
        keys["direction"] = f"{_number(math.degrees(request.direction))} deg"
    if request.area is not None:
        keys["area"] = f"{_number(request.area * 1e4)} cm^2"
    notes = {
        "law": 'point by point; law = "scan" builds on its summits',
        "tightening_pressure": "the load that was given has tightened it; heavier ones are refused",
    }
    lines = [
        f"{key} = {_toml(value)}" + (f"  # {notes[key]}" if key in notes else "")
        for key, value in (keys | _reading(request)).items()
    ]
    return ["[surface]", *lines, *_numbers(findings)]


def _rough(findings: Findings, joint: ProfileJoint) -> list[str]:
    """A profile by its spectrum, with its skewness and kurtosis, as a rough face."""
    surface, statistics = joint.surface, findings.statistics
    moments = {name: float(_number(getattr(statistics, name))) for name in ("skewness", "kurtosis")}
    keys: dict[str, Any] = {
        "law": "rough",
        "materials": list(findings.request.materials or ()),
        "rq": _length(surface.rms),
        "roll_off": _length(surface.roll_off),
        "shortest": _length(surface.shortest),
        "hurst": surface.hurst,
        **({} if statistics.skewness < -1.0 else moments),
        "area": f"{_number(joint.area * 1e4)} cm^2",
    }
    rough = [f"{key} = {_toml(value)}" for key, value in keys.items()]
    return ["[surface]", *rough, *_numbers(findings)]


def faces_block(request: Request, folder: Path) -> str:
    """Two faces, several scans of one, or a drawing, as a study in this folder has them."""
    table = faces_table(request, folder)
    lines = [f"{key} = {_toml(value)}" for key, value in table.items()]
    remark = "" if request.area else "  # of the joint: put yours here"
    return "\n".join(["[surface]", *lines]) + f"{remark}\n"


def faces_table(request: Request, folder: Path) -> dict[str, Any]:
    """The same as keys and values, the area last."""
    for name in ("heights", "direction"):
        if getattr(request, name) is not None:
            raise InputError(f"`{name}` goes with one scan of one face, whose summits are known")
    if request.area is None and request.normal_load is not None:
        raise InputError(
            '`area="2 cm^2"` goes with `normal_load="500 N"`: faces have no size of their own'
        )
    if request.scans and request.against and request.drawing:
        raise InputError("wanted two faces: scans and scans against them, or scans and a drawing")
    drawing = {
        key: value if key == "process" else _length(value) for key, value in request.drawing.items()
    }
    first, second = (
        _scanned(request, paths, folder) if paths else None
        for paths in (request.scans, request.against)
    )
    table: dict[str, Any] = {"materials": list(request.materials or ("steel", "steel"))}
    if first is None and second is None:
        table |= {"law": "drawing", **drawing}
    else:
        faces = {"first": first or drawing, "second": second or (drawing if first else None)}
        table |= {"law": "two-faces", **{name: face for name, face in faces.items() if face}}
    return {**table, "area": f"{_number((request.area or 1e-4) * 1e4)} cm^2"}


def _scanned(request: Request, paths: tuple[Path, ...], folder: Path) -> dict[str, Any]:
    """Keys of a face by its scans."""
    cutoff = {"cutoff": _length(request.cutoff)} if request.cutoff_given else {}
    scans = [_path(path, folder) for path in paths]
    return {"scan": scans, **cutoff, **_conditioning(request), **_reading(request)}


def _conditioning(request: Request, profile: bool = False) -> dict[str, Any]:
    """Keys of what is done to a scan, where it is not usual."""
    usual: dict[str, Any] = {
        "long_cutoff": None,
        "filter": "gaussian" if request.long_cutoff is not None else request.filter,
        "crop": None,
        "level": "plane",
        "outliers": None,
        "fill": False,
        **({} if profile else {"method": "watershed", "prominence": None}),
    }
    keys = {key: value for key in usual if (value := getattr(request, key)) != usual[key]}
    numbers = ("outliers",)
    return {k: v if k in numbers else "none" if v is None else _read(v) for k, v in keys.items()}


def _reading(request: Request) -> dict[str, Any]:
    return {key: _read(value) for key, value in request.reading.items() if value not in (None, ())}


def _read(value: Any) -> Any:
    """An option of reading: lengths with their unit, several as a list, one by itself."""
    if isinstance(value, tuple):
        return _read(value[0]) if len(value) == 1 else [_read(item) for item in value]
    return _length(value) if isinstance(value, float) else value


def _path(path: Path, folder: Path) -> str:
    """The scan as a study in this folder finds it: as it was given, if from the root."""
    if path.is_absolute():
        return os.fspath(path)
    return seen_from(folder, path)


def _numbers(findings: Findings) -> list[str]:
    """The same in numbers, as comments."""
    lines = []
    for name, part in findings.estimates.items():
        if part is None:
            continue
        lines += [
            "",
            f"# In numbers, {name}:",
            '# law = "greenwood-williamson"',
            f'# heights = {{ kind = "gaussian", std = {_toml(_length(part.std))}, '
            f"mean = {_toml(_length(part.mean_height))} }}",
            f"# radius = {_toml(_length(part.radius))}",
            f"# density = {_toml(f'{_number(part.density * 1e-6)} 1/mm^2')}",
        ]
    return lines


def _toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_toml(inner)}' for key, inner in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    # A basic string of TOML is written as one of JSON.
    return f"{value:g}" if isinstance(value, float) else json.dumps(value, ensure_ascii=False)


def _number(value: float) -> str:
    return f"{value:.6g}"


def _length(value: float | None) -> str:
    if value is None:
        return "none"
    return engineering(value, "m", 6, trim=True).replace("\N{MICRO SIGN}", "u")
