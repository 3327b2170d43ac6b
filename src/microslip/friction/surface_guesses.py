"""Initial guesses of a rough surface from loops."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip.contact import GreenwoodWilliamson, NormalLaw
from microslip.contact.base import check_pair
from microslip.contact.heights import Gaussian, HeightDistribution, as_heights
from microslip.contact.materials import MaterialPair
from microslip.friction.guesses import (
    Features,
    Scaled,
    all_features,
    fit_limit_and_length,
    loads_per_loop,
)

CONVENTIONAL_AREA = 1e-4
"""Apparent area [m^2] if unknown; loops do not depend on it."""

_SPREAD = 0.05
"""Conventional density * radius * std [-], since loops determine only density * sqrt(radius).

Measured engineering surfaces have a few hundredths (Greenwood and Williamson 1966,
DOI 10.1098/rspa.1966.0242). Loops do not depend on it; contact counts and areas do.
"""


@dataclass(frozen=True)
class Shape:
    """Normal law with lengths in a given ``unit`` [m]."""

    law: NormalLaw
    unit: float

    def separation(self, z: float, ratio: float) -> float:
        """Return the separation at which the load is ``ratio`` times the load at z."""
        if ratio == 1.0:
            return z
        load = ratio * self.law._derivative_at(z * self.unit, 0)
        return float(self.law.separation(load)) / self.unit

    def share(self, z: float, x: Floats) -> Floats:
        """Return the force over the force limit at steps x from z: 1 - n(z + x)/n(z)."""
        load = self.law._derivative_at(z * self.unit, 0)
        return self.law._drop(z * self.unit, x * self.unit) / load


def shape_of(heights: HeightDistribution, pair: MaterialPair) -> tuple[Shape, tuple[float, float]]:
    """Return the shape of the heights and its range of standardised separations."""
    unit = heights.spread
    if not unit > 0.0:
        raise InputError(f"`heights` must differ from one another, got {show(heights)}")
    law = GreenwoodWilliamson(pair, heights, radius=1.0, density=1.0, area=1.0)
    low, high = (end / unit for end in heights.span)
    return Shape(law, unit), (low, 0.999 * high + 0.001 * low)


_STEPS = np.concatenate(([0.0], np.geomspace(1e-5, 100.0, 240)))


def fit_interface(
    data: Any, loads: Sequence[float], reference: float, shape: Shape, span: tuple[float, float]
) -> tuple[float, float, float]:
    """Fit the friction coefficient, slip scale [m] and separation at the reference load."""
    features = all_features(data)
    best = (math.inf, 0.0, 0.0, 0.0)
    low, high = max(span[0], -1.0), min(span[1], 5.0)
    if not low < high:
        low, high = span
    # Separations at which a load exceeds the range of the heights are skipped.
    for count in (7, 5):
        grid = np.linspace(low, high, count)
        for z in grid.tolist():
            try:
                curves = [
                    shape.share(shape.separation(z, load / reference), _STEPS) for load in loads
                ]
            except InputError:
                continue
            fit = _fit_all(features, loads, curves)
            if fit.misfit < best[0]:
                best = (fit.misfit, fit.limit, fit.length, z)
        step = 0.7 * float(grid[1] - grid[0])
        low, high = max(span[0], best[3] - step), min(span[1], best[3] + step)
    if not math.isfinite(best[0]):
        raise InputError(
            "`normal_load` must be in the range that one surface with these heights carries, got "
            f"{min(loads):g} to {max(loads):g} N"
        )
    return best[1], best[2], best[3]


def _fit_all(features: Sequence[Features], loads: Sequence[float], curves: list[Floats]) -> Scaled:
    """Fit a common length and limits proportional to the loads; see :func:`fit_shape`."""
    # Each loop has the same weight, independent of its load.
    sizes = [1.0 / math.sqrt(float(f.backbone @ f.backbone)) for f in features]
    force = np.concatenate([f.backbone * size for f, size in zip(features, sizes, strict=True)])
    parts = list(zip(features, loads, sizes, curves, strict=True))

    def rows(lengths: Floats) -> Floats:
        return np.concatenate(
            [
                (load * size) * np.interp(f.half / lengths[:, None], _STEPS, curve)
                for f, load, size, curve in parts
            ],
            axis=1,
        )

    shortest = min(float(f.half.min()) for f in features)
    largest = max(f.amplitude for f in features)
    return fit_limit_and_length(rows, force, 0.2 * shortest, 50.0 * largest)


def guess_surface(
    data: Any,
    pair: MaterialPair,
    normal_load: Any,
    heights: Any,
    radius: float | None,
    area: float | None,
) -> tuple[GreenwoodWilliamson, float, float]:
    """Fit surface, coefficient of friction and mean load [N]; see :meth:`Interface.guess`."""
    check_pair(pair)
    loads = loads_per_loop(normal_load, len(all_features(data)), data)
    shape_heights = Gaussian(std=1.0) if heights is None else as_heights(heights)
    shape, span = shape_of(shape_heights, pair)
    mean = math.exp(float(np.mean(np.log(loads))))
    friction, slip, separation = fit_interface(data, loads, mean, shape, span)
    std = slip / (friction * pair.stiffness_ratio)
    area = positive("area", CONVENTIONAL_AREA if area is None else area, "m^2")
    unit = GreenwoodWilliamson(pair, shape_heights._scaled(std / shape.unit), 1.0, 1.0, area)
    root = mean / unit.load(separation * std)  # density * sqrt(radius)
    size = (_SPREAD / (root * std)) ** 2 if radius is None else radius
    size = positive("radius", size, "m")
    return (
        replace(unit, radius=size, density=root / math.sqrt(size)),
        friction,
        mean,
    )
