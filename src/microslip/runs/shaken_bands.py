"""Bands of a structure on a ground that moves, from the modal curves of its samples."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.runs.shaking import NOISY, SWEPT, ShakenBands, Shaking
from microslip.runs.structure_prediction import SHARES, Mode, Sampled
from microslip.structures import Convergence, ReducedJoint
from microslip.structures.modal_curve import refined
from microslip.structures.periodic_motion import POWERS
from microslip.structures.random_vibration import AMPLITUDES, mean_over_amplitudes
from microslip.structures.spectral_response import LinearStructure, Spectrum
from microslip.study.structure import StructurePart
from microslip.sweeps.quantiles import quantiles

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
