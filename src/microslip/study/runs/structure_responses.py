"""Responses of a structure to harmonic forces, from its modal curves, with uncertainty bands."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip.friction.sweeps.quantiles import quantiles
from microslip.structures import ModalCurve, ReducedJoint
from microslip.structures.modal_curve import (
    Resonant,
    interpolate_in_amplitude,
    resonant,
)
from microslip.structures.periodic_motion import POWERS
from microslip.study.runs.structure_prediction import (
    BAND_QUANTILES,
    ForcedMode,
    ModeSamples,
    joint_damping,
)
from microslip.study.schema import GROUPS
from microslip.study.structure import StructurePart

_DENSE = 512  # points of the surrogate model from which quantiles are computed
_FREQUENCIES = 121
_WIDTHS = 5.0  # range shown beyond the outermost peaks, in half-widths of the resonance


def gain_of(curve: ModalCurve, joint: ReducedJoint) -> Floats:
    """Return |mode shape at the sensor times mode shape at the force| [1/kg] for each amplitude."""
    sensed, pushed = (curve.shape @ joint.sensor(name) for name in ("sensor", "force"))
    return np.asarray(abs(sensed * pushed.conj()))


def forced_mode(
    part: StructurePart,
    joint: ReducedJoint,
    curve: ModalCurve,
    sampled: ModeSamples | None,
    force: float,
) -> ForcedMode:
    """Return the response of one mode to a harmonic force [N], with bands for uncertain inputs."""
    power = POWERS[part.quantity]
    solved = curve.converged
    asked = part.amplitudes[solved]

    def answers(logs: Floats, base: Floats, at: Floats) -> Resonant:
        """Return, for each sample, the peak amplitude and frequency, and amplitudes at ``at`` [Hz].

        ``logs`` are ln(frequency), ln(damping ratio of the joint) and ln(gain) over the amplitudes,
        ``base`` the base damping ratios of the samples.
        """
        fine, values = interpolate_in_amplitude(asked, logs.reshape(len(logs), 3, -1))
        frequency, of_joint, gain = np.moveaxis(values, 1, 0)
        moved = fine / (2.0 * math.pi * frequency) ** power
        found = resonant(moved, frequency, of_joint + base[:, None], force * gain, at)
        peak = found.peak * (2.0 * math.pi * found.peak[:, 1:]) ** [power, 0]
        return Resonant(peak, found.beyond, found.amplitude * (2.0 * math.pi * at) ** power)

    frequency, damping = curve.frequency[solved], curve.damping_ratio[solved]
    gain = gain_of(curve, joint)[solved]
    base = np.array([curve.base_damping])
    row = np.log([frequency, joint_damping(curve)[solved], gain]).reshape(1, -1)
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
    if not solved_rows.any() or peaks.beyond.all():  # no peak is known, so there is no band
        return plain._replace(beyond=1.0)

    def of_points(points: Floats, base: Floats) -> Floats:
        found = answers(points, base, at)
        return np.log(np.hstack([found.peak, found.amplitude]))

    # The first points of each Sobol' sequence also cover the cube evenly.
    first = np.arange(len(sampled.dense)).reshape(GROUPS, -1)[:, : _DENSE // GROUPS].ravel()
    known = sampled.base_damping[0][solved_rows], sampled.base_damping[1][first]
    bands, errors = quantiles(
        sampled.scores[solved_rows], logs[solved_rows], sampled.dense[first], BAND_QUANTILES, known,
        of_points,
    )  # fmt: skip
    bands = np.exp(bands)
    return plain._replace(
        bands=bands[:, 2:],
        peak_bands=bands[:, :2],
        error=float(np.max(errors[:, 0])),
        beyond=float(peaks.beyond.mean()),
    )
