"""Frequency and damping of a mode against its amplitude, and quantities derived from them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, whole_number
from microslip.errors import InputError
from microslip.report.plot import Plot
from microslip.report.plottable import Plottable
from microslip.structures.answer import Answer
from microslip.structures.balance import Balance
from microslip.structures.modal_model import ModalJoints, ModalModel
from microslip.structures.nonlinear_mode import ModeEquations, follow
from microslip.structures.periodic_motion import AmplitudeMeasure, HarmonicBasis
from microslip.structures.quasi_static import QuasiStatic
from microslip.structures.resonance import sides

_CLOSE = 0.02  # relative distance of a multiple of the frequency to another mode


class Resonance(NamedTuple):
    """A multiple of a mode's frequency close to the frequency of another mode."""

    amplitude: float
    """Amplitudes of the curve at which they are closest."""
    multiple: int
    mode: int
    """The other mode, counted from 0."""
    distance: float
    """The other frequency over the multiple, less one [-]."""


@dataclass(frozen=True, eq=False, repr=False)
class ModalCurve(Answer, Plottable):
    """A nonlinear mode along amplitudes; made by ``structure.modes(...)``.

    Amplitudes that the solver did not reach hold NaN; ``message`` says where and why.
    """

    method: str
    """``harmonic-balance`` or ``quasi-static``."""
    index: int
    """Index of the elastic mode, counted from 0."""
    amplitude: Floats
    """Amplitudes as they were asked for: modal [m kg^(1/2)], or at the sensor."""
    modal_amplitude: Floats
    """a = sqrt(x1^H M x1) of the fundamental harmonic [m kg^(1/2)]."""
    frequency: Floats
    """Frequencies [Hz]."""
    damping_ratio: Floats
    """Damping ratios of steady motion [-], base damping included; of a free decay see
    :attr:`decay_damping_ratio`."""
    shape: NDArray[np.complex128]
    """Fundamental harmonics over their modal amplitude (amplitudes, n) [kg^(-1/2)].

    The motion is the real part of shape * modal_amplitude * exp(i omega t).
    """
    loss: Floats
    """Energy lost a cycle by each joint or node (amplitudes, joints) [J]."""
    mac: Floats
    """Modal assurance criterion of the shape beside that of the sticking joints [-]."""
    near: tuple[Resonance, ...]
    """Multiples of the frequency close to another mode, the nearest of each pair."""
    linear_frequency: float
    """Frequency of the mode whose joints stick [Hz]."""
    base_damping: float
    """The damping ratio that was given as an input [-]."""
    converged: NDArray[np.bool_]
    """Whether each amplitude was solved."""
    iterations: int
    """Iterations of Newton's method in all."""
    message: str
    """Outcome in a sentence: where and why it stopped, and what to try."""
    _solve_by_other: Callable[[], ModalCurve] | None
    _with_more_harmonics: Callable[[], Floats] | None

    def _figure(self) -> Plot:
        from microslip.structures.figures import modal_figure

        return modal_figure(self)

    def _sizes(self, columns: Floats) -> Floats:
        return np.abs(self.shape.real @ columns) * self.modal_amplitude[:, None]

    @property
    def status(self) -> str:
        """``solved``, or ``stopped`` where some amplitudes were not reached."""
        return "solved" if bool(self.converged.all()) else "stopped"

    @cached_property
    def other_method(self) -> ModalCurve:
        """The same by the other method; solved when first asked for."""
        if self._solve_by_other is None:
            raise InputError("other_method is not kept in a curve that was read or copied")
        return self._solve_by_other()

    @property
    def frequency_difference(self) -> Floats:
        """Quasi-static over balanced frequency, less one [-]."""
        return self._difference("frequency")

    @property
    def damping_difference(self) -> Floats:
        """Quasi-static over balanced damping ratio, less one [-]; base damping counts in both."""
        return self._difference("damping_ratio")

    def _difference(self, name: str) -> Floats:
        curves = (self, self.other_method)
        quick, exact = curves if self.method == "quasi-static" else curves[::-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(getattr(quick, name) / getattr(exact, name) - 1.0)

    @property
    def harmonic_error(self) -> Floats:
        """Relative change of the joints' damping ratio by harmonics beyond the set [-].

        By one step of Newton's method at each amplitude with those that were left out, up to two
        above the highest, when first asked for; NaN where nothing was solved. Above some percent
        take ``harmonics`` beyond the set.
        """
        return self.harmonic_changes[:, 1]

    @cached_property
    def harmonic_changes(self) -> Floats:
        """The same of frequency and damping ratio, (amplitudes, 2) [-]."""
        if self._with_more_harmonics is None:
            raise InputError(
                "harmonic_error is of a curve by harmonic balance, not of one that was "
                "read, copied or made quasi-static"
            )
        return self._with_more_harmonics()

    @cached_property
    def decay_damping_ratio(self) -> Floats:
        """Damping ratios that a free decay shows as it passes these amplitudes [-].

        What a cycle takes of an amplitude a is its loss over dE/da, and that is not omega^2 a: with
        g = d ln omega/d ln a without the joints' part, it is (1 + g/2) times as much where springs
        bend (the action omega a^2/2), and (1 - E_d'(a)/(4 omega^2 a)) times where joints slip,
        whose tangent counts (Caughey 1960, DOI 10.1115/1.3644075). NaN of less than two amplitudes.
        """
        result = np.full(self.frequency.shape, np.nan)
        a, first, back = np.unique(
            self.modal_amplitude[self.converged], return_index=True, return_inverse=True
        )
        if a.size < 2:
            return result
        by = np.log(a)
        order: Literal[1, 2] = 2 if a.size > 2 else 1
        omega = 2.0 * math.pi * self.frequency[self.converged][first]
        lost = self.loss[self.converged][first].sum(axis=1)
        shift = np.gradient(np.log(omega), by, edge_order=order)
        steep = np.gradient(np.log(np.maximum(lost, 1e-300)), by, edge_order=order)
        slip = steep * lost / (2.0 * omega * a) ** 2
        # Joints that slip lower the frequency by a quarter of it.
        ratio = 1.0 + 0.5 * (shift + 0.5 * slip) - slip
        result[self.converged] = self.damping_ratio[self.converged] / ratio[back]
        return result

    @property
    def loss_share(self) -> Floats:
        """Share of each joint in the loss of a cycle (amplitudes, joints) [-]."""
        total = self.loss.sum(axis=1, keepdims=True)
        share = np.zeros_like(self.loss)
        return np.asarray(np.divide(self.loss, total, out=share, where=total > 0.0))

    def forced_response(self, force: ArrayLike, *, samples: int = 400) -> tuple[Floats, Floats]:
        """Response near the resonance in closed form, from this curve alone.

        Parameters
        ----------
        force : array_like
            Amplitudes (n,) of a harmonic force in phase everywhere [N], one a degree of freedom.
        samples : int, optional
            Amplitudes on each side of the peak.

        Returns
        -------
        frequency : ndarray
            Frequencies [Hz]: up the left side of the resonance, down the right.
        modal_amplitude : ndarray
            Amplitudes there.

        Notes
        -----
        At the modal amplitude a the mode answers like a linear one of frequency omega(a) and
        damping zeta(a): (omega^2 - W^2)^2 + (2 zeta omega W)^2 = (p/a)^2 with p = |shape^H force|
        (Szemplinska-Stupnicka 1979, DOI 10.1016/S0022-460X(79)80003-1; Schwarz et al. 2020,
        DOI 10.1007/s11071-019-05211-7). Other modes are left out.
        """
        f = floats("force", force)
        if f.shape != (self.shape.shape[1],):
            raise InputError(
                f"force must be one for each of the {self.shape.shape[1]} degrees of freedom, "
                f"got shape {f.shape}"
            )
        samples = whole_number("samples", samples, 2, 1_000_000)
        good = np.flatnonzero(self.converged)
        good = good[np.argsort(self.modal_amplitude[good])]
        a = self.modal_amplitude[good]
        if a.size < 2:
            raise InputError("force needs a curve of at least two solved amplitudes")
        push = np.abs(self.shape[good].conj() @ f)
        grid = np.geomspace(a[0], a[-1], samples)
        at = np.log(grid)

        def along(values: Floats) -> Floats:
            return np.asarray(np.interp(at, np.log(a), values))

        omega = 2.0 * math.pi * along(self.frequency[good])
        zeta, p = along(self.damping_ratio[good]), along(push)
        below, above = sides(grid, omega, zeta, p)
        there = np.isfinite(above)
        if there.all():
            raise InputError(
                f"force must be one whose peak lies on the curve, which ends at the modal "
                f"amplitude {a[-1]:g}; solve for larger amplitudes, or push less"
            )
        end = int(np.argmin(there))
        swings = below[:end] > 0.0
        squares = np.concatenate([below[:end][swings], above[:end][::-1]])
        amplitudes = np.concatenate([grid[:end][swings], grid[:end][::-1]])
        return np.sqrt(squares) / (2.0 * math.pi), amplitudes

    def __repr__(self) -> str:
        solved = self.converged
        if not solved.any():
            return f"ModalCurve(mode {self.index}, {self.method}, nothing solved: {self.message})"
        f, z = self.frequency[solved], self.damping_ratio[solved]
        return (
            f"ModalCurve(mode {self.index}, {self.method}, {int(solved.sum())} of {solved.size} "
            f"amplitudes, {f.min():.4g} to {f.max():.4g} Hz, "
            f"damping {z.min():.3g} to {z.max():.3g})"
        )

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_solve_by_other": None, "_with_more_harmonics": None}


class _Row(NamedTuple):
    """A solved amplitude, by its place among them."""

    place: int
    modal_amplitude: float
    omega: float
    damping: float
    shape: np.ndarray
    """In modal coordinates, of any length."""
    loss: Floats


@dataclass(frozen=True, eq=False)
class ModeSolver:
    """A mode, the amplitudes at which it is wanted, and the damping that is added."""

    model: ModalModel
    index: int
    amplitudes: Floats
    measure: AmplitudeMeasure
    basis: HarmonicBasis
    base_damping: float

    def balanced(self) -> ModalCurve:
        """By harmonic balance, with continuation."""
        joints = self._joints()
        balance = Balance(self.model, joints, self.basis)
        equations = ModeEquations(balance, self.index, self.measure)
        followed = follow(equations, self.amplitudes)
        rows = []
        for i, solution in enumerate(followed.solutions):
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
        if followed.stopped_at is None:
            message = f"solved in {followed.iterations} iterations and {followed.steps} steps"
        else:
            message = (
                f"stopped beyond the amplitude {followed.stopped_at:.4g}: harmonic balance "
                f"did not converge in steps of 1 %, after {followed.iterations} iterations; try "
                "more samples, fewer harmonics, or amplitudes that end there (the mode may meet "
                "another one, or all joints may slide)"
            )

        def more_harmonics() -> Floats:
            changes = np.full((self.amplitudes.size, 2), np.nan)
            for i, solution in enumerate(followed.solutions):
                if solution is not None:
                    changes[i] = equations.unbalanced(solution.point, float(self.amplitudes[i]))
            return changes

        return self._curve(
            "harmonic-balance", joints, rows, followed.iterations, message, self.quasi_static,
            more_harmonics,
        )  # fmt: skip

    def _resonances(self, frequency: Floats) -> tuple[Resonance, ...]:
        """Multiples of the frequency near other modes, the joints of which stick."""
        stuck = np.sqrt(self.model.squares) / (2.0 * math.pi)
        found = []
        for multiple in self.basis.harmonics[1:]:
            for index in range(stuck.size if np.isfinite(frequency).any() else 0):
                distance = stuck[index] / (multiple * frequency) - 1.0
                place = int(np.nanargmin(abs(distance)))
                itself = multiple == 1 and index == self.index
                if not itself and abs(distance[place]) < _CLOSE:
                    amplitude = float(self.amplitudes[place])
                    found.append(Resonance(amplitude, multiple, index, float(distance[place])))
        return tuple(found)

    def quasi_static(self) -> ModalCurve:
        """By quasi-static modal analysis."""
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
        return self._curve("quasi-static", joints, rows, solver.iterations, message, self.balanced)

    def _joints(self) -> ModalJoints:
        """The joints along the mode of sticking joints."""
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
        other_method: Callable[[], ModalCurve],
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
            _solve_by_other=other_method,
            _with_more_harmonics=more_harmonics,
        )
