"""What comes beside a record: one number for each sample, or one for all."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats
from microslip.errors import InputError


def loads_along(name: str, loads: ArrayLike, size: int) -> Floats:
    """Normal loads [N] >= 0 of a record of ``size`` samples: one for each, or one for all."""
    values = along(name, loads, size)
    if values.min() < 0.0:
        i = int(np.argmax(values < 0.0))
        where = f" at sample {i}" if np.ndim(loads) else ""
        raise InputError(f"`{name}` must not be negative [N], got {exact(values[i])}{where}")
    return values


def along(name: str, numbers: ArrayLike, size: int) -> Floats:
    """Numbers along a record of ``size`` samples: one for each, or one for all."""
    values = floats(name, numbers)
    if values.ndim > 1 or values.size not in (1, size):
        raise InputError(
            f"`{name}` must be one number or one for each of the {size} samples, got shape "
            f"{values.shape}"
        )
    return np.ascontiguousarray(np.broadcast_to(values.reshape(-1), (size,)))


def saved_array(arrays: Mapping[str, ArrayLike], key: str, width: int | None) -> Floats:
    """One of the arrays that a state was saved in, checked for its shape."""
    try:
        array = np.array(arrays[key], dtype=float)
    except (KeyError, TypeError, ValueError, IndexError):
        raise InputError(f"arrays must hold {key!r}, as to_arrays() of a state gives it") from None
    right = array.shape == (7,) if width is None else array.ndim == 2 and array.shape[1] == width
    if not right or not np.all(np.isfinite(array)):
        shape = "(7,)" if width is None else f"(n, {width})"
        raise InputError(
            f"arrays must hold finite {key!r} of shape {shape}, got shape {array.shape}"
        )
    return array
