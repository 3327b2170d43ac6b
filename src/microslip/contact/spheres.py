"""Loads of given spherical summits: N(d) = sum of k (y - d)^(3/2) over the summits with y > d.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.kernels import Integers
from microslip._core.kernels.table import NODES, TO_SERIES, PolynomialTable

_BLOCK = 1 << 18  # products held at a time
CACHED = 1 << 14  # the same where there are many passes over them: as many as a cache holds
_FEW_SUMMITS = 24  # summits that are summed one by one
_NEAR_PANELS = 3  # panels in which a summit is summed by itself: its own and those next to it
_OCCUPANTS = 8  # summits a panel, on average
DERIVATIVES = {-1: 0.4, 0: 1.0, 1: -1.5, 2: 0.75}
"""Factors of s^(3/2 - order) in the derivatives of s^(3/2) by the separation."""


def blocks(rows: int, columns: int, size: int = _BLOCK) -> list[slice]:
    """Return slices of rows, each with at most ``size`` matrix elements or a single row."""
    step = max(1, size // max(1, columns))
    return [slice(i, i + step) for i in range(0, rows, step)]


class Summand(NamedTuple):
    """Definition of a sum over contacts as a function of an increment v of the separation.

    It is the sum of k s^power share(x, q, 1 - q), with x = v/s and q = sqrt(max(1 - x, 0)), where k
    is the load constant of each contact and s its indentation before the increment. The instances
    are DROP, FALL, EXCESS and EXCESS_SLOPE.
    """

    power: float
    order: int
    """Power of v to which the sum is proportional for small v, 0 to 3."""
    share: Callable[[Floats, Floats, Floats], Floats]
    """Contribution of a contact over k s^power [-], as a function of x, q and 1 - q."""
    slipped: Callable[[Floats, Floats, Floats], Floats]
    """Sum over contacts with s < v, from v and their sums of k s^(3/2) and k s^(5/2)."""


# Closed forms of Cattaneo and Mindlin's sphere that do not cancel for small x.
DROP = Summand(1.5, 1, lambda x, q, p: p * (1.0 + q * (1.0 + q)), lambda v, n, m: n)
"""N(d) - N(d + v)."""
FALL = Summand(0.5, 0, lambda x, q, p: 1.5 * q, lambda v, n, m: 0.0 * n)
"""-N'(d + v)."""
EXCESS = Summand(
    2.5,
    3,
    lambda x, q, p: 0.1 * p * p * p * (1.0 + q * (3.0 + q)) + 0.5 * np.maximum(x - 1.0, 0.0),
    lambda v, n, m: 0.5 * v * n - 0.4 * m,
)
"""Half the integral of w (v - w) N''(d + w) over [0, v]: the energy."""
EXCESS_SLOPE = Summand(1.5, 2, lambda x, q, p: 0.25 * p * p * (2.0 + q), lambda v, n, m: 0.5 * n)
"""Half the integral of w N''(d + w) over [0, v]."""


class Contacts:
    """Contacts of given summits at one separation, with indentations s [m] and load constants k.

    The sums of :class:`Summand` are functions of an increment v of the separation. Few contacts are
    summed one by one. For many, v is divided into panels. Contacts with s in the panel of v or in
    the next two are summed one by one. Contacts with smaller s, which have ended before v, are
    included by cumulative sums over s, and contacts with larger s, whose sum is smooth in v, by a
    polynomial in v on each panel. Polynomials are gathered from coarse to fine panels (as in a fast
    multipole method): n contacts cost O(n log n) once and O(1) per value. Panels extend to eight
    times the median of s; contacts with larger s also have panels of their own, for larger v.
    """

    def __init__(self, indentations: Floats, constants: Floats) -> None:
        # Summits of one height are one.
        self._s, groups = np.unique(indentations, return_inverse=True)
        self._k: Floats = np.bincount(groups, constants).astype(float)
        self._tables: dict[float, PolynomialTable] = {}
        self._panels = 0
        self._outer: Contacts | None = None
        if self._s.size <= _FEW_SUMMITS:
            return
        end = min(float(self._s[-1]), 8.0 * float(self._s[self._s.size // 2]))
        inside = int(np.searchsorted(self._s, end, side="right"))
        levels = max(3, int(np.ceil(np.log2(inside / _OCCUPANTS))))
        self._panels, self._width = 1 << levels, end / (1 << levels)
        self._panel = (self._s / self._width).astype(np.int64)
        self._panel[:inside] = np.minimum(self._panel[:inside], self._panels - 1)
        self._first = np.searchsorted(self._panel, np.arange(self._panels + _NEAR_PANELS + 1))
        self._loads = np.append(0.0, np.cumsum(self._k * _power(self._s, 1.5)))
        self._moments = np.append(0.0, np.cumsum(self._k * _power(self._s, 2.5)))
        if inside < self._s.size:
            self._outer = Contacts(self._s[inside:], self._k[inside:])
        self._inside = inside

    def sum(self, kind: Summand, v: Floats) -> Floats:
        """Return the sum over the contacts after the separation has increased by ``v`` >= 0 [m].

        ``kind`` selects the quantity: the drop of the load, the stiffness, or the energy and its
        derivative (:data:`DROP`, :data:`FALL`, :data:`EXCESS`, :data:`EXCESS_SLOPE`). ``v`` and the
        result are one-dimensional.
        """
        result = np.empty(v.size)
        if not self._panels:
            everyone = np.arange(self._s.size)
            for part in blocks(v.size, self._s.size):
                result[part] = self._terms(kind, v[part, None], everyone).sum(axis=1)
            return result
        within = v < self._panels * self._width
        result[within] = self._within(kind, v[within])
        if not within.all():
            beyond = v[~within]
            count = np.full(beyond.size, self._inside)
            result[~within] = kind.slipped(beyond, self._loads[count], self._moments[count])
            if self._outer is not None:
                result[~within] += self._outer.sum(kind, beyond)
        return result

    def _within(self, kind: Summand, v: Floats) -> Floats:
        table = self._tables.get(kind.power + 10 * kind.order)
        if table is None:
            table = self._tables[kind.power + 10 * kind.order] = self._far(kind)
        result = np.empty(v.size)
        for part in blocks(v.size, 4 * _NEAR_PANELS * _OCCUPANTS):  # a panel may hold more
            step = v[part]
            panel = np.minimum(step / self._width, self._panels - 1).astype(np.int64)
            first, end = self._first[panel], self._first[panel + _NEAR_PANELS]
            total = table.value(step)
            total += kind.slipped(step, self._loads[first], self._moments[first])
            if step.size <= 4:  # a solver's trial: one short sum
                for i, (low, high) in enumerate(zip(first, end, strict=True)):
                    total[i] += self._terms(kind, step[i], np.arange(low, high)).sum()
            else:
                for k in range(int((end - first).max())):
                    at = np.flatnonzero(first + k < end)
                    total[at] += self._terms(kind, step[at], first[at] + k)
            result[part] = total
        return result

    def _terms(self, kind: Summand, v: Any, summits: Integers) -> Floats:
        return _terms(kind, v, self._s[summits], self._k[summits])

    def _far(self, kind: Summand) -> PolynomialTable:
        """Tabulate the sum over contacts with s beyond the panel of v and the next two.

        The table holds the sum divided by v**kind.order, which is smooth on each panel of v.
        """
        points = 0.5 * (1.0 + NODES)
        halves = [_resample(side) for side in (0, 1)]
        weight = self._k * _power(self._s, kind.power)
        levels = self._panels.bit_length() - 1
        values = np.zeros((1, NODES.size))
        for level in range(levels + 1):
            shift = levels - level
            panel = self._panel >> shift
            width = self._width * (1 << shift)
            if level:
                # A panel inherits what its parent has; then come the summits that are far from it
                # but were near to its parent.
                values = np.stack([values @ half for half in halves], axis=1)
                values = values.reshape(-1, NODES.size)
            for distance in range(_NEAR_PANELS, 2 * _NEAR_PANELS):
                target = panel - distance
                new = (target >= 0) & (target < len(values))
                if level:
                    new &= (panel >> 1) - (target >> 1) < _NEAR_PANELS
                elif distance == _NEAR_PANELS:  # the root takes all that is far from everything
                    new, target = panel >= _NEAR_PANELS, np.zeros_like(panel)
                else:
                    continue
                if not new.any():
                    continue
                at, s = target[new], self._s[new]
                sums = np.empty((NODES.size, len(values)))
                for row, point in enumerate(points):
                    v = (at + point) * width
                    x = v / s
                    q = np.sqrt(1.0 - x)
                    terms = weight[new] * kind.share(x, q, x / (1.0 + q)) / v**kind.order
                    sums[row] = np.bincount(at, terms, minlength=len(values))
                values += sums.T
        end = self._width * self._panels
        return PolynomialTable.from_series(values @ TO_SERIES, end, kind.order, 0.0)


def _terms(kind: Summand, v: Any, s: Floats, k: Floats) -> Floats:
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        x = v / s
    x = np.where(s > 0.0, x, 0.0)
    q = np.sqrt(np.maximum(1.0 - x, 0.0))
    p = np.minimum(x, 1.0) / (1.0 + q)  # 1 - q without cancellation
    return np.asarray(k * _power(s, kind.power) * kind.share(x, q, p))


def _power(s: Floats, power: float) -> Floats:
    result = np.sqrt(s)
    for _ in range(int(power)):
        result = s * result
    return result


@lru_cache(maxsize=2)
def _resample(side: int) -> Floats:
    """Return the matrix from values at panel nodes to nodes of its lower (0) or upper half (1)."""
    inner = 0.5 * NODES + (side - 0.5)
    series = np.polynomial.chebyshev.chebvander(inner, NODES.size - 1)
    return np.ascontiguousarray(TO_SERIES @ series.T)


class Spheres:
    """Hertzian spheres: summit heights [m] and constants k = (4/3) E* sqrt(radius) (19.3)."""

    def __init__(self, heights: Floats, constants: Floats) -> None:
        order = np.argsort(heights)[::-1]
        self.heights = heights[order]
        self.constants = constants[order]
        self._contacts: dict[float, Contacts] = {}

    def __getstate__(self) -> dict[str, Any]:
        return {"heights": self.heights, "constants": self.constants, "_contacts": {}}

    def derivative(self, separation: Floats, order: int) -> Floats:
        """Return the derivative of N of order 0 to 2, or its integral to infinity (order -1)."""
        flat = separation.reshape(-1)
        result = np.zeros(flat.size)
        for part in blocks(flat.size, self.count(float(flat.min())), CACHED):
            count = self.count(float(flat[part].min()))
            s = np.maximum(self.heights[:count] - flat[part, None], 0.0)
            terms = np.sqrt(s)
            if order == 2:
                terms = np.divide(1.0, terms, out=terms, where=terms > 0.0)
            for _ in range(1 - order):
                terms *= s
            result[part] = DERIVATIVES[order] * (terms @ self.constants[:count])
        return result.reshape(separation.shape)

    def sum(self, kind: Summand, d: Floats | float, v: Floats) -> Floats:
        """Return the sum that ``kind`` defines at separations ``d`` for increments ``v`` [m]."""
        if isinstance(d, np.ndarray):
            result = np.zeros(v.size)
            for part in blocks(v.size, self.count(float(d.min())), CACHED):
                count = self.count(float(d[part].min()))
                s = np.maximum(self.heights[:count] - d[part, None], 0.0)
                result[part] = _terms(kind, v[part, None], s, self.constants[:count]).sum(axis=1)
            return result
        contacts = self._contacts.get(d)
        if contacts is None:
            count = self.count(d)
            contacts = Contacts(self.heights[:count] - d, self.constants[:count])
            # A handful of loads at a time, in a new dictionary: other threads may read the old.
            cached = dict(list(self._contacts.items())[-7:])
            cached[d] = contacts
            self._contacts = cached
        return contacts.sum(kind, v)

    def count(self, separation: float) -> int:
        """Return the number of summits higher than a separation [m]."""
        return int(np.searchsorted(-self.heights, -separation, side="left"))
