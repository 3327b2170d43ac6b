"""A frequency that falls by friction adds damping in a known ratio; by geometry it does not."""

from __future__ import annotations

import numpy as np
import pytest

import microslip as ms
from microslip.structures.modal_curve import added_damping, judge_shift

METAL = ms.Material(69e9, 0.33)
SURFACE = ms.GreenwoodWilliamson(
    ms.MaterialPair(METAL, METAL), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
JOINT = ms.Interface(SURFACE, 0.55, normal_load=2000.0)
SLIP = JOINT.force_limit / JOINT.tangential_stiffness


def judged(curve: ms.ModalCurve) -> tuple[float | None, str]:
    verdict = judge_shift("test", curve.amplitude, curve.frequency, curve.damping_ratio)
    return verdict.value, verdict.word


def test_microslip_adds_the_damping_of_a_bent_backbone() -> None:
    """By harmonic balance of a mass on a spring and a rough joint."""
    mass = ms.Structure([[2.0]], [[4.0 * JOINT.tangential_stiffness]])
    jointed = mass.attach(JOINT, directions=[1.0])
    curve = jointed.modes(0, SLIP * np.geomspace(0.03, 0.3, 9), at=[1.0])
    value, word = judged(curve)
    assert value == pytest.approx(1.0, abs=0.15)
    assert word == "ok"
    shift = 1.0 - curve.frequency[0] / curve.linear_frequency
    assert curve.damping_ratio[0] == pytest.approx(added_damping(shift), rel=0.1)


@pytest.mark.parametrize("quartic", [6e23, -6e23])
def test_geometry_is_distinguished(quartic: float) -> None:
    mass = ms.Structure([[2.0]], [[4.0 * JOINT.tangential_stiffness]])
    jointed = mass.attach(JOINT, directions=[1.0])
    whole = jointed.with_geometry([1.0], quartic=np.full((1,) * 4, quartic))
    curve = whole.modes(0, SLIP * np.geomspace(0.03, 0.3, 5), at=[1.0])
    value, word = judged(curve)
    assert value is not None
    assert word == "outside", (value, curve.frequency)


def test_what_does_not_move_is_not_judged() -> None:
    still = judge_shift("t", np.array([1.0, 2.0]), np.full(2, 100.0), np.array([0.01, 0.02]))
    assert still.word == "not judged"
    assert "t" in still.name
