"""Structure with joints on a base in random vibration, by statistical linearisation.

Each joint is replaced by a spring and a dashpot with the same stiffness and loss on average over
the amplitudes of its motion, which in narrow-band Gaussian motion have a Rayleigh distribution. For
contact fields the frequency and damping of each mode are averaged over amplitudes in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, positive, record, show, whole_number
from microslip._core.errors import InputError
from microslip._core.verdicts import Rule, Verdict
from microslip._core.wording import quoted
from microslip.structures.base_motion import BaseMotion, Frame, base_motion
from microslip.structures.joint_groups import FieldAttachment, LawGroup
from microslip.structures.modal_curve import ModalCurve
from microslip.structures.modal_model import ModalResult
from microslip.structures.nonlinear_mode import ModeSolver
from microslip.structures.periodic_motion import (
    MotionQuantity,
    amplitude_measure,
    averaged_stiffness,
    harmonic_basis,
    power_of,
)
from microslip.structures.spectral_response import (
    BaseSpectrum,
    Variances,
    linear_structure,
)
from microslip.structures.static import MOST_MODES, AtRest, base_damping, solver_method

RandomMethod = Literal["joints", "modes"]
_NODES = 32
_ROUNDS = 100
_ENOUGH = 1e-4
_LEAST = 1e-3  # of the mode that moves most: modes that move less do not feel their joints
_X, _MEAN = np.polynomial.laguerre.laggauss(_NODES)
_AMPLITUDES = np.sqrt(2.0 * _X)
"""Quadrature nodes and weights for means over Rayleigh amplitudes of unit standard deviation."""

OUTSIDE = Rule(
    "motion beyond the strongest mode",
    watch=0.05,
    outside=0.3,
    meaning="One mode moves the joints: fraction of the velocity variance due to other modes.",
    reason="If several modes moved one joint, its power was underestimated by 15 to 39 %.",
    remedy="Integrate in time for the power of these joints; standard deviations remain valid.",
)
SOFTENING = Rule(
    "loss of a joint's stiffness",
    watch=0.4,
    outside=0.7,
    meaning="Joints slip only partly: fraction of its stiffness at rest that a joint loses.",
    reason=(
        "At 0.3 the kurtosis of the motion is 3.1, at 0.6 3.9, at 0.9 4 to 8, and peaks reach 6 to "
        "9 standard deviations where Gaussian ones reach 4.4."
    ),
    remedy="Integrate in time for peaks, or increase the normal loads of the joints.",
)


MODAL_SOFTENING = replace(
    SOFTENING,
    name="fall of a mode's stiffness",
    watch=0.1,
    outside=0.3,
    meaning="Joints slip only partly: fraction of its stiffness that a mode loses.",
)


@dataclass(frozen=True, eq=False, repr=False)
class RandomResponse(ModalResult):
    """Stationary random motion, the result of ``structure.random_response(...)``.

    By statistical linearisation over Rayleigh amplitudes (Caughey 1960, DOI 10.1115/1.3644075).
    Displacements and velocities are relative to the base, accelerations to the ground.
    """

    method: RandomMethod
    """``joints``: each joint linearised by itself; ``modes``: curves of the modes averaged."""
    frequency: Floats
    """Equivalent frequencies of the modes in the band of the noise [Hz]."""
    damping_ratio: Floats
    """Equivalent damping ratios of the modes [-]."""
    joint_deviation: Floats
    """Standard deviation of each joint's motion [m]; NaN by ``modes``."""
    joint_power: Floats
    """Power dissipated in each joint or node [W]."""
    iterations: int
    """Number of fixed-point iterations."""
    message: str
    """Outcome: solved, or where and why the solver stopped."""
    verdicts: tuple[Verdict, ...]
    """Verdicts on the assumptions that one mode moves each joint and that joints slip partly."""
    _shapes: Floats
    _carried: Floats
    _variances: Variances
    _answer: Callable[[Floats], tuple[NDArray[Any], NDArray[Any]]]
    """Function that returns modal coordinates (frequencies, modes) per unit base acceleration,
    and motions of the joints."""
    _spectrum: BaseSpectrum

    def _sizes(self, columns: Floats) -> Floats:
        """Return three times the standard deviation of the motion along columns (n, k) [m]."""
        modal = columns.T @ self._shapes
        squares = np.einsum("km,mn,kn->k", modal, self._variances.displacement, modal)
        return np.asarray(3.0 * np.sqrt(squares))

    def _reading(self, at: ArrayLike, quantity: MotionQuantity) -> tuple[float, float]:
        """Return the variances of the signal of a sensor and of its time derivative."""
        power = power_of(quantity)
        modal = self._at(at)
        if power == 2:
            modal = np.append(modal, self._carried_at(at))
        n, pair = modal.size, self._variances[power : power + 2]  # accelerations with the base's
        signal, rate = (float(modal @ part[:n, :n] @ modal) for part in pair)
        return signal, rate

    def standard_deviation(self, at: ArrayLike, quantity: MotionQuantity = "displacement") -> float:
        """Return the standard deviation at a sensor.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).
        quantity : {"displacement", "velocity", "acceleration"}, optional
            Displacement [m] or velocity [m/s] relative to the base, or acceleration [m/s^2]
            relative to the ground.

        Returns
        -------
        float
            Standard deviation of this quantity.
        """
        return math.sqrt(max(self._reading(at, quantity)[0], 0.0))

    def spectrum(
        self, at: ArrayLike, frequencies: ArrayLike, quantity: MotionQuantity = "displacement"
    ) -> Floats:
        """Return the power spectral density at a sensor, of the equivalent linear structure.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).
        frequencies : array_like
            Frequencies [Hz] above zero, one-dimensional.
        quantity : {"displacement", "velocity", "acceleration"}, optional
            As for :meth:`standard_deviation`.

        Returns
        -------
        ndarray
            One-sided densities [unit^2/Hz], zero outside the frequencies of the base spectrum.
        """
        power, modal = power_of(quantity), self._at(at)
        f = np.atleast_1d(record("frequencies", frequencies, "Hz"))
        omega = 2.0 * math.pi * np.array([positive("frequencies", x, "Hz", 100.0) for x in f])
        signal = (self._answer(omega)[0] @ modal) * (1j * omega) ** power
        if power == 2:
            signal = signal + self._carried_at(at)
        return np.asarray(np.abs(signal) ** 2 * self._spectrum.at(f))

    def peak(
        self, at: ArrayLike, duration: float, quantity: MotionQuantity = "displacement"
    ) -> float:
        """Return the expected largest excursion at a sensor, for Gaussian motion (Davenport 1964).

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).
        duration : float
            Duration of the noise [s].
        quantity : {"displacement", "velocity", "acceleration"}, optional
            As for :meth:`standard_deviation`.

        Returns
        -------
        float
            Expected peak [m, m/s or m/s^2]; in gross slip peaks are larger, see
            ``verdicts``.
        """
        length = positive("duration", duration, "s", 60.0)
        signal, rate = self._reading(at, quantity)
        crossings = math.sqrt(rate / signal) / math.pi * length  # of either side
        factor = math.sqrt(2.0 * math.log(max(crossings, math.e)))
        return (factor + 0.5772 / factor) * math.sqrt(signal)

    def __repr__(self) -> str:
        numbers = ", ".join(
            f"{f:.4g} Hz at {100.0 * z:.3g} %"
            for f, z in zip(self.frequency[:3], self.damping_ratio[:3], strict=True)
        )
        return f"RandomResponse({numbers}, {self.message})"


def _linearised(
    groups: Sequence[LawGroup], deviation: Floats, rate: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return equivalent springs and dashpots of joints, and their mean loss per cycle [J].

    Springs [N/m] are relative to sticking joints; ``deviation`` [m] and ``rate`` [m/s] are the
    standard deviations of displacement and velocity. All have the shape (coordinates,).
    """
    softer, dashpots, energies = np.zeros((3, deviation.size))
    laws = [group.law for group in groups for _ in range(group.static.size)]
    for place, law in enumerate(laws):
        sigma = float(deviation[place])
        if sigma > 0.0 and rate[place] > 0.0:
            a = sigma * _AMPLITUDES
            energies[place] = np.asarray(law.dissipated_energy(a)) @ _MEAN
            square = 2.0 * sigma**2
            mean = float((a**2 * averaged_stiffness(law, a)) @ _MEAN) / square
            softer[place] = mean - law.tangential_stiffness
            # An amplitude's cycle in the time that its motion takes.
            dashpots[place] = energies[place] / (math.pi * square) * sigma / rate[place]
    return softer, dashpots, energies


def _fixed_point(advance: Callable[[float], float], enough: float, what: str) -> tuple[int, str]:
    """Iterate until the relative change returned by ``advance(relaxation)`` is below ``enough``.

    Return the number of rounds, and a message on the outcome, where ``what`` names the unknown.
    """
    change = math.inf
    for rounds in range(1, _ROUNDS + 1):
        change = advance(1.0 if rounds < 5 else 0.7)
        if change < enough:
            return rounds, f"solved in {rounds} rounds"
    return rounds, f"stopped after {rounds} rounds: the {what} still changes by {change:.1e}"


def _by_joints(base: BaseMotion, psd: object) -> RandomResponse:
    spectrum = BaseSpectrum.of(psd)
    joints = base.model.joints(base.push[:, 0] / base.model.squares)
    groups = [group for group in joints.groups if isinstance(group, LawGroup)]
    if len(groups) < len(joints.groups):
        raise InputError('method must be "modes" for fields of contact and for a geometry')
    carried = joints.carried(base.carried)[:, 0] if base.strains else np.zeros(joints.stuck.size)
    linear = linear_structure(base, spectrum, joints.flat, carried)
    softer, dashpots, energies = np.zeros((3, joints.stuck.size))
    variances = linear.variances(softer, dashpots)

    def advance(share: float) -> float:
        nonlocal softer, dashpots, energies, variances
        before = np.sqrt(variances.joints)
        new, slowing, energies = _linearised(groups, before, np.sqrt(variances.joint_rates))
        softer, dashpots = (
            old + share * (aim - old) for old, aim in ((softer, new), (dashpots, slowing))
        )
        variances = linear.variances(softer, dashpots)
        moved = np.abs(np.sqrt(variances.joints) - before)
        return float((moved / np.where(before > 0.0, before, 1.0)).max(initial=0.0))

    rounds, message = _fixed_point(advance, _ENOUGH, "joints' motion")
    deviation, rate = np.sqrt(variances.joints), np.sqrt(variances.joint_rates)
    turns = np.where(deviation > 0.0, rate / np.where(deviation > 0.0, deviation, 1.0), 0.0)
    power = energies * turns / (2.0 * math.pi)
    poles = linear.poles(softer, dashpots)
    lost = float((-softer / joints.stuck).max(initial=0.0)) if joints.stuck.size else None
    # A joint with a negligible loss is not judged by the number of modes that move it.
    losing = power > 0.01 * power.max(initial=0.0)
    aside = float(variances.outside[losing].max()) if losing.any() else None
    inside = (np.abs(poles) >= 2.0 * math.pi * spectrum.frequency[0]) & (
        np.abs(poles) <= 2.0 * math.pi * spectrum.frequency[-1]
    )
    poles = poles[inside]
    return RandomResponse(
        "joints", np.abs(poles) / (2.0 * math.pi), -poles.real / np.abs(poles), deviation,
        power, rounds, message,
        (OUTSIDE.judge(aside), SOFTENING.judge(lost)), base.model.shapes, base.carried[:, 0],
        variances, partial(linear.answer, softer=softer, dashpots=dashpots), spectrum,
    )  # fmt: skip


def _by_modes(
    base: BaseMotion, psd: object, modes: int, curve: Callable[[int, Floats], ModalCurve]
) -> RandomResponse:
    """Return the response with amplitude curves for the modes that move most; others are linear.

    The frequency and damping of such a mode are means of its curve over Rayleigh amplitudes,
    weighted with the squared amplitude.
    """
    model, spectrum, idle = base.model, BaseSpectrum.of(psd), np.zeros(0)
    linear = linear_structure(base, spectrum, np.zeros((model.size, 0)), idle)
    count = model.joints(base.push[:, 0] / model.squares).stuck.size
    if base.strains:
        raise InputError("supports that move against another need joints of laws along directions")
    damping = linear.damping.copy()
    if not damping.any():
        # Of the curves' own smallest amplitudes, so that the first round has a resonance.
        damping[np.diag_indices(model.size)] = 2e-3 * np.sqrt(model.squares)
    variances = replace(linear, damping=damping).variances(idle, idle)
    moving = np.diag(variances.displacement)
    chosen = np.sort(np.argsort(-moving)[:modes])
    chosen = chosen[moving[chosen] > _LEAST**2 * moving.max()]
    curves: dict[int, ModalCurve] = {}
    loss = np.zeros(0)
    squares, shapes, push = model.squares.copy(), model.shapes.copy(), linear.push.copy()
    lost, current = "", linear

    def advance(share: float) -> float:
        nonlocal squares, damping, loss, lost, current, variances
        deviation = np.sqrt(np.diag(variances.displacement))
        damping, shifted, power = linear.damping.copy(), model.squares.copy(), []
        for j in chosen.tolist():
            a = deviation[j] * _AMPLITUDES
            known = curves.get(j)
            # A curve is made again unless it holds the amplitudes that count.
            low, high = 0.3 * deviation[j], 3.0 * deviation[j]
            if known is None or not known.amplitude.min() < low < high < known.amplitude.max():
                amplitudes = deviation[j] * np.geomspace(0.05, 4.5, 14)
                known = curves[j] = curve(j, amplitudes)
                if not known.converged.any():
                    raise InputError(f"psd is too strong for mode {j}: {known.message}")
            good = np.flatnonzero(known.converged)
            if not known.converged.all():
                lost = f"; mode {j} {known.message}"
            solved = known.modal_amplitude[good]
            within = np.clip(a, solved.min(), solved.max())  # constant beyond the ends of the curve
            along = partial(_interpolated, solved, at=within)
            omega = 2.0 * math.pi * along(known.frequency[good])
            zeta = along(known.damping_ratio[good])
            square = 2.0 * deviation[j] ** 2
            shifted[j] = float((a**2 * omega**2) @ _MEAN) / square
            rate = float((a**2 * 2.0 * zeta * omega) @ _MEAN) / square
            damping[j, :], damping[:, j], damping[j, j] = 0.0, 0.0, rate
            turns = math.sqrt(shifted[j]) / (2.0 * math.pi)
            # Losses over the amplitude's cube vary slowly.
            cubes = solved[:, None] ** 3
            lost_in_cycles = along(known.loss[good] / cubes) * within[:, None] ** 3
            power.append(lost_in_cycles.T @ _MEAN * turns)
            by_shape = along(known.shape[good].real) * (a**2)[:, None]
            shapes[:, j] = by_shape.T @ _MEAN / square
        loss = np.sum(power, axis=0)
        squares = squares + share * (shifted - squares)
        push[chosen] = -shapes[:, chosen].T @ base.inertia[:, 0]
        current = replace(linear, squares=squares, damping=damping, push=push)
        variances = current.variances(idle, idle)
        after = np.sqrt(np.diag(variances.displacement)[chosen])
        return float(np.abs(after / deviation[chosen] - 1.0).max())

    rounds, message = _fixed_point(advance, 10.0 * _ENOUGH, "motion")
    message += lost
    omega = np.sqrt(squares[chosen])
    rates = np.diag(variances.velocity)[chosen]
    softening = float((1.0 - squares[chosen] / model.squares[chosen]).max())
    return RandomResponse(
        "modes", omega / (2.0 * math.pi), np.diag(damping)[chosen] / (2.0 * omega),
        np.full(count, np.nan), loss, rounds, message,
        (OUTSIDE.judge(1.0 - float(rates.max() / rates.sum())), MODAL_SOFTENING.judge(softening)),
        shapes, base.carried[:, 0], variances,
        partial(current.answer, softer=idle, dashpots=idle), spectrum,
    )  # fmt: skip


def _interpolated(amplitudes: Floats, values: Floats, at: Floats) -> Floats:
    """Interpolate a curve over the logarithm of the amplitude."""
    from scipy.interpolate import PchipInterpolator

    order = np.argsort(amplitudes)
    if order.size < 2:
        return np.repeat(values[:1], at.size, axis=0)
    return np.asarray(PchipInterpolator(np.log(amplitudes[order]), values[order])(np.log(at)))


@solver_method
def random_response(
    rest: AtRest,
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
    """Compute the stationary random motion of a structure on a base in random vibration.

    Parameters
    ----------
    psd : array_like
        Power spectral density of the base acceleration: frequencies [Hz] and one-sided densities
        [(m/s^2)^2/Hz], shape (2, points) or (points, 2); linear in between, zero outside.
    directions, supports, damping_frame, joints_on_base : optional
        As for :meth:`base_response`, with one input.
    method : {"joints", "modes"}, optional
        ``joints`` linearises each joint by itself and needs backbone laws; ``modes`` averages
        curves of :meth:`modes`, as contact fields need. By default ``joints`` where possible.
    modes : int, optional
        For ``modes``: number of modes with curves, those that move most; others are linear.
    damping_ratio : float, optional
        For ``modes``: damping ratio without the joints [-], added to the curves.
    harmonics, samples : optional
        For ``modes``: as for :meth:`modes`.

    Returns
    -------
    RandomResponse
        Standard deviations, peaks, equivalent frequencies and damping ratios, power dissipated by
        the joints, and verdicts on the assumptions.

    Notes
    -----
    In narrow-band noise the amplitude a of a joint has a Rayleigh distribution. The joint is
    replaced by a spring E[a^2 k(a)]/E[a^2], with the stiffness k(a) of the fundamental harmonic,
    and a dashpot that dissipates the mean energy per cycle. Both depend on the resulting motion and
    are found by fixed-point iteration, in about ten rounds. ``verdicts`` judge the assumptions that
    one mode moves each joint and that joints do not slip fully.
    """
    base = base_motion(rest, directions, supports, damping_frame, joints_on_base)
    fields = any(isinstance(a, FieldAttachment) for a in rest.attachments)
    if method not in (None, *get_args(RandomMethod)):
        words = quoted(get_args(RandomMethod))
        raise InputError(f"method must be {words}, got {show(method)}")
    share = base_damping(damping_ratio)
    if (method or ("modes" if fields or rest._geometric else "joints")) == "joints":
        if share:
            raise InputError(
                '`damping_ratio` is that of method="modes"; by joints the structure has its '
                f"own damping matrix, got {share:g}"
            )
        return _by_joints(base, psd)
    basis = harmonic_basis(rest._orders(harmonics), samples)

    def curve(index: int, amplitudes: Floats) -> ModalCurve:
        measure = amplitude_measure(None, "displacement", base.model.shapes, index)
        return ModeSolver(base.model, index, amplitudes, measure, basis, share).balanced()

    count = whole_number("modes", modes, 1, MOST_MODES)
    return _by_modes(base, psd, count, curve)
