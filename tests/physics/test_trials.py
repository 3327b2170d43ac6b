"""States as contact elements: loads, tangents, what has been dissipated, and plain arrays."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from cases import all_laws, ends_below, every_joint, reach_of, records
from hypothesis import given
from hypothesis import strategies as st

import microslip as ms
from microslip.friction.energies import energies_along

WORKED = ms.Interface.examples()[0]
EPS = np.finfo(float).eps


def walk(joint: ms.Interface, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    depth = joint.normal_load / joint.normal_stiffness
    share = rng.uniform(-0.4, 0.4, count)
    if ends_below(joint):
        share = np.abs(share)
    return joint.separation + depth * share, reach_of(joint) * rng.uniform(-0.8, 0.8, count)


@every_joint
def test_trials_tell_force_load_and_tangents(joint) -> None:
    depth, reach = joint.normal_load / joint.normal_stiffness, reach_of(joint)
    state, errors = joint.start(), []
    d, x = walk(joint, 24, seed=7)
    whole = joint.coupled_response(x, separation=d)
    heavy = joint.friction_coefficient * whole.normal_load.max()
    for i, (d_, x_) in enumerate(zip(d, x, strict=True)):
        trial = state.try_(x_, separation=d_)
        force, stiffness = trial
        assert (trial.force, trial.stiffness, trial.displacement) == (force, stiffness, x_)
        assert force == pytest.approx(whole.force[i], abs=1e-12 * heavy)
        assert trial.normal_load == trial.load == pytest.approx(whole.normal_load[i], rel=1e-12)
        assert trial.separation == pytest.approx(d_, rel=1e-14)
        tangent = trial.tangent
        assert tangent[0, 0] == stiffness
        for column, (dx, dd) in enumerate(((1e-6 * reach, 0.0), (0.0, 1e-6 * depth))):
            up = state.try_(x_ + dx, separation=max(d_ + dd, d.min()))
            down = state.try_(x_ - dx, separation=max(d_ - dd, d.min()))
            step = 2.0 * dx + (up.separation - down.separation)
            scale = joint.tangential_stiffness if column == 0 else joint.normal_stiffness
            for row, name in enumerate(("force", "normal_load")):
                slope = (getattr(up, name) - getattr(down, name)) / step
                errors.append(abs(slope - tangent[row, column]) / scale)
        state.try_(x_, separation=d_)
        state.commit()
        assert state.normal_load == pytest.approx(whole.normal_load[i], rel=1e-12)
        assert state.separation == pytest.approx(d_, rel=1e-14)
    assert np.median(errors) < 1e-7
    assert np.quantile(errors, 0.9) < 1e-4  # a last summit or a knot within the difference
    most = heavy * np.abs(np.diff(x, prepend=0.0)).sum()
    total = whole.dissipated_energy[-1]
    assert state.dissipated_energy == pytest.approx(total, rel=1e-11, abs=1e-14 * most)


@every_joint
def test_the_plain_engine_tells_the_same_tangent(joint) -> None:
    """Before the load has ever varied, and with a separation given that is the joint's own."""
    rng = np.random.default_rng(1)
    x = reach_of(joint) * rng.uniform(-0.9, 0.9, 12)
    plain, coupled = joint.start(), joint.start()
    for v in x:
        one, other = plain.try_(v), coupled.try_(v, separation=joint.separation)
        np.testing.assert_allclose(
            one.tangent, other.tangent, rtol=1e-9, atol=1e-9 * joint.tangential_stiffness
        )
        assert one.normal_load == pytest.approx(joint.normal_load, rel=1e-12)
        plain.commit()
        coupled.commit()
        assert plain.stiffness == pytest.approx(coupled.stiffness, rel=1e-9)
        total = coupled.dissipated_energy
        assert plain.dissipated_energy == pytest.approx(total, rel=1e-8, abs=1e-13 * total)


@all_laws
@given(x=records(max_size=30), cut=st.integers(0, 30))
def test_dissipated_energy_of_a_state(law, x, cut):
    """Work is store and loss; pieces, trials and the whole tell the same."""
    x = x * reach_of(law)
    wanted = energies_along(law, x, law.force(x))[1][-1]
    whole = law.start()
    whole.advance(x)
    state = law.start()
    for v in x[:cut]:
        state.try_(float(v))
        state.commit()
    if cut < x.size:
        state.advance(x[cut:])
    most = law.force_limit * np.abs(np.diff(x, prepend=0.0)).sum()
    assert whole.dissipated_energy == pytest.approx(wanted, rel=1e-10, abs=1e-12 * most)
    assert state.dissipated_energy == pytest.approx(whole.dissipated_energy, rel=1e-12, abs=0)


@every_joint
def test_states_under_a_varying_load_go_through_pickles(joint) -> None:
    d, x = walk(joint, 40, seed=4)
    state = joint.start()
    state.advance(x[:30], separation=d[:30])
    other = pickle.loads(pickle.dumps(state))
    assert other.dissipated_energy == state.dissipated_energy
    np.testing.assert_array_equal(
        other.advance(x[30:], separation=d[30:]), state.advance(x[30:], separation=d[30:])
    )
    assert other.dissipated_energy == state.dissipated_energy


def test_a_reversal_costs_the_same_for_any_number_of_open_ones() -> None:
    """It looks at the reversals that it closes, and at no others."""
    state = WORKED.start()
    count = 2000
    state.advance(1e-6 * (1.0 - np.arange(count) / count / 2) * (-1.0) ** np.arange(count))
    looked = []
    closed = type(state._memory).closed

    def watched(memory, x, first=0):
        looked.append(memory.depth - first)
        return closed(memory, x, first)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(state._memory), "closed", watched)
        for k in range(20):  # ever larger: each closes the loop of those before it
            state.try_(1e-9 * 1.3**k * (-1.0) ** k)
            state.commit()
    assert looked
    assert max(looked) < 10


def test_other_refusals() -> None:
    spring = ms.Jenkins(1e7, 5.0).start()
    for call in (
        lambda: spring.try_(1e-7, separation=0.0),
        lambda: spring.try_(1e-7).tangent,
        lambda: spring.normal_load,
        lambda: spring.advance([1e-7], separation=[0.0]),
    ):
        with pytest.raises(ms.InputError, match="has no meaning for a law without a surface"):
            call()
    assert spring.try_(1e-7).stiffness == 1e7
