"""Records without noise on the steps of a converter: not clipped, and known to half a step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from laboratory.imperfections import an_imperfect_set

import microslip as ms


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 14])
def test_numbers_of_a_law_hold(seed: int) -> None:
    made = an_imperfect_set("converter steps", seed)
    fit = ms.identify(made.records, held_back=0.0, intervals="curvature", **made.options)
    for name, truth in made.truth.items():
        number = fit.parameters[name]
        assert number.verdict == "identified"
        assert number.low <= truth <= number.high
    assert not any("clipped" in note or "smoother" in note for note in fit.notes)


@pytest.mark.slow
def test_a_sensor_at_its_end_is_in_doubt_on_steps_too() -> None:
    made = an_imperfect_set("converter steps", 1)
    records = []
    for one in made.records:
        steps = np.unique(one.force)
        step, top = float(np.diff(steps).min()), 0.9 * float(steps[-1])
        clipped = step * np.round(np.clip(one.force, -top, top) / step)
        load = one.normal_load
        records.append(
            ms.Record(one.displacement, clipped, normal_load=load, sample_rate=one.sample_rate)
        )
    fit = ms.identify(records, held_back=0.0, intervals="curvature", **made.options)
    assert {number.verdict for number in fit.parameters.values()} <= {"in doubt", "apparent"}
    assert any("a clipped sensor, or" in note for note in fit.notes)


def test_half_a_step_is_in_the_intervals_of_measure() -> None:
    made = an_imperfect_set("converter steps", 1)
    for record in made.records[1::2]:
        found = ms.measure(record).mean["friction_peak"]
        step = float(np.diff(np.unique(record.force)).min()) / record.normal_load
        assert found.low <= made.truth["friction_coefficient"] <= found.high
        # A value of which the step alone is known has a standard deviation of step/sqrt(12).
        half = 0.5 * (found.high - found.low)
        assert half == pytest.approx(1.96 * step / math.sqrt(12.0), rel=0.2)
