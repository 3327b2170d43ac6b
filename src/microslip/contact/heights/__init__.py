"""Distributions of summit heights and their partial moments."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip.contact.heights.base import HeightDistribution as HeightDistribution
from microslip.contact.heights.closed_forms import Discrete as Discrete
from microslip.contact.heights.closed_forms import Exponential as Exponential
from microslip.contact.heights.closed_forms import Gaussian as Gaussian
from microslip.contact.heights.statistical import Statistical as Statistical
from microslip.contact.heights.tabulated import TabulatedHeights as TabulatedHeights

HEIGHTS: tuple[type[HeightDistribution], ...] = (
    Gaussian,
    Exponential,
    Discrete,
    Statistical,
    TabulatedHeights,
)
"""Every height distribution; the shared tests run over it."""


def as_heights(value: Any) -> HeightDistribution:
    """Convert a scipy.stats distribution or an array; return a HeightDistribution unchanged."""
    if isinstance(value, HeightDistribution):
        return value
    if hasattr(value, "sf"):
        return Statistical(value)
    if isinstance(value, (list, tuple, np.ndarray)):
        return Discrete(value)
    raise InputError(
        "`heights` must be ms.Gaussian(std=...), ms.Exponential(scale=...), "
        "ms.TabulatedHeights(height, density), a frozen scipy.stats distribution or an "
        f"array of heights [m], got {show(value)}"
    )
