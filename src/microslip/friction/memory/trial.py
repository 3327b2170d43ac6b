"""The result of a trial of a state, as Newton's method needs it from a contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError

if TYPE_CHECKING:
    from microslip.contact.load_curve import LoadCurve


class Trial(tuple[float, float]):
    """The end of a trial step, which unpacks as ``force, stiffness``.

    Made by :meth:`microslip.State.try_`. The tangents are those of the step, straight in separation
    and displacement, as it ends (Jaeger 1998, DOI 10.1115/1.2833765): what Newton's method needs.
    """

    _displacement: float
    _density: float
    _curve: LoadCurve | None
    _step: float
    _normal_load: float | None

    @classmethod
    def _of(
        cls,
        force: float,
        stiffness: float,
        displacement: float,
        density: float,
        curve: LoadCurve | None,
        step: float = 0.0,
        normal_load: float | None = None,
    ) -> Trial:
        """A trial whose last contact has the D ``density``."""
        trial = cls((force, stiffness))
        trial._displacement, trial._density, trial._curve = displacement, density, curve
        trial._step, trial._normal_load = step, normal_load
        return trial

    @property
    def force(self) -> float:
        """Tangential force [N]."""
        return self[0]

    @property
    def stiffness(self) -> float:
        """Tangent stiffness [N/m] at this load: dT/d(displacement)."""
        return self[1]

    @property
    def displacement(self) -> float:
        """Displacement [m]."""
        return self._displacement

    @property
    def separation(self) -> float:
        """Separation [m]; only an interface has one."""
        return self._curve_for("separation").origin + self._step

    @property
    def normal_load(self) -> float:
        """Normal load [N]; only an interface has one."""
        curve = self._curve_for("normal_load")
        return (
            curve.derivative_at(self._step, 0) if self._normal_load is None else self._normal_load
        )

    load = normal_load

    @property
    def tangent(self) -> Floats:
        """d(force, normal_load)/d(displacement, separation) [N/m], shape (2, 2)."""
        fall, by_separation = self._by_separation("tangent")
        return np.array([[self[1], by_separation], [0.0, -fall]])

    @property
    def tangent_by_load(self) -> Floats:
        """d(force, normal_load)/d(displacement, normal_load), [N/m] and [-], shape (2, 2).

        Where there is no contact the force does not change with the load to first order: 0.
        """
        fall, by_separation = self._by_separation("tangent_by_load")
        return np.array([[self[1], by_separation / -fall if fall > 0.0 else 0.0], [0.0, 1.0]])

    def _by_separation(self, name: str) -> tuple[float, float]:
        """-N' [N/m], and the derivative of the force by the separation."""
        curve = self._curve_for(name)
        fall = -curve.derivative_at(self._step, 1)
        # mu s [N'(d) - N'(q)] where the front q slipped; with the mean fall where it stuck.
        return fall, -self._density * (curve.friction * fall - curve.slip * self[1])

    def _curve_for(self, name: str) -> LoadCurve:
        if self._curve is None:
            raise InputError(f"{name} has no meaning for this law: it has no surface")
        return self._curve

    def __repr__(self) -> str:
        return f"Trial(force={self[0]:g}, stiffness={self[1]:g})"
