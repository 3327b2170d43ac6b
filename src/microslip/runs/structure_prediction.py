"""The numbers of a bolted structure: its rest, its modes and bands, its shaken motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.structures import (
    BaseResponse,
    Convergence,
    FrequencyResponse,
    ModalCurve,
    ModalIdentification,
    ModalTest,
    Preload,
    Pulse,
    RandomResponse,
    ReducedJoint,
    ShockResponse,
)
from microslip.structures.base_motion import ControlOf
from microslip.study.build import blame, build_surface
from microslip.study.description import StudyDescription
from microslip.study.structure import StructurePart
from microslip.study.vibration import EXCITED

_POINTS = 400  # frequencies of a spectrum that is drawn


@dataclass(frozen=True)
class Sweep:
    """One sweep, as a sensor shows it."""

    level: float
    """Acceleration that was held [m/s^2]."""
    response: BaseResponse
    sensor: Floats
    """Direction of the sensor."""

    @property
    def acceleration(self) -> Floats:
        """Absolute acceleration of the sensor [m/s^2]."""
        omega = 2.0 * math.pi * self.response.frequency
        return self.response.absolute_amplitude(self.sensor) * omega**2

    @property
    def transmissibility(self) -> Floats:
        """Its size [-]."""
        return np.asarray(np.abs(self.response.transmissibility(self.sensor)))

    @property
    def base_acceleration(self) -> Floats:
        """Acceleration of the ground [m/s^2]."""
        return np.asarray(np.abs(self.response.base_acceleration).max(axis=1))

    @property
    def force(self) -> Floats:
        """Fundamental of the force that moves the ground [N]."""
        first = self.response.harmonics.index(1)
        return np.asarray(np.abs(self.response.base_force[:, 0, first]))

    @property
    def peak(self) -> int:
        """Place of the resonance."""
        return int(np.argmax(self.transmissibility))


SWEPT = ("resonance", "damping_ratio", "transmissibility")
NOISY = ("equivalent_frequency", "equivalent_damping_ratio", "displacement_deviation",
         "acceleration_deviation")  # fmt: skip


class ShakenBands(NamedTuple):
    """Quantiles of 5, 50 and 95 % of what is shaken, over the uncertain inputs."""

    sweeps: tuple[tuple[float, dict[str, Floats]], ...]
    """Level [m/s^2], and its quantiles by the names of SWEPT."""
    noise: dict[str, Floats]
    """By the names of NOISY; none where other modes move the sensor."""
    error: float
    """Largest relative half width of the 90 % intervals of the quantiles [-]."""
    reached: float
    """Largest amplitude of all samples over that of the modal curves [-]; what needs more than one
    is left out."""


@dataclass(frozen=True)
class Shaking:
    """All results for a moving ground."""

    sensor: Floats
    """Direction of the sensor, the motion of the ground among it."""
    sweeps: tuple[Sweep, ...]
    noise: RandomResponse | None
    duration: float
    """Duration of the noise [s]."""
    frequency: Floats
    """At which its spectra are shown [Hz]."""
    level: Floats
    """Spectral density of the ground there [(m/s^2)^2/Hz]."""
    severity: Floats
    """Peaks of the pulses [m/s^2]."""
    shocks: tuple[ShockResponse, ...]
    bands: ShakenBands | None = None
    """Bands of uncertain inputs."""

    def peaks(self, quantity: str) -> Floats:
        """Largest at the sensor under each pulse [m or m/s^2]."""
        values = [s.peak(self.sensor, quantity) for s in self.shocks]  # type: ignore[arg-type]
        return np.array(values)


def shaken(study: StudyDescription, joint: ReducedJoint, first: float) -> Shaking | None:
    """Request of a study without uncertain inputs; its first mode is at so many Hz."""
    part = study.structure
    if part is None or all(getattr(part, name) is None for name in EXCITED):
        return None
    with blame(study, "structure"):
        friction, damping = study.joint.friction_coefficient, float(part.base_damping_ratio)
        state = joint.on_base(build_surface(study), float(friction), damping)
    sensor = joint.sensor("sensor", base=True)
    sweeps: tuple[Sweep, ...] = ()
    if (asked := part.base) is not None:
        with blame(study, "structure.base"):
            swept = asked.frequencies or (0.9 * first, 1.1 * first)
            frequencies = np.linspace(*swept, asked.points)
            on = joint.base(asked.direction) | {"harmonics": part.harmonics}
            sweeps = tuple(
                _sweep(state, asked.control, level, frequencies, sensor, on)
                for level in asked.acceleration
            )
    noise, frequency, density = None, np.zeros(0), np.zeros(0)
    if (power := part.random) is not None:
        given = np.array([power.frequencies, power.levels])
        with blame(study, "structure.random"):
            noise = state.random_response(
                given, **joint.base(power.direction), modes=power.modes, harmonics=part.harmonics
            )
        frequency = _frequencies_near(given[0], noise)
        density = np.interp(frequency, *given)
    severity = np.zeros(0)
    shocks: tuple[ShockResponse, ...] = ()
    if (test := part.shock) is not None:
        severity = np.array(test.acceleration)
        with blame(study, "structure.shock"):
            shocks = tuple(
                state.shock(Pulse.half_sine(height, test.duration), **joint.base(test.direction))
                for height in test.acceleration
            )
    return Shaking(
        sensor, sweeps, noise, 0.0 if power is None else power.duration, frequency, density,
        severity, shocks,
    )  # fmt: skip


def _sweep(
    state: Preload,
    control: ControlOf,
    level: float,
    frequencies: Floats,
    sensor: Floats,
    on: dict[str, Any],
) -> Sweep:
    """One sweep at a level of the ground, or of the sensor."""
    if control == "response":
        excitation: dict[str, Any] = {"acceleration": 1.0, "at": sensor, "level": level}
    else:
        excitation = {"acceleration": level}
    response = state.base_response(frequencies=frequencies, control=control, **excitation, **on)
    if not response.frequency.size:
        raise InputError(f"no sweep at {level:g} m/s^2 was solved: {response.message}")
    return Sweep(level, response, sensor)


def _frequencies_near(given: Floats, noise: RandomResponse) -> Floats:
    """Frequencies of a spectrum, dense about its resonances [Hz]."""
    low, high = float(given[0]), float(given[-1])
    even = np.geomspace(max(low, 1e-3 * high), high, _POINTS)
    widths = np.linspace(-8.0, 8.0, 81)[:, None] * noise.damping_ratio
    about = (noise.frequency * (1.0 + widths)).ravel()
    every = np.unique(np.concatenate([given, even, about]))
    return np.asarray(every[(every >= low) & (every <= high) & (every > 0.0)])


SHARES = (0.05, 0.5, 0.95)
"""Quantiles of the bands."""


@dataclass(frozen=True)
class Bands:
    """Results of a mode over the samples of the uncertain inputs."""

    frequency: Floats  # quantiles at each amplitude [Hz], shape (3, amplitudes)
    damping_ratio: Floats  # the same [-]
    ranking: tuple[tuple[str, float], ...]
    """Share of each input in the scatter of ln(damping ratio) [-], the largest first."""
    frequency_error: float
    """Largest relative half-width of the 90 % intervals of the quantiles, for there are so few
    samples [-]; infinite where they leave an outer quantile open."""
    damping_error: float
    """The same of the damping ratio [-]."""
    unsolved: int
    """Samples that do not reach all amplitudes; at those they do not count."""
    model_error: tuple[float, float] | None
    """Error of patches, mesh and reduction that the ends include, of frequency and joint damping
    [-]; None where it was not estimated."""


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
    pushes: dict[str, Floats]
    """The same for a ground that accelerates along x, y, z, see :mod:`.shaken_bands` [-]."""
    base_damping: tuple[Floats, Floats]
    """Base damping added to it, at the samples and at those many points [-]."""


class ForcedMode(NamedTuple):
    """Response to a harmonic force near a mode, as amplitudes of the sensor's quantity."""

    force: float
    """Its amplitude [N]."""
    frequency: Floats
    """Frequencies [Hz]."""
    response: Floats
    """With everything at its middle; the largest that lasts."""
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
    """One mode along the amplitudes at the sensor."""

    number: int  # counted from 1
    curve: ModalCurve  # by harmonic balance
    quick: ModalCurve | None  # quasi-static; None beside a geometry, whose mean it does not follow
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
    shaking: Shaking | None = None  # on a ground that moves
    frequency_responses: tuple[FrequencyResponse, ...] = ()  # one a force, all modes together
