"""The settled cycle as solvers take it: forces, stiffnesses and the tree of its derivative."""

from __future__ import annotations

import numpy as np
import pytest
from cases import all_laws, is_polygon, law_params, reach_of, records, stiffness_of
from hypothesis import assume, given
from hypothesis import strategies as st
from usual import fine_slope, slope

import microslip as ms

ROUNDING = 1e-14  # of the force limit


def order_from(root: int, size: int) -> list[int]:
    """Samples in the cyclic order that begins at the root."""
    return [(root + i) % size for i in range(size)]


def derivative(response: ms.friction.PeriodicResponse, change: np.ndarray) -> np.ndarray:
    """dT/dp by D[t] = D[parent] + k[t] (c'[t] - c'[parent]), for c' = dc/dp."""
    root = response.root
    result = np.full(change.size, np.nan)
    for t in order_from(root, change.size):
        parent, stiffness = int(response.parent[t]), response.stiffness[t]
        if t == root:
            result[t] = stiffness * change[t]
        else:
            result[t] = result[parent] + stiffness * (change[t] - change[parent])
    assert np.all(np.isfinite(result))  # no parent after its child
    return result


@all_laws
@given(x=records(max_size=40))
def test_periodic_is_the_second_pass(law, x):
    x = x * reach_of(law)
    response = law.periodic(x)
    passes = law.force(np.tile(x, 4)).reshape(4, -1)
    atol = ROUNDING * law.force_limit
    np.testing.assert_allclose(response.force, passes[1], rtol=0, atol=atol)
    # Settled it is: after the second pass nothing changes any more.
    np.testing.assert_allclose(passes[2:], passes[1:3], rtol=0, atol=atol)
    state = law.start()
    state.advance(x)
    slopes = []
    for v in x:
        slopes.append(state.try_(v)[1])
        state.commit()
    # As trials of the second pass see it, but at samples that close a loop from another branch.
    same = np.isclose(response.stiffness, slopes, rtol=0, atol=1e-12 * stiffness_of(law))
    assert np.mean(same) >= 0.5
    assert same[response.root]


@all_laws
@given(x=records(max_size=40))
def test_tree(law, x):
    x = x * reach_of(law)
    force, stiffness, parent, root = law.periodic(x)
    assert root == int(np.argmax(np.abs(x)))
    assert parent[root] == root
    assert force.shape == stiffness.shape == parent.shape == x.shape
    rank = {t: i for i, t in enumerate(order_from(root, x.size))}
    np.testing.assert_allclose(force[root], law.backbone(x[root]), rtol=1e-14)
    for t in range(x.size):
        p = int(parent[t])
        if t == root:
            continue
        assert rank[p] < rank[t]
        # Each sample hangs from its reversal by Masing's branch, and its stiffness is that one's.
        if abs(x[t]) == abs(x[root]):
            assert p == root  # as far as the root: on the first loading curve again
            half = abs(x[t])
            # By the branch that closes there or by the first loading curve: but for rounding.
            end = abs(abs(force[t]) - abs(force[root]))
            assert end <= 2 * ROUNDING * law.force_limit
        else:
            half = 0.5 * abs(x[t] - x[p])
            rise = 2 * np.sign(x[t] - x[p]) * law.backbone(half)
            assert abs(force[p] + rise - force[t]) <= 2 * ROUNDING * law.force_limit
        assert stiffness[t] == pytest.approx(
            law.backbone_stiffness(half), rel=1e-12, abs=1e-12 * stiffness_of(law)
        )
        # Branches nest: none is longer than the one that its reversal hangs from.
        if abs(x[p]) != abs(x[root]):
            assert abs(x[t] - x[p]) <= abs(x[p] - x[int(parent[p])]) + 1e-12 * abs(x[p])


@all_laws
@given(x=records(max_size=40), data=st.data())
def test_derivative_is_the_recursion(law, x, data):
    """Down the tree in one call, one column or many, from rest or from the mean."""
    x = x * reach_of(law)
    assume(np.ptp(x) > 0.0)
    seed = data.draw(st.integers(0, 9))
    directions = np.random.default_rng(seed).normal(size=(x.size, 3))
    response = law.periodic(x)
    assume(np.all(np.isfinite(response.stiffness)))
    got = response.derivative(directions)
    wanted = np.column_stack([derivative(response, column) for column in directions.T])
    atol = 1e-12 * np.abs(response.stiffness).max() * x.size
    np.testing.assert_allclose(got, wanted, rtol=0, atol=atol)
    np.testing.assert_array_equal(response.derivative(directions[:, 0]), got[:, 0])
    about = law.periodic(x, rest="mean")
    np.testing.assert_array_equal(about.force, law.periodic(x - x.mean()).force)
    level = directions - directions.mean(axis=0)
    np.testing.assert_allclose(
        about.derivative(directions), law.periodic(x - x.mean()).derivative(level), rtol=0,
        atol=1e-12 * np.abs(about.stiffness).max() * x.size,
    )  # fmt: skip


@all_laws
def test_derivative_against_finite_differences(law):
    """With respect to each Fourier coefficient of a displacement with minor loops."""
    size = 64
    t = 2 * np.pi * np.arange(size) / size
    x = 0.3 + np.cos(t) + 0.5 * np.sin(2 * t + 0.3) + 0.6 * np.cos(5 * t + 1) + 0.1 * np.sin(9 * t)
    reach = reach_of(law)
    response = law.periodic(reach * x)
    assert len(set(response.parent.tolist())) >= 6
    shapes = [np.ones(size), *(f(k * t) for k in (1, 2, 5, 7) for f in (np.cos, np.sin))]
    for shape in shapes:
        got = derivative(response, shape) * reach
        wanted = fine_slope(lambda s, way=shape: law.periodic(reach * (x + s * way)).force, 1e-4)
        # A backbone that bends (one sphere's end, a table's knots) leaves the step size to first
        # order at the odd sample; all others agree to the noise of the difference.
        error = np.abs(got - wanted) / law.force_limit
        assert np.median(error) < 1e-7
        # A thousand corners are met more often than a few.
        assert np.quantile(error, 0.9) < (1e-4 if is_polygon(law) else 1e-5)
        assert error.max() < 2e-2


def test_derivative_of_a_smooth_law_is_good_everywhere():
    law = law_params()[0].values[0]
    rng = np.random.default_rng(3)
    t = 2 * np.pi * np.arange(200) / 200
    for _ in range(5):
        a = rng.normal(size=(2, 6)) / np.arange(1, 7)
        harmonics = np.array([[np.cos(k * t), np.sin(k * t)] for k in range(1, 7)])
        x = np.einsum("ck,kct->t", a, harmonics) * reach_of(law)
        shape = harmonics[int(rng.integers(6)), int(rng.integers(2))]
        got = derivative(law.periodic(x), shape) * reach_of(law)
        way = shape * reach_of(law)
        wanted = slope(lambda s, x=x, way=way: law.periodic(x + s * way).force, 3e-5)
        np.testing.assert_allclose(wanted, got, rtol=0, atol=1e-7 * law.force_limit)


@all_laws
@given(data=st.data(), x=records(min_size=2, max_size=20))
def test_where_a_cycle_begins_does_not_matter(law, data, x):
    """Rolled, the same cycle; reflected, the mirror image."""
    x = x * reach_of(law)
    # Of two largest samples of one size the first is the root.
    assume(np.sum(np.abs(x) == np.abs(x).max()) == 1)
    shift = data.draw(st.integers(0, x.size - 1))
    first, rolled = law.periodic(x), law.periodic(np.roll(x, shift))
    atol = ROUNDING * law.force_limit
    np.testing.assert_allclose(np.roll(first.force, shift), rolled.force, rtol=0, atol=atol)
    assert (first.root + shift) % x.size == rolled.root
    np.testing.assert_array_equal(np.roll((first.parent + shift) % x.size, shift), rolled.parent)
    mirror = law.periodic(-x)
    np.testing.assert_array_equal(mirror.force, -first.force)
    np.testing.assert_array_equal(mirror.parent, first.parent)
    np.testing.assert_array_equal(mirror.stiffness, first.stiffness)


@all_laws
def test_symmetric_cycle_is_the_loop(law):
    """A sine: the settled cycle is the closed loop of its amplitude."""
    a = 0.9 * reach_of(law)
    x = a * np.cos(2 * np.pi * np.arange(128) / 128)
    x[64] = -a
    response = law.periodic(x)
    assert response.root == 0
    loop = law.loop(a, samples=129)
    np.testing.assert_allclose(loop.displacement[:-1], x, rtol=0, atol=1e-15 * a)
    np.testing.assert_allclose(
        response.force, loop.force[:-1], rtol=0, atol=2e-14 * law.force_limit
    )
    work = np.sum(0.5 * (response.force + np.roll(response.force, -1)) * (np.roll(x, -1) - x))
    nothing = 1e-15 * 4 * a * law.force_limit
    assert work == pytest.approx(law.dissipated_energy(a), rel=2e-2, abs=nothing)


@all_laws
def test_degenerate_cycles(law):
    assert law.periodic([0.0, 0.0]).force.tolist() == [0.0, 0.0]
    held = law.periodic(np.full(5, 0.5 * reach_of(law)))
    assert held.root == 0
    np.testing.assert_allclose(held.force, law.backbone(0.5 * reach_of(law)), rtol=1e-14)
    one = law.periodic([-0.3 * reach_of(law)])
    assert one.parent.tolist() == [0]
    assert one.force[0] == pytest.approx(-law.backbone(0.3 * reach_of(law)), rel=1e-14, abs=0)
    assert derivative(one, np.ones(1))[0] == pytest.approx(
        law.backbone_stiffness(0.3 * reach_of(law)), rel=1e-12, abs=0
    )
