"""Keys of tightened bolts, and the distribution of the normal load of a study over the faces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from microslip._core.quantities import named
from microslip._core.units import AREA, FORCE, LENGTH, PRESSURE
from microslip.friction.pressure import BOLTS, RINGS, Pressure
from microslip.structures.bolt_tightening import (
    GRADES,
    TIGHTENING_FACTOR,
    BoltForces,
    ClampedBolt,
    embedding_of,
    tension_band,
)
from microslip.structures.bolts import Bolts
from microslip.study.fields import ANGLE, SHARE, Numbers, one_of, optional, quantity, whole_number
from microslip.study.part import Part, SubTable, key, optional_key, tag
from microslip.study.readers import Items, KeyedError, Place
from microslip.study.uncertain import Spread, Unsure

_LOST = "; the tension falls by f_Z over the resiliences of bolt and plates."


class TightenedBolts(Part):
    """Keys common to bolts of a structure and bolts that press a joint."""

    torque: float | None = optional(Bolts, "torque")
    nut_factor: float | None = optional(Bolts, "nut_factor")
    thread_friction: float | None = optional(Bolts, "thread_friction")
    bearing_friction: float | None = optional(Bolts, "bearing_friction")
    hole: float | None = optional(Bolts, "hole")
    grade: str | None = optional_key(
        one_of(*GRADES), "Property class, whose proof stress bounds the tension.", '"8.8"'
    )
    tightening_factor: float | None = optional(
        Bolts,
        "tightening_factor",
        help="Largest over smallest preload at one torque (VDI 2230's alpha_A), so the torque is "
        "an uncertain input; where others are uncertain it is 1.6 unless given.",
    )
    embedding: float | None = optional_key(
        Unsure(quantity(LENGTH, "8 um")), f"Embedding f_Z of all faces of a bolt (VDI 2230){_LOST}"
    )
    rz: float | None = optional_key(
        Unsure(quantity(LENGTH, "6.3 um")),
        f"Rz of the faces, for f_Z by the table of VDI 2230, in place of embedding{_LOST}",
    )
    interfaces: int = key(
        whole_number(1, 20), "Number of faces between the plates, for rz.", default=1
    )
    size: str | None

    _plate_modulus: float | None = None  # of what the bolts clamp, once the materials are read

    @property
    def model_spreads(self) -> dict[str, Spread]:
        """Scatter of the tension at a given torque."""
        if self.torque is None or isinstance(self.torque, Spread):
            return {}
        low, high = tension_band(self.tightening_factor or TIGHTENING_FACTOR)
        spread = Spread.between(low * self.torque, high * self.torque)
        spread.unit = "N m"
        return {"torque": spread}

    def check(self, place: Place) -> None:
        """Refuse embedding given twice or without a size; a given factor always scatters."""
        if self.embedding is not None and self.rz is not None:
            raise KeyedError(".rz", "wanted embedding or rz, got both; remove one")
        for name in ("embedding", "rz"):
            if getattr(self, name) is not None and self.size is None:
                raise KeyedError(
                    ".size", f'missing; {name} wants the resilience of a size such as size = "M8"'
                )
        if self.rz is not None:
            embedding_of(self.rz, self.interfaces)
        if self.tightening_factor is not None:
            self.__dict__.update(self.model_spreads)

    @property
    def embeds(self) -> bool:
        """Whether any tension is lost."""
        return self.embedding is not None or self.rz is not None

    def clamped(self, length: float) -> ClampedBolt | None:
        """A bolt through plates so thick together [m]; None where size or plates are not known."""
        if self.size is None or self._plate_modulus is None:
            return None
        return ClampedBolt(self.size, length, self._plate_modulus)

    def forces(self, assembly: float, length: float, utilisation: float | None) -> BoltForces:
        """Forces of a bolt by its tension after tightening [N] and the thickness clamped [m]."""
        clamped, embedded = self.clamped(length), self.embedding or 0.0
        if self.rz is not None:
            embedded = embedding_of(self.rz, self.interfaces)
        factor = self.tightening_factor or (1.0 if self.torque is None else TIGHTENING_FACTOR)
        return BoltForces(
            assembly,
            tightening_factor=factor,
            embedding=float(embedded),
            loss=0.0 if clamped is None else clamped.loss(float(embedded)),
            load_factor=None if clamped is None else clamped.load_factor(),
            utilisation=utilisation,
        )


def clamp(study: Any) -> None:
    """Tell bolts and a structure of which materials of a study their plates and parts are."""
    pressure, part = getattr(study.joint, "pressure", None), study.structure
    bodies = tuple(getattr(study.surface, "materials", ()))
    if pressure is not None and isinstance(pressure, TightenedBolts):
        modulus = _modulus(study, bodies, pressure.plates)  # type: ignore[attr-defined]
        joint = study.joint.copy(pressure=pressure.copy(_plate_modulus=modulus))
        joint.settle()
        study.__dict__["joint"] = joint
    if part is not None:
        modulus = _modulus(study, bodies[:1], [1.0] * len(bodies[:1]))
        metals = {name: material.build() for name, material in study.material.items()}
        study.__dict__["structure"] = part.copy(
            bolts=part.bolts.copy(_plate_modulus=modulus), _metals=(metals, *bodies[:1])
        )


def _modulus(study: Any, names: Sequence[str], thickness: Sequence[float]) -> float | None:
    """Modulus of plates on each other [Pa]; None if one is not described, or is rigid."""
    metals = [study.material.get(name) for name in names]
    moduli = [getattr(metal, "young_modulus", None) for metal in metals]
    soft = sum(t / float(e) for t, e in zip(thickness, moduli, strict=True) if e is not None)
    return None if None in metals or not soft else sum(thickness) / soft


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
    inner: float | None = optional_key(_LENGTH, "Radius of the hole, if there is one.", '"4.5 mm"')
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
    axial_load: float | None = optional_key(
        Unsure(quantity(FORCE, "2 kN")),
        "Axial load on each bolt, which parts the plates; all but the bolt's share relieves them.",
    )
    load_factor: float | None = optional_key(
        Unsure(SHARE),
        "The bolt's share of it (VDI 2230's Phi); by the resiliences if absent, for a load that "
        "enters half-way (n = 0.5).",
        "0.1",
    )
    head: float | None = optional_key(
        _LENGTH, "Bearing diameter of head, nut or washer on the plates.", '"16 mm"'
    )
    angle: float = key(
        Unsure(ANGLE), "Half angle of the cone.", '"30 deg"', default=math.radians(30.0)
    )
    edge: float | None = optional_key(
        _LENGTH, "Diameter at which the plates end, or half-way to the next bolt.", '"30 mm"'
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


ANY_PRESSURE = SubTable(
    *(ConePressure, ParabolaPressure, AnnulusPressure, TablePressure, PatchesPressure),
    BoltPressure,
    tag="kind",
)
"""A pressure distribution by its kind."""
