"""Cycles of amplitude one, kept for the next loop of as many samples."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from microslip._core.checks import Floats, floats, show
from microslip._core.frozen import lock
from microslip.errors import Argument, InputError
from microslip.loops import unit_cycle


def checked_cycle(amplitude: float, samples: int) -> tuple[float, Floats, int]:
    """An amplitude, the samples of a cycle of amplitude one, and the index of -1 among them."""
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < 5:
        raise InputError(
            Argument("samples"), f" must be an integer of at least 5, got {show(samples)}"
        )
    a = floats("amplitude", amplitude)
    if a.ndim > 0 or a <= 0.0:
        raise InputError(
            Argument("amplitude"), f" must be one number above zero [m], got {show(amplitude)}"
        )
    return (float(a), *shape_of(int(samples)))


@lru_cache(maxsize=32)
def shape_of(samples: int) -> tuple[Floats, int]:
    """Samples of a cycle of amplitude one, and the index of -1 among them."""
    shape, turn = unit_cycle(samples)
    return lock(shape), turn


@lru_cache(maxsize=32)
def halves_of(samples: int) -> Floats:
    """Half the distance of each sample of the unit cycle from the turning point before it."""
    shape, turn = shape_of(samples)
    return lock(0.5 * np.concatenate((1.0 - shape[: turn + 1], 1.0 + shape[turn + 1 :])))
