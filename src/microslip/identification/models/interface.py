"""The Extended Greenwood Model for an identification, in the parameters that loops determine."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from microslip._core.checks import Floats, positive
from microslip._core.errors import InputError
from microslip.contact import GreenwoodWilliamson, MeasuredContact
from microslip.friction.fit_parameters import FitParameter
from microslip.friction.guesses import loads_of
from microslip.friction.interface import Interface
from microslip.friction.surface_guesses import CONVENTIONAL_AREA, Shape, interface_values
from microslip.identification.models.base import (
    UNKNOWN,
    Branch,
    Derived,
    Loads,
    Materials,
    Model,
    Values,
)
from microslip.identification.models.sphere import FRICTION, mean_load
from microslip.identification.models.surface_shape import Template, template_of

_HEIGHTS, _TALLEST = 192, 8.0
"""Heights of which the numbers of summits scatter, and up to how far above the lowest contact."""


@dataclass(frozen=True, eq=False)
class InterfaceModel(Model):
    """T0 = mu N [1 - n(h + x)/n(h)] with x = u/slip_scale, for loads that the records know.

    The normal law is a template with two scales, N(d) = C n(d/s). Loops determine mu, the length
    slip_scale = kappa s and, weakly, the separation h = d/s at the ``reference_load``; at a load N
    it is h_N with n(h_N) = n(h) N/N_ref (Ciavarella 1998, J. Appl. Mech. 65, 998).
    """

    template: Template
    reference_load: float | None = None
    law: Interface | None = None
    own_loads: tuple[float, ...] = ()
    """Loads [N] that have a separation of their own each, which is then that at this load."""

    name = "interface"
    scales_with_load = True
    options = ("heights", "surface", "reference_load")
    at_reference = ("standardised_separation",)
    """Parameters that belong to the reference load."""

    @cached_property
    def parameters(self) -> tuple[FitParameter, ...]:
        """Coefficient of friction, slip scale, and separation at the reference load.

        For Gaussian heights the separation lies between -4 and 8: below, all summits but three in
        100 000 touch and none is left to be met; above, less than one in 10^15 touches.
        """
        return (
            FRICTION,
            FitParameter("slip_scale", "kappa s", "m", "slip of a summit as high as s", above=0.0),
            FitParameter(
                "standardised_separation",
                "h",
                meaning="separation over s at the reference load",
                search=self.template.bounds(),
                beyond=True,
            ),
        )

    @property
    def start(self) -> Values | None:
        """Values of the instance it was made of, its separation taken to the reference load."""
        if self.law is None:
            return None
        unit = self.template.unit
        ratio = self._ratio(self.law.normal_load)[1]
        separation = self.law.separation / unit
        if ratio != 1.0:
            separation = self.template.separation(separation, 1.0 / ratio)
        return {
            "friction_coefficient": self.law.friction_coefficient,
            "slip_scale": self.law.slip_per_indentation * unit,
            "standardised_separation": separation,
        }

    def prepared(self, loops: Sequence[Any], loads: Loads) -> InterfaceModel:
        """With the geometric mean of the loads, unless a reference was given by itself."""
        checked_loads = loads_of(loads, len(loops))
        if self.reference_load is not None and self.law is None:
            return self
        return replace(self, reference_load=mean_load(checked_loads))

    def split(self, names: Collection[str], loads: Sequence[float]) -> InterfaceModel:
        """With a separation of its own at each of the loads, if it is among the names."""
        separation_loads = tuple(loads) if set(names) & set(self.at_reference) else ()
        return replace(self, own_loads=separation_loads)

    def guess(self, loops: Sequence[Any], loads: Loads) -> dict[str, float]:
        """First guess of :meth:`Interface.guess`, at the reference load."""
        checked_loads = loads_of(loads, len(loops))
        if self.own_loads:
            reference: float | None = self._reference(checked_loads[0])
        else:
            reference = self.prepared(loops, loads).reference_load
        assert reference is not None
        template = self.template
        shape = Shape(template.law, template.unit)
        values = interface_values(loops, checked_loads, reference, shape, template.bounds())
        return self.within(dict(zip(self.names, values, strict=True)))

    def _reference(self, load: float | None) -> float | None:
        """The load [N] whose separation a parameter is: of several the nearest."""
        if load is None or not self.own_loads:
            return self.reference_load
        return min(self.own_loads, key=lambda candidate: abs(math.log(candidate / load)))

    def _ratio(self, load: float | None) -> tuple[float, float]:
        """The load [N] and its share of the reference."""
        reference = self._reference(load)
        if load is None and reference is None:
            raise InputError(
                "`normal_load` must be known: the model scales with it; state it with the "
                "record, for example Record(..., normal_load=500.0)"
            )
        if reference is None or load is None:
            stated = load if reference is None else reference
            assert stated is not None
            return stated, 1.0
        return load, load / reference

    def branch(self, u: Floats, values: Values, load: float | None) -> Branch:
        """First loading curve and derivatives, exact from x towards 0 to deep in gross slip."""
        load, ratio = self._ratio(load)
        mu, scale, h = (values[name] for name in self.names)
        here = self.template.separation(h, ratio)
        x = np.minimum(u, 1e200) / scale
        share, by_step, by_separation = self.template.shares(here, x)
        limit = mu * load
        slope = (limit / scale) * by_step
        by_values = np.empty((3, u.size))
        np.multiply(load, share, out=by_values[0])
        np.multiply(x, slope, out=by_values[1])
        np.negative(by_values[1], out=by_values[1])
        moved = 1.0 if ratio == 1.0 else self.template.rate(h) / self.template.rate(here)
        np.multiply(limit * moved, by_separation, out=by_values[2])
        return limit * share, slope, by_values

    def by_summits(
        self,
        u: Floats,
        values: Values,
        load: float | None,
        loads: Loads,
    ) -> Floats:
        """Counts at each height scatter as Poisson has it; the separation gives way to each.

        With c summits too many at a height z the load stays what it is, so that h rises, and
        T0 changes by -mu N/n(h) c [(z - h - x)^(3/2) - (z - h)^(3/2) n'(h + x)/n'(h)].
        """
        law = self.template.law
        if not isinstance(law, GreenwoodWilliamson):
            return np.zeros((0, u.size))
        load, ratio = self._ratio(load)
        mu, scale, h = (values[name] for name in self.names)
        template = self.template
        here = template.separation(h, ratio)
        lowest = min(template.separation(h, self._ratio(any_load)[1]) for any_load in loads)
        heights, unit = law.heights, template.unit
        top = max(heights.span[1] / unit, lowest + 1.0)
        edges = np.linspace(lowest, min(top, lowest + _TALLEST), _HEIGHTS + 1)
        z = 0.5 * (edges[1:] + edges[:-1])[:, None]
        share = heights._density(z * unit) * unit * (edges[1] - edges[0])
        x = np.minimum(u, 1e200) / scale
        fall = template.shares(here, x).by_step / template.rate(here)
        above = np.maximum(z - here, 0.0) ** 1.5
        change = np.maximum(z - here - x, 0.0) ** 1.5 - above * fall
        return np.asarray(-mu * load / template.load(here) * np.sqrt(share) * change)

    # -- what follows ----------------------------------------------------------------------------

    def build(
        self, values: Values, load: float | None = None, given: Materials = UNKNOWN
    ) -> Interface:
        """The joint on a pair; radius and area, which loops do not know, by convention."""
        pair, area, radius = self.completed(given)
        if pair is None:
            raise InputError(
                "`pair` must be given, the two materials: loops determine kappa s alone, and "
                "kappa = mu E*/4G* depends on them"
            )
        radius = None if radius is None else positive("radius", radius, "m")
        area = CONVENTIONAL_AREA if area is None else positive("area", area, "m^2")
        load, ratio = self._ratio(load)
        mu, scale, h = (values[name] for name in self.names)
        length = scale / (mu * pair.stiffness_ratio)
        constant = load / ratio / self.template.load(h)
        surface = self.template.surface(pair, length, constant, area, radius)
        return Interface(surface, mu, normal_load=load)

    def derived(
        self, values: Values, loads: Loads, given: Materials = UNKNOWN
    ) -> tuple[Derived, ...]:
        """Force limit, stiffness, separation of each load; what pair and area add."""
        pair, area, _ = self.completed(given)
        mu, scale, h = (values[name] for name in self.names)
        template = self.template
        rate = template.rate(h)
        quantities: list[Derived] = []

        def add(name: str, unit: str, value: float, logs: list[float], load: float | None) -> None:
            """A value with its derivatives by ln mu, ln slip_scale and h, over the value."""
            by = value * np.array(logs) / np.array([mu, scale, 1.0])
            quantities.append(Derived(name, unit, value, by, load))

        different = sorted({self._ratio(load)[0] for load in loads})
        for load in different:
            here = template.separation(h, self._ratio(load)[1])
            there = template.rate(here)
            moved = rate / there
            add("force_limit", "N", mu * load, [1.0, 0.0, 0.0], load)
            stiffness = mu * load * there / scale
            turn = self._curve(here) * moved
            add("tangential_stiffness", "N/m", stiffness, [1.0, -1.0, turn], load)
            by_h = np.array([0.0, 0.0, moved])
            quantities.append(Derived("standardised_separation", "", here, by_h, load))
        reference = self._reference(different[0]) or different[0]
        constant = reference / template.load(h)
        add("load_scale", "N", constant, [0.0, 0.0, rate], None)
        if pair is not None:
            law = template.law  # a lay has a ratio of its own
            ratio = (law if isinstance(law, MeasuredContact) else pair).stiffness_ratio
            length = scale / (mu * ratio)
            add("std", "m", length, [-1.0, 1.0, 0.0], None)
            if area is not None and isinstance(template.law, GreenwoodWilliamson):
                stiff = 4.0 / 3.0 * pair.composite_modulus * area
                product = constant / (length**1.5 * stiff)
                add("density_root_radius", "m^-1.5", product, [1.5, -1.5, rate], None)
        return tuple(quantities)

    def _curve(self, z: float) -> float:
        """Derivative of ln(-n'/n) at z."""
        law, unit = self.template.law, self.template.unit
        n, n1, n2 = (law._derivative_at(z * unit, order) for order in (0, 1, 2))
        return unit * (n2 / n1 - n1 / n)

    @classmethod
    def of(cls, law: Interface) -> InterfaceModel:
        """The model of a joint: its surface is the template, its load the reference."""
        return cls(template_of(law.surface), law.normal_load, law)

    @classmethod
    def create(  # type: ignore[override]
        cls, heights: Any = None, surface: Any = None, reference_load: float | None = None
    ) -> InterfaceModel:
        """The model on heights or on the shape of a surface; without either, Gaussian heights."""
        if heights is not None and surface is not None:
            raise InputError("heights or surface must be given, one of them, got both")
        if reference_load is not None:
            reference_load = positive("reference_load", reference_load, "N")
        return cls(template_of(heights if surface is None else surface), reference_load)

    @classmethod
    def examples(cls) -> tuple[tuple[Model, Values], ...]:
        """Gaussian and other heights, given summits and a table."""
        from scipy import stats

        shapes: tuple[tuple[Any, tuple[float, ...]], ...] = (
            (None, (-3.0, 1.5, 5.0)),
            ([0.0, 2e-7, -3e-7, 5e-7, 1e-7], (-2.0, 0.3)),
            (stats.weibull_min(2.2, scale=1e-6), (1.0, 3.0)),
            (Interface.examples()[0].surface, (2.2,)),
        )
        examples: list[tuple[Model, Values]] = []
        for shape, separations in shapes:
            template = template_of(shape)
            for h in separations:
                values = (0.5, 3e-7, h)
                model = cls(template, 800.0)
                examples.append((model, dict(zip(model.names, values, strict=True))))
        return tuple(examples)
