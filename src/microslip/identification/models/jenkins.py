"""Jenkins' cell for an identification."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.friction.jenkins import Jenkins
from microslip.identification.models.base import BackboneModel, Branch, Derived, Model, Parameter


@dataclass(frozen=True)
class JenkinsModel(BackboneModel):
    """A spring and a slider: T0 = min(k u, F) (Iwan 1966, DOI 10.1115/1.3625199)."""

    law: Jenkins | None = None

    name = "jenkins"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Stiffness and force limit."""
        return (
            Parameter("stiffness", "N/m", 1e-6, 1e15, log=True),
            Parameter("force_limit", "N", 1e-12, 1e12, log=True),
        )

    @property
    def start(self) -> Mapping[str, float] | None:
        """Values of the instance it was made of."""
        if self.law is None:
            return None
        return {"stiffness": self.law.stiffness, "force_limit": self.law.force_limit}

    def guess(self, loops: Sequence[Any], loads: Sequence[float | None]) -> dict[str, float]:
        """Those of :meth:`Jenkins.guess`."""
        law = Jenkins.guess(loops)
        return self.within({"stiffness": law.stiffness, "force_limit": law.force_limit})

    def branch(self, u: Floats, values: Mapping[str, float], load: float | None) -> Branch:
        """At the yield displacement the derivatives are those beyond it."""
        stiffness, limit = values["stiffness"], values["force_limit"]
        sticks = u < limit / stiffness
        force = np.where(sticks, np.minimum(stiffness * np.where(sticks, u, 0.0), limit), limit)
        by_values = np.stack((np.where(sticks, u, 0.0), np.where(sticks, 0.0, 1.0)))
        return force, np.where(sticks, stiffness, 0.0), by_values

    def build(
        self, values: Mapping[str, float], load: float | None = None, **known: Any
    ) -> Jenkins:
        """The cell; the load does not enter."""
        return Jenkins(values["stiffness"], values["force_limit"])

    def derived(
        self, values: Mapping[str, float], loads: Sequence[float | None], *known: Any, **more: Any
    ) -> tuple[Derived, ...]:
        """The yield displacement F/k."""
        k, limit = values["stiffness"], values["force_limit"]
        end = limit / k
        return (Derived("yield_displacement", "m", end, np.array([-end / k, 1.0 / k]), None),)

    @classmethod
    def of(cls, law: Jenkins) -> JenkinsModel:
        """The model of a cell."""
        return cls(law)

    @classmethod
    def examples(cls) -> tuple[tuple[Model, Mapping[str, float]], ...]:
        """The examples of the law."""
        models = [cls(law) for law in Jenkins.examples()]
        return tuple((model, model.start or {}) for model in models)
