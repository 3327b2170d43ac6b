"""The friction log: the force over displacement and cycle, for both directions of motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

MOST_CYCLES, PLACES = 96, 64
_LEAST = 6


class FrictionLog(NamedTuple):
    """The force of some of the cycles, spread evenly over the logarithm of their number."""

    rows: NDArray[np.intp]
    """Numbers of the cycles, the first being 0."""
    place: Floats
    """Displacement from its middle, of the amplitude [-]."""
    forward: Floats
    """Force [N] by cycle and place, the displacement rising; the force's middle is taken off."""
    backward: Floats
    """The same, the displacement falling."""


def friction_log(x: Floats, force: Floats, columns: Mapping[str, Floats]) -> FrictionLog | None:
    """The log of a record; None of a few cycles."""
    count = columns["start"].size
    if count < _LEAST:
        return None
    rows = np.unique(np.rint(np.geomspace(1.0, count, MOST_CYCLES)).astype(np.intp) - 1)
    place = np.linspace(-1.0, 1.0, PLACES)
    ways = np.full((2, rows.size, PLACES), np.nan)
    for at, row in enumerate(rows):
        first = int(columns["start"][row])
        part = slice(first, first + int(columns["period"][row]) + 1)
        amplitude = float(columns["amplitude"][row])
        if not amplitude > 0.0:
            continue
        share = (x[part] - columns["displacement_offset"][row]) / amplitude
        away = force[part] - columns["force_offset"][row]
        # Noise turns the displacement at its ends only if it is smoothed over a few samples.
        width = max(share.size // 64, 1)
        rising = share[2 * width :] - share[: -2 * width] > 0.0
        middle, forces = share[width:-width], away[width:-width]
        for way, chosen in zip(ways, (rising, ~rising), strict=True):
            if chosen.any():
                order = np.argsort(middle[chosen], kind="stable")
                way[at] = np.interp(place, middle[chosen][order], forces[chosen][order])
    return FrictionLog(rows, place, ways[0], ways[1])
