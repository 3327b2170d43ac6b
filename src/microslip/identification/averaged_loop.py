"""Loops that were averaged before they came here: one cycle, of which the noise is stated."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import number, show
from microslip._core.frozen import lock
from microslip._core.units import engineering
from microslip.errors import InputError
from microslip.identification.displacement_series import QUIET, series_of
from microslip.identification.folding import MOST_BINS, Folded
from microslip.tribometer.cycles import BAND, FEWEST_SAMPLES, crossings_of
from microslip.tribometer.record import Record

_REPEATED = 0.3
"""Of a usual step: a last sample as near to the first one is that one again."""


def noise_of(stated: Any) -> tuple[float, float]:
    """Standard deviations of a force [N] and of a displacement [m]."""
    if isinstance(stated, str) or not hasattr(stated, "__len__") or len(stated) != 2:
        raise InputError(
            "`noise` must be the standard deviations of a force [N] and a displacement [m], "
            f"such as (2.0, 5e-9), got {show(stated)}"
        )
    force, displacement = (
        number("noise", value, unit, example)
        for value, unit, example in zip(stated, ("N", "m"), (2.0, 5e-9), strict=True)
    )
    if not force > 0.0 or displacement < 0.0:
        raise InputError(
            f"`noise` must be above zero in the force, got {force:g} N, {displacement:g} m"
        )
    return force, displacement


def averaged(record: Record, noise: tuple[float, float], bins: int = MOST_BINS) -> Folded:
    """A single cycle, averaged already; its last sample may be the first one again."""
    x, force, load = record.displacement, record.force, record.normal_load
    size = x.size
    spans = [float(np.ptp(values)) or 1.0 for values in (x, force)]
    way = np.hypot(np.diff(x) / spans[0], np.diff(force) / spans[1])
    gap = math.hypot((x[-1] - x[0]) / spans[0], (force[-1] - force[0]) / spans[1])
    if gap < _REPEATED * float(np.median(way)):
        size -= 1
    x, force = x[:size], force[:size]
    middle = 0.5 * float(x.max() + x.min())
    turns = crossings_of(np.tile(x - middle, 3), BAND * 0.5 * spans[0])
    if size < FEWEST_SAMPLES or not 5 <= turns <= 6:
        raise InputError(
            f"{record.name}: an averaged loop is one cycle of {FEWEST_SAMPLES} samples or "
            f"more, got {size} samples that cross their middle {turns // 3} times; of whole "
            "records the noise is found, without `noise`"
        )
    phase = 2.0 * math.pi * np.arange(size) / size
    rate = None
    if record.time is not None:
        time = record.time[:size]
        rate = (size - 1.0) / size / float(time[-1] - time[0])
        phase = 2.0 * math.pi * (time - time[0]) * rate
    elif record.sample_rate is not None:
        rate = record.sample_rate / size
    # From its highest place on, as those of records are.
    first = int(np.argmax(x))
    x, force, phase = (np.roll(values, -first) for values in (x, force, phase))
    phase = np.mod(phase - phase[0], 2.0 * math.pi)
    floor = QUIET * 0.5 * spans[0]
    harmonics, coefficients, covariance, series_noise = series_of(phase, x, size)
    stated = max(noise[1], floor)
    column = np.arange(size) * min(size, bins) // size
    count = np.bincount(column).astype(float)
    places = np.bincount(column, phase) / count
    sums = np.bincount(column, force)
    said = (
        f"taken for one averaged cycle, the noise of a force {engineering(noise[0], 'N')} and of a "
        f"displacement {engineering(noise[1], 'm')}, as stated",
    )
    return Folded(
        name=record.name,
        phase=lock(places),
        spread=lock(np.sqrt(np.bincount(column, (phase - places[column]) ** 2) / count)),
        force=lock(sums / count),
        count=lock(count),
        cycle_force=lock(sums[None].astype(float)),
        cycle_count=lock(count[None]),
        harmonics=lock(harmonics),
        coefficients=lock(coefficients),
        covariance=lock(covariance * (stated / max(series_noise, floor)) ** 2),
        force_noise=noise[0],
        displacement_noise=noise[1],
        normal_load=float(load.mean()) if isinstance(load, np.ndarray) else load,
        frequency=rate,
        cycles=1,
        left_out=0,
        notes=(*record.notes, *said),
        said=said,
    )
