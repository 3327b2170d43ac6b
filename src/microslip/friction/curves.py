"""Load curves asked one separation at a time, for laws that no profile gives."""

from __future__ import annotations

import math

import numpy as np

from microslip.normal import NormalLaw
from microslip.normal.spheres import Spheres


class LawCurve:
    """The load curve of a law, one separation at a time."""

    def __init__(self, law: NormalLaw, origin: float) -> None:
        self._law, self._origin = law, origin

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""
        return float(self._law._drop(base + self._origin, np.array([width]))[0])

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""
        there = separation + self._origin
        return self._law._derivative_at(there, 0), -self._law._derivative_at(there, 1)


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
