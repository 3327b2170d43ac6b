"""Smooth backbones as piecewise polynomials, accurate to rounding and fast to evaluate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock

_POINTS = kernels.TERMS + 2
_ANGLES = math.pi * (np.arange(_POINTS) + 0.5) / _POINTS
NODES = np.cos(_ANGLES)
"""Nodes of a panel in [-1, 1]."""
TO_SERIES = 2.0 / _POINTS * np.cos(np.outer(_ANGLES, np.arange(_POINTS)))
TO_SERIES[:, 0] *= 0.5
"""Matrix from samples on a panel, in rows, to its Chebyshev series."""
# A separate step from series to powers of s: high coefficients are then at rounding level, so the
# large entries of this matrix do no harm.
TO_POWERS = np.array(
    [
        np.pad(chebyshev.cheb2poly(row), (0, kernels.TERMS))[: kernels.TERMS]
        for row in np.eye(kernels.TERMS)
    ]
)
_ROUNDING = 2e-15  # truncation error over the value on a panel
_PANELS = (16, 24, 32, 48, 64, 96, 128, 192, 256)


@dataclass(frozen=True, eq=False)
class PolynomialTable(Locked):
    """Function u^power S(u), u >= 0, with S polynomial on equal panels; linear beyond them."""

    coefficients: Floats  # (panels, TERMS)
    inverse_width: float
    power: int
    limit: float
    rate: float

    @classmethod
    def sample(
        cls,
        shape: Callable[[Floats], Floats],
        end: float,
        power: int,
        limit: float,
        rate: float = 0.0,
        tolerance: float = 1e-13,
    ) -> PolynomialTable | None:
        """Sample S on (0, end]; None if panels do not resolve it to the relative ``tolerance``.

        Storing S instead of the function keeps the relative accuracy as u approaches 0. Panels are
        halved until the truncation error is within rounding, or stops decreasing because ``shape``
        itself has rounding errors. Beyond ``end`` the function is ``limit`` + ``rate`` (u - end).
        """
        before = math.inf
        for panels in _PANELS:
            width = end / panels
            u = width * (np.arange(panels)[:, None] + 0.5 * (1.0 + NODES))
            series = shape(u.reshape(-1)).reshape(u.shape) @ TO_SERIES
            left_out = np.abs(series[:, kernels.TERMS - 1 :]).max(axis=1)
            size = np.abs(series[:, 0])
            if not size.min() > 0.0:  # underflow: no table
                return None
            worst = float((left_out / size).max())
            if worst <= _ROUNDING or (worst <= tolerance and worst > 0.3 * before):
                return cls.from_series(series, end, power, limit, rate)
            before = worst
        return None

    @classmethod
    def from_series(
        cls, series: Floats, end: float, power: int, limit: float, rate: float = 0.0
    ) -> PolynomialTable:
        """Create a table from Chebyshev series of S: one row per panel, at least TERMS columns."""
        powers = np.ascontiguousarray(series[:, : kernels.TERMS] @ TO_POWERS)
        return cls(lock(powers), len(series) / end, power, limit, rate)

    @cached_property
    def arguments(self) -> tuple[Any, ...]:
        """Fields of the table in the order in which the kernels take them."""
        return self.coefficients, self.inverse_width, self.power, self.limit, self.rate

    def value(self, u: Floats) -> Floats:
        """Return the tabulated function at ``u``, an array of any shape."""
        flat = np.ascontiguousarray(u, dtype=float).reshape(-1)
        out = np.empty_like(flat)
        with np.errstate(over="ignore"):  # overflow is past the end
            kernels.compiled.evaluate(flat, out, None, *self.arguments)
        return out.reshape(np.shape(u))

    def value_and_slope(self, u: Floats) -> tuple[Floats, Floats]:
        """Return the function and its derivative at ``u``, any shape."""
        flat = np.ascontiguousarray(u, dtype=float).reshape(-1)
        out, slope = np.empty_like(flat), np.empty_like(flat)
        kernels.compiled.evaluate(flat, out, slope, *self.arguments)
        return out.reshape(np.shape(u)), slope.reshape(np.shape(u))

    def at(self, u: float) -> tuple[float, float]:
        """Return the function and its derivative at a single ``u``."""
        pair: tuple[float, float] = kernels.compiled.evaluate_one(u, *self.arguments)
        return pair
