"""Previews of files for the workbench: data and figures of a scan or a record."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import numpy as np

from microslip._core.errors import InputError

if TYPE_CHECKING:
    from microslip.laboratory import Record
    from microslip.surfaces import Scan


def scan_view(scan: Scan, level: Any) -> dict[str, Any]:
    """Return the preview of a scan: levelled height map and spectrum."""
    from microslip.figures.kit import coarse, coloured
    from microslip.figures.svg import png_bytes
    from microslip.surfaces.faults import automatic_level
    from microslip.surfaces.figures import SHARE
    from microslip.surfaces.spectrum import spectrum

    level = automatic_level(scan.notes) if level == "auto" else level
    levelled = scan.condition(level=level)
    view: dict[str, Any] = {
        "what": "scan",
        "level": level or "none",
        "shape": list(scan.heights.shape),
        "pixel": list(scan.pixel),
        "rms": levelled.statistics().rms if not scan.missing else None,
        "missing": scan.missing,
    }
    waves: Any = spectrum(levelled)
    if not scan.is_profile:
        low, high = np.nanquantile(levelled.heights, (SHARE, 1.0 - SHARE)).tolist()
        picture = png_bytes(coloured(coarse(levelled.heights)[::-1], low, high))
        view["picture"] = "data:image/png;base64," + base64.b64encode(picture).decode("ascii")
    else:
        waves = waves.axes[0]
    fine = np.isfinite(waves.wavelength) & np.isfinite(waves.density)
    return {**view, "spectrum": [waves.wavelength[fine].tolist(), waves.density[fine].tolist()]}


def record_view(record: Record, say: Any = str) -> dict[str, Any]:
    """Return the preview of a record: displacement and force over time, loop and cycles.

    If no cycles are found, the entry "no_cycles" is the reason, as text from ``say(error)``.
    """
    from microslip.figures.kit import envelope
    from microslip.laboratory import measure

    time = record.seconds
    has_time = time is not None
    if time is None:
        time = np.arange(len(record), dtype=np.float64)
    every = max(1, len(record) // 4000)
    view: dict[str, Any] = {
        "what": "record",
        "samples": len(record),
        "has_time": has_time,
        "notes": list(map(str, record.notes)),
        "path": [record.displacement[::every].tolist(), record.force[::every].tolist()],
        "cycles": [],
    }
    for name in ("displacement", "force"):
        drawn = envelope(values := getattr(record, name))
        view[name] = [time[drawn].tolist(), values[drawn].tolist()]
    try:
        starts = measure(record).cycles["start"].astype(int)
        view["cycles"] = [float(time[min(start, time.size - 1)]) for start in starts[:400]]
    except InputError as error:
        view["no_cycles"] = say(error)
    return view
