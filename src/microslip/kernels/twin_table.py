"""Tables in NumPy: part of :mod:`microslip.kernels.twin`."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip.kernels.layout import TERMS, Floats

_BLOCK = 8192  # samples a pass, so that temporaries stay in cache


def _shape(c: Any, s: Any) -> Any:
    """The polynomial of a panel: a row of coefficients and a number, or arrays for each."""
    q = s * s
    even = ((((c[10] * q + c[8]) * q + c[6]) * q + c[4]) * q + c[2]) * q + c[0]
    odd = ((((c[11] * q + c[9]) * q + c[7]) * q + c[5]) * q + c[3]) * q + c[1]
    return odd * s + even


def _shape_slope(c: Any, s: Any) -> Any:
    q = s * s
    even = ((((11 * c[11]) * q + 9 * c[9]) * q + 7 * c[7]) * q + 5 * c[5]) * q + 3 * c[3]
    odd = ((((10 * c[10]) * q + 8 * c[8]) * q + 6 * c[6]) * q + 4 * c[4]) * q + 2 * c[2]
    return (even * q + c[1]) + odd * s


def _value(u: Any, shape: Any, power: int) -> Any:
    """u^power S for a power of 0 to 3."""
    for _ in range(power):
        shape = u * shape
    return shape


def _slope(u: Any, shape: Any, grade: Any, power: int) -> Any:
    if power == 0:
        return grade
    slope = power * shape + u * grade
    for _ in range(power - 1):
        slope = u * slope
    return slope


def evaluate(
    u: Floats,
    value: Floats,
    slope: Floats | None,
    coefficients: Floats,
    inverse_width: float,
    power: int,
    limit: float,
    rate: float,
) -> None:
    """Value, and slope if an array is given for it, of a table at ``u``."""
    columns = np.ascontiguousarray(coefficients.reshape(-1, TERMS).T)
    panels = columns.shape[1]
    end = panels / inverse_width
    for start in range(0, u.size, _BLOCK):
        part = slice(start, start + _BLOCK)
        v = u[part]
        z = v * inverse_width
        outside = ~(z < panels)
        panel = np.where(outside, 0, z).astype(np.int64)
        # Beyond the table the polynomials would overflow, and are not used.
        s = np.where(outside, 0.0, 2.0 * (z - panel) - 1.0)
        c = [column.take(panel) for column in columns]
        shape = _shape(c, s)
        inside = np.where(outside, 0.0, v)
        value[part] = _value(inside, shape, power)
        if slope is not None:
            slope[part] = _slope(inside, shape, 2.0 * inverse_width * _shape_slope(c, s), power)
        if outside.any():
            value[part][outside] = limit + rate * (v[outside] - end) if rate else limit
            if slope is not None:
                slope[part][outside] = rate


def evaluate_one(
    u: float, coefficients: Floats, inverse_width: float, power: int, limit: float, rate: float
) -> tuple[float, float]:
    """Value and slope of a table at one place, in the order of operations of :func:`evaluate`."""
    z = u * inverse_width
    panels = coefficients.size // TERMS
    if not z < panels:
        return (limit + rate * (u - panels / inverse_width) if rate else limit), rate
    panel = int(z)
    s = 2.0 * (z - panel) - 1.0
    c: list[float] = coefficients.reshape(-1, TERMS)[panel].tolist()
    shape = _shape(c, s)
    grade = 2.0 * inverse_width * _shape_slope(c, s)
    return _value(u, shape, power), _slope(u, shape, grade, power)
