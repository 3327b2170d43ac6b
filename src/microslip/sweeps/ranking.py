"""Contributions to a scatter: shares of the inputs by a linear regression."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats


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
