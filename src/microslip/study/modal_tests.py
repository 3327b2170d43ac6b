"""Tests of modes in a study, drawn over what it predicts, and what is fitted to them."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import REQUIRED, JsonSchema
from microslip._core.units import FREQUENCY
from microslip.structures.modal_test import Motion
from microslip.study.fields import FILE, LINE, SHARE, one_of, quantity, whole_number
from microslip.study.part import Part, Table, key
from microslip.study.readers import Items, Place

FITTED = ("friction_coefficient", "tension", "form", "young_modulus", "base_damping_ratio")
"""Parameters that can be fitted to a test."""

_COLUMNS = ("amplitude", "frequency", "damping_ratio")
MOST_MODES = 10
MODE = whole_number(1, MOST_MODES, "1", noun=f"a mode from 1 to {MOST_MODES}")
_HERTZ = quantity(FREQUENCY, "150 Hz")


class MeasuredPart(Part):
    """A test of one mode, drawn over the prediction: a curve, a ring-down or a stepped sine."""

    file: str = key(
        FILE,
        "CSV file with a line of column names; relative to the folder of the study. "
        "Amplitude, frequency and damping ratio are a curve; time and displacement, velocity or "
        "acceleration a ring-down; frequency, amplitude and phase a stepped sine.",
        '"test.csv"',
        default=REQUIRED,
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
        default=None,
    )
    mode: int | None = key(
        MODE,
        "The mode that was tested, counted from 1; of `structure.modes` the one whose "
        "frequency is nearest unless given.",
        default=None,
    )
    motion: Motion | None = key(
        one_of(*get_args(Motion)),
        "Origin of a curve: steady responses (steady) or free decays (decay), whose "
        "damping ratios differ; as the file shows unless given.",
        default=None,
    )
    fit: tuple[str, ...] | None = key(
        Items(
            one_of(*FITTED), '["friction_coefficient", "tension"]', (1, len(FITTED)), distinct=True
        ),
        "Parameters fitted to the test, starting from the values of the study.",
        default=None,
    )
    frequency_error: float = key(
        SHARE, "Relative uncertainty of the frequencies, the model's included.", default=0.003
    )
    damping_error: float = key(SHARE, "Relative uncertainty of the damping ratios.", default=0.05)
    _table: Floats
    _motion: Motion

    def check(self, place: Place) -> None:
        """Read the test."""
        from microslip.structures import ModalTest

        named = {name: getattr(self, name) for name in _COLUMNS if name in self._keys_in_file}
        stated: dict[str, Any] = {} if self.motion is None else {"motion": self.motion}
        path = place.reading.path(self.file)
        test = ModalTest.read(path, band=self.band, columns=named, **stated)
        self._motion = test.motion
        self._table = np.stack([test.amplitude, test.frequency, test.damping_ratio], axis=1)
        doubts = [
            f"{v.name} is {v.value:.3g}: {v.remedy}"
            for v in test.verdicts
            if v.value is not None and v.word != "ok"
        ]
        place.reading.notes.extend(f"structure.measured: {n}" for n in (*test.notes, *doubts))

    @property
    def table(self) -> Floats:
        """Columns amplitude [m], frequency [Hz] and damping ratio [-]."""
        return self._table

    @property
    def measured_motion(self) -> Motion:
        """Whether it was steady motion or a decay."""
        return self._motion


class _Tests(Items):
    """One table, or a list of them."""

    def read(self, raw_value: object, place: Place) -> Any:
        """A tuple of the tests."""
        return super().read([raw_value] if isinstance(raw_value, dict) else raw_value, place)

    def schema(self) -> JsonSchema:
        """A table, or a list of them."""
        several = super().schema()
        return {"anyOf": [several["items"], several]}


TESTS = _Tests(Table(MeasuredPart), '[{ file = "test.csv" }]', (0, 20))
