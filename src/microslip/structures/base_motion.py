"""Structure on moving supports: on a shaker table, or on several supports with their own motions.

The displacements are x = y + carried x_b, with the prescribed support motions (inputs) x_b, the
static response ``carried`` of the structure with sticking joints to a unit of each input, and y,
which is zero at the supports. A joint with directions B moves by B^T y + B^T carried x_b, and the
forces -(M carried) x_b'' - (C carried) x_b' excite y. For one rigid base only the inertia force
remains, and y is the displacement relative to the base.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NoReturn, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.wording import quoted
from microslip.structures.balance import Balance
from microslip.structures.forced import (
    ForcedResponse,
    checked_frequencies,
    coefficients,
    complex_amplitudes,
    line_of,
)
from microslip.structures.forced_path import Control, Drive, at_frequency, follow
from microslip.structures.geometry import GeometryAttachment
from microslip.structures.joint_groups import change_rows, joint_motion
from microslip.structures.matrices import direction_matrix, is_sparse, solve_linear, vector
from microslip.structures.modal_model import ModalModel, modal_model, stuck_stiffness
from microslip.structures.periodic_motion import MotionQuantity, harmonic_basis, power_of
from microslip.structures.static import AtRest, solver_method, static_state

Frame = Literal["base", "ground"]
_ROUNDING = 1e-8  # of the sides of a joint: motion that is none


@dataclass(frozen=True, eq=False)
class BaseMotion:
    """Static motion, inertia and damping forces of a structure per unit of each base input."""

    model: ModalModel
    """Modal model with fixed supports, where the shapes are zero."""
    carried: Floats
    """Static displacements of all degrees of freedom per unit of each input (n, inputs)."""
    inertia: Floats
    """M carried, (n, inputs) [kg]."""
    drag: Floats | None
    """C carried, (n, inputs) [kg/s]; None if no dashpot resists the base motion."""
    strains: bool
    """Whether relative support motion strains the structure or moves its joints."""
    rest: AtRest
    """Static state of the whole structure."""

    @property
    def push(self) -> Floats:
        """Modal forces per unit acceleration of each input (modes, inputs)."""
        return np.asarray(-self.model.shapes.T @ self.inertia)

    @property
    def viscous_push(self) -> Floats | None:
        """Modal forces of dashpots per unit velocity of each input (modes, inputs), or None."""
        return None if self.drag is None else np.asarray(-self.model.shapes.T @ self.drag)


def base_motion(
    rest: AtRest,
    directions: ArrayLike,
    supports: Sequence[int] | None = None,
    damping_frame: Frame | None = None,
    joints_on_base: bool = False,
) -> BaseMotion:
    """Return the base motion; arguments as for :meth:`microslip.Preload.base_response`."""
    if damping_frame is not None and damping_frame not in get_args(Frame):
        raise InputError(
            f"damping_frame must be {quoted(get_args(Frame))}, got {show(damping_frame)}"
        )
    if supports is None:
        return _under_the_structure(rest, directions, damping_frame, joints_on_base)
    return _at_supports(rest, directions, supports, damping_frame)


def _under_the_structure(
    rest: AtRest, directions: ArrayLike, frame: Frame | None, joints_on_base: bool
) -> BaseMotion:
    carried = direction_matrix("directions", directions, rest.static_force.size)
    # A geometry bends with the motion from the base, which is what the matrices count.
    joints = tuple(a for a in rest.attachments if not isinstance(a, GeometryAttachment))
    share, place = joint_motion(joints, carried)
    if share > _ROUNDING and not joints_on_base:
        raise InputError(
            f"directions must not deform joints, but the base deforms those of attachment {place} "
            f"by {share:.2g} of the motion of their sides. Write joints_on_base=True for joints of "
            "the structure with the base, or give the degrees of freedom of the base by supports="
        )
    drag = None
    if rest.damping is not None:
        drag = _drag_of_mass(rest, carried, frame)
    inertia = np.asarray(rest.mass @ carried)
    return BaseMotion(rest.model, carried, inertia, drag, False, rest)


def _drag_of_mass(rest: AtRest, carried: Floats, frame: Frame | None) -> Floats | None:
    """Return alpha M carried [kg/s], (n, inputs), for Rayleigh damping C = alpha M + beta K.

    These are forces of dashpots that are fixed to the ground, per unit base velocity. Return None
    if the dashpots are fixed to the base; this is assumed for any other C.
    """
    pull = np.asarray(rest.damping @ carried).ravel()
    parts = [np.asarray(m @ carried).ravel() for m in (rest.mass, rest.stiffness)]
    size = float(np.linalg.norm(pull))
    if size == 0.0:
        return None
    basis = np.stack(parts, axis=1)
    weights, *_ = np.linalg.lstsq(basis / np.maximum(np.linalg.norm(basis, axis=0), 1e-300), pull)
    unit = basis / np.maximum(np.linalg.norm(basis, axis=0), 1e-300)
    left = float(np.linalg.norm(pull - unit @ weights))
    if left > 1e-6 * size or abs(weights[0]) < 1e-6 * size:
        return None
    if frame is None:
        raise InputError(
            "damping has a part proportional to the mass, whose dashpots are fixed to the base or "
            'to the ground: write damping_frame="base" or damping_frame="ground"'
        )
    if frame == "base":
        return None
    return np.asarray((unit[:, 0] * weights[0]).reshape(carried.shape))


def _at_supports(
    rest: AtRest, directions: ArrayLike, supports: Sequence[int], frame: Frame | None
) -> BaseMotion:
    size = rest.static_force.size
    given = np.asarray(supports)
    if (
        given.ndim != 1
        or given.dtype.kind not in "iu"
        or not 0 < given.size < size
        or given.min() < 0
        or given.max() >= size
        or np.unique(given).size < given.size
    ):
        raise InputError(
            f"supports must be different degrees of freedom from 0 to {size - 1}, not all of "
            f"them, such as [0, {size - 1}], got {show(supports)}"
        )
    moved = direction_matrix("directions at the supports", directions, given.size)
    free = np.setdiff1d(np.arange(size), given)
    inner_joints = [change_rows(a, lambda rows: rows[free]) for a in rest.attachments]
    cut = np.ix_(free, free)
    mass, stiffness = _part(rest.mass, cut), _part(rest.stiffness, cut)
    damping = None if rest.damping is None else _part(rest.damping, cut)
    displacement, _, error, _ = static_state(
        stiffness, mass, tuple(inner_joints), rest.static_force[free]
    )
    if error > 1e-6:
        raise InputError("supports must leave a state of rest under the static forces")
    motions = [a.columns.T @ displacement for a in inner_joints]
    inner = modal_model(mass, stiffness, damping, tuple(inner_joints), motions)
    if inner.free.shape[1]:
        raise InputError(
            f"supports must restrain the structure: {inner.free.shape[1]} rigid-body motions "
            "are free"
        )
    if not inner.size:
        raise InputError("supports must leave at least one elastic mode")
    stuck = stuck_stiffness(rest.stiffness, rest.attachments, motions)
    carried = np.zeros((size, moved.shape[1]))
    carried[given] = moved
    pull = -np.asarray(_part(stuck, np.ix_(free, given)) @ moved)
    carried[free] = solve_linear(_part(stuck, cut), pull)
    shapes = np.zeros((size, inner.size))
    shapes[free] = inner.shapes
    model = replace(
        inner, shapes=shapes, free=np.zeros((size, 0)), attachments=rest.attachments,
        motions=tuple(motions),
    )  # fmt: skip
    drag = None
    if rest.damping is not None and frame != "base":
        drag = np.asarray(rest.damping @ carried)
        scale = np.asarray(abs(rest.damping) @ np.abs(carried))
        if float(np.abs(drag).max()) <= _ROUNDING * float(scale.max(initial=1e-300)):
            drag = None
        elif frame is None and _is_rigid(rest, carried):
            raise InputError(
                "damping resists the base's rigid motion, as a part proportional to the mass does, "
                "whose dashpots are fixed to the base or to the ground: write "
                'damping_frame="base" or damping_frame="ground"'
            )
    inertia = np.asarray(rest.mass @ carried)
    return BaseMotion(model, carried, inertia, drag, not _is_rigid(rest, carried), rest)


def _is_rigid(rest: AtRest, carried: Floats) -> bool:
    if joint_motion(rest.attachments, carried)[0] > _ROUNDING:
        return False
    pull = np.abs(np.asarray(rest.stiffness @ carried)).max()
    scale = np.asarray(abs(rest.stiffness) @ np.abs(carried)).max()
    return bool(pull <= _ROUNDING * scale)


def _part(matrix: Any, cut: Any) -> Any:
    return matrix.tocsc()[cut] if is_sparse(matrix) else matrix[cut]


ControlOf = Literal["base", "response"]


@dataclass(frozen=True, eq=False, repr=False)
class BaseResponse(ForcedResponse):
    """Periodic motions on a moving base, the result of ``structure.base_response(...)``.

    Computed along a path of frequencies like a :class:`ForcedResponse` (Krack and Gross 2019,
    DOI 10.1007/978-3-030-14023-6). ``displacement`` is relative to the static response to the
    base motion, which for one rigid base is the motion of the base.
    """

    base_acceleration: NDArray[np.complex128]
    """Acceleration of each input along the path (points, inputs) [m/s^2]."""
    base_force: NDArray[np.complex128]
    """Shaker force of each input (points, inputs, harmonics) [N]."""
    _carried: Floats

    @property
    def absolute_displacement(self) -> NDArray[np.complex128]:
        """Complex amplitudes relative to the ground (points, n, harmonics) [m], not stored."""
        absolute = self.displacement
        absolute[:, :, self.harmonics.index(1)] += self._base_motion @ self._carried.T
        return absolute

    @property
    def _base_motion(self) -> NDArray[np.complex128]:
        """Complex displacement amplitude of each input along the path (points, inputs) [m]."""
        return np.asarray(-self.base_acceleration / (2.0 * np.pi * self.frequency[:, None]) ** 2)

    def frequency_response(self, *_: Any, **__: Any) -> NoReturn:
        """Raise an error: a response to base motion has a :meth:`transmissibility`."""
        raise InputError("a motion of the base has no force; use transmissibility(at)")

    def transmissibility(self, at: ArrayLike) -> NDArray[np.complex128]:
        """Return the absolute motion at a sensor over the base motion, in the fundamental harmonic.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).

        Returns
        -------
        ndarray
            Complex ratios of amplitudes [-], shape (points,). With several inputs the denominator
            is the first one that moves.
        """
        moving = int(np.argmax(np.abs(self.base_acceleration).max(axis=0) > 0.0))
        absolute = self._fundamental(at) + self._base_motion @ self._carried_at(at)
        return np.asarray(absolute / self._base_motion[:, moving])


@solver_method
def base_response(
    rest: AtRest,
    *,
    directions: ArrayLike,
    acceleration: Any,
    frequencies: ArrayLike,
    control: ControlOf = "base",
    at: ArrayLike | None = None,
    level: float | None = None,
    quantity: MotionQuantity = "acceleration",
    supports: Sequence[int] | None = None,
    damping_frame: Frame | None = None,
    joints_on_base: bool = False,
    harmonics: Sequence[int] | None = None,
    samples: int = 64,
) -> BaseResponse:
    """Compute periodic motions on a shaker table or on moving supports, along frequencies.

    Parameters
    ----------
    directions : array_like
        Displacement R of each degree of freedom per unit displacement of each input [-], shape
        (n,) or (n, inputs). With ``supports``: displacement of each support, (supports,) or
        (supports, inputs).
    acceleration : complex or array_like
        Amplitude a of the acceleration Re(a exp(i omega t)) of each input [m/s^2], (inputs,).
    frequencies : array_like
        Frequencies [Hz], one-dimensional, in increasing or decreasing order.
    control : {"base", "response"}, optional
        Quantity held constant along the frequencies: the acceleration of the base, or the absolute
        motion at a sensor, for which the level of the base is adjusted. A response under response
        control does not fold over; ``stable`` refers to the motion at a fixed base level.
    at : array_like, optional
        Direction of the controlled sensor, shape (n,).
    level : float, optional
        Target amplitude at the sensor [m, m/s or m/s^2].
    quantity : {"acceleration", "velocity", "displacement"}, optional
        Quantity of the sensor that is controlled.
    supports : sequence of int, optional
        Indices of the degrees of freedom that are moved. By default the matrices describe a
        structure fixed to one rigid base, and displacements are relative to this base.
    damping_frame : {"base", "ground"}, optional
        Where the dashpots that resist rigid motion are fixed, such as those of a part of C
        proportional to M; required if C has such a part.
    joints_on_base : bool, optional
        Whether joints connect the structure to the base. If not, ``directions`` that deform a
        joint raise an InputError.
    harmonics, samples : optional
        As for :meth:`modes`.

    Returns
    -------
    BaseResponse
        Relative and absolute motions, acceleration of the base, force that moves the base, and
        transmissibilities.

    Notes
    -----
    For one rigid base the relative displacement y obeys
    M y'' + C y' + K y + joint forces = -M R a. If supports move relative to each other, y is
    relative to the static response with sticking joints, which also moves the joints. At the peak
    of a mode with modal amplitude q, |shape^T M R| a = 2 zeta omega^2 q.
    """
    base = base_motion(rest, directions, supports, damping_frame, joints_on_base)
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
    basis = harmonic_basis(rest._orders(harmonics), samples)
    forces = {0: coefficients(base.push @ given, basis)}
    if base.viscous_push is not None:
        # The velocity is a/(i omega).
        forces[1] = coefficients(base.viscous_push @ (-1j * given), basis)
    motions: dict[int, Floats] = {}
    line = line_of(model, forces[0], targets)
    if not line.any() and not base.strains:
        raise InputError(
            "directions must be a motion that strains the structure: no mode is excited"
        )
    joints = model.joints(line)
    if base.strains:
        motions[2] = coefficients(-joints.carried(base.carried) @ given, basis)
    rigid = model.free.T @ (base.inertia @ given)
    controlled = None
    if control == "response":
        controlled = _control(base, given, at, level, quantity)
    elif level is not None or at is not None:
        raise InputError('at and level belong to control="response"; the base has `acceleration`')
    drive = Drive(Balance(model, joints, basis), forces, motions, rigid, controlled)
    return _response(base, given, drive, targets)


def _control(
    base: BaseMotion,
    given: NDArray[np.complex128],
    at: ArrayLike | None,
    level: float | None,
    quantity: MotionQuantity,
) -> Control:
    if at is None or level is None:
        raise InputError(
            'control="response" needs the sensor at=direction and its target level=...'
        )
    sensor = vector("at", at, base.carried.shape[0])
    target = positive("level", level, "", 10.0)
    moved = complex(sensor @ (-base.carried @ given))
    free = complex(sensor @ (base.model.free @ (base.model.free.T @ (base.inertia @ given))))
    carried = np.array([(moved + free).real, -(moved + free).imag])
    modal = base.model.shapes.T @ sensor
    if not carried.any() and not modal.any():
        raise InputError("at must be a direction in which the structure moves")
    return Control(modal, carried, power_of(quantity), target)


def _response(
    base: BaseMotion, given: NDArray[np.complex128], drive: Drive, targets: Floats
) -> BaseResponse:
    path, fields = follow(drive, targets)
    basis, joints = drive.balance.basis, drive.balance.joints
    first = basis.harmonics.index(1)
    shapes, coordinates = fields["_shapes"], fields["_coordinates"]
    levels = np.array([solved.point.level for solved in path]).reshape(-1, 1)
    acceleration = levels * given
    omegas = 2.0 * np.pi * fields["frequency"]
    turning = 1j * np.array(basis.harmonics) * omegas[:, None]
    moved = -acceleration / omegas[:, None] ** 2

    def along(columns: Any, order: int, absolute: bool = True) -> NDArray[np.complex128]:
        """Return the harmonics of the motion along ``columns``, (points, inputs, harmonics).

        ``order`` is that of the time derivative; ``absolute`` includes the motion of the base.
        """
        part = (columns.T @ shapes) @ coordinates
        if absolute:
            part[:, :, first] += moved @ (base.carried.T @ columns)
        return np.asarray(part * turning[:, None, :] ** order)

    # The force of the supports: all forces on the structure, projected on the carried motion.
    force = along(base.inertia, 2)
    if base.drag is not None:
        force += along(base.drag, 1)
    if base.strains:
        force += along(np.asarray(base.rest.stiffness @ base.carried), 0)
        if base.rest.damping is not None and base.drag is None:
            force += along(np.asarray(base.rest.damping @ base.carried), 1, absolute=False)
        sides = joints.split(joints.carried(base.carried))
        for i, solved in enumerate(path):
            q, omega, level = solved.point
            motion = at_frequency(drive.motions, omega)[0]
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
