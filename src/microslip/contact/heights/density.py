"""Partial moments of summit heights with an arbitrary density, tabulated once."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev as cheb
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.quadrature import gauss_legendre
from microslip.contact.heights.base import HeightDistribution

_DEGREE = 15
_TOLERANCE = 3e-12  # of the largest value on a panel
_RATIO = 1e-4  # a panel over which a function falls further is split: relative accuracy in the tail
_MAX_HALVINGS = 48  # halvings of a first panel
_NOISE = 1e-10  # of the largest value: what a density may scatter by
_MIN_WIDTH = 1e-7  # of the spread: closer breaks of a root of N'' matter to no integral
_PANELS = 600  # panels; a density as noisy as that is taken as it is

_FEW_THRESHOLDS = 200  # thresholds

_ANGLES = math.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1)
_POINTS = np.cos(_ANGLES)
_TRANSFORM = 2.0 / (_DEGREE + 1) * np.cos(np.outer(np.arange(_DEGREE + 1), _ANGLES))
_TRANSFORM[0] *= 0.5
NODES, _WEIGHTS = gauss_legendre(20)
# From so many widths away a panel is so many charges, see `_panel_masses`.
_LEVELS = ((60.0, 6), (4.0, 11), (0.125, 20))


@dataclass(frozen=True)
class PanelFit:
    """PanelFit polynomial: Chebyshev series on panels between ``edges``, in increasing order."""

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


def _lagrange(nodes: Floats, x: Floats) -> Floats:
    """Return the Lagrange polynomials of ``nodes`` at ``x``, shape (x, nodes)."""
    masks = ~np.eye(nodes.size, dtype=bool)
    columns = [
        np.prod((x[:, None] - nodes[o]) / (n - nodes[o]), axis=1)
        for n, o in zip(nodes, masks, strict=True)
    ]
    return np.stack(columns, axis=1)


def _resolve(function: Callable[[Floats], Floats], edges: Floats, limit: int = _PANELS) -> PanelFit:
    """Approximate a function on panels between ``edges``, halved to at most ``limit`` panels."""
    pending = np.column_stack((edges[:-1], edges[1:]))
    panels: list[tuple[float, float, Floats]] = []
    before = np.full(len(pending), np.inf)
    for depth in range(_MAX_HALVINGS + 1):
        low, high = pending[:, :1], pending[:, 1:]
        values = function(0.5 * (low + high) + 0.5 * (high - low) * _POINTS)
        c = values @ _TRANSFORM.T
        size = np.abs(values).max(axis=1)
        # Near an end the distance to it is known to rounding only: a noise no split removes.
        noise = 4e-16 * np.maximum(np.abs(low), np.abs(high)) / (high - low)
        omitted = np.abs(c[:, -3:]).max(axis=1) / np.where(size > 0.0, size, 1.0)
        rough = omitted > _TOLERANCE + noise[:, 0]
        # A small rest that a halving did not lessen is noise of the function itself.
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


def _pairs(start: NDArray[np.intp], end: NDArray[np.intp]) -> tuple[Any, Any]:
    """Return pairs (panel, index) for the indices ``start`` to ``end - 1`` of each panel."""
    count = np.maximum(end - start, 0)
    panel = np.repeat(np.arange(count.size), count)
    return panel, np.arange(panel.size) + np.repeat(start - (np.cumsum(count) - count), count)


class DensityHeights(HeightDistribution):
    """Heights with a density that is smooth between given edges.

    A subclass defines ``_pdf``, ``_edges``, ``spread`` and ``span``. The moments are tabulated
    once: that of order -1/2 by quadrature over the square root of the distance from the threshold,
    those of higher orders by integration of its piecewise Chebyshev series.
    """

    @property
    @abstractmethod
    def _edges(self) -> Floats:
        """Ends of the initial panels [m], increasing; the density is smooth between them."""

    @abstractmethod
    def _pdf(self, y: Floats) -> Floats:
        """Density [1/m] at heights [m] of any shape, zero outside the range of the heights."""

    def _probabilities(self, edges: Floats) -> Floats:
        width = np.diff(edges)[:, None]
        return self._pdf(edges[:-1, None] + width * NODES) * width * _WEIGHTS

    @cached_property
    def _density_pieces(self) -> PanelFit:
        return _resolve(self._pdf, self._edges)

    @cached_property
    def _panel_masses(self) -> tuple[tuple[float, Floats, Floats], ...]:
        """Sets of point masses [-] that replace the density of a panel for thresholds below it.

        A set is (smallest distance of the threshold from the panel in panel widths, positions above
        the lower panel edge [m], masses); the last two have the shape (panels, points). The larger
        the distance, the fewer points suffice for an error of 1e-14.
        """
        edges = self._density_pieces.edges
        fine = self._probabilities(edges)
        levels = []
        for distance, count in _LEVELS:
            nodes, basis = NODES, np.eye(NODES.size)
            if count < NODES.size:
                nodes = 0.5 + 0.5 * np.cos(math.pi * (np.arange(count) + 0.5) / count)
                basis = _lagrange(nodes, NODES)
            levels.append((distance, np.diff(edges)[:, None] * nodes, fine @ basis))
        return tuple(levels)

    def _root_moment(self, t: Floats) -> Floats:
        """Return the integral of 2 pdf(t + z^2) over z > 0: the moment of order -1/2 at t [m]."""
        edges = self._density_pieces.edges
        width = np.diff(edges)
        order = np.argsort(t, axis=None)
        flat = t.ravel()[order]
        total = np.zeros_like(flat)
        # Of the rising thresholds the first few are so far below a panel.
        end = np.zeros(width.size, dtype=np.intp)
        for distance, nodes, weights in self._panel_masses:
            start, end = end, np.searchsorted(flat, edges[:-1] - distance * width)
            if flat.size < _FEW_THRESHOLDS:  # all panels at once, in place of one after the other
                panel, at = _pairs(start, end)
                gap = (edges[panel] - flat[at])[:, None] + nodes[panel]
                part = (weights[panel] / np.sqrt(gap)).sum(axis=1)
                total += np.bincount(at, part, minlength=flat.size)
                continue
            for j in np.flatnonzero(end > start):
                gap = edges[j] - flat[start[j] : end[j], None]
                total[start[j] : end[j]] += (1.0 / np.sqrt(gap + nodes[j])) @ weights[j]
        # Nearer than an eighth of its width a panel sees the singularity.
        panel, at = _pairs(end, np.searchsorted(flat, edges[1:]))
        from_here = flat[at]
        low = np.sqrt(np.maximum(edges[panel] - from_here, 0.0))
        high = np.sqrt(edges[panel + 1] - from_here)
        z = low[:, None] + (high - low)[:, None] * NODES
        part = 2.0 * (high - low) * (self._pdf(from_here[:, None] + z * z) @ _WEIGHTS)
        total += np.bincount(at, part, minlength=flat.size)
        result = np.empty_like(total)
        result[order] = total
        return result.reshape(t.shape)

    @cached_property
    def _tables(self) -> dict[int, PanelFit]:
        """Tables of the moments against the threshold, by twice the order of the moment."""
        # Where the density jumps it has a root, which takes ever smaller panels.
        edges = self._density_pieces.edges
        root = _resolve(self._root_moment, edges, _PANELS + 2 * edges.size)
        tables = {-1: root}
        for twice in (1, 3, 5):
            tables[twice] = tables[twice - 2].tail(0.5 * twice)
        tables[0] = self._density_pieces.tail(1.0)
        tables[2] = tables[0].tail(1.0)
        tables[4] = tables[2].tail(2.0)
        return tables

    def _masses_below(self, octave: int) -> tuple[Floats, Floats]:
        """Return a discrete distribution, heights [m] and probabilities, that replaces the density.

        It serves for moments above thresholds that are below the lowest height by at least
        2**-octave times the range of the heights. Its heights are denser near the lowest one.
        """
        cloud = self._clouds.get(octave)
        if cloud is None:
            edges = self._density_pieces.edges
            edges = np.union1d(edges, edges[0] + np.ptp(edges) * 2.0 ** -np.arange(float(octave)))
            width = np.diff(edges)[:, None]
            y = edges[:-1, None] + width * NODES
            cloud = self._clouds[octave] = y.ravel(), self._probabilities(edges).ravel()
        return cloud

    @cached_property
    def _clouds(self) -> dict[int, tuple[Floats, Floats]]:
        return {}

    @cached_property
    def _breaks(self) -> Floats:
        """Heights [m], increasing, at which integrals over the moments are split.

        First come points below the lowest height, each half as far from it as the one before; then
        the panel edges of the table of order -1/2.
        """
        edges = self._tables[-1].edges
        below = edges[0] - self.spread * 2.0 ** np.arange(12.0, -48.0, -1.0)
        distinct = np.append(np.diff(edges) > _MIN_WIDTH * self.spread, True)
        return np.concatenate((below, edges[distinct]))

    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        low, high = self.span
        t = np.atleast_1d(threshold)
        result = np.zeros(t.shape)
        inside = (t >= low) & (t < high)
        if inside.any():
            result[inside] = np.maximum(self._tables[twice_order](t[inside]), 0.0)
        below = np.flatnonzero(t < low)
        if below.size:
            flat, moments = t.ravel(), result.ravel()
            octaves = np.clip(np.ceil(-np.log2((low - flat[below]) / (high - low))), 0.0, 60.0)
            for octave in np.unique(octaves):
                y, probability = self._masses_below(int(octave))
                mine = below[octaves == octave]
                for i in range(0, mine.size, 64):
                    s = y - flat[mine[i : i + 64], None]
                    terms = np.sqrt(s) if twice_order & 1 else np.ones_like(s)
                    if twice_order < 0:
                        np.divide(1.0, terms, out=terms)
                    for _ in range(twice_order // 2):
                        terms *= s
                    moments[mine[i : i + 64]] = terms @ probability
        return result.reshape(np.shape(threshold))

    def _density(self, height: Floats) -> Floats:
        return self._pdf(height)
