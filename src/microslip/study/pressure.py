"""Distribution of the normal load of a study over the faces."""

from __future__ import annotations

import math
from dataclasses import replace

from microslip._core.quantities import named
from microslip._core.units import AREA, FORCE, LENGTH, PRESSURE
from microslip.friction.pressure import BOLTS, RINGS, Pressure
from microslip.structures.bolt_tightening import BoltForces
from microslip.structures.bolts import Bolts
from microslip.study.bolt_forces import TightenedBolts
from microslip.study.fields import ANGLE, SHARE, Numbers, one_of, optional, quantity, whole_number
from microslip.study.part import Part, Table, key, tag
from microslip.study.readers import Items, KeyedError, Place
from microslip.study.uncertain import Unsure

_LENGTH = Unsure(quantity(LENGTH, "12 mm"))
_COUNT = whole_number(1, 10_000, "4")
_PRESSURES = Numbers(quantity(PRESSURE, "20 MPa", "any"), '["20 MPa", "12 MPa", "0 MPa"]')


class PressurePart(Part):
    """A distribution of pressure; the normal load says how large it is."""

    @property
    def load(self) -> float | None:
        """Normal load [N] that the distribution itself says, if it does."""
        return None

    @property
    def tightening(self) -> float | None:
        """The largest that it has been [N], if it says so."""
        return self.load

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        raise NotImplementedError

    def check(self, place: Place) -> None:
        """Refuse values that no distribution has."""
        self.spread()


class _Round(PressurePart):
    """Round, between two radii."""

    outer: float = key(_LENGTH, "Outer radius.", '"8 mm"')
    inner: float | None = key(
        _LENGTH, "Radius of the hole, if there is one.", '"4.5 mm"', default=None
    )
    count: int = key(_COUNT, "Number of such contacts, equal and separate.", default=1)

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        kind = self.tag_value("kind")
        options = {} if kind == "annulus" else {"rings": rings}
        pressure: Pressure = getattr(Pressure, kind)(
            self.outer, self.inner or 0.0, count=self.count, **options
        )
        return pressure


class ConePressure(_Round):
    """Pressure that falls along a straight line to none at the outer radius."""

    kind: str = tag("cone", "Falls along a straight line from the inner radius.")


class ParabolaPressure(_Round):
    """Pressure that falls along a parabola to none at the outer radius."""

    kind: str = tag("parabola", "Falls along a parabola from the inner radius.")


class AnnulusPressure(_Round):
    """An even pressure on a ring or a disc."""

    kind: str = tag("annulus", "Even between the radii.")


class TablePressure(PressurePart):
    """Round, by a table of pressures at distances from the axis; only how they compare counts."""

    kind: str = tag("table", "Tabulated over the distance from the axis.")
    distance: tuple[float, ...] = key(
        Numbers(quantity(LENGTH, "0 mm", "any"), '["0 mm", "5 mm", "10 mm"]'),
        "Distances, rising: a list or a column of a CSV file.",
    )
    pressure: tuple[float, ...] = key(
        _PRESSURES, "Pressures there: a list or a column of a CSV file."
    )
    count: int = key(_COUNT, "Number of such contacts, equal and separate.", default=1)

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        return Pressure.table(self.distance, self.pressure, count=self.count)


class PatchesPressure(PressurePart):
    """Patches of a pressure film or of a finite-element model."""

    kind: str = tag("patches", "Patches with their areas and pressures.")
    area: tuple[float, ...] = key(
        Numbers(quantity(AREA, "4 mm^2"), '["4 mm^2", "4 mm^2"]', single=True),
        "Area of each patch, or of all: a list or a column of a CSV file.",
    )
    pressure: tuple[float, ...] = key(
        _PRESSURES, "Pressure on each: a list or a column of a CSV file.", '["20 MPa", "12 MPa"]'
    )

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        return Pressure.patches(self.area, self.pressure)


class BoltPressure(TightenedBolts, PressurePart):
    """Pressure of bolts between two plates: a cone of 30 degrees from head and nut."""

    kind: str = tag("bolt", "By bolts through two plates.")
    size: str = key(one_of(*BOLTS), "Size of the bolts, which gives head and hole.", '"M8"')
    plates: tuple[float, ...] = key(
        Items(_LENGTH, '["10 mm", "10 mm"]', (1, 2)), "Thickness of both plates."
    )
    count: int = key(_COUNT, "How many bolts.", default=1)
    preload: float | None = optional(Bolts, "tension")
    nut_factor: float | None = optional(
        Bolts, "nut_factor", help="K of torque = K d tension; 0.2 if absent, without frictions."
    )
    axial_load: float | None = key(
        Unsure(quantity(FORCE, "2 kN")),
        "Axial load on each bolt, which parts the plates; all but the bolt's share relieves them.",
        default=None,
    )
    load_factor: float | None = key(
        Unsure(SHARE),
        "The bolt's share of it (VDI 2230's Phi); by the resiliences if absent, for a load that "
        "enters half-way (n = 0.5).",
        "0.1",
        default=None,
    )
    head: float | None = key(
        _LENGTH,
        "Bearing diameter of head, nut or washer on the plates.",
        '"16 mm"',
        default=None,
    )
    angle: float = key(
        Unsure(ANGLE), "Half angle of the cone.", '"30 deg"', default=math.radians(30.0)
    )
    edge: float | None = key(
        _LENGTH,
        "Diameter at which the plates end, or half-way to the next bolt.",
        '"30 mm"',
        default=None,
    )

    def check(self, place: Place) -> None:
        """A tension or a torque, and what both refuse."""
        self.spread()
        super().check(place)
        if self.preload is not None and self.torque is not None:
            raise KeyedError(".torque", "wanted preload or torque, got both; remove one")
        for name in ("embedding", "rz", "axial_load", "load_factor"):
            if self.preload is None and self.torque is None and getattr(self, name) is not None:
                raise KeyedError(f".{name}", "wanted only beside preload or torque")
        if self.load_factor is not None and self.axial_load is None:
            raise KeyedError(".load_factor", "wanted only beside axial_load")
        _ = self.load

    @property
    def bolt_forces(self) -> BoltForces | None:
        """Forces of a bolt, if its tension is known; below yield where the grade is."""
        if self.torque is None and self.preload is None:
            return None
        bolt = BOLTS[self.size]
        ruled = self.thread_friction is not None or self.bearing_friction is not None
        default = None if ruled else 0.2
        bolts = Bolts(
            positions=[0.0],
            shank=bolt.diameter,
            hole=self.hole or bolt.hole,
            washer=self.head or bolt.head,
            tension=self.preload,
            torque=None if self.torque is None else float(self.torque),
            thread=bolt.diameter,
            nut_factor=self.nut_factor if self.nut_factor is not None else default,
            pitch=bolt.pitch if ruled else None,
            **named(self, "size", "grade", "thread_friction", "bearing_friction"),
        )
        thickness = float(sum(self.plates)) * (2.0 if len(self.plates) == 1 else 1.0)
        utilisation = None if self.grade is None else float(bolts.utilisation[0])
        forces = self.forces(float(bolts.tension[0]), thickness, utilisation)
        share = forces.load_factor if self.load_factor is None else float(self.load_factor)
        return replace(forces, load_factor=share, axial_load=float(self.axial_load or 0.0))

    @property
    def load(self) -> float | None:
        """Clamp force of all bolts [N], if their tension is given."""
        forces = self.bolt_forces
        return None if forces is None else self.count * forces.clamping

    @property
    def tightening(self) -> float | None:
        """The same right after tightening [N]."""
        forces = self.bolt_forces
        return None if forces is None else self.count * forces.assembly

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        sizes = named(self, "count", "hole", "head", "angle", "edge")
        return Pressure.bolt(self.size, self.plates, rings=rings, **sizes)


ANY_PRESSURE = Table(
    *(ConePressure, ParabolaPressure, AnnulusPressure, TablePressure, PatchesPressure),
    BoltPressure,
    tag="kind",
)
"""A pressure distribution by its kind."""
