"""Elliptic summits: against integrals of Hertz and Cerruti, the circle, and known effects."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy import integrate
from studies import SURFACE, edited

import microslip as ms
from microslip.normal.greenwood_williamson import hertz_ellipse, stiffness_ratio
from microslip.scans import random_surface
from microslip.scans.summit_set import elliptic_surface

ALUMINIUM = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(ALUMINIUM, ALUMINIUM)
ROUND = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), 1e-3, 1e8, 2e-4)


def lay(ratio: float, direction: float, pair: ms.MaterialPair = PAIR) -> ms.EllipticSummits:
    return ms.EllipticSummits(pair, ms.Gaussian(5e-7), 1e-3, 1e8, 2e-4, ratio, direction)


def test_the_ellipse_with_thirty_digits() -> None:
    """Johnson's (4.26)-(4.33) in complete elliptic integrals, solved for the axes by mpmath."""
    with mpmath.workdps(30):
        for ratio in (0.999, 0.5, 0.03, 1e-5):

            def relation(t: mpmath.mpf, ratio: float = ratio) -> mpmath.mpf:
                m = 1 - t * t
                k, e = mpmath.ellipk(m), mpmath.ellipe(m)
                return mpmath.log((k - e) / (e / (t * t) - k) / mpmath.mpf(ratio))

            found = hertz_ellipse(ratio)
            t = mpmath.findroot(relation, found.axis_ratio)
            m = 1 - t * t
            k, e = mpmath.ellipk(m), mpmath.ellipe(m)
            size = (4 / (mpmath.pi * m) * t**1.5 * mpmath.sqrt((e / t**2 - k) * (k - e))) ** (
                mpmath.mpf(1) / 3
            )
            depth = 2 / mpmath.pi * mpmath.sqrt(t) * k / size
            wanted = (t, depth**-1.5, size**2 / depth, (k - e) / (m * k))
            # The axes of all but a circle go with the root of the misfit of the ratio.
            for value, exact in zip(found, wanted, strict=True):
                assert value == pytest.approx(float(exact), rel=2e-12)
    assert hertz_ellipse(1.0) == (1.0, pytest.approx(1.0), pytest.approx(1.0), pytest.approx(0.5))


def test_compliance_by_integration() -> None:
    """<cos^2> over the directions, weighted by the radius of the ellipse, by QUADPACK."""
    for ratio in (0.5, 0.03):
        ellipse = hertz_ellipse(ratio)
        t = ellipse.axis_ratio
        for beta in (0.0, 0.4, math.pi / 2):

            def radius(f: float, t: float = t) -> float:
                return 1.0 / math.hypot(t * math.cos(f), math.sin(f))

            def part(f: float, beta: float = beta) -> float:
                return radius(f) * math.cos(f - beta) ** 2

            mean = integrate.quad(part, 0.0, 2 * math.pi, epsabs=0, epsrel=1e-12, limit=400)[0]
            mean /= integrate.quad(radius, 0.0, 2 * math.pi, epsabs=0, epsrel=1e-12, limit=400)[0]
            nu = 0.33
            wanted = 1.0 + nu / (1.0 - nu) * mean
            assert lay(ratio, beta).stiffness_ratio == pytest.approx(wanted, rel=1e-12)


def test_limits_and_known_effects() -> None:
    circle = lay(1.0, 0.7)
    joint, same = (ms.Interface(s, 0.55, normal_load=2000.0) for s in (ROUND, circle))
    x = np.array([1e-9, 1e-7, 1e-6])
    np.testing.assert_allclose(same.backbone(x), joint.backbone(x), rtol=1e-13)
    np.testing.assert_allclose(same.dissipated_energy(x), joint.dissipated_energy(x), rtol=1e-12)
    assert same.contact_area == pytest.approx(joint.contact_area, rel=1e-13)
    steel = ms.MaterialPair(ms.Material(210e9, 0.3), ALUMINIUM)
    assert stiffness_ratio(steel, 0.5) == pytest.approx(steel.stiffness_ratio, rel=1e-14)
    rigid = ms.MaterialPair(ms.Material.rigid(), ALUMINIUM)
    assert stiffness_ratio(rigid, 0.5) == pytest.approx(rigid.stiffness_ratio, rel=1e-14)
    # Motion across against along at the same load: k_t x1.07 at b/a = 0.5, x1.20 at 0.1.
    for ratio, effect in ((0.3517716, 1.07), (0.0273702, 1.20)):
        across, along = (
            ms.Interface(lay(ratio, beta), 0.55, normal_load=2000.0).tangential_stiffness
            for beta in (0.5 * math.pi, 0.0)
        )
        assert across / along == pytest.approx(effect, abs=0.005)
    # Everything tangential goes with it: fields, straight steps and one joint agree.
    law = lay(0.1, 0.3)
    joint = ms.Interface(law, 0.55, normal_load=2000.0)
    field = ms.JointField(law, 0.55, areas=[2e-4], loads=[2000.0])
    np.testing.assert_allclose(field.rigid().backbone(x), joint.backbone(x), rtol=1e-9)
    assert joint.slip_per_indentation == 0.55 * law.stiffness_ratio


def test_in_a_study_and_wrong() -> None:
    block = SURFACE.replace('"greenwood-williamson"', '"elliptic-summits"')
    block += 'curvature_ratio = 0.1\ndirection = "90 deg"\n'
    joint = ms.Study.from_toml(edited((SURFACE, block))).run().joints[1]
    wanted = ms.Interface(lay(0.1, 0.5 * math.pi), 0.55, normal_load=2000.0)
    assert joint.tangential_stiffness == pytest.approx(wanted.tangential_stiffness, rel=1e-12)
    for old, new, says in (
        ("0.1", "1.5", "surface.curvature_ratio: wanted a number"),
        ("90 deg", "90", 'surface.direction: wanted an angle such as "90 deg"'),
    ):
        with pytest.raises(ms.StudyError) as caught:
            ms.Study.from_toml(edited((SURFACE, block.replace(old, new))))
        assert says in str(caught.value)


def test_tightened_ellipses() -> None:
    """Without yield the elastic ones, round ones are spheres, and yield makes them stiff."""
    across = lay(0.1, 0.5 * math.pi)
    elastic = across.tightened(500.0, yield_stress=1e12)
    d = across.separation([1.0, 50.0, 400.0])
    for name in ("load", "stiffness", "contact_area", "contact_count", "contact_probability"):
        np.testing.assert_allclose(getattr(elastic, name)(d), getattr(across, name)(d), rtol=1e-7)
    assert elastic.stiffness_ratio == across.stiffness_ratio
    joint = ms.Interface(elastic, 0.4, normal_load=300.0)
    wanted = ms.Interface(across, 0.4, normal_load=300.0)
    assert joint.dissipated_energy(1e-7) == pytest.approx(wanted.dissipated_energy(1e-7), rel=1e-6)
    round_ones = lay(1.0, 0.0).tightened(500.0, yield_stress=2e8)
    spheres = ms.GreenwoodWilliamson(
        across.pair, across.heights, across.radius, across.density, across.area
    ).tightened(500.0, yield_stress=2e8)
    at = spheres.separation(200.0)
    assert round_ones.load(at) == pytest.approx(200.0, rel=1e-9)
    yielded = across.tightened(500.0, yield_stress=2e8)
    assert ms.Interface(yielded, 0.4, normal_load=300.0).normal_stiffness > wanted.normal_stiffness


def test_from_the_principal_curvatures_of_a_scan() -> None:
    """Stretched four times along y, the lay is y; as it is made, no direction is another."""
    made = random_surface((256, 256), 1e-6, m0=4e-14, m2=1e-3, m4=2e8, seed=2)
    even, stretched = (
        ms.Scan(made.heights, (1e-6, step)).summits(None, prominence=1e-9) for step in (1e-6, 4e-6)
    )
    circle = PAIR.stiffness_ratio
    for angle in (0.0, 0.8, 0.5 * math.pi):
        law = elliptic_surface(even, PAIR, "2 cm^2", direction=angle)
        # As many summits lie along as across, to their scatter over some hundred.
        assert law.stiffness_ratio == pytest.approx(circle, rel=0.01)
        assert law.radius == even.equivalent_radius
    across, along = (
        elliptic_surface(stretched, PAIR, 2e-4, direction=angle) for angle in (0.0, 0.5 * math.pi)
    )
    assert across.stiffness_ratio < 0.97 * circle < 1.03 * circle < along.stiffness_ratio
    assert across.curvature_ratio == along.curvature_ratio < 0.2
    with pytest.raises(ms.InputError, match="of the method watershed"):
        elliptic_surface(even.statistics(), PAIR, 2e-4, direction=0.0)  # type: ignore[arg-type]
