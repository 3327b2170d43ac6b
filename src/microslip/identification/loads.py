"""Groups of equal loads; thresholds, first-loading force and rig of sliders."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from microslip._core.checks import Floats

SAME = 0.01
"""Relative difference below which values, such as normal loads, are treated as equal."""


def groups_of(values: Iterable[float]) -> list[list[float]]:
    """Sort values into groups; each value is within 1 % of the smallest of its group."""
    groups: list[list[float]] = []
    for value in sorted(values):
        if groups and value <= groups[-1][0] * (1.0 + SAME):
            groups[-1].append(value)
        else:
            groups.append([value])
    return groups


def carried(y: Floats, old: float, new: float) -> Floats:
    """Return the thresholds at the reference load [m] after a change of friction.

    Thresholds decrease from the reference load to a second load, by ``old`` [m] before the change
    and by ``new`` [m] after it; at the second load they do not change. ``y`` are the thresholds at
    the reference load before the change; those up to ``old`` are scaled by new/old.
    """
    return np.where(y > old, y + (new - old), y * (new / old)) if old > 0.0 else y


def backbone_of(y: Floats, k: Floats, u: Floats) -> Floats:
    """Return the first-loading force sum_i k_i min(u, y_i) [N] at displacements u of any shape."""
    order = np.argsort(y)
    y, k = y[order], k[order]
    slipped = np.append(0.0, np.cumsum(k * y))
    stuck = np.append(np.cumsum(k[::-1])[::-1], 0.0)
    at = np.searchsorted(y, u, side="right")
    return np.asarray(slipped[at] + u * stuck[at])


def stiffness_of(y: Floats, k: Floats, u: Any) -> Floats:
    """Return the tangent stiffness [N/m] of the backbone of sliders (y, k) at displacements u."""
    order = np.argsort(y)
    stuck = np.append(np.cumsum(k[order][::-1])[::-1], 0.0)
    return np.asarray(stuck[np.searchsorted(y[order], u, side="right")])


def shift_between(high: Any, low: Any) -> float:
    """Return the shift [m] of thresholds from the fit of a load to that of a lower load.

    If B_low(u) = B_high(u* + u) - B_high(u*) at displacements u, with the backbones B, it is -u*.
    """
    u = np.linspace(0.0, low.largest, 41)[1:]
    starts = np.linspace(0.0, high.largest, 401)
    tail = high.backbone(starts[:, None] + u) - high.backbone(starts)[:, None]
    miss = np.sum((tail - low.backbone(u)) ** 2, axis=1)
    return -float(starts[int(np.argmin(miss))])


def joint_alone(y: Floats, k: Floats, compliance: float) -> tuple[Floats, Floats]:
    """Return the sliders of the joint from those of joint and rig in series.

    The displacement of the joint is u - c B(u), with the displacement u and the backbone B of both
    and the compliance c of the rig [m/N]. If B is piecewise linear, so is the backbone of the
    joint; a segment with the stiffness of the rig becomes 1e3 times as stiff as the rig.
    """
    corners = np.append(0.0, y)
    force = np.minimum(corners[:, None], y) @ k
    x = np.diff(corners) - compliance * np.diff(force)
    rise = np.diff(force)
    x = np.maximum(x, 1e-3 * compliance * rise)
    slope = np.append(rise / x, 0.0)
    slope = np.minimum.accumulate(slope)
    keep = -np.diff(slope) > 1e-12 * slope[0]
    return np.cumsum(x)[keep], -np.diff(slope)[keep]
