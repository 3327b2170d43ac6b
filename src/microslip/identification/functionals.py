"""Secant stiffness and damping from force and energy; sliders of the joint without the rig."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats


def quantity_of(name: str, force: float, energy: float, a: float) -> tuple[float, float, float]:
    """Return a quantity at amplitude a [m], and its derivatives d/d(force) and d/d(energy)."""
    if name == "force":
        return force, 1.0, 0.0
    if name == "energy":
        return energy, 0.0, 1.0
    if name == "secant":
        return force / a, 1.0 / a, 0.0
    factor = (1.0 if name == "loss" else 0.5) / (math.pi * a * force)
    return factor * energy, -factor * energy / force, factor


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
