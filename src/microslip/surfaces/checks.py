"""Validation of the heights and the pixel of a scan."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import LARGEST, exact, floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.units import AREA, LENGTH, Kind, QuantityError, engineering, to_si

SPIKE = 1e6
"""Distance from the median, in median distances, beyond which a point is invalid."""

REMOTENESS = 3.0
"""Distance from all other points, in ranges of those points, beyond which a repeated height may
denote missing points."""

_LEAST_SLOPE = 3e-4
"""Rms slope between points below which the height unit is probably wrong."""

_ATOM = 1e-10  # [m] smaller variations are rounding


def far_points(heights: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask of heights so far from the median that in a plot all others would look flat."""
    none = np.zeros(heights.shape, dtype=bool)
    # 100 000 points suffice for the usual distance and take milliseconds.
    step = max(1, heights.size // 100_000)
    sample = heights.ravel()[::step]
    sample = sample[~np.isnan(sample)]
    if sample.size < 4:
        return none
    middle = float(np.median(sample))
    usual = float(np.median(np.abs(sample - middle)))
    if usual < _ATOM:  # mostly flat: use the range of the central 98 %
        low, high = np.percentile(sample, (1.0, 99.0))
        usual = max(float(high - low), _ATOM)
    far = middle + SPIKE * usual, middle - SPIKE * usual
    if np.nanmax(heights) <= far[0] and np.nanmin(heights) >= far[1]:
        return none
    return (heights > far[0]) | (heights < far[1])


def repeated(heights: NDArray[np.float64]) -> tuple[float, int, float, float] | None:
    """Return a probable fill value, its count, and limits of the other heights; or None.

    A fill value, such as -9999, occurs several times exactly, and its distance from all other
    heights exceeds three times their range.
    """
    for end, beyond in ((np.nanmin, np.greater), (np.nanmax, np.less)):
        value = float(end(heights))
        count = int(np.count_nonzero(heights == value))
        if count < 2:
            continue
        remainder = heights[beyond(heights, value)]
        if remainder.size < max(4, count):
            continue
        low, high = float(remainder.min()), float(remainder.max())
        size = high - low
        if max(low - value, value - high) > REMOTENESS * size > 0.0:
            # Limits with few digits, one to two ranges beyond the other heights.
            digit = 10.0 ** math.floor(math.log10(size))
            low, high = math.floor(low / digit - 1.0), math.ceil(high / digit + 1.0)
            return value, count, low * digit, high * digit
    return None


def exact_zeros(heights: NDArray[np.float64]) -> int | None:
    """Return how often height 0 occurs if that is over ten times as often as heights next to it.

    Otherwise return None: in data with few digits all heights near zero are equally frequent.
    """
    count = int(np.count_nonzero(heights == 0.0))
    if count < 10 or count < 1e-5 * heights.size:
        return None
    sizes = np.abs(heights[(heights != 0.0) & ~np.isnan(heights)])
    if sizes.size < 10:
        return None
    near = np.partition(sizes, min(2 * count, sizes.size - 1))[: 2 * count + 1]
    _, often = np.unique(near, return_counts=True)
    # Both signs contribute to each absolute value.
    return count if count > 10 * int(often.max()) else None


def implausible(heights: NDArray[np.float64], pixel: tuple[float, ...]) -> list[str]:
    """Return messages about heights or a pixel that are probably in the wrong unit."""
    low, high = np.nanpercentile(heights[:: max(1, heights.shape[0] // 500)], (0.5, 99.5)).tolist()
    height, step = high - low, min(pixel)
    size = max(n * s for n, s in zip(heights.shape[::-1], pixel, strict=True))
    questions = []
    if not 1e-11 < height < 5e-2 or height > 3.0 * size:
        questions.append(
            f"heights span {engineering(height, 'm')} on {engineering(size, 'm')}: check their unit"
        )
    slopes = [
        float(np.sqrt(np.nanmean(np.diff(heights, axis=axis) ** 2))) / distance
        for axis, distance in zip(range(heights.ndim), pixel[::-1], strict=True)
    ]
    if 0.0 < max(slopes) < _LEAST_SLOPE:
        questions.append(
            f"the rms slope {max(slopes):.2g} is smaller than that of polished faces: check the "
            "unit of the heights"
        )
    if not 1e-10 < step < 5e-3:
        questions.append(f"the pixel is {engineering(step, 'm')}: check its unit")
    return questions


def enough(name: str, heights: NDArray[np.float64]) -> None:
    """Raise an InputError for an area with too few rows or columns for curvatures."""
    if heights.ndim == 2 and min(heights.shape) < 3:
        size = " x ".join(str(count) for count in heights.shape[::-1])
        raise InputError(
            f"{name[:60]}: curvatures need three points along x and y, got {size}; for a "
            "profile, use one row"
        )


def objection(heights: NDArray[np.float64]) -> str:
    """Return the reason why heights cannot be evaluated: constant, or with huge spikes; else ""."""
    low, high = float(np.fmin.reduce(heights, axis=None)), float(np.fmax.reduce(heights, axis=None))
    if low == high:
        return f"all heights are {exact(low)} m; read another channel, or export more digits"
    if count := int(np.count_nonzero(far_points(heights))):
        return (
            f"{count} of {heights.size} points lie more than {SPIKE:g} times farther from "
            f"the median than usual (lowest {low:g} m, highest {high:g} m); remove them "
            'with `repaired()`, or `valid=("-1 mm", "1 mm")` when reading'
        )
    return ""


def pixel_of(pixel: Any, axes: int) -> tuple[float, ...]:
    """Return the distance between neighbouring points [m] along each axis.

    ``pixel`` is one distance for all ``axes`` (1 or 2), or one per axis.
    """
    if isinstance(pixel, (list, tuple)):
        steps = tuple(_step(distance) for distance in pixel)
    elif isinstance(pixel, np.ndarray) and pixel.ndim:
        steps = tuple(_step(step) for step in floats("pixel", pixel, "m").ravel().tolist())
    else:
        return (_step(pixel),) * axes
    if len(steps) != axes:
        shape = "one distance" if axes == 1 else "one distance, or (along x, along y)"
        raise InputError(f"`pixel` must be {shape}, got {len(steps)} of them")
    return steps


def length_of(name: str, value: Any, example: str) -> float:
    """Return a length [m] from a number in metres, or from text with a unit."""
    return _quantity(name, value, LENGTH, example, 1e-5)


def area_of(area: Any) -> float:
    """Return an area [m^2] from a number in square metres, or from text such as "2 cm^2"."""
    return _quantity("area", area, AREA, "2 cm^2", 1e-4)


def _quantity(name: str, value: Any, kind: Kind, example: str, number: float) -> float:
    if isinstance(value, str):
        try:
            return to_si(value, kind, example)
        except QuantityError as error:
            raise InputError(f"`{name}`: {error}") from None
    return positive(name, value, kind.unit, number)


def _step(value: Any) -> float:
    step = length_of("pixel", value, "1.66 um")
    if not 1e-15 <= step <= 1e3:
        raise InputError(f"`pixel` must be between 1e-15 m and 1000 m, got {exact(step)} m")
    return step


def height_array(heights: ArrayLike) -> NDArray[np.float64]:
    """Validate heights and return them as a read-only array; NaN where they are missing."""
    mask = np.ma.getmaskarray(heights) if np.ma.isMaskedArray(heights) else None
    try:
        array = np.asarray(np.ma.getdata(heights) if mask is not None else heights)
    except Exception:  # an object's own conversion may raise anything
        raise InputError(f"`heights` must be an array of numbers, got {show(heights)}") from None
    if array.dtype.kind not in "iuf":
        raise InputError(f"`heights` must be an array of numbers, got {show(heights)}")
    if array.ndim not in (1, 2):
        raise InputError(
            "`heights` must have two dimensions, rows along y and columns along x, or one "
            f"for a profile, got shape {array.shape}"
        )
    if array.ndim == 1 and array.size < 4:
        raise InputError(f"a profile needs at least four points, got {array.size}")
    if array.ndim == 2 and min(array.shape) < 2:
        hint = "; for a profile, give one dimension" if array.size > 3 else ""
        rows, columns = array.shape
        raise InputError(
            f"`heights` must have at least two rows and two columns, got {rows} x {columns}{hint}"
        )
    # Arrays locked by this package are not copied.
    shared = array.dtype == np.float64 and array.flags.c_contiguous and mask is None
    if not (shared and not array.flags.writeable and array.base is None):
        with np.errstate(all="ignore"):  # overflow is detected below
            array = np.array(array, dtype=np.float64, order="C")
    if mask is not None:
        array[mask] = np.nan
    _check_values(array)
    return lock(array)


def _check_values(array: NDArray[np.float64]) -> None:
    with np.errstate(all="ignore"):
        low, high = float(np.fmin.reduce(array, axis=None)), float(np.fmax.reduce(array, axis=None))
    if math.isnan(low):
        raise InputError(f"all {array.size} heights are missing (NaN)")
    if math.isinf(low) or math.isinf(high):
        count = np.count_nonzero(np.isinf(array))
        raise InputError(
            f"`heights` must be finite, or NaN where missing: {count} of {array.size} are infinite"
        )
    if max(-low, high) > LARGEST:
        worst = low if -low > high else high
        raise InputError(
            f"`heights` must be heights in metres, got {worst:g} m; mark missing points as NaN"
        )
