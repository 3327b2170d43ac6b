"""The rough joint of most tests of structures, and a chain of three masses with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import microslip as ms

METAL = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(METAL, METAL)


def rough(heights: Any, pair: ms.MaterialPair = PAIR, area: float = 2e-4) -> ms.GreenwoodWilliamson:
    """The summits of the worked example with other heights, bodies and areas."""
    return ms.GreenwoodWilliamson(pair, heights, radius=1e-3, density=1e8, area=area)


def slope(call: Callable[[float], Any], step: float) -> Any:
    """Derivative of a function at zero, by a central difference."""
    return (call(step) - call(-step)) / (2.0 * step)


def fine_slope(call: Callable[[float], Any], step: float) -> Any:
    """Derivative of a function at zero, by a central difference of fourth order."""
    return (4.0 * slope(call, step) - slope(call, 2.0 * step)) / 3.0


SURFACE = rough(ms.Gaussian(std=5e-7))
JOINT = ms.Interface(SURFACE, 0.55, normal_load=2000.0)
SLIP = JOINT.force_limit / JOINT.tangential_stiffness
MASS = np.diag([2.0, 3.0, 2.0])
SPRING = 2e9
STIFFNESS = SPRING * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
BETWEEN = np.array([1.0, -1.0, 0.0])
