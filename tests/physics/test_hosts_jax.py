"""Joints in JAX: jit, grad, jacobians and vmap against differences; `make hosts` installs it."""

import numpy as np
import pytest
from differentiable import CASES, POINT, C, check_field, differences, direct, field_motion, make

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


def test_second_derivatives_are_refused(joint):
    with pytest.raises(ms.InputError, match="first derivatives only"):
        jax.hessian(lambda a: joint.dissipated_energy(POINT, a))(3e-7)


def test_a_batch_is_one_call(joint, monkeypatch):
    """One callback for all rows, and no derivatives by parameters where none move."""
    from microslip.export.hosts import jax as host

    calls = []
    callback = host.jax.pure_callback

    def counted(function, *arguments, **options):
        def count(*given):
            calls.append(given)
            return function(*given)

        return callback(count, *arguments, **options)

    monkeypatch.setattr(host.jax, "pure_callback", counted)
    rows = jax.jit(jax.vmap(lambda c: joint.harmonics(POINT, c, (0, 1, 3))))(
        np.stack([C, 2.0 * C, -C])
    )
    assert len(calls) == 1
    np.testing.assert_allclose(rows[1], make(**POINT).harmonics(2.0 * C, (0, 1, 3)).force)
    monkeypatch.setattr(ms.Interface, "parameter_derivatives", None)
    by = jax.jacobian(lambda c: joint.harmonics(POINT, c, (0, 1, 3)))(C)
    np.testing.assert_allclose(by, make(**POINT).harmonics(C, (0, 1, 3)).jacobian, rtol=1e-12)


@pytest.mark.parametrize("varies", [False, True])
def test_fields_have_their_jacobians(joint, varies):
    from microslip.export.hosts.jax import DifferentiableField

    nodes, motion = field_motion(varies)
    field = DifferentiableField(nodes)

    def both(*motion):
        found = field.harmonics(*motion, harmonics=(0, 1, 3))
        return jax.numpy.stack(found if varies else [found])

    by = jax.jacobian(both, argnums=tuple(range(len(motion))))(*motion)
    check_field(nodes, motion, jax.jit(both)(*motion), by)
    x = motion[0]
    rows = jax.vmap(lambda c: field.harmonics(c, harmonics=(0, 1, 3)))(np.stack([x, 2.0 * x]))
    np.testing.assert_allclose(rows[1], nodes.harmonics(2.0 * x, (0, 1, 3)).force, rtol=1e-12)
