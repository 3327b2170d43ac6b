"""Stiffness of a contact after a reversal, and the range over which it holds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.tribometer.cuts import Cuts

SHARE = 0.25
"""Share of the range of the force after a reversal, from which its stiffness is read."""
BENT = 0.05
"""Share of the force by which it has left its first tangent where the linear range ends."""
_FEWEST = 5
"""Samples in the window, at least."""


STIFFNESSES = ("reversal_stiffness", "stiffness_left", "stiffness_right")
"""Columns whose mean is that of their inverses."""


class Way(NamedTuple):
    """After one kind of reversal, a value for each cycle; not a number where nothing is told."""

    compliance: Floats
    """First slope of the displacement over the force [m/N]."""
    range: Floats
    """Displacement [m] after which the force is 5 % below the first tangent."""


def way_of(
    x: Floats,
    force: Floats,
    begin: NDArray[np.int64],
    end: NDArray[np.int64],
    span: Floats,
    compliance: float,
) -> Way:
    """Ways from ``begin`` to ``end``, on which displacement and force both rise.

    Noise of the force must not decide which samples count, nor stand on the axis that the slope is
    over, or contacts look stiffer than they are. So the window is where the mean over the cycles
    has gone a quarter of its range, and in it each cycle is freed of noise by the shapes of the
    mean one and a parabola in time; only then is what the rig gives way taken off, ``compliance``
    [m/N].
    """
    nothing = np.full(begin.size, np.nan)
    length = int(np.median(end - begin)) if begin.size else 0
    if length < _FEWEST:
        return Way(nothing, nothing)
    rows = np.clip(begin[:, None] + np.arange(length), 0, x.size - 1)
    moved = x[rows] - x[begin][:, None]
    size = np.median(np.ptp(moved, axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (force[rows] - force[begin][:, None]) / span[:, None]
        scaled = moved * (size / np.ptp(moved, axis=1))[:, None]
    good = np.isfinite(share).all(axis=1) & np.isfinite(scaled).all(axis=1)
    if not good.any() or size == 0.0:
        return Way(nothing, nothing)
    window = _window(share[good].mean(axis=0))
    if window < _FEWEST:
        return Way(nothing, nothing)
    mean_of_both = scaled[good].mean(axis=0)[:window] / size, share[good].mean(axis=0)[:window]
    smooth = _smoother(window, mean_of_both if np.count_nonzero(good) > 2 else ())
    place, gone = (values[:, :window] @ smooth for values in (moved, share))
    place = place - compliance * span[:, None] * gone
    # Over -ln(1 - f) an exponential contact is a straight line, in series with a rig nearly.
    z = -np.log1p(-np.clip(np.where(good[:, None], gone, 0.0), -0.5, 0.9))
    powers = z[:, :, None] ** np.arange(3)
    normal = np.einsum("nwi,nwj->nij", powers, powers)
    right = np.einsum("nwi,nw->ni", powers, np.where(good[:, None], place, 0.0))
    good &= np.linalg.cond(normal) < 1e12
    first, second = nothing.copy(), nothing.copy()
    polynomials = np.linalg.solve(normal[good], right[good][..., None])[..., 0]
    first[good], second[good] = polynomials[:, 1] / span[good], polynomials[:, 2] / span[good]
    with np.errstate(divide="ignore", invalid="ignore"):
        # x = span (a z + b z^2), with z = f + f^2/2 + ...: bent by (1/2 + b/a) f.
        bend = 0.5 + second / first
        linear = first * span * BENT / bend
    return Way(first, np.where((first > 0.0) & (bend > 0.0), linear, np.nan))


def _smoother(window: int, means: tuple[Floats, ...]) -> Floats:
    """Smoothing of the samples of a window: the shapes of the mean way, and a parabola."""
    time = np.arange(window) / window
    shapes = [np.ones(window), *means]
    room = window - 2 - len(shapes)
    shapes += [time, time**2, time**3][: max(0, min(room, 2 if means else 3))]
    if len(shapes) < 3:
        return np.eye(window)
    basis, _ = np.linalg.qr(np.array(shapes).T)
    return np.asarray(basis @ basis.T)


def _window(share: Floats) -> int:
    """Samples until a mean way has gone a quarter of its range; a little smoothed."""
    half = max(0, share.size // 200)
    if half:
        share = np.convolve(np.pad(share, half, mode="edge"), np.ones(2 * half + 1), "valid") / (
            2 * half + 1
        )
    beyond = np.flatnonzero(share > SHARE)
    return int(beyond[0]) if beyond.size else int(share.size)


def stiffness_columns(
    x: Floats, force: Floats, cycles: Cuts, span: Floats, compliance: float
) -> dict[str, Floats]:
    """Stiffness after the highest ("right"), the lowest displacement, both; linear range."""
    right, after_lowest = (
        way_of(sign * x, sign * force, begin, end, span, compliance)
        for sign, begin, end in (
            (-1.0, cycles.peaks, cycles.troughs),
            (1.0, cycles.troughs, np.append(cycles.peaks[1:], cycles.cuts[-1])),
        )
    )
    if cycles.flipped:
        after_lowest, right = right, after_lowest
    linear = np.full(span.size, np.nan)
    is_told = np.isfinite(after_lowest.range) | np.isfinite(right.range)
    linear[is_told] = np.nanmean(np.array([after_lowest.range, right.range])[:, is_told], axis=0)
    return {
        "reversal_stiffness": _inverse(0.5 * (after_lowest.compliance + right.compliance)),
        "stiffness_left": _inverse(after_lowest.compliance),
        "stiffness_right": _inverse(right.compliance),
        "linear_range": linear,
    }


def _inverse(compliance: Floats) -> Floats:
    """Stiffnesses; of a compliance that noise makes negative the same, for their mean's sake."""
    nothing = np.full_like(compliance, np.nan)
    return np.divide(1.0, compliance, out=nothing, where=compliance != 0.0)
