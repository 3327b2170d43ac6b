"""States of all nodes at once: single joints, differences, first loading, energies."""

from __future__ import annotations

import dataclasses
import pickle
import tracemalloc
from typing import Any

import numpy as np
import pytest
from usual import SURFACE, slope

import microslip as ms
from microslip.contact import NORMAL_LAWS
from microslip.contact.exact_curves import SlipLosses
from microslip.friction.memory import Diagram

NODES, SAMPLES = 6, 60
RNG = np.random.default_rng(3)
FIELD = ms.JointField(
    SURFACE,
    RNG.uniform(0.1, 0.8, NODES),
    areas=RNG.uniform(1e-6, 1e-5, NODES),
    pressures=RNG.uniform(1e5, 2e7, NODES),
)
# Eighths, so that records turn and close where they were before, and rest.
X = 1e-7 * RNG.integers(-12, 13, (SAMPLES, NODES)) / 4.0
D = FIELD.separations + 1e-7 * RNG.integers(-6, 7, (SAMPLES, NODES)) / 2.0


SURFACES_WITHOUT_PROFILE = [s for law in NORMAL_LAWS[1:] for s in law.examples()]


def joint(node: int) -> ms.Interface:
    own = dataclasses.replace(SURFACE, area=FIELD.areas[node])
    return ms.Interface(own, FIELD.friction[node], normal_load=FIELD.normal_loads[node])


def advanced(state: ms.FieldState, x: Any, d: Any = None) -> np.ndarray:
    """Forces along records, a step a row, each tried twice."""
    forces = []
    for i, row in enumerate(x):
        state.try_(-3.0 * row + 1e-7)
        forces.append(state.try_(row, None if d is None else d[i])[0])
        state.commit()
    return np.array(forces)


def test_nodes_are_joints_under_a_load_that_varies() -> None:
    state = FIELD.start(energies=True)
    forces = advanced(state, X, D)
    for i in range(NODES):
        wanted = joint(i).coupled_response(X[:, i], separation=D[:, i])
        scale = FIELD.friction[i] * wanted.normal_load.max()
        np.testing.assert_allclose(forces[:, i], wanted.force, rtol=0, atol=1e-13 * scale)
        assert state.dissipated_energy[i] == pytest.approx(wanted.dissipated_energy[-1], rel=1e-12)
        assert state.normal_load[i] == pytest.approx(wanted.normal_load[-1], rel=1e-13)
    np.testing.assert_allclose(state.displacement, X[-1], rtol=1e-15, atol=1e-30)
    np.testing.assert_allclose(state.separation, D[-1], rtol=1e-14)
    np.testing.assert_array_equal(state.force, forces[-1])


def test_tangents_are_differences() -> None:
    state = FIELD.start()
    advanced(state, X[:25], D[:25])
    for dx, dd in ((2e-8, 5e-8), (-3e-8, -4e-8), (1e-9, -9e-8), (6e-7, 1e-8), (-6e-7, 3e-7)):
        x, d = state.displacement + dx, state.separation + dd
        tangent = state.try_(x, d).tangent
        # Rounding: 2e-16 of mu N over 1e-13 m, against N over a length.
        atol = 3e-8 * np.abs(tangent).max(axis=(1, 2))
        for k, way in enumerate(np.eye(2)):

            def at(s: float, way: Any = way, x: Any = x, d: Any = d) -> np.ndarray:
                return np.stack(state.try_(x + s * way[0], d + s * way[1])[:2], axis=1)

            assert (np.abs(slope(at, 1e-13) - tangent[:, :, k]).max(axis=1) < atol).all()
        stiffness = state.try_(x)[1]
        assert (np.abs(slope(lambda s, x=x: state.try_(x + s)[0], 1e-13) - stiffness) < atol).all()


def noise_in_bursts(rng: np.random.Generator, steps: int, nodes: int) -> np.ndarray:
    """Return noise whose bursts decay, at times of their own in each node, shape (steps, nodes).

    A burst leaves many open reversals in one node while the start of a burst closes those of
    another. That makes the pool of rows grow and shrink in the same step.
    """
    x = np.empty((steps, nodes))
    for node in range(nodes):
        begin = 0
        while begin < steps:
            k = np.arange(min(int(rng.geometric(1 / 15)), steps - begin))
            burst = (-1.0) ** k * rng.uniform(0.75, 0.97) ** k
            rough = rng.uniform(0.7, 1.3, k.size) if rng.random() < 0.5 else 1.0
            x[begin : begin + k.size, node] = rng.choice([-1.0, 1.0]) * rough * burst
            begin += k.size
    return x


def few_nodes(rng: np.random.Generator, nodes: int) -> tuple[ms.JointField, list[ms.Interface]]:
    """Return a field of few nodes and the interfaces that it must equal."""
    friction, areas = rng.uniform(0.2, 0.7, nodes), rng.uniform(1e-6, 1e-5, nodes)
    field = ms.JointField(SURFACE, friction, areas=areas, pressures=rng.uniform(1e6, 2e7, nodes))
    single = [
        ms.Interface(dataclasses.replace(SURFACE, area=area), mu, normal_load=load)
        for area, mu, load in zip(areas, friction, field.normal_loads, strict=True)
    ]
    return field, single


@pytest.mark.parametrize("varying", [False, True], ids=["held", "varying"])
@pytest.mark.parametrize("nodes", [2, pytest.param(3, marks=pytest.mark.slow), 4])
def test_few_nodes_under_long_noise_are_single_states(nodes: int, varying: bool) -> None:
    """Forces, loads, tangents and energies at every step, whatever the pool of rows does.

    To rounding, not bit by bit: a node counts separations from its own rest and divides by the
    weight of its area, a single state counts from the separation of the interface.
    """
    # Of these seeds at least one makes a node outgrow the pool while another gives up rows.
    for seed in (1, 9, 20, 33):
        rng = np.random.default_rng(seed)
        field, joints = few_nodes(rng, nodes)
        x = 4e-7 * noise_in_bursts(rng, 300, nodes)
        d = field.separations + 1e-7 * rng.normal(size=x.shape)
        state, singles = field.start(energies=True), [j.start() for j in joints]
        found, wanted = [], []
        for i in range(len(x)):
            trial = state.try_(x[i], d[i] if varying else None)
            state.commit()
            both = trial.force, trial.load, *trial.tangent.reshape(nodes, 4).T
            found.append((*both, state.dissipated_energy))
            row = []
            for k, single in enumerate(singles):
                # At a held load the separation is stated all the same, so that there is a tangent.
                one = single.try_(x[i, k], separation=d[i, k] if varying else joints[k].separation)
                single.commit()
                row.append(
                    (one.force, one.normal_load, *one.tangent.flat, single.dissipated_energy)
                )
            wanted.append(np.transpose(row))
        got, right = np.array(found), np.array(wanted)
        # Relative to the largest of each quantity in each node.
        scale = np.abs(right).max(axis=0)
        scale[scale == 0.0] = 1.0
        np.testing.assert_allclose(
            got / scale, right / scale, rtol=0, atol=1e-12, err_msg=f"seed {seed}"
        )


@pytest.mark.parametrize("surface", SURFACES_WITHOUT_PROFILE, ids=str)
def test_laws_without_a_profile(surface: ms.NormalLaw) -> None:
    own = ms.Interface(surface, 0.4, normal_load=0.2 * surface.load(surface._span[0]))
    length = own.normal_load / own.normal_stiffness
    field = ms.JointField(
        surface, 0.4, areas=[1e-4, 1e-4], loads=own.normal_load, surface_area=1e-4
    )
    x = X[:30, :2] * own.slip_per_indentation * length / 2e-7
    d = own.separation + (D[:30, :2] - FIELD.separations[:2]) * length / 6e-7
    state = field.start(energies=True)
    forces = advanced(state, x, d)
    for i in range(2):
        wanted = own.coupled_response(x[:, i], separation=d[:, i])
        scale = 0.4 * wanted.normal_load.max()
        np.testing.assert_allclose(forces[:, i], wanted.force, rtol=0, atol=1e-12 * scale)
        # Their losses are sums by quadrature, good to 1e-9 over corners.
        assert state.dissipated_energy[i] == pytest.approx(wanted.dissipated_energy[-1], rel=1e-9)


def test_what_is_done_is_lost_once_settled() -> None:
    """The work of a settled cycle is what it dissipates: nothing else is kept."""
    t = 2.0 * np.pi * np.arange(1, 2001) / 1000
    state = FIELD.start(energies=True)
    work, lost, force, x_last, d = np.zeros(NODES), 0.0, 0.0, 0.0, FIELD.separations
    for i, angle in enumerate(t):
        x = 3e-7 * np.sin(angle)
        new = state.try_(x, d + 1e-7 * np.sin(angle + 1.0)).force
        state.commit()
        if i >= 1000:
            work += 0.5 * (force + new) * (x - x_last)
        elif i == 999:
            lost = state.dissipated_energy
        force, x_last = new, x
    # The trapezoidal rule's error is of second order: 1e-5.
    np.testing.assert_allclose(state.dissipated_energy - lost, work, rtol=2e-5)


def test_long_and_short_runs_lose_alike() -> None:
    """Long runs lose by integrals of N, short ones by quadrature; both by a quadrature of N''."""
    joint = ms.Interface.examples()[0].at(normal_load=2000.0)  # with a load curve of its own
    curve, rng = joint._load_curve, np.random.default_rng(2)
    moves = rng.normal(size=(2, 400)) * 10.0 ** rng.uniform(-5.0, 0.0, (2, 400))
    x, d = 3e-7 * np.cumsum(moves, axis=1) / (1.0 + 0.1 * np.abs(np.cumsum(moves, axis=1)))
    for steps in (d - d[0], np.zeros(400)):
        lost = Diagram().losses(steps, curve.slip * x, curve)
        wanted = SlipLosses(joint.surface, curve.origin).of(Diagram().runs(steps, x), x.size)
        wanted *= curve.friction * curve.slip
        np.testing.assert_allclose(lost, wanted, rtol=1e-11, atol=1e-10 * lost.mean())
        assert abs(lost.sum() / wanted.sum() - 1.0) < 2e-13


def test_try_changes_nothing_and_copies_are_independent() -> None:
    state = FIELD.start(energies=True)
    advanced(state, X[:10], D[:10])
    before = state.try_(X[11], D[11])
    other = state.copy()
    other.commit()
    advanced(other, X[12:20], D[12:20])
    state.rollback()
    after = state.try_(X[11], D[11])
    for one, two in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, two)
    state.rollback()
    with pytest.raises(ms.InputError, match="not accumulated; start the state with"):
        _ = FIELD.start().dissipated_energy


def test_states_are_small_and_grow_with_open_reversals_alone() -> None:
    nodes = 20_000
    field = ms.JointField(SURFACE, 0.3, areas=1e-5, loads=np.full(nodes, 50.0))
    field._nodes.curve.profile(0.0, 0.0)  # of the field, not of its states
    x = 1e-7 * np.sin(np.arange(nodes))
    field.start().try_(x)
    tracemalloc.start()
    state = field.start()
    for factor in (1.0, -0.5, 0.9):
        state.try_(factor * x)
        state.commit()
    state.try_(0.2 * x)
    held = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    reversals = state.open_reversals.sum()
    assert held < 200 * nodes + 40 * reversals
    before = len(state._rows)
    for k in range(30):  # ever smaller, for one node only
        state.try_(np.where(np.arange(nodes) == 7, 0.9**k * (-1.0) ** k, 0.2) * x)
        state.commit()
    assert state.open_reversals[7] > 20
    assert len(state._rows) <= before


@pytest.mark.parametrize("counts", [False, True])
@pytest.mark.parametrize("surface", [SURFACE, SURFACES_WITHOUT_PROFILE[0]], ids=["rough", "given"])
def test_states_go_through_pickles(surface: ms.NormalLaw, counts: bool) -> None:
    own = ms.Interface(surface, 0.4, normal_load=0.1 * surface.load(surface._span[0]))
    length = own.normal_load / own.normal_stiffness
    loads = own.normal_load * np.array([1.0, 0.0, 0.3])
    field = ms.JointField(surface, 0.4, areas=1e-4, loads=loads, surface_area=1e-4)
    x = X[:, :3] * own.slip_per_indentation * length / 2e-7
    d = field.separations + (D[:, :3] - FIELD.separations[:3] - 2e-7) * length / 6e-7
    state = field.start(energies=counts)
    advanced(state, x[:30], d[:30])
    other = pickle.loads(pickle.dumps(state))
    np.testing.assert_array_equal(other.force, state.force)
    same = advanced(state, x[30:], d[30:])
    scale = np.abs(same).max()
    np.testing.assert_allclose(advanced(other, x[30:], d[30:]), same, rtol=0, atol=1e-13 * scale)
    if counts:
        np.testing.assert_allclose(other.dissipated_energy, state.dissipated_energy, rtol=1e-9)
