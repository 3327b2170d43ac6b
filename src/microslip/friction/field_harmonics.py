"""The Fourier coefficients of the settled forces of many nodes, as a named result."""

from __future__ import annotations

from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

Bools: TypeAlias = NDArray[np.bool_]


class FieldHarmonics(tuple[Floats, ...]):
    """Fourier coefficients of the settled forces of nodes, with their Jacobians.

    It unpacks as ``force, jacobian`` where separations were not given, else as ``force, load,
    jacobian``. Between turning points the forces follow Jaeger (1998), DOI 10.1115/1.2833765.
    """

    force: Floats
    """Coefficients of the tangential forces [N], shape (nodes, coefficients), in two directions
    (nodes, 2, coefficients)."""
    load: Floats | None
    """Coefficients of the normal loads [N], (nodes, coefficients); None at held separations."""
    jacobian: Floats
    """Derivatives [N/m] of the coefficients of the forces by those of the displacements, see the
    method for the shape."""
    residual: Floats
    """Estimated distance of each node's force from that of the limit cycle [N], shape (nodes,).

    In one direction the cycle is known exactly: 0.
    """
    converged: Bools
    """Whether the residual of each node is within the tolerance, shape (nodes,)."""

    def __new__(
        cls,
        force: Floats,
        load: Floats | None,
        jacobian: Floats,
        residual: Floats | None = None,
        converged: Bools | None = None,
    ) -> Self:
        """Without a residual all nodes have converged."""
        parts = (force, jacobian) if load is None else (force, load, jacobian)
        found = super().__new__(cls, parts)
        found.force, found.load, found.jacobian = force, load, jacobian
        found.residual = np.zeros(len(force)) if residual is None else residual
        found.converged = np.ones(len(force), dtype=bool) if converged is None else converged
        return found
