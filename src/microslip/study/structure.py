"""Floor 10: a bolted structure in a study: its drawing, its bolts, and what is not known of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, cast

import numpy as np
from pydantic import AfterValidator, PrivateAttr, ValidationInfo, model_validator

from microslip._core.checks import Floats
from microslip._core.units import FORCE, LENGTH, MASS_DENSITY, TORQUE
from microslip.errors import InputError
from microslip.study import fields
from microslip.study.columns import Column, FileName
from microslip.study.fields import array, different, integer, number, one_of, quantity
from microslip.study.mesh import MeshPart
from microslip.study.modal_tests import MOST_MODES, Tests
from microslip.study.part import KeyedError, Part, optional, required
from microslip.study.uncertain import Uncertain

if TYPE_CHECKING:
    from microslip.materials import Material
    from microslip.normal import NormalLaw
    from microslip.structures import Convergence, LapJoint, ReducedJoint

MOST_POINTS, MOST_SAMPLES = 100, 4096

PlainSize = Annotated[float, quantity(LENGTH, "25 mm")]
Size = Annotated[PlainSize, Uncertain('"25 mm"')]
Place = Annotated[float, quantity(LENGTH, "30 mm", "any"), Uncertain('"30 mm"')]
Places = Annotated[tuple[Place, ...], array('["-30 mm", "0 mm", "30 mm"]', 200, single=True)]
Tension = Annotated[float, quantity(FORCE, "12 kN"), Uncertain('"12 kN"')]
Torque = Annotated[float, quantity(TORQUE, "20 N m"), Uncertain('"20 N m"')]
UncertainDensity = Annotated[
    float, quantity(MASS_DENSITY, "7850 kg/m^3"), Uncertain('"7850 kg/m^3"')
]
_FACTOR = number("a finite number such as 1.0")


class BoltsPart(Part):
    """Equal bolts through the lap: places from its middle, diameters, tension or torque."""

    positions: Places | None = optional(
        "Places along the lap, from its middle; a mesh has them itself.",
        '["-30 mm", "0 mm", "30 mm"]',
    )
    across: Places | None = optional(
        "Places across the lap, one a bolt; all in the middle unless given.",
        '["0 mm", "0 mm", "0 mm"]',
    )
    shank: Size | None = optional("Diameter of the shanks; a mesh has it itself.", '"8 mm"')
    hole: Size | None = optional("Diameter of the holes.", '"8.4 mm"')
    washer: Size | None = optional("Outer diameter of the washers, or of the heads.", '"17 mm"')
    head: Size | None = optional(
        "Height of a head and of a nut with its washer; 0.8 shank diameters unless given.", '"7 mm"'
    )
    tension: Tension | None = optional("Tension of each bolt.", '"12 kN"')
    torque: Torque | None = optional("Tightening torque instead of the tension.", '"20 N m"')
    thread: Size | None = optional("Nominal diameter of the thread, for a torque.", '"8 mm"')
    nut_factor: fields.LoadShare | None = optional(
        "K of torque = K d tension, such as 0.2 for dry steel.", "0.2"
    )
    pitch: Size | None = optional("Pitch of the thread, with two frictions.", '"1.25 mm"')
    thread_friction: fields.UncertainFriction | None = optional("Friction in the thread.", "0.12")
    bearing_friction: fields.UncertainFriction | None = optional(
        "Friction under the turned head or nut.", "0.12"
    )

    @model_validator(mode="after")
    def _check_places(self) -> Self:
        if self.across is not None and len(self.across) != len(self.positions or ()):
            raise KeyedError(
                "structure.bolts.across",
                f"wanted one place a bolt, {len(self.positions or ())} of them, got "
                f"{len(self.across)}",
            )
        return self

    @property
    def bearing(self) -> float | None:
        """Mean diameter of what presses on the plates [m]."""
        return None if self.hole is None or self.washer is None else 0.5 * (self.hole + self.washer)


class SensorPart(Part):
    """Where amplitudes are meant, as a test's sensor shows them."""

    at: Annotated[tuple[Place, Place, Place], array('["0.36 m", "0 m", "0 m"]', 3, min_items=3)] = (
        required(
            "Its place from the middle of the lap: along, across, upwards.",
            '["0.36 m", "0 m", "0 m"]',
        )
    )
    direction: Annotated[Literal["x", "y", "z"], one_of("x", "y", "z")] = optional(
        "Along (x), across (y) or upwards (z).", default="z"
    )


class AmplitudeRange(Part):
    """Displacement amplitudes at the sensor [m], evenly spaced on a log axis."""

    start: PlainSize = required("Smallest amplitude.", '"0.1 um"', alias="from")
    to: PlainSize = required("Largest amplitude.", '"30 um"')
    points: Annotated[int, integer(2, MOST_POINTS, 10)] = optional("How many.", default=10)

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if not self.start < self.to:
            raise KeyedError("structure.amplitude.to", "wanted more than `from`")
        return self


class FormPart(Part):
    """How far the faces stand apart where nothing presses: columns x, y and gap of a CSV file."""

    file: FileName = required(
        "CSV file with a line of column names; relative to the folder of the study.", '"form.csv"'
    )
    x: fields.Line = optional("Column of the places along the lap.", '"x"', default="x")
    y: fields.Line = optional("Column of the places across it.", '"y"', default="y")
    gap: fields.Line = optional("Column of the gaps.", '"gap"', default="gap")
    factor: Annotated[float, _FACTOR, Uncertain("1.0")] = optional(
        "What the gaps are multiplied with: 0 is flat, -1 the reversed form.", "1.0", default=1.0
    )
    _table: Floats = PrivateAttr(default_factory=lambda: np.zeros((0, 3)))

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        read = [
            Column(file=self.file, column=name).read(LENGTH, "any", info, f"structure.form.{key}")
            for key, name in (("x", self.x), ("y", self.y), ("gap", self.gap))
        ]
        self._table = np.array(read).T
        return self

    @property
    def table(self) -> Floats:
        """Columns x, y and gap [m]."""
        return self._table


class StructurePart(Part):
    """Two beams or plates, bolted where they overlap; the first body of the surface below."""

    length: Size | None = optional("From end to end.", '"720 mm"')
    width: Size | None = optional("Across.", '"25.4 mm"')
    thickness: Size | None = optional("Of each part, outside the lap.", '"25.4 mm"')
    lap: Size | None = optional("Length of the overlap.", '"120 mm"')
    style: Annotated[Literal["half-lap", "single-lap"], one_of("half-lap", "single-lap")] = (
        optional(
            "Parts half as thick in the overlap, or whole plates on each other.", default="half-lap"
        )
    )
    mesh: MeshPart | None = optional(
        "A mesh of one's own in place of length, width, thickness and lap."
    )
    density: UncertainDensity | None = optional("Mass density of the parts.", '"7850 kg/m^3"')
    bolts: BoltsPart = required("The bolts.")
    patches: Annotated[
        tuple[Annotated[int, integer(1, 100)], ...],
        array("[15, 2]", 2, min_items=2),
    ] = optional("Contact patches along and across the lap.", default=(15, 2))
    element_size: PlainSize | None = optional(
        "Size of the finite elements in the lap; a 24th of the lap or a quarter of the "
        "width, what is less, unless given.",
        '"5 mm"',
    )
    form: FormPart | None = optional("Form of the faces; flat unless given.")
    modes: Annotated[
        tuple[Annotated[int, integer(1, MOST_MODES, words="a mode counted from 1")], ...],
        array("[1, 3]", MOST_MODES),
        AfterValidator(different),
    ] = optional("Elastic modes, counted from 1.", default=(1,))
    amplitude: AmplitudeRange | None = optional(
        "Amplitudes at the sensor; from 1e-7 to 5e-5 of the length unless given."
    )
    sensor: SensorPart | None = optional(
        "Where amplitudes are meant; the right end unless given, and required with a mesh.",
        '{ at = ["0.36 m", "0 m", "0 m"], direction = "z" }',
    )
    base_damping_ratio: fields.ViscousRatio = optional(
        "Damping of all but the joint, which is added: an input, no result.", "0.0005", default=0.0
    )
    samples: Annotated[int, integer(8, MOST_SAMPLES, 64)] = optional(
        "Samples for the bands, where something is given as a range.", default=64
    )
    converge: fields.YesOrNo = optional(
        "Whether patches are refined where energy is lost, and what finer patches, "
        "elements, more kept modes and harmonics would change is told; some minutes.",
        default=False,
    )
    measured: Tests = optional(
        "A test, or several of them as [[structure.measured]], drawn over the prediction.",
        default=(),
    )

    @model_validator(mode="after")
    def _check_structure(self) -> Self:
        bolts = ("positions", "shank")
        if self.mesh is None:
            _require(self, "structure", (*_DRAWING_KEYS, "density"))
            _require(self.bolts, "structure.bolts", (*bolts, "hole", "washer"))
        else:
            _refuse(self, "structure", (*_DRAWING_KEYS, "element_size"))
            _refuse(self.bolts, "structure.bolts", (*bolts, "across", "head"))
            _require(self, "structure", ("sensor", *(() if self.mesh.densities else ("density",))))
            if self.style != "half-lap":
                raise KeyedError("structure.style", _BESIDE)
            if self.converge:
                raise KeyedError("structure.converge", "wanted none beside structure.mesh, whose "
                                                       "elements cannot be made finer")  # fmt: skip
        for test in self.measured:
            if test.mode is not None and test.mode not in self.modes:
                raise KeyedError(
                    "structure.measured.mode",
                    f"wanted one of structure.modes, got {test.mode}",
                )
        if len({test.fit for test in self.measured if test.fit}) > 1:
            raise KeyedError(
                "structure.measured.fit", "wanted the same in all tests, or in one of them"
            )
        if "form" in self.fitted and self.form is None:
            raise KeyedError(
                "structure.measured.fit", 'wanted "form" only with a table structure.form, got none'
            )
        try:
            _ = self.tension if self.mesh is not None else self.build()
        except InputError as error:
            raise KeyedError("structure", str(error)) from None
        return self

    @property
    def fitted(self) -> tuple[str, ...]:
        """What is fitted to the tests."""
        return next((test.fit for test in self.measured if test.fit), ())

    @property
    def amplitudes(self) -> Floats:
        """Amplitudes at the sensor [m]."""
        span = self.amplitude
        if span is None:
            return np.geomspace(1e-7 * self.extent, 5e-5 * self.extent, 10)
        return np.geomspace(span.start, span.to, span.points)

    @property
    def extent(self) -> float:
        """Its largest size [m]."""
        if self.mesh is not None:
            return float(np.ptp(self.mesh.joint.mesh.points, axis=0).max())
        return cast(float, self.length)

    @property
    def tension(self) -> Floats:
        """Tension of each bolt [N]."""
        from microslip.structures.bolts import TIGHTENING, tensions

        count = len(self.bolts.positions or () if self.mesh is None else self.mesh.bolts)
        tightening = {name: getattr(self.bolts, name) for name in TIGHTENING}
        return tensions(count, **tightening, bearing=self.bolts.bearing)

    @property
    def face_area(self) -> float:
        """Area of the contact faces [m^2]."""
        return self.build().face_area if self.mesh is None else self.mesh.joint.face_area

    @property
    def sensing(self) -> tuple[tuple[float, float, float], str]:
        """Place [m] and direction of the sensor."""
        if self.sensor is not None:
            return self.sensor.at, self.sensor.direction
        lap = self.build()
        return (
            0.5 * lap.length,
            0.0,
            0.0 if self.style == "half-lap" else 0.5 * lap.thickness,
        ), "z"

    @property
    def holes(self) -> list[tuple[float, float, float, int]]:
        """Place along and across [m], diameter [m] and contact of each bolt's hole."""
        if self.mesh is not None:
            return self.mesh.joint.shank_sections(self.mesh.along)
        bolts = self.build().bolts
        return [(float(x), float(y), bolts.hole, 0) for x, y in bolts.positions]

    def reduce(self, materials: Mapping[str, Material], usual: str) -> ReducedJoint:
        """The structure as a small linear model; ``usual`` names the material of its parts."""
        sensors = {"sensor": self.sensing}
        if self.mesh is not None:
            joint = self.mesh.build(materials, usual, self.density, self.tension)
            return joint.reduce(self.patches, sensors=sensors, along=self.mesh.along)
        return self.build().reduce(
            materials[usual],
            cast(float, self.density),
            self.patches,
            element_size=self.element_size,
            sensors=sensors,
        )

    def convergence(
        self, material: Material, surface: NormalLaw, friction: float, amplitudes: Floats
    ) -> Convergence:
        """The model with patches refined for its first mode, at modal amplitudes [m kg^½]."""
        form = None if self.form is None else self.form.table * [1.0, 1.0, self.form.factor]
        return self.build().converge(
            material,
            cast(float, self.density),
            surface,
            friction,
            amplitudes,
            mode=self.modes[0] - 1,
            patches=self.patches,
            form=form,
            element_size=self.element_size,
            sensors={"sensor": self.sensing},
        )

    def build(self) -> LapJoint:
        """The lap joint of the drawing, where there is no mesh."""
        from microslip.structures import Bolts, LapJoint

        sizes: dict[str, Any] = {
            name: getattr(self.bolts, name)
            for name in type(self.bolts).model_fields
            if name not in ("positions", "across")
        }
        places: Any = self.bolts.positions
        if self.bolts.across is not None:
            places = np.stack([places, self.bolts.across], axis=1)
        bolts = Bolts(places, **{k: v for k, v in sizes.items() if v is not None})
        sizes = {name: getattr(self, name) for name in _DRAWING_KEYS}
        return LapJoint(**sizes, bolts=bolts, style=self.style)


_DRAWING_KEYS = ("length", "width", "thickness", "lap")
_BESIDE = "wanted none beside structure.mesh, which shows it"


def _require(part: Part, path: str, names: Iterable[str]) -> None:
    for name in names:
        if getattr(part, name) is None:
            example = (type(part).model_fields[name].examples or ["{ ... }"])[0]
            raise KeyedError(f"{path}.{name}", f"missing; write for example {name} = {example}")


def _refuse(part: Part, path: str, names: Iterable[str]) -> None:
    for name in names:
        if getattr(part, name) is not None:
            raise KeyedError(f"{path}.{name}", _BESIDE)
