"""Fields of one asperity: stick and slip zones, tractions and surface displacements.

The solutions of Boussinesq and Cerruti (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.6)
need two integrals over the contact area of an axisymmetric traction q, at a point at distance r
from the centre,

    phi(r)              = integral of q / distance dA,
    psi(r) cos(2 angle) = integral of q (x^2 - y^2) / distance^3 dA,

called potential and deviator. Here "distance", with the components x and y, is that between the
point and the element dA, and "angle" is the direction from the centre to the point. psi(r) is the
mean of phi over the disc of radius r minus phi(r). For a Hertz pressure on the contact circle of
radius a minus that on the stick circle of radius c,

    q(r) = k [sqrt(a^2 - r^2) - sqrt(c^2 - r^2)]   (0 for the root of a negative number),

with k = mu 2 E*/(pi rho) [Pa/m], phi and psi are integrals of one function g, which is min(a^2 -
t^2, a^2 - c^2) for t < a and 0 for t >= a:

    phi = pi k integral of g(r sin p) dp,   psi = pi k integral of g(r sin p) cos(2p) dp

over 0 <= p <= pi/2. No digits cancel far from the contact or for c close to a.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, plain, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.quadrature import gauss_legendre
from microslip.contact.materials import Material, MaterialPair

# g is a polynomial of sines, for which this rule is exact to rounding on a quarter turn.
_NODES, _WEIGHTS = gauss_legendre(16)

BodyName = Literal["first", "second"]


class Zone(NamedTuple):
    """Circle or ring of the contact with a common slip history (19.9), (19.18)."""

    kind: Literal["stick", "stuck", "slip"]
    """``stick``: has not slipped since rest; ``stuck``: has slipped, but not since the last
    reversal; ``slip``: slips now."""
    inner: float
    """Inner radius [m]."""
    outer: float
    """Outer radius [m]."""
    direction: int
    """Direction of the last slip, 1 or -1; 0 if the zone has not slipped."""


@dataclass(frozen=True, eq=False, repr=False)
class AsperityFields(Locked):
    """State of one asperity at the end of a record; the result of :meth:`Asperity.fields`.

    Notes
    -----
    The memory of a record is its open reversals. First loading up to the first of them, and each
    branch from one to the next, contribute one Cattaneo term: mu times the Hertz pressure of the
    contact minus mu times that of the circle of radius c that did not slip on the branch. The term
    of first loading has the factor 1, later terms have the factor 2, with alternating signs
    (Mindlin and Deresiewicz, J. Appl. Mech. 20, 327, 1953). The force (19.13)-(19.24) and all
    fields are sums of these terms for any record.
    """

    asperity: Any
    """The :class:`Asperity`."""
    displacement: float
    """Tangential displacement at the end of the record [m]."""
    force: float
    """Tangential force at the end of the record [N]."""
    _distances: NDArray[np.float64]
    """Length of first loading, then half the length of each branch from one open reversal to the
    next [m]."""
    _factors: NDArray[np.float64]
    """Factor of each Cattaneo term: 1 or -1 for first loading, then 2 and -2 alternating."""

    # -- zones ----------------------------------------------------------------------------------

    @cached_property
    def _removed(self) -> list[float]:
        """Difference a^2 - c^2 [m^2] for each Cattaneo term, decreasing from term to term.

        a is the contact radius, c the radius of the circle that did not slip on that branch.
        """
        share = np.minimum(self._distances / self.asperity.slip_limit, 1.0)
        removed: list[float] = (share * self.asperity.contact_radius**2).tolist()
        return removed

    def _radius(self, term: int) -> float:
        return math.sqrt(max(self.asperity.contact_radius**2 - self._removed[term], 0.0))

    @property
    def stick_radius(self) -> float:
        """Radius c [m] of the circle that currently sticks (19.9); 0 in gross slip.

        On first loading (c/a)^3 = 1 - |T|/(mu N); on a branch from a reversal at force T_r it is 1
        - |T - T_r|/(2 mu N).
        """
        return self._radius(-1)

    @property
    def unslipped_radius(self) -> float:
        """Radius [m] of the circle that has not slipped since rest; c in (19.18)."""
        return self._radius(0)

    @property
    def reversed_slip_radius(self) -> float:
        """Inner radius c' [m] of the slip after the first reversal (19.18).

        (c'/a)^3 = 1 - |T - T_r|/(2 mu N), with the force T_r at the first open reversal and T at
        the second, or at the end of the record if there is no second. Without reversals it is a.
        """
        return self._radius(1) if self._factors.size > 1 else self.asperity.contact_radius

    @property
    def zones(self) -> tuple[Zone, ...]:
        """Circle and rings of the contact, from the centre outwards, without empty zones."""
        ways = [0, *np.sign(self._factors).astype(int).tolist()]
        radii = [
            0.0,
            *(self._radius(k) for k in range(len(ways) - 1)),
            self.asperity.contact_radius,
        ]
        kinds: list[Any] = ["stick", *["stuck"] * (len(ways) - 2), "slip"]
        zones = zip(kinds, radii[:-1], radii[1:], ways, strict=True)
        return tuple(Zone(*zone) for zone in zones if zone[1] < zone[2])

    # -- tractions ------------------------------------------------------------------------------

    def traction(self, radius: ArrayLike) -> Any:
        """Compute the tangential traction q(r) along the force, at most mu p(r) (Figs. 19.2, 19.3).

        ``radius`` holds the distances r from the centre of the contact [m], not negative, of any
        shape. Tractions [Pa] have the same shape and are 0 outside the contact. Their integral over
        the contact area is the force.
        """
        places = distances("radius", radius)
        r, a = places.reshape(-1), self.asperity.contact_radius
        inside = np.sqrt(np.maximum(a - r, 0.0) * (a + r))
        total = np.zeros_like(r)
        for factor, removed in zip(self._factors.tolist(), self._removed, strict=True):
            c = math.sqrt(max(a * a - removed, 0.0))
            root = np.sqrt(np.maximum(c - r, 0.0) * (c + r))
            # Inside the stick circle, the difference of the roots without cancellation.
            total += factor * np.divide(removed, inside + root, out=inside.copy(), where=root > 0.0)
        scale = self.asperity._pressure_factor * self.asperity.friction_coefficient
        return plain((scale * total).reshape(places.shape))

    # -- displacements --------------------------------------------------------------------------

    def _terms(self, r: Floats) -> Iterator[tuple[float, Floats, Floats]]:
        """Yield the factor, potential phi(r) and deviator psi(r) [Pa m] of each Cattaneo term.

        The module defines phi and psi, and the class the terms and their factors.
        """
        joint = self.asperity
        grade = joint._pressure_factor * joint.friction_coefficient
        for factor, removed in zip(self._factors.tolist(), self._removed, strict=True):
            yield factor, *potentials(grade, joint.contact_radius, removed, r)

    def surface_displacement(
        self, x: ArrayLike, y: ArrayLike = 0.0, body: BodyName | None = None
    ) -> tuple[Any, Any]:
        """Compute the tangential surface displacement, inside and outside the contact.

        Parameters
        ----------
        x, y : array_like
            Coordinates [m] from the centre, x along the force; shapes that broadcast.
        body : {"first", "second"}, optional
            Body whose displacement is computed, positive along the force on that body. By default
            the sum of both bodies, equal to ``displacement`` in the unslipped circle.

        Returns
        -------
        u_x, u_y : float or ndarray
            Displacements along and across the force [m], relative to distant points of each body.

        Notes
        -----
        Cerruti's solution, summed over the Cattaneo terms of the traction. For a single Hertz
        traction it agrees with Johnson, Contact Mechanics (1985, DOI 10.1017/CBO9781139171731),
        section 3.6. The displacement u_y of both bodies is slip across the force, which Cattaneo
        and Mindlin neglect: on first loading it is at most nu/(4 - 2 nu) of u_x in the contact.
        """
        px, py = floats("x", x, "m"), floats("y", y, "m")
        try:
            px, py = np.broadcast_arrays(px, py)
        except ValueError:
            raise InputError(
                f"`x` and `y` must have shapes that broadcast, got {px.shape} and {py.shape}"
            ) from None
        r = np.hypot(px, py)
        cosine = np.divide(px, r, out=np.ones_like(r), where=r > 0.0)
        sine = np.divide(py, r, out=np.zeros_like(r), where=r > 0.0)
        along, across = shares(self.asperity.pair, body)
        ux, uy = np.zeros_like(r), np.zeros_like(r)
        for factor, phi, psi in self._terms(r.reshape(-1)):
            deviator = across * psi.reshape(r.shape)
            ux += factor * (along * phi.reshape(r.shape) + (cosine**2 - sine**2) * deviator)
            uy += factor * (2.0 * sine * cosine * deviator)
        return plain(ux), plain(uy)

    def slip(self, radius: ArrayLike) -> Any:
        """Compute the slip [m] since rest along the force, at distances from the centre.

        Slip is the displacement of the joint minus the surface displacements of both bodies,
        averaged over the circle of this radius. It is 0 in the unslipped circle; outside the
        contact it is the relative displacement of facing points. ``radius`` [m] is not negative, of
        any shape, which is that of the result.

        Notes
        -----
        On first loading the integral of mu p times the slip over the contact is the dissipated
        energy, a quarter of that of the cycle (19.29).
        """
        r = distances("radius", radius)
        share, _ = shares(self.asperity.pair, None)
        total = np.zeros(r.size)
        for (factor, phi, _), distance in zip(
            self._terms(r.reshape(-1)), self._distances.tolist(), strict=True
        ):
            total += factor * (distance - share * phi)
        return plain(total.reshape(r.shape))

    def __repr__(self) -> str:
        return (
            f"AsperityFields(displacement={self.displacement:g}, force={self.force:g}, "
            f"stick_radius={self.stick_radius:g}, terms={self._factors.size})"
        )


def distances(name: str, value: ArrayLike) -> Floats:
    """Check distances from the centre of the contact [m], which must not be negative."""
    r = floats(name, value, "m")
    if r.min() < 0.0:
        raise InputError(f"`{name}` must not be negative [m], got {r.min():g}")
    return r


def bodies(pair: MaterialPair, body: BodyName | None) -> tuple[Material, ...]:
    """Return the material of the selected body, or both materials for None."""
    if body is None:
        return pair.first, pair.second
    if body not in ("first", "second"):
        raise InputError(f'`body` must be "first", "second" or None, got {show(body)}')
    return (pair.first,) if body == "first" else (pair.second,)


def shares(pair: MaterialPair, body: BodyName | None) -> tuple[float, float]:
    """Return the factors [1/Pa] of phi and psi in the surface displacement, summed over bodies."""
    materials = bodies(pair, body)
    along = sum((2.0 - m.poisson_ratio) / m.shear_modulus for m in materials)
    across = sum(m.poisson_ratio / m.shear_modulus for m in materials)
    return along / (4.0 * math.pi), across / (4.0 * math.pi)


def potentials(k: float, outer: float, removed: float, r: Floats) -> tuple[Floats, Floats]:
    """Return potential and deviator (see the module) of one Cattaneo term at distances r [m].

    ``k`` is the factor [Pa/m] of the Hertz pressure, ``outer`` is a, and ``removed`` is a^2 - c^2.
    """
    inner = math.sqrt(max(outer * outer - removed, 0.0))
    far = np.maximum(r, np.finfo(float).tiny)  # the sine is 1 at the centre
    sine, edge = np.minimum(inner / far, 1.0), np.minimum(outer / far, 1.0)
    first, last = np.arcsin(sine), np.arcsin(edge)
    angle = first[:, None] + (last - first)[:, None] * _NODES
    g = np.maximum(outer**2 - (r[:, None] * np.sin(angle)) ** 2, 0.0)
    width = last - first
    phi = removed * first + width * (g @ _WEIGHTS)
    # cos(2p) integrates to sin(p) cos(p), which is 0 in the stick circle.
    cosine = np.sqrt((1.0 - sine) * (1.0 + sine))
    psi = removed * sine * cosine + width * ((g * np.cos(2.0 * angle)) @ _WEIGHTS)
    return math.pi * k * phi, math.pi * k * psi
