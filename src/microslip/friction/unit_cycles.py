"""Cycles of amplitude one, kept for the next loop of as many samples."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from microslip._core.checks import Floats, floats, show, whole
from microslip._core.frozen import lock
from microslip.errors import Argument, InputError
from microslip.loops import unit_cycle

MOST_SAMPLES = 10_000_000


def checked_cycle(amplitude: float, samples: int) -> tuple[float, Floats, int]:
    """An amplitude, the samples of a cycle of amplitude one, and the index of -1 among them."""
    count = whole("samples", samples, 5, MOST_SAMPLES)
    a = floats("amplitude", amplitude)
    if a.ndim > 0 or a <= 0.0:
        raise InputError(
            Argument("amplitude"), f" must be one number above zero [m], got {show(amplitude)}"
        )
    return (float(a), *shape_of(count))


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
