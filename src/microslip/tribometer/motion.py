"""Floor 6: the motion that a tribometer commands, and all the places where it turns."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

_NEAR = 1e-9
"""Angle [rad] from a turning point over which the motion stands still, to rounding."""


def shape(angle: Floats, share: float) -> Floats:
    """Displacement over its amplitude: a sine and its third harmonic; at rest up to angle 0."""
    top = 1.0 - share
    if share > 1.0 / 9.0:  # the peak is then beside the middle of the half cycle
        sine = math.sqrt((1.0 + 3.0 * share) / (12.0 * share))
        top = (1.0 + 3.0 * share) * sine - 4.0 * share * sine**3
    moved = (np.sin(angle) + share * np.sin(3.0 * angle)) / top
    return np.where(angle > 0.0, moved, 0.0)


def turns(first: float, last: float, share: float) -> Floats:
    """Angles at which that motion turns.

    The velocity is cos t + 3 s cos 3t = cos t (1 - 9 s + 12 s cos^2 t).
    """
    first, quarter = max(first, 0.0), 0.5 * math.pi
    if last <= first:
        return np.zeros(0)
    within = [quarter]  # of half a cycle
    if share > 1.0 / 9.0:
        beside = math.acos(math.sqrt((9.0 * share - 1.0) / (12.0 * share)))
        within = [beside, quarter, math.pi - beside]
    halves = np.arange(first // math.pi, last // math.pi + 1.0)
    every: Floats = (math.pi * halves[:, None] + np.array(within)).reshape(-1)
    return every[(every > first) & (every < last)]


def path(size: int, step: float, parts: int, between: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Angles of a history, more than are sampled, and which of them are."""
    angle: Floats = np.arange(float(size))
    angle *= step
    sampled = np.ones(size, dtype=bool)
    if parts > 1:
        fine: Floats = np.arange(float((size - 1) * parts + 1))
        fine *= step / parts
        fine[::parts] = angle
        angle, sampled = fine, np.zeros(fine.size, dtype=bool)
        sampled[::parts] = True
    between = between[(np.diff(between, prepend=0.0) > _NEAR) & (between < angle[-1])]
    at = np.searchsorted(angle, between)
    far = (between - angle[at - 1] > _NEAR) & (angle[at] - between > _NEAR)
    at, between = at[far], between[far]
    return np.insert(angle, at, between), np.insert(sampled, at, False)
