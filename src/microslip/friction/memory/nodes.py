"""Joints on one load curve, with their records and cycles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats
from microslip._core.errors import InputError

if TYPE_CHECKING:
    from microslip.contact.base import NormalLaw
    from microslip.contact.load_curve import LoadCurve


@dataclass(frozen=True, eq=False)
class Nodes:
    """Joints that share a load curve, one entry a joint in each array; one joint is one node.

    Places are displacements over ``slips``; steps are separations, from the origin of the curve or
    from those at rest, over ``lengths``.
    """

    curve: LoadCurve
    weights: Floats
    """Tangential force of a node over the one of the curve, mu included."""
    scales: Floats
    """Normal load of a node over that of the curve."""
    slips: Floats
    """Displacement per place, kappa times the length."""
    rests: Floats
    """Steps at rest from the origin of the curve."""
    origins: Floats | None = None
    """Separations [m] of step zero, one a node; None is the origin of the curve."""
    lengths: Floats | None = None
    """Separation per step [-], beside origins: 1 where a node has the law of the surface."""

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.rests.size

    @cached_property
    def stiffness_scales(self) -> Floats:
        """Tangential stiffness of a node over that of the curve [1/m]."""
        return self.weights / self.slips

    def per_node(self, name: str, value: ArrayLike, unit: str) -> Floats:
        """Validate numbers, one a node or one for all; convert quantities to ``unit``."""
        return along(name, value, self.size, unit, "nodes")

    def steps_at(self, name: str, separations: ArrayLike) -> Floats:
        """Steps from the origin of separations [m], one a node or one for all, checked."""
        return self.steps_of(self.per_node(name, separations, "m"))

    def steps_of(self, separations: Floats) -> Floats:
        """Steps of separations [m], nodes along the first axis, checked."""
        separations = self.checked(separations)
        if self.origins is None:
            return separations - self.curve.origin
        origins = self.origins.reshape(-1, *[1] * (separations.ndim - 1))
        return self.per_length(separations - origins)

    def separations_of(self, steps: Floats) -> Floats:
        """Separations [m] of steps from the origin, one a node."""
        if self.origins is None or self.lengths is None:
            return self.curve.origin + steps
        return self.origins + self.lengths * steps

    def per_length(self, values: Floats) -> Floats:
        """Values over the lengths of their nodes, which are along the first axis."""
        if self.lengths is None:
            return values
        return np.asarray(values / self.lengths.reshape(-1, *[1] * (values.ndim - 1)))

    def checked(self, separations: Floats) -> Floats:
        """Separations for which the surface has an answer, nodes along the first axis."""
        return checked_separations(self.curve.surface, separations)

    def reach(self, *steps: Floats | None) -> tuple[float, float]:
        """Least and largest step of the curve for steps from rest, nodes along the first axis."""
        moved = [s + self.rests.reshape(-1, *[1] * (s.ndim - 1)) for s in steps if s is not None]
        low = min(float(s.min()) for s in [self.rests, *moved])
        # A curve that is shared goes as far out as there is any load.
        high = low if self.curve.shared else max(float(s.max()) for s in [self.rests, *moved])
        return low, high


def checked_separations(surface: NormalLaw, separations: Floats) -> Floats:
    """Separations for which a surface has an answer; what is refused says at which node."""
    try:
        return surface._separations(separations)
    except InputError as error:
        node = np.unravel_index(np.argmin(separations), separations.shape)[0]
        where = f" at node {node}" if len(separations) > 1 else ""
        raise InputError(error.text + where) from None


def along(name: str, numbers: ArrayLike, size: int, unit: str, kind: str = "samples") -> Floats:
    """Validate numbers along ``size`` samples or nodes: one for each, or one for all."""
    values = floats(name, numbers, unit)
    if values.shape == (size,):
        return values
    if values.ndim > 1 or values.size not in (1, size):
        raise InputError(
            f"`{name}` must be one number or one for each of the {size} {kind}, got shape "
            f"{values.shape}"
        )
    return np.ascontiguousarray(np.broadcast_to(values.reshape(-1), (size,)))


def loads_along(name: str, loads: ArrayLike, size: int) -> Floats:
    """Normal loads [N] >= 0 of a record of ``size`` samples: one for each, or one for all."""
    values = along(name, loads, size, "N")
    if values.min() < 0.0:
        i = int(np.argmax(values < 0.0))
        where = f" at sample {i}" if np.ndim(loads) else ""
        raise InputError(f"`{name}` must not be negative [N], got {exact(values[i])}{where}")
    return values


def steps_along(
    curve: LoadCurve, size: int, normal_load: ArrayLike | None, separation: ArrayLike | None
) -> Floats:
    """Steps of a curve along a record, of which one of loads [N] and separations [m] is given."""
    if separation is not None:
        return curve.steps_at(along("separation", separation, size, "m"))
    loads = loads_along("normal_load", normal_load, size)  # type: ignore[arg-type]
    return curve.steps_of(loads, numbered=np.ndim(normal_load) > 0)  # type: ignore[arg-type]
