"""Quantiles of what is known at few points of its inputs, and how sure they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microslip._core.checks import Floats

_GROUPS = 8
_TELLING = 0.9  # share of the scatter that points left out must follow from the others


def quantiles(
    scores: Floats,
    values: Floats,
    dense: Floats,
    shares: Sequence[float],
    added: tuple[Floats, Floats] | None = None,
) -> tuple[Floats, Floats]:
    """Quantiles of each column of values, and their standard errors by the jackknife.

    ``scores`` (n, inputs) are the normal scores of the inputs at which ``values`` (n, columns) are
    known, not a number where they are not; ``dense`` are many more. Where what is left out follows
    from the rest, quantiles are those of a cubic interpolation at all of ``dense``: a smooth
    function of a few inputs has them within 1 % from 32 points, whose own order tells them within
    10 %. Elsewhere they are those of the points. The error is that of eight times seven eighths of
    the points (Efron and Tibshirani 1993, DOI 10.1201/9780429246593). Where there is something
    ``added``, known at the scores and at all of ``dense``, the values are logarithms of what it is
    added to, and quantiles are those of the logarithm of the sum.
    """
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
) -> tuple[Floats, Floats]:
    count = len(values)
    group = np.arange(count) % _GROUPS
    folds = [group != g for g in range(min(_GROUPS, count))] if count > 1 else []
    smooth = False
    if count >= 2 * (scores.shape[1] + 1) + _GROUPS:
        residual = np.zeros_like(values)
        for fold in folds:
            residual[~fold] = values[~fold] - _interpolated(
                scores[fold], values[fold], scores[~fold]
            )
        scatter = ((values - values.mean(axis=0)) ** 2).sum()
        rounding = 1e-24 * residual.size  # of logarithms that are all the same
        smooth = bool((residual**2).sum() <= (1.0 - _TELLING) * scatter + rounding)

    def of(fold: Floats | slice) -> Floats:
        points = _interpolated(scores[fold], values[fold], dense) if smooth else values[fold]
        if added is not None:
            points = np.log(np.exp(points) + (added[1] if smooth else added[0][fold])[:, None])
        return np.quantile(points, shares, axis=0)

    parts = np.array([of(fold) for fold in folds])
    middle = of(slice(None))
    if not len(parts):
        return middle, np.full_like(middle, np.nan)
    spread = ((parts - parts.mean(axis=0)) ** 2).sum(axis=0)
    return middle, np.sqrt((len(parts) - 1.0) / len(parts) * spread)


def _interpolated(scores: Floats, values: Floats, places: Floats) -> Floats:
    from scipy.interpolate import RBFInterpolator

    return np.asarray(RBFInterpolator(scores, values, kernel="cubic")(places))
