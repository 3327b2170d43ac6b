"""Segalman's four parameters for an identification."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.friction.segalman import SegalmanIwan
from microslip.identification.models.base import BackboneModel, Branch, Derived, Model, Parameter


@dataclass(frozen=True)
class SegalmanModel(BackboneModel):
    """T0 = u [K_T - K x^p/(p + 1)], x = u/phi, p = 1 + chi, K = K_T/(1 + beta), up to phi.

    After Segalman (2005, DOI 10.1115/1.1989354). With E = beta (p + 1) + p its derivatives are sums
    of nothing that cancels: phi depends on the other parameters, and what that gives is in them.
    """

    law: SegalmanIwan | None = None

    name = "segalman"

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Force limit, stiffness at rest, exponent of the density, and the last slider's share.

        Segalman takes chi between -1 and 0; a joint of rough surfaces tends to 0, and what stiffens
        may lie above.
        """
        return (
            Parameter("force_limit", "N", 1e-12, 1e12, log=True),
            Parameter("stiffness", "N/m", 1e-6, 1e15, log=True),
            Parameter("chi", "", -0.99, 3.0),
            Parameter("beta", "", 0.0, 100.0),
        )

    @property
    def start(self) -> Mapping[str, float] | None:
        """Values of the instance it was made of."""
        return None if self.law is None else {name: getattr(self.law, name) for name in self.names}

    def guess(self, loops: Sequence[Any], loads: Sequence[float | None]) -> dict[str, float]:
        """Those of :meth:`SegalmanIwan.guess`."""
        law = SegalmanIwan.guess(loops)
        return self.within({name: getattr(law, name) for name in self.names})

    def branch(self, u: Floats, values: Mapping[str, float], load: float | None) -> Branch:
        """At phi and beyond the derivatives are those of gross slip."""
        limit, stiffness, chi, beta = (values[name] for name in self.names)
        p = 1.0 + chi
        spread, whole = stiffness / (1.0 + beta), beta * (p + 1.0) + p
        phi = limit * (1.0 + beta) * (p + 1.0) / (stiffness * whole)
        sticks = u < phi
        x = np.where(sticks, u / phi, 1.0)
        v, power = x * phi, x**p
        force = np.minimum(v * (stiffness - spread / (p + 1.0) * power), limit)
        slope = np.where(sticks, spread * (beta + (1.0 - power)), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            slow = np.where(x > 0.0, -power * np.log(x), 0.0)
        part = v * spread / (p + 1.0)
        by_values = np.stack(
            (
                part * power * (p / limit),
                v * (1.0 - power / (1.0 + beta)),
                part * (slow + power * (beta / whole)),
                part * power * (beta * (p + 1.0) / ((1.0 + beta) * whole)),
            )
        )
        by_values[1:, ~sticks] = 0.0
        by_values[0, ~sticks] = 1.0
        return np.where(sticks, force, limit), slope, by_values

    def curve(
        self, u: Floats, values: Mapping[str, float], load: float | None
    ) -> tuple[Floats, Floats]:
        """Force and slope alone."""
        limit, stiffness, chi, beta = (values[name] for name in self.names)
        p = 1.0 + chi
        spread, whole = stiffness / (1.0 + beta), beta * (p + 1.0) + p
        phi = limit * (1.0 + beta) * (p + 1.0) / (stiffness * whole)
        x = np.minimum(u / phi, 1.0)
        power = x**p
        force = x * phi * (stiffness - spread / (p + 1.0) * power)
        slope = np.where(x < 1.0, spread * (beta + (1.0 - power)), 0.0)
        return np.where(x < 1.0, np.minimum(force, limit), limit), slope

    def build(
        self, values: Mapping[str, float], load: float | None = None, **known: Any
    ) -> SegalmanIwan:
        """The model itself; the load does not enter."""
        return SegalmanIwan(*(values[name] for name in self.names))

    def derived(
        self, values: Mapping[str, float], loads: Sequence[float | None], *known: Any, **more: Any
    ) -> tuple[Derived, ...]:
        """The displacement phi at which gross slip begins."""
        limit, stiffness, chi, beta = (values[name] for name in self.names)
        p = 1.0 + chi
        whole = beta * (p + 1.0) + p
        phi = limit * (1.0 + beta) * (p + 1.0) / (stiffness * whole)
        logs = (
            1.0 / limit,
            -1.0 / stiffness,
            -1.0 / ((p + 1.0) * whole),
            -1.0 / ((1.0 + beta) * whole),
        )
        return (Derived("slip_displacement", "m", phi, phi * np.array(logs), None),)

    @classmethod
    def of(cls, law: SegalmanIwan) -> SegalmanModel:
        """The model of an instance."""
        return cls(law)

    @classmethod
    def examples(cls) -> tuple[tuple[Model, Mapping[str, float]], ...]:
        """The examples of the law."""
        models = [cls(law) for law in SegalmanIwan.examples()]
        return tuple((model, model.start or {}) for model in models)
