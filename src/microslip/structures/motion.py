"""A motion in time of a structure with joints, and where its energy goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, number, record
from microslip._core.frozen import LockedArrays
from microslip.errors import InputError
from microslip.report.plot import Plot
from microslip.report.plottable import PlottableAtSensor
from microslip.structures.assembled_faces import AssembledGroup, AssembledState
from microslip.structures.joint_groups import JointState
from microslip.structures.matrices import vector
from microslip.structures.modal_model import ModalJoints, ModalModel

_ITERATIONS = 30
_STEP = 1e-12  # of the largest joint motion so far, for the last step of Newton's method


@dataclass(frozen=True, eq=False, repr=False)
class Motion(LockedArrays, PlottableAtSensor):
    """A motion in time; made by ``structure.integrate(...)``. Displacements count from rest.

    By the generalised-alpha method (Chung and Hulbert 1993, DOI 10.1115/1.2900803).
    """

    time: Floats
    """Times [s]; fewer than asked for where the method stopped."""
    displacement: Floats
    """(times, n) [m]."""
    velocity: Floats
    """(times, n) [m/s]."""
    joint_motion: Floats
    """Relative motions of the joints, (times, coordinates) [m]."""
    joint_force: Floats
    """Forces of the joints beyond those at rest, (times, coordinates) [N]."""
    work: Floats
    """Work of the forces up to each time, with the energy of the start [J]."""
    kinetic_energy: Floats
    """[J]."""
    elastic_energy: Floats
    """Of the structure without its joints [J]."""
    joint_energy: Floats
    """What went into the joints, stored or lost: the work of their forces [J]."""
    joint_loss: Floats
    """What of it friction has lost, by joint or node, (times, joints) [J]; it never falls."""
    viscous_energy: Floats
    """Lost by the damping matrix [J]."""
    message: str
    """What came of it; where and why it stopped, and what to try."""
    _with_steps: Callable[[int], Floats] | None = None

    @cached_property
    def step_error(self) -> float:
        """Largest error of a displacement for the length of the steps, over the largest one [-].

        By the motion in steps twice and four times as long (Richardson 1911, DOI
        10.1098/rsta.1911.0009), of whatever order these show; solved when first asked for, which
        takes three quarters of the time again. Unlike :attr:`energy_error` it sees what each impact
        shifts. Where the three do not approach each other it is their difference, and no bound:
        take shorter steps.
        """
        if self._with_steps is None:
            raise InputError("step_error is not kept in a motion that was read or copied")
        size = float(np.abs(self.displacement).max(initial=0.0))
        if not size:
            return 0.0
        coarser, coarsest = self._with_steps(2), self._with_steps(4)
        moved, before = (
            float(np.abs(a[: len(b)] - b[: len(a)]).max()) / size
            for a, b in ((self.displacement[::2], coarser), (coarser[::2], coarsest))
        )
        ratio = min(before / moved, 4.0) if moved else 4.0  # of a method of second order
        return moved / (ratio - 1.0) if ratio > 1.5 else 2.0 * max(moved, before)

    @property
    def dissipated_energy(self) -> Floats:
        """Lost up to each time, by friction and by the damping matrix [J]."""
        return np.asarray(self.joint_loss.sum(axis=1) + self.viscous_energy)

    @property
    def stored_energy(self) -> Floats:
        """Elastic energy of the structure and in its joints, counted from rest [J].

        With it work = kinetic + stored + dissipated, to the error of the steps.
        """
        stored = self.joint_energy - self.joint_loss.sum(axis=1)
        return np.asarray(self.elastic_energy + stored)

    @property
    def energy_error(self) -> float:
        """Largest gap in work = kinetic + elastic + joints + viscous, over the largest of them [-].

        Of second order in the length of the steps. It says that no energy is lost on the way, not
        that the motion is right: where faces meet and part, :attr:`step_error` does.
        """
        parts = (self.kinetic_energy, self.elastic_energy, self.joint_energy, self.viscous_energy)
        largest = max(float(np.abs(part).max()) for part in (*parts, self.work))
        gap = float(np.abs(self.work - np.sum(parts, axis=0)).max())
        return gap / largest if largest else 0.0

    @property
    def status(self) -> str:
        """``solved``, or ``stopped`` before the last time."""
        return "solved" if self.message.startswith("solved") else "stopped"

    def _figure(self, at: int | None) -> Plot:
        from microslip.structures.figures import motion_figure

        return motion_figure(self, at)

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_with_steps": None}

    def __repr__(self) -> str:
        return f"Motion({self.time.size} times to {self.time[-1]:g} s, {self.message})"


class Coefficients(NamedTuple):
    """Of the method, by the spectral radius at high frequencies."""

    mass: float
    force: float
    beta: float
    gamma: float

    @classmethod
    def of(cls, radius: float) -> Coefficients:
        """Second order for every radius; 1 loses nothing, 0 what is fast in one step."""
        mass, force = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
        return cls(mass, force, 0.25 * (1.0 - mass + force) ** 2, 0.5 - mass + force)


class TimeSteps:
    """Modal coordinates, elastic and rigid, from step to step; joints commit at each.

    In the modes of the sticking joints the linear part is solved once and for all; each step
    iterates on the joints' motions alone.
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
        self._c = c = Coefficients.of(radius)
        diagonal = (1.0 - c.mass) / (c.beta * step**2) + (1.0 - c.force) * self.squares
        matrix = np.diag(diagonal)
        matrix += (1.0 - c.force) * c.gamma / (c.beta * step) * self.damping
        self._inverse = np.linalg.inv(matrix) if self._damped else None
        self._weights = 1.0 / diagonal
        self._pull = (1.0 - c.force) * self._solve(self._directions)
        self._flexibility = self._directions.T @ self._pull
        self._states: list[JointState | AssembledState] = [
            group.resumed() if isinstance(group, AssembledGroup) else group.start()
            for group in joints.groups
        ]
        self._identity = np.eye(joints.stuck.size)
        self.short = np.zeros(joints.stuck.size)
        """Joint forces beyond those of sticking joints [N]."""
        self.motion = np.zeros(joints.stuck.size)
        """Motions of the joints [m]."""
        self._largest = 0.0
        self._before = self._lost()

    def _lost(self) -> Floats:
        return np.concatenate([state.lost for state in self._states] or [np.zeros(0)])

    @property
    def lost(self) -> Floats:
        """Energies that the joints have lost since the static state [J], all groups in a row."""
        return self._lost() - self._before

    def _solve(self, right: Floats) -> Floats:
        if self._inverse is None:
            return np.asarray((self._weights * right.T).T)
        return np.asarray(self._inverse @ right)

    def try_joints(self, motion: Floats) -> tuple[Floats, Floats]:
        """Forces beyond sticking and their tangents, (coordinates, coordinates)."""
        force, slopes = self._joints.answers(motion, [state.try_ for state in self._states])
        return force - self._joints.stuck * motion, self._joints.tangent_matrix(slopes)

    def commit(self, motion: Floats, short: Floats) -> None:
        """Make the last trial of the joints their state."""
        for state in self._states:
            state.commit()
        self.motion, self.short = motion, short
        self._largest = max(self._largest, float(np.abs(motion).max(initial=0.0)))

    def place(self, q: Floats) -> None:
        """Load the joints along a straight path from rest."""
        motion = self._directions.T @ q
        self.commit(motion, self.try_joints(motion)[0])

    def acceleration(self, q: Floats, v: Floats, force: Floats) -> Floats:
        """Of the state as it is."""
        return np.asarray(
            force - self.damping @ v - self.squares * q - self._directions @ self.short
        )

    def advance(
        self, q: Floats, v: Floats, a: Floats, before: Floats, after: Floats
    ) -> tuple[Floats, Floats, Floats] | None:
        """One step under modal forces; None where Newton's method does not converge."""
        c, h = self._c, self._step
        drift = q + h * v + h * h * (0.5 - c.beta) * a  # displacement without the new acceleration
        speed = v + h * (1.0 - c.gamma) * a
        right = (1.0 - c.force) * after + c.force * before - c.mass * a
        right += (1.0 - c.mass) / (c.beta * h * h) * drift - c.force * (
            self.squares * q + self._directions @ self.short
        )
        if self._damped:
            predicted = speed - c.gamma / (c.beta * h) * drift
            right -= self.damping @ ((1.0 - c.force) * predicted + c.force * v)
        linear = self._solve(right)
        aim = self._directions.T @ linear
        motion = aim - self._flexibility @ self.short
        size = max(self._largest, float(np.abs(aim).max(initial=0.0)), 1e-300)
        moved = np.inf
        for _ in range(_ITERATIONS):
            try:
                short, tangent = self.try_joints(motion)
            except InputError:  # far beyond what the law knows
                return None
            miss = motion - aim + self._flexibility @ short
            change = np.linalg.solve(self._identity + self._flexibility @ tangent, miss)
            last, moved = moved, float(np.abs(change).max(initial=0.0))
            if moved <= _STEP * size or (moved <= 1e-9 * size and moved >= last):
                break
            motion = motion - change
        else:
            return None
        self.commit(motion, short)
        new = linear - self._pull @ short
        acceleration = (new - drift) / (c.beta * h * h)
        return new, speed + h * c.gamma * acceleration, acceleration


def integrate(
    model: ModalModel,
    mass: Any,
    stiffness: Any,
    force: Any,
    time: ArrayLike,
    displacement: ArrayLike | None,
    velocity: ArrayLike | None,
    radius: float,
) -> Motion:
    """See :meth:`microslip.Preload.integrate`."""
    times = np.atleast_1d(record("time", time))
    size = model.shapes.shape[0]
    steps = np.diff(times)
    if times.size < 2 or steps.min() <= 0.0 or np.ptp(steps) > 1e-6 * steps.mean():
        raise InputError(
            "time must hold at least two rising times in even steps, such as "
            "np.linspace(0.0, 0.1, 10001)"
        )
    radius = number("spectral_radius", radius)
    if not 0.0 <= radius <= 1.0:
        raise InputError(f"spectral_radius must be from 0 to 1, got {exact(radius)}")
    forces = _forces(force, times, size)
    start, speed = (
        np.zeros(size) if value is None else vector(name, value, size)
        for name, value in (("displacement", displacement), ("velocity", velocity))
    )
    shapes = np.concatenate([model.shapes, model.free], axis=1)
    modal_force = forces @ shapes
    to_modal = np.asarray((mass @ shapes).T)
    q, v = to_modal @ start, to_modal @ speed
    joints = model.joints(_line(model, q, v, modal_force))
    stepper = TimeSteps(model, joints, float(steps.mean()), radius)
    stepper.place(q)
    a = stepper.acceleration(q, v, modal_force[0])
    count = times.size
    rows = [np.empty((count, width)) for width in (q.size, q.size, stepper.motion.size)]
    rows.append(np.empty_like(rows[2]))
    rows.append(np.empty((count, stepper.lost.size)))
    reached = 0
    for i in range(count):
        if i:
            moved = stepper.advance(q, v, a, modal_force[i - 1], modal_force[i])
            if moved is None:
                break
            q, v, a = moved
        total = stepper.short + joints.stuck * stepper.motion
        for row, value in zip(rows, (q, v, stepper.motion, total, stepper.lost), strict=True):
            row[i] = value
        reached = i + 1
    message = f"solved in {count - 1} steps"
    if reached < count:
        message = (
            f"stopped at {times[reached - 1]:.6g} s: the joints' motion in the next step was not "
            "found; try shorter steps"
        )
    modal, speeds, motion, pull, lost = (row[:reached] for row in rows)
    x, speed = modal @ shapes.T, speeds @ shapes.T
    kinetic = 0.5 * np.sum(speeds**2, axis=1)
    elastic = 0.5 * np.sum(x * np.asarray(stiffness @ x.T).T, axis=1)
    beginning = motion[0] if motion.size else np.zeros(0)
    joint = _work(pull, motion) + 0.5 * float(pull[0] @ beginning)
    viscous = _work(speeds @ stepper.damping, modal)
    work = _work(forces[:reached], x) + kinetic[0] + elastic[0] + joint[0]

    def with_steps(factor: int) -> Floats:
        """Displacements in steps so many times as long."""
        rows = slice(0, reached, factor)
        arguments = (
            model,
            mass,
            stiffness,
            forces[rows],
            times[rows],
            displacement,
            velocity,
            radius,
        )
        return integrate(*arguments).displacement if len(times[rows]) > 1 else x[:1]

    return Motion(
        times[:reached], x, speed, motion, pull, work, kinetic, elastic, joint, lost, viscous,
        message, with_steps,
    )  # fmt: skip


def _work(force: Floats, path: Floats) -> Floats:
    """Work of a force along a path up to each time, by the trapezoidal rule."""
    means = 0.5 * (force[1:] + force[:-1])
    return np.append(0.0, np.cumsum(np.sum(means * np.diff(path, axis=0), axis=1)))


def _line(model: ModalModel, q: Floats, v: Floats, force: Floats) -> Floats:
    """A motion along which the joints will move most: that of the start, or of the force."""
    elastic = slice(0, model.size)
    if q[elastic].any():
        return q[elastic]
    if v[elastic].any():
        return np.asarray(v[elastic] / np.sqrt(model.squares))
    strongest = force[int(np.argmax(np.abs(force).sum(axis=1))), elastic]
    if strongest.any():
        return np.asarray(strongest / model.squares)
    result = np.zeros(model.size)
    result[:1] = 1.0
    return result


def _forces(force: Any, times: Floats, size: int) -> Floats:
    """Forces at each time, (times, n)."""
    if force is None:
        return np.zeros((times.size, size))
    if callable(force):
        try:
            force = [force(float(t)) for t in times]
        except (TypeError, ValueError) as error:
            raise InputError(f"force, as a function of the time, failed: {error}") from None
    array = floats("force", force)
    if array.shape != (times.size, size):
        raise InputError(
            f"force must have the shape ({times.size}, {size}), a row for each time, or be a "
            f"function of the time that gives {size} forces, got {array.shape}"
        )
    return array
