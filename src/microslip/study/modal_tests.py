"""Floor 10: tests of modes in a study, drawn over what it predicts, and what is fitted to them."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, PrivateAttr, ValidationInfo, model_validator

from microslip._core.checks import Floats
from microslip._core.units import FREQUENCY, LENGTH
from microslip.study.columns import Column, FileName
from microslip.study.fields import Line, Share, array, different, integer, one_of, quantity
from microslip.study.part import Check, Part, Reading, optional, required

FITTED = ("friction_coefficient", "tension", "form", "base_damping_ratio")
"""What can be fitted to a test."""

MOST_MODES = 10

Hertz = Annotated[float, quantity(FREQUENCY, "150 Hz")]


class MeasuredPart(Part):
    """A test of one mode, drawn over the prediction: a curve, a ring-down or a stepped sine."""

    file: FileName = required(
        "CSV file with a line of column names; relative to the folder of the study. "
        "Amplitude, frequency and damping ratio are a curve; time and displacement, velocity or "
        "acceleration a ring-down; frequency, amplitude and phase a stepped sine.",
        '"test.csv"',
    )
    amplitude: Line = optional(
        "Column of the displacement amplitudes at the sensor.", '"amplitude"', default="amplitude"
    )
    frequency: Line = optional("Column of the frequencies.", '"frequency"', default="frequency")
    damping_ratio: Line = optional(
        "Column of the damping ratios, in percent where its header says so.",
        '"damping_ratio"',
        default="damping_ratio",
    )
    band: Annotated[tuple[Hertz, Hertz], array('["150 Hz", "220 Hz"]', 2, min_items=2)] | None = (
        optional(
            "Frequencies between which the mode of a ring-down lies, where others ring with it.",
            '["150 Hz", "220 Hz"]',
        )
    )
    mode: Annotated[int, integer(1, MOST_MODES, words="a mode counted from 1")] | None = optional(
        "The mode that was tested, counted from 1; of `structure.modes` the one whose "
        "frequency is nearest unless given.",
        "1",
    )
    fit: (
        Annotated[
            tuple[Annotated[str, one_of(*FITTED)], ...],
            array('["friction_coefficient", "tension"]', len(FITTED)),
            AfterValidator(different),
        ]
        | None
    ) = optional(
        "What is fitted to the test, from the values of the study on.",
        '["friction_coefficient", "tension"]',
    )
    frequency_error: Share = optional(
        "Relative uncertainty of the frequencies, the model's included.", default=0.003
    )
    damping_error: Share = optional("Relative uncertainty of the damping ratios.", default=0.05)
    _table: Floats = PrivateAttr(default_factory=lambda: np.zeros((0, 3)))

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        from microslip._core.units import RATIO
        from microslip.structures import ModalTest
        from microslip.structures.modal_test import modal_kind

        reading = Reading.of(info)
        path = reading.path(self.file)
        named = {"amplitude", "frequency", "damping_ratio"} & self.model_fields_set
        kind = modal_kind(path)
        if self.band is not None or kind in ("ring-down", "stepped sine") or (kind and not named):
            test = ModalTest.read(path, band=self.band)
            self._table = np.stack([test.amplitude, test.frequency, test.damping_ratio], axis=1)
            reading.notes.extend(f"structure.measured: {note}" for note in test.notes)
            return self
        read = [
            Column(file=self.file, column=name, unit=unit).read(
                kind, "positive", info, f"structure.measured.{key}"
            )
            for key, name, kind, unit in (
                ("amplitude", self.amplitude, LENGTH, None),
                ("frequency", self.frequency, FREQUENCY, None),
                ("damping_ratio", self.damping_ratio, RATIO, "1"),
            )
        ]
        self._table = np.array(read).T
        return self

    @property
    def table(self) -> Floats:
        """Columns amplitude [m], frequency [Hz] and damping ratio [-]."""
        return self._table


def _as_list(raw_value: object) -> object:
    return [raw_value] if isinstance(raw_value, (dict, MeasuredPart)) else raw_value


Tests = Annotated[
    tuple[MeasuredPart, ...],
    Check(_as_list, lambda inner: {"anyOf": [inner["items"], {**inner, "maxItems": 20}]}),
]
