"""Differences without cancellation, as integrals with a positive integrand.

Let f be decreasing and convex with derivatives f', f'' and tail integral M(t), that of f from t to
infinity. Three functions are needed for steps u >= 0 from a given t, including very small steps:

    drop(u)    = f(t) - f(t + u)                             = integral of -f'(t + v)
    excess(u)  = (u/2) (f(t) + f(t + u)) - (M(t) - M(t + u)) = 1/2 integral of v (u - v) f''(t + v)
    excess'(u) = (f(t) - f(t + u) + u f'(t + u)) / 2         = 1/2 integral of v f''(t + v)

with integrals over 0 <= v <= u: the decrease of f, the error of the trapezoidal rule for the
integral of f, and the derivative of this error.

The expressions on the left lose all digits for small u, the integrals none. For u up to a fraction
of the decay length f/|f'| Gauss-Legendre quadrature is exact to rounding; for larger u the
expressions on the left are accurate.

If f'' is singular like (edge - t)^(-1/2) below an edge (the lower end of a bounded height
distribution), the part below the edge is integrated over the square root of the distance to it. For
other breaks of f the integral is split at the breaks.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import lock

Integrand = Callable[[Floats, Floats, Floats | float], Floats]


@lru_cache
def gauss_legendre(count: int) -> tuple[Floats, Floats]:
    """Return nodes and weights on [0, 1], exact for polynomials of degree 2 count - 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return lock(0.5 * (1.0 + nodes)), lock(0.5 * weights)


_NODES, _WEIGHTS = gauss_legendre(20)
_BLOCK = 1 << 14  # rows of nodes per block, sized for the cache


def _integral(g: Integrand, u: Floats, t: Floats | float, f: Convex) -> Floats:
    """Integrate g(v, u, t) over v from 0 to each ``u``, split where f(t + v) has kinks."""
    if isinstance(t, np.ndarray):
        return _integrals(g, u, t, f)
    breaks = f._breaks
    if breaks.size:
        first, last = np.searchsorted(breaks, (t, t + u.max()), side="right")
        inner = breaks[first:last] - t
        if inner.size:
            return _piecewise(g, u, t, np.concatenate(([0.0], inner, [np.inf])))
        return _smooth(g, u, t, -math.inf)
    return _smooth(g, u, t, f._edge)


def _integrals(g: Integrand, u: Floats, t: Floats, f: Convex) -> Floats:
    total = np.zeros_like(u)
    breaks = f._breaks
    first, last = (np.searchsorted(breaks, end, side="right") for end in (t, t + u))
    count = 1 + last - first  # pieces between breaks
    for start in range(0, u.size, _BLOCK):
        rows = slice(start, start + _BLOCK)
        if not breaks.size:
            total[rows] = _smooth(g, u[rows], t[rows], f._edge)
            continue
        owner = np.repeat(np.arange(u.size)[rows], count[rows])
        ends = np.cumsum(count[rows])
        piece = (
            first[owner] - 1 + np.arange(owner.size) - np.repeat(ends - count[rows], count[rows])
        )
        head = np.zeros(owner.size, dtype=bool)
        head[ends - count[rows]] = True
        low = np.where(head, 0.0, breaks[piece] - t[owner])
        tail = np.roll(head, -1)  # the next one is another row's first
        high = np.where(tail, u[owner], np.append(breaks, np.inf)[piece + 1] - t[owner])
        width = high - low
        v = low[:, None] + width[:, None] * _NODES
        part = width * (g(v, u[owner, None], t[owner, None]) @ _WEIGHTS)
        total += np.bincount(owner, part, minlength=u.size)
    return total


def _smooth(g: Integrand, u: Floats, t: Floats | float, edge: float) -> Floats:
    """Integrate g(v, u, t) over v from 0 to each ``u``; f'' may be singular below ``edge``."""
    here = t[:, None] if isinstance(t, np.ndarray) else t
    if not np.any(edge > t):
        v = u[:, None] * _NODES
        return np.asarray(u * (g(v, u[:, None], here) @ _WEIGHTS))
    below = np.maximum(edge - t, 0.0)
    left = np.minimum(u, below)
    right = u - left
    near = np.sqrt(below)
    # Difference of the roots without cancellation.
    reach = np.divide(left, near + np.sqrt(below - left), out=np.zeros_like(u), where=left > 0.0)
    step = reach[:, None] * _NODES
    twice = 2.0 * (near[:, None] if isinstance(near, np.ndarray) else near)
    v = step * (twice - step)
    total = ((twice - 2.0 * step) * reach[:, None] * g(v, u[:, None], here)) @ _WEIGHTS
    if np.any(right > 0.0):
        v = left[:, None] + right[:, None] * _NODES
        total = total + right * (g(v, u[:, None], here) @ _WEIGHTS)
    return np.asarray(total)


def _piecewise(g: Integrand, u: Floats, t: float, marks: Floats) -> Floats:
    """Integrate g from 0 to each ``u``, split at ``marks``, which begin with 0 and end with inf."""
    total = np.zeros_like(u)
    for low, high in pairwise(marks):
        # Steps that cover the whole piece share its nodes.
        beyond = np.flatnonzero(u > high)
        if beyond.size:
            v = (low + (high - low) * _NODES)[None, :]
            total[beyond] += (high - low) * (g(v, u[beyond, None], t) @ _WEIGHTS)
        at = np.flatnonzero((u > low) & (u <= high))
        if at.size:
            step = u[at]
            width = step - low
            v = low + width[:, None] * _NODES
            total[at] += width * (g(v, step[:, None], t) @ _WEIGHTS)
    return total


class Convex(Protocol):
    """Interface of a decreasing convex function f: its derivatives of order -1 (M) to 2."""

    @property
    def _edge(self) -> float: ...

    @property
    def _breaks(self) -> Floats: ...

    def _derivative(self, separation: Floats, order: int) -> Floats: ...

    def _derivative_at(self, separation: float, order: int) -> float: ...


class Kinked:
    """Convex function f with the positions of its ``kinks``, at which integrals are split."""

    _edge = -math.inf

    def __init__(self, f: Convex, kinks: Floats) -> None:
        self._breaks = kinks
        self._derivative = f._derivative
        self._derivative_at = f._derivative_at


# One rule across many kinks is not exact, and splitting at each is slow. With ``pieces`` the plain
# difference is used for all steps for which it keeps enough digits: its error is rounding over the
# step, in decay lengths, for the drop, and over the squared step for the other two functions.


def drop(f: Convex, t: Floats | float, u: Floats, pieces: Kinked | None = None) -> Floats:
    """Return f(t) - f(t + u), accurate to a few units in the last digit.

    The steps ``u`` are one-dimensional; ``t`` is a number or an array of the same size. With
    ``pieces``, integrals are split at its kinks. This also holds for :func:`excess` and
    :func:`excess_slope`.
    """
    here, length = _decay(f, t)
    result = here - f._derivative(t + u, 0)
    small = u < (0.5 if pieces is None else 0.01) * length
    return _replace_small(
        result, small, pieces or f, u, t, lambda v, u, t: -f._derivative(t + v, 1)
    )


def excess(f: Convex, t: Floats | float, u: Floats, pieces: Kinked | None = None) -> Floats:
    """Return half the integral of v (u - v) f''(t + v) over 0 <= v <= u."""
    here, length = _decay(f, t)
    end = t + u
    area = _at(f, t, -1) - f._derivative(end, -1)
    result = 0.5 * u * (here + f._derivative(end, 0)) - area
    small = u < (1.0 if pieces is None else 0.1) * length
    return _replace_small(
        result,
        small,
        pieces or f,
        u,
        t,
        lambda v, u, t: 0.5 * v * (u - v) * f._derivative(t + v, 2),
    )


def excess_slope(f: Convex, t: Floats | float, u: Floats, pieces: Kinked | None = None) -> Floats:
    """Return half the integral of v f''(t + v) over 0 <= v <= u, the derivative of excess."""
    here, length = _decay(f, t)
    end = t + u
    result = 0.5 * (here - f._derivative(end, 0) + u * f._derivative(end, 1))
    small = u < (1.0 if pieces is None else 0.03) * length
    return _replace_small(
        result, small, pieces or f, u, t, lambda v, u, t: 0.5 * v * f._derivative(t + v, 2)
    )


def _replace_small(
    result: Floats, small: Floats, f: Convex, u: Floats, t: Floats | float, g: Integrand
) -> Floats:
    if small.any():
        there = t[small] if isinstance(t, np.ndarray) else t
        result[small] = _integral(g, u[small], there, f)
    return result


def _at(f: Convex, t: Floats | float, order: int) -> Any:
    return f._derivative(t, order) if isinstance(t, np.ndarray) else f._derivative_at(t, order)


def _decay(f: Convex, t: Floats | float) -> tuple[Any, Any]:
    """Return f(t) and the decay length f/|f'|, 0 where f vanishes."""
    here, slope = _at(f, t, 0), _at(f, t, 1)
    if not isinstance(here, np.ndarray):
        return here, here / -slope if slope < 0.0 else 0.0
    return here, np.divide(here, -slope, out=np.zeros_like(here), where=slope < 0.0)
