"""Random faces: their flatness, correlation and plane, rims, and where a study draws them."""

from __future__ import annotations

import numpy as np
import pytest
from laps import STRIP, small_joint

import microslip as ms
from microslip.structures.random_form import random_face, random_gaps, rim_gaps

FLAT = STRIP.replace("[structure]", '[structure]\nform = { flatness = "4 um" }', 1)


def test_a_face_has_its_flatness_and_no_plane() -> None:
    rng = np.random.default_rng(1)
    places = rng.uniform(-0.05, 0.05, (400, 2))
    weights = rng.uniform(0.5, 1.5, 400)
    for correlation in (0.01, 0.1, 1.0):
        heights = random_face(places, weights, 2e-5, correlation, rng)
        assert np.ptp(heights) == pytest.approx(2e-5, rel=1e-12)
        for moment in (
            np.ones(400),
            *places.T,
        ):  # rounding of fields far above what is left of them
            assert abs((weights * moment) @ heights) < 1e-7 * (weights * abs(moment)).sum() * 2e-5


def test_waves_correlate_as_a_squared_exponential() -> None:
    """Correlation exp(-d^2/2l^2) over many faces, where the plane takes nothing."""
    line = np.linspace(0.0, 1.0, 101)
    places = np.array([(x, y) for x in line for y in (0.0, 0.5, 1.0)])
    rng, length = np.random.default_rng(2), 0.05
    found = []
    for _ in range(60):
        heights = random_face(places, np.ones(len(places)), 1.0, length, rng)[::3]
        heights = heights - heights.mean()
        found.append([(heights[: 101 - lag] * heights[lag:]).mean() for lag in (0, 3, 5, 8)])
    ratios = np.mean(found, axis=0)
    wanted = np.exp(-0.5 * (np.array([0.0, 0.03, 0.05, 0.08]) / length) ** 2)
    # The mean over a line of this length takes a share of sqrt(2 pi) l / 1 of the variance.
    taken = np.sqrt(2.0 * np.pi) * length
    wanted = (wanted - taken) / (1.0 - taken)
    np.testing.assert_allclose(ratios / ratios[0], wanted, atol=0.05)


def test_two_faces_part_and_rims_close() -> None:
    joint = small_joint()
    gaps = random_gaps(joint, 1e-6, 0.02, np.random.default_rng(3))
    again = random_gaps(joint, 1e-6, 0.02, np.random.default_rng(3))
    np.testing.assert_array_equal(gaps, again)
    assert 0.0 < np.ptp(gaps) < 2e-6
    rim = rim_gaps(joint, [(0.0, 0.0, 0.0066, 0)], 1e-5)
    assert rim.min() < 0.0
    # The middle patches of three by two lie around the hole.
    assert set(np.argsort(rim)[:2]) == {2, 3}
    assert not rim_gaps(joint, [(0.0, 0.0, 0.0066, 1)], 1e-5).any()
    # Its volume is that of the cone from the edge of the hole to the end of its reach.
    hole = 0.5 * 0.0066
    for reach in (0.0, 0.4):
        end = (0.95 + 0.72 * reach) * 0.0066
        cone = end * (end**2 - hole**2) / 2.0 - (end**3 - hole**3) / 3.0
        volume = 2.0 * np.pi * 1e-5 * cone / (end - hole)
        gaps = rim_gaps(joint, [(0.0, 0.0, 0.0066, 0)], 1e-5, reach)
        assert -(gaps @ joint.patch_areas) == pytest.approx(volume, rel=0.03)


def test_a_study_draws_faces_for_samples_and_none_for_the_middle() -> None:
    part = ms.Study.from_toml(FLAT).structure
    assert part.form.is_random
    assert (part.form.correlation.low, part.form.correlation.high) == (0.03 / 8, 0.03)
    assert part.form.correlation.log
    joint = small_joint()
    assert not part.form.apply(joint, part.holes, None).patch_gaps.any()
    drawn = part.form.apply(joint, part.holes, np.random.default_rng(0)).patch_gaps
    assert 0.0 < drawn.max() < 8e-6
    ground = ms.Study.from_toml(FLAT.replace('flatness = "4 um"', 'machining = "ground"'))
    assert (ground.structure.form.flatness.low, ground.structure.form.flatness.high) == (
        3e-6,
        15e-6,
    )
