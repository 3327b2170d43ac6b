"""Any law that declares its parameters, for an identification."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import Parameter, key_of, parameters_of, values_of
from microslip.friction.base import BackboneLaw
from microslip.identification.models.base import (
    UNKNOWN,
    BackboneModel,
    Branch,
    Derived,
    Loads,
    Materials,
    Model,
    Values,
)

_STEP = 2.0**-8
"""Step of a difference, of the value or of what is searched: the error of sixth order is then next
to that of rounding, some 1e-13 of a smooth backbone."""


@dataclass(frozen=True)
class LawModel(BackboneModel):
    """A law by the metadata of its parameters; its load does not enter.

    Derivatives are those of the law where it gives them, else differences of the sixth order:
    right to about 1e-11 of the force limit where the law is smooth and right to rounding itself,
    and spread over 1 % of a parameter where it has a corner.
    """

    kind: type[BackboneLaw]
    law: BackboneLaw | None = None

    @property
    def name(self) -> str:
        """Name of the law in studies and commands."""
        return key_of(self.kind)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the law."""
        return parameters_of(self.kind)

    @property
    def start(self) -> Values | None:
        """Values of the instance it was made of."""
        return None if self.law is None else values_of(self.law)

    def guess(self, loops: Sequence[Any], loads: Loads) -> dict[str, float]:
        """First guess of the law's own."""
        return self.within(values_of(self.kind.guess(loops)))

    def branch(self, u: Floats, values: Values, load: float | None) -> Branch:
        """Backbone, slope and derivatives by the parameters."""
        law = self.build(values)
        by_values = law._parameter_derivatives(u)
        if by_values is None:
            by_values = self._differences(lambda law_at: law_at._backbone(u), values, u.size)
        return law._backbone(u), law._slope(u), by_values

    def curve(self, u: Floats, values: Values, load: float | None) -> tuple[Floats, Floats]:
        """Backbone and slope alone."""
        law = self.build(values)
        return law._backbone(u), law._slope(u)

    def build(
        self, values: Values, load: float | None = None, given: Materials = UNKNOWN
    ) -> BackboneLaw:
        """The law itself; the load does not enter."""
        return self.kind(**{name: values[name] for name in self.names})

    def derived(
        self, values: Values, loads: Loads, given: Materials = UNKNOWN
    ) -> tuple[Derived, ...]:
        """Derived quantities of the law; its limit and its stiffness in any case."""
        units = dict(self.kind._quantities)
        if "force_limit" not in self.names:
            units["force_limit"] = "N"
        if not {"stiffness", "tangential_stiffness"} & set(self.names):
            units["tangential_stiffness"] = "N/m"
        law = self.build(values)
        quantities = []
        for name, unit in units.items():

            def of(law_at: BackboneLaw, name: str = name) -> Floats:
                return np.array([getattr(law_at, name)])

            gradient = self._differences(of, values, 1)[:, 0]
            quantities.append(Derived(name, unit, float(getattr(law, name)), gradient, None))
        return tuple(quantities)

    def _differences(
        self, function: Callable[[BackboneLaw], Floats], values: Values, size: int
    ) -> Floats:
        """Derivatives by the parameters (parameters, places)."""
        rows = np.empty((len(self.parameters), size))
        for row, parameter in zip(rows, self.parameters, strict=True):
            value = values[parameter.name]
            scale = abs(value)
            if not parameter.is_positive:
                scale = max(scale, min(1.0, parameter.high - parameter.low))
            step = _STEP * scale
            places = _places(value, step, parameter)
            row[:] = sum(
                weight * function(self.build({**values, parameter.name: value + place * step}))
                for place, weight in zip(places, _weights(places), strict=True)
                if weight
            )
            row /= step
        return rows

    @classmethod
    def of(cls, law: BackboneLaw) -> LawModel:
        """The model of an instance."""
        return cls(type(law), law)

    def examples(self) -> tuple[tuple[Model, Values], ...]:  # type: ignore[override]
        """The examples of the law."""
        return tuple((LawModel(self.kind, law), values_of(law)) for law in self.kind.examples())


def _places(value: float, step: float, parameter: Parameter) -> tuple[int, ...]:
    """Seven steps about a value, moved as far as the parameter allows none on one side."""
    low, high = max(parameter.above, parameter.least), min(parameter.below, parameter.most)
    # An open end is kept away from by a step.
    down = (
        math.inf if math.isinf(low) else (value - low) / step - (parameter.above >= parameter.least)
    )
    up = (
        math.inf
        if math.isinf(high)
        else (high - value) / step - (parameter.below <= parameter.most)
    )
    first = -3 + max(0, 3 - math.floor(min(down, 3.0))) - max(0, 3 - math.floor(min(up, 3.0)))
    return tuple(range(first, first + 7))


@lru_cache(maxsize=16)
def _weights(places: tuple[int, ...]) -> tuple[float, ...]:
    """Weights of the first derivative by values at steps from a place, exact to the sixth power."""
    powers = np.vander(np.array(places, dtype=float), increasing=True).T
    unit = np.zeros(len(places))
    unit[1] = 1.0
    weights = np.linalg.solve(powers, unit)
    weights[np.abs(weights) < 1e-12] = 0.0
    return tuple(weights.tolist())
