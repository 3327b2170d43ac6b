"""Conversion of a file to a scan: format, units, pixel size, missing points, and notes."""

from __future__ import annotations

import math
import numbers
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.errors import InputError
from microslip._core.units import LENGTH, QuantityError, engineering, to_si
from microslip._core.verdicts import Remark
from microslip._core.wording import quote, shorten
from microslip.readers.files import POINTS, reading
from microslip.readers.instruments import RawHeights
from microslip.surfaces.checks import (
    exact_zeros,
    far_points,
    height_array,
    implausible,
    pixel_of,
    repeated,
)
from microslip.surfaces.faults import faults
from microslip.surfaces.heights_in_files import read_heights
from microslip.surfaces.repair import fill_values

SUSPECT = "suspect"
"""Kind of a remark on points that may denote missing measurements."""

UNIT_QUESTION = "likely unit error"
"""Kind of a remark on probably wrong units."""


def read_scan(
    path: Path,
    format_name: Any,
    unit: Any,
    pixel: Any,
    channel: Any,
    valid: Any,
    limit: int = POINTS,
) -> tuple[np.ndarray, tuple[float, ...], str, tuple[str, ...]]:
    """Return heights [m], NaN where missing, pixel [m], name and notes of a scan.

    Options that the user has not given are None. Error messages contain the file name.
    """
    with reading(path, "a scan", limit, shorten(str(path), 200)):
        raw = _line(read_heights(path, format_name, channel, pixel is not None))
        return _scan_content(raw, path, unit, pixel, valid)


def _scan_content(
    raw: RawHeights, path: Path, unit: Any, given_pixel: Any, valid: Any
) -> tuple[np.ndarray, tuple[float, ...], str, tuple[str, ...]]:
    factors, notes = _units(raw, unit)
    pixel, origin = _pixel(raw, given_pixel, factors[0])
    heights = _metres(raw.values, factors[1])
    notes += _valid(heights, valid)
    heights = height_array(heights)
    pixel = pixel_of(pixel, heights.ndim)
    name = shorten(path.name, 100)
    counts = " x ".join(str(n) for n in heights.shape[::-1])
    steps = " x ".join(engineering(step, "m", 4) for step in dict.fromkeys(pixel))
    first = f"{name}: {raw.kind}, {counts} points, pixel {steps} {origin}."
    low, high = np.nanmin(heights), np.nanmax(heights)
    if low == high:
        raise ValueError(
            f"all heights are {engineering(float(low), 'm', 6, trim=True)}: nothing to measure; "
            "read another channel or array"
        )
    missing = float(np.count_nonzero(np.isnan(heights)) / heights.size)
    if missing:
        notes.append(f"missing: {missing:.3g} of the points.")
    if count := int(np.count_nonzero(far_points(heights))):
        spiky = (
            f"spikes: {count} points lie more than a million times farther from the median "
            f"than usual, up to {engineering(float(max(abs(low), abs(high))), 'm')}; "
            "remove them with `repaired()`."
        )
        notes.append(spiky)
    elif atom := repeated(heights):
        value, count, *limits = atom
        lowest, highest = (engineering(limit, "m", 6, trim=True) for limit in limits)
        words = (
            f"{count} points are all {_length(value)}, far from all others; if that "
            "denotes missing points, remove them with `repaired()`, or with "
            f'`valid=("{lowest}", "{highest}")` when reading.'
        )
        notes.append(Remark(SUSPECT, words))
    if (zeros := exact_zeros(heights)) is not None:
        words = (
            f"{zeros} points are exactly 0, far more than at any other height; if 0 "
            "denotes missing points, mark them as missing (NaN) first."
        )
        notes.append(Remark(SUSPECT, words))
    measured = np.where(fill_values(heights), np.nan, heights)
    notes += [Remark(UNIT_QUESTION, question) for question in implausible(measured, pixel)]
    notes += faults(measured)
    return heights, pixel, name, (first, *raw.notes, *notes)


def _line(raw: RawHeights) -> RawHeights:
    shape = np.shape(raw.values)
    if len(shape) != 2 or min(shape) != 1 or max(shape) < 4:
        return raw
    row = shape[0] == 1
    lines = "one row" if row else "one column"
    pixel = raw.pixel if raw.pixel is None or len(raw.pixel) == 1 else raw.pixel[int(not row) :][:1]
    return raw._replace(
        values=raw.values.reshape(-1),
        pixel=pixel,
        notes=(*raw.notes, f"profile: {lines} of {max(shape)} points, read as a profile."),
    )


def _units(raw: RawHeights, unit: Any) -> tuple[tuple[float, float], list[str]]:
    """Return metres per unit of the coordinates and metres per unit of the heights, and notes."""
    if raw.unit is not None:
        if unit is not None:
            raise InputError(f'the file states heights in "{shorten(raw.unit, 20)}"; omit `unit`')
        factor = _factor(raw.unit)
        return (factor, factor), [f"heights: in {shorten(raw.unit, 20)}, as stated in the file."]
    across, up = raw.columns
    if unit is None:
        if up is None:
            example = '"um"' if across is None else f'("{across}", "um")'
            raise InputError(
                "the file does not state the unit of its heights; write for example "
                f"`unit={example}`"
            )
        if across is None and raw.steps is not None:
            raise InputError(
                f'the file states heights in "{up}", but not the unit of coordinates; '
                f'write for example `unit=("mm", "{up}")`'
            )
        return _factors((across or up, up), raw, "as stated in the file")
    pair = unit if isinstance(unit, (list, tuple)) else (unit,) * 2
    if len(pair) != 2:
        raise InputError(
            '`unit`: wanted a unit such as "um", or units of the coordinates and of the '
            f'heights such as `unit=("mm", "um")`, got {quote(unit)}'
        )
    for axis, file_unit, stated in zip(("coordinates", "heights"), (across, up), pair, strict=True):
        if file_unit is not None and _factor(file_unit) != _factor(stated):
            units = f'("{across or pair[0]}", "{up or pair[1]}")'
            raise InputError(
                f'the file states {axis} in "{file_unit}", not "{shorten(stated, 20)}"; '
                + ("omit `unit`" if across and up else f"write `unit={units}`")
            )
    return _factors((pair[0], pair[1]), raw, "as given")


def _factors(
    pair: tuple[Any, Any], raw: RawHeights, source: str
) -> tuple[tuple[float, float], list[str]]:
    notes = [f"heights: in {shorten(str(pair[1]), 20)}, {source}."]
    if raw.steps is not None and pair[0] != pair[1]:
        notes.append(f"coordinates: in {shorten(str(pair[0]), 20)}, {source}.")
    return (_factor(pair[0]), _factor(pair[1])), notes


def _factor(unit: Any) -> float:
    if not isinstance(unit, str) or not unit.strip():
        raise InputError(f'`unit`: wanted a unit of length such as "um", got {quote(unit)}')
    try:
        return to_si(f"1 {unit.strip()}", LENGTH, "1 um")
    except QuantityError as error:
        raise InputError(f"`unit`: {error}") from None


def _pixel(raw: RawHeights, given: Any, factor: float) -> tuple[tuple[float, ...], str]:
    """Return the distance of neighbouring points [m], and a note of its source."""
    axes = np.ndim(raw.values)
    if given is not None:
        if axes not in (1, 2):
            axes = 2
        before = raw.pixel
        source = "as given"
        if before is not None:
            steps = " x ".join(engineering(step, "m", 4) for step in dict.fromkeys(before))
            source += f" (the file states {steps})"
        return pixel_of(given, axes), source
    if raw.pixel is not None:
        return raw.pixel, "as stated in the file"
    if raw.steps is not None:
        return tuple(step * factor for step in raw.steps), "by its coordinates"
    raise InputError('the file does not state the pixel; write for example `pixel="1.66 um"`')


def _metres(heights: np.ndarray, factor: float) -> np.ndarray:
    mask = np.ma.getmaskarray(heights) if np.ma.isMaskedArray(heights) else None
    values = np.ma.getdata(heights)
    if values.dtype.kind not in "iuf":
        raise ValueError(f"wanted real heights, got an array of {values.dtype}")
    values = values.astype(
        np.float64, copy=False
    )  # before scaling, to avoid rounding in single precision
    with np.errstate(all="ignore"):  # overflow is rejected as a height
        # Divide by a whole reciprocal: 0.3 um then becomes exactly 3e-7.
        reciprocal = round(1.0 / factor) if factor < 1.0 else 0
        exact = reciprocal and math.isclose(reciprocal * factor, 1.0, rel_tol=1e-15)
        result = values / float(reciprocal) if exact else values * factor
    result = np.ascontiguousarray(result, dtype=np.float64)
    if mask is not None and mask.any():
        result[mask] = np.nan
    return result


def _valid(heights: np.ndarray, limits: Any) -> list[str]:
    if limits is None:
        return []
    if not isinstance(limits, (list, tuple)) or len(limits) != 2:
        raise InputError(
            f'`valid` must be two heights such as ("-1 mm", "1 mm"), got {quote(limits)}'
        )
    low, high = (_height(limit) for limit in limits)
    if not low < high:
        raise InputError(
            f"`valid`: the first height must be the lower one, got {_length(low)} and "
            f"{_length(high)}"
        )
    beyond = (heights < low) | (heights > high)
    count = int(np.count_nonzero(beyond))
    heights[beyond] = np.nan
    points = "1 point" if count == 1 else f"{count} points"
    verb = "is" if count == 1 else "are"
    return [f"valid: {points} below {_length(low)} or above {_length(high)} {verb} missing."]


def _length(value: float) -> str:
    return engineering(value, "m", 4, trim=True)


def _height(value: Any) -> float:
    if isinstance(value, str):
        try:
            return to_si(value, LENGTH, "1 mm", sign="any")
        except QuantityError as error:
            raise InputError(f"`valid`: {error}") from None
    if isinstance(value, numbers.Real) and not isinstance(value, bool) and not math.isnan(value):
        return float(value)
    raise InputError(f'`valid`: wanted a height [m] or such as "1 mm", got {quote(value)}')
