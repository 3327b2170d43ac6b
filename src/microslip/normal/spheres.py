"""Sums over given summits, each a sphere: N = sum of k (y - d)^(3/2) over those with y > d."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from microslip._checks import Floats
from microslip.kernels import Integers
from microslip.kernels.table import NODES, TO_SERIES, Table

_BLOCK = 1 << 18  # products held at a time
_FACTORS = {-1: 0.4, 0: 1.0, 1: -1.5, 2: 0.75}
_FEW = 24  # summits that are summed one by one
_NEAR = 3  # panels in which a summit is summed by itself: its own and those next to it


def blocks(rows: int, columns: int) -> list[slice]:
    """Slices of the rows of a matrix, each of a size that a cache or two can hold."""
    step = max(1, _BLOCK // max(1, columns))
    return [slice(i, i + step) for i in range(0, rows, step)]


class Kind(NamedTuple):
    """A sum over the contacts of weight s^power share(x), with x = v/s."""

    power: float
    share: Callable[[Floats, Floats, Floats], Floats]
    """Of x < 1, q = sqrt(1 - x) and 1 - q, for what has not slipped wholly."""
    order: int
    """Leading power of v (of the table: 0, 1 or 3)."""


# Closed forms of Cattaneo and Mindlin's sphere that do not cancel for small x.
DROP = Kind(1.5, lambda x, q, p: p * (1.0 + q * (1.0 + q)), 1)
"""N(d) - N(d + v)."""
FALL = Kind(0.5, lambda x, q, p: 1.5 * q, 0)
"""-N'(d + v)."""
EXCESS = Kind(2.5, lambda x, q, p: 0.1 * p * p * p * (1.0 + q * (3.0 + q)), 3)
"""Half the integral of w (v - w) N''(d + w) over [0, v]: the energy."""
EXCESS_SLOPE = Kind(1.5, lambda x, q, p: 0.25 * p * p * (2.0 + q), 1)
"""Half the integral of w N''(d + w) over [0, v]."""


class Contacts:
    """The contacts of given summits at one separation, with indentations s and load constants k.

    Few are summed one by one. Of many, only the summits whose slip limit is near v are; those that
    have slipped wholly are running sums, and the rest, smooth in v, is a polynomial on each panel
    of v. The polynomials are gathered from coarse panels to fine ones (as in a fast multipole
    method), so that n contacts cost O(n log n) once and O(1) a value then.
    """

    def __init__(self, indentations: Floats, constants: Floats) -> None:
        order = np.argsort(indentations)
        self._s = indentations[order]
        self._k = constants[order]
        self._tables: dict[Kind, Table] = {}
        self._levels = 0
        if self._s.size <= _FEW:
            return
        self._levels = max(3, int(np.ceil(np.log2(self._s.size / 8))))
        panels = 1 << self._levels
        self._width = float(self._s[-1]) / panels
        panel = np.minimum((self._s / self._width).astype(np.int64), panels - 1)
        self._first = np.searchsorted(panel, np.arange(panels + 1))  # summits of panel b
        self._panel = panel
        self._loads = np.append(0.0, np.cumsum(self._k * _power(self._s, 1.5)))
        self._moments = np.append(0.0, np.cumsum(self._k * _power(self._s, 2.5)))

    def sum(self, kind: Kind, v: Floats) -> Floats:
        """The sum at steps ``v`` >= 0, one-dimensional."""
        result = np.empty(v.size)
        if not self._levels:
            everyone = np.arange(self._s.size)
            for part in blocks(v.size, self._s.size):
                result[part] = self._terms(kind, v[part, None], everyone).sum(axis=1)
            return result
        table = self._tables.get(kind)
        if table is None:
            table = self._tables[kind] = self._far(kind)
        for part in blocks(v.size, 4 * _NEAR * 8):
            step = v[part]
            panel = np.minimum(step / self._width, 1 << self._levels).astype(np.int64)
            first = self._first[panel]
            end = self._first[np.minimum(panel + _NEAR, 1 << self._levels)]
            total = table.value(step)
            if kind is EXCESS_SLOPE:
                total *= step
            total += self._slipped(kind, step, first)
            if step.size <= 4:  # a solver's trial: one short sum
                for i, (low, high) in enumerate(zip(first, end, strict=True)):
                    total[i] += self._terms(kind, step[i], np.arange(low, high)).sum()
            else:
                for k in range(int((end - first).max())):
                    at = np.flatnonzero(first + k < end)
                    total[at] += self._terms(kind, step[at], first[at] + k)
            result[part] = total
        return result

    def _terms(self, kind: Kind, v: Floats, which: Integers) -> Floats:
        s = self._s[which]
        x = v / s
        q = np.sqrt(np.maximum(1.0 - x, 0.0))
        p = np.minimum(x, 1.0) / (1.0 + q)  # 1 - q without cancellation
        share = kind.share(x, q, p)
        if kind is EXCESS:
            share = np.where(x > 1.0, 0.5 * x - 0.4, share)
        return np.asarray(self._k[which] * _power(s, kind.power) * share)

    def _slipped(self, kind: Kind, v: Floats, count: Integers) -> Floats:
        """Share of the ``count`` least indented summits, all of which have slipped wholly."""
        if kind is DROP:
            return np.asarray(self._loads[count])
        if kind is EXCESS:
            return np.asarray(0.5 * v * self._loads[count] - 0.4 * self._moments[count])
        return np.asarray(0.5 * self._loads[count]) if kind is EXCESS_SLOPE else np.zeros(v.size)

    def _far(self, kind: Kind) -> Table:
        """What the summits beyond the near panels give, over v to the power of the table."""
        points = 0.5 * (1.0 + NODES)
        halves = [_resample(side) for side in (0, 1)]
        values = np.zeros((1, NODES.size))
        weight = self._k * _power(self._s, kind.power)
        divisor = 2 if kind is EXCESS_SLOPE else kind.order
        for level in range(1, self._levels + 1):
            # A panel inherits what its parent has; then come the summits that are far from it but
            # were near to its parent.
            values = np.stack([values @ half for half in halves], axis=1).reshape(-1, NODES.size)
            shift = self._levels - level
            own = self._panel >> shift
            width = self._width * (1 << shift)
            for distance in range(_NEAR, 2 * _NEAR):
                target = own - distance
                new = (target >= 0) & ((own >> 1) - (target >> 1) < _NEAR)
                if not new.any():
                    continue
                at, s = target[new], self._s[new]
                sums = np.empty((NODES.size, values.shape[0]))
                for row, point in enumerate(points):
                    v = (at + point) * width
                    x = v / s
                    q = np.sqrt(1.0 - x)
                    terms = weight[new] * kind.share(x, q, x / (1.0 + q)) / v**divisor
                    sums[row] = np.bincount(at, terms, minlength=values.shape[0])
                values += sums.T
        end = self._width * (1 << self._levels)
        return Table.from_series(values @ TO_SERIES, end, kind.order, 0.0)


def _power(s: Floats, power: float) -> Floats:
    """S to the power of 1/2, 3/2 or 5/2."""
    result = np.sqrt(s)
    for _ in range(int(power)):
        result = s * result
    return result


@lru_cache(maxsize=2)
def _resample(side: int) -> Floats:
    """Takes values at a panel's nodes to those at its left (0) or right (1) half's nodes."""
    inner = 0.5 * NODES + (side - 0.5)
    series = np.polynomial.chebyshev.chebvander(inner, NODES.size - 1)
    return np.ascontiguousarray(TO_SERIES @ series.T)


class Spheres:
    """Hertzian spheres at given heights.

    Parameters
    ----------
    heights : ndarray
        Heights [m].
    constants : ndarray
        Load constants k = (4/3) E* sqrt(radius) [N/m^1.5] of (19.3).
    """

    def __init__(self, heights: Floats, constants: Floats) -> None:
        order = np.argsort(heights)[::-1]
        self.heights = heights[order]
        self.constants = constants[order]
        self._contacts: dict[float, Contacts] = {}

    def derivative(self, separation: Floats, order: int) -> Floats:
        """Derivative of the load, orders -1 (integral to infinity) to 2; any shape."""
        flat = separation.reshape(-1)
        result = np.zeros(flat.size)
        for part in blocks(flat.size, self.count(float(flat.min()))):
            count = self.count(float(flat[part].min()))
            s = np.maximum(self.heights[:count] - flat[part, None], 0.0)
            terms = np.sqrt(s)
            if order == 2:
                terms = np.divide(1.0, terms, out=terms, where=terms > 0.0)
            for _ in range(1 - order):
                terms *= s
            result[part] = _FACTORS[order] * (terms @ self.constants[:count])
        return result.reshape(separation.shape)

    def sum(self, kind: Kind, d: float, v: Floats) -> Floats:
        """A sum over the contacts at the separation ``d`` for steps ``v`` from it."""
        contacts = self._contacts.get(d)
        if contacts is None:
            count = self.count(d)
            contacts = Contacts(self.heights[:count] - d, self.constants[:count])
            if len(self._contacts) >= 8:  # a handful of loads at a time
                self._contacts.pop(next(iter(self._contacts)))
            self._contacts[d] = contacts
        return contacts.sum(kind, v)

    def count(self, separation: float) -> int:
        """How many summits stand above a separation."""
        return int(np.searchsorted(-self.heights, -separation, side="left"))
