"""Records without noise on the steps of a converter: not clipped, and known to half a step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from laboratory.imperfections import an_imperfect_set

import microslip as ms


def test_half_a_step_is_in_the_intervals_of_measure() -> None:
    made = an_imperfect_set("converter steps", 1)
    for record in made.records[1::2]:
        found = ms.measure(record).mean["friction_peak"]
        step = float(np.diff(np.unique(record.force)).min()) / record.normal_load
        assert found.low <= made.truth["friction_coefficient"] <= found.high
        # A value of which the step alone is known has a standard deviation of step/sqrt(12).
        half = 0.5 * (found.high - found.low)
        assert half == pytest.approx(1.96 * step / math.sqrt(12.0), rel=0.2)
