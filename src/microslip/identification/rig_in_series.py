"""A law's backbone behind a spring, with its derivatives."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from microslip._core.checks import Floats
from microslip.identification.models.base import BackboneModel

Answer = tuple[Floats, Floats, Floats, Floats]
"""Force, stiffness, derivatives by the law's parameters and by the compliance in series."""

_STEPS = 60
_NEAR, _THERE = 1e-5, 1e-8


def behind_spring(
    model: BackboneModel,
    y: Floats,
    values: Mapping[str, float],
    load: float | None,
    compliance: float,
    guess: Floats,
) -> tuple[Answer, Floats]:
    """Branch function of the law behind a spring: v + c T0(v) = y.

    ``guess`` is what v was last, of another size at first. Also v as it is now.
    """
    if compliance == 0.0:
        force, stiffness, by = model.branch(y, values, load)
        return (force, stiffness, by, -stiffness * force), guess
    v = guess if guess.size == y.size else np.zeros_like(y)
    scale = float(y.max())
    # The sum is concave and rising: after one step Newton's method climbs, never past it.
    for _ in range(_STEPS):
        force, stiffness = model.curve(v, values, load)
        new = v + (y - v - compliance * force) / (1.0 + compliance * stiffness)
        new = np.clip(new, 0.0, y)
        moved = float(np.max(np.abs(new - v)))
        v = new
        if moved <= _NEAR * scale:
            # The last of its steps with all derivatives; beyond a kink it is not the last.
            force, stiffness, by = model.branch(v, values, load)
            step = (y - v - compliance * force) / (1.0 + compliance * stiffness)
            if float(np.max(np.abs(step))) <= _THERE * scale:
                break
            v = np.clip(v + step, 0.0, y)
    else:
        force, stiffness, by = model.branch(v, values, load)
        step = np.zeros_like(v)
    force = force + stiffness * step
    share = 1.0 / (1.0 + compliance * stiffness)
    answer = force, stiffness * share, by * share, -stiffness * share * force
    return answer, np.clip(v + step, 0.0, y)
