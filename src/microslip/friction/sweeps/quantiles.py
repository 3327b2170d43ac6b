"""Quantiles from few points of the inputs, and their sampling error."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from microslip._core.checks import Floats

CONFIDENCE = 0.9
"""Confidence level of all intervals of quantiles."""
_TAIL = 0.5 * (1.0 + CONFIDENCE)
_GROUPS = 8
_NEAR, _FEWEST_NEAR = 5, 6  # one of how many points is near a quantile, and how many are at least
_TELLING = 0.9  # share of the scatter that points left out must follow from the others


def intervals(samples: Floats, shares: Sequence[float], draws: int | None = None) -> Floats:
    """Intervals of quantiles of ``samples`` (groups, points of each, ...), from order statistics.

    Gives low and high ends (2, shares, ...) that hold the quantiles of what is sampled with a
    confidence of 90 %: the share below the quantile scatters between the groups, each a scrambling
    of its own, and Student's t over them says between which samples in their order the quantile
    lies. Infinite where that is beyond all samples: there are too few. Groups of quasi-random
    points are unbiased and independent of each other, whatever happens within them (L'Ecuyer and
    Lemieux 2002, DOI 10.1007/0-306-48102-2_20). One group is taken for independent draws, whose
    count below a quantile is binomial: too wide, never too narrow, for quasi-random ones. Where
    several points belong to each draw, ``draws`` says how many of these there are.
    """
    from scipy.special import stdtrit

    groups, count = samples.shape[0], samples.shape[0] * samples.shape[1]
    rest = samples.shape[2:]
    ordered = np.sort(samples.reshape(count, -1), axis=0)
    ends = np.full((2, len(shares), ordered.shape[1]), np.nan)
    for place, share in enumerate(shares):
        if groups > 1:
            middle = np.quantile(ordered, share, axis=0)
            below = (samples.reshape(groups, -1, ordered.shape[1]) <= middle).mean(axis=1)
            reach = stdtrit(groups - 1, _TAIL) * below.std(axis=0, ddof=1) / math.sqrt(groups)
            first = np.floor(count * (share - reach)).astype(int)
            last = np.ceil(count * (share + reach)).astype(int) + 1
        else:
            from scipy.stats import binom

            of_draw, low = count / (draws or count), binom.ppf(1.0 - _TAIL, draws or count, share)
            high = binom.ppf(_TAIL, draws or count, share) + 1.0
            first = np.full(ordered.shape[1], math.floor(low * of_draw))
            last = np.full(ordered.shape[1], math.ceil(high * of_draw))
        for end, rank, beyond in ((0, first, -math.inf), (1, last, math.inf)):
            inside = (rank >= 1) & (rank <= count)
            at = ordered[np.clip(rank, 1, count) - 1, np.arange(ordered.shape[1])]
            ends[end, place] = np.where(np.isnan(ordered[-1]), np.nan, np.where(inside, at, beyond))
    return ends.reshape(2, len(shares), *rest)


def samples_for(count: int, error: float, target: float) -> int:
    """Samples that bring an error of ``count`` of them to a target, at most.

    Errors of independent draws halve for four times as many, of quasi-random points sooner.
    """
    return math.ceil(count * max(error / target, 1.0) ** 2)


def quantiles(
    scores: Floats,
    values: Floats,
    dense: Floats,
    shares: Sequence[float],
    added: tuple[Floats, Floats] | None = None,
    of: Callable[[Floats, Floats], Floats] | None = None,
) -> tuple[Floats, Floats]:
    """Quantiles of each column of values, and the half-widths of their 90 % intervals.

    ``scores`` (n, inputs) are the normal scores of the inputs at which ``values`` (n, columns) are
    known, not a number where they are not; ``dense`` are many more, in eight groups one after the
    other, each a scrambling of its own. Where what is left out follows from the rest, quantiles are
    those of a cubic interpolation at all of ``dense``: a smooth function of a few inputs has them
    within 1 % from 32 points, whose own order tells them within 10 %. Their error is that of the
    quantiles of ``dense``, and what the interpolation misses of left-out points near the quantile:
    the mean of it, which moves the quantile, and its standard error. Elsewhere quantiles are those
    of the points, their intervals of order statistics, infinite where there are too few. Where
    there is something ``added``, known at the scores and at all of ``dense``, the values are
    logarithms of what it is added to, and quantiles are those of the logarithm of the sum, or of
    the columns that a function ``of`` makes of both, all of them finite.
    """
    if of is not None:
        return _of_columns(scores, values, dense, shares, added, of)
    middles, errors = np.full((2, len(shares), values.shape[1]), np.nan)
    finite = np.isfinite(values)
    patterns = np.unique(finite, axis=1).T
    for pattern in patterns:
        columns = np.flatnonzero((finite == pattern[:, None]).all(axis=0))
        if pattern.any():
            known = None if added is None else (added[0][pattern], added[1])
            estimate = _of_columns(
                scores[pattern], values[pattern][:, columns], dense, shares, known
            )
            middles[:, columns], errors[:, columns] = estimate
    return middles, errors


def _of_columns(
    scores: Floats,
    values: Floats,
    dense: Floats,
    shares: Sequence[float],
    added: tuple[Floats, Floats] | None,
    derived: Callable[[Floats, Floats], Floats] | None = None,
) -> tuple[Floats, Floats]:
    count = len(values)
    smooth, residual = False, np.zeros_like(values)
    if count >= 2 * (scores.shape[1] + 1) + _GROUPS:
        group = np.arange(count) * _GROUPS // count  # points in a row fill the cube
        for fold in (group != g for g in range(_GROUPS)):
            residual[~fold] = values[~fold] - _interpolated(
                scores[fold], values[fold], scores[~fold]
            )
        scatter = ((values - values.mean(axis=0)) ** 2).sum()
        rounding = 1e-24 * residual.size  # of logarithms that are all the same
        smooth = bool((residual**2).sum() <= (1.0 - _TELLING) * scatter + rounding)

    def of(points: Floats, at_all: bool = False) -> Floats:
        if added is None:
            return points
        other = added[1] if at_all else added[0]
        if derived is not None:
            return derived(points, other)
        return np.asarray(np.log(np.exp(points) + other[:, None]))

    points = of(_interpolated(scores, values, dense), True) if smooth else of(values)
    middle = np.quantile(points, shares, axis=0)
    blocks = points[: len(points) // _GROUPS * _GROUPS].reshape(_GROUPS, -1, points.shape[1])
    ends = intervals(blocks if smooth else points[None], shares)
    half = np.maximum(middle - ends[0], ends[1] - middle)
    if smooth:
        known = of(values)
        half = np.hypot(_missed_near(known, known - of(values - residual), middle), half)
    return middle, half


def _missed_near(values: Floats, misses: Floats, middle: Floats) -> Floats:
    """Mean of what is missed of the values nearest to each quantile, with its standard error."""
    count = max(_FEWEST_NEAR, len(values) // _NEAR)
    order = np.argsort(abs(values[None] - middle[:, None]), axis=1)[:, :count]
    near = np.take_along_axis(np.broadcast_to(misses, (len(middle), *misses.shape)), order, axis=1)
    return np.asarray(np.sqrt(near.mean(axis=1) ** 2 + near.var(axis=1, ddof=1) / count))


def _interpolated(scores: Floats, values: Floats, places: Floats) -> Floats:
    from scipy.interpolate import RBFInterpolator

    return np.asarray(RBFInterpolator(scores, values, kernel="cubic")(places))


def ranking(scores: Floats, logs: Floats) -> tuple[Floats, float]:
    """Shares of the inputs in the scatter of a logarithm, from their normal scores (n, inputs).

    And the share of the scatter that the regression explains. What is not finite is left out.
    """
    finite = np.isfinite(logs)
    matrix = np.column_stack([np.ones(int(finite.sum())), scores[finite]])
    target = logs[finite]
    solved = np.linalg.lstsq(matrix, target, rcond=None)[0]
    squares = np.asarray(solved[1:] ** 2, dtype=np.float64)
    scatter = float(((target - target.mean()) ** 2).sum())
    residual = float(((target - matrix @ solved) ** 2).sum())
    shares: Floats = np.asarray(squares / (squares.sum() or 1.0), dtype=np.float64)
    return shares, 1.0 - residual / scatter if scatter > 0.0 else 1.0
