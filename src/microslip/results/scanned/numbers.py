"""A measured scan as plain values: what summary.json and the tables hold."""

from __future__ import annotations

import math
from typing import Any

from microslip._version import __version__
from microslip.report.files import header
from microslip.results.scanned import joint_section, texture
from microslip.results.scanned.findings import Findings
from microslip.results.scanned.patch_scatter import HEIGHTS, MOMENTS, SUMMITS
from microslip.scans.cutoffs import CutoffTable
from microslip.scans.height_fit import HeightFit

KIND = "microslip-surface"
"""What summary.json says of a folder of a measured scan."""
FACES_KIND = "microslip-faces"
"""The same of a folder of faces."""


def summarise(
    found: Findings, remarks: tuple[str, ...], files: tuple[str, ...] = ()
) -> dict[str, Any]:
    """What summary.json holds: plain values in SI units, None for what there is not."""
    request, scan = found.request, found.scan
    errors = found.errors
    units = {name: unit for name, (_, unit) in {**HEIGHTS, **MOMENTS}.items()}
    numbers = {name: getattr(found.statistics, name) for name in HEIGHTS}
    numbers |= {name: getattr(found.moments, name) for name in MOMENTS}
    return {
        **header(KIND, 1, found.raw.name),
        "version": __version__,
        "name": found.raw.name,
        "cutoff": request.cutoff,
        "cutoff_given": request.cutoff_given,
        "long_cutoff": request.long_cutoff,
        "level": request.level or "none",
        "outliers": request.outliers,
        "fill": request.fill,
        "method": request.method,
        "area": request.area,
        "points": list(scan.heights.shape[::-1]),
        "pixel": list(scan.pixel),
        "size": list(scan.size),
        "missing": _plain(scan.missing),
        "warnings": list(remarks),
        "parameters": {
            name: _quantity(value, errors.get(name), units[name]) for name, value in numbers.items()
        },
        "summits": {
            estimate: None
            if part is None
            else {
                name: _quantity(getattr(part, name), errors.get(f"{estimate}.{name}"), unit)
                for name, (_, unit) in SUMMITS.items()
            }
            for estimate, part in found.estimates.items()
        },
        "count": None if found.summits is None else found.summits.count,
        "prominence": None if found.summits is None else found.summits.threshold,
        "heights": _height_fit(found.fit),
        "over_cutoffs": _over_cutoffs(found.table),
        "texture": texture.measure(found),
        "joint": joint_section.summary(found),
        "validity": [
            {
                "name": verdict.name,
                "value": _plain(verdict.value),
                "limit": _plain(verdict.limit),
                "word": verdict.word,
                "meaning": verdict.meaning,
                "reason": verdict.reason,
                "remedy": verdict.remedy,
            }
            for verdict in found.verdicts
        ],
        "notes": list(scan.notes if found.summits is None else found.summits.notes),
        "files": list(files),
    }


def _quantity(value: float, error: float | None, unit: str) -> dict[str, Any]:
    return {"value": _plain(value), "error": _plain(error), "unit": unit}


def _plain(value: Any) -> float | None:
    """A Python float, or None for what is not known: JSON has no NaN."""
    return float(value) if value is not None and math.isfinite(value) else None


def _height_fit(fit: HeightFit) -> dict[str, Any]:
    return {
        "verdict": fit.verdict,
        "word": fit.gaussian.word,
        "fits": [
            {
                "name": law.name,
                "shapes": [_plain(shape) for shape in law.shapes],
                "place": _plain(law.place),
                "scale": _plain(law.scale),
                "mirrored": law.mirrored,
                "share": _plain(law.share),
                "shift": _plain(law.shift),
                "tail": _plain(law.tail),
                "word": law.word,
            }
            for law in fit.fits
        ],
    }


def _over_cutoffs(table: CutoffTable) -> list[dict[str, float | None]]:
    """A row for each cut-off; null where there is none, the first law."""
    return [
        {
            name: (value or None) if name == "cutoff" else _plain(value)
            for name, value in row.items()
        }
        for row in table.rows()
    ]
