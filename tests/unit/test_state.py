"""States: trials, commits, records piece by piece, and what is kept when something is refused."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from cases import refusal
from usual import JOINT, SLIP

import microslip as ms

REACH = 2.0 * SLIP  # there most contacts slip


def record(size: int) -> np.ndarray:
    walk = np.random.default_rng(3).normal(size=size)
    walk[10:13] = walk[9]  # a rest
    walk[20:30] = np.linspace(walk[20], 3.0, 10)  # a run that closes loops
    return REACH * walk


def snapshot(state: ms.State) -> tuple[float, float, int, bytes]:
    future = REACH * np.array([0.1, -0.3, 2.0, -4.0])
    return (
        state.displacement,
        state.force,
        state.open_reversals,
        state.copy().advance(future).tobytes(),
    )


# -- right use -------------------------------------------------------------------------------------


def test_what_is_stored_grows_with_open_reversals_only() -> None:
    JOINT.force([1e-7, 2e-7])  # what the joint itself keeps is there from now on
    state = JOINT.start()
    before = len(pickle.dumps(state))
    wave = 1e-6 * np.sin(np.linspace(0.0, 400.0 * np.pi, 100_001))
    for part in np.array_split(wave, 7):
        state.advance(part)
    for x in wave[:1500].tolist():
        state.try_(x)
        state.commit()
    assert state.open_reversals <= 2
    assert len(pickle.dumps(state)) - before < 4096
    decay = wave * np.linspace(1.0, 0.0, wave.size)
    state.advance(2.0 * decay)
    assert 350 < state.open_reversals < 450
    assert len(pickle.dumps(state)) - before < 64 * 1024
    state.advance(3e-6)
    assert state.open_reversals == 0
    assert len(pickle.dumps(state)) - before < 4096


# -- trials and copies: tests/physics/test_properties.py has their rules, on every law -------------


def test_commit_needs_a_trial() -> None:
    message = "commit needs a trial; call try_(displacement) first"
    state = JOINT.start()
    state.rollback()  # nothing to forget is fine
    assert refusal(state.commit) == message
    state.try_(1e-7)
    state.rollback()
    assert refusal(state.commit) == message
    state.try_(1e-7)
    state.commit()
    assert refusal(state.commit) == message
    state.try_(2e-7)
    state.advance([0.0])
    assert refusal(state.commit) == message


# -- refusals --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "bad",
    [[], [np.nan], [1e-7, np.inf], [1e-7, 2e-7, -np.inf], [[1e-7]], None, "x", [1j], [1e-7, None]],
    ids=str,
)
def test_refused_record_changes_nothing(bad: object) -> None:
    state = JOINT.start()
    state.advance(record(30))
    force, stiffness = state.try_(0.3 * REACH)
    before = snapshot(state)
    refusal(state.advance, bad)
    assert snapshot(state) == before
    state.commit()  # the trial is still there
    assert (state.displacement, state.force) == (0.3 * REACH, force)
    assert np.isfinite(stiffness)


@pytest.mark.parametrize("seed", range(4))
def test_a_limited_depth_tells_a_bound_that_holds(seed):
    """Beside the exact memory: a decay stays exact, noise within the bound; saved states go on."""
    rng, n = np.random.default_rng(seed), 600
    decay = np.exp(-np.arange(n) / 200) * np.cos(np.arange(n) * np.pi / 3)
    x = 3e-7 * (rng.standard_normal(n) if seed % 2 else decay)
    x[-1] = 1e-5  # beyond everything
    d = JOINT.separation + 1e-7 * (seed > 1) * rng.standard_normal(n)
    field = ms.JointField(
        JOINT.surface, 0.55, areas=[1.0, 2.0], separations=JOINT.separation,
        surface_area=1.0,
    )  # fmt: skip
    wanted = JOINT.coupled_force(x, separation=d)
    for depth in (4, 10):
        one, many = JOINT.start(depth=depth), field.start(depth=depth)
        pieces = JOINT.start(depth=depth)
        for i in range(n):
            trial = one.try_(x[i], separation=d[i])
            answer = many.try_([x[i]] * 2, separations=[d[i]] * 2)
            one.commit(), many.commit()
            tiny = 1e-9 * JOINT.force_limit
            assert abs(trial.force - wanted[i]) <= one.error_bound + tiny
            assert np.all(abs(answer.force / [1.0, 2.0] - wanted[i]) <= many.error_bound + tiny)
            assert one.open_reversals <= depth
            assert many.open_reversals.max() <= depth
            if i % 200 == 100:
                one, many = pickle.loads(pickle.dumps((one, many)))
        forces = np.concatenate([pieces.advance(x[k : k + 60], separation=d[k : k + 60])
                                 for k in range(0, n, 60)])  # fmt: skip
        assert np.all(abs(forces - wanted) <= pieces.error_bound + tiny)
        assert pieces.open_reversals <= depth
        assert forces[-1] == pytest.approx(wanted[-1], rel=1e-9)
        assert trial.force == pytest.approx(wanted[-1], rel=1e-9)
        if seed == 0:
            assert one.error_bound == 0.0


def test_a_depth_is_refused_where_it_cannot_be_kept():
    with pytest.raises(ms.InputError, match="depth must be an integer from 4"):
        JOINT.start(depth=3)
    with pytest.raises(ms.InputError, match="depth must be None for a law without a surface"):
        ms.Jenkins(1e8, 10.0).start(depth=8)
