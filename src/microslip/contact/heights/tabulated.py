"""Summit heights with a tabulated density."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, record, sized
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip._core.parameters import parameter
from microslip._core.quadrature import gauss_legendre
from microslip.contact.heights.base import HeightDistribution
from microslip.contact.heights.piecewise_density import (
    Panels,
    direct,
    far_series,
    panels_of,
    piece_moment,
    piece_moment_at,
)

_FEW_KNOTS = 16  # knots up to which places where moments are not smooth are listed
_BLOCK = 1 << 15  # values a pass

_MOST_PANELS = 5000
"""Largest number of panels of a table; each takes about 0.5 ms at the first evaluation."""


@dataclass(frozen=True, eq=False)
class TabulatedHeights(Locked, HeightDistribution):
    """Summit heights with a tabulated density: linear between its points, zero outside.

    Parameters
    ----------
    height : array_like
        Heights [m] in non-decreasing order, at least two different ones. The density jumps at a
        repeated height.
    density : array_like
        Density at the heights, not below zero, in any unit: it is normalised by its integral,
        :attr:`integral`, to [1/m], and takes the place of the Gaussian density (19.25).

    Notes
    -----
    As a function of the square root of y - t, with the threshold t, (y - t)^n times a linear
    density is a polynomial, which Gauss-Legendre quadrature with 2 to 5 nodes integrates exactly,
    with positive terms only. For orders 0, 1 and 2 the pieces above the threshold contribute
    polynomials in the threshold, whose coefficients are summed once. For half-integer orders the
    moments are Chebyshev series on each piece, with errors of 1e-13, so that the time of a value
    grows with the logarithm of the length of the table.

    For the series, a piece more than twice as wide as the next is divided into panels, one for each
    factor of two. The time of the first evaluation grows with the number of panels, at most 5000.
    This suffices for thousands of heights with equal spacing, but only for hundreds if neighbouring
    spacings differ by many powers of ten.
    """

    height: ArrayLike = field(metadata=parameter("y", "m", "heights, rising", many=True))
    density: ArrayLike = field(
        metadata=parameter("p", "1/m", "density at these", least=0.0, many=True)
    )
    integral: float = field(init=False, default=1.0)
    """Integral of the given density [-], by which it was normalised."""
    _support: tuple[int, int] = field(init=False, default=(0, 0), repr=False)
    _panels: Panels = field(init=False, repr=False)

    def __post_init__(self) -> None:
        height = sized("height", record("height", self.height, "m")).reshape(-1)
        density = record("density", self.density).reshape(-1)
        if height.size != density.size:
            raise InputError(
                f"`density` must have one value for each of the {height.size} heights, got "
                f"{density.size}"
            )
        steps = np.diff(height)
        if steps.size == 0 or steps.min() < 0.0 or not steps.max() > 0.0:
            raise InputError(
                "`height` must be at least two heights [m] in increasing order, got "
                + (
                    f"{height.size} of which {int(np.count_nonzero(steps < 0.0))} fall"
                    if steps.size and steps.min() < 0.0
                    else f"{np.unique(height).size}"
                )
            )
        if density.min() < 0.0:
            raise InputError(f"`density` must not be below zero [1/m], got {density.min():g}")
        with np.errstate(all="ignore"):
            integral = float((steps * (0.5 * density[1:] + 0.5 * density[:-1])).sum())
        if not (math.isfinite(integral) and integral > 0.0):
            raise InputError(f"`density` must have an integral above zero, got {integral:g}")
        with np.errstate(over="ignore"):
            density = density / integral
        if not np.isfinite(density).all():
            raise InputError("`density` must vary over lengths that double precision resolves [m]")
        # Zero at either end is no part of the distribution.
        pieces = np.flatnonzero((steps > 0.0) & (density[1:] + density[:-1] > 0.0))
        first, last = int(pieces[0]), int(pieces[-1]) + 1
        assign(self, height=lock(height.copy()), density=lock(density), integral=integral)
        assign(self, edge=float(height[first]), _support=(first, last))
        panels = panels_of(*self._pieces, _MOST_PANELS)
        if panels is None:
            steps = steps[steps > 0.0]
            raise InputError(
                f"a table must need at most {_MOST_PANELS} panels, got {height.size} heights with "
                f"steps from {steps.min():.3g} m to {steps.max():.3g} m, which need more: each "
                "step is divided until it is at most twice the next. Give the density at fewer "
                "heights or in equal steps, such as new = np.linspace(height[0], height[-1], "
                "1000) and np.interp(new, height, density)"
            )
        assign(self, _panels=panels)

    def __repr__(self) -> str:
        low, high = self.span
        return f"TabulatedHeights({np.size(self.height)} points from {low:g} to {high:g})"

    @cached_property
    def _pieces(self) -> tuple[Floats, Floats, Floats]:
        """Knots [m], and the density [1/m] at the left and right end of each piece."""
        first, last = self._support
        knots = np.asarray(self.height)[first : last + 1]
        density = np.asarray(self.density)[first : last + 1]
        real = np.flatnonzero(np.diff(knots) > 0.0)
        return np.append(knots[real], knots[-1]), density[real], density[real + 1]

    @cached_property
    def _moments_about_knots(self) -> tuple[Floats, Floats, Floats]:
        """Moments of orders 0, 1 and 2 about each knot of the panels, of the density above it."""
        knots, left, right = self._panels
        width = np.diff(knots)
        zero = 0.5 * width * (left + right)
        first_moment = width**2 * (left + 2.0 * right) / 6.0
        two = width**3 * (left + 3.0 * right) / 12.0
        f0 = _above(zero)
        f1 = _above(first_moment + width * f0[1:])
        f2 = _above(two + width * (2.0 * f1[1:] + width * f0[1:]))
        return f0, f1, f2

    @cached_property
    def _far(self) -> dict[int, Floats]:
        return far_series(self._panels)

    @cached_property
    def mean(self) -> float:
        """Mean height [m]."""
        knots, left, right = self._pieces
        width, first = np.diff(knots), knots[:-1] - knots[0]
        terms = width * (first * (left + right) / 2.0 + width * (left + 2.0 * right) / 6.0)
        return float(knots[0] + terms.sum())

    @cached_property
    def spread(self) -> float:
        """Standard deviation of the heights [m]."""
        knots, left, right = self._pieces
        width = np.diff(knots)[:, None]
        nodes, weights = gauss_legendre(2)  # exact: a square times a straight line
        y = knots[:-1, None] + width * nodes - self.mean
        density = left[:, None] + (right - left)[:, None] * nodes
        return math.sqrt(float((y * y * density * width).sum(axis=0) @ weights))

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest height [m] of the range in which the density is not zero."""
        knots = self._pieces[0]
        return float(knots[0]), float(knots[-1])

    @property
    def top(self) -> float:
        """Upper end [m] of the range in which the density is not zero."""
        return self.span[1]

    @cached_property
    def _breaks(self) -> Floats:
        """Knots [m], and points ever closer to each from below; empty for more than 16 knots."""
        knots = self._pieces[0]
        if knots.size > _FEW_KNOTS:
            return np.zeros(0)
        width = np.append(knots[1] - knots[0], np.diff(knots))
        near = knots[:, None] - width[:, None] * 0.25 ** np.arange(1.0, 10.0)
        far = knots[0] - width[0] * 4.0 ** np.arange(0.0, 6.0)
        return np.unique(np.concatenate([knots, near.reshape(-1), far]))

    @cached_property
    def _small_kinks(self) -> Floats:
        """Knots [m] and points as in :attr:`_breaks`, for more than 16 knots; else empty."""
        knots, left, right = self._pieces
        if knots.size <= _FEW_KNOTS:
            return np.zeros(0)
        jump = np.append(left, 0.0) != np.append(0.0, right)
        width = np.append(knots[1] - knots[0], np.diff(knots))
        near = knots[:, None] - width[:, None] * 0.25 ** np.arange(1.0, 4.0)
        below = knots[jump, None] - width[jump, None] * 4.0 ** np.arange(-9.0, 6.0)
        return np.unique(np.concatenate([knots, near.reshape(-1), below.reshape(-1)]))

    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        flat = np.ascontiguousarray(threshold, dtype=float).reshape(-1)
        result = np.zeros(flat.size)
        for start in range(0, flat.size, _BLOCK):
            part = slice(start, start + _BLOCK)
            result[part] = self._moments(twice_order, flat[part])
        return result.reshape(np.shape(threshold))

    def _moments(self, twice: int, t: Floats) -> Floats:
        knots, left, right = self._panels
        result = np.zeros(t.size)
        inside = np.flatnonzero((t >= knots[0]) & (t < knots[-1]))
        below = np.flatnonzero(t < knots[0])
        if below.size:
            if twice % 2:
                start = np.zeros(below.size, dtype=np.intp)
                result[below] = direct(self._panels, twice, t[below], start)
            else:
                result[below] = self._moment_above(twice, np.zeros_like(below), knots[0] - t[below])
        if not inside.size:
            return result
        t = t[inside]
        panel = np.searchsorted(knots, t, side="right") - 1
        a, b = knots[panel], knots[panel + 1]
        width = b - a
        # Of positive terms, so that next to an end where the density is zero it keeps its digits.
        here = left[panel] * ((b - t) / width) + right[panel] * ((t - a) / width)
        total = piece_moment(twice, np.zeros_like(t), b - t, b - t, here, right[panel])
        if twice % 2 == 0:
            result[inside] = total + self._moment_above(twice, panel + 1, b - t)
            return result
        after = np.minimum(panel + 1, left.size - 1)
        end = knots[after + 1]
        next_one = piece_moment(twice, b - t, end - t, end - b, left[after], right[after])
        total += np.where(panel + 1 < left.size, next_one, 0.0)
        series = self._far[twice]
        x = 2.0 * ((t - a) / width) - 1.0
        # Clenshaw's recurrence, with a series of its own for each value.
        high = low = np.zeros_like(x)
        for k in range(series.shape[1] - 1, 0, -1):
            high, low = series[panel, k] + 2.0 * x * high - low, high
        total += np.maximum(series[panel, 0] + x * high - low, 0.0)
        result[inside] = total
        return result

    def _moment_at(self, twice_order: int, threshold: float) -> float:
        knots, left, right = self._lists
        panel = bisect_right(knots, threshold) - 1
        if panel < 0 or panel + 1 >= len(knots) or twice_order % 2 == 0:
            return super()._moment_at(twice_order, threshold)
        a, b = knots[panel], knots[panel + 1]
        ahead, share = b - threshold, (threshold - a) / (b - a)
        here = left[panel] * (ahead / (b - a)) + right[panel] * share
        total = piece_moment_at(twice_order, 0.0, ahead, ahead, here, right[panel])
        if panel + 1 < len(left):
            end, beyond = knots[panel + 2], panel + 1
            total += piece_moment_at(
                twice_order, ahead, end - threshold, end - b, left[beyond], right[beyond]
            )
        series: list[float] = self._far[twice_order][panel].tolist()
        x = 2.0 * share - 1.0
        high = low = 0.0
        for term in series[:0:-1]:
            high, low = term + 2.0 * x * high - low, high
        return total + max(series[0] + x * high - low, 0.0)

    @cached_property
    def _lists(self) -> tuple[list[float], list[float], list[float]]:
        knots, left, right = self._panels
        return knots.tolist(), left.tolist(), right.tolist()

    def _moment_above(self, twice: int, knot: NDArray[np.intp], distance: Floats) -> Floats:
        """Return moments of order twice/2 above knots, about points ``distance`` [m] below them."""
        f0, f1, f2 = (f[knot] for f in self._moments_about_knots)
        if twice == 0:
            return f0
        if twice == 2:
            return np.asarray(f1 + distance * f0)
        return np.asarray(f2 + distance * (2.0 * f1 + distance * f0))

    def _density(self, height: Floats) -> Floats:
        knots, left, right = self._pieces
        panel = np.clip(np.searchsorted(knots, height, side="right") - 1, 0, left.size - 1)
        low, high = knots[panel], knots[panel + 1]
        value = left[panel] * ((high - height) / (high - low))
        value += right[panel] * ((height - low) / (high - low))
        return np.where((height >= knots[0]) & (height <= knots[-1]), value, 0.0)

    def _below(self, height: Floats) -> Floats:
        # Summed from below: the difference to one has no digits in the lower tail.
        knots, left, right = self._pieces
        width = np.diff(knots)
        sums = np.append(0.0, np.cumsum(0.5 * width * (left + right)))
        y = np.clip(height, knots[0], knots[-1])
        panel = np.clip(np.searchsorted(knots, y, side="right") - 1, 0, left.size - 1)
        step = y - knots[panel]
        share = step / width[panel]
        here = left[panel] * (1.0 - share) + right[panel] * share
        return np.asarray(sums[panel] + 0.5 * step * (left[panel] + here))

    @classmethod
    def examples(cls) -> tuple[HeightDistribution, ...]:
        """Return a ramp, a trapezoid with a jump at both ends, and a roof of three pieces."""
        return (
            cls([-4e-7, 8e-7], [0.0, 2.0]),
            cls([-1e-6, 1e-6], [3.0, 1.0]),
            cls([-1e-6, -2e-7, 1e-7, 9e-7], [0.0, 3.0, 2.5, 0.0]),
        )


def _above(terms: Floats) -> Floats:
    return np.append(np.cumsum(terms[::-1])[::-1], 0.0)
