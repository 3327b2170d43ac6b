"""Equations of a nonlinear mode at one amplitude, solved by Newton's method."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from microslip._core.errors import InputError
from microslip.structures.balance import Balance, Elimination, ModePoint, ModeResidual, ModeStep
from microslip.structures.periodic_motion import AmplitudeMeasure, HarmonicForces

SMALLEST_INEXACT, LARGEST_DIRECT = 300, 900
"""Numbers of unknowns above which GMRES takes less time: for inexact steps, and for all."""
NO_LOSS = 1e-8
"""Damping ratio of joints to which errors are relative at least: no structure shows less."""
_LOOSE = 1e-6
"""Tolerance above which large systems are solved to a hundredth by GMRES."""
_ITERATIONS = 40
_BALANCED = 1e-13  # residual at which a step more changes nothing but rounding
_FALLING = 0.1  # factors of a step are used again if it shrinks the residual to less than this
_LEAST_SHARE = 0.01  # shortest step of the line search; shorter ones lead to no solution
_STALLED = 1e-7  # residual with which a stalled line search counts as rounding


class Solution(NamedTuple):
    """Result of Newton's method at one amplitude of a mode."""

    point: ModePoint
    converged: bool
    iterations: int
    answers: list[HarmonicForces]


@dataclass(frozen=True, eq=False)
class ModeEquations:
    """Equations of one nonlinear mode at an amplitude."""

    balance: Balance
    index: int
    """Modal coordinate with prescribed phase."""
    measure: AmplitudeMeasure
    rtol: float = 1e-10
    """Relative size of the last step of Newton's method."""

    def solve(self, guess: ModePoint, amplitude: float) -> Solution:
        """Solve by Newton's method with a line search on the scaled residual.

        The factorised Jacobian is reused while steps reduce the residual tenfold, since a residual
        costs a third of a factorisation. The tolerance of the solution does not depend on it.
        Inexact steps are used until one is too long: with gross slip the remaining hundredth of the
        forces moves joints far, and lets the line search fail where exact steps converge.
        """
        point, converged, iterations, before = guess, False, 0, 0.0
        current = self._residual(point, amplitude)
        factors: Elimination | None = None
        loose = self.rtol > _LOOSE
        inexact = loose and self._unknowns > SMALLEST_INEXACT
        while iterations < _ITERATIONS:
            iterations += 1
            reused = factors is not None
            step, factors = self._newton_step(point, current, factors, inexact)
            if step is None:
                break
            q = np.abs(step.coefficients).max() / np.abs(point.coefficients).max()
            size = max(float(q), abs(step.omega) / point.omega, abs(step.damping))
            share, trial, after = 1.0, point, current
            while share > _LEAST_SHARE:
                trial = ModePoint(
                    point.coefficients - share * step.coefficients,
                    # A frequency does not change sign, however bad a guess was.
                    max(point.omega - share * step.omega, 0.2 * point.omega),
                    point.damping - share * step.damping,
                )
                after = self._tried(trial, amplitude, current)
                small = size < 1e-6 and math.isfinite(after.merit)
                if after.merit < (1.0 - 0.1 * share) * current.merit or small:
                    break
                share *= 0.25
            else:
                if reused or inexact:
                    factors, inexact = None, False
                    continue
                # Nothing better lies that way: either this is rounding, or it is the end.
                converged = current.merit < _STALLED
                break
            inexact = inexact and share == 1.0
            if after.merit > _FALLING * current.merit:
                factors = None
            point, current = trial, after
            # Inexact steps shrink at a steady rate, which gives the size of the next one. They are
            # also short far from a solution where joints move little beside the structure.
            rate = size / before if before and loose else 1.0
            left, before = size * min(max(rate, 0.01), 1.0), size
            near = left < self.rtol and (not loose or after.merit < 0.1 * self.rtol)
            if share == 1.0 and (near or (size < 1e-6 and after.merit < _BALANCED)):
                converged = True
                break
        return Solution(point, converged, iterations, current.answers)

    def unbalanced(self, point: ModePoint, amplitude: float) -> tuple[float, float]:
        """Return relative changes of frequency and damping by a Newton step with more harmonics."""
        basis = self.balance.basis.with_more_harmonics()
        richer = replace(self, balance=replace(self.balance, basis=basis))
        q = np.zeros((self.balance.model.size, basis.size))
        q[:, np.isin(basis.orders, self.balance.basis.orders)] = point.coefficients
        padded = point._replace(coefficients=q)
        step, _ = richer._newton_step(padded, richer._residual(padded, amplitude))
        if step is None:
            return math.nan, math.nan
        damping = -step.damping / max(abs(point.damping), NO_LOSS)
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

    @property
    def _unknowns(self) -> int:
        modes, size = self.balance.shape
        if self.balance.model.damping is None:
            modes = min(modes, self.balance.joints.flat.shape[1])
        return modes * size

    def _tried(self, point: ModePoint, amplitude: float, current: ModeResidual) -> ModeResidual:
        """Return the residual of a trial, infinite if it presses summits beyond their reach."""
        try:
            return self._residual(point, amplitude)
        except InputError:
            return current._replace(merit=math.inf)

    def _newton_step(
        self,
        point: ModePoint,
        current: ModeResidual,
        factors: Elimination | None = None,
        inexact: bool = False,
    ) -> tuple[ModePoint | None, Elimination | None]:
        modes, size = self.balance.shape
        change = None
        if factors is None:
            q, omega, zeta = point
            velocity = self.balance.velocity(q, omega)
            by_omega = self.balance.by_omega(q, omega) - 4.0 * zeta * velocity
            columns = np.stack([by_omega, -2.0 * omega * velocity], axis=-1)
            system = ModeStep(self.balance, self.index, point, current, columns)
            if inexact:
                change = system.iterate(0.01)
            elif self._unknowns > LARGEST_DIRECT:
                change = system.iterate(1e-9 if current.merit < 1e-4 else 1e-4)
            if change is None:
                factors = system.eliminate()
        if factors is not None:
            change = factors.step(current)
        if change is None or not np.isfinite(change).all():
            return None, None
        step = ModePoint(change[:-2].reshape(modes, size), float(change[-2]), float(change[-1]))
        return step, factors
