"""Both ways to a modal curve: the balance of harmonics and the quasi-static one."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.amplitude import AmplitudeMeasure
from microslip.structures.balance import Balance
from microslip.structures.continuation import follow
from microslip.structures.harmonic_basis import HarmonicBasis
from microslip.structures.modal_curve import ModalCurve, locked_curve
from microslip.structures.modal_model import ModalModel
from microslip.structures.nonlinear_mode import ModeEquations
from microslip.structures.quasi_static import QuasiStatic


def balanced_curve(
    model: ModalModel,
    index: int,
    amplitudes: Floats,
    measure: AmplitudeMeasure,
    basis: HarmonicBasis,
    base_damping: float,
    other: Callable[[], ModalCurve],
) -> ModalCurve:
    """By the balance of harmonics, with continuation."""
    joints = model.joints(_own(model, index))
    balance = Balance(model, joints, basis)
    followed = follow(ModeEquations(balance, index, measure), amplitudes)
    rows = _Rows(model, amplitudes.size, sum(g.stuck.shape[0] for g in joints.groups))
    for i, solution in enumerate(followed.solutions):
        if solution is None:
            continue
        q, omega, zeta = solution.point
        modal = math.sqrt(float(np.sum(q[:, 1:3] ** 2)))
        motions = joints.split(joints.flat.T @ q)
        loss = [
            np.asarray(basis.work(answer.force, motion).sum(axis=1))
            for answer, motion in zip(solution.answers, motions, strict=True)
        ]
        shape = model.shapes @ (q[:, 1] - 1j * q[:, 2]) / modal
        rows.put(i, modal, omega, zeta + base_damping, shape, loss)
    if followed.stopped_at is None:
        message = f"solved in {followed.iterations} iterations and {followed.steps} steps"
    else:
        message = (
            f"stopped beyond the amplitude {followed.stopped_at:.4g}: the balance of harmonics did "
            f"not converge in steps of 1 %, after {followed.iterations} iterations; try more "
            "samples, fewer harmonics, or amplitudes that end there (the mode may meet another "
            "one, or all joints may slide)"
        )
    return rows.curve(
        "harmonic-balance", index, amplitudes, base_damping, followed.iterations, message, other
    )


def quasi_static_curve(
    model: ModalModel,
    index: int,
    amplitudes: Floats,
    measure: AmplitudeMeasure,
    base_damping: float,
    other: Callable[[], ModalCurve],
) -> ModalCurve:
    """By quasi-static modal analysis."""
    joints = model.joints(_own(model, index))
    solver = QuasiStatic(model, joints, index, measure)
    points = solver.curve(amplitudes)
    rows = _Rows(model, amplitudes.size, sum(g.stuck.shape[0] for g in joints.groups))
    reached = [(i, point) for i, point in enumerate(points) if point is not None]
    if reached:
        dampings, energies = solver.losses([point for _, point in reached])
        for (i, point), damping, energy in zip(reached, dampings, energies, strict=True):
            shape = model.shapes @ point.shape / point.modal_amplitude
            rows.put(
                i,
                point.modal_amplitude,
                point.omega,
                float(damping) + base_damping,
                shape,
                [energy],
            )
    solved = [float(a) for a, p in zip(amplitudes, points, strict=True) if p is not None]
    if len(solved) == amplitudes.size:
        message = f"solved in {solver.iterations} iterations"
    else:
        where = f"beyond the amplitude {max(solved):.4g}" if solved else "at the first amplitude"
        message = (
            f"stopped {where}: the static deflection along the mode was not found; all joints may "
            'slide there, which method="harmonic-balance" follows further'
        )
    return rows.curve(
        "quasi-static", index, amplitudes, base_damping, solver.iterations, message, other
    )


def _own(model: ModalModel, index: int) -> Floats:
    """The mode of sticking joints, in its own coordinates."""
    result = np.zeros(model.size)
    result[index] = 1.0
    return result


class _Rows:
    """The numbers of a curve as they come."""

    def __init__(self, model: ModalModel, count: int, joints: int) -> None:
        self._model = model
        self.modal, self.frequency, self.damping = np.full((3, count), np.nan)
        self.shape = np.full((count, model.shapes.shape[0]), np.nan, dtype=complex)
        self.loss = np.full((count, joints), np.nan)

    def put(
        self,
        i: int,
        modal: float,
        omega: float,
        damping: float,
        shape: np.ndarray,
        loss: list[Floats],
    ) -> None:
        self.modal[i], self.frequency[i], self.damping[i] = modal, omega / (2 * math.pi), damping
        self.shape[i] = shape
        self.loss[i] = np.concatenate([*loss, np.zeros(0)])

    def curve(
        self,
        method: str,
        index: int,
        amplitudes: Floats,
        base_damping: float,
        iterations: int,
        message: str,
        other: Callable[[], ModalCurve],
    ) -> ModalCurve:
        return locked_curve(
            method=method,
            index=index,
            amplitude=amplitudes.copy(),
            modal_amplitude=self.modal,
            frequency=self.frequency,
            damping_ratio=self.damping,
            shape=self.shape,
            loss=self.loss,
            linear_frequency=math.sqrt(float(self._model.squares[index])) / (2.0 * math.pi),
            base_damping=base_damping,
            converged=np.isfinite(self.frequency),
            iterations=iterations,
            message=message,
            _other=other,
        )
