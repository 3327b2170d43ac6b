"""Slip regime of measured cycles (stick, partial or gross slip), by the thresholds of a law."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip.friction import BackboneLaw
from microslip.laboratory.estimates import chance_below

REGIMES = ("stick", "partial slip", "gross slip")
ONSET = 0.99
"""Force over its limit at gross slip, for laws that only approach the limit."""
RESOLVED = 1e-3
"""Smallest energy ratio of partial slip, for laws without losses below their yield."""


class Thresholds(NamedTuple):
    """Thresholds between stick, partial slip and gross slip, on the energy ratios A and B."""

    stick: float
    """Largest energy ratio A of stick."""
    gross: float
    """Smallest ratio B (Fouvry) of gross slip."""
    source: str
    """Source of the thresholds."""


_OF_SPHERE = Thresholds(0.0033783480491788817, 0.7694644203726145, "one sphere")
"""Sphere (19.15): A where T0 is 1 % below its first tangent, and B = 0.2/(2^(1/3) - 1) at the
slip limit."""


def thresholds(model: BackboneLaw | None = None) -> Thresholds:
    """Return the thresholds between the regimes for a law, by default those of one sphere."""
    if model is None:
        return _OF_SPHERE
    bent, onset, word = _ends_of(model)
    peak = float(model.backbone(onset))
    width = abs(onset - 2.0 * float(model.backbone_displacement(0.5 * peak)))
    # Where the onset is the yield of a single slider nothing slides yet: any sliding is gross.
    energy = float(model.dissipated_energy(onset))
    gross = energy / (4.0 * peak * width) if width > 1e-6 * onset else 0.0
    stick = max(float(model.energy_ratio(bent)), RESOLVED)
    return Thresholds(stick, gross, f"{type(model).__name__} at {word}")


def _ends_of(model: BackboneLaw) -> tuple[float, float, str]:
    """Return the displacements [m] at the end of stick and at gross slip.

    The third item describes how gross slip was defined.
    """
    if not isinstance(model, BackboneLaw):
        raise InputError(f"`model` must be a backbone law, such as an Interface, got {show(model)}")
    first = model.tangential_stiffness
    if not math.isfinite(first):
        raise InputError(
            f"`model` must have a finite stiffness at rest, and {type(model).__name__} is "
            "rigid there"
        )
    limit = model.force_limit
    nearly = float(model.backbone_displacement(ONSET * limit))
    onset, word = nearly, "99 % of its limit"
    if float(model.backbone(1.5 * nearly)) >= limit * (1.0 - 1e-12):
        # It reaches its limit: at the first place from which it rises no more.
        reached = limit * (1.0 - 1e-12)
        onset = _first(lambda u: float(model.backbone(u)) >= reached, nearly, 1.5 * nearly)
        word = "its limit"
    bent = _first(lambda u: float(model.backbone(u)) < 0.99 * first * u, 0.0, onset, 200)
    return bent, onset, word


def _first(holds: Callable[[float], bool], low: float, high: float, steps: int = 100) -> float:
    """Return by bisection the smallest value in [low, high] from which a condition holds."""
    for _ in range(steps):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


class RecordRegimes(NamedTuple):
    """Slip regime of each cycle of a record, and probability of each regime for the mean cycle."""

    of_each: tuple[str, ...]
    """Regime of each cycle; settled cycles have that of their mean."""
    probability: dict[str, float]
    """Probability of each regime for the mean."""


def regimes_of(
    columns: Mapping[str, Floats],
    limits: Thresholds,
    is_counted: NDArray[np.bool_],
    is_moving: bool,
) -> RecordRegimes:
    """Return the slip regime of each cycle, and the probabilities of the mean cycle's regime."""
    energy, force = columns["dissipated_energy"], columns["force_amplitude"]
    below = _chance_below(energy, 4.0 * columns["amplitude"] * force, limits.stick, is_counted)
    short = _chance_below(
        energy, 4.0 * force * columns["sliding_distance"], limits.gross, is_counted
    )
    likely = dict(
        zip(REGIMES, (below, (1.0 - below) * short, (1.0 - below) * (1.0 - short)), strict=True)
    )
    stick = ~(columns["energy_ratio"] > limits.stick)
    gross = ~stick & (columns["fouvry_ratio"] >= limits.gross)
    cycle_regimes = tuple(
        REGIMES[0 if s else 2 if g else 1] for s, g in zip(stick, gross, strict=True)
    )
    if is_moving:
        share = {name: cycle_regimes.count(name) / max(len(cycle_regimes), 1) for name in REGIMES}
        return RecordRegimes(cycle_regimes, share)
    mean = max(REGIMES, key=lambda name: likely[name])
    pairs = zip(cycle_regimes, is_counted.tolist(), strict=True)
    return RecordRegimes(
        tuple(mean if is_chosen else regime for regime, is_chosen in pairs), likely
    )


def _chance_below(
    above: Floats, under: Floats, limit: float, is_counted: NDArray[np.bool_]
) -> float:
    """Return the probability [-] that mean ``above`` over mean ``under`` is at most a limit."""
    fine = is_counted & np.isfinite(above) & np.isfinite(under)
    return chance_below(above[fine] - limit * under[fine])
