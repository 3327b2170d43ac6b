"""Settled cycles of all nodes of a field: single joints, differences, brute force, both kernels."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from usual import SURFACE, slope

import microslip as ms
from microslip.contact import NORMAL_LAWS
from microslip.friction.harmonics import harmonic_force

NODES, SAMPLES, ORDERS = 12, 48, (0, 1, 3)
RNG = np.random.default_rng(7)
SHAPE = np.array([0.5, 1.0, 0.7, 0.4, 0.3])
AREAS = RNG.uniform(1e-6, 1e-5, NODES)
FRICTION = RNG.uniform(0.1, 0.8, NODES)
FIELD = ms.JointField(SURFACE, FRICTION, areas=AREAS, pressures=RNG.uniform(1e5, 2e7, NODES))
COEFFICIENTS = 4e-7 * SHAPE * RNG.normal(size=(NODES, 5))
SEPARATIONS = 4e-7 * SHAPE * RNG.normal(size=(NODES, 5)) * RNG.uniform(0.0, 2.0, (NODES, 1))
SEPARATIONS[:, 0] += FIELD.separations
# Pressed down so far from rest that the root lies within new contact that stuck.
PRESSED = SEPARATIONS - np.eye(5)[0] * 4e-6


def sampled(coefficients: np.ndarray, samples: int = SAMPLES) -> np.ndarray:
    """Cycles of Fourier coefficients."""
    t = 2.0 * np.pi * np.arange(samples) / samples
    columns = [np.ones(samples)]
    for n in ORDERS[1:]:
        columns += [np.cos(n * t), np.sin(n * t)]
    return np.asarray(coefficients @ np.array(columns))


X, D = sampled(COEFFICIENTS), sampled(SEPARATIONS)


def joint(field: ms.JointField, node: int) -> ms.Interface:
    own = dataclasses.replace(SURFACE, area=field.areas[node])
    return ms.Interface(own, field.friction[node], normal_load=field.normal_loads[node])


def test_nodes_are_joints_at_a_held_load() -> None:
    found = FIELD.periodic(X)
    for i in range(NODES):
        wanted = joint(FIELD, i).periodic(X[i])
        scale = FIELD.force_limits[i]
        np.testing.assert_allclose(found.force[i], wanted.force, rtol=0, atol=1e-13 * scale)
        scale = FIELD.tangential_stiffnesses[i]
        np.testing.assert_allclose(found.stiffness[i], wanted.stiffness, rtol=0, atol=1e-12 * scale)
        np.testing.assert_allclose(found.load[i], FIELD.normal_loads[i], rtol=1e-13)


def test_small_cycles_keep_their_digits() -> None:
    """A held load costs no digits, however small the cycle against the separations."""
    small = 1e-6 * X
    found = FIELD.periodic(small)
    for i in range(NODES):
        wanted = joint(FIELD, i).periodic(small[i]).force
        np.testing.assert_allclose(
            found.force[i], wanted, rtol=0, atol=1e-13 * np.abs(wanted).max()
        )


@pytest.mark.parametrize("kind", ["around rest", "pressed"])
def test_nodes_are_joints_under_a_load_that_varies(kind: str) -> None:
    separations = sampled(SEPARATIONS if kind == "around rest" else PRESSED)
    found = FIELD.periodic(X, separations)
    for i in range(NODES):
        own = joint(FIELD, i)
        root = int(np.argmax(separations[i] + np.abs(X[i]) / own.slip_per_indentation))
        x, d = (np.tile(np.roll(cycle[i], -root), 4) for cycle in (X, separations))
        wanted = own.coupled_force(x, separation=d).reshape(4, -1)
        scale = own.friction_coefficient * found.load[i].max()
        np.testing.assert_allclose(
            np.roll(found.force[i], -root), wanted[-1], rtol=0, atol=1e-13 * scale
        )
        if kind == "around rest":  # all memory is gone where a cycle begins
            np.testing.assert_allclose(wanted[0], wanted[-1], rtol=0, atol=1e-13 * scale)


def test_it_does_not_matter_with_which_sample_a_cycle_begins() -> None:
    for d in (None, D, sampled(PRESSED)):
        wanted = FIELD.periodic(X, d)
        rolled = FIELD.periodic(
            np.roll(X, 17, axis=1), None if d is None else np.roll(d, 17, axis=1)
        )
        for name in ("force", "load", "stiffness"):
            one, other = np.roll(getattr(wanted, name), 17, axis=1), getattr(rolled, name)
            np.testing.assert_array_equal(one, other)


def test_nodes_settle_from_anywhere() -> None:
    """From rest to any sample first, the second cycle is the one that settles."""
    found = FIELD.periodic(X, D)
    for i in range(NODES):
        own = joint(FIELD, i)
        reach = (D[i] + np.abs(X[i]) / own.slip_per_indentation).max()
        if reach < own.separation:
            continue
        for start in (0, 11, 30):
            x, d = (np.tile(np.roll(cycle[i], -start), 2) for cycle in (X, D))
            second = own.coupled_force(x, separation=d)[SAMPLES:]
            scale = own.friction_coefficient * found.load[i].max()
            np.testing.assert_allclose(
                np.roll(second, start), found.force[i], rtol=0, atol=1e-13 * scale
            )


def differences(field: ms.JointField, x: Any, d: Any, step: float) -> np.ndarray:
    """The Jacobian by central differences."""
    _, _, jacobian = field.harmonics(x, ORDERS, separations=d, samples=SAMPLES)
    found = np.zeros_like(jacobian)
    for k, e in enumerate(np.eye(5)):
        for column, (dx, dd) in enumerate(((e, 0.0 * e), (0.0 * e, e))):

            def at(s: float, dx: Any = dx, dd: Any = dd) -> np.ndarray:
                moved = {"separations": d + s * dd, "samples": SAMPLES}
                return np.stack(field.harmonics(x + s * dx, ORDERS, **moved)[:2], axis=1)

            found[:, :, column, :, k] = slope(at, step)
    return found


@pytest.mark.parametrize("separations", [SEPARATIONS, PRESSED], ids=["around rest", "pressed"])
def test_jacobian_is_its_differences(separations: np.ndarray) -> None:
    _, _, jacobian = FIELD.harmonics(COEFFICIENTS, ORDERS, separations=separations, samples=SAMPLES)
    found = differences(FIELD, COEFFICIENTS, separations, 1e-13)
    scale = np.abs(jacobian).max(axis=(1, 2, 3, 4), keepdims=True)
    # Rounding of the differences, 2e-16 of the force over a step of 1e-13 m: 1e-8 of N/length.
    np.testing.assert_allclose(found / scale, jacobian / scale, rtol=0, atol=2e-8)


def test_jacobian_without_separations() -> None:
    force, jacobian = FIELD.harmonics(COEFFICIENTS, ORDERS, samples=SAMPLES)
    still = np.eye(5)[0] * FIELD.separations[:, None]
    other, load, whole = FIELD.harmonics(COEFFICIENTS, ORDERS, separations=still, samples=SAMPLES)
    scale = FIELD.force_limits[:, None]
    np.testing.assert_allclose(force / scale, other / scale, rtol=0, atol=1e-14)
    np.testing.assert_allclose(load[:, 0], FIELD.normal_loads, rtol=1e-13)
    stiff = FIELD.tangential_stiffnesses[:, None, None]
    np.testing.assert_allclose(jacobian / stiff, whole[:, 0, 0] / stiff, rtol=0, atol=1e-12)


@pytest.mark.parametrize("surface", [s for law in NORMAL_LAWS[1:] for s in law.examples()], ids=str)
def test_laws_without_a_profile(surface: ms.NormalLaw) -> None:
    """Given summits and tables ask the law itself."""
    load = 0.2 * surface.load(surface._span[0])
    own = ms.Interface(surface, 0.4, normal_load=load)
    length = own.normal_load / own.normal_stiffness
    field = ms.JointField(surface, 0.4, areas=[1e-4, 1e-4], loads=load, surface_area=1e-4)
    x = own.slip_per_indentation * length * np.array([[1.0, 0.3], [0.5, 0.9]]) @ SHAPE_CYCLE
    d = (
        field.separations[:, None]
        + 0.3 * length * np.array([[0.4, -0.5], [0.9, 0.1]]) @ SHAPE_CYCLE
    )
    held, varying = field.periodic(x), field.periodic(x, d)
    for i in range(2):
        wanted = own.periodic(x[i]).force
        np.testing.assert_allclose(held.force[i], wanted, rtol=0, atol=2e-13 * own.force_limit)
        root = int(np.argmax(d[i] + np.abs(x[i]) / own.slip_per_indentation))
        moved = np.roll(x[i], -root), np.roll(d[i], -root)
        force = own.coupled_force(moved[0], separation=moved[1])
        scale = 0.4 * varying.load[i].max()
        np.testing.assert_allclose(
            np.roll(varying.force[i], -root), force, rtol=0, atol=1e-12 * scale
        )
    directions = RNG.normal(size=(2, SHAPE_CYCLE.shape[1], 3)) * length
    slopes, falls = varying.derivative(directions, directions[:, :, ::-1])

    def at(s: float) -> np.ndarray:
        moved = field.periodic(x + s * directions[:, :, 0], d + s * directions[:, :, 2])
        return np.stack((moved.force, moved.load))

    for found, wanted in zip((slopes, falls), slope(at, 1e-6), strict=True):
        # Roots of given summits and corners of tables: differences err where a front meets one.
        miss = np.abs(wanted - found[:, :, 0]) / np.abs(found).max()
        assert np.median(miss) < 1e-8
        assert miss.max() < 2e-2


TURNS = 2.0 * np.pi * np.arange(24) / 24
SHAPE_CYCLE = np.stack((np.cos(TURNS + 0.3), np.sin(2.0 * TURNS)))


def test_derivatives_of_a_cycle_are_its_differences() -> None:
    u, v = RNG.normal(size=(2, NODES, SAMPLES, 2))
    slopes, falls = FIELD.periodic(X, D).derivative(u, v)
    for k in range(2):

        def at(s: float, k: int = k) -> np.ndarray:
            moved = FIELD.periodic(X + s * u[:, :, k], D + s * v[:, :, k])
            return np.stack((moved.force, moved.load))

        for found, wanted in zip((slopes, falls), slope(at, 1e-13), strict=True):
            off = np.abs(found[:, :, k] - wanted)
            assert (off < 5e-8 * np.abs(found[:, :, k]).max(axis=1, keepdims=True)).all()
    held = FIELD.periodic(X)
    same, nothing = held.derivative(u)
    tree = joint(FIELD, 3).periodic(X[3])
    wanted = np.zeros(SAMPLES)
    for i in range(SAMPLES):
        t = (tree.root + i) % SAMPLES
        above = tree.parent[t] if i else None
        change = u[3, t, 0] - (0.0 if above is None else u[3, above, 0])
        wanted[t] = (0.0 if above is None else wanted[above]) + tree.stiffness[t] * change
    scale = np.abs(wanted).max()
    np.testing.assert_allclose(same[3, :, 0], wanted, rtol=0, atol=1e-12 * scale)
    assert not nothing.any()


def test_where_a_cycle_rests() -> None:
    lifted = X + 1e-7
    mean = lifted.mean(axis=1)
    wanted = FIELD.periodic(lifted - mean[:, None]).force
    for rest in ("mean", mean):
        found = FIELD.periodic(lifted, rest=rest).force
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())
    force, jacobian = FIELD.harmonics(COEFFICIENTS, ORDERS, rest="mean", samples=SAMPLES)
    assert not jacobian[:, :, 0].any(), "it moves along with its mean"
    moved = COEFFICIENTS + np.eye(5)[0] * 1e-6
    np.testing.assert_allclose(
        FIELD.harmonics(moved, ORDERS, rest="mean", samples=SAMPLES)[0], force,
        rtol=0, atol=1e-12 * np.abs(force).max(),
    )  # fmt: skip
    slopes, _ = FIELD.periodic(X, rest="mean").derivative(np.ones((SAMPLES, 1)))
    assert np.abs(slopes).max() < 1e-12 * FIELD.tangential_stiffnesses.max()


def test_a_cycle_dissipates_the_energy_of_the_joint() -> None:
    """The sine coefficient of the force holds the loss: E = pi a F, and the error is of order 2."""
    a = 3e-7
    wanted = np.array([joint(FIELD, i).dissipated_energy(a) for i in range(NODES)])
    errors = []
    for samples in (64, 128, 256, 512):
        force, _ = FIELD.harmonics([0.0, a, 0.0], (0, 1), samples=samples)
        errors.append(np.abs(np.pi * a * -force[:, 2] / wanted - 1.0).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.8).all(), errors
    assert errors[-1] < 1e-4


class Untabulated:
    """A joint without its table: what integrates it is Python's rule of Gauss, cut at kinks."""

    _table = None

    def __init__(self, law: ms.Interface) -> None:
        self._law = law

    def __getattr__(self, name: str) -> Any:
        return getattr(self._law, name)


@pytest.mark.parametrize("rest", [0.0, 2e-7, "mean"])
@pytest.mark.parametrize("orders", [(0, 1, 3), (1, 2, 5, 7), (0, 1)])
def test_without_samples_the_kernel_is_the_integral_of_another_rule(
    orders: tuple[int, ...], rest: Any
) -> None:
    size = 2 * len(orders) - (orders[0] == 0)
    c = 4e-7 * np.random.default_rng(11).normal(size=(NODES, size))
    force, jacobian = FIELD.harmonics(c, orders, rest=rest)
    for i in range(NODES):
        own = joint(FIELD, i)
        wanted = harmonic_force(Untabulated(own), c[i], orders, rest, 1e-12)
        for found in ((force[i], jacobian[i]), own.harmonics(c[i], orders, rest)):
            off = np.abs(found[0] - wanted.force).max() / own.force_limit
            assert off < 1e-12, (i, off)
            off = np.abs(found[1] - wanted.jacobian).max() / own.tangential_stiffness
            assert off < 1e-10, (i, off)


def test_without_samples_the_jacobian_is_that_of_differences() -> None:
    _, jacobian = FIELD.harmonics(COEFFICIENTS, ORDERS)
    for k, way in enumerate(np.eye(5)):
        slopes = slope(lambda s, e=way: FIELD.harmonics(COEFFICIENTS + s * e, ORDERS)[0], 1e-12)
        off = np.abs(slopes - jacobian[:, :, k]) / FIELD.tangential_stiffnesses[:, None]
        assert off.max() < 2e-5  # of second order, and digits that differences lose


def test_without_samples_a_cycle_dissipates_the_energy_of_the_joint() -> None:
    a = np.geomspace(1e-10, 1e-5, 9)
    for amplitude in a.tolist():
        force, _ = FIELD.harmonics([0.0, amplitude, 0.0], (0, 1))
        wanted = FIELD.dissipated_energy(amplitude)
        scale = FIELD.tangential_stiffnesses * amplitude**2
        off = np.abs(-np.pi * amplitude * force[:, 2] - wanted) / np.maximum(wanted, 1e-6 * scale)
        assert off.max() < 1e-8


def test_without_samples_corners_and_laws_without_a_profile_are_met() -> None:
    heights = 5e-7 * np.random.default_rng(3).normal(size=60)
    rough = ms.AsperityPopulation(SURFACE.pair, heights, radii=1e-3)
    for surface in (rough, ms.SphereOnFlat(SURFACE.pair, radius=5e-3)):
        field = ms.JointField(surface, 0.3, areas=[1e-4, 1e-4], loads=[2.0, 0.0], surface_area=1e-4)
        c = 3e-7 * SHAPE
        force, jacobian = field.harmonics(c, ORDERS, rtol=1e-9)
        law = ms.Interface(surface, 0.3, normal_load=2.0)
        wanted = harmonic_force(Untabulated(law), c, ORDERS, 0.0, 1e-10)
        np.testing.assert_allclose(force[0], wanted.force, rtol=0, atol=1e-7 * law.force_limit)
        off = np.abs(jacobian[0] - wanted.jacobian) / law.tangential_stiffness
        assert off.max() < 1e-5
        assert not force[1].any()
        assert not jacobian[1].any()


def test_from_nothing_the_stiffness_is_that_at_rest() -> None:
    for samples in (SAMPLES, None):
        force, jacobian = FIELD.harmonics(np.zeros(5), ORDERS, samples=samples)
        assert not force.any()
    stiff = FIELD.tangential_stiffnesses[:, None, None]
    np.testing.assert_allclose(jacobian / stiff, np.tile(np.eye(5), (NODES, 1, 1)), atol=1e-13)


def test_open_nodes_close_and_open() -> None:
    """A node without a load at rest carries one where it closes, and none where it is open."""
    field = ms.JointField(SURFACE, 0.3, areas=1e-5, loads=[0.0])
    d = np.where(np.arange(SAMPLES) % 24 < 12, 4e-7, field.separations[0] + 1e-6)
    x = 3e-7 * np.sin(np.arange(SAMPLES) * np.pi / 12.0)
    cycle = field.periodic(x, d)
    assert not cycle.force[:, d > 1e-6].any()
    assert not cycle.load[:, d > 1e-6].any()
    closed = cycle.force[0, d < 1e-6]
    assert np.abs(closed).max() > 0.1 * 0.3 * cycle.load.max()


@pytest.mark.parametrize("rest", [0.0, 2e-7, "mean"])
@pytest.mark.parametrize("d", [SEPARATIONS, PRESSED], ids=["varying", "pressed"])
def test_varying_separations_without_samples_are_the_limit_of_samples(
    d: np.ndarray, rest: Any
) -> None:
    """Samples have an error of second order: two numbers of them extrapolated."""
    coarse, fine = (
        FIELD.harmonics(COEFFICIENTS, ORDERS, separations=d, rest=rest, samples=samples)
        for samples in (1 << 13, 1 << 14)
    )
    force, load, jacobian = FIELD.harmonics(COEFFICIENTS, ORDERS, separations=d, rest=rest)
    scale = np.abs(fine[0]).max(axis=1, keepdims=True)
    # Their turning points shift from sample to sample, so the extrapolation is but near; pressed
    # down further between the samples, they have roots, and samples are of order 3/2.
    near = 2e-6 if d is SEPARATIONS else 2e-4
    assert (np.abs(force - (4.0 * fine[0] - coarse[0]) / 3.0) / scale).max() < near
    np.testing.assert_allclose(load, fine[1], rtol=0, atol=1e-13 * np.abs(fine[1]).max())
    for a, b in ((0, 0), (0, 1), (1, 1)):
        off = np.abs(jacobian[:, a, b] - fine[2][:, a, b]).max(axis=(1, 2))
        assert (off / np.abs(fine[2][:, a, b]).max(axis=(1, 2))).max() < 2e-3


@pytest.mark.parametrize("d", [SEPARATIONS, PRESSED], ids=["varying", "pressed"])
def test_varying_separations_without_samples_reach_their_tolerance(d: np.ndarray) -> None:
    exact = FIELD.harmonics(COEFFICIENTS, ORDERS, separations=d, rtol=1e-14)
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
        found = FIELD.harmonics(COEFFICIENTS, ORDERS, separations=d, rtol=rtol)
        scale = np.abs(exact[0]).max(axis=1, keepdims=True)
        assert (np.abs(found[0] - exact[0]) / scale).max() < rtol
        off = np.abs(found[2] - exact[2]).max(axis=(1, 2, 3, 4))
        assert (off / np.abs(exact[2]).max(axis=(1, 2, 3, 4))).max() < 100.0 * rtol


def test_separations_that_stay_need_no_rule_of_their_own() -> None:
    """The held rule, another program, to rounding; and of a node that stands still."""
    still = FIELD.separations[:, None] * np.eye(5)[:1]
    for c in (COEFFICIENTS, COEFFICIENTS * (np.arange(NODES) % 3 > 0)[:, None]):
        force, jacobian = FIELD.harmonics(c, ORDERS)
        other, load, whole = FIELD.harmonics(c, ORDERS, separations=still)
        scale = FIELD.force_limits[:, None]
        assert (np.abs(other - force) / scale).max() < 1e-12
        np.testing.assert_allclose(load[:, 0], FIELD.normal_loads, rtol=1e-13)
        off = np.abs(whole[:, 0, 0] - jacobian) / FIELD.tangential_stiffnesses[:, None, None]
        assert off.max() < 1e-10


def test_normal_motion_alone_has_no_force_and_the_stiffness_of_small_shear() -> None:
    d = SEPARATIONS.copy()
    force, load, jacobian = FIELD.harmonics(np.zeros((NODES, 5)), ORDERS, separations=d)
    assert np.abs(force).max() < 1e-13 * np.abs(load).max()
    tiny = 1e-5 * np.abs(d[:, 1:]).max(axis=1, keepdims=True) * SHAPE
    sheared = FIELD.harmonics(tiny, ORDERS, separations=d)[0]
    wanted = np.einsum("nij,nj->ni", jacobian[:, 0, 0], tiny)
    scale = np.abs(wanted).max(axis=1)
    assert (np.abs(sheared - wanted).max(axis=1) / scale).max() < 1e-3
