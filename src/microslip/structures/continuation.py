"""A nonlinear mode followed from amplitude to amplitude."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.nonlinear_mode import ModeEquations, ModePoint, Solution

_SMALLEST = 1e-6  # of the first amplitude: where a mode of sticking joints is to be found
_FINEST = 0.01  # shortest step in the logarithm of the amplitude


@dataclass(frozen=True, eq=False)
class Followed:
    """What came out at each amplitude."""

    solutions: list[Solution | None]
    """In the order of the amplitudes; None where it was not reached."""
    iterations: int
    steps: int
    stopped_at: float | None
    """The amplitude beyond which nothing was found."""


def follow(equations: ModeEquations, amplitudes: Floats) -> Followed:
    """Solve at rising amplitudes, each from the ones before; steps in between where it needs them.

    The predictor goes on straight in the logarithm of the amplitude: what grows in proportion to
    it, as all does for sticking joints, is predicted exactly.
    """
    order = np.argsort(amplitudes, kind="stable")
    solutions: list[Solution | None] = [None] * amplitudes.size
    iterations = steps = 0
    track: list[tuple[float, ModePoint]] = []
    before = -1
    for place in order:
        target = float(amplitudes[place])
        if track and target == track[-1][0]:  # asked for twice
            solution = solutions[before]
        elif not track:
            solution, spent, trials = _begin(equations, target)
            iterations, steps = iterations + spent, steps + trials
        else:
            solution = None
            stride = math.log(target / track[-1][0])
            while True:
                gap = math.log(target / track[-1][0])
                ahead = min(stride, gap)
                at = target if ahead == gap else track[-1][0] * math.exp(ahead)
                guess = _predicted(track, at)
                candidate = equations.solve(guess, at)
                iterations, steps = iterations + candidate.iterations, steps + 1
                if candidate.converged and _same_mode(candidate.point, guess):
                    track.append((at, candidate.point))
                    if at == target:
                        solution = candidate
                        break
                    stride = 1.5 * ahead
                else:
                    stride = 0.5 * ahead
                    if stride < _FINEST:
                        break
        if solution is None:
            stopped = track[-1][0] if track else target
            return Followed(solutions, iterations, steps, stopped)
        solutions[place] = solution
        before = place
        if not track or track[-1][0] != target:
            track.append((target, solution.point))
        del track[:-3]
    return Followed(solutions, iterations, steps, None)


def _begin(equations: ModeEquations, target: float) -> tuple[Solution | None, int, int]:
    """The first amplitude: from the mode of sticking joints, further below where it must be."""
    iterations = steps = 0
    start = target
    while start > 0.9 * _SMALLEST * target:
        guess = _stuck(equations, start)
        candidate = equations.solve(guess, start)
        iterations, steps = iterations + candidate.iterations, steps + 1
        if candidate.converged and _same_mode(candidate.point, guess):
            if start == target:
                return candidate, iterations, steps
            climb = follow(
                equations, np.geomspace(start, target, 2 + round(math.log10(target / start)))
            )
            return climb.solutions[-1], iterations + climb.iterations, steps + climb.steps
        start *= 0.1
    return None, iterations, steps


def _same_mode(point: ModePoint, guess: ModePoint) -> bool:
    """Whether Newton's method stayed near its guess: it may land on a motion far away."""
    a, b = point.coefficients[:, 1:3].ravel(), guess.coefficients[:, 1:3].ravel()
    likeness = abs(float(a @ b)) / float(np.linalg.norm(a) * np.linalg.norm(b))
    return likeness > 0.8 and 0.7 < point.omega / guess.omega < 1.4


def _stuck(equations: ModeEquations, amplitude: float) -> ModePoint:
    model = equations.balance.model
    omega = math.sqrt(model.squares[equations.index])
    shape = np.zeros(model.size)
    shape[equations.index] = 1.0
    q = np.zeros(equations.balance.shape)
    q[equations.index, 1] = amplitude / equations.measure.factor(shape, omega)
    return ModePoint(q, omega, 0.0)


def _predicted(track: Sequence[tuple[float, ModePoint]], amplitude: float) -> ModePoint:
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
