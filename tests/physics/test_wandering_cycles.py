"""Friction that wanders from cycle to cycle: how often intervals hold what it wanders about.

Closed loops of an elastic and perfectly plastic contact, each with a limit of its own: nothing of
the package makes them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from sliders import slider

import microslip as ms
from microslip.laboratory.estimates import mean_of

Floats = NDArray[np.float64]

STIFFNESS, LIMIT, AMPLITUDE, LOAD, A_CYCLE = 1e7, 30.0, 10e-6, 100.0, 120
ENERGY = 4.0 * LIMIT * (AMPLITUDE - LIMIT / STIFFNESS)


def wandering(rng: np.random.Generator, cycles: int, correlation: float) -> Floats:
    """A first-order series of unit variance."""
    steps = rng.normal(size=cycles)
    series = np.empty(cycles)
    series[0] = steps[0]
    for i in range(1, cycles):
        series[i] = correlation * series[i - 1] + math.sqrt(1.0 - correlation**2) * steps[i]
    return series


def record(seed: int, correlation: float, cycles: int = 60, share: float = 0.01) -> ms.Record:
    """Loops from peak to peak, the limit of each way constant."""
    rng = np.random.default_rng([seed, round(100 * correlation)])
    limits = LIMIT * (1.0 + share * wandering(rng, cycles, correlation))
    phase = np.arange(cycles * A_CYCLE + 1) / A_CYCLE
    x = AMPLITUDE * np.cos(2.0 * np.pi * phase)
    # From one sample to the next: elastic up to the limit of the cycle.
    force = slider(x, STIFFNESS, limits[np.minimum(phase.astype(int), cycles - 1)], LIMIT)
    x = x + 0.001 * AMPLITUDE * rng.normal(size=x.size)
    force = force + 0.002 * LIMIT * rng.normal(size=x.size)
    return ms.Record(x, force, normal_load=LOAD, sample_rate=1000.0)


@pytest.mark.slow
@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9, 0.98])
def test_intervals_of_energy_and_friction(correlation: float) -> None:
    """At least 9 of 10 hold, of 40, even where 60 cycles hardly tell."""
    held = {"dissipated_energy": 0, "friction_energy": 0}
    truths = {"dissipated_energy": ENERGY, "friction_energy": LIMIT / LOAD}
    for seed in range(40):
        mean = ms.measure(record(seed, correlation)).mean
        for name, truth in truths.items():
            # The corners of the loop, read off its samples, are worth a little.
            slack = 3e-4 * truth
            held[name] += mean[name].low - slack <= truth <= mean[name].high + slack
    assert min(held.values()) >= 36


@pytest.mark.slow
@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_intervals_of_fits(correlation: float) -> None:
    held = 0
    for seed in range(20):
        number = ms.identify(record(seed, correlation)).force_limit
        slack = 5e-4 * LIMIT
        held += number.low - slack <= LIMIT <= number.high + slack
    assert held >= 17


def test_independent_cycles_have_the_intervals_of_before() -> None:
    """Student's; a chance resemblance widens few of them."""
    rng = np.random.default_rng(1)
    wider = []
    for _ in range(300):
        values = 5.0 + rng.normal(size=60)
        number = mean_of(values, 0.95)
        half = 2.000995 * float(values.std(ddof=1)) / math.sqrt(60)
        wider.append(0.5 * (number.high - number.low) / half)
    assert np.median(wider) == pytest.approx(1.0, rel=1e-6)
    assert np.mean(wider) < 1.1
    assert min(wider) > 1.0 - 1e-6


def test_cycles_that_run_in_have_their_range() -> None:
    """A course that only rises ends where it ends; one that wanders may go on."""
    noise = 0.002 * np.random.default_rng(2).normal(size=60)
    bursts = np.repeat([18.0, 18.4, 21.4, 29.6, 30.0], 12)
    for course in (30.0 - 12.0 * np.exp(-np.arange(60) / 20.0), bursts, -bursts):
        values = course + noise
        number = mean_of(values, 0.95, moving=True)
        assert (number.low, number.high) == pytest.approx((values.min(), values.max()), abs=0.02)
    wanders = 30.0 + np.sin(np.arange(60) / 10.0) + noise
    number = mean_of(wanders, 0.95, moving=True)
    assert number.low < wanders.min() - 0.2
    assert number.high > wanders.max() + 0.2
