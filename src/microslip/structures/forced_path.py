"""Continuation of periodic motions over a range of frequencies, around turning points.

By arc length (Keller's method), as in Krack and Gross (2019), DOI 10.1007/978-3-030-14023-6.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.structures.balance import Balance

_ITERATIONS = 25
_STEP = 1e-10
_MOST_POINTS = 3000
_ENOUGH = 8  # iterations with which a step is as long as it should be, twice over
_FINEST = 1e-6  # shortest arc step, beside the range of frequencies


def at_frequency(parts: dict[int, Floats], omega: float) -> tuple[Any, Any]:
    """Return the sum of part * omega^-k over ``parts`` by k, and its derivative by omega."""
    value = sum((part * omega**-k for k, part in parts.items()), 0.0)
    slope = sum((-k * part * omega ** -(k + 1) for k, part in parts.items() if k), 0.0)
    return value, slope


@dataclass(frozen=True, eq=False)
class Control:
    """Sensor whose fundamental amplitude is controlled, and its target."""

    sensor: Floats
    """Sensor in modal coordinates, shape (modes,)."""
    carried: Floats
    """Motion of the sensor with the base, cosine and sine, times omega^2 at level 1."""
    power: int
    """0, 1, 2: displacement, velocity, acceleration."""
    target: float
    """Target amplitude of that quantity."""

    def miss(self, q: Floats, omega: float, level: float) -> tuple[float, Floats, float, float]:
        """Return (amplitude/target)^2 - 1 and its derivatives with respect to q, level and omega.

        q are Fourier coefficients of the modal coordinates (modes, size); omega is in [rad/s].
        """
        signal = self.sensor @ q[:, 1:3] + level * self.carried / omega**2
        factor = omega ** (2 * self.power) / self.target**2
        value = factor * float(signal @ signal)
        by_q = np.zeros_like(q)
        by_q[:, 1:3] = 2.0 * factor * self.sensor[:, None] * signal
        crossed = 2.0 * factor * float(signal @ self.carried) / omega**2
        by_omega = 2.0 * self.power * value / omega - 2.0 * level * crossed / omega
        return value - 1.0, by_q, crossed, by_omega


class _Point(NamedTuple):
    coefficients: Floats
    omega: float
    level: float
    """Factor of the excitation."""


class _Solved(NamedTuple):
    point: _Point
    tangent: Floats
    """Unit tangent of the path in scaled unknowns."""
    iterations: int
    stable: bool


@dataclass(frozen=True, eq=False)
class Drive:
    """Equations of motion under an excitation whose level is given or set by a control.

    Forces and base motions are sums of F_k omega^-k [rad/s], given as dictionaries from k to the
    Fourier coefficients F_k.
    """

    balance: Balance
    forces: dict[int, Floats]
    """Forces on the modes, shape (modes, size)."""
    motions: dict[int, Floats]
    """Joint motions imposed by a moving base, besides those of the modes (coordinates, size)."""
    rigid: NDArray[np.complex128]
    """Rigid-body coordinates (motions,), times omega^2."""
    control: Control | None = None

    def linear_response(self, omega: float, share: float) -> _Point:
        """Return the linear response with sticking joints, as a starting point of iterations.

        Without a control the excitation has the level ``share``. With a control the level is such
        that the sensor has ``share`` times the target amplitude.
        """
        balance = self.balance
        modes, size = balance.shape
        matrix = balance.linear_matrix(omega, 0.0).reshape(modes * size, modes * size)
        force = at_frequency(self.forces, omega)[0]
        q = np.linalg.solve(matrix, force.reshape(-1)).reshape(modes, size)
        level = share
        if self.control is not None:
            level /= math.sqrt(self.control.miss(q, omega, 1.0)[0] + 1.0)
        return _Point(level * q, omega, level)


class _Path:
    """Equations along the path in scaled unknowns: Fourier coefficients, level and frequency.

    The level is unknown only if the drive has a control. ``unit`` and ``width`` scale coefficients
    [m] and changes of omega [rad/s].
    """

    def __init__(self, drive: Drive, unit: float, width: float, share: float = 1.0) -> None:
        self._drive, self._unit, self._width, self._share = drive, unit, width, share

    def _system(self, point: _Point) -> tuple[Floats, Floats]:
        balance, drive = self._drive.balance, self._drive
        modes, size = balance.shape
        q, omega, level = point
        push, push_slope = at_frequency(drive.forces, omega)
        carried, carried_slope = at_frequency(drive.motions, omega)
        forces, answers = balance.joint_forces(q, level * carried)
        gap = balance.linear(q, omega, 0.0) + forces - level * push
        inner = balance.linear_matrix(omega, 0.0) + balance.tangent_matrix(answers)
        by_omega = balance.by_omega(q, omega) - level * push_slope
        if drive.motions:
            by_omega = by_omega + balance.by_motion(answers, level * carried_slope)
        scale = np.maximum(balance.model.squares, omega**2)[:, None] * self._unit
        count = modes * size
        rows = count + (drive.control is not None)
        matrix, miss = np.zeros((rows, rows + 1)), np.zeros(rows)
        matrix[:count, :count] = (inner / scale[:, :, None, None]).reshape(count, count)
        matrix[:count, :count] *= self._unit
        matrix[:count, rows] = (by_omega / scale).reshape(-1) * self._width
        miss[:count] = (gap / scale).reshape(-1)
        if drive.control is not None:
            too_much, by_q, by_level, over_omega = drive.control.miss(q, omega, level)
            by_force = -push
            if drive.motions:
                by_force = by_force + balance.by_motion(answers, carried)
            unit_level = self._unit_level(omega)
            matrix[:count, count] = (by_force / scale).reshape(-1) * unit_level
            matrix[count, :count] = by_q.reshape(-1) * self._unit
            matrix[count, count] = by_level * unit_level
            matrix[count, rows] = over_omega * self._width
            miss[count] = too_much + 1.0 - self._share**2
        return miss, matrix

    def _unit_level(self, omega: float) -> float:
        """Return the excitation level at which the largest static modal response is ``unit``."""
        push = at_frequency(self._drive.forces, omega)[0]
        return self._unit / float(
            (np.abs(push).max(axis=1) / self._drive.balance.model.squares).max()
        )

    def solve(self, guess: _Point, tangent: Floats | None) -> _Solved | None:
        """Solve by Newton's method with steps normal to ``tangent``; None fixes the frequency."""
        modes, size = self._drive.balance.shape
        count = modes * size
        controlled = self._drive.control is not None
        point = guess
        last_unknown = np.append(np.zeros(count + controlled), 1.0)
        border = last_unknown if tangent is None else tangent
        last = math.inf
        for iterations in range(1, _ITERATIONS + 1):
            gap, matrix = self._system(point)
            system = np.concatenate([matrix, border[None]])
            try:
                step = np.linalg.solve(system, np.append(gap, 0.0))
            except np.linalg.LinAlgError:
                return None
            length = float(np.abs(step).max())
            if not math.isfinite(length) or length > 1e3:
                return None
            point = self.moved(point, -step)
            if point.omega <= 0.0:
                return None
            relative = length / max(1e-3, float(np.abs(point.coefficients).max()) / self._unit)
            if relative < _STEP or (relative < 1e-8 and relative >= last):
                along = np.linalg.solve(system, last_unknown)
                stable = bool(np.linalg.slogdet(matrix[:count, :count])[0] > 0.0)
                return _Solved(point, along / np.linalg.norm(along), iterations, stable)
            last = relative
        return None

    def moved(self, point: _Point, move: Floats) -> _Point:
        count = point.coefficients.size
        change = move[:count].reshape(point.coefficients.shape) * self._unit
        level = point.level
        if self._drive.control is not None:
            level += float(move[count]) * self._unit_level(point.omega)
        omega = point.omega + float(move[-1]) * self._width
        return _Point(point.coefficients + change, omega, level)

    def distance(self, a: _Point, b: _Point) -> float:
        q = float(np.linalg.norm(a.coefficients - b.coefficients)) / self._unit
        return math.hypot(q, (a.omega - b.omega) / self._width)


def follow(drive: Drive, targets: Floats) -> tuple[list[_Solved], dict[str, Any]]:
    """Follow periodic motions from the first to the last of the frequencies ``targets`` [Hz].

    Return the points of the path, and the values of the attributes of a :class:`ForcedResponse`.
    """
    path, marks, iterations, stopped = _follow(drive, 2.0 * math.pi * targets)
    message = f"solved at {len(path)} points in {iterations} iterations"
    if stopped:
        where = path[-1].point.omega / (2.0 * math.pi) if path else targets[0]
        message = (
            f"stopped at {where:.6g} Hz after {iterations} iterations: {stopped}; try more "
            "samples, other harmonics, some damping, or less force"
        )
    model, harmonics = drive.balance.model, drive.balance.basis.harmonics
    motion = np.zeros((len(path), model.size + drive.rigid.size, len(harmonics)), dtype=complex)
    for row, solved in zip(motion, path, strict=True):
        q, omega, level = solved.point
        row[: model.size, 0] = q[:, 0]
        row[: model.size, 1:] = q[:, 1::2] - 1j * q[:, 2::2]
        row[model.size :, 1] = level * drive.rigid / omega**2
    return path, {
        "frequency": np.array([solved.point.omega / (2.0 * math.pi) for solved in path]),
        "_coordinates": motion,
        "_shapes": np.concatenate([model.shapes, model.free], axis=1),
        "harmonics": harmonics,
        "requested": np.array(marks, dtype=bool),
        "stable": np.array([solved.stable for solved in path], dtype=bool),
        "iterations": iterations,
        "message": message,
    }


def _follow(drive: Drive, omegas: Floats) -> tuple[list[_Solved], list[bool], int, str]:
    direction = 1.0 if omegas[-1] > omegas[0] else -1.0
    span = abs(float(omegas[-1] - omegas[0]))
    start = drive.linear_response(float(omegas[0]), 1.0)
    unit = float(np.abs(start.coefficients).max())
    path = _Path(drive, unit, span)
    here = path.solve(start, None)
    if here is None:
        here = _ramped(drive, float(omegas[0]), span)
    if here is None:
        return [], [], 0, "the first frequency was not solved"
    # Near a resonance the motion is many times that off it: the arc is measured by the largest.
    iterations = here.iterations
    points, marks = [here], [True]
    if here.tangent[-1] * direction < 0.0:
        here = here._replace(tangent=-here.tangent)
    step = 0.25 * abs(float(omegas[1] - omegas[0])) / span
    longest = float(np.abs(np.diff(omegas)).max()) / span
    while len(points) < _MOST_POINTS:
        largest = max(float(np.abs(here.point.coefficients).max()), unit)
        path = _Path(drive, largest, span)
        rescaled = np.append(here.tangent[:-1] / (largest / unit), here.tangent[-1])
        here = here._replace(tangent=rescaled / np.linalg.norm(rescaled))
        unit = largest
        # Not further than the frequencies asked for lie apart, and a tenth of the motion itself.
        step = min(step, longest / max(abs(float(here.tangent[-1])), 1e-3 * longest), 0.2)
        ahead = path.solve(path.moved(here.point, step * here.tangent), here.tangent)
        if ahead is None or path.distance(ahead.point, here.point) > 2.0 * step:
            step *= 0.5
            if step < _FINEST:
                return points, marks, iterations, "the steps along the path became too short"
            continue
        iterations += ahead.iterations
        if float(ahead.tangent @ here.tangent) < 0.0:
            ahead = ahead._replace(tangent=-ahead.tangent)
        went = ahead.point.omega - here.point.omega
        inside = [w for w in omegas if 0.0 < (w - here.point.omega) * np.sign(went) <= abs(went)]
        for omega in sorted(inside, reverse=ahead.point.omega < here.point.omega):
            share = (omega - here.point.omega) / (ahead.point.omega - here.point.omega)
            guess, level = (
                b + share * (a - b)
                for a, b in (
                    (ahead.point.coefficients, here.point.coefficients),
                    (ahead.point.level, here.point.level),
                )
            )
            at = path.solve(_Point(guess, float(omega), level), None)
            if at is not None:
                iterations += at.iterations
                points.append(at)
                marks.append(True)
        if (ahead.point.omega - omegas[-1]) * direction >= 0.0:
            return points, marks, iterations, ""
        if (omegas[0] - ahead.point.omega) * direction > 0.05 * span:
            return points, marks, iterations, "the response turned back beyond the first frequency"
        points.append(ahead)
        marks.append(False)
        step *= min(2.0, max(0.5, _ENOUGH / 2.0 / ahead.iterations))
        here = ahead
    return points, marks, iterations, f"{_MOST_POINTS} points did not reach the last frequency"


def _ramped(drive: Drive, omega: float, span: float) -> _Solved | None:
    """Return the first point of a path, solved with excitation increasing to the full level.

    ``span`` is the range of omega along the path [rad/s]. None if the solution fails.
    """
    guess = drive.linear_response(omega, 1e-3)
    solved = None
    for share in np.geomspace(1e-3, 1.0, 25):
        linear = drive.linear_response(omega, share)
        unit = max(float(np.abs(p.coefficients).max()) for p in (guess, linear))
        level = share if drive.control is None else guess.level
        solved = _Path(drive, unit, span, share).solve(guess._replace(level=level), None)
        if solved is None:
            return None
        ahead = 25.0 / 24.0
        guess = _Point(solved.point.coefficients * ahead, omega, solved.point.level * ahead)
    return solved
