"""Settled cycles of a record folded onto one cycle: mean loop, and scatter of the cycles."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, number, show
from microslip._core.errors import InputError
from microslip._core.frozen import LockedArrays
from microslip._core.units import engineering
from microslip._core.wording import plural
from microslip.laboratory.cuts import FEWEST_SAMPLES, one_loop
from microslip.laboratory.cycles import Cycles, cycles_of, step_of
from microslip.laboratory.estimates import Trend, trend
from microslip.laboratory.mean_cycle import (
    MeanCycle,
    all_turns,
    drift_of,
    errors_of_steps,
    places_of,
)
from microslip.laboratory.motion import QUIET, PeriodicMotion, motion_of
from microslip.laboratory.record import Record

FEWEST_CYCLES = 3
_MOST_BINS = 512
_JUDGED, _LIKELY = 8, 2.0
"""Fewest cycles for an estimate of growth, and standard errors of a likely one."""
_CHANGED = 0.2
"""Relative range of the mean loads of the cycles above which a record is rejected."""
_FEW = 16
"""Samples per bin, on average, up to which the phase of each sample is kept."""

_LOAD_HARMONICS, _STANDS_OUT, _UNVARIED = 32, 3.5, 3e-4
"""Largest number of load harmonics; standard errors of a significant one, and its smallest size
over the mean."""


@dataclass(frozen=True, eq=False, repr=False)
class Folded(LockedArrays):
    """Settled cycles of a record, averaged by phase within the cycle.

    The displacement is a Fourier series of the significant harmonics, plus corners for motions such
    as a triangular wave; the force is averaged in bins of phase. The noise of both is estimated
    from the scatter between the cycles, after removal of a linear drift.
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
    motion: PeriodicMotion
    """Displacement as a sum of harmonics and corners."""
    force_noise: float
    """Standard deviation of one sample of force [N]."""
    normal_load: float | None
    """Mean normal load [N]; None without one."""
    cycles: int
    """Number of settled cycles."""
    notes: tuple[str, ...]
    """Notes on the cycles and on the folding."""
    load_terms: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    """Cosine and sine of each harmonic of the normal load [N]; empty if the load is constant."""
    drifted: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    """Effect of one standard error of the drift on the force of each bin [N]."""
    stepped: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    """Effects of the converter steps, one standard deviation per row [N]."""
    growth: float = 0.0
    """Relative growth of the force of the loops over the cycles; 0 if not significant."""
    cycle_amplitude: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    """Displacement amplitude of each cycle [m]; empty for an averaged cycle."""
    completed: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    """Whether each bin is of the half of a loop that symmetry completes; empty for whole loops."""
    samples: NDArray[np.float64] = field(default_factory=lambda: np.zeros((3, 0)))
    """Phase [rad], bin and cycle of each sample, shape (3, samples).

    Given only if bins hold few samples with uneven phases; otherwise empty.
    """

    def displacement(self, phase: Floats, order: int = 0) -> Floats:
        """Evaluate the displacement [m] at phases [rad], or its phase derivative of ``order``."""
        return self.motion.basis(phase, order) @ self.motion.coefficients

    @property
    def amplitude(self) -> float:
        """Amplitude of the displacement [m], half its range."""
        phase = np.append(np.linspace(0.0, 2.0 * math.pi, 2048), self.motion.corners)
        return 0.5 * float(np.ptp(self.displacement(phase)))

    @property
    def way(self) -> Floats:
        """Displacement increment over each bin [m]; its product with the force is the work."""
        width = 0.5 * (np.roll(self.phase, -1) - np.roll(self.phase, 1)) % math.pi
        return self.displacement(self.phase, 1) * width

    def part(self, rows: NDArray[np.bool_]) -> Folded:
        """Return the average of some of the cycles, with the displacement and noise of all."""
        count = self.cycle_count[rows].sum(axis=0)
        full = count > 0.0
        force = self.cycle_force[rows].sum(axis=0)[full] / count[full]
        changed = {
            "phase": self.phase[full],
            "spread": self.spread[full],
            "force": force,
            "count": count[full],
            "drifted": self.drifted[full] if self.drifted.size else self.drifted,
            "stepped": self.stepped[:, full] if self.stepped.size else self.stepped,
            "cycle_force": self.cycle_force[np.ix_(rows, full)],
            "cycle_count": self.cycle_count[np.ix_(rows, full)],
            "motion": replace(
                self.motion,
                covariance=self.motion.covariance * (self.cycles / np.count_nonzero(rows)),
            ),
            "cycles": int(np.count_nonzero(rows)),
        }
        phases, bins, cycles = self.samples[:, rows[self.samples[2].astype(np.int64)]]
        bins, cycles = (
            (np.cumsum(m) - 1)[i.astype(int)] for m, i in ((full, bins), (rows, cycles))
        )
        changed["samples"] = np.stack((phases, bins, cycles))
        return replace(self, **changed)

    def __repr__(self) -> str:
        return f"Folded({self.name!r}, {self.cycles} cycles, {self.phase.size} bins)"


def fold(record: Record, bins: int = _MOST_BINS) -> Folded:
    """Fold the settled cycles of a record, except the first of the record, onto one cycle of phase.

    Parameters
    ----------
    record : Record
        Displacement, force and, if measured, normal load.
    bins : int, optional
        Number of phase bins for the force, at least 16; fewer if a cycle has fewer samples.

    Returns
    -------
    Folded
        Displacement as Fourier series, mean force in bins, and the noise of both.
    """
    if not isinstance(record, Record):
        raise InputError(
            f"`records` must be Records, got {show(record)}; write Record(displacement, "
            "force) or Record.read(path)"
        )
    judgement = cycles_of(record)
    record = judgement.record
    x, force = record.displacement, record.force
    seconds = record.seconds
    time = np.arange(float(x.size)) if seconds is None else seconds
    turns, samples_a_cycle = all_turns(time, x, judgement.blocks)
    is_folded, spike_notes = _folded_cycles(judgement)
    counting = judgement.settled
    rows = np.flatnonzero(is_folded)
    starts, sample = judgement.columns["start"], np.arange(x.size)
    place = np.searchsorted(starts, sample, side="right") - 1
    inside = (place >= 0) & (sample < (starts + judgement.columns["period"])[place])
    inside &= is_folded[place]
    del sample
    place = (np.cumsum(is_folded) - 1)[place[inside]]
    phase = 2.0 * math.pi * turns[inside]
    del turns
    x, force = x[inside], force[inside]
    phase_count, is_alike = places_of(phase, samples_a_cycle)
    size = int(min(bins, max(16, phase_count)))

    # Where a cycle has a whole number of samples they lie in the middle of the bins.
    width = 2.0 * math.pi / size
    edge = float(phase[0]) % width - 0.5 * width
    wrapped = edge + np.mod(phase - edge, 2.0 * math.pi)
    cycle = np.rint((phase - wrapped) / (2.0 * math.pi)).astype(np.int64)
    column = np.clip(((wrapped - edge) / width).astype(np.int64), 0, size - 1)
    phase = wrapped
    cycle -= cycle.min()
    number = np.cumsum(np.bincount(column, minlength=size) > 0) - 1
    size = int(number[-1]) + 1
    if size < number.size:
        column = number[column]
    curve = MeanCycle(phase, column, size, is_alike and phase_count <= size)
    total, spread = curve.total, curve.spread
    spread[spread < 1e-3 * width] = 0.0
    drift, drift_error = drift_of(force, cycle, curve)
    moved, moved_error = drift_of(x, cycle, curve)
    gone = phase / (2.0 * math.pi)
    gone += cycle
    gone -= float(gone.mean())
    del cycle
    x -= moved * gone
    motion = motion_of(np.mod(phase, 2.0 * math.pi), x, phase_count)
    del x
    harmonics = motion.harmonics
    saw = np.zeros(motion.coefficients.size)
    # A straight line, cut at each cycle.
    saw[2 : 2 + 2 * harmonics.size : 2] = moved_error / (math.pi * harmonics)
    level = curve.of(force - drift * gone)
    drifted = drift_error * np.bincount(column, gone) / total
    del gone
    noise_f = curve.noise(level.residual, 1)
    load = _mean_load(record, inside, place)
    load_terms = _load_terms(record, inside, curve)
    notes = [*judgement.notes(counting), *spike_notes]
    notes += [judgement.delay] if judgement.delay else []
    if counting.is_moving:
        notes.append("the cycles drift: the identified law is an average over them")
    elif judgement.plateaus:
        notes.append("the record may be clipped, which affects the identified law")
    step, stepped = step_of(force), np.zeros((0, size))
    if step is not None:
        # Half a step as a standard deviation: errors of steps go along with the course of a loop.
        stepped = 0.5 * step * errors_of_steps(force, step, column)
        if stepped.size:  # nor do the means of single bins know more of it
            noise_f = math.hypot(noise_f, 0.5 * step * math.sqrt(float(total.mean())))
    del force
    few = bool(spread.any()) and phase.size <= _FEW * size
    samples: NDArray[Any] = np.stack((phase, column, place)) if few else np.zeros((3, 0))
    place *= size
    place += column
    shape = rows.size, size
    counts = np.bincount(place, minlength=rows.size * size).reshape(shape).astype(float)
    sums: Floats = counts * level.base
    sums += np.bincount(place, level.residual, minlength=rows.size * size).reshape(shape)
    grown = _growth(sums, counts, level.mean)
    growth = grown.slope if abs(grown.slope) > _LIKELY * grown.standard_error else 0.0
    return Folded(
        name=record.name,
        phase=curve.middle,
        spread=spread,
        force=level.mean,
        count=total,
        cycle_force=sums,
        cycle_count=counts,
        cycle_amplitude=np.asarray(judgement.columns["amplitude"])[is_folded],
        motion=replace(motion, covariance=motion.covariance + np.outer(saw, saw)),
        force_noise=max(noise_f, QUIET * 0.5 * float(np.ptp(level.mean))),
        normal_load=load,
        cycles=int(rows.size),
        notes=tuple(notes),
        load_terms=load_terms,
        growth=growth,
        drifted=drifted,
        stepped=stepped,
        samples=samples,
    )


def _growth(sums: Floats, counts: Floats, mean: Floats) -> Trend:
    number = sums.shape[0]
    away = mean - np.average(mean, weights=counts.sum(axis=0))
    if number < _JUDGED or not away.any():
        return Trend(0.0, math.inf, number)
    factors = (sums @ away - counts @ (away * (mean - away))) / (counts @ away**2)
    return trend(np.linspace(0.0, 1.0, number), factors)


def _folded_cycles(judged: Cycles) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """Select the cycles to fold: settled ones, or closed ones if too few are settled.

    The first cycle is excluded, and cycles with spikes if enough other cycles remain.
    """
    closed, spared = ~judged.is_open, ~judged.has_spike
    closed[0] = False  # it begins at rest
    for chosen in (judged.settled.selection & closed & spared, closed & spared, closed):
        if np.count_nonzero(chosen) >= FEWEST_CYCLES:
            break
    else:
        raise InputError(
            f"{judged.record.name}: at least {FEWEST_CYCLES} closed cycles after the first one are "
            f"needed for an estimate of the noise, got {np.count_nonzero(closed)} of {closed.size}"
        )
    lost = int(np.count_nonzero(chosen & ~spared))
    if not lost:
        return chosen, ()
    return chosen, (f"too few cycles without spikes: {plural(lost, 'cycle')} with spikes used",)


def _mean_load(record: Record, inside: NDArray[np.bool_], cycle: NDArray[np.int64]) -> float | None:
    if not isinstance(record.normal_load, np.ndarray):
        return record.normal_load
    load = record.normal_load[inside]
    mean = float(load.mean())
    cycle_means = np.bincount(cycle, load) / np.bincount(cycle)
    low, high = float(cycle_means.min()), float(cycle_means.max())
    if high - low > _CHANGED * abs(mean):
        raise InputError(
            f"{record.name}: the normal load must be the same in all cycles, got means of "
            f"{low:.4g} to {high:.4g} N; select rows with one load, such as `rows=slice(0, 5000)`"
        )
    return mean


def load_basis(phase: Floats, terms: int) -> Floats:
    """Return cosine and sine of harmonics 1, 2, ... at phases [rad], shape (phases, terms)."""
    angles = np.outer(phase, np.arange(1, terms // 2 + 1))
    return np.stack((np.cos(angles), np.sin(angles)), axis=2).reshape(phase.size, terms)


def _load_terms(record: Record, inside: NDArray[np.bool_], curve: MeanCycle) -> Floats:
    number = min(_LOAD_HARMONICS, curve.size // 4)
    if not isinstance(record.normal_load, np.ndarray) or not number:
        return np.zeros(0)
    load = record.normal_load[inside]
    level = curve.of(load)
    basis = np.hstack((np.ones((curve.size, 1)), load_basis(curve.middle, 2 * number)))
    gram = basis.T @ (curve.total[:, None] * basis)
    terms = np.linalg.lstsq(gram, basis.T @ (curve.total * level.mean), rcond=None)[0]
    error = curve.noise(level.residual) * math.sqrt(2.0 / load.size)
    sizes = np.hypot(terms[1::2], terms[2::2])
    counts = sizes > max(_STANDS_OUT * error, _UNVARIED * abs(float(load.mean())))
    if not counts.any():
        return np.zeros(0)
    last = int(np.flatnonzero(counts)[-1]) + 1
    return np.asarray(terms[1 : 1 + 2 * last] * np.repeat(counts[:last], 2))


# -- loops averaged by the rig --------------------------------------------------------------------


def stated_noise(stated: Any) -> tuple[float, float]:
    """Validate the standard deviations of a force [N] and of a displacement [m]."""
    if isinstance(stated, str) or not hasattr(stated, "__len__") or len(stated) != 2:
        raise InputError(
            "`noise` must be the standard deviations of a force [N] and a displacement [m], "
            f"such as (2.0, 5e-9), got {show(stated)}"
        )
    force = number("noise", stated[0], "N", 2.0)
    displacement = number("noise", stated[1], "m", 5e-9)
    if not force > 0.0 or displacement < 0.0:
        raise InputError(
            f"`noise` must be above zero in the force, got {force:g} N, {displacement:g} m"
        )
    return force, displacement


def averaged(record: Record, noise: tuple[float, float], bins: int = _MOST_BINS) -> Folded:
    """Average a record of one cycle, already the mean of several, in at most ``bins`` phase bins.

    ``noise`` holds the standard deviations of a sample of force [N] and of displacement [m].
    """
    load = record.normal_load
    size, is_one, _ = one_loop(record.displacement, record.force)
    x, force = record.displacement[:size], record.force[:size]
    span = float(np.ptp(x)) or 1.0
    if size < FEWEST_SAMPLES or not is_one:
        raise InputError(
            f"{record.name}: with `noise` a record must be one averaged cycle of at least "
            f"{FEWEST_SAMPLES} samples, got {size} samples that are no single cycle; without "
            "`noise` it is estimated from several cycles"
        )
    time: Floats = np.arange(float(size)) if record.time is None else record.time[:size]
    phase = 2.0 * math.pi * (time - time[0]) * ((size - 1.0) / size / float(time[-1] - time[0]))
    # From its highest place on, as those of records are.
    first = int(np.argmax(x))
    x, force, phase = (np.roll(values, -first) for values in (x, force, phase))
    phase = np.mod(phase - phase[0], 2.0 * math.pi)
    floor = QUIET * 0.5 * span
    motion = motion_of(phase, x, size)
    scale = max(noise[1], floor) / max(motion.noise, floor)
    column = np.arange(size) * min(size, bins) // size
    count = np.bincount(column).astype(float)
    places = np.bincount(column, phase) / count
    sums = np.bincount(column, force)
    note = (
        f"read as one averaged cycle with the given noise, {engineering(noise[0], 'N')} in force "
        f"and {engineering(noise[1], 'm')} in displacement"
    )
    return Folded(
        name=record.name,
        phase=places,
        spread=np.sqrt(np.bincount(column, (phase - places[column]) ** 2) / count),
        force=sums / count,
        count=count,
        cycle_force=sums[None].astype(float),
        cycle_count=count[None],
        motion=replace(motion, covariance=motion.covariance * scale**2),
        force_noise=noise[0],
        normal_load=float(load.mean()) if isinstance(load, np.ndarray) else load,
        cycles=1,
        notes=(note,),
        samples=np.stack((phase, column, np.zeros(size))),
    )
