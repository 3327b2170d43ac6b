"""Evaluation of several measured records together: wear, contradictions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from microslip._core import checks
from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.units import engineering
from microslip.laboratory.cycle_columns import gain_error
from microslip.laboratory.estimates import Estimate, checked_confidence, quantile, with_gain
from microslip.laboratory.manifest import Cell, text_of
from microslip.laboratory.measurement import Measurement

_CARRIED, _SAME_LOAD, _BESIDE = 1.05, 0.03, 0.25
"""Ratio of forces above which two records contradict each other; relative width of one load;
largest relative difference of measured and nominal load or amplitude."""

_NEW = 0.05
"""Largest fraction of the cycles of a specimen that may be missing before its first record."""
_FIRST_CYCLE = (
    "State in the manifest the number of the first cycle of each file in the life of the specimen, "
    'in a column "first cycle"'
)

NUMBERS = {"worn_volume": "m^3", "first_cycle": "", "normal_load": "N", "amplitude": "m"}
"""Numeric columns of a campaign and their units."""


class Wear(NamedTuple):
    """Energy wear coefficient of the records with a worn volume."""

    coefficient: Estimate | None
    """Slope [m^3/J] of the line through zero of worn volume over energy; None without records."""
    records: tuple[str, ...]
    """Names of these records."""
    energy: Floats
    """Energy that the specimen had dissipated at the end of each record [J]."""
    volume: Floats
    """Worn volumes [m^3]."""
    unknown: Mapping[str, str] = MappingProxyType({})
    """Names of records with a worn volume but without a known energy, with the reason."""


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
        """Fit worn volumes as proportional to the energy dissipated since the specimen was new.

        After Fouvry, Liskiewicz, Kapsa, Hannel and Sauger (2003, DOI
        10.1016/S0043-1648(03)00117-0). Cycles are numbered by "first_cycle", else by the rig's
        counter, or from 1 in the only record of a specimen. Energies of cycles that were not logged
        are interpolated linearly in the cycle number. The interval of the coefficient includes the
        largest error of this interpolation if the energy changes monotonically between the logged
        cycles. None if no volume was measured.
        """
        confidence = checked_confidence(confidence)
        measurements, volumes = self.measurements, self._column("worn_volume")
        first_cycles = self._column("first_cycle")
        specimens = self._contacts() or tuple(map(str, range(len(measurements))))
        if not any(volume is not None for volume in volumes):
            return None
        rows: list[tuple[str, float, float, float]] = []
        unknown: dict[str, str] = {}
        for i, volume in enumerate(volumes):
            if volume is None:
                continue
            members = [j for j, name in enumerate(specimens) if name == specimens[i]]
            try:
                numbers = [
                    _numbers(measurements[j], first_cycles[j], len(members)) for j in members
                ]
                energy, error = _energy_until(measurements, members, numbers, i)
            except InputError as reason:
                unknown[measurements[i].name] = str(reason)
                continue
            rows.append((measurements[i].name, energy, error, volume))
        work, errors, worn = np.array([row[1:] for row in rows]).reshape(-1, 3).T
        coefficient = None
        if rows:
            gain = gain_error("dissipated_energy", measurements[0].gain_errors)
            line = _line_through_zero(work, errors, worn, confidence)
            coefficient = with_gain(line, gain, confidence)
        names = tuple(row[0] for row in rows)
        return Wear(coefficient, names, work, worn, MappingProxyType(unknown))

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


def _numbers(measured: Measurement, first: float | None, records: int) -> Floats:
    """Number the cycles of a record in the life of its specimen, from 1."""
    counter = measured.cycles.get("cycle_number")
    if counter is not None and np.all(np.diff(counter) > 0.0):
        return counter if first is None else counter + (first - counter[0])
    if np.any(np.diff(measured.cycles["start"]) > measured.cycles["period"][:-1] + 0.5):
        raise InputError(
            "cycles between its blocks were not logged; name the column of the rig's counter of "
            'cycles ("cycle column" in a manifest, `cycle_number=...` in Python)'
        )
    if first is None and records > 1:
        raise InputError(f"its specimen has several records. {_FIRST_CYCLE}")
    return np.arange(float(len(measured))) + (1.0 if first is None else first)


def _energy_until(
    measurements: Sequence[Measurement], members: list[int], numbers: list[Floats], last: int
) -> tuple[float, float]:
    """Return the energy [J] of a specimen up to the end of a record, and the bound of its error."""
    ordered = sorted(zip(numbers, members, strict=True), key=lambda pair: float(pair[0][0]))
    if any(after[0] <= before[-1] for (before, _), (after, _) in pairwise(ordered)):
        raise InputError(
            "its specimen has several series whose cycles are counted from the same number. "
            f'{_FIRST_CYCLE}, or a "specimen" of its own for each series'
        )
    end = next(float(of_record[-1]) for of_record, j in ordered if j == last)
    number = np.concatenate([of_record for of_record, _ in ordered])
    energy = np.concatenate([measurements[j].cycles["dissipated_energy"] for _, j in ordered])
    known = (number <= end) & np.isfinite(energy)
    number, energy = number[known], energy[known]
    if number[0] - 1.0 > _NEW * end:
        raise InputError(
            f"its specimen's first record begins at cycle {number[0]:.12g}; the energy before is "
            "not known: give the records from the first cycle on"
        )
    skipped = np.diff(number) - 1.0
    between = 0.5 * (energy[:-1] + energy[1:])
    error = float(np.sum(skipped * 0.5 * np.abs(np.diff(energy))))
    before = (number[0] - 1.0) * energy[0]
    total = float(energy.sum() + np.sum(skipped * between) + before)
    if not total > 0.0:
        raise InputError(f"its energy is {total:.3g} J; check the sign of the force")
    return total, error + before


def _line_through_zero(work: Floats, errors: Floats, volume: Floats, confidence: float) -> Estimate:
    """Fit volume = slope * work; the interval includes the bounds ``errors`` of ``work`` [J]."""
    square = float(work @ work)
    slope = float(work @ volume) / square
    error, half = math.nan, 0.0
    if work.size > 1:
        residual = volume - slope * work
        error = math.sqrt(float(residual @ residual) / (work.size - 1) / square)
        half = quantile(confidence, work.size - 1) * error
    elif not errors.any():
        return Estimate(slope, math.nan, math.nan, math.nan, 1)
    # Errors of cycles that were not logged are bounds, and may have one sign in all records.
    ratio = float((errors / work).max())
    low, high = (slope - half) / (1.0 + ratio), (slope + half) / max(1.0 - ratio, 1e-3)
    return Estimate(slope, low, high, error, int(work.size))
