"""Equations of harmonic balance for a nonlinear mode or a forced motion, and their Newton steps.

The unknowns are the Fourier coefficients Q of the modal coordinates, shape (modes, size) with
``size`` coefficients for each mode, and, for a nonlinear mode, its angular frequency omega and
damping ratio zeta: the *extended periodic motion* of Krack (2015), DOI
10.1016/j.compstruc.2015.03.008, in which the term -2 zeta omega x' compensates the losses of the
joints.

With sticking joints the modes of a structure are uncoupled: their dynamic compliance is diagonal. A
step of Newton's method therefore solves only for the forces of joints that slip or open, for
coefficients near resonance, and for the borders: omega and zeta, with the equations of amplitude
and phase.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.structures.modal_model import ModalJoints, ModalModel
from microslip.structures.periodic_motion import HarmonicBasis, HarmonicForces


@dataclass(frozen=True, eq=False)
class Balance:
    """Equations of harmonic balance; ``answers`` are joint forces and Jacobian of each group.

    *Slip forces* are joint forces minus those of sticking joints; the latter are the stiffness at
    rest times the joint motion.
    """

    model: ModalModel
    joints: ModalJoints
    basis: HarmonicBasis

    @property
    def shape(self) -> tuple[int, int]:
        """Shape (modes, size) of the Fourier coefficients of motions and of modal forces."""
        return self.model.size, self.basis.size

    def joint_forces(
        self, coefficients: Floats, carried: Floats | float = 0.0
    ) -> tuple[Floats, list[HarmonicForces]]:
        """Return the modal slip forces (modes, size), and the joint forces of each group.

        Both are Fourier coefficients. ``carried`` is the joint motion due to a moving base,
        (coordinates, size) [m].
        """
        motion = self.joints.flat.T @ coefficients + carried
        answers = [
            group.harmonic_forces(part, self.basis)
            for group, part in zip(self.joints.groups, self.joints.split(motion), strict=True)
        ]
        forces = [answer.force.reshape(-1, self.basis.size) for answer in answers]
        total = np.concatenate([np.zeros((0, self.basis.size)), *forces])
        return self.joints.flat @ (total - self.joints.stuck[:, None] * motion), answers

    def linear(self, coefficients: Floats, omega: float, damping: Floats | float) -> Floats:
        """Return the forces of inertia, damping, and stiffness with sticking joints (modes, size).

        ``damping`` [rad/s], such as -2 zeta omega, is a factor on the modal velocities; its forces
        are added to those of the damping matrix.
        """
        orders = self.basis.orders
        square = self.model.squares[:, None] - (orders * omega) ** 2
        return square * coefficients + self.damped(self.velocity(coefficients, omega), damping)

    def velocity(self, coefficients: Floats, omega: float) -> Floats:
        """Return the Fourier coefficients (modes, size) of the velocity of a motion."""
        result = np.zeros_like(coefficients)
        rate = omega * self.basis.orders[1::2]
        result[:, 1::2] = rate * coefficients[:, 2::2]
        result[:, 2::2] = -rate * coefficients[:, 1::2]
        return result

    def by_omega(self, coefficients: Floats, omega: float) -> Floats:
        """Return the derivative of inertia and damping forces with respect to omega."""
        inertia = -2.0 * omega * self.basis.orders**2 * coefficients
        return inertia + self.damped(self.velocity(coefficients, omega), 0.0) / omega

    def damped(self, velocity: Floats, damping: Floats | float) -> Floats:
        """Return the damping forces of a velocity (modes, size), as in :meth:`linear`."""
        result = damping * velocity
        if self.model.damping is not None:
            result = result + self.model.damping @ velocity
        return result

    def by_motion(self, answers: list[HarmonicForces], motion: Floats) -> Floats:
        """Return the change of the modal slip forces (modes, size) for a change of joint motions.

        ``motion`` are the Fourier coefficients of this small change (coordinates, size) [m].
        """
        size = self.basis.size
        moved = -self.joints.stuck[:, None] * motion
        for part, answer in zip(self.joints.parts, answers, strict=True):
            joints, width = answer.force.shape[:2]
            blocks = answer.jacobian.reshape(joints, width * size, width * size)
            local = motion[part].reshape(joints, width * size, 1)
            moved[part] += (blocks @ local).reshape(-1, size)
        return np.asarray(self.joints.flat @ moved)

    def tangent_matrix(self, answers: list[HarmonicForces]) -> Floats:
        """Return the Jacobian of the modal slip forces, shape (modes, size, modes, size)."""
        modes, size = self.shape
        result = np.zeros((modes, size, modes, size))
        for answer, directions, group in zip(
            answers, self.joints.directions, self.joints.groups, strict=True
        ):
            joints, width = group.stuck.shape
            blocks = answer.beyond(group.stuck)
            # (joints, c, k, c', l) with the directions of c' -> (joints, c, k, l, modes)
            half = np.matmul(
                blocks.transpose(0, 1, 2, 4, 3).reshape(joints, -1, width),
                directions.transpose(1, 2, 0),
            ).reshape(joints, width, size * size * modes)
            full = directions.reshape(modes, -1) @ half.reshape(joints * width, -1)
            result += full.reshape(modes, size, size, modes).transpose(0, 1, 3, 2)
        return result

    def linear_matrix(self, omega: float, damping: float) -> Floats:
        """Return the derivative of :meth:`linear` with respect to the coefficients."""
        modes, size = self.shape
        result = np.zeros((modes, size, modes, size))
        index = np.arange(modes)
        for k, order in enumerate(self.basis.orders):
            result[index, k, index, k] = self.model.squares - (order * omega) ** 2
        damper = damping * np.eye(modes)
        if self.model.damping is not None:
            damper = damper + self.model.damping
        for k in range(1, size, 2):
            rate = omega * self.basis.orders[k]
            result[:, k, :, k + 1] += rate * damper
            result[:, k + 1, :, k] -= rate * damper
        return result


_STUCK = 1e-13  # of the stiffness at rest: tangents that differ by less are those of sticking
_NEAR = 0.05  # of the larger square of frequencies: compliances beyond are solved for, not inverted


class ModePoint(NamedTuple):
    """Periodic motion of a nonlinear mode."""

    coefficients: Floats
    """Fourier coefficients of the modal coordinates, (modes, size)."""
    omega: float
    damping: float


class ModeResidual(NamedTuple):
    """Residual of the equations of a mode."""

    forces: Floats
    border: Floats
    """Residuals of the equations of amplitude and phase, (2,)."""
    merit: float
    answers: list[HarmonicForces]
    by_q: Floats
    """Derivatives of the amplitude equation with respect to the coefficients q."""
    by_omega: float


class _Compliance:
    """Dynamic compliance of the modes at each harmonic, applied to complex amplitudes."""

    def __init__(self, balance: Balance, omega: float, damping: float) -> None:
        squares, viscous = balance.model.squares, balance.model.damping
        at = omega * np.array(balance.basis.harmonics, dtype=float)[:, None]
        drag = damping if viscous is None else damping + np.diag(viscous)
        stiff, scale = squares - at**2, np.maximum(squares, omega**2)
        # What is near resonance is stiffened; an unknown of its own takes that back.
        added = np.where(stiff**2 + (at * drag) ** 2 < (_NEAR * scale) ** 2, scale, 0.0)
        self.added = np.repeat(added, 2, axis=0)[1:].T
        diagonal = stiff + added + 1j * at * drag
        if viscous is None:
            self._inverse: NDArray[Any] = 1.0 / diagonal
        else:
            full = 1j * at[:, :, None] * (viscous - np.diag(np.diag(viscous)))
            index = np.arange(squares.size)
            full[:, index, index] += diagonal
            self._inverse = np.linalg.inv(full)

    def on(self, force: Floats, transposed: bool = False) -> Floats:
        """Return the Fourier coefficients of the motion under forces (modes, size, ...)."""
        turning = force[:, ::2].astype(complex)
        turning[:, 1:] = force[:, 1::2] - 1j * force[:, 2::2]
        inverse = self._inverse.conj() if transposed else self._inverse
        if inverse.ndim == 2:
            turning = inverse.T.reshape(turning.shape[:2] + (1,) * (force.ndim - 2)) * turning
        else:
            turning = np.einsum("hmn,nh...->mh...", inverse, turning)
        result = np.empty(force.shape)
        result[:, 0] = turning[:, 0].real
        result[:, 1::2], result[:, 2::2] = turning[:, 1:].real, -turning[:, 1:].imag
        return result

    def between(self, directions: Floats, result: Floats) -> None:
        """Fill ``result`` with the compliance between joint coordinates at each harmonic.

        ``directions`` (modes, coordinates) are the joint directions in modal coordinates. Rows and
        columns of ``result`` are numbered by coordinate, then by Fourier coefficient.
        """
        size = 2 * self._inverse.shape[0] - 1
        for h, inverse in enumerate(self._inverse):
            k = max(2 * h - 1, 0)
            result[k::size, k::size] = straight = _between(directions, inverse.real)
            if h:
                result[k + 1 :: size, k + 1 :: size] = straight
                result[k::size, k + 1 :: size] = crossed = _between(directions, inverse.imag)
                result[k + 1 :: size, k::size] = -crossed


def _between(flat: Floats, inverse: Floats) -> Floats:
    part = np.ascontiguousarray(inverse)
    return np.asarray(flat.T @ (part[:, None] * flat if part.ndim == 1 else part @ flat))


class _Factors:
    """LU factors of a matrix with scaled rows and columns; the matrix is overwritten."""

    def __init__(self, matrix: Floats) -> None:
        from scipy.linalg.lapack import dgetrf

        self._rows = np.abs(matrix).max(axis=1)
        self.regular = bool(np.isfinite(self._rows).all()) and bool((self._rows > 0.0).all())
        if not self.regular:
            return
        matrix /= self._rows[:, None]
        self._columns = np.abs(matrix).max(axis=0)
        self.regular = bool((self._columns > 0.0).all())
        if self.regular:
            matrix /= self._columns
            # The transpose of an array in rows is one in columns, which LAPACK takes as it is.
            self._factors, self._pivots, info = dgetrf(matrix.T, overwrite_a=True)
            self.regular = info == 0

    def solve(self, right: Floats) -> Floats:
        from scipy.linalg.lapack import dgetrs

        solved, _ = dgetrs(self._factors, self._pivots, right / self._rows, trans=1)
        return np.asarray(solved / self._columns)


def _not_sticking(
    balance: Balance, answers: list[HarmonicForces]
) -> tuple[list[Floats], list[Floats]]:
    """Return directions and tangents of the joints that slip or open, by group.

    Directions have the shape (modes, joints * coordinates), tangents less those of sticking
    (joints, coordinates * size, coordinates * size).
    """
    columns, tangents = [], []
    size = balance.basis.size
    for answer, directions, group in zip(
        answers, balance.joints.directions, balance.joints.groups, strict=True
    ):
        blocks = answer.beyond(group.stuck)
        by_row = np.abs(blocks).max(axis=(2, 3, 4), initial=0.0)
        by_column = np.abs(blocks).max(axis=(1, 2, 4), initial=0.0)
        free = np.maximum(by_row, by_column) > _STUCK * group.stuck.max(initial=0.0)
        joints, coordinates = np.flatnonzero(free.any(axis=1)), np.flatnonzero(free.any(axis=0))
        harmonics = np.arange(size)
        selected = blocks[np.ix_(joints, coordinates, harmonics, coordinates, harmonics)]
        width = coordinates.size * size
        if selected.size:
            columns.append(directions[:, joints][:, :, coordinates].reshape(len(directions), -1))
            tangents.append(selected.reshape(joints.size, width, width))
    return columns, tangents


class Elimination(NamedTuple):
    """Factorised linear system of a Newton step, to be solved for one or more residuals."""

    compliance: _Compliance
    flat: Floats
    """Directions of the coordinates that do not stick, (modes, coordinates)."""
    columns: Floats
    """Derivatives of the force equations with respect to the border unknowns,
    (modes, size, borders)."""
    turned: Floats
    """Rows of the border equations multiplied by the compliance, (borders, modes * size)."""
    blocks: list[Floats]
    rows: list[slice]
    factors: _Factors

    def step(self, residual: ModeResidual) -> Floats:
        """Return the Newton step of all unknowns for a residual."""
        forces = residual.forces
        right = np.zeros(self.flat.shape[1] * forces.shape[1] + self.columns.shape[2])
        total = right.size - self.columns.shape[2]
        right[:total] = np.tensordot(self.flat, self.compliance.on(forces), axes=(0, 0)).reshape(-1)
        for block, part in zip(self.blocks, self.rows, strict=True):
            right[part] = block @ right[part]
        right[total : total + 2] = residual.border
        right[total:] -= self.turned @ forces.reshape(-1)
        unknowns = self.factors.solve(right)
        pull, borders = unknowns[:total].reshape(-1, forces.shape[1]), unknowns[total:]
        coefficients = self.compliance.on(forces - self.flat @ pull - self.columns @ borders)
        return np.append(coefficients.reshape(-1), borders[:2])


@dataclass(frozen=True, eq=False)
class ModeStep:
    """Linear system of a Newton step for a nonlinear mode."""

    balance: Balance
    index: int
    point: ModePoint
    current: ModeResidual
    columns: Floats
    """Derivatives of the forces with respect to omega and zeta, (modes, size, 2)."""

    @property
    def _damping(self) -> float:
        return -2.0 * self.point.damping * self.point.omega

    def eliminate(self) -> Elimination | None:
        """Factorise the system of borders and joints that do not stick; None if singular.

        Borders are the equations of amplitude and phase, and of coefficients near resonance.
        """
        modes, size = self.balance.shape
        compliance = _Compliance(self.balance, self.point.omega, self._damping)
        loose, tangents = _not_sticking(self.balance, self.current.answers)
        flat = np.concatenate([np.zeros((modes, 0)), *loose], axis=1)
        # Borders: amplitude and phase, then each coefficient near resonance, which is itself.
        places = np.argwhere(compliance.added)
        count, total = 2 + len(places), flat.shape[1] * size
        matrix = np.zeros((total + count, total + count))
        compliance.between(flat, matrix[:total, :total])
        columns, weights = np.zeros((2, modes, size, count))
        columns[..., :2] = self.columns
        weights[..., 0], weights[self.index, 2, 1] = self.current.by_q, 1.0
        for border, (mode, k) in enumerate(places, start=2):
            columns[mode, k, border], weights[mode, k, border] = -compliance.added[mode, k], 1.0
        corner = np.diag([0.0, 0.0] + [-1.0] * len(places))
        corner[0, 0] = self.current.by_omega
        # What the borders do to the loose coordinates.
        moved = np.tensordot(flat, compliance.on(columns), axes=(0, 0))
        matrix[:total, total:] = moved.reshape(total, count)
        blocks = [block for tangent in tangents for block in tangent]
        ends = np.cumsum([0, *map(len, blocks)])
        rows = [slice(start, stop) for start, stop in pairwise(ends)]
        for block, part in zip(blocks, rows, strict=True):
            matrix[part] = block @ matrix[part]
        matrix[np.arange(total), np.arange(total)] += 1.0
        # The borders' equations, with the coefficients expressed by forces.
        turned = compliance.on(weights, transposed=True)
        by_pull = np.tensordot(turned, flat, axes=(0, 0))
        matrix[total:, :total] = -by_pull.transpose(1, 2, 0).reshape(count, total)
        turned = turned.reshape(-1, count).T
        matrix[total:, total:] = corner - turned @ columns.reshape(-1, count)
        factors = _Factors(matrix)
        if not factors.regular:
            return None
        return Elimination(compliance, flat, columns, turned, blocks, rows, factors)

    def iterate(self, tolerance: float) -> Floats | None:
        """Solve by GMRES to a relative residual, preconditioned with sticking joints.

        Here motions are relative to the largest coefficient, forces to ``scale``, and coefficients
        are complex amplitudes, cosine + i sine, as pairs of numbers (with zero beside the mean).
        """
        balance, omega, i = self.balance, self.point.omega, self.index
        squares, viscous, joints = balance.model.squares, balance.model.damping, balance.joints
        rates = omega * np.array(balance.basis.harmonics)
        wide = balance.basis.size + 1
        unit = float(np.abs(self.point.coefficients).max())
        scale = np.maximum(squares, omega**2)[:, None]
        drag = self._damping if viscous is None else self._damping + np.diag(viscous)[:, None]
        dynamic = (squares[:, None] - rates**2 - 1j * rates * drag) / scale
        compliance = 1.0 / np.where(abs(dynamic) < 1e-4, dynamic + 1.0, dynamic)
        coupling = None if viscous is None else (viscous - np.diag(np.diag(viscous))) / scale
        to_joints, from_joints = np.ascontiguousarray(joints.flat.T), joints.flat / scale
        tangents = []
        for part, answer, group in zip(
            joints.parts, self.current.answers, joints.groups, strict=True
        ):
            blocks = np.insert(np.insert(answer.beyond(group.stuck), 1, 0.0, 2), 1, 0.0, 4)
            tangents.append(
                (part, blocks.reshape(len(blocks), *(wide * group.stuck.shape[1],) * 2))
            )

        def paired(coefficients: Floats) -> Floats:
            return np.insert(coefficients, 1, 0.0, axis=1).reshape(-1)

        by_borders = np.stack(
            [paired(self.columns[..., k] / scale) * by / unit for k, by in enumerate((omega, 1.0))],
            axis=1,
        )
        sine = i * wide + 3
        by_q = unit * paired(self.current.by_q)

        def multiply(x: Floats) -> Floats:
            q = x[:-2].reshape(-1, wide)
            forces = dynamic * q.view(complex)
            if coupling is not None:
                forces -= 1j * rates * (coupling @ q.view(complex))
            motion = to_joints @ q
            moved = np.empty_like(motion)
            for part, blocks in tangents:
                local = motion[part].reshape(len(blocks), -1, 1)
                moved[part] = (blocks @ local).reshape(-1, wide)
            total = (forces.view(float) + from_joints @ moved).reshape(-1) + by_borders @ x[-2:]
            border = by_q @ x[:-2] + self.current.by_omega * omega * x[-2]
            return np.concatenate([total, [border, x[sine]]])

        # The preconditioner is exact in the fundamental harmonic of the mode, omega and zeta.
        inner = [sine - 1, sine, -2, -1]
        core = np.empty((4, 4))
        for column, place in enumerate(inner):
            x = np.zeros(by_q.size + 2)
            x[place] = 1.0
            core[:, column] = multiply(x)[inner]
        core_inverse = np.linalg.pinv(core)

        def precondition(y: Floats) -> Floats:
            x = y.copy()
            x[:-2] = (compliance * y[:-2].reshape(-1, wide).view(complex)).view(float).reshape(-1)
            x[inner] = core_inverse @ y[inner]
            return x

        forces, border = self.current.forces / scale / unit, self.current.border
        right = np.append(paired(forces), [border[0], border[1] / unit])
        y = gmres(lambda y: multiply(precondition(y)), right, tolerance, 160)
        if y is None:
            return None
        step = precondition(y)
        coefficients = unit * np.delete(step[:-2].reshape(-1, wide), 1, axis=1)
        return np.append(coefficients.reshape(-1), [omega * step[-2], step[-1]])


def gmres(
    product: Callable[[Floats], Floats], right: Floats, tolerance: float, iterations: int
) -> Floats | None:
    """Solve by GMRES without restarts (Saad and Schultz 1986); return None without convergence."""
    start = float(np.linalg.norm(right))
    if start == 0.0:
        return np.zeros_like(right)
    basis = np.empty((iterations + 1, right.size))
    basis[0] = right / start
    upper = np.zeros((iterations + 1, iterations))
    for j in range(iterations):
        vector = product(basis[j])
        for _ in range(2):  # once more, for orthogonality to rounding
            parts = basis[: j + 1] @ vector
            vector = vector - parts @ basis[: j + 1]
            upper[: j + 1, j] += parts
        upper[j + 1, j] = np.linalg.norm(vector)
        if upper[j + 1, j] > 0.0:
            basis[j + 1] = vector / upper[j + 1, j]
        if j % 4 == 3 or j == iterations - 1 or upper[j + 1, j] <= 1e-14:
            head = np.zeros(j + 2)
            head[0] = start
            weights, *_ = np.linalg.lstsq(upper[: j + 2, : j + 1], head, rcond=None)
            miss = float(np.linalg.norm(upper[: j + 2, : j + 1] @ weights - head))
            if miss <= tolerance * start:
                return np.asarray(weights @ basis[: j + 1])
    return None
