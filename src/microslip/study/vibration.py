"""Tables of a structure: sensor, amplitudes, form of the faces, force, and modal tests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast, get_args

import numpy as np

from microslip._core.checks import Floats
from microslip._core.quantities import named
from microslip._core.units import ACCELERATION, FREQUENCY, VELOCITY
from microslip.structures.modal_test import MeasuredMotion
from microslip.study.fields import (
    AMPLITUDE,
    ANY_HEIGHT,
    FILE,
    FRACTION,
    LOAD,
    PLACE,
    POSITIVE_LENGTH,
    column_values,
    integer,
    one_of,
    scalar,
    with_unit,
)
from microslip.study.part import Part, key, optional_key
from microslip.study.readers import DeclaredValue, KeyedError, ListOf, Place
from microslip.study.uncertain import Spread, Uncertain

if TYPE_CHECKING:
    from microslip.structures import ModalTest, ReducedJoint

_HERTZ = with_unit(FREQUENCY, "150 Hz")
MOST_FORCES = 10


AMPLITUDES = {
    "displacement": AMPLITUDE,
    "velocity": with_unit(VELOCITY, "1 mm/s"),
    "acceleration": with_unit(ACCELERATION, "1 m/s^2"),
}
MOST_POINTS = 100
_PLACES = Uncertain(PLACE)


class SensorPart(Part):
    """Sensor whose amplitudes the study gives: its position and direction."""

    at: tuple[float, float, float] = key(
        ListOf(_PLACES, '["0.36 m", "0 m", "0 m"]', (3, 3)),
        "Position from the middle of the lap: along, across, upwards.",
    )
    direction: str = key(
        one_of("x", "y", "z"),
        "Direction: along (x), across (y) or upwards (z).",
        '"z"',
        default="z",
    )


class SensedAmplitude(float):
    """Amplitude at the sensor in SI units, and its quantity."""

    quantity: str


class _Sensed(DeclaredValue):
    """Reader of an amplitude: a displacement, velocity or acceleration, according to its unit."""

    def read(self, raw_value: object, place: Place) -> Any:
        for name, declared in AMPLITUDES.items():
            try:
                value = SensedAmplitude(declared.read(raw_value))
            except ValueError:
                continue
            value.quantity = name
            return value
        return super().read(raw_value, place)  # raises the error


class AmplitudeRange(Part):
    """Amplitudes at the sensor, evenly spaced on a log axis."""

    start: SensedAmplitude = key(
        _Sensed(AMPLITUDE),
        "Smallest amplitude: a displacement, velocity or acceleration, according to its unit.",
        '"0.1 um"',
        alias="from",
    )
    to: SensedAmplitude = key(_Sensed(AMPLITUDE), "Largest amplitude.", '"30 um"')
    points: int = key(integer(2, MOST_POINTS, "10"), "Number of amplitudes.", default=10)

    def check(self, place: Place) -> None:
        """Reject a range that does not increase, or whose ends are different quantities."""
        if self.start.quantity != self.to.quantity:
            raise KeyedError(
                ".to", f"wanted {self.start.quantity} as in `from`, got {self.to.quantity}"
            )
        if not self.start < self.to:
            raise KeyedError(".to", "wanted more than `from`")


MACHINING = {"ground": (3e-6, 15e-6), "milled": (10e-6, 50e-6)}
"""Peak-to-valley form of a face of 50 to 150 mm [m], log-uniform, by machining process."""


class FormPart(Part):
    """Gap between the unloaded faces: a measured table, or random faces of a given flatness."""

    file: str | None = optional_key(
        FILE,
        "CSV file of a measured form, with columns x (along the lap), y (across) and gap; omit it "
        "for random faces.",
        '"form.csv"',
    )
    factor: float = key(
        Uncertain(scalar("1.0")),
        "Factor on the gaps of the file: 0 for flat faces, -1 for the reversed form.",
        default=1.0,
    )
    flatness: float | None = optional_key(
        Uncertain(POSITIVE_LENGTH),
        "Peak-to-valley deviation of each face from its best-fit plane, if no form was measured; "
        "each sample draws two random faces.",
        '"20 um"',
    )
    machining: str | None = optional_key(
        one_of(*MACHINING),
        "Machining process, instead of the flatness: 3 to 15 um for ground, 10 to 50 um for "
        "milled faces.",
        '"ground"',
    )
    correlation: float | None = optional_key(
        Uncertain(POSITIVE_LENGTH),
        "Correlation length of random faces; by default 1/8 to 1 of the lap, log-uniform.",
        '"40 mm"',
    )
    rim: float | None = optional_key(
        Uncertain(ANY_HEIGHT),
        "Height of the raised rim around holes from drilling and tightening, sum of both faces; "
        "for faces with a rim visible on a scan or as marks.",
        '{ low = "0 um", high = "20 um" }',
    )
    table: Floats | None = None
    """Columns x, y and gap [m]; None without a file."""

    def check(self, place: Place) -> None:
        """Read the gaps from their file, and reject keys that are missing or contradictory."""
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
            raise KeyedError(".correlation", "wanted only with flatness or machining")
        if self.file is None:
            return
        columns = ("x", "y", "gap")
        values = [column_values(PLACE, place.at(name), self.file, name) for name in columns]
        self.keep(table=np.array(values).T)

    @property
    def is_random(self) -> bool:
        """Whether each sample of the inputs has its own random faces."""
        return self.flatness is not None

    def apply(
        self,
        joint: ReducedJoint,
        holes: list[tuple[float, float, float, int]],
        rng: np.random.Generator | None,
    ) -> ReducedJoint:
        """Return the joint with the gaps of this form between its faces.

        ``holes`` are positions along and across, diameter [m] and contact number. Without ``rng``,
        random faces are flat and the raised rims around holes have their mean width.
        """
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
    """Harmonic force on the structure, for the response near each mode."""

    amplitude: tuple[float, ...] = key(
        ListOf(LOAD, '["1 N", "5 N"]', (1, MOST_FORCES), single=True),
        "Amplitude of the force, or a list of amplitudes.",
        '"5 N"',
    )
    at: tuple[float, float, float] | None = optional_key(
        ListOf(PLACE, '["0.3 m", "0 m", "0 m"]', (3, 3)),
        "Point of application, from the middle of the lap: along, across, upwards; by default at "
        "the sensor.",
    )
    direction: str | None = optional_key(
        one_of("x", "y", "z"),
        "Direction: along (x), across (y) or upwards (z); by default that of the sensor.",
    )


FITTED = ("friction_coefficient", "tension", "form", "young_modulus", "base_damping_ratio")
"""Parameters that can be fitted to a test."""

MAX_MODES = 10
MODE = integer(1, MAX_MODES, "1", noun=f"a mode from 1 to {MAX_MODES}")


class MeasuredPart(Part):
    """A test of one mode, compared with the prediction."""

    file: str = key(
        FILE,
        "CSV file with a line of column names, relative to the folder of the study. Its columns "
        "define the test: amplitude, frequency and damping ratio for a curve; time and "
        "displacement, velocity or acceleration for a ring-down.",
        '"test.csv"',
    )
    band: tuple[float, float] | None = optional_key(
        ListOf(_HERTZ, '["150 Hz", "220 Hz"]', (2, 2)),
        "Frequency band of the mode in a ring-down with several modes.",
    )
    mode: int | None = optional_key(
        MODE,
        "Number of the tested mode, from 1; by default the one of `structure.modes` with the "
        "nearest frequency.",
    )
    motion: MeasuredMotion | None = optional_key(
        one_of(*get_args(MeasuredMotion)),
        "Origin of a curve: steady responses (steady) or free decays (decay), which have "
        "different damping ratios; by default according to the file.",
    )
    fit: tuple[str, ...] | None = optional_key(
        ListOf(
            one_of(*FITTED), '["friction_coefficient", "tension"]', (1, len(FITTED)), distinct=True
        ),
        "Parameters fitted to the test, starting from the values of the study.",
    )
    frequency_error: float = key(
        FRACTION,
        "Relative uncertainty of the frequencies, including that of the model.",
        default=0.003,
    )
    damping_error: float = key(
        FRACTION, "Relative uncertainty of the damping ratios.", default=0.05
    )
    test: ModalTest
    """The test as read, without the number of its mode."""

    def check(self, place: Place) -> None:
        """Read the test from its file."""
        from microslip.structures import ModalTest

        stated: dict[str, Any] = named(self, "frequency_error", "damping_error")
        if self.motion is not None:
            stated["motion"] = self.motion
        test = ModalTest.read(place.path(self.file), band=self.band, **stated)
        place.notes.extend(f"structure.measured: {note}" for note in test.notes)
        self.keep(test=test)
