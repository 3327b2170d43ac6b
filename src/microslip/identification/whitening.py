"""Weights of residuals after elimination of nuisance parameters, by generalised least squares."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats

_SMALL = 0.02  # of the noise: nuisance parameters of smaller effect are not eliminated


def directions_of(flat: Floats, uncertain: Floats) -> tuple[Floats, Floats]:
    """Return directions D (bins, directions) and shares s (directions,).

    With them a row r of values over their noise (bins,) becomes r - (r D) s D', in which the
    nuisance parameters are eliminated. The columns of ``flat`` and ``uncertain`` (bins, parameters)
    are the effects over the noise of one parameter each. The parameters of ``flat`` are unknown;
    those of ``uncertain`` are known to be zero with a standard error of 1.
    """
    basis, _ = np.linalg.qr(flat)
    uncertain = uncertain - basis @ (basis.T @ uncertain)
    square, turned = np.linalg.eigh(uncertain.T @ uncertain)
    matters = square > _SMALL**2
    further = (uncertain @ turned[:, matters]) / np.sqrt(square[matters])
    shrink = 1.0 - 1.0 / np.sqrt(1.0 + square[matters])
    return np.hstack((basis, further)), np.append(np.ones(basis.shape[1]), shrink)
