"""Triangle and trapezoid drives: the law does not know rate, so they identify as a sine does.

The closed loops are those of one sphere by hand (Mindlin); nothing of the package makes them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from sliders import sphere, sphere_loop

import microslip as ms
from microslip.identification import fold

Floats = NDArray[np.float64]
FRICTION, LOAD, SLIP = 0.5, 100.0, 2e-6


def drive(turn: Floats, cut: float) -> Floats:
    """A triangle of unit amplitude, its tips cut off as with ``cut`` more of it."""
    part = np.mod(turn, 1.0)
    shape = np.where(part < 0.5, 1.0 - 4.0 * part, 4.0 * part - 3.0)
    return np.clip((1.0 + cut) * shape, -1.0, 1.0)


def record(seed: int, amplitude: float, cut: float, noise: float) -> ms.Record:
    rng = np.random.default_rng([seed, round(100.0 * cut)])
    turn = np.arange(2460) / 200.3 + rng.uniform()
    x = amplitude * drive(turn, cut)
    force = sphere_loop(x, np.mod(turn, 1.0) < 0.5, amplitude, FRICTION * LOAD, SLIP)
    x = x + 0.3 * noise * amplitude * rng.normal(size=x.size)
    force = force + noise * force.max() * rng.normal(size=x.size)
    return ms.Record(x, force, normal_load=LOAD, sample_rate=2000.0)


@pytest.mark.slow
@pytest.mark.parametrize("cut", [0.0, 0.3])
@pytest.mark.parametrize("noise", [0.001, 0.004, 0.01])
def test_the_law_answers(cut: float, noise: float) -> None:
    held = 0
    for seed in range(4):
        records = [
            record(10 * seed + i, share * SLIP, cut, noise) for i, share in enumerate((0.4, 2.0))
        ]
        found = ms.identify(records)
        assert found.masing.reduced_chi_squared < 1.3
        limit = found.force_limit
        assert limit.value == pytest.approx(FRICTION * LOAD, rel=5e-3)
        held += limit.low <= FRICTION * LOAD <= limit.high
        force = found.force(0.5 * SLIP)
        truth = sphere(0.5 * SLIP, FRICTION * LOAD, SLIP)
        held += force.low <= truth <= force.high
    assert held >= 6


@pytest.mark.parametrize(("cut", "corners"), [(0.0, 2), (0.3, 4)])
def test_corners_are_where_they_are(cut: float, corners: int) -> None:
    folded = fold(record(3, 1e-6, cut, 0.004))
    assert folded.motion.corners.size == corners
    assert folded.motion.harmonics.size < 4
    phase = np.linspace(0.0, 2.0 * math.pi, 4001)
    turn = phase / (2.0 * math.pi) + 0.5 * (folded.displacement(np.zeros(1))[0] < 0.0)
    # Samples say the place of a corner to 3e-4 rad; 150 harmonics cut tips by 1.3e-3.
    np.testing.assert_allclose(folded.displacement(phase), 1e-6 * drive(turn, cut), atol=3e-10)
    ahead, behind = (folded.displacement(phase + way * 1e-6) for way in (1.0, -1.0))
    slope = folded.displacement(phase, 1)
    assert np.median(np.abs((ahead - behind) / 2e-6 - slope)) < 1e-12


def test_a_sine_keeps_its_few_harmonics() -> None:
    turn = np.arange(2460) / 200.3
    x = np.cos(2.0 * math.pi * turn) + 0.05 * np.cos(6.0 * math.pi * turn)
    rng = np.random.default_rng(1)
    x = 1e-6 * (x + 0.001 * rng.normal(size=x.size))
    folded = fold(ms.Record(x, 1e7 * x, sample_rate=2000.0))
    assert folded.motion.harmonics.tolist() == [1, 3]
