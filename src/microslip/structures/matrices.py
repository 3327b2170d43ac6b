"""Mass, stiffness and damping matrices: checks, linear modes and rigid-body motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock

_ASYMMETRY = 1e-8  # of the largest entry: what files with eight digits leave
LARGEST_DENSE = 4000
"""Degrees of freedom up to which a sparse matrix is treated as a dense one."""


def is_sparse(value: Any) -> bool:
    """Return whether a matrix is a sparse matrix of SciPy, without importing SciPy."""
    return type(value).__module__.startswith("scipy.sparse") and hasattr(value, "tocsc")


def check_indices(name: str, matrix: Any) -> None:
    """Raise InputError for sparse indices outside the shape, which SciPy does not check."""
    try:
        if matrix.format in ("csc", "csr", "bsr"):
            matrix.check_format(full_check=True)
            return
        if matrix.format == "lil":
            places = [np.array([column for row in matrix.rows for column in row], dtype=int)]
            sizes = matrix.shape[1:]
        elif matrix.format == "coo":
            places, sizes = [matrix.row, matrix.col], matrix.shape
        else:
            return  # dictionaries and diagonals are converted by rules that look
        for place, size in zip(places, sizes, strict=True):
            if place.size and not 0 <= place.min() <= place.max() < size:
                raise ValueError(f"indices must be from 0 to {size - 1}")
    except (ValueError, TypeError, IndexError) as error:
        raise InputError(f"`{name}` must be a valid sparse matrix: {error}") from None


def symmetric_matrix(name: str, value: Any, size: int | None = None) -> Any:
    """Validate a square symmetric matrix; return it read-only, as a dense or CSC array."""
    if is_sparse(value):
        check_indices(name, value)
        matrix = value.tocsc().astype(float)
        matrix.sum_duplicates()
        entries = matrix.data
        bad = int(np.count_nonzero(~np.isfinite(entries)))
        if bad:
            raise InputError(f"{name} must be finite: {bad} of its entries are not")
    else:
        matrix = floats(name, value)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"{name} must be a square matrix, got shape {matrix.shape}")
    if size is not None and matrix.shape[0] != size:
        raise InputError(
            f"{name} must be {size} x {size}, as the mass matrix is, got "
            f"{matrix.shape[0]} x {matrix.shape[1]}"
        )
    largest = float(abs(matrix).max())
    gap = abs(matrix - matrix.T)
    if float(gap.max()) > _ASYMMETRY * largest:
        row, column = _place(gap)
        raise InputError(
            f"{name} must be symmetric, but [{row}, {column}] = {matrix[row, column]:.6g} and "
            f"[{column}, {row}] = {matrix[column, row]:.6g}"
        )
    result = 0.5 * (matrix + matrix.T)
    if is_sparse(result):
        result = result.tocsc()
        lock(result.data)
        return result
    return lock(np.ascontiguousarray(result))


def _place(gap: Any) -> tuple[int, int]:
    if is_sparse(gap):
        gap = gap.tocoo()
        i = int(np.argmax(gap.data))
        return int(gap.row[i]), int(gap.col[i])
    row, column = np.unravel_index(int(np.argmax(gap)), gap.shape)
    return int(row), int(column)


def check_mass(mass: Any) -> None:
    """Raise InputError unless the mass matrix is positive definite."""
    diagonal = mass.diagonal()
    if diagonal.min() <= 0.0:
        i = int(np.argmin(diagonal))
        raise InputError(
            f"mass must be positive definite, but degree of freedom {i} has the mass "
            f"{diagonal[i]:.6g}; condense out what has no mass"
        )
    if not positive_definite(mass):
        raise InputError(
            "mass must be positive definite: some motion has zero or negative kinetic energy"
        )


def check_stiffness(stiffness: Any, mass: Any) -> None:
    """Raise InputError unless the stiffness matrix is positive semidefinite, to rounding."""
    # Beside the largest stiffness to mass ratio, which bounds the rounding of all others.
    rate = fastest_rate(stiffness, mass) or 1.0
    if not positive_definite(stiffness + 1e-10 * rate * mass):
        raise InputError(
            "stiffness must not be negative in any direction: it has an eigenvalue below zero; "
            "give the structure without its joints, and without negative springs"
        )


def fastest_rate(stiffness: Any, mass: Any) -> float:
    """Return an estimate of the largest eigenvalue of K x = lambda M x [rad^2/s^2]."""
    with np.errstate(over="ignore"):
        rate = float((abs(stiffness).sum(axis=0) / mass.diagonal()).max())
    if not np.isfinite(rate):
        raise InputError(
            "stiffness over mass must be finite: the entries differ by too many orders of magnitude"
        )
    return rate


def factorised(matrix: Any, pivot_threshold: float | None = None) -> Any:
    """Return the LU factors of a sparse symmetric matrix, an object with the method ``solve``."""
    from scipy.sparse.linalg import splu

    return splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=pivot_threshold,
        options={"SymmetricMode": True},
    )


def solve_linear(matrix: Any, right: Floats) -> Floats:
    """Return the solution (n, columns) of linear equations with a dense or sparse matrix."""
    if is_sparse(matrix):
        return np.asarray(factorised(matrix, 0.01).solve(np.ascontiguousarray(right)))
    return np.asarray(np.linalg.solve(matrix, right))


def with_springs(stiffness: Any, columns: Any, springs: Floats) -> Any:
    """Return the stiffness with springs [N/m] along ``columns``, K + B diag(k) B^T."""
    if is_sparse(stiffness):
        from scipy.sparse import csc_matrix, diags

        sides = csc_matrix(columns)
        return (stiffness + sides @ diags(springs) @ sides.T).tocsc()
    return stiffness + (columns * springs) @ columns.T


def positive_definite(matrix: Any) -> bool:
    """Return whether all eigenvalues of a symmetric matrix are above zero."""
    if is_sparse(matrix):
        try:
            # Without pivoting the signs of the pivots are those of the eigenvalues.
            factors = factorised(matrix, 0.0)
        except RuntimeError:
            return False
        return bool((factors.U.diagonal() > 0.0).all())
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return True


def vector(name: str, value: ArrayLike, size: int) -> Floats:
    """Validate a vector with one number per degree of freedom."""
    array = floats(name, value)
    if array.shape != (size,):
        raise InputError(f"`{name}` must have the shape ({size},), got {array.shape}")
    return array


def direction_matrix(name: str, value: Any, size: int, last: Sequence[int] = ()) -> Any:
    """Validate directions of shape (size, joints), or (size, nodes, k) with k in ``last``."""
    array = floats(name, value.toarray() if is_sparse(value) else value)
    expected = f"({size},) or ({size}, columns)"
    if last:
        expected = f"({size}, nodes, {last[0]}), or ({size}, nodes, {last[1]}) in a plane"
    came = array.shape
    if array.ndim == 1 and not last:
        array = array[:, None]
    fits = array.ndim == 3 and array.shape[2] in last if last else array.ndim == 2
    if not fits or array.shape[0] != size:
        raise InputError(
            f"{name} must have the shape {expected}, one row for each degree of freedom, got {came}"
        )
    idle = np.flatnonzero(~np.any(array.reshape(size, -1), axis=0))
    if idle.size:
        column = np.unravel_index(int(idle[0]), array.shape[1:])
        raise InputError(
            f"{name} must have a nonzero number in each column, and column "
            f"{show(tuple(int(i) for i in column))} is all zeros"
        )
    return lock(np.array(array))


def linear_modes(stiffness: Any, mass: Any, count: int | None = None) -> tuple[Floats, Floats]:
    """Return squared angular frequencies, increasing, and shapes of modal mass 1 kg."""
    size = mass.shape[0]
    if is_sparse(mass) or is_sparse(stiffness):
        if size > LARGEST_DENSE and count is not None and count < size - 1:
            return _few_modes(stiffness, mass, count)
        mass, stiffness = dense(mass), dense(stiffness)
    from scipy.linalg import eigh

    subset = None if count is None or count >= size else (0, count - 1)
    squares, shapes = eigh(stiffness, mass, subset_by_index=subset, check_finite=False)
    return squares, shapes


def _few_modes(stiffness: Any, mass: Any, count: int) -> tuple[Floats, Floats]:
    from scipy.sparse.linalg import LinearOperator, eigsh

    # A small shift below zero, that rigid modes do not make the matrix singular.
    shift = -1e-10 * fastest_rate(stiffness, mass)
    factors = factorised(stiffness - shift * mass, 0.01)
    solve = LinearOperator(stiffness.shape, matvec=factors.solve, dtype=float)
    start = np.cos(np.arange(mass.shape[0], dtype=float))  # the same each time
    squares, shapes = eigsh(stiffness, count, M=mass, sigma=shift, OPinv=solve, v0=start, tol=1e-12)
    order = np.argsort(squares)
    return squares[order], shapes[:, order]


def dense(matrix: Any) -> Floats:
    """Convert a matrix to a dense array."""
    return np.asarray(matrix.toarray() if is_sparse(matrix) else matrix)


def least_square(stiffness: Any, mass: Any) -> float:
    """Return the squared angular frequency [rad^2/s^2] below which a mode is a rigid motion."""
    return fastest_rate(stiffness, mass) * float(50.0 * mass.shape[0] * 2.3e-16)


def rigid_count(squares: Floats, stiffness: Any, mass: Any) -> int:
    """Return the number of ``squares`` [rad^2/s^2] that are zero up to rounding."""
    return int(np.count_nonzero(squares <= least_square(stiffness, mass)))
