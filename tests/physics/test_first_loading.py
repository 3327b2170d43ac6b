"""One straight step from rest, the first of a state: in fifty digits, differences and limits."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from cases import ends_below, every_joint, reach_of

import microslip as ms

WORKED = ms.Interface.examples()[0]


def first_step(surface, mu, x, separation, start):
    """Response of nodes, each on the whole area of the surface, to one step from rest."""
    nodes = np.broadcast_arrays(x, separation, start)
    field = ms.JointField(surface, mu, areas=1.0, surface_area=1.0, separations=nodes[2].ravel())
    return field.start().try_(nodes[0].ravel(), nodes[1].ravel())


def test_tangents_against_high_precision() -> None:
    """One sphere in fifty digits: N = (-d)^(3/2) in units of its own."""
    sphere = ms.SphereOnFlat(WORKED.surface.pair, radius=1e-3)
    scale, mu = float(sphere.load(-1e-4)) * 1e6, 0.3
    kappa = mu * sphere.pair.stiffness_ratio
    depth = 1e-6
    rng = np.random.default_rng(4)
    for _ in range(60):
        d0, d = -depth * rng.uniform([0.01, -0.3], 2.0)
        x = kappa * depth * rng.uniform(-1.5, 1.5) * rng.choice([1e-4, 0.3, 1.0])
        got = ms.Interface(sphere, mu, separation=d0).start().try_(x, separation=d)

        def load(s):
            return scale * max(-s, mp.mpf(0)) ** mp.mpf(1.5)

        def force(x_, d_, d0=d0):
            place, fall = abs(x_) / mp.mpf(kappa), mp.mpf(d0) - d_
            if place <= fall:
                return mu * (load(d_) - load(mp.mpf(d0))) * x_ / (kappa * fall)
            return mp.sign(x_) * mu * (load(d_) - load(d_ + place))

        with mp.workdps(50):
            exact = float(force(mp.mpf(x), mp.mpf(d)))
            assert got.force == pytest.approx(exact, rel=1e-12, abs=1e-13 * mu * scale * depth**1.5)
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
        response = first_step(joint.surface, joint._friction, x, d, start)
        return np.stack((response.force, response.load), axis=-1)

    got = first_step(joint.surface, joint._friction, x, d, start).tangent
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


def test_from_no_contact() -> None:
    x = np.array([1e-8, -2e-7, 1e-6, 0.0])
    # Pressed from far away along a flat path nothing slips: all contact is proportional.
    start = WORKED.separation + 1e-3
    found = first_step(WORKED.surface, 0.55, x, WORKED.separation, start)
    kappa = 0.55 * WORKED.surface.pair.stiffness_ratio
    wanted = 0.55 * found.load * x / (kappa * 1e-3)
    np.testing.assert_allclose(found.force, wanted, rtol=1e-12)
    lifted = first_step(WORKED.surface, 0.55, x, 1.0, 0.0)
    np.testing.assert_array_equal(lifted.force, 0.0)
    np.testing.assert_array_equal(lifted.tangent, 0.0)
