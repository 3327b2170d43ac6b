"""The envelope of a free decay with a joint, without its single cycles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact
from microslip._core.frozen import LockedArrays
from microslip.errors import InputError
from microslip.friction import BackboneLaw
from microslip.kernels import Integers
from microslip.numerics.inversion import adaptive

MOST_CYCLES = 10_000_000
_STEEPEST = 0.5  # share of its amplitude that a cycle may lose and still be slow
_FAINTEST = 1e-90  # of the first amplitude: what is smaller is nothing


@dataclass(frozen=True, eq=False)
class Decay(LockedArrays):
    """The envelope of a free oscillation, at its beginning and after each cycle.

    Amplitudes vary slowly, as in the averaging of Caughey (1960, DOI 10.1115/1.3644075); what an
    amplitude holds of energy is taken from the joint's turning points.
    """

    time: NDArray[np.float64]
    """Times since the release [s]."""
    amplitude: NDArray[np.float64]
    """Amplitudes [m]."""
    frequency: NDArray[np.float64]
    """Frequencies with which the oscillation is seen to swing, 1/period [Hz]."""
    damping_ratio: NDArray[np.float64]
    """Damping ratios that a logarithmic decrement shows [-]."""

    def __repr__(self) -> str:
        return (
            f"Decay({self.time.size - 1} cycles in {self.time[-1]:g} s, "
            f"amplitude from {self.amplitude[0]:g} to {self.amplitude[-1]:g})"
        )


def averaged_stiffness(joint: BackboneLaw, a: Floats) -> Floats:
    """First harmonic of the loop in phase with the displacement, over the amplitude [N/m].

    (4/pi a) times the integral of [T0(a) - T0(a sin^2(phi/2))] cos(phi) over the descending
    branch, 0 <= phi <= pi: adaptive, since a backbone may have kinks.
    """
    result = np.full_like(a, joint.tangential_stiffness)
    moved = np.flatnonzero(a > 0.0)
    if moved.size == 0:
        return result
    amplitude = a[moved]
    peak = joint._backbone(amplitude)

    # In gross slip all happens soon after the turning point.
    def integrand(phi: Floats, index: Integers) -> Floats:
        below = peak[index] - joint._backbone(amplitude[index] * np.sin(0.5 * phi) ** 2)
        return np.asarray(below * np.cos(phi))

    total = adaptive(integrand, np.full(moved.size, math.pi), 1e-13, 50)
    result[moved] = 4.0 / math.pi * total / amplitude
    return result


def slow_flow(
    joint: BackboneLaw,
    mass: float,
    spring: float,
    dashpot: float,
    stuck: float,
    amplitude: float,
    cycles: int | None,
    duration: float | None,
) -> Decay:
    """The envelope after 0, 1, 2 ... cycles, see :meth:`microslip.Oscillator.decay`."""
    from scipy.integrate import solve_ivp
    from scipy.interpolate import CubicSpline

    periods = math.inf if duration is None else duration * stuck / (2.0 * math.pi)
    places = np.linspace(math.log(amplitude) - 20.0, math.log(amplitude), 257)
    averaged = averaged_stiffness(joint, np.exp(places))
    omega = CubicSpline(places, np.sqrt((spring + averaged) / mass))

    def rates(a: Floats) -> tuple[Floats, Floats, Floats]:
        """Amplitude lost a cycle, angular frequency and damping ratio."""
        stiffness = spring + joint._slope(a)
        natural = omega(np.maximum(np.log(a), places[0]))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            friction = joint._energy(a) / a / stiffness
            viscous = 0.5 * dashpot * natural / stiffness
            slowed = np.sqrt(1.0 - viscous**2)
            lost = friction + 2.0 * math.pi * a * viscous / slowed
        # As a logarithmic decrement would show it.
        decrement = 0.5 * friction / math.pi / a
        return lost, natural * slowed, viscous + decrement

    def flow(_: float, state: Floats) -> tuple[float, float]:
        """Per cycle: of the amplitude over the first one, of the time in periods when stuck."""
        lost, swing, _ratio = rates(amplitude * np.maximum(state[:1], _FAINTEST))
        return -float(lost[0]) / amplitude, stuck / float(swing[0])

    def slow(_: float, state: Floats) -> float:
        share = max(float(state[0]), _FAINTEST)
        return _STEEPEST + flow(0.0, np.array([share]))[0] / share

    def there(_: float, state: Floats) -> float:
        return float(state[0]) - _FAINTEST

    def within(_: float, state: Floats) -> float:
        return periods - float(state[1])

    if not slow(0.0, np.ones(1)) > 0.0:
        raise InputError(
            f"`amplitude` must be one that decays slowly: of {exact(amplitude)} m a cycle "
            "would lose more than half; ring_down(...) follows any motion"
        )
    if duration is not None and not periods <= MOST_CYCLES:
        raise InputError(
            f"`duration` must be at most {MOST_CYCLES} periods of the oscillator, got "
            f"{exact(duration)} s, which are {periods:.3g}"
        )
    limit = periods + 1.0 if cycles is None else float(cycles)
    events = [slow, there] + ([within] if cycles is None else [])
    for event in events:
        event.terminal = True  # type: ignore[attr-defined]  # as SciPy wants it
    solution = solve_ivp(
        flow,
        (0.0, limit),
        (1.0, 0.0),
        method="DOP853",
        rtol=1e-10,
        atol=(1e-3 * _FAINTEST, 1e-10),
        dense_output=True,
        events=events,
    )
    count = math.floor(float(solution.t[-1]) * (1.0 + 1e-12))
    share, time = solution.sol(np.arange(count + 1.0))
    share[0], time[0] = 1.0, 0.0
    a = amplitude * np.maximum(share, _FAINTEST)
    _, swing, ratio = rates(a)
    return Decay(time * (2.0 * math.pi / stuck), a, swing / (2.0 * math.pi), ratio)
