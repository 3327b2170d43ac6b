"""Floor 8: a measured scan as plain values: what summary.json and the tables hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from microslip._version import __version__
from microslip.study.scanned_errors import HEIGHTS, MOMENTS, SUMMITS, UNITS

if TYPE_CHECKING:
    from microslip.scans.cutoffs import CutoffTable
    from microslip.scans.height_distribution import HeightFit
    from microslip.study.scanned import Findings

KIND = "microslip-surface"
"""What summary.json says of a folder of a measured scan."""

NOT_GIVEN = (
    "No short-wave cut-off was given: the pixel decides. Choose one from the table over cut-offs."
)
"""First line of all that is shown then."""

TOO_SMALL = (
    "No short-wave cut-off was given: the pixel decides. The scan is too small to choose one: four "
    "pixels are more than a third of it."
)
"""The same of a scan with nothing to choose from."""


def summarise(found: Findings, files: tuple[str, ...] = ()) -> dict[str, Any]:
    """What summary.json holds.

    Parameters
    ----------
    found : Findings
        What was found.
    files : tuple of str
        Names of the other files.

    Returns
    -------
    dict
        Plain values in SI units; None for what there is not.
    """
    request, scan = found.request, found.scan
    errors = found.errors
    numbers = {name: getattr(found.statistics, name) for name in HEIGHTS}
    numbers |= {name: getattr(found.moments, name) for name in MOMENTS}
    return {
        "kind": KIND,
        "version": __version__,
        "name": found.raw.name,
        "cutoff": request.cutoff,
        "cutoff_given": request.given,
        "long_cutoff": request.long_cutoff,
        "level": request.level,
        "outliers": request.outliers,
        "fill": request.fill,
        "method": request.method,
        "area": request.area,
        "points": list(scan.heights.shape[::-1]),
        "pixel": list(scan.pixel),
        "size": list(scan.size),
        "missing": _plain(scan.missing),
        "warnings": warnings(found),
        "parameters": {
            name: {"value": _plain(value), "error": _plain(errors.get(name)), "unit": UNITS[name]}
            for name, value in numbers.items()
        },
        "summits": {
            estimate: None
            if part is None
            else {
                name: {
                    "value": _plain(getattr(part, name)),
                    "error": _plain(errors.get(f"{estimate}.{name}")),
                    "unit": UNITS[name],
                }
                for name in SUMMITS
            }
            for estimate, part in found.estimates.items()
        },
        "count": None if found.summits is None else found.summits.count,
        "prominence": None if found.summits is None else found.summits.threshold,
        "heights": _height_fit(found.fit),
        "over_cutoffs": _over_cutoffs(found.table),
        "validity": [
            {
                "name": verdict.name,
                "value": _plain(verdict.value),
                "limit": _plain(verdict.limit),
                "word": verdict.word,
                "meaning": verdict.meaning,
            }
            for verdict in found.verdicts
        ],
        "notes": list(scan.notes if found.summits is None else found.summits.notes),
        "files": [*files, *(("summary.json",) if files else ())],
    }


def warnings(found: Findings) -> list[str]:
    """What the reader has to know first, in sentences; none if all is well."""
    not_given = NOT_GIVEN if found.table.cutoff.size > 1 else TOO_SMALL
    return [*(() if found.request.given else (not_given,)), *found.reasons]


def _plain(value: Any) -> float | None:
    """A Python float, or None for what is not known: JSON has no NaN."""
    return float(value) if value is not None and math.isfinite(value) else None


def _height_fit(fit: HeightFit) -> dict[str, Any]:
    return {
        "verdict": fit.verdict,
        "word": fit.gaussian.word,
        "fits": [
            {
                "name": one.name,
                "shapes": [_plain(shape) for shape in one.shapes],
                "place": _plain(one.place),
                "scale": _plain(one.scale),
                "mirrored": one.mirrored,
                "share": _plain(one.share),
                "shift": _plain(one.shift),
                "tail": _plain(one.tail),
                "word": one.word,
            }
            for one in fit.fits
        ],
    }


def _over_cutoffs(table: CutoffTable) -> list[dict[str, float | None]]:
    """A row for each cut-off; null where there is none, the first one."""
    return [
        {
            name: (value or None) if name == "cutoff" else _plain(value)
            for name, value in row.items()
        }
        for row in table.rows()
    ]
