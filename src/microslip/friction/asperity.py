"""Single asperity: a sphere on a flat, with the tractions and displacements of the contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import (
    Floats,
    check_one_of,
    exact,
    floats,
    number,
    plain,
    positive,
    record,
)
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip.contact import SphereOnFlat
from microslip.contact.base import aluminium
from microslip.contact.materials import Material, MaterialPair
from microslip.friction.fields import AsperityFields, BodyName, bodies, distances, potentials
from microslip.friction.interface import Interface
from microslip.friction.memory import Memory


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Asperity(Interface):
    """Sphere on a flat under constant normal load, after Hertz, Cattaneo and Mindlin.

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    radius : float
        Radius rho of the sphere [m], above zero.
    friction_coefficient : float
        Coulomb's coefficient mu [-], above zero.
    normal_load : float, optional
        Normal load N [N], above zero.
    indentation : float, optional
        Indentation s [m], above zero, given instead of the load.

    Notes
    -----
    The law is that of an :class:`Interface` with a :class:`SphereOnFlat` surface: (19.10) and
    (19.12)-(19.24) of chapter 19 (DOI 10.1007/978-3-319-56818-8_19). Misprints of the chapter are
    corrected, and the law is extended to any record. A cycle of amplitude delta_m up to the slip
    limit delta_L dissipates E_d = (4/5) mu N delta_L (1 - q)^3 (1 + 3 q + q^2) with q = sqrt(1 -
    delta_m/delta_L). For a larger amplitude add 4 mu N (delta_m - delta_L) to the value at q = 0.

    The tractions and surface displacements are those of Cattaneo (1938) and Mindlin (1949, DOI
    10.1115/1.4009973). They neglect slip perpendicular to the force, and the coupling of normal and
    tangential motion for dissimilar bodies.
    """

    surface: SphereOnFlat

    def __init__(
        self,
        pair: MaterialPair,
        radius: float,
        friction_coefficient: float,
        normal_load: float | None = None,
        indentation: float | None = None,
    ) -> None:
        surface = SphereOnFlat(pair, radius)
        check_one_of("normal_load [N] or indentation [m]", normal_load, indentation)
        separation = None
        if indentation is not None:
            separation = -positive("indentation", indentation, "m")
        super().__init__(surface, friction_coefficient, normal_load, separation)  # type: ignore[arg-type]

    def at(self, *, normal_load: float | None = None, separation: float | None = None) -> Asperity:
        """Return the asperity at another normal load [N] or separation [m].

        The separation is 0 at first contact, so it is minus the indentation.
        """
        check_one_of("normal_load [N] or separation [m]", normal_load, separation)
        indentation = None if separation is None else -number("separation", separation, "m")
        if indentation is not None and indentation <= 0.0:
            raise InputError(
                f"`separation` must be below zero [m] for contact, got {-indentation:g}"
            )
        return Asperity(
            self.pair,
            self.radius,
            self.friction_coefficient,
            normal_load=normal_load,
            indentation=indentation,
        )

    @property
    def pair(self) -> MaterialPair:
        """Pair of materials."""
        return self.surface.pair

    @property
    def radius(self) -> float:
        """Radius rho of the sphere [m]."""
        return self.surface.radius

    # -- Hertz ----------------------------------------------------------------------------------

    @property
    def indentation(self) -> float:
        """Indentation s [m] (19.3): approach of distant points since first contact."""
        return -self.separation

    @cached_property
    def contact_radius(self) -> float:
        """Contact radius a = sqrt(rho s) [m] (19.1)."""
        return math.sqrt(self.radius * self.indentation)

    @cached_property
    def _pressure_factor(self) -> float:
        """Factor 2 E*/(pi rho) [Pa/m] of the Hertz pressure p(r) = factor * sqrt(a^2 - r^2)."""
        return 2.0 * self.pair.composite_modulus / (math.pi * self.radius)

    @cached_property
    def peak_pressure(self) -> float:
        """Hertz pressure 3 N/(2 pi a^2) [Pa] at the centre of the contact."""
        return self._pressure_factor * self.contact_radius

    def pressure(self, radius: ArrayLike) -> Any:
        """Compute the normal pressure p(r) = 2 E*/(pi rho) sqrt(a^2 - r^2) (Fig. 19.3).

        rho is the radius of the sphere and a that of the contact. ``radius`` holds the distances r
        from the centre of the contact [m], not negative, of any shape. Pressures [Pa] have the same
        shape and are 0 outside the contact.
        """
        r = distances("radius", radius)
        a = self.contact_radius
        return plain(self._pressure_factor * np.sqrt(np.maximum(a - r, 0.0) * (a + r)))

    def normal_displacement(self, radius: ArrayLike, body: BodyName | None = None) -> Any:
        """Compute the normal surface displacement [m] at distances from the centre of the contact.

        ``radius`` holds the distances r [m], not negative, of any shape, inside or outside the
        contact. ``body`` is "first" or "second"; the displacement is into that body, relative to
        its distant points. By default it is the sum of both, inside the contact s - r^2/(2 rho)
        with indentation s and radius rho of the sphere. Other names raise InputError.

        Notes
        -----
        Johnson, Contact Mechanics (1985, DOI 10.1017/CBO9781139171731), section 3.4.
        """
        r = distances("radius", radius)
        share = sum((1.0 - m.poisson_ratio**2) / m.young_modulus for m in bodies(self.pair, body))
        a = self.contact_radius
        phi, _ = potentials(self._pressure_factor, a, a * a, r.reshape(-1))
        return plain(share / math.pi * phi.reshape(r.shape))

    # -- Cattaneo and Mindlin -------------------------------------------------------------------

    @cached_property
    def slip_limit(self) -> float:
        """Slip limit delta_L = kappa s = 3 mu N/(16 a G*) [m], kappa = mu E*/(4 G*) (19.12)."""
        return self.slip_per_indentation * self.indentation

    def stick_radius(
        self, displacement: ArrayLike | None = None, *, force: ArrayLike | None = None
    ) -> Any:
        """Compute the radius c [m] of the stick circle on first loading (19.9).

        Displacements [m] are from rest; forces T [N] must not exceed the force limit. Either has
        any shape, which is that of the result; signs are ignored. c = a (1 - T/mu N)^(1/3), and 0
        at and beyond the slip limit.
        """
        name, values = _one_of(displacement, force)
        if name == "displacement":
            share = np.minimum(np.abs(floats(name, values, "m")), 1e200) / self.slip_limit
            return plain(self.contact_radius * np.sqrt(np.maximum(1.0 - share, 0.0)))
        sizes = np.abs(floats(name, values, "N"))
        if sizes.max() > self.force_limit:
            raise InputError(
                f"`{name}` must not exceed the force limit {self.force_limit:.10g} N in magnitude, "
                f"got {sizes.max():.10g} N"
            )
        return plain(self.contact_radius * np.cbrt(1.0 - sizes / self.force_limit))

    def _inverse(self, force: Floats) -> Floats:
        share = np.log1p(-force / self.force_limit)
        return np.asarray(-self.slip_limit * np.expm1(2.0 / 3.0 * share))

    def fields(
        self, displacement: ArrayLike | None = None, *, force: ArrayLike | None = None
    ) -> AsperityFields:
        """Compute slip zones, tractions and surface displacements at the end of a record from rest.

        The result has them as attributes and methods. The record is one-dimensional: displacements
        [m], or forces [N] below the force limit. Its turning points and last sample are sufficient;
        a single number means first loading to this displacement or force.
        """
        name, values = _one_of(displacement, force)
        x = record(name, values, "N" if name == "force" else "m").reshape(-1)
        if name == "force":
            x = self.displacement(x)
        memory = Memory()
        memory.respond(x, self._backbone, None)
        turns = np.append(memory.stack[: memory.depth, 0], memory.last)
        moves = np.diff(turns, prepend=0.0)
        double = np.where(np.arange(turns.size) > 0, 2.0, 1.0)
        return AsperityFields(
            self,
            memory.last,
            memory.value,
            lock(np.abs(moves) / double),
            lock(np.sign(moves) * double),
        )

    def __repr__(self) -> str:
        return (
            f"Asperity(radius={exact(self.radius)}, "
            f"friction_coefficient={exact(self.friction_coefficient)}, "
            f"normal_load={exact(self.normal_load)}, indentation={self.indentation:g})"
        )

    @classmethod
    def examples(cls) -> tuple[Asperity, ...]:  # type: ignore[override]
        """Return a ball of 5 mm radius, and a summit of 1 mm radius against a stiffer body."""
        metal = aluminium()
        unlike = MaterialPair(metal.first, Material(young_modulus=210e9, poisson_ratio=0.3))
        return cls(metal, 5e-3, 0.55, normal_load=10.0), cls(unlike, 1e-3, 0.2, indentation=3e-7)


def _one_of(displacement: ArrayLike | None, force: ArrayLike | None) -> tuple[str, ArrayLike]:
    check_one_of("displacement [m] or force=... [N]", displacement, force)
    if force is None:
        return "displacement", displacement  # type: ignore[return-value]
    return "force", force
