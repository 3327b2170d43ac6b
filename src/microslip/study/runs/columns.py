"""Results of one joint as columns: cyclic quantities and histories."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock
from microslip.friction import Interface
from microslip.friction.energies import dissipated_along


@dataclass(frozen=True, eq=False, repr=False)
class ResultColumns(Locked):
    """Base class: attributes are arrays of equal length, or None if the quantity is unknown."""

    def __post_init__(self) -> None:
        for array in self.columns().values():
            lock(array)

    def columns(self) -> dict[str, Floats]:
        """Return the arrays by name, without unknown quantities."""
        named = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: array for name, array in named.items() if isinstance(array, np.ndarray)}

    def __repr__(self) -> str:
        columns = self.columns()
        size = len(next(iter(columns.values())))
        return f"{type(self).__name__}({size} of {', '.join(columns)})"


_BY_METHOD = (
    "dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio", "secant_stiffness",
    "dissipation_exponent",
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class AmplitudeCurve(ResultColumns):
    """Cyclic quantities of one joint against the displacement amplitude, as equal-length arrays.

    `force_ratio` is the force amplitude over the force limit, `tangent_stiffness` the slope
    :meth:`~microslip.Interface.backbone_stiffness` of the first loading curve, `slider_density` the
    second derivative -T'' of the force T of first loading [N/m^2], see
    :class:`~microslip.friction.Sliders`, and `stick_share` the stick area over the real contact
    area. `stick_area` and `stick_share` are None for normal laws without individual contacts. The
    other quantities are those of the methods of :class:`microslip.Interface` with the same name.
    """

    amplitude: Floats
    force_amplitude: Floats
    force_ratio: Floats
    dissipated_energy: Floats
    energy_ratio: Floats
    loss_factor: Floats
    damping_ratio: Floats
    secant_stiffness: Floats
    tangent_stiffness: Floats
    dissipation_exponent: Floats
    slider_density: Floats
    stick_area: Floats | None
    stick_share: Floats | None

    @classmethod
    def of(cls, joint: Interface, amplitude: Floats, force: Floats | None = None) -> AmplitudeCurve:
        """Return the quantities of a joint at displacement amplitudes [m] and their forces [N]."""
        if force is None:
            force = np.asarray(joint.backbone(amplitude))
        contact = getattr(joint, "contact_area", None)  # a friction law from a file has none
        stick = None if contact is None else np.asarray(joint.stick_area(amplitude))
        return cls(
            amplitude=amplitude.copy(),
            force_amplitude=force.copy(),
            force_ratio=force / joint.force_limit,
            tangent_stiffness=np.asarray(joint.backbone_stiffness(amplitude)),
            **{name: np.asarray(getattr(joint, name)(amplitude)) for name in _BY_METHOD},
            slider_density=np.asarray(joint.sliders().density(amplitude)),
            stick_area=stick,
            stick_share=None if stick is None else stick / contact,
        )


@dataclass(frozen=True, eq=False, repr=False)
class HistoryResponse(ResultColumns):
    """Response of one joint to the history of the study, from rest, as equal-length arrays.

    Parameters
    ----------
    displacement : ndarray
        Displacements [m], given or computed.
    force : ndarray
        Forces [N], given or computed.
    dissipated_energy : ndarray
        Energy dissipated since rest [J].
    """

    displacement: Floats
    force: Floats
    dissipated_energy: Floats

    @classmethod
    def of(
        cls,
        joint: Interface,
        values: Floats,
        quantity: Literal["displacement", "force"],
    ) -> HistoryResponse:
        """Return the response of a joint to displacements [m] or forces [N]."""
        if quantity == "displacement":
            displacement, force = values.copy(), np.asarray(joint.force(values))
        else:
            displacement, force = np.asarray(joint.displacement(values)), values.copy()
        return cls(displacement, force, dissipated_along(joint, displacement, values))
