"""Nodes on a common load curve, and checks of their displacements, separations and loads."""

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
    """Joints that share a load curve, one entry per joint in each array.

    Displacements and separations are converted to the variables of the load curve, both in [m]. A
    place is a displacement divided by ``slips``. A step is a difference of separations divided by
    ``lengths``: a step from the origin is relative to the separation ``origins`` of the joint, at
    which the argument of the load curve is 0; a step from rest is relative to that at rest.
    """

    curve: LoadCurve
    weights: Floats
    """Force limit mu N of a node over the load of the curve at the same step [-]."""
    scales: Floats
    """Normal load N of a node over the load of the curve at the same step [-]."""
    slips: Floats
    """Displacement over place [-]: the slip per indentation kappa times ``lengths``."""
    rests: Floats
    """Steps from the origin at rest [m]."""
    origins: Floats | None = None
    """Separations [m] at step 0 from the origin; None if all are ``curve.origin``."""
    lengths: Floats | None = None
    """Separation difference over step [-]; None if all are 1, as for the law of the surface."""

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.rests.size

    @cached_property
    def nearest(self) -> float:
        """Smallest separation [m] that is certainly in the range of the surface."""
        return max(self.curve.surface._deepest, self.curve.surface._span[0])

    def per_node(self, name: str, value: ArrayLike, unit: str) -> Floats:
        """Return a number or array, plain or with a unit, as one value per node in ``unit``."""
        return along(name, value, self.size, unit, "nodes")

    def steps_at(self, name: str, separations: ArrayLike) -> Floats:
        """Check separations [m], a number or one per node; return steps from the origin [m]."""
        return self.steps_of(self.per_node(name, separations, "m"))

    def steps_of(self, separations: Floats) -> Floats:
        """Check separations [m], nodes on the first axis; return steps from the origin [m]."""
        separations = self.checked(separations)
        if self.origins is None:
            return separations - self.curve.origin
        origins = self.origins.reshape(-1, *[1] * (separations.ndim - 1))
        return self.per_length(separations - origins)

    def separations_of(self, steps: Floats) -> Floats:
        """Convert steps from the origin of the curve [m], one per node, to separations [m]."""
        if self.origins is None or self.lengths is None:
            return self.curve.origin + steps
        return self.origins + self.lengths * steps

    def per_length(self, values: Floats) -> Floats:
        """Convert d/d(step) to d/d(separation), for values with nodes on the first axis."""
        if self.lengths is None:
            return values
        return np.asarray(values / self.lengths.reshape(-1, *[1] * (values.ndim - 1)))

    def checked(self, separations: Floats) -> Floats:
        """Check that separations, with nodes on the first axis, are in the range of the surface."""
        return checked_separations(self.curve.surface, separations)

    def reach(self, *steps: Floats | None) -> tuple[float, float]:
        """Convert steps from rest to steps from the origin [m]; return the smallest and largest."""
        moved = [s + self.rests.reshape(-1, *[1] * (s.ndim - 1)) for s in steps if s is not None]
        low = min(float(s.min()) for s in [self.rests, *moved])
        # A shared curve extends to zero load.
        high = low if self.curve.shared else max(float(s.max()) for s in [self.rests, *moved])
        return low, high


def checked_separations(surface: NormalLaw, separations: Floats) -> Floats:
    """Check that separations are in the range of a surface; errors name the node."""
    try:
        return surface._separations(separations)
    except InputError as error:
        node = np.unravel_index(np.argmin(separations), separations.shape)[0]
        where = f" at node {node}" if len(separations) > 1 else ""
        raise InputError(error.text + where) from None


def along(name: str, numbers: ArrayLike, size: int, unit: str, kind: str = "samples") -> Floats:
    """Check a number or ``size`` values, one per sample or node; return shape (size,)."""
    values = floats(name, numbers, unit)
    if values.shape == (size,):
        return values
    if values.ndim > 1 or values.size not in (1, size):
        raise InputError(
            f"`{name}` must be one number or one for each of the {size} {kind}, got shape "
            f"{values.shape}"
        )
    return np.ascontiguousarray(np.broadcast_to(values.reshape(-1), (size,)))


def steps_along(
    curve: LoadCurve, size: int, normal_load: ArrayLike | None, separation: ArrayLike | None
) -> Floats:
    """Return separations from the origin of a curve [m] for given loads or separations."""
    if separation is not None:
        return curve.steps_at(along("separation", separation, size, "m"))
    loads = along("normal_load", normal_load, size, "N")  # type: ignore[arg-type]
    several = np.ndim(normal_load) > 0  # type: ignore[arg-type]
    if loads.min() < 0.0:
        i = int(np.argmax(loads < 0.0))
        where = f" at sample {i}" if several else ""
        raise InputError(f"`normal_load` must not be negative [N], got {exact(loads[i])}{where}")
    return curve.steps_of(loads, numbered=several)
