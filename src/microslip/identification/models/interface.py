"""Extended Greenwood Model for an identification, in parameters that loops determine."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, positive
from microslip._core.errors import InputError
from microslip.contact import GreenwoodWilliamson, MeasuredContact, SphereOnFlat
from microslip.contact.materials import MaterialPair
from microslip.friction.interface import Interface
from microslip.identification.models.surface_shape import (
    CONVENTIONAL_AREA,
    Template,
    template_of,
)

FRICTION, SCALE, SEPARATION = "friction_coefficient", "slip_scale", "standardised_separation"
_HEIGHTS, _TALLEST = 192, 8.0
"""Number of height classes with random summit counts, and their range above the lowest contact."""

Values = Mapping[str, float]


class Materials(NamedTuple):
    """Materials and area of a surface, which loops do not determine."""

    pair: MaterialPair | None = None
    area: float | None = None
    """Apparent area [m^2]."""
    radius: float | None = None
    """Radius of the summits [m]."""


@dataclass(frozen=True, eq=False)
class InterfaceModel:
    """Interface whose first-loading force is T0 = mu N [1 - n(h + x)/n(h)], x = u/slip_scale.

    The normal load at separation d is N = C n(d/s), with a known shape n, a length s and a constant
    C [N]. Loops determine the friction coefficient mu, the length slip_scale = kappa s, where kappa
    = mu E*/(4 G*) depends on the materials, and, weakly, the separation h = d/s at the
    ``reference_load`` N_ref. At another load N the separation h_N solves n(h_N) = n(h) N/N_ref
    (Ciavarella 1998, J. Appl. Mech. 65, 998). For a sphere s is the approach at the reference load,
    and h is -1.
    """

    template: Template
    reference_load: float

    @classmethod
    def of_shape(cls, shape: Any, loads: Sequence[float]) -> InterfaceModel:
        """Return the model of a height distribution or a surface; None means Gaussian heights.

        The reference load is the geometric mean of the ``loads`` [N].
        """
        return cls(template_of(shape), math.exp(float(np.mean(np.log(loads)))))

    @property
    def is_sphere(self) -> bool:
        """Whether the surface is a single sphere."""
        return isinstance(self.template.law, SphereOnFlat)

    def _values(self, values: Values) -> tuple[float, float, float]:
        """Return friction coefficient mu, slip scale [m] and separation h at the reference load."""
        h = -1.0 if self.is_sphere else values[SEPARATION]
        return values[FRICTION], values[SCALE], h

    def _at(self, values: Values, load: float) -> tuple[float, float, float]:
        """Return the force limit [N], the slip scale [m] and the separation h at a load [N]."""
        mu, scale, h = self._values(values)
        return mu * load, scale, self.template.separation(h, load / self.reference_load)

    def curve(self, u: Floats, values: Values, load: float) -> Floats:
        """Return the force [N] of first loading at displacements u >= 0 [m]."""
        limit, scale, here = self._at(values, load)
        return limit * self.template.share(here, np.minimum(u, 1e200) / scale)

    def slope(self, u: Floats, values: Values, load: float) -> Floats:
        """Return the stiffness [N/m] of first loading at displacements u >= 0 [m]."""
        limit, scale, here = self._at(values, load)
        return limit / scale * self.template.fall(here, u / scale)

    def by_summits(self, u: Floats, values: Values, load: float, loads: Sequence[float]) -> Floats:
        """Return the standard deviations of the force that random summits cause, times sqrt(M) [N].

        M is the total number of summits. The result has the shape (height intervals,
        displacements); the intervals are the same for all ``loads``. The number of summits in each
        interval of heights z scatters by Poisson's distribution. If it exceeds its mean by c M, h
        rises to keep the load N, and the force of first loading changes as follows, with the
        separation h at the load N, and n and x as defined in the class:

        -mu N/n(h) c [(z - h - x)^(3/2) - (z - h)^(3/2) n'(h + x)/n'(h)].
        """
        law = self.template.law
        if not isinstance(law, GreenwoodWilliamson):
            return np.zeros((0, u.size))
        template, heights, unit = self.template, law.heights, self.template.unit
        limit, scale, here = self._at(values, load)
        lowest = min(self._at(values, one)[2] for one in loads)
        top = max(heights.span[1] / unit, lowest + 1.0)
        edges = np.linspace(lowest, min(top, lowest + _TALLEST), _HEIGHTS + 1)
        z = 0.5 * (edges[1:] + edges[:-1])[:, None]
        share = heights._density(z * unit) * unit * (edges[1] - edges[0])
        x = np.minimum(u, 1e200) / scale
        fall = template.fall(here, x) / template.rate(here)
        above = np.maximum(z - here, 0.0) ** 1.5
        change = np.maximum(z - here - x, 0.0) ** 1.5 - above * fall
        return np.asarray(-limit / template.load(here) * np.sqrt(share) * change)

    # -- what follows ----------------------------------------------------------------------------

    def build(self, values: Values, load: float, given: Materials) -> Interface:
        """Return the interface; an unknown radius or area gets a conventional value."""
        pair, area, radius = given
        if pair is None:
            raise InputError(
                "`pair` must be given, the two materials: loops determine kappa s alone, and "
                "kappa = mu E*/4G* depends on them"
            )
        radius = None if radius is None else positive("radius", radius, "m")
        area = CONVENTIONAL_AREA if area is None else positive("area", area, "m^2")
        mu, scale, h = self._values(values)
        length = scale / (mu * pair.stiffness_ratio)
        constant = self.reference_load / self.template.load(h)
        surface = self.template.surface(pair, length, constant, area, radius)
        return Interface(surface, mu, normal_load=load)

    def derived(self, values: Values, load: float, given: Materials) -> dict[str, float]:
        """Return force limit, stiffness and, with materials ``given``, sizes of summits (SI)."""
        pair, area, _ = given
        mu, _, h = self._values(values)
        template, (limit, scale, here) = self.template, self._at(values, load)
        stiffness = limit * template.rate(here) / scale
        found = {"force_limit": limit, "tangential_stiffness": stiffness}
        if pair is None:
            return found
        law = template.law  # a lay has a ratio of its own
        length = scale / (mu * (law if isinstance(law, MeasuredContact) else pair).stiffness_ratio)
        stiff = 4.0 / 3.0 * pair.composite_modulus
        if self.is_sphere:
            radius = (self.reference_load / (length**1.5 * stiff)) ** 2
            return found | {"radius": radius, "approach": -here * length}
        found["std"] = length
        if area is not None and isinstance(law, GreenwoodWilliamson):
            constant = self.reference_load / template.load(h)
            found["density_root_radius"] = float(np.divide(constant, length**1.5 * stiff * area))
        return found
