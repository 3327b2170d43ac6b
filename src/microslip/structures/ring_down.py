"""A free decay in time: its integration and evaluation."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import LockedArrays, lock
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.friction import BackboneLaw
from microslip.friction.energies import energies_along
from microslip.friction.memory import State

_MOST_SAMPLES = 20_000_000
_PATIENCE = 20.0  # longest half cycle, over the longest that swings
_TRIALS = 40


@dataclass(frozen=True, eq=False)
class RingDown(LockedArrays, Plottable):
    """Free oscillation, sampled evenly in time, with its turning points.

    Cycle i is from turning point 2i to turning point 2i + 2. Since a joint may hold the mass away
    from zero, amplitudes are half the distance from one turning point to the next. The joint force
    obeys Masing's rule with memory: (19.19)-(19.24) of DOI 10.1007/978-3-319-56818-8_19. Swings
    smaller than 1e-12 of the displacement about which they occur are below the rounding error of
    the joint force and count as rest.
    """

    time: NDArray[np.float64]
    """Times since the release [s], evenly spaced."""
    displacement: NDArray[np.float64]
    """Displacements [m]."""
    velocity: NDArray[np.float64]
    """Velocities [m/s]."""
    force: NDArray[np.float64]
    """Force of the joint [N], positive if it resists a positive displacement."""
    mechanical_energy: NDArray[np.float64]
    """Kinetic energy plus the energies stored in spring and joint [J]."""
    dissipated_energy: NDArray[np.float64]
    """Energy dissipated by the joint since the release [J]."""
    viscous_energy: NDArray[np.float64]
    """Energy dissipated by the dashpot [J]."""
    turning_time: NDArray[np.float64]
    """Times of the turning points [s], release included, to the accuracy of the integrator."""
    turning_displacement: NDArray[np.float64]
    """Turning points [m]; these points are not among the samples."""

    def _figure(self) -> Plot:
        from microslip.structures.figures import ring_down_figure

        return ring_down_figure(self)

    @cached_property
    def _half_ranges(self) -> tuple[Floats, Floats]:
        """Half-ranges [m] of the downward and of the upward motion of each whole cycle."""
        half = 0.5 * np.abs(np.diff(self.turning_displacement))
        end = half.size // 2 * 2
        return half[:end:2], half[1:end:2]

    @cached_property
    def amplitude(self) -> Floats:
        """Amplitude of each cycle [m], the mean of its two half ranges."""
        down, up = self._half_ranges
        return lock(0.5 * (down + up))

    @cached_property
    def frequency(self) -> Floats:
        """Frequency of each cycle [Hz], the reciprocal of its duration.

        With the damping ratio zeta it is sqrt(1 - zeta^2) times the natural frequency.
        """
        begin = self.turning_time[: 2 * self._half_ranges[0].size + 1 : 2]
        return lock(1.0 / np.diff(begin))

    @cached_property
    def damping_ratio(self) -> Floats:
        """Damping ratio of each cycle [-] by the logarithmic decrement of its half ranges."""
        down, up = self._half_ranges
        decrement = np.log(down / up)
        return lock(decrement / np.hypot(math.pi, decrement))

    @cached_property
    def energy_error(self) -> float:
        """Largest change of mechanical plus dissipated energy, over the energy at release [-]."""
        total = self.mechanical_energy + self.dissipated_energy + self.viscous_energy
        return float(np.abs(total / total[0] - 1.0).max())

    def __repr__(self) -> str:
        return (
            f"RingDown({self.time.size} samples in {self.time[-1]:g} s, "
            f"{self._half_ranges[0].size} cycles, release at {self.displacement[0]:g} m)"
        )


# -- one step --------------------------------------------------------------------------------------

# The cubic of Hermite on [0, 1], for a value and a slope at each end, in powers of s.
_HERMITE = np.array(
    [[1.0, 0.0, -3.0, 2.0], [0.0, 1.0, -2.0, 1.0], [0.0, 0.0, 3.0, -2.0], [0.0, 0.0, -1.0, 1.0]]
)
_TERMS = 26


@lru_cache(maxsize=1)
def _weights() -> list[tuple[float, ...]]:
    """Return Taylor coefficients of exp(A) and of the integrals of exp(A (1 - s)) H(s).

    The integrals are over 0 <= s <= 1, for each of the four Hermite cubics H. The result has a
    tuple for each power of A, with the coefficients of exp(A) and of the four integrals.
    """
    n = np.arange(_TERMS)
    factorial = np.array([math.factorial(int(i)) for i in range(_TERMS + 4)], dtype=float)
    # Integral of (1 - s)^n/n! s^j over [0, 1].
    powers = np.array([factorial[j] / factorial[n + j + 1] for j in range(4)])
    rows = np.vstack((1.0 / factorial[n], _HERMITE @ powers))
    return [tuple(column) for column in rows.T.tolist()]


def _propagator(step: float, square: float, twice: float, mass: float) -> tuple[float, ...]:
    """Return coefficients of a step of q'' + twice q' + square q = -g/mass.

    g is the joint force minus that of the sticking joint, a cubic in time. Six coefficients are for
    the new displacement, then six for the new velocity: the factors of the old q and q', of g and
    g' at the beginning of the step, and of g and g' at its end.
    """
    p, r = 0.0, 1.0  # the response to an impulse, in powers of the step
    e12 = e22 = 0.0
    q0 = q1 = q2 = q3 = v0 = v1 = v2 = v3 = 0.0
    for w, w0, w1, w2, w3 in _weights():
        e12 += w * p
        e22 += w * r
        q0 += w0 * p
        q1 += w1 * p
        q2 += w2 * p
        q3 += w3 * p
        v0 += w0 * r
        v1 += w1 * r
        v2 += w2 * r
        v3 += w3 * r
        p, r = step * r, -step * (square * p + twice * r)
        if w * (abs(p) + step * abs(r)) <= 1e-19 * abs(e12):
            break
    h = -step / mass
    k = h * step
    return (
        e22 + twice * e12, e12, h * q0, k * q1, h * q2, k * q3,
        -square * e12, e22, h * v0, k * v1, h * v2, k * v3,
    )  # fmt: skip


class _Motion:
    def __init__(
        self, joint: BackboneLaw, mass: float, spring: float, dashpot: float, amplitude: float
    ) -> None:
        stiffness = joint.tangential_stiffness
        self.mass, self.spring, self.dashpot = mass, spring, dashpot
        # The linear part of each step: that of the sticking joint.
        self.held = stiffness if math.isfinite(stiffness) else 0.0
        self.square = (self.spring + self.held) / self.mass
        self.state: State = joint.start()
        self.q, self.v, self.viscous = amplitude, 0.0, 0.0
        self.force = self.state.try_(amplitude)[0]
        self.state.commit()
        self.turns = [(0.0, amplitude, self.force)]
        self.range = amplitude
        self.rests = not self.turn(-1)

    def turn(self, way: int) -> bool:
        """Reverse at a turning point to direction ``way`` (1 or -1); False if the mass stays."""
        self.way, self.v, self.before = way, 0.0, (0.0, 0.0, 0.0)
        # Force and tangent are those after the reversal, which a rigid joint feels at once.
        self.force, slope = self.state.try_(math.nextafter(self.q, way * math.inf))
        self.state.rollback()
        self.fall = slope - self.held
        self.a = -(self.spring * self.q + self.force) / self.mass
        return self.a * way > 0.0

    def propagator(self, step: float) -> tuple[float, ...]:
        return _propagator(step, self.square, self.dashpot / self.mass, self.mass)

    def step(self, step: float, propagator: tuple[float, ...], time: float) -> None:
        if not self._turns_in(step, propagator):
            end = self._solve(step, propagator)
            if end[1] * self.way > 0.0:
                self._accept(step, end)
                return
        turned = self._to_turning_point(step)
        self.turns.append((time + turned, self.q, self.state.force))
        self.range = 0.5 * abs(self.q - self.turns[-2][1])
        moves = self.turn(-self.way)
        if not moves or self.range <= 1e-12 * abs(self.q):
            self.rests = True
        elif step - turned > 1e-12 * step:
            remainder = step - turned
            self._accept(remainder, self._solve(remainder, self.propagator(remainder)))

    def _turns_in(self, step: float, propagator: tuple[float, ...]) -> bool:
        """Return whether the velocity changes its sign if the joint force continues as a cubic."""
        rate = self.fall * self.v
        g = self.force - self.held * self.q
        e21, e22, v0, v1, v2, v3 = propagator[6:]
        v = e21 * self.q + e22 * self.v + (v0 + v2) * g + (v1 + v3 + step * v2) * rate
        return v * self.way <= 0.0

    def _solve(
        self, step: float, propagator: tuple[float, ...]
    ) -> tuple[float, float, float, float]:
        """Return displacement, velocity, force, and tangent minus that at rest, after a step."""
        e11, e12, q0, q1, q2, q3, e21, e22, v0, v1, v2, v3 = propagator
        g, rate = self.force - self.held * self.q, self.fall * self.v
        explicit = e11 * self.q + e12 * self.v + q0 * g + q1 * rate
        pace = e21 * self.q + e22 * self.v + v0 * g + v1 * rate
        length, old, pace_before = self.before
        if length == step:
            # As the cubic through the two steps goes on.
            ahead = 5.0 * old - 4.0 * g + step * (2.0 * pace_before + 4.0 * rate)
            x = explicit + q2 * ahead
            x += q3 * (12.0 * (old - g) / step + 5.0 * pace_before + 8.0 * rate)
        else:
            x = explicit + q2 * (g + step * rate) + q3 * rate
        enough = 1e-13 * self.range + 1e-15 * abs(x)
        for _ in range(_TRIALS):
            force, slope = self.state.try_(x)
            fall = slope - self.held
            g = force - self.held * x
            v = (pace + v2 * g) / (1.0 - v3 * fall)
            miss = explicit + q2 * g + q3 * fall * v - x
            if abs(miss) <= enough:
                break
            x += miss / (1.0 - q2 * fall)
        return x, v, force, fall

    def _to_turning_point(self, step: float) -> float:
        jerk = -((self.spring + self.held + self.fall) * self.v + self.dashpot * self.a) / self.mass
        tau = min(-self.v / self.a, step)
        tau = min(-self.v / (self.a + 0.5 * jerk * tau), step)
        tolerance = math.sqrt(self.square) * (1e-13 * self.range + 1e-15 * abs(self.q))
        for _ in range(_TRIALS):
            end = self._solve(tau, self.propagator(tau))
            if abs(end[1]) <= tolerance:
                break
            x, v, force, _ = end
            a = -(self.spring * x + force + self.dashpot * v) / self.mass
            before, tau = tau, min(max(tau - v / a, 0.0), step)
            if tau == before:
                break
        self._accept(tau, end)
        return tau

    def _accept(self, step: float, end: tuple[float, float, float, float]) -> None:
        self.state.commit()
        self.before = step, self.force - self.held * self.q, self.fall * self.v
        self.q, v, self.force, self.fall = end
        a = -(self.spring * self.q + self.force + self.dashpot * v) / self.mass
        if self.dashpot > 0.0:
            # Simpson's rule, the velocity in the middle from the cubic through both ends.
            middle = 0.5 * (self.v + v) + 0.125 * step * (self.a - a)
            square = (self.v**2 + 4.0 * middle**2 + v**2) / 6.0
            self.viscous += self.dashpot * step * square
        self.v, self.a = v, a


def ring_down(
    joint: BackboneLaw,
    mass: float,
    spring: float,
    dashpot: float,
    stuck: float,
    amplitude: float,
    cycles: int | None,
    duration: float | None,
    samples_per_cycle: int,
) -> RingDown:
    """Integrate a free oscillation; ``stuck`` [rad/s] is its frequency with a sticking joint."""
    if stuck == 0.0:
        raise InputError(
            "`stiffness` must be above zero with a joint that is rigid at rest: without a "
            "spring there is no oscillation, got 0"
        )
    period = 2.0 * math.pi / stuck
    step, count = period / samples_per_cycle, _MOST_SAMPLES
    if duration is not None:
        count = max(1, math.ceil(duration / step * (1.0 - 1e-12)))
        step = duration / count
    samples = float(count if cycles is None else cycles * samples_per_cycle)
    if samples > _MOST_SAMPLES:
        raise InputError(
            f"ring_down computes at most {_MOST_SAMPLES} samples, this one needs {samples:.3g}; "
            "take fewer cycles, a shorter duration or fewer samples_per_cycle"
        )
    turns = math.inf if cycles is None else 2 * cycles
    motion = _Motion(joint, mass, spring, dashpot, amplitude)
    propagator = motion.propagator(step)
    patience = math.inf
    if cycles is not None:
        slip = math.sqrt(spring / mass)
        slowest = period + (2.0 * math.pi / slip if slip > 0.0 else 0.0)
        patience = _PATIENCE * slowest / step
    # Numbers in a row: a sample is 32 bytes, not four objects.
    rows, size = array("d", (motion.q, 0.0, motion.state.force, 0.0)), 1
    before, latest = [1], 0  # of each turning point: the index of the first sample after it
    while size <= count and len(motion.turns) <= turns and not motion.rests:
        motion.step(step, propagator, step * (size - 1))
        if len(motion.turns) > len(before):
            before.append(size)
            latest = size
        elif size - latest > patience:
            raise InputError(
                "cycles cannot be counted: the mass creeps back without turning, since the "
                "dashpot is strong against the sliding joint; give duration=... [s] instead"
            )
        # The state's own force: at a sample that is a turning point that of the way there.
        rows.extend((motion.q, motion.v, motion.state.force, motion.viscous))
        size += 1
        if size > _MOST_SAMPLES and cycles is not None:
            raise InputError(
                f"ring_down computes at most {_MOST_SAMPLES} samples, and {len(motion.turns) // 2} "
                "cycles have taken that many; take fewer cycles"
            )
    q, v, force, viscous = np.array(rows).reshape(size, 4).T.copy()
    times, places, forces = np.array(motion.turns).T
    # All places in the order of time.
    at = np.array(before[1:], dtype=np.int64)
    path, path_forces = np.insert(q, at, places[1:]), np.insert(force, at, forces[1:])
    stored, lost = energies_along(joint, path, path_forces)
    sample = np.arange(q.size) + np.searchsorted(at, np.arange(q.size), side="right")
    if motion.rests:
        # Held, or swinging by less than its place is known to.
        v[-1], force[-1] = 0.0, -spring * q[-1]
        missing = count + 1 - size if duration is not None else 0
        q, v, force, viscous = (np.pad(row, (0, missing), "edge") for row in (q, v, force, viscous))
        sample = np.pad(sample, (0, missing), "edge")
    mechanical = 0.5 * (mass * v**2 + spring * q**2) + stored[sample]
    return RingDown(
        time=np.asarray(step * np.arange(q.size), dtype=float),
        displacement=q,
        velocity=v,
        force=force,
        mechanical_energy=mechanical,
        dissipated_energy=lost[sample] - lost[0],
        viscous_energy=viscous,
        turning_time=times,
        turning_displacement=places,
    )
