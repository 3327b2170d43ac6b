"""Results of a bolted structure: static state, modes with bands, forced responses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures import (
    Convergence,
    ModalCurve,
    ModalIdentification,
    ModalTest,
    Preload,
    ReducedJoint,
)
from microslip.structures.tie_limits import TieLimits
from microslip.study.structure import StructurePart

BAND_QUANTILES = (0.05, 0.5, 0.95)
"""Quantiles of the bands."""


@dataclass(frozen=True)
class ModeBands:
    """Quantiles of frequency and damping of a mode over the samples of the inputs."""

    frequency: Floats  # quantiles at each amplitude [Hz], shape (3, amplitudes)
    damping_ratio: Floats  # quantiles at each amplitude [-], shape (3, amplitudes)
    ranking: tuple[tuple[str, float], ...]
    """Fraction of the variance of ln(damping ratio) due to each input [-], largest first."""
    slopes: dict[str, tuple[tuple[str, float], ...]]
    """Change of ln(frequency) and ln(damping ratio) per standard deviation of each input [-]."""
    frequency_error: Floats
    """Largest relative half-width of the 90 % intervals of the quantiles [-], (amplitudes,).

    Infinite if there are too few samples for an outer quantile; NaN if no sample was solved.
    """
    damping_error: Floats
    """Largest relative half-width for the damping ratio [-], (amplitudes,)."""
    unsolved: int
    """Number of samples without a solution at some amplitude, where they are ignored."""
    model_error: tuple[float, float] | None
    """Relative errors of frequency and joint damping from patches, mesh and reduction [-].

    The ends of the bands include them; None if they were not estimated.
    """


def joint_damping(curve: ModalCurve) -> Floats:
    """Return the damping ratio of the joint alone [-], at least 1e-14.

    Without slip, rounding may give zero or negative differences, which have no logarithm.
    """
    return np.maximum(curve.damping_ratio - curve.base_damping, 1e-14)


class ModeSamples(NamedTuple):
    """Results of one mode for all samples of the uncertain inputs."""

    scores: Floats
    """Normal scores of the inputs, shape (samples, inputs)."""
    dense: Floats
    """Normal scores at many more points, for the surrogate model."""
    frequency: Floats
    """Frequency [Hz], shape (samples, amplitudes); NaN without a solution."""
    joint_damping: Floats
    """Damping ratio of the joint alone [-], shape (samples, amplitudes)."""
    gain: Floats
    """Product of the mode shapes at sensor and force [1/kg]; ones without a force."""
    base_damping: tuple[Floats, Floats]
    """Base damping ratio at the samples and at the dense points [-]."""


class ForcedMode(NamedTuple):
    """Response near a mode to a harmonic force, in the SI unit of the sensor's quantity."""

    force: float
    """Amplitude of the force [N]."""
    frequency: Floats
    """Frequencies [Hz]."""
    response: Floats
    """Largest stable response at the central values of the inputs."""
    peak: Floats
    """Amplitude and frequency [Hz] of the peak; NaN beyond the largest amplitude."""
    bands: Floats | None
    """Quantiles of the response, shape (3, frequencies)."""
    peak_bands: Floats | None
    """Quantiles of amplitude and frequency of the peak, shape (3, 2)."""
    error: float
    """Largest relative half-width of the 90 % intervals of the quantiles of the peak [-]."""
    beyond: float
    """Fraction of samples with a peak beyond the largest amplitude, which replaces it [-]."""
    largest_force: float
    """Force for a peak at the largest amplitude, at the central values of the inputs [N]."""


@dataclass(frozen=True)
class Mode:
    """Predicted mode: frequency and damping against amplitude, bands and forced responses."""

    number: int  # counted from 1
    curve: ModalCurve  # by harmonic balance
    bands: ModeBands | None  # None without uncertain inputs
    forced: tuple[ForcedMode, ...] = ()  # one per force

    @property
    def last(self) -> int:
        """Index of the largest amplitude for which the mode was solved."""
        return int(np.flatnonzero(self.curve.converged)[-1])

    def slip(self, joint: ReducedJoint) -> Floats:
        """Return the tangential amplitude between the faces of each patch [m], at :attr:`last`."""
        moved = abs(self.curve.shape[self.last] * self.curve.modal_amplitude[self.last])
        relative = moved[: 3 * joint.patches].reshape(-1, 3)
        return np.asarray(np.hypot(relative[:, 0], relative[:, 1]))

    def loss(self) -> Floats:
        """Return each patch's fraction of the dissipated energy [-] at the largest amplitude."""
        return np.asarray(self.curve.loss_share[self.last])


TestWord = Literal["inside", "above", "below", "on both sides", "not compared"]
_STEADY_RATIO = 0.2
"""Ratio of damping rise to relative frequency fall [-] below which microslip is doubtful."""


class QuantityVerdict(NamedTuple):
    """Comparison of a measured quantity with the 5 to 95 % band of its mode."""

    test: str
    mode: int
    quantity: str
    """``frequency`` or ``damping_ratio``."""
    word: TestWord
    points: int
    """Number of points within the amplitudes of the prediction."""
    above: int
    below: int
    distance: float
    """Largest relative distance from the nearest end of the band [-]; negative below the band."""
    candidates: tuple[tuple[str, str], ...]
    """Inputs that would reduce the difference, most influential first, with "more" or "less"."""
    unit: str
    """Unit error that would put the test inside the band, or empty."""

    @property
    def inside(self) -> int:
        """Number of measured points inside the band."""
        return self.points - self.above - self.below


class AmplitudeTrend(NamedTuple):
    """Change of frequency and damping over the amplitudes of a test or a prediction."""

    source: str
    mode: int
    base_damping: float
    """Damping ratio without the joint [-]; NaN for a test."""
    rise: float
    """Damping ratio at the largest minus that at the smallest amplitude [-]."""
    fall: float
    """Relative change of the frequency from the smallest to the largest amplitude [-]."""

    @property
    def ratio(self) -> float:
        """Rise of the damping ratio over the relative fall of the frequency [-].

        Microslip of a joint at constant pressure gives 0.40 to 0.50.
        """
        return -self.rise / self.fall if self.fall < 0.0 else math.nan

    @property
    def doubt(self) -> str:
        """Reason to doubt that microslip causes the change with amplitude; "" if there is none."""
        if not math.isfinite(self.ratio) or abs(self.fall) < 1e-4 or self.ratio >= _STEADY_RATIO:
            return ""
        return (
            f"{self.source}: the damping ratio rises by {self.ratio:.2g} times the relative fall "
            "of the frequency; microslip gives 0.4 to 0.5. Look for nonlinear stiffness, such as "
            "large deflections or opening gaps."
        )


@dataclass(frozen=True)
class StructurePrediction:
    """All results of the structure of a study."""

    part: StructurePart  # table of the study
    joint: ReducedJoint  # reduced model
    state: Preload  # preloaded state at the central values of the inputs
    modes: tuple[Mode, ...]  # in the order of the study
    inputs: tuple[tuple[str, str], ...]  # uncertain inputs: name and distribution
    identified: ModalIdentification | None = None  # fit to the tests, if requested
    tests: tuple[ModalTest, ...] = ()
    convergence: Convergence | None = None  # convergence study for the first mode
    patch_error: tuple[float, float] | None = None
    """Estimated relative errors of frequency and joint damping by the patches [-]."""
    limits: tuple[TieLimits, ...] = ()  # one per mode: open lap, tied under washers, fully tied
    judged: tuple[QuantityVerdict, ...] = ()  # comparison of tests and bands
    changes: tuple[
        AmplitudeTrend, ...
    ] = ()  # changes over the amplitudes, of predictions and tests
