"""Joints in JAX: jit, grad, jacobians and vmap against differences; `make hosts` installs it."""

from __future__ import annotations

import numpy as np
import pytest
from differentiable import CASES, POINT, C, differences, direct, make

import microslip as ms

jax = pytest.importorskip("jax", reason="JAX is not installed; make hosts runs this")


@pytest.fixture(scope="module")
def joint():
    jax.config.update("jax_enable_x64", True)
    from microslip.export.hosts.jax import DifferentiableJoint

    return DifferentiableJoint(make)


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
    way = differences(name, x, options, weights, by_point, np.asarray(by_x))
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
        with pytest.raises(ms.InputError, match="JAX must use 64-bit numbers"):
            joint.dissipated_energy(POINT, 1e-7)
    finally:
        jax.config.update("jax_enable_x64", True)
