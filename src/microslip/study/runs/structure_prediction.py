"""Numbers of a bolted structure: static state, modes with bands, forced responses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures import (
    Convergence,
    FrequencyResponse,
    ModalCurve,
    ModalIdentification,
    ModalTest,
    Preload,
    ReducedJoint,
)
from microslip.structures.tie_limits import TieLimits
from microslip.study.runs.structure_verdicts import Change, QuantityVerdict
from microslip.study.structure import StructurePart

SHARES = (0.05, 0.5, 0.95)
"""Quantiles of the bands."""


@dataclass(frozen=True)
class Bands:
    """Results of a mode over the samples of the uncertain inputs."""

    frequency: Floats  # quantiles at each amplitude [Hz], shape (3, amplitudes)
    damping_ratio: Floats  # the same [-]
    ranking: tuple[tuple[str, float], ...]
    """Share of each input in the scatter of ln(damping ratio) [-], the largest first."""
    slopes: dict[str, tuple[tuple[str, float], ...]]
    """Change of ln(frequency) and ln(damping ratio) by a standard deviation of each input [-]."""
    frequency_error: float
    """Largest relative half-width of the 90 % intervals of the quantiles [-]; infinite where too
    few samples leave an outer quantile open, NaN where no sample was solved."""
    damping_error: float
    """The same of the damping ratio [-]."""
    unsolved: int
    """Samples that do not reach all amplitudes; at those they do not count."""
    model_error: tuple[float, float] | None
    """Error of patches, mesh and reduction that the ends include, of frequency and joint damping
    [-]; None where it was not estimated."""


def joint_damping(curve: ModalCurve) -> Floats:
    """Return the damping ratio of the joint alone [-], at least 1e-14.

    Rounding of stuck joints leaves differences of zero or below, which have no logarithm.
    """
    return np.maximum(curve.damping_ratio - curve.base_damping, 1e-14)


class Sampled(NamedTuple):
    """A mode over the samples of what is not known exactly."""

    scores: Floats
    """Inputs as normal scores, (samples, inputs)."""
    dense: Floats
    """The same at many more points."""
    frequency: Floats
    """(samples, amplitudes) [Hz]; NaN where the balance was not reached."""
    joint_damping: Floats
    """Damping ratio of the joint alone, the same [-]."""
    gain: Floats
    """Modal displacement at the sensor times that at the force, the same [1/kg]; ones without."""
    base_damping: tuple[Floats, Floats]
    """Base damping added to it, at the samples and at those many points [-]."""


class ForcedMode(NamedTuple):
    """Response to a harmonic force near a mode, as amplitudes of the sensor's quantity."""

    force: float
    """Amplitude of the force [N]."""
    frequency: Floats
    """Frequencies [Hz]."""
    response: Floats
    """Largest stable response with all inputs at their medians."""
    peak: Floats
    """Amplitude and frequency [Hz] of the peak; beyond the curve NaN."""
    bands: Floats | None
    """Quantiles at each frequency (3, frequencies)."""
    peak_bands: Floats | None
    """Quantiles of amplitude and frequency of the peak (3, 2)."""
    error: float
    """Half width of the widest 90 % interval of the quantiles of the peak, relative [-]."""
    beyond: float
    """Share of samples whose peak lies beyond the largest amplitude, which stands for it [-]."""
    largest_force: float
    """Force that just reaches the largest amplitude, everything at its middle [N]."""


@dataclass(frozen=True)
class Mode:
    """Mode along the amplitudes at the sensor."""

    number: int  # counted from 1
    curve: ModalCurve  # by harmonic balance
    bands: Bands | None  # None where everything is given as one number
    forced: tuple[ForcedMode, ...] = ()  # one a force

    @property
    def last(self) -> int:
        """Place of the largest solved amplitude."""
        return int(np.flatnonzero(self.curve.converged)[-1])

    def slip(self, joint: ReducedJoint) -> Floats:
        """Relative tangential amplitude of each patch at the largest solved amplitude [m]."""
        moved = abs(self.curve.shape[self.last] * self.curve.modal_amplitude[self.last])
        relative = moved[: 3 * joint.patches].reshape(-1, 3)
        return np.asarray(np.hypot(relative[:, 0], relative[:, 1]))

    def loss(self) -> Floats:
        """Share of each patch in the loss at the largest solved amplitude [-]."""
        return np.asarray(self.curve.loss_share[self.last])


class TightMode(NamedTuple):
    """A mode of a structure with slack bolts as it is with all of them tight."""

    of: int
    """Number of the mode with slack bolts, from 1."""
    number: int
    """Number of the one most alike."""
    mac: float
    """Modal assurance criterion of their shapes [-], 1 for the same."""
    curve: ModalCurve


@dataclass(frozen=True)
class StructurePrediction:
    """All numbers of the structure of a study."""

    part: StructurePart  # what was asked for
    joint: ReducedJoint  # the reduced model
    state: Preload  # tightened, everything uncertain at its middle
    modes: tuple[Mode, ...]  # in the order of the study
    inputs: tuple[tuple[str, str], ...]  # what is not known exactly, and how far it is known
    identified: ModalIdentification | None = None  # what the tests say, where a fit is asked for
    tests: tuple[ModalTest, ...] = ()
    convergence: Convergence | None = None  # how good the model is for the first mode
    tight: tuple[TightMode, ...] = ()  # its modes with all bolts tight, where some are slack
    frequency_responses: tuple[FrequencyResponse, ...] = ()  # one a force, all modes together
    limits: tuple[TieLimits, ...] = ()  # one a mode: the lap open, tied under washers, tied
    judged: tuple[QuantityVerdict, ...] = ()  # tests against the bands
    changes: tuple[Change, ...] = ()  # rise and fall of predictions and tests
