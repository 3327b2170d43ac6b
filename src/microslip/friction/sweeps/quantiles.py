"""Quantiles of results from few samples of the inputs, with confidence intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from microslip._core.checks import Floats

_CONFIDENCE = 0.9
"""Confidence level of the intervals of quantiles."""
_TAIL = 0.5 * (1.0 + _CONFIDENCE)
_GROUPS = 8
_NEAR, _FEWEST_NEAR = 5, 6  # a fifth of the points is near a quantile, at least six
_EXPLAINED = 0.9  # fraction of the variance that cross-validation must explain


def intervals(samples: Floats, shares: Sequence[float]) -> Floats:
    """Return 90 % confidence intervals of quantiles of ``samples`` from order statistics.

    ``samples`` has shape (groups, points per group, ...), and ``shares`` are the probabilities of
    the quantiles. The result, shape (2, shares, ...), holds the lower and upper ends. Groups are
    independent scramblings of quasi-random points. The fraction of samples below a quantile differs
    between groups; its standard deviation and Student's t distribution give the half-width r of an
    interval of the mean fraction. The ends for the probability p are the samples of ranks n (p - r)
    and n (p + r) among all n samples; an end is infinite if there is no such sample. The estimates
    of the groups are unbiased and independent whatever the dependence within a group (L'Ecuyer and
    Lemieux 2002, DOI 10.1007/0-306-48102-2_20).

    The samples of a single group are treated as independent, so that the number below the quantile
    is binomial; this is conservative for quasi-random points.
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

            low, high = binom.ppf([1.0 - _TAIL, _TAIL], count, share)
            first = np.full(ordered.shape[1], math.floor(low))
            last = np.full(ordered.shape[1], math.ceil(high + 1.0))
        for end, rank, beyond in ((0, first, -math.inf), (1, last, math.inf)):
            inside = (rank >= 1) & (rank <= count)
            at = ordered[np.clip(rank, 1, count) - 1, np.arange(ordered.shape[1])]
            ends[end, place] = np.where(np.isnan(ordered[-1]), np.nan, np.where(inside, at, beyond))
    return ends.reshape(2, len(shares), *rest)


def quantiles(
    scores: Floats,
    values: Floats,
    dense: Floats,
    shares: Sequence[float],
    added: tuple[Floats, Floats] | None = None,
    of: Callable[[Floats, Floats], Floats] | None = None,
) -> tuple[Floats, Floats]:
    """Return quantiles of each column of values and the half-widths of their 90 % intervals.

    ``scores`` (points, inputs) are the normal scores of the inputs at which ``values`` (points,
    columns) are known, NaN where a value is missing. ``shares`` are the probabilities of the
    quantiles; both results have the shape (shares, columns). ``dense`` are many more normal scores:
    the rows of eight groups in succession, each an independent scrambling of quasi-random points.

    If interpolation explains 90 % of the variance of a column in cross-validation, its quantiles
    are those of a cubic interpolation at ``dense``: for a smooth function of a few inputs 32 points
    give them within 1 %, but their order statistics only within 10 %. The half-width then combines
    that of the quantiles of ``dense`` with the cross-validation residuals near the quantile (mean
    and standard error). Otherwise, for example if a column jumps between two branches, the
    quantiles are those of the points, with intervals from order statistics, infinite for too few
    points.

    ``added`` is a second quantity, known everywhere: (its values at ``scores``, those at
    ``dense``), both one-dimensional. If it is given, ``values`` must be logarithms, and the
    quantiles are those of log(exp(values) + added). If a function ``of`` is given too, the
    quantiles are those of the columns of ``of(values, added)`` instead, with the values of both
    quantities at the same points; ``values`` must then be finite.
    """
    if of is not None:
        return _column_quantiles(scores, values, dense, shares, added, of)
    middles, errors = np.full((2, len(shares), values.shape[1]), np.nan)
    finite = np.isfinite(values)
    patterns = np.unique(finite, axis=1).T
    for pattern in patterns:
        columns = np.flatnonzero((finite == pattern[:, None]).all(axis=0))
        if pattern.any():
            known = None if added is None else (added[0][pattern], added[1])
            estimate = _column_quantiles(
                scores[pattern], values[pattern][:, columns], dense, shares, known
            )
            middles[:, columns], errors[:, columns] = estimate
    return middles, errors


def _column_quantiles(
    scores: Floats,
    values: Floats,
    dense: Floats,
    shares: Sequence[float],
    added: tuple[Floats, Floats] | None,
    derived: Callable[[Floats, Floats], Floats] | None = None,
) -> tuple[Floats, Floats]:
    count = len(values)
    smooth, residual = np.zeros(values.shape[1], dtype=bool), np.zeros_like(values)
    if count >= 2 * (scores.shape[1] + 1) + _GROUPS:
        group = np.arange(count) * _GROUPS // count  # consecutive points fill the cube
        for fold in (group != g for g in range(_GROUPS)):
            residual[~fold] = values[~fold] - _interpolated(
                scores[fold], values[fold], scores[~fold]
            )
        squares = np.array([residual**2, (values - values.mean(axis=0)) ** 2]).sum(axis=1)
        if derived is not None:  # which needs all columns by one method
            squares = np.repeat(squares.sum(axis=1, keepdims=True), values.shape[1], axis=1)
        rounding = 1e-24 * count  # for equal logarithms
        smooth = squares[0] <= (1.0 - _EXPLAINED) * squares[1] + rounding

    def of(points: Floats, at_all: bool = False) -> Floats:
        if added is None:
            return points
        other = added[1] if at_all else added[0]
        if derived is not None:
            return derived(points, other)
        return np.asarray(np.log(np.exp(points) + other[:, None]))

    def estimate(columns: Any, interpolate: bool) -> tuple[Floats, Floats]:
        known = values[:, columns]
        points = of(_interpolated(scores, known, dense), True) if interpolate else of(known)
        middle = np.quantile(points, shares, axis=0)
        blocks = points[: len(points) // _GROUPS * _GROUPS].reshape(_GROUPS, -1, points.shape[1])
        ends = intervals(blocks if interpolate else points[None], shares)
        half = np.maximum(middle - ends[0], ends[1] - middle)
        if interpolate:
            misses = of(known) - of(known - residual[:, columns])
            half = np.hypot(_residual_near(of(known), misses, middle), half)
        return middle, half

    if smooth.all() or not smooth.any():
        return estimate(slice(None), bool(smooth.all()))
    result = np.empty((2, len(shares), values.shape[1]))
    for chosen in (True, False):
        result[:, :, smooth == chosen] = estimate(smooth == chosen, chosen)
    return result[0], result[1]


def _residual_near(values: Floats, misses: Floats, middle: Floats) -> Floats:
    """Return the cross-validation residual near each quantile, shape (shares, columns).

    For each quantile in ``middle`` it is sqrt(m^2 + s^2), with the mean m and the standard error s
    of the residuals ``misses`` of the 20 % of ``values`` nearest to the quantile.
    """
    count = max(_FEWEST_NEAR, len(values) // _NEAR)
    order = np.argsort(abs(values[None] - middle[:, None]), axis=1)[:, :count]
    near = np.take_along_axis(np.broadcast_to(misses, (len(middle), *misses.shape)), order, axis=1)
    return np.asarray(np.sqrt(near.mean(axis=1) ** 2 + near.var(axis=1, ddof=1) / count))


def _interpolated(scores: Floats, values: Floats, places: Floats) -> Floats:
    from scipy.interpolate import RBFInterpolator

    return np.asarray(RBFInterpolator(scores, values, kernel="cubic")(places))


def regression(scores: Floats, logs: Floats) -> tuple[Floats, Floats, float]:
    """Fit ``logs``, logarithms of a result, linearly on the normal scores, shape (samples, inputs).

    Return the slopes, their squares over the sum of these (the fraction of the variance due to each
    input), and the fraction of the variance that the fit explains [-]. Values that are not finite
    are ignored; the slopes are zero if no more than one value for each input is left.
    """
    finite, inputs = np.isfinite(logs), scores.shape[1]
    if finite.sum() <= inputs:
        return np.zeros(inputs), np.zeros(inputs), 1.0
    matrix = np.column_stack([np.ones(int(finite.sum())), scores[finite]])
    target = logs[finite]
    solved: Floats = np.linalg.lstsq(matrix, target, rcond=None)[0].astype(np.float64)
    squares = solved[1:] ** 2
    scatter = float(((target - target.mean()) ** 2).sum())
    residual = float(((target - matrix @ solved) ** 2).sum())
    explained = 1.0 - residual / scatter if scatter > 0.0 else 1.0
    return solved[1:], squares / (squares.sum() or 1.0), explained
