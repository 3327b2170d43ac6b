"""Forces, moving ground and geometry of a structure in a study, and the tests of its modes."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import ACCELERATION, FORCE, FREQUENCY, TIME, VELOCITY
from microslip.structures.base_motion import ControlOf
from microslip.structures.geometry import geometry
from microslip.structures.modal_test import Motion
from microslip.study.fields import (
    AMPLITUDE,
    FILE,
    LENGTH,
    LINE,
    LOAD,
    MASS,
    PLACE,
    SHARE,
    column_values,
    number,
    one_of,
    quantity,
    whole_number,
)
from microslip.study.part import Part, Table, key
from microslip.study.readers import Items, KeyedError, Place, Plain
from microslip.study.uncertain import Unsure

_LEVELS = Items(quantity(ACCELERATION, "5 m/s^2"), '["5 m/s^2", "20 m/s^2"]', (1, 20), single=True)
_HERTZ = quantity(FREQUENCY, "150 Hz")
_COORDINATE, _FORCE = PLACE, quantity(FORCE, "2 N", "any")
Axis = Literal["x", "y", "z"]
MOST_FORCES = 10


AMPLITUDES = {
    "displacement": AMPLITUDE,
    "velocity": quantity(VELOCITY, "1 mm/s"),
    "acceleration": quantity(ACCELERATION, "1 m/s^2"),
}
MOST_POINTS = 100
_PLACES = Unsure(PLACE)


class SensorPart(Part):
    """Sensor at which amplitudes are meant, as in a test."""

    at: tuple[float, float, float] = key(
        Items(_PLACES, '["0.36 m", "0 m", "0 m"]', (3, 3)),
        "Its place from the middle of the lap: along, across, upwards.",
    )
    direction: str = key(
        one_of("x", "y", "z"),
        "Direction: along (x), across (y) or upwards (z).",
        '"z"',
        default="z",
    )


class MassPart(Part):
    """A mass fixed to the structure, such as a sensor or the armature of a shaker."""

    at: tuple[float, float, float] = key(
        Items(_PLACES, '["0.3 m", "0 m", "12.7 mm"]', (3, 3)),
        "Its place from the middle of the lap: along, across, upwards.",
    )
    mass: float = key(Unsure(MASS), "What it weighs.")


class SensedAmplitude(float):
    """An amplitude at the sensor in SI units, and of which quantity it is."""

    quantity: str


class _Sensed(Plain):
    """An amplitude of displacement, velocity or acceleration, as its unit says."""

    def read(self, raw_value: object, place: Place) -> Any:
        """The amplitude with its quantity."""
        for name, declared in AMPLITUDES.items():
            try:
                value = SensedAmplitude(declared.read(raw_value))
            except ValueError:
                continue
            value.quantity = name
            return value
        return super().read(raw_value, place)  # says what is wrong with it


class AmplitudeRange(Part):
    """Amplitudes at the sensor, of displacement, velocity or acceleration, even on a log axis."""

    start: SensedAmplitude = key(
        _Sensed(AMPLITUDE),
        "Smallest amplitude: a displacement, velocity or acceleration, by its unit.",
        '"0.1 um"',
        alias="from",
    )
    to: SensedAmplitude = key(_Sensed(AMPLITUDE), "Largest amplitude.", '"30 um"')
    points: int = key(whole_number(2, MOST_POINTS, "10"), "How many.", default=10)

    def check(self, place: Place) -> None:
        """Refuse amplitudes that do not rise, or of two quantities."""
        if self.start.quantity != self.to.quantity:
            raise KeyedError(
                ".to", f"wanted {self.start.quantity} as in `from`, got {self.to.quantity}"
            )
        if not self.start < self.to:
            raise KeyedError(".to", "wanted more than `from`")


class FormPart(Part):
    """Gap between the unloaded faces: columns x, y and gap of a CSV file."""

    file: str = key(FILE, example='"form.csv"')
    x: str = key(LINE, "Column of the places along the lap.", '"x"', default="x")
    y: str = key(LINE, "Column of the places across it.", '"y"', default="y")
    gap: str = key(LINE, "Column of the gaps.", '"gap"', default="gap")
    factor: float = key(
        Unsure(number("1.0")),
        "Factor on the gaps: 0 is flat, -1 the reversed form.",
        default=1.0,
    )
    table: Floats
    """Columns x, y and gap [m]."""

    def check(self, place: Place) -> None:
        """Read the columns."""
        names = {"x": self.x, "y": self.y, "gap": self.gap}
        table = np.array(
            [column_values(PLACE, place.at(to), self.file, name) for to, name in names.items()]
        ).T
        self.keep(table=table)


class ForcePart(Part):
    """A harmonic force on the structure and the response near each mode."""

    amplitude: tuple[float, ...] = key(
        Items(LOAD, '["1 N", "5 N"]', (1, MOST_FORCES), single=True),
        "Amplitude of the force, or several of them.",
        '"5 N"',
    )
    at: tuple[float, float, float] | None = key(
        Items(PLACE, '["0.3 m", "0 m", "0 m"]', (3, 3)),
        "Point of application, from the middle of the lap: along, across, upwards; at the sensor "
        "unless given.",
    )
    direction: str | None = key(
        one_of("x", "y", "z"),
        "Direction: along (x), across (y) or upwards (z); that of the sensor unless given.",
    )


class _Shaken(Part):
    """Keys of a moving ground."""

    direction: Axis = key(
        one_of("x", "y", "z"), "Direction in which the ground moves.", '"z"', default="z"
    )


class BasePart(_Shaken):
    """Sines of the ground, as a shaker table makes them, stepped through the first mode."""

    acceleration: tuple[float, ...] = key(
        _LEVELS, "Levels, a sweep each: of the ground, or of the sensor where that is controlled."
    )
    control: ControlOf = key(
        one_of("base", "response"),
        "Quantity controlled along a sweep: the acceleration of the ground (base), or the absolute "
        "acceleration of the sensor (response), where the resonance does not fold over.",
        default="base",
    )
    frequencies: tuple[float, float] | None = key(
        Items(_HERTZ, '["150 Hz", "200 Hz"]', (2, 2)),
        "Range of the sweep; 10 % about the first mode unless given.",
    )
    points: int = key(whole_number(5, 500, "60"), "How many frequencies.", default=60)

    def check(self, place: Place) -> None:
        """Refuse values that do not rise."""
        if self.frequencies is not None and not self.frequencies[0] < self.frequencies[1]:
            raise KeyedError(".frequencies", "wanted the lower one first, and another one")


class RandomPart(_Shaken):
    """Noise of the ground by its power spectral density, straight between points."""

    frequencies: tuple[float, ...] = key(
        Items(_HERTZ, '["20 Hz", "2 kHz"]', (2, 1000)), "Frequencies of the points, rising."
    )
    levels: tuple[float, ...] = key(
        Items(number("0.5", least=0.0), "[0.5, 0.5]", (2, 1000)),
        "Levels there, one-sided, in (m/s^2)^2/Hz.",
    )
    duration: float = key(
        quantity(TIME, "60 s"), "Duration of the noise, for the expected peaks.", default=60.0
    )
    modes: int = key(
        whole_number(1, 10, "2"),
        "Number of modes with nonlinear joints; others are linear.",
        default=2,
    )

    def check(self, place: Place) -> None:
        """A level each, over rising frequencies."""
        if len(self.levels) != len(self.frequencies):
            raise KeyedError(
                ".levels",
                f"wanted one a frequency, {len(self.frequencies)} of them, got {len(self.levels)}",
            )
        if (np.diff(self.frequencies) <= 0.0).any():
            raise KeyedError(".frequencies", "wanted rising frequencies")
        if not any(self.levels):
            raise KeyedError(".levels", "wanted some level above zero")


class ShockPart(_Shaken):
    """Half-sine pulses of the ground, as shock tests have them (IEC 60068-2-27)."""

    acceleration: tuple[float, ...] = key(_LEVELS, "Severities: the peak of each pulse.")
    duration: float = key(quantity(TIME, "11 ms"), "Duration of the pulses.")


class CoordinatePart(Part):
    """A place whose displacement says how far a thin part bends."""

    at: tuple[float, float, float] = key(
        Items(PLACE, '["0 mm", "0 mm", "0.75 mm"]', (3, 3)),
        "Its place from the middle of the lap: along, across, upwards.",
    )
    direction: Axis = key(one_of("x", "y", "z"), "Direction.", '"z"', default="z")
    displacement: str = key(LINE, "Column of its displacements.", '"u"', default="u")
    force: str = key(LINE, "Column of the forces that hold it there.", '"F"', default="F")


class GeometryPart(Part):
    """Thin, curved parts that stiffen or soften as they bend: drawn, or by cases of a solver."""

    file: str | None = key(FILE, example='"cases.csv"')
    coordinates: tuple[CoordinatePart, ...] = key(
        Items(Table(CoordinatePart), '[{ at = ["0 mm", "0 mm", "0.75 mm"] }]', (1, 6)),
        "Places that are moved in the cases of a file, all others free.",
        default=(),
    )
    reach: float | None = key(
        LENGTH,
        "Largest bending of the middle of a drawn part, where there is no file; 1.5 of its "
        "thicknesses unless given.",
        '"2 mm"',
    )
    cases: tuple[Floats, Floats]
    """Displacements [m] and forces [N], (cases, coordinates)."""

    def check(self, place: Place) -> None:
        """Read the cases, and see that they tell one potential."""
        if (self.file is None) != (not self.coordinates):
            raise KeyedError(
                ".coordinates" if self.file else ".file",
                "wanted both, file and coordinates, or neither for the part of a drawing between "
                "two grounds",
            )
        if self.file is None:
            return
        if self.reach is not None:
            raise KeyedError(".reach", "wanted none beside a file, whose cases say how far")
        file = self.file
        z, forces = (
            np.array([
                column_values(declared, place.at(name), file, getattr(part, name))
                for part in self.coordinates
            ]).T
            for name, declared in (("displacement", _COORDINATE), ("force", _FORCE))
        )  # fmt: skip
        geometry(np.eye(len(self.coordinates)), None, None, (z, forces), None, None)
        self.keep(cases=(z, forces))

    @property
    def sensors(self) -> dict[str, Any]:
        """Its places and directions by name."""
        return {f"bend {i}": (c.at, c.direction) for i, c in enumerate(self.coordinates, 1)}


EXCITED = ("base", "random", "shock")
"""Tables that want something on the ground."""


def check_ground(part: Any, grounded: bool) -> None:
    """Refuse a ground that moves and holds nothing."""
    for name in EXCITED:
        if getattr(part, name) is not None and not grounded:
            raise KeyedError(
                f".{name}", "wanted a structure on the ground: write structure.ground, or "
                "structure.mesh.ground for a mesh",
            )  # fmt: skip


FITTED = ("friction_coefficient", "tension", "form", "young_modulus", "base_damping_ratio")
"""Parameters that can be fitted to a test."""

_COLUMNS = ("amplitude", "frequency", "damping_ratio")
MOST_MODES = 10
MODE = whole_number(1, MOST_MODES, "1", noun=f"a mode from 1 to {MOST_MODES}")


class MeasuredPart(Part):
    """A test of one mode, drawn over the prediction: a curve, a ring-down or a stepped sine."""

    file: str = key(
        FILE,
        "CSV file with a line of column names; relative to the folder of the study. "
        "Amplitude, frequency and damping ratio are a curve; time and displacement, velocity or "
        "acceleration a ring-down; frequency, amplitude and phase a stepped sine.",
        '"test.csv"',
    )
    amplitude: str = key(
        LINE,
        "Column of the amplitudes at the sensor: displacement, velocity or acceleration, as its "
        "unit says.",
        '"amplitude"',
        default="amplitude",
    )
    frequency: str = key(LINE, "Column of the frequencies.", '"frequency"', default="frequency")
    damping_ratio: str = key(
        LINE,
        "Column of the damping ratios, in percent where its header says so.",
        '"damping_ratio"',
        default="damping_ratio",
    )
    band: tuple[float, float] | None = key(
        Items(_HERTZ, '["150 Hz", "220 Hz"]', (2, 2)),
        "Frequencies between which the mode of a ring-down lies, where others ring with it.",
    )
    mode: int | None = key(
        MODE,
        "The mode that was tested, counted from 1; of `structure.modes` the one whose "
        "frequency is nearest unless given.",
    )
    motion: Motion | None = key(
        one_of(*get_args(Motion)),
        "Origin of a curve: steady responses (steady) or free decays (decay), whose "
        "damping ratios differ; as the file shows unless given.",
    )
    fit: tuple[str, ...] | None = key(
        Items(
            one_of(*FITTED), '["friction_coefficient", "tension"]', (1, len(FITTED)), distinct=True
        ),
        "Parameters fitted to the test, starting from the values of the study.",
    )
    frequency_error: float = key(
        SHARE, "Relative uncertainty of the frequencies, the model's included.", default=0.003
    )
    damping_error: float = key(SHARE, "Relative uncertainty of the damping ratios.", default=0.05)
    table: Floats
    """Columns amplitude [m], frequency [Hz] and damping ratio [-]."""
    measured_motion: Motion
    """Whether it was steady motion or a decay."""

    def check(self, place: Place) -> None:
        """Read the test."""
        from microslip.structures import ModalTest

        named = {name: getattr(self, name) for name in _COLUMNS if name in self._keys_in_file}
        stated: dict[str, Any] = {} if self.motion is None else {"motion": self.motion}
        path = place.reading.path(self.file)
        test = ModalTest.read(path, band=self.band, columns=named, **stated)
        table = np.stack([test.amplitude, test.frequency, test.damping_ratio], axis=1)
        self.keep(table=table, measured_motion=test.motion)
        doubts = [
            f"{v.name} is {v.value:.3g}: {v.remedy}"
            for v in test.verdicts
            if v.value is not None and v.word != "ok"
        ]
        place.reading.notes.extend(f"structure.measured: {n}" for n in (*test.notes, *doubts))
