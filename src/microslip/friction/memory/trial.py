"""Result of a trial step, with the tangents for Newton's method."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError

if TYPE_CHECKING:
    from microslip.contact.load_curve import LoadCurve


class Trial(tuple[float, float]):
    """End of a trial step, which unpacks as ``force, stiffness``.

    Returned by :meth:`microslip.State.try_`. The step is straight in separation and displacement
    from the committed state (Jaeger 1998, DOI 10.1115/1.2833765). The tangents are derivatives at
    its end, as needed by Newton's method.
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
        """Tangent stiffness dT/d(displacement) [N/m] at constant normal load."""
        return self[1]

    @property
    def displacement(self) -> float:
        """Displacement [m]."""
        return self._displacement

    @property
    def separation(self) -> float:
        """Separation [m], for an interface only."""
        return self._curve_for("separation").origin + self._step

    @property
    def normal_load(self) -> float:
        """Normal load [N], for an interface only."""
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

    def _by_separation(self, name: str) -> tuple[float, float]:
        """Return -dN/dd and dT/dd [N/m], with separation d; errors name the attribute ``name``."""
        curve = self._curve_for(name)
        fall = -curve.derivative_at(self._step, 1)
        # mu s [N'(d) - N'(q)] for a slipping front q; the mean decrease for sticking.
        return fall, -self._density * (curve.friction * fall - curve.slip * self[1])

    def _curve_for(self, name: str) -> LoadCurve:
        if self._curve is None:
            raise InputError(f"`{name}` has no meaning for a law without a surface")
        return self._curve

    def __repr__(self) -> str:
        return f"Trial(force={self[0]:g}, stiffness={self[1]:g})"
