"""The envelope of a free oscillation as a slow flow: no swing is followed, only their amplitude."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats, exact
from microslip.errors import Argument, InputError
from microslip.structures.swinging import Swinging

MOST_CYCLES = 10_000_000
STEEPEST = 0.5
"""Share of its amplitude that a cycle may lose and still be slow."""
_FAINTEST = 1e-90  # of the first amplitude: what is smaller is nothing


def slow_flow(
    oscillator: Swinging, amplitude: float, cycles: int | None, duration: float | None
) -> tuple[Floats, Floats, Floats, Floats]:
    """Times, amplitudes, frequencies and damping ratios after 0, 1, 2 ... cycles."""
    from scipy.integrate import solve_ivp
    from scipy.interpolate import CubicSpline

    joint, dashpot = oscillator.joint, oscillator.viscous_coefficient
    stuck = oscillator._stuck
    periods = math.inf if duration is None else duration * stuck / (2.0 * math.pi)
    places = np.linspace(math.log(amplitude) - 20.0, math.log(amplitude), 257)
    balanced = oscillator.angular_frequency(np.exp(places), method="harmonic-balance")
    omega = CubicSpline(places, balanced)

    def rates(a: Floats) -> tuple[Floats, Floats, Floats]:
        """What a cycle takes of an amplitude, its angular frequency and its damping ratio."""
        stiffness = oscillator.stiffness + joint._slope(a)
        swing = omega(np.maximum(np.log(a), places[0]))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            friction = joint._energy(a) / a / stiffness
            viscous = 0.5 * dashpot * swing / stiffness
            slowed = np.sqrt(1.0 - viscous**2)
            lost = friction + 2.0 * math.pi * a * viscous / slowed
        # As a logarithmic decrement would show it.
        decrement = 0.5 * friction / math.pi / a
        return lost, swing * slowed, viscous + decrement

    def flow(_: float, state: Floats) -> tuple[float, float]:
        """Per cycle: of the amplitude over the first one, of the time in periods when stuck."""
        lost, seen, _ratio = rates(amplitude * np.maximum(state[:1], _FAINTEST))
        return -float(lost[0]) / amplitude, stuck / float(seen[0])

    def slow(_: float, state: Floats) -> float:
        share = max(float(state[0]), _FAINTEST)
        return STEEPEST + flow(0.0, np.array([share]))[0] / share

    def there(_: float, state: Floats) -> float:
        return float(state[0]) - _FAINTEST

    def within(_: float, state: Floats) -> float:
        return periods - float(state[1])

    if not slow(0.0, np.ones(1)) > 0.0:
        raise InputError(
            Argument("amplitude"),
            f" must be one that decays slowly: of {exact(amplitude)} m a cycle would lose "
            "more than half; ring_down(...) follows any motion",
        )
    if duration is not None and not periods <= MOST_CYCLES:
        raise InputError(
            Argument("duration"),
            f" must be at most {MOST_CYCLES} periods of the oscillator, "
            f"got {exact(duration)} s, which are {periods:.3g}",
        )
    most = periods + 1.0 if cycles is None else float(cycles)
    events = [slow, there] + ([within] if cycles is None else [])
    for event in events:
        event.terminal = True  # type: ignore[attr-defined]  # as SciPy wants it
    solution = solve_ivp(
        flow,
        (0.0, most),
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
    _, seen, ratio = rates(a)
    return time * (2.0 * math.pi / stuck), a, seen / (2.0 * math.pi), ratio
