"""Fourier coefficients of the forces of many nodes, with Jacobians, for harmonic balance."""

from __future__ import annotations

from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

Bools: TypeAlias = NDArray[np.bool_]


class FieldHarmonics(tuple[Floats, ...]):
    """Fourier coefficients of the settled forces of nodes, with their Jacobians.

    Unpacks as ``force, jacobian`` for constant separations, otherwise as ``force, load, jacobian``.
    Forces follow Jaeger (1998), DOI 10.1115/1.2833765.
    """

    force: Floats
    """Coefficients of the tangential forces [N], shape (nodes, coefficients), or
    (nodes, 2, coefficients) for two directions."""
    load: Floats | None
    """Coefficients of the normal loads [N], (nodes, coefficients); None at constant separations."""
    jacobian: Floats
    """Derivatives [N/m] of force coefficients with respect to displacement coefficients; the
    method that returns this result describes the shape."""
    residual: Floats
    """Estimated error of the force of each node [N], shape (nodes,): in two directions its distance
    from the limit cycle, under varying separations the error of the integration; 0 at constant
    separations, where only rounding occurs, and NaN for sampled cycles, whose error is unknown."""
    converged: Bools
    """True for each node whose residual is within the tolerance or unknown, shape (nodes,)."""

    def __new__(
        cls,
        force: Floats,
        load: Floats | None,
        jacobian: Floats,
        residual: Floats | None = None,
        converged: Bools | None = None,
    ) -> Self:
        """Create the result; if ``residual`` is None, it is 0 and all nodes have converged."""
        parts = (force, jacobian) if load is None else (force, load, jacobian)
        found = super().__new__(cls, parts)
        found.force, found.load, found.jacobian = force, load, jacobian
        found.residual = np.zeros(len(force)) if residual is None else residual
        found.converged = np.ones(len(force), dtype=bool) if converged is None else converged
        return found
