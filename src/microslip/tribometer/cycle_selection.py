"""Floor 6: which cycles of a record the means are of, and what to say of the others."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from microslip._core.wording import plural
from microslip.errors import InputError
from microslip.tribometer.spikes import Spike

OPEN = 0.25
"""Closure error beyond which a cycle is not one of those that the means are of."""
_MOST_LOSS = 1.05 * 4.0 / math.pi  # of a rectangle; noise may make its corners a little less


def counted_cycles(
    columns: Mapping[str, NDArray[np.float64]], spikes: tuple[Spike, ...]
) -> tuple[NDArray[np.bool_], list[str]]:
    """The cycles that the means are of, and what to say of the others."""
    notes = []
    closure, first = columns["closure_error"], columns["start"]
    last = first + columns["period"]
    sound = np.ones(closure.size, dtype=bool)
    for spike in spikes:
        sound &= (last < spike.first) | (first > spike.last)
    texts = "; ".join(map(str, spikes[:3])) + ("; ..." if len(spikes) > 3 else "")
    if not sound.any():
        raise InputError(
            f"no cycle is without a spike: {plural(len(spikes), 'spike')}, {texts}; look at the "
            "sensor and its cable, or leave these samples out"
        )
    if not sound.all():
        notes.append(
            f"left out of the means: {_cycles(~sound)} with a spike, here straight lines: {texts}"
        )
    elif spikes:
        notes.append(f"spikes beyond the whole cycles: {texts}")
    closed = closure <= OPEN
    if not (sound & closed).any():
        notes.append("no cycle closes, the ends of each differ by over a quarter of the force")
        return sound, notes
    if not closed.all():
        notes.append(
            f"left out of the means: {_cycles(~closed)} whose ends differ by over a quarter of "
            "the force, as in running in"
        )
    return sound & closed, notes


def excess_loss_notes(loss_factor: NDArray[np.float64]) -> list[str]:
    """What to say of loops that are larger than the rectangle around them."""
    large = loss_factor > _MOST_LOSS
    if not large.any():
        return []
    return [
        f"a loss factor above 4/π = 1.27, up to {float(np.nanmax(loss_factor)):.3g}, in "
        f"{_cycles(large)}: no closed loop has more than the rectangle around it, so these "
        "channels are no loop, have spikes, or a rig softer than it is was taken off"
    ]


def _cycles(is_named: NDArray[np.bool_]) -> str:
    """Such as "2 cycles (3, 8)"."""
    places = np.flatnonzero(is_named) + 1
    numbers = ", ".join(map(str, places[:5])) + (", ..." if places.size > 5 else "")
    return f"{plural(places.size, 'cycle')} ({numbers})"
