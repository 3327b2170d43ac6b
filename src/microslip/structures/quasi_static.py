"""Quasi-static modal analysis: frequency and damping from static loading along a mode.

The structure is loaded by the inertia of its own motion, K v + joints(v) = lambda M v, along rising
q = sqrt(v^T M v) and to both sides; omega^2 = lambda (Festjens, Chevallier and Dion 2013,
DOI 10.1016/j.ijmecsci.2013.06.008; Lacayo and Allen 2019, DOI 10.1016/j.ymssp.2018.08.034). What a
cycle loses is summed over the joints' own closed loops: Masing's rule does not hold for the whole
curve where contacts open and close.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.amplitude import AmplitudeMeasure
from microslip.structures.gmres import gmres
from microslip.structures.modal_model import ModalJoints, ModalModel

_ITERATIONS = 30
_STEP = 1e-11
_LARGEST_DIRECT = 150  # modes up to which the equations are solved by elimination


class StaticPoint(NamedTuple):
    """A static deflection by the mode's own inertia."""

    shape: Floats
    """Modal coordinates, (modes,)."""
    square: float
    """Lambda [rad^2/s^2]."""


class QuasiStaticPoint(NamedTuple):
    """The mode at an amplitude."""

    square: float
    """Of the angular frequency [rad^2/s^2]; not above zero where nothing holds the mode."""
    shape: Floats
    """Half of the motion from one side to the other, in modal coordinates."""
    modal_amplitude: float

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s]."""
        return math.sqrt(max(self.square, 0.0))


class QuasiStatic:
    """The equations of the static deflections along a mode."""

    def __init__(
        self, model: ModalModel, joints: ModalJoints, index: int, measure: AmplitudeMeasure
    ) -> None:
        self.model, self.joints, self.index, self.measure = model, joints, index, measure
        self.iterations = 0

    def curve(self, amplitudes: Floats) -> list[QuasiStaticPoint | None]:
        """One point for each amplitude; None where the equations were not solved."""
        order = np.argsort(amplitudes, kind="stable")
        result: list[QuasiStaticPoint | None] = [None] * amplitudes.size
        stuck = np.zeros(self.model.size)
        stuck[self.index] = 1.0
        start = StaticPoint(stuck, float(self.model.squares[self.index]))
        sides = {1.0: start, -1.0: StaticPoint(-stuck, start.square)}
        reached = 0.0
        factor = self.measure.factor(stuck, math.sqrt(start.square))
        for place in order:
            q = float(amplitudes[place]) / factor
            for _ in range(1 if self.measure.sensor is None else 12):
                moved = self._both_sides(sides, reached, q)
                if moved is None:
                    return result
                sides, reached = moved, q
                ahead, behind = sides[1.0], sides[-1.0]
                shape = 0.5 * (ahead.shape - behind.shape)
                point = QuasiStaticPoint(0.5 * (ahead.square + behind.square), shape, q)
                factor = self.measure.factor(point.shape / q, point.omega)
                target = float(amplitudes[place]) / factor
                if abs(target / q - 1.0) < 1e-9:
                    break
                q = target
            result[place] = point
        return result

    def _both_sides(
        self, sides: dict[float, StaticPoint], reached: float, q: float
    ) -> dict[float, StaticPoint] | None:
        """Both sides at an amplitude, by steps in between where it needs them."""
        result = {}
        for sign, point in sides.items():
            low, here, target = reached, point, q
            for _ in range(60):
                trial = self._solve(here, low, target)
                if trial is None:
                    # The way up from nothing is scaled too; small steps are sure.
                    target = math.sqrt(low * target) if low else 0.1 * target
                    if low and target < 1.001 * low:
                        return None
                    continue
                if target == q:
                    result[sign] = trial
                    break
                low, here, target = target, trial, q
            else:
                return None
        return result

    def _solve(self, start: StaticPoint, reached: float, q: float) -> StaticPoint | None:
        """Newton's method on the deflection and lambda, the amplitude held."""
        modes = self.model.size
        v = start.shape * (q / reached if reached else q)
        square = start.square
        flat, stuck, squares = self.joints.flat, self.joints.stuck, self.model.squares
        size = math.inf
        for _ in range(_ITERATIONS):
            self.iterations += 1
            motion = flat.T @ v
            force, slopes = self.joints.first_loading(motion)
            gap = (squares - square) * v + flat @ (force - stuck * motion)
            right = np.append(gap / q, float(v @ v) / q**2 - 1.0)
            step = self._newton_step(v / q, square, slopes, right)
            if step is None:
                return None
            move, before = step[:modes] * q, size
            size = max(float(np.abs(move).max()) / q, abs(step[modes]) / square)
            if not math.isfinite(size):
                return None
            share = 1.0 if size < 0.5 else 0.5 / size
            v = v - share * move
            square = square - share * float(step[modes])
            if size < _STEP or (size < 1e-8 and size >= before):
                return StaticPoint(v, square)
        return None

    def _newton_step(
        self, shape: Floats, square: float, slopes: list[Floats], right: Floats
    ) -> Floats | None:
        """Solve for the change of the shape and of lambda: by GMRES where there are many modes."""
        modes, joints = self.model.size, self.joints
        differences = self.model.squares - square
        # Rows of stiff modes, compared by the motion they mean.
        scale = np.append(np.maximum(self.model.squares, square), 1.0)
        if modes > _LARGEST_DIRECT:
            weights = np.maximum(differences, 0.05 * scale[:modes])
            index = self.index

            def precondition(y: Floats) -> Floats:
                x = y * scale
                x[:modes] /= weights
                # The mode's own row gives lambda, the row of the amplitude the mode's own motion.
                motion = shape[index]
                x[index], x[modes] = y[modes] / (2.0 * motion), -y[index] * scale[index] / motion
                return np.asarray(x)

            def product(y: Floats) -> Floats:
                x = precondition(y)
                moved = joints.tangent_forces(slopes, joints.flat.T @ x[:modes])
                rows = differences * x[:modes] + joints.flat @ moved - shape * x[modes]
                return np.asarray(np.append(rows, 2.0 * float(shape @ x[:modes])) / scale)

            answer = gmres(product, right / scale, 1e-8, 120)
            if answer is not None:
                return precondition(answer)
        matrix = np.zeros((modes + 1, modes + 1))
        tangent = joints.tangent_matrix(slopes)
        matrix[:modes, :modes] = joints.flat @ (tangent @ joints.flat.T)
        matrix[np.arange(modes), np.arange(modes)] += differences
        matrix[:modes, modes] = -shape
        matrix[modes, :modes] = 2.0 * shape
        try:
            return np.asarray(np.linalg.solve(matrix / scale[:, None], right / scale))
        except np.linalg.LinAlgError:
            return None

    def losses(self, points: list[QuasiStaticPoint]) -> tuple[Floats, Floats]:
        """Damping ratios, and the losses of a cycle by joint [J], all groups in a row.

        Of all points at once: a law takes little longer for many amplitudes than for one.
        """
        shapes = np.array([point.shape for point in points]).reshape(-1, self.model.size)
        motions = shapes @ self.joints.flat
        energies = [np.zeros((len(points), 0))]
        for part, group in zip(self.joints.parts, self.joints.groups, strict=True):
            energies.append(group.loop_energies(motions[:, part].reshape(-1, *group.stuck.shape)))
        energy = np.concatenate(energies, axis=1)
        square = np.array([point.square for point in points])
        q = np.array([point.modal_amplitude for point in points])
        with np.errstate(divide="ignore", invalid="ignore"):
            damping = energy.sum(axis=1) / (2.0 * math.pi * square * q**2)
            if self.model.damping is not None:
                viscous = np.einsum("pi,ij,pj->p", shapes, self.model.damping, shapes)
                damping += viscous / (2.0 * np.sqrt(square) * q**2)
        return np.where(square > 0.0, damping, math.nan), energy
