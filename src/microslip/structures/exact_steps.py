"""Time steps with an exact linear part, for joints that follow laws and never open."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.joint_groups import LawGroup
from microslip.structures.modal_model import ModalJoints, ModalModel
from microslip.structures.time_steps import TimeSteps


def are_exact(model: ModalModel, joints: ModalJoints) -> bool:
    """Whether all joints are laws along directions, and the damping leaves modes apart."""
    damping = np.zeros((1, 1)) if model.damping is None else np.asarray(model.damping)
    coupling = np.abs(damping - np.diag(np.diag(damping))).max(initial=0.0)
    laws = all(isinstance(group, LawGroup) for group in joints.groups)
    return laws and bool(coupling <= 1e-9 * np.abs(damping).max(initial=0.0))


class ExactSteps(TimeSteps):
    """The modes as they swing by themselves, under forces that are cubics in time over a step.

    What joints give less than sticking ones, and its rate, is matched at both ends (Hermite's
    cubic), as :meth:`microslip.Oscillator.ring_down` does; a turning point inside a step costs the
    third order. After Hochbruck and Ostermann (2010), DOI 10.1017/S0962492910000048.
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

    def begin(self, v: Floats) -> None:
        """Rates of the joints' forces at the start."""
        self._rate = self._step * (self.try_joints(self.motion)[1] @ (self._directions.T @ v))

    def advance(
        self, q: Floats, v: Floats, a: Floats, before: Floats, after: Floats
    ) -> tuple[Floats, Floats, Floats] | None:
        """One step under modal forces; None where Newton's method does not converge."""
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
