"""Laws that declare their parameters, and Iwan cells, for an identification."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip._core.parameters import key_of, values_of
from microslip.friction.base import BackboneLaw
from microslip.friction.fit_parameters import FitParameter, fit_parameters_of
from microslip.friction.guesses import cell_stiffnesses, yield_grid
from microslip.friction.iwan import Iwan
from microslip.identification.models.base import (
    UNKNOWN,
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
class LawModel(Model):
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
    def parameters(self) -> tuple[FitParameter, ...]:
        """Parameters of the law."""
        return fit_parameters_of(self.kind)

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


def _places(value: float, step: float, parameter: FitParameter) -> tuple[int, ...]:
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


# -- Iwan's cells: linear in their stiffnesses ----------------------------------------------------

MOST_CELLS = 64
_NO_STIFFNESS = 1e-12  # of the largest stiffness: a cell that is none


@dataclass(frozen=True, eq=False)
class IwanModel(Locked, Model):
    """T0 = sum of k_i min(u, y_i): yield displacements on a fixed geometric grid.

    Only the stiffnesses k_i >= 0 are fitted, in which the model is linear (Iwan 1966,
    DOI 10.1115/1.3625199).
    """

    cells: int = 12
    yields: Floats | None = None
    """Yield displacements [m], rising; None until :meth:`prepared` has seen the data."""
    law: Iwan | None = None

    name = "iwan"
    options = ("cells",)

    def __post_init__(self) -> None:
        is_integer = isinstance(self.cells, (int, np.integer)) and not isinstance(self.cells, bool)
        if not is_integer or not 1 <= self.cells <= MOST_CELLS:
            raise InputError(
                f"`cells` must be an integer from 1 to {MOST_CELLS}, got {show(self.cells)}"
            )
        if self.yields is not None:
            object.__setattr__(self, "yields", lock(np.array(self.yields, dtype=float)))

    @cached_property
    def parameters(self) -> tuple[FitParameter, ...]:
        """The stiffness of each cell, in the order in which they yield."""
        count = self.cells if self.yields is None else self.yields.size
        return tuple(
            FitParameter(
                f"stiffness_{i + 1}",
                f"k_{i + 1}",
                "N/m",
                f"stiffness of cell {i + 1}",
                least=0.0,
                search=(0.0, 1e15),
                natural=True,
            )
            for i in range(count)
        )

    @property
    def start(self) -> Values | None:
        """Stiffnesses of the instance it was made of."""
        if self.law is None:
            return None
        return dict(zip(self.names, self.law._cells.stiffnesses.tolist(), strict=True))

    @property
    def _grid(self) -> Floats:
        if self.yields is None:
            raise InputError(
                "`yields` must be known: the grid is made from data; use prepared(loops, loads)"
            )
        return self.yields

    def prepared(self, loops: Sequence[Any], loads: Loads) -> IwanModel:
        """With a geometric grid from the smallest step that the loops resolve to the largest."""
        if self.yields is not None:
            return self
        return replace(self, yields=yield_grid(loops, self.cells))

    def guess(self, loops: Sequence[Any], loads: Loads) -> dict[str, float]:
        """Stiffnesses by non-negative least squares over the branches of the loops."""
        model = self.prepared(loops, loads)
        return self.within(
            dict(zip(model.names, cell_stiffnesses(loops, model._grid).tolist(), strict=True))
        )

    def branch(self, u: Floats, values: Values, load: float | None) -> Branch:
        """At a yield displacement the derivative is that beyond it."""
        k = np.array([values[name] for name in self.names])
        by_values = np.minimum(u, self._grid[:, None])
        return k @ by_values, self._pieces(u, k)[1], by_values

    def curve(self, u: Floats, values: Values, load: float | None) -> tuple[Floats, Floats]:
        """Piece by piece: what has yielded is a constant, what has not a spring."""
        return self._pieces(u, np.array([values[name] for name in self.names]))

    def _pieces(self, u: Floats, k: Floats) -> tuple[Floats, Floats]:
        stuck = np.append(np.cumsum(k[::-1])[::-1], 0.0)
        gone = np.append(0.0, np.cumsum(k * self._grid))
        piece = np.searchsorted(self._grid, u, side="right")
        slope = stuck[piece]
        return gone[piece] + slope * u, slope

    def build(self, values: Values, load: float | None = None, given: Materials = UNKNOWN) -> Iwan:
        """The cells that have any stiffness."""
        k = np.array([values[name] for name in self.names])
        real = k > _NO_STIFFNESS * max(float(k.max()), 0.0)
        if not real.any():
            raise InputError("`stiffnesses` must be above zero for one cell at least, got none")
        return Iwan(k[real], k[real] * self._grid[real])

    def derived(
        self, values: Values, loads: Loads, given: Materials = UNKNOWN
    ) -> tuple[Derived, ...]:
        """Stiffness at rest and force limit, sums over the cells."""
        k = np.array([values[name] for name in self.names])
        unit_gradient, grid = np.ones_like(k), np.array(self._grid)
        return (
            Derived("stiffness", "N/m", float(k.sum()), unit_gradient, None),
            Derived("force_limit", "N", float(k @ grid), grid, None),
        )

    @classmethod
    def of(cls, law: Iwan) -> IwanModel:
        """The model whose grid is that of the instance's own cells."""
        if law.cell_count > MOST_CELLS:
            raise InputError(
                f"`law` must have at most {MOST_CELLS} cells to be fitted, got {law.cell_count}"
            )
        return cls(law.cell_count, law._cells.yields, law)

    @classmethod
    def examples(cls) -> tuple[tuple[Model, Values], ...]:
        """Examples of laws of few cells."""
        models = [cls.of(law) for law in Iwan.examples() if law.cell_count <= MOST_CELLS]
        return tuple((model, model.start or {}) for model in models)
