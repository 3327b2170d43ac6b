"""Frequency, third harmonic, load ripple and mean loop of a record."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip.laboratory.blocks import Block
from microslip.laboratory.cuts import Cuts
from microslip.laboratory.loop_shape import UNDECIDED
from microslip.laboratory.record import Record

_FOLDS, _MOST_SAMPLES = 64, 1 << 18
_THIRD, _FIFTH, _IN_PHASE = 0.02, 0.15, 0.2
"""Least third harmonic over the fundamental, largest fifth over the third, and part of the third
out of phase, of a sine seen by a sensor that is not linear."""


def _angles(cycles: Cuts) -> tuple[slice, Floats]:
    """Return the slice of the first whole cycles, and the phase of its samples [cycles]."""
    count = int(np.searchsorted(cycles.cuts, cycles.cuts[0] + _MOST_SAMPLES, side="right")) - 1
    cuts = cycles.cuts[: max(1, count) + 1]
    place = np.arange(cuts[0], cuts[-1])
    return slice(int(cuts[0]), int(cuts[-1])), np.interp(place, cuts, np.arange(cuts.size)) % 1.0


def third_harmonic_of(record: Record, block: Block) -> tuple[float, list[str]]:
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


def load_ripple_of(record: Record, block: Block) -> float | None:
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
