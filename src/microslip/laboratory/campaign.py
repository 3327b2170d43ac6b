"""Evaluation of several measured records together: wear, contradictions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from microslip._core import checks
from microslip._core.checks import positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.units import engineering
from microslip.laboratory.manifest import Cell, text_of
from microslip.laboratory.measurement import Measurement
from microslip.laboratory.wear import Wear, wear_of

_CARRIED, _SAME_LOAD, _BESIDE = 1.05, 0.03, 0.25
"""Ratio of forces above which two records contradict each other; relative width of one load;
largest relative difference of measured and nominal load or amplitude."""

NUMBERS = {"worn_volume": "m^3", "first_cycle": "", "normal_load": "N", "amplitude": "m"}
"""Numeric columns of a campaign and their units."""


@dataclass(frozen=True, eq=False)
class Campaign(Locked):
    """Measured records of one or several test runs.

    Parameters
    ----------
    measurements : sequence of Measurement
        Evaluated records, at least one.
    columns : mapping of str to sequence, optional
        Data of each record, as in a manifest, such as "stage"; None where a value is unknown.
        Records with equal "specimen" (without it, equal "run": test run, rig or laboratory) are of
        one contact. "worn_volume" [m^3] is the volume after the record, "first_cycle" [-] the
        number of its first cycle in the life of the specimen, "normal_load" [N] and "amplitude" [m]
        are nominal values.
    """

    measurements: Sequence[Measurement]
    columns: Mapping[str, Sequence[Cell]] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        count = len(checks.members("measurements", self.measurements, Measurement, "Measurements"))
        if not isinstance(self.columns, Mapping):
            raise InputError(f"`columns` must be a mapping of names, got {show(self.columns)}")
        for name, values in self.columns.items():
            is_right = isinstance(values, Sequence) and not isinstance(values, str)
            if not (is_right and len(values) == count):
                raise InputError(
                    f"`columns`: {name} must have a value for each of {count} records, got "
                    f"{show(values)}"
                )
        for name, unit in NUMBERS.items():
            for value in self._column(name):
                if value is not None and value != 0.0:
                    positive(name, value, unit, 1.0)

    def _column(self, name: str) -> Sequence[Any]:
        return self.columns.get(name) or [None] * len(self.measurements)

    def wear(self, confidence: float = 0.95) -> Wear | None:
        """Fit the energy wear coefficient to the worn volumes; None if none was measured."""
        return wear_of(
            self.measurements,
            self._contacts() or tuple(map(str, range(len(self.measurements)))),
            self._column("worn_volume"),
            self._column("first_cycle"),
            confidence,
        )

    def _contacts(self) -> tuple[str, ...]:
        """Contact (specimen) of each record; an empty tuple if the records have no labels."""
        return tuple(map(text_of, self.columns.get("specimen") or self.columns.get("run", ())))

    def contradictions(self) -> list[str]:
        """Return notes on records that contradict each other or the values in the manifest.

        A contact in gross slip at a force cannot carry a larger force without gross slip in another
        record at the same load. The mean load or amplitude of a record should not differ from its
        nominal value by more than a quarter.
        """
        notes = []
        for name, unit in (("normal_load", "N"), ("amplitude", "m")):
            for measured, nominal in zip(self.measurements, self._column(name), strict=True):
                mean = measured.mean.get(name)
                if nominal and mean and abs(mean.value - nominal) > _BESIDE * nominal:
                    notes.append(
                        f"{measured.name}: {name.replace('_', ' ')} {engineering(nominal, unit)} "
                        f"by the manifest, measured {engineering(mean.value, unit)}"
                    )
        labels = self._contacts()
        by_load: dict[tuple[str, int], list[Measurement]] = {}
        for i, measured in enumerate(self.measurements):
            load = measured.mean.get("normal_load")
            if load is not None and load.value > 0.0:  # unlabelled records are of one contact
                step = round(math.log(load.value) / _SAME_LOAD)
                by_load.setdefault((labels[i] if labels else "", step), []).append(measured)
        for members in by_load.values():
            sliding = [m for m in members if set(m.possible_regimes) == {"gross slip"}]
            if not sliding:
                continue
            weakest = min(sliding, key=lambda m: m.mean["force_amplitude"].value)
            limit = weakest.mean["force_amplitude"]
            for other in members:
                force = other.mean["force_amplitude"]
                if force.value > _CARRIED * limit.value and "gross slip" not in (
                    other.possible_regimes
                ):
                    notes.append(
                        f"{weakest.name} is in gross slip at {engineering(limit.value, 'N')}, but "
                        f"{other.name} reaches {engineering(force.value, 'N')} in "
                        f"{other.regime} at the same load: friction or load changed between "
                        "them, or one of them has a parallel spring or spikes; the regimes of "
                        "both are uncertain"
                    )
        return notes
