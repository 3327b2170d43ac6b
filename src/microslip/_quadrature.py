"""Differences that must not cancel, as integrals with a positive integrand.

Let f be decreasing and convex with derivatives f', f'' and tail integral M(t) (from t to
infinity). Wanted for steps u >= 0 from a given t, small steps included:

    drop(u)    = f(t) - f(t + u)                             = integral of -f'(t + v)
    excess(u)  = (u/2) (f(t) + f(t + u)) - (M(t) - M(t + u)) = 1/2 integral of v (u - v) f''(t + v)
    excess'(u) = (f(t) - f(t + u) + u f'(t + u)) / 2         = 1/2 integral of v f''(t + v)

over 0 <= v <= u: the fall of f, and by how much the trapezoidal rule overestimates its integral.

The left sides lose all digits for small u, the right sides none. Up to a fraction of the decay
length f/|f'| Gauss-Legendre quadrature of the right side is exact to rounding; beyond it the left
side is good.

Where f'' is singular like (edge - t)^(-1/2) below an edge (the lower end of a bounded height
distribution), the part below it is integrated in the root of the distance. Where f has other
breaks, the integral is taken piece by piece between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Protocol

import numpy as np

from microslip._checks import Floats

Function = Callable[[Floats, Floats], Floats]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)
_NODES = 0.5 * (1.0 + _NODES)  # on [0, 1]
_WEIGHTS = 0.5 * _WEIGHTS


def _integral(g: Function, u: Floats, t: float, f: Convex) -> Floats:
    """Integral of g(v, u) over v in [0, u], one row of nodes for each of the ``u``."""
    breaks = f._breaks
    if breaks.size:
        first, last = np.searchsorted(breaks, (t, t + u.max()), side="right")
        inner = breaks[first:last] - t
        if inner.size:
            return _piecewise(g, u, np.concatenate(([0.0], inner, [np.inf])))
        edge = -math.inf
    else:
        edge = f._edge
    below = edge - t if math.isfinite(edge) and edge > t else 0.0
    left = np.minimum(u, below)
    right = u - left
    total = np.zeros_like(u)
    if below > 0.0:
        near = math.sqrt(below)
        reach = left / (near + np.sqrt(below - left))  # difference of the roots, not cancelling
        step = reach[:, None] * _NODES
        v = step * (2.0 * near - step)
        total = (2.0 * (near - step) * reach[:, None] * g(v, u[:, None])) @ _WEIGHTS
    if np.any(right > 0.0):
        v = left[:, None] + right[:, None] * _NODES
        total = total + right * (g(v, u[:, None]) @ _WEIGHTS)
    return total


def _piecewise(g: Function, u: Floats, marks: Floats) -> Floats:
    """The same between marks 0 = v_0 < v_1 ... , each piece for the steps that reach into it."""
    total = np.zeros_like(u)
    for low, high in pairwise(marks):
        at = np.flatnonzero(u > low)
        step = u[at]
        width = np.minimum(step, high) - low
        v = low + width[:, None] * _NODES
        total[at] += width * (g(v, step[:, None]) @ _WEIGHTS)
    return total


class Convex(Protocol):
    """A decreasing convex function: derivatives of order -1 (tail integral), 0, 1 and 2."""

    @property
    def _edge(self) -> float: ...

    @property
    def _breaks(self) -> Floats: ...

    def _derivative(self, separation: Floats, order: int) -> Floats: ...

    def _derivative_at(self, separation: float, order: int) -> float: ...


def drop(f: Convex, t: float, u: Floats) -> Floats:
    """f(t) - f(t + u) for steps ``u`` (one-dimensional), to a few units in the last place."""
    here, length = _decay(f, t)
    result = here - f._derivative(t + u, 0)
    small = u < 0.5 * length
    if small.any():
        result[small] = _integral(lambda v, u: -f._derivative(t + v, 1), u[small], t, f)
    return result


def excess(f: Convex, t: float, u: Floats) -> Floats:
    """Half the integral of v (u - v) f''(t + v) over [0, u], for steps ``u``."""
    here, length = _decay(f, t)
    whole = f._derivative_at(t, -1) - f._derivative(t + u, -1)
    result = 0.5 * u * (here + f._derivative(t + u, 0)) - whole
    small = u < length
    if small.any():
        result[small] = 0.5 * _integral(
            lambda v, u: v * (u - v) * f._derivative(t + v, 2), u[small], t, f
        )
    return result


def excess_slope(f: Convex, t: float, u: Floats) -> Floats:
    """Half the integral of v f''(t + v) over [0, u], for steps ``u``."""
    here, length = _decay(f, t)
    result = 0.5 * (here - f._derivative(t + u, 0) + u * f._derivative(t + u, 1))
    small = u < length
    if small.any():
        result[small] = 0.5 * _integral(lambda v, u: v * f._derivative(t + v, 2), u[small], t, f)
    return result


def _decay(f: Convex, t: float) -> tuple[float, float]:
    """f(t) and the length f/|f'| on which it decays there."""
    here = f._derivative_at(t, 0)
    return here, here / -f._derivative_at(t, 1)
