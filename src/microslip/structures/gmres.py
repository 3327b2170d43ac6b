"""Linear systems that are known by their product with a vector."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from microslip._core.checks import Floats


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
