"""Floor 8: how the normal load of a study is spread over the faces."""

from __future__ import annotations

import math
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from microslip._core.units import AREA, FORCE, LENGTH, PRESSURE, TORQUE
from microslip.errors import InputError
from microslip.friction.pressure import BOLTS, RINGS, Pressure
from microslip.study import fields
from microslip.study.columns import FromFile
from microslip.study.fields import angle, array, integer, one_of, quantity
from microslip.study.part import KeyedError, Part, keyed, optional, required
from microslip.study.uncertain import Uncertain

Length = Annotated[float, quantity(LENGTH, "12 mm"), Uncertain('"12 mm"')]
_Angle = Annotated[float, angle("30 deg"), Uncertain('"30 deg"')]
_Count = Annotated[int, integer(1, 10_000, words="a whole number of one or more such as 4")]
_COUNT = Field(default=1, description="How many such, equal and apart.", examples=["4"])
_DISTANCES = Annotated[
    tuple[Annotated[float, quantity(LENGTH, "0 mm", "any")], ...],
    array('["0 mm", "5 mm", "10 mm"]', fields.MAX_VALUES),
    FromFile(LENGTH, "joint.pressure.distance"),
]
_AREAS = Annotated[
    tuple[Annotated[float, quantity(AREA, "4 mm^2")], ...],
    array('["4 mm^2", "4 mm^2"]', fields.MAX_VALUES, single=True),
    FromFile(AREA, "joint.pressure.area", "positive"),
]
_PRESSURES = Annotated[
    tuple[Annotated[float, quantity(PRESSURE, "20 MPa", "any")], ...],
    array('["20 MPa", "12 MPa", "0 MPa"]', fields.MAX_VALUES),
    FromFile(PRESSURE, "joint.pressure.pressure"),
]


class PressurePart(Part):
    """A distribution of pressure; the normal load says how large it is."""

    kind: str

    @property
    def load(self) -> float | None:
        """Normal load [N] that the distribution itself says, if it does."""
        return None

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _check_distribution(self) -> Self:
        try:
            self.spread()
        except InputError as error:
            raise keyed(error, "joint.pressure") from None
        return self


class _Round(PressurePart):
    """Round, between two radii."""

    outer: Length = required("Radius at which it ends.", '"8 mm"')
    inner: Length | None = optional("Radius of the hole, if there is one.", '"4.5 mm"')
    count: _Count = _COUNT

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        options = {} if self.kind == "annulus" else {"rings": rings}
        pressure: Pressure = getattr(Pressure, self.kind)(
            self.outer, self.inner or 0.0, count=self.count, **options
        )
        return pressure


class ConePressure(_Round):
    """Pressure that falls along a straight line to none at the outer radius."""

    kind: Literal["cone"] = required("Falls along a straight line from the inner radius.")


class ParabolaPressure(_Round):
    """Pressure that falls along a parabola to none at the outer radius."""

    kind: Literal["parabola"] = required("Falls along a parabola from the inner radius.")


class AnnulusPressure(_Round):
    """An even pressure on a ring or a disc."""

    kind: Literal["annulus"] = required("Even between the radii.")


class TablePressure(PressurePart):
    """Round, by a table of pressures at distances from the axis; only how they compare counts."""

    kind: Literal["table"] = required("By a table over the distance from the axis.")
    distance: _DISTANCES = required(
        "Distances, rising: a list or a column of a CSV file.", '["0 mm", "5 mm", "10 mm"]'
    )
    pressure: _PRESSURES = required(
        "Pressures there: a list or a column of a CSV file.", '["20 MPa", "12 MPa", "0 MPa"]'
    )
    count: _Count = _COUNT

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        return Pressure.table(self.distance, self.pressure, count=self.count)


class PatchesPressure(PressurePart):
    """Patches of a pressure film or of a finite-element model."""

    kind: Literal["patches"] = required("Patches with their areas and pressures.")
    area: _AREAS = required(
        "Area of each patch, or of all: a list or a column of a CSV file.", '["4 mm^2", "4 mm^2"]'
    )
    pressure: _PRESSURES = required(
        "Pressure on each: a list or a column of a CSV file.", '["20 MPa", "12 MPa"]'
    )

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        return Pressure.patches(self.area, self.pressure)


class BoltPressure(PressurePart):
    """What bolts press where two plates meet: a cone of 30 degrees from head and nut."""

    kind: Literal["bolt"] = required("By bolts through two plates.")
    size: Annotated[str, one_of(*BOLTS)] = required(
        "Size of the bolts, which gives head and hole.", '"M8"'
    )
    plates: Annotated[tuple[Length, ...], array('["10 mm", "10 mm"]', 2)] = required(
        "Thickness of both plates.", '["10 mm", "10 mm"]'
    )
    count: _Count = optional("How many bolts.", "4", default=1)
    preload: Annotated[float, quantity(FORCE, "15 kN"), Uncertain('"15 kN"')] | None = optional(
        "Tension of each bolt.", '"15 kN"'
    )
    torque: Annotated[float, quantity(TORQUE, "20 N m"), Uncertain('"20 N m"')] | None = optional(
        "Tightening torque in its place.", '"20 N m"'
    )
    nut_factor: fields.LoadShare | None = optional(
        "K of torque = K d tension; 0.2 if absent, without frictions.", "0.2"
    )
    thread_friction: fields.UncertainFriction | None = optional(
        "Friction in the thread, for VDI 2230.", "0.12"
    )
    bearing_friction: fields.UncertainFriction | None = optional(
        "Friction under the head, for VDI 2230.", "0.12"
    )
    hole: Length | None = optional("Diameter of the holes.", '"9 mm"')
    head: Length | None = optional(
        "Diameter of what presses on the plates: head, nut or washer.", '"16 mm"'
    )
    angle: _Angle = optional("Half angle of the cone.", '"30 deg"', default=math.radians(30.0))
    edge: Length | None = optional(
        "Diameter at which the plates end, or half-way to the next bolt.", '"30 mm"'
    )

    @model_validator(mode="after")
    def _check_tension(self) -> Self:
        if self.preload is not None and self.torque is not None:
            raise KeyedError(
                "joint.pressure.torque", "wanted preload or torque, got both; remove one"
            )
        if self.torque is not None:
            try:
                self._tension()
            except InputError as error:
                raise keyed(error, "joint.pressure") from None
        return self

    def _tension(self) -> float:
        """Tension of a bolt by its torque [N]."""
        from microslip.structures import Bolts

        bolt = BOLTS[self.size]
        ruled = self.thread_friction is not None or self.bearing_friction is not None
        default = None if ruled else 0.2
        bolts = Bolts(
            positions=[0.0],
            shank=bolt.diameter,
            hole=self.hole or bolt.hole,
            washer=self.head or bolt.head,
            torque=self.torque,
            thread=bolt.diameter,
            nut_factor=self.nut_factor if self.nut_factor is not None else default,
            pitch=bolt.pitch if ruled else None,
            thread_friction=self.thread_friction,
            bearing_friction=self.bearing_friction,
        )
        return float(bolts.tension[0])

    @property
    def load(self) -> float | None:
        """Tension of all bolts [N], if it is given."""
        if self.torque is not None:
            return self.count * self._tension()
        return None if self.preload is None else self.count * self.preload

    def spread(self, rings: int = RINGS) -> Pressure:
        """The distribution."""
        return Pressure.bolt(
            self.size,
            self.plates,
            count=self.count,
            hole=self.hole,
            head=self.head,
            angle=self.angle,
            edge=self.edge,
            rings=rings,
        )


PRESSURES: dict[str, type[Part]] = {
    "cone": ConePressure,
    "parabola": ParabolaPressure,
    "annulus": AnnulusPressure,
    "table": TablePressure,
    "patches": PatchesPressure,
    "bolt": BoltPressure,
}
"""Tables of pressure distributions by their kind."""

if TYPE_CHECKING:
    AnyPressure = PressurePart
else:
    AnyPressure = Annotated[reduce(or_, PRESSURES.values()), Field(discriminator="kind")]
