"""Fourier basis of displacements and forces of a cycle, and checks of Fourier coefficients."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, is_whole, rising_orders, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock

_MOST_SAMPLES = 1 << 20
MOST_ORDERS = 200  # highest harmonic in the kernel if many are given: work grows with its square
_MOST_FEW_ORDERS = 5000  # if few are given: work is linear in the highest one
_ALL_ORDERS = np.zeros(0)


class Basis:
    """Basis functions [1,] cos(n t), sin(n t) of given harmonics n, in increasing order."""

    def __new__(cls, harmonics: Any) -> Basis:
        """Return the basis of given harmonics; equal harmonics share one object."""
        if isinstance(harmonics, tuple) and all(type(n) is int for n in harmonics):
            return _basis(harmonics)
        return _basis(tuple(rising_orders("harmonics", harmonics)))

    def _fill(self, harmonics: tuple[int, ...]) -> None:
        self.orders = list(rising_orders("harmonics", harmonics))
        if not self.orders:
            raise InputError("`harmonics` must not be empty, got none; write harmonics=[0, 1, 3]")
        self.columns = [k for n in self.orders for k in ((2 * n - 1, 2 * n) if n else (0,))]
        self.is_dense = self.columns == list(range(2 * self.orders[-1] + 1))
        self.has_mean = self.orders[0] == 0
        turning = [n for n in self.orders if n]
        self._n = np.repeat(np.array(turning, dtype=float), 2)
        self._phase = np.tile([0.0, -0.5 * math.pi], len(turning))
        self.size = self._n.size + self.has_mean
        # With few harmonics, products of two functions are fewer than all orders up to twice the
        # highest one.
        count = 2 * len(turning) + 1
        self.is_sparse = count * (count + 1) // 2 < 4 * self.orders[-1] + 1

    def values(self, t: Floats, derivative: int = 0) -> Floats:
        """Return the basis functions, or a derivative (order 1 or 2); rows are phases t [rad]."""
        angle = t[:, None] * self._n
        even, odd = np.cos(angle[:, ::2]), np.sin(angle[:, ::2])
        waves = np.empty((t.size, self._n.size))
        if derivative % 2:
            waves[:, ::2], waves[:, 1::2] = -odd, even
        else:
            waves[:, ::2], waves[:, 1::2] = even, odd
        if derivative:
            waves *= self._n if derivative == 1 else -self._n * self._n
        if not self.has_mean:
            return waves
        mean = np.zeros((t.size, 1)) if derivative else np.ones((t.size, 1))
        return np.hstack((mean, waves))

    @property
    def factors(self) -> Floats:
        """Fourier coefficients over the integrals of basis function times force in a period."""
        result = np.full(self.size, 1.0 / math.pi)
        if self.has_mean:
            result[0] = 0.5 / math.pi
        return result

    def sampled(self, samples: Any) -> tuple[Floats, Floats]:
        """Return matrices W and A of shape (samples, size), for equidistant samples of a period.

        Samples are W @ coefficients, and coefficients are samples @ A.
        """
        fewest = 2 * self.orders[-1] + 1
        if not is_whole(samples) or not fewest <= samples <= _MOST_SAMPLES:
            raise InputError(
                f"`samples` must be a whole number from {fewest}, for harmonic {self.orders[-1]}, "
                f"to {_MOST_SAMPLES}, got {show(samples)}"
            )
        return _sampled(tuple(self.orders), int(samples))

    @property
    def in_kernel(self) -> bool:
        """True if the compiled kernels can integrate up to the highest harmonic of the basis."""
        return self.orders[-1] <= (_MOST_FEW_ORDERS if self.is_sparse else MOST_ORDERS)

    def integrated(
        self, rows: Floats, begin: Floats | float, tolerance: float, kernel: Any, *line: Any
    ) -> tuple[Floats, Floats]:
        """Compute Fourier coefficients of forces and their Jacobians with a compiled kernel.

        ``rows`` are displacement coefficients [m], shape (joints, size), and ``begin``
        displacements at rest [m], one or one per joint. ``tolerance`` is relative to the largest
        force. ``line`` are further arguments of ``kernel``: the tables and factors of the law.
        """
        orders = _ALL_ORDERS
        if self.is_sparse:
            first = 0 if self.has_mean else 1
            columns = list(range(first, first + self.size))
            full = np.zeros((len(rows), first + self.size))
            full[:, first:], orders = rows, self._n[::2].copy()
        else:
            full, columns = self.dense(rows)
        full[:, 0] -= begin
        force, jacobian = np.empty(full.shape), np.empty((*full.shape, full.shape[1]))
        if kernel(full, *full.shape, tolerance, force, jacobian, orders, *line):
            raise tolerance_error(tolerance)
        if len(columns) == full.shape[1]:
            return force, jacobian
        return force[:, columns], jacobian[:, columns][:, :, columns]

    def dense(self, rows: Floats) -> tuple[Floats, list[int]]:
        """Return coefficients of all harmonics up to the highest one, and their column indices.

        The coefficients are ``rows`` (joints, size), with zeros for harmonics that the basis lacks.
        The indices are those of the columns of ``rows`` in the result.
        """
        if self.is_dense:
            return np.array(rows, dtype=float, order="C"), self.columns
        dense = np.zeros((len(rows), 2 * self.orders[-1] + 1))
        dense[:, self.columns] = rows
        return dense, self.columns


@lru_cache(maxsize=64)
def _basis(harmonics: tuple[int, ...]) -> Basis:
    basis = object.__new__(Basis)
    basis._fill(harmonics)
    return basis


def tolerance_error(tolerance: float) -> InputError:
    """Return the exception for a tolerance not reached on a load curve with many corners."""
    return InputError(
        f"`rtol` must be larger for this law, whose load curve has too many corners for "
        f"{tolerance:g}; write rtol={100.0 * tolerance:g}"
    )


@lru_cache(maxsize=32)
def _sampled(orders: tuple[int, ...], samples: int) -> tuple[Floats, Floats]:
    basis = Basis(list(orders))
    functions = np.ascontiguousarray(basis.values(2.0 * math.pi * np.arange(samples) / samples))
    analysis = np.ascontiguousarray(functions * (basis.factors * (2.0 * math.pi / samples)))
    return lock(functions), lock(analysis)


def coefficients_of(
    name: str, coefficients: ArrayLike, basis: Basis, nodes: int | None = None
) -> Floats:
    """Check and return Fourier coefficients, shape (size,), with the size of the basis.

    With ``nodes``, (nodes, size) is accepted too, and is the shape of the result.
    """
    values = floats(name, coefficients, "m")
    if nodes is not None:
        if values.shape not in ((basis.size,), (nodes, basis.size)):
            raise InputError(
                f"`{name}` must have the shape ({nodes}, {basis.size}), a row for each node "
                f"in the order of the harmonics, or ({basis.size},) for equal rows, "
                f"got {values.shape}"
            )
        return np.broadcast_to(values, (nodes, basis.size))
    if values.shape != (basis.size,):
        raise InputError(
            f"`{name}` must hold {basis.size} numbers, [mean,] cosine and sine of each harmonic of "
            f"{basis.orders}, got shape {values.shape}"
        )
    return values
