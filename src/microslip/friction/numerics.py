"""Numerics that a backbone law without formulas of its own falls back on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from microslip._checks import Floats

# Gauss-Lobatto: with the ends among its nodes a rule sees a kink close to one of them.
_BASIS = np.polynomial.legendre.Legendre.basis(11)
_NODES = np.concatenate(([-1.0], np.sort(_BASIS.deriv().roots().real), [1.0]))
_WEIGHTS = 1.0 / (132.0 * _BASIS(_NODES) ** 2)
_NODES = 0.5 * (1.0 + _NODES)


def lobatto(function: Callable[[Floats], Floats], low: Floats, high: Floats) -> Floats:
    """Integral of a function over each of many intervals."""
    width = high - low
    places = low[:, None] + width[:, None] * _NODES
    return np.asarray(width * (function(places.ravel()).reshape(places.shape) @ _WEIGHTS))


def invert(
    value_and_slope: Callable[[Floats], tuple[Floats, Floats]],
    target: Floats,
    low: Floats,
    high: Floats,
) -> Floats:
    """Newton's method on a rising function, kept in brackets, for all targets at once."""
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
