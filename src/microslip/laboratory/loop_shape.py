"""Shape of the mean loop and of the channels in it: clearance, lost motion, springs, harmonics.

At a constant load the force of a contact that obeys Masing's rules rises after each reversal along
a concave branch. A branch that is not concave has another cause.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip._core.units import engineering
from microslip.laboratory.blocks import CycleBlock
from microslip.laboratory.cuts import Cuts
from microslip.laboratory.record import Record

BINS = 48
"""Bins of the displacement on each branch."""
UNDECIDED = "cause not determined"
_NOT_CONCAVE, _HOLLOW, _ERRORS = 0.005, 8.0, 5.0
"""Smallest depth of a hollow of the branch over the force amplitude, and over its error; smallest
significant difference of forces over its error."""
_ASYMMETRIC = 0.05
"""Smallest reported difference of both branches over the force amplitude."""
_OFFSET = 0.05
_PINCHED, _BAND = 0.35, 0.15
"""Slope at zero force over those before and after it, and half the band of force about zero."""
_FLAT, _FLAT_BINS = 0.25, 2
"""Slope after a reversal over the largest one, and number of bins, of lost motion."""
_STRAIGHT, _SPRING, _STEEP = 0.06, 0.05, 1.8
"""Largest relative change of slope in the last half of a straight branch, its smallest part of the
force range, and smallest ratio of the slope after the reversal."""

_FOLDS, _MOST_SAMPLES = 64, 1 << 18
_THIRD, _FIFTH, _IN_PHASE = 0.02, 0.15, 0.2
"""Least third harmonic over the fundamental, largest fifth over the third, and part of the third
out of phase, of a sine seen by a sensor that is not linear."""


class Shape(NamedTuple):
    """Mean branch from one reversal to the next, averaged over both directions of motion."""

    place: Floats
    """Displacement from the reversal over its range [-]."""
    force: Floats
    """Force without offset over the force amplitude [-]."""
    error: float
    """Standard error of a bin [-]."""
    asymmetry: float
    """Largest half difference of both directions, without offset [-]."""
    offset: float
    """Offset of the force over its amplitude [-]."""
    amplitude: float
    """Displacement amplitude [m]."""
    force_amplitude: float
    """Force amplitude [N]."""


def shape_of(
    x: Floats, force: Floats, columns: Mapping[str, Floats], rows: NDArray[np.intp]
) -> Shape | None:
    """Average the branches of the cycles ``rows``; None if there are too few samples."""
    branches: list[list[tuple[Floats, Floats]]] = [[], []]
    size = float(np.median(columns["force_amplitude"][rows]))
    for row in rows[np.linspace(0, rows.size - 1, min(64, rows.size)).astype(int)]:
        first = int(columns["start"][row])
        part = slice(first, first + int(columns["period"][row]) + 1)
        middle, amplitude = (columns[name][row] for name in ("displacement_offset", "amplitude"))
        offset = force[part].mean()  # of less noise than the middle between the reversals
        if not (amplitude > 0.0 and size > 0.0):
            continue
        p, f = (x[part] - middle) / amplitude, (force[part] - offset) / size
        top, low = int(np.argmax(p)), int(np.argmin(p))
        order = np.arange(p.size - 1)
        falling = ((order - top) % order.size) < ((low - top) % order.size)
        branches[0].append((0.5 * (1.0 - p[:-1][falling]), -f[:-1][falling]))
        branches[1].append((0.5 * (1.0 + p[:-1][~falling]), f[:-1][~falling]))
    if not branches[0]:
        return None
    means, errors = [], []
    for parts in branches:
        place, values = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
        at = np.clip((place * BINS).astype(int), 0, BINS - 1)
        count = np.bincount(at, minlength=BINS)
        if np.count_nonzero(count) < BINS // 2:
            return None
        full = count > 0
        grid = (np.arange(BINS) + 0.5) / BINS
        mean = np.bincount(at, values, minlength=BINS)[full] / count[full]
        where = np.bincount(at, place, minlength=BINS)[full] / count[full]
        means.append(np.interp(grid, where, mean))
        away = values - np.interp(place, where, mean)
        squares = np.bincount(at, away**2, minlength=BINS)[full]
        # Noise of the displacement counts where the branch is steep.
        errors.append(float(np.quantile(np.sqrt(squares) / count[full], 0.9)))
    both = 0.5 * (means[0] + means[1])
    skew = 0.5 * (means[1] - means[0])
    return Shape(
        grid,
        both,
        max(errors) / np.sqrt(2.0),
        float(np.abs(skew - np.median(skew))[2:-2].max()),
        float(np.median(columns["force_offset"][rows] / columns["force_amplitude"][rows])),
        float(np.median(columns["amplitude"][rows])),
        float(np.median(columns["force_amplitude"][rows])),
    )


def hollow_of(shape: Shape) -> tuple[float, float]:
    """Return the largest depth of a branch below its concave hull, and where it occurs.

    The depth is divided by the force amplitude; the place is the displacement since the reversal,
    divided by its range [-].
    """
    points = [(0, float(shape.force[0]))]
    for i, value in enumerate(shape.force.tolist()):
        while len(points) > 1:
            (a, fa), (b, fb) = points[-2:]
            if (fb - fa) * (i - a) > (value - fa) * (b - a):
                break
            points.pop()
        if i:
            points.append((i, value))
    hull = np.interp(np.arange(shape.force.size), *np.array(points).T)
    hull = np.maximum.accumulate(hull)
    depth = hull - shape.force
    at = int(depth.argmax())
    return float(depth[at]), float(shape.place[at])


def parallel_spring(shape: Shape) -> float | None:
    """Return the force of a spring in parallel with the contact at the amplitude, over that of all.

    None unless the second half of the branch is straight.
    """
    slope = np.polynomial.polynomial.polyfit
    p, f = shape.place, shape.force
    third, last = (
        float(slope(p[part], f[part], 1)[1])
        for part in ((p >= low) & (p <= high) for low, high in ((0.5, 0.74), (0.74, 0.97)))
    )
    first = float(np.max(np.diff(f[: BINS // 2]) * BINS)) - 2.0 * _ERRORS * shape.error * BINS
    straight = abs(third - last) < _STRAIGHT * last + _ERRORS * shape.error * 4.0
    if not (last > 0.0 and straight and 0.5 * last > _SPRING and first > _STEEP * last):
        return None
    # The slope must be significant.
    if _ERRORS * shape.error * 4.0 > 0.3 * last:
        return None
    return 0.25 * (third + last)


def without_spring(columns: Mapping[str, Floats], shape: Shape, spring: float) -> dict[str, Floats]:
    """Subtract the force of a parallel spring in the columns that determine slip regimes."""
    rest = 1.0 - spring
    force = shape.force - spring * (2.0 * shape.place - 1.0)
    crossing = float(np.interp(0.0, np.maximum.accumulate(force), shape.place))
    slid = columns["amplitude"] * (1.0 - 2.0 * crossing)
    pushed = columns["force_amplitude"] * rest
    energy = columns["dissipated_energy"]
    return {
        **columns,
        "force_amplitude": pushed,
        "sliding_distance": slid,
        "energy_ratio": columns["energy_ratio"] / rest,
        "fouvry_ratio": energy / (4.0 * pushed * slid),
    }


def clearance_of(shape: Shape) -> float | None:
    """Return the width [m] of a clearance, where the force stays near zero; None without one."""
    p, f = shape.place, shape.force
    inside = np.flatnonzero(np.abs(f) < _BAND)
    before, after = np.flatnonzero(f <= -_BAND), np.flatnonzero(f >= _BAND)
    if inside.size < 3 or not before.size or not after.size or before[-1] > after[0]:
        return None
    slopes = np.diff(f) / np.diff(p)
    first, last = inside[0], inside[-1]
    at_zero = float((f[last] - f[first]) / (p[last] - p[first]))
    steep = float(np.max(slopes[: first + 1])), float(np.max(slopes[last:]))
    if at_zero > _PINCHED * min(steep):
        return None
    ends = np.interp((-_BAND, _BAND), np.maximum.accumulate(f), p)
    return 2.0 * shape.amplitude * max(float(ends[1] - ends[0]) - 2.0 * _BAND / min(steep), 0.0)


def lost_motion_of(shape: Shape) -> float | None:
    """Return the displacement [m] after a reversal without change of force; None without one."""
    slopes = np.diff(shape.force) / np.diff(shape.place)
    is_flat = np.abs(slopes) < _FLAT * slopes.max()
    steep = int(np.argmax(~is_flat[1:])) + 1
    if steep <= _FLAT_BINS or slopes[:steep].max() > 0.5 * slopes.max():
        return None
    return float(shape.place[steep]) * 2.0 * shape.amplitude


def shape_notes(shape: Shape | None, is_load_recorded: bool) -> list[str]:
    """Return notes on the shape of the branch; if the cause is ambiguous, all causes are listed.

    ``is_load_recorded`` states whether the normal load was recorded within the cycles.
    """
    if shape is None:
        return []
    notes: list[str] = []
    depth, place = hollow_of(shape)
    width: float | None = None
    if depth > _NOT_CONCAVE + _HOLLOW * shape.error:
        if (width := clearance_of(shape)) is not None:
            notes.append(
                f"clearance: a dead zone of {engineering(width, 'm')} at zero force; energy and "
                "stiffness are those of joint and clearance together"
            )
        elif (width := lost_motion_of(shape)) is not None:
            notes.append(
                f"lost motion: after each reversal the force does not change over "
                f"{engineering(width, 'm')}, as with play between the joint and its displacement "
                "sensor; energies and amplitudes include it"
            )
        else:
            load = "" if is_load_recorded else "of the normal load within the cycle, or "
            notes.append(
                f"the branches of the loop are not concave, as those of friction at a constant "
                f"load are: the force is {100.0 * depth:.0f} % of its amplitude too low at "
                f"{100.0 * place:.0f} % of the way after a reversal; {UNDECIDED}. Possible are a "
                "load that changes within the cycle, stick-slip, play in the drive, a force that "
                "depends on the rate, and a delay. A record "
                f"{load}at another frequency would identify the cause"
            )
    if width is None and shape.asymmetry > _ASYMMETRIC + _ERRORS * shape.error:
        notes.append(
            f"the two directions of the loop differ by {100.0 * shape.asymmetry:.0f} % of the "
            f"force amplitude; {UNDECIDED} (a load that changes with the displacement, a tilted or "
            "worn specimen, a sensor that is not linear). A record of the normal load within the "
            "cycle, or with the specimen turned around, would identify the cause"
        )
    elif abs(shape.offset) > _OFFSET:
        notes.append(
            f"the middle of the force range is {100.0 * abs(shape.offset):.0f} % of its "
            f"amplitude from zero; {UNDECIDED} (a zero error of the sensor, or friction that "
            "differs with the direction). A record without contact, or with the specimen turned "
            "around, would identify the cause"
        )
    if not notes and (spring := parallel_spring(shape)) is not None:
        stiffness = spring * shape.force_amplitude / shape.amplitude
        notes.append(
            f"a spring in parallel of {engineering(stiffness, 'N/m')}: the force rises "
            f"linearly to each reversal, by {100.0 * spring:.0f} % of its amplitude on each "
            "side. Regimes are those of the loop without the spring, and the friction coefficient "
            f"by the peak is {1.0 - spring:.3g} times the value given"
        )
    return notes


# -- channels within the mean cycle ---------------------------------------------------------------


def _angles(cycles: Cuts) -> tuple[slice, Floats]:
    """Return the slice of the first whole cycles, and the phase of its samples [cycles]."""
    count = int(np.searchsorted(cycles.cuts, cycles.cuts[0] + _MOST_SAMPLES, side="right")) - 1
    cuts = cycles.cuts[: max(1, count) + 1]
    place = np.arange(cuts[0], cuts[-1])
    return slice(int(cuts[0]), int(cuts[-1])), np.interp(place, cuts, np.arange(cuts.size)) % 1.0


def third_harmonic_of(record: Record, block: CycleBlock) -> tuple[float, list[str]]:
    """Return the third harmonic of the displacement over the fundamental [-], with a note.

    The note is given if it is in phase with the fundamental and the fifth harmonic is much smaller,
    as for a sinusoidal motion measured by a sensor with a cubic characteristic.
    """
    piece, share = _angles(block.cycles)
    x = record.displacement[block.samples][piece]
    x = x - x.mean()
    first, third, fifth = (np.dot(x, np.exp(-2j * math.pi * n * share)) for n in (1, 3, 5))
    size, turn = float(abs(third) / abs(first)), first / abs(first)
    is_cubic = size > _THIRD and abs(fifth) < _FIFTH * abs(third)
    is_cubic &= abs((third / turn**3).imag) < _IN_PHASE * abs(third)
    if not is_cubic:
        return size, []
    return size, [
        f"the displacement has a third harmonic of {100.0 * size:.1f} %, in phase "
        f"with the first and without others: {UNDECIDED} (the drive, or a displacement sensor that "
        "is not linear, which makes amplitude, energy and stiffness wrong). A calibration of the "
        "sensor would identify the cause"
    ]


def load_ripple_of(record: Record, block: CycleBlock) -> float | None:
    """Return half the range of the normal load within the mean cycle, over its mean [-]."""
    if not isinstance(record.normal_load, np.ndarray):
        return None
    piece, share = _angles(block.cycles)
    load = record.normal_load[block.samples][piece]
    folds = min(_FOLDS, max(4, int(block.cycles.period)))
    fold = np.minimum((share * folds).astype(np.int64), folds - 1)
    count = np.bincount(fold, minlength=folds)
    mean = np.bincount(fold, load, minlength=folds)[count > 0] / count[count > 0]
    return float(0.5 * np.ptp(mean) / load.mean()) if load.mean() != 0.0 else None


def mean_loop_of(
    x: Floats, force: Floats, columns: Mapping[str, Floats], rows: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """Return displacement [m] and force [N] of the closed mean loop of the cycles ``rows``.

    At most a hundred cycles, evenly distributed over the rows, are averaged.
    """
    some = rows[np.linspace(0, rows.size - 1, min(100, rows.size)).astype(int)]
    share = np.linspace(0.0, 1.0, 257)
    places = columns["start"][some, None] + columns["period"][some, None] * share
    at = np.minimum(places.astype(np.intp), x.size - 2)
    part = np.minimum(places - at, 1.0)
    loop = [(v[at] + part * (v[at + 1] - v[at])).mean(axis=0) for v in (x, force)]
    for values in loop:
        values[-1] = values[0]
    return lock(loop[0]), lock(loop[1])
