"""Time history of a structure with joints, and its energy balance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from inspect import unwrap
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, number, record
from microslip._core.errors import InputError
from microslip.figures.plot import Plot
from microslip.figures.plottable import PlottableAtSensor
from microslip.structures.matrices import vector
from microslip.structures.modal_model import ModalModel, SolverResult
from microslip.structures.static import AtRest, solver_method
from microslip.structures.time_steps import ExactSteps, TimeSteps, are_exact

_RADIUS = 0.9  # spectral radius unless given


@dataclass(frozen=True, eq=False, repr=False)
class Motion(SolverResult, PlottableAtSensor):
    """Motion in time relative to the static state, the result of ``structure.integrate(...)``.

    Each mode is integrated exactly if all joints are backbone laws; otherwise by the
    generalised-alpha method, see :meth:`microslip.Preload.integrate`.
    """

    time: Floats
    """Times [s]; fewer than requested if the method stopped."""
    displacement: Floats
    """Displacements (times, n) [m]."""
    velocity: Floats
    """Velocities (times, n) [m/s]."""
    joint_motion: Floats
    """Relative motions of the joints, (times, coordinates) [m]."""
    joint_force: Floats
    """Forces of the joints beyond those at rest, (times, coordinates) [N]."""
    work: Floats
    """Initial energy plus the work of the applied forces up to each time [J]."""
    kinetic_energy: Floats
    """Kinetic energy [J]."""
    elastic_energy: Floats
    """Energy of the structure without its joints [J]."""
    joint_energy: Floats
    """Work done on the joints, stored or dissipated [J]."""
    joint_loss: Floats
    """Energy dissipated by each joint or node up to each time (times, joints) [J]."""
    viscous_energy: Floats
    """Energy dissipated by the damping matrix [J]."""
    message: str
    """Outcome: where and why the solver stopped, and what to try."""
    _with_steps: Callable[[int], Floats] | None = None
    _least_gain: float = 4.0  # of steps half as long: turning points may take their part

    @cached_property
    def step_error(self) -> float:
        """Largest error of a displacement due to the step size, over the largest displacement [-].

        Estimated from motions with steps twice and four times as long, by Richardson extrapolation
        (1911, DOI 10.1098/rsta.1911.0009) with the observed order. Computed at the first access,
        which takes 75 % of the time of the integration. Unlike :attr:`energy_error` it includes
        errors at impacts. If the three motions do not converge, it is twice their largest
        difference and not a bound: use shorter steps.
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
        ratio = min(before / moved, self._least_gain) if moved else self._least_gain
        return moved / (ratio - 1.0) if ratio > 1.5 else 2.0 * max(moved, before)

    @property
    def dissipated_energy(self) -> Floats:
        """Energy dissipated up to each time, by friction and by the damping matrix [J]."""
        return np.asarray(self.joint_loss.sum(axis=1) + self.viscous_energy)

    @property
    def stored_energy(self) -> Floats:
        """Elastic energy of the structure and its joints, relative to rest [J].

        Balance: work = kinetic + stored + dissipated energy, up to the integration error.
        """
        stored = self.joint_energy - self.joint_loss.sum(axis=1)
        return np.asarray(self.elastic_energy + stored)

    @property
    def energy_error(self) -> float:
        """Largest error of the energy balance over the largest energy [-].

        It is of second order in the step size. A small value shows that energy is conserved, not
        that the motion is accurate: if faces open and close, use :attr:`step_error`.
        """
        parts = (self.kinetic_energy, self.elastic_energy, self.joint_energy, self.viscous_energy)
        largest = max(float(np.abs(part).max()) for part in (*parts, self.work))
        gap = float(np.abs(self.work - np.sum(parts, axis=0)).max())
        return gap / largest if largest else 0.0

    def _sizes(self, columns: Floats) -> Floats:
        return np.abs(self.displacement @ columns)

    def _figure(self, at: int | None) -> Plot:
        from microslip.structures.figures import motion_figure

        return motion_figure(self, at)

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_with_steps": None}

    def __repr__(self) -> str:
        errors = f"energy error {self.energy_error:.1e}"
        if "step_error" in vars(self):  # where it has been asked for
            errors += f", step error {self.step_error:.1e}"
        return f"Motion({self.time.size} times to {self.time[-1]:g} s, {self.message}, {errors})"


@solver_method
def integrate(
    rest: AtRest,
    force: Any,
    time: ArrayLike,
    *,
    displacement: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    spectral_radius: float | None = None,
) -> Motion:
    """Compute the motion in time under forces in addition to static ones, or after a release.

    Parameters
    ----------
    force : array_like, callable or None
        Forces [N] of shape (times, n), or a function of the time [s] that gives n forces.
    time : array_like
        Evenly spaced times [s], one-dimensional; the time steps of the integration.
    displacement : array_like, optional
        Initial displacements relative to the static state (n,) [m]; the joints are loaded along a
        straight path to them.
    velocity : array_like, optional
        Initial velocities (n,) [m/s].
    spectral_radius : float, optional
        Spectral radius of the generalised-alpha method at high frequency, 0 to 1 [-]; 1 adds no
        numerical damping. If given, this method is used.

    Returns
    -------
    Motion
        Displacements, velocities, joint motions and forces, and the balance of energy.

    Notes
    -----
    If all joints are backbone laws and no damping couples the modes, each mode is integrated
    exactly for joint forces that are cubic in time over a step (Hochbruck and Ostermann 2010, DOI
    10.1017/S0962492910000048). Otherwise, for example if faces separate, the generalised-alpha
    method is used (Chung and Hulbert 1993, DOI 10.1115/1.2900803; spectral radius 0.9 by default).
    This method is of second order: the frequency error is about 1e-4 with 256 steps per period, and
    a sixteenth of that with 1024. Nodes of fields slide along one line each, as in :meth:`modes`:
    that of the initial motion, or of the response to the largest force.
    """
    model, mass, stiffness, radius = rest.model, rest.mass, rest.stiffness, spectral_radius
    times = np.atleast_1d(record("time", time, "s"))
    size = model.shapes.shape[0]
    steps = np.diff(times)
    if times.size < 2 or steps.min() <= 0.0 or np.ptp(steps) > 1e-6 * steps.mean():
        raise InputError(
            "time must hold at least two increasing times in equal steps, such as "
            "np.linspace(0.0, 0.1, 10001)"
        )
    if radius is not None and not 0.0 <= (radius := number("spectral_radius", radius)) <= 1.0:
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
    run = march(model, modal_force, times, q, v, radius)
    modal, speeds, motion, pull = run.place, run.speed, run.motion, run.pull
    reached = len(modal)
    x, speed = modal @ shapes.T, speeds @ shapes.T
    kinetic = 0.5 * np.sum(speeds**2, axis=1)
    elastic = 0.5 * np.sum(x * np.asarray(stiffness @ x.T).T, axis=1)
    beginning = motion[0] if motion.size else np.zeros(0)
    cubic = isinstance(run.stepper, ExactSteps)
    joint = _work(pull, motion, cubic) + 0.5 * float(pull[0] @ beginning)
    viscous = _work(speeds @ run.stepper.damping, modal, cubic)
    work = _work(forces[:reached], x, cubic) + kinetic[0] + elastic[0] + joint[0]

    def with_steps(factor: int) -> Floats:
        """Return displacements (times, n) [m], computed with steps longer by ``factor``."""
        rows = slice(0, reached, factor)
        if len(times[rows]) < 2:
            return np.asarray(x[:1])
        begin: Any = {"displacement": displacement, "velocity": velocity, "spectral_radius": radius}
        # Longer steps may leave what a geometry is known for: that says nothing of this motion.
        coarser: Motion = unwrap(integrate)(rest, forces[rows], times[rows], **begin)
        return coarser.displacement

    return Motion(
        times[:reached], x, speed, motion, pull, work, kinetic, elastic, joint, run.lost, viscous,
        run.message, with_steps, 2.0 if cubic else 4.0,
    )  # fmt: skip


class March(NamedTuple):
    """Time history of elastic and rigid modal coordinates, and of the joints."""

    stepper: TimeSteps
    place: Floats
    """Modal displacements (times, modes); fewer times than requested if the method stopped."""
    speed: Floats
    motion: Floats
    """Motion of the joints, (times, coordinates) [m]."""
    pull: Floats
    """Forces of the joints, (times, coordinates) [N]."""
    lost: Floats
    """Dissipated energies (times, joints) [J]."""
    stuck: Floats
    """Stiffnesses of sticking joints [N/m]."""
    message: str

    def acceleration(self, force: Floats) -> Floats:
        """Return modal accelerations under the modal forces ``force``, both (times, modes)."""
        short = self.pull - self.stuck * self.motion
        return self.stepper.acceleration(self.place, self.speed, force[: len(short)], short)


def march(
    model: ModalModel,
    force: Floats,
    times: Floats,
    place: Floats | None = None,
    speed: Floats | None = None,
    radius: float | None = None,
) -> March:
    """Integrate with constant steps under modal forces (times, modes).

    Begin with displacements ``place`` and velocities ``speed`` (modes,), zero by default.
    ``radius`` is the spectral radius of generalised-alpha; with None steps are exact where joints
    permit it.
    """
    q, v = (np.zeros(force.shape[1]) if x is None else x for x in (place, speed))
    joints = model.joints(_line(model, q, v, force))
    step = float(np.diff(times).mean())
    stepper: TimeSteps
    if radius is None and are_exact(model, joints):
        stepper = ExactSteps(model, joints, step, force)
    else:
        stepper = TimeSteps(model, joints, step, _RADIUS if radius is None else radius)
    stepper.begin(q, v)
    a = stepper.acceleration(q, v, force[0], stepper.short)
    count = times.size
    rows = [np.empty((count, width)) for width in (q.size, q.size, stepper.motion.size)]
    rows.append(np.empty_like(rows[2]))
    rows.append(np.empty((count, stepper.lost.size)))
    reached = 0
    for i in range(count):
        if i:
            moved = stepper.advance(q, v, a, force[i - 1], force[i])
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
            f"stopped at {times[reached - 1]:.6g} s: the next step did not "
            "converge; try shorter steps"
        )
    place, speed, motion, pull, lost = (row[:reached] for row in rows)
    return March(stepper, place, speed, motion, pull, lost, joints.stuck, message)


def _work(force: Floats, path: Floats, cubic: bool) -> Floats:
    """Return the cumulative work along paths (times, k), linear or ``cubic`` between times."""
    step, change = np.diff(path, axis=0), np.diff(force, axis=0)
    pieces = 0.5 * (force[1:] + force[:-1]) * step
    if cubic and len(path) > 2:
        bends = (np.diff(np.gradient(values, axis=0), axis=0) for values in (force, path))
        of_force, of_path = bends
        pieces = pieces + (change * of_path - of_force * step) / 12.0
    return np.append(0.0, np.cumsum(np.sum(pieces, axis=1)))


def _line(model: ModalModel, q: Floats, v: Floats, force: Floats) -> Floats:
    """Return an estimate of the modal motion (modes,), along which nodes of fields slide."""
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
