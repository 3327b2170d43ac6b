"""A joint that is pressed unevenly: how the pressure is spread, and the law of all of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, plain, positive, record, show, whole
from microslip._core.frozen import Locked, lock
from microslip._core.wording import did_you_mean, quoted
from microslip.errors import Argument, InputError
from microslip.friction.base import BackboneLaw
from microslip.friction.bolt_sizes import BOLTS
from microslip.friction.interface import Interface
from microslip.friction.parallel import Parallel
from microslip.friction.validity import RULES, Verdict
from microslip.materials import MaterialPair
from microslip.normal import NormalLaw
from microslip.numerics.quadrature import gauss_legendre

RINGS = 32
"""Rings of a smooth distribution: Gauss nodes over the area."""
_MOST_PIECES = 200
_MOST = 10_000  # rings, or places that are alike
_PANEL = 4  # nodes between two points of a table


@dataclass(frozen=True, eq=False, repr=False)
class Pressure(Locked):
    """How a normal load is spread over the faces: areas, and the pressure on each for a unit load.

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
        What it is called.

    Raises
    ------
    InputError
        From what makes it: radii, plates or pressures that hold no pressure.
    """

    areas: Floats
    shares: Floats
    distances: Floats | None = None
    kind: str = "patches"

    def __post_init__(self) -> None:
        for array in (self.areas, self.shares, self.distances):
            if array is not None:
                lock(array)

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
            How many such, equal and far enough apart.
        rings : int, optional
            Rings that stand for the whole: 32 are good to 1e-11 in the energy, 8 to 1e-6.

        Raises
        ------
        InputError
            Radii that do not hold a ring, no whole number.
        """
        return cls._ring("cone", lambda t: 1.0 - t, outer, inner, count, rings)

    @classmethod
    def parabola(
        cls, outer: float, inner: float = 0.0, *, count: int = 1, rings: int = RINGS
    ) -> Pressure:
        """The same along a parabola with its top at the inner radius.

        As 1 - ((r - r_i)/(r_o - r_i))^2, between radii [m] as of :meth:`cone`.

        Raises
        ------
        InputError
            Radii that do not hold a ring, no whole number.
        """
        return cls._ring("parabola", lambda t: 1.0 - t * t, outer, inner, count, rings)

    @classmethod
    def annulus(cls, outer: float, inner: float = 0.0, *, count: int = 1) -> Pressure:
        """An even pressure on a ring, or on a disc.

        Parameters
        ----------
        outer, inner : float
            Radii [m] between which the faces are pressed.
        count : int, optional
            How many such, equal and far enough apart.

        Raises
        ------
        InputError
            Radii that do not hold a ring, no whole number.
        """
        outer, inner = _radii(outer, inner)
        area = whole("count", count, 1, _MOST) * math.pi * (outer - inner) * (outer + inner)
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
        """What a bolt presses where two plates meet: a cone by Rötscher's rule.

        Parameters
        ----------
        size : str
            "M3" to "M36", which gives hole and head.
        plates : sequence of float
            Thickness of both plates [m].
        count : int, optional
            How many bolts.
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

        Raises
        ------
        InputError
            Another size; lengths that do not fit into each other.

        Notes
        -----
        The pressure of a head spreads as a cone of about 30 degrees from either side (see Wileman,
        Choudhury and Green 1991, DOI 10.1115/1.2912801), so where plates of unlike thickness meet,
        the nearer side decides.
        """
        if not isinstance(size, str) or size not in BOLTS:
            near = did_you_mean(size, BOLTS) if isinstance(size, str) else ""
            raise InputError(
                Argument("size"), f" must be one of {quoted(BOLTS)}, got {show(size)}{near}"
            )
        thick = record("plates", plates).reshape(-1)
        if thick.size != 2 or not thick.min() > 0.0:
            raise InputError(
                Argument("plates"), f" must be two thicknesses above zero [m], got {show(plates)}"
            )
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
            raise InputError(
                Argument("edge"), f" must be above the hole, {exact(hole)} m, got {exact(end)}"
            )
        cut = (end - hole) / (rim - hole)
        return cls._ring("bolt", lambda t: 1.0 - cut * t, 0.5 * end, 0.5 * hole, count, rings)

    @classmethod
    def _ring(
        cls, kind: str, shape: Any, outer: float, inner: float, count: int, rings: int
    ) -> Pressure:
        outer, inner = _radii(outer, inner)
        share, weight = gauss_legendre(whole("rings", rings, 1, _MOST))
        # Denser towards the rim, where the pressure ends.
        t = share * (2.0 - share)
        weight = weight * 2.0 * (1.0 - share)
        r = inner + (outer - inner) * t
        areas = whole("count", count, 1, _MOST) * 2.0 * math.pi * (outer - inner) * weight * r
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
            How many such.

        Raises
        ------
        InputError
            Lengths that differ, distances that do not rise, a negative pressure, no pressure.
        """
        r, p = record("distance", distance).reshape(-1), _pressures(pressure)
        if r.size != p.size or r.size < 2:
            raise InputError(
                Argument("distance"),
                f" and pressure must be two lists of one length, two at least, got {r.size} and "
                f"{p.size}",
            )
        if r[0] < 0.0 or not np.all(np.diff(r) > 0.0):
            raise InputError(Argument("distance"), " must rise from zero or more [m]")
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
        return cls._pressed(whole("count", count, 1, _MOST) * areas, loads, places, "table")

    @classmethod
    def patches(cls, area: ArrayLike, pressure: ArrayLike) -> Pressure:
        """Patches of a film or of a finite-element model, each with its area and pressure.

        Parameters
        ----------
        area : array_like
            Areas [m^2] of any shape, above zero; or one for all.
        pressure : array_like
            Pressures, of any scale, not negative, some above zero.

        Raises
        ------
        InputError
            Lengths that differ, an area not above zero, a negative pressure, no pressure.
        """
        a, p = floats("area", area).reshape(-1), _pressures(pressure)
        if a.size not in (1, p.size) or not a.min() > 0.0:
            raise InputError(
                Argument("area"),
                f" must be one above zero [m^2], or one for each of the {p.size} pressures, got "
                f"{show(area)}",
            )
        a = np.broadcast_to(a, p.shape).copy()
        return cls._pressed(a, a * p, None, "patches")

    @classmethod
    def _pressed(cls, areas: Floats, loads: Floats, places: Floats | None, kind: str) -> Pressure:
        """Without what bears nothing, or next to nothing."""
        bears = loads > 1e-12 * loads.sum() * areas / areas.sum()
        if not bears.any():
            raise InputError(Argument("pressure"), " must be above zero somewhere, got none")
        held = loads[bears]
        return cls(areas[bears], held / held.sum(), None if places is None else places[bears], kind)

    def __repr__(self) -> str:
        return (
            f"Pressure({self.kind!r}, area={self.area:g}, concentration={self.concentration:.4g})"
        )


def _radii(outer: float, inner: float) -> tuple[float, float]:
    outer = positive("outer", outer, "m", 0.01)
    inner = float(floats("inner", inner)) if inner != 0.0 else 0.0
    if not 0.0 <= inner < outer:
        raise InputError(
            Argument("inner"),
            f" must be zero or more and below outer, {exact(outer)} m, got {exact(inner)}",
        )
    return outer, inner


def _pressures(pressure: ArrayLike) -> Floats:
    p = floats("pressure", pressure).reshape(-1)
    if p.min() < 0.0:
        raise InputError(Argument("pressure"), f" must not be negative, got {exact(p.min())}")
    return p


def _given(pressure: Any) -> Pressure:
    """A distribution of pressure, and nothing else."""
    if isinstance(pressure, Pressure):
        return pressure
    raise InputError(
        Argument("pressure"),
        f" must be a Pressure, got {show(pressure)}; write ms.Pressure.cone(outer=0.01)",
    )


@dataclass(frozen=True, eq=False, repr=False)
class PressedJoint(Parallel):
    """A joint under a pressure that varies from place to place, while the body moves as one.

    Every place is at the separation that its pressure asks for, so the law is a sum of joints, one
    for each area that is pressed alike: a :class:`Parallel` law.

    Parameters
    ----------
    surface : NormalLaw
        A surface with an apparent area, which must hold what is pressed.
    friction_coefficient : float
        Coulomb's coefficient mu [-], above zero.
    pressure : Pressure
        How the load is spread.
    normal_load : float
        All of it [N].

    Raises
    ------
    InputError
        A surface without an area, or too small a one; a value out of its range; a load that the
        surface cannot carry where it is pressed most.

    Notes
    -----
    The sum of Ciavarella and Jaeger's superposition over the places, T0 = sum mu [N_p(d_p) -
    N_p(d_p + delta/kappa)] (DOI 10.1115/1.2833765). A tightened surface was tightened under the
    same distribution. The bodies beneath are rigid: what they give way is not in it.
    """

    laws: Sequence[BackboneLaw] = field(init=False, default=())
    surface: NormalLaw
    friction_coefficient: float
    pressure: Pressure
    normal_load: float

    def __post_init__(self) -> None:
        _given(self.pressure)
        load = positive("normal_load", self.normal_load, "N", 2000.0)
        object.__setattr__(self, "normal_load", load)
        mu = positive("friction_coefficient", self.friction_coefficient)
        object.__setattr__(self, "friction_coefficient", mu)
        apparent = getattr(self.surface, "area", None)
        if apparent is not None and self.pressure.area > apparent * (1.0 + 1e-9):
            raise InputError(
                Argument("pressure"),
                f" must lie within the area of the surface, {exact(apparent)} m^2, got one on "
                f"{self.pressure.area:.6g} m^2",
            )
        laws = tuple(
            Interface(self.surface._patch(area, share), mu, normal_load=share * load)
            for area, share in zip(
                self.pressure.areas.tolist(), self.pressure.shares.tolist(), strict=True
            )
        )
        object.__setattr__(self, "laws", laws)

    def at(self, *, normal_load: float) -> PressedJoint:
        """The same joint under another load [N], spread in the same way.

        Raises
        ------
        InputError
            A load that is not above zero, or that the surface cannot carry where pressed most.
        """
        return PressedJoint(self.surface, self.friction_coefficient, self.pressure, normal_load)

    # -- places -----------------------------------------------------------------------------------

    @cached_property
    def pressures(self) -> Floats:
        """Pressure [Pa] on each area of the distribution."""
        return lock(self.normal_load * self.pressure.shares / self.pressure.areas)

    @cached_property
    def separations(self) -> Floats:
        """Separation [m] of each."""
        return lock(np.array([law.separation for law in self._joints]))

    @property
    def _joints(self) -> tuple[Interface, ...]:
        return self.laws  # type: ignore[return-value]

    def slip_shares(self, displacement: float) -> Floats:
        """How near each place is to sliding at a displacement [m]: T/(mu N) there, 0 to 1.

        Raises
        ------
        InputError
            Not a finite number.
        """
        u = float(floats("displacement", displacement))
        return np.array([float(law.backbone(u)) / law.force_limit for law in self._joints])

    # -- all of it --------------------------------------------------------------------------------

    @cached_property
    def separation(self) -> float:
        """Separation [m] where the pressure is largest."""
        return float(self.separations[np.argmax(self.pressures)])

    @property
    def slip_per_indentation(self) -> float:
        """Kappa [-], the same everywhere."""
        return self._joints[0].slip_per_indentation

    @cached_property
    def normal_stiffness(self) -> float:
        """Normal stiffness [N/m] of the faces that move as one."""
        return math.fsum(law.normal_stiffness for law in self._joints)

    @cached_property
    def contact_count(self) -> float | None:
        """Summits in contact; None for a surface that does not know its contacts."""
        return self._total("contact_count")

    @cached_property
    def contact_area(self) -> float | None:
        """Real contact area [m^2]; None for a surface that does not know its contacts."""
        return self._total("contact_area")

    def _total(self, name: str) -> float | None:
        values = [getattr(law, name) for law in self._joints]
        return None if any(value is None for value in values) else math.fsum(values)

    def stick_area(self, displacement: ArrayLike) -> Any:
        """Contact area that still sticks on first loading [m^2].

        Parameters
        ----------
        displacement : array_like
            Displacements [m] of any shape, which the result has too.

        Raises
        ------
        InputError
            A displacement that is not finite.
        """
        x = floats("displacement", displacement)
        return plain(np.asarray(sum(np.asarray(law.stick_area(x)) for law in self._joints)))

    @property
    def validity(self) -> tuple[Verdict, ...]:
        """Verdicts where the pressure is largest; contacts are those of the whole joint."""
        worst = self._joints[int(np.argmax(self.pressures))]
        values = worst.surface._assumptions(worst.separation)
        if "contacts" in values:
            values["contacts"] = self.contact_count
        return tuple(rule.judge(values[rule.name]) for rule in RULES if rule.name in values)

    def __repr__(self) -> str:
        return (
            f"PressedJoint({type(self.surface).__name__}, {self.pressure!r}, "
            f"friction_coefficient={exact(self.friction_coefficient)}, "
            f"normal_load={exact(self.normal_load)})"
        )

    @classmethod
    def guess(
        cls,
        data: Any,
        *,
        pressure: Pressure | None = None,
        pair: MaterialPair | None = None,
        normal_load: ArrayLike | None = None,
        heights: Any = None,
        radius: float | None = None,
        area: float | None = None,
    ) -> PressedJoint:
        """A joint to start a fit from: that of :meth:`Interface.guess`, pressed as it is told.

        Parameters
        ----------
        data : Loop, Record or sequence of such
            What was measured: displacement [m] and force [N], at least one closed cycle each.
        pressure : Pressure
            How the load is spread, which must be given.
        pair, normal_load, heights, radius : optional
            As those of :meth:`Interface.guess`: lengths in [m], loads in [N].
        area : float, optional
            Apparent area of the surface [m^2]; without it that of the pressure.

        Returns
        -------
        PressedJoint
            At the geometric mean of the loads.

        Raises
        ------
        InputError
            No pressure, or one beyond the area; whatever :meth:`Interface.guess` refuses.
        """
        spread = _given(pressure)
        area = spread.area if area is None else area
        joint = Interface.guess(
            data, pair=pair, normal_load=normal_load, heights=heights, radius=radius, area=area
        )
        return cls(joint.surface, joint.friction_coefficient, spread, joint.normal_load)

    @classmethod
    def examples(cls) -> tuple[PressedJoint, ...]:
        """The project's worked example under a ring that is pressed on few places."""
        joint = Interface.examples()[0]
        spread = Pressure.patches([2e-5, 4e-5, 6e-5], [3.0, 2.0, 0.5])
        return (cls(joint.surface, joint.friction_coefficient, spread, 2000.0),)
