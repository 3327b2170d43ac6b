"""Limits with a known answer, and the numbers that anyone can find with a pocket calculator."""

import math

import mpmath as mp
import numpy as np
import pytest
from cases import all_laws, law_params, missing_share, reach_of
from usual import PAIR

import microslip as ms
from microslip.contact import NORMAL_LAWS

INTERFACES = law_params(which=lambda law: isinstance(law, ms.Interface))
MU = 0.55


def rough(heights, **changes):
    values = {"pair": PAIR, "radius": 1e-3, "density": 1e8, "area": 2e-4, **changes}
    return ms.GreenwoodWilliamson(heights=heights, **values)


def worked(load):
    return ms.Interface(rough(ms.Gaussian(5e-7)), MU, normal_load=load)


# The worked example: the milled Al 2017 pair


@pytest.mark.parametrize(
    ("load", "h", "contacts", "area_share"),
    [(100.0, 1.905, 568, None), (2000.0, 0.568, 5700, 0.028), (5000.0, -0.005, 10_041, 0.063)],
)
def test_worked_example(load, h, contacts, area_share):
    joint = worked(load)
    assert joint.separation / 5e-7 == pytest.approx(h, abs=6e-4)
    assert joint.contact_count == pytest.approx(contacts, rel=2e-3 if load == 2000 else 1e-3, abs=0)
    assert joint.force_limit == MU * load
    if area_share is not None:
        assert joint.contact_area / 2e-4 == pytest.approx(area_share, abs=6e-4)


def test_worked_example_at_2_kn():
    joint = worked(2000.0)
    assert joint.tangential_stiffness == pytest.approx(5.70e9, abs=0.006e9)
    assert joint.slip_per_indentation * 5e-7 == pytest.approx(0.343e-6, abs=0.0005e-6)
    assert joint.surface.summit_count == 20_000
    assert PAIR.stiffness_ratio == pytest.approx((2 - 0.33) / (2 * (1 - 0.33)), rel=1e-15, abs=0)
    # Contact radii between 14 and 20 um over the chapter's loads of 100 to 5000 N.
    radii = [
        1e6 * math.sqrt(j.contact_area / (math.pi * j.contact_count))
        for j in (worked(100.0), worked(5000.0))
    ]
    assert 13.5 < radii[0] < radii[1] < 20.5
    # The chapter's ranges: 1 to 100 um reach gross slip, and the amplitude curves span both ends.
    assert joint.backbone(100e-6) == pytest.approx(joint.force_limit, rel=1e-14, abs=0)
    assert joint.dissipation_exponent(1e-11) == pytest.approx(3, abs=1e-4)
    assert joint.dissipation_exponent(100e-6) == pytest.approx(1, abs=0.01)


def test_real_area_of_a_tenth_needs_merged_contacts():
    """The wear mark of the chapter, 10 % at 2 kN, as arithmetic: summits wider than their pitch."""
    surface = rough(ms.Gaussian(5e-7), radius=8.3e-3, density=9.06e8)
    joint = ms.Interface(surface, MU, normal_load=2000.0)
    assert joint.contact_area / 2e-4 == pytest.approx(0.1, abs=5e-4)
    assert {v.name: v.word for v in joint.validity}["density * radius * std"] == "outside"


# Exponential heights


@pytest.mark.parametrize("h", [0.0, 0.3, 4.0, 60.0])
def test_exponential_closed_form(h):
    """T0 = mu N (1 - exp(-x)), E_d = mu N kappa sigma [4x - 8 + (8 + 4x) exp(-x)], for h >= 0."""
    scale = 8e-7
    joint = ms.Interface(rough(ms.Exponential(scale)), MU, separation=h * scale)
    length, top = joint.slip_per_indentation * scale, joint.force_limit
    load = joint.surface.summit_count * PAIR.composite_modulus * math.sqrt(math.pi * 1e-3)
    assert joint.normal_load == pytest.approx(load * scale**1.5 * math.exp(-h), rel=3e-14, abs=0)
    x = np.array([1e-12, 1e-7, 1e-3, 0.1, 0.5, 1.0, 3.0, 10.0, 30.0, 500.0])
    np.testing.assert_allclose(joint.backbone(length * x), -top * np.expm1(-x), rtol=1e-14)
    # exp(-y) knows y to its last place only, y up to 560 here.
    np.testing.assert_allclose(
        joint.backbone_stiffness(length * x), top / length * np.exp(-x), rtol=3e-13
    )
    np.testing.assert_allclose(
        joint.sliders().density(length * x), top / length**2 * np.exp(-x), rtol=3e-13
    )
    with mp.workdps(60):
        wanted = [
            float(top * length * (4 * v - 8 + (8 + 4 * v) * mp.exp(-v))) for v in map(mp.mpf, x)
        ]
    np.testing.assert_allclose(joint.dissipated_energy(length * x), wanted, rtol=2e-14)
    # Every exponential joint is the same joint: contacts go with the load, force with both.
    assert joint.contact_count == pytest.approx(20_000 * math.exp(-h), rel=1e-14, abs=0)
    assert joint.contact_area == pytest.approx(
        math.pi * 1e-3 * scale * joint.contact_count, rel=1e-14, abs=0
    )


# Small and large amplitudes


@pytest.mark.parametrize("law", INTERFACES)
def test_small_amplitudes_are_cubic(law):
    """E_d -> (2/3) (mu/kappa^2) N''(d) a^3 = -(2/3) T0''(0) a^3; the next term is of order a."""
    reach = reach_of(law)
    curvature = law.sliders().density(0.0)
    scale = curvature * reach / law.tangential_stiffness
    a = np.array([1e-9, 1e-7, 1e-5]) * reach
    cubic = 2 / 3 * curvature * a**3
    np.testing.assert_allclose(law.dissipated_energy(a) / cubic, 1, atol=3e-4 * max(1, scale))
    assert law.dissipated_energy(a)[0] == pytest.approx(cubic[0], rel=1e-7 * max(1, scale), abs=0)
    np.testing.assert_allclose(law.dissipation_exponent(a), 3, atol=3e-4 * max(1, scale))
    assert law.dissipation_exponent(0.0) == 3
    assert law.dissipated_energy(0.0) == 0
    # Damping goes like the amplitude, stiffness to its value at rest.
    np.testing.assert_allclose(
        law.loss_factor(a), 2 / 3 / math.pi * curvature * a / law.tangential_stiffness, rtol=1e-3
    )
    assert law.secant_stiffness(a[0]) == pytest.approx(law.tangential_stiffness, rel=1e-8, abs=0)
    assert law.secant_stiffness(0.0) == law.tangential_stiffness


def test_cubic_coefficient_against_high_precision():
    joint = worked(2000.0)
    with mp.workdps(30):
        h = mp.mpf(joint.separation) / mp.mpf(5e-7)
        modulus = mp.mpf(69e9) / (2 * (1 - mp.mpf(0.33) ** 2))
        half = mp.mpf(1) / 2
        moment = mp.gamma(half) / mp.sqrt(2 * mp.pi) * mp.exp(-h * h / 4) * mp.pcfd(-half, h)
        bend = 20_000 * modulus * mp.sqrt(mp.mpf(1e-3)) / mp.sqrt(mp.mpf(5e-7)) * moment
        kappa = mp.mpf(MU) * (2 - mp.mpf(0.33)) / (2 * (1 - mp.mpf(0.33)))
        coefficient = float(mp.mpf(2) / 3 * mp.mpf(MU) / kappa**2 * bend)
    for a in (1e-30, 1e-24, 1e-18):
        assert joint.dissipated_energy(a) == pytest.approx(coefficient * a**3, rel=2e-12, abs=0)


@all_laws
def test_large_amplitudes_are_linear(law):
    """E_d -> 4 mu N (a - 2 kappa M/N): a slope of 4 mu N, and an axis it meets."""
    if isinstance(law, ms.Interface):
        start = np.array([law.separation])
        tail = float(law.surface._derivative(start, -1)[0])
        offset = 2 * law.slip_per_indentation * tail / law.normal_load
        a = reach_of(law) * np.array([1e3, 1e5, 1e8])
        wanted = 4 * law.force_limit * (a - offset)
        # Light loads hang on the last place of the separation.
        doubt = 1e-15 * abs(law.separation) * law.normal_stiffness / law.normal_load
        np.testing.assert_allclose(law.dissipated_energy(a), wanted, rtol=1e-14 + doubt)
    far = 1e9 * reach_of(law)
    near = 1e-8 + missing_share(law, far)
    assert near < 1e-3
    assert law.energy_ratio(far) == pytest.approx(1, abs=near)
    assert law.loss_factor(far) == pytest.approx(4 / math.pi, rel=near, abs=0)
    assert law.damping_ratio(far) == pytest.approx(2 / math.pi, rel=near, abs=0)
    assert law.dissipation_exponent(far) == pytest.approx(1, abs=near)


@all_laws
def test_energy_is_the_area_of_the_backbone(law):
    """E_d = 8 int T0 - 4 a T0(a) by quadrature, where it does not cancel."""
    nodes, weights = np.polynomial.legendre.leggauss(100)
    corners = np.sort(law.sliders().yield_displacements)
    for a in reach_of(law) * np.array([0.4, 1.01, 2.5]):
        marks = np.concatenate(([0.0], corners[(corners > 0) & (corners < a)], [a]))
        width = np.diff(marks)
        u = marks[:-1, None] + 0.5 * width[:, None] * (1 + nodes)
        area = 0.5 * float(width @ (law.backbone(u) @ weights))
        wanted = 8 * area - 4 * a * law.backbone(a)
        nothing = 1e-14 * 4 * a * law.backbone(a)
        # Finite populations and tables bend on the way: there quadrature is coarse.
        assert law.dissipated_energy(a) == pytest.approx(wanted, rel=2e-5, abs=nothing)
        # and dE_d/da = 4 (T0 - a T0')
        slope = 4 * (law.backbone(a) - a * law.backbone_stiffness(a))
        exponent = law.dissipation_exponent(a)
        if law.dissipated_energy(a) == 0:
            assert slope == pytest.approx(0, abs=nothing / a)
            assert math.isnan(exponent)
            continue
        assert exponent * law.dissipated_energy(a) == pytest.approx(a * slope, rel=1e-12, abs=0)


# Stiff, slippery, sticky


def test_coulomb_limit():
    """Stiff bodies at one load: rigid-plastic, the loop a box."""
    reaches = []
    for stiffness in (1e9, 1e12, 1e15, 1e18):
        body = ms.Material(stiffness, 0.33)
        surface = rough(ms.Gaussian(5e-7), pair=ms.MaterialPair(body, body))
        joint = ms.Interface(surface, MU, normal_load=2000.0)
        reaches.append(reach_of(joint))
        a = 1e4 * 5e-7
        assert joint.energy_ratio(a) == pytest.approx(1, abs=2 * reach_of(joint) / a)
        assert joint.loss_factor(a) < 4 / math.pi
        forces = joint.force(a * np.array([1, -1, 0.5, 1]))
        np.testing.assert_allclose(forces, joint.force_limit * np.array([1, -1, 1, 1]), rtol=1e-14)
    # It is only slowly that more, higher summits at one load become stiff: like 1/h.
    assert np.all(np.diff(reaches) < 0)
    assert reaches[0] / reaches[-1] < 20
    # A flat surface does it at once: all contact is lost within a hair.
    flat = ms.Interface(rough(ms.Gaussian(5e-13)), MU, normal_load=1e-3)
    assert flat.backbone(1e-11) == pytest.approx(flat.force_limit, rel=1e-14, abs=0)


def test_full_stick_limit():
    """Endless friction: the joint is a spring and wastes nothing."""
    surface = rough(ms.Gaussian(5e-7))
    first = ms.Interface(surface, MU, normal_load=2000.0)
    x = 1e-6 * np.array([1.0, -0.5, 0.8, 0.3, -1.0])
    for friction in (1e3, 1e6, 1e9):
        joint = ms.Interface(surface, friction, normal_load=2000.0)
        assert joint.tangential_stiffness == pytest.approx(
            first.tangential_stiffness, rel=1e-15, abs=0
        )
        force = joint.force(x)
        linear = joint.tangential_stiffness * x
        np.testing.assert_allclose(force, linear, rtol=0, atol=3 / friction * linear.max())
        assert joint.loss_factor(1e-6) < 1 / friction
        assert joint.stick_area(1e-6) == pytest.approx(joint.contact_area, rel=3 / friction, abs=0)


# Heavy and light


def test_all_summits_in_contact():
    """h -> -infinity: N_a equal spheres, the scatter of heights a small correction."""
    for h in (-1e2, -4e2, -1.9e3):  # no deeper than the radius, 2000 of these lengths
        joint = ms.Interface(rough(ms.Gaussian(5e-7)), MU, separation=h * 5e-7)
        depth = -h * 5e-7
        assert joint.contact_count == pytest.approx(20_000, rel=1e-15, abs=0)
        assert joint.contact_area == pytest.approx(
            20_000 * math.pi * 1e-3 * depth, rel=1e-14, abs=0
        )
        one = ms.Interface(ms.SphereOnFlat(PAIR, 1e-3), MU, separation=-depth)
        second = 1 / h**2  # of the series in 1/h^2 the next term
        assert joint.normal_load == pytest.approx(20_000 * one.normal_load, rel=second, abs=0)
        assert joint.normal_load == pytest.approx(
            20_000 * one.normal_load * (1 + 0.375 * second), rel=max(second**2, 1e-14), abs=0
        )
        limit = joint.slip_per_indentation * depth
        x = limit * np.array([1e-3, 0.2, 0.5, 0.9])
        np.testing.assert_allclose(joint.backbone(x), 20_000 * one.backbone(x), rtol=8 * second)
        np.testing.assert_allclose(
            joint.dissipated_energy(x), 20_000 * one.dissipated_energy(x), rtol=300 * second
        )
    deep = ms.Interface(rough(ms.Exponential(5e-7)), MU, separation=-9e-4)
    assert deep.contact_count == 20_000
    assert deep.contact_area == pytest.approx(
        20_000 * math.pi * 1e-3 * (9e-4 + 5e-7), rel=1e-14, abs=0
    )


def test_light_loads_look_exponential():
    """h large: heights above the plane fall off like exp(-h s/sigma), and so does the rest."""
    deviations = []
    for h in (5.0, 10.0, 20.0, 35.0):
        joint = ms.Interface(rough(ms.Gaussian(5e-7)), MU, separation=h * 5e-7)
        x = np.array([0.1, 0.5, 1.0, 2.0, 4.0])
        length = joint.slip_per_indentation * 5e-7 / h
        shape = joint.backbone(length * x) / joint.force_limit
        deviations.append(np.abs(shape / -np.expm1(-x) - 1).max() * h**2)
    assert max(deviations) < 3.5
    assert deviations[-1] == pytest.approx(
        deviations[-2], rel=0.05, abs=0
    )  # of second order in 1/h


# Every normal law


@pytest.mark.parametrize(
    "surface", [s for cls in NORMAL_LAWS for s in cls.examples()], ids=lambda s: type(s).__name__
)
def test_normal_law_is_decreasing_convex_and_its_inverse_inverts(surface):
    low, high = surface._span
    d = np.linspace(low, high, 2001)[:-1]
    d = d[surface.load(d) > 1e-250]
    load, stiffness = surface.load(d), surface.stiffness(d)
    assert np.all(np.diff(load) < 0)
    assert np.all(np.diff(stiffness) <= 1e-14 * stiffness[:-1])
    assert np.all(stiffness > 0)
    back = surface.separation(load)
    doubt = np.maximum(np.abs(d), 0.01 * (high - low)) + load / stiffness
    assert np.all(np.abs(back - d) <= 3e-15 * doubt)
    # The stiffness is the slope: its integral over each step by Gauss points.
    nodes, weights = np.polynomial.legendre.leggauss(12)
    t = 0.5 * (d[1:] + d[:-1])[:, None] + 0.5 * np.diff(d)[:, None] * nodes
    area = 0.5 * np.diff(d) * (surface.stiffness(t) @ weights)
    error = np.abs(area / (load[:-1] - load[1:]) - 1)
    # Given summits and tables bend at some places, within a few of the steps.
    smooth = surface._spheres is None and not isinstance(surface, ms.TabulatedNormalLaw)
    lost = 1e-15 * load[:-1] / area
    between = np.ones(error.size, dtype=bool)
    if isinstance(surface, ms.TabulatedNormalLaw):  # whose bends are where its pieces meet
        between = np.diff(np.searchsorted(surface._spline.knots, d)) == 0
    assert between.sum() > 100
    assert np.mean((error <= 1e-12 + lost)[between]) > (0.999 if smooth else 0.98)
    assert np.all(error < 1e-2)
