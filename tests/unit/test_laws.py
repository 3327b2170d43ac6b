"""The laws that the model is compared with: what each is, and what none of them takes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import microslip as ms

COULOMB = ms.Coulomb(force_limit=100.0)
JENKINS = ms.Jenkins(stiffness=5e7, force_limit=100.0)
SEGALMAN = ms.SegalmanIwan(force_limit=4000.0, stiffness=1.5e8, chi=-0.5, beta=0.6)


# -- Coulomb: rigid --------------------------------------------------------------------------------


def test_coulomb_backbone() -> None:
    np.testing.assert_array_equal(
        COULOMB.backbone([0.0, -0.0, 1e-300, -1e-12, 5.0]), [0.0, -0.0, 100.0, -100.0, 100.0]
    )
    np.testing.assert_array_equal(COULOMB.backbone_stiffness([0.0, 1e-12]), [math.inf, 0.0])
    assert COULOMB.tangential_stiffness == math.inf
    np.testing.assert_array_equal(COULOMB.secant_stiffness([0.0, 1e-6]), [math.inf, 1e8])


def test_coulomb_in_a_solver() -> None:
    state = COULOMB.start()
    assert state.try_(0.0) == (0.0, math.inf)
    assert state.try_(1e-9) == (100.0, 0.0)
    state.commit()
    assert state.try_(1e-9) == (100.0, 0.0)
    assert state.try_(0.5e-9) == (-100.0, 0.0)
    state.commit()
    assert (state.force, state.displacement, state.open_reversals) == (-100.0, 0.5e-9, 1)
    assert state.advance([0.6e-9, 0.6e-9, 2e-9]).tolist() == [100.0] * 3
    response = COULOMB.periodic([0.0, 1e-6, 0.0, -1e-6])
    assert response.force.tolist() == [100.0, 100.0, -100.0, -100.0]
    assert response.stiffness.tolist() == [0.0] * 4


# -- Jenkins and Iwan: polygons --------------------------------------------------------------------


def test_jenkins() -> None:
    assert JENKINS.yield_displacement == 2e-6
    np.testing.assert_allclose(
        JENKINS.force([1e-6, 3e-6, 0.0, -3e-6, 2.5e-6]), [50, 100, -50, -100, 100], rtol=1e-14
    )
    np.testing.assert_allclose(JENKINS.displacement([50.0, -50.0]), [1e-6, -1e-6], rtol=1e-15)
    a = np.array([1e-6, 2e-6, 5e-6])
    np.testing.assert_allclose(JENKINS.dissipated_energy(a), [0, 0, 1.2e-3], rtol=1e-14)
    # The textbook's loss factor, (4/pi) (1 - y/a).
    assert JENKINS.loss_factor(5e-6) == pytest.approx(4 / math.pi * 0.6, rel=1e-15, abs=0)
    assert JENKINS.start().try_(3e-6) == (100.0, 0.0)
    assert JENKINS.start().try_(1e-6) == (50.0, 5e7)
    assert math.isnan(JENKINS.dissipation_exponent(1e-6))
    assert JENKINS.backbone(1e300) == 100.0


# -- Segalman --------------------------------------------------------------------------------------


def test_segalman() -> None:
    """His formulas: phi = F_S (1 + beta)/(K_T (beta + (chi + 1)/(chi + 2)))."""
    phi = 4000.0 * 1.6 / (1.5e8 * (0.6 + 0.5 / 1.5))
    assert SEGALMAN.slip_displacement == pytest.approx(phi, rel=1e-15, abs=0)
    assert SEGALMAN.tangential_stiffness == 1.5e8
    assert SEGALMAN.backbone(phi) == SEGALMAN.backbone(1e9) == 4000.0
    sliders = SEGALMAN.sliders()
    assert sliders.yield_displacements.tolist() == [SEGALMAN.slip_displacement]
    assert sliders.stiffnesses[0] == pytest.approx(1.5e8 * 0.6 / 1.6, rel=1e-15, abs=0)
    # R phi^(chi + 1)/(chi + 1) is the stiffness of all others.
    density = sliders.density([phi / 4, phi / 2, 1.01 * phi])
    spread = 1.5e8 / 1.6 * 0.5 / phi
    np.testing.assert_allclose(density, [2 * spread, math.sqrt(2) * spread, 0], rtol=1e-14)
    assert sliders.density(0.0) == math.inf
    assert SEGALMAN.dissipation_exponent([0.0, 1e-12, 0.9 * phi]).tolist() == pytest.approx(
        [2.5, 2.5, 2.5], rel=1e-14, abs=0
    )
    assert SEGALMAN.dissipation_exponent(1e3 * phi) == pytest.approx(1, abs=1e-3)
