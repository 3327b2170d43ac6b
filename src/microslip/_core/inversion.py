"""Adaptive integration and inversion of functions, for laws without closed forms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

# Gauss-Lobatto: nodes at both ends detect a kink close to an end.
_BASIS = np.polynomial.legendre.Legendre.basis(11)
_NODES = np.concatenate(([-1.0], np.sort(_BASIS.deriv().roots().real), [1.0]))
_WEIGHTS = 1.0 / (132.0 * _BASIS(_NODES) ** 2)
_NODES = 0.5 * (1.0 + _NODES)


def adaptive(
    function: Callable[[Floats, NDArray[np.int64]], Floats],
    span: Floats,
    tolerance: float,
    halvings: int,
    noise: Callable[[Floats, Floats], Floats] = lambda low, high: np.zeros_like(low),
) -> Floats:
    """Integrate functions i = 0, 1, ... from 0 to ``span[i]``; return one integral per function.

    ``function(x, i)`` returns the value of function ``i[k]`` at each ``x[k]``; functions may have
    kinks. Intervals are graded towards 0 and bisected, at most ``halvings`` times. An interval is
    accepted when bisection changes its integral by less than ``tolerance`` times the integral over
    the whole span plus ``noise(low, high)``, an estimate of the rounding error on the interval
    [low, high].
    """
    edges = np.append(0.0, 0.25 ** np.arange(12.0, -1.0, -1.0))
    low, high = (np.outer(span, side).ravel() for side in (edges[:-1], edges[1:]))
    owner = np.repeat(np.arange(span.size), edges.size - 1)

    def integral(low: Floats, high: Floats) -> Floats:
        places = low[:, None] + (high - low)[:, None] * _NODES
        values = function(places.ravel(), np.repeat(owner, _NODES.size)).reshape(places.shape)
        return np.asarray((high - low) * (values @ _WEIGHTS))

    total = np.zeros_like(span)
    coarse = integral(low, high)
    scale = np.bincount(owner, np.abs(coarse), minlength=span.size)
    for depth in range(halvings):
        middle = 0.5 * (low + high)
        left, right = integral(low, middle), integral(middle, high)
        rough = np.abs(left + right - coarse) > tolerance * scale[owner] + noise(low, high)
        if depth == halvings - 1:
            rough[:] = False
        total += np.bincount(owner[~rough], (left + right)[~rough], minlength=span.size)
        if not rough.any():
            break
        low, middle, high = low[rough], middle[rough], high[rough]
        low, high = np.concatenate((low, middle)), np.concatenate((middle, high))
        coarse = np.concatenate((left[rough], right[rough]))
        owner = np.concatenate((owner[rough], owner[rough]))
    return total


def invert(
    value_and_slope: Callable[[Floats], tuple[Floats, Floats]],
    target: Floats,
    low: Floats,
    high: Floats,
) -> Floats:
    """Solve f(x) = ``target`` for an increasing f on [low, high], to rounding.

    ``value_and_slope(x)`` returns f and f'. Newton's method is used, with bisection where a step
    would leave the bracket; a target outside the values of f gives the nearer end of [low, high].
    """
    low, high = low.copy(), high.copy()
    x = low.copy()
    active = np.arange(target.size)
    for _ in range(200):
        here = x[active]
        value, slope = value_and_slope(here)
        miss = target[active] - value
        low[active] = np.where(miss >= 0.0, here, low[active])
        high[active] = np.where(miss <= 0.0, here, high[active])
        with np.errstate(divide="ignore", invalid="ignore"):
            new = here + miss / slope
        inside = (new >= low[active]) & (new <= high[active])
        new = np.where(inside, new, 0.5 * (low[active] + high[active]))
        x[active] = new
        going = np.abs(new - here) > 4.5e-16 * np.abs(new)
        going &= np.abs(miss) > 2.3e-16 * target[active]
        active = active[going]
        if active.size == 0:
            break
    return x
