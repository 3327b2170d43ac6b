"""Periodic motions of a structure on a shaker, along a range of frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NoReturn, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, positive, show
from microslip._core.wording import quoted
from microslip.errors import InputError
from microslip.structures.balance import Balance
from microslip.structures.base_motion import BaseMotion
from microslip.structures.forced import (
    ForcedResponse,
    checked_frequencies,
    coefficients,
    complex_amplitudes,
    line_of,
)
from microslip.structures.forced_path import Control, Drive, Excitation, Followed, follow
from microslip.structures.matrices import vector
from microslip.structures.periodic_motion import Quantity, harmonic_basis, power_of

ControlOf = Literal["base", "response"]


@dataclass(frozen=True, eq=False, repr=False)
class BaseResponse(ForcedResponse):
    """Periodic motions on a moving base; made by ``structure.base_response(...)``.

    Followed as a :class:`ForcedResponse` is (Krack and Gross 2019,
    DOI 10.1007/978-3-030-14023-6). ``displacement`` counts from the base: from the
    static answer to the supports.
    """

    base_acceleration: NDArray[np.complex128]
    """Acceleration of each input along the path (points, inputs) [m/s^2]."""
    base_force: NDArray[np.complex128]
    """Force that moves each input (points, inputs, harmonics) [N]: what the shaker gives."""
    _carried: Floats

    @property
    def absolute_displacement(self) -> NDArray[np.complex128]:
        """Amplitudes of each harmonic as one on the ground sees them (points, n, harmonics) [m].

        Made anew each time, as ``displacement``.
        """
        absolute = self.displacement
        absolute[:, :, self.harmonics.index(1)] += self._base_motion @ self._carried.T
        return absolute

    @property
    def _base_motion(self) -> NDArray[np.complex128]:
        """Displacement of each input (points, inputs) [m]."""
        return np.asarray(-self.base_acceleration / (2.0 * np.pi * self.frequency[:, None]) ** 2)

    def _from_ground(self, at: ArrayLike) -> NDArray[np.complex128]:
        """The fundamental at a sensor as seen from the ground [m]."""
        return np.asarray(self._fundamental(at) + self._base_motion @ self._carried_at(at))

    def absolute_amplitude(self, at: ArrayLike) -> Floats:
        """As :meth:`amplitude`, seen from the ground [m]: of an accelerometer over omega^2.

        ``at`` is the direction of the sensor, shape (n,).
        """
        return np.asarray(np.abs(self._from_ground(at)))

    def frequency_response(self, *_: Any, **__: Any) -> NoReturn:
        """Refused: what a base moves has a :meth:`transmissibility`."""
        raise InputError("a motion of the base has no force; ask for transmissibility(at)")

    def transmissibility(self, at: ArrayLike) -> NDArray[np.complex128]:
        """Absolute motion of the fundamental at a sensor over that of the base.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).

        Returns
        -------
        ndarray
            Complex ratios [-], one a point; of several inputs over the first that moves.
        """
        moving = int(np.argmax(np.abs(self.base_acceleration).max(axis=0) > 0.0))
        return np.asarray(self._from_ground(at) / self._base_motion[:, moving])


def base_response(
    base: BaseMotion,
    acceleration: Any,
    frequencies: ArrayLike,
    control: ControlOf,
    at: ArrayLike | None,
    level: float | None,
    quantity: Quantity,
    harmonics: Sequence[int],
    samples: int,
) -> BaseResponse:
    """See :meth:`microslip.Preload.base_response`."""
    if control not in get_args(ControlOf):
        raise InputError(f"control must be {quoted(get_args(ControlOf))}, got {show(control)}")
    model, inputs = base.model, base.carried.shape[1]
    given = np.atleast_1d(complex_amplitudes("acceleration", acceleration))
    if given.shape != (inputs,) or not given.any():
        raise InputError(
            f"acceleration must be one amplitude [m/s^2] for each of the {inputs} inputs, not all "
            f"zero, got shape {given.shape}"
        )
    targets = checked_frequencies(frequencies)
    basis = harmonic_basis(harmonics, samples)
    forces = {0: coefficients(base.push @ given, basis)}
    if base.viscous_push is not None:
        # The velocity is a/(i omega).
        forces[1] = coefficients(base.viscous_push @ (-1j * given), basis)
    motions: dict[int, Floats] = {}
    line = line_of(model, forces[0], targets)
    if not line.any() and not base.strains:
        raise InputError(
            "directions must be a motion that strains the structure: no mode is pushed"
        )
    joints = model.joints(line)
    if base.strains:
        motions[2] = coefficients(-joints.carried(base.carried) @ given, basis)
    rigid = model.free.T @ (base.inertia @ given)
    excitation = Excitation(forces, motions, rigid)
    controlled = None
    if control == "response":
        controlled = _control(base, given, at, level, quantity)
    elif level is not None or at is not None:
        raise InputError('at and level belong to control="response"; the base has `acceleration`')
    drive = Drive(Balance(model, joints, basis), excitation, controlled)
    return _response(base, given, drive, follow(drive, targets))


def _control(
    base: BaseMotion,
    given: NDArray[np.complex128],
    at: ArrayLike | None,
    level: float | None,
    quantity: Quantity,
) -> Control:
    if at is None or level is None:
        raise InputError(
            'control="response" needs the sensor at=direction and the level=... that it is held at'
        )
    sensor = vector("at", at, base.carried.shape[0])
    target = positive("level", level, "", 10.0)
    moved = complex(sensor @ (-base.carried @ given))
    free = complex(sensor @ (base.model.free @ (base.model.free.T @ (base.inertia @ given))))
    carried = np.array([(moved + free).real, -(moved + free).imag])
    modal = base.model.shapes.T @ sensor
    if not carried.any() and not modal.any():
        raise InputError("at must be where something moves")
    return Control(modal, carried, power_of(quantity), target)


def _response(
    base: BaseMotion, given: NDArray[np.complex128], drive: Drive, followed: Followed
) -> BaseResponse:
    fields = followed.fields(drive)
    basis, joints = drive.balance.basis, drive.balance.joints
    first = basis.harmonics.index(1)
    shapes, coordinates = fields["_shapes"], fields["_coordinates"]
    levels = np.array([solved.point.level for solved in followed.path]).reshape(-1, 1)
    acceleration = levels * given
    omegas = 2.0 * np.pi * fields["frequency"]
    turning = 1j * np.array(basis.harmonics) * omegas[:, None]
    moved = -acceleration / omegas[:, None] ** 2

    def work(columns: Any, power: int, absolute: bool = True) -> NDArray[np.complex128]:
        """Work of the columns (n, inputs) on the motion or a rate of it."""
        part = (columns.T @ shapes) @ coordinates
        if absolute:
            part[:, :, first] += moved @ (base.carried.T @ columns)
        return np.asarray(part * turning[:, None, :] ** power)

    # What the supports take up: the forces on all, as far as they work on the carried motion.
    force = work(base.inertia, 2)
    if base.drag is not None:
        force += work(base.drag, 1)
    if base.strains:
        force += work(np.asarray(base.rest.stiffness @ base.carried), 0)
        if base.rest.damping is not None and base.drag is None:
            force += work(np.asarray(base.rest.damping @ base.carried), 1, absolute=False)
        sides = joints.split(joints.carried(base.carried))
        for i, solved in enumerate(followed.path):
            q, omega, level = solved.point
            motion = Excitation.at(drive.excitation.motions, omega)[0]
            _, answers = drive.balance.joint_forces(q, level * motion)
            for side, answer in zip(sides, answers, strict=True):
                pull = np.tensordot(side, answer.force, axes=([0, 1], [0, 1]))
                force[i, :, 0] += pull[:, 0]
                force[i, :, 1:] += pull[:, 1::2] - 1j * pull[:, 2::2]
    return BaseResponse(
        **fields,
        base_acceleration=acceleration,
        base_force=force,
        _carried=base.carried,
    )
