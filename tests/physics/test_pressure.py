"""A pressure that varies from place to place: against sums, closed forms, limits, known effects."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate
from usual import JOINT, PAIR, SURFACE, rough

import microslip as ms
from microslip.friction.pressure import BOLTS

AREA = 2e-4
OUTER = math.sqrt(AREA / math.pi)
PLACES = np.array([1e-9, 1e-8, 1e-7, 1e-6])


def pressed(pressure: ms.Pressure, load: float = 2000.0) -> ms.PressedJoint:
    return ms.PressedJoint(SURFACE, 0.55, pressure, load)


def test_against_an_integral_over_the_radius() -> None:
    """Exponential heights have a law of one shape under any pressure: so has the sum."""
    heights, scale = ms.Exponential(5e-7), 5e-7
    joint = ms.PressedJoint(rough(heights), 0.55, ms.Pressure.cone(OUTER, 2e-3), 20.0)
    kappa = joint.slip_per_indentation
    whole = integrate.quad(lambda r: 2 * math.pi * r * (OUTER - r), 2e-3, OUTER)[0]
    x = PLACES / (kappa * scale)
    # Every place has the same law mu N (1 - e^-x): so has the sum, however the load is spread.
    np.testing.assert_allclose(joint.backbone(PLACES), -11.0 * np.expm1(-x), rtol=1e-12)
    pressures = 20.0 * (OUTER - joint.pressure.distances) / whole
    # At the rim the radius itself cancels.
    np.testing.assert_allclose(joint.pressures, pressures, rtol=1e-12, atol=1e-15 * 3e5 * 10)


def test_against_a_sum_over_many_rings() -> None:
    """By the midpoint rule in the radius, which knows nothing of Gauss."""
    edges = np.linspace(0.0, OUTER, 2001)
    middle = 0.5 * (edges[1:] + edges[:-1])
    areas = math.pi * np.diff(edges**2)
    loads = areas * (1.0 - (middle / OUTER) ** 2)
    loads *= 2000.0 / loads.sum()
    kappa = JOINT.slip_per_indentation
    d = SURFACE.separation(loads * AREA / areas)
    stiffness = float(np.sum(areas / AREA * SURFACE.stiffness(d))) / PAIR.stiffness_ratio
    joint = pressed(ms.Pressure.parabola(OUTER))
    assert joint.tangential_stiffness == pytest.approx(stiffness, rel=1e-6)
    for u in PLACES:
        drops = SURFACE.load(d) - SURFACE.load(d + u / kappa)
        force = 0.55 * float(np.sum(areas / AREA * drops))
        assert joint.backbone(u) == pytest.approx(force, rel=1e-6)


def test_published_effects() -> None:
    """Beside an even one: a parabola -4 % of k_t, -8 % of E_d; a cone on half of it -20, -40."""
    parabola, cone = (
        pressed(ms.Pressure.parabola(OUTER)),
        pressed(ms.Pressure.cone(OUTER / math.sqrt(2.0))),
    )

    def lost(joint: ms.PressedJoint, amplitude: float) -> float:
        return joint.dissipated_energy(amplitude) / JOINT.dissipated_energy(amplitude) - 1.0

    assert parabola.tangential_stiffness / JOINT.tangential_stiffness == pytest.approx(
        0.96, abs=0.005
    )
    assert lost(parabola, 1e-8) == pytest.approx(-0.08, abs=0.005)
    assert cone.tangential_stiffness / JOINT.tangential_stiffness == pytest.approx(0.80, abs=0.01)
    assert lost(cone, 1e-8) == pytest.approx(-0.40, abs=0.005)
    assert lost(cone, 1e-6) == pytest.approx(-0.11, abs=0.005)


def test_rings_converge_and_limits_hold() -> None:
    fine = pressed(ms.Pressure.cone(OUTER, rings=200))
    for rings, within in ((8, 2e-6), (32, 1e-10)):
        joint = pressed(ms.Pressure.cone(OUTER, rings=rings))
        np.testing.assert_allclose(
            joint.dissipated_energy(PLACES), fine.dissipated_energy(PLACES), rtol=within
        )
        assert joint.force_limit == pytest.approx(1100.0, rel=1e-12)
    even = pressed(ms.Pressure.annulus(OUTER))
    np.testing.assert_allclose(even.backbone(PLACES), JOINT.backbone(PLACES), rtol=1e-12)
    # Four bolts that carry four times as much on four times the area: four times one.
    one, four = (ms.Pressure.bolt("M5", [2e-3, 9e-3], count=n) for n in (1, 4))
    a, b = pressed(one, 500.0), pressed(four, 2000.0)
    np.testing.assert_allclose(b.backbone(PLACES), 4.0 * a.backbone(PLACES), rtol=1e-12)
    assert b.contact_area == pytest.approx(4.0 * a.contact_area, rel=1e-12)
    # Patches are what they say.
    patches = pressed(ms.Pressure.patches([1e-5, 3e-5, 2e-5], [2.0, 1.0, 0.0]))
    assert patches.pressure.areas.tolist() == [1e-5, 3e-5]
    wanted = sum(
        ms.Interface(rough(ms.Gaussian(5e-7), area=area), 0.55, normal_load=load).backbone(PLACES)
        for area, load in ((1e-5, 800.0), (3e-5, 1200.0))
    )
    np.testing.assert_allclose(patches.backbone(PLACES), wanted, rtol=1e-14)


def test_a_bolt_by_rotscher() -> None:
    spread = ms.Pressure.bolt("M8", [10e-3, 6e-3])
    bolt = BOLTS["M8"]
    rim = 0.5 * bolt.head + 6e-3 * math.tan(math.radians(30.0))
    assert spread.area == pytest.approx(math.pi * (rim**2 - (0.5 * bolt.hole) ** 2), rel=1e-12)
    joint = pressed(ms.Pressure.bolt("M8", [5e-3, 5e-3], edge=12e-3), 1000.0)
    assert float(joint.pressures @ joint.pressure.areas) == pytest.approx(1000.0, rel=1e-13)
    # What slips first is what is pressed least.
    shares = joint.slip_shares(1e-8)
    assert np.all(np.diff(shares) > 0.0)
    assert np.all(np.diff(joint.pressures) < 0.0)
    total = float(shares @ (0.55 * joint.normal_load * joint.pressure.shares))
    assert total == pytest.approx(joint.backbone(1e-8), rel=1e-12)


def test_a_face_was_tightened_under_the_same_pressure() -> None:
    steel = ms.Material(210e9, 0.3, hardness=2.4e9)
    law = ms.DrawnFace(ms.MaterialPair(steel, steel), 8e-7, 0.12, 1e-4, 6e7)
    spread = ms.Pressure.patches([1e-5, 4e-5], [3.0, 1.0])
    joint = ms.PressedJoint(law, 0.55, spread, 1000.0)
    assert joint.pressures == pytest.approx([1000.0 * 3.0 / 7e-5, 1000.0 / 7e-5])
    tightened = [place.surface.tightening_pressure for place in joint.laws]
    assert tightened == pytest.approx([6e7, 2e7])
    heavier = joint.at(normal_load=1800.0)  # each place is tightened anew
    tightened = [place.surface.tightening_pressure for place in heavier.laws]
    assert tightened == pytest.approx(heavier.pressures.tolist())
    assert ms.PressedJoint(law, 0.55, spread, 1800.0).tangential_stiffness == pytest.approx(
        heavier.tangential_stiffness, rel=1e-9
    )
    lighter = joint.at(normal_load=900.0)  # on the places as they are
    fresh = ms.PressedJoint(law, 0.55, joint.pressure, 900.0)
    assert lighter.laws[0].surface is joint.laws[0].surface
    np.testing.assert_array_equal(lighter.backbone(PLACES), fresh.backbone(PLACES))
    assert (lighter.normal_load, lighter.separation) == (900.0, fresh.separation)
    # As of a field with these nodes, whose places share the shape of the law.
    field = ms.JointField(law, 0.55, areas=spread.areas, loads=1000.0 * spread.shares)
    reach = joint.force_limit / joint.tangential_stiffness
    for u in reach * np.array([0.1, 1.0, 3.0]):
        assert field.rigid().backbone(u) == pytest.approx(joint.backbone(u), rel=0.01)


def test_an_even_pressure_is_judged_as_an_interface_is() -> None:
    """Of unlike metals too, whose coupling is a matter of the pair."""
    pair = ms.MaterialPair(ms.Material(210e9, 0.3), ms.Material(70e9, 0.45))
    surface = rough(ms.Gaussian(5e-7), pair, 1e-4)
    pressure = ms.Pressure.patches(np.full(4, 0.25e-4), np.full(4, 1e7))
    spread = ms.PressedJoint(surface, 0.5, pressure, 1000.0).validity
    even = ms.Interface(surface, 0.5, normal_load=1000.0).validity
    assert "Dundurs' constant of the pair" in [verdict.name for verdict in spread]
    assert [(v.name, v.word) for v in spread] == [(v.name, v.word) for v in even]
    values = [[v.value for v in of if v.value is not None] for of in (spread, even)]
    np.testing.assert_allclose(*values, rtol=1e-9)
