"""Keys of tightened bolts, and contact pressure distributions of a study."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from microslip._core.quantities import named
from microslip._core.units import AREA, LENGTH, PRESSURE
from microslip.contact.half_space import solid_stiffness
from microslip.contact.materials import MaterialPair
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
from microslip.study.fields import (
    ANY_ANGLE,
    Numbers,
    integer,
    one_of,
    optional,
    with_unit,
)
from microslip.study.part import Part, SubTable, key, optional_key, tag
from microslip.study.readers import KeyedError, ListOf, Place
from microslip.study.uncertain import Spread, Uncertain

_LOST = "; the tension drops by f_Z divided by the resiliences of bolt and plates."


class TightenedBolts(Part):
    """Keys of how bolts are tightened, shared by the bolts of a structure and pressure cones."""

    torque: float | None = optional(Bolts, "torque")
    nut_factor: float | None = optional(Bolts, "nut_factor")
    thread_friction: float | None = optional(Bolts, "thread_friction")
    bearing_friction: float | None = optional(Bolts, "bearing_friction")
    hole: float | None = optional(Bolts, "hole")
    grade: str | None = optional_key(
        one_of(*GRADES), "Property class; its proof stress limits the tension.", '"8.8"'
    )
    tightening_factor: float | None = optional(
        Bolts,
        "tightening_factor",
        help="Ratio of largest to smallest preload at one torque (alpha_A of VDI 2230); it makes "
        "the torque an uncertain input. By default 1.6 if other inputs are uncertain.",
    )
    embedding: float | None = optional_key(
        Uncertain(with_unit(LENGTH, "8 um")),
        f"Total embedding f_Z of the faces clamped by a bolt (VDI 2230){_LOST}",
    )
    rz: float | None = optional_key(
        Uncertain(with_unit(LENGTH, "6.3 um")),
        f"Rz of the faces, instead of embedding: f_Z is taken from the table of VDI 2230{_LOST}",
    )
    interfaces: int = key(
        integer(1, 20), "Number of interfaces between the plates, for rz.", default=1
    )
    size: str | None

    _plate_modulus: float | None = None  # mean of the clamped plates, set after the materials

    @property
    def model_spreads(self) -> dict[str, Spread]:
        """Uncertain torque by key; its scatter follows from the tightening factor of VDI 2230."""
        if self.torque is None or isinstance(self.torque, Spread):
            return {}
        low, high = tension_band(self.tightening_factor or TIGHTENING_FACTOR)
        spread = Spread.between(low * self.torque, high * self.torque)
        spread.unit = "N m"
        return {"torque": spread}

    def check(self, place: Place) -> None:
        """Reject embedding that is given by two keys or without a bolt size.

        A given tightening factor makes the torque an uncertain number.
        """
        if self.embedding is not None and self.rz is not None:
            raise KeyedError(".rz", "wanted embedding or rz, got both; remove one")
        for name in ("embedding", "rz"):
            if getattr(self, name) is not None and self.size is None:
                raise KeyedError(
                    ".size", f'missing; {name} needs the size of the bolts, such as size = "M8"'
                )
        if self.rz is not None:
            embedding_of(self.rz, self.interfaces)
        if self.tightening_factor is not None:
            self.__dict__.update(self.model_spreads)

    @property
    def embeds(self) -> bool:
        """Whether embedding of the clamped faces reduces the tension."""
        return self.embedding is not None or self.rz is not None

    def clamped(self, length: float) -> ClampedBolt | None:
        """Return a bolt with the plates that it clamps, of total thickness ``length`` [m].

        None if the size of the bolt or the modulus of the plates is unknown.
        """
        if self.size is None or self._plate_modulus is None:
            return None
        return ClampedBolt(self.size, length, self._plate_modulus)

    def forces(self, assembly: float, length: float, utilisation: float | None) -> BoltForces:
        """Return the forces of a bolt from its assembly preload [N] and clamp length [m].

        ``utilisation`` is the tightening stress over the proof stress [-].
        """
        clamped, embedded = self.clamped(length), self.embedding or 0.0
        if self.rz is not None:
            embedded = embedding_of(self.rz, self.interfaces)
        factor = self.tightening_factor or (1.0 if self.torque is None else TIGHTENING_FACTOR)
        return BoltForces(
            assembly,
            tightening_factor=factor,
            embedding=float(embedded),
            loss=0.0 if clamped is None else clamped.loss(float(embedded)),
            utilisation=utilisation,
        )


def set_clamped_materials(study: Any) -> None:
    """Give bolts the modulus of the plates that they clamp, and a structure its materials."""
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
    """Return the modulus [Pa] of plates in series; None if one is unknown or all are rigid."""
    metals = [study.material.get(name) for name in names]
    moduli = [getattr(metal, "young_modulus", None) for metal in metals]
    soft = sum(t / float(e) for t, e in zip(thickness, moduli, strict=True) if e is not None)
    return None if None in metals or not soft else sum(thickness) / soft


_LENGTH = Uncertain(with_unit(LENGTH, "12 mm"))
_COUNT = integer(1, 10_000, "4")
_PRESSURES = Numbers(with_unit(PRESSURE, "20 MPa", "any"), '["20 MPa", "12 MPa", "0 MPa"]')


class PressurePart(Part):
    """Base of the tables of contact pressure distributions, which are scaled to the normal load."""

    @property
    def load(self) -> float | None:
        """Normal load [N] implied by the distribution; None if it is given separately."""
        return None

    @property
    def tightening(self) -> float | None:
        """Largest normal load that was applied earlier [N]; None if unknown."""
        return self.load

    def spread(self, rings: int = RINGS) -> Pressure:
        """Return the pressure distribution; axisymmetric ones are divided into ``rings``."""
        raise NotImplementedError

    def largest(self, load: float) -> float:
        """Return the largest pressure [Pa] under a normal load [N]."""
        spread = self.spread()
        return float((spread.shares / spread.areas).max()) * load

    def solid_stiffness(self, pair: MaterialPair, area: float) -> tuple[float, float]:
        """Return normal and tangential stiffness [N/m] of the bodies behind the contact.

        The bodies are half-spaces; by default the contact is a disc of the apparent area [m^2].
        """
        return solid_stiffness(pair, area)

    def check(self, place: Place) -> None:
        """Raise an error for an invalid distribution."""
        self.spread()


class _Round(PressurePart):
    """Axisymmetric pressure between an inner and an outer radius."""

    outer: float = key(_LENGTH, "Outer radius.", '"8 mm"')
    inner: float | None = optional_key(_LENGTH, "Radius of the hole; by default none.", '"4.5 mm"')
    count: int = key(_COUNT, "Number of identical, separate contacts.", default=1)

    def spread(self, rings: int = RINGS) -> Pressure:
        kind = self.tag_value("kind")
        options = {} if kind == "annulus" else {"rings": rings}
        pressure: Pressure = getattr(Pressure, kind)(
            self.outer, self.inner or 0.0, count=self.count, **options
        )
        return pressure

    def solid_stiffness(self, pair: MaterialPair, area: float) -> tuple[float, float]:
        """Return the stiffnesses of half-spaces behind all discs or annuli [N/m]."""
        hole = (self.inner or 0.0) / self.outer
        one = math.pi * self.outer**2 * (1.0 - hole**2)
        normal, tangential = solid_stiffness(pair, one, hole)
        return self.count * normal, self.count * tangential


class ConePressure(_Round):
    """Pressure that decreases linearly to zero at the outer radius."""

    kind: str = tag("cone", "Decreases linearly to zero at the outer radius.")


class AnnulusPressure(_Round):
    """Uniform pressure on a ring or a disc."""

    kind: str = tag("annulus", "Uniform between the radii.")


class RectanglePressure(PressurePart):
    """Uniform pressure on a rectangle."""

    kind: str = tag("rectangle", "Uniform on a rectangle, such as a specimen of a rig.")
    length: float = key(_LENGTH, "One side.", '"12 mm"')
    width: float = key(_LENGTH, "The other side.", '"3 mm"')
    count: int = key(_COUNT, "Number of identical, separate contacts.", default=1)

    def spread(self, rings: int = RINGS) -> Pressure:
        """Return the uniform pressure on the total area of all rectangles."""
        return Pressure.patches([self.count * self.length * self.width], [1.0])

    def solid_stiffness(self, pair: MaterialPair, area: float) -> tuple[float, float]:
        """Return the stiffnesses of half-spaces behind all rectangles [N/m]."""
        sides = self.length, self.width
        normal, tangential = solid_stiffness(pair, math.prod(sides), aspect=max(sides) / min(sides))
        return self.count * normal, self.count * tangential


class PatchesPressure(PressurePart):
    """Areas and pressures of patches, from a pressure film or from finite elements."""

    kind: str = tag("patches", "Patches with areas and pressures.")
    area: tuple[float, ...] = key(
        Numbers(with_unit(AREA, "4 mm^2"), '["4 mm^2", "4 mm^2"]', single=True),
        "Area of each patch, or one for all: a list or a column of a CSV file.",
    )
    pressure: tuple[float, ...] = key(
        _PRESSURES,
        "Pressure of each patch: a list or a column of a CSV file.",
        '["20 MPa", "12 MPa"]',
    )

    def spread(self, rings: int = RINGS) -> Pressure:
        """Return the distribution with the areas and pressures of the patches."""
        return Pressure.patches(self.area, self.pressure)


class BoltPressure(TightenedBolts, PressurePart):
    """Pressure between two bolted plates, spreading in cones with a half-angle of 30 degrees."""

    kind: str = tag("bolt", "Cone under the heads of bolts through two plates.")
    size: str = key(one_of(*BOLTS), "Size of the bolts, which defines head and hole.", '"M8"')
    plates: tuple[float, ...] = key(
        ListOf(_LENGTH, '["10 mm", "10 mm"]', (1, 2)), "Thickness of the two plates."
    )
    count: int = key(_COUNT, "Number of bolts.", default=1)
    preload: float | None = optional(Bolts, "tension")
    nut_factor: float | None = optional(
        Bolts,
        "nut_factor",
        help="K of torque = K d tension; by default 0.2, unless friction coefficients are given.",
    )
    head: float | None = optional_key(
        _LENGTH, "Bearing diameter of head, nut or washer on the plates.", '"16 mm"'
    )
    angle: float = key(
        Uncertain(ANY_ANGLE), "Half angle of the cone.", '"30 deg"', default=math.radians(30.0)
    )
    edge: float | None = optional_key(
        _LENGTH,
        "Largest diameter of the cone: the edge of the plates, or half-way to the next bolt.",
        '"30 mm"',
    )

    def check(self, place: Place) -> None:
        """Reject a preload and a torque given together, and keys that require one of them."""
        self.spread()
        super().check(place)
        if self.preload is not None and self.torque is not None:
            raise KeyedError(".torque", "wanted preload or torque, got both; remove one")
        for name in ("embedding", "rz"):
            if self.preload is None and self.torque is None and getattr(self, name) is not None:
                raise KeyedError(f".{name}", "wanted only with preload or torque")
        _ = self.load

    @property
    def bolt_forces(self) -> BoltForces | None:
        """Forces of a bolt; None if neither preload nor torque is given."""
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
        return self.forces(float(bolts.tension[0]), thickness, utilisation)

    @property
    def load(self) -> float | None:
        """Clamp force of all bolts [N]; None if neither preload nor torque is given."""
        forces = self.bolt_forces
        return None if forces is None else self.count * forces.clamping

    @property
    def tightening(self) -> float | None:
        """Clamp force of all bolts right after tightening [N]; None if unknown."""
        forces = self.bolt_forces
        return None if forces is None else self.count * forces.assembly

    def spread(self, rings: int = RINGS) -> Pressure:
        """Return the distribution of the pressure cone between the plates."""
        sizes = named(self, "count", "hole", "head", "angle", "edge")
        return Pressure.bolt(self.size, self.plates, rings=rings, **sizes)


ANY_PRESSURE = SubTable(
    *(ConePressure, AnnulusPressure, RectanglePressure, PatchesPressure, BoltPressure),
    tag="kind",
)
"""Table of a pressure distribution of any kind."""
