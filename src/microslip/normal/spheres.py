"""Sums over given summits, each a sphere: N = sum of k (y - d)^(3/2) over those with y > d."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from microslip._checks import Floats

_BLOCK = 1 << 18  # products held at a time
_FACTORS = {-1: 0.4, 0: 1.0, 1: -1.5, 2: 0.75}


_Share = Callable[[Floats, Floats, Floats], Floats]


def blocks(rows: int, columns: int) -> list[slice]:
    """Slices of the rows of a matrix, each of a size that a cache or two can hold."""
    step = max(1, _BLOCK // max(1, columns))
    return [slice(i, i + step) for i in range(0, rows, step)]


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

    def derivative(self, separation: Floats, order: int) -> Floats:
        """Derivative of the load, orders -1 (integral to infinity) to 2; any shape."""
        flat = separation.reshape(-1)
        result = np.zeros(flat.size)
        power = 1.5 - order
        for part in self._parts(flat.size, float(flat.min())):
            count = self._count(float(flat[part].min()))
            s = self.heights[:count] - flat[part, None]
            with np.errstate(divide="ignore"):
                terms = np.where(s > 0.0, np.maximum(s, 0.0) ** power, 0.0)
            result[part] = _FACTORS[order] * (terms @ self.constants[:count])
        return result.reshape(separation.shape)

    def drop(self, d: float, u: Floats) -> Floats:
        """N(d) - N(d + u): with q = sqrt(1 - u/s), s^(3/2) (1 - q)(1 + q + q^2) for each."""
        return self._sum(d, u, 1.5, lambda x, q, p: p * (1.0 + q + q * q))

    def excess(self, d: float, u: Floats) -> Floats:
        """Energy integral: s^(5/2) (1 - q)^3 (1 + 3q + q^2)/10, and x/2 - 2/5 once x = u/s > 1."""

        def share(x: Floats, q: Floats, p: Floats) -> Floats:
            return np.where(x > 1.0, 0.5 * x - 0.4, 0.1 * p**3 * (1.0 + q * (3.0 + q)))

        return self._sum(d, u, 2.5, share)

    def excess_slope(self, d: float, u: Floats) -> Floats:
        """Its derivative: s^(3/2) (1 - q)^2 (2 + q)/4."""
        return self._sum(d, u, 1.5, lambda x, q, p: 0.25 * p * p * (2.0 + q))

    def _sum(self, d: float, u: Floats, power: float, share: _Share) -> Floats:
        count = self._count(d)
        s = self.heights[:count] - d
        weight = self.constants[:count] * s**power
        result = np.empty(u.size)
        for part in self._parts(u.size, d):
            x = u[part, None] / s
            q = np.sqrt(np.maximum(1.0 - x, 0.0))
            p = np.minimum(x, 1.0) / (1.0 + q)  # 1 - q without cancellation
            result[part] = share(x, q, p) @ weight
        return result

    def _count(self, separation: float) -> int:
        """How many summits stand above a separation."""
        return int(np.searchsorted(-self.heights, -separation, side="left"))

    def _parts(self, size: int, separation: float) -> list[slice]:
        return blocks(size, self._count(separation))
