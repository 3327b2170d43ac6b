"""Both ways to a modal curve: the balance of harmonics and the quasi-static one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.amplitude import AmplitudeMeasure
from microslip.structures.balance import Balance
from microslip.structures.harmonic_basis import HarmonicBasis
from microslip.structures.modal_curve import ModalCurve
from microslip.structures.modal_model import ModalJoints, ModalModel
from microslip.structures.nonlinear_mode import ModeEquations, ModePoint, Solution
from microslip.structures.quasi_static import QuasiStatic

_SMALLEST = 1e-6  # of the first amplitude: where a mode of sticking joints is to be found
_FINEST = 0.01  # shortest step in the logarithm of the amplitude


class _Row(NamedTuple):
    """A solved amplitude, by its place among them."""

    place: int
    modal_amplitude: float
    omega: float
    damping: float
    shape: np.ndarray
    loss: Floats


@dataclass(frozen=True, eq=False)
class ModeSolver:
    """A mode, the amplitudes at which it is wanted, and the damping that is added."""

    model: ModalModel
    index: int
    amplitudes: Floats
    measure: AmplitudeMeasure
    basis: HarmonicBasis
    base_damping: float

    def balanced(self) -> ModalCurve:
        """By the balance of harmonics, with continuation."""
        joints = self._joints()
        balance = Balance(self.model, joints, self.basis)
        followed = follow(ModeEquations(balance, self.index, self.measure), self.amplitudes)
        rows = []
        for i, solution in enumerate(followed.solutions):
            if solution is None:
                continue
            q, omega, zeta = solution.point
            modal = math.sqrt(float(np.sum(q[:, 1:3] ** 2)))
            motions = joints.split(joints.flat.T @ q)
            loss = [
                self.basis.work(answer.force, motion).sum(axis=1)
                for answer, motion in zip(solution.answers, motions, strict=True)
            ]
            shape = self.model.shapes @ (q[:, 1] - 1j * q[:, 2]) / modal
            rows.append(_Row(i, modal, omega, zeta, shape, np.concatenate([*loss, np.zeros(0)])))
        if followed.stopped_at is None:
            message = f"solved in {followed.iterations} iterations and {followed.steps} steps"
        else:
            message = (
                f"stopped beyond the amplitude {followed.stopped_at:.4g}: the balance of harmonics "
                f"did not converge in steps of 1 %, after {followed.iterations} iterations; try "
                "more samples, fewer harmonics, or amplitudes that end there (the mode may meet "
                "another one, or all joints may slide)"
            )
        return self._curve(
            "harmonic-balance", joints, rows, followed.iterations, message, self.quasi_static
        )

    def quasi_static(self) -> ModalCurve:
        """By quasi-static modal analysis."""
        joints = self._joints()
        solver = QuasiStatic(self.model, joints, self.index, self.measure)
        solved = [(i, p) for i, p in enumerate(solver.curve(self.amplitudes)) if p is not None]
        rows = []
        if solved:
            losses = zip(*solver.losses([point for _, point in solved]), strict=True)
            for (i, point), (damping, energy) in zip(solved, losses, strict=True):
                modal = point.modal_amplitude
                shape = self.model.shapes @ point.shape / modal
                rows.append(_Row(i, modal, point.omega, float(damping), shape, energy))
        message = f"solved in {solver.iterations} iterations"
        if len(solved) < self.amplitudes.size:
            reached = max((float(self.amplitudes[i]) for i, _ in solved), default=math.nan)
            where = f"beyond the amplitude {reached:.4g}" if solved else "at the first amplitude"
            message = (
                f"stopped {where}: the static deflection along the mode was not found; all joints "
                'may slide there, which method="harmonic-balance" follows further'
            )
        return self._curve("quasi-static", joints, rows, solver.iterations, message, self.balanced)

    def _joints(self) -> ModalJoints:
        """The joints along the mode of sticking joints."""
        line = np.zeros(self.model.size)
        line[self.index] = 1.0
        return self.model.joints(line)

    def _curve(
        self,
        method: str,
        joints: ModalJoints,
        rows: list[_Row],
        iterations: int,
        message: str,
        other_method: Callable[[], ModalCurve],
    ) -> ModalCurve:
        count = self.amplitudes.size
        modal, frequency, damping = np.full((3, count), np.nan)
        shape = np.full((count, self.model.shapes.shape[0]), np.nan, dtype=complex)
        loss = np.full((count, sum(g.stuck.shape[0] for g in joints.groups)), np.nan)
        for row in rows:
            i = row.place
            modal[i], frequency[i] = row.modal_amplitude, row.omega / (2 * math.pi)
            damping[i] = row.damping + self.base_damping
            shape[i], loss[i] = row.shape, row.loss
        return ModalCurve(
            method=method,
            index=self.index,
            amplitude=self.amplitudes.copy(),
            modal_amplitude=modal,
            frequency=frequency,
            damping_ratio=damping,
            shape=shape,
            loss=loss,
            linear_frequency=math.sqrt(float(self.model.squares[self.index])) / (2.0 * math.pi),
            base_damping=self.base_damping,
            converged=np.isfinite(frequency),
            iterations=iterations,
            message=message,
            _solve_by_other=other_method,
        )


# -- the balance of harmonics from amplitude to amplitude ------------------------------------------


@dataclass(frozen=True, eq=False)
class Continuation:
    """What came out at each amplitude."""

    solutions: list[Solution | None]
    """In the order of the amplitudes; None where it was not reached."""
    iterations: int
    steps: int
    stopped_at: float | None
    """The amplitude beyond which nothing was found."""


def follow(equations: ModeEquations, amplitudes: Floats) -> Continuation:
    """Solve at rising amplitudes, each from the ones before; steps in between where it needs them.

    The predictor goes on straight in the logarithm of the amplitude: what grows in proportion to
    it, as all does for sticking joints, is predicted exactly.
    """
    order = np.argsort(amplitudes, kind="stable")
    solutions: list[Solution | None] = [None] * amplitudes.size
    iterations, steps, before = 0, 0, -1
    track: list[tuple[float, ModePoint]] = []
    for place in order:
        target = float(amplitudes[place])
        if track and target == track[-1][0]:  # asked for twice
            solution = solutions[before]
        elif not track:
            solution, spent, trials = _first_solution(equations, target)
            iterations, steps = iterations + spent, steps + trials
        else:
            solution = None
            stride = math.log(target / track[-1][0])
            while True:
                gap = math.log(target / track[-1][0])
                ahead = min(stride, gap)
                at = target if ahead == gap else track[-1][0] * math.exp(ahead)
                guess = _prediction(track, at)
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
            return Continuation(solutions, iterations, steps, stopped)
        solutions[place], before = solution, place
        if not track or track[-1][0] != target:
            track.append((target, solution.point))
        del track[:-3]
    return Continuation(solutions, iterations, steps, None)


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
    """Whether Newton's method stayed near its guess: it may land on a motion far away."""
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
