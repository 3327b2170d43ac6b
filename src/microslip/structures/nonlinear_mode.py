"""A nonlinear mode from amplitude to amplitude: Newton's method on harmonic balance."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.balance import Balance
from microslip.structures.newton_steps import ModePoint, ModeResidual, ModeStep
from microslip.structures.periodic_motion import AmplitudeMeasure, HarmonicForces

LARGEST_DIRECT = 900
"""Unknowns up to which the equations are solved by elimination, beyond by GMRES."""
_ITERATIONS = 40
_STEP = 1e-10  # relative size of the last step of Newton's method
_BALANCED = 1e-13  # residual at which a step more changes nothing but rounding
_STALLED = 1e-7  # residual with which a stalled line search counts as rounding


class Solution(NamedTuple):
    """Result of Newton's method."""

    point: ModePoint
    converged: bool
    iterations: int
    residual: float
    """Residual of the equations, each beside the largest force in it [-]."""
    answers: list[HarmonicForces]


@dataclass(frozen=True, eq=False)
class ModeEquations:
    """The equations of one nonlinear mode at an amplitude."""

    balance: Balance
    index: int
    """Modal coordinate whose phase is held."""
    measure: AmplitudeMeasure

    def solve(self, guess: ModePoint, amplitude: float) -> Solution:
        """Newton's method with a line search on the scaled residual."""
        point, converged, iterations = guess, False, 0
        current = self._residual(point, amplitude)
        while iterations < _ITERATIONS:
            iterations += 1
            step = self._newton_step(point, amplitude, current)
            if step is None:
                break
            q = np.abs(step.coefficients).max() / np.abs(point.coefficients).max()
            size = max(float(q), abs(step.omega) / point.omega, abs(step.damping))
            share, trial, after = 1.0, point, current
            while share > 1e-3:
                trial = self._moved(point, step, share)
                after = self._residual(trial, amplitude)
                if after.merit < (1.0 - 0.1 * share) * current.merit or size < 1e-6:
                    break
                share *= 0.5
            else:
                # Nothing better lies that way: either this is rounding, or it is the end.
                converged = current.merit < _STALLED
                break
            point, current = trial, after
            if share == 1.0 and (size < _STEP or (size < 1e-6 and after.merit < _BALANCED)):
                converged = True
                break
        return Solution(point, converged, iterations, current.merit, current.answers)

    def unbalanced(self, point: ModePoint, amplitude: float) -> tuple[float, float]:
        """Relative changes of a solution's frequency and damping by a step with more harmonics."""
        basis = self.balance.basis.richer()
        richer = replace(self, balance=replace(self.balance, basis=basis))
        q = np.zeros((self.balance.model.size, basis.size))
        q[:, np.isin(basis.orders, self.balance.basis.orders)] = point.coefficients
        padded = point._replace(coefficients=q)
        step = richer._newton_step(padded, amplitude, richer._residual(padded, amplitude))
        if step is None:
            return math.nan, math.nan
        damping = -step.damping / point.damping if point.damping else 0.0
        return -step.omega / point.omega, damping

    def _residual(self, point: ModePoint, amplitude: float) -> ModeResidual:
        balance = self.balance
        q, omega, zeta = point
        joint_forces, answers = balance.joint_forces(q)
        forces = balance.linear(q, omega, -2.0 * zeta * omega) + joint_forces
        measured, by_q, by_omega = self.measure.square(q, omega)
        border = np.array([measured / amplitude**2 - 1.0, q[self.index, 2]])
        size = math.sqrt(float(np.sum(q[:, 1:3] ** 2)))
        scale = np.maximum(balance.model.squares, omega**2)[:, None] * size
        merit = math.sqrt(float(np.sum((forces / scale) ** 2)) + border[0] ** 2)
        return ModeResidual(
            forces, border, merit, answers, by_q / amplitude**2, by_omega / amplitude**2
        )

    def _newton_step(
        self, point: ModePoint, amplitude: float, current: ModeResidual
    ) -> ModePoint | None:
        modes, size = self.balance.shape
        q, omega, zeta = point
        velocity = self.balance.velocity(q, omega)
        by_omega = self.balance.by_omega(q, omega) - 4.0 * zeta * velocity
        columns = np.stack([by_omega, -2.0 * omega * velocity], axis=-1)
        system = ModeStep(self.balance, self.index, point, current, columns)
        damped = self.balance.model.damping is not None
        unknowns = modes if damped else min(modes, self.balance.joints.flat.shape[1])
        direct = unknowns * size <= LARGEST_DIRECT
        change = system.eliminate() if direct else system.iterate()
        if change is None and not direct:
            change = system.eliminate()
        if change is None or not np.isfinite(change).all():
            return None
        return ModePoint(change[:-2].reshape(modes, size), float(change[-2]), float(change[-1]))

    def _moved(self, point: ModePoint, step: ModePoint, share: float) -> ModePoint:
        # A frequency does not change sign, however bad a guess was.
        omega = max(point.omega - share * step.omega, 0.2 * point.omega)
        q = point.coefficients - share * step.coefficients
        return ModePoint(q, omega, point.damping - share * step.damping)


_SMALLEST = 1e-6  # of the first amplitude: where a mode of sticking joints is to be found
_FINEST = 0.01  # shortest step in the logarithm of the amplitude
# -- from amplitude to amplitude -------------------------------------------------------------------

_Found = TypeVar("_Found")
Track = list[tuple[float, _Found]]
"""Amplitudes that were reached, rising, the last three, and what was found there."""


def climb(
    amplitudes: Floats,
    track: Track[_Found],
    attempt: Callable[[Track[_Found], float], _Found | None],
    finest: float,
) -> list[_Found | None]:
    """Results at rising amplitudes, each from those before; steps in between where it needs them.

    ``track`` is where it begins; None from where steps in the logarithm would be too short.
    """
    results: list[_Found | None] = [None] * amplitudes.size
    for place in np.argsort(amplitudes, kind="stable"):
        target, stride = float(amplitudes[place]), math.inf
        while target != track[-1][0]:
            gap = math.log(target / track[-1][0])
            ahead = min(stride, gap)
            at = target if ahead == gap else track[-1][0] * math.exp(ahead)
            found = attempt(track, at)
            if found is None:
                stride = 0.5 * ahead
                if stride < finest:
                    return results
            else:
                track.append((at, found))
                del track[:-3]
                stride = 1.5 * ahead
        results[place] = track[-1][1]
    return results


@dataclass(frozen=True, eq=False)
class Continuation:
    """Results at each amplitude."""

    solutions: list[Solution | None]
    """In the order of the amplitudes; None where it was not reached."""
    iterations: int
    steps: int
    stopped_at: float | None
    """The amplitude beyond which nothing was found."""


def follow(equations: ModeEquations, amplitudes: Floats) -> Continuation:
    """Solve the balance of harmonics at amplitudes.

    The predictor goes on straight in the logarithm of the amplitude: what grows in proportion to
    it, as all does for sticking joints, is predicted exactly.
    """
    lowest = float(amplitudes.min())
    first, iterations, steps = _first_solution(equations, lowest)
    if first is None:
        return Continuation([None] * amplitudes.size, iterations, steps, lowest)

    def attempt(track: Track[Solution], at: float) -> Solution | None:
        nonlocal iterations, steps
        guess = _prediction([(a, solution.point) for a, solution in track], at)
        candidate = equations.solve(guess, at)
        iterations, steps = iterations + candidate.iterations, steps + 1
        near = candidate.converged and _same_mode(candidate.point, guess)
        return candidate if near else None

    track = [(lowest, first)]
    solutions = climb(amplitudes, track, attempt, _FINEST)
    stopped = track[-1][0] if None in solutions else None
    return Continuation(solutions, iterations, steps, stopped)


def _first_solution(equations: ModeEquations, target: float) -> tuple[Solution | None, int, int]:
    """The first amplitude: from the mode of sticking joints, further below where it must be."""
    iterations, steps, start = 0, 0, target
    while start > 0.9 * _SMALLEST * target:
        guess = _sticking_mode(equations, start)
        candidate = equations.solve(guess, start)
        iterations, steps = iterations + candidate.iterations, steps + 1
        if candidate.converged and _same_mode(candidate.point, guess):
            if start == target:
                return candidate, iterations, steps
            rising = np.geomspace(start, target, 2 + round(math.log10(target / start)))
            climb = follow(equations, rising)
            return climb.solutions[-1], iterations + climb.iterations, steps + climb.steps
        start *= 0.1
    return None, iterations, steps


def _same_mode(point: ModePoint, guess: ModePoint) -> bool:
    """Whether Newton's method stayed near its guess: it may converge to another motion."""
    a, b = point.coefficients[:, 1:3].ravel(), guess.coefficients[:, 1:3].ravel()
    likeness = abs(float(a @ b)) / float(np.linalg.norm(a) * np.linalg.norm(b))
    return likeness > 0.8 and 0.7 < point.omega / guess.omega < 1.4


def _sticking_mode(equations: ModeEquations, amplitude: float) -> ModePoint:
    model = equations.balance.model
    omega = math.sqrt(model.squares[equations.index])
    shape = np.zeros(model.size)
    shape[equations.index] = 1.0
    q = np.zeros(equations.balance.shape)
    q[equations.index, 1] = amplitude / equations.measure.factor(shape, omega)
    return ModePoint(q, omega, 0.0)


def _prediction(track: Sequence[tuple[float, ModePoint]], amplitude: float) -> ModePoint:
    last, point = track[-1]
    factor = amplitude / last
    if len(track) == 1:
        return point._replace(coefficients=factor * point.coefficients)
    before, earlier = track[-2]
    share = min(math.log(factor) / math.log(last / before), 3.0)
    slope = point.coefficients / last - earlier.coefficients / before
    return ModePoint(
        amplitude * (point.coefficients / last + share * slope),
        point.omega * (point.omega / earlier.omega) ** share,
        point.damping + share * (point.damping - earlier.damping),
    )
