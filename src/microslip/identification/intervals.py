"""Floor 6: the profiles of all coordinates of a fit."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from microslip._checks import Floats
from microslip.identification.fit import Fit, minimise
from microslip.identification.minos import minos
from microslip.identification.problem import Problem
from microslip.identification.profiles import (
    Interval,
    covariance_of,
    cycle_ratio,
    information,
    profile,
)

Progress = Callable[[float], None]

_SIGNIFICANT = 1e-3
_RESTARTS = 3


class Profiled:
    """A fit with the profiles of its coordinates."""

    def __init__(self, best: Fit, intervals: list[Interval], widen: Floats, cov: Floats) -> None:
        self.best, self.intervals, self.widen, self.covariance = best, intervals, widen, cov


def profiled(
    problem: Problem,
    best: Fit,
    level: float,
    freedom: int,
    report: Progress,
    by_minos: bool,
) -> Profiled:
    """Intervals of all free coordinates; from a better minimum, should a profile find one."""
    from scipy.special import chdtrc, chdtri

    threshold = float(chdtri(1, 1.0 - level))
    size = best.q.size
    for attempt in range(_RESTARTS):
        if not best.finite:
            nothing = Interval(-math.inf, math.inf, True, True, best.q, best.q)
            return Profiled(best, [nothing] * size, np.ones(size), np.eye(size))
        covariance = covariance_of(information(problem, best.q))
        reduced = best.cost / freedom
        excess = reduced if chdtrc(freedom, best.cost) < _SIGNIFICANT else 1.0
        widen = np.maximum(cycle_ratio(problem, best.q), max(excess, 1.0))
        intervals = []
        better: Fit | None = None
        for i in range(size):
            last = attempt == _RESTARTS - 1
            rise = threshold * float(widen[i])
            other = minos(problem, best, i, rise, covariance) if by_minos else None
            interval, lower = (
                profile(problem, best, i, rise, covariance) if other is None else (other, None)
            )
            report((i + 1) / size)
            intervals.append(interval)
            if lower is not None and not last:
                better = lower
                break
        if better is None:
            break
        problem.update(better.q)
        best = minimise(problem, better.q)
    return Profiled(best, intervals, widen, covariance)
