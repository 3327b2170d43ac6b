"""What cycles and states ask of the nodes of a field."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip.friction.field_curve import FieldCurve


class FieldNodes(Protocol):
    """Nodes on one load curve; steps are separations from its origin."""

    @property
    def size(self) -> int:
        """Number of nodes."""

    @property
    def separations(self) -> Floats:
        """Separations at rest [m]."""

    @property
    def normal_loads(self) -> Floats:
        """Normal loads at rest [N]."""

    @property
    def _weights(self) -> Floats:
        """What N of the surface is times for the force of gross slip."""

    @property
    def _scale(self) -> Floats:
        """What it is times for the load of a node."""

    @property
    def _slip(self) -> Floats:
        """Displacement per separation, kappa."""

    @property
    def _steps(self) -> Floats:
        """Separations at rest from the origin."""

    @property
    def _curve(self) -> FieldCurve:
        """The load curve."""

    def _each(self, name: str, value: Any) -> Floats:
        """One number a node."""

    def _step_array(self, separations: ArrayLike) -> Floats:
        """Separations, one a node, from the origin."""

    def _check_separations(self, separations: Floats) -> Floats:
        """Separations that the surface has an answer for."""
