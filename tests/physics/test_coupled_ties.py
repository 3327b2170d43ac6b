"""Loads that vary in exact proportion, ties, moves of rounding, and contact that lifts far off."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from cases import ends_below, every_joint, reach_of
from hypothesis import given
from hypothesis import strategies as st

import microslip as ms

EPS = np.finfo(float).eps
WORKED = ms.Interface.examples()[0]
PAIR = WORKED.surface.pair
SUMMITS = ms.Interface(
    ms.GreenwoodWilliamson(
        PAIR, np.array([0.0, 0.2, -0.3, 0.5, 0.1]) * 1e-6, radius=1e-3, density=1e6, area=1e-4
    ),
    friction_coefficient=0.3,
    separation=0.0,
)

# Along a line through the start, with points met again and moves of a rounding.
turns = st.one_of(st.integers(-4, 4).map(lambda k: k / 8), st.floats(-0.5, 0.5))
nudges = st.sampled_from([0.0, 0.0, 0.0, 1e-17, -1e-17, 3e-16, -1e-15, 1e-12])
points = st.lists(st.tuples(turns, nudges, nudges), min_size=1, max_size=16)
ratios = st.sampled_from([0.1, -0.4, 0.75, 1.0, -1.0, 1.0 + 1e-15, 1.25, 3.0, 0.0])


def inclined(joint: ms.Interface, ratio: float, moves: list[Any]) -> tuple[Any, Any]:
    """Separations and displacements of a path along displacement = ratio kappa (d - d0)."""
    depth = joint.force_limit / joint.normal_stiffness / joint.friction_coefficient
    share, across, along = np.array(moves).reshape(-1, 3).T
    if ends_below(joint):
        share = np.abs(share)  # below its first separation a table has no answer
    step = depth * (share + np.abs(across))
    x = ratio * joint.slip_per_indentation * step + reach_of(joint) * along
    return joint.separation + step, x


def test_a_row_passed_in_its_own_proportion_loses_nothing() -> None:
    """It lost NaN: a front a rounding before the separation."""
    x = np.array([
        5.277293844412532e-09, -6.178295232482965e-09, -2.5742896802012353e-10,
        -2.8317186482213592e-09, 5.792151780452779e-10,
    ])  # fmt: skip
    d = np.array([
        1.4114917667690203e-07, -1.6524781659734872e-07, -6.885325691556197e-09,
        -7.573858260711818e-08, 1.5491982806001442e-08,
    ])  # fmt: skip
    lost = SUMMITS.coupled_response(x, separation=d).energy_per_step
    assert lost[0] > 0.0
    np.testing.assert_allclose(lost[1:], 0.0, rtol=0, atol=1e-30)


@every_joint
@given(moves=points, ratio=ratios)
def test_proportional_paths(joint, moves, ratio):
    """Nothing is gained, each force is within friction, and halves of steps lose the same."""
    d, x = inclined(joint, ratio, moves)
    response = joint.coupled_response(x, separation=d)
    lost, limit = response.energy_per_step, joint.friction_coefficient * response.normal_load
    assert np.all(np.isfinite(lost))
    assert np.all(lost >= 0.0)
    heavy = max(limit.max(), joint.force_limit)
    assert np.all(np.abs(response.force) <= limit + 1e-12 * heavy)
    ends = np.column_stack((np.append(joint.separation, d), np.append(0.0, x)))
    fine = np.concatenate([[0.5 * (a + b), b] for a, b in pairwise(ends)])
    parts = joint.coupled_response(fine[:, 1], separation=fine[:, 0])
    np.testing.assert_allclose(parts.force[1::2], response.force, rtol=0, atol=2e-12 * heavy)
    if not isinstance(getattr(joint.surface, "heights", None), ms.Statistical):
        most = heavy * np.abs(np.diff(x, prepend=0.0)).sum()
        total, again = lost.sum(), parts.energy_per_step.sum()
        # With what the last place of a separation costs where the load is light.
        last_place = EPS * np.abs(d).max() * joint.normal_stiffness / joint.normal_load
        assert again == pytest.approx(total, rel=1e-9, abs=(1e-12 + 8.0 * last_place) * most)


def lift_energy(joint: ms.Interface, x: float, rise: float) -> float:
    """One straight step that lifts: springs one by one, each with a slider, in closed form."""
    law, d0, kappa = joint.surface, joint.separation, joint.slip_per_indentation
    move = abs(x) / kappa

    def lost(v: float) -> float:
        begin, end = v / (move + rise), min(v / rise, 1.0)
        if begin >= end:
            return 0.0
        slipped = v * (end - begin) - 0.5 * rise * (end * end - begin * begin)
        return (move + rise) * slipped * float(law._derivative_at(d0 + v, 2))

    length = joint.normal_load / joint.normal_stiffness
    cuts = np.union1d(length * np.arange(0.0, 60.0, 0.25), [rise, move + rise])
    cuts = cuts[cuts <= max(60.0 * length, 0.0)]
    nodes, weights = np.polynomial.legendre.leggauss(16)
    total = sum(
        0.5 * (b - a) * weight * lost(0.5 * (a + b) + 0.5 * (b - a) * node)
        for a, b in pairwise(cuts)
        for node, weight in zip(nodes, weights, strict=True)
    )
    return joint.friction_coefficient * kappa * total


@pytest.mark.parametrize("lift", [0.5, 5.0, 10.0, 20.0, 50.0, 1e4])
@pytest.mark.parametrize("load", [1e-3, 2e3, 1e5])
def test_one_step_that_lifts_far_off(load, lift) -> None:
    """It was wrong by up to all of it, or divided by a stiffness of zero."""
    joint = WORKED.at(normal_load=load)
    rise = lift * joint.normal_load / joint.normal_stiffness
    x = 0.3 * reach_of(joint)
    response = joint.coupled_response([x], separation=[joint.separation + rise])
    assert response.dissipated_energy[0] == pytest.approx(lift_energy(joint, x, rise), rel=1e-9)
    t = np.linspace(0.0, 1.0, 101)[1:]
    fine = joint.coupled_response(x * t, separation=joint.separation + rise * t)
    assert response.dissipated_energy[0] == pytest.approx(fine.dissipated_energy[-1], rel=1e-11)
    assert response.force[0] == pytest.approx(fine.force[-1], rel=1e-9, abs=1e-13 * load)


WITHOUT_PROFILE = [
    ms.Interface(
        ms.TabulatedNormalLaw(PAIR, [0.0, 2e-7, 1e-6], [900.0, 400.0, 100.0], tail="exponential"),
        friction_coefficient=0.3,
        normal_load=600.0,
    ),
    *(
        joint
        for joint in ms.Interface.examples()
        if joint._load_curve.profile(0.0, 0.0) is None and joint.surface._spheres is None
    ),
]


@pytest.mark.parametrize("joint", WITHOUT_PROFILE)
@pytest.mark.parametrize("lift", [3.0, 30.0, 300.0])
def test_lift_off_of_laws_without_a_profile(joint, lift) -> None:
    rise = lift * joint.normal_load / joint.normal_stiffness
    x = 0.3 * reach_of(joint)
    t = np.linspace(0.0, 1.0, 1001)[1:]
    whole = joint.coupled_response([x], separation=[joint.separation + rise])
    fine = joint.coupled_response(x * t, separation=joint.separation + rise * t)
    # Heights drawn by another library come with rounding of their own.
    rel = 1e-7 if isinstance(getattr(joint.surface, "heights", None), ms.Statistical) else 1e-9
    assert whole.dissipated_energy[0] == pytest.approx(fine.dissipated_energy[-1], rel=rel)


@every_joint
def test_far_away_there_is_neither_force_nor_loss(joint) -> None:
    d = joint.separation + np.array([1.0, 1e3, 1e20, 1e39, 1e3])
    x = reach_of(joint) * np.array([0.3, 1e3, -1e3, 1e30, 0.0])
    response = joint.coupled_response(x, separation=d)
    np.testing.assert_array_equal(response.force, 0.0)
    lost = response.energy_per_step
    assert np.isfinite(lost[0])
    assert lost[0] >= 0.0
    np.testing.assert_array_equal(lost[1:], 0.0)
