"""Elastic sliders computed step by step: independent references for friction laws."""

from __future__ import annotations

from typing import Any

import numpy as np


def slider(x: np.ndarray, stiffness: float, limit: Any, start: float = 0.0) -> np.ndarray:
    """Force [N] of one slider along a path [m]; its force limit [N] may vary along it."""
    force, last, limit = np.empty(x.size), start, np.broadcast_to(limit, x.shape)
    for i, step in enumerate(np.diff(x, prepend=x[0])):
        last = force[i] = min(max(last + stiffness * step, -limit[i]), limit[i])
    return force


def sphere(u: Any, limit: float, slip: float) -> Any:
    """Force [N] of a sphere in first loading, by Mindlin; ``slip`` [m] is its slip limit."""
    return limit * (1.0 - (1.0 - np.clip(u / slip, 0.0, 1.0)) ** 1.5)


def sphere_loop(
    x: np.ndarray, falling: np.ndarray, amplitude: float, limit: float, slip: float
) -> np.ndarray:
    """Force of the settled loop of a sphere at places between its ends, by Masing's rules."""
    top = sphere(amplitude, limit, slip)
    down = top - 2.0 * sphere(0.5 * (amplitude - x), limit, slip)
    up = 2.0 * sphere(0.5 * (amplitude + x), limit, slip) - top
    return np.where(falling, down, up)


def stops(
    path: np.ndarray, stiffnesses: np.ndarray, yields: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Force and dissipated energy along a path, from the stretch of each slider by itself."""
    stretch, before, forces, lost = np.zeros_like(yields), 0.0, [], [0.0]
    for x in path:
        free = stretch + (x - before)
        stretch = np.clip(free, -yields, yields)
        before = x
        forces.append(float(stiffnesses @ stretch))
        lost.append(lost[-1] + float(stiffnesses @ (yields * np.abs(free - stretch))))
    return np.array(forces), np.array(lost[1:])
