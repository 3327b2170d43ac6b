"""Lag of the force behind the displacement of a record: its removal, and its estimate."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, exact, number, show
from microslip._core.errors import InputError
from microslip.laboratory.blocks import gaps_of
from microslip.laboratory.cuts import Cuts, noise_of
from microslip.laboratory.estimates import quantile
from microslip.laboratory.record import Record


def condition(record: Record, *, delay: float) -> Record:
    """Return a copy of a record without a delay of its force, with a note on the change.

    Parameters
    ----------
    record : Record
        Record to correct, without gaps in its time.
    delay : float
        Time [s] by which the force lags behind the displacement, as stated by a note of `measure`.

    Returns
    -------
    Record
        The samples for which a shifted force exists; the force is interpolated linearly.
    """
    if not isinstance(record, Record):
        raise InputError(f"`record` must be a Record, got {show(record)}")
    delay = number("delay", delay, "s", 1e-4)
    time = record.seconds
    if time is None:
        raise InputError("delay needs a record with time or sample_rate")
    if (gaps := gaps_of(record)).size:
        raise InputError(
            f"{record.name}: the time has a gap after {exact(time[gaps[0]])} s, and no delay can "
            "be removed across it; take the samples of one block"
        )
    if abs(delay) > 0.25 * float(time[-1] - time[0]):
        raise InputError(f"`delay` must be less than a quarter of the record, got {delay:g} s")
    has_force = (time + delay >= time[0]) & (time + delay <= time[-1])
    force = np.interp(time[has_force] + delay, time, record.force)
    note = f"the force was shifted forward by {delay:.6g} s"
    return record._taken(has_force, force=force, notes=(*record.notes, note))


# -- the lag of the force ------------------------------------------------------------------------

_COARSE, _FINE = 31, 21
"""Number of shifts tried first, and around the best of them."""
_SHAPES = (((1.0, 1.5, 2.0), (1.0, 2.0)), ((1.0, 2.0), (1.0, 2.0)))
"""Powers of the distance to the reversal in the force before and after it. The power 3/2 belongs to
a contact near gross slip (19.15); the second set gives the systematic error."""
_DOUBT, _LEAST, _OF_WINDOW = 0.5, 0.06, 0.003
"""Systematic error of the lag: fraction of the difference of both sets of powers, samples, and
fraction of the window."""
_GROUPS = 10
_DEGREE = 10
"""Degree of the polynomial of the displacement within a fifth of a cycle from its reversal."""


class Lag(NamedTuple):
    """Lag of the force behind the displacement [samples]; negative if the force leads."""

    value: float
    half: float
    """Half-width of the confidence interval of the lag [samples]; infinite if it is not known."""
    misfit_left: float
    """Sum of squared residuals at the reversals with the lag, over that without it [-]."""


def lag_of(
    x: Floats,
    force: Floats,
    cuts: Cuts,
    confidence: float,
    most: int | None = None,
    smallest: float = 0.0,
) -> Lag | None:
    """Estimate the lag of the force in a block of cycles, or in its first ``most`` cycles.

    The interval follows from the scatter between groups of successive cycles. None if there are too
    few cycles or samples, or if the lag is not above ``smallest`` [samples].
    """
    reach = int(cuts.period / 5.0)
    inside = np.flatnonzero((cuts.peaks >= reach) & (cuts.troughs < force.size - reach))[:most]
    if inside.size < 2:
        return None
    steps = np.arange(-reach, reach + 1)
    sign = -0.5 if cuts.flipped else 0.5
    # Half the differences of samples around a peak and around the next trough (cycles, samples).
    tops, bottoms = (turns[inside][:, None] + steps for turns in (cuts.peaks, cuts.troughs))
    forces, ways = (sign * (values[tops] - values[bottoms]) for values in (force, x))
    profile = forces.mean(axis=0)
    fallen = np.flatnonzero(profile[reach:] < profile.max() - 0.25 * float(np.ptp(profile)))
    # Samples within a quarter of the force range after a reversal.
    half = min(int(fallen[0]) if fallen.size else reach, (2 * reach) // 3)
    if half < 4:
        return None

    middle, best, at_zero = _shift(forces, ways, half, _SHAPES[0])
    if not abs(middle) > smallest:
        return None
    edges = np.linspace(0, inside.size, min(_GROUPS, inside.size) + 1).astype(int)
    late = np.array(
        [_shift(forces[a:b], ways[a:b], half, _SHAPES[0], middle)[0] for a, b in pairwise(edges)]
    )
    other = _shift(forces, ways, half, _SHAPES[1], middle)[0]
    chance = quantile(confidence, late.size - 1) * float(late.std(ddof=1)) / math.sqrt(late.size)
    doubt = _LEAST + _OF_WINDOW * half + _DOUBT * abs(middle - other)
    # Lags of groups are sought near that of all of them: beyond that range they are not known.
    is_found = float(np.abs(late - middle).max()) < 2.4 * half / (_COARSE - 1.0)
    noise = noise_of(forces.ravel()) ** 2 / inside.size * (2 * half + 1)
    left = max(best - noise, 0.0) / max(at_zero - noise, 1e-300)
    return Lag(float(late.mean()), math.hypot(chance, doubt) if is_found else math.inf, left)


def _shift(
    forces: Floats,
    ways: Floats,
    half: int,
    powers: tuple[tuple[float, ...], tuple[float, ...]],
    near: float | None = None,
) -> tuple[float, float, float]:
    """Fit the lag of the force around a reversal, with powers of the displacement on each side.

    Rows of ``forces`` [N] and ``ways`` [m] are cycles, with the reversal in the middle; forces
    within ``half`` samples of it are fitted; ``near`` is a first estimate of the lag.
    Return the lag [samples] and the sums of squares with and without it [N^2].
    """
    reach = ways.shape[1] // 2
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
    found = float(places[best] + np.clip(shift, -2.0 * step, 2.0 * step))
    left = misfits(np.array([found, 0.0]))
    return found, float(left[0]), float(left[1])
