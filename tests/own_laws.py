"""A law and heights that somebody adds: what one file holds, and no list of the package."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import microslip as ms
from microslip._core.checks import Floats
from microslip._core.parameters import parameter


@dataclass(frozen=True)
class Hyperbola(ms.BackboneLaw):
    """T0 = k u/(1 + k u/F), whose tail is algebraic: at 100 reaches 1 % of its limit is left."""

    stiffness: float = field(metadata=parameter("k", "N/m", "stiffness at rest", above=0.0))
    force_limit: float = field(metadata=parameter("F", "N", "force of gross slip", above=0.0))

    def _backbone(self, u: Floats) -> Floats:
        x = u * (self.stiffness / self.force_limit)
        return self.force_limit * (x / (1.0 + x))

    def _slope(self, u: Floats) -> Floats:
        return self.stiffness / (1.0 + u * (self.stiffness / self.force_limit)) ** 2

    @classmethod
    def examples(cls) -> tuple[Hyperbola, ...]:
        """A stiff one and a soft one."""
        return cls(stiffness=5e7, force_limit=100.0), cls(stiffness=1e3, force_limit=2e-3)


@dataclass(frozen=True)
class Ramp(ms.HeightDistribution):
    """Heights from 0 to a top, the more the higher: density 2 y/top^2."""

    highest: float = field(metadata=parameter("y_t", "m", "highest summit", above=0.0))

    edge = 0.0

    @property
    def top(self) -> float:
        """The highest summit [m]."""
        return self.highest

    @property
    def spread(self) -> float:
        """Standard deviation [m]."""
        return self.highest / math.sqrt(18.0)

    @property
    def span(self) -> tuple[float, float]:
        """All of them [m]."""
        return 0.0, self.highest

    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        # Between max(t, 0) and the top, with s = y - t: integral of 2 (s + t) s^n ds/top^2.
        n = 0.5 * twice_order
        t = np.minimum(threshold, self.highest)
        low, high = np.maximum(-t, 0.0), self.highest - t

        def inner(s: Any) -> Any:
            return s ** (n + 1.0) * (s / (n + 2.0) + t / (n + 1.0))

        return np.asarray(2.0 / self.highest**2 * (inner(high) - inner(low)))

    def _density(self, height: Floats) -> Floats:
        inside = (height >= 0.0) & (height <= self.highest)
        return np.where(inside, 2.0 * height / self.highest**2, 0.0)

    @classmethod
    def examples(cls) -> tuple[ms.HeightDistribution, ...]:
        """One top stands for all."""
        return (cls(highest=2e-6),)


LAWS = (*ms.friction.LAWS, Hyperbola)
"""What the shared tests run over."""
HEIGHTS = (*ms.contact.heights.HEIGHTS, Ramp)
