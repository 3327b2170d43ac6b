"""Intervals of what campaigns say hold the truth as often as they claim."""

from __future__ import annotations

import numpy as np
import pytest

from microslip.laboratory.campaign import proportional


def test_the_wear_coefficient_is_a_line_through_zero() -> None:
    exact = proportional(("a", "b"), np.array([1.0, 2.0]), np.array([3e-12, 6e-12]), 0.95)
    assert exact.coefficient.value == pytest.approx(3e-12, rel=1e-12)
