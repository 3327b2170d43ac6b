"""A structure at rest under its static forces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip.structures.joint_groups import Attachment, FieldAttachment
from microslip.structures.modal_model import ModalModel, modal_model


@dataclass(frozen=True, eq=False, repr=False)
class AtRest:
    """Matrices and joints of a structure, and where its static forces hold it."""

    mass: Any
    stiffness: Any
    damping: Any
    attachments: tuple[Attachment, ...]
    static_force: Floats
    """Forces [N] that were given."""
    displacement: Floats
    """Static displacements (n,) [m]."""
    equilibrium_error: float
    """Largest unbalanced force over the largest force [-]."""
    iterations: int
    """Steps of Newton's method."""

    # -- the static state -------------------------------------------------------------------------

    @property
    def message(self) -> str:
        """Result in a sentence."""
        return (
            f"at rest after {self.iterations} steps, {self.equilibrium_error:.1e} of the largest "
            "force unbalanced"
        )

    @cached_property
    def _motions(self) -> list[Floats]:
        return [a.columns.T @ self.displacement for a in self.attachments]

    def _by_node(self, measure: Any) -> Floats:
        parts = [
            measure(a, u)
            for a, u in zip(self.attachments, self._motions, strict=True)
            if isinstance(a, FieldAttachment)
        ]
        return lock(np.concatenate([*parts, np.zeros(0)]))

    @cached_property
    def gaps(self) -> Floats:
        """Separations of the nodes of all fields at rest [m], measured as their surface's are."""
        return self._by_node(lambda a, u: a.separations(u))

    @cached_property
    def normal_loads(self) -> Floats:
        """Normal loads of the nodes of all fields [N]."""
        return self._by_node(lambda a, u: a.loads(u))

    @cached_property
    def pressures(self) -> Floats:
        """Mean pressures of the nodes of all fields [Pa]."""
        return lock(self.normal_loads / self._by_node(lambda a, _: a.areas))

    @cached_property
    def model(self) -> ModalModel:
        """The structure in the modes it has while all joints stick."""
        return modal_model(self.mass, self.stiffness, self.damping, self.attachments, self._motions)
