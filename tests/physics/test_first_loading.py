"""One straight step from rest: against the engine of memory diagrams, differences and limits."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from cases import ends_below, joint_params, reach_of

import microslip as ms

JOINTS = joint_params()
every_joint = pytest.mark.parametrize("joint", JOINTS)
WORKED = ms.Interface.examples()[0]


def ends(joint: ms.Interface) -> tuple[np.ndarray, np.ndarray]:
    """Separations and displacements around the joint's rest, ties of stick and slip among them."""
    depth = joint.normal_load / joint.normal_stiffness
    share = np.array([0.0, 0.25, -0.25, 0.5, -0.03, 1e-7, -1e-7, 3.0])
    if ends_below(joint):
        share = np.abs(share)
    kappa = joint.slip_per_indentation
    x = np.concatenate((
        reach_of(joint) * np.array([0.0, 0.5, -0.5, 1e-6, -0.01, 4.0]),
        kappa * depth * np.array([0.25, -0.0625, 0.5, 0.2499]),
    ))  # fmt: skip
    return joint.separation + depth * share, x


@every_joint
def test_it_is_the_first_step_of_a_record(joint) -> None:
    d, x = (v.ravel() for v in np.meshgrid(*ends(joint)))
    response = joint.first_loading(x, separation=d)
    wanted = [float(joint.coupled_force([b], separation=[a])[0]) for a, b in zip(d, x, strict=True)]
    heavy = joint.friction_coefficient * max(response.load.max(), joint.normal_load)
    np.testing.assert_allclose(response.force, wanted, rtol=1e-12, atol=1e-13 * heavy)
    np.testing.assert_allclose(response.load, joint.surface.load(d), rtol=1e-13)
    own = joint.first_loading(x, separation=joint.separation)
    np.testing.assert_allclose(own.force, joint.backbone(x), rtol=1e-12)
    at_rest = joint.first_loading(0.0, separation=joint.separation)
    assert isinstance(at_rest.force, float)
    assert at_rest.tangent.shape == (2, 2)
    assert at_rest.tangent[0, 0] == pytest.approx(joint.tangential_stiffness, rel=1e-12)
    assert at_rest.tangent[1, 1] == pytest.approx(-joint.normal_stiffness, rel=1e-12)


def test_tangents_against_high_precision() -> None:
    """One sphere in fifty digits: N = (-d)^(3/2) in units of its own."""
    sphere = ms.SphereOnFlat(WORKED.surface.pair, radius=1e-3)
    scale, mu = float(sphere.load(-1e-4)) * 1e6, 0.3
    kappa = mu * sphere.pair.stiffness_ratio
    depth = 1e-6
    rng = np.random.default_rng(4)
    for _ in range(60):
        d0, d = -depth * rng.uniform(-0.3, 2.0, 2)
        x = kappa * depth * rng.uniform(-1.5, 1.5) * rng.choice([1e-4, 0.3, 1.0])
        got = ms.first_loading(sphere, mu, x, separation=d, start=d0)

        def load(s):
            return scale * max(-s, mp.mpf(0)) ** mp.mpf(1.5)

        def force(x_, d_, d0=d0):
            place, fall = abs(x_) / mp.mpf(kappa), mp.mpf(d0) - d_
            if place <= fall:
                return mu * (load(d_) - load(mp.mpf(d0))) * x_ / (kappa * fall)
            return mp.sign(x_) * mu * (load(d_) - load(d_ + place))

        with mp.workdps(50):
            assert got.force == pytest.approx(float(force(mp.mpf(x), mp.mpf(d))), rel=1e-12, abs=0)
            by_x = mp.diff(lambda v, d=d: force(v, mp.mpf(d)), mp.mpf(x), h=mp.mpf(1e-25))
            by_d = mp.diff(lambda v, x=x: force(mp.mpf(x), v), mp.mpf(d), h=mp.mpf(1e-25))
        stiff = mu / kappa * 1.5 * scale * np.sqrt(2.0 * depth)
        atol = 1e-13 * stiff
        np.testing.assert_allclose(
            got.tangent[0], [float(by_x), float(by_d)], rtol=1e-11, atol=atol
        )


@every_joint
def test_tangents_against_differences(joint) -> None:
    depth, reach = joint.normal_load / joint.normal_stiffness, reach_of(joint)
    rng = np.random.default_rng(5)
    d = joint.separation + depth * rng.uniform(0.0 if ends_below(joint) else -0.4, 0.4, 40)
    x = reach * rng.uniform(-1.2, 1.2, 40)
    start = joint.separation

    def at(x, d):
        response = ms.first_loading(joint.surface, joint._friction, x, separation=d, start=start)
        return np.stack((response.force, response.load), axis=-1)

    got = ms.first_loading(joint.surface, joint._friction, x, separation=d, start=start).tangent
    h = 1e-6
    by_x = (at(x + h * reach, d) - at(x - h * reach, d)) / (2.0 * h * reach)
    up, down = d + h * depth, d - h * depth  # a separation may be coarse beside the depth
    by_d = (at(x, up) - at(x, down)) / (up - down)[:, None]
    scale = np.array([joint.tangential_stiffness, joint.normal_stiffness])
    for wanted, part in ((by_x, got[:, :, 0]), (by_d, got[:, :, 1])):
        error = np.abs(wanted - part) / scale
        # A last summit or a knot within the difference is seen to first order.
        assert np.median(error) < 1e-7
        assert np.quantile(error, 0.9) < 1e-4


def test_from_no_contact_and_shapes() -> None:
    d0 = WORKED.separation + np.array([[1e-3], [2e-7], [-1e-7]])
    x = np.array([1e-8, -2e-7, 1e-6, 0.0])
    force, load, tangent = ms.first_loading(
        WORKED.surface, 0.55, x, separation=WORKED.separation, start=d0
    )
    assert force.shape == load.shape == (3, 4)
    assert tangent.shape == (3, 4, 2, 2)
    # Pressed from far away along a flat path nothing slips: all contact is proportional.
    kappa = 0.55 * WORKED.surface.pair.stiffness_ratio
    wanted = 0.55 * load[0] * x / (kappa * 1e-3)
    np.testing.assert_allclose(force[0], wanted, rtol=1e-12)
    lifted = ms.first_loading(WORKED.surface, 0.55, x, separation=1.0, start=0.0)
    np.testing.assert_array_equal(lifted.force, 0.0)
    np.testing.assert_array_equal(lifted.tangent, 0.0)
    by_load = WORKED.first_loading(x, normal_load=3000.0)
    np.testing.assert_allclose(by_load.load, 3000.0, rtol=1e-12)
