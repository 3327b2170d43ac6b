"""Whether the shift of a measured mode's frequency can come from friction.

A joint that softens by friction dissipates: of a backbone T = k d - c d^(1 + chi) the loop loses
what adds zeta = (2/pi) r chi/(2 + chi) to the damping, r the loss of the secant stiffness, twice
that of the frequency; 0.424 of the relative shift for chi = 1 (microslip).
"""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip._core.verdicts import Rule, Verdict

_NOTHING = 5e-4  # of the frequency: a smaller shift says nothing

SHIFT = Rule(
    "frequency shift beside friction's",
    watch=2.5,
    outside=6.0,
    meaning=(
        "Friction shifts the frequency: the shift over the one that belongs to the damping "
        "added with amplitude (microslip: added damping 0.424 of the relative shift)."
    ),
    reason=(
        "On a bolted beam in microslip the damping added was 0.93 to 1.08 times that; "
        "a shift far larger, or upwards, comes from geometry (thin or curved parts) or from gaps."
    ),
    remedy="Give the structure its geometry, with_geometry(...), or fit smaller amplitudes alone.",
    missing="The frequency moves by less than 0.05 %, too little to judge.",
)


def added_damping(shift: float, exponent: float = 1.0) -> float:
    """Damping ratio that friction adds as it lowers a frequency by a share ``shift`` [-]."""
    return 2.0 / math.pi * 2.0 * shift * exponent / (2.0 + exponent)


def judge_shift(name: str, amplitude: Floats, frequency: Floats, damping: Floats) -> Verdict:
    """Hold a backbone's shift from its smallest amplitudes to its largest to its damping."""
    rule, order = SHIFT, np.argsort(amplitude)
    third = max(1, amplitude.size // 3)
    low, high = order[:third], order[-third:]
    shift = float(frequency[low].mean() - frequency[high].mean()) / float(frequency[low].mean())
    gain = float(damping[high].mean() - damping[low].mean())
    value: float | None = None
    if amplitude.size > 1 and abs(shift) > _NOTHING:
        value = math.inf if shift < 0.0 or gain <= 0.0 else added_damping(shift) / gain
        value = min(value, 1e3)
    verdict = rule.judge(value)
    return verdict._replace(name=f"{rule.name}, {name}")
