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


class Score(NamedTuple):
    """Expected decrease of the sum of squares by further forces, all taken as linear."""

    fall: float
    share: float
    """Decrease as a share of the sum of squares."""
    sizes: Floats
    """Sizes at which they would."""
    distinct: int
    """Number of forces that no coordinate makes."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Coordinates of a problem with their sum of squares, and how they were found."""

    problem: Problem
    q: Floats
    cost: float = math.inf
    """Sum of squares."""
    cause: str = ""
    """Cause of a fit that did not converge, as a kind of caveat; empty where it did."""
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

    @property
    def reduced(self) -> float:
        """Sum of squares over degrees of freedom [-]."""
        return self.cost / self.problem.freedom

    @property
    def information(self) -> Floats:
        """Half the second derivatives of the sum of squares, after Gauss and Newton."""
        _, by = self.problem.residuals(self.q)
        return by.T @ by

    @property
    def at_bounds(self) -> list[int]:
        """Coordinates that ended at a bound; a lower one that joints have does not count."""
        problem, (low, high) = self.problem, self.problem.bounds
        near = _AT_BOUND * np.minimum(high - low, 1.0)
        natural = {parameter.name for parameter in problem.model.parameters if parameter.natural}
        is_natural = np.array(
            [c.parameter in natural for c in problem.free_coordinates], dtype=bool
        )
        at_low, at_high = self.q - low <= near, high - self.q <= near
        return [int(i) for i in np.flatnonzero((at_low & ~is_natural) | at_high)]

    def score(self, rows: Floats) -> Score:
        """The score test (Rao 1948) of forces of any size, by their weighted courses (rows)."""
        residual, by = self.problem.residuals(self.q)
        columns = np.zeros((residual.size, len(rows)))
        columns[: rows.shape[1]] = self.problem.whitened(rows).T
        remainder = columns - by @ (covariance_of(by.T @ by) @ (by.T @ columns))
        norm = np.linalg.norm(remainder, axis=0)
        distinct = norm > _DISTINCT * np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        sizes = np.zeros(len(rows))
        if distinct.any():
            basis = remainder[:, distinct] / norm[distinct]
            sizes[distinct] = -np.linalg.lstsq(basis, residual, rcond=None)[0] / norm[distinct]
        moved = remainder @ sizes
        fall = float(moved @ moved)
        share = min(fall / self.cost, 1.0) if self.cost > 0.0 else 0.0
        return Score(fall, share, sizes, int(distinct.sum()))

    # -- to a minimum ---------------------------------------------------------------------------

    def minimised(self, tolerance: float = _TOLERANCE) -> Fit:
        """Least squares from here; parts that no record has in common one after the other."""
        parts = self.problem.parts
        if len(parts) < 2:
            return self._least_squares(np.arange(self.q.size), tolerance)
        first = fit = Fit(self.problem, np.clip(self.q, *self.problem.bounds))
        for part in parts:
            fit = fit._least_squares(part, tolerance)
            if not fit.finite:
                return fit
            first = fit if first.converged else first
        return replace(fit, cause=first.cause, why=first.why)

    def settled(self, moving: NDArray[np.intp], good_enough: float = 1e-3) -> Fit:
        """The minimum near a good start; ``good_enough`` is how far its sum may be off."""
        fit, reached = self._descended(moving, good_enough)
        return fit if reached else fit._in_trust_region(moving, 1e-7, _FEW_EVALUATIONS)

    def settled_near(self, moving: NDArray[np.intp] | None = None) -> Fit | None:
        """The minimum near this, part by part; None where the law has no answer on the way."""
        fit = Fit(self.problem, self.q)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            try:
                for part in self.problem.parts if moving is None else [moving]:
                    fit = fit.settled(part)
                    if not fit.finite:
                        return None
            except (ArithmeticError, ValueError, np.linalg.LinAlgError):
                return None
        return fit

    def _least_squares(self, moving: NDArray[np.intp], tolerance: float) -> Fit:
        """The least squares, in a trust region where damped steps do not reach it."""
        with warnings.catch_warnings(), np.errstate(all="ignore"):  # a start may be far away
            warnings.simplefilter("ignore")
            fit, reached = self._descended(moving, share=1e-3 * tolerance)
        # What is not finite from the start on has its reason told there.
        return fit if reached and fit.finite else self._in_trust_region(moving, tolerance)

    def _in_trust_region(
        self, moving: NDArray[np.intp], tolerance: float, evaluation_limit: int | None = None
    ) -> Fit:
        from scipy.optimize import least_squares

        problem, (low, high) = self.problem, self.problem.bounds
        q = np.clip(self.q, low, high)
        if moving.size == 0:
            residual, _ = problem.residuals(q)
            return Fit(problem, q, float(np.dot(residual, residual)))
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
                return Fit(problem, q, math.inf, "broken off", str(error))
        # The only other way to end is the limit of evaluations.
        cause = "" if solution.status > 0 else "used up"
        return Fit(problem, at(solution.x), 2.0 * float(solution.cost), cause)

    def _descended(
        self, moving: NDArray[np.intp], good_enough: float = 1e-12, share: float = 0.0
    ) -> tuple[Fit, bool]:
        """End of damped Gauss-Newton steps within the bounds, and whether it is a minimum.

        Levenberg (1944, DOI 10.1090/qam/10666) and Marquardt (1963, DOI 10.1137/0111030). The sum
        of squares may be off its minimum by ``good_enough`` or by a share of itself.
        """
        problem, (low, high) = self.problem, self.problem.bounds
        q = np.clip(self.q, low, high)
        residual, by = problem.residuals(q)
        cost = float(np.dot(residual, residual))
        damping, idle = 0.0, 0
        for _ in range(_MOST_STEPS):
            if moving.size == 0 or not np.isfinite(cost):
                return Fit(problem, q, cost), True
            enough = max(good_enough, share * cost)
            free, step, gain = _step_within(q, residual, by, moving, low, high, damping)
            if free.size == 0 or (damping == 0.0 and gain <= enough):
                return Fit(problem, q, cost), True
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
                return Fit(problem, q, cost), True
            if damping > _MOST_DAMPING:
                break  # a kink, at which no derivative tells the way on
        return Fit(problem, q, cost), False

    # -- under the weights of where it ends -----------------------------------------------------

    def under_own_weights(self) -> Fit:
        """The fit under the weights of where it ended, damped, until it stays; else the best."""
        problem, fit, best, lowest = self.problem, self, self, math.inf
        for passed in range(_PASSES + _DAMPED):
            if problem.evaluations > problem.evaluation_limit:
                return replace(best, cause="used up")
            used = problem.nuisance_effects
            fit = fit._reweighed()
            if fit.deviance < lowest:
                best, lowest = fit, fit.deviance
            if passed >= _PASSES:
                problem.update(fit.q, _SHARE, used)
            before, fit = fit, fit.minimised(1e-8)
            if not fit.finite:
                return best
            # Squares of standard errors.
            if fit._moved_from(before) < max(1e-4, 1e-6 * fit.cost):
                break
        under = fit.cost
        fit = fit._reweighed()
        if abs(fit.cost - under) <= _SETTLED * max(fit.cost, 1.0):
            return fit
        best = fit if fit.deviance < lowest else best
        return replace(best, cause="unsettled")

    def resettled(self) -> Fit:
        """The fit near this, under the weights of where it ends."""
        problem = self.problem
        problem.evaluation_limit = problem.evaluations + _MOST_IN_ALL
        problem.update(self.q)
        fit = self.minimised().under_own_weights()
        if not fit.finite:
            return fit
        problem.update(fit.q)
        return fit.refitted()

    def refitted(self) -> Fit:
        """The fit once more under the weights as they now are."""
        refit = self.minimised()
        if not refit.finite:
            return self
        ended = refit if self.converged else self
        return replace(ended, q=refit.q, cost=refit.cost, weight=self.problem.log_determinant)

    def robust(self, loss: str) -> Fit:
        """The fit under a robust loss, by weights that follow the residuals.

        So the offsets and the other nuisances are robust, too, which are projected out linearly. A
        law that fits badly as a whole is judged by its median residual, or all of it would be
        outliers.
        """
        problem, fit = self.problem, self
        for passed in range(30):
            if problem.evaluations > problem.evaluation_limit:
                return replace(fit, cause="used up")
            residual = problem.standardised(fit.q)
            scale = _TOLERATED * max(1.0, float(np.median(np.abs(residual))) / 0.6745)
            problem.weigh(np.sqrt(_LOSS_WEIGHTS[loss]((residual / scale) ** 2)))
            problem.update(fit.q, _SHARE, problem.nuisance_effects if passed >= _PASSES else ())
            before, fit = fit, fit.refitted()
            if fit._moved_from(before) < 1e-6:
                break
        return fit

    def _reweighed(self) -> Fit:
        """The fit with its sum of squares under the weights of its own tangents."""
        self.problem.update(self.q)
        residual, _ = self.problem.residuals(self.q)
        cost = float(residual @ residual)
        return replace(self, cost=cost, weight=self.problem.log_determinant)

    def _moved_from(self, before: Fit) -> float:
        _, by = self.problem.residuals(self.q)
        moved = by @ (self.q - before.q)
        return float(np.dot(moved, moved))

    def is_better(self, best: Fit) -> bool:
        """Whether it is the one to keep; one that converged may be a little worse."""
        if not self.finite or not best.finite:
            return self.finite
        if self.converged and not best.converged:
            return self.deviance < 1.1 * best.deviance
        if best.converged and not self.converged:
            return not best.deviance < 1.1 * self.deviance
        return self.deviance < best.deviance


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


_LOSS_WEIGHTS: dict[str, Callable[[Floats], Floats]] = {
    "linear": np.ones_like,
    "soft_l1": lambda z: 1.0 / np.sqrt(1.0 + z),
    "huber": lambda z: 1.0 / np.sqrt(np.maximum(z, 1.0)),
    "cauchy": lambda z: 1.0 / (1.0 + z),
    "arctan": lambda z: 1.0 / (1.0 + z**2),
}
_TOLERATED = 2.0
"""Residual, in units of its noise, from which on a robust loss gives less weight to a force."""


def solve(problem: Problem, starts: Iterable[Floats], loss: str = "linear") -> Fit | None:
    """The best of several starts, each by its own weights, tried if those before ended badly."""
    best: Fit | None = None
    problem.evaluation_limit = problem.evaluations + _MOST_IN_ALL
    for start in starts:
        if best is not None and problem.evaluations > problem.evaluation_limit:
            break
        problem.forget()
        fit = Fit(problem, np.clip(start, *problem.bounds)).minimised(1e-6)
        fit = fit.under_own_weights() if fit.finite else fit
        # Two that end at the same place: other starts would end there, too.
        is_repeated = best is not None and abs(fit.deviance - best.deviance) < 1e-3 * best.deviance
        if best is None or fit.is_better(best):
            best = fit
        if is_repeated or (
            best.converged and best.cost < 3.0 * problem.freedom and not best.at_bounds
        ):
            break
    if best is not None and best.finite:
        problem.update(best.q)
        best = best.refitted()
        if loss != "linear":
            best = best.robust(loss)
    return best
