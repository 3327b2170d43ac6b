"""Forced response by the balance of harmonics, followed around turning points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats
from microslip._core.frozen import LockedArrays
from microslip.errors import InputError
from microslip.report.plot import Plot
from microslip.report.plottable import PlottableAtSensor
from microslip.structures.balance import Balance
from microslip.structures.matrices import vector
from microslip.structures.modal_model import ModalModel
from microslip.structures.periodic_motion import harmonic_basis

_ITERATIONS = 25
_STEP = 1e-10
_MOST_POINTS = 3000
_ENOUGH = 8  # iterations with which a step is as long as it should be, twice over
_FINEST = 1e-6  # shortest arc step, beside the range of frequencies


@dataclass(frozen=True, eq=False, repr=False)
class ForcedResponse(LockedArrays, PlottableAtSensor):
    """Periodic motions along a range of frequencies; made by ``structure.forced_response(...)``.

    By the balance of harmonics with arc length (Keller's continuation), as in Krack and Gross
    (2019), DOI 10.1007/978-3-030-14023-6: where the response folds over, a frequency has several.
    """

    frequency: Floats
    """Frequencies along the path [Hz]; they turn back where the response folds."""
    displacement: NDArray[np.complex128]
    """Amplitudes x of each harmonic, (points, n, harmonics), motion Re(x exp(i h w t)) [m]."""
    harmonics: tuple[int, ...]
    """Which harmonics; 0 is the mean."""
    asked: NDArray[np.bool_]
    """Which points are at frequencies that were asked for."""
    stable: NDArray[np.bool_]
    """Which motions last: those between turning points do not.

    The sign of the determinant of the balance's Jacobian, which holds what settled cycles remember:
    right for growth that is slow beside the motion, not for motion at half its frequency or at a
    second one (Krack and Gross 2019, DOI 10.1007/978-3-030-14023-6).
    """
    iterations: int
    """Iterations of Newton's method in all."""
    message: str
    """What came of it; where and why it stopped, and what to try."""

    @property
    def status(self) -> str:
        """``solved``, or ``stopped`` before the last frequency."""
        return "solved" if self.message.startswith("solved") else "stopped"

    @property
    def turning_points(self) -> NDArray[np.int64]:
        """Indices of the points at which the frequency turns back."""
        way = np.sign(np.diff(self.frequency))
        return np.asarray(1 + np.flatnonzero(way[1:] != way[:-1]))

    def amplitude(self, at: ArrayLike) -> Floats:
        """Displacement amplitude of the fundamental harmonic at a sensor.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).

        Returns
        -------
        ndarray
            Amplitudes [m], one a point.
        """
        sensor = vector("at", at, self.displacement.shape[1])
        first = self.harmonics.index(1)
        return np.asarray(np.abs(self.displacement[:, :, first] @ sensor))

    def _figure(self, at: ArrayLike | None) -> Plot:
        from microslip.structures.figures import response_figure

        return response_figure(self, None if at is None else floats("at", at))

    def __repr__(self) -> str:
        return f"ForcedResponse({self.frequency.size} points, {self.message})"


class _Point(NamedTuple):
    coefficients: Floats
    omega: float


class _Solved(NamedTuple):
    point: _Point
    tangent: Floats
    """Unit tangent of the path in scaled unknowns."""
    iterations: int
    stable: bool


class _Path:
    """The equations along the path; unknowns are scaled coefficients and the frequency."""

    def __init__(self, balance: Balance, force: Floats, unit: float, width: float) -> None:
        self._balance, self._force = balance, force
        self._unit, self._width = unit, width

    def _system(self, point: _Point) -> tuple[Floats, Floats]:
        """Residual and its derivatives, (count,) and (count, count + 1), scaled."""
        balance = self._balance
        modes, size = balance.shape
        forces, answers = balance.joint_forces(point.coefficients)
        gap = balance.linear(point.coefficients, point.omega, 0.0) + forces - self._force
        inner = balance.linear_matrix(point.omega, 0.0) + balance.tangent_matrix(answers)
        by_omega = balance.by_omega(*point)
        scale = np.maximum(balance.model.squares, point.omega**2)[:, None] * self._unit
        count = modes * size
        matrix = np.empty((count, count + 1))
        matrix[:, :count] = (inner / scale[:, :, None, None]).reshape(count, count) * self._unit
        matrix[:, count] = (by_omega / scale).reshape(-1) * self._width
        return (gap / scale).reshape(-1), matrix

    def solve(self, guess: _Point, tangent: Floats | None) -> _Solved | None:
        """Newton's method across a tangent; at a fixed frequency without one."""
        modes, size = self._balance.shape
        point = guess
        last_unknown = np.append(np.zeros(modes * size), 1.0)
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
            move = step[:-1].reshape(modes, size) * self._unit
            omega = point.omega - float(step[-1]) * self._width
            if omega <= 0.0:
                return None
            point = _Point(point.coefficients - move, omega)
            relative = length / max(1e-3, float(np.abs(point.coefficients).max()) / self._unit)
            if relative < _STEP or (relative < 1e-8 and relative >= last):
                along = np.linalg.solve(system, last_unknown)
                stable = bool(np.linalg.slogdet(matrix[:, :-1])[0] > 0.0)
                return _Solved(point, along / np.linalg.norm(along), iterations, stable)
            last = relative
        return None

    def ahead(self, solved: _Solved, step: float) -> _Point:
        """A guess a step along the tangent."""
        modes, size = self._balance.shape
        move = step * solved.tangent
        return _Point(
            solved.point.coefficients + move[:-1].reshape(modes, size) * self._unit,
            solved.point.omega + float(move[-1]) * self._width,
        )

    def distance(self, a: _Point, b: _Point) -> float:
        """Between points, in scaled unknowns."""
        q = float(np.linalg.norm(a.coefficients - b.coefficients)) / self._unit
        return math.hypot(q, (a.omega - b.omega) / self._width)


def forced_response(
    model: ModalModel,
    force: ArrayLike,
    frequencies: ArrayLike,
    harmonics: Sequence[int],
    samples: int,
) -> ForcedResponse:
    """See :meth:`microslip.Preload.forced_response`."""
    size = model.shapes.shape[0]
    try:
        push = np.asarray(force)
    except Exception:  # an object's own conversion may raise anything; said below
        push = np.zeros(0)
    real = floats("force", np.stack([push.real, push.imag]) if np.iscomplexobj(push) else force)
    if not np.iscomplexobj(push):
        real = np.stack([real, np.zeros_like(real)])
    if real.shape != (2, size):
        raise InputError(f"force must have the shape ({size},), got {real.shape[1:]}")
    targets = floats("frequencies", frequencies)
    ways = np.sign(np.diff(targets.reshape(-1)))
    if targets.ndim != 1 or targets.size < 2 or targets.min() <= 0.0 or abs(ways.sum()) < ways.size:
        raise InputError(
            "frequencies must be at least two above zero that rise or fall [Hz], such as "
            "np.linspace(150.0, 200.0, 101)"
        )
    basis = harmonic_basis(harmonics, samples)
    modal = np.zeros((model.size, basis.size))
    # Re(F exp(i w t)) = Re F cos - Im F sin.
    modal[:, 1], modal[:, 2] = real[0] @ model.shapes, -(real[1] @ model.shapes)
    middle = (2.0 * math.pi * float(np.median(targets))) ** 2
    gain = np.abs(model.squares - middle) + 1e-3 * middle
    line = modal[:, 1] / gain if np.any(modal[:, 1]) else modal[:, 2] / gain
    if not np.any(line):
        raise InputError("force must push some elastic mode, not only move the structure")
    balance = Balance(model, model.joints(line), basis)
    omegas = 2.0 * math.pi * targets
    path, marks, iterations, stopped = _follow(balance, modal, omegas)
    points = [solved.point for solved in path]
    message = f"solved at {len(points)} points in {iterations} iterations"
    if stopped:
        where = points[-1].omega / (2.0 * math.pi) if points else targets[0]
        message = (
            f"stopped at {where:.6g} Hz after {iterations} iterations: {stopped}; try more "
            "samples, other harmonics, some damping, or less force"
        )
    motion = np.zeros((len(points), size, len(basis.harmonics)), dtype=complex)
    rigid = model.free @ (model.free.T @ (real[0] + 1j * real[1]))
    for i, (q, omega) in enumerate(points):
        motion[i, :, 0] = model.shapes @ q[:, 0]
        motion[i, :, 1:] = model.shapes @ (q[:, 1::2] - 1j * q[:, 2::2])
        motion[i, :, 1] -= rigid / omega**2
    frequency = np.array([point.omega / (2.0 * math.pi) for point in points])
    return ForcedResponse(
        frequency,
        motion,
        basis.harmonics,
        np.array(marks, dtype=bool),
        np.array([solved.stable for solved in path], dtype=bool),
        iterations,
        message,
    )


def _follow(
    balance: Balance, force: Floats, omegas: Floats
) -> tuple[list[_Solved], list[bool], int, str]:
    """Points along the path from the first to the last frequency."""
    direction = 1.0 if omegas[-1] > omegas[0] else -1.0
    span = abs(float(omegas[-1] - omegas[0]))
    start = _Point(_linear_response(balance, force, float(omegas[0])), float(omegas[0]))
    unit = float(np.abs(start.coefficients).max())
    path = _Path(balance, force, unit, span)
    here = path.solve(start, None)
    if here is None:
        here = _ramped(balance, force, float(omegas[0]), span)
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
        path = _Path(balance, force, largest, span)
        rescaled = np.append(here.tangent[:-1] / (largest / unit), here.tangent[-1])
        here = here._replace(tangent=rescaled / np.linalg.norm(rescaled))
        unit = largest
        # Not further than the frequencies asked for lie apart, and a tenth of the motion itself.
        step = min(step, longest / max(abs(float(here.tangent[-1])), 1e-3 * longest), 0.2)
        ahead = path.solve(path.ahead(here, step), here.tangent)
        if ahead is None or path.distance(ahead.point, here.point) > 2.0 * step:
            step *= 0.5
            if step < _FINEST:
                return points, marks, iterations, "the arc's steps became too short"
            continue
        iterations += ahead.iterations
        if float(ahead.tangent @ here.tangent) < 0.0:
            ahead = ahead._replace(tangent=-ahead.tangent)
        went = ahead.point.omega - here.point.omega
        inside = [w for w in omegas if 0.0 < (w - here.point.omega) * np.sign(went) <= abs(went)]
        for omega in sorted(inside, reverse=ahead.point.omega < here.point.omega):
            share = (omega - here.point.omega) / (ahead.point.omega - here.point.omega)
            guess = here.point.coefficients + share * (
                ahead.point.coefficients - here.point.coefficients
            )
            at = path.solve(_Point(guess, float(omega)), None)
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


def _linear_response(balance: Balance, force: Floats, omega: float) -> Floats:
    """What sticking joints answer."""
    modes, size = balance.shape
    matrix = balance.linear_matrix(omega, 0.0).reshape(modes * size, modes * size)
    return np.asarray(np.linalg.solve(matrix, force.reshape(-1)).reshape(modes, size))


def _ramped(balance: Balance, force: Floats, omega: float, width: float) -> _Solved | None:
    """The first point by rising forces, where it is not found at once."""
    guess = _Point(np.zeros(balance.shape), omega)
    solved = None
    for share in np.geomspace(1e-3, 1.0, 25):
        unit = max(
            float(np.abs(guess.coefficients).max()),
            float(np.abs(_linear_response(balance, share * force, omega)).max()),
        )
        solved = _Path(balance, share * force, unit, width).solve(guess, None)
        if solved is None:
            return None
        guess = _Point(solved.point.coefficients * (25.0 / 24.0), omega)
    return solved
