"""The linear system of a nonlinear mode, brought down to the joints that do not stick.

Beside sticking joints the modes of a structure do not know of each other: their dynamic compliance
is diagonal. What is left to solve for are the forces of the joints that slip or open, the
coefficients of modes near resonance, and the borders.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.balance import Balance
from microslip.structures.periodic_motion import HarmonicForces

_STUCK = 1e-13  # of the stiffness at rest: tangents that differ by less are those of sticking
_NEAR = 0.05  # of the larger square of frequencies: compliances beyond are solved for, not inverted


class ModePoint(NamedTuple):
    """A periodic motion of a nonlinear mode."""

    coefficients: Floats
    """Fourier coefficients of the modal coordinates, (modes, size)."""
    omega: float
    damping: float


class ModeResidual(NamedTuple):
    """Residual of the equations of a mode at a point."""

    forces: Floats
    border: Floats
    """Amplitude and phase."""
    merit: float
    answers: list[HarmonicForces]
    by_q: Floats
    """Derivatives of the amplitude's equation."""
    by_omega: float


class Bordered(NamedTuple):
    """A x + (joints) x + columns y = right, rows x + corner y = below."""

    columns: Floats
    """(modes, size, borders)."""
    rows: Floats
    """(borders, modes, size)."""
    corner: Floats
    """(borders, borders)."""
    right: Floats
    """(modes, size)."""
    below: Floats
    """(borders,)."""


class _Loose(NamedTuple):
    """Joints of a group that do not stick, in the coordinates in which they do not."""

    directions: Floats
    """(modes, joints * coordinates)."""
    tangent: Floats
    """Beyond sticking, (joints, coordinates * size, coordinates * size)."""


def solve(
    balance: Balance,
    answers: list[HarmonicForces],
    omega: float,
    damping: float,
    system: Bordered,
) -> tuple[Floats, Floats] | None:
    """The coefficients (modes, size) and the borders; None where there is no answer.

    For a structure without a damping matrix, which would couple its modes.
    """
    modes, size = balance.shape
    orders, squares = balance.basis.orders, balance.model.squares
    stiff = squares[:, None] - (orders * omega) ** 2
    drag = np.broadcast_to(damping * omega * orders, stiff.shape)
    scale = np.maximum(squares, omega**2)[:, None]
    weight = stiff**2 + drag**2
    resonant = weight < (_NEAR * scale) ** 2
    inverse = np.where(resonant, 0.0, 1.0 / np.where(resonant, 1.0, weight))
    soft, lag = stiff * inverse, drag * inverse

    def comply(force: Floats) -> Floats:
        """Coefficients that forces make, without the ones that are solved for."""
        shape = soft.shape + (1,) * (force.ndim - 2)
        result, factor = soft.reshape(shape) * force, lag.reshape(shape)
        result[:, 1::2] -= factor[:, 1::2] * force[:, 2::2]
        result[:, 2::2] += factor[:, 2::2] * force[:, 1::2]
        return np.asarray(result)

    loose = [part for part in _loose(balance, answers) if part.tangent.size]
    flat = np.concatenate([np.zeros((modes, 0)), *(part.directions for part in loose)], axis=1)
    count = flat.shape[1]
    # Compliance of the loose coordinates, (count, size, count, size): harmonics do not mix in it.
    compliance = np.zeros((count, size, count, size))
    for k in range(size):
        compliance[:, k, :, k] = flat.T @ (soft[:, k, None] * flat)
    for k in range(1, size, 2):
        crossed = flat.T @ (lag[:, k, None] * flat)
        compliance[:, k, :, k + 1] -= crossed
        compliance[:, k + 1, :, k] += crossed
    retained = np.argwhere(resonant)
    borders = system.below.size
    extra = retained.shape[0] + borders
    # What the other unknowns do to the loose coordinates: retained coefficients and borders.
    moved = np.zeros((count, size, extra))
    for place, (mode, k) in enumerate(retained):
        moved[:, k, place] = flat[mode]
    by_border = comply(system.columns)
    moved[:, :, retained.shape[0] :] = -np.tensordot(flat, by_border, axes=(0, 0))
    response = comply(system.right)
    start = np.tensordot(flat, response, axes=(0, 0))
    total = count * size
    matrix = np.zeros((total + extra, total + extra))
    right = np.zeros(total + extra)
    first = 0
    for part in loose:
        joints, width = part.tangent.shape[:2]
        coordinates = joints * width // size
        rows = slice(first * size, (first + coordinates) * size)
        here = slice(first, first + coordinates)
        shaped = compliance[here].reshape(joints, width, total)
        matrix[rows, :total] = (part.tangent @ shaped).reshape(-1, total)
        shaped = moved[here].reshape(joints, width, extra)
        matrix[rows, total:] = -(part.tangent @ shaped).reshape(-1, extra)
        right[rows] = (part.tangent @ start[here].reshape(joints, width, 1)).ravel()
        first += coordinates
    matrix[np.arange(total), np.arange(total)] += 1.0
    # The equations of the coefficients that are retained.
    for place, (mode, k) in enumerate(retained):
        row = total + place
        matrix[row].reshape(-1)[k:total:size] = flat[mode]
        matrix[row, total + retained.shape[0] :] = system.columns[mode, k]
        matrix[row, row] += stiff[mode, k]
        right[row] = system.right[mode, k]
        if k:
            partner_index = k + 1 if k % 2 else k - 1
            sign = 1.0 if k % 2 else -1.0
            partner = np.flatnonzero((retained[:, 0] == mode) & (retained[:, 1] == partner_index))
            matrix[row, total + int(partner[0])] += sign * drag[mode, k]
    # The borders, with the coefficients expressed by forces.
    for border in range(borders):
        row, weights = total + retained.shape[0] + border, system.rows[border]
        turned = _transposed(soft, lag, weights)
        matrix[row, :total] = -(flat.T @ turned).ravel()
        for place, (mode, k) in enumerate(retained):
            matrix[row, total + place] = weights[mode, k]
        matrix[row, total + retained.shape[0] :] = system.corner[border] - np.tensordot(
            turned, system.columns, axes=([0, 1], [0, 1])
        )
        right[row] = system.below[border] - float(np.sum(turned * system.right))
    unknowns = _balanced_solve(matrix, right)
    if unknowns is None:
        return None
    pull, outer = unknowns[:total].reshape(count, size), unknowns[total:]
    y = outer[retained.shape[0] :]
    x = comply(system.right - flat @ pull - system.columns @ y)
    for place, (mode, k) in enumerate(retained):
        x[mode, k] = outer[place]
    return x, y


def _transposed(soft: Floats, lag: Floats, weights: Floats) -> Floats:
    """The transposed compliance on weights of coefficients."""
    result = soft * weights
    result[:, 1::2] += lag[:, 2::2] * weights[:, 2::2]
    result[:, 2::2] -= lag[:, 1::2] * weights[:, 1::2]
    return np.asarray(result)


def _balanced_solve(matrix: Floats, right: Floats) -> Floats | None:
    """Elimination after rows and columns were scaled to one."""
    rows = np.abs(matrix).max(axis=1)
    if not np.isfinite(rows).all() or (rows == 0.0).any():
        return None
    matrix /= rows[:, None]
    columns = np.abs(matrix).max(axis=0)
    if (columns == 0.0).any():
        return None
    matrix /= columns
    try:
        return np.asarray(np.linalg.solve(matrix, right / rows) / columns)
    except np.linalg.LinAlgError:
        return None


def _loose(balance: Balance, answers: list[HarmonicForces]) -> list[_Loose]:
    """Joints that do not stick."""
    result = []
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
        columns = directions[:, joints][:, :, coordinates].reshape(directions.shape[0], -1)
        result.append(_Loose(columns, selected.reshape(joints.size, width, width)))
    return result


@dataclass(frozen=True, eq=False)
class ModeStep:
    """The linear system of a step of Newton's method."""

    balance: Balance
    index: int
    point: ModePoint
    current: ModeResidual
    columns: Floats
    """Derivatives of the forces by omega and zeta, (modes, size, 2)."""

    @property
    def _damping(self) -> float:
        return -2.0 * self.point.damping * self.point.omega

    @property
    def _scale(self) -> Floats:
        """Of the rows: forces of very different modes, compared by the motion they mean."""
        return np.maximum(self.balance.model.squares, self.point.omega**2)[:, None]

    def _right(self, unit: float) -> np.ndarray:
        """Forces and borders of the point, scaled."""
        forces = (self.current.forces / self._scale).reshape(-1) / unit
        return np.append(forces, [self.current.border[0], self.current.border[1] / unit])

    def eliminate(self) -> Floats | None:
        """By Gauss's elimination, of the joints that do not stick alone where that will do."""
        modes, size = self.balance.shape
        if self.balance.model.damping is None:
            return self._by_joints()
        count = modes * size
        matrix = np.zeros((count + 2, count + 2))
        inner = self.balance.linear_matrix(self.point.omega, self._damping)
        inner += self.balance.tangent_matrix(self.current.answers)
        q = self.point.coefficients
        unit = float(np.abs(q).max())
        scale = self._scale
        matrix[:count, :count] = (inner / scale[:, :, None, None]).reshape(count, count) * unit
        omega = self.point.omega
        matrix[:count, -2] = (self.columns[..., 0] / scale).reshape(-1) * omega
        matrix[:count, -1] = (self.columns[..., 1] / scale).reshape(-1)
        matrix[:count] /= unit
        matrix[-2, :count] = self.current.by_q.reshape(-1) * unit
        matrix[-2, -2] = self.current.by_omega * omega
        matrix[-1, self.index * size + 2] = 1.0
        try:
            step = np.linalg.solve(matrix, self._right(unit))
        except np.linalg.LinAlgError:
            return None
        step[:count] *= unit
        step[-2] *= omega
        return step

    def _by_joints(self) -> Floats | None:
        phase = np.zeros(self.balance.shape)
        phase[self.index, 2] = 1.0
        system = Bordered(
            self.columns,
            np.stack([self.current.by_q, phase]),
            np.array([[self.current.by_omega, 0.0], [0.0, 0.0]]),
            self.current.forces,
            self.current.border,
        )
        answers = self.current.answers
        step = solve(self.balance, answers, self.point.omega, self._damping, system)
        return None if step is None else np.append(step[0].reshape(-1), step[1])

    def iterate(self) -> Floats | None:
        """By GMRES, preconditioned with the structure whose joints stick."""
        modes, size = self.balance.shape
        count = modes * size
        unit = float(np.abs(self.point.coefficients).max())
        omega = self.point.omega
        scale = self._scale
        solve = self._preconditioner(unit)

        def product(y: Floats) -> Floats:
            x = solve(y)
            change = x[:count].reshape(modes, size)
            forces = self.balance.linear(change, omega, self._damping)
            forces += self.balance.tangent(self.current.answers, change)
            forces /= unit
            forces += self.columns[..., 0] * (x[-2] * omega / unit)
            forces += self.columns[..., 1] * (x[-1] / unit)
            border = [
                float(np.sum(self.current.by_q * change)) + self.current.by_omega * x[-2] * omega,
                change[self.index, 2] / unit,
            ]
            return np.append((forces / scale).reshape(-1), border)

        y = gmres(product, self._right(unit), 1e-9 if self.current.merit < 1e-4 else 1e-4, 160)
        if y is None:
            return None
        step = solve(y)
        step[-2] *= omega
        return step

    def _preconditioner(self, unit: float) -> Callable[[Floats], Floats]:
        """Solves with sticking joints; the mode's own four unknowns with their joint forces."""
        modes, size = self.balance.shape
        count, i = modes * size, self.index
        omega, scale = self.point.omega, self._scale
        orders = self.balance.basis.orders
        square = (self.balance.model.squares[:, None] - (orders * omega) ** 2) / scale
        damping: Floats | float = self._damping
        if self.balance.model.damping is not None:
            damping = damping + self.balance.model.damping.diagonal()[:, None]
        rate = np.broadcast_to(orders * omega * damping / scale, square.shape)
        weight = 1.0 / np.maximum(square**2 + rate**2, 1e-8)
        cosine, sine = np.arange(1, size, 2), np.arange(2, size, 2)
        core = np.zeros((4, 4))
        for column in range(2):
            change = np.zeros((modes, size))
            change[i, 1 + column] = 1.0
            forces = self.balance.linear(change, omega, self._damping)
            forces += self.balance.tangent(self.current.answers, change)
            core[:2, column] = forces[i, 1:3] / scale[i]
        core[:2, 2] = self.columns[i, 1:3, 0] * omega / unit / scale[i]
        core[:2, 3] = self.columns[i, 1:3, 1] / unit / scale[i]
        core[2, :2] = self.current.by_q[i, 1:3] * unit
        core[2, 2] = self.current.by_omega * omega
        core[3, 1] = 1.0
        inverse = np.linalg.pinv(core)

        def solve(y: Floats) -> Floats:
            forces = y[:count].reshape(modes, size) * unit
            x = np.empty_like(forces)
            x[:, 0] = forces[:, 0] / square[:, 0]
            a, b, w = square[:, cosine], rate[:, cosine], weight[:, cosine]
            x[:, cosine] = w * (a * forces[:, cosine] - b * forces[:, sine])
            x[:, sine] = w * (b * forces[:, cosine] + a * forces[:, sine])
            # Scaled as the unknowns are: motion by its unit, frequency by itself.
            four = inverse @ np.array([y[i * size + 1], y[i * size + 2], y[-2], y[-1]])
            x[i, 1:3] = four[:2] * unit
            return np.append(x.reshape(-1), four[2:])

        return solve


def gmres(
    product: Callable[[Floats], Floats], right: Floats, tolerance: float, iterations: int
) -> Floats | None:
    """Saad and Schultz's method without restarts; None where it does not get there."""
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
        if j % 8 == 7 or j == iterations - 1 or upper[j + 1, j] <= 1e-14:
            head = np.zeros(j + 2)
            head[0] = start
            weights, *_ = np.linalg.lstsq(upper[: j + 2, : j + 1], head, rcond=None)
            miss = float(np.linalg.norm(upper[: j + 2, : j + 1] @ weights - head))
            if miss <= tolerance * start:
                return np.asarray(weights @ basis[: j + 1])
    return None
