"""Evaluation of the cycles of a record: energy, damping, friction, stiffness, slip regime."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.quantities import json_value, named
from microslip._core.units import engineering, significant
from microslip._core.wording import plural
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.laboratory.conditioning import condition
from microslip.laboratory.cuts import noise_of, one_loop
from microslip.laboratory.cycle_columns import (
    COLUMN_UNITS,
    LABELS,
    checked_gains,
    columns_of,
    gain_error,
    sampling_errors,
)
from microslip.laboratory.cycles import check_direction, cycles_of
from microslip.laboratory.estimates import (
    Estimate,
    chance_below_zero,
    checked_confidence,
    mean_of,
    mean_of_inverses,
    with_gain,
)
from microslip.laboratory.loop_shape import (
    UNDECIDED,
    load_ripple_of,
    mean_loop_of,
    parallel_spring,
    shape_notes,
    third_harmonic_of,
    without_spring,
)
from microslip.laboratory.record import Record

REGIMES = ("stick", "partial slip", "gross slip")
STICK, GROSS = 0.0033783480491788817, 0.7694644203726145
"""Largest energy ratio A of stick, and smallest ratio B of gross slip, of one sphere (19.15): A
where T0 is 1 % below its first tangent, and B = 0.2/(2^(1/3) - 1) at the slip limit."""
_NOISE_SAMPLES = 1 << 17
MOST_OF_LOOP = 1 << 17
"""Largest number of samples of a single averaged loop."""
_ELASTIC = 0.5
"""Sliding ratio [-] below which most of the displacement is elastic."""
_TWO_SIDED = 1.96
"""Normal quantile by which half-widths become standard errors."""
_USUAL = {
    "amplitude": (0.0, 0.1, "m", "displacement"),
    "force_amplitude": (0.0, 1e7, "N", "force"),
    "dissipated_energy": (0.0, 1e3, "J", "force"),
    "friction_peak": (2e-3, 5.0, "", "normal_load"),
}
"""Smallest and largest plausible values; beyond them a unit is probably wrong."""


class AmplitudeLevel(NamedTuple):
    """Settled cycles of a record at one of several amplitudes, with their means."""

    cycles: NDArray[np.intp]
    """Indices of the cycles, from 0."""
    is_settled: bool
    """Whether the cycles are settled; otherwise the intervals are the range of the cycles."""
    mean: Mapping[str, Estimate]
    """Means of the columns with confidence intervals."""


@dataclass(frozen=True, eq=False)
class Measurement(Plottable):
    """Evaluated cycles of a record, with means and confidence intervals.

    Parameters
    ----------
    name : str
        Name of the record.
    cycles : mapping of str to ndarray
        Columns with a value for each cycle, one-dimensional, in SI units: ``start`` (sample) and
        ``period`` [samples], ``frequency`` [Hz], ``amplitude`` [m] and ``force_amplitude`` [N]
        (half ranges), ``displacement_offset`` [m] and ``force_offset`` [N] (mid-ranges),
        ``normal_load`` [N], ``dissipated_energy`` [J], ``energy_ratio`` A, ``loss_factor``,
        ``damping_ratio``, ``sliding_distance`` [m], ``sliding_ratio`` D, ``fouvry_ratio`` B,
        ``friction_peak``, ``friction_energy``, ``chord_stiffness`` [N/m] and ``closure_error`` [-].
    regimes : tuple of str
        "stick", "partial slip" or "gross slip", for each cycle.
    mean : mapping of str to Estimate
        Means of the columns with their confidence intervals (Student), over the cycles that are
        closed (end forces differ by at most a quarter of the force range), have no spike and are
        settled: of one amplitude (within 1 % or the noise), without a trend in force and energy of
        over 2 %. If no cycles are settled, the intervals are the range of the cycles.
    confidence : float
        Level of the intervals [-].
    frequency : float or None
        Median frequency of the cycles [Hz]; None for a record without time.
    third_harmonic, load_ripple : float or None
        Third harmonic of the displacement over its fundamental [-]; half the range of the normal
        load within the mean cycle over its mean [-], None if the load was not recorded.
    rig_stiffness : float or None
        Stiffness of the rig [N/m] whose deflection was subtracted from the displacement.
    loop : tuple of ndarray
        Displacement [m] and force [N] of the mean cycle, one-dimensional, for figures.
    notes : tuple of str
        Notes on the record.
    probability : mapping of str to float
        Probability of each regime for the mean of the cycles [-].
    is_settled : bool
        Whether the averaged cycles are settled; if not, intervals are the range of the cycles.
    levels : tuple of AmplitudeLevel
        Settled cycles and means at each amplitude of a record with stepped amplitudes; else empty.
    gain_errors : mapping of str to float
        Relative standard deviations [-] of the gains of the sensors, included in ``mean``.

    Notes
    -----
    Loops are evaluated as in Fig. 19.7 and (19.29)-(19.30) of chapter 19 (DOI
    10.1007/978-3-319-56818-8_19). With the energy E_d, the amplitudes T_m of the force and delta of
    the displacement, and half the width delta_g of the loop at the middle of its force range,
    A = E_d/(4 T_m delta), D = delta_g/delta and B = E_d/(4 T_m delta_g). D and B are those of
    Fouvry, Kapsa and Vincent (1995, DOI 10.1016/0043-1648(94)06582-9).
    """

    name: str
    cycles: Mapping[str, NDArray[np.float64]]
    regimes: tuple[str, ...]
    mean: Mapping[str, Estimate]
    confidence: float
    frequency: float | None
    third_harmonic: float
    load_ripple: float | None
    rig_stiffness: float | None
    loop: tuple[NDArray[np.float64], NDArray[np.float64]]
    notes: tuple[str, ...]
    is_settled: bool = True

    def _figure(self) -> Plot:
        from microslip.laboratory.figures import measured_loops

        return measured_loops([self])

    probability: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    levels: tuple[AmplitudeLevel, ...] = ()
    gain_errors: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def __len__(self) -> int:
        return len(self.regimes)

    @property
    def regime(self) -> str:
        """Most probable regime of the cycles of the means."""
        return max(REGIMES, key=lambda name: self.probability.get(name, self.regimes.count(name)))

    @property
    def possible_regimes(self) -> dict[str, float]:
        """Most probable regimes with their probabilities, which sum to at least ``confidence``."""
        possible: dict[str, float] = {}
        for name, share in sorted(self.probability.items(), key=lambda item: -item[1]):
            if sum(possible.values()) < self.confidence:
                possible[name] = share
        return possible

    def summary(self) -> dict[str, Any]:
        """Return the contents of summary.json: results without the columns; NaN becomes None."""
        levels = [
            {"first_cycle": int(level.cycles[0]) + 1, "last_cycle": int(level.cycles[-1]) + 1}
            | {"settled": level.is_settled, "mean": _with_units(level.mean)}
            for level in self.levels
        ]
        summary: dict[str, Any] = json_value(
            {
                "name": self.name,
                "cycles": len(self),
                "regime": self.regime,
                "regimes": {name: self.regimes.count(name) for name in REGIMES},
                "probability": self.probability,
                "thresholds": {"stick": STICK, "gross": GROSS},
                "confidence": self.confidence,
                "settled": self.is_settled,
                **named(self, "frequency", "third_harmonic", "load_ripple", "rig_stiffness"),
                "mean": _with_units(self.mean),
                "levels": levels,
                "notes": self.notes,
            }
        )
        return summary

    def __repr__(self) -> str:
        return f"Measurement({self.name!r}, {plural(len(self), 'cycle')}, {self.regime})"


def measure(
    record: Record,
    *,
    rig_stiffness: float | None = None,
    confidence: float = 0.95,
    cycles: slice | None = None,
    delay: float = 0.0,
    gain_errors: Mapping[str, float] | None = None,
) -> Measurement:
    """Measure every cycle of a record.

    Parameters
    ----------
    record : Record
        Displacement, force and, if measured, normal load.
    rig_stiffness : float, optional
        Stiffness k of the rig in series [N/m], above zero: its deflection T/k is subtracted from
        the displacement. Energy, force, sliding distance and B do not depend on it.
    confidence : float, optional
        Level of the confidence intervals [-], between 0 and 1.
    cycles : slice, optional
        Range of cycles to average, counted from 0; by default the settled ones.
    delay : float, optional
        Time [s] by which the force lags behind the displacement; the lag is removed.
    gain_errors : mapping, optional
        Relative standard deviations [-] of the gains of the sensors, from their calibration, by
        "force", "displacement" and "normal_load". These errors are common to all cycles and are
        included in the intervals.

    Returns
    -------
    Measurement
        Columns of the cycles, their means with confidence intervals, and regimes.

    Notes
    -----
    Reversal points are estimated between the samples, and on each branch the force is integrated
    over the displacement by cubics in time. The remaining error due to the sample spacing is
    estimated from every other sample and widens the intervals of the means. Spikes, up to three
    consecutive samples, are replaced by straight lines, and their cycles left out of the means.
    Cycles are cut at gaps of the time, and the frequency is computed within the blocks between
    gaps. An open cycle is closed by its chord; ``closure_error`` is the difference of the forces at
    its ends over their range. The chord stiffness is that of the first 5 % of the force range after
    a reversal; its interval includes the difference between three shapes of the branch (powers 1
    and 2 or 1 and 3/2 of the force, or a logarithm). Stiffnesses are averaged as compliances. With
    the mean normal load P of a cycle and half the width delta_g of the loop at the middle of its
    force range, ``friction_peak`` is the force amplitude over P, and ``friction_energy`` is
    E_d/(4 P delta_g), with the energy E_d of (19.29).

    A, B and D are those of :class:`Measurement`. The regime is "stick" up to the A at which the
    backbone of one sphere is 1 % below its initial tangent (0.0034), and "gross slip" from the B at
    which a sphere reaches its limit (0.7695). Settled cycles have the regime of their mean, with a
    probability from their scatter.
    """
    if not isinstance(record, Record):
        raise InputError(
            f"record must be a Record, got {show(record)}; "
            "write Record(displacement, force) or Record.read(path)"
        )
    level = checked_confidence(confidence)
    gains = checked_gains(gain_errors)
    record = condition(record, delay=delay) if delay else record
    judged = cycles_of(_turned_to_its_peak(record))
    record, columns = judged.record, judged.columns
    x, force = record.displacement, record.force
    counting = judged.selected(cycles)
    energies = columns["dissipated_energy"][counting.selection]
    largest = judged.largest_block
    channels = x[largest.samples], force[largest.samples]
    # A few cycles may agree by chance better than the noise of their samples allows.
    error = max(float(energies.std()), _energy_noise(*channels, largest.cycles.period))
    check_direction(
        *(record.name, float(np.median(energies)), error / energies.size**0.5, *channels),
        "`delay` of the right size removes it",
    )
    compliance = 0.0
    if rig_stiffness is not None:
        rig_stiffness = positive("rig_stiffness", rig_stiffness, "N/m", 1e8)
        compliance = 1.0 / rig_stiffness
        columns = columns_of(record, compliance)
        _refuse_soft(rig_stiffness, columns)
        x = x - force / rig_stiffness
    coarse = sampling_errors(record, largest, columns, compliance)
    notes = [*record.notes, *judged.notes(counting)]
    if any(np.isnan(columns["chord_stiffness"])):
        notes.append(
            "in some cycles the first quarter of the force after a reversal has too few samples "
            "for a stiffness"
        )
    shape = judged.shape(counting.selection)
    is_load_recorded = isinstance(record.normal_load, np.ndarray)
    notes += [judged.delay] if judged.delay else shape_notes(shape, is_load_recorded)
    third_harmonic, bent_notes = third_harmonic_of(record, largest)
    notes += bent_notes
    notes += beyond_all_rigs(columns)
    columns = {name: columns[name] for name in COLUMN_UNITS if name in columns}
    spring = None if shape is None or judged.delay else parallel_spring(shape)
    of_contact = columns if not (shape and spring) else without_spring(columns, shape, spring)
    regimes, probability = _regimes_of(of_contact, counting.selection, counting.is_moving)
    counted = [regimes[i] for i in np.flatnonzero(counting.selection)]
    slid = columns["sliding_ratio"][counting.selection]
    is_gross = 2 * counted.count(REGIMES[2]) > len(counted) and np.isfinite(slid).any()
    if rig_stiffness is None and is_gross and np.nanmedian(slid) < _ELASTIC:
        notes.append(
            "B indicates gross slip though most of the displacement is elastic; "
            f"{UNDECIDED} (contact, rig, or crosstalk between the sensors). A record of a rigid "
            "specimen would identify the cause; give `rig_stiffness` to subtract the rig"
        )
    rates = columns.get("frequency")
    steps = judged.step_errors
    shared = {k: math.hypot(steps.get(k, 0.0), gains.get(k, 0.0)) for k in {**steps, **gains}}
    errors = shared, coarse
    return Measurement(
        name=record.name,
        cycles=MappingProxyType({name: lock(values) for name, values in columns.items()}),
        regimes=regimes,
        mean=_means(columns, counting.selection, level, counting.is_moving, *errors),
        gain_errors=MappingProxyType(gains),
        probability=MappingProxyType(probability),
        confidence=level,
        frequency=None if rates is None else float(np.median(rates)),
        third_harmonic=third_harmonic,
        load_ripple=load_ripple_of(record, judged.largest_block),
        rig_stiffness=rig_stiffness,
        loop=mean_loop_of(x, force, columns, np.flatnonzero(counting.selection)),
        notes=tuple(notes),
        is_settled=not counting.is_moving,
        levels=tuple(
            AmplitudeLevel(lock(rows), not moving, _means(columns, rows, level, moving, *errors))
            for rows, moving in counting.levels
        ),
    )


def _regimes_of(
    columns: Mapping[str, Floats],
    is_counted: NDArray[np.bool_],
    is_moving: bool,
) -> tuple[tuple[str, ...], dict[str, float]]:
    """Return the slip regime of each cycle, and the probability of each regime for their mean.

    The mean is over the cycles ``is_counted``. If these have a trend, ``is_moving``, their fraction
    in each regime takes the place of its probability.
    """
    energy, force = columns["dissipated_energy"], columns["force_amplitude"]
    below, short = (
        chance_below_zero(away[is_counted & np.isfinite(away)])
        for away in (
            energy - STICK * (4.0 * columns["amplitude"] * force),
            energy - GROSS * (4.0 * force * columns["sliding_distance"]),
        )
    )
    likely = dict(
        zip(REGIMES, (below, (1.0 - below) * short, (1.0 - below) * (1.0 - short)), strict=True)
    )
    stick = ~(columns["energy_ratio"] > STICK)
    gross = ~stick & (columns["fouvry_ratio"] >= GROSS)
    cycle_regimes = tuple(
        REGIMES[0 if s else 2 if g else 1] for s, g in zip(stick, gross, strict=True)
    )
    if is_moving:
        counted = [cycle_regimes[i] for i in np.flatnonzero(is_counted)]
        return cycle_regimes, {name: counted.count(name) / len(counted) for name in REGIMES}
    mean = max(REGIMES, key=lambda name: likely[name])
    pairs = zip(cycle_regimes, is_counted.tolist(), strict=True)
    return tuple(mean if is_chosen else regime for regime, is_chosen in pairs), likely


def _means(
    columns: Mapping[str, Floats],
    rows: NDArray[Any],
    level: float,
    is_moving: bool,
    gains: Mapping[str, float],
    coarse: Mapping[str, float],
) -> Mapping[str, Estimate]:
    means = {}
    for name, values in columns.items():
        if name in ("start", "cycle_number"):
            continue
        average = mean_of_inverses if name == "chord_stiffness" else mean_of
        mean = average(values[rows], level, is_moving)
        error = gain_error(name, gains)
        if mean.number > 1:
            error = math.hypot(error, coarse.get(name, 0.0) / _TWO_SIDED)
        means[name] = with_gain(mean, error, level)
    return MappingProxyType(means)


def _energy_noise(x: Floats, force: Floats, period: float) -> float:
    x, force = x[:_NOISE_SAMPLES], force[:_NOISE_SAMPLES]
    moved, pushed = (float(np.linalg.norm(np.diff(values))) for values in (x, force))
    return math.hypot(noise_of(force) * moved, noise_of(x) * pushed) / math.sqrt(x.size / period)


def _with_units(means: Mapping[str, Estimate]) -> dict[str, Any]:
    return {name: {"unit": COLUMN_UNITS[name], **mean._asdict()} for name, mean in means.items()}


def _turned_to_its_peak(record: Record) -> Record:
    """Return a single averaged loop rotated to begin at its maximum; other records unchanged."""
    x, force = record.displacement, record.force
    if x.size > MOST_OF_LOOP or not all(one_loop(x, force)[1:]):
        return record
    size = one_loop(x, force)[0]
    order = (int(np.argmax(x[:size])) + np.arange(size + 1)) % size
    rate = record.sample_rate
    if record.time is not None:
        rate = (x.size - 1) / float(record.time[-1] - record.time[0])
    note = "one closed loop: taken as an averaged loop, from its largest displacement on"
    notes = (*record.notes, note)
    return record._taken(order, time=None, sample_rate=rate, cycle_number=None, notes=notes)


def beyond_all_rigs(columns: Mapping[str, Floats | float]) -> list[str]:
    """Return a note for each column whose median no rig reaches: a wrong unit, probably."""
    notes = []
    for name, (least, most, unit, role) in _USUAL.items():
        size = abs(float(np.nanmedian(columns[name]))) if name in columns else least
        if not least <= size <= most:
            text = engineering(size, unit) if unit else significant(size)
            usual = "um" if role == "displacement" else "N"
            notes.append(
                f"{LABELS[name]} of {text} is outside the range of any rig; are the units right? "
                f'`units={{"{role}": "{usual}"}}` states them'
            )
    return notes


def _refuse_soft(rig_stiffness: float, columns: Mapping[str, Floats]) -> None:
    left, pushed = (float(np.median(columns[name])) for name in ("amplitude", "force_amplitude"))
    deflection = abs(pushed) / rig_stiffness
    if left > 0.0:
        return
    raise InputError(
        f"`rig_stiffness` {engineering(rig_stiffness, 'N/m')} deflects by "
        f"{engineering(deflection, 'm')} under the force amplitude of "
        f"{engineering(abs(pushed), 'N')}, more than the whole measured amplitude of "
        f"{engineering(left + deflection, 'm')}; a number alone is in N/m, so "
        f"{exact(rig_stiffness)} N/um is `rig_stiffness={1e6 * rig_stiffness:g}`"
    )
