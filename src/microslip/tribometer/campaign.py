"""Measured records together: evolution, fretting map, wear, and runs compared."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.frozen import Locked
from microslip._core.units import engineering
from microslip.errors import InputError
from microslip.tribometer.counting import dissipated
from microslip.tribometer.estimates import Estimate, quantile
from microslip.tribometer.measurement import Measurement

COMPARED = ("friction_peak", "friction_energy", "reversal_stiffness", "dissipated_energy")
"""Columns whose means are compared between runs."""
SAME_CONDITION = 0.05
"""Share by which loads, and amplitudes, may differ to be of one condition."""
_NEW = 0.05
"""Share of the cycles of a contact before its first logged one that is neglected."""
MIXED = 0.05
"""Probability of a second regime from which on a condition is mixed."""


class Point(NamedTuple):
    """A record in the fretting map."""

    record: str
    amplitude: float
    """[m]"""
    normal_load: float
    """[N]"""
    regime: str
    """The likeliest; "mixed" where another one is as likely as 1 in 20, or has as many cycles."""


class Wear(NamedTuple):
    """Energy wear coefficient: worn volume over dissipated energy."""

    coefficient: Estimate
    """[m^3/J], of a straight line through zero."""
    records: tuple[str, ...]
    energy: Floats
    """Energy [J] dissipated in all cycles of each record."""
    volume: Floats
    """Worn volume [m^3]."""


class BetweenRuns(NamedTuple):
    """A quantity over several runs at one condition: analysis of variance, runs at random."""

    column: str
    condition: str
    runs: tuple[str, ...]
    mean: Estimate
    """Mean of the means of runs; its interval holds what differs between runs."""
    within: float
    """Standard deviation between the records of a run; not a number of one record a run."""
    between: float
    """Standard deviation between the runs themselves; 0 where no more than within shows."""


@dataclass(frozen=True, eq=False)
class Campaign(Locked):
    """Measured records of one or several runs.

    Parameters
    ----------
    measurements : sequence of Measurement
        In the order in which they were recorded, at least one.
    runs : sequence of str, optional
        Label of the run, the rig or the laboratory of each; without it each is a specimen of its
        own.
    worn_volumes : sequence of float or None, optional
        Worn volume [m^3] that goes with each record, above zero; None where none was measured.
    area : float, optional
        Apparent area [m^2], for energies and stiffnesses per area.

    Notes
    -----
    Wear after Fouvry, Liskiewicz, Kapsa, Hannel and Sauger (2003, DOI
    10.1016/S0043-1648(03)00117-0); fretting maps after Vingsbo and Soderberg (1988, DOI
    10.1016/0043-1648(88)90050-1); variance between runs as in ISO 5725-2.
    """

    measurements: Sequence[Measurement]
    runs: Sequence[str] | None = None
    worn_volumes: Sequence[float | None] | None = None
    area: float | None = None

    def __post_init__(self) -> None:
        count = len(self.measurements)
        if count == 0:
            raise InputError("`measurements` must be at least one, got none")
        for name in ("runs", "worn_volumes"):
            labels = getattr(self, name)
            if labels is not None and len(labels) != count:
                raise InputError(
                    f"`{name}` must be one for each of {count} records, got {show(labels)}"
                )
        for volume in self.worn_volumes or ():
            if volume is not None:
                positive("worn_volumes", volume, "m^3", 1e-12)
        if self.area is not None:
            positive("area", self.area, "m^2", 2e-4)

    def energies(self) -> Floats:
        """Energy [J] dissipated in all cycles of each record, those not logged included.

        Not a number where these are not known.
        """
        totals = [measured.dissipated() for measured in self.measurements]
        return np.array([math.nan if up_to is None else up_to.energy[-1] for up_to in totals])

    def uncounted(self) -> dict[str, str]:
        """Records whose energy is not known, and why."""
        reasons = {}
        energies = self._worn_by()
        for measured, energy in zip(self.measurements, energies, strict=True):
            if math.isfinite(energy) or measured.count is None:
                continue
            reasons[measured.name] = measured.count.source
            if measured.count.numbers is not None:
                reasons[measured.name] = (
                    f"it begins at cycle {measured.count.numbers[0]:.12g}, and what was before is "
                    "not among the records of its run"
                )
        return reasons

    def cumulative(self) -> list[Floats]:
        """Energy [J] dissipated up to each cycle of each record, on from the last of its run.

        Records without the label of a run are specimens of their own.
        """
        labels = self.runs or [str(i) for i in range(len(self.measurements))]
        by_run: dict[str, list[int]] = {}
        for i, label in enumerate(labels):
            by_run.setdefault(label, []).append(i)
        cumulated = {
            i: energy
            for members in by_run.values()
            for i, energy in zip(members, self._of_run(members), strict=True)
        }
        return [cumulated[i] for i in range(len(self.measurements))]

    def _of_run(self, members: Sequence[int]) -> list[Floats]:
        """Energy [J] up to each cycle of the records of one run."""
        measurements = [self.measurements[i] for i in members]
        counts = [measured.count for measured in measurements]
        numbers = [c.numbers for c in counts if c is not None and c.is_of_contact]
        if len(members) > 1 and len(numbers) == len(members):
            joined = np.concatenate([values for values in numbers if values is not None])
            if np.all(np.diff(joined) > 0.0):
                energy_of_each = np.concatenate(
                    [m.cycles["dissipated_energy"] for m in measurements]
                )
                edges = np.cumsum([len(measured) for measured in measurements])[:-1]
                return list(np.split(dissipated(joined, energy_of_each).energy, edges))
        before, energies = 0.0, []
        for measured in measurements:
            up_to = measured.dissipated()
            energy_of_each = np.full(len(measured), np.nan) if up_to is None else up_to.energy
            energies.append(before + energy_of_each)
            before = float(energies[-1][-1])
        return energies

    def _worn_by(self) -> Floats:
        """Energy [J] that the contact of each record has dissipated since it was new."""
        energies = self.energies()
        for i, (measured, cumulated) in enumerate(
            zip(self.measurements, self.cumulative(), strict=True)
        ):
            count = measured.count
            if count is None or count.numbers is None or not count.is_of_contact:
                continue
            energy_of_each, first = float(energies[i]), float(count.numbers[0])
            # Of a run that the rig's counter numbers through, all that was before.
            energies[i] = cumulated[-1]
            if energy_of_each == cumulated[-1] and first > 1.0 + _NEW * float(count.numbers[-1]):
                energies[i] = math.nan
        return energies

    def fretting_map(self) -> list[Point]:
        """Amplitude, load and regime of each record that has a normal load."""
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
        """Energy wear coefficient of the worn records whose energy is known; None without any."""
        volumes = self.worn_volumes or [None] * len(self.measurements)
        energies = self._worn_by()
        rows = [i for i, volume in enumerate(volumes) if volume is not None]
        rows = [i for i in rows if math.isfinite(energies[i])]
        if not rows:
            return None
        energy = energies[rows]
        volume = np.array([volumes[i] for i in rows], dtype=float)
        if not np.all(energy > 0.0):
            raise InputError(
                "an energy wear coefficient needs records that dissipate energy, got "
                f"{float(energy.min()):.3g} J; is the sign of the force right?"
            )
        square = float(energy @ energy)
        slope = float(energy @ volume) / square
        names = tuple(self.measurements[i].name for i in rows)
        if energy.size < 2:
            nothing = math.nan
            return Wear(Estimate(slope, nothing, nothing, nothing, 1), names, energy, volume)
        residual = volume - slope * energy
        error = math.sqrt(float(residual @ residual) / (energy.size - 1) / square)
        half = quantile(confidence, energy.size - 1) * error
        coefficient = Estimate(slope, slope - half, slope + half, error, int(energy.size))
        return Wear(coefficient, names, energy, volume)

    def comparison(self, confidence: float = 0.95) -> list[BetweenRuns]:
        """Runs compared, at each condition that at least two of them have; none without runs."""
        if self.runs is None or len(set(self.runs)) < 2:
            return []
        comparisons = []
        for condition, members in self._conditions():
            for column in COMPARED:
                by_run: dict[str, list[float]] = {}
                for i in members:
                    mean = self.measurements[i].mean.get(column)
                    if mean is not None and math.isfinite(mean.value):
                        by_run.setdefault(self.runs[i], []).append(mean.value)
                if len(by_run) > 1:
                    comparisons.append(between_runs(column, condition, by_run, confidence))
        return comparisons

    def _conditions(self) -> list[tuple[str, list[int]]]:
        """Records of one load and amplitude, and what these are in words."""
        groups: list[list[int]] = []
        places = []
        for measured in self.measurements:
            pressed = measured.mean.get("normal_load")
            amplitude = measured.mean["amplitude"].value
            places.append((amplitude, math.nan if pressed is None else pressed.value))
        for i, place in enumerate(places):
            for group in groups:
                first = places[group[0]]
                if all(
                    (math.isnan(a) and math.isnan(b)) or abs(a - b) <= SAME_CONDITION * abs(b)
                    for a, b in zip(place, first, strict=True)
                ):
                    group.append(i)
                    break
            else:
                groups.append([i])
        words = []
        for group in groups:
            amplitude, load = places[group[0]]
            text = engineering(amplitude, "m")
            words.append(text if math.isnan(load) else f"{text}, {engineering(load, 'N')}")
        return list(zip(words, groups, strict=True))


def between_runs(
    column: str, condition: str, by_run: dict[str, list[float]], confidence: float
) -> BetweenRuns:
    """One-way analysis of variance with random runs, which may have unlike numbers of records."""
    sizes = np.array([len(values) for values in by_run.values()], dtype=float)
    means = np.array([float(np.mean(values)) for values in by_run.values()])
    runs, total = sizes.size, float(sizes.sum())
    middle = float(means.mean())
    error = float(means.std(ddof=1)) / math.sqrt(runs)
    half = quantile(confidence, runs - 1) * error
    within, variance = math.nan, float(means.var(ddof=1))
    if total > runs:
        square = sum(float(np.sum((np.array(v) - np.mean(v)) ** 2)) for v in by_run.values())
        within = math.sqrt(square / (total - runs))
        grand = float(sizes @ means) / total
        among = float(sizes @ (means - grand) ** 2) / (runs - 1)
        usual = (total - float(sizes @ sizes) / total) / (runs - 1)
        variance = max(among - within**2, 0.0) / usual
    mean = Estimate(middle, middle - half, middle + half, error, runs)
    return BetweenRuns(column, condition, tuple(by_run), mean, within, math.sqrt(variance))
