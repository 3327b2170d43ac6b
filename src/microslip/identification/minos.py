"""Intervals by MINOS of iminuit, a second way to the profiles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.identification.fit import Fit, bounds_of
from microslip.identification.problem import Problem
from microslip.identification.profiles import Interval


def minos(
    problem: Problem, best: Fit, i: int, threshold: float, covariance: Floats
) -> Interval | None:
    """The profile of coordinate ``i`` by MINOS.

    James and Roos (1975, DOI 10.1016/0010-4655(75)90039-9).

    Minuit moves along the valley: its coordinates are the one in question, with what the others do
    on its way, and the others among themselves, all in units of standard errors. None where it
    finds no end within the bounds; there the profiles of this package take over.
    """
    from iminuit import Minuit

    low, high = bounds_of(problem)
    ways = _ways(covariance, i)
    # Beyond a bound the sum of squares goes on as at the bound, and rises.
    unit = np.sqrt(np.diag(covariance))

    def beyond(q: Floats) -> tuple[Floats, Floats]:
        inside = np.clip(q, low, high)
        return inside, (q - inside) / unit

    def value(z: Floats) -> float:
        inside, out = beyond(best.q + ways @ z)
        residual, _ = problem.residuals(inside)
        return float(residual @ residual) - best.cost + float(out @ out)

    def gradient(z: Floats) -> Floats:
        inside, out = beyond(best.q + ways @ z)
        residual, by = problem.residuals(inside)
        slope = 2.0 * (by.T @ residual) * (out == 0.0) + 2.0 * out / unit
        return np.asarray(ways.T @ slope)

    names = [f"z{k}" for k in range(best.q.size)]
    search: Any = Minuit(value, np.zeros(best.q.size), grad=gradient, name=names)
    search.errordef = threshold
    search.strategy = 0
    search.errors = math.sqrt(threshold)
    search.print_level = 0
    search.migrad(iterate=2)
    if not search.valid:
        return None
    try:
        search.minos("z0", ncall=400)
    except RuntimeError:
        return None
    errors = search.merrors["z0"]
    if not errors.is_valid:
        return None
    ends = best.q[i] + ways[i, 0] * (search.values["z0"] + np.array([errors.lower, errors.upper]))
    if ends[0] <= low[i] or ends[1] >= high[i]:
        return None
    places = [best.q + ways[:, 0] * (end - best.q[i]) / ways[i, 0] for end in ends]
    at_low, at_high = (np.clip(place, low, high) for place in places)
    return Interval(float(ends[0]), float(ends[1]), False, False, at_low, at_high)


def _ways(covariance: Floats, i: int) -> Floats:
    """Columns: the way of coordinate ``i`` with the others following, then the others alone."""
    size = covariance.shape[0]
    conditional = np.delete(np.arange(size), i)
    first = covariance[:, i] / math.sqrt(float(covariance[i, i]))
    remainder = covariance - np.outer(first, first)
    unit = np.sqrt(np.maximum(np.diag(remainder)[conditional], 1e-300))
    scaled = remainder[np.ix_(conditional, conditional)] / np.outer(unit, unit)
    values, vectors = np.linalg.eigh(scaled)
    ways = np.zeros((size, size))
    ways[:, 0] = first
    ways[np.ix_(conditional, np.arange(1, size))] = (
        unit[:, None] * vectors * np.sqrt(np.maximum(values, 1e-14))
    )
    return ways
