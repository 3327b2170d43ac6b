"""Evaluation of several measured records together: evolution, fretting map and wear.

Worn volume is proportional to dissipated energy, after Fouvry, Liskiewicz, Kapsa, Hannel and Sauger
(2003, DOI 10.1016/S0043-1648(03)00117-0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from microslip._core import checks
from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.units import engineering
from microslip.laboratory.blocks import Dissipated, dissipated
from microslip.laboratory.cycle_columns import gain_error
from microslip.laboratory.estimates import Estimate, quantile, with_gain
from microslip.laboratory.manifest import Cell, text_of
from microslip.laboratory.measurement import Measurement

_NEW = 0.05
"""Fraction of the cycles before the first logged one that is neglected."""
_CARRIED, _SAME_LOAD = 1.05, 0.03
"""Ratio of forces above which two records contradict each other; relative width of one load."""
MIXED = 0.05
"""Probability of a second regime from which on a condition is mixed."""
_LEAST_WORK = 1e-3
"""Smallest share of the work that is assumed, whatever its error."""


def _accumulated(measured: Measurement) -> Dissipated:
    up_to = measured.dissipated()
    unknown = np.full(len(measured), np.nan)
    return Dissipated(unknown, unknown) if up_to is None else up_to


class Point(NamedTuple):
    """Record as a point of the fretting map."""

    record: str
    amplitude: float
    """Displacement amplitude [m]."""
    normal_load: float
    """Normal load [N]."""
    regime: str
    """Likeliest regime; "mixed" if another one has a probability or share of cycles of 5 %."""


@dataclass(frozen=True, eq=False)
class Campaign(Locked):
    """Measured records of one or several test runs.

    Parameters
    ----------
    measurements : sequence of Measurement
        Evaluated records in the order in which they were recorded, at least one.
    runs : sequence of str, optional
        Label of the run, the rig or the laboratory of each record. Records with the same label are
        of one contact. Without it, and without a column "specimen", each record is of a separate
        contact.
    worn_volumes : sequence of float or None, optional
        Worn volume [m^3] measured after each record; None if it was not measured.
    columns : mapping of str to sequence, optional
        Other data of each record, as in a manifest: "specimen", "stage" and others.

    Notes
    -----
    Fretting maps after Vingsbo and Soderberg (1988, DOI 10.1016/0043-1648(88)90050-1).
    """

    measurements: Sequence[Measurement]
    runs: Sequence[str] | None = None
    worn_volumes: Sequence[float | None] | None = None
    columns: Mapping[str, Sequence[Cell]] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        count = len(checks.members("measurements", self.measurements, Measurement, "Measurements"))
        if not isinstance(self.columns, Mapping):
            raise InputError(f"`columns` must be a mapping of names, got {show(self.columns)}")
        for name, values in {
            "runs": self.runs, "worn_volumes": self.worn_volumes, **self.columns
        }.items():  # fmt: skip
            is_right = isinstance(values, Sequence) and not isinstance(values, str)
            if values is not None and not (is_right and len(values) == count):
                raise InputError(
                    f"`{name}` must be one for each of {count} records, got {show(values)}"
                )
        for volume in self.worn_volumes or ():
            if volume is not None and volume != 0.0:
                positive("worn_volumes", volume, "m^3", 1e-12)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Label of each record's contact: the specimen, else the run, else the record number."""
        if "specimen" in self.columns:
            return tuple(map(text_of, self.columns["specimen"]))
        return tuple(self.runs or map(str, range(len(self.measurements))))

    def energies(self) -> Floats:
        """Return the energy [J] dissipated in all cycles of each record, unlogged cycles included.

        NaN if the number of unlogged cycles is not known.
        """
        return np.array([_accumulated(measured).energy[-1] for measured in self.measurements])

    def uncounted(self) -> dict[str, str]:
        """Return the names of records whose contact energy is unknown, with the reason."""
        reasons = {}
        energies, _ = self.worn_by()
        for measured, energy in zip(self.measurements, energies, strict=True):
            if math.isfinite(energy) or measured.count is None:
                continue
            reasons[measured.name] = measured.count.source
            if measured.name in self._counted_twice():
                reasons[measured.name] = (
                    "its specimen has several series whose cycles are counted from the same "
                    "number; state in the manifest the number of the first cycle of each file in "
                    'the life of the specimen, "cycle", or a "specimen" of its own for each series'
                )
            elif measured.count.numbers is not None:
                reasons[measured.name] = (
                    f"it begins at cycle {measured.count.numbers[0]:.12g}, and what was before is "
                    "not among the records of its run; give those of one contact the same specimen"
                )
        return reasons

    def cumulative(self) -> list[Floats]:
        """Return the cumulative energy [J] at each cycle, for each record.

        The energy of earlier records of the same contact is included. Without labels of runs or
        specimens each record is a separate contact.
        """
        return [up_to.energy for up_to in self._cumulated()]

    def _cumulated(self) -> list[Dissipated]:
        cumulated = {
            i: up_to
            for members in self._by_contact().values()
            for i, up_to in zip(members, self._of_contact(members), strict=True)
        }
        return [cumulated[i] for i in range(len(self.measurements))]

    def _by_contact(self) -> dict[str, list[int]]:
        by_contact: dict[str, list[int]] = {}
        for i, label in enumerate(self.contacts):
            by_contact.setdefault(label, []).append(i)
        return by_contact

    def _counted_twice(self) -> set[str]:
        """Return the names of records of a contact in which a cycle number occurs twice."""
        names: set[str] = set()
        for members in self._by_contact().values():
            counts = [self.measurements[i].count for i in members]
            ranges = sorted(
                (float(c.numbers[0]), float(c.numbers[-1]))
                for c in counts
                if c is not None and c.is_of_contact and c.numbers is not None
            )
            if any(second[0] <= first[1] for first, second in pairwise(ranges)):
                names |= {self.measurements[i].name for i in members}
        return names

    def contradictions(self) -> list[str]:
        """Return notes on records of one contact and load that contradict each other.

        A contact in gross slip at a force cannot carry a larger force without gross slip in another
        record at the same load.
        """
        notes = []
        for members in self._by_load().values():
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

    def _by_load(self) -> dict[tuple[str, int], list[Measurement]]:
        """Group records by contact and load; unlabelled records are taken as one contact."""
        is_named = "specimen" in self.columns or self.runs is not None
        by_load: dict[tuple[str, int], list[Measurement]] = {}
        for measured, label in zip(self.measurements, self.contacts, strict=True):
            load = measured.mean.get("normal_load")
            if load is not None and load.value > 0.0:
                step = round(math.log(load.value) / _SAME_LOAD)
                by_load.setdefault((label if is_named else "", step), []).append(measured)
        return by_load

    def _numbered_through(self, members: Sequence[int]) -> list[Floats] | None:
        counts = [self.measurements[i].count for i in members]
        numbers = [c.numbers for c in counts if c is not None and c.is_of_contact]
        known = [values for values in numbers if values is not None]
        if len(known) < len(members) or np.any(np.diff(np.concatenate(known)) <= 0.0):
            return None
        return known

    def _of_contact(self, members: Sequence[int]) -> list[Dissipated]:
        measurements = [self.measurements[i] for i in members]
        numbers = self._numbered_through(members) if len(members) > 1 else None
        if numbers is not None:
            energy_of_each = np.concatenate([m.cycles["dissipated_energy"] for m in measurements])
            edges = np.cumsum([len(measured) for measured in measurements])[:-1]
            joined = dissipated(np.concatenate(numbers), energy_of_each)
            return [
                Dissipated(*parts)
                for parts in zip(*(np.split(j, edges) for j in joined), strict=True)
            ]
        before, found = (0.0, 0.0), []
        for measured in measurements:
            energy, errors = _accumulated(measured)
            found.append(Dissipated(before[0] + energy, before[1] + errors))
            before = float(found[-1].energy[-1]), found[-1].error
        return found

    def worn_by(self) -> tuple[Floats, Floats]:
        """Return the energy [J] dissipated by each record's contact since new, and its error.

        NaN if the energy is not known.
        """
        of_each = [_accumulated(measured) for measured in self.measurements]
        chosen = []
        twice = self._counted_twice()
        for measured, alone, cumulated in zip(
            self.measurements, of_each, self._cumulated(), strict=True
        ):
            count = measured.count
            numbers = None if count is None or not count.is_of_contact else count.numbers
            # A specimen is worn by all that was before, whatever numbers its cycles; a run that the
            # rig's counter numbers through as well.
            is_all = numbers is not None or "specimen" in self.columns
            worn = cumulated if is_all else alone
            energy = float(worn.energy[-1])
            if measured.name in twice:
                energy = math.nan
            begins = 1.0 if numbers is None else float(numbers[0]) - _NEW * float(numbers[-1])
            if begins > 1.0 and float(alone.energy[-1]) == energy:
                energy = math.nan  # what was before is not known
            chosen.append((energy, worn.error))
        energies, errors = np.array(chosen).T
        return energies, errors

    def fretting_map(self) -> list[Point]:
        """Return amplitude, load and regime of each record that has a normal load."""
        points = []
        for measured in self.measurements:
            load = measured.mean.get("normal_load")
            if load is None:
                continue
            likely = sorted(measured.probability.values())
            count = len(measured)
            frequencies = sorted(
                measured.regimes.count(name) / count for name in measured.probability
            )
            mixed = len(likely) > 1 and max(likely[-2], frequencies[-2]) >= MIXED
            amplitude = measured.mean["amplitude"].value
            regime = "mixed" if mixed else measured.regime
            points.append(Point(measured.name, amplitude, load.value, regime))
        return points

    def wear(self, confidence: float = 0.95) -> Wear | None:
        """Fit the energy wear coefficient [m^3/J] to records with a worn volume; None without."""
        volumes = self.worn_volumes or [None] * len(self.measurements)
        energies, errors = self.worn_by()
        rows = [
            i
            for i, volume in enumerate(volumes)
            if volume is not None and math.isfinite(energies[i])
        ]
        if not rows:
            return None
        volume = np.array([volumes[i] for i in rows], dtype=float)
        names = tuple(self.measurements[i].name for i in rows)
        wear = with_unlogged_cycles(names, energies[rows], errors[rows], volume, confidence)
        gain = gain_error("dissipated_energy", self.measurements[0].gain_errors)
        return wear._replace(coefficient=with_gain(wear.coefficient, gain, confidence))


class Wear(NamedTuple):
    """Energy wear coefficient [m^3/J]: worn volume per dissipated energy."""

    coefficient: Estimate
    """Slope of a straight line through zero [m^3/J]."""
    records: tuple[str, ...]
    energy: Floats
    """Energy that the contact of each record has dissipated [J]."""
    volume: Floats
    """Worn volumes [m^3]."""
    scatter: float = math.nan
    """Standard deviation of the volumes about the line [m^3]."""


def with_unlogged_cycles(
    names: tuple[str, ...], work: Floats, errors: Floats, volume: Floats, confidence: float
) -> Wear:
    """Fit :func:`proportional` and widen its interval by the error of unlogged cycles.

    The errors [J] are bounds common to all records of a contact, so the change of the coefficient
    is added to each end of the interval, not in quadrature.
    """
    wear = proportional(names, work, volume, confidence)
    if not errors.any():
        return wear
    ends = (np.maximum(work - errors, _LEAST_WORK * work), work + errors)
    values = [proportional(names, end, volume, confidence).coefficient.value for end in ends]
    value, low, high, error, number = wear.coefficient
    below, above = value - min(*values, value), max(*values, value) - value
    if math.isnan(low):  # a single volume has no scatter
        low = high = value
    return wear._replace(coefficient=Estimate(value, low - below, high + above, error, number))


def proportional(names: tuple[str, ...], work: Floats, volume: Floats, confidence: float) -> Wear:
    """Fit worn volume [m^3] as proportional to dissipated energy [J], by least squares."""
    if not np.all(work > 0.0):
        raise InputError(
            "an energy wear coefficient needs records that dissipate energy, got "
            f"{float(work.min()):.3g} J; is the sign of the force right?"
        )
    square = float(work @ work)
    slope = float(work @ volume) / square
    if work.size < 2:
        nothing = math.nan
        return Wear(Estimate(slope, nothing, nothing, nothing, 1), names, work, volume)
    residual = volume - slope * work
    scatter = math.sqrt(float(residual @ residual) / (work.size - 1))
    error = scatter / math.sqrt(square)
    half = quantile(confidence, work.size - 1) * error
    coefficient = Estimate(slope, slope - half, slope + half, error, int(work.size))
    return Wear(coefficient, names, work, volume, scatter=scatter)
