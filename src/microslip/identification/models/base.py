"""Base of the models: parameters of a law, and its force with exact derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.contact.materials import MaterialPair
from microslip.friction.fit_parameters import FitParameter

Values = Mapping[str, float]
"""Values of the parameters of a law, by their names."""
Loads = Sequence[float | None]
"""Normal loads [N], None where none is known."""


class Materials(NamedTuple):
    """Materials and area of a surface, which loops do not determine."""

    pair: MaterialPair | None = None
    area: float | None = None
    """Apparent area [m^2]."""
    radius: float | None = None
    """Radius of the summits [m]."""


UNKNOWN = Materials()


class Derived(NamedTuple):
    """A quantity that follows from the parameters, with its derivatives by them."""

    name: str
    unit: str
    value: float
    gradient: Floats
    """Derivatives by the parameters, in their order and physical."""
    load: float | None
    """Normal load [N] that it belongs to; None for one that belongs to all."""


Branch = tuple[Floats, Floats, Floats]
"""T0 [N], its derivative by the displacement [N/m], and by each parameter (parameters, places)."""


class Model(ABC):
    """Law of an identification, given by its backbone, from which Masing's rules make every cycle.

    A model that needs to know the data first, a grid of yield displacements or a reference load,
    is what :meth:`prepared` returns.
    """

    scales_with_load: ClassVar[bool] = False
    """Whether the load enters, so that records of all loads share the parameters by default."""
    options: ClassVar[tuple[str, ...]] = ()
    """Names of what :meth:`made` takes."""
    at_reference: ClassVar[tuple[str, ...]] = ()
    """Parameters that all loads may share, but as they are at one load."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Its name in studies and commands."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[FitParameter, ...]:
        """The parameters, in the order of every derivative."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def start(self) -> Values | None:
        """Values of the instance that the model was made of; None for one made of a name."""
        return None

    def completed(self, given: Materials) -> Materials:
        """Materials given, else those of the instance that it was made of."""
        surface = self._surface
        own_values = {name: getattr(surface, name, None) for name in Materials._fields}
        return Materials(**{name: getattr(given, name) or own_values[name] for name in own_values})

    @property
    def _surface(self) -> Any:
        return getattr(getattr(self, "law", None), "surface", None)

    def prepared(self, loops: Sequence[Any], loads: Loads) -> Model:
        """The model with what it has to know of the data; most are ready as they are."""
        return self

    def split(self, names: Collection[str], loads: Sequence[float]) -> Model:
        """The model where each of the loads [N] has values of its own of the parameters named."""
        return self

    @abstractmethod
    def guess(self, loops: Sequence[Any], loads: Loads) -> dict[str, float]:
        """Values to start from: physical, and within the bounds.

        ``loops`` have ``displacement`` [m] and ``force`` [N], one or many cycles each; ``loads``
        [N] are theirs.
        """

    @abstractmethod
    def build(self, values: Values, load: float | None = None, given: Materials = UNKNOWN) -> Any:
        """The law that has these values, as users know it."""

    @abstractmethod
    def branch(self, u: Floats, values: Values, load: float | None) -> Branch:
        """First loading curve at u >= 0 [m], one-dimensional, and all its derivatives."""

    def by_summits(
        self,
        u: Floats,
        values: Values,
        load: float | None,
        loads: Loads,
    ) -> Floats:
        """Change of :meth:`curve` by one summit: a row for each height.

        One standard deviation of the number of summits at each height, the same heights for all
        ``loads``; no rows for a law without summits of random heights.
        """
        return np.zeros((0, u.size))

    def curve(self, u: Floats, values: Values, load: float | None) -> tuple[Floats, Floats]:
        """First loading curve and its slope at u >= 0 [m]: :meth:`branch` without the rest."""
        return self.branch(u, values, load)[:2]

    def derived(
        self, values: Values, loads: Loads, given: Materials = UNKNOWN
    ) -> tuple[Derived, ...]:
        """Derived quantities, for each of the different loads where they depend on it."""
        return ()

    def within(self, values: Values) -> dict[str, float]:
        """The values, those outside their bounds brought to them."""
        return {p.name: min(max(float(values[p.name]), p.low), p.high) for p in self.parameters}

    @classmethod
    def of(cls, law: Any) -> Model:
        """The model of an instance of its law, which gives the values to start from."""
        return cls(law)  # type: ignore[call-arg]

    @classmethod
    def create(cls, **options: Any) -> Model:
        """The model without an instance; the ``options`` are checked by name already."""
        return cls(**options)

    @classmethod
    def examples(cls) -> tuple[tuple[Model, Values], ...]:
        """Prepared models with values, for the shared tests."""
        return ()
