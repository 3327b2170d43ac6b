"""Checks of arguments of public functions, with one wording for each kind of mistake.

Numbers are in SI units. A quantity with a unit (pint, astropy, unyt) is converted to the unit of
the argument. It is rejected if it has another dimension or if the argument has no unit; its unit is
never ignored. Values of xarray and pandas objects are taken to be in SI units, even if their
attributes name another unit.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.errors import InputError
from microslip._core.units import LARGEST as LARGEST
from microslip._core.units import SMALLEST as SMALLEST

Floats = NDArray[np.float64]
Progress = Callable[[float], None]
"""Function that is called with the completed fraction of a calculation, from 0 to 1."""


def show(value: Any) -> str:
    """Format a value for an error message, shortened to 60 characters."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # the repr of a foreign object may raise anything
        text = f"a {type(value).__name__} that cannot be shown"
    return text if len(text) <= 60 else text[:57] + "..."


def exact(value: float) -> str:
    """Format a number with the fewest digits that identify it."""
    short = f"{value:g}"
    return short if float(short) == value else repr(float(value))


_PLAIN: frozenset[type] = frozenset({np.ndarray, float, int, bool, np.float64, np.float32, str})


_DEEPEST_LIST = 4
"""Depth of nested lists searched for quantities; inputs have at most three levels."""


def without_unit(name: str, value: Any, unit: str, depth: int = 0) -> Any:
    """Return the magnitude of a quantity in ``unit``; return a value without unit unchanged.

    A quantity has the attributes ``to`` and ``magnitude`` (pint), or ``to``, ``value`` and ``unit``
    (astropy). It may be the ``data`` of an xarray object or an item of a list; ``depth`` is the
    number of lists that contain ``value``. InputError is raised for a quantity of another
    dimension.
    """
    if type(value) in _PLAIN:
        return value
    if isinstance(value, (list, tuple)):
        if depth == _DEEPEST_LIST or set(map(type, value)) <= _PLAIN:
            return value
        return [without_unit(name, item, unit, depth + 1) for item in value]
    quantity = _quantity_of(value)
    if quantity is None:
        return value
    try:
        converted = quantity.to(unit)
        return converted.magnitude if hasattr(converted, "magnitude") else converted.value
    except Exception:  # each library has its own exceptions
        came = getattr(quantity, "units", None) or getattr(quantity, "unit", None)
        expected = f"a quantity in {unit}" if unit else "a plain number without a unit"
        raise InputError(f"`{name}` must be {expected}, got one in {came}") from None


def _quantity_of(value: Any) -> Any:
    try:
        for item in (value, getattr(value, "data", None)):
            if hasattr(item, "to") and (
                hasattr(item, "magnitude") or (hasattr(item, "value") and hasattr(item, "unit"))
            ):
                return item
    except Exception:  # an object's own attributes may raise anything
        pass
    return None


def number(name: str, value: Any, unit: str = "", example: float = 1.0) -> float:
    """Check that a value is a finite real number; convert a quantity to ``unit``."""
    if type(value) is float and math.isfinite(value):  # fast path for solvers
        return value
    if not isinstance(value, (list, tuple)):
        value = without_unit(name, value, unit)
    expected = f"a finite number{f' in {unit}' if unit else ''}"
    if isinstance(value, np.ndarray) and value.ndim == 0 and not np.ma.is_masked(value):
        value = value.item()
    if not isinstance(value, numbers.Real) or isinstance(value, (bool, np.timedelta64)):
        hint = f", for example {name}={example:g}" if isinstance(value, str) else ""
        raise InputError(f"`{name}` must be {expected}, got {show(value)}{hint}")
    try:
        with np.errstate(over="ignore"):
            result = float(value)
    except Exception:  # overflow, or any error of a foreign conversion
        result = math.nan
    if not math.isfinite(result):
        raise InputError(f"`{name}` must be {expected}, got {show(value)}")
    return result


def positive(name: str, value: Any, unit: str = "", example: float = 1.0) -> float:
    """Check that a value is a number from SMALLEST = 1e-40 to LARGEST = 1e40."""
    result = number(name, value, unit, example)
    _check_size(name, result, result, unit)
    return result


def _check_size(name: str, smallest: float, largest: float, unit: str) -> None:
    in_unit = f" [{unit}]" if unit else ""
    if smallest <= 0.0:
        raise InputError(f"`{name}` must be above zero{in_unit}, got {exact(smallest)}")
    if not (smallest >= SMALLEST and largest <= LARGEST):
        worst = exact(largest if largest > LARGEST else smallest)
        limits = f"between {SMALLEST:g} and {LARGEST:g}{in_unit}"
        raise InputError(f"`{name}` must be {limits}, got {worst}")


_FEW = 4096  # size up to which isfinite is faster than the sum below


def floats(
    name: str, value: ArrayLike, unit: str = "", *, missing: bool = False, endless: bool = False
) -> Floats:
    """Check that values are finite numbers and return a contiguous float64 array of the same shape.

    Quantities are converted to ``unit``. Empty arrays raise InputError. ``missing`` allows NaN,
    ``endless`` allows positive infinity.
    """
    if (
        type(value) is np.ndarray
        and value.dtype.char == "d"
        and value.dtype.isnative
        and 0 < value.size <= _FEW
        and value.ndim
        and np.isfinite(value).all()
    ):
        return np.ascontiguousarray(value)
    try:
        value = without_unit(name, value, unit)
        # NumPy would convert bytes to small integers.
        if isinstance(value, (bytes, bytearray)) or np.ma.is_masked(value):
            raise TypeError
        if isinstance(value, memoryview) and value.format in ("B", "b", "c"):
            raise TypeError
        raw_values = np.asarray(value)
        if raw_values.dtype.kind not in "iuf":
            raise TypeError
        with np.errstate(over="ignore"):  # overflow becomes infinity, checked below
            array = np.ascontiguousarray(raw_values, dtype=float).reshape(raw_values.shape)
    except InputError:
        raise
    except Exception:  # an object's own conversion may raise anything
        raise InputError(
            f"`{name}` must be a number or an array of numbers, got {show(value)}"
        ) from None
    if array.size == 0:
        raise InputError(f"`{name}` must hold at least one number, got an empty array")
    # The sum is a fast test: it is finite unless a value is not, or it overflows.
    with np.errstate(all="ignore"):
        total = float(np.add.reduce(array, axis=None))
    if not math.isfinite(total):
        allowed = (missing & np.isnan(raw_values)) | (endless & np.isposinf(raw_values))
        bad = np.flatnonzero(~np.isfinite(array) & ~allowed)
        if bad.size:
            raise InputError(
                f"`{name}` must be finite: {bad.size} of {array.size} values are not, the first "
                f"is {array.flat[bad[0]]} at index {bad[0]}"
            )
    return array


def positives(name: str, value: ArrayLike, unit: str = "") -> Floats:
    """Check that numbers of any shape are from SMALLEST = 1e-40 to LARGEST = 1e40."""
    array = floats(name, value, unit)
    _check_size(name, float(array.min()), float(array.max()), unit)
    return array


def check_one_of(wording: str, first: Any, second: Any) -> None:
    """Check that exactly one of two values is not None; ``wording`` names both in messages."""
    if (first is None) == (second is None):
        came = "neither" if first is None else "both"
        raise InputError(f"exactly one of {wording} must be given, got {came}")


def is_whole(value: Any) -> bool:
    """Return True for an integer other than bool and timedelta64."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.timedelta64))


def whole_number(name: str, value: Any, low: int = 1, high: int | None = None) -> int:
    """Check that a value is an integer from ``low`` to ``high``; None means no upper limit."""
    if not is_whole(value) or value < low or (high is not None and value > high):
        span = f"of at least {low}" if high is None else f"from {low} to {high}"
        raise InputError(f"`{name}` must be an integer {span}, got {show(value)}")
    return int(value)


def rising_orders(name: str, value: Any) -> tuple[int, ...]:
    """Check that values are increasing whole numbers >= 0, such as orders of harmonics."""
    try:
        orders = np.asarray(value)
        fit = orders.dtype.kind in "iu" and orders.ndim == 1 and not np.ma.is_masked(value)
    except Exception:  # an object's own conversion may raise anything
        fit = False
    if not fit or orders.min(initial=0) < 0 or np.any(orders[1:] <= orders[:-1]):
        raise InputError(
            f"`{name}` must be increasing whole numbers, such as [0, 1, 3], got {show(value)}"
        )
    return tuple(orders.tolist())


def members(name: str, value: Any, kind: type, expected: str) -> list[Any]:
    """Check that a value is a nonempty sequence of instances of ``kind``; return a list."""
    checked: list[Any] = []
    try:
        for member in value.ravel().tolist() if isinstance(value, np.ndarray) else value:
            if not isinstance(member, kind):
                raise InputError(
                    f"`{name}` must be {expected}, got {show(member)} at index {len(checked)}"
                )
            checked.append(member)
    except InputError:
        raise
    except Exception:  # not iterable, or any error of a foreign iterator
        raise InputError(f"`{name}` must be {expected}, got {show(value)}") from None
    if not checked:
        raise InputError(f"`{name}` must be {expected}, got none")
    return checked


def beyond(values: Any, scale: Any) -> Any:
    """Divide ``values`` by ``scale``; an overflow gives infinity without a warning."""
    with np.errstate(over="ignore"):
        return values / scale


def sized(name: str, value: ArrayLike, unit: str = "m") -> Floats:
    """Check that absolute values are at most LARGEST = 1e40, so that energies stay finite."""
    array = floats(name, value, unit)
    if max(-float(array.min()), float(array.max())) > LARGEST:
        worst = float(np.abs(array).max())
        raise InputError(f"`{name}` must be at most {LARGEST:g} {unit}, got {worst:g} {unit}")
    return array


def record(name: str, value: ArrayLike, unit: str = "") -> Floats:
    """Check that a value is a one-dimensional series; a number is a series of one sample."""
    array = floats(name, value, unit)
    if array.ndim > 1:
        raise InputError(f"`{name}` must be one-dimensional, got shape {array.shape}")
    return array


def plain(array: Floats, like: Any = None) -> Any:
    """Return a result in the type of the argument ``like`` from which it was computed.

    A zero-dimensional result becomes a float. If ``like`` is an object of xarray or pandas with the
    shape of the result, the result gets its dimensions, coordinates, index and columns, but not its
    name and attributes, which describe the argument.
    """
    if type(like) not in _PLAIN:
        library = type(like).__module__.partition(".")[0]
        if library == "xarray" and getattr(like, "shape", None) == array.shape:
            return type(like)(array, coords=like.coords, dims=like.dims)
        if library == "pandas" and getattr(like, "shape", None) == array.shape:
            labels = {
                name: getattr(like, name) for name in ("index", "columns") if hasattr(like, name)
            }
            return type(like)(array, **labels) if labels else array
    return float(array) if array.ndim == 0 else array
