"""Time integration in the modal coordinates of the structure with sticking joints.

By the generalised-alpha method (Chung and Hulbert 1993, DOI 10.1115/1.2900803), or with exact
integration of the linear part if all joints are backbone laws, which never open.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip.structures.joint_groups import JointState, LawGroup
from microslip.structures.modal_model import ModalJoints, ModalModel

_ITERATIONS = 30
_LAST_CHANGE = 1e-12  # of the largest joint motion so far, for the last step of Newton's method


class TimeSteps:
    """Integrator of the modal coordinates and of the states of the joints.

    The linear equations, with joints as springs of their stiffness at rest, are factorised once.
    Each step solves for the joint motions alone by Newton's method and then commits the joint
    states. The equations are normalised to unit modal mass. The name ``short`` denotes *slip
    forces* [N]: joint forces minus those of sticking joints.
    """

    def __init__(self, model: ModalModel, joints: ModalJoints, step: float, radius: float) -> None:
        self._joints, self._step = joints, step
        rigid = model.free.shape[1]
        self.squares = np.concatenate([model.squares, np.zeros(rigid)])
        self._directions = np.concatenate([joints.flat, np.zeros((rigid, joints.flat.shape[1]))])
        self.damping = np.zeros((self.squares.size, self.squares.size))
        if model.damping is not None:
            self.damping[: model.size, : model.size] = model.damping
        self._damped = model.damping is not None
        # Alpha_m, alpha_f, beta and gamma for the spectral radius at high frequency.
        alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
        beta, gamma = 0.25 * (1.0 - alpha_m + alpha_f) ** 2, 0.5 - alpha_m + alpha_f
        self._c = alpha_m, alpha_f, beta, gamma
        diagonal = (1.0 - alpha_m) / (beta * step**2) + (1.0 - alpha_f) * self.squares
        matrix = np.diag(diagonal)
        matrix += (1.0 - alpha_f) * gamma / (beta * step) * self.damping
        self._inverse = np.linalg.inv(matrix) if self._damped else None
        self._weights = 1.0 / diagonal
        self._pull = (1.0 - alpha_f) * self._solve(self._directions)
        self._flexibility = self._directions.T @ self._pull
        self._states: list[JointState] = [group.start() for group in joints.groups]
        self._identity = np.eye(joints.stuck.size)
        self.short = np.zeros(joints.stuck.size)
        """Joint forces minus those of sticking joints [N]."""
        self.motion = np.zeros(joints.stuck.size)
        """Motions of the joints [m]."""
        self._largest = 0.0
        self._before = self._lost()

    def _lost(self) -> Floats:
        return np.concatenate([state.lost for state in self._states] or [np.zeros(0)])

    @property
    def lost(self) -> Floats:
        """Energy dissipated by each joint of all groups since the static state (joints,) [J]."""
        return self._lost() - self._before

    def _solve(self, right: Floats) -> Floats:
        if self._inverse is None:
            return np.asarray((self._weights * right.T).T)
        return np.asarray(self._inverse @ right)

    def try_joints(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return the slip forces of the joints and their tangents at a joint motion.

        ``motion`` [m] and forces [N] have the shape (coordinates,), tangents [N/m] (coordinates,
        coordinates). The committed states of the joints do not change.
        """
        force, slopes = self._joints.answers(motion, [state.try_ for state in self._states])
        return force - self._joints.stuck * motion, self._joints.tangent_matrix(slopes)

    def commit(self, motion: Floats, short: Floats) -> None:
        """Accept the last trial; store its joint ``motion`` [m] and slip forces ``short`` [N]."""
        for state in self._states:
            state.commit()
        self.motion, self.short = motion, short
        self._largest = max(self._largest, float(np.abs(motion).max(initial=0.0)))

    def _find(
        self, aim: Floats, motion: Floats, correction: Callable[[Floats, Floats, Floats], Floats]
    ) -> bool:
        """Solve for the joint motion by Newton's method and commit it; return False if it fails.

        ``correction`` returns the Newton step [m] from motion, slip forces and tangents; ``motion``
        is the initial guess [m]. The tolerance is relative to ``aim``, the motion without slip, or
        to the largest motion so far.
        """
        size = max(self._largest, float(np.abs(aim).max(initial=0.0)), 1e-300)
        moved = np.inf
        for _ in range(_ITERATIONS):
            try:
                short, tangent = self.try_joints(motion)
            except InputError:  # far beyond what the law knows
                return False
            change = correction(motion, short, tangent)
            last, moved = moved, float(np.abs(change).max(initial=0.0))
            if moved <= _LAST_CHANGE * size or (moved <= 1e-9 * size and moved >= last):
                self.commit(motion, short)
                return True
            motion = motion - change
        return False

    def begin(self, q: Floats, v: Floats) -> None:
        """Load the joints straight from rest to the modal displacements ``q``, and commit.

        Methods that need the initial velocities ``v`` (modes,) store them.
        """
        motion = self._directions.T @ q
        self.commit(motion, self.try_joints(motion)[0])

    def acceleration(self, q: Floats, v: Floats, force: Floats, short: Floats) -> Floats:
        """Return modal accelerations from the equation of motion, (modes,) or (times, modes)."""
        return np.asarray(
            force - v @ self.damping.T - self.squares * q - short @ self._directions.T
        )

    def advance(
        self, q: Floats, v: Floats, a: Floats, before: Floats, after: Floats
    ) -> tuple[Floats, Floats, Floats] | None:
        """Return displacement, velocity and acceleration after a step.

        Return None if Newton's method did not converge. ``before`` and ``after`` are the modal
        forces at the beginning and at the end of the step.
        """
        (alpha_m, alpha_f, beta, gamma), h = self._c, self._step
        drift = q + h * v + h * h * (0.5 - beta) * a  # displacement without the new acceleration
        speed = v + h * (1.0 - gamma) * a
        right = (1.0 - alpha_f) * after + alpha_f * before - alpha_m * a
        right += (1.0 - alpha_m) / (beta * h * h) * drift - alpha_f * (
            self.squares * q + self._directions @ self.short
        )
        if self._damped:
            predicted = speed - gamma / (beta * h) * drift
            right -= self.damping @ ((1.0 - alpha_f) * predicted + alpha_f * v)
        linear = self._solve(right)
        aim = self._directions.T @ linear

        def correction(motion: Floats, short: Floats, tangent: Floats) -> Floats:
            miss = motion - aim + self._flexibility @ short
            return np.asarray(np.linalg.solve(self._identity + self._flexibility @ tangent, miss))

        if not self._find(aim, aim - self._flexibility @ self.short, correction):
            return None
        new = linear - self._pull @ self.short
        acceleration = (new - drift) / (beta * h * h)
        return new, speed + h * gamma * acceleration, acceleration


def are_exact(model: ModalModel, joints: ModalJoints) -> bool:
    """Return whether exact integration applies: only backbone laws, and diagonal modal damping."""
    damping = np.zeros((1, 1)) if model.damping is None else np.asarray(model.damping)
    coupling = np.abs(damping - np.diag(np.diag(damping))).max(initial=0.0)
    laws = all(isinstance(group, LawGroup) for group in joints.groups)
    return laws and bool(coupling <= 1e-9 * np.abs(damping).max(initial=0.0))


class ExactSteps(TimeSteps):
    """Exact integration of each mode under modal forces that are cubic in time over a step.

    The (Hermite) cubic has, at both ends of the step, the values and rates of the joint forces
    minus those of sticking joints, as in :meth:`microslip.Oscillator.ring_down`. A turning point
    inside a step lowers the order. After Hochbruck and Ostermann (2010),
    DOI 10.1017/S0962492910000048.
    """

    def __init__(self, model: ModalModel, joints: ModalJoints, step: float, force: Floats) -> None:
        from scipy.interpolate import Akima1DInterpolator
        from scipy.linalg import expm

        super().__init__(model, joints, step, 1.0)
        # Of [q, step v, four powers of a modal force] over one step.
        flow = np.zeros((self.squares.size, 6, 6))
        flow[:, 0, 1] = 1.0
        flow[:, 1, 0] = -self.squares * step**2
        flow[:, 1, 1] = -np.diag(self.damping) * step
        flow[:, 1, 2] = step**2
        flow[:, 2, 3] = flow[:, 3, 4] = flow[:, 4, 5] = 1.0
        answer = expm(flow)[:, :2]
        _, _, p2, p3, p4, p5 = np.moveaxis(answer, 2, 0)
        self._free = answer[:, :, :2]
        # By the force and its rate times the step, at the beginning and at the end.
        self._cubic = np.stack(
            [p2 - 6.0 * p4 + 12.0 * p5, p3 - 4.0 * p4 + 6.0 * p5, 6.0 * p4 - 12.0 * p5,
             6.0 * p5 - 2.0 * p4], axis=2,
        )  # fmt: skip
        lines = self._directions
        self._by_force, self._by_rate = (
            np.einsum("mj,mi,mk->ijk", lines, self._cubic[:, :, end], lines) for end in (2, 3)
        )
        rates = np.zeros_like(force)
        if len(force) > 2 and np.any(force):
            at = np.arange(float(len(force)))
            rates = Akima1DInterpolator(at, force).derivative()(at)
        self._rates, self._row = rates, 0
        self._rate = np.zeros(joints.stuck.size)  # of the joints' forces, times the step

    def begin(self, q: Floats, v: Floats) -> None:
        """Load the joints as :meth:`TimeSteps.begin`; store the initial rates of slip forces."""
        super().begin(q, v)
        self._rate = self._step * (self.try_joints(self.motion)[1] @ (self._directions.T @ v))

    def advance(
        self, q: Floats, v: Floats, a: Floats, before: Floats, after: Floats
    ) -> tuple[Floats, Floats, Floats] | None:
        """Return displacement, velocity and (unused) acceleration, as :meth:`TimeSteps.advance`."""
        lines, row = self._directions, self._row
        self._row += 1
        known = np.stack(
            [before - lines @ self.short, self._rates[row] - lines @ self._rate, after,
             self._rates[row + 1]], axis=1,
        )  # fmt: skip
        place, speed = np.einsum("mij,mj->im", self._free, np.stack([q, self._step * v], axis=1))
        pushed = np.einsum("mij,mj->im", self._cubic, known)
        place, speed = place + pushed[0], speed + pushed[1]
        aim, pace = lines.T @ place, lines.T @ speed
        start = aim - self._by_force[0] @ self.short - self._by_rate[0] @ self._rate

        def correction(motion: Floats, short: Floats, tangent: Floats) -> Floats:
            turn = pace - self._by_force[1] @ short
            rate = tangent @ np.linalg.solve(self._identity + self._by_rate[1] @ tangent, turn)
            miss = motion - aim + self._by_force[0] @ short + self._by_rate[0] @ rate
            self._rate = rate
            return np.asarray(np.linalg.solve(self._identity + self._by_force[0] @ tangent, miss))

        if not self._find(aim, start, correction):
            return None
        ends = np.stack([lines @ self.short, lines @ self._rate], axis=1)
        short_of_sticking = np.einsum("mij,mj->im", self._cubic[:, :, 2:], ends)
        return place - short_of_sticking[0], (speed - short_of_sticking[1]) / self._step, a
