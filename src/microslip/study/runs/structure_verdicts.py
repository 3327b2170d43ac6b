"""Verdict on a measured quantity of a mode, and its change over the amplitudes."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

TestWord = Literal["inside", "above", "below", "on both sides", "not compared"]
_STEADY_RATIO = 0.2
"""Ratio of damping rise to relative frequency fall [-] below which microslip is doubtful."""


class QuantityVerdict(NamedTuple):
    """Comparison of a measured quantity with the 5 to 95 % band of its mode."""

    test: str
    mode: int
    quantity: str
    """``frequency`` or ``damping_ratio``."""
    word: TestWord
    points: int
    """Number of points within the amplitudes of the prediction."""
    above: int
    below: int
    distance: float
    """Largest relative distance from the nearest end of the band [-]; negative below the band."""
    candidates: tuple[tuple[str, str], ...]
    """Inputs that would reduce the difference, most influential first, with "more" or "less"."""
    unit: str
    """Unit error that would put the test inside the band, or empty."""

    @property
    def inside(self) -> int:
        """Number of points inside the band."""
        return self.points - self.above - self.below


class AmplitudeTrend(NamedTuple):
    """Change of frequency and damping over the amplitudes of a test or a prediction."""

    source: str
    mode: int
    base_damping: float
    """Damping ratio without the joint [-]; NaN for a test."""
    rise: float
    """Damping ratio at the largest minus that at the smallest amplitude [-]."""
    fall: float
    """Relative change of the frequency from the smallest to the largest amplitude [-]."""

    @property
    def ratio(self) -> float:
        """Rise of the damping ratio over the relative fall of the frequency [-].

        Microslip of a joint at constant pressure gives 0.40 to 0.50.
        """
        return -self.rise / self.fall if self.fall < 0.0 else math.nan

    @property
    def doubt(self) -> str:
        """Reason to doubt that microslip causes the change, or empty."""
        if not math.isfinite(self.ratio) or abs(self.fall) < 1e-4 or self.ratio >= _STEADY_RATIO:
            return ""
        return (
            f"{self.source}: the damping ratio rises by {self.ratio:.2g} times the relative fall "
            "of the frequency; microslip gives 0.4 to 0.5. Look for nonlinear stiffness, such as "
            "large deflections or opening gaps."
        )
