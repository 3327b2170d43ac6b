"""Joints in JAX: jit, grad, jacobians and vmap against differences; `make hosts` installs it."""

from __future__ import annotations

import numpy as np
import pytest

import microslip as ms

jax = pytest.importorskip("jax", reason="JAX is not installed; make hosts runs this")

_AL = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material(69e9, 0.33))
POINT = {"friction_coefficient": 0.55, "normal_load": 2000.0, "std": 5e-7}
X = 4e-7 * np.sin(0.4 * np.arange(40)) * (1.0 + 0.3 * np.sin(0.07 * np.arange(40)))
C = np.array([1e-7, 3e-7, -5e-8, 1e-7, 4e-8])


def make(friction_coefficient, normal_load, std):
    surface = ms.GreenwoodWilliamson(_AL, ms.Gaussian(std), radius=1e-3, density=1e8, area=2e-4)
    return ms.Interface(surface, friction_coefficient, normal_load=normal_load)


@pytest.fixture(scope="module")
def joint():
    jax.config.update("jax_enable_x64", True)
    from microslip.hosts.jax import DifferentiableJoint

    return DifferentiableJoint(make)


CASES = [("force", X, ()), ("harmonics", C, ((0, 1, 3),)), ("dissipated_energy", 3e-7, ())]


def direct(name, point, x, options):
    law = make(**point)
    result = getattr(law, name)(x, *options)
    return np.asarray(result.force if name == "harmonics" else result)


@pytest.mark.parametrize(("name", "x", "options"), CASES)
def test_values_and_gradients_are_those_of_differences(joint, name, x, options):
    def function(point, at):
        return getattr(joint, name)(point, at, *options)

    value = jax.jit(function)(POINT, x)
    np.testing.assert_allclose(value, direct(name, POINT, x, options), rtol=1e-13)
    weights = np.cos(np.arange(np.size(x))).reshape(np.shape(x))

    def total(point, at):
        return (weights * function(point, at)).sum()

    by_point, by_x = jax.jit(jax.grad(total, argnums=(0, 1)))(POINT, x)
    for key, number in POINT.items():
        step = 1e-4 * number
        ends = [direct(name, {**POINT, key: number + s * step}, x, options) for s in (1, -1)]
        wanted = (weights * (ends[0] - ends[1])).sum() / (2.0 * step)
        scale = np.abs(weights * ends[0]).sum() / number
        assert abs(by_point[key] - wanted) < 1e-6 * scale, key
    way = np.sin(1.0 + np.arange(np.size(x))).reshape(np.shape(x))
    ends = [direct(name, POINT, x + s * 1e-13 * way, options) for s in (1, -1)]
    wanted = (weights * (ends[0] - ends[1])).sum() / 2e-13
    scale = np.abs(np.asarray(by_x) * way).sum()
    assert abs((np.asarray(by_x) * way).sum() - wanted) < 2e-5 * scale
    # Forward mode is the same derivative.
    _, along = jax.jvp(lambda at: total(POINT, at), (x,), (way,))
    assert float(along) == pytest.approx(float((np.asarray(by_x) * way).sum()), rel=1e-10)


def test_batches_are_their_rows(joint):
    loads = np.array([1000.0, 2000.0, 3000.0])

    def energy(load, amplitude):
        return joint.dissipated_energy({**POINT, "normal_load": load}, amplitude)

    found = jax.vmap(jax.grad(energy), in_axes=(0, None))(loads, 3e-7)
    for load, slope in zip(loads, found, strict=True):
        law = make(**{**POINT, "normal_load": float(load)})
        wanted = law.parameter_derivatives("dissipated_energy", 3e-7)["normal_load"]
        assert float(slope) == pytest.approx(wanted, rel=1e-12)
    rows = jax.vmap(lambda c: joint.harmonics(POINT, c, (0, 1, 3)))(np.stack([C, 2.0 * C]))
    np.testing.assert_allclose(rows[1], make(**POINT).harmonics(2.0 * C, (0, 1, 3)).force)


def test_numbers_of_32_bits_are_refused(joint):
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(ms.InputError, match="JAX must compute with 64 bits"):
            joint.dissipated_energy(POINT, 1e-7)
    finally:
        jax.config.update("jax_enable_x64", True)
