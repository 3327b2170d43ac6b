"""Settled cycles under a separation that varies: the engine's second pass, and differences."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import ends_below, every_joint, reach_of
from hypothesis import given
from hypothesis import strategies as st
from usual import fine_slope, slope

import microslip as ms

WORKED = ms.Interface.examples()[0]
SPHERE = next(
    joint for joint in ms.Interface.examples() if isinstance(joint.surface, ms.SphereOnFlat)
)
SIZE = 96
T = 2.0 * np.pi * np.arange(SIZE) / SIZE
SHAPES = np.column_stack([np.ones(SIZE), *(f(k * T) for k in (1, 2, 3) for f in (np.cos, np.sin))])


def cycle(joint: ms.Interface, phase: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and separations with inner loops, sticking rows and lost rows."""
    depth = joint.normal_load / joint.normal_stiffness
    x = 0.2 + 0.8 * np.cos(T) + 0.3 * np.sin(3.0 * T + phase)
    lift = 0.45 if ends_below(joint) else 0.1
    d = lift + 0.3 * np.cos(T + 1.3 * phase) + 0.1 * np.sin(2.0 * T)
    return reach_of(joint) * x, joint.separation + depth * d


@every_joint
@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0, 3.0])
def test_it_is_the_second_pass_of_the_engine(joint, phase) -> None:
    x, d = cycle(joint, phase)
    response = joint.periodic(x, separation=d)
    whole = joint.coupled_response(np.tile(x, 4), separation=np.tile(d, 4))
    passes = whole.force.reshape(4, -1)
    atol = 1e-12 * joint.force_limit
    np.testing.assert_allclose(response.force, passes[1], rtol=0, atol=atol)
    np.testing.assert_allclose(passes[2:], passes[1:3], rtol=0, atol=atol)
    np.testing.assert_allclose(response.normal_load, joint.surface.load(d), rtol=1e-12)
    np.testing.assert_array_equal(response.separation, d)
    lost = whole.energy_per_step.reshape(4, -1).sum(axis=1)
    assert response.dissipated_energy == pytest.approx(lost[2], rel=1e-9)


@pytest.mark.parametrize("joint", [WORKED, SPHERE], ids=["rough", "sphere"])
@pytest.mark.parametrize("phase", [0.2, 1.0, 2.0, 2.6, 3.0])
def test_derivatives_of_smooth_laws_to_the_last_digit_of_differences(joint, phase) -> None:
    x, d = cycle(joint, phase)
    reach, depth = reach_of(joint), joint.normal_load / joint.normal_stiffness
    nothing = np.zeros_like(SHAPES)
    response = joint.periodic(x, separation=d)
    got = response.derivative(np.hstack((SHAPES, nothing)), separation=np.hstack((nothing, SHAPES)))

    for k in range(14):
        move, rise = (0.0, depth * SHAPES[:, k - 7]) if k >= 7 else (reach * SHAPES[:, k], 0.0)

        def at(s: float, move: Any = move, rise: Any = rise) -> np.ndarray:
            return joint.periodic(x + s * move, separation=d + s * rise).force

        wanted, near, scale = fine_slope(at, 2e-5), slope(at, 1e-6), reach if k < 7 else depth
        error = np.abs(scale * got[:, k] - wanted) / joint.force_limit
        assert np.quantile(error, 0.98) < 1e-9
        # A sample next to a kink is seen by the small step only, to that one's rounding.
        close = np.abs(scale * got[:, k] - near) / joint.force_limit
        assert np.minimum(error, close).max() < 1e-6


@every_joint
def test_derivatives_against_differences(joint) -> None:
    """Where a last summit or a knot bends the law, a difference is good to first order only."""
    reach, depth = reach_of(joint), joint.normal_load / joint.normal_stiffness
    for phase in (0.3, 2.1):
        x, d = cycle(joint, phase)
        response = joint.periodic(x, separation=d)
        for shape in SHAPES[:, :4].T:
            for move, rise in ((reach * shape, 0.0 * shape), (0.0 * shape, depth * shape)):
                got = response.derivative(move, separation=rise)

                def at(s: float, x: Any = x, d: Any = d, move: Any = move, rise: Any = rise) -> Any:
                    return joint.periodic(x + s * move, separation=d + s * rise).force

                error = np.abs(slope(at, 1e-6) - got) / joint.force_limit
                assert np.median(error) < 1e-6
                assert np.quantile(error, 0.85) < 1e-4
        np.testing.assert_allclose(
            response.derivative(SHAPES[:, 1]) + response.derivative(separation=SHAPES[:, 2]),
            response.derivative(SHAPES[:, 1], separation=SHAPES[:, 2]),
            rtol=1e-12,
            atol=1e-12 * joint.tangential_stiffness,
        )


@every_joint
def test_a_constant_separation_is_the_other_engine(joint) -> None:
    x, _ = cycle(joint, 0.7)
    plain = joint.periodic(x)
    coupled = joint.periodic(x, separation=joint.separation)
    atol = 2e-12 * joint.force_limit
    np.testing.assert_allclose(coupled.force, plain.force, rtol=0, atol=atol)
    np.testing.assert_allclose(
        coupled.derivative(SHAPES), plain.derivative(SHAPES),
        rtol=0, atol=1e-8 * joint.tangential_stiffness,
    )  # fmt: skip
    # Off the first loading curve, where a front passes a summit, it is the same stiffness, too.
    same = np.isclose(coupled.stiffness, plain.stiffness, rtol=1e-9)
    assert np.mean(same) > 0.95


@pytest.mark.parametrize("rest", [0.0, 3e-7, -2e-7, "mean"])
def test_where_the_joint_began(rest) -> None:
    """From a displacement of its own, or from the mean, which moves along."""
    joint = WORKED
    x, d = cycle(joint, 0.5)
    x = x + 0.1 * reach_of(joint) * np.cos(2.0 * T)  # one largest size, not two
    begin = x.mean() if rest == "mean" else rest
    for given_ in ({}, {"separation": d}):
        response = joint.periodic(x, rest=rest, **given_)
        shifted = joint.periodic(x - begin, **given_)
        np.testing.assert_array_equal(response.force, shifted.force)
        got = response.derivative(reach_of(joint) * SHAPES)
        for column, shape in zip(got.T, reach_of(joint) * SHAPES.T, strict=True):

            def at(s: float, shape: Any = shape, given_: Any = given_) -> np.ndarray:
                return joint.periodic(x + s * shape, rest=rest, **given_).force

            wanted = slope(at, 1e-5)
            np.testing.assert_allclose(column, wanted, rtol=0, atol=1e-7 * joint.force_limit)
    if rest == "mean":
        np.testing.assert_allclose(got[:, 0], 0.0, atol=1e-12 * joint.force_limit)


@every_joint
@given(
    moves=st.lists(
        st.tuples(st.integers(-6, 6).map(lambda k: k / 8), st.integers(-4, 4).map(lambda k: k / 8)),
        min_size=1,
        max_size=12,
    )
)
def test_any_cycle_settles_in_one_pass(joint, moves) -> None:
    """Ties, repeated samples, lift-off and proportional steps among them."""
    depth = joint.normal_load / joint.normal_stiffness
    x, d = np.array(moves).T
    if ends_below(joint):
        d = np.abs(d)
    x, d = 2.0 * reach_of(joint) * x, joint.separation + depth * d
    response = joint.periodic(x, separation=d)
    passes = joint.coupled_force(np.tile(x, 4), separation=np.tile(d, 4)).reshape(4, -1)
    heavy = joint.friction_coefficient * max(response.normal_load.max(), joint.normal_load)
    np.testing.assert_allclose(response.force, passes[1], rtol=0, atol=1e-12 * heavy)
    np.testing.assert_allclose(passes[2:], passes[1:3], rtol=0, atol=1e-11 * heavy)
    changes = response.derivative(np.ones(x.size), separation=np.ones(x.size))
    assert np.all(np.isfinite(changes))
    assert response.dissipated_energy >= 0.0


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({}, "displacement or separation must be given"),
        ({"displacement": np.ones(3)}, "displacement must have one row for each of the 96"),
        (
            {"displacement": np.ones(SIZE), "separation": np.ones((SIZE, 2))},
            "directions must have the same shape",
        ),
        ({"displacement": np.full(SIZE, np.nan)}, "displacement must be finite"),
    ],
)
def test_directions_that_have_no_answer_are_refused(given_, message) -> None:
    x, d = cycle(WORKED, 0.0)
    response = WORKED.periodic(x, separation=d)
    with pytest.raises(ms.InputError, match=message):
        response.derivative(**given_)


def test_other_refusals() -> None:
    x, d = cycle(WORKED, 0.0)
    for call, message in (
        (lambda: WORKED.periodic(x, rest="zero"), "rest must be a displacement"),
        (lambda: WORKED.periodic(x, rest=np.nan), "rest must be a finite number"),
        (lambda: WORKED.periodic(x, separation=d[:4]), "one for each of the 96 samples"),
        (lambda: WORKED.periodic(x).derivative(np.ones((4, 2))), "one row for each of the 96"),
    ):
        with pytest.raises(ms.InputError, match=message):
            call()
