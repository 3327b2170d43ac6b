"""Study of a scanned joint, as input of `microslip predict`."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

from microslip._core.files import relative_path
from microslip._core.units import engineering
from microslip.study.toml_text import dump
from microslip.surfaces.findings import Findings, Request
from microslip.surfaces.joints import FaceJoint

STUDY_NAME = "study.toml"


def face_study_text(findings: Findings, face: FaceJoint, folder: Path) -> str:
    """Return a study of the face solved point by point; paths in it are relative to ``folder``."""
    request = findings.request
    tables = {
        "surface": _surface(findings, face, folder),
        "joint": {
            "friction_coefficient": request.friction_coefficient,
            "normal_load": engineering(face.joint.normal_load, "N", 9, trim=True),
        },
        "excitation": {"amplitudes": [_length(face.amplitude)]},
    }
    head = [
        f"# A joint of {findings.raw.name}, written by microslip surface:",
        f"#   microslip predict {STUDY_NAME}",
    ]
    if face.unresolved_amplitude is not None:
        head.append(
            "# The scan does not determine the damping of cycles up to "
            f"{engineering(face.unresolved_amplitude, 'm')} in amplitude."
        )
    study = {"schema": 1, "title": findings.raw.name, **tables}
    return "\n".join(head) + f"\n{dump(study)}"


def _surface(findings: Findings, face: FaceJoint, folder: Path) -> dict[str, Any]:
    request = findings.request
    path = request.path
    keys: dict[str, Any] = {
        "law": "face",
        "materials": list(request.materials or ()),
        "scan": os.fspath(path) if path.is_absolute() else relative_path(folder, path),
        "level": findings.level or "none",
        **_lengths(request, "cutoff", "long_cutoff", "crop"),
        "tightening_pressure": engineering(face.law.numbers.pressure, "Pa", 6, trim=True),
        "piece": face.piece or "none",
        "area": f"{face.law.area * 1e4:.6g} cm^2",
    }
    if request.direction is not None:
        keys["direction"] = f"{math.degrees(request.direction):.6g} deg"
    return keys | {key: _read(value) for key, value in request.reading.items() if value != ()}


def _lengths(request: Request, *names: str) -> dict[str, Any]:
    values = {name: getattr(request, name) for name in names}
    return {name: _read(value) for name, value in values.items() if value is not None}


def _read(value: Any) -> Any:
    """Format an option of the scan as TOML: lengths with unit, several values as a list."""
    if isinstance(value, tuple):
        return _read(value[0]) if len(value) == 1 else [_read(item) for item in value]
    return _length(value) if isinstance(value, float) else value


def _length(value: float) -> str:
    return engineering(value, "m", 6, trim=True).replace("\N{MICRO SIGN}", "u")
