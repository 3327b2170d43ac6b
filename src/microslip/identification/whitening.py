"""Weights of residuals after elimination of nuisance parameters, by generalised least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats

_SMALL = 0.02  # of the noise: nuisance parameters of smaller effect are not eliminated


@dataclass(frozen=True, eq=False)
class Metric:
    """Whitening of the residuals of a record, with nuisance parameters eliminated."""

    directions: Floats
    shrink: Floats

    def apply(self, rows: Floats) -> Floats:
        """Return whitened residuals or derivatives, given weighted ones of shape (..., bins)."""
        return rows - ((rows @ self.directions) * self.shrink) @ self.directions.T


def metric_of(flat: Floats, uncertain: Floats) -> Metric:
    """Return the whitening of residuals after elimination of nuisance parameters.

    The columns of both arrays, shape (bins, parameters), are the weighted effects of one parameter
    each. The parameters of ``flat`` are free; those of ``uncertain`` have the variance 1.
    """
    basis, _ = np.linalg.qr(flat)
    uncertain = uncertain - basis @ (basis.T @ uncertain)
    square, turned = np.linalg.eigh(uncertain.T @ uncertain)
    matters = square > _SMALL**2
    basis_uncertain = (uncertain @ turned[:, matters]) / np.sqrt(square[matters])
    shrink = 1.0 - 1.0 / np.sqrt(1.0 + square[matters])
    return Metric(
        np.hstack((basis, basis_uncertain)), np.concatenate((np.ones(basis.shape[1]), shrink))
    )
