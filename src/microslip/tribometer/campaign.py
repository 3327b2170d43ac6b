"""Measured records together: evolution, fretting map, wear, and runs compared."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.frozen import Locked
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quoted
from microslip.errors import InputError
from microslip.tribometer.blocks import Dissipated, dissipated
from microslip.tribometer.campaign_laws import (
    ARCHARD,
    Pooled,
    RunningIn,
    Wear,
    of_one,
    pooled,
    proportional,
    running_in,
    unlogged,
    with_threshold,
)
from microslip.tribometer.cycle_columns import gain_error
from microslip.tribometer.estimates import Estimate, quantile, with_gain
from microslip.tribometer.manifest import Cell, numeric, text_of
from microslip.tribometer.measurement import Measurement
from microslip.tribometer.regimes import RegimeBorders

PerCycle = Callable[[Measurement], Floats]
"""Contribution of each cycle of a record to a sum."""


def energy_of(measured: Measurement) -> Floats:
    """Energy [J] of each cycle."""
    return measured.cycles["dissipated_energy"]


def archard_of(measured: Measurement) -> Floats:
    """Normal load times sliding distance [N m] of each cycle."""
    return 4.0 * measured.cycles["normal_load"] * measured.cycles["sliding_distance"]


def _accumulated(measured: Measurement, of: PerCycle) -> Dissipated:
    """Sum over the cycles of one record, those not logged included; NaN if unknown."""
    up_to = measured.accumulated(of(measured))
    unknown = np.full(len(measured), np.nan)
    return Dissipated(unknown, unknown) if up_to is None else up_to


COMPARED = ("friction_peak", "friction_energy", "reversal_stiffness", "dissipated_energy")
"""Columns whose means are compared between runs."""
SAME_CONDITION = 0.05
"""Share by which loads, and amplitudes, may differ to be of one condition."""
_NEW = 0.05
"""Share of the cycles of a contact before its first logged one that is neglected."""
_SPAN = 1.5
"""Ratio of the loads from which on an exponent is asked for."""
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


class LoadLaw(NamedTuple):
    """Stiffness after reversal against normal load: k = k_1 (N/N_1)^n."""

    exponent: Estimate
    """n [-]."""
    stiffness: float
    """[N/m] at the middle load."""
    load: float
    """The middle load, of the logarithms [N]."""
    with_rig: bool
    """Whether the stiffness is that of rig and contact in series."""


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
        Worn volume [m^3] that goes with each record; None where none was measured.
    area : float, optional
        Apparent area [m^2], for energies and stiffnesses per area.

    columns : mapping of str to sequence, optional
        Other data of each record, as of a manifest: "specimen", "stage" and others.
    group : str, optional
        Column whose values are specimens: without it "specimen", where there is one.
    over : str, optional
        Column of numbers over which the means are drawn: without it "stage", where there is one.
    borders : RegimeBorders, optional
        Limits of the regimes by a law, for the fretting map.

    Notes
    -----
    Fretting maps after Vingsbo and Soderberg (1988, DOI
    10.1016/0043-1648(88)90050-1); variance between runs as in ISO 5725-2.
    """

    measurements: Sequence[Measurement]
    runs: Sequence[str] | None = None
    worn_volumes: Sequence[float | None] | None = None
    area: float | None = None
    columns: Mapping[str, Sequence[Cell]] = field(default_factory=lambda: MappingProxyType({}))
    group: str | None = None
    over: str | None = None
    borders: RegimeBorders | None = None

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
        for name, values in self.columns.items():
            if len(values) != count:
                raise InputError(f"column {name!r} must have a value for each of {count} records")
        for name in filter(None, (self.group, self.over)):
            if name not in self.columns:
                raise InputError(
                    f"no column {show(name)}{did_you_mean(name, self.columns)}; there are "
                    f"{quoted(self.columns) if self.columns else 'none'}"
                )
        if self.over is not None and not numeric(self.columns[self.over]):
            raise InputError(f"`over` must be a column of numbers, got {self.over!r}")
        for volume in self.worn_volumes or ():
            if volume is not None and volume != 0.0:
                positive("worn_volumes", volume, "m^3", 1e-12)
        if self.area is not None:
            positive("area", self.area, "m^2", 2e-4)

    @property
    def grouped_by(self) -> str | None:
        """The column whose values are specimens."""
        return self.group or ("specimen" if "specimen" in self.columns else None)

    @property
    def drawn_over(self) -> str | None:
        """The column of numbers over which the means are drawn."""
        stages = self.columns.get("stage")
        return self.over or ("stage" if stages is not None and numeric(stages) else None)

    @property
    def places(self) -> Floats:
        """The numbers of that column; not a number where there is none."""
        values = self.columns[self.drawn_over or ""]
        return np.array([v if isinstance(v, float) else math.nan for v in values])

    @property
    def specimens(self) -> tuple[str, ...]:
        """Label of the specimen of each record; empty where none are told apart."""
        return () if self.grouped_by is None else tuple(map(text_of, self.columns[self.grouped_by]))

    @property
    def contacts(self) -> tuple[str, ...]:
        """Label of the contact of each record: of its specimen, else its run, else its own."""
        if "specimen" in self.columns:
            return tuple(map(text_of, self.columns["specimen"]))
        return tuple(self.runs or map(str, range(len(self.measurements))))

    def energies(self, of: PerCycle = energy_of) -> Floats:
        """Energy [J] dissipated in all cycles of each record, those not logged included.

        Not a number where these are not known.
        """
        return np.array([_accumulated(measured, of).energy[-1] for measured in self.measurements])

    def uncounted(self) -> dict[str, str]:
        """Records whose energy is not known, and why."""
        reasons = {}
        energies, _ = self._worn_by()
        for measured, energy in zip(self.measurements, energies, strict=True):
            if math.isfinite(energy) or measured.count is None:
                continue
            reasons[measured.name] = measured.count.source
            if measured.count.numbers is not None:
                reasons[measured.name] = (
                    f"it begins at cycle {measured.count.numbers[0]:.12g}, and what was before is "
                    "not among the records of its run; give those of one contact the same specimen"
                )
        return reasons

    def cumulative(self, of: PerCycle = energy_of) -> list[Floats]:
        """Energy [J] dissipated up to each cycle of each record, on from the last of its contact.

        Records without the label of a run or a specimen are specimens of their own.
        """
        return [up_to.energy for up_to in self._cumulated(of)]

    def _cumulated(self, of: PerCycle) -> list[Dissipated]:
        cumulated = {
            i: up_to
            for members in self._by_contact().values()
            for i, up_to in zip(members, self._of_contact(members, of), strict=True)
        }
        return [cumulated[i] for i in range(len(self.measurements))]

    def _by_contact(self) -> dict[str, list[int]]:
        by_contact: dict[str, list[int]] = {}
        for i, label in enumerate(self.contacts):
            by_contact.setdefault(label, []).append(i)
        return by_contact

    def _numbered_through(self, members: Sequence[int]) -> list[Floats] | None:
        """Numbers of the cycles of a contact's records, where one counter counts them all."""
        counts = [self.measurements[i].count for i in members]
        numbers = [c.numbers for c in counts if c is not None and c.is_of_contact]
        known = [values for values in numbers if values is not None]
        if len(known) < len(members) or np.any(np.diff(np.concatenate(known)) <= 0.0):
            return None
        return known

    def _of_contact(self, members: Sequence[int], of: PerCycle) -> list[Dissipated]:
        """Energy [J] up to each cycle of the records of one contact."""
        measurements = [self.measurements[i] for i in members]
        numbers = self._numbered_through(members) if len(members) > 1 else None
        if numbers is not None:
            energy_of_each = np.concatenate([of(m) for m in measurements])
            edges = np.cumsum([len(measured) for measured in measurements])[:-1]
            joined = dissipated(np.concatenate(numbers), energy_of_each)
            return [
                Dissipated(*parts)
                for parts in zip(*(np.split(j, edges) for j in joined), strict=True)
            ]
        before, found = (0.0, 0.0), []
        for measured in measurements:
            energy, errors = _accumulated(measured, of)
            found.append(Dissipated(before[0] + energy, before[1] + errors))
            before = float(found[-1].energy[-1]), found[-1].error
        return found

    def _worn_by(self, of: PerCycle = energy_of) -> tuple[Floats, Floats]:
        """Energy [J] that the contact of each record has dissipated since it was new; its error."""
        of_each = [_accumulated(measured, of) for measured in self.measurements]
        chosen = []
        for measured, alone, cumulated in zip(
            self.measurements, of_each, self._cumulated(of), strict=True
        ):
            count = measured.count
            numbers = None if count is None or not count.is_of_contact else count.numbers
            # A specimen is worn by all that was before, whatever numbers its cycles; a run that the
            # rig's counter numbers through as well.
            is_all = numbers is not None or "specimen" in self.columns
            worn = cumulated if is_all else alone
            energy = float(worn.energy[-1])
            begins = 1.0 if numbers is None else float(numbers[0]) - _NEW * float(numbers[-1])
            if begins > 1.0 and float(alone.energy[-1]) == energy:
                energy = math.nan  # what was before is not known
            chosen.append((energy, worn.error))
        energies, errors = np.array(chosen).T
        return energies, errors

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
        return next(iter(self.wear_laws(confidence)), None)

    def wear_laws(self, confidence: float = 0.95) -> tuple[Wear, ...]:
        """Worn volume by dissipated energy, with a threshold, and by Archard's load times way."""
        volumes = self.worn_volumes or [None] * len(self.measurements)
        rows = [i for i, volume in enumerate(volumes) if volume is not None]
        energies, errors = self._worn_by()
        rows = [i for i in rows if math.isfinite(energies[i])]
        if not rows:
            return ()
        volume = np.array([volumes[i] for i in rows], dtype=float)
        names = tuple(self.measurements[i].name for i in rows)
        laws = []
        gain = gain_error("dissipated_energy", self.measurements[0].gain_errors)
        for line in (proportional, with_threshold):
            law = unlogged(line, names, energies[rows], errors[rows], volume, confidence)
            if law is not None:
                coefficient = with_gain(law.coefficient, gain, confidence)
                laws.append(law._replace(coefficient=coefficient))
        if all("normal_load" in measured.mean for measured in self.measurements):
            work, errors = (values[rows] for values in self._worn_by(archard_of))
            if np.all(work > 0.0):
                law = unlogged(proportional, names, work, errors, volume, confidence)
                laws += [] if law is None else [law._replace(law=ARCHARD)]
        return tuple(laws)

    def pooled(self, confidence: float = 0.95) -> list[tuple[str, Pooled]]:
        """Specimens at each condition that at least two of them have: each, scatter, all."""
        labels = self.specimens
        found = []
        for condition, members in self._conditions() if len(set(labels)) > 1 else []:
            for column in COMPARED:
                by_label: dict[str, list[Estimate]] = {}
                for i in members:
                    measured = self.measurements[i]
                    mean = (measured.own_mean or measured.mean).get(column)
                    if mean is not None and math.isfinite(mean.value):
                        if not measured.is_settled:  # how far its cycles range is no error
                            mean = mean._replace(standard_error=math.nan)
                        by_label.setdefault(labels[i], []).append(mean)
                if len(by_label) > 1:
                    estimates = [(label, of_one(m, confidence)) for label, m in by_label.items()]
                    pool = pooled(column, estimates, confidence)
                    gain = gain_error(column, self.measurements[0].gain_errors)
                    mean_of_all = with_gain(pool.mean, gain, confidence)
                    found.append((condition, pool._replace(mean=mean_of_all)))
        return found

    def load_law(self, confidence: float = 0.95) -> LoadLaw | None:
        """Growth of the stiffness with the load; None of loads that are few or alike.

        A straight line of the logarithms; specimens have a height of their own.
        """
        rows = [
            (label, load.value, stiffness.value, measured.rig_stiffness is None)
            for label, measured in zip(
                self.specimens or ("",) * len(self.measurements), self.measurements, strict=True
            )
            if (load := measured.mean.get("normal_load")) is not None
            and (stiffness := measured.mean["reversal_stiffness"]).value > 0.0
        ]
        loads = np.array([row[1] for row in rows])
        if loads.size < 3 or loads.max() < _SPAN * loads.min():
            return None
        x, y = np.log(loads), np.log([row[2] for row in rows])
        middle = float(x.mean())
        intercepts = {label for label, *_ in rows}
        at_middle = float(y.mean())
        for label in intercepts:
            of = np.array([row[0] == label for row in rows])
            x[of] -= x[of].mean()
            y[of] -= y[of].mean()
        square, freedom = float(x @ x), loads.size - len(intercepts) - 1
        if freedom < 1 or square < 1e-3 * loads.size:
            return None
        slope = float(x @ y) / square
        residual = y - slope * x
        error = math.sqrt(float(residual @ residual) / freedom / square)
        half = quantile(confidence, freedom) * error
        exponent = Estimate(slope, slope - half, slope + half, error, int(loads.size))
        return LoadLaw(exponent, math.exp(at_middle), math.exp(middle), any(r[3] for r in rows))

    def _histories(self, alike: bool = False) -> list[tuple[str, list[int], list[Floats]]]:
        """Each contact, or record, whose cycles are counted: its name, records and numbers.

        With ``alike`` those of one amplitude and one load in all of their cycles.
        """
        found = []
        for label, members in self._by_contact().items():
            numbers = self._numbered_through(members)
            if numbers is not None and not (alike and self._differ(members)):
                is_named = "specimen" in self.columns or self.runs is not None
                name = label if is_named else self.measurements[members[0]].name
                found.append((name, members, numbers))
                continue
            for i in members:
                up_to, measured = self.measurements[i].count, self.measurements[i]
                if alike and self._differ([i]):
                    continue
                if up_to is None or up_to.numbers is not None:
                    usual = np.arange(1.0, len(measured) + 1.0)
                    file_numbers = (
                        usual if up_to is None or up_to.numbers is None else up_to.numbers
                    )
                    found.append((measured.name, [i], [file_numbers]))
        return found

    def _differ(self, members: Sequence[int]) -> bool:
        """Whether amplitudes or loads of the cycles of some records are unlike."""
        columns = [self.measurements[i].cycles for i in members]
        for name in ("amplitude", "normal_load"):
            if all(name in c for c in columns):
                sizes = np.concatenate([c[name] for c in columns])
                if float(np.ptp(sizes)) > 2.0 * SAME_CONDITION * abs(float(np.median(sizes))):
                    return True
        return False

    def running_in(self, confidence: float = 0.95) -> list[RunningIn]:
        """Running-in of friction and energy of each contact, where there is one."""
        found = []
        for name, members, numbers in self._histories(alike=True):
            columns = [self.measurements[i].cycles for i in members]
            for column in ("friction_energy", "dissipated_energy"):
                if all(column in c for c in columns):
                    values = np.concatenate([c[column] for c in columns])
                    law = running_in(name, column, np.concatenate(numbers), values, confidence)
                    found += [] if law is None else [law]
        return found

    def friction_logs(self) -> list[tuple[str, bool, Floats, Floats]]:
        """Forces of each contact over way (there, back), cycle and place, most cycles first.

        Each with the contact's name, whether they are over the load, and the cycles' numbers.
        """
        found = []
        for name, members, numbers in self._histories():
            records = [self.measurements[i] for i in members]
            logs = [record.friction_log for record in records]
            loads = [record.mean.get("normal_load") for record in records]
            is_loaded = all(load is not None for load in loads)
            parts = [
                np.array([log.forward, log.backward]) / (load.value if is_loaded and load else 1.0)
                for log, load in zip(logs, loads, strict=True)
                if log is not None
            ]
            places = [n[log.rows] for n, log in zip(numbers, logs, strict=True) if log is not None]
            if parts:
                found.append((name, is_loaded, np.concatenate(places), np.concatenate(parts, 1)))
        return sorted(found, key=lambda log: -float(log[2][-1]))

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
        over = self.drawn_over
        stages = None if over is None else self.columns[over]
        for i, place in enumerate(places):
            for group in groups:
                first = places[group[0]]
                if (stages is None or stages[i] == stages[group[0]]) and all(
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
            text += "" if math.isnan(load) else f", {engineering(load, 'N')}"
            if stages is not None:
                text += f", {over} {text_of(stages[group[0]])}"
            words.append(text)
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
