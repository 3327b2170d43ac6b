"""Parts of stepped records with one amplitude and frequency each, and single digitised loops."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip.laboratory.blocks import blocks_of, stops_of
from microslip.laboratory.cuts import FEWEST_SAMPLES, noise_of, runs_of
from microslip.laboratory.folding import Folded, averaged
from microslip.laboratory.record import Record

_ALIKE = 0.05
"""Largest relative difference of amplitudes or periods within a group of cycles."""
_FEWEST = 4
"""Smallest number of cycles of a piece: one of running-in and three settled ones."""
_LEAST_RANGE = 40.0
"""Smallest range of a displacement with cycles, over its noise."""
_END = 4.0
"""Distance of the first or last sample from the extreme one, over the noise, up to which half a
loop begins or ends with that sample."""
_NEAR, _MOST_CYCLES = 0.5, 3.0
"""Fraction of the amplitude beyond which a run has a turning point; cycles of a digitised loop."""
_STRONG = 8.0
"""Least power of a significant harmonic of half a loop, over its variance and the logarithm of the
number of samples."""


def _part(record: Record, first: int, last: int, label: str) -> Record:
    rows = slice(first, last + 1)
    return record._taken(rows, cycle_number=None, name=f"{record.name}, {label}")


def _cycles_of(record: Record, least: float) -> list[tuple[int, int]]:
    """Return the first sample and the length in samples of each cycle of a record.

    Stretches without cycles, which may be much smaller there, are searched again if the
    displacement moves by ``least`` [m] or more.
    """
    x = record.displacement
    try:
        blocks = blocks_of(record).having_cycles
    except (InputError, ValueError):
        blocks = ()
        rest = np.abs(x - np.median(x))
        is_free = rest < 0.5 * rest.max()  # without what is much larger than the rest
    else:
        is_free = np.ones(x.size, dtype=bool)
    found = []
    for block in blocks:
        cuts = block.first + np.asarray(block.cycles.cuts)
        found += list(zip(cuts[:-1].tolist(), np.diff(cuts).tolist(), strict=True))
        is_free[cuts[0] : cuts[-1]] = False
    for begin, end in stops_of(record) if blocks else ():
        is_free[begin:end] = False
    for begin, end in runs_of(is_free).tolist():
        if end - begin > _FEWEST * FEWEST_SAMPLES and np.ptp(x[begin:end]) >= least:
            inner = _cycles_of(_part(record, begin, end - 1, "part"), least)
            found += [(begin + start, period) for start, period in inner]
    return sorted(found)


def stretches_of(record: Record) -> tuple[list[Record], int]:
    """Cut a record of several amplitudes or frequencies into parts with one of each.

    Return the parts, and the number of cycles in none of them. A record is not cut if its cycles
    are alike, or if fewer than two parts have enough cycles.
    """
    cycles = _cycles_of(record, _LEAST_RANGE * noise_of(record.displacement))
    if not cycles:
        return [record], 0
    start, period = np.array(cycles).T
    # The standard deviation within a cycle, which noise changes less than the range.
    x = np.append(0.0, record.displacement - record.displacement.mean())
    sums, squares = np.cumsum(x), np.cumsum(x**2)
    mean, square = ((c[start + period] - c[start]) / period for c in (sums, squares))
    amplitude = np.sqrt(np.maximum(square - mean**2, 0.0))
    groups: list[list[int]] = []
    for i in range(start.size):
        if groups:
            last = groups[-1]
            pairs = (
                (amplitude[i], np.median(amplitude[last])),
                (period[i], np.median(period[last])),
            )
            if all(abs(one / other - 1.0) <= _ALIKE for one, other in pairs if other):
                last.append(i)
                continue
        groups.append([i])
    long = [group for group in groups if len(group) >= _FEWEST]
    if len(long) < 2:
        return [record], 0
    pieces = []
    for group in long:
        first, end = int(start[group[0]]), int(start[group[-1]] + period[group[-1]])
        label = f"cycles {group[0] + 1} to {group[-1] + 1}"
        pieces.append(_part(record, first, min(end, record.displacement.size - 1), label))
    return pieces, start.size - sum(len(group) for group in long)


def _turning_samples(x: Floats) -> NDArray[np.int64]:
    low, high = np.percentile(x, (1.0, 99.0))
    away = (x - 0.5 * (low + high)) / (0.5 * (high - low))
    side = np.where(away > _NEAR, 1, np.where(away < -_NEAR, -1, 0))
    at = np.flatnonzero(side)
    runs = np.split(at, np.flatnonzero(np.diff(side[at])) + 1) if at.size else []
    return np.array([run[np.argmax(side[run[0]] * x[run])] for run in runs], dtype=np.int64)


def _without_weak_harmonics(folded: Folded) -> Folded:
    """Remove harmonics that are not significant: each displacement is used twice."""
    motion, end = folded.motion, 1 + 2 * folded.motion.harmonics.size
    power = (motion.coefficients**2 / np.diag(motion.covariance))[1:end].reshape(-1, 2).sum(axis=1)
    strong = (power > _STRONG * math.log(folded.count.sum())) | (motion.harmonics == 1)
    strong |= motion.harmonics.size > 4  # significant together
    kept = np.ones(motion.coefficients.size, dtype=bool)
    kept[1:end] = np.repeat(strong, 2)
    motion = replace(
        motion,
        harmonics=motion.harmonics[strong],
        coefficients=motion.coefficients[kept],
        covariance=motion.covariance[np.ix_(kept, kept)],
    )
    return replace(folded, motion=motion)


def loop_of(record: Record, noise: tuple[float, float], bins: int) -> Folded:
    """Fold a digitised loop, which spans from half a cycle to three cycles, onto one cycle.

    ``noise`` is the standard deviation of force [N] and displacement [m]. Of several cycles the
    last one is used. Half a cycle, between two turning points, is completed by symmetry.
    """
    x, force = record.displacement, record.force
    turns = _turning_samples(x)
    if turns.size == 2 and abs(int(turns[1] - turns[0])) >= 0.9 * (x.size - 1):
        # Where the motion slows down, noise moves the extreme sample: the ends are as good.
        turns[0] *= abs(x[0] - x[turns[0]]) > _END * noise[1]
        if abs(x[-1] - x[turns[1]]) <= _END * noise[1]:
            turns[1] = x.size - 1
        middle_x, middle = (0.5 * (values[turns[0]] + values[turns[1]]) for values in (x, force))
        branch = slice(int(turns[0]), int(turns[1]))
        f, load = force[branch] - middle, record.normal_load
        half = np.repeat([1.0, -1.0], f.size)
        # Each displacement occurs twice; with twice the variance it counts once. Forces
        # are fitted on the measured branch alone, with an offset: their middle is not known.
        for _ in range(2):
            whole = Record(
                half * np.tile(x[branch] - middle_x, 2),
                half * np.tile(f, 2),
                normal_load=float(np.mean(load)) if load is not None else None,
                name=record.name,
            )
            folded = _without_weak_harmonics(averaged(whole, noise, bins))
            # An error of the middle has opposite signs on both halves, and the motion has no jumps.
            first = int(np.argmax(whole.displacement))
            phase = math.pi * np.mod(np.arange(half.size) - first, half.size) / f.size
            columns = np.column_stack((folded.motion.basis(phase), half))
            normal = 0.5 * columns.T @ columns
            normal[-1, -1] += 2.0  # by both ends
            inverse = np.linalg.inv(normal)
            middle_x += float(inverse[-1] @ (0.5 * columns.T @ whole.displacement))
        width = 3.0**0.5 * folded.spread
        falls = [folded.displacement(folded.phase + way * width, 1) < 0.0 for way in (-1.0, 1.0)]
        measured = np.equal(falls, x[branch][-1] < x[branch][0]).all(axis=0)
        side = np.where(folded.displacement(folded.phase, 1) < 0.0, -1.0, 1.0)
        error = float(inverse[-1, -1]) ** 0.5 * noise[1]
        shift = np.linalg.lstsq(folded.motion.basis(folded.phase), error * side)[0]
        covariance = 2.0 * folded.motion.covariance + np.outer(shift, shift)
        note = "half a loop: its other half is completed by symmetry, and not fitted"
        return replace(
            folded,
            motion=replace(folded.motion, covariance=covariance),
            completed=~measured,
            notes=(*folded.notes, note),
        )
    steps = np.hypot(*((np.roll(v, -1) - v) / np.ptp(v) for v in (x, force)))
    # A single closed loop: its ends are no turning points, wherever it starts.
    is_one = turns.size <= 3 and steps[-1] <= 2.0 * np.quantile(steps, 0.95)
    period = 2.0 * float(np.mean(np.diff(turns))) if turns.size > 1 else 0.0
    if not is_one and period and 1.02 * period < x.size <= _MOST_CYCLES * period:
        if turns.size >= 3:
            first, last = int(turns[-3]), int(turns[-1])
        else:
            first, last = x.size - 1 - round(period), x.size - 1
        return averaged(_part(record, first, last - 1, "last cycle"), noise, bins)
    return averaged(record, noise, bins)
