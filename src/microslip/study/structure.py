"""Table of a bolted structure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import JsonSchema
from microslip.structures.bolt_tightening import BoltForces
from microslip.structures.bolted_beam import LapJoint
from microslip.structures.bolts import tensions, yield_tension
from microslip.structures.reduction_patches import contact_frame, shared_extent, usual_counts
from microslip.study.bodies import (
    DRAWING_KEYS,
    BoltsPart,
    MeshPart,
)
from microslip.study.fields import (
    POSITIVE_DENSITY,
    POSITIVE_LENGTH,
    VISCOUS_RATIO,
    YES_NO,
    integer,
    one_of,
    optional,
)
from microslip.study.part import Part, SubTable, key, optional_key
from microslip.study.readers import KeyedError, ListOf, Place
from microslip.study.uncertain import Spread, Uncertain
from microslip.study.vibration import (
    AMPLITUDES,
    MAX_MODES,
    MODE,
    AmplitudeRange,
    ForcePart,
    FormPart,
    MeasuredPart,
    SensorPart,
)

if TYPE_CHECKING:
    from microslip.contact.materials import Material
    from microslip.structures import ModalTest
    from microslip.structures.reduction import Reducer

LABORATORY = Spread.between(2e-4, 1e-3, log=True)
"""Damping ratio of free steel structures without a joint [-], see docs/bolted-structures.md."""
_MEASURED = Spread.between(1e-9, 1.0, log=True)
"""Placeholder for a base damping that is computed from the tests of a study."""
_MOST_SAMPLES = 4096
_COARSE = (15, 2)  # patches that a convergence study refines


class BaseDamping(Uncertain):
    """Reader of a base damping ratio: a number, a range, or the name of its source."""

    def read(self, raw_value: object, place: Place) -> Any:
        """Return the base damping ratio or its distribution."""
        named = {"laboratory": LABORATORY, "measured": _MEASURED}
        known = named.get(raw_value) if isinstance(raw_value, str) else None
        return super().read(raw_value, place) if known is None else known

    def schema(self) -> JsonSchema:
        """Return the JSON Schema of valid values."""
        inner = super().schema()
        return {**inner, "anyOf": [{"enum": ["laboratory", "measured"]}, *inner["anyOf"]]}


def measured_base_damping(tests: Iterable[ModalTest]) -> Spread:
    """Return the range of the base damping from tests at small amplitude [-].

    The damping ratio at the smallest amplitude is an upper limit, since it includes the joint. The
    lower limit is extrapolated to zero amplitude by a straight line through the points up to three
    times the smallest amplitude: the damping ratio of microslip grows in proportion to the
    amplitude (Mindlin and Deresiewicz 1953, DOI 10.1115/1.4010702), or faster.
    """
    ends = []
    for test in tests:
        order = np.argsort(test.amplitude)
        amplitude, damping = test.amplitude[order], test.damping_ratio[order]
        lowest = float(damping[0])
        near = amplitude <= max(3.0 * amplitude[0], float(amplitude[min(1, amplitude.size - 1)]))
        line = lowest
        if near.sum() > 1:
            line = float(np.polyfit(amplitude[near], damping[near], 1)[1])
        error = test.damping_error
        ends += [max(min(line, lowest), 0.1 * lowest) * (1.0 - error), lowest * (1.0 + error)]
    return Spread.between(min(ends), max(ends))


class StructurePart(Part):
    """Two beams or plates, bolted where they overlap; they are of the surface's first material."""

    length: float | None = optional(LapJoint, "length")
    width: float | None = optional(LapJoint, "width")
    thickness: float | None = optional(LapJoint, "thickness")
    lap: float | None = optional(LapJoint, "lap")
    style: Literal["half-lap", "single-lap"] = key(
        one_of("half-lap", "single-lap"),
        "half-lap: parts of half thickness in the overlap; single-lap: plates of full thickness.",
        default="half-lap",
    )
    mesh: MeshPart | None = optional_key(
        SubTable(MeshPart), "Mesh, instead of length, width, thickness and lap."
    )
    density: float | None = optional_key(Uncertain(POSITIVE_DENSITY), "Mass density of the parts.")
    bolts: BoltsPart = key(SubTable(BoltsPart), "The bolts.")
    patches: tuple[int, int] | None = optional_key(
        ListOf(integer(1, 100), "[30, 2]", (2, 2)),
        "Contact patches along and across the lap; by default some 60, such as 30 x 2. Patches "
        "that the elements cannot resolve are merged.",
    )
    element_size: float | None = optional_key(
        POSITIVE_LENGTH,
        "Size of the finite elements in the lap; by default the smaller of 1/24 of the lap and "
        "1/4 of the width.",
        '"5 mm"',
    )
    form: FormPart | None = optional_key(SubTable(FormPart), "Form of the faces; flat by default.")
    modes: tuple[int, ...] = key(
        ListOf(MODE, "[1, 3]", (1, MAX_MODES), distinct=True),
        "Numbers of the elastic modes, from 1.",
        default=(1,),
    )
    amplitude: AmplitudeRange | None = optional_key(
        SubTable(AmplitudeRange),
        "Amplitudes at the sensor; by default from 1e-7 to 5e-5 of the length.",
    )
    sensor: SensorPart | None = optional_key(
        SubTable(SensorPart),
        "Point and direction of the amplitudes; by default the right end. Required with a mesh.",
        '{ at = ["0.36 m", "0 m", "0 m"], direction = "z" }',
    )
    force: ForcePart | None = optional_key(
        SubTable(ForcePart),
        "Harmonic force, for the response near each mode.",
        '{ amplitude = "5 N" }',
    )
    base_damping_ratio: float = key(
        BaseDamping(VISCOUS_RATIO),
        "Damping ratio without the joint, added to that of the joint; an input, not a result. "
        '"laboratory" (the default): 0.02 to 0.1 %, log-uniform, for steel parts suspended on '
        'strings with sensors. "measured": from the tests at small amplitude, such as a ring-down.',
        '"laboratory"',
        default=LABORATORY,
    )
    harmonics: tuple[int, ...] = key(
        ListOf(integer(0, 16, "1"), "[0, 1, 2, 3]", (1, 17), distinct=True),
        "Harmonics of the motion; the report estimates the effect of higher harmonics.",
        default=(0, 1, 2, 3),
    )
    samples: int = key(
        integer(8, _MOST_SAMPLES, "64"),
        "Number of samples for the bands, if inputs are uncertain.",
        default=64,
    )
    converge: bool = key(
        YES_NO,
        "Refine patches where energy is dissipated, and report the changes by finer patches, "
        "finer elements, more retained modes and more harmonics; takes minutes.",
        default=False,
    )
    measured: tuple[MeasuredPart, ...] = key(
        ListOf(SubTable(MeasuredPart), '[{ file = "test.csv" }]', (0, 20), single=True),
        "Tests to compare with the prediction; several are written as [[structure.measured]].",
        default=(),
    )

    _metals: tuple[dict[str, Material], str]  # materials of the study, name of the default one

    def check(self, place: Place) -> None:
        """Reject conflicting keys, incomplete dimensions, and a mesh without its required keys."""
        if self.mesh is None:
            _require(self, "", (*DRAWING_KEYS, "density"))
            _require(self.bolts, ".bolts", ("positions", "shank", "hole", "washer"))
        else:
            _refuse(self, "", (*DRAWING_KEYS, "element_size"))
            drawn = ("positions", "shank", "across", "head", "washer_thickness", "mass")
            _refuse(self.bolts, ".bolts", self.bolts.written(drawn))
            _require(self, "", ("sensor", *(() if self.mesh.densities else ("density",))))
            _require(self.bolts, ".bolts", ("clamp_length",) if self.bolts.embeds else ())
            if self.style != "half-lap":
                raise KeyedError(".style", _BESIDE)
            if self.converge:
                raise KeyedError(".converge", "wanted only without structure.mesh, whose elements "
                                              "cannot be refined")  # fmt: skip
        for test in self.measured:
            if test.mode is not None and test.mode not in self.modes:
                raise KeyedError(
                    ".measured.mode", f"wanted one of structure.modes, got {test.mode}"
                )
        if len({test.fit for test in self.measured if test.fit}) > 1:
            raise KeyedError(".measured.fit", "wanted the same list in all tests, or in one test")
        if self.form is not None and self.form.is_random and self.form.correlation is None:
            longest = self._lap_length
            correlation = Spread.between(longest / 8.0, longest, log=True)
            correlation.unit = "m"
            self.form.keep(correlation=correlation)
        if self.base_damping_ratio is _MEASURED:
            if not self.measured:
                raise KeyedError(
                    ".base_damping_ratio",
                    'wanted "measured" only with structure.measured, got none',
                )
            self.keep(base_damping_ratio=measured_base_damping(part.test for part in self.measured))
        if "form" in self.fitted and (self.form is None or self.form.table is None):
            raise KeyedError(
                ".measured.fit", 'wanted "form" only with a table structure.form, got none'
            )
        if "young_modulus" in self.fitted and self.mesh is not None:
            raise KeyedError(
                ".measured.fit",
                'wanted "young_modulus" only without structure.mesh, whose bodies may have '
                "different materials",
            )
        from microslip.structures.periodic_motion import harmonic_basis

        harmonic_basis(self.harmonics, 64)
        _ = self._tensions  # raises an error for invalid bolts

    @property
    def fitted(self) -> tuple[str, ...]:
        """Names of the parameters that are fitted to the tests."""
        return next((test.fit for test in self.measured if test.fit), ())

    @property
    def amplitudes(self) -> Floats:
        """Amplitudes at the sensor, in the SI unit of :attr:`quantity`."""
        span = self.amplitude
        if span is None:
            return np.geomspace(1e-7 * self.extent, 5e-5 * self.extent, 10)
        return np.geomspace(span.start, span.to, span.points)

    @property
    def quantity(self) -> str:
        """Quantity of the sensor's amplitudes: displacement, velocity or acceleration."""
        return "displacement" if self.amplitude is None else self.amplitude.start.quantity

    @property
    def unit(self) -> str:
        """SI unit of the sensor's amplitudes."""
        return AMPLITUDES[self.quantity].unit

    @property
    def extent(self) -> float:
        """Largest dimension of the structure [m]."""
        if self.mesh is not None:
            return float(np.ptp(self.mesh.joint.mesh.points, axis=0).max())
        return cast(float, self.length)

    @property
    def _lap_length(self) -> float:
        """Largest dimension of a contact (lap) between the parts [m]."""
        if self.mesh is None:
            return float(cast(float, self.lap))
        mesh = self.mesh.joint.mesh
        sides = ((c.lower, c.upper) for c in mesh.contacts)
        return max(
            min(float(np.ptp(mesh.points[side].reshape(-1, 3), axis=0).max()) for side in both)
            for both in sides
        )

    @property
    def _tensions(self) -> Floats:
        """Nominal tension of each bolt [N], shape (bolts,)."""
        if self.mesh is None:
            return self.build().tension
        return tensions(self.bolts, len(self.mesh.bolts))

    @property
    def bolt_forces(self) -> BoltForces | None:
        """Forces of the bolt with the smallest tension; None if the bolts have no size."""
        if self.bolts.size is None:
            return None
        length = self.bolts.clamp_length
        if length is None and self.mesh is None:
            length = self.thickness * (1.0 if self.style == "half-lap" else 2.0)  # type: ignore[operator]
        if length is None:
            return None
        forces = self._tensions
        utilisation = None
        if self.bolts.grade is not None:
            utilisation = float(forces.max() / yield_tension(self.bolts))
        return self.bolts.forces(float(forces.min()), float(length), utilisation)

    @property
    def tension(self) -> Floats:
        """Tension of each bolt [N], reduced by embedding."""
        loss = self.bolt_forces.loss if self.bolts.embeds else 0.0  # type: ignore[union-attr]
        return self._tensions - loss

    @property
    def face_area(self) -> float:
        """Area of the contact faces [m^2]."""
        return self.build().face_area if self.mesh is None else self.mesh.joint.face_area

    @property
    def sensing(self) -> tuple[tuple[float, float, float], str]:
        """Position [m] of the sensor, and the direction of its motion."""
        if self.sensor is not None:
            return self.sensor.at, self.sensor.direction
        beam = self.build()
        height = 0.0 if self.style == "half-lap" else 0.5 * beam.thickness
        return (0.5 * beam.length, 0.0, height), "z"

    @property
    def holes(self) -> list[tuple[float, float, float, int]]:
        """Bolt holes: position along and across [m], diameter [m], number of the contact."""
        if self.mesh is not None:
            return self.mesh.joint.shank_sections(self.mesh.along)
        bolts = self.build().bolts
        return [(float(x), float(y), bolts.hole, 0) for x, y in bolts.positions]

    @property
    def washers(self) -> list[tuple[float, float, float, int]]:
        """Washers: position along and across [m], pressed diameter [m], number of the contact.

        The diameter is taken as two shank diameters for a mesh, which has no named washers.
        """
        if self.mesh is not None:
            return [(x, y, 2.0 * d, contact) for x, y, d, contact in self.holes]
        bolts = self.build().bolts
        return [(float(x), float(y), bolts.pressed, 0) for x, y in bolts.positions]

    @property
    def body(self) -> tuple[Material, float]:
        """Material and mass density [kg/m^3] of both parts of a structure given by dimensions."""
        metals, usual = self._metals
        return metals[usual], cast(float, self.density)

    def reducer(self) -> Reducer:
        """Return the finite-element model of the structure, which yields the reduced models."""
        from microslip.structures.reduction import Reducer

        if self.mesh is not None:
            joint = self.mesh.build(*self._metals, self.density)
            return Reducer(joint.mesh, {}, self._along)
        mesh = self.build().mesh(*self.body, self.element_size)
        return Reducer(mesh, {}, np.array([1.0, 0.0, 0.0]))

    @property
    def _along(self) -> Floats | None:
        """First direction of the patches of a mesh; None for the longest one of the faces."""
        if self.mesh is None or self.mesh.along is None:
            return None
        return np.array(self.mesh.along)

    @property
    def reduction(self) -> dict[str, Any]:
        """Keyword arguments of the reduction of the mesh."""
        return {
            "tension": self.tension,
            "patches": self.patches or (_COARSE if self.converge else None),
            "sensors": self.sensors,
        }

    @property
    def sensors(self) -> dict[str, tuple[tuple[float, float, float], str]]:
        """Positions [m] and directions of the sensor and of the force."""
        places = {"sensor": self.sensing}
        if self.force is None:
            return places
        at, direction = self.sensing
        return {**places, "force": (self.force.at or at, self.force.direction or direction)}

    @property
    def gaps(self) -> Floats | None:
        """Gap between the faces: table with the columns x, y and gap [m]; None for flat faces."""
        if self.form is None or self.form.table is None:
            return None
        return np.asarray(self.form.table * [1.0, 1.0, self.form.factor])

    @property
    def patch_size(self) -> float:
        """Side [m] of a square with the mean area of a patch of all contacts."""
        if self.mesh is None:
            sides = np.array([[self._lap_length, cast(float, self.width)]])
        else:
            mesh, along = self.mesh.joint.mesh, self._along
            frames = [(contact, contact_frame(mesh, contact, along)) for contact in mesh.contacts]
            extents = [shared_extent(mesh, contact, frame) for contact, frame in frames]
            sides = np.array([high - low for low, high in extents])
        counts = np.array([self.patches or usual_counts(*side) for side in sides])
        return float(np.sqrt(sides.prod(axis=1).sum() / counts.prod(axis=1).sum()))

    def build(self) -> LapJoint:
        """Return the lap joint with the dimensions and bolts of the study."""
        sizes: dict[str, Any] = {name: getattr(self, name) for name in DRAWING_KEYS}
        return LapJoint(**sizes, bolts=self.bolts.build(), style=self.style)


_BESIDE = "wanted only without structure.mesh, which defines it"


def _require(part: Part, path: str, names: Iterable[str]) -> None:
    for name in names:
        if getattr(part, name) is None:
            example = part.keys[name].example
            raise KeyedError(f"{path}.{name}", f"missing; write for example {name} = {example}")


def _refuse(part: Part, path: str, names: Iterable[str]) -> None:
    for name in names:
        if getattr(part, name) not in (None, ()):
            raise KeyedError(f"{path}.{name}", _BESIDE)
