"""The structure of a study on a moving ground: sine sweeps, noise, pulses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.structures import (
    BaseResponse,
    Preload,
    Pulse,
    RandomResponse,
    ReducedJoint,
    ShockResponse,
)
from microslip.structures.base_motion import ControlOf
from microslip.study.build import blame, build_surface
from microslip.study.description import StudyDescription
from microslip.study.shaking import EXCITED

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
