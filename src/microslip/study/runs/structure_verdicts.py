"""Verdict on a tested quantity of a mode, and its change over the amplitudes."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

Word = Literal["inside", "above", "below", "on both sides", "not compared"]
_STEADY_RATIO = 0.2
"""Rise of damping over fall of frequency [-] below which a test does not show microslip."""


class QuantityVerdict(NamedTuple):
    """Quantity of a test judged against the 5 to 95 % band of its mode."""

    test: str
    mode: int
    quantity: str
    """``frequency`` or ``damping_ratio``."""
    word: Word
    points: int
    """Points of the test within the amplitudes of the prediction."""
    above: int
    below: int
    distance: float
    """Largest distance from the nearest end of the band over that end [-]; negative below."""
    candidates: tuple[tuple[str, str], ...]
    """Inputs that move the quantity, the strongest first, and "more" or "less" of each."""
    unit: str
    """Error of units that would bring the test inside, or empty."""

    @property
    def inside(self) -> int:
        """Points inside the band."""
        return self.points - self.above - self.below


class Change(NamedTuple):
    """Change over the amplitudes of a test or a prediction."""

    source: str
    mode: int
    base_damping: float
    """Damping that the joint has no part in [-]; NaN of a test."""
    rise: float
    """Damping ratio at the largest less that at the smallest amplitude [-]."""
    fall: float
    """Relative change of the frequency between the ends of the amplitudes [-]."""

    @property
    def ratio(self) -> float:
        """Rise of the damping over the relative fall of the frequency [-].

        Microslip of a joint at constant pressure has 0.40 to 0.50.
        """
        return -self.rise / self.fall if self.fall < 0.0 else math.nan

    @property
    def doubt(self) -> str:
        """Reason to doubt that microslip makes the change, or empty."""
        if not math.isfinite(self.ratio) or abs(self.fall) < 1e-4 or self.ratio >= _STEADY_RATIO:
            return ""
        return (
            f"{self.source}: the damping rises by {self.ratio:.2g} of the relative fall of the "
            "frequency, where microslip gives 0.4 to 0.5: look for nonlinear stiffness, such as "
            "large bending or gaps that open."
        )
