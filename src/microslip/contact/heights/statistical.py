"""Summit heights with any continuous distribution of scipy.stats.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.quadrature import gauss_legendre
from microslip.contact.heights.base import HeightDistribution
from microslip.contact.heights.panel_fit import PANELS, PanelFit, resolve

_HIGH_TAILS = (1e-50, 1e-75, 1e-100, 1e-150, 1e-200, 1e-300)  # tail probabilities of a range's end
_LOW_TAILS = (1e-20, 1e-14)  # and for the lower: what lies below carries no share of a load
_MIN_WIDTH = 1e-7  # of the spread: closer breaks of a root of N'' matter to no integral
_FEW_THRESHOLDS = 200
_NODES, _WEIGHTS = gauss_legendre(20)
# Distance of a threshold in panel widths, and number of point masses, see `_panel_masses`.
_LEVELS = ((60.0, 6), (4.0, 11), (0.125, 20))


@dataclass(frozen=True, eq=False)
class Statistical(HeightDistribution):
    """Summit heights [m] with a frozen continuous distribution of scipy.stats: (19.5)-(19.8).

    Parameters
    ----------
    distribution : frozen scipy.stats distribution
        For example ``scipy.stats.weibull_min(2.2, scale=1e-6)``: ``pdf``, ``sf``, ``isf``, ``ppf``,
        ``std`` and ``support`` are used.

    Notes
    -----
    Moments are tabulated once (tens of milliseconds), with relative errors below 1e-10 for smooth
    densities, down to tail probabilities of 1e-30: that of order -1/2 by quadrature over the square
    root of the distance from the threshold, those of higher orders by integration of its piecewise
    Chebyshev series.
    """

    distribution: Any

    def __post_init__(self) -> None:
        d = self.distribution
        needed = ("dist", "pdf", "cdf", "sf", "isf", "ppf", "support", "std")
        if hasattr(d, "pmf") or not all(hasattr(d, name) for name in needed):
            raise InputError(
                "`heights` must be a frozen continuous scipy.stats distribution such as "
                f"scipy.stats.weibull_min(2.2, scale=1e-6), got {show(d)}"
                + ("; freeze it by calling it" if callable(d) else "")
            )
        with np.errstate(all="ignore"):
            several = any(np.ndim(v) for v in (*d.support(), d.sf(0.0)))
        if several:
            raise InputError(f"`heights` must be one distribution, got several at once: {self!r}")
        low, high = (float(v) for v in d.support())
        if not high > low:
            raise InputError(
                f"`heights` must have a support of nonzero length, got [{low:g}, {high:g}]"
            )
        index = math.inf if math.isfinite(high) else self._tail_index()
        if index <= 1.5 + 1e-6:
            raise InputError(
                "`heights` must have a finite moment of order 3/2 (the normal load), got a "
                f"distribution whose tail falls like y^-{index:.3g}"
            )
        assign(self, _index=index, edge=low)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Statistical):
            return NotImplemented
        one, two = self.distribution, other.distribution
        return one is two or (
            type(one.dist) is type(two.dist)
            and tuple(one.dist._parse_args(*one.args, **one.kwds))
            == tuple(two.dist._parse_args(*two.args, **two.kwds))
        )

    __hash__ = HeightDistribution.__hash__

    def _scaled(self, factor: float) -> Statistical:
        frozen = self.distribution
        try:
            shapes, at, scale = frozen.dist._parse_args(*frozen.args, **frozen.kwds)
            return Statistical(frozen.dist(*shapes, loc=at * factor, scale=scale * factor))
        except (AttributeError, TypeError):
            raise InputError(
                f"`heights` must be of a distribution with location and scale, got {show(frozen)}"
            ) from None

    def _tail_index(self) -> float:
        """Exponent b of the tail P(y > Y) ~ Y^-b, at the largest resolved height Y."""
        d = self.distribution
        with np.errstate(all="ignore"):
            for first, second in ((1e-150, 1e-300), (1e-40, 1e-80), (1e-15, 1e-30), (1e-5, 1e-10)):
                y = [float(d.isf(p)) - float(d.isf(0.5)) for p in (first, second)]
                back = [float(d.sf(v + float(d.isf(0.5)))) for v in y]
                if (
                    all(map(math.isfinite, y))
                    and 0.0 < y[0] < y[1]
                    and all(
                        abs(b / p - 1.0) < 0.1 for b, p in zip(back, (first, second), strict=True)
                    )
                ):
                    return math.log(first / second) / math.log(y[1] / y[0])
        return math.inf if math.isfinite(float(d.std())) else 0.0

    def __repr__(self) -> str:
        d = self.distribution
        arguments = [show(v) for v in getattr(d, "args", ())]
        arguments += [f"{name}={show(v)}" for name, v in getattr(d, "kwds", {}).items()]
        name = getattr(getattr(d, "dist", d), "name", type(d).__name__)
        return f"Statistical({name}({', '.join(arguments)}))"

    @cached_property
    def spread(self) -> float:
        """Standard deviation of the heights [m]; the interquartile range if it is infinite."""
        if all(map(math.isfinite, self.distribution.support())) and not self._singular:
            # A distribution that knows its moments only as integrals takes long over them.
            edges = self._density_pieces.edges
            y = edges[:-1, None] + np.diff(edges)[:, None] * _NODES
            share = self._probabilities(edges)
            return math.sqrt(float((share * (y - (share * y).sum()) ** 2).sum()))
        std = float(self.distribution.std())
        if math.isfinite(std) and std > 0.0:
            return std
        return float(self.distribution.ppf(0.75) - self.distribution.ppf(0.25))

    @cached_property
    def span(self) -> tuple[float, float]:
        """Heights [m] between which practically all summits lie."""
        d = self.distribution
        low, high = (float(v) for v in d.support())
        with np.errstate(all="ignore"):
            low = max(low, next(v for p in _LOW_TAILS if math.isfinite(v := float(d.ppf(p)))))
            if not math.isfinite(high):
                high = self._upper_end()
        return low, high

    @property
    def top(self) -> float:
        """Upper end of the support [m]."""
        return float(self.distribution.support()[1])

    def _upper_end(self) -> float:
        """Height [m] above which probability and load are negligible."""
        d, largest, end = self.distribution, 0.0, -math.inf
        for p in (0.5, 1e-3, 1e-6, 1e-10, 1e-14, 1e-20, 1e-30, *_HIGH_TAILS):
            y = float(d.isf(p))
            if not math.isfinite(y) or y < end:
                break
            end, share = y, p * max(y - float(d.isf(0.5)), 0.0) ** 1.5
            largest = max(largest, share)
            if p <= _HIGH_TAILS[0] and share < 1e-14 * largest:
                break
        return end

    @cached_property
    def _singular(self) -> bool:
        """True if the density is infinite at an end of its range."""
        ends = [end for end in self.distribution.support() if math.isfinite(end)]
        with np.errstate(all="ignore"):
            return any(not math.isfinite(float(self.distribution.pdf(end))) for end in ends)

    @cached_property
    def _edges(self) -> Floats:
        """Edges of the initial panels [m]: quantiles, so that no narrow peak is missed."""
        d = self.distribution
        low, high = self.span
        inner = np.asarray(d.ppf([0.001, 0.1, 0.3, 0.5, 0.7, 0.9, 0.999]), dtype=float)
        inner = inner[(inner > low) & (inner < high)]
        # An almost infinite range is left in octaves, not in thousands of halvings.
        middle = float(d.ppf(0.5))
        step = float(inner[-1] - inner[0]) if inner.size > 1 else high - low
        with np.errstate(over="ignore"):
            octaves = step * 2.0 ** np.arange(0.0, 1024.0)
        edges = np.concatenate(([low, high], inner, middle + octaves, middle - octaves))
        edges = edges[(edges >= low) & (edges <= high)]
        bins = getattr(getattr(d, "dist", None), "_hbins", None)
        if bins is not None and not d.args and not d.kwds:  # a histogram jumps at its bins
            edges = np.concatenate((edges, bins))
        return np.unique(edges)

    def _pdf(self, y: Floats) -> Floats:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            values = np.asarray(self.distribution.pdf(y), dtype=float)
        return np.where(np.isfinite(values), values, 0.0)

    def _probabilities(self, edges: Floats) -> Floats:
        """Probabilities of point masses, shape (panels, nodes).

        If the density is infinite at an end, they are scaled to the exact sum over each panel.
        """
        width = np.diff(edges)[:, None]
        weights = self._pdf(edges[:-1, None] + width * _NODES) * width * _WEIGHTS
        if not self._singular:
            return weights
        sf = np.asarray(self.distribution.sf(edges), dtype=float)
        cdf = np.asarray(self.distribution.cdf(edges), dtype=float)
        exact = np.where(sf[:-1] < 0.5, -np.diff(sf), np.diff(cdf))
        total = weights.sum(axis=1)
        off = (np.abs(exact - total) > 1e-12 * total) & (np.abs(exact - total) < 0.1 * total)
        weights[off] *= (exact[off] / total[off])[:, None]
        return weights

    @cached_property
    def _density_pieces(self) -> PanelFit:
        return resolve(self._pdf, self._edges)

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
            nodes, basis = _NODES, np.eye(_NODES.size)
            if count < _NODES.size:
                nodes = 0.5 + 0.5 * np.cos(math.pi * (np.arange(count) + 0.5) / count)
                basis = _lagrange(nodes, _NODES)
            levels.append((distance, np.diff(edges)[:, None] * nodes, fine @ basis))
        return tuple(levels)

    def _root_moment(self, t: Floats) -> Floats:
        """Return the integral of 2 pdf(t + z^2) over z > 0: the moment of order -1/2 at t [m]."""
        edges = self._density_pieces.edges
        width = np.diff(edges)
        order = np.argsort(t, axis=None)
        flat = t.ravel()[order]
        total = np.zeros_like(flat)
        # The thresholds rise: those more than `distance` widths below a panel come first.
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
        # Panels nearer than an eighth of their width are integrated over z, which is not singular.
        panel, at = _pairs(end, np.searchsorted(flat, edges[1:]))
        from_here = flat[at]
        low = np.sqrt(np.maximum(edges[panel] - from_here, 0.0))
        high = np.sqrt(edges[panel + 1] - from_here)
        z = low[:, None] + (high - low)[:, None] * _NODES
        part = 2.0 * (high - low) * (self._pdf(from_here[:, None] + z * z) @ _WEIGHTS)
        total += np.bincount(at, part, minlength=flat.size)
        result = np.empty_like(total)
        result[order] = total
        return result.reshape(t.shape)

    @cached_property
    def _tables(self) -> dict[int, PanelFit]:
        """Tables of the moments against the threshold, by twice the order of the moment."""
        # At a jump of the density the moment varies as a square root: it needs ever smaller panels.
        edges = self._density_pieces.edges
        root = resolve(self._root_moment, edges, PANELS + 2 * edges.size)
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
            y = edges[:-1, None] + width * _NODES
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

    def partial_moment(self, order: float, threshold: ArrayLike) -> Any:
        """Partial moment [m^order], any shape, as :meth:`HeightDistribution.partial_moment`."""
        moment = super().partial_moment(order, threshold)
        index: float = self._index  # type: ignore[attr-defined]
        if order >= index:
            raise InputError(
                f"`order` must be below {index:.3g}, where the moments of this distribution "
                f"become infinite, got {order:g}"
            )
        if order <= 0.0 or math.isinf(index):
            return moment
        # What a power tail holds beyond the end of the tables, which are made for order 3/2.
        end = self.span[1]
        beyond = float(self.distribution.sf(end)) * end**order * index / (index - order)
        return moment + beyond

    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        if twice_order == 0 and self._singular:
            return np.asarray(self.distribution.sf(threshold), dtype=float)
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
        return np.asarray(self.distribution.pdf(height), dtype=float)

    @classmethod
    def examples(cls) -> tuple[HeightDistribution, ...]:
        """Return distributions without bounds, with a lower bound, and with two bounds."""
        from scipy import stats

        return (
            cls(stats.norm(loc=1e-7, scale=5e-7)),
            cls(stats.weibull_min(2.2, scale=1e-6)),
            cls(stats.uniform(loc=-1e-6, scale=2e-6)),
        )


def _lagrange(nodes: Floats, x: Floats) -> Floats:
    """Return the Lagrange polynomials of ``nodes`` at ``x``, shape (x, nodes)."""
    masks = ~np.eye(nodes.size, dtype=bool)
    columns = [
        np.prod((x[:, None] - nodes[o]) / (n - nodes[o]), axis=1)
        for n, o in zip(nodes, masks, strict=True)
    ]
    return np.stack(columns, axis=1)


def _pairs(start: NDArray[np.intp], end: NDArray[np.intp]) -> tuple[Any, Any]:
    """Return pairs (panel, index) for the indices ``start`` to ``end - 1`` of each panel."""
    count = np.maximum(end - start, 0)
    panel = np.repeat(np.arange(count.size), count)
    return panel, np.arange(panel.size) + np.repeat(start - (np.cumsum(count) - count), count)
