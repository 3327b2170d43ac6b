"""Sensor, amplitudes, form, force and tests of the modes of a structure in a study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast, get_args

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import ACCELERATION, FREQUENCY, VELOCITY
from microslip.structures.modal_test import Motion
from microslip.study.fields import (
    AMPLITUDE,
    FILE,
    HEIGHT,
    LENGTH,
    LINE,
    LOAD,
    PLACE,
    SHARE,
    column_values,
    number,
    one_of,
    quantity,
    whole_number,
)
from microslip.study.part import Part, key, optional_key
from microslip.study.readers import Items, KeyedError, Place, Plain
from microslip.study.uncertain import Spread, Unsure

if TYPE_CHECKING:
    from microslip.structures import ReducedJoint

_HERTZ = quantity(FREQUENCY, "150 Hz")
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


MACHINING = {"ground": (3e-6, 15e-6), "milled": (10e-6, 50e-6)}
"""Peak to valley of a face of 50 to 150 mm by its machining [m], log-uniform."""


class FormPart(Part):
    """Gap between the unloaded faces: a measured table, or random faces of a flatness."""

    file: str | None = optional_key(
        FILE, "CSV file of a measured form; nothing if the faces are random.", '"form.csv"'
    )
    x: str = key(LINE, "Column of the places along the lap.", '"x"', default="x")
    y: str = key(LINE, "Column of the places across it.", '"y"', default="y")
    gap: str = key(LINE, "Column of the gaps.", '"gap"', default="gap")
    factor: float = key(
        Unsure(number("1.0")),
        "Factor on the gaps of the file: 0 is flat, -1 the reversed form.",
        default=1.0,
    )
    flatness: float | None = optional_key(
        Unsure(LENGTH),
        "Peak to valley of each face without its best plane, for whoever has a drawing and no "
        "scan: each sample draws two random faces.",
        '"20 um"',
    )
    machining: str | None = optional_key(
        one_of(*MACHINING),
        "Machining in place of the flatness: ground faces 3 to 15 um, milled ones 10 to 50 um.",
        '"ground"',
    )
    correlation: float | None = optional_key(
        Unsure(LENGTH),
        "Correlation length of random faces; an eighth of the lap to the lap, log-uniform, unless "
        "given.",
        '"40 mm"',
    )
    rim: float | None = optional_key(
        Unsure(HEIGHT),
        "Height of the rim that drilling and tightening raise around a hole, of both faces "
        "together, for whoever sees it on a scan or shadow marks around holes.",
        '{ low = "0 um", high = "20 um" }',
    )
    table: Floats | None = None
    """Columns x, y and gap [m]; None without a file."""

    def check(self, place: Place) -> None:
        """Read the columns; refuse forms given twice."""
        if self.machining is not None:
            if self.flatness is not None:
                raise KeyedError(".machining", "wanted flatness or machining, got both; remove one")
            flatness = Spread.between(*MACHINING[self.machining], log=True)
            flatness.unit = "m"
            self.keep(flatness=flatness)
        if self.file is None and self.flatness is None and self.rim is None:
            raise KeyedError(
                ".flatness", 'missing; write for example flatness = "20 um", machining = "ground", '
                'or file = "form.csv"'
            )  # fmt: skip
        if (
            self.rim is not None
            and min(float(self.rim), getattr(self.rim, "low", None) or 0.0) < 0.0
        ):
            raise KeyedError(".rim", "wanted a height of zero or more")
        if self.correlation is not None and self.flatness is None:
            raise KeyedError(".correlation", "wanted only beside flatness or machining")
        if self.file is None:
            return
        names = {"x": self.x, "y": self.y, "gap": self.gap}
        table = np.array(
            [column_values(PLACE, place.at(to), self.file, name) for to, name in names.items()]
        ).T
        self.keep(table=table)

    @property
    def is_random(self) -> bool:
        """Whether each sample draws faces of its own."""
        return self.flatness is not None

    def apply(
        self,
        joint: ReducedJoint,
        holes: list[tuple[float, float, float, int]],
        rng: np.random.Generator | None,
    ) -> ReducedJoint:
        """Return the joint with this form; without random numbers that of the middle, no waves."""
        from microslip.structures.random_form import random_gaps, rim_gaps

        gaps = np.zeros(joint.patches)
        if self.table is not None:
            gaps = joint.with_form(self.table, self.factor).patch_gaps
        if self.rim is not None:
            reach = 0.5 if rng is None else float(rng.uniform())
            gaps = gaps + rim_gaps(joint, holes, float(self.rim), reach)
        if self.flatness is not None and rng is not None:
            length = float(cast(float, self.correlation))
            gaps = gaps + random_gaps(joint, float(self.flatness), length, rng)
        return joint.with_form(gaps)


class ForcePart(Part):
    """A harmonic force on the structure and the response near each mode."""

    amplitude: tuple[float, ...] = key(
        Items(LOAD, '["1 N", "5 N"]', (1, MOST_FORCES), single=True),
        "Amplitude of the force, or several of them.",
        '"5 N"',
    )
    at: tuple[float, float, float] | None = optional_key(
        Items(PLACE, '["0.3 m", "0 m", "0 m"]', (3, 3)),
        "Point of application, from the middle of the lap: along, across, upwards; at the sensor "
        "unless given.",
    )
    direction: str | None = optional_key(
        one_of("x", "y", "z"),
        "Direction: along (x), across (y) or upwards (z); that of the sensor unless given.",
    )


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
    band: tuple[float, float] | None = optional_key(
        Items(_HERTZ, '["150 Hz", "220 Hz"]', (2, 2)),
        "Frequencies between which the mode of a ring-down lies, where others ring with it.",
    )
    mode: int | None = optional_key(
        MODE,
        "The mode that was tested, counted from 1; of `structure.modes` the one whose "
        "frequency is nearest unless given.",
    )
    motion: Motion | None = optional_key(
        one_of(*get_args(Motion)),
        "Origin of a curve: steady responses (steady) or free decays (decay), whose "
        "damping ratios differ; as the file shows unless given.",
    )
    fit: tuple[str, ...] | None = optional_key(
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
