"""One sphere on a flat, the commonest fretting rig, and known surfaces, as laws to fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip.contact import SphereOnFlat
from microslip.contact.base import aluminium
from microslip.contact.materials import MaterialPair
from microslip.friction.fit_parameters import FitParameter, fit_parameters_of
from microslip.friction.guesses import loads_of
from microslip.friction.interface import Interface
from microslip.identification.models.base import (
    UNKNOWN,
    Branch,
    Derived,
    Loads,
    Materials,
    Model,
    Values,
)

(FRICTION,) = (p for p in fit_parameters_of(Interface) if p.name == "friction_coefficient")


def mean_load(loads: Sequence[float]) -> float:
    """The geometric mean of loads [N]."""
    return math.exp(float(np.mean(np.log(loads))))


def _limit_of(loops: Sequence[Any], loads: Sequence[float]) -> float:
    """Coefficient of friction from the loop that comes closest to sliding."""
    return max(
        0.5 * float(np.ptp(loop.force)) / load for loop, load in zip(loops, loads, strict=True)
    )


@dataclass(frozen=True)
class SphereModel(Model):
    """T0 = mu N [1 - (1 - u/u_L)^(3/2)], u_L = slip_limit (N/N_ref)^(2/3).

    Cattaneo (1938) and Mindlin (1949, DOI 10.1115/1.4009973). Loops determine mu and the slip
    limit; with the materials this is the radius, u_L = mu lambda s and
    N = (4/3) E* sqrt(R) s^(3/2).
    """

    reference_load: float | None = None
    law: Interface | None = None

    name = "sphere"
    scales_with_load = True
    at_reference = ("slip_limit",)

    @property
    def parameters(self) -> tuple[FitParameter, ...]:
        """Coefficient of friction and slip limit at the reference load."""
        limit = FitParameter(
            "slip_limit", "u_L", "m", "displacement of gross slip at the reference load", above=0.0
        )
        return (FRICTION, limit)

    @property
    def start(self) -> Values | None:
        """Values of the instance it was made of, taken to the reference load."""
        if self.law is None:
            return None
        limit = -self.law.slip_per_indentation * self.law.separation
        ratio = (self.reference_load or self.law.normal_load) / self.law.normal_load
        return {
            "friction_coefficient": self.law.friction_coefficient,
            "slip_limit": limit * ratio ** (2.0 / 3.0),
        }

    def prepared(self, loops: Sequence[Any], loads: Loads) -> SphereModel:
        """With the geometric mean of the loads as reference."""
        return replace(self, reference_load=mean_load(loads_of(loads, len(loops))))

    def _reference(self, load: float) -> float:
        return load if self.reference_load is None else self.reference_load

    def guess(self, loops: Sequence[Any], loads: Loads) -> dict[str, float]:
        """From the largest force, and from the stiffness after a reversal, 3/2 mu N/u_L."""
        checked_loads = loads_of(loads, len(loops))
        friction = _limit_of(loops, checked_loads)
        limits = []
        for loop, load in zip(loops, checked_loads, strict=True):
            top = int(np.argmax(loop.displacement))
            x, force = np.roll(loop.displacement, -top), np.roll(loop.force, -top)
            gone = (force[0] - force) / float(np.ptp(force))
            far = int(np.argmax(gone > 0.2))
            stiffness = (force[0] - force[far]) / max(x[0] - x[far], 1e-300)
            ratio = (self._reference(load) / load) ** (2.0 / 3.0)
            limits.append(1.5 * friction * load / max(stiffness, 1e-300) * ratio)
        return self.within(
            {"friction_coefficient": friction, "slip_limit": float(np.median(limits))}
        )

    def branch(self, u: Floats, values: Values, load: float | None) -> Branch:
        """First loading and derivatives, in closed form."""
        assert load is not None
        limit = values["slip_limit"] * (load / self._reference(load)) ** (2.0 / 3.0)
        force = values["friction_coefficient"] * load
        stuck = np.maximum(1.0 - u / limit, 0.0)
        # 1 - (1 - x)^(3/2) without loss of digits.
        x = np.minimum(u / limit, 1.0)
        share = x * (3.0 - 3.0 * x + x**2) / (1.0 + stuck * np.sqrt(stuck))
        slope = 1.5 * force / limit * np.sqrt(stuck)
        by = np.stack((load * share, -slope * u / values["slip_limit"]))
        return force * share, slope, by

    def build(
        self, values: Values, load: float | None = None, given: Materials = UNKNOWN
    ) -> Interface:
        """The joint on a pair of materials, of the radius that the slip limit says."""
        pair = self.completed(given).pair
        if pair is None:
            raise InputError("`pair` must be given: loops determine the slip limit alone")
        load = load or self.reference_load
        assert load is not None
        surface = SphereOnFlat(pair, self._radius(values, pair, self._reference(load)))
        return Interface(surface, values["friction_coefficient"], normal_load=load)

    @staticmethod
    def _radius(values: Values, pair: MaterialPair, load: float) -> float:
        deep = values["slip_limit"] / (values["friction_coefficient"] * pair.stiffness_ratio)
        return float((0.75 * load / (pair.composite_modulus * deep**1.5)) ** 2)

    def derived(
        self, values: Values, loads: Loads, given: Materials = UNKNOWN
    ) -> tuple[Derived, ...]:
        """Force limit and stiffness at each load; with the materials the radius."""
        mu, limit = (values[name] for name in self.names)
        pair, quantities = self.completed(given).pair, []
        for load in sorted({load for load in loads if load is not None}):
            load_limit = limit * (load / self._reference(load)) ** (2.0 / 3.0)
            stiff = 1.5 * mu * load / load_limit
            quantities.append(Derived("force_limit", "N", mu * load, np.array([load, 0.0]), load))
            by = np.array([stiff / mu, -stiff / limit])
            quantities.append(Derived("tangential_stiffness", "N/m", stiff, by, load))
        if pair is not None:
            radius = self._radius(values, pair, self._reference(loads[0] or 1.0))
            by = np.array([3.0 * radius / mu, -3.0 * radius / limit])
            quantities.append(Derived("radius", "m", radius, by, None))
        return tuple(quantities)

    @classmethod
    def of(cls, law: Interface) -> SphereModel:
        """The model of a joint on a sphere."""
        return cls(law.normal_load, law)

    @classmethod
    def examples(cls) -> tuple[tuple[Model, Values], ...]:
        """A ball at one load."""
        law = Interface(SphereOnFlat(aluminium(), radius=5e-3), 0.6, normal_load=500.0)
        model = cls.of(law)
        return ((model, model.start or {}),)


@dataclass(frozen=True)
class GivenSurfaceModel(Model):
    """T0 = mu [N(d) - N(d + u/(mu lambda))] on a surface that is known: only mu is left to fit."""

    surface: Any

    name = "given-surface"
    scales_with_load = True

    @property
    def parameters(self) -> tuple[FitParameter, ...]:
        """Coefficient of friction."""
        return (FRICTION,)

    @property
    def _surface(self) -> Any:
        return self.surface

    def guess(self, loops: Sequence[Any], loads: Loads) -> dict[str, float]:
        """From the largest force."""
        return self.within({"friction_coefficient": _limit_of(loops, loads_of(loads, len(loops)))})

    def branch(self, u: Floats, values: Values, load: float | None) -> Branch:
        """Branch of the interface; its slope by mu at fixed displacement is T0/mu - (u/mu) T0'."""
        law = self.build(values, load)
        force, slope = np.asarray(law.backbone(u)), np.asarray(law.backbone_stiffness(u))
        return force, slope, ((force - u * slope) / values["friction_coefficient"])[None]

    def build(
        self, values: Values, load: float | None = None, given: Materials = UNKNOWN
    ) -> Interface:
        """The joint on the surface."""
        assert load is not None
        return Interface(self.surface, values["friction_coefficient"], normal_load=load)

    def derived(
        self, values: Values, loads: Loads, given: Materials = UNKNOWN
    ) -> tuple[Derived, ...]:
        """Force limit at each load."""
        mu = values["friction_coefficient"]
        return tuple(
            Derived("force_limit", "N", mu * load, np.array([load]), load)
            for load in sorted({load for load in loads if load is not None})
        )
