"""Closed loops: what a polygon of samples says, and how fast it becomes the closed form."""

import math

import numpy as np
import pytest
from cases import all_laws, invertible_laws, is_polygon, law_params, reach_of

import microslip as ms

polygons = pytest.mark.parametrize("law", law_params(which=is_polygon))
# Not polygons: where a law's corners fall between samples changes the constant of an order.
rounded_laws = pytest.mark.parametrize("law", law_params(which=lambda law: not is_polygon(law)))
AMPLITUDES = (0.05, 0.7, 3.0)


@all_laws
def test_loop_is_the_settled_force(law):
    for share in AMPLITUDES:
        a = share * reach_of(law)
        for samples in (5, 64, 65):
            loop = law.loop(a, samples=samples)
            assert loop.displacement.size == loop.force.size == samples
            assert loop.displacement[0] == loop.displacement[-1] == a
            assert loop.displacement.min() == -a
            assert loop.force[0] == loop.force[-1]
            assert loop.closure_error == 0
            turn = int(np.argmin(loop.displacement))
            assert np.all(np.diff(loop.displacement[: turn + 1]) < 0)
            assert np.all(np.diff(loop.displacement[turn:]) > 0)
            np.testing.assert_allclose(
                loop.force, law.force(loop.displacement), rtol=0, atol=1e-14 * law.force_limit
            )
            assert loop.displacement_amplitude == a
            assert loop.force_amplitude == pytest.approx(law.backbone(a), rel=1e-14, abs=0)
            assert loop.secant_stiffness == pytest.approx(law.secant_stiffness(a), rel=1e-14, abs=0)


@rounded_laws
def test_loop_measures_converge_at_second_order(law):
    """Energy, damping and sliding ratio of the polygon towards the law's closed forms."""
    sizes = (129, 257, 513, 1025)
    for share in AMPLITUDES:
        a = share * reach_of(law)
        loops = [law.loop(a, samples=size) for size in sizes]
        for name in ("dissipated_energy", "loss_factor", "damping_ratio", "energy_ratio"):
            wanted = getattr(law, name)(a)
            errors = [abs(getattr(loop, name) / wanted - 1) for loop in loops]
            order = np.log2(errors[0] / errors[-1]) / 3
            assert 1.7 < order < 2.4, (name, share, errors)
        # A polygon inside a convex loop is too small.
        assert all(loop.dissipated_energy < law.dissipated_energy(a) for loop in loops)


@polygons
def test_loops_of_polygons_converge_at_second_order(law):
    """The same for laws with corners, as a bound; and below the first yield nothing is lost."""
    for share in (*AMPLITUDES, 1.1):
        a = share * reach_of(law)
        box = 4 * a * law.backbone(a)
        for size in (129, 513, 2049):
            missing = law.dissipated_energy(a) - law.loop(a, samples=size).dissipated_energy
            assert -1e-14 * box <= missing <= 6 / size**2 * box
    a = 0.999 * law.sliders().yield_displacements.min()
    assert law.dissipated_energy(a) == law.loss_factor(a) == 0
    assert abs(law.loop(a).energy_ratio) < 1e-15


@invertible_laws
def test_sliding_ratio(law):
    """D = delta_g/delta_m with T(delta_g) = 0 on the way back: 2 T0((a - delta_g)/2) = T0(a)."""
    for share in AMPLITUDES:
        a = share * reach_of(law)
        wanted = 1 - 2 * law.backbone_displacement(0.5 * law.backbone(a)) / a
        errors = [abs(law.loop(a, samples=size).sliding_ratio - wanted) for size in (201, 3201)]
        # A chord between two samples, wherever they and the corners of the law fall: second order.
        assert errors[0] < 3e-4
        assert errors[1] < 3e-4 / 16**2


@all_laws
def test_asymmetric_loops(law):
    """Between any two reversals the loop is that of half their distance, whatever its mean."""
    reach = reach_of(law)
    for low, high in ((0.2, 1.4), (-1.3, 0.1), (-0.2, 1.0)):
        half = 0.5 * (high - low) * reach
        shape = law.loop(half, samples=401)
        moved = 0.5 * (high + low) * reach + shape.displacement
        # Entered by a larger move, on either side.
        for past in (2.0, -2.0):
            force = law.force(np.concatenate(([past * reach], moved, moved[1:])))[-401:]
            loop = ms.Loop(moved, force)
            assert loop.closure_error <= 1e-14
            assert loop.displacement_amplitude == pytest.approx(half, rel=1e-14, abs=0)
            assert loop.force_amplitude == pytest.approx(law.backbone(half), rel=1e-12, abs=0)
            # Displacements about another mean have other last places.
            for name in ("dissipated_energy", "loss_factor", "sliding_ratio", "secant_stiffness"):
                nothing = 1e-15 * (4 * half * law.force_limit if name.endswith("energy") else 1)
                assert getattr(loop, name) == pytest.approx(
                    getattr(shape, name), rel=1e-8, abs=nothing
                ), name
            middle = 0.5 * (force.max() + force.min())
            np.testing.assert_allclose(
                force - middle, shape.force, rtol=0, atol=1e-11 * law.force_limit
            )
    # After the first loading curve only, the same: its far end is the first reversal.
    x = reach * np.array([1.2, 0.3, 1.2, 0.3, 1.2])
    force = law.force(x)
    assert force[0] == force[2] == force[4]
    assert force[1] == force[3]


def test_open_loops_say_so():
    """A chord closes the polygon, and the gap is told."""
    law = law_params()[0].values[0]
    a = reach_of(law)
    cycle = a * np.concatenate((np.linspace(0, 1, 200), np.linspace(1, -1, 400), [-0.9]))
    loop = ms.Loop(cycle, law.force(cycle))
    assert loop.closure_error == pytest.approx(
        abs(loop.force[-1]) / (2 * law.backbone(a)), rel=1e-12, abs=0
    )
    closed = ms.Loop(np.append(cycle, cycle[0]), np.append(loop.force, loop.force[0]))
    assert loop.dissipated_energy == pytest.approx(closed.dissipated_energy, rel=1e-13, abs=0)


def test_pairs_of_samples_are_counted_once():
    """A repeated sample adds no area; scaling both axes scales the energy."""
    law = law_params()[0].values[0]
    loop = law.loop(reach_of(law), samples=101)
    twice = ms.Loop(np.repeat(loop.displacement, 2), np.repeat(loop.force, 2))
    assert twice.dissipated_energy == pytest.approx(loop.dissipated_energy, rel=1e-14, abs=0)
    big = ms.Loop(1e3 * loop.displacement, 1e-2 * loop.force)
    assert big.dissipated_energy == pytest.approx(10 * loop.dissipated_energy, rel=1e-13, abs=0)
    shifted = ms.Loop(loop.displacement + 1e-6, loop.force + 100.0)
    for name in ("dissipated_energy", "sliding_ratio", "loss_factor"):
        assert getattr(shifted, name) == pytest.approx(getattr(loop, name), rel=1e-9, abs=0)


@pytest.mark.parametrize("lag", [1e-3, 0.3, 1.0, math.pi / 2])
@pytest.mark.parametrize("start", [0.0, 1.0, 4.0])
def test_a_viscous_loop(lag, start):
    """An ellipse: area pi x t sin(lag), loss factor sin(lag)."""
    phase = start + np.linspace(0.0, 2.0 * np.pi, 2001)
    loop = ms.Loop(2e-6 * np.cos(phase), 3.0 * np.cos(phase + lag))
    assert loop.dissipated_energy == pytest.approx(math.pi * 6e-6 * math.sin(lag), rel=1e-5, abs=0)
    assert loop.loss_factor == pytest.approx(math.sin(lag), rel=1e-5, abs=0)
    assert loop.damping_ratio == pytest.approx(0.5 * math.sin(lag), rel=1e-5, abs=0)
    assert loop.energy_ratio == pytest.approx(math.pi / 4 * math.sin(lag), rel=1e-5, abs=0)
    assert loop.secant_stiffness == pytest.approx(1.5e6, rel=1e-5, abs=0)
    assert loop.sliding_ratio == pytest.approx(math.sin(lag), rel=1e-4, abs=0)
    assert loop.closure_error < 1e-14
