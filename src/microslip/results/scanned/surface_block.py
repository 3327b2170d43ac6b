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
from microslip.scans.options import LAWS_OF_HEIGHTS

_HEAD = """\
# The surface of a study, from a scan: put it in place of [surface] in one that
# `microslip new` writes into this folder, and name the two bodies.
"""


def block(findings: Findings, folder: Path) -> str:
    """The surface as a study in this folder has it: TOML, with the same in numbers as comments."""
    request = findings.request
    remark = (
        "decides what a summit is" if request.cutoff_given else "none was given: the pixel decides"
    )
    lines = [
        "[surface]",
        'law = "scan"',
        'materials = ["steel", "steel"]  # the two bodies: put yours here',
        f"scan = {_text(_path(request.path, folder))}",
        f"cutoff = {_length(request.cutoff)}  # {remark}",
    ]
    profile = findings.scan.is_profile
    lines += [f"{key} = {value}" for key, value in _conditioning(request, profile).items()]
    lines.append(
        'estimate = "mccool"  # or "nayak": a profile has no summits to count'
        if profile
        else 'estimate = "counted"  # or "neighbours", "mccool", "nayak"'
    )
    if request.direction is not None:
        lines.append(f"direction = {_angle(request.direction)}  # of the motion: elliptic summits")
    elif not profile:
        law = request.heights or (
            "gaussian" if findings.laws is None else findings.laws.recommended
        )
        lines.append(f'heights = "{law}"  # or {_other_laws(law)}')
    area = request.area
    lines.append(
        '# area = "2 cm^2"  # apparent area of the joint: a profile has none, so put yours here'
        if area is None and profile
        else '# area = "2 cm^2"  # apparent area of the joint; without it that of the scan'
        if area is None
        else f"area = {_text(f'{_number(area * 1e4)} cm^2')}"
    )
    lines += [f"{key} = {value}" for key, value in _reading(request).items()]
    lines += _numbers(findings)
    return _HEAD + "\n".join(lines) + "\n"


def faces_block(request: Request, folder: Path) -> str:
    """Two faces, several scans of one, or a drawing, as a study in this folder has them."""
    for name in ("heights", "direction"):
        if getattr(request, name) is not None:
            raise InputError(f"`{name}` goes with one scan of one face, whose summits are known")
    if request.area is None and request.normal_load is not None:
        raise InputError(
'`area="2 cm^2"` goes with `normal_load="500 N"`: faces have no size of their own'
)  # fmt: skip
    if request.scans and request.against and request.drawing:
        raise InputError("wanted two faces: scans and scans against them, or scans and a drawing")
    drawing = {
        key: _text(value) if key == "process" else _length(value)
        for key, value in request.drawing.items()
    }
    first, second = (
        _scanned(request, paths, folder) if paths else None
        for paths in (request.scans, request.against)
    )
    materials = (
        '"steel", "steel"' if not request.materials else ", ".join(map(_text, request.materials))
    )
    lines = ["[surface]", f"materials = [{materials}]"]
    if first is None and second is None:
        lines += ['law = "drawing"', *(f"{key} = {value}" for key, value in drawing.items())]
    else:
        lines.append('law = "two-faces"')
        faces = (first or drawing, second or (drawing if first else None))
        for name, face in zip(("first", "second"), faces, strict=True):
            if face:
                inner = ", ".join(f"{key} = {value}" for key, value in face.items())
                lines.append(f"{name} = {{ {inner} }}")
    area = f'"{_number((request.area or 1e-4) * 1e4)} cm^2"'
    remark = "" if request.area else "  # of the joint: put yours here"
    return "\n".join([*lines, f"area = {area}{remark}"]) + "\n"


def _scanned(request: Request, paths: tuple[Path, ...], folder: Path) -> dict[str, str]:
    """Keys of a face by its scans."""
    cutoff = {"cutoff": _length(request.cutoff)} if request.cutoff_given else {}
    scans = ", ".join(_text(_path(path, folder)) for path in paths)
    return {"scan": f"[{scans}]", **cutoff, **_conditioning(request), **_reading(request)}


def _conditioning(request: Request, profile: bool = False) -> dict[str, str]:
    """Keys of what is done to a scan, where it is not usual."""
    keys = {}
    if request.long_cutoff is not None:
        keys["long_cutoff"] = _length(request.long_cutoff)
    if request.level != "plane":
        keys["level"] = _text(request.level or "none")
    if request.outliers is not None:
        keys["outliers"] = f"{request.outliers:g}"
    if request.fill:
        keys["fill"] = "true"
    if request.method != "watershed" and not profile:
        keys["method"] = _text(request.method)
    if request.prominence is not None and not profile:
        keys["prominence"] = _length(request.prominence)
    return keys


def _reading(request: Request) -> dict[str, str]:
    options = {key: value for key, value in request.reading.items() if value not in (None, ())}
    return {key: _value(value) for key, value in options.items()}


def _angle(value: float) -> str:
    return _text(f"{_number(math.degrees(value))} deg")


def _other_laws(law: str) -> str:
    return ", ".join(f'"{name}"' for name in LAWS_OF_HEIGHTS if name != law)


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
            f'# heights = {{ kind = "gaussian", std = {_length(part.std)}, '
            f"mean = {_length(part.mean_height)} }}",
            f"# radius = {_length(part.radius)}",
            f"# density = {_text(f'{_number(part.density * 1e-6)} 1/mm^2')}",
        ]
    return lines


def _text(text: str) -> str:
    # A basic string of TOML is written as one of JSON.
    return json.dumps(text, ensure_ascii=False)


def _number(value: float) -> str:
    return f"{value:.6g}"


def _length(value: float | None) -> str:
    if value is None:
        return '"none"'
    return _text(engineering(value, "m", 6, trim=True).replace("\N{MICRO SIGN}", "u"))


def _value(value: Any) -> str:
    if isinstance(value, tuple):
        return _value(value[0]) if len(value) == 1 else f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float):
        return _length(value)
    return _text(value) if isinstance(value, str) else str(value)
