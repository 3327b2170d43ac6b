"""Differences of laws with many kinks, such as heights by a long table have.

The sums are those of :mod:`microslip.numerics.quadrature`. One rule over many kinks is not exact,
and a piece for each is slow. So a step takes the difference itself as soon as that keeps enough
digits; only shorter steps, which meet few kinks, are integrated piece by piece.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from microslip._core.checks import Floats
from microslip.numerics import quadrature

# Steps in decay lengths from which on the difference serves. What it loses there is rounding over
# the step for the drop, and rounding over its square for the other two.
_DROP = 0.01
_EXCESS = 0.1
_EXCESS_SLOPE = 0.03


class _Kinked(Protocol):
    """A normal law that tells where its second derivative jumps within a few decay lengths."""

    @property
    def _edge(self) -> float: ...

    @property
    def _breaks(self) -> Floats: ...

    @property
    def _small_kinks(self) -> Floats: ...

    def _derivative(self, separation: Floats, order: int) -> Floats: ...

    def _derivative_at(self, separation: float, order: int) -> float: ...


class _Pieces:
    """A law whose kinks are told, as the quadrature asks for them."""

    _edge = -np.inf

    def __init__(self, law: _Kinked) -> None:
        self._breaks = law._small_kinks
        self._derivative = law._derivative
        self._derivative_at = law._derivative_at


def drop(law: _Kinked, d: Floats | float, u: Floats) -> Floats:
    """N(d) - N(d + u)."""
    here, length = quadrature._decay(law, d)
    result: Floats = here - law._derivative(d + u, 0)
    small = u < _DROP * length
    if small.any():
        result[small] = quadrature.drop(_Pieces(law), _of(d, small), u[small])
    return result


def excess(law: _Kinked, d: Floats | float, u: Floats) -> Floats:
    """Half the integral of v (u - v) N''(d + v) over [0, u]."""
    here, length = quadrature._decay(law, d)
    end = d + u
    area = quadrature._at(law, d, -1) - law._derivative(end, -1)
    result: Floats = 0.5 * u * (here + law._derivative(end, 0)) - area
    small = u < _EXCESS * length
    if small.any():
        result[small] = quadrature.excess(_Pieces(law), _of(d, small), u[small])
    return result


def excess_slope(law: _Kinked, d: Floats | float, u: Floats) -> Floats:
    """Half the integral of v N''(d + v) over [0, u]."""
    here, length = quadrature._decay(law, d)
    end = d + u
    result: Floats = 0.5 * (here - law._derivative(end, 0) + u * law._derivative(end, 1))
    small = u < _EXCESS_SLOPE * length
    if small.any():
        result[small] = quadrature.excess_slope(_Pieces(law), _of(d, small), u[small])
    return result


def _of(d: Floats | float, small: np.ndarray) -> Floats | float:
    return d[small] if isinstance(d, np.ndarray) else d
