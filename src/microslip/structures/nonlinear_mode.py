"""One point of a nonlinear mode: Newton's method on the balance of harmonics at an amplitude."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.amplitude import AmplitudeMeasure
from microslip.structures.balance import Balance
from microslip.structures.contact_elimination import Bordered, solve
from microslip.structures.gmres import gmres
from microslip.structures.joint_groups import HarmonicForces

LARGEST_DIRECT = 900
"""Unknowns up to which the equations are solved by elimination, beyond by GMRES."""
_ITERATIONS = 40
_STEP = 1e-10  # relative size of the last step of Newton's method
_STALLED = 1e-7  # residual with which a stalled line search counts as rounding


class ModePoint(NamedTuple):
    """A periodic motion of a nonlinear mode."""

    coefficients: Floats
    """Of the modal coordinates, (modes, size)."""
    omega: float
    damping: float


class Solution(NamedTuple):
    """What Newton's method came to."""

    point: ModePoint
    converged: bool
    iterations: int
    residual: float
    """Of the equations, each beside the largest force in it [-]."""
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
            if share == 1.0 and size < _STEP:
                converged = True
                break
        return Solution(point, converged, iterations, current.merit, current.answers)

    def _residual(self, point: ModePoint, amplitude: float) -> _Residual:
        balance = self.balance
        q, omega, zeta = point
        joint_forces, answers = balance.joint_forces(q)
        forces = balance.linear(q, omega, -2.0 * zeta * omega) + joint_forces
        measured, by_q, by_omega = self.measure.square(q, omega)
        border = np.array([measured / amplitude**2 - 1.0, q[self.index, 2]])
        size = math.sqrt(float(np.sum(q[:, 1:3] ** 2)))
        scale = np.maximum(balance.model.squares, omega**2)[:, None] * size
        merit = math.sqrt(float(np.sum((forces / scale) ** 2)) + border[0] ** 2)
        return _Residual(
            forces, border, merit, answers, by_q / amplitude**2, by_omega / amplitude**2
        )

    def _newton_step(
        self, point: ModePoint, amplitude: float, current: _Residual
    ) -> ModePoint | None:
        modes, size = self.balance.shape
        q, omega, zeta = point
        velocity = self.balance.velocity(q, omega)
        by_omega = self.balance.by_omega(q, omega) - 4.0 * zeta * velocity
        columns = np.stack([by_omega, -2.0 * omega * velocity], axis=-1)
        system = _Bordered(self.balance, self.index, point, current, columns)
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


class _Residual(NamedTuple):
    forces: Floats
    border: Floats
    """Amplitude and phase."""
    merit: float
    answers: list[HarmonicForces]
    by_q: Floats
    """Derivatives of the amplitude's equation."""
    by_omega: float


@dataclass(frozen=True, eq=False)
class _Bordered:
    """The linear system of a step of Newton's method."""

    balance: Balance
    index: int
    point: ModePoint
    current: _Residual
    columns: Floats
    """Derivatives of the forces by omega and zeta, (modes, size, 2)."""

    @property
    def _damping(self) -> float:
        return -2.0 * self.point.damping * self.point.omega

    @property
    def _scale(self) -> Floats:
        """Of the rows: forces of very different modes, compared by the motion they mean."""
        return np.maximum(self.balance.model.squares, self.point.omega**2)[:, None]

    def _right(self, unit: float) -> np.ndarray:
        """Forces and borders of the point, scaled."""
        forces = (self.current.forces / self._scale).reshape(-1) / unit
        return np.append(forces, [self.current.border[0], self.current.border[1] / unit])

    def eliminate(self) -> Floats | None:
        """By Gauss's elimination, of the joints that do not stick alone where that will do."""
        modes, size = self.balance.shape
        if self.balance.model.damping is None:
            return self._by_joints()
        count = modes * size
        matrix = np.zeros((count + 2, count + 2))
        inner = self.balance.linear_matrix(self.point.omega, self._damping)
        inner += self.balance.tangent_matrix(self.current.answers)
        q = self.point.coefficients
        unit = float(np.abs(q).max())
        scale = self._scale
        matrix[:count, :count] = (inner / scale[:, :, None, None]).reshape(count, count) * unit
        omega = self.point.omega
        matrix[:count, -2] = (self.columns[..., 0] / scale).reshape(-1) * omega
        matrix[:count, -1] = (self.columns[..., 1] / scale).reshape(-1)
        matrix[:count] /= unit
        matrix[-2, :count] = self.current.by_q.reshape(-1) * unit
        matrix[-2, -2] = self.current.by_omega * omega
        matrix[-1, self.index * size + 2] = 1.0
        try:
            step = np.linalg.solve(matrix, self._right(unit))
        except np.linalg.LinAlgError:
            return None
        step[:count] *= unit
        step[-2] *= omega
        return step

    def _by_joints(self) -> Floats | None:
        phase = np.zeros(self.balance.shape)
        phase[self.index, 2] = 1.0
        system = Bordered(
            self.columns,
            np.stack([self.current.by_q, phase]),
            np.array([[self.current.by_omega, 0.0], [0.0, 0.0]]),
            self.current.forces,
            self.current.border,
        )
        answers = self.current.answers
        step = solve(self.balance, answers, self.point.omega, self._damping, system)
        return None if step is None else np.append(step[0].reshape(-1), step[1])

    def iterate(self) -> Floats | None:
        """By GMRES, preconditioned with the structure whose joints stick."""
        modes, size = self.balance.shape
        count = modes * size
        unit = float(np.abs(self.point.coefficients).max())
        omega = self.point.omega
        scale = self._scale
        solve = self._preconditioner(unit)

        def product(y: Floats) -> Floats:
            x = solve(y)
            change = x[:count].reshape(modes, size)
            forces = self.balance.linear(change, omega, self._damping)
            forces += self.balance.tangent(self.current.answers, change)
            forces /= unit
            forces += self.columns[..., 0] * (x[-2] * omega / unit)
            forces += self.columns[..., 1] * (x[-1] / unit)
            border = [
                float(np.sum(self.current.by_q * change)) + self.current.by_omega * x[-2] * omega,
                change[self.index, 2] / unit,
            ]
            return np.append((forces / scale).reshape(-1), border)

        y = gmres(product, self._right(unit), 1e-9 if self.current.merit < 1e-4 else 1e-4, 160)
        if y is None:
            return None
        step = solve(y)
        step[-2] *= omega
        return step

    def _preconditioner(self, unit: float) -> Callable[[Floats], Floats]:
        """Solves with sticking joints; the mode's own four unknowns with their joint forces."""
        modes, size = self.balance.shape
        count, i = modes * size, self.index
        omega, scale = self.point.omega, self._scale
        orders = self.balance.basis.orders
        square = (self.balance.model.squares[:, None] - (orders * omega) ** 2) / scale
        damping: Floats | float = self._damping
        if self.balance.model.damping is not None:
            damping = damping + self.balance.model.damping.diagonal()[:, None]
        rate = np.broadcast_to(orders * omega * damping / scale, square.shape)
        weight = 1.0 / np.maximum(square**2 + rate**2, 1e-8)
        cosine, sine = np.arange(1, size, 2), np.arange(2, size, 2)
        core = np.zeros((4, 4))
        for column in range(2):
            change = np.zeros((modes, size))
            change[i, 1 + column] = 1.0
            forces = self.balance.linear(change, omega, self._damping)
            forces += self.balance.tangent(self.current.answers, change)
            core[:2, column] = forces[i, 1:3] / scale[i]
        core[:2, 2] = self.columns[i, 1:3, 0] * omega / unit / scale[i]
        core[:2, 3] = self.columns[i, 1:3, 1] / unit / scale[i]
        core[2, :2] = self.current.by_q[i, 1:3] * unit
        core[2, 2] = self.current.by_omega * omega
        core[3, 1] = 1.0
        inverse = np.linalg.pinv(core)

        def solve(y: Floats) -> Floats:
            forces = y[:count].reshape(modes, size) * unit
            x = np.empty_like(forces)
            x[:, 0] = forces[:, 0] / square[:, 0]
            a, b, w = square[:, cosine], rate[:, cosine], weight[:, cosine]
            x[:, cosine] = w * (a * forces[:, cosine] - b * forces[:, sine])
            x[:, sine] = w * (b * forces[:, cosine] + a * forces[:, sine])
            # Scaled as the unknowns are: motion by its unit, frequency by itself.
            four = inverse @ np.array([y[i * size + 1], y[i * size + 2], y[-2], y[-1]])
            x[i, 1:3] = four[:2] * unit
            return np.append(x.reshape(-1), four[2:])

        return solve
