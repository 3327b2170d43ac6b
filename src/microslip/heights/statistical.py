"""Summit heights by any continuous distribution of scipy.stats."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev as cheb
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, show
from microslip.errors import Argument, InputError
from microslip.heights.base import HeightDistribution
from microslip.numerics.quadrature import gauss_legendre

_DEGREE = 15
_TOLERANCE = 3e-12  # of the largest value on a panel
_RATIO = 1e-4  # a panel over which a function falls further is split: relative accuracy in the tail
_DEEPEST = 48  # halvings of a first panel
_NOISE = 1e-10  # of the largest value: what a density may scatter by
_MOST = 600  # panels; a density as noisy as that is taken as it is
_HIGH = (1e-50, 1e-75, 1e-100, 1e-150, 1e-200, 1e-300)  # tail probabilities of a range's end
_LOW = (1e-20, 1e-14)  # and for the lower: what lies below carries no share of a load

_ANGLES = math.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1)
_POINTS = np.cos(_ANGLES)
_TRANSFORM = 2.0 / (_DEGREE + 1) * np.cos(np.outer(np.arange(_DEGREE + 1), _ANGLES))
_TRANSFORM[0] *= 0.5
_NODES, _WEIGHTS = gauss_legendre(20)
# From so many widths away a panel is so many charges, see `_charges`.
_LEVELS = ((60.0, 6), (4.0, 11), (0.125, 20))


@dataclass(frozen=True)
class _Pieces:
    """A function as Chebyshev series on panels, in falling order towards its upper end."""

    edges: Floats
    coefficients: Floats  # (terms, panels)

    def __call__(self, t: Floats) -> Floats:
        panel = np.clip(np.searchsorted(self.edges, t, side="right") - 1, 0, self.edges.size - 2)
        low, high = self.edges[panel], self.edges[panel + 1]
        s = ((t - low) - (high - t)) / (high - low)
        b1, b2 = np.zeros_like(t), np.zeros_like(t)
        for c in self.coefficients[:0:-1]:
            b1, b2 = 2.0 * s * b1 - b2 + c[panel], b1
        return np.asarray(s * b1 - b2 + self.coefficients[0][panel])

    def tail(self, factor: float) -> _Pieces:
        """``factor`` times the integral from t to the upper end, panel by panel from the right."""
        half = 0.5 * np.diff(self.edges)
        inner = cheb.chebint(self.coefficients, axis=0) * half
        total = inner.sum(axis=0)  # at s = 1
        whole = total - cheb.chebval(-1.0, inner)
        after = np.append(np.cumsum(whole[::-1])[::-1][1:], 0.0)
        inner = -inner
        inner[0] += total + after
        return _Pieces(self.edges, factor * inner)


def _lagrange(nodes: Floats, x: Floats) -> Floats:
    """Values at ``x`` (rows) of the polynomials that are one at one of ``nodes`` (columns)."""
    others = ~np.eye(nodes.size, dtype=bool)
    columns = [
        np.prod((x[:, None] - nodes[o]) / (n - nodes[o]), axis=1)
        for n, o in zip(nodes, others, strict=True)
    ]
    return np.stack(columns, axis=1)


def _resolve(function: Callable[[Floats], Floats], edges: Floats) -> _Pieces:
    """Panels between (and within) ``edges`` on which a polynomial is the function."""
    pending = np.column_stack((edges[:-1], edges[1:]))
    done: list[tuple[float, float, Floats]] = []
    before = np.full(len(pending), np.inf)
    for depth in range(_DEEPEST + 1):
        low, high = pending[:, :1], pending[:, 1:]
        values = function(0.5 * (low + high) + 0.5 * (high - low) * _POINTS)
        c = values @ _TRANSFORM.T
        size = np.abs(values).max(axis=1)
        # Near an end the distance to it is known to rounding only: a noise no split removes.
        noise = 4e-16 * np.maximum(np.abs(low), np.abs(high)) / (high - low)
        rest = np.abs(c[:, -3:]).max(axis=1) / np.where(size > 0.0, size, 1.0)
        rough = rest > _TOLERANCE + noise[:, 0]
        # A small rest that a halving did not lessen is noise of the function itself.
        rough &= (rest > _NOISE) | (rest < 0.3 * before)
        steep = np.abs(values).min(axis=1) < _RATIO * size
        split = (rough | steep) & ((high - low) > 1e-15 * np.abs(low))[:, 0]
        if depth == _DEEPEST or len(done) + 2 * len(pending) > _MOST:
            split[:] = False
        done += [(*pair, row) for pair, row in zip(pending[~split], c[~split], strict=True)]
        before = np.concatenate((rest[split], rest[split]))
        low, high = pending[split, 0], pending[split, 1]
        middle = 0.5 * (low + high)
        pending = np.concatenate((np.column_stack((low, middle)), np.column_stack((middle, high))))
        if not len(pending):
            break
    done.sort(key=lambda item: item[0])
    return _Pieces(
        np.array([item[0] for item in done] + [done[-1][1]]),
        np.ascontiguousarray(np.array([item[2] for item in done]).T),
    )


@dataclass(frozen=True, eq=False)
class Statistical(HeightDistribution):
    """Summit heights by a frozen continuous distribution of scipy.stats, in metres: (19.5)-(19.8).

    Parameters
    ----------
    distribution : frozen scipy.stats distribution
        For example ``scipy.stats.weibull_min(2.2, scale=1e-6)``: ``pdf``, ``sf``, ``isf``,
        ``ppf``, ``std`` and ``support`` are used.

    Raises
    ------
    InputError
        Not a continuous distribution; one whose partial moment of order 3/2, that is its normal
        load, is infinite (a tail heavier than y^(-5/2) in the density).

    Notes
    -----
    The moments are tabulated once (tens of milliseconds): the one of order -1/2 by quadrature in
    the root of the distance, those above it by integrating its piecewise Chebyshev series. Their
    relative error is below 1e-10 for smooth densities, down to tail probabilities of 1e-30.
    """

    distribution: Any

    def __post_init__(self) -> None:
        d = self.distribution
        needed = ("dist", "pdf", "cdf", "sf", "isf", "ppf", "support", "std")
        if hasattr(d, "pmf") or not all(hasattr(d, name) for name in needed):
            raise InputError(
                Argument("heights"),
                " must be a frozen continuous scipy.stats distribution such as "
                f"scipy.stats.weibull_min(2.2, scale=1e-6), got {show(d)}"
                + ("; freeze it by calling it" if callable(d) else ""),
            )
        with np.errstate(all="ignore"):
            several = any(np.ndim(v) for v in (*d.support(), d.sf(0.0)))
        if several:
            raise InputError(
                Argument("heights"), f" must be one distribution, got several at once: {self!r}"
            )
        low, high = (float(v) for v in d.support())
        if not high > low:
            raise InputError(
                Argument("heights"), f" must have a support of some length, got [{low:g}, {high:g}]"
            )
        index = math.inf if math.isfinite(high) else self._tail_index()
        if index <= 1.5 + 1e-6:
            raise InputError(
                Argument("heights"),
                " must have a finite moment of order 3/2 (the normal load), got a "
                f"distribution whose tail falls like y^-{index:.3g}",
            )
        object.__setattr__(self, "_index", index)
        object.__setattr__(self, "edge", low)

    def _scaled(self, factor: float) -> Statistical:
        frozen = self.distribution
        try:
            shapes, at, scale = frozen.dist._parse_args(*frozen.args, **frozen.kwds)
            return Statistical(frozen.dist(*shapes, loc=at * factor, scale=scale * factor))
        except (AttributeError, TypeError):
            raise InputError(
                Argument("heights"),
                f" must be of a distribution with location and scale, got {show(frozen)}",
            ) from None

    def _tail_index(self) -> float:
        """Exponent b of P(y > Y) ~ Y^-b as far out as the distribution can tell."""
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
        given = [show(v) for v in getattr(d, "args", ())]
        given += [f"{name}={show(v)}" for name, v in getattr(d, "kwds", {}).items()]
        name = getattr(getattr(d, "dist", d), "name", type(d).__name__)
        return f"Statistical({name}({', '.join(given)}))"

    @cached_property
    def spread(self) -> float:
        """Standard deviation of the heights [m]; the quartile distance where that is infinite."""
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
        """Heights [m] below and above which there is next to nothing."""
        d = self.distribution
        low, high = (float(v) for v in d.support())
        with np.errstate(all="ignore"):
            low = max(low, next(v for p in _LOW if math.isfinite(v := float(d.ppf(p)))))
            if not math.isfinite(high):
                high = self._upper_end()
        return low, high

    @property
    def top(self) -> float:
        """Upper end of the distribution's support [m]."""
        return float(self.distribution.support()[1])

    def _upper_end(self) -> float:
        """Height beyond which neither probability nor the share of the load matters."""
        d, most, end = self.distribution, 0.0, -math.inf
        for p in (0.5, 1e-3, 1e-6, 1e-10, 1e-14, 1e-20, 1e-30, *_HIGH):
            y = float(d.isf(p))
            if not math.isfinite(y) or y < end:
                break
            end, share = y, p * max(y - float(d.isf(0.5)), 0.0) ** 1.5
            most = max(most, share)
            if p <= _HIGH[0] and share < 1e-14 * most:
                break
        return end

    @cached_property
    def _singular(self) -> bool:
        """Whether the density is infinite at an end of its range."""
        ends = [end for end in self.distribution.support() if math.isfinite(end)]
        with np.errstate(all="ignore"):
            return any(not math.isfinite(float(self.distribution.pdf(end))) for end in ends)

    @cached_property
    def _edges(self) -> Floats:
        """First panels: quantiles, so that no narrow peak is missed."""
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
        """What the nodes of each panel stand for.

        Near a singular end of a density no node does it justice: there each panel is given its
        exact probability.
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
    def _density_pieces(self) -> _Pieces:
        return _resolve(self._pdf, self._edges)

    @cached_property
    def _charges(self) -> tuple[tuple[float, Floats, Floats], ...]:
        """Nodes and weights of the panels for thresholds beyond so many of their widths.

        From far away a panel is fewer charges: those that give the polynomials of lower degree the
        same integral, which is all that the kernel is there, to 1e-14.
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
        """The moment of order -1/2 for thresholds within the span: 2 pdf(t + z^2) dz."""
        edges = self._density_pieces.edges
        width = np.diff(edges)
        order = np.argsort(t, axis=None)
        flat = t.ravel()[order]
        total = np.zeros_like(flat)
        # Of the rising thresholds the first few are so far below a panel.
        end = np.zeros(width.size, dtype=np.intp)
        for distance, nodes, weights in self._charges:
            start, end = end, np.searchsorted(flat, edges[:-1] - distance * width)
            for j in np.flatnonzero(end > start):
                gap = edges[j] - flat[start[j] : end[j], None]
                total[start[j] : end[j]] += (1.0 / np.sqrt(gap + nodes[j])) @ weights[j]
        # Nearer than an eighth of its width a panel sees the singularity.
        last = np.searchsorted(flat, edges[1:])
        count = np.maximum(last - end, 0)
        panel = np.repeat(np.arange(width.size), count)
        at = np.arange(panel.size) + np.repeat(end - (np.cumsum(count) - count), count)
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
    def _tables(self) -> dict[int, _Pieces]:
        """Moments by twice their order; two chains of integrals, from -1/2 and from the density."""
        root = _resolve(self._root_moment, self._density_pieces.edges)
        tables = {-1: root}
        for twice in (1, 3, 5):
            tables[twice] = tables[twice - 2].tail(0.5 * twice)
        tables[0] = self._density_pieces.tail(1.0)
        tables[2] = tables[0].tail(1.0)
        tables[4] = tables[2].tail(2.0)
        return tables

    def _cloud(self, octave: int) -> tuple[Floats, Floats]:
        """Nodes and probabilities that integrate the density, seen from so far below its end.

        From 2**-octave of its range below its lower end: towards that end they are refined so far
        that no threshold there sees a singular integrand, and no further.
        """
        kept = self._clouds.get(octave)
        if kept is None:
            edges = self._density_pieces.edges
            edges = np.union1d(edges, edges[0] + np.ptp(edges) * 2.0 ** -np.arange(float(octave)))
            width = np.diff(edges)[:, None]
            y = edges[:-1, None] + width * _NODES
            kept = self._clouds[octave] = y.ravel(), self._probabilities(edges).ravel()
        return kept

    @cached_property
    def _clouds(self) -> dict[int, tuple[Floats, Floats]]:
        """Those that were asked for."""
        return {}

    @cached_property
    def _breaks(self) -> Floats:
        """Panels of the moment of order -1/2, and ever smaller ones towards the lower end."""
        edges = self._tables[-1].edges
        below = edges[0] - self.spread * 2.0 ** np.arange(12.0, -48.0, -1.0)
        return np.concatenate((below, edges))

    def partial_moment(self, order: float, threshold: ArrayLike) -> Any:
        """As for every distribution; an order whose moment is infinite is an error, too."""
        moment = super().partial_moment(order, threshold)
        index: float = self._index  # type: ignore[attr-defined]
        if order >= index:
            raise InputError(
                Argument("order"),
                f" must be below {index:.3g}, where the moments of this distribution become "
                f"infinite, got {order:g}",
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
                y, probability = self._cloud(int(octave))
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
        """Unbounded, bounded below and bounded on both sides."""
        from scipy import stats

        return (
            cls(stats.norm(loc=1e-7, scale=5e-7)),
            cls(stats.weibull_min(2.2, scale=1e-6)),
            cls(stats.uniform(loc=-1e-6, scale=2e-6)),
        )
