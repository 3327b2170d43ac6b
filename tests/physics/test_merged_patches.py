"""Patches of a reduced joint merged in pairs: a coarser contact on the same bodies."""

from __future__ import annotations

import numpy as np
import pytest
from laps import LARGER, bolted_lap
from scipy import sparse
from usual import rough

import microslip as ms
from microslip.structures.reduction_convergence import merged, patch_error
from microslip.structures.reduction_patches import Patches, Samples, merging

STEEL = ms.Material(young_modulus=210e9, poisson_ratio=0.3)
AMPLITUDES = [1e-6, 1e-5]


def mode(joint: ms.ReducedJoint) -> tuple[np.ndarray, np.ndarray]:
    summits = rough(ms.Exponential(8e-7), ms.MaterialPair(STEEL, STEEL), 1.0)
    curve = joint.tightened(summits, 0.4).modes(0, AMPLITUDES, at=joint.sensor("end"))
    return curve.frequency, curve.damping_ratio


@pytest.mark.parametrize(
    ("axis", "coarse"), [(0, (4, 2)), pytest.param(1, (8, 1), marks=pytest.mark.slow)]
)
def test_merged_patches_act_as_a_reduction_to_wider_ones(axis, coarse) -> None:
    found, wanted = merged(bolted_lap((8, 2)), axis), bolted_lap(coarse)
    assert found.patches == wanted.patches
    order = [np.lexsort(joint.layout[:, [3, 1]].T) for joint in (found, wanted)]
    np.testing.assert_allclose(found.layout[order[0]], wanted.layout[order[1]], atol=1e-9)
    areas = [joint.patch_areas[i] for joint, i in zip((found, wanted), order, strict=True)]
    np.testing.assert_allclose(*areas, rtol=1e-9)
    # The differences within a pair remain free, as the body under one wide patch is.
    for part, whole in zip(mode(found), mode(wanted), strict=True):
        np.testing.assert_allclose(part, whole, rtol=2e-2)


def test_error_is_a_third_of_the_changes_by_merging() -> None:
    fine = mode(bolted_lap((8, 2)))
    coarse = [mode(merged(bolted_lap((8, 2)), axis)) for axis in (0, 1)]
    changes = [
        [np.abs(a / b - 1.0).max() for a, b in zip(trial, fine, strict=True)] for trial in coarse
    ]
    expected = np.sqrt((np.array(changes) ** 2).sum(axis=0)) / 3.0
    np.testing.assert_allclose(patch_error(bolted_lap((8, 2)), mode), expected, rtol=1e-9)
    single = merged(merged(merged(merged(bolted_lap((8, 2)), 0), 0), 0), 1)
    assert single.patches == 1
    assert patch_error(single, mode) is None


@pytest.mark.slow
def test_patches_finer_than_the_elements_are_merged() -> None:
    """Twice as many patches as the elements tell apart give the answer of the usual number."""
    usual, fine = bolted_lap(None), bolted_lap((60, 4))
    assert usual.patches < 60 < fine.patches < 240
    for joint in (usual, fine):
        assert joint.patch_areas.sum() == pytest.approx(LARGER.face_area, rel=5e-3)
        assert np.unique(joint.samples.patches).size == joint.patches
        low, high = joint.patch_boxes[:, [0, 2]], joint.patch_boxes[:, [1, 3]]
        shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
        overlap = np.triu((shared > 1e-9).all(axis=2), 1)
        assert not overlap.any()
    for part, whole in zip(mode(usual), mode(fine), strict=True):
        np.testing.assert_allclose(part, whole, rtol=2e-2)


@pytest.mark.parametrize("seed", range(20))
def test_merged_boxes_do_not_overlap_across_holes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = (part.ravel() for part in np.meshgrid(np.arange(10.0), np.arange(8.0)))
    solid = rng.random(x.size) > 0.3
    boxes = np.column_stack([x, x + 1.0, y, y + 1.0])[solid]
    count = len(boxes)
    areas, numbers = np.ones(count), np.arange(count)
    samples = Samples(boxes[:, ::2] + 0.5, areas, numbers)
    functionals = sparse.identity(3 * count, format="csr")
    patches = Patches(samples, areas, boxes, np.zeros(count, dtype=int), functionals, 0.0)
    for _ in range(3):
        patches, _ = merging(patches, rng.random(len(patches.areas)) ** 3)
        low, high = patches.boxes[:, [0, 2]], patches.boxes[:, [1, 3]]
        shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
        assert not np.triu((shared > 1e-9).all(axis=2), 1).any()
        own = samples.places[:, None] - 0.5 * (low + high)
        inside = (abs(own) < 0.5 * (high - low)).all(axis=2)
        assert inside[numbers, patches.samples.patches].all()
