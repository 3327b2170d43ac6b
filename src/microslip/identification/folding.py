"""A record folded on one cycle: what all its settled cycles say together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, show
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering, significant
from microslip.errors import InputError
from microslip.identification.displacement_series import QUIET, series_of
from microslip.identification.drift import Drift, drift_of
from microslip.identification.mean_cycle import MeanCycle, Turns, all_turns, places_of, stretches
from microslip.identification.outliers import cycles_without_spikes, jumps, mean_load
from microslip.loops import Loop
from microslip.tribometer.blocks import blocks_of
from microslip.tribometer.cycle_columns import rigid_columns_of
from microslip.tribometer.estimates import Estimate, trend
from microslip.tribometer.measurement import clipped
from microslip.tribometer.record import Record
from microslip.tribometer.settling import CERTAIN, OPEN, Settled, settled
from microslip.tribometer.spikes import Spike, spikes_of, without_spikes

FEWEST_CYCLES = 3
MOST_BINS = 512
GROWN = 0.02
"""Growth of the force over the cycles of a record from which on a mean over them is of no state."""
_ALIKE = 0.003
"""Relative change of force and energy over the cycles that are folded, if any are as settled,"""
_JUDGED, _LIKELY = 8, 2.0
"""cycles from which their growth is judged, and standard errors from which on it is likely."""


@dataclass(frozen=True, eq=False, repr=False)
class Folded(Locked):
    """The settled cycles of a record on one cycle of phase.

    The displacement is a Fourier series with the harmonics that stand out of the noise, the force
    its mean in bins of the phase. Both carry the noise seen in the scatter between the cycles; a
    straight drift is taken off both.
    """

    name: str
    phase: NDArray[np.float64]
    """Mean phase of each bin [rad], increasing."""
    spread: NDArray[np.float64]
    """Standard deviation of the phases within each bin [rad]."""
    force: NDArray[np.float64]
    """Mean force of each bin [N]."""
    count: NDArray[np.float64]
    """Samples in each bin."""
    cycle_force: NDArray[np.float64]
    """Sum of the forces of each cycle (rows) in each bin [N]."""
    cycle_count: NDArray[np.float64]
    """Samples of each cycle (rows) in each bin."""
    harmonics: NDArray[np.int64]
    """Numbers of the harmonics of the displacement; the mean is not among them."""
    coefficients: NDArray[np.float64]
    """Mean [m], then cosine and sine of each harmonic [m]."""
    covariance: NDArray[np.float64]
    """Covariance of the coefficients [m^2]."""
    force_noise: float
    """Standard deviation of one sample of force [N]."""
    displacement_noise: float
    """Standard deviation of one sample of displacement [m]."""
    normal_load: float | None
    """Mean normal load [N]; None without one."""
    frequency: float | None
    """Cycles a second [Hz]; None without a time base."""
    cycles: int
    """Number of settled cycles."""
    left_out: int
    """Number of cycles that were left out."""
    notes: tuple[str, ...]
    said: tuple[str, ...] = ()
    """Those of the notes that are of the folding itself, not of the record."""
    load_error: float = 0.0
    """Standard error of the mean normal load [N]; 0 of one that was given as a number."""
    drift: float = 0.0
    """Change of the force a cycle [N] beside the loops, which is taken off."""
    drifted: NDArray[np.float64] = field(default_factory=lambda: lock(np.zeros(0)))
    """What one standard error of that does to the force of each bin [N]."""
    growth: float = 0.0
    """Relative growth of the loops' force over the cycles that count; 0 where it is likely to be no
    more than noise."""
    doubt: str = ""
    """Why nothing can be identified from the record; empty where it can."""
    freedom: float = math.inf
    """Degrees of freedom from which the noise of the force is known."""
    play: float = 0.0
    """Half the play [m] between joint and transducer, of which the joint sees nothing,"""
    play_error: float = 0.0
    """and its standard error [m]."""

    def basis(self, phase: Floats, order: int = 0) -> Floats:
        """Mean, cosines and sines at phases [rad], or a derivative of them by the phase."""
        n = self.harmonics.astype(float)
        angle = np.outer(phase, n) + 0.5 * math.pi * order
        factor = n**order
        first = np.full((phase.size, 1), 1.0 if order == 0 else 0.0)
        rows = np.stack((factor * np.cos(angle), factor * np.sin(angle)), axis=2)
        return np.hstack((first, rows.reshape(phase.size, 2 * n.size)))

    def displacement(self, phase: Floats, order: int = 0) -> Floats:
        """Displacement [m] at phases [rad], or a derivative of it by the phase."""
        return self.basis(phase, order) @ self.coefficients

    @property
    def amplitude(self) -> float:
        """Half the range of the displacement [m]."""
        return 0.5 * float(np.ptp(self.displacement(np.linspace(0.0, 2.0 * math.pi, 2048))))

    @property
    def way(self) -> Floats:
        """Way of the displacement that each bin stands for [m]: with forces, energies."""
        width = 0.5 * (np.roll(self.phase, -1) - np.roll(self.phase, 1)) % math.pi
        return self.displacement(self.phase, 1) * width

    @property
    def loop(self) -> Loop:
        """The mean loop, closed."""
        x, force = self.displacement(self.phase), self.force
        return Loop(np.append(x, x[0]), np.append(force, force[0]))

    def part(self, rows: NDArray[np.bool_]) -> Folded:
        """The same with some of its cycles only; displacement and noise stay those of all."""
        count = self.cycle_count[rows].sum(axis=0)
        full = count > 0.0
        force = self.cycle_force[rows].sum(axis=0)[full] / count[full]
        changed = {
            "phase": lock(self.phase[full]),
            "spread": lock(self.spread[full]),
            "force": lock(force),
            "count": lock(count[full]),
            "drifted": lock(self.drifted[full] if self.drifted.size else self.drifted),
            "cycle_force": lock(self.cycle_force[np.ix_(rows, full)]),
            "cycle_count": lock(self.cycle_count[np.ix_(rows, full)]),
            "covariance": lock(self.covariance * (self.cycles / np.count_nonzero(rows))),
            "cycles": int(np.count_nonzero(rows)),
        }
        return Folded(**{**self.__dict__, **changed})

    def __repr__(self) -> str:
        return f"Folded({self.name!r}, {self.cycles} cycles, {self.phase.size} bins)"


def fold(
    record: Record, cycles: slice | None = None, bins: int = MOST_BINS, *, running_in: int = 1
) -> Folded:
    """Fold a record on one cycle; cycles with spikes are left out, and a note names these.

    Parameters
    ----------
    record : Record
        Displacement, force and, where there is one, normal load.
    cycles : slice, optional
        Whole cycles to take, the first being 0; without it all but those of the running-in and
        those whose ends differ by over a quarter of the range of force.
    bins : int, optional
        Bins of the phase for the force, at least 16; fewer where a cycle has fewer samples.
    running_in : int, optional
        Cycles at the begin that are left out.

    Returns
    -------
    Folded
        Displacement as Fourier series, force in bins, noise of both.
    """
    if not isinstance(record, Record):
        raise InputError(
            f"`records` must be Records, got {show(record)}; write Record(displacement, "
            "force) or Record.read(path)"
        )
    spikes = spikes_of(record)
    folded, jumps_there = _fold(record, spikes, cycles, bins, running_in)
    # Those that only the other cycles show come to light once all are folded.
    return (
        _fold(record, (*spikes, *jumps_there), cycles, bins, running_in)[0]
        if jumps_there
        else folded
    )


def _fold(
    record: Record, spikes: Sequence[Spike], cycles: slice | None, bins: int, running_in: int
) -> tuple[Folded, list[Spike]]:
    """The folded record without its spikes, and further ones."""
    record = without_spikes(record, spikes)
    x, force = record.displacement, record.force
    blocks = blocks_of(record)
    time = np.arange(x.size, dtype=float)
    if record.time is not None:
        time = record.time
    elif record.sample_rate is not None:
        time = time / record.sample_rate
    _force_range(force)  # of a dead sensor no cycle can be judged
    like = _similar_samples(record) if cycles is None else None
    phases = all_turns(time, x, blocks)
    del time
    cycle_count, rate, samples_a_cycle = phases.cycle_count, phases.rate, phases.samples_a_cycle
    is_settled = _settled_cycles(phases, force, cycles, running_in, record.name, like)
    is_settled, spike_notes = cycles_without_spikes(is_settled, spikes, phases.place, FEWEST_CYCLES)
    rows = np.flatnonzero(is_settled)
    inside = np.append(is_settled, False)[phases.place]
    cycle = phases.place[inside]
    phase = phases.turns[inside]
    del phases
    phase -= cycle
    phase *= 2.0 * math.pi
    place = (np.cumsum(is_settled) - 1)[cycle]
    x, force = x[inside], force[inside]
    places = places_of(phase, samples_a_cycle)
    size = int(min(bins, max(16, places.number)))

    # Where a cycle has a whole number of samples they lie in the middle of the bins.
    width = 2.0 * math.pi / size
    edge = float(phase[0]) % width - 0.5 * width
    column = np.empty(phase.size, dtype=np.int64)
    for piece in stretches(phase.size):
        wrapped = edge + np.mod(phase[piece] - edge, 2.0 * math.pi)
        cycle[piece] += np.rint((phase[piece] - wrapped) / (2.0 * math.pi)).astype(np.int64)
        column[piece] = np.clip(((wrapped - edge) / width).astype(np.int64), 0, size - 1)
        phase[piece] = wrapped
    cycle -= cycle.min()
    number = np.cumsum(np.bincount(column, minlength=size) > 0) - 1
    size = int(number[-1]) + 1
    if size < number.size:
        column = number[column]
    curve = MeanCycle(phase, column, size, places.alike and places.number <= size)
    total, spread = curve.total, curve.spread
    spread[spread < 1e-3 * width] = 0.0
    drift, moved = drift_of(force, cycle, curve), drift_of(x, cycle, curve)
    gone = phase / (2.0 * math.pi)
    gone += cycle
    gone -= float(gone.mean())
    del cycle
    drifting = (
        *_drift_note("force", "N", drift, gone, force),
        *_drift_note("displacement", "m", moved, gone, x),
    )
    x -= moved.slope * gone
    harmonics, coefficients, covariance, noise_x = series_of(
        np.mod(phase, 2.0 * math.pi), x, places.number
    )
    del x
    saw = np.zeros(coefficients.size)
    saw[2::2] = moved.error / (math.pi * harmonics)  # a straight line, cut at each cycle
    level = curve.of(force - drift.slope * gone)
    drifted = drift.error * np.bincount(column, gone) / total
    del gone
    noise_f = curve.noise(level.residual, 1)
    load = mean_load(record, inside, place, curve)
    said = (
        *blocks.notes,
        *(() if like is None else like.notes),
        *clipped(record),
        *spike_notes,
        *load.notes,
        *drifting,
    )
    further_spikes = jumps(level.residual, column, inside, force)
    del force
    place *= size
    place += column
    shape = rows.size, size
    counts = np.bincount(place, minlength=rows.size * size).reshape(shape).astype(float)
    sums: Floats = counts * level.base
    sums += np.bincount(place, level.residual, minlength=rows.size * size).reshape(shape)
    grown = _growth(sums, counts, level.mean)
    growth = grown.value if abs(grown.value) > _LIKELY * grown.standard_error else 0.0
    certain = growth if abs(growth) > CERTAIN * grown.standard_error else 0.0
    if abs(certain) > _ALIKE:
        said = (*said, _growth_note(certain))
    doubt = _doubt_of(record, like, certain)
    timed = record.time is not None or record.sample_rate is not None
    folded = Folded(
        name=record.name,
        phase=lock(curve.middle),
        spread=lock(spread),
        force=lock(level.mean),
        count=lock(total),
        cycle_force=lock(sums),
        cycle_count=lock(counts),
        harmonics=lock(harmonics),
        coefficients=lock(coefficients),
        covariance=lock(covariance + np.outer(saw, saw)),
        force_noise=max(noise_f, QUIET * 0.5 * float(np.ptp(level.mean))),
        displacement_noise=noise_x,
        normal_load=load.mean,
        frequency=rate if timed else None,
        cycles=int(rows.size),
        left_out=int(cycle_count - rows.size),
        notes=(*record.notes, *said),
        said=said,
        load_error=load.error,
        drift=drift.slope,
        growth=growth,
        drifted=lock(drifted),
        doubt=doubt,
        freedom=max(curve.freedom - 1.0, 1.0),
    )
    return folded, further_spikes


def _growth(sums: Floats, counts: Floats, mean: Floats) -> Estimate:
    """Relative growth of the loops' force, by the factor of each cycle on the mean one."""
    number = sums.shape[0]
    if number < _JUDGED:
        return Estimate(0.0, math.nan, math.nan, math.inf, number)
    away = mean - np.average(mean, weights=counts.sum(axis=0))
    if not away.any():
        return Estimate(0.0, math.nan, math.nan, math.inf, number)
    factors = (sums @ away - counts @ (away * (mean - away))) / (counts @ away**2)
    return trend(np.linspace(0.0, 1.0, number), factors, 0.95)


def _similar_samples(record: Record) -> Settled:
    """Samples of the settled cycles, as :func:`microslip.measure` tells them, more strictly."""
    columns = rigid_columns_of(record)
    similar = settled(columns, columns["closure_error"] <= OPEN, _ALIKE)
    samples = np.full(record.force.size, similar.is_moving)
    if not similar.is_moving:
        rows = np.stack([columns[name][similar.selection] for name in ("start", "period")], axis=1)
        for begin, period in rows:
            margin = int(0.1 * period)
            samples[max(int(begin) - margin, 0) : int(begin) + int(period) + margin] = True
    return similar._replace(selection=samples)


def _doubt_of(record: Record, like: Settled | None, growth: float) -> str:
    """Why a mean over the cycles of a record is of no state of a joint; empty where it is."""
    if abs(growth) > GROWN or (like is not None and like.is_moving):
        return "found as a mean over cycles that move, so of no state of the joint"
    if clipped(record):
        return "found from a record that looks clipped"
    return ""


def _growth_note(growth: float) -> str:
    return (
        f"the force of the cycles {'grows' if growth > 0.0 else 'falls'} by "
        f"{significant(100.0 * abs(growth), 2)} % over those that count, as in running in or wear: "
        "what is found is a mean over states, none of which it describes; take settled ones, "
        "cycles=slice(first, last)"
    )


def _drift_note(
    name: str, unit: str, drift: Drift, turns: Floats, values: Floats
) -> tuple[str, ...]:
    """A note on a drift that is more than noise."""
    if not drift.is_certain:
        return ()
    total = drift.slope * float(np.ptp(turns))
    share = 100.0 * abs(total) / float(np.ptp(values))
    return (
        f"the {name} drifts by {engineering(total, unit)} over the cycles that count, "
        f"{significant(share, 2)} % of its range; a straight line is taken off",
    )


def _settled_cycles(
    phases: Turns,
    force: Floats,
    cycles: slice | None,
    running_in: int,
    name: str,
    like: Settled | None,
) -> NDArray[np.bool_]:
    """Which of the whole cycles are settled."""
    cycle_count = phases.cycle_count
    if cycle_count < 1:
        raise InputError(f"{name}: no whole cycle from one peak to the next")
    is_chosen = np.zeros(cycle_count, dtype=bool)
    if cycles is not None:
        if not isinstance(cycles, slice):
            raise InputError(f"`cycles` must be a slice, such as slice(2, 20), got {show(cycles)}")
        is_chosen[cycles] = True
    else:
        gap = _differences_of_ends(phases, force)
        is_chosen[min(running_in, cycle_count) :] = True
        is_chosen &= gap <= OPEN
        if like is not None and not like.selection.all():
            of_cycle = phases.place >= 0
            place = phases.place[of_cycle]
            unlike = np.bincount(place, ~like.selection[of_cycle], minlength=cycle_count)
            alike = is_chosen & (unlike == 0)
            is_chosen = alike if np.count_nonzero(alike) >= FEWEST_CYCLES else is_chosen
    if np.count_nonzero(is_chosen) < FEWEST_CYCLES:
        raise InputError(
            f"{name}: at least {FEWEST_CYCLES} settled whole cycles are needed, got "
            f"{np.count_nonzero(is_chosen)} of {cycle_count} (left out: {running_in} of "
            "running-in, and those that do not close); the scatter between cycles is the measure "
            "of the noise"
        )
    return is_chosen


def _differences_of_ends(phases: Turns, force: Floats) -> Floats:
    """How far the forces at both ends of each cycle are apart, of their range."""
    gaps, range_of_ends = [], 0.0
    for samples, before, cycle_count in phases.ends:
        turns, block_force = phases.turns[samples] - before, force[samples]
        ends = np.clip(np.searchsorted(turns, np.arange(cycle_count + 1) - 1e-9), 0, turns.size - 1)
        half = max(1, int(0.01 * (ends[-1] - ends[0]) / cycle_count))
        sums = np.concatenate((np.zeros(1), np.cumsum(block_force)))
        low, high = np.clip(ends - half, 0, None), np.clip(ends + half + 1, None, turns.size)
        value = (sums[high] - sums[low]) / (high - low)
        gaps.append(np.abs(np.diff(value)))
        range_of_ends = max(range_of_ends, float(np.ptp(value)))
    return np.concatenate(gaps) / max(range_of_ends, _force_range(force))


def _force_range(force: Floats) -> float:
    sampled = force[:: max(1, force.size >> 17)]
    low, high = np.percentile(sampled, (1.0, 99.0))
    if low == high:
        raise InputError(f"`force` must vary, got {low:g} N nearly throughout: a dead sensor")
    return float(high - low)
