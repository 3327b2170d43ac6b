"""Oscillators: shapes, what is frozen, what ends early, and each error."""

from __future__ import annotations

import numpy as np
import pytest
from cases import refusal

import microslip as ms

CELL = ms.Jenkins(stiffness=5e7, force_limit=100.0)


# -- right use -------------------------------------------------------------------------------------


def test_dry_friction_at_rest() -> None:
    dry = ms.Oscillator(2.0, 3e7, ms.Coulomb(100.0))
    assert dry.frequency(0.0) == np.inf
    assert dry.damping_ratio(0.0) == 0.0
    assert dry.damping_ratio(0.0, method="harmonic-balance") == 0.0


def test_a_mass_that_is_held_rests() -> None:
    dry = ms.Oscillator(2.0, 8.0, ms.Coulomb(force_limit=0.3))
    held = dry.ring_down(0.03, cycles=5)
    assert held.time.tolist() == [0.0]
    assert held.force.tolist() == [-8.0 * 0.03]
    assert held.amplitude.size == held.frequency.size == held.damping_ratio.size == 0
    slides = dry.ring_down(0.2, duration=20.0, samples_per_cycle=10)
    assert slides.time[-1] == pytest.approx(20.0, rel=1e-14)
    last = slides.time > slides.turning_time[-1] + slides.time[1]
    assert last.sum() > 40
    assert np.ptp(slides.displacement[last]) == 0.0
    assert np.all(slides.velocity[last] == 0.0)
    np.testing.assert_array_equal(slides.force[last], -8.0 * slides.displacement[last])
    assert slides.energy_error < 1e-11


def test_swings_below_rounding_end() -> None:
    """What a dashpot has left of a motion is smaller than the place it rests at is known to."""
    mode = ms.Oscillator(1.0, 1e9, ms.Interface.examples()[0], 0.3)
    motion = mode.ring_down(1e-6, cycles=1000)
    assert motion.amplitude.size < 30
    assert motion.velocity[-1] == 0.0
    assert abs(motion.displacement[-1]) > 1e-10
    assert np.all(np.isfinite(motion.frequency))


# -- errors ----------------------------------------------------------------------------------------


def test_a_mass_that_creeps() -> None:
    creeping = ms.Oscillator(2.0, 5e2, CELL, 0.5)
    assert refusal(creeping.ring_down, 1.0, cycles=1, samples_per_cycle=8) == (
        "cycles cannot be counted: the mass creeps back without turning, since the dashpot is "
        "strong against the sliding joint; give duration=... [s] instead"
    )
    motion = creeping.ring_down(1.0, duration=0.1, samples_per_cycle=8)
    assert np.all(np.diff(motion.displacement) < 0.0)
