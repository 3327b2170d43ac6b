"""Distributions of a nonuniform pressure over a joint."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.by_value import ByValue
from microslip._core.checks import (
    LARGEST,
    Floats,
    exact,
    floats,
    number,
    positive,
    positives,
    record,
    show,
    whole_number,
)
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip._core.quadrature import gauss_legendre
from microslip._core.wording import did_you_mean, quoted

RINGS = 32
"""Default number of rings of a smooth distribution: Gauss nodes over the area."""
_MAX_COUNT = 10_000  # rings, or equal contacts


@dataclass(frozen=True)
class BoltSize:
    """Dimensions of a metric bolt with its nut and washers [m].

    Heads of ISO 4014:2011, nuts of ISO 4032:2012 (style 1), washers of ISO 7089:2000 (normal
    series), holes of ISO 273:1979 and coarse threads of ISO 261:1998; largest values within
    tolerance, except for the bearing diameter, the smallest.
    """

    diameter: float
    pitch: float
    head: float
    """Smallest bearing diameter d_w of the head."""
    hole: float
    """Clearance hole, medium series."""
    flats: float
    """Width s across the flats of head and nut."""
    heights: float
    """Sum of the heights k of the head and m of the nut."""
    washer: float
    """Outer diameter of the washers."""
    washer_thickness: float


def _size(*millimetres: float) -> BoltSize:
    return BoltSize(*(1e-3 * value for value in millimetres))


BOLTS = MappingProxyType(
    {
        "M3": _size(3, 0.5, 4.57, 3.4, 5.5, 4.4, 7, 0.5),
        "M4": _size(4, 0.7, 5.88, 4.5, 7, 6, 9, 0.8),
        "M5": _size(5, 0.8, 6.88, 5.5, 8, 8.2, 10, 1),
        "M6": _size(6, 1.0, 8.88, 6.6, 10, 9.2, 12, 1.6),
        "M8": _size(8, 1.25, 11.63, 9.0, 13, 12.1, 16, 1.6),
        "M10": _size(10, 1.5, 14.63, 11.0, 16, 14.8, 20, 2),
        "M12": _size(12, 1.75, 16.63, 13.5, 18, 18.3, 24, 2.5),
        "M14": _size(14, 2.0, 19.64, 15.5, 21, 21.6, 28, 2.5),
        "M16": _size(16, 2.0, 22.49, 17.5, 24, 24.8, 30, 3),
        "M20": _size(20, 2.5, 28.19, 22.0, 30, 30.5, 37, 3),
        "M24": _size(24, 3.0, 33.61, 26.0, 36, 36.5, 44, 4),
        "M30": _size(30, 3.5, 42.75, 33.0, 46, 44.3, 56, 4),
        "M36": _size(36, 4.0, 51.11, 39.0, 55, 53.5, 66, 5),
    }
)
"""Hexagon bolts with nuts and plain washers by size."""


@dataclass(frozen=True, eq=False, repr=False)
class Pressure(ByValue, Locked):
    """Distribution of a normal load: areas, and the fraction of the load on each.

    Parameters
    ----------
    areas : ndarray
        Areas of equal pressure [m^2], one-dimensional.
    shares : ndarray
        Fraction of the load on each area [-], above zero, with sum 1.
    distances : ndarray, optional
        Distance of each area from the axis [m], for axisymmetric distributions.
    kind : str, optional
        Name of the distribution.
    """

    areas: Floats
    shares: Floats
    distances: Floats | None = None
    kind: str = "patches"

    def __post_init__(self) -> None:
        arrays = {"areas": positives("areas", self.areas, "m^2")}
        arrays["shares"] = positives("shares", self.shares)
        if self.distances is not None:
            arrays["distances"] = floats("distances", self.distances, "m")
        shapes = [array.shape for array in arrays.values()]
        if arrays["areas"].ndim != 1 or len(set(shapes)) > 1:
            raise InputError(
                f"{', '.join(arrays)} must be sequences of the same length, got shapes "
                f"{', '.join(map(str, shapes))}; write ms.Pressure.patches([1e-4], [1.0])"
            )
        if abs(math.fsum(arrays["shares"]) - 1.0) > 1e-9:
            raise InputError(
                f"`shares` must sum to 1, got {math.fsum(arrays['shares']):.10g}; "
                "Pressure.patches takes pressures of any scale"
            )
        if not isinstance(self.kind, str):
            raise InputError(f"`kind` must be text, got {show(self.kind)}")
        assign(self, **{name: lock(array) for name, array in arrays.items()})

    @property
    def area(self) -> float:
        """Total pressed area [m^2]."""
        return math.fsum(self.areas)

    @property
    def concentration(self) -> float:
        """Largest pressure over the mean pressure of the pressed area [-]."""
        return float((self.shares / self.areas).max() * self.area)

    @classmethod
    def cone(
        cls, outer: float, inner: float = 0.0, *, count: int = 1, rings: int = RINGS
    ) -> Pressure:
        """Return a pressure that decreases linearly from the inner radius to zero at the outer one.

        Parameters
        ----------
        outer, inner : float
            Outer and inner radius of the pressed ring [m].
        count : int, optional
            Number of equal contacts that share the load.
        rings : int, optional
            Number of rings. The relative error of the energy is 1e-11 with 32 and 1e-6 with 8.
        """
        return cls._ring("cone", lambda t: 1.0 - t, outer, inner, count, rings)

    @classmethod
    def parabola(
        cls, outer: float, inner: float = 0.0, *, count: int = 1, rings: int = RINGS
    ) -> Pressure:
        """Return a parabolic pressure with its maximum at the inner radius.

        p ~ 1 - ((r - r_i)/(r_o - r_i))^2 at radius r. Other arguments are as for :meth:`cone` [m].
        """
        return cls._ring("parabola", lambda t: 1.0 - t * t, outer, inner, count, rings)

    @classmethod
    def annulus(cls, outer: float, inner: float = 0.0, *, count: int = 1) -> Pressure:
        """Return a uniform pressure on a ring or disc; arguments as for :meth:`cone` [m]."""
        outer, inner = _radii(outer, inner)
        area = (
            whole_number("count", count, 1, _MAX_COUNT)
            * math.pi
            * (outer - inner)
            * (outer + inner)
        )
        return cls(np.array([area]), np.ones(1), np.array([0.5 * (outer + inner)]), "annulus")

    @classmethod
    def bolt(
        cls,
        size: str,
        plates: Sequence[float],
        *,
        count: int = 1,
        hole: float | None = None,
        head: float | None = None,
        angle: float = math.radians(30.0),
        edge: float | None = None,
        rings: int = RINGS,
    ) -> Pressure:
        """Return the pressure between two bolted plates: a cone after Rötscher.

        Parameters
        ----------
        size : str
            "M3" to "M36", which determines the default ``hole`` and ``head``.
        plates : sequence of float
            Thickness of both plates [m].
        count : int, optional
            Number of bolts.
        hole, head : float, optional
            Diameters of the hole and of the bearing face of head or washer [m].
        angle : float, optional
            Half angle of the pressure cone [rad], by default 30 degrees.
        edge : float, optional
            Diameter of the plates [m], unlimited by default.
        rings : int, optional
            As for :meth:`cone`.

        Returns
        -------
        Pressure
            Decreasing linearly from the hole to zero at the radius (head + 2 t tan(angle))/2, with
            the thickness t of the thinner plate; truncated at the edge.

        Notes
        -----
        The pressure of a head spreads in a cone of about 30 degrees from either side (see Wileman,
        Choudhury and Green 1991, DOI 10.1115/1.2912801), so for plates of different thickness the
        thinner plate determines the radius.
        """
        if not isinstance(size, str) or size not in BOLTS:
            near = did_you_mean(size, BOLTS) if isinstance(size, str) else ""
            raise InputError(f"`size` must be one of {quoted(BOLTS)}, got {show(size)}{near}")
        thick = record("plates", plates, "m").reshape(-1)
        if thick.size != 2 or not thick.min() > 0.0:
            raise InputError(f"`plates` must be two thicknesses above zero [m], got {show(plates)}")
        bolt = BOLTS[size]
        hole = positive("hole", bolt.hole if hole is None else hole, "m", 9e-3)
        head = positive("head", bolt.head if head is None else head, "m", 12e-3)
        angle = positive("angle", angle, "rad", 0.5)
        if not bolt.diameter < hole < head or angle >= 0.5 * math.pi:
            raise InputError(
                "`hole` must be above the bolt diameter and below `head`, and `angle` below "
                f"pi/2, got diameter {exact(bolt.diameter)}, hole {exact(hole)}, head "
                f"{exact(head)} [m], angle {exact(angle)} [rad]"
            )
        rim = head + 2.0 * float(thick.min()) * math.tan(angle)
        end = rim if edge is None else min(positive("edge", edge, "m", 0.03), rim)
        if end <= hole:
            raise InputError(f"`edge` must be above the hole, {exact(hole)} m, got {exact(end)}")
        cut = (end - hole) / (rim - hole)
        return cls._ring("bolt", lambda t: 1.0 - cut * t, 0.5 * end, 0.5 * hole, count, rings)

    @classmethod
    def _ring(
        cls, kind: str, shape: Any, outer: float, inner: float, count: int, rings: int
    ) -> Pressure:
        outer, inner = _radii(outer, inner)
        share, weight = gauss_legendre(whole_number("rings", rings, 1, _MAX_COUNT))
        # Nodes are clustered towards the rim.
        t = share * (2.0 - share)
        weight = weight * 2.0 * (1.0 - share)
        r = inner + (outer - inner) * t
        areas = (
            whole_number("count", count, 1, _MAX_COUNT)
            * 2.0
            * math.pi
            * (outer - inner)
            * weight
            * r
        )
        loads = areas * shape(t)
        return cls(areas, loads / loads.sum(), r, kind)

    @classmethod
    def patches(cls, area: ArrayLike, pressure: ArrayLike) -> Pressure:
        """Return a measured or computed pressure, given for patches.

        Parameters
        ----------
        area : array_like
            Areas of the patches [m^2], above zero: a number or any shape.
        pressure : array_like
            Pressures in any unit (only ratios matter), not negative, not all zero.
        """
        a, p = floats("area", area, "m^2").reshape(-1), _pressures(pressure)
        if a.size not in (1, p.size) or not (a.min() > 0.0 and a.max() <= LARGEST):
            raise InputError(
                f"`area` must be one area above zero [m^2], or one for each of the {p.size} "
                f"pressures, got {show(area)}"
            )
        a = np.broadcast_to(a, p.shape).copy()
        loads = a * p
        # Areas of less than 1e-12 times the mean pressure are left out.
        bears = loads > 1e-12 * loads.sum() * a / a.sum()
        if not bears.any():
            raise InputError("`pressure` must have a value above zero, got none")
        load = loads[bears]
        return cls(a[bears], load / load.sum())

    def __repr__(self) -> str:
        return (
            f"Pressure({self.kind!r}, area={self.area:g}, concentration={self.concentration:.4g})"
        )


def _radii(outer: float, inner: float) -> tuple[float, float]:
    outer = positive("outer", outer, "m", 0.01)
    inner = number("inner", inner, "m", 0.003)
    if not 0.0 <= inner < outer:
        raise InputError(
            f"`inner` must be zero or more and below `outer`, {exact(outer)} m, got {exact(inner)}"
        )
    return outer, inner


def _pressures(pressure: ArrayLike) -> Floats:
    p = floats("pressure", pressure, "Pa").reshape(-1)
    if p.min() < 0.0:
        raise InputError(f"`pressure` must not be negative, got {exact(p.min())}")
    if p.max() > LARGEST:
        raise InputError(f"`pressure` must be at most {LARGEST:g}, got {exact(p.max())}")
    return p
