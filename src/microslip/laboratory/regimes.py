"""Slip regime of measured cycles (stick, partial or gross slip), by the thresholds of a sphere."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip.laboratory.estimates import chance_below_zero

REGIMES = ("stick", "partial slip", "gross slip")
STICK, GROSS = 0.0033783480491788817, 0.7694644203726145
"""Largest energy ratio A of stick, and smallest ratio B of gross slip, of one sphere (19.15): A
where T0 is 1 % below its first tangent, and B = 0.2/(2^(1/3) - 1) at the slip limit."""


def regimes_of(
    columns: Mapping[str, Floats],
    is_counted: NDArray[np.bool_],
    is_moving: bool,
) -> tuple[tuple[str, ...], dict[str, float]]:
    """Return the slip regime of each cycle, and the probability of each regime for their mean.

    The mean is over the cycles ``is_counted``. If these have a trend, ``is_moving``, their fraction
    in each regime takes the place of its probability.
    """
    energy, force = columns["dissipated_energy"], columns["force_amplitude"]
    below, short = (
        chance_below_zero(away[is_counted & np.isfinite(away)])
        for away in (
            energy - STICK * (4.0 * columns["amplitude"] * force),
            energy - GROSS * (4.0 * force * columns["sliding_distance"]),
        )
    )
    likely = dict(
        zip(REGIMES, (below, (1.0 - below) * short, (1.0 - below) * (1.0 - short)), strict=True)
    )
    stick = ~(columns["energy_ratio"] > STICK)
    gross = ~stick & (columns["fouvry_ratio"] >= GROSS)
    cycle_regimes = tuple(
        REGIMES[0 if s else 2 if g else 1] for s, g in zip(stick, gross, strict=True)
    )
    if is_moving:
        counted = [cycle_regimes[i] for i in np.flatnonzero(is_counted)]
        return cycle_regimes, {name: counted.count(name) / len(counted) for name in REGIMES}
    mean = max(REGIMES, key=lambda name: likely[name])
    pairs = zip(cycle_regimes, is_counted.tolist(), strict=True)
    return tuple(mean if is_chosen else regime for regime, is_chosen in pairs), likely
