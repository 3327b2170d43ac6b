"""Nonlinear modes by harmonic balance, continued from amplitude to amplitude."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, number, show, whole_number
from microslip._core.errors import InputError
from microslip._core.wording import quoted
from microslip.structures.balance import Balance, ModePoint
from microslip.structures.modal_curve import ModalCurve, Resonance
from microslip.structures.modal_model import ModalJoints, ModalModel
from microslip.structures.mode_equations import ModeEquations, Solution
from microslip.structures.periodic_motion import (
    AmplitudeMeasure,
    HarmonicBasis,
    ModeMethod,
    MotionQuantity,
    amplitude_measure,
    checked_amplitudes,
    harmonic_basis,
)
from microslip.structures.quasi_static import QuasiStatic, Track, continue_in_amplitude
from microslip.structures.static import MOST_MODES, AtRest, base_damping, solver_method

_CLOSE = 0.02  # relative distance of a multiple of the frequency to another mode
_SMALLEST = 1e-6  # of the first amplitude: where a mode of sticking joints is to be found
_COARSE, _FINEST = 0.1, 0.01
"""Shortest step in the logarithm of the amplitude, usually and if no other branch is found."""
_RESONANT = 0.02  # higher harmonic of a mode over the fundamental, at an internal resonance
_FARTHER = 5.0  # from the resonance, of a guess beyond it
_BEYOND = 2.5, 1.5, 4.0  # amplitudes over the last one before a resonance


def follow_mode(
    equations: ModeEquations, amplitudes: Floats
) -> tuple[list[Solution | None], int, int, float]:
    """Follow a mode through the amplitudes, beginning with the smallest one.

    Return the solution at each amplitude, or None; the total numbers of Newton iterations and of
    continuation steps; and the largest amplitude that was reached. The predictor extrapolates
    coefficients over amplitude linearly in ln(amplitude), which is exact for sticking joints.

    Where a multiple of the frequency crosses that of another mode, the branch from small amplitudes
    turns into a motion of the other mode. Beyond the crossing the mode is another branch, on which
    the resonant harmonic has the opposite sign; it is followed from there in both directions.
    """
    lowest, orders = float(amplitudes.min()), equations.balance.basis.orders[1:]
    first, iterations, steps = _first_solution(equations, lowest)
    if first is None:
        return [None] * amplitudes.size, iterations, steps, lowest

    def solve(guess: ModePoint, at: float) -> Solution | None:
        nonlocal iterations, steps
        steps += 1
        try:
            candidate = equations.solve(guess, at)
        except InputError:  # the extrapolation presses summits beyond their reach
            return None
        iterations += candidate.iterations
        near = candidate.converged and _same_mode(candidate.point, guess, orders)
        return candidate if near else None

    def attempt(track: Track[Solution], at: float) -> Solution | None:
        return solve(_prediction([(a, solution.point) for a, solution in track], at), at)

    track: Track[Solution] = [(lowest, first)]
    missing = np.ones(amplitudes.size, dtype=bool)
    solutions: list[Solution | None] = [None] * amplitudes.size

    def fill(places: np.ndarray, finest: float) -> None:
        found = continue_in_amplitude(amplitudes[places], track, attempt, finest)
        for place, solution in zip(np.flatnonzero(places), found, strict=True):
            solutions[place], missing[place] = solution, solution is None

    finest = _COARSE
    fill(missing, finest)
    while (missing & (amplitudes > track[-1][0])).any():
        last, solution = track[-1]
        beyond = _beyond_resonance(equations, solution.point)
        for factor in _BEYOND:
            at = factor * last
            found = None if beyond is None else solve(_prediction([(last, beyond)], at), at)
            if found is not None:
                for side in (amplitudes < at, amplitudes >= at):
                    track, finest = [(at, found)], _COARSE
                    fill(missing & side, finest)
                break
        else:
            if finest == _FINEST:
                break
            finest = _FINEST
            fill(missing & (amplitudes > last), finest)
    return solutions, iterations, steps, track[-1][0]


def _beyond_resonance(equations: ModeEquations, point: ModePoint) -> ModePoint | None:
    """Return a guess for the other branch at an internal resonance; None without resonance.

    The amplitude of a harmonic is inversely proportional to its distance from resonance: the guess
    is five times as far from it on the other side.
    """
    q, harmonics = point.coefficients.copy(), np.array(equations.balance.basis.harmonics[1:])
    size = np.hypot(q[:, 1::2], q[:, 2::2])
    crossing = np.sqrt(equations.balance.model.squares)[:, None] / harmonics
    size[(abs(crossing / point.omega - 1.0) > _CLOSE) | (harmonics == 1)] = 0.0
    mode, multiple = np.unravel_index(np.argmax(size), size.shape)
    if size[mode, multiple] < _RESONANT * float(np.linalg.norm(q[:, 1:3])):
        return None
    q[mode, 1 + 2 * multiple : 3 + 2 * multiple] /= -_FARTHER
    beyond = crossing[mode, multiple] + _FARTHER * (crossing[mode, multiple] - point.omega)
    return point._replace(coefficients=q, omega=float(beyond))


def _first_solution(equations: ModeEquations, target: float) -> tuple[Solution | None, int, int]:
    iterations, steps, start = 0, 0, target
    orders = equations.balance.basis.orders[1:]
    while start > 0.9 * _SMALLEST * target:
        guess = _sticking_mode(equations, start)
        candidate = equations.solve(guess, start)
        iterations, steps = iterations + candidate.iterations, steps + 1
        if candidate.converged and _same_mode(candidate.point, guess, orders):
            if start == target:
                return candidate, iterations, steps
            rising = np.geomspace(start, target, 2 + round(math.log10(target / start)))
            solutions, more, further, _ = follow_mode(equations, rising)
            return solutions[-1], iterations + more, steps + further
        start *= 0.1
    return None, iterations, steps


def _same_mode(point: ModePoint, guess: ModePoint, orders: Floats) -> bool:
    """Return False if a point belongs to a different mode from that of the guess.

    Then its shape or frequency differs much from the guess, or more than half of its kinetic energy
    is in higher harmonics.
    """
    a, b = point.coefficients[:, 1:3].ravel(), guess.coefficients[:, 1:3].ravel()
    likeness = abs(float(a @ b)) / float(np.linalg.norm(a) * np.linalg.norm(b))
    energies = (orders * point.coefficients[:, 1:]) ** 2
    of_fundamental = float(energies[:, :2].sum()) > 0.5 * float(energies.sum())
    return of_fundamental and likeness > 0.8 and 0.7 < point.omega / guess.omega < 1.4


def _sticking_mode(equations: ModeEquations, amplitude: float) -> ModePoint:
    model = equations.balance.model
    omega = math.sqrt(model.squares[equations.index])
    shape = np.zeros(model.size)
    shape[equations.index] = 1.0
    q = np.zeros(equations.balance.shape)
    q[equations.index, 1] = amplitude / equations.measure.factor(shape, omega)
    return ModePoint(q, omega, 0.0)


def _prediction(track: Sequence[tuple[float, ModePoint]], amplitude: float) -> ModePoint:
    last, point = track[-1]
    factor = amplitude / last
    if len(track) == 1:
        return point._replace(coefficients=factor * point.coefficients)
    before, earlier = track[-2]
    share = min(math.log(factor) / math.log(last / before), 3.0)
    slope = point.coefficients / last - earlier.coefficients / before
    return ModePoint(
        amplitude * (point.coefficients / last + share * slope),
        point.omega * (point.omega / earlier.omega) ** share,
        point.damping + share * (point.damping - earlier.damping),
    )


class _Row(NamedTuple):
    place: int
    modal_amplitude: float
    omega: float
    damping: float
    shape: np.ndarray
    """Complex mode shape in modal coordinates (modes,), with any norm."""
    loss: Floats


@dataclass(frozen=True, eq=False)
class ModeSolver:
    """Solver for one mode at given amplitudes, by harmonic balance or quasi-statically."""

    model: ModalModel
    index: int
    amplitudes: Floats
    measure: AmplitudeMeasure
    basis: HarmonicBasis
    base_damping: float
    rtol: float = 1e-10

    def balanced(self) -> ModalCurve:
        """Compute the mode by harmonic balance with continuation."""
        joints = self._joints()
        balance = Balance(self.model, joints, self.basis)
        equations = ModeEquations(balance, self.index, self.measure, self.rtol)
        solutions, iterations, steps, reached = follow_mode(equations, self.amplitudes)
        rows = []
        for i, solution in enumerate(solutions):
            if solution is None:
                continue
            q, omega, zeta = solution.point
            modal = math.sqrt(float(np.sum(q[:, 1:3] ** 2)))
            motions = joints.split(joints.flat.T @ q)
            loss = [
                self.basis.work(answer.force, motion).sum(axis=1)
                for answer, motion in zip(solution.answers, motions, strict=True)
            ]
            first = (q[:, 1] - 1j * q[:, 2]) / modal
            rows.append(_Row(i, modal, omega, zeta, first, np.concatenate([*loss, np.zeros(0)])))
        message = f"solved in {iterations} iterations and {steps} steps"
        missing = self.amplitudes[[solution is None for solution in solutions]]
        if missing.size and missing.max() < reached:
            message = (
                f"no solution from the amplitude {missing.min():.4g} to {missing.max():.4g}, where "
                "a multiple of the frequency equals that of another mode (internal resonance)"
            )
        elif missing.size:
            message = (
                f"stopped beyond the amplitude {reached:.4g}: harmonic balance "
                f"did not converge in steps of 1 %, after {iterations} iterations; try "
                "more samples, fewer harmonics, or amplitudes that end there (the mode may meet "
                "another one, or all joints may slide)"
            )

        def more_harmonics() -> Floats:
            changes = np.full((self.amplitudes.size, 2), np.nan)
            for i, solution in enumerate(solutions):
                if solution is not None:
                    changes[i] = equations.unbalanced(solution.point, float(self.amplitudes[i]))
            return changes

        return self._curve("harmonic-balance", joints, rows, iterations, message, more_harmonics)

    def _resonances(self, frequency: Floats) -> tuple[Resonance, ...]:
        """Return the harmonics whose frequency is within 2 % of another mode with sticking joints.

        ``frequency`` [Hz] is that of the solved mode at each amplitude.
        """
        stuck = np.sqrt(self.model.squares) / (2.0 * math.pi)
        found: list[Resonance] = []
        if not np.isfinite(frequency).any():
            return ()
        for multiple in self.basis.harmonics[1:]:
            distances = stuck[:, None] / (multiple * frequency) - 1.0
            places = np.nanargmin(abs(distances), axis=1)
            nearest = distances[np.arange(stuck.size), places]
            for index in np.flatnonzero(abs(nearest) < _CLOSE).tolist():
                if multiple != 1 or index != self.index:
                    amplitude = float(self.amplitudes[places[index]])
                    found.append(Resonance(amplitude, multiple, index, float(nearest[index])))
        return tuple(found)

    def quasi_static(self) -> ModalCurve:
        """Compute the mode by quasi-static modal analysis."""
        joints = self._joints()
        solver = QuasiStatic(self.model, joints, self.index, self.measure)
        rows = []
        for i, point in enumerate(solver.curve(self.amplitudes)):
            if point is not None:
                modal = float(np.linalg.norm(point.shape))
                shape = point.shape / modal
                omega, damping = math.sqrt(point.square), solver.damping(point)
                rows.append(_Row(i, modal, omega, damping, shape, point.loss))
        message = f"solved in {solver.iterations} iterations"
        if len(rows) < self.amplitudes.size:
            reached = max((float(self.amplitudes[row.place]) for row in rows), default=math.nan)
            where = f"beyond the amplitude {reached:.4g}" if rows else "at the first amplitude"
            message = (
                f"stopped {where}: the static cycle along the mode was lost; the mode may meet "
                "another one, or all joints may slide, which "
                'method="harmonic-balance" follows further'
            )
        return self._curve("quasi-static", joints, rows, solver.iterations, message)

    def _joints(self) -> ModalJoints:
        line = np.zeros(self.model.size)
        line[self.index] = 1.0
        return self.model.joints(line)

    def _curve(
        self,
        method: str,
        joints: ModalJoints,
        rows: list[_Row],
        iterations: int,
        message: str,
        more_harmonics: Callable[[], Floats] | None = None,
    ) -> ModalCurve:
        count = self.amplitudes.size
        modal, frequency, damping, mac = np.full((4, count), np.nan)
        shape = np.full((count, self.model.shapes.shape[0]), np.nan, dtype=complex)
        loss = np.full((count, sum(g.stuck.shape[0] for g in joints.groups)), np.nan)
        for row in rows:
            i = row.place
            modal[i], frequency[i] = row.modal_amplitude, row.omega / (2 * math.pi)
            damping[i] = row.damping + self.base_damping
            shape[i], loss[i] = self.model.shapes @ row.shape, row.loss
            mac[i] = abs(row.shape[self.index]) ** 2 / float(np.sum(abs(row.shape) ** 2))
        return ModalCurve(
            method=method,
            index=self.index,
            amplitude=self.amplitudes.copy(),
            modal_amplitude=modal,
            frequency=frequency,
            damping_ratio=damping,
            shape=shape,
            loss=loss,
            mac=mac,
            near=self._resonances(frequency),
            linear_frequency=math.sqrt(float(self.model.squares[self.index])) / (2.0 * math.pi),
            base_damping=self.base_damping,
            converged=np.isfinite(frequency),
            iterations=iterations,
            message=message,
            _with_more_harmonics=more_harmonics,
        )


@solver_method
def modes(
    rest: AtRest,
    index: int,
    amplitudes: ArrayLike,
    *,
    harmonics: Sequence[int] | None = None,
    method: ModeMethod = "harmonic-balance",
    samples: int = 64,
    at: ArrayLike | None = None,
    quantity: MotionQuantity = "displacement",
    damping_ratio: float = 0.0,
    rtol: float = 1e-10,
) -> ModalCurve:
    """Compute frequency and damping of a mode against its amplitude.

    Parameters
    ----------
    index : int
        Index of the elastic mode, from 0, in order of the frequencies with sticking joints.
    amplitudes : array_like
        Amplitudes of the fundamental harmonic x1, above zero, one-dimensional: modal amplitudes
        a = sqrt(x1^H M x1) [m kg^(1/2)], or amplitudes at the sensor ``at``.
    harmonics : sequence of int, optional
        Orders of the harmonics; 0, the mean, is always added. By default 0 to 3, or 0 to 5 with a
        geometry. The second harmonic is needed if faces separate;
        :attr:`ModalCurve.harmonic_error` estimates the effect of further harmonics.
    method : {"harmonic-balance", "quasi-static"}, optional
        Reference method or fast approximation.
    samples : int, optional
        Samples per period for the forces of fields.
    at : array_like, optional
        Direction of a sensor to which the amplitudes refer, shape (n,).
    quantity : {"displacement", "velocity", "acceleration"}, optional
        Quantity that the sensor measures: [m], [m/s] or [m/s^2].
    damping_ratio : float, optional
        Damping ratio of everything but the joints [-], added at all amplitudes.
    rtol : float, optional
        Tolerance of harmonic balance [-]. The last step of Newton's method changes coefficients
        and frequency by less than this fraction, and the damping ratio by less than this number.
        1e-5 takes two thirds of the time.

    Returns
    -------
    ModalCurve
        Frequencies [Hz], damping ratios, shapes and the loss of each joint.

    Notes
    -----
    The balance is that of the extended periodic motion, M x'' + C x' - 2 zeta omega M x' + K x
    + joint forces = static forces (Krack 2015, DOI 10.1016/j.compstruc.2015.03.008). Each node of
    a field follows the exact friction law with varying separation along its line of motion in the
    mode with sticking joints; across that line it sticks.
    """
    index = whole_number("index", index, 0, MOST_MODES)
    if method not in get_args(ModeMethod):
        raise InputError(f"method must be {quoted(get_args(ModeMethod))}, got {show(method)}")
    a = checked_amplitudes(amplitudes)
    basis = harmonic_basis(rest._orders(harmonics), samples)
    base, model = base_damping(damping_ratio), rest._elastic
    rtol = number("rtol", rtol, example=1e-10)
    if not 1e-14 <= rtol <= 1e-4:
        raise InputError(f"rtol must be from 1e-14 to 1e-4, got {exact(rtol)}")
    if index >= model.size:
        raise InputError(f"index must be below {model.size}, the elastic modes, got {index}")
    measure = amplitude_measure(at, quantity, model.shapes, index)
    solver = ModeSolver(model, index, a, measure, basis, base, rtol)
    return solver.balanced() if method == "harmonic-balance" else solver.quasi_static()
