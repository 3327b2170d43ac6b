"""The nodes of a field: what cycles ask of them, and what is given, one number a node."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from microslip._core.checks import LARGEST, SMALLEST, Floats, exact, floats, positive
from microslip.errors import InputError
from microslip.friction.field_curve import FieldCurve
from microslip.memory.field_state import Nodes
from microslip.normal.base import NormalLaw


class FieldNodes(Nodes, Protocol):
    """Nodes on one load curve, with their cycles; steps are separations from its origin."""

    @property
    def separations(self) -> Floats:
        """Separations at rest [m]."""

    @property
    def normal_loads(self) -> Floats:
        """Normal loads at rest [N]."""

    @property
    def _curve(self) -> FieldCurve:
        """The load curve."""

    def _check_separations(self, separations: Floats) -> Floats:
        """Separations that the surface has an answer for."""


def at(node: int) -> str:
    """Where something is wrong."""
    return f" at node {node}"


def nodes_of(values: dict[str, Any]) -> dict[str, Floats]:
    """Arrays of one length, one number a node."""
    arrays = {name: floats(name, value) for name, value in values.items()}
    for name, array in arrays.items():
        if array.ndim > 1:
            raise InputError(f"`{name}` must be one-dimensional, got shape {array.shape}")
    lengths = {name: array.size for name, array in arrays.items() if array.ndim}
    size = max(lengths.values(), default=1)
    if any(length != size for length in lengths.values()):
        came = ", ".join(f"{length} {name}" for name, length in lengths.items())
        raise InputError(f"`all` must be of one length, one a node, or one number, got {came}")
    return {
        name: np.array(np.broadcast_to(array.reshape(-1), (size,)), order="C")
        for name, array in arrays.items()
    }


def check_positive(name: str, unit: str, values: Floats) -> None:
    """Each number is above zero, and of a size that a joint can have."""
    off = (values <= 0.0) | (values < SMALLEST) | (values > LARGEST)
    if off.any():
        i = int(np.argmax(off))
        bounds = "above zero" if values[i] <= 0.0 else f"between {SMALLEST:g} and {LARGEST:g}"
        raise InputError(f"`{name}` must be {bounds}{unit}, got {exact(values[i])}{at(i)}")


def area_of(surface: NormalLaw, area: float | None) -> float:
    """The apparent area [m^2] that a load of the surface is for: as given, or its own."""
    if area is not None:
        return positive("surface_area", area, "m^2", 2e-4)
    surface_area = getattr(surface, "area", None)
    if surface_area is None:
        raise InputError(
            f"`surface_area` must be given: the law of a {type(surface).__name__} does not "
            "tell which apparent area it stands for; write surface_area=2e-4 [m^2]"
        )
    return positive("surface_area", surface_area, "m^2")
