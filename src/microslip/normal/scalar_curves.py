"""Load curves evaluated one separation at a time, for laws without a profile."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Protocol

import numpy as np

from microslip.normal.base import NormalLaw
from microslip.normal.spheres import Spheres
from microslip.normal.spline import Spline

_SMALL_DROP = 1e-3  # of the load
_CACHED_LOADS = 64
_FEW_SUMMITS = 24  # for which plain Python is quicker than arrays


class ScalarCurve(Protocol):
    """A load curve, asked one separation at a time."""

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""


def scalar_curve(law: NormalLaw, origin: float) -> ScalarCurve:
    """The load curve of a law; separations count from ``origin``."""
    if law._spline is not None:
        return TableCurve(law._spline, origin)
    spheres = law._spheres
    if spheres is None:
        return LawCurve(law, origin)
    kind = SpheresCurve if spheres.heights.size <= _FEW_SUMMITS else ManySpheresCurve
    return kind(spheres, origin)


class LawCurve:
    """The load curve of any law."""

    def __init__(self, law: NormalLaw, origin: float) -> None:
        self._law, self._origin = law, origin
        self._loads_at: dict[float, tuple[float, float]] = {}

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""
        here, fall = self.load(base)
        if width * fall > _SMALL_DROP * here:  # the difference loses no digit that counts
            return here - self.load(base + width)[0]
        return float(self._law._drop(base + self._origin, np.array([width]))[0])

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'; a solver asks for those of one place again and again."""
        pair = self._loads_at.get(separation)
        if pair is None:
            there = separation + self._origin
            pair = self._law._derivative_at(there, 0), -self._law._derivative_at(there, 1)
            if len(self._loads_at) >= _CACHED_LOADS:
                self._loads_at = {}  # a new one: other threads may read the old
            self._loads_at[separation] = pair
        return pair


class SpheresCurve:
    """The same of a few spheres, in plain Python: arrays of a few are slow."""

    def __init__(self, spheres: Spheres, origin: float) -> None:
        heights = (spheres.heights - origin).tolist()
        self._spheres = list(zip(heights, spheres.constants.tolist(), strict=True))

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w), as DROP of normal/spheres.py."""
        total = 0.0
        for height, constant in self._spheres:
            s = height - base
            if s <= 0.0:
                break
            x = min(width / s, 1.0)
            q = math.sqrt(1.0 - x)
            total += constant * s * math.sqrt(s) * (x / (1.0 + q)) * (1.0 + q * (1.0 + q))
        return total

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""
        load = fall = 0.0
        for height, constant in self._spheres:
            s = height - separation
            if s <= 0.0:
                break
            root = constant * math.sqrt(s)
            load += s * root
            fall += 1.5 * root
        return load, fall


class ManySpheresCurve:
    """The same of many: each is visited once a question."""

    def __init__(self, spheres: Spheres, origin: float) -> None:
        self._heights, self._constants = spheres.heights - origin, spheres.constants
        self._depths = -self._heights

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""
        count = int(np.searchsorted(self._depths, -base, side="left"))
        s = self._heights[:count] - base
        beyond = np.maximum(s - width, 0.0)
        root, inner = np.sqrt(s), np.sqrt(beyond)
        # A^3 - B^3 for the roots A and B, without cancellation.
        terms = np.minimum(s, width) * (s + root * inner + beyond) / (root + inner)
        return float(terms @ self._constants[:count])

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""
        count = int(np.searchsorted(self._depths, -separation, side="left"))
        s = self._heights[:count] - separation
        roots = np.sqrt(s) * self._constants[:count]
        return float(s @ roots), 1.5 * float(roots.sum())


class TableCurve:
    """The same of a table: parabolas between its knots, in plain Python."""

    def __init__(self, spline: Spline, origin: float) -> None:
        self._knots: list[float] = (spline.knots - origin).tolist()
        self._last = len(self._knots) - 2  # the last piece
        self._curvatures: list[float] = spline.curvatures.tolist()
        self._loads: list[float] = spline.loads.tolist()
        self._slopes: list[float] = spline.slopes.tolist()
        self._ends: list[float] = spline.ends.tolist()
        # Of positive terms, so that a fall over some pieces is right to rounding.
        drops = -0.5 * np.diff(spline.knots) * (spline.slopes[:-1] + spline.ends)
        self._falls: list[float] = drops.tolist()
        self._tail = spline.decay_length if spline.has_tail else 0.0

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""
        knots, last = self._knots, self._last
        if base >= knots[-1]:
            if not self._tail:
                return 0.0
            return -self.load(base)[0] * math.expm1(-width / self._tail)
        i = max(bisect_right(knots, base) - 1, 0)
        r, curve, slope = knots[i + 1] - base, self._curvatures[i], -self._ends[i]
        if width <= r:
            return width * (slope + curve * (r - 0.5 * width))
        total = r * (slope + 0.5 * curve * r)
        j = max(bisect_right(knots, base + width) - 1, i + 1)
        total += sum(self._falls[i + 1 : j])
        h = max(width - (knots[j] - base), 0.0)
        if j <= last:
            return total + h * (-self._slopes[j] - 0.5 * self._curvatures[j] * h)
        return total - (self._loads[-1] * math.expm1(-h / self._tail) if self._tail else 0.0)

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""
        past = separation - self._knots[-1]
        if past >= 0.0:
            if not self._tail:
                return 0.0, 0.0
            load = self._loads[-1] * math.exp(-past / self._tail)
            return load, load / self._tail
        i = max(bisect_right(self._knots, separation) - 1, 0)
        r, curve, slope = self._knots[i + 1] - separation, self._curvatures[i], -self._ends[i]
        return self._loads[i + 1] + r * (0.5 * r * curve + slope), slope + r * curve
