"""Smooth load curves N(d) as piecewise polynomials, with derivatives, differences and inverse."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock
from microslip._core.kernels import QUADRATURE_RULES
from microslip._core.kernels.table import NODES, TO_POWERS, TO_SERIES
from microslip._core.quadrature import gauss_legendre

Derivative = Callable[[Floats, int], Floats]
"""Derivatives of N with respect to the separation, of order 0, 1 and 2."""

_ROUNDING = 2e-15  # truncation error over N'' on a panel
_TOLERANCE = 1e-13  # the same once it stops falling, at the rounding error of the law
_WIDTHS = (2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.18)  # of panels, in decay lengths
_MAX_PANELS = 4096
_KINKED_PANELS = (512, 1024, 2048, 4096)  # panels of a law with many small kinks
_KINKED_TOLERANCE = 3e-12  # error of N over N at rest
_INVERSE_TOLERANCE = 1e-9  # error of the inverse before a Newton step, in decay lengths
_LOSS_RULES = np.concatenate(
    [np.concatenate(gauss_legendre(count)) for _, count in QUADRATURE_RULES]
)


class _Grid(NamedTuple):
    """Panels of equal width; panel number ``first`` begins at the separation ``anchor``."""

    anchor: float
    width: float
    first: int
    middles: Floats

    @classmethod
    def of(
        cls, low: float, end: float, width: float, edge: float, panels: int | None = None
    ) -> _Grid:
        """Return panels of equal ``width`` from ``low`` to ``end``, or ``panels`` of them.

        The load curve is smooth only above ``edge`` <= low, so no panel extends below it.
        """
        # A panel begins at 0 or at the edge, so that nearby places keep their digits.
        anchor = 0.0 if low - width >= edge else edge
        first = -math.floor((low - anchor) / width)
        count = panels or first + math.ceil((end - anchor) / width)
        middles = np.asarray(anchor + width * (np.arange(count) - first + 0.5), dtype=np.float64)
        return cls(anchor, width, first, middles)

    def series(self, derivative: Derivative, bend: float) -> tuple[Floats, float]:
        """Return the Chebyshev series of N'' on each panel, and their largest truncation error.

        ``derivative(d, order)`` returns N, N' or N''. The error [-] is relative to the leading
        coefficient of the panel or, if larger, to ``bend``, a reference value of N'' [N/m^2].
        """
        x = self.middles[:, None] + 0.5 * self.width * NODES
        series = np.asarray(
            derivative(x.reshape(-1), 2).reshape(x.shape) @ TO_SERIES, dtype=np.float64
        )
        left_out = np.abs(series[:, kernels.TERMS - 1 :]).max(axis=1)
        return series, float((left_out / np.maximum(np.abs(series[:, 0]), bend)).max())


@dataclass(frozen=True, eq=False)
class Profile(Locked):
    """Decreasing convex load curve N(d), accurate to rounding on [low, high].

    N'' is sampled and integrated, so that N'', N' and N are accurate relative to their values.
    Beyond ``high`` the error of N'' is small only relative to N''(high), and those of N' and N
    accordingly.
    """

    coefficients: Floats  # (panels, PROFILE_TERMS)
    anchor: float
    inverse_width: float
    first: int
    low: float
    high: float

    @classmethod
    def sample(
        cls, derivative: Derivative, low: float, high: float, end: float, edge: float
    ) -> Profile | None:
        """Sample N(d) on panels from ``low`` to ``end``; None if they do not resolve N''.

        ``derivative(d, order)`` returns N, N' or N'' at separations. N is accurate relative to its
        value up to ``high`` and vanishes from ``end`` on. Below ``edge`` <= low the function is not
        smooth.
        """
        load, slope, bend = (float(derivative(np.array([high]), k)[0]) for k in range(3))
        if not (load > 0.0 and slope < 0.0 and bend > 0.0):
            return None
        length = load / -slope
        before = math.inf
        for share in _WIDTHS:
            width = share * length
            count = (end - low) / width
            if not count < _MAX_PANELS:
                return None
            grid = _Grid.of(low, end, width, edge)
            with np.errstate(all="ignore"):
                series, worst = grid.series(derivative, bend)
            if worst <= _ROUNDING or (worst <= _TOLERANCE and worst > 0.3 * before):
                return cls._integrated(derivative, series, grid, low, high)
            before = worst
        return None

    @classmethod
    def sample_kinked(
        cls, derivative: Derivative, low: float, end: float, edge: float
    ) -> Profile | None:
        """Sample N(d) with many small kinks in N'', as from a tabulated density of heights.

        Panels as narrow as the spacing of the kinks keep the error of N below 3e-12 of N(0) and
        that of N' at about 1e-10 of N'(0). As N is integrated twice from N'', a relative error e of
        N'' causes an error of N of about e (w/l)^2, with the panel width w and the decay length l =
        N/|N'| at d = 0.
        """
        load, slope, bend = (float(derivative(np.zeros(1), k)[0]) for k in range(3))
        if not (load > 0.0 and slope < 0.0 and bend > 0.0):
            return None
        length = load / -slope
        for panels in _KINKED_PANELS:
            width = (end - low) / (panels - 2)
            grid = _Grid.of(low, end, width, edge, panels)
            series, worst = grid.series(derivative, bend)
            if worst * (width / length) ** 2 <= _KINKED_TOLERANCE:
                return cls._integrated(derivative, series, grid, low, end)
        return None

    @classmethod
    def _integrated(
        cls, derivative: Derivative, series: Floats, grid: _Grid, low: float, high: float
    ) -> Profile:
        half, middle = 0.5 * grid.width, grid.middles
        powers = series[:, : kernels.TERMS] @ TO_POWERS
        k = np.arange(kernels.TERMS)
        coefficients = np.empty((len(middle), kernels.PROFILE_TERMS))
        coefficients[:, 0] = derivative(middle, 0)
        coefficients[:, 1] = half * derivative(middle, 1)
        coefficients[:, 2:] = half * half * powers / ((k + 1) * (k + 2))
        return cls(lock(coefficients), grid.anchor, 1.0 / grid.width, grid.first, low, high)

    @cached_property
    def arguments(self) -> tuple[Any, ...]:
        """Arguments of the kernels: coefficients and positions of the polynomial pieces."""
        return self.coefficients, self.anchor, self.inverse_width, self.first

    @cached_property
    def loss_rules(self) -> Floats:
        """Quadrature rules and integrals of N, an argument of the kernels that compute slip losses.

        Slip losses are the friction work under varying load. The array holds the nodes and weights
        of :data:`microslip._core.kernels.QUADRATURE_RULES`, then for each panel the integral of N
        [N m] from the middle of the panel to infinity.
        """
        odd = self.coefficients * (-1.0) ** np.arange(kernels.PROFILE_TERMS)
        left, right = (
            0.5 / self.inverse_width * (c / np.arange(1.0, kernels.PROFILE_TERMS + 1.0)).sum(axis=1)
            for c in (odd, self.coefficients)
        )
        after = np.cumsum((left + right)[::-1])[::-1] - left
        return lock(np.concatenate((_LOSS_RULES, after)))

    def load(self, separation: Floats) -> Floats:
        """Return the loads N [N] at separations [m], one-dimensional."""
        value = np.empty(separation.size)
        kernels.compiled.loads(separation, value, None, *self.arguments)
        return value

    @cached_property
    def span(self) -> tuple[float, float]:
        """Smallest and largest load [N] for which :meth:`separations` is defined."""
        lightest, heaviest = self.load(np.array([self.high, self.low])).tolist()
        return (lightest, heaviest) if self._inverse is not None else (math.inf, 0.0)

    @cached_property
    def _inverse(self) -> tuple[Any, ...] | None:
        """Series of the separation as a function of ln N, None if N does not decrease strictly."""
        grid = np.linspace(self.low, self.high, 8 * len(self.coefficients) + 1)
        heights = np.log(self.load(grid))
        start, reach = heights[-1], float(heights[0] - heights[-1])
        if not reach > 0.0 or not np.all(np.diff(heights) < 0.0):
            return None
        for panels in (16, 32, 64, 128, 256, 512):
            x = reach / panels * (np.arange(panels)[:, None] + 0.5 * (1.0 + NODES))
            flat = x.reshape(-1)
            d = np.interp(flat, heights[::-1] - start, grid[::-1])
            value, fall = np.empty(d.size), np.empty(d.size)
            for _ in range(4):
                kernels.compiled.loads(d, value, fall, *self.arguments)
                d = np.clip(d + (np.log(value) - start - flat) * value / fall, self.low, self.high)
            series = d.reshape(x.shape) @ TO_SERIES
            length = (value / fall).reshape(x.shape).min(axis=1)
            left_out = np.abs(series[:, kernels.TERMS - 1 :]).max(axis=1)
            if np.all(left_out <= _INVERSE_TOLERANCE * length):
                powers = np.ascontiguousarray(series[:, : kernels.TERMS] @ TO_POWERS)
                return lock(powers), panels / reach, float(start)
        return None

    def separations(self, load: Floats) -> Floats:
        """Return the separations [m] of loads [N] within :attr:`span`, one-dimensional."""
        result = np.empty(load.size)
        kernels.compiled.separations(load, result, *self.arguments, *(self._inverse or ()))
        return result
