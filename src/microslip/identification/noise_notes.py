"""What is said of the noise: loads that widen intervals, and scatter that is no noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import significant
from microslip.identification.fit import Fit
from microslip.identification.problem import Problem
from microslip.identification.profiles import covariance_of

_NOTICED = 1.1  # times as wide
_RARE = 1e-4
_QUIET = 1e-8  # of the range of force: less noise is none


def notes_of(problem: Problem, best: Fit, freedom: int, loss: str = "linear") -> list[str]:
    """What is worth saying of the noise of the loads, and of a misfit too small to be noise."""
    notes: list[str] = []
    if not best.finite:
        return notes
    wider = widened_by_loads(problem, best.q)
    if wider and max(wider.values()) > _NOTICED:
        name = max(wider, key=lambda key: wider[key])
        notes.append(
            f"the noise of the measured load makes the interval of {name} "
            f"{significant(wider[name], 3)} times as wide: more cycles, or a load that is known "
            "better, would narrow it"
        )
    # A robust loss gives less weight to noise, too.
    if loss == "linear" and is_less_than_noise(problem, best.cost, freedom):
        notes.append(
            "the mean loops are smoother than the scatter of the forces lets expect (reduced "
            f"chi-squared {significant(best.cost / freedom, 2)}): that scatter is no white noise, "
            "such as a force that wanders; the intervals may be wider than need be"
        )
    return notes


def widened_by_loads(problem: Problem, q: Floats) -> Mapping[str, float]:
    """How many times as wide the noise of the loads makes each interval, if all is linear."""
    uncertain = [problem.has_load_error(i) for i in problem.order]
    if not any(uncertain) or not problem.nuisance_effects:
        return {}
    by_all = problem.residuals(q)[1]
    metrics = list(problem.metrics)
    problem.metrics = [
        problem.metric_of(at, loads=False) if is_uncertain else metric
        for at, (is_uncertain, metric) in enumerate(zip(uncertain, metrics, strict=True))
    ]
    problem._last = None
    by_rest = problem.residuals(q)[1]
    problem.metrics = metrics
    problem._last = None
    with_loads, without = (np.diag(covariance_of(by.T @ by)) for by in (by_all, by_rest))
    names = [problem.coordinates[int(j)].name for j in problem.free]
    return dict(zip(names, np.sqrt(with_loads / without).tolist(), strict=True))


def is_less_than_noise(problem: Problem, cost: float, freedom: int) -> bool:
    """Whether the misfit is significantly less than the noise seen between the cycles.

    That noise is known from as many degrees of freedom as the cycles have (Fisher's F).
    """
    from scipy.special import fdtr

    noise_freedom = sum(record.freedom for record in problem.folded)
    quiet = [record.force_noise < _QUIET * float(np.ptp(record.force)) for record in problem.folded]
    return not all(quiet) and bool(fdtr(freedom, noise_freedom, cost / freedom) < _RARE)
