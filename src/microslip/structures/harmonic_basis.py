"""Periodic motions by their Fourier coefficients: [mean,] cos 1, sin 1, cos 3, sin 3 and so on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from microslip._core.checks import Floats, rising_orders, show, whole_number
from microslip._core.frozen import lock
from microslip.errors import InputError

MOST_SAMPLES = 1 << 16
_MOST_ORDER = 1000


@dataclass(frozen=True)
class HarmonicBasis:
    """Which harmonics a motion has, and the samples of a period it is looked at."""

    harmonics: tuple[int, ...]
    """Rising; 0, the mean, is always among them."""
    samples: int

    @property
    def size(self) -> int:
        """Coefficients of a motion."""
        return 2 * len(self.harmonics) - 1

    @cached_property
    def orders(self) -> Floats:
        """The harmonic of each coefficient."""
        return lock(np.repeat(np.array(self.harmonics, dtype=float), 2)[1:])

    def work(self, force: Floats, displacement: Floats) -> Floats:
        """Work of a force over a period, of coefficients in the last axis."""
        cosines, sines = slice(1, None, 2), slice(2, None, 2)
        crossed = (
            force[..., cosines] * displacement[..., sines]
            - force[..., sines] * displacement[..., cosines]
        )
        return math.pi * np.asarray(crossed @ self.orders[cosines])


def harmonic_basis(harmonics: Sequence[int], samples: Any) -> HarmonicBasis:
    """The basis of these harmonics, the mean and the fundamental among them, or an error."""
    orders = rising_orders("harmonics", harmonics)
    if 1 not in orders:
        raise InputError(
            f"harmonics must have 1 among them, got {show(harmonics)}; write harmonics=[1, 3]"
        )
    if orders[-1] > _MOST_ORDER:
        raise InputError(f"harmonics must be at most {_MOST_ORDER}, got {orders[-1]}")
    samples = whole_number("samples", samples, 1, MOST_SAMPLES)
    if samples < 4 * orders[-1]:
        raise InputError(
            f"samples must be at least {4 * orders[-1]}, four a period of the highest one, "
            f"got {samples}"
        )
    return HarmonicBasis(tuple(sorted({0, *orders})), samples)
