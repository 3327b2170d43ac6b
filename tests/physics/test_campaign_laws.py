"""Intervals of what campaigns say hold the truth as often as they claim."""

from __future__ import annotations

import math

import numpy as np
import pytest

from microslip.tribometer.campaign_laws import (
    of_one,
    pooled,
    proportional,
    running_in,
    with_threshold,
)
from microslip.tribometer.estimates import Estimate
from microslip.tribometer.regimes import borders_of


@pytest.mark.parametrize("number", [3, 6, 12])
@pytest.mark.parametrize("scatter", [0.0, 0.01, 0.05])
def test_the_pooled_value_includes_specimens_and_cycles(number: int, scatter: float) -> None:
    """Specimens whose own errors differ by a factor of fifteen, from none to much scatter."""
    rng = np.random.default_rng([7, number])
    trials, held = 2000, 0
    for _ in range(trials):
        errors = rng.uniform(0.002, 0.03, number)
        found = 0.5 + scatter * rng.normal(size=number) + errors * rng.normal(size=number)
        each = [
            (str(i), Estimate(v, math.nan, math.nan, e, 20))
            for i, (v, e) in enumerate(zip(found, errors, strict=True))
        ]
        mean = pooled("mu", each, 0.95).mean
        held += mean.low < 0.5 < mean.high
    assert held / trials > 0.935, "three standard errors of the trials below 0.95"


def test_records_of_one_specimen_count_by_scatter_or_by_their_own_errors() -> None:
    """Two of them: the interval is 12.706 times the larger error, that of Student at 95 %."""
    for apart, error, wanted in ((2.0, 0.1, 1.0), (0.0, 0.5, 0.5 / math.sqrt(2.0))):
        means = [Estimate(3.0 + way * apart / 2.0, 0.0, 9.0, error, 8) for way in (-1.0, 1.0)]
        one = of_one(means, 0.95)
        assert (one.value, one.standard_error) == pytest.approx((3.0, wanted), rel=1e-12)
        assert one.high - one.value == pytest.approx(12.7062 * wanted, rel=1e-5)
        assert of_one(means[:1], 0.95) == means[0]


@pytest.mark.parametrize("correlation", [0.0, 0.8])
def test_the_constant_of_running_in(correlation: float) -> None:
    rng = np.random.default_rng(5)
    n, trials, held, told = 1.0 + np.arange(200.0), 200, np.zeros(2), 0
    for _ in range(trials):
        noise = rng.normal(size=n.size)
        for i in range(1, n.size):
            noise[i] = correlation * noise[i - 1] + math.sqrt(1.0 - correlation**2) * noise[i]
        law = running_in("", "", n, 0.5 - 0.2 * np.exp(-(n - 1.0) / 20.0) + 0.01 * noise, 0.95)
        if law is not None:
            told += 1
            ends = ((law.constant, 20.0), (law.settled, 0.5))
            held += [estimate.low < truth < estimate.high for estimate, truth in ends]
    assert told > 0.9 * trials
    assert np.all(held / told > 0.92)
    steady = [running_in("", "", n, rng.normal(0.5, 0.01, n.size), 0.95) for _ in range(100)]
    assert steady == [None] * 100, "nothing runs in"


def test_the_threshold_of_wear() -> None:
    rng = np.random.default_rng(6)
    held = 0
    for _ in range(4000):
        energy = rng.uniform(100.0, 1000.0, 8)
        volume = 2e-13 * (energy - 80.0) + 4e-12 * rng.normal(size=8)
        law = with_threshold((), energy, volume, 0.95)
        assert law is not None
        assert law.threshold is not None
        held += law.threshold.low < 80.0 < law.threshold.high
    assert held > 0.94 * 4000
    exact = proportional(("a", "b"), np.array([1.0, 2.0]), np.array([3e-12, 6e-12]), 0.95)
    assert exact.coefficient.value == pytest.approx(3e-12, rel=1e-12)


def test_borders_of_a_sphere() -> None:
    """All of a sphere slides from its slip limit, which grows with the load to 2/3."""
    import microslip as ms

    steel = ms.Material(210e9, 0.3)
    sphere = ms.SphereOnFlat(ms.MaterialPair(steel, steel), radius=5e-3)
    joint = ms.Interface(sphere, 0.4, normal_load=10.0)
    borders = borders_of(lambda load: joint.at(normal_load=load), [10.0, 1000.0], 1e8)
    assert borders is not None
    contact = borders.gross - 0.4 * borders.normal_load / 1e8
    slope = np.polyfit(np.log(borders.normal_load), np.log(contact), 1)[0]
    assert slope == pytest.approx(2.0 / 3.0, abs=1e-6)
    limits = [joint.at(normal_load=float(load)) for load in borders.normal_load[::12]]
    slip = [-law.slip_per_indentation * law.separation for law in limits]
    assert np.allclose(contact[::12], slip, rtol=1e-6)
    assert borders_of(lambda load: joint, [], None) is None
