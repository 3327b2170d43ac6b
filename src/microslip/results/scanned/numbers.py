"""A measured scan as plain values: what summary.json and the tables hold."""

from __future__ import annotations

from typing import Any

from microslip._version import __version__
from microslip.report.files import header, plain
from microslip.results.scanned import joint_section
from microslip.scans.cutoffs import CutoffTable
from microslip.scans.findings import Findings
from microslip.scans.height_fit import HeightFit
from microslip.scans.patch_scatter import HEIGHTS, MOMENTS, SUMMITS

KIND = "microslip-surface"
"""What summary.json says of a folder of a measured scan."""
FACES_KIND = "microslip-faces"
"""The same of a folder of faces."""


def summarise(findings: Findings, remarks: tuple[str, ...]) -> dict[str, Any]:
    """What summary.json holds: plain values in SI units, None for what there is not."""
    request, scan = findings.request, findings.scan
    errors = findings.errors
    units = {name: unit for name, (_, unit) in {**HEIGHTS, **MOMENTS}.items()}
    numbers = {name: getattr(findings.statistics, name) for name in HEIGHTS}
    numbers |= {name: getattr(findings.moments, name) for name in MOMENTS}
    return {
        **header(KIND, 1, findings.raw.name),
        "version": __version__,
        "name": findings.raw.name,
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
        "missing": plain(scan.missing),
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
            for estimate, part in findings.estimates.items()
        },
        "count": None if findings.summits is None else findings.summits.count,
        "prominence": None if findings.summits is None else findings.summits.threshold,
        "heights": _height_fit(findings.fit),
        "over_cutoffs": _over_cutoffs(findings.table),
        "texture": plain(findings.texture()),
        "joint": joint_section.summary(findings),
        "validity": [plain(verdict._asdict()) for verdict in findings.verdicts],
        "notes": list(scan.notes if findings.summits is None else findings.summits.notes),
        "files": [],
    }


def _quantity(value: float, error: float | None, unit: str) -> dict[str, Any]:
    return {"value": plain(value), "error": plain(error), "unit": unit}


_OF_FITS = ("name", "shapes", "place", "scale", "mirrored", "share", "shift", "tail")


def _height_fit(fit: HeightFit) -> dict[str, Any]:
    return {
        "verdict": fit.verdict,
        "word": fit.gaussian.word,
        "fits": [
            {**{name: plain(getattr(law, name)) for name in _OF_FITS}, "word": law.word}
            for law in fit.fits
        ],
    }


def _over_cutoffs(table: CutoffTable) -> list[dict[str, float | None]]:
    """A row for each cut-off; null where there is none, the first law."""
    return [
        {name: (value or None) if name == "cutoff" else plain(value) for name, value in row.items()}
        for row in table.rows()
    ]
