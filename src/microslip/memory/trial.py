"""The result of a trial of a state: all that Newton's method asks of a contact."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError


class Surface(Protocol):
    """What a trial asks of an interface; separations count from its own."""

    friction: float
    """Coefficient mu [-]."""
    slip: float
    """Displacement per place, kappa [-]."""
    origin: float
    """Its own separation [m]."""

    def load(self, separation: Floats) -> Floats:
        """N [N] at separations [m]."""

    def normal_stiffnesses(self, separation: Floats) -> Floats:
        """-N' [N/m] at separations [m]."""


class Trial(tuple[float, float]):
    """The end of a trial step, which unpacks as ``force, stiffness``.

    Made by :meth:`microslip.State.try_`. The tangents are those of the step, straight in separation
    and displacement, as it ends (Jaeger 1998, DOI 10.1115/1.2833765): what Newton's method needs.
    """

    _displacement: float
    _density: float
    _surface: Surface | None
    _step: float
    _normal_load: float | None

    @classmethod
    def _of(
        cls,
        force: float,
        stiffness: float,
        displacement: float,
        density: float,
        surface: Surface | None,
        step: float = 0.0,
        normal_load: float | None = None,
    ) -> Trial:
        """A trial whose last contact has the D ``density``."""
        trial = cls((force, stiffness))
        trial._displacement, trial._density, trial._surface = displacement, density, surface
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
        surface = self._interface("separation")
        return surface.origin + self._step

    @property
    def normal_load(self) -> float:
        """Normal load [N]; only an interface has one."""
        surface = self._interface("normal_load")
        if self._normal_load is None:
            return float(surface.load(np.array([self._step]))[0])
        return self._normal_load

    load = normal_load

    @property
    def tangent(self) -> Floats:
        """d(force, normal_load)/d(displacement, separation) [N/m], shape (2, 2)."""
        surface = self._interface("tangent")
        fall = float(surface.normal_stiffnesses(np.array([self._step]))[0])
        return np.array([[self[1], self._by_separation(surface, fall)], [0.0, -fall]])

    @property
    def tangent_by_load(self) -> Floats:
        """d(force, normal_load)/d(displacement, normal_load), [N/m] and [-], shape (2, 2).

        Where there is no contact the force does not change with the load to first order: 0.
        """
        surface = self._interface("tangent_by_load")
        fall = float(surface.normal_stiffnesses(np.array([self._step]))[0])
        by_load = self._by_separation(surface, fall) / -fall if fall > 0.0 else 0.0
        return np.array([[self[1], by_load], [0.0, 1.0]])

    def _by_separation(self, surface: Surface, fall: float) -> float:
        # mu s [N'(d) - N'(q)] where the front q slipped; with the mean fall where it stuck.
        return -self._density * (surface.friction * fall - surface.slip * self[1])

    def _interface(self, name: str) -> Surface:
        if self._surface is None:
            raise InputError(f"{name} has no meaning for this law: it has no surface")
        return self._surface

    def __repr__(self) -> str:
        return f"Trial(force={self[0]:g}, stiffness={self[1]:g})"
