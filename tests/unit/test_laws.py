"""The laws that the model is compared with: what each is, and what none of them takes."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import microslip as ms

COULOMB = ms.Coulomb(force_limit=100.0)
JENKINS = ms.Jenkins(stiffness=5e7, force_limit=100.0)
IWAN = ms.Iwan([3e7, 1e7, 6e7], [60.0, 50.0, 30.0])  # yields at 2, 5 and 0.5 um
SEGALMAN = ms.SegalmanIwan(force_limit=4000.0, stiffness=1.5e8, chi=-0.5, beta=0.6)


# -- Coulomb: rigid --------------------------------------------------------------------------------


def test_coulomb_backbone() -> None:
    np.testing.assert_array_equal(
        COULOMB.backbone([0.0, -0.0, 1e-300, -1e-12, 5.0]), [0.0, -0.0, 100.0, -100.0, 100.0]
    )
    np.testing.assert_array_equal(COULOMB.backbone_stiffness([0.0, 1e-12]), [math.inf, 0.0])
    assert COULOMB.tangential_stiffness == math.inf
    np.testing.assert_array_equal(COULOMB.secant_stiffness([0.0, 1e-6]), [math.inf, 1e8])


def test_coulomb_history_is_the_sign_of_the_last_motion() -> None:
    rng = np.random.default_rng(5)
    x = np.concatenate(([0.0, 0.0], rng.normal(size=500).round(1)))
    sign, wanted = 0.0, []
    for step in np.diff(x, prepend=0.0):
        sign = np.sign(step) or sign
        wanted.append(100.0 * sign)
    np.testing.assert_array_equal(COULOMB.force(x), wanted)
    assert wanted[:2] == [0.0, 0.0], "at rest until something moves"


def test_coulomb_energy_and_damping() -> None:
    a = np.array([1e-12, 1e-6, 3.0])
    np.testing.assert_array_equal(COULOMB.dissipated_energy(a), 400.0 * a)
    np.testing.assert_array_equal(COULOMB.energy_ratio(a), 1.0)
    np.testing.assert_allclose(COULOMB.loss_factor(a), 4 / math.pi, rtol=1e-15)
    np.testing.assert_allclose(COULOMB.damping_ratio(a), 2 / math.pi, rtol=1e-15)
    np.testing.assert_array_equal(COULOMB.dissipation_exponent(a), 1.0)
    assert COULOMB.dissipated_energy(0.0) == COULOMB.energy_ratio(0.0) == 0.0
    assert math.isnan(COULOMB.dissipation_exponent(0.0))


def test_coulomb_loop_is_a_box() -> None:
    loop = COULOMB.loop(2e-6, samples=401)
    assert loop.closure_error == 0
    assert set(loop.force.tolist()) == {100.0, -100.0}
    # Its sides take one sample each.
    assert loop.dissipated_energy == pytest.approx(4 * 100 * 2e-6, rel=1e-4, abs=0)
    assert loop.sliding_ratio == pytest.approx(1, abs=1e-4)


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


def test_coulomb_slider() -> None:
    sliders = COULOMB.sliders()
    assert sliders.yield_displacements.tolist() == [0.0]
    assert sliders.stiffnesses.tolist() == [math.inf]
    assert sliders.density(1e-6) == 0.0


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


def test_iwan() -> None:
    assert IWAN.cell_count == 3
    assert IWAN.force_limit == 140.0
    assert IWAN.tangential_stiffness == 1e8
    u = np.array([0.25e-6, 0.5e-6, 1e-6, 2e-6, 3e-6, 5e-6, 9.0])
    np.testing.assert_allclose(IWAN.backbone(u), [25, 50, 70, 110, 120, 140, 140], rtol=1e-15)
    np.testing.assert_array_equal(IWAN.backbone_stiffness(u), [1e8, 4e7, 4e7, 1e7, 1e7, 0, 0])
    np.testing.assert_allclose(
        IWAN.backbone_displacement([25.0, 70.0, 120.0, -139.0]),
        [0.25e-6, 1e-6, 3e-6, -4.9e-6],
        rtol=1e-14,
    )
    wanted = 4 * np.array([0.0, 0.0, 30 * 0.5e-6, 30 * 1.5e-6, 30 * 2.5e-6 + 60 * 1e-6])
    np.testing.assert_allclose(IWAN.dissipated_energy(u[:5]), wanted, rtol=1e-14)
    assert IWAN.sliders().yield_displacements.tolist() == [30 / 6e7, 60 / 3e7, 50 / 1e7]
    assert IWAN.sliders().stiffnesses.tolist() == [6e7, 3e7, 1e7]
    assert IWAN.stiffnesses.tolist() == [3e7, 1e7, 6e7], "as given"


def test_iwan_holds_arrays_of_its_own() -> None:
    stiffnesses, limits = np.array([1.0, 2.0]), np.array([3.0, 4.0])
    law = ms.Iwan(stiffnesses, limits)
    stiffnesses[:] = limits[:] = 7.0
    assert law.force_limit == 7.0
    assert law.stiffnesses.tolist() == [1.0, 2.0]
    other = pickle.loads(pickle.dumps(law))
    assert other.backbone(1.5) == law.backbone(1.5) == 4.5


def test_one_cell_is_jenkins() -> None:
    one = ms.Iwan([5e7], [100.0])
    x = 1e-6 * np.array([1.0, 3.0, -0.2, 0.4, -0.2, 5.0, -7.0])
    np.testing.assert_allclose(one.force(x), JENKINS.force(x), rtol=1e-14)
    a = np.abs(x)
    np.testing.assert_array_equal(one.dissipated_energy(a), JENKINS.dissipated_energy(a))


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


def test_segalman_without_a_last_slider() -> None:
    law = ms.SegalmanIwan(90.0, 1e8, chi=0.0, beta=0.0)
    assert law.sliders().yield_displacements.size == 0
    assert law.slip_displacement == pytest.approx(1.8e-6, rel=1e-15, abs=0)
    # Even sliders: Iwan's parabola.
    u = 1.8e-6 * np.array([0.1, 0.5, 1.0])
    np.testing.assert_allclose(law.backbone(u), 90 * (1 - (1 - u / 1.8e-6) ** 2), rtol=1e-14)
    assert law.backbone_stiffness(1.8e-6) == 0.0


# -- as cells, and as four parameters --------------------------------------------------------------


def test_few_sliders_come_back_as_they_are() -> None:
    back = IWAN.to_iwan(10)
    assert back.cell_count == 3
    u = 1e-6 * np.array([0.3, 1.0, 3.0, 8.0])
    np.testing.assert_allclose(back.backbone(u), IWAN.backbone(u), rtol=1e-14)
    assert JENKINS.to_iwan(1).backbone(1e-6) == 50.0


def test_many_cells_gather_into_few() -> None:
    many = ms.Iwan.examples()[2]
    few = many.to_iwan(np.int64(7))
    assert few.cell_count == 7
    assert few.force_limit == pytest.approx(many.force_limit, rel=1e-14, abs=0)
    assert few.tangential_stiffness == pytest.approx(many.tangential_stiffness, rel=1e-14, abs=0)
    u = np.linspace(0, 1e-6, 1001)
    assert np.abs(few.backbone(u) - many.backbone(u)).max() < 0.01 * many.force_limit


def test_result_of_a_fit() -> None:
    fit = SEGALMAN.to_segalman(1e-7, 1e-4)
    assert isinstance(fit, ms.SegalmanFit)
    assert isinstance(fit.law, ms.SegalmanIwan)
    assert (fit.law.force_limit, fit.law.stiffness) == (4000.0, 1.5e8)
    assert fit.smallest_amplitude == pytest.approx(1e-7, rel=1e-15, abs=0)
    assert fit.largest_amplitude == pytest.approx(1e-4, rel=1e-15, abs=0)
    assert all(type(value) is float for value in fit[1:])
