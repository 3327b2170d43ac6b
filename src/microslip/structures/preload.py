"""A structure at rest under its static forces, and its motion about that state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, number, show, whole_number
from microslip._core.wording import quoted
from microslip.errors import InputError
from microslip.numerics.threads import single_threaded
from microslip.structures.base_motion import (
    BaseMotion,
    BaseResponse,
    ControlOf,
    Frame,
    base_motion,
    base_response,
)
from microslip.structures.forced import ForcedResponse, forced_response
from microslip.structures.geometry import HARMONICS as GEOMETRY_HARMONICS
from microslip.structures.geometry import GeometryAttachment
from microslip.structures.joint_groups import FieldAttachment
from microslip.structures.matrices import linear_modes
from microslip.structures.modal_curve import ModalCurve
from microslip.structures.modal_model import Answer, ModalModel, stuck_stiffness
from microslip.structures.motion import Motion, integrate
from microslip.structures.nonlinear_mode import ModeSolver
from microslip.structures.periodic_motion import (
    HARMONICS,
    Quantity,
    amplitude_measure,
    checked_amplitudes,
    harmonic_basis,
)
from microslip.structures.random_vibration import (
    RandomMethod,
    RandomResponse,
    by_joints,
    by_modes,
)
from microslip.structures.shock import ShockResponse, shock
from microslip.structures.static import AtRest

_Answer = TypeVar("_Answer", bound=Answer)
Method = Literal["harmonic-balance", "quasi-static"]


class LinearModes(NamedTuple):
    """Modes of a structure whose joints are linear springs."""

    frequency: Floats
    """Frequencies [Hz], rising; rigid motions are among them."""
    shape: Floats
    """Shapes (n, modes), each of modal mass 1 kg."""


_MOST_MODES = 100_000


@dataclass(frozen=True, eq=False, repr=False)
class Preload(AtRest):
    """A structure at rest; made by :meth:`microslip.Structure.preload`."""

    # -- linear motion about it -------------------------------------------------------------------

    @property
    def _elastic(self) -> ModalModel:
        """The same, where there is a mode at all."""
        if not self.model.size:
            raise InputError(
                "nothing holds the structure in any motion: it has no elastic mode; give it a "
                "stiffness, or joints that hold it"
            )
        return self.model

    @single_threaded
    def linear_modes(self, count: int = 10, *, joints: str = "stuck") -> LinearModes:
        """Modes of small motion.

        Parameters
        ----------
        count : int, optional
            Number of modes.
        joints : {"stuck", "open"}, optional
            Joints as springs of their stiffness at rest, or none at all.

        Returns
        -------
        LinearModes
            ``frequency`` [Hz] and ``shape``.
        """
        if joints not in ("stuck", "open"):
            raise InputError(f'joints must be "stuck" or "open", got {show(joints)}')
        count = whole_number("count", count, 1, _MOST_MODES)
        stiffness = self.stiffness
        if joints == "stuck":
            stiffness = stuck_stiffness(stiffness, self.attachments, self._motions)
        squares, shapes = linear_modes(stiffness, self.mass, min(count, self.static_force.size))
        frequency = np.sqrt(np.maximum(squares, 0.0)) / (2.0 * math.pi)
        return LinearModes(frequency, shapes)

    # -- nonlinear modes --------------------------------------------------------------------------

    @single_threaded
    def modes(
        self,
        index: int,
        amplitudes: ArrayLike,
        *,
        harmonics: Sequence[int] | None = None,
        method: Method = "harmonic-balance",
        samples: int = 64,
        at: ArrayLike | None = None,
        quantity: Quantity = "displacement",
        damping_ratio: float = 0.0,
    ) -> ModalCurve:
        """Frequency and damping of a mode against its amplitude.

        Parameters
        ----------
        index : int
            Which elastic mode, 0 the lowest of the structure whose joints stick.
        amplitudes : array_like
            One-dimensional, above zero, of the fundamental harmonic: modal ones a = sqrt(x1^H M x1)
            [m kg^(1/2)], or what a sensor shows.
        harmonics : sequence of int, optional
            Harmonics of the motion; its mean is always among them. (0, 1, 2, 3) unless given, with
            a geometry to 5. The second counts where faces
            part; :attr:`ModalCurve.harmonic_error` tells what those beyond the set would change.
        method : {"harmonic-balance", "quasi-static"}, optional
            The reference, or the quick look. The curve tells their difference.
        samples : int, optional
            Samples of a period at which nodes of fields are looked at.
        at : array_like, optional
            Direction (n,) of a sensor, at which the amplitudes are meant.
        quantity : {"displacement", "velocity", "acceleration"}, optional
            Quantity that the sensor measures: [m], [m/s] or [m/s^2].
        damping_ratio : float, optional
            Base damping [-] of all but the joints, which is added; it is an input, no result.

        Returns
        -------
        ModalCurve
            Frequencies [Hz], damping ratios, shapes and the loss of each joint.

        Notes
        -----
        The balance is that of the extended periodic motion, M x'' + C x' - 2 zeta omega M x' + K x
        + joints = static forces (Krack 2015, DOI 10.1016/j.compstruc.2015.03.008). In a field each
        node follows the exact coupled law along its line of motion in the mode, under a separation
        that varies; across that line it sticks.
        """
        index = whole_number("index", index, 0, _MOST_MODES)
        if method not in get_args(Method):
            raise InputError(f"method must be {quoted(get_args(Method))}, got {show(method)}")
        a = checked_amplitudes(amplitudes)
        basis = harmonic_basis(self._orders(harmonics), samples)
        base = base_damping(damping_ratio)
        model = self._elastic
        if index >= model.size:
            raise InputError(f"index must be below {model.size}, the elastic modes, got {index}")
        measure = amplitude_measure(at, quantity, model.shapes, index)

        solver = ModeSolver(model, index, a, measure, basis, base)
        balanced = method == "harmonic-balance"
        return self._within_reach(solver.balanced() if balanced else solver.quasi_static())

    def _orders(self, harmonics: Sequence[int] | None) -> Sequence[int]:
        """Harmonics that were asked for, or those that the joints and the geometry need."""
        if harmonics is not None:
            return harmonics
        return GEOMETRY_HARMONICS if self._bends else HARMONICS

    @property
    def _bends(self) -> list[GeometryAttachment]:
        return [a for a in self.attachments if isinstance(a, GeometryAttachment)]

    def _within_reach(self, answer: _Answer) -> _Answer:
        """The motion, or an error where it goes beyond what a geometry was told by."""
        for geometry in self._bends:
            columns = geometry.coordinates
            before = 0.0 if geometry.rest is None else geometry.rest
            geometry.check_reach(np.abs(columns.T @ (self.displacement - before)))
            geometry.check_reach(answer._sizes(columns))
        return answer

    @single_threaded
    def forced_response(
        self,
        force: ArrayLike,
        frequencies: ArrayLike,
        *,
        harmonics: Sequence[int] | None = None,
        samples: int = 64,
    ) -> ForcedResponse:
        """Periodic motions under a harmonic force, along a range of frequencies.

        Parameters
        ----------
        force : array_like
            Amplitudes F (n,) [N] of the force Re(F exp(i omega t)), complex for other phases.
        frequencies : array_like
            Frequencies [Hz], one-dimensional, rising or falling; between them the path takes steps
            of its own.
        harmonics, samples : optional
            As for :meth:`modes`.

        Returns
        -------
        ForcedResponse
            Frequencies along the path, amplitudes of each harmonic, turning points.

        Notes
        -----
        The balance of harmonics is followed by arc length, around the turning points where the
        response folds over (Krack and Gross 2019, DOI 10.1007/978-3-030-14023-6). Damping is that
        of the joints and of C. A curve of :meth:`modes` gives the response near one resonance in
        closed form.
        """
        orders = self._orders(harmonics)
        response = forced_response(self._elastic, force, frequencies, orders, samples)
        return self._within_reach(response)

    # -- on a moving base -------------------------------------------------------------------------

    def _base(
        self,
        directions: ArrayLike,
        supports: Sequence[int] | None,
        damping_frame: Frame | None,
        joints_on_base: bool,
    ) -> BaseMotion:
        return base_motion(self, directions, supports, damping_frame, joints_on_base)

    @single_threaded
    def base_response(
        self,
        *,
        directions: ArrayLike,
        acceleration: Any,
        frequencies: ArrayLike,
        control: ControlOf = "base",
        at: ArrayLike | None = None,
        level: float | None = None,
        quantity: Quantity = "acceleration",
        supports: Sequence[int] | None = None,
        damping_frame: Frame | None = None,
        joints_on_base: bool = False,
        harmonics: Sequence[int] | None = None,
        samples: int = 64,
    ) -> BaseResponse:
        """Periodic motions on a shaker table, or on several supports, along frequencies.

        Parameters
        ----------
        directions : array_like
            The base's motion R: what each degree of freedom moves by with it, shape (n,), or
            (n, inputs); with ``supports`` what each of these moves by, (supports,) or
            (supports, inputs).
        acceleration : complex or array_like
            Amplitude of the base's acceleration a [m/s^2], Re(a exp(i omega t)), one an input.
        frequencies : array_like
            Frequencies [Hz], one-dimensional, rising or falling.
        control : {"base", "response"}, optional
            Quantity controlled in the sweep: the base's acceleration, or the motion of a sensor
            as seen from the ground, by a level of the base that follows. Such a response does not
            fold over; ``stable`` is that of the motion at a fixed level.
        at : array_like, optional
            Direction (n,) of the sensor that is held.
        level : float, optional
            Amplitude at which it is held [m, m/s or m/s^2].
        quantity : {"acceleration", "velocity", "displacement"}, optional
            Quantity of the sensor that is controlled.
        supports : sequence of int, optional
            Degrees of freedom of these matrices that are moved. Without them the matrices are of a
            structure that is held by its base, all in one piece, and motions count from it.
        damping_frame : {"base", "ground"}, optional
            Frame of the dashpots that resist rigid motion, as a part of C proportional to M does.
        joints_on_base : bool, optional
            Whether joints that ``directions`` would move hold the structure to the base.
        harmonics, samples : optional
            As for :meth:`modes`.

        Returns
        -------
        BaseResponse
            Motions relative and absolute, the base's acceleration and the force that moves it,
            transmissibilities.

        Notes
        -----
        Of a rigid base M y'' + C y' + K y + joints = -M R a. Where supports move against another
        the motion counts from the static answer of the structure with sticking joints, and each
        joint is carried along by it. At the peak of a mode |shape^T M R| a = 2 zeta omega^2 q.
        """
        base = self._base(directions, supports, damping_frame, joints_on_base)
        orders = self._orders(harmonics)
        return self._within_reach(
            base_response(
                base, acceleration, frequencies, control, at, level, quantity, orders, samples
            )
        )

    @single_threaded
    def random_response(
        self,
        psd: Any,
        *,
        directions: ArrayLike,
        method: RandomMethod | None = None,
        modes: int = 2,
        supports: Sequence[int] | None = None,
        damping_frame: Frame | None = None,
        joints_on_base: bool = False,
        damping_ratio: float = 0.0,
        harmonics: Sequence[int] | None = None,
        samples: int = 64,
    ) -> RandomResponse:
        """Stationary motion on a base that moves at random.

        Parameters
        ----------
        psd : array_like
            Frequencies [Hz] and one-sided levels [(m/s^2)^2/Hz] of the base's acceleration, shape
            (2, points) or (points, 2), straight in between and nothing outside.
        directions, supports, damping_frame, joints_on_base : optional
            As for :meth:`base_response`, of one input.
        method : {"joints", "modes"}, optional
            Each joint linearised by itself, for laws along directions; or the first modes by their
            curves, which fields of contact need. What the joints allow unless given.
        modes : int, optional
            Number of modes, by ``modes``, those that move most; others are linear.
        damping_ratio : float, optional
            Base damping [-] of the curves, by ``modes``.
        harmonics, samples : optional
            Amplitudes of the curves, as for :meth:`modes`.

        Returns
        -------
        RandomResponse
            Standard deviations, peaks, equivalent frequencies and damping ratios, the power that
            joints lose, and verdicts on what was assumed.

        Notes
        -----
        The amplitude a of a joint in narrow-band noise is distributed as Rayleigh has it. A spring
        E[a^2 k(a)]/E[a^2] and a dashpot that loses the mean energy of a cycle stand for it, k(a)
        the stiffness of the fundamental harmonic. Spring and dashpot depend on the motion that they
        allow: a fixed point, found in some ten rounds. Two modes that move one joint, and gross
        slip, are judged by ``verdicts``.
        """
        base = self._base(directions, supports, damping_frame, joints_on_base)
        fields = any(isinstance(a, FieldAttachment) for a in self.attachments)
        if method not in (None, *get_args(RandomMethod)):
            words = quoted(get_args(RandomMethod))
            raise InputError(f"method must be {words}, got {show(method)}")
        share = base_damping(damping_ratio)
        if (method or ("modes" if fields or self._bends else "joints")) == "joints":
            if share:
                raise InputError(
                    '`damping_ratio` is that of method="modes"; by joints the structure has its '
                    f"own damping matrix, got {share:g}"
                )
            return by_joints(base, psd)
        basis = harmonic_basis(self._orders(harmonics), samples)

        def curve(index: int, amplitudes: Floats) -> ModalCurve:
            measure = amplitude_measure(None, "displacement", base.model.shapes, index)
            return ModeSolver(base.model, index, amplitudes, measure, basis, share).balanced()

        count = whole_number("modes", modes, 1, _MOST_MODES)
        return self._within_reach(by_modes(base, psd, count, curve))

    @single_threaded
    def shock(
        self,
        pulse: Any,
        *,
        directions: ArrayLike,
        duration: float | None = None,
        supports: Sequence[int] | None = None,
        damping_frame: Frame | None = None,
        joints_on_base: bool = False,
        damping_ratio: float = 0.0,
    ) -> ShockResponse:
        """The motion under a pulse of the base.

        Parameters
        ----------
        pulse : Pulse or pair of array_like
            ``ms.Pulse.half_sine(amplitude, duration)``, or times [s] and accelerations [m/s^2],
            one-dimensional.
        directions, supports, damping_frame, joints_on_base : optional
            As for :meth:`base_response`, of one rigid base.
        duration : float, optional
            End of the motion [s]; five periods after the pulse unless given.
        damping_ratio : float, optional
            Base damping of each mode [-], besides C.

        Returns
        -------
        ShockResponse
            ``peak(at)`` and ``history(at)`` of displacements, velocities and accelerations.

        Notes
        -----
        Integrated with the state of each joint, as :meth:`integrate` has it, in 200 steps for a
        period of the mode that the base moves most and 50 for the pulse at least: peaks of
        displacements to some 1e-3, of accelerations to 2 % where faces part, else to 1e-3.
        """
        base = self._base(directions, supports, damping_frame, joints_on_base)
        return self._within_reach(shock(base, pulse, duration, base_damping(damping_ratio)))

    # -- motion in time ---------------------------------------------------------------------------

    @single_threaded
    def integrate(
        self,
        force: Any,
        time: ArrayLike,
        *,
        displacement: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        spectral_radius: float | None = None,
    ) -> Motion:
        """The motion in time under forces besides the static ones, or after a release.

        Parameters
        ----------
        force : array_like, callable or None
            Forces [N] of shape (times, n), or a function of the time [s] that gives n forces.
        time : array_like
            Times [s] in even steps, one-dimensional: the steps of the method.
        displacement : array_like, optional
            Displacements at the beginning (n,) [m] from the state of rest; the joints are loaded
            straight to them.
        velocity : array_like, optional
            Velocities at the beginning (n,) [m/s].
        spectral_radius : float, optional
            Spectral radius for very fast motion, 0 to 1; 1 adds no damping of its own. Asks for
            the generalised-alpha method.

        Returns
        -------
        Motion
            Displacements, velocities, joint motions and forces, and the balance of energy.

        Notes
        -----
        Where all joints are laws along directions and no damping couples the modes, each mode is
        exact under joint forces that are cubics in time over a step (Hochbruck and Ostermann 2010,
        DOI 10.1017/S0962492910000048). Elsewhere, as where faces part, it is the generalised-alpha
        method (Chung and Hulbert 1993, DOI 10.1115/1.2900803; spectral radius 0.9), of second
        order: 256 steps a period leave some 1e-4 of the frequency, four times as many a sixteenth.
        Nodes of fields move along their line as in :meth:`modes`, that of the motion at the
        beginning or of the strongest force.
        """
        motion = integrate(
            self.model, self.mass, self.stiffness, force, time, displacement, velocity,
            spectral_radius,
        )  # fmt: skip
        return self._within_reach(motion)

    def __repr__(self) -> str:
        return f"Preload({self.static_force.size} degrees of freedom, {self.message})"


def base_damping(value: Any) -> float:
    """A damping ratio of all but the joints [-], or an error."""
    ratio = number("damping_ratio", value, example=0.001)
    if not 0.0 <= ratio < 1.0:
        raise InputError(f"damping_ratio must be from 0 to below 1, got {exact(ratio)}")
    return ratio
