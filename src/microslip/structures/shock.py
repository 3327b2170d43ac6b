"""A structure with joints on a base that is shocked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, positive
from microslip._core.frozen import LockedArrays, assign, lock
from microslip._core.verdicts import Rule, Verdict
from microslip.errors import InputError
from microslip.friction import Iwan
from microslip.structures.base_motion import BaseMotion
from microslip.structures.joint_groups import LawAttachment
from microslip.structures.matrices import vector
from microslip.structures.modal_model import ModalModel, modal_model
from microslip.structures.motion import integrate
from microslip.structures.periodic_motion import AmplitudeMeasure, Quantity, power_of
from microslip.structures.quasi_static import QuasiStatic

ShockMethod = Literal["integration", "oscillator"]
_STEPS = 200  # a period of the mode that moves most
_MOST_STEPS = 1e7
_SLOW = 40  # modes beside it that answer dynamically
_LATE = 10.0  # periods after a short pulse: what the oscillator tells of later ones is wrong
_LARGEST = 2e7  # displacements that are kept

SOFTENING = Rule(
    "loss of stiffness of the mode",
    watch=0.2,
    outside=0.45,
    meaning="One oscillator represents a mode whose shape hardly changes as joints slip.",
    reason=(
        "Held against integration in 35 cases, peaks were within 4 % in displacement and 12 % in "
        "acceleration up to 0.25, 15 % and 12 % up to 0.45, and 21 % and 34 % beyond."
    ),
    remedy='Write method="integration", with joints of laws along directions.',
)

RISE = Rule(
    "rise of the stiffness of the mode",
    watch=0.02,
    outside=0.1,
    meaning="One oscillator softens: faces that part and bending do not stiffen the mode.",
    reason="Its cells follow a curve that falls; what rises is taken as level.",
    remedy="Integrate in time, or hold the peaks against sweeps at these amplitudes.",
)


@dataclass(frozen=True, eq=False, init=False)
class Pulse:
    """An acceleration of the base that begins and ends.

    Parameters
    ----------
    time : array_like
        Rising times [s] from zero, one-dimensional.
    acceleration : array_like
        Accelerations there [m/s^2], straight in between and nothing after.

    Notes
    -----
    What it does to a jointed structure is integrated as Chung and Hulbert (1993) have it,
    DOI 10.1115/1.2900803.
    """

    time: Floats
    acceleration: Floats

    def __init__(self, time: ArrayLike, acceleration: ArrayLike) -> None:
        t, a = floats("time", time), floats("acceleration", acceleration)
        if t.ndim != 1 or t.size < 2 or t[0] != 0.0 or np.diff(t).min() <= 0.0:
            raise InputError("time of a pulse must rise from 0, at least two times [s]")
        if a.shape != t.shape or not a.any():
            raise InputError(
                f"acceleration of a pulse must be one for each of the {t.size} times, not all "
                f"zero, got shape {a.shape}"
            )
        assign(self, time=lock(t.copy()), acceleration=lock(a.copy()))

    @classmethod
    def half_sine(cls, amplitude: float, duration: float) -> Pulse:
        """Half of a sine, as shock tests have it (IEC 60068-2-27).

        Parameters
        ----------
        amplitude : float
            Its peak [m/s^2].
        duration : float
            [s]
        """
        height = positive("amplitude", amplitude, "m/s^2", 300.0)
        length = positive("duration", duration, "s", 0.011)
        share = np.linspace(0.0, 1.0, 257)
        return cls(length * share, height * np.sin(math.pi * share))

    @property
    def duration(self) -> float:
        """Its length [s]."""
        return float(self.time[-1])


@dataclass(frozen=True, eq=False, repr=False)
class ShockResponse(LockedArrays):
    """Motion under a pulse of the base; made by ``structure.shock(...)``.

    Displacements and velocities count from the base, accelerations from the ground. By the
    generalised-alpha method (Chung and Hulbert 1993, DOI 10.1115/1.2900803).
    """

    method: ShockMethod
    """``integration`` with the joints' states, or ``oscillator`` along a quasi-static curve."""
    time: Floats
    """Times [s]."""
    base_acceleration: Floats
    """Of the base, (times,) [m/s^2]."""
    message: str
    """What came of it."""
    verdicts: tuple[Verdict, ...]
    """Whether one oscillator can stand for the mode; none of integration."""
    _coordinates: Floats
    _speeds: Floats
    _shapes: Floats
    _carried: Floats

    @property
    def status(self) -> str:
        """``solved``, or ``stopped`` before the last time."""
        return "solved" if self.message.startswith("solved") else "stopped"

    def history(self, at: ArrayLike, quantity: Quantity = "displacement") -> Floats:
        """The motion at a sensor.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).
        quantity : {"displacement", "velocity", "acceleration"}, optional
            [m] or [m/s] from the base, or [m/s^2] from the ground.

        Returns
        -------
        ndarray
            One value a time.
        """
        power = power_of(quantity)
        sensor = vector("at", at, self._shapes.shape[0])
        modal = self._shapes.T @ sensor
        if power == 0:
            return np.asarray(self._coordinates @ modal)
        speed = np.asarray(self._speeds @ modal)
        if power == 1:
            return speed
        carried = float(sensor @ self._carried)
        return np.asarray(np.gradient(speed, self.time) + carried * self.base_acceleration)

    def _sizes(self, columns: Floats) -> Floats:
        """Of displacements along columns (n, k), (times, k) [m]."""
        return np.abs(self._coordinates @ (self._shapes.T @ columns))

    def peak(self, at: ArrayLike, quantity: Quantity = "displacement") -> float:
        """Largest size at a sensor of direction ``at``, shape (n,) [m, m/s or m/s^2]."""
        return float(np.abs(self.history(at, quantity)).max())

    def __repr__(self) -> str:
        return f"ShockResponse({self.time.size} times to {self.time[-1]:g} s, {self.message})"


def shock(
    base: BaseMotion, pulse: Any, method: ShockMethod, duration: float | None, zeta: float
) -> ShockResponse:
    """See :meth:`microslip.Preload.shock`."""
    given = pulse if isinstance(pulse, Pulse) else _pulse(pulse)
    if base.carried.shape[1] != 1 or base.strains:
        raise InputError(
            "directions must be one motion of a rigid base; supports that move against another "
            "have no shock"
        )
    push = base.push[:, 0]
    if not push.any():
        raise InputError(
            "directions must be a motion that strains the structure: no mode is pushed"
        )
    index = int(np.argmax(np.abs(push) / base.model.squares))
    period = 2.0 * math.pi / math.sqrt(base.model.squares[index])
    after = 5.0 * period if duration is None else positive("duration", duration, "s", 0.1)
    end = given.duration + after if duration is None else after
    if method == "oscillator" and given.duration < period and end > given.duration + _LATE * period:
        raise InputError(
            f"duration must end within {_LATE:g} periods of a pulse that is shorter than one, at "
            f"{given.duration + _LATE * period:.4g} s: later ring-downs of the oscillator are "
            'wrong by 14 to 350 %; write method="integration"'
        )
    step = min(period / _STEPS, given.duration / 50.0)
    if not end / step <= _MOST_STEPS:
        raise InputError(
            f"duration must be at most {_MOST_STEPS * step:.4g} s, {_MOST_STEPS:g} steps of "
            f"{step:.3g} s, got {end:.4g} s"
        )
    time: Floats = step * np.arange(math.ceil(end / step) + 1.0)
    a = np.asarray(np.interp(time, given.time, given.acceleration, right=0.0))
    solve = _integrated if method == "integration" else _oscillator
    return solve(base, index, time, a, zeta)


def _pulse(value: Any) -> Pulse:
    try:
        time, acceleration = value
    except (TypeError, ValueError):
        raise InputError(
            "pulse must be ms.Pulse.half_sine(amplitude, duration), or times and accelerations"
        ) from None
    return Pulse(time, acceleration)


def _integrated(
    base: BaseMotion, index: int, time: Floats, a: Floats, zeta: float
) -> ShockResponse:
    """All joints with their states."""
    size = base.carried.shape[0]
    if time.size * size > _LARGEST:
        raise InputError(
            f'method="integration" would keep {time.size} times of {size} degrees of freedom; '
            'reduce the structure, or write method="oscillator"'
        )
    model = base.model
    if zeta:
        extra = np.diag(2.0 * zeta * np.sqrt(model.squares))
        damping = extra if model.damping is None else model.damping + extra
        model = ModalModel(
            model.shapes, model.squares, damping, model.free, model.attachments, model.motions
        )
    forces = -np.outer(a, base.inertia[:, 0])
    if base.drag is not None:
        steps = np.append(0.0, np.cumsum(0.5 * (a[1:] + a[:-1]) * np.diff(time)))
        forces = forces - np.outer(steps, base.drag[:, 0])
    motion = integrate(model, base.mass, base.stiffness, forces, time, None, None, 0.9)
    count = motion.time.size
    return ShockResponse(
        "integration", motion.time, a[:count], motion.message, (), motion.displacement,
        motion.velocity, np.eye(size), base.carried[:, 0],
    )  # fmt: skip


def _oscillator(
    base: BaseMotion, index: int, time: Floats, a: Floats, zeta: float
) -> ShockResponse:
    """One mode along its quasi-static curve, the others as long as their joints stick."""
    model, push = base.model, base.push[:, 0]
    slow = np.union1d(np.arange(min(_SLOW, model.size)), [index])
    place = int(np.flatnonzero(slow == index)[0])
    squares = model.squares[slow]
    damping = np.diag(2.0 * zeta * np.sqrt(squares))
    if model.damping is not None:
        damping = damping + model.damping[np.ix_(slow, slow)]
    largest = 3.0 * abs(push[index]) * float(np.abs(a).max()) / model.squares[index]
    amplitudes, squares_along, shapes = _curve(model, index, largest)
    cells, rest = _cells(amplitudes, squares_along)
    stiffness = np.diag(squares)
    stiffness[place, place] = rest
    direction = np.zeros((slow.size, 1))
    direction[place] = 1.0
    joint = LawAttachment(cells, direction)
    modes = modal_model(np.eye(slow.size), stiffness, damping, (joint,), [np.zeros(1)])
    # A mode's shape changes as its joints soften: that of the peak counts, found in two rounds.
    column = np.eye(model.size)[index]
    for _ in range(3):
        along = push.copy()
        along[index] = float(column @ push)
        forces = np.outer(a, along[slow])
        motion = integrate(modes, np.eye(slow.size), stiffness, forces, time, None, None, 0.9)
        reached = float(np.abs(motion.displacement[:, place]).max())
        column = np.array([np.interp(reached, amplitudes, shape) for shape in shapes.T])
    count = motion.time.size
    stiff = squares_along / squares_along[0]
    softening = 1.0 - float(np.interp(reached, amplitudes, stiff))
    message = motion.message
    if reached > amplitudes[-1]:
        message = (
            f"stopped: the motion reaches the modal amplitude {reached:.3g}, the quasi-static "
            f'curve {amplitudes[-1]:.3g}; write method="integration"'
        )
    fast = np.setdiff1d(np.arange(model.size), slow)
    static = np.outer(a[:count], push[fast] / model.squares[fast])
    order = np.concatenate([slow, fast])
    shapes_of_peak = model.shapes.copy()
    shapes_of_peak[:, index] = model.shapes @ column
    return ShockResponse(
        "oscillator", motion.time, a[:count], message,
        (SOFTENING.judge(softening), RISE.judge(float(stiff.max()) - 1.0)),
        np.concatenate([motion.displacement, static], axis=1),
        np.concatenate([motion.velocity, np.zeros_like(static)], axis=1),
        shapes_of_peak[:, order], base.carried[:, 0],
    )  # fmt: skip


def _curve(model: ModalModel, index: int, largest: float) -> tuple[Floats, Floats, Floats]:
    """Amplitudes, squares of the quasi-static frequencies, and shapes along a mode."""
    from scipy.interpolate import PchipInterpolator

    line = np.zeros(model.size)
    line[index] = 1.0
    solver = QuasiStatic(model, model.joints(line), index, AmplitudeMeasure(None))
    amplitudes = largest * np.geomspace(1e-4, 1.0, 25)
    points = [point for point in solver.curve(amplitudes) if point is not None]
    if len(points) < 3:
        raise InputError('no quasi-static curve was found; write method="integration"')
    a = np.array([point.amplitude for point in points])
    squares = np.array([point.square for point in points])
    dense = np.geomspace(a[0], a[-1], 80)
    shapes = np.array([point.shape / np.linalg.norm(point.shape) for point in points])
    shapes *= np.sign(shapes[:, index])[:, None]
    places = np.log(dense)
    along = [np.asarray(PchipInterpolator(np.log(a), v)(places)) for v in (squares, shapes)]
    return dense, along[0], along[1]


def _cells(amplitudes: Floats, squares: Floats) -> tuple[Iwan, float]:
    """Jenkins cells whose first loading runs through the curve's, and the spring beside them."""
    force = squares * amplitudes
    slopes = np.diff(np.append(0.0, force)) / np.diff(np.append(0.0, amplitudes))
    slopes = np.minimum.accumulate(slopes)
    rest = max(float(slopes[-1]), 1e-6 * float(slopes[0]))
    parts = np.maximum(slopes - np.append(slopes[1:], rest), 0.0)
    yielding = parts > 1e-12 * slopes[0]
    if not yielding.any():  # all sticks: a cell that never slips
        return Iwan([0.5 * rest], [0.5 * rest * 1e3 * amplitudes[-1]]), 0.5 * rest
    return Iwan(parts[yielding], parts[yielding] * amplitudes[yielding]), rest
