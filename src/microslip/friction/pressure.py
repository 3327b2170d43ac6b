"""Uneven pressure of a joint: its distribution, and the law of the whole joint."""

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
"""Rings of a smooth distribution: Gauss nodes over the area."""
_MOST_PIECES = 200
_MAX_COUNT = 10_000  # rings, or places that are alike
_PANEL = 4  # nodes between two points of a table


@dataclass(frozen=True)
class BoltSize:
    """Dimensions of a metric bolt with its nut and washers [m]."""

    diameter: float
    pitch: float
    head: float
    """Least bearing diameter d_w of head and nut (ISO 4014)."""
    hole: float
    """Clearance hole, medium series (ISO 273)."""
    flats: float
    """Width s across the flats of head and nut (ISO 4014, ISO 4032)."""
    heights: float
    """Heights k of the head and m of the nut, together."""
    washer: float
    """Outer diameter of the washers (ISO 7089)."""
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
"""Hexagon bolts with nuts and plain washers by their size."""


@dataclass(frozen=True, eq=False, repr=False)
class Pressure(ByValue, Locked):
    """Distribution of a normal load over the faces: areas, and pressure on each for a unit load.

    Made by :meth:`cone`, :meth:`parabola`, :meth:`annulus`, :meth:`bolt`, :meth:`table` or
    :meth:`patches`.

    Parameters
    ----------
    areas : ndarray
        Areas that are pressed alike [m^2].
    shares : ndarray
        Share of the load on each [-], all above zero; they sum to 1.
    distances : ndarray, optional
        Distance of each from the axis [m], where there is one.
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
                f"{', '.join(arrays)} must be lists of one length, got shapes "
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
        """Area that is pressed at all [m^2]."""
        return math.fsum(self.areas)

    @property
    def concentration(self) -> float:
        """Largest pressure over the mean on the pressed area [-]."""
        return float((self.shares / self.areas).max() * self.area)

    # -- round ones -------------------------------------------------------------------------------

    @classmethod
    def cone(
        cls, outer: float, inner: float = 0.0, *, count: int = 1, rings: int = RINGS
    ) -> Pressure:
        """Pressure that falls along a straight line, from an inner radius to none at the outer one.

        Parameters
        ----------
        outer, inner : float
            Radii [m] between which the faces are pressed; the inner one is that of a hole, if any.
        count : int, optional
            Number of such contacts, equal and far enough apart.
        rings : int, optional
            Rings that stand for the whole: 32 are good to 1e-11 in the energy, 8 to 1e-6.
        """
        return cls._ring("cone", lambda t: 1.0 - t, outer, inner, count, rings)

    @classmethod
    def parabola(
        cls, outer: float, inner: float = 0.0, *, count: int = 1, rings: int = RINGS
    ) -> Pressure:
        """The same along a parabola with its top at the inner radius.

        As 1 - ((r - r_i)/(r_o - r_i))^2, between radii [m] as of :meth:`cone`.
        """
        return cls._ring("parabola", lambda t: 1.0 - t * t, outer, inner, count, rings)

    @classmethod
    def annulus(cls, outer: float, inner: float = 0.0, *, count: int = 1) -> Pressure:
        """An even pressure on a ring, or on a disc: radii [m] and count as of :meth:`cone`."""
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
        """Pressure of a bolt between two plates: a cone by Rötscher's rule.

        Parameters
        ----------
        size : str
            "M3" to "M36", which gives hole and head.
        plates : sequence of float
            Thickness of both plates [m].
        count : int, optional
            Number of bolts.
        hole, head : float, optional
            Diameters of the hole and of what presses on the plates, head or washer [m].
        angle : float, optional
            Half angle of the pressure cone [rad]; 30 degrees.
        edge : float, optional
            Diameter at which the plates end [m].
        rings : int, optional
            As of :meth:`cone`.

        Returns
        -------
        Pressure
            On the ring from the hole to (head + 2 t tan(angle))/2 with t the thinner plate, falling
            along a straight line to none there, or cut at the edge.

        Notes
        -----
        The pressure of a head spreads as a cone of about 30 degrees from either side (see Wileman,
        Choudhury and Green 1991, DOI 10.1115/1.2912801), so where plates of unlike thickness meet,
        the nearer side decides.
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
                "a bolt must fit into its hole, its head must cover that, and the angle is below a "
                f"right one, got diameter {exact(bolt.diameter)}, hole {exact(hole)}, head "
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
        # Denser towards the rim, where the pressure ends.
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

    # -- measured or computed ---------------------------------------------------------------------

    @classmethod
    def table(cls, distance: ArrayLike, pressure: ArrayLike, *, count: int = 1) -> Pressure:
        """Round, by pressures at distances from the axis, straight between them.

        Parameters
        ----------
        distance : array_like
            Distances [m], one-dimensional, rising, the first not negative: two at least.
        pressure : array_like
            Pressures there, of any scale: only how they compare counts; not negative, some above
            zero.
        count : int, optional
            Number of such contacts.
        """
        r, p = record("distance", distance, "m").reshape(-1), _pressures(pressure)
        if r.size != p.size or r.size < 2:
            raise InputError(
                "`distance` and pressure must be two lists of one length, two at least, got "
                f"{r.size} and {p.size}"
            )
        if r[0] < 0.0 or not np.all(np.diff(r) > 0.0):
            raise InputError("`distance` must rise from zero or more [m]")
        # Within each of the pieces, or a few together, by Gauss in the area.
        edges = r if r.size <= _MOST_PIECES else np.interp(
            np.linspace(0.0, r.size - 1.0, _MOST_PIECES), np.arange(r.size), r
        )  # fmt: skip
        share, weight = gauss_legendre(_PANEL)
        squares = edges * edges
        nodes = squares[:-1, None] + np.diff(squares)[:, None] * share
        areas = (math.pi * np.diff(squares)[:, None] * weight).reshape(-1)
        places = np.sqrt(nodes).reshape(-1)
        loads = areas * np.interp(places, r, p)
        return cls._pressed(
            whole_number("count", count, 1, _MAX_COUNT) * areas, loads, places, "table"
        )

    @classmethod
    def patches(cls, area: ArrayLike, pressure: ArrayLike) -> Pressure:
        """Patches of a film or of a finite-element model, each with its area and pressure.

        Parameters
        ----------
        area : array_like
            Areas [m^2] of any shape, above zero; or one for all.
        pressure : array_like
            Pressures, of any scale, not negative, some above zero.
        """
        a, p = floats("area", area, "m^2").reshape(-1), _pressures(pressure)
        if a.size not in (1, p.size) or not (a.min() > 0.0 and a.max() <= LARGEST):
            raise InputError(
                f"`area` must be one above zero [m^2], or one for each of the {p.size} "
                f"pressures, got {show(area)}"
            )
        a = np.broadcast_to(a, p.shape).copy()
        return cls._pressed(a, a * p, None, "patches")

    @classmethod
    def _pressed(cls, areas: Floats, loads: Floats, places: Floats | None, kind: str) -> Pressure:
        """Without what bears nothing, or next to nothing."""
        bears = loads > 1e-12 * loads.sum() * areas / areas.sum()
        if not bears.any():
            raise InputError("`pressure` must be above zero somewhere, got none")
        load = loads[bears]
        return cls(areas[bears], load / load.sum(), None if places is None else places[bears], kind)

    def __repr__(self) -> str:
        return (
            f"Pressure({self.kind!r}, area={self.area:g}, concentration={self.concentration:.4g})"
        )


def _radii(outer: float, inner: float) -> tuple[float, float]:
    outer = positive("outer", outer, "m", 0.01)
    inner = number("inner", inner, "m", 0.003)
    if not 0.0 <= inner < outer:
        raise InputError(
            f"`inner` must be zero or more and below outer, {exact(outer)} m, got {exact(inner)}"
        )
    return outer, inner


def _pressures(pressure: ArrayLike) -> Floats:
    p = floats("pressure", pressure, "Pa").reshape(-1)
    if p.min() < 0.0:
        raise InputError(f"`pressure` must not be negative, got {exact(p.min())}")
    if p.max() > LARGEST:
        raise InputError(f"`pressure` must be at most {LARGEST:g}, got {exact(p.max())}")
    return p
