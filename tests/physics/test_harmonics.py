"""Fourier coefficients of the settled force: dense quadrature, differences, closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from cases import all_laws, is_elastic, law_params, reach_of
from scipy.optimize import brentq
from usual import fine_slope, slope

import microslip as ms

COULOMB = ms.Coulomb(force_limit=3.0)
WORKED = ms.Interface.examples()[0]


def functions(t: np.ndarray, harmonics: list[int]) -> np.ndarray:
    columns = []
    for n in harmonics:
        columns += [np.ones_like(t)] if n == 0 else [np.cos(n * t), np.sin(n * t)]
    return np.column_stack(columns)


def dense(law: ms.BackboneLaw, c: np.ndarray, harmonics: list[int], panels: int) -> np.ndarray:
    """Coefficients by a rule on many panels between the turning points, which are samples, too."""

    def speed(t: float) -> float:
        return float((functions(np.array([t + 1e-6]), harmonics) @ c)[0]
                     - (functions(np.array([t - 1e-6]), harmonics) @ c)[0])  # fmt: skip

    grid = np.linspace(0.013, 0.013 + 2.0 * math.pi, 400)
    turns = [brentq(speed, a, b, xtol=1e-15) for a, b in pairwise(grid) if speed(a) * speed(b) < 0]
    edges = np.concatenate([
        np.linspace(a, b, panels + 1)[:-1] for a, b in pairwise([*turns, turns[0] + 2.0 * math.pi])
    ])  # fmt: skip
    ends = np.append(edges[1:], turns[0] + 2.0 * math.pi)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    t = np.column_stack(
        (edges, 0.5 * (edges + ends)[:, None] + 0.5 * np.outer(ends - edges, nodes))
    )
    w = np.column_stack((0.0 * edges, 0.5 * np.outer(ends - edges, weights)))
    waves = functions(t.ravel(), harmonics)
    integrals = waves.T @ (w.ravel() * law.periodic(waves @ c).force) / math.pi
    integrals[0] *= 0.5
    return integrals


@pytest.mark.parametrize("law", law_params(which=lambda law: law._kinks.size > 60))
def test_coefficients_against_dense_quadrature(law) -> None:
    """Two inner loops and a mean, of laws with many kinks; test_exactness.py has all others."""
    harmonics = [0, 1, 3]
    c = reach_of(law) * np.array([0.3, 1.1, 0.4, 0.5, -0.7])
    got = law.harmonics(c, harmonics)
    wanted = dense(law, c, harmonics, 6000)
    # The panels do not know where loops close: their error, not that of the pieces.
    np.testing.assert_allclose(got.force, wanted, rtol=0, atol=2e-10 * law.force_limit)


@all_laws
def test_one_harmonic_against_samples(law) -> None:
    """Samples that hit the turning points, of which one harmonic has two."""
    size = 65536
    t = 2.0 * np.pi * np.arange(size) / size
    c = np.array([0.0, 0.9 * reach_of(law), 0.0])
    force, jacobian = law.harmonics(c, [0, 1])
    sampled = law.periodic(c[1] * np.cos(t)).force
    wanted = 2.0 / size * functions(t, [0, 1]).T @ sampled
    # A jump is met by samples to first order, a kink to second.
    rough = 8.0 / size if not is_elastic(law) else 2.0 / size**2 * 10.0 + 1e-10
    assert force[0] == pytest.approx(0.5 * wanted[0], abs=rough * law.force_limit)
    np.testing.assert_allclose(force[1:], wanted[1:], rtol=0, atol=rough * law.force_limit)
    # Work of the settled cycle: the loop's area, and that the phase does not matter.
    energy = law.dissipated_energy(c[1])
    assert math.pi * c[1] * -force[2] == pytest.approx(
        -energy if force[2] > 0 else energy, rel=1e-9, abs=1e-10 * c[1] * law.force_limit
    )
    turned = law.harmonics([0.0, 0.0, c[1]], [0, 1])
    np.testing.assert_allclose(
        turned.force, [force[0], -force[2], force[1]], rtol=0, atol=2e-10 * law.force_limit
    )
    assert jacobian.shape == (3, 3)


# A thousand kinks take a second a pair: they are met from zero.
@pytest.mark.parametrize(
    ("law", "rest"),
    [
        pytest.param(*param.values, rest, id=f"{param.id}-{rest}", marks=param.marks)
        for param in law_params()
        for rest in (0.0, "mean", "there")
        if rest == 0.0 or param.values[0]._kinks.size <= 100
    ],
)
def test_jacobian_against_differences(law, rest) -> None:
    harmonics, reach = [0, 1, 3], reach_of(law)
    begin = 0.1 * reach if rest == "there" else rest
    c = reach * np.array([0.3, 1.1, 0.4, 0.5, -0.7])
    jacobian = law.harmonics(c, harmonics, begin).jacobian
    scale = law.tangential_stiffness if is_elastic(law) else law.force_limit / reach
    for column, move in zip(jacobian.T, np.eye(5), strict=True):
        wanted = fine_slope(
            lambda s, move=move: law.harmonics(c + s * move, harmonics, begin).force, 1e-5 * reach
        )
        np.testing.assert_allclose(column, wanted, rtol=0, atol=1e-8 * scale)
    if rest == "mean":
        np.testing.assert_allclose(jacobian[:, 0], 0.0, atol=1e-12 * scale)


def test_rigid_friction_in_closed_form() -> None:
    """Coulomb under a cosine: a square wave, whose phase turns with the motion."""
    force, jacobian = COULOMB.harmonics([0.0, 2e-6, 0.0], [0, 1])
    wave = 4.0 * 3.0 / math.pi
    np.testing.assert_allclose(force, [0.0, 0.0, -wave], atol=1e-12)
    np.testing.assert_allclose(jacobian[1:, 1:], [[0.0, wave / 2e-6], [0.0, 0.0]], atol=1e-3)


@pytest.mark.parametrize("orders", [range(4), [0, 1, 40]])
def test_rigid_friction_in_parallel_adds_its_square_wave(orders) -> None:
    """Coefficients by signs between turning points, and a Jacobian by differences."""
    soft = ms.Jenkins(1e7, 2.0)
    both, harmonics = ms.Parallel([soft, COULOMB, ms.Coulomb(1.0)]), list(orders)
    c = 5e-7 * np.random.default_rng(1).normal(size=2 * len(harmonics) - 1)
    found, alone = both.harmonics(c, harmonics), soft.harmonics(c, harmonics)
    t = 2.0 * math.pi * (np.arange(400_000) + 0.5) / 400_000
    speed = np.gradient(functions(t, harmonics) @ c)
    wave = functions(t, harmonics).T @ np.sign(speed) * (2.0 * 4.0 / t.size)
    wave[0] *= 0.5
    assert np.abs(found.force - alone.force - wave).max() < 1e-3
    assert np.isfinite(found.jacobian).all()
    for k, move in enumerate(np.eye(c.size)):
        wanted = slope(lambda s, way=move: both.harmonics(c + s * way, harmonics).force, 1e-12)
        scale = np.abs(found.jacobian).max()
        np.testing.assert_allclose(found.jacobian[:, k], wanted, rtol=0, atol=1e-4 * scale)


def test_a_separation_that_does_not_vary_is_the_other_integration() -> None:
    c = reach_of(WORKED) * np.array([0.2, 0.9, 0.1, 0.3, -0.2])
    held = WORKED.separation * np.eye(1, 5)[0]
    plain, varied = WORKED.harmonics(c, [0, 1, 2]), WORKED.harmonics(c, [0, 1, 2], separation=held)
    assert varied.jacobian.shape == (2, 2, 5, 5)
    atol = 1e-9 * WORKED.force_limit
    np.testing.assert_allclose(varied.force, plain.force, rtol=0, atol=atol)
    np.testing.assert_allclose(
        varied.jacobian[0, 0], plain.jacobian, rtol=0, atol=1e-7 * WORKED.tangential_stiffness
    )


def test_rest_and_tiny_motions() -> None:
    c = np.array([3e-7, 0.0, 0.0])
    force, jacobian = WORKED.harmonics(c, [0, 1])
    np.testing.assert_allclose(force, [WORKED.backbone(3e-7), 0.0, 0.0], rtol=1e-13)
    assert jacobian[0, 0] == pytest.approx(WORKED.backbone_stiffness(3e-7), rel=1e-12)
    small = WORKED.harmonics([3e-7, 1e-12, 0.0], [0, 1])
    np.testing.assert_allclose(small.jacobian[1:, 1:], jacobian[1:, 1:], rtol=1e-4, atol=1e5)
    nothing = WORKED.harmonics(np.zeros(4), [1, 2])
    np.testing.assert_array_equal(nothing.force, 0.0)
    np.testing.assert_allclose(nothing.jacobian, WORKED.tangential_stiffness * np.eye(4))
    # From zero a mean force stays, from the mean none does.
    held = WORKED.harmonics([5e-7, 3e-7, 0.0], [0, 1])
    assert held.force[0] == pytest.approx(177.0, abs=1.0)
    level = WORKED.harmonics([5e-7, 3e-7, 0.0], [0, 1], "mean")
    assert level.force[0] == pytest.approx(0.0, abs=1e-9)


@all_laws
@pytest.mark.parametrize("orders", [[0, 1, 30], [3, 25]])
def test_few_high_orders_agree_with_all_orders(law: ms.BackboneLaw, orders: list[int]) -> None:
    """The kernel integrates few orders by themselves, at a cost linear in the highest one."""
    rng = np.random.default_rng(4)
    columns = [k for n in orders for k in ((2 * n - 1, 2 * n) if n else (0,))]
    every = np.zeros(2 * orders[-1] + 1)
    every[columns] = reach_of(law) * rng.normal(size=len(columns))
    few = law.harmonics(every[columns], orders)
    full = law.harmonics(every, range(orders[-1] + 1))
    jacobian = full.jacobian[np.ix_(columns, columns)]
    assert np.abs(few.force - full.force[columns]).max() < 1e-10 * np.abs(full.force).max()
    assert np.abs(few.jacobian - jacobian).max() < 1e-8 * np.abs(jacobian).max()


def test_few_high_orders_of_a_field_agree_with_the_joint() -> None:
    """Order 300, which the kernel integrates only if few orders are given."""
    field = ms.JointField(WORKED.surface, 0.55, areas=[1e-4, 1e-4], loads=[600.0, 1400.0])
    c = 3e-7 * np.array([[0.1, 1.0, 0.2, 0.3, -0.1], [0.0, 0.4, 0.2, 0.02, 0.3]])
    found = field.harmonics(c, [0, 1, 300])
    for i, load in enumerate((600.0, 1400.0)):
        half = ms.Interface(replace(WORKED.surface, area=1e-4), 0.55, normal_load=load)
        alone = half.harmonics(c[i], [0, 1, 300])
        assert np.abs(found.force[i] - alone.force).max() < 1e-9 * load
        assert np.abs(found.jacobian[i] - alone.jacobian).max() < 1e-8 * half.tangential_stiffness
