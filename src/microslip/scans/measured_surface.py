"""A rough surface fitted to summits of a scan, with the height that those reached."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from microslip.friction.validity import TAIL_RULE
from microslip.normal import GreenwoodWilliamson
from microslip.numerics.quadrature import gauss_legendre

Heights = Literal["gaussian", "table", "discrete", "population"]
"""Laws of the heights of summits that were counted."""

TAIL = TAIL_RULE.name

_PANELS = 32


@dataclass(frozen=True, eq=False)
class MeasuredSurface(GreenwoodWilliamson):
    """A surface of fitted summit heights, with the height above which none was measured."""

    highest: float = np.inf
    """Height [m] of the highest summit that was measured; it enters no load, only the verdict."""

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        share = 0.0 if separation is None else self.load_share_above(self.highest, separation)
        return {**super()._assumptions(separation), TAIL: share}

    def load_share_above(self, height: float, separation: float) -> float:
        """Share [-] of the load at a separation [m] that summits above a height [m] carry.

        The partial moment of order 3/2 about the separation, from the height upwards: by parts,
        (t - d)^(3/2) F_0(t) + 3/2 times the integral of (y - d)^(1/2) F_0(y) above t, where F_0
        is the share of summits that are higher.
        """
        heights, start = self._heights, max(height, separation)
        end = min(heights.top, start + 40.0 * heights.spread)
        if not end > start:
            return 0.0
        nodes, weights = gauss_legendre(16)
        # Panels that grow from the start: F_0 falls fast, and above d the root is steep.
        edges = start + (end - start) * np.linspace(0.0, 1.0, _PANELS + 1) ** 3
        width = np.diff(edges)
        y = edges[:-1, None] + width[:, None] * nodes
        above = heights._moment(0, y.ravel()).reshape(y.shape)
        integral = float(((np.sqrt(y - separation) * above) @ weights) @ width)
        first = (start - separation) ** 1.5 * heights._moment_at(0, start)
        share: float = (first + 1.5 * integral) / heights._moment_at(3, separation)
        return min(share, 1.0)
