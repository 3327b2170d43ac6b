"""The linear system of a nonlinear mode, brought down to the joints that do not stick.

Beside sticking joints the modes of a structure do not know of each other: their dynamic compliance
is diagonal. What is left to solve for are the forces of the joints that slip or open, the
coefficients of modes near resonance, and the borders.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.balance import Balance
from microslip.structures.joint_groups import HarmonicForces

_STUCK = 1e-13  # of the stiffness at rest: tangents that differ by less are those of sticking
_NEAR = 0.05  # of the larger square of frequencies: compliances beyond are solved for, not inverted


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
