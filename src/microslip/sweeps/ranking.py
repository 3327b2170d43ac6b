"""What decides a scattered result: shares of the inputs by a linear regression."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats


def ranking(scores: Floats, logs: Floats) -> tuple[Floats, float]:
    """Shares of the inputs in the scatter of a logarithm, from their normal scores (n, inputs).

    And the share of the scatter that the regression explains. What is not finite is left out.
    """
    known = np.isfinite(logs)
    matrix = np.column_stack([np.ones(int(known.sum())), scores[known]])
    wanted = logs[known]
    solved = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
    squares = np.asarray(solved[1:] ** 2, dtype=np.float64)
    whole = float(((wanted - wanted.mean()) ** 2).sum())
    rest = float(((wanted - matrix @ solved) ** 2).sum())
    shares: Floats = np.asarray(squares / (squares.sum() or 1.0), dtype=np.float64)
    return shares, 1.0 - rest / whole if whole > 0.0 else 1.0
