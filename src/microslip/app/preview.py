"""What a file holds, for a look before anything is computed: run as a process of its own.

Reads one JSON table from the standard input and answers with one.
"""

from __future__ import annotations

import base64
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from microslip.errors import InputError

_POINTS = 1200
_SCAN_OPTIONS = ("unit", "pixel", "key", "channel")
_RECORD_OPTIONS = ("displacement", "force", "normal_load", "time", "sample_rate")


def look(question: dict[str, Any]) -> dict[str, Any]:
    """Look into a scan or a record; with a part of it to keep, write that to a file."""
    path = Path(question["path"])
    options = {k.replace("-", "_"): v for k, v in (question.get("options") or {}).items() if v}
    if question["what"] == "scan":
        return _scan(path, options, question.get("part"), question.get("save"))
    return _record(path, options, question.get("part"), question.get("save"))


def _scan(path: Path, options: dict[str, Any], part: Any, save: str | None) -> dict[str, Any]:
    from microslip.report.svg import png_bytes
    from microslip.scans import Scan
    from microslip.scans.figures import SHARE, coarse, coloured
    from microslip.scans.spectrum import spectrum

    reading: dict[str, Any] = {k: v for k, v in options.items() if k in _SCAN_OPTIONS}
    for name in ("unit", "pixel"):
        if isinstance(reading.get(name), list):
            values = reading[name]
            reading[name] = values[0] if len(values) == 1 else tuple(values)
    scan = Scan.read(path, **reading)
    if part is not None and save is not None:
        return _save_scan(scan, part, Path(save))
    level = scan.condition(level=options.get("level", "plane"))
    view: dict[str, Any] = {
        "what": "scan",
        "name": path.name,
        "shape": list(scan.heights.shape),
        "size": list(scan.size),
        "pixel": list(scan.pixel),
        "notes": list(map(str, scan.notes)),
        "rms": level.statistics().rms if not scan.missing else None,
        "missing": scan.missing,
    }
    waves: Any = spectrum(level)
    if not scan.is_profile:
        low, high = np.nanquantile(level.heights, (SHARE, 1.0 - SHARE)).tolist()
        picture = png_bytes(coloured(coarse(level.heights)[::-1], low, high))
        view["picture"] = "data:image/png;base64," + base64.b64encode(picture).decode("ascii")
        view["heights"] = [low, high]
    else:
        waves = waves.axes[0]
    return {**view, "spectrum": _pairs(waves.wavelength, waves.density)}


def _save_scan(scan: Any, part: Any, save: Path) -> dict[str, Any]:
    """Write the rectangle that was drawn, [left, right, bottom, top] in metres, as arrays."""
    dx, dy = scan.pixel
    left, right, bottom, top = (float(x) for x in part)
    columns = slice(max(round(left / dx), 0), round(right / dx) + 1)
    rows = slice(max(round(bottom / dy), 0), round(top / dy) + 1)
    heights = scan.heights[rows, columns]
    if min(heights.shape) < 8:
        raise InputError(f"the part must have at least 8 x 8 points, got {heights.shape}")
    with save.open("wb") as file:
        np.save(file, heights, allow_pickle=False)
    shape = " x ".join(map(str, heights.shape[::-1]))
    return {"unit": "m", "pixel": [f"{dx!r} m", f"{dy!r} m"], "kept": shape}


def _record(path: Path, options: dict[str, Any], part: Any, save: str | None) -> dict[str, Any]:
    from microslip.tribometer import Record, measure

    reading: dict[str, Any] = {k: v for k, v in options.items() if k in _RECORD_OPTIONS}
    if options.get("turn"):
        reading["turn"] = True
    record = Record.read(path, **reading)
    if part is not None and save is not None:
        return _save_record(record, part, Path(save))
    time, has_time = _times(record)
    every = max(1, len(record) // 4000)
    view: dict[str, Any] = {
        "what": "record",
        "name": record.name,
        "samples": len(record),
        "has_time": has_time,
        "notes": list(map(str, record.notes)),
        "displacement": _envelope(time, record.displacement),
        "force": _envelope(time, record.force),
        "path": _pairs(record.displacement[::every], record.force[::every]),
        "cycles": [],
    }
    try:
        cycles = measure(record).cycles
        starts = cycles["start"].astype(int)
        view["cycles"] = [float(time[min(start, time.size - 1)]) for start in starts[:400]]
    except InputError as error:
        view["notes"].append(str(error))
    return view


def _save_record(record: Any, part: Any, save: Path) -> dict[str, Any]:
    """Write the samples between two times as a record of their own."""
    time, _ = _times(record)
    first, last = np.searchsorted(time, sorted(float(x) for x in part))
    keep = slice(int(first), int(last) + 1)
    if time[keep].size < 16:
        raise InputError(f"the part must have at least 16 samples, got {time[keep].size}")

    def cut(values: Any) -> Any:
        return values[keep] if np.ndim(values) == 1 else values

    type(record)(
        cut(record.displacement), cut(record.force), normal_load=cut(record.normal_load),
        time=cut(record.time), sample_rate=record.sample_rate, name=record.name,
    ).to_csv(save)  # fmt: skip
    return {"kept": f"{time[keep].size} samples"}


def _times(record: Any) -> tuple[Any, bool]:
    """Times [s], or the numbers of the samples."""
    if record.time is not None:
        return record.time, True
    numbers = np.arange(len(record), dtype=np.float64)
    if record.sample_rate is not None:
        return numbers / record.sample_rate, True
    return numbers, False


def _envelope(time: Any, values: Any) -> list[list[float]]:
    """A record for a picture: all of it, or the extremes of each stretch."""
    width = -(-values.size // _POINTS)
    if width < 3:
        return _pairs(time, values)
    stretches = values[: values.size // width * width].reshape(-1, width)
    starts = width * np.arange(len(stretches))
    ends = np.sort(np.stack([stretches.argmin(axis=1), stretches.argmax(axis=1)]), axis=0) + starts
    places = ends.T.ravel()
    return _pairs(time[places], values[places])


def _pairs(x: Any, y: Any) -> list[list[float]]:
    fine = np.isfinite(x) & np.isfinite(y)
    return [np.asarray(x)[fine].tolist(), np.asarray(y)[fine].tolist()]


def main() -> None:
    """Answer one question."""
    try:
        answer = look(json.load(sys.stdin))
    except InputError as error:
        answer = {"error": str(error)}
    except (OSError, ValueError, TypeError, KeyError, MemoryError) as error:
        answer = {"error": f"{type(error).__name__}: {error}"[:500]}
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main()
