"""The least squares of an identification, and its weights."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.identification.problem import Problem

_TOLERANCE = 1e-10
_PASSES, _DAMPED, _SHARE = 4, 12, 0.5
_SETTLED = 0.01
"""Share by which the sum of squares may change with weights of where the fit ended."""
_MOST_EVALUATIONS = 150
_MOST_IN_ALL = 2000
"""Evaluations of one minimisation, and of all that a fit takes, its starts and weights together."""
_AT_BOUND = 1e-6
_DISTINCT = 1e-4  # of its size, that no coordinate makes
_FEW_EVALUATIONS = 30
_MOST_STEPS, _IDLE = 40, 3
_LEAST_DAMPING, _MOST_DAMPING = 1e-3, 1e6


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a minimisation."""

    q: Floats
    cost: float
    """Sum of squares."""
    cause: str = ""
    """Why it did not converge, as a kind of caveat; empty where it did."""
    why: str = ""
    """Reason of an early end."""
    weight: float = 0.0
    """Logarithm of the determinant of the covariance under which the sum was taken."""

    @property
    def converged(self) -> bool:
        """Whether it ended at a minimum."""
        return not self.cause

    @property
    def deviance(self) -> float:
        """Quantity by which sums under different weights are compared."""
        return self.cost + self.weight

    @property
    def finite(self) -> bool:
        """Whether there is anything to report."""
        return bool(np.isfinite(self.cost))


def bounds_of(problem: Problem) -> tuple[Floats, Floats]:
    """Lower and upper bounds of the free coordinates, as they are fitted."""
    limits = [problem.coordinates[int(j)].limits for j in problem.free]
    low, high = (np.array([end[k] for end in limits]) for k in (0, 1))
    return low, high


def minimise(
    problem: Problem,
    start: Floats,
    *,
    moving: NDArray[np.intp] | None = None,
    tolerance: float = _TOLERANCE,
) -> Fit:
    """Least squares from a start; parts that no record has in common one after the other."""
    if moving is not None or len(problem.parts) < 2:
        moving = np.arange(start.size) if moving is None else moving
        return _least_squares(problem, start, moving, tolerance)
    low, high = bounds_of(problem)
    fit, first = Fit(np.clip(start, low, high), math.inf), Fit(start, math.inf)
    for part in problem.parts:
        fit = _least_squares(problem, fit.q, part, tolerance)
        if not fit.finite:
            return fit
        first = fit if first.converged else first
    return replace(fit, cause=first.cause, why=first.why)


def _in_trust_region(
    problem: Problem,
    start: Floats,
    moving: NDArray[np.intp],
    tolerance: float,
    evaluation_limit: int | None = None,
) -> Fit:
    from scipy.optimize import least_squares

    low, high = bounds_of(problem)
    q = np.clip(start, low, high)
    if moving.size == 0:
        residual, _ = problem.residuals(q)
        return Fit(q, float(np.dot(residual, residual)))
    inner_low, inner_high = low[moving], high[moving]
    # The method wants a start strictly inside.
    width = np.minimum(inner_high - inner_low, 1.0)
    inside = np.clip(q[moving], inner_low + 1e-9 * width, inner_high - 1e-9 * width)

    def at(part: Floats) -> Floats:
        full_q = q.copy()
        full_q[moving] = part
        return full_q

    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            solution = least_squares(
                lambda part: problem.residuals(at(part))[0],
                inside,
                jac=lambda part: problem.residuals(at(part))[1][:, moving],
                bounds=(inner_low, inner_high),
                x_scale="jac",
                ftol=tolerance,
                xtol=tolerance,
                gtol=1e-12,
                max_nfev=_MOST_EVALUATIONS if evaluation_limit is None else evaluation_limit,
            )
        except (ValueError, np.linalg.LinAlgError) as error:
            return Fit(q, math.inf, "broken off", str(error))
    # The only other way to end is the limit of evaluations.
    cause = "" if solution.status > 0 else "used up"
    return Fit(at(solution.x), 2.0 * float(solution.cost), cause)


def _least_squares(
    problem: Problem, start: Floats, moving: NDArray[np.intp], tolerance: float
) -> Fit:
    """The least squares from a start, in a trust region where damped steps do not reach it."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):  # a start may be far away
        warnings.simplefilter("ignore")
        fit, reached = _descended(problem, start, moving, share=1e-3 * tolerance)
    # What is not finite from the start on has its reason told there.
    return fit if reached and fit.finite else _in_trust_region(problem, start, moving, tolerance)


def settle(
    problem: Problem, start: Floats, moving: NDArray[np.intp], *, good_enough: float = 1e-3
) -> Fit:
    """The minimum near a good start; ``good_enough`` is how far its sum of squares may be off."""
    fit, reached = _descended(problem, start, moving, good_enough)
    return fit if reached else _in_trust_region(problem, fit.q, moving, 1e-7, _FEW_EVALUATIONS)


def settle_near(
    problem: Problem, start: Floats, moving: NDArray[np.intp] | None = None
) -> Fit | None:
    """The minimum near a start, part by part; None where the law has no answer on the way."""
    fit = Fit(start, math.inf)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            for part in problem.parts if moving is None else [moving]:
                fit = settle(problem, fit.q, part)
                if not fit.finite:
                    return None
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None
    return fit


def covariance_of(information: Floats) -> Floats:
    """The inverse of an information; very large where the data say nothing."""
    size = np.sqrt(np.diag(information))
    unknown = size == 0.0
    size[unknown] = 1.0
    scaled = information / np.outer(size, size)
    values, vectors = np.linalg.eigh(scaled)
    values = np.maximum(values, 1e-14)
    inverse = (vectors / values) @ vectors.T
    return np.asarray(inverse / np.outer(size, size))


class Score(NamedTuple):
    """Expected decrease of the sum of squares by further forces, all taken as linear."""

    fall: float
    sizes: Floats
    """Sizes at which they would."""
    distinct: int
    """How many of them no coordinate makes."""


def score(problem: Problem, q: Floats, rows: Floats) -> Score:
    """The score test (Rao 1948) of forces of any size, given by their weighted courses (rows)."""
    residual, by = problem.residuals(q)
    columns = np.zeros((residual.size, len(rows)))
    columns[: rows.shape[1]] = problem.whitened(rows).T
    remainder = columns - by @ (covariance_of(by.T @ by) @ (by.T @ columns))
    norm = np.linalg.norm(remainder, axis=0)
    distinct = norm > _DISTINCT * np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    sizes = np.zeros(len(rows))
    if distinct.any():
        basis = remainder[:, distinct] / norm[distinct]
        sizes[distinct] = -np.linalg.lstsq(basis, residual, rcond=None)[0] / norm[distinct]
    moved = remainder @ sizes
    return Score(float(moved @ moved), sizes, int(distinct.sum()))


def _descended(
    problem: Problem,
    start: Floats,
    moving: NDArray[np.intp],
    good_enough: float = 1e-12,
    share: float = 0.0,
) -> tuple[Fit, bool]:
    """End of damped Gauss-Newton steps within the bounds, and whether it is a minimum.

    Levenberg (1944, DOI 10.1090/qam/10666) and Marquardt (1963, DOI 10.1137/0111030). The sum of
    squares may be off its minimum by ``good_enough`` or by a share of itself.
    """
    low, high = bounds_of(problem)
    q = np.clip(start, low, high)
    residual, by = problem.residuals(q)
    cost = float(np.dot(residual, residual))
    damping, idle = 0.0, 0
    for _ in range(_MOST_STEPS):
        if moving.size == 0 or not np.isfinite(cost):
            return Fit(q, cost), True
        enough = max(good_enough, share * cost)
        free, step, gain = _step_within(q, residual, by, moving, low, high, damping)
        if free.size == 0 or (damping == 0.0 and gain <= enough):
            return Fit(q, cost), True
        new = q.copy()
        new[free] += step
        new = np.clip(new, low, high)
        there, by_there = problem.residuals(new)
        new_cost = float(np.dot(there, there))
        if new_cost < cost:
            # At a kink steps may continue without any gain.
            idle = idle + 1 if cost - new_cost < enough else 0
            q, residual, by, cost = new, there, by_there, new_cost
            damping = 0.1 * damping if damping > _LEAST_DAMPING else 0.0
        else:
            damping = max(10.0 * damping, _LEAST_DAMPING)
        if idle >= _IDLE:
            return Fit(q, cost), True
        if damping > _MOST_DAMPING:
            break  # a kink, at which no derivative tells the way on
    return Fit(q, cost), False


def _step_within(
    q: Floats,
    residual: Floats,
    by: Floats,
    moving: NDArray[np.intp],
    low: Floats,
    high: Floats,
    damping: float,
) -> tuple[NDArray[np.intp], Floats, float]:
    """The step, with those left out that lie at a bound and would leave it."""
    free = moving
    while free.size:
        step, gain = _step(residual, by[:, free], damping)
        out = ((q[free] <= low[free]) & (step < 0.0)) | ((q[free] >= high[free]) & (step > 0.0))
        if not out.any():
            return free, step, gain
        free = free[~out]
    return free, np.zeros(0), 0.0


def _step(residual: Floats, by: Floats, damping: float) -> tuple[Floats, float]:
    """Newton's step after Gauss, and how much it takes off the sum of squares, if all is linear."""
    scale = np.linalg.norm(by, axis=0)
    scale[scale == 0.0] = 1.0
    normal = (by / scale).T @ (by / scale)
    right = (by / scale).T @ residual
    # A ridge of rounding's size keeps directions that nothing is known of where they are.
    normal[np.diag_indices_from(normal)] += 1e-13 + damping
    step = -np.linalg.solve(normal, right)
    return step / scale, float(-np.dot(right, step))


def solve(
    problem: Problem, starts: Iterable[Floats], *, freedom: int, loss: str = "linear"
) -> Fit | None:
    """The best of several starts, each by its own weights, tried if those before ended badly."""
    best: Fit | None = None
    problem.evaluation_limit = problem.evaluations + _MOST_IN_ALL
    for start in starts:
        if best is not None and problem.evaluations > problem.evaluation_limit:
            break
        problem.forget()
        fit = _reweighted(problem, start)
        # Two that end at the same place: other starts would end there, too.
        is_repeated = best is not None and abs(fit.deviance - best.deviance) < 1e-3 * best.deviance
        if best is None or _is_better(fit, best):
            best = fit
        good = is_repeated or (
            best.converged and best.cost < 3.0 * freedom and not at_bounds(problem, best.q)
        )
        if good:
            break
    if best is not None and best.finite:
        problem.update(best.q)
        best = _refitted(problem, best)
        if loss != "linear":
            best = _robust(problem, best, loss)
    return best


_LOSS_WEIGHTS: dict[str, Callable[[Floats], Floats]] = {
    "linear": np.ones_like,
    "soft_l1": lambda z: 1.0 / np.sqrt(1.0 + z),
    "huber": lambda z: 1.0 / np.sqrt(np.maximum(z, 1.0)),
    "cauchy": lambda z: 1.0 / (1.0 + z),
    "arctan": lambda z: 1.0 / (1.0 + z**2),
}
_TOLERATED = 2.0
"""Residual, in units of its noise, from which on a robust loss gives less weight to a force."""


def _robust(problem: Problem, fit: Fit, loss: str) -> Fit:
    """The fit under a robust loss, by weights that follow the residuals.

    So the offsets and the other nuisances are robust, too, which are projected out linearly. A law
    that fits badly as a whole is judged by its median residual, or all of it would be outliers.
    """
    for passed in range(30):
        if problem.evaluations > problem.evaluation_limit:
            return replace(fit, cause="used up")
        residual = problem.standardised(fit.q)
        scale = _TOLERATED * max(1.0, float(np.median(np.abs(residual))) / 0.6745)
        problem.weigh(np.sqrt(_LOSS_WEIGHTS[loss]((residual / scale) ** 2)))
        problem.update(fit.q, _SHARE, problem.nuisance_effects if passed >= _PASSES else ())
        before, fit = fit, _refitted(problem, fit)
        _, by = problem.residuals(fit.q)
        moved = by @ (fit.q - before.q)
        if float(moved @ moved) < 1e-6:
            break
    return fit


def _refitted(problem: Problem, fit: Fit) -> Fit:
    """The fit once more under the weights as they now are."""
    refit = minimise(problem, fit.q)
    if not refit.finite:
        return fit
    ended = refit if fit.converged else fit
    return replace(ended, q=refit.q, cost=refit.cost, weight=problem.log_determinant)


def _reweighted(problem: Problem, start: Floats) -> Fit:
    low, high = bounds_of(problem)
    fit = minimise(problem, np.clip(start, low, high), tolerance=1e-6)
    return _under_own_weights(problem, fit) if fit.finite else fit


def resettled(problem: Problem, start: Floats) -> Fit:
    """The fit near a start, under the weights of where it ends."""
    problem.evaluation_limit = problem.evaluations + _MOST_IN_ALL
    problem.update(start)
    fit = _under_own_weights(problem, minimise(problem, start))
    if not fit.finite:
        return fit
    problem.update(fit.q)
    return _refitted(problem, fit)


def _under_own_weights(problem: Problem, fit: Fit) -> Fit:
    """The fit under the weights of where it ended, damped, until it stays; else the best place."""
    best = fit
    lowest = math.inf
    for passed in range(_PASSES + _DAMPED):
        if problem.evaluations > problem.evaluation_limit:
            return replace(best, cause="used up")
        used = problem.nuisance_effects
        problem.update(fit.q)
        fit = _reweighed(problem, fit)
        if fit.deviance < lowest:
            best, lowest = fit, fit.deviance
        if passed >= _PASSES:
            problem.update(fit.q, _SHARE, used)
        before, fit = fit, minimise(problem, fit.q, tolerance=1e-8)
        if not fit.finite:
            return best
        _, by = problem.residuals(fit.q)
        moved = by @ (fit.q - before.q)
        if float(np.dot(moved, moved)) < max(1e-4, 1e-6 * fit.cost):  # squares of standard errors
            break
    under = fit.cost
    problem.update(fit.q)
    fit = _reweighed(problem, fit)
    if abs(fit.cost - under) <= _SETTLED * max(fit.cost, 1.0):
        return fit
    best = fit if fit.deviance < lowest else best
    return replace(best, cause="unsettled")


def _reweighed(problem: Problem, fit: Fit) -> Fit:
    """The fit with its sum of squares under the weights as they now are."""
    residual, _ = problem.residuals(fit.q)
    return replace(fit, cost=float(residual @ residual), weight=problem.log_determinant)


def _is_better(fit: Fit, best: Fit) -> bool:
    if not fit.finite or not best.finite:
        return fit.finite
    # One that converged may be a little worse.
    if fit.converged and not best.converged:
        return fit.deviance < 1.1 * best.deviance
    if best.converged and not fit.converged:
        return not best.deviance < 1.1 * fit.deviance
    return fit.deviance < best.deviance


def at_bounds(problem: Problem, q: Floats) -> list[int]:
    """Free coordinates that ended at a bound; a lower one that joints have does not count."""
    low, high = bounds_of(problem)
    near = _AT_BOUND * np.minimum(high - low, 1.0)
    natural = {parameter.name for parameter in problem.model.parameters if parameter.natural}
    is_natural = np.array(
        [problem.coordinates[j].parameter in natural for j in problem.free], dtype=bool
    )
    at_low, at_high = q - low <= near, high - q <= near
    return [int(i) for i in np.flatnonzero((at_low & ~is_natural) | at_high)]
