"""Delay of the force of a record behind its displacement: a lag, or a filter."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.tribometer.cuts import Cuts
from microslip.tribometer.estimates import quantile

_COARSE, _FINE = 31, 21
"""Shifts that are tried, and those around the best of them."""
_SHAPES = (((1.0, 1.5, 2.0), (1.0, 2.0)), ((1.0, 2.0), (1.0, 2.0)))
"""Powers of the way that the force is made of before a reversal and after it. A contact that has
nearly slid before is of the power 3/2 there (19.15); what the second makes of it is the doubt."""
_DOUBT, _LEAST, _OF_WINDOW = 0.5, 0.03, 0.003
"""Doubt of the lag in any case: share of the difference of both readings, of a sample, and of the
window."""
_DEGREE = 10
"""Degree of the polynomial of the displacement within a fifth of a cycle from its reversal."""


class Lag(NamedTuple):
    """Lag of the force [samples], positive where it is late."""

    value: float
    half: float
    """Half its interval."""
    error: float
    number: int
    """Groups of cycles that it is the mean of."""


class _Reversals(NamedTuple):
    """Samples around the reversals of some cycles: a row each, troughs turned around."""

    force: Floats
    way: Floats
    reach: int
    """Samples on each side."""
    half: int
    """Samples that count: until a quarter of the force is gone."""

    def shift(self, rows: slice, shapes: int = 0, near: float | None = None) -> float:
        """Lag [samples] in the mean of some of the cycles."""
        return _shift(
            self.force[rows], self.way[rows], self.reach, self.half, _SHAPES[shapes], near
        )


def _reversals(x: Floats, force: Floats, cuts: Cuts, most: int) -> _Reversals:
    reach = int(cuts.period / 5.0)
    inside = np.flatnonzero((cuts.peaks >= reach) & (cuts.troughs < force.size - reach))
    inside = inside[:most] if most else inside
    if inside.size < 2:
        raise InputError("delay_of needs at least two cycles away from the ends of the record")
    steps = np.arange(-reach, reach + 1)
    sign = -0.5 if cuts.flipped else 0.5
    forces, ways = (
        sign * (values[cuts.peaks[inside][:, None] + steps] - values[ends[:, None] + steps])
        for values, ends in ((force, cuts.troughs[inside]), (x, cuts.troughs[inside]))
    )
    profile = forces.mean(axis=0)
    spread = float(np.ptp(profile)) * 2.0
    fallen = np.flatnonzero(profile[reach:] < profile.max() - 0.125 * spread)
    half = min(int(fallen[0]) if fallen.size else reach, (2 * reach) // 3)
    if half < 4:
        raise InputError(
            f"delay_of needs at least 4 samples in the first quarter of the force after a "
            f"reversal, got {half}; sample faster"
        )
    return _Reversals(forces, ways, reach, half)


def lag_of(
    x: Floats, force: Floats, cuts: Cuts, confidence: float, groups: int = 10, most: int = 0
) -> Lag:
    """The lag in a block of cycles, of the first ``most`` of them if that is above zero."""
    reversals = _reversals(x, force, cuts, most)
    size = reversals.force.shape[0]
    middle = reversals.shift(slice(None))
    edges = np.linspace(0, size, min(groups, size) + 1).astype(int)
    late = np.array([reversals.shift(slice(a, b), 0, middle) for a, b in pairwise(edges)])
    other = reversals.shift(slice(None), 1, middle)
    error = float(late.std(ddof=1)) / math.sqrt(late.size)
    chance = quantile(confidence, late.size - 1) * error
    doubt = _LEAST + _OF_WINDOW * reversals.half + _DOUBT * abs(middle - other)
    return Lag(float(late.mean()), math.hypot(chance, doubt), error, late.size)


def looks_late(x: Floats, force: Floats, cuts: Cuts, smallest: float, most: int) -> bool:
    """Whether a first look finds the force late or early by more than that [samples]."""
    try:
        return abs(_reversals(x, force, cuts, most).shift(slice(None))) > smallest
    except InputError:  # too few cycles or samples to tell
        return False


def _shift(
    forces: Floats,
    ways: Floats,
    reach: int,
    half: int,
    powers: tuple[tuple[float, ...], tuple[float, ...]],
    near: float | None = None,
) -> float:
    """Shift with which the way, on both sides with factors of its own, fits the mean force best."""
    force = forces.mean(axis=0)[reach - half : reach + half + 1]
    # Free of noise: as the way stands on the axis, noise there would look like a kink.
    grid = np.arange(-reach, reach + 1.0) / reach
    way = np.polyfit(grid, ways.mean(axis=0), min(_DEGREE, reach))
    t = np.arange(-half, half + 1.0)
    close = np.polyval(way, np.linspace(-0.3, 0.3, 601))
    top, size = float(close.max()), max(float(np.ptp(np.polyval(way, t / reach))), 1e-300)

    def misfits(places: Floats) -> Floats:
        away = t - places[:, None]
        moved = np.maximum(top - np.polyval(way, away / reach), 0.0) / size
        before, after = np.where(away < 0.0, moved, 0.0), np.where(away >= 0.0, moved, 0.0)
        columns = [before**power for power in powers[0]] + [after**power for power in powers[1]]
        basis = np.linalg.qr(np.stack([np.ones_like(away), *columns], axis=2))[0]
        residual = force - np.einsum("pni,pi->pn", basis, np.einsum("pni,n->pi", basis, force))
        return np.asarray(np.einsum("pn,pn->p", residual, residual))

    step = half / (_COARSE - 1.0)
    if near is None:
        places = np.linspace(-0.5 * half, 0.5 * half, _COARSE)
        near = float(places[int(misfits(places).argmin())])
    places = near + step * np.linspace(-3.0, 3.0, _FINE)
    values = misfits(places)
    best = int(np.clip(values.argmin(), 2, _FINE - 3))
    # A parabola through some: a single misfit is rough where a sample passes the reversal.
    rows = slice(max(best - 4, 0), best + 5)
    bend, slope, _ = np.polyfit(places[rows] - places[best], values[rows], 2)
    shift = -0.5 * slope / bend if bend > 0.0 else 0.0
    return float(places[best] + np.clip(shift, -2.0 * step, 2.0 * step))
