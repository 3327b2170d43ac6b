"""Approximation of functions by Chebyshev series on panels, halved until the fit is accurate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev as cheb

from microslip._core.checks import Floats

_DEGREE = 15
_TOLERANCE = 3e-12  # of the largest value on a panel
_RATIO = 1e-4  # a panel over which a function falls further is split: relative accuracy in the tail
_MAX_HALVINGS = 48  # halvings of a first panel
_NOISE = 1e-10  # accepted scatter of a density, relative to its largest value on a panel
PANELS = 600
"""Default limit of the number of panels: noisy densities are not refined beyond it."""

_ANGLES = math.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1)
_POINTS = np.cos(_ANGLES)
_TRANSFORM = 2.0 / (_DEGREE + 1) * np.cos(np.outer(np.arange(_DEGREE + 1), _ANGLES))
_TRANSFORM[0] *= 0.5


@dataclass(frozen=True)
class PanelFit:
    """Piecewise polynomial: Chebyshev series on panels between ``edges``, in increasing order."""

    edges: Floats
    coefficients: Floats  # (terms, panels)

    def __call__(self, t: Floats) -> Floats:
        """Return the values of the piecewise polynomial at arguments ``t`` of any shape."""
        panel = np.clip(np.searchsorted(self.edges, t, side="right") - 1, 0, self.edges.size - 2)
        low, high = self.edges[panel], self.edges[panel + 1]
        s = ((t - low) - (high - t)) / (high - low)
        b1, b2 = np.zeros_like(t), np.zeros_like(t)
        for c in self.coefficients[:0:-1]:
            b1, b2 = 2.0 * s * b1 - b2 + c[panel], b1
        return np.asarray(s * b1 - b2 + self.coefficients[0][panel])

    def tail(self, factor: float) -> PanelFit:
        """Return ``factor`` times the integral from t to the last edge, as a function of t."""
        half = 0.5 * np.diff(self.edges)
        inner = cheb.chebint(self.coefficients, axis=0) * half
        total = inner.sum(axis=0)  # at s = 1
        areas = total - cheb.chebval(-1.0, inner)
        after = np.append(np.cumsum(areas[::-1])[::-1][1:], 0.0)
        inner = -inner
        inner[0] += total + after
        return PanelFit(self.edges, factor * inner)


def resolve(function: Callable[[Floats], Floats], edges: Floats, limit: int = PANELS) -> PanelFit:
    """Approximate a function on panels between ``edges``, halved to at most ``limit`` panels."""
    pending = np.column_stack((edges[:-1], edges[1:]))
    panels: list[tuple[float, float, Floats]] = []
    before = np.full(len(pending), np.inf)
    for depth in range(_MAX_HALVINGS + 1):
        low, high = pending[:, :1], pending[:, 1:]
        values = function(0.5 * (low + high) + 0.5 * (high - low) * _POINTS)
        c = values @ _TRANSFORM.T
        size = np.abs(values).max(axis=1)
        # Rounding errors of the arguments limit the accuracy on narrow panels far from zero.
        noise = 4e-16 * np.maximum(np.abs(low), np.abs(high)) / (high - low)
        omitted = np.abs(c[:, -3:]).max(axis=1) / np.where(size > 0.0, size, 1.0)
        rough = omitted > _TOLERANCE + noise[:, 0]
        # A small residual that halving has not reduced is noise of the function itself.
        rough &= (omitted > _NOISE) | (omitted < 0.3 * before)
        steep = np.abs(values).min(axis=1) < _RATIO * size
        split = (rough | steep) & ((high - low) > 1e-15 * np.abs(low))[:, 0]
        if depth == _MAX_HALVINGS or len(panels) + 2 * len(pending) > limit:
            split[:] = False
        panels += [(*pair, row) for pair, row in zip(pending[~split], c[~split], strict=True)]
        before = np.concatenate((omitted[split], omitted[split]))
        low, high = pending[split, 0], pending[split, 1]
        middle = 0.5 * (low + high)
        pending = np.concatenate((np.column_stack((low, middle)), np.column_stack((middle, high))))
        if not len(pending):
            break
    panels.sort(key=lambda item: item[0])
    return PanelFit(
        np.array([item[0] for item in panels] + [panels[-1][1]]),
        np.ascontiguousarray(np.array([item[2] for item in panels]).T),
    )
