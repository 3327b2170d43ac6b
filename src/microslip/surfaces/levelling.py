"""Least-squares form of a surface, plane or curved, from the points that are present."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError

# Degrees of the Legendre polynomials in x and y, plane first.
_TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
_COUNT = {"mean": 1, "plane": 3, "quadratic": 6}


def level(heights: Floats, form: str) -> tuple[Floats, float]:
    """Return the heights above the fitted form, and the height range of the form [m].

    Legendre polynomials of coordinates from -1 to 1 keep the normal equations well conditioned; a
    second pass over the residual removes rounding errors.
    """
    grid = heights[None] if heights.ndim == 1 else heights
    terms = [t for t in _TERMS[: _COUNT[form]] if heights.ndim == 2 or t[1] == 0]
    along = [_legendre(n) for n in grid.shape[::-1]]
    gaps = np.isnan(grid)
    gapless = not gaps.any()
    matrix = _normal_matrix(None if gapless else ~gaps, along, terms)
    _check(matrix, form, int(grid.size - np.count_nonzero(gaps)))
    result = np.array(grid)
    # Subtract the mean first: heights may be far from zero.
    total: Floats = np.zeros(len(terms))
    for turn in range(3):
        right = _right(result if gapless else np.where(gaps, 0.0, result), along, terms)
        if turn == 0:
            step: Floats = np.zeros(len(terms))
            step[0] = right[0] / matrix[0, 0]
        else:
            step = np.asarray(np.linalg.solve(matrix, right), dtype=float)
        total += step
        result -= _surface(step, along, terms)
    shape = _surface(total, along, terms)
    return result.reshape(heights.shape), float(shape.max() - shape.min())


def _legendre(count: int) -> Floats:
    t = np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1)
    return np.stack([np.ones(count), t, 1.5 * t * t - 0.5])


def _normal_matrix(
    present: np.ndarray | None, along: list[Floats], terms: list[tuple[int, int]]
) -> Floats:
    x, y = along
    pairs_x = np.einsum("in,jn->ijn", x, x)
    pairs_y = np.einsum("in,jn->ijn", y, y)
    if present is None:
        sums = np.einsum("ij,kl->ikjl", pairs_x.sum(-1), pairs_y.sum(-1))
    else:
        # Sum the mask against each product block by block, without a copy of the whole mask.
        rows = np.concatenate(
            [
                np.asarray(part, dtype=float) @ pairs_x.reshape(9, -1).T
                for part in np.array_split(present, max(1, present.size >> 20))
            ]
        )
        sums = (pairs_y.reshape(9, -1) @ rows).reshape(3, 3, 3, 3).transpose(2, 0, 3, 1)
    # sums[i, k, j, l]: x of degrees i and j, y of degrees k and l.
    return np.array([[sums[i, k, j, m] for j, m in terms] for i, k in terms])


def _right(values: Floats, along: list[Floats], terms: list[tuple[int, int]]) -> Floats:
    sums = along[1] @ (values @ along[0].T)
    return np.array([sums[k, i] for i, k in terms])


def _surface(factors: Floats, along: list[Floats], terms: list[tuple[int, int]]) -> Floats:
    square = np.zeros((3, 3))
    for factor, (i, k) in zip(factors, terms, strict=True):
        square[k, i] = factor
    return np.asarray(along[1].T @ (square @ along[0]))


def _check(matrix: Floats, form: str, count: int) -> None:
    scale = 1.0 / np.sqrt(np.maximum(matrix.diagonal(), 1e-300))
    values = np.linalg.eigvalsh(matrix * np.outer(scale, scale))
    if not values[0] > 1e-9 * values[-1]:
        raise InputError(
            f'`level="{form}"`: {count} points do not determine this form; '
            'use more points, `level="plane"` or `level="mean"`'
        )
