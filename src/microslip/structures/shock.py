"""A structure with joints under a shock of its base."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, positive
from microslip._core.errors import InputError
from microslip._core.frozen import assign, lock
from microslip.structures.base_motion import Frame, base_motion
from microslip.structures.modal_model import ModalResult
from microslip.structures.motion import march
from microslip.structures.periodic_motion import MotionQuantity, power_of
from microslip.structures.static import AtRest, base_damping, solver_method

_STEPS = 200  # a period of the mode that moves most
_IN_PULSE = 50  # steps at least
_LARGEST = 2e7  # modal coordinates that are kept


@dataclass(frozen=True, eq=False, init=False)
class Pulse:
    """Acceleration of the base with a beginning and an end.

    Parameters
    ----------
    time : array_like
        Increasing times [s], starting at zero, one-dimensional.
    acceleration : array_like
        Accelerations at these times [m/s^2]; linear in between, zero afterwards.

    Notes
    -----
    For the integration of the response see Chung and Hulbert (1993), DOI 10.1115/1.2900803.
    """

    time: Floats
    acceleration: Floats

    def __init__(self, time: ArrayLike, acceleration: ArrayLike) -> None:
        t, a = floats("time", time, "s"), floats("acceleration", acceleration, "m/s^2")
        if t.ndim != 1 or t.size < 2 or t[0] != 0.0 or np.diff(t).min() <= 0.0:
            raise InputError("time of a pulse must increase from 0, at least two times [s]")
        if a.shape != t.shape or not a.any():
            raise InputError(
                f"acceleration of a pulse must be one for each of the {t.size} times, not all "
                f"zero, got shape {a.shape}"
            )
        assign(self, time=lock(t.copy()), acceleration=lock(a.copy()))

    @classmethod
    def half_sine(cls, amplitude: float, duration: float) -> Pulse:
        """Return a half-sine pulse of shock tests (IEC 60068-2-27).

        Parameters
        ----------
        amplitude : float
            Peak acceleration [m/s^2].
        duration : float
            Duration [s].
        """
        height = positive("amplitude", amplitude, "m/s^2", 300.0)
        length = positive("duration", duration, "s", 0.011)
        share = np.linspace(0.0, 1.0, 257)
        return cls(length * share, height * np.sin(math.pi * share))

    @property
    def duration(self) -> float:
        """Duration of the pulse [s]."""
        return float(self.time[-1])


@dataclass(frozen=True, eq=False, repr=False)
class ShockResponse(ModalResult):
    """Motion under a pulse of the base, the result of ``structure.shock(...)``.

    Displacements and velocities are relative to the base, accelerations to the ground. Integrated
    like a :class:`Motion` (Chung and Hulbert 1993, DOI 10.1115/1.2900803).
    """

    time: Floats
    """Times [s]."""
    base_acceleration: Floats
    """Acceleration of the base, (times,) [m/s^2]."""
    message: str
    """Outcome: solved, or where and why the solver stopped."""
    _modal: tuple[Floats, Floats, Floats]
    _shapes: Floats
    _carried: Floats

    def history(self, at: ArrayLike, quantity: MotionQuantity = "displacement") -> Floats:
        """Return the motion at a sensor.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).
        quantity : {"displacement", "velocity", "acceleration"}, optional
            Displacement [m] or velocity [m/s] relative to the base, or acceleration [m/s^2]
            relative to the ground.

        Returns
        -------
        ndarray
            Values at the times, shape (times,).
        """
        power = power_of(quantity)
        motion = np.asarray(self._modal[power] @ self._at(at))
        return motion + self._carried_at(at) * self.base_acceleration if power == 2 else motion

    def _sizes(self, columns: Floats) -> Floats:
        return np.abs(self._modal[0] @ (self._shapes.T @ columns))

    def peak(self, at: ArrayLike, quantity: MotionQuantity = "displacement") -> float:
        """Return the largest magnitude of the motion at a sensor [m, m/s or m/s^2].

        ``at`` is the direction of the sensor, shape (n,); see :meth:`history`.
        """
        return float(np.abs(self.history(at, quantity)).max())

    def __repr__(self) -> str:
        return f"ShockResponse({self.time.size} times to {self.time[-1]:g} s, {self.message})"


@solver_method
def shock(
    rest: AtRest,
    pulse: Any,
    *,
    directions: ArrayLike,
    duration: float | None = None,
    supports: Sequence[int] | None = None,
    damping_frame: Frame | None = None,
    joints_on_base: bool = False,
    damping_ratio: float = 0.0,
) -> ShockResponse:
    """Compute the motion under a pulse of the base.

    Parameters
    ----------
    pulse : Pulse or pair of array_like
        ``ms.Pulse.half_sine(amplitude, duration)``, or times [s] and accelerations [m/s^2],
        one-dimensional.
    directions, supports, damping_frame, joints_on_base : optional
        As for :meth:`base_response`, for one rigid base.
    duration : float, optional
        Time at which the motion ends [s]; by default the pulse plus five periods of the mode that
        the base excites most.
    damping_ratio : float, optional
        Damping ratio of each mode without the joints [-], in addition to C.

    Returns
    -------
    ShockResponse
        ``peak(at)`` and ``history(at)`` of displacements, velocities and accelerations.

    Notes
    -----
    Integrated as by :meth:`integrate`, with at least 200 steps per period of the mode that the base
    excites most and 50 steps per pulse. The relative error of peak displacements is about 1e-3,
    that of peak accelerations 2 % if faces separate and 1e-3 otherwise.
    """
    base = base_motion(rest, directions, supports, damping_frame, joints_on_base)
    zeta = base_damping(damping_ratio)
    try:
        given = pulse if isinstance(pulse, Pulse) else Pulse(*pulse)
    except TypeError:
        raise InputError(
            "pulse must be ms.Pulse.half_sine(amplitude, duration), or times and accelerations"
        ) from None
    if base.carried.shape[1] != 1 or base.strains:
        raise InputError(
            "directions must be one motion of a rigid base; supports with relative "
            "motion have no shock"
        )
    push = base.push[:, 0]
    if not push.any():
        raise InputError(
            "directions must be a motion that strains the structure: no mode is excited"
        )
    model = base.model
    period = 2.0 * math.pi / math.sqrt(model.squares[np.argmax(np.abs(push) / model.squares)])
    end = given.duration + 5.0 * period
    if duration is not None:
        end = positive("duration", duration, "s", 0.1)
    step = min(period / _STEPS, given.duration / _IN_PULSE)
    most = _LARGEST / model.size * step
    if not end <= most:
        raise InputError(
            f"duration must be at most {most:.4g} s, {_LARGEST:g} values of {model.size} modes in "
            f"steps of {step:.3g} s, got {end:.4g} s"
        )
    time: Floats = step * np.arange(math.ceil(end / step) + 1.0)
    a = np.asarray(np.interp(time, given.time, given.acceleration, right=0.0))
    force = np.outer(a, push)
    if (drag := base.viscous_push) is not None:
        velocity = np.append(0.0, np.cumsum(0.5 * (a[1:] + a[:-1]) * np.diff(time)))
        force += np.outer(velocity, drag[:, 0])
    if zeta:
        extra = np.diag(2.0 * zeta * np.sqrt(model.squares))
        model = replace(model, damping=extra if model.damping is None else model.damping + extra)
    force = np.concatenate([force, np.zeros((time.size, model.free.shape[1]))], axis=1)
    run = march(model, force, time)
    count = run.place.shape[0]
    return ShockResponse(
        time[:count], a[:count], run.message, (run.place, run.speed, run.acceleration(force)),
        np.concatenate([model.shapes, model.free], axis=1), base.carried[:, 0],
    )  # fmt: skip
