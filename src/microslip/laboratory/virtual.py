"""Virtual tribometer: the rig of section 2.1 of chapter 19, DOI 10.1007/978-3-319-56818-8_19."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact, number, positive, show, whole_number
from microslip._core.errors import InputError
from microslip.friction import BackboneLaw
from microslip.laboratory.record import Record

_CHANNELS = ("displacement", "force", "normal_load")
SAMPLES_A_CYCLE = 512
_FEWEST_SAMPLES = 16
_MOST_SAMPLES = 100_000_000
STEPS_A_CYCLE = 1024
"""Smallest number of steps per cycle of a joint under a varying load."""


class InSeries(BackboneLaw):
    """Joint in series with a spring; the displacement is that of the far end of the spring.

    A series connection of laws that obey Masing's rules obeys them too, so this is a backbone law.
    """

    def __init__(self, joint: BackboneLaw, stiffness: float) -> None:
        self.joint, self.stiffness = joint, stiffness

    @property
    def force_limit(self) -> float:
        """Force at gross slip [N], equal to that of the joint."""
        return self.joint.force_limit

    def contact_displacement(self, x: Floats) -> Floats:
        """Return the displacement u of the joint [m], from u + T0(u)/k = x with its backbone T0."""
        k, first = self.stiffness, self.joint.tangential_stiffness
        # u + T0(u)/k is concave: from below Newton's method climbs to the answer, never past it.
        u = np.maximum(x / (1.0 + first / k), x - self.joint.force_limit / k)
        u = np.clip(u, 0.0, x)
        for _ in range(100):
            gap = x - u - self.joint._backbone(u) / k
            step = gap / (1.0 + self.joint._slope(u) / k)
            better = np.clip(u + step, u, x)
            if np.all(better - u <= 1e-15 * x):
                return better
            u = better
        return u

    def _backbone(self, u: Floats) -> Floats:
        inner = self.contact_displacement(u)
        if math.isinf(self.joint.tangential_stiffness):  # the force is the spring's to know
            return np.minimum(self.stiffness * (u - inner), self.force_limit)
        return self.joint._backbone(inner)

    def _slope(self, u: Floats) -> Floats:
        inner = self.joint._slope(self.contact_displacement(u))
        with np.errstate(invalid="ignore"):
            slope = inner / (1.0 + inner / self.stiffness)
        return np.where(np.isinf(inner), self.stiffness, slope)


@dataclass(frozen=True, eq=False)
class VirtualTribometer:
    """Tribometer of section 2.1 of chapter 19 with a joint under test, with its imperfections.

    The displacement is commanded and measured at the transducer, so the compliance of the rig is
    in series with the joint: k_rig (x - delta) = T(delta), with the displacements x at the
    transducer and delta of the joint. The rig is ideal by default.

    Parameters
    ----------
    joint : BackboneLaw
        Joint under test, at its own normal load.
    rig_stiffness : float, optional
        Stiffness of the rig [N/m], above zero; if omitted or infinite, the rig is rigid.
    noise : float, optional
        White Gaussian noise: standard deviation of each channel relative to its amplitude (of the
        load: to its mean) [-].
    load_ripple : float, optional
        Largest deviation of the normal load relative to its mean [-], 0 <= ripple < 1; 0.02 on
        the rig of the chapter. The deviation is proportional to the tangential force at constant
        load. Only for laws with a surface, whose normal load is known.
    ripple_phase : float, optional
        Angle by which the ripple leads that force [rad].
    third_harmonic : float, optional
        Third harmonic of the displacement over its fundamental [-], 0 <= ratio <= 1/9; 0.05 on the
        rig of the chapter. It flattens the peaks; above 1/9 the motion would reverse beside them.
    sample_rate : float, optional
        Sampling rate [Hz]; by default 512 samples per cycle.
    seed : int, optional
        Seed of the noise: the same seed gives the same record.

    Notes
    -----
    The rig of section 2.1 of chapter 19 (DOI 10.1007/978-3-319-56818-8_19) reaches normal loads of
    100 to 5000 N, forces of 5000 N, amplitudes of 1 to 100 um and 200 Hz; other values are
    accepted. A lower sampling rate only omits samples.

    At a constant load the response is exact at every sample, the compliance included. With a load
    ripple the joint follows at least 1024 straight lines of separation and displacement per cycle.
    For ripples of up to 0.3 on surfaces and spheres, at up to 30 um, the error is less than 1e-3 of
    the force on a rigid rig, less than 1e-4 with a rig of 2e8 N/m.
    """

    joint: BackboneLaw
    _: KW_ONLY
    rig_stiffness: float | None = None
    noise: float = 0.0
    load_ripple: float = 0.0
    ripple_phase: float = 0.0
    third_harmonic: float = 0.0
    sample_rate: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.joint, BackboneLaw):
            raise InputError(
                f"`joint` must be a backbone law, such as an Interface, got {show(self.joint)}"
            )
        keep = object.__setattr__
        if isinstance(self.rig_stiffness, float) and self.rig_stiffness == math.inf:
            keep(self, "rig_stiffness", None)
        if self.rig_stiffness is not None:
            keep(self, "rig_stiffness", positive("rig_stiffness", self.rig_stiffness, "N/m", 1e8))
        if self.sample_rate is not None:
            keep(self, "sample_rate", positive("sample_rate", self.sample_rate, "Hz", 1e4))
        for name, largest, words in (
            ("load_ripple", math.nextafter(1.0, 0.0), "below 1"),
            ("third_harmonic", 1.0 / 9.0, "1/9"),
        ):
            value = number(name, getattr(self, name), "", 0.02)
            if not 0.0 <= value <= largest:
                raise InputError(f"`{name}` must be from 0 to {words}, got {exact(value)}")
            keep(self, name, value)
        keep(self, "ripple_phase", number("ripple_phase", self.ripple_phase, "rad"))
        if self.load_ripple > 0.0 and self.joint._load_curve is None:
            raise InputError(
                f"load_ripple has no meaning for {type(self.joint).__name__}: it has no surface"
            )
        whole_number("seed", self.seed, 0)
        keep(self, "noise", number("noise", self.noise))
        if self.noise < 0.0:
            raise InputError(f"`noise` must not be negative, got {exact(self.noise)}")

    @cached_property
    def series(self) -> BackboneLaw:
        """Joint and rig in series at the mean normal load."""
        if self.rig_stiffness is None:
            return self.joint
        return InSeries(self.joint, self.rig_stiffness)

    def record(self, *, amplitude: float, frequency: float = 1.0, cycles: int = 10) -> Record:
        """Simulate a record of some cycles.

        The joint starts from rest. A quarter of a cycle loads it to the first peak; then follow
        ``cycles`` cycles from peak to peak.

        Parameters
        ----------
        amplitude : float
            Half the range of the displacement [m] at the transducer, third harmonic included.
        frequency : float, optional
            Frequency of the cycles [Hz].
        cycles : int, optional
            Number of cycles, at least 1.

        Returns
        -------
        Record
            Displacement [m] at the transducer, force [N] and, if the joint has one, normal load
            [N], each with noise.
        """
        amplitude = positive("amplitude", amplitude, "m", 1e-5)
        frequency = positive("frequency", frequency, "Hz", 10.0)
        cycles = whole_number("cycles", cycles, 1, _MOST_SAMPLES)
        rate = self.sample_rate or SAMPLES_A_CYCLE * frequency
        if rate < _FEWEST_SAMPLES * frequency:
            raise InputError(
                f"`sample_rate` must give at least {_FEWEST_SAMPLES} samples per cycle, "
                f"{exact(_FEWEST_SAMPLES * frequency)} Hz at {exact(frequency)} Hz, got "
                f"{exact(rate)} Hz"
            )
        length = (cycles + 0.25) * rate / frequency
        steps = max(length, (cycles + 0.25) * STEPS_A_CYCLE if self.load_ripple else 0.0)
        if steps > _MOST_SAMPLES:
            raise InputError(
                f"a record must have at most {_MOST_SAMPLES} samples, {STEPS_A_CYCLE} a cycle with "
                f"load_ripple, got {steps:.4g}: take fewer cycles or a lower sample_rate"
            )
        size, step = math.floor(length + 1e-9) + 1, 2.0 * math.pi * frequency / rate
        angle, sampled = self._angles(step * np.arange(float(size)))
        x = amplitude * motion_over_amplitude(angle, self.third_harmonic)
        force, load = self._respond(x, amplitude, angle)
        history = {"displacement": x, "force": force, "normal_load": load}
        clean = {name: v[sampled] for name, v in history.items() if v is not None}
        noisy = self._with_noise(clean, amplitude)
        return Record(**noisy, sample_rate=rate, name="virtual tribometer")

    def _angles(self, samples: Floats) -> tuple[Floats, NDArray[np.intp]]:
        """Return the phases of the drive [rad] for integration, and the indices of the samples.

        Between the phases ``samples`` are the reversals of the motion, and with a load ripple its
        reversals and its start from rest, and at least ``STEPS_A_CYCLE`` equal steps per cycle.
        """
        last = float(samples[-1])
        between = np.arange(0.5 * math.pi, last, math.pi)
        if self.load_ripple > 0.0:
            ripple = np.arange(0.5 * math.pi, last + self.ripple_phase, math.pi)
            ripple = np.append(ripple, 0.0) - self.ripple_phase
            parts = math.ceil(STEPS_A_CYCLE * samples[1] / (2.0 * math.pi) - 1e-9)
            steps = samples[1] / parts * np.arange(parts * samples.size - parts)
            between = np.concatenate((between, ripple[(ripple > 0.0) & (ripple < last)], steps))
        angles = np.union1d(samples, between)
        return angles, np.searchsorted(angles, samples)

    def _respond(self, x: Floats, amplitude: float, angle: Floats) -> tuple[Floats, Floats | None]:
        """Return force [N] and normal load [N] for displacements ``x`` [m] from rest.

        The normal load is None if the tribometer has none.
        """
        mean: float | None = getattr(self.joint, "normal_load", None)
        if mean is None or self.load_ripple == 0.0:
            load = None if mean is None else np.full(x.size, mean)
            return np.asarray(self.series.force(x)), load
        ahead = amplitude * motion_over_amplitude(angle + self.ripple_phase, self.third_harmonic)
        at_mean = np.asarray(self.series.force(ahead))
        ripple = self.load_ripple / float(self.series.backbone(amplitude))
        load = mean * (1.0 + ripple * at_mean)
        if self.rig_stiffness is None:
            return np.asarray(self.joint.start().advance(x, load)), load
        return self._step(x, load, self.joint.force_limit / mean, self.rig_stiffness), load

    def _step(self, x: Floats, load: Floats, friction: float, stiffness: float) -> Floats:
        state, forces = self.joint.start(), np.empty(x.size)
        u, tangent = 0.0, self.joint.tangential_stiffness
        force = 0.0
        for i, (place, weight) in enumerate(zip(x.tolist(), load.tolist(), strict=True)):
            reach = friction * weight / stiffness  # |T| <= mu N
            low, high = place - reach, place + reach
            tolerance = 1e-14 * (abs(place) + reach)
            # First guess: along the last tangent.
            u += (stiffness * (place - u) - force) / (stiffness + tangent)
            for _ in range(200):
                if not low <= u <= high:
                    u = 0.5 * (low + high)
                force, tangent = state.try_(u, weight)
                gap = stiffness * (place - u) - force  # falls with u
                if gap > 0.0:
                    low = u
                else:
                    high = u
                move = gap / (stiffness + tangent)
                if abs(move) <= tolerance or high - low <= tolerance:
                    break
                u += move
            state.commit()
            forces[i] = force
        return forces

    def _with_noise(self, clean: Mapping[str, Floats], amplitude: float) -> dict[str, Any]:
        # A stream of its own for each channel: noise on one changes nothing in the others.
        streams = np.random.default_rng(self.seed).spawn(len(_CHANNELS))
        noisy = {}
        for name, stream in zip(_CHANNELS, streams, strict=True):
            if name not in clean:
                continue
            values = clean[name]
            half_range = amplitude if name == "displacement" else 0.5 * float(np.ptp(values))
            size = self.noise * (float(values.mean()) if name == "normal_load" else half_range)
            noisy[name] = values + stream.normal(0.0, size, values.size) if size else values
        return noisy


def motion_over_amplitude(angle: Floats, share: float) -> Floats:
    """Return displacement over amplitude: a sine with third harmonic; zero up to angle 0."""
    moved = (np.sin(angle) + share * np.sin(3.0 * angle)) / (1.0 - share)
    return np.where(angle > 0.0, moved, 0.0)
