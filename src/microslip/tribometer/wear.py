"""Worn volume against dissipated energy, with and without a threshold, and against Archard's work.

Archard's law (1953, DOI 10.1063/1.1721448) charges normal load times sliding distance, the energy
law what was dissipated; with a threshold nothing wears up to some energy. After Fouvry, Liskiewicz,
Kapsa, Hannel and Sauger (2003, DOI 10.1016/S0043-1648(03)00117-0).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.tribometer.estimates import Estimate, quantile

_LEAST = 1e-3
"""Share of the work that is left of it at least, whatever its error."""
ENERGY, THRESHOLD, ARCHARD = "energy", "energy with a threshold", "Archard"


class Wear(NamedTuple):
    """A wear law: worn volume in proportion to something."""

    coefficient: Estimate
    """[m^3/J], or of Archard's law [m^3/(N m)], of a straight line."""
    records: tuple[str, ...]
    energy: Floats
    """Work of each record that wear is in proportion to [J] or [N m]."""
    volume: Floats
    """Worn volume [m^3]."""
    law: str = ENERGY
    threshold: Estimate | None = None
    """Below which nothing wears [J]."""
    scatter: float = math.nan
    """Standard deviation of the volumes beside the line [m^3]."""

    @property
    def has_threshold(self) -> bool:
        """Whether the threshold is above zero by its interval."""
        return self.threshold is not None and self.threshold.low > 0.0


def unlogged(
    law: Callable[[tuple[str, ...], Floats, Floats, float], Wear | None],
    names: tuple[str, ...],
    work: Floats,
    errors: Floats,
    volume: Floats,
    confidence: float,
) -> Wear | None:
    """A law whose coefficient also knows the errors of the work in cycles that were not logged.

    These are bounds, common to all records of a contact, so they are added and not squared.
    """
    wear = law(names, work, volume, confidence)
    if wear is None or not errors.any():
        return wear
    ends = (np.maximum(work - errors, _LEAST * work), work + errors)
    far = [law(names, end, volume, confidence) for end in ends]
    values = [wear.coefficient.value, *(w.coefficient.value for w in far if w is not None)]
    value, low, high, error, number = wear.coefficient
    below, above = value - min(values), max(values) - value
    if math.isnan(low):  # one volume: no scatter tells more
        low = high = value
    coefficient = Estimate(value, low - below, high + above, error, number)
    return wear._replace(coefficient=coefficient)


def proportional(names: tuple[str, ...], work: Floats, volume: Floats, confidence: float) -> Wear:
    """A straight line through zero by least squares."""
    if not np.all(work > 0.0):
        raise InputError(
            "an energy wear coefficient needs records that dissipate energy, got "
            f"{float(work.min()):.3g} J; is the sign of the force right?"
        )
    square = float(work @ work)
    slope = float(work @ volume) / square
    if work.size < 2:
        nothing = math.nan
        return Wear(Estimate(slope, nothing, nothing, nothing, 1), names, work, volume)
    residual = volume - slope * work
    scatter = math.sqrt(float(residual @ residual) / (work.size - 1))
    error = scatter / math.sqrt(square)
    half = quantile(confidence, work.size - 1) * error
    coefficient = Estimate(slope, slope - half, slope + half, error, int(work.size))
    return Wear(coefficient, names, work, volume, scatter=scatter)


def with_threshold(
    names: tuple[str, ...], work: Floats, volume: Floats, confidence: float
) -> Wear | None:
    """A straight line that begins at some energy; None where the records do not tell one.

    The interval of the threshold is Fieller's (1954), which is exact for straight lines.
    """
    if work.size < 3 or not np.ptp(work) > 0.0:
        return None
    middle, height = float(work.mean()), float(volume.mean())
    away = work - middle
    square = float(away @ away)
    slope = float(away @ volume) / square
    residual = volume - height - slope * away
    freedom = work.size - 2
    scatter = math.sqrt(float(residual @ residual) / freedom)
    reach = quantile(confidence, freedom) * scatter
    # Where the line may be zero: (height - slope d)^2 <= reach^2 (1/n + d^2/square).
    leading = slope**2 - reach**2 / square
    if leading <= 0.0 or slope <= 0.0:
        return None
    root = reach * math.sqrt(max(height**2 / square + leading / work.size, 0.0))
    low, high = (middle - (slope * height + sign * root) / leading for sign in (1.0, -1.0))
    error = scatter / math.sqrt(square)
    half = reach / math.sqrt(square)
    count = int(work.size)
    start = middle - height / slope
    of_start = (high - low) / (2.0 * quantile(confidence, freedom))
    return Wear(
        Estimate(slope, slope - half, slope + half, error, count),
        names,
        work,
        volume,
        THRESHOLD,
        Estimate(start, low, high, of_start, count),
        scatter,
    )
