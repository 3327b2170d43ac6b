"""Running in: a quantity that tends to its settled value exponentially, with its constant."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.tribometer.estimates import Estimate, dependence_of, quantile

_LEAST = 12
_GRID = 240
_CERTAIN = 5.0
"""Standard errors from which on there is something that runs in."""


class RunningIn(NamedTuple):
    """y = settled + change exp(-(n - first)/constant), n being the number of the cycle."""

    label: str
    column: str
    settled: Estimate
    """Asymptote, in the unit of the column."""
    change: float
    """Excess over it at the first cycle."""
    constant: Estimate
    """Cycles in which what is left falls to 1/e."""
    first: float
    """Number of the first cycle."""
    numbers: Floats
    """Numbers of the cycles, and their values."""
    values: Floats

    def at(self, numbers: Floats) -> Floats:
        """The law at some cycles."""
        return self.settled.value + self.change * np.exp(
            -(numbers - self.first) / self.constant.value
        )


def running_in(
    label: str, column: str, numbers: Floats, values: Floats, confidence: float
) -> RunningIn | None:
    """The law of one contact; None where nothing runs in, or its constant is not told.

    Least squares, by the profile over the constant; neighbouring cycles that are alike widen it.
    """
    fine = np.isfinite(numbers) & np.isfinite(values)
    n, y = numbers[fine], values[fine]
    if n.size < _LEAST or not n[-1] > n[0]:
        return None
    first = float(n[0])
    away = n - first
    reach = float(away[-1])
    step = float(np.diff(n).min())
    constants = np.geomspace(0.3 * max(step, 1e-3 * reach / n.size), 3.0 * reach, _GRID)
    fits = [_line(np.exp(-away / constant), y) for constant in constants]
    squares = np.array([fit[0] for fit in fits])
    best = int(squares.argmin())
    if best in (0, _GRID - 1):
        return None
    freedom = n.size - 3
    constant = float(constants[best])
    square, settled, change, error, of_settled = _line(np.exp(-away / constant), y)
    residual = y - settled - change * np.exp(-away / constant)
    dependence = dependence_of(residual, 3)
    freedom = min(freedom, max(dependence.freedom, 1))
    noise = square / max(n.size - 3, 1) * dependence.factor
    if not abs(change) > _CERTAIN * error * math.sqrt(noise):
        return None
    edge = square + quantile(confidence, freedom) ** 2 * noise
    inside = np.flatnonzero(squares <= edge)
    low, high = int(inside[0]), int(inside[-1])
    # Beyond a third of what was seen the settled value is an extrapolation.
    if low == 0 or high == _GRID - 1 or constants[high] > 0.5 * reach:
        return None
    t = quantile(confidence, freedom)
    ends = [float(constants[low - 1]), float(constants[high + 1])]
    settles = [fits[at][1] for at in inside]
    half = t * of_settled * math.sqrt(noise)
    span = Estimate(constant, ends[0], ends[1], (ends[1] - ends[0]) / (2.0 * t), int(n.size))
    limit = Estimate(
        settled,
        settled - math.hypot(half, settled - min(settles)),
        settled + math.hypot(half, max(settles) - settled),
        half / t,
        int(n.size),
    )
    return RunningIn(label, column, limit, change, span, first, n, y)


def _line(x: Floats, y: Floats) -> tuple[float, float, float, float, float]:
    """Squares beside a line, its value at zero, its slope, and errors of both of unit noise."""
    middle = float(x.mean())
    away = x - middle
    square = max(float(away @ away), 1e-300)
    slope = float(away @ y) / square
    at_zero = float(y.mean()) - slope * middle
    left = y - at_zero - slope * x
    error = 1.0 / math.sqrt(square)
    return float(left @ left), at_zero, slope, error, math.sqrt(1.0 / x.size + middle**2 / square)
