"""Responses of a structure to forces and to a moving ground, with bands, from the modal curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.runs.structure_prediction import (
    NOISY,
    SHARES,
    SWEPT,
    ForcedMode,
    Mode,
    Sampled,
    ShakenBands,
    Shaking,
)
from microslip.structures import Convergence, FrequencyResponse, ModalCurve, Preload, ReducedJoint
from microslip.structures.forced import Node, six_digits
from microslip.structures.modal_curve import Resonant, refined, resonant, with_phase
from microslip.structures.periodic_motion import POWERS
from microslip.structures.random_vibration import AMPLITUDES, mean_over_amplitudes
from microslip.structures.spectral_response import LinearStructure, Spectrum
from microslip.study.schema import GROUPS
from microslip.study.structure import StructurePart
from microslip.sweeps.quantiles import quantiles

_DENSE = 512  # points at which responses interpolate between the samples
_FREQUENCIES = 121
_BETWEEN = 400  # points of a frequency response, even on a log axis, besides those near modes
_WIDTHS = 5.0  # half widths of the resonance that are shown beside the outermost peaks


def gain_of(curve: ModalCurve, joint: ReducedJoint) -> Floats:
    """Modal displacement at the sensor times that at the force, by amplitude [1/kg]."""
    return np.asarray(abs(_gain(curve, joint)))


def _gain(curve: ModalCurve, joint: ReducedJoint) -> Floats:
    sensed, pushed = (curve.shape @ joint.sensor(name) for name in ("sensor", "force"))
    return np.asarray(sensed * pushed.conj())


def forced_modes(
    part: StructurePart, joint: ReducedJoint, curve: ModalCurve, sampled: Sampled | None
) -> tuple[ForcedMode, ...]:
    """One for each force."""
    forces = () if part.force is None else part.force.amplitude
    return tuple(_forced(part, joint, curve, sampled, force) for force in forces)


def _forced(
    part: StructurePart,
    joint: ReducedJoint,
    curve: ModalCurve,
    sampled: Sampled | None,
    force: float,
) -> ForcedMode:
    power = POWERS[part.quantity]
    solved = curve.converged
    asked = part.amplitudes[solved]

    def answers(logs: Floats, base: Floats, at: Floats) -> Resonant:
        """In the sensor's quantity, of rows of ln frequency, ln zeta of the joint, ln gain."""
        fine, values = refined(asked, logs.reshape(len(logs), 3, -1))
        frequency, of_joint, gain = np.moveaxis(values, 1, 0)
        moved = fine / (2.0 * math.pi * frequency) ** power
        found = resonant(moved, frequency, of_joint + base[:, None], force * gain, at)
        peak = found.peak * (2.0 * math.pi * found.peak[:, 1:]) ** [power, 0]
        return Resonant(peak, found.beyond, found.amplitude * (2.0 * math.pi * at) ** power)

    frequency, damping = curve.frequency[solved], curve.damping_ratio[solved]
    gain = gain_of(curve, joint)[solved]
    base = np.array([curve.base_damping])
    row = np.log([frequency, damping - curve.base_damping, gain]).reshape(1, -1)
    middle = answers(row, base, np.ones(1))
    most = 2.0 * damping[-1] * asked[-1] * (2.0 * math.pi * frequency[-1]) ** (2 - power) / gain[-1]
    peaks = middle
    if sampled is not None:
        logs = np.log([sampled.frequency, sampled.joint_damping, sampled.gain])[:, :, solved]
        logs = np.moveaxis(logs, 0, 1).reshape(len(sampled.scores), -1)
        solved_rows = np.isfinite(logs).all(axis=1)
        peaks = answers(logs[solved_rows], sampled.base_damping[0][solved_rows], np.ones(1))
    ends = np.append(peaks.peak[:, 1], middle.peak[0, 1])
    width = float(np.exp(np.interp(np.log(middle.peak[0, 0]), np.log(asked), np.log(damping))))
    near = _WIDTHS * min(width, 0.05)
    at = np.linspace(ends.min() * (1.0 - near), ends.max() * (1.0 + near), _FREQUENCIES)
    response = answers(row, base, at).amplitude[0]
    reached = np.where(middle.beyond[0], math.nan, middle.peak[0])
    plain = ForcedMode(force, at, response, reached, None, None, math.nan, 0.0, float(most))
    if sampled is None:
        return plain._replace(beyond=float(middle.beyond[0]))

    def of_points(points: Floats, base: Floats) -> Floats:
        found = answers(points, base, at)
        return np.log(np.hstack([found.peak, found.amplitude]))

    # The first points of each scrambling fill the cube as well.
    first = np.arange(len(sampled.dense)).reshape(GROUPS, -1)[:, : _DENSE // GROUPS].ravel()
    known = sampled.base_damping[0][solved_rows], sampled.base_damping[1][first]
    bands, errors = quantiles(
        sampled.scores[solved_rows], logs[solved_rows], sampled.dense[first], SHARES, known,
        of_points,
    )  # fmt: skip
    bands = np.exp(bands)
    return plain._replace(
        bands=bands[:, 2:],
        peak_bands=bands[:, :2],
        error=float(np.max(errors[:, 0])),
        beyond=float(peaks.beyond.mean()),
    )


def frequency_responses(
    part: StructurePart, joint: ReducedJoint, state: Preload, modes: tuple[Mode, ...]
) -> tuple[FrequencyResponse, ...]:
    """Motion of the sensor over each force: the modes that were asked for, and all others linear.

    From half the frequency of the lowest of them to a quarter above the highest.
    """
    forces = () if part.force is None else part.force.amplitude
    rows = [joint.sensor(name) for name in (("sensor", "force") if forces else ())]
    return tuple(_frequency_response(part, rows, joint, state, modes, force) for force in forces)


def _frequency_response(
    part: StructurePart,
    rows: list[Floats],
    joint: ReducedJoint,
    state: Preload,
    modes: tuple[Mode, ...],
    force: float,
) -> FrequencyResponse:
    model, base, power = state.model, float(part.base_damping_ratio), POWERS[part.quantity]
    linear = np.ones(model.size, dtype=bool)
    linear[[mode.number - 1 for mode in modes]] = False
    at_rest = [mode.curve.linear_frequency for mode in modes]
    low, high = 0.5 * min(at_rest), 1.25 * max(at_rest)
    natural = np.sqrt(model.squares[linear])
    peaks = natural[(natural > 2.0 * math.pi * low) & (natural < 2.0 * math.pi * high)]
    near = np.outer(peaks / (2.0 * math.pi), 1.0 + base * np.linspace(-_WIDTHS, _WIDTHS, 41))
    of_modes = [forced.frequency for mode in modes for forced in mode.forced
                if forced.force == force]  # fmt: skip
    at = np.concatenate([np.geomspace(low, high, _BETWEEN), near.ravel(), *of_modes])
    at = six_digits(at[(at >= low) & (at <= high)])
    omega = 2.0 * math.pi * at
    gains, free = (
        (rows[0] @ shapes) * (rows[1] @ shapes) for shapes in (model.shapes[:, linear], model.free)
    )
    stiffness = natural[:, None] ** 2 - omega**2 + 2j * base * natural[:, None] * omega
    value = (gains[:, None] / stiffness).sum(axis=0) - free.sum() / omega**2
    for mode in modes:
        curve, solved = mode.curve, mode.curve.converged
        gain = _gain(curve, joint)[solved]
        columns = [curve.frequency[solved], curve.damping_ratio[solved] - base, abs(gain)]
        fine, (values,) = refined(part.amplitudes[solved], np.log(columns)[None])
        frequency, of_joint, size = values
        fine = fine / (2.0 * math.pi * frequency) ** power
        moved = with_phase(fine, frequency, of_joint + base, force * size, at)
        value = value + np.sign(gain[0].real) * moved / force
    known = np.isfinite(value)
    value = value[known] * (1j * omega[known]) ** power
    return FrequencyResponse(at[known], value, part.quantity, force, *_nodes(part))


def _nodes(part: StructurePart) -> tuple[Node, Node]:
    """Points at which it is measured and pushed."""
    places = [part.sensors[name] for name in ("sensor", "force")]
    pushed = 1 if places[0][0] == places[1][0] else 2
    words = [
        f"{name} at {' '.join(f'{1e3 * x:g}' for x in at)} mm, {direction}"
        for name, (at, direction) in zip(("sensor", "force"), places, strict=True)
    ]
    return Node(1, places[0][1], words[0]), Node(pushed, places[1][1], words[1])


AXES = ("x", "y", "z")
_NEAR = 0.2  # of ln(frequency) between a mode and a resonance that is its own
_ROUNDS, _ENOUGH = 60, 1e-6
_REACH = 3.0  # standard deviations that curves must hold
_MOST = 0.8  # share of the variance that the mode must have


class _Rows(NamedTuple):
    """Finely spaced curves of one mode (samples, amplitudes)."""

    moved: Floats
    """Displacement of the sensor from the ground [m]."""
    omega: Floats
    damping: Floats
    push: Floats
    """Displacement of the sensor for a unit of modal displacement times force on the mode for a
    unit of acceleration [-]."""
    carried: float
    """Motion of the sensor with the ground, counted as that in resonance [-]."""

    @property
    def ground(self) -> Floats:
        """Accelerations of the ground that have the peaks of resonances there [m/s^2]."""
        lost = 2.0 * self.damping * np.sqrt(1.0 - self.damping**2)
        return lost * self.omega**2 * self.moved / self.push

    @property
    def sensor_acceleration(self) -> Floats:
        """Accelerations of the sensor there, from the ground at rest [m/s^2]."""
        return np.hypot(self.omega**2 * self.moved, self.carried * self.ground)


def push_of(shape: NDArray[np.complex128], joint: ReducedJoint, direction: str) -> Floats:
    """See :class:`_Rows`; (amplitudes,)."""
    inertia = joint.base_inertia[: joint.size, AXES.index(direction)]
    push = (shape @ joint.sensor("sensor")) * (shape @ inertia).conj()
    return np.asarray(np.copysign(np.abs(push), push.real))


def shaken_bands(
    part: StructurePart,
    joint: ReducedJoint,
    shaking: Shaking,
    modes: tuple[Mode, ...],
    samples: list[Sampled | None],
    convergence: Convergence | None,
) -> ShakenBands | None:
    """Bands of the sweeps in closed form, of noise for the mode that moves most."""
    if not all(s is not None and np.isfinite(s.frequency).all(axis=1).any() for s in samples):
        return None
    columns: list[Floats] = []
    levels, reached = [], []
    scores = dense = np.zeros(0)

    def rows_of(index: int, direction: str) -> tuple[_Rows, _Rows]:
        """The mode with everything at its middle, and of its samples."""
        curve, sampled = modes[index].curve, samples[index]
        assert sampled is not None  # who calls has looked
        solved, power = curve.converged, POWERS[part.quantity]
        nonlocal scores, dense
        scores, dense = sampled.scores, sampled.dense
        of_joint = curve.damping_ratio - curve.base_damping
        middle = [curve.frequency, of_joint, push_of(curve.shape, joint, direction)]
        many = [sampled.frequency, sampled.joint_damping, sampled.pushes[direction]]
        carried = float(joint.sensor("sensor", base=True)[joint.size :][AXES.index(direction)])
        carried *= math.copysign(1.0, middle[2][0])

        def rows(values: list[Floats], base: Floats) -> _Rows:
            logs = np.moveaxis(np.log(np.abs(values))[..., solved], 0, 1)
            fine, (f, zeta, push) = refine(part.amplitudes[solved], logs)
            omega = 2.0 * math.pi * f
            return _Rows(fine / omega**power, omega, zeta + base[:, None], push, carried)

        at_middle = rows([value[None] for value in middle], np.array([curve.base_damping]))
        return at_middle, rows(many, sampled.base_damping[0])

    for sweep in shaking.sweeps:
        at = float(sweep.response.frequency[sweep.peak])
        gaps = [abs(math.log(at / mode.curve.linear_frequency)) for mode in modes]
        index = int(np.argmin(gaps))
        if part.base is None or gaps[index] > _NEAR:
            continue
        _, rows = rows_of(index, part.base.direction)
        controlled = rows.ground if part.base.control == "base" else rows.sensor_acceleration
        reached.append(sweep.level / float(np.nanmin(controlled[:, -1])))
        if reached[-1] > 1.0:
            continue
        values = (
            rows.omega / (2.0 * math.pi),
            rows.damping,
            rows.sensor_acceleration / rows.ground,
        )
        columns += [_where(controlled, sweep.level, value) for value in values]
        levels.append(sweep.level)
    noisy = []
    if part.random is not None and shaking.noise is not None:
        spectrum = Spectrum.of((part.random.frequencies, part.random.levels))
        curves = [rows_of(index, part.random.direction) for index in range(len(modes))]
        alone = [_in_noise(middle, spectrum) for middle, _ in curves]
        index = int(np.argmax([of[0, 2] for of in alone]))
        complete = np.array([shaking.noise.standard_deviation(shaking.sensor, quantity)
                          for quantity in ("displacement", "acceleration")])  # fmt: skip
        rows = curves[index][1]
        many = _in_noise(rows, spectrum)
        reach = _REACH * np.sqrt(many[:, 2]) / rows.moved[:, -1]
        if alone[index][0, 2] > _MOST * complete[0] ** 2:
            reached.append(float(np.nanmax(reach)))
        if alone[index][0, 2] > _MOST * complete[0] ** 2 and reached[-1] <= 1.0:
            # What other modes and the ground add stays as it is.
            variances = many[:, 2:] + np.maximum(complete**2 - alone[index][0, 2:], 0.0)
            noisy = [many[:, 0], many[:, 1], *np.sqrt(variances).T]
    if not columns + noisy:
        return ShakenBands((), {}, 0.0, max(reached)) if reached else None
    middle, errors = quantiles(scores, np.log(np.array(columns + noisy)).T, dense, SHARES)
    if convergence is not None:
        f, zeta = convergence.error
        of_model = [f, zeta, zeta] * len(levels) + [f, zeta, 0.5 * zeta, 0.5 * zeta][: len(noisy)]
        middle = middle + np.array(of_model) * np.array([-1.0, 0.0, 1.0])[:, None]
    ends = np.exp(middle).T
    of_sweeps = ends[: len(columns)].reshape(-1, len(SWEPT), len(SHARES))
    return ShakenBands(
        tuple((level, dict(zip(SWEPT, row, strict=True)))
              for level, row in zip(levels, of_sweeps, strict=True)),
        dict(zip(NOISY, ends[len(columns) :], strict=False)),
        float(np.nanmax(errors, initial=0.0)), max(reached),
    )  # fmt: skip


def refine(amplitude: Floats, logs: Floats) -> tuple[Floats, Floats]:
    """Finer curves, NaN for samples that do not reach all amplitudes: (columns, samples, ...)."""
    complete = np.isfinite(logs).all(axis=(1, 2))
    fine, refined_logs = refined(amplitude, logs[complete])
    values = np.full((refined_logs.shape[1], len(logs), fine.size), math.nan)
    values[:, complete] = np.moveaxis(refined_logs, 1, 0)
    return fine, values


def _where(controlled: Floats, level: float, values: Floats) -> Floats:
    """Values at which something rising comes to a level, a row a sample."""
    pairs = zip(np.maximum.accumulate(controlled, axis=1), values, strict=True)
    return np.exp([np.interp(math.log(level), np.log(h), np.log(v)) for h, v in pairs])


def _in_noise(rows: _Rows, spectrum: Spectrum) -> Floats:
    """Equivalent frequency and damping, variances of displacement and acceleration (samples, 4)."""
    result = np.full((len(rows.moved), 4), math.nan)
    idle, none = np.zeros(0), np.zeros((1, 0))
    for row, curve in enumerate(zip(*rows[:4], strict=True)):
        moved, omega, damping, push = curve
        if not np.isfinite(moved).all():
            continue
        place, size = np.log(moved), float(moved[0])
        for _ in range(_ROUNDS):
            a = size * AMPLITUDES
            average = _average(place, a)
            square, rate = average(omega**2), average(2.0 * damping * omega)
            variances = LinearStructure(
                np.array([square]), np.array([[rate]]), none, np.array([average(push)]),
                np.zeros(1), idle, spectrum,
            ).variances(idle, idle)  # fmt: skip
            before, size = size, math.sqrt(float(variances.displacement[0, 0]))
            if abs(size / before - 1.0) < _ENOUGH:
                break
        sensor = np.array([-1.0, rows.carried])  # the push is that of inertia, against the ground
        natural = math.sqrt(square)
        result[row, :2] = natural / (2.0 * math.pi), rate / (2.0 * natural)
        result[row, 2:] = size**2, sensor @ variances.acceleration @ sensor
    return result


def _average(place: Floats, amplitudes: Floats) -> Callable[[Floats], float]:
    """Means of values over amplitudes of noise, with the square of the amplitude."""

    def mean(values: Floats) -> float:
        at = np.interp(np.log(amplitudes), place, values)
        squares = amplitudes**2
        weighted = mean_over_amplitudes(squares * at) / mean_over_amplitudes(squares)
        return float(weighted)

    return mean
