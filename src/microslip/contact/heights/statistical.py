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
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip.contact.heights.base import HeightDistribution
from microslip.contact.heights.density import NODES, DensityHeights

_HIGH_TAILS = (1e-50, 1e-75, 1e-100, 1e-150, 1e-200, 1e-300)  # tail probabilities of a range's end
_LOW_TAILS = (1e-20, 1e-14)  # and for the lower: what lies below carries no share of a load


@dataclass(frozen=True, eq=False)
class Statistical(DensityHeights):
    """Summit heights [m] with a frozen continuous distribution of scipy.stats: (19.5)-(19.8).

    Parameters
    ----------
    distribution : frozen scipy.stats distribution
        For example ``scipy.stats.weibull_min(2.2, scale=1e-6)``: ``pdf``, ``sf``, ``isf``, ``ppf``,
        ``std`` and ``support`` are used.

    Notes
    -----
    Moments are tabulated once (tens of milliseconds), with relative errors below 1e-10 for smooth
    densities, down to tail probabilities of 1e-30.
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

    __hash__ = DensityHeights.__hash__

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
            y = edges[:-1, None] + np.diff(edges)[:, None] * NODES
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
        weights = super()._probabilities(edges)
        if not self._singular:
            return weights
        sf = np.asarray(self.distribution.sf(edges), dtype=float)
        cdf = np.asarray(self.distribution.cdf(edges), dtype=float)
        exact = np.where(sf[:-1] < 0.5, -np.diff(sf), np.diff(cdf))
        total = weights.sum(axis=1)
        off = (np.abs(exact - total) > 1e-12 * total) & (np.abs(exact - total) < 0.1 * total)
        weights[off] *= (exact[off] / total[off])[:, None]
        return weights

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
        return super()._moment(twice_order, threshold)

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
