"""Quasi-static modal analysis: frequency and damping from slow cycles along a mode.

The structure is loaded statically by inertia forces, K x + joint forces(x) = lambda M v, where v is
half the displacement from one turning point to the other and lambda = omega^2 (Festjens, Chevallier
and Dion 2013, DOI 10.1016/j.ijmecsci.2013.06.008; Lacayo and Allen 2019,
DOI 10.1016/j.ymssp.2018.08.034). At each amplitude two static cycles are computed, and the loss of
the second one is used. If contacts open and close, Masing's rule holds neither for the loading
curve of the structure nor for each joint at its static load: the damping of a bolted beam by
Masing's rule for each joint was 1.3 to 3.2 times too large.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple, TypeVar

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.modal_model import ModalJoints, ModalModel
from microslip.structures.periodic_motion import AmplitudeMeasure

_ITERATIONS = 30
_STEP = 1e-9
_STEPS = 6, 24
"""Number of load steps from one turning point to the other; larger number if that fails.

32 steps change the loss of a bolted beam by 1e-5 to 1 %, most where its contacts open far.
"""
_FINEST = 1e-3  # shortest step in the logarithm of the amplitude
_SMALLEST = 1e-6  # of an amplitude: where a mode of sticking joints is to be found


Laws = list[Callable[..., tuple[Floats, Floats]]]
System = Callable[[Floats], tuple[Floats, Callable[[], Floats]]]
"""Residual at the unknowns, and a function that returns the Jacobian."""


_Found = TypeVar("_Found")
Track = list[tuple[float, _Found]]
"""Last three amplitudes solved, with their solutions."""


def continue_in_amplitude(
    amplitudes: Floats,
    track: Track[_Found],
    attempt: Callable[[Track[_Found], float], _Found | None],
    finest: float,
) -> list[_Found | None]:
    """Return a result for each amplitude, by continuation with adaptive steps from the nearest one.

    ``track`` contains the starting solutions with their amplitudes; all ``amplitudes`` are on one
    side of the last one. ``attempt`` returns the solution at a further amplitude, or None if it
    finds none. Results are None beyond an amplitude at which the step in ln(amplitude) would be
    shorter than ``finest``.
    """
    results: list[_Found | None] = [None] * amplitudes.size
    for place in np.argsort(abs(np.log(amplitudes / track[-1][0])), kind="stable"):
        target, stride = float(amplitudes[place]), math.inf
        while target != track[-1][0]:
            gap = math.log(target / track[-1][0])
            ahead = min(stride, abs(gap))
            at = target
            if ahead < abs(gap):
                at = track[-1][0] * math.exp(math.copysign(ahead, gap))
            found = attempt(track, at)
            if found is None:
                stride = 0.5 * ahead
                if stride < finest:
                    return results
            else:
                track.append((at, found))
                del track[:-3]
                stride = 1.5 * ahead
        results[place] = track[-1][1]
    return results


class QuasiStaticPoint(NamedTuple):
    """Quasi-static mode at one amplitude."""

    amplitude: float
    """Amplitude in the unit of the measure."""
    square: float
    """Lambda, the square of the angular frequency [rad^2/s^2]."""
    shape: Floats
    """Amplitude in modal coordinates: half of the motion between the turning points."""
    loss: Floats
    """Energy dissipated per cycle in each joint [J], for all groups."""


class _BranchLost(Exception):
    """Raised if no equilibrium is found near the previous one."""


class QuasiStatic:
    """Quasi-static cycles along a mode."""

    def __init__(
        self, model: ModalModel, joints: ModalJoints, index: int, measure: AmplitudeMeasure
    ) -> None:
        self.model, self.joints, self.index, self.measure = model, joints, index, measure
        self.iterations = 0
        self._compliance = joints.flat / model.squares[:, None]
        self._flexibility = joints.flat.T @ self._compliance

    def curve(self, amplitudes: Floats) -> list[QuasiStaticPoint | None]:
        """Compute a point for each amplitude; None where no equilibrium was found."""
        shape = np.zeros(self.model.size)
        shape[self.index] = 1.0
        square = float(self.model.squares[self.index])
        unit = self.measure.factor(shape, math.sqrt(square))
        smallest = _SMALLEST * float(amplitudes.min())
        begin = QuasiStaticPoint(smallest, square, shape * (smallest / unit), np.zeros(0))

        def attempt(track: Track[QuasiStaticPoint], amplitude: float) -> QuasiStaticPoint | None:
            for steps in _STEPS:
                with suppress(_BranchLost):
                    return self._cycle(track[-1][1], amplitude, steps)
            return None

        return continue_in_amplitude(amplitudes, [(smallest, begin)], attempt, _FINEST)

    def _cycle(self, guess: QuasiStaticPoint, amplitude: float, steps: int) -> QuasiStaticPoint:
        states = [group.start() for group in self.joints.groups]
        laws = [state.try_ for state in states]

        def commit() -> Floats:
            for state in states:
                state.commit()
            return np.concatenate([np.zeros(0), *(state.lost for state in states)])

        shape, square = guess.shape * (amplitude / guess.amplitude), guess.square
        turn, motion = np.zeros_like(shape), np.zeros(self.joints.stuck.size)
        shares = np.linspace(0.0, 1.0, steps // 2 + 1)[1:-1]
        lost, squares = [], []
        for half_cycle in range(5):
            load = square * shape
            for share in shares:
                motion = self._loaded(laws, share * load, load, motion)
                commit()
            opposite = turn if half_cycle else None
            ahead = turn - 2.0 * shape if half_cycle else shape
            turned, square = self._turn(laws, ahead, opposite, square, amplitude)
            shape = 0.5 * (turned - turn) if half_cycle else turned
            turn, motion = turned, self.joints.flat.T @ turned
            shares = np.cos(math.pi * np.arange(1, steps) / steps)
            lost.append(commit())
            squares.append(square)
        likeness = abs(float(shape @ guess.shape))
        likeness /= float(np.linalg.norm(shape) * np.linalg.norm(guess.shape))
        square = 0.5 * (squares[-1] + squares[-2])
        if likeness < 0.8 or not 0.5 < square / guess.square < 2.0:
            raise _BranchLost
        return QuasiStaticPoint(amplitude, square, shape, lost[-1] - lost[-3])

    def _loaded(self, laws: Laws, force: Floats, force_scale: Floats, motion: Floats) -> Floats:
        """Return joint motions (coordinates,) [m] under modal forces ``force``, by Newton's method.

        States do not change. ``force_scale`` gives the tolerance; ``motion`` is the initial guess.
        """
        aim = self._compliance.T @ force
        unit = float(np.abs(self._compliance.T @ force_scale).max(initial=0.0)) or 1.0

        def system(motion: Floats) -> tuple[Floats, Callable[[], Floats]]:
            pull, slopes = self.joints.answers(motion, laws)
            miss = motion - aim + self._flexibility @ (pull - self.joints.stuck * motion)

            def matrix() -> Floats:
                result = self.joints.by_tangents(self._flexibility, slopes)
                result[np.diag_indices_from(result)] += 1.0
                return np.asarray(result)

            return miss, matrix

        return self._solved(system, motion, np.full(motion.size, unit))

    def _turn(
        self, laws: Laws, x: Floats, opposite: Floats | None, square: float, amplitude: float
    ) -> tuple[Floats, float]:
        """Return the turning point (modes,) of a motion of given amplitude, and its lambda.

        The motion is half the displacement from the ``opposite`` turning point, or all of that from
        rest if ``opposite`` is None. ``x`` and ``square`` are the initial guesses of turning point
        and lambda.
        """
        flat, squares, modes = self.joints.flat, self.model.squares, self.model.size
        part = 1.0 if opposite is None else 0.5
        behind = np.zeros(modes) if opposite is None else opposite
        unit = part * float(np.linalg.norm(x - behind))
        # Residuals of stiff modes are compared by the motion that they mean.
        scale = np.append(unit * np.maximum(squares, square), 1.0)
        fundamental = np.zeros((modes, 3))

        def system(y: Floats) -> tuple[Floats, Callable[[], Floats]]:
            x, square = y[:modes], float(y[modes])
            if not square > 0.0:
                raise _BranchLost
            shape = fundamental[:, 1] = part * (x - behind)
            omega = math.sqrt(square)
            measured, by_shape, by_omega = self.measure.square(fundamental, omega)
            motion = flat.T @ x
            pull, slopes = self.joints.answers(motion, laws)
            gap = squares * x - square * shape + flat @ (pull - self.joints.stuck * motion)

            def matrix() -> Floats:
                result = np.zeros((modes + 1, modes + 1))
                result[:modes, :modes] = self.joints.by_tangents(flat, slopes) @ flat.T
                result[np.arange(modes), np.arange(modes)] += squares - part * square
                result[:modes, modes] = -shape
                result[modes, :modes] = part * by_shape[:, 1] / amplitude**2
                result[modes, modes] = 0.5 * by_omega / (omega * amplitude**2)
                return np.asarray(result / scale[:, None])

            return np.append(gap, measured / amplitude**2 - 1.0) / scale, matrix

        units = np.append(np.full(modes, unit), square)
        y = self._solved(system, np.append(x, square), units)
        return y[:modes], float(y[modes])

    def _solved(self, system: System, y: Floats, units: Floats) -> Floats:
        from scipy.linalg.lapack import dgetrf, dgetrs

        factors: tuple[Floats, Floats, int] | None = None
        before = math.inf
        for _ in range(_ITERATIONS):
            self.iterations += 1
            miss, matrix = system(y)
            if not y.size:
                return y
            if factors is None:
                factors = dgetrf(matrix() * units)
                if factors[2]:
                    break  # singular
            step = dgetrs(factors[0], factors[1], miss)[0]
            size = float(np.abs(step).max())
            if size <= _STEP or (size <= 1e-7 and size >= before):
                return y
            if not math.isfinite(size):
                break
            y = y - min(1.0, 0.5 / size) * units * step
            if size > 0.1 * before or size > 0.1:
                factors = None
            before = size
        raise _BranchLost

    def damping(self, point: QuasiStaticPoint) -> float:
        """Return the damping ratio by the losses of the joints and of the damping matrix [-]."""
        energy = point.square * float(point.shape @ point.shape)
        result = float(point.loss.sum()) / (2.0 * math.pi * energy)
        if self.model.damping is not None:
            viscous = float(point.shape @ self.model.damping @ point.shape)
            result += 0.5 * math.sqrt(point.square) * viscous / energy
        return result
