"""Fields of one asperity: zones, tractions and surface displacements.

The solutions of Boussinesq and Cerruti (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.6)
need two integrals of a layer q(r): its potential and its deviator at distance r from the centre,

    phi(r)            = integral of q / distance dA,
    psi(r) cos(2 angle) = integral of q (x^2 - y^2) / distance^3 dA,

where x and y are the components of the distance. psi is the mean of phi over the disc of radius r
minus phi at its edge. For a Hertz layer with the Hertz layer of the stick circle removed,

    q(r) = k [sqrt(a^2 - r^2) - sqrt(c^2 - r^2)]   (0 for the root of a negative number),

both are integrals of one positive function g(t) = min(a^2 - t^2, a^2 - c^2), t < a:

    phi = pi k integral of g(r sin p) dp,   psi = pi k integral of g(r sin p) cos(2p) dp

over 0 <= p <= pi/2. Both are free of cancellation far from the contact and for c close to a.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, plain, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.quadrature import gauss_legendre
from microslip.contact.materials import Material, MaterialPair

# g is a polynomial of sines, for which this rule is exact to rounding on a quarter turn.
_NODES, _WEIGHTS = gauss_legendre(16)

Body = Literal["first", "second"]


class Zone(NamedTuple):
    """Circle or ring of the contact with a common slip history (19.9), (19.18)."""

    kind: Literal["stick", "stuck", "slip"]
    """``stick``: has not slipped since rest; ``stuck``: has, but not since the last reversal;
    ``slip``: slips now."""
    inner: float
    """Inner radius [m]."""
    outer: float
    """Outer radius [m]."""
    direction: int
    """Direction of the last slip, 1 or -1; 0 if the zone has not slipped."""


class _SphereContact(Protocol):
    """Interface of a sphere pressed on a flat, see :class:`microslip.Asperity`."""

    @property
    def pair(self) -> MaterialPair: ...

    @property
    def friction_coefficient(self) -> float: ...

    @property
    def contact_radius(self) -> float: ...

    @property
    def slip_limit(self) -> float: ...

    @property
    def _pressure_factor(self) -> float: ...


@dataclass(frozen=True, eq=False, repr=False)
class AsperityFields(Locked):
    """State of one asperity at the end of a record; the result of :meth:`Asperity.fields`.

    Notes
    -----
    Each remembered move since rest contributes one Cattaneo term: the difference of two Hertz
    tractions mu p, of the contact and of the circle of radius c that did not slip in this move. The
    first term counts once, later terms twice, with alternating signs (Mindlin and Deresiewicz,
    J. Appl. Mech. 20, 327, 1953). The force (19.13)-(19.24) and all fields are therefore short sums
    for any record.
    """

    asperity: _SphereContact
    """The asperity."""
    displacement: float
    """Tangential displacement at the end of the record [m]."""
    force: float
    """Tangential force at the end of the record [N]."""
    _distances: NDArray[np.float64]
    """Distance of each move from its reversal, halved for all but the first [m]."""
    _factors: NDArray[np.float64]
    """Factor of each term: 1 or -1 for the first, then 2 and -2 alternating."""

    # -- zones ----------------------------------------------------------------------------------

    @cached_property
    def _removed(self) -> list[float]:
        """Radius term a^2 - c^2 of each move [m^2], decreasing: later slip is shallower."""
        share = np.minimum(self._distances / self.asperity.slip_limit, 1.0)
        removed: list[float] = (share * self.asperity.contact_radius**2).tolist()
        return removed

    def _radius(self, term: int) -> float:
        return math.sqrt(max(self.asperity.contact_radius**2 - self._removed[term], 0.0))

    @property
    def stick_radius(self) -> float:
        """Radius c [m] of the circle that currently sticks (19.9); 0 in gross slip.

        On first loading (c/a)^3 = 1 - |T|/mu N; after a reversal at T_r, 1 - |T - T_r|/2 mu N.
        """
        return self._radius(-1)

    @property
    def unslipped_radius(self) -> float:
        """Radius [m] of the circle that has not slipped since rest, c* in (19.18)."""
        return self._radius(0)

    @property
    def reversed_slip_radius(self) -> float:
        """Inner radius c' [m] of the slip after the first reversal (19.18).

        (c'/a)^3 = 1 - |T - T_r|/2 mu N with T at the end of this move. The contact radius if there
        was no reversal.
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
        """Compute the tangential traction q(r) along the force, at most mu p (Figs. 19.2, 19.3).

        Parameters
        ----------
        radius : array_like
            Distances r from the centre of the contact [m], not negative, any shape.

        Returns
        -------
        float or ndarray
            Tractions [Pa], shape of ``radius``; 0 outside the contact. Their integral over the
            contact area is the force.
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
        """Yield factor, potential and deviator of each term, for one-dimensional distances."""
        joint = self.asperity
        grade = joint._pressure_factor * joint.friction_coefficient
        for factor, removed in zip(self._factors.tolist(), self._removed, strict=True):
            yield factor, *potentials(grade, joint.contact_radius, removed, r)

    def surface_displacement(
        self, x: ArrayLike, y: ArrayLike = 0.0, body: Body | None = None
    ) -> tuple[Any, Any]:
        """Compute the tangential surface displacement, inside and outside the contact.

        Parameters
        ----------
        x, y : array_like
            Coordinates [m] from the centre, x along the force; shapes that broadcast.
        body : {"first", "second"}, optional
            Body whose displacement is computed, positive along the force on it. By default the sum
            of both bodies, which is the displacement of the asperity in the unslipped circle.

        Returns
        -------
        u_x, u_y : float or ndarray
            Displacements along and across the force [m], relative to distant points of each body.

        Notes
        -----
        Cerruti's solution, summed over the terms of the traction. Within one Hertz layer it agrees
        with Johnson, Contact Mechanics (1985, DOI 10.1017/CBO9781139171731), section 3.6. The sum
        of u_y is slip across the force, neglected by Cattaneo and Mindlin: on first loading at most
        nu/(4 - 2 nu) of u_x in the contact.
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
        """Compute the slip [m] since rest along the force, averaged over the angle.

        The displacement minus the surface displacements of both bodies: 0 in the unslipped circle,
        and outside the contact the relative displacement of facing points. Distances [m] are as
        :meth:`traction` has them.

        Notes
        -----
        On first loading the integral of mu p times the slip is the dissipated energy, a quarter of
        that of the cycle (19.29).
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
    """Check distances from the centre [m], which must not be negative."""
    r = floats(name, value, "m")
    if r.min() < 0.0:
        raise InputError(f"`{name}` must not be negative [m], got {r.min():g}")
    return r


def bodies(pair: MaterialPair, body: Body | None) -> tuple[Material, ...]:
    """Return the materials of the selected body, or of both."""
    if body is None:
        return pair.first, pair.second
    if body not in ("first", "second"):
        raise InputError(f'`body` must be "first", "second" or None, got {show(body)}')
    return (pair.first,) if body == "first" else (pair.second,)


def shares(pair: MaterialPair, body: Body | None) -> tuple[float, float]:
    """Return the factors of potential and deviator of a traction [1/Pa], summed over bodies."""
    materials = bodies(pair, body)
    along = sum((2.0 - m.poisson_ratio) / m.shear_modulus for m in materials)
    across = sum(m.poisson_ratio / m.shear_modulus for m in materials)
    return along / (4.0 * math.pi), across / (4.0 * math.pi)


def potentials(k: float, outer: float, removed: float, r: Floats) -> tuple[Floats, Floats]:
    """Return potential and deviator of the Hertz layer minus that of the stick circle."""
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
