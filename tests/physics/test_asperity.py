"""One asperity's fields against high precision, other methods, and what must hold for any record.

The other methods know nothing of the code: chords of the contact through Cerruti's kernel, ring
loads in elliptic integrals, and a contact of discrete rings that slip by Coulomb's law in steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from cases import moves
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, special

import microslip as ms
from microslip.friction.fields import potentials

AL, STEEL = ms.Material(69e9, 0.33), ms.Material(210e9, 0.3)
BALL = ms.Asperity(
    ms.MaterialPair(AL, AL), radius=5e-3, friction_coefficient=0.55, normal_load=10.0
)
PAIRS = {
    "alike": ms.MaterialPair(AL, AL),
    "unlike": ms.MaterialPair(AL, STEEL),
    "rigid": ms.MaterialPair(ms.Material.rigid(), AL),
    "auxetic": ms.MaterialPair(ms.Material(3e9, -0.4), ms.Material(1e6, 0.5)),
}
ASPERITIES = {
    name: ms.Asperity(pair, radius=2e-3, friction_coefficient=0.3, normal_load=5.0)
    for name, pair in PAIRS.items()
} | {"ball": BALL}
all_asperities = pytest.mark.parametrize("asperity", ASPERITIES.values(), ids=ASPERITIES)

# Every branch that the chapter names, in slip limits (Figs. 19.12-19.17), and some it does not.
PATHS: dict[str, list[float]] = {
    "rest": [0.0],
    "hardly moved": [1e-9],
    "loading OA": [0.6],
    "unloading AB": [0.6, 0.1],
    "unloading AB, next to nothing": [0.6, 0.6 - 1e-9],
    "back at zero": [0.6, 0.0],
    "full reversal C": [0.6, -0.6],
    "reloading CD": [0.6, -0.6, 0.2],
    "reloading, T_B > 0": [0.6, 0.5, 0.55],
    "reloading BC": [0.9, -0.3, 0.4],
    "unloading again CD": [0.9, -0.3, 0.4, 0.0],
    "five reversals": [0.9, -0.7, 0.6, -0.4, 0.3, 0.05],
    "a closed loop": [0.9, 0.2, 0.5, 0.2, 0.1],
    "virgin again": [0.5, -0.3, 0.9],
    "gross slip": [2.5],
    "at the slip limit": [1.0],
    "after gross slip": [2.5, 2.0],
    "gross slip back": [2.5, -1.0],
    "reloading after it": [2.5, -1.0, 0.0],
    "the other way": [-0.8, 0.1],
}  # fmt: skip
all_paths = pytest.mark.parametrize("path", PATHS.values(), ids=PATHS)

_T = np.linspace(-3.6, 3.6, 217)
DOUBLE_EXPONENTIAL = (  # nodes on [0, 1] and weights: blind to what the ends hide
    1.0 / (1.0 + np.exp(-math.pi * np.sinh(_T))),
    (_T[1] - _T[0])
    * math.pi
    * np.cosh(_T)
    * np.exp(-math.pi * np.abs(np.sinh(_T)))
    / (1.0 + np.exp(-math.pi * np.abs(np.sinh(_T)))) ** 2,
)


def area_integral(value: Callable[[Any], Any], edges: list[float]) -> float:
    """Integral over the contact of what is smooth between circles, in the area itself."""
    nodes, weights = DOUBLE_EXPONENTIAL
    total = 0.0
    for inner, outer in pairwise(edges):
        area = inner**2 + (outer**2 - inner**2) * nodes
        total += math.pi * (outer**2 - inner**2) * float(weights @ value(np.sqrt(area)))
    return total


def edges_of(fields: ms.AsperityFields) -> list[float]:
    return [0.0, *(zone.outer for zone in fields.zones)]


def test_the_quadrature() -> None:
    _, weights = DOUBLE_EXPONENTIAL
    assert weights.sum() == pytest.approx(1.0, rel=1e-14, abs=0)
    root = area_integral(lambda r: np.sqrt(np.maximum(4.0 - r * r, 0.0)), [0.0, 2.0])
    assert root == pytest.approx(2.0 / 3.0 * math.pi * 8.0, rel=1e-14, abs=0)


# -- Hertz (19.1)-(19.3) ---------------------------------------------------------------------------


@all_asperities
def test_hertz_against_high_precision(asperity: ms.Asperity) -> None:
    with mp.workdps(30):
        pair = asperity.pair
        soft = sum(
            (1 - mp.mpf(m.poisson_ratio) ** 2) / mp.mpf(m.young_modulus)
            for m in (pair.first, pair.second)
        )
        rho, load = mp.mpf(asperity.radius), mp.mpf(asperity.normal_load)
        a = mp.cbrt(3 * load * rho * soft / 4)
        expected = {
            "contact_radius": a,
            "indentation": a**2 / rho,
            "contact_area": mp.pi * a**2,
            "peak_pressure": 3 * load / (2 * mp.pi * a**2),
            "normal_stiffness": 2 * a / soft,
        }
    for name, value in expected.items():
        assert getattr(asperity, name) == pytest.approx(float(value), rel=4e-15, abs=0), name
    assert asperity.contact_count == 1.0


@all_asperities
def test_the_pressure_carries_the_load(asperity: ms.Asperity) -> None:
    a = asperity.contact_radius
    assert area_integral(asperity.pressure, [0.0, a]) == pytest.approx(
        asperity.normal_load, rel=1e-13, abs=0
    )
    assert asperity.pressure(a) == 0.0
    assert asperity.pressure(1.1 * a) == 0.0


@all_asperities
def test_normal_displacement(asperity: ms.Asperity) -> None:
    """In the contact the sphere's shape; outside Johnson's (3.42a); far away a point force."""
    a, s, rho = asperity.contact_radius, asperity.indentation, asperity.radius
    r = a * np.array([0.0, 1e-9, 0.3, 0.99, 1.0])
    np.testing.assert_allclose(asperity.normal_displacement(r), s - r**2 / (2 * rho), rtol=1e-14)
    for ratio in (1.0 + 1e-9, 1.5, 7.0, 1e4, 1e9):
        with mp.workdps(50):
            x = mp.mpf(ratio)
            form = (2 - x**2) * mp.asin(1 / x) + mp.sqrt(x**2 - 1)
            wanted = float(mp.mpf(s) / mp.pi * form)
        assert asperity.normal_displacement(ratio * a) == pytest.approx(wanted, rel=1e-14, abs=0)
    far = 1e7 * a
    point = asperity.normal_load / (math.pi * asperity.pair.composite_modulus * far)
    assert asperity.normal_displacement(far) == pytest.approx(point, rel=1e-13, abs=0)
    bodies = [asperity.normal_displacement(r, body=body) for body in ("first", "second")]
    np.testing.assert_allclose(sum(bodies), asperity.normal_displacement(r), rtol=1e-14)


# -- limits and landmarks --------------------------------------------------------------------------


@all_asperities
def test_landmarks_at_the_slip_limit(asperity: ms.Asperity) -> None:
    limit = asperity.slip_limit
    energy = asperity.dissipated_energy(limit)
    assert asperity.energy_ratio(limit) == pytest.approx(0.2, rel=1e-14, abs=0)
    assert asperity.loss_factor(limit) == pytest.approx(0.8 / math.pi, rel=1e-14, abs=0)
    assert asperity.damping_ratio(limit) == pytest.approx(0.4 / math.pi, rel=1e-14, abs=0)
    # Where the loop crosses T = 0 the branch has fallen by mu N, twice half of it.
    gap = limit - 2.0 * asperity.backbone_displacement(asperity.force_limit / 2)
    assert gap / limit == pytest.approx(2.0 * 0.5 ** (2 / 3) - 1.0, rel=1e-13, abs=0)
    assert gap / limit == pytest.approx(0.2599, abs=5e-5)  # D
    assert energy / (4.0 * asperity.force_limit * gap) == pytest.approx(0.7695, abs=5e-5)  # B
    assert asperity.loop(limit, samples=20001).sliding_ratio == pytest.approx(0.2599, abs=5e-5)


@all_asperities
def test_slip_limit_and_stiffness(asperity: ms.Asperity) -> None:
    """(19.12) with G* as a modulus; Mindlin's 8 a G*, chapter's G*; 2 a E*."""
    a, shear = asperity.contact_radius, asperity.pair.composite_shear_modulus
    wanted = 3.0 * asperity.friction_coefficient * asperity.normal_load / (16.0 * a * shear)
    assert asperity.slip_limit == pytest.approx(wanted, rel=4e-15, abs=0)
    assert asperity.tangential_stiffness == pytest.approx(8.0 * a * shear, rel=4e-15, abs=0)
    ratio = asperity.normal_stiffness / asperity.tangential_stiffness
    assert ratio == pytest.approx(asperity.pair.stiffness_ratio, rel=4e-15, abs=0)


def test_alike_bodies() -> None:
    """Johnson's (7.41): k_n/k_t = (2 - nu)/2(1 - nu)."""
    ratio = BALL.normal_stiffness / BALL.tangential_stiffness
    assert ratio == pytest.approx(1.67 / (2 * 0.67), rel=1e-14, abs=0)


@all_asperities
def test_it_is_the_interface_of_a_sphere(asperity: ms.Asperity) -> None:
    surface = ms.SphereOnFlat(asperity.pair, asperity.radius)
    assert asperity.surface == surface
    pressed = ms.Asperity(asperity.pair, asperity.radius, 0.3, indentation=asperity.indentation)
    assert pressed.normal_load == pytest.approx(asperity.normal_load, rel=1e-15, abs=0)
    joint = ms.Interface(surface, asperity.friction_coefficient, asperity.normal_load)
    alone = ms.AsperityPopulation(asperity.pair, [0.0], asperity.radius)
    other = ms.Interface(alone, asperity.friction_coefficient, asperity.normal_load)
    record = asperity.slip_limit * np.array([0.5, -0.2, 0.3, -0.9, 1.4, 0.0])
    for law, tolerance in ((joint, 0.0), (other, 1e-13)):
        np.testing.assert_allclose(asperity.force(record), law.force(record), rtol=tolerance)
        energies = law.dissipated_energy(np.abs(record))
        np.testing.assert_allclose(
            asperity.dissipated_energy(np.abs(record)), energies, rtol=tolerance
        )


# -- force and energy ------------------------------------------------------------------------------

SHARES = (1e-14, 1e-9, 1e-4, 0.03, 0.5, 0.97, 1.0 - 1e-9, 1.0)


def _exact_backbone(share: float) -> mp.mpf:
    return 1 - (1 - mp.mpf(share)) ** mp.mpf("1.5")


@pytest.mark.parametrize("share", SHARES)
def test_first_loading_against_high_precision(share: float) -> None:
    """(19.10) and its inverse; the digits of 1 - share are lost before they come here."""
    displacement = share * BALL.slip_limit
    with mp.workdps(40):
        wanted = float(_exact_backbone(displacement / BALL.slip_limit))
    assert BALL.backbone(displacement) / BALL.force_limit == pytest.approx(wanted, rel=4e-15, abs=0)
    if share < 0.99:
        back = BALL.backbone_displacement(BALL.backbone(displacement))
        assert back == pytest.approx(displacement, rel=1e-14, abs=0)


@pytest.mark.parametrize("share", SHARES)
def test_energy_against_high_precision(share: float) -> None:
    """The chapter's way, the force r left over, and the product that does not cancel: all one."""
    with mp.workdps(60):
        x = mp.mpf(share * BALL.slip_limit / BALL.slip_limit)
        r = 1 - _exact_backbone(float(x))
        fifth, third = mp.mpf(5), mp.mpf(3)
        first = (
            mp.mpf(24) / 5
            * (1 - r ** (fifth / third) - fifth / 6 * (1 - r) * (1 + r ** (2 / third)))
        )  # fmt: skip
        q = mp.sqrt(1 - x)
        second = mp.mpf(4) / 5 * (1 - q) ** 3 * (1 + 3 * q + q**2)
        assert abs(first / second - 1) < 1e-15
    energy = BALL.dissipated_energy(share * BALL.slip_limit)
    scale = BALL.force_limit * BALL.slip_limit
    assert energy / scale == pytest.approx(float(second), rel=1e-14, abs=0)


def test_energy_beyond_the_slip_limit() -> None:
    scale = BALL.force_limit * BALL.slip_limit
    energy = BALL.dissipated_energy(BALL.slip_limit * np.array([1.0, 1.5, 100.0]))
    np.testing.assert_allclose(energy / scale, [0.8, 2.8, 396.8], rtol=1e-14)


# -- tractions -------------------------------------------------------------------------------------


@all_asperities
@all_paths
def test_the_traction_carries_the_force(asperity: ms.Asperity, path: list[float]) -> None:
    record = asperity.slip_limit * np.array(path)
    fields = asperity.fields(record)
    assert fields.displacement == record[-1]
    assert fields.force == np.atleast_1d(asperity.force(record))[-1]
    total = area_integral(fields.traction, edges_of(fields))
    assert total == pytest.approx(fields.force, rel=0, abs=2e-14 * asperity.force_limit)
    if len(path) == 1:
        # Nearly singular at the edge if small: radii of 16 digits leave the integral 8 of them.
        assert total == pytest.approx(fields.force, rel=3e-8, abs=0)


@given(path=st.lists(moves, min_size=1, max_size=30), name=st.sampled_from(sorted(ASPERITIES)))
def test_tractions_of_any_record(path: list[float], name: str) -> None:
    asperity = ASPERITIES[name]
    record = asperity.slip_limit * np.array(path)
    fields = asperity.fields(record)
    edges = edges_of(fields)
    total = area_integral(fields.traction, edges)
    assert total == pytest.approx(fields.force, rel=0, abs=1e-13 * asperity.force_limit)
    # Coulomb's law everywhere, met where it slips.
    a = asperity.contact_radius
    r = np.concatenate([np.linspace(0.0, 1.1 * a, 301), edges])
    bound = asperity.friction_coefficient * asperity.pressure(r)
    q = fields.traction(r)
    assert np.all(np.abs(q) <= bound * (1.0 + 1e-13) + 1e-16 * bound.max())
    for zone in fields.zones:
        if zone.kind == "slip":
            inside = (r > zone.inner) & (r < zone.outer)
            np.testing.assert_allclose(q[inside], zone.direction * bound[inside], rtol=1e-15)
    assert np.all(q[r >= a] == 0.0)
    # All is odd in the record.
    mirror = asperity.fields(-record)
    np.testing.assert_array_equal(mirror.traction(r), -q)
    np.testing.assert_array_equal(mirror.slip(r), -fields.slip(r))


@given(path=st.lists(moves, min_size=1, max_size=30))
def test_zones_of_any_record(path: list[float]) -> None:
    fields = BALL.fields(BALL.slip_limit * np.array(path))
    a = BALL.contact_radius
    zones = fields.zones
    assert zones[0].inner == 0.0
    assert zones[-1].outer == a
    for first, second in pairwise(zones):
        assert first.outer == second.inner
        assert first.direction != second.direction
    order = {"stick": 0, "stuck": 1, "slip": 2}
    assert [order[zone.kind] for zone in zones] == sorted(order[zone.kind] for zone in zones)
    # What sticks now is the stick area of half the distance from the reversal.
    turns = np.cumsum(fields._factors * fields._distances)
    scale = max(1.0, max(abs(v) for v in path)) * BALL.slip_limit
    assert turns[-1] == pytest.approx(fields.displacement, rel=0, abs=1e-14 * scale)
    area = BALL.stick_area(float(fields._distances[-1]))
    assert math.pi * fields.stick_radius**2 == pytest.approx(area, rel=1e-12, abs=1e-14 * a * a)
    assert fields.unslipped_radius <= fields.stick_radius <= a


def test_cattaneo() -> None:
    """Fig. 19.2 in numbers: two Hertz tractions, and mu p in the ring that slips."""
    fields = BALL.fields(0.5 * BALL.slip_limit)
    a, c = BALL.contact_radius, fields.stick_radius
    assert c / a == pytest.approx(math.sqrt(0.5), rel=1e-15, abs=0)
    r = a * np.array([0.0, 0.3, 0.7, 0.8, 0.95])
    hertz = np.sqrt(1.0 - (r / a) ** 2)
    inner = c / a * np.sqrt(np.maximum(1.0 - (r / c) ** 2, 0.0))
    wanted = BALL.friction_coefficient * BALL.peak_pressure * (hertz - inner)
    np.testing.assert_allclose(fields.traction(r), wanted, rtol=1e-13)
    assert [zone.kind for zone in fields.zones] == ["stick", "slip"]


def test_small_forces_lose_no_digits() -> None:
    """Mindlin's traction without slip, T/2 pi a sqrt(a^2 - r^2), inside."""
    a = BALL.contact_radius
    r = a * np.array([0.0, 0.5, 0.9])
    for share in (1e-9, 1e-13):
        fields = BALL.fields(share * BALL.slip_limit)
        mindlin = fields.force / (2.0 * math.pi * a * np.sqrt(a * a - r * r))
        np.testing.assert_allclose(fields.traction(r), mindlin, rtol=10 * share + 2e-15)
        np.testing.assert_allclose(
            fields.surface_displacement(r)[0], fields.displacement, rtol=3e-15
        )


@pytest.mark.parametrize("peak", [1e-6, 0.2, 0.7, 0.99])
def test_reversed_slip(peak: float) -> None:
    """(19.18), at T = 0 as printed and in general, up to C, where all original slip is covered."""
    a, limit = BALL.contact_radius, BALL.force_limit
    c = BALL.stick_radius(force=peak * limit)
    for now in (0.6, 0.3, 0.0, -0.9, -0.999):
        fields = BALL.fields(force=limit * peak * np.array([1.0, now]))
        wanted = a * (1.0 - (1.0 - now) * peak / 2.0) ** (1 / 3)
        assert fields.reversed_slip_radius == pytest.approx(wanted, rel=1e-12, abs=0)
        assert fields.stick_radius == fields.reversed_slip_radius
        assert fields.unslipped_radius == pytest.approx(c, rel=1e-12, abs=0)
        kinds = [(zone.kind, zone.direction) for zone in fields.zones]
        assert kinds == [("stick", 0), ("stuck", 1), ("slip", -1)]
    at_zero = BALL.fields(force=[peak * limit, 0.0]).reversed_slip_radius
    assert 2.0 * (at_zero / a) ** 3 == pytest.approx(1.0 + (c / a) ** 3, rel=1e-12, abs=0)


def test_stick_radius() -> None:
    a = BALL.contact_radius
    shares = np.array([0.0, 0.3, -0.8, 1.0, 2.0])
    radii = BALL.stick_radius(shares * BALL.slip_limit)
    np.testing.assert_allclose(radii / a, np.sqrt([1.0, 0.7, 0.2, 0.0, 0.0]), rtol=1e-15)
    forces = BALL.backbone(shares * BALL.slip_limit)
    np.testing.assert_allclose(BALL.stick_radius(force=forces), radii, rtol=1e-14, atol=1e-7 * a)
    np.testing.assert_allclose(
        BALL.stick_area(shares * BALL.slip_limit), math.pi * radii**2, rtol=1e-14
    )


# -- displacements ---------------------------------------------------------------------------------


@all_asperities
@all_paths
def test_what_has_not_slipped_moves_with_the_asperity(
    asperity: ms.Asperity, path: list[float]
) -> None:
    fields = asperity.fields(asperity.slip_limit * np.array(path))
    scale = max(abs(v) for v in path) * asperity.slip_limit
    if fields.unslipped_radius > 0.0:
        r = fields.unslipped_radius * np.array([0.0, 0.3, 0.99, 1.0])
        angle = np.array([0.0, 0.7, 2.0, 5.0])
        ux, uy = fields.surface_displacement(r * np.cos(angle), r * np.sin(angle))
        np.testing.assert_allclose(ux, fields.displacement, rtol=0, atol=1e-14 * scale + 1e-300)
        np.testing.assert_allclose(uy, 0.0, rtol=0, atol=1e-14 * scale + 1e-300)
        np.testing.assert_allclose(fields.slip(r), 0.0, rtol=0, atol=1e-14 * scale + 1e-300)


@all_asperities
def test_slip_dissipates_the_energy(asperity: ms.Asperity) -> None:
    """Friction times slip over the contact: what first loading and a branch dissipate."""
    mu = asperity.friction_coefficient

    def work(first: ms.AsperityFields | None, last: ms.AsperityFields) -> float:
        def density(r: Any) -> Any:
            slip = last.slip(r) - (first.slip(r) if first is not None else 0.0)
            return mu * asperity.pressure(r) * np.abs(slip)

        # Only where it slips now has it slipped in this move.
        return area_integral(density, [last.stick_radius, asperity.contact_radius])

    for share in (0.05, 0.6, 1.0, 1.7):
        top = share * asperity.slip_limit
        loaded = asperity.fields(top)
        wanted = asperity.dissipated_energy(top) / 4.0
        # Slip is a small difference of displacements where there is little of it.
        assert work(None, loaded) == pytest.approx(wanted, rel=1e-12 / share**2, abs=0)
        for low in (0.7, -0.1, -1.0):
            back = asperity.fields([top, low * top])
            wanted = asperity.dissipated_energy((1.0 - low) * top / 2.0) / 2.0
            tolerance = 1e-11 / ((1 - low) * share) ** 3
            assert work(loaded, back) == pytest.approx(wanted, rel=tolerance, abs=0)


def chords(fields: ms.AsperityFields, body: ms.Material, x: float, y: float) -> tuple[float, float]:
    """u_x and u_y by Cerruti's kernel along all chords through a place, in polar coordinates.

    With these the kernel's 1/distance cancels, and what is left is bounded.
    """
    edges = edges_of(fields)
    away = math.hypot(x, y)
    nodes, weights = DOUBLE_EXPONENTIAL

    def chord(angle: float) -> float:
        along = x * math.cos(angle) + y * math.sin(angle)
        closest = away**2 - along**2
        marks = {0.0}
        for edge in edges[1:]:
            if edge**2 > closest:
                half = math.sqrt(edge**2 - closest)
                marks |= {max(-along - half, 0.0), max(-along + half, 0.0)}
        total = 0.0
        for low, high in pairwise(sorted(marks)):
            t = low + (high - low) * nodes
            r = np.sqrt(np.maximum(closest + (t + along) ** 2, 0.0))
            total += (high - low) * float(weights @ fields.traction(r))
        return total

    # Chords that touch a circle are where the integrand bends.
    scale = fields.asperity.peak_pressure * edges[-1]
    start = math.atan2(y, x)
    turns = [0.0, math.pi, 2.0 * math.pi]
    for edge in edges[1:]:
        if edge < away:
            lean = math.asin(edge / away)
            turns += [math.pi - lean, math.pi + lean, lean, 2.0 * math.pi - lean]
    nu = body.poisson_ratio
    results = []
    for kernel in (
        lambda v: 1.0 - nu + nu * math.cos(v) ** 2,
        lambda v: nu * math.sin(v) * math.cos(v),
    ):
        total = 0.0
        for low, high in pairwise(sorted(turns)):
            total += integrate.quad(
                lambda v, k=kernel: k(start + v) * chord(start + v),
                low, high, epsabs=1e-12 * scale, epsrel=1e-9, limit=60,
            )[0]  # fmt: skip
        results.append(total / (2.0 * math.pi * body.shear_modulus))
    return results[0], results[1]


@pytest.mark.parametrize("name", ["loading OA", "reloading BC", "gross slip"])
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.5, 0.4), (0.3, -0.85), (1.3, 0.9)], ids=str)
def test_displacement_by_cerruti(name: str, place: tuple[float, float]) -> None:
    asperity = ASPERITIES["unlike"]
    fields = asperity.fields(asperity.slip_limit * np.array(PATHS[name]))
    x, y = (v * asperity.contact_radius for v in place)
    sums = np.zeros(2)
    for body, material in (("first", AL), ("second", STEEL)):
        wanted = chords(fields, material, x, y)
        got = fields.surface_displacement(x, y, body=body)  # type: ignore[arg-type]
        np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-8 * abs(wanted[0]))
        sums += got
    np.testing.assert_allclose(fields.surface_displacement(x, y), sums, rtol=1e-13, atol=1e-25)


def reference_layer(outer: Any, inner: Any, r: Any) -> tuple[Any, Any]:
    """Both potentials over pi k in closed form, as Johnson has them; mpmath numbers."""

    def hertz(a: Any) -> tuple[Any, Any]:
        if a == 0:
            return mp.mpf(0), mp.mpf(0)
        if r <= a:
            return mp.pi / 4 * (2 * a**2 - r**2), mp.pi / 8 * r**2
        angle, root = mp.asin(a / r), a * mp.sqrt(r**2 - a**2)
        return (
            ((2 * a**2 - r**2) * angle + root) / 2,
            (r**2 / 2 * angle + root * (a**2 / r**2 - mp.mpf(1) / 2)) / 2,
        )

    whole, core = hertz(outer), hertz(inner)
    return whole[0] - core[0], whole[1] - core[1]


@pytest.mark.parametrize("removed", [1e-12, 1e-6, 0.01, 0.5, 0.99, 1.0])
def test_potentials_against_high_precision(removed: float) -> None:
    inner = math.sqrt(1.0 - removed)
    places = {
        0.0,
        1e-9,
        0.4,
        0.8 * inner,
        inner,
        0.5 * (1 + inner),
        1.0,
        1.0 + 1e-9,
        1.7,
        30.0,
        1e8,
    }
    r = np.array(sorted(places))
    phi, psi = potentials(1.0 / math.pi, 1.0, removed, r)
    # Where the ring is thin its edges are uncertain by a last place, to the root near r = a.
    tolerance = 3e-15 + 3e-16 / math.sqrt(removed)
    for i, place in enumerate(r):
        with mp.workdps(60):
            core = mp.sqrt(1 - mp.mpf(removed))
            wanted = reference_layer(mp.mpf(1), core, mp.mpf(float(place)))
            first, second = float(wanted[0]), float(wanted[1])
        assert phi[i] == pytest.approx(first, rel=tolerance, abs=0), place
        assert psi[i] == pytest.approx(second, rel=0, abs=tolerance * first), place


@pytest.mark.parametrize("name", ["loading OA", "reloading BC", "after gross slip"])
def test_far_away_it_is_a_point_force(name: str) -> None:
    asperity = ASPERITIES["unlike"]
    fields = asperity.fields(asperity.slip_limit * np.array(PATHS[name]))
    far = 1e7 * asperity.contact_radius
    for body, material in (("first", AL), ("second", STEEL)):
        nu = material.poisson_ratio
        unit = fields.force / (2.0 * math.pi * material.shear_modulus * far)
        for angle in (0.0, 0.6, 2.2):
            x, y = far * math.cos(angle), far * math.sin(angle)
            ux, uy = fields.surface_displacement(x, y, body=body)  # type: ignore[arg-type]
            wanted = unit * (1.0 - nu + nu * math.cos(angle) ** 2)
            assert ux == pytest.approx(wanted, rel=1e-12, abs=0)
            across = unit * nu * math.sin(angle) * math.cos(angle)
            assert uy == pytest.approx(across, rel=0, abs=1e-12 * abs(unit))


def test_a_rigid_body_does_not_move() -> None:
    asperity = ASPERITIES["rigid"]
    fields = asperity.fields(0.4 * asperity.slip_limit)
    x = asperity.contact_radius * np.linspace(0.0, 2.0, 5)
    assert not np.any(fields.surface_displacement(x, body="first"))
    assert not np.any(asperity.normal_displacement(x, body="first"))
    both = fields.surface_displacement(x)
    np.testing.assert_array_equal(fields.surface_displacement(x, body="second"), both)


# -- a contact of rings, step by step --------------------------------------------------------------


def disc(radius: Any, r: Any) -> Any:
    """Potential of a uniform disc: Johnson's (3.29), in elliptic integrals."""
    inner = np.minimum(r / radius, 1.0) ** 2
    outer = np.minimum(radius / r, 1.0) ** 2
    outside = (
        4.0
        * r
        * (special.ellipe(outer) - (1.0 - outer) * special.ellipk(np.minimum(outer, 1 - 1e-15)))
    )
    return np.where(r < radius, 4.0 * radius * special.ellipe(inner), outside)


def rings(count: int, path: list[float]) -> Iterator[tuple[Any, Any]]:
    """Radii and tractions over mu p0 after each move of a discrete contact, Coulomb in steps.

    Slip along the force alone, as Cattaneo and Mindlin have it, radii over a, moves over delta_L.
    """
    edges = np.linspace(0.0, 1.0, count + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    influence = disc(edges[1:], middle[:, None])
    influence[:, 1:] -= disc(edges[1:-1], middle[:, None])
    limit = np.sqrt(1.0 - middle**2)
    # In these units the slip limit gives way by the potential of mu p at the centre.
    influence /= math.pi**2 / 2.0
    traction, slip = np.zeros(count), np.zeros(count)
    for place in path:
        for _ in range(3000):
            before = traction.copy()
            for i in range(count):
                gap = place - slip[i] - influence[i] @ traction
                traction[i] = min(max(traction[i] + gap / influence[i, i], -limit[i]), limit[i])
            if np.abs(traction - before).max() < 1e-10:
                break
        slip = place - influence @ traction
        yield middle, traction.copy()


@pytest.mark.parametrize("name", ["reloading BC", "five reversals", "reloading after it"])
def test_against_a_contact_of_rings(name: str) -> None:
    """It knows no superposition, and comes to the same tractions as its rings get finer."""
    misfits = []
    for count in (12, 24):
        worst = 0.0
        for i, (r, traction) in enumerate(rings(count, PATHS[name])):
            fields = BALL.fields(BALL.slip_limit * np.array(PATHS[name][: i + 1]))
            scale = BALL.friction_coefficient * BALL.peak_pressure
            miss = fields.traction(r * BALL.contact_radius) / scale - traction
            worst = max(worst, float(np.sqrt(np.mean(miss**2))))
        misfits.append(worst)
    assert misfits[1] < 0.03
    assert misfits[1] < 0.7 * misfits[0]


# -- the chapter as printed ------------------------------------------------------------------------

# Its formulas in units of mu N and delta_L, letter by letter but for G*: the misprint of their
# unit first, then those that are left with the right slip limit. What each should be: THEORY of the
# chapter's authors is continuity at reversals, |T| <= mu N and full reversal at C.


def first_loading(x: float) -> float:
    return 1.0 - (1.0 - x) ** 1.5  # (19.10)


def unloading(x: float, peak: float, sign: float, half_inside: bool = True) -> float:
    """(19.13) with - T_max, (19.20) with + T_max; the half within the power or before it."""
    inner = x + (1.0 - peak) ** (2 / 3) + 1.0
    power = (0.5 * inner) ** 1.5 if half_inside else 0.5 * inner**1.5
    return 2.0 * (power - 1.0) + sign * peak


def reloading(x: float, shift: float, turn: float, offset: float) -> float:
    """(19.14), (19.21): what is raised there, and what is taken off."""
    inner = -0.5 * (x - shift - (1.0 - turn) ** (2 / 3) - 1.0)
    return -2.0 * (inner**1.5 - 1.0) - offset


def reduced(path: list[float]) -> float:
    forces = BALL.force(BALL.slip_limit * np.array(path))
    return float(np.atleast_1d(forces)[-1]) / BALL.force_limit


def test_printed_slip_limit() -> None:
    """(19.12) with G* the modulus of (19.11) is no length: 6e19 times too long, in N Pa/m."""
    pair = BALL.pair
    shear = pair.composite_shear_modulus
    printed = 3 / 16 * shear * BALL.force_limit / BALL.contact_radius
    assert printed / BALL.slip_limit == pytest.approx(shear**2, rel=1e-14, abs=0)
    # As a compliance, 1/G* of (19.11), it is right.
    right = 3 / 16 / shear * BALL.force_limit / BALL.contact_radius
    assert right == pytest.approx(BALL.slip_limit, rel=1e-14, abs=0)


def test_printed_unloading() -> None:
    """(19.13): unloading from 0.5 delta_L has to begin where first loading ended, and does not."""
    peak = first_loading(0.5)
    assert reduced([0.5]) == pytest.approx(peak, rel=1e-14, abs=0)
    assert unloading(0.5, peak, +1.0) == pytest.approx(peak, rel=1e-14, abs=0)
    assert unloading(0.5, peak, -1.0) == pytest.approx(-peak, rel=1e-14, abs=0)  # as printed
    outside = unloading(0.5, peak, +1.0, half_inside=False)
    assert outside - peak == pytest.approx(2**1.5 - 2.0, rel=1e-14, abs=0)  # 0.83 mu N above
    # Corrected it is the branch, down to C and its mirror there.
    for x in (0.3, 0.0, -0.4, -0.5):
        assert reduced([0.5, x]) == pytest.approx(unloading(x, peak, +1.0), rel=0, abs=1e-14)
    assert reduced([0.5, -0.5]) == pytest.approx(-peak, rel=1e-14, abs=0)


def test_printed_reloading() -> None:
    """(19.14) has its sign right: with the half inside it starts from - T_max at C."""
    peak = first_loading(0.5)
    for x in (-0.5, -0.2, 0.1, 0.5):
        wanted = reloading(x, 0.0, peak, peak)
        assert reduced([0.5, -0.5, x]) == pytest.approx(wanted, rel=0, abs=1e-14)


def test_printed_sliding() -> None:
    """(19.17) slides at - mu N after reloading; friction opposes motion: + mu N."""
    assert reduced([1.8, -1.8, 1.8]) == 1.0
    assert reduced([1.8, -1.8]) == -1.0


@pytest.mark.parametrize(("a", "b"), [(0.6, -0.2), (0.6, 0.5)])
def test_printed_variable_amplitude(a: float, b: float) -> None:
    """(19.21), (19.22) take |T_B| for - T_B: right below zero, a jump at B above it."""
    peak = first_loading(a)
    at_b = unloading(b, peak, +1.0)
    assert reduced([a, b]) == pytest.approx(at_b, rel=1e-13, abs=0)

    def continued(x: float, turn: float) -> float:
        shift = b - (-1.0 + (1.0 - turn) ** (2 / 3))
        return reloading(x, shift, turn, turn)

    assert continued(b, -at_b) == pytest.approx(at_b, rel=1e-13, abs=0)
    middle = 0.5 * (a + b)
    assert reduced([a, b, middle]) == pytest.approx(continued(middle, -at_b), rel=0, abs=1e-13)
    jump = continued(b, abs(at_b)) - at_b
    assert (abs(jump) < 1e-13) == (at_b < 0.0)
    if at_b > 0.0:
        assert jump == pytest.approx(-2.0 * at_b, rel=1e-13, abs=0)
        assert jump == pytest.approx(-1.1978, abs=5e-5)


def test_printed_formulas_end_before_a_loop_closes() -> None:
    """0.5, -0.3, then 0.9 delta_L: the branch alone gives 1.070 mu N, more than Coulomb allows."""
    at_b = unloading(-0.3, first_loading(0.5), +1.0)
    shift = -0.3 - (-1.0 + (1.0 + at_b) ** (2 / 3))
    assert reloading(0.9, shift, -at_b, -at_b) == pytest.approx(1.070, abs=5e-4)
    assert reduced([0.5, -0.3, 0.9]) == pytest.approx(0.968, abs=5e-4)
    assert reduced([0.5, -0.3, 0.9]) == pytest.approx(first_loading(0.9), rel=1e-14, abs=0)


def test_printed_reversed_slip() -> None:
    """(19.18) is the radius at T = 0 only: at C the reversed slip covers all, it does not."""
    a, peak = BALL.contact_radius, 0.7
    c = (1.0 - peak) ** (1 / 3)
    printed = (0.5 * (1.0 + c**3)) ** (1 / 3)
    limit = peak * BALL.force_limit
    zero = BALL.fields(force=[limit, 0.0]).reversed_slip_radius
    radii = np.array([zero, BALL.fields(force=[limit, -limit * (1.0 - 1e-14)]).stick_radius])
    np.testing.assert_allclose(radii / a, [printed, c], rtol=1e-13)
    assert printed - c > 0.19


def test_printed_distribution() -> None:
    """(19.26): half of erf is 0 at the mean, negative below it; and it is no density."""
    heights = ms.Gaussian(std=2.0, mean=1.0)
    y = np.array([-3.0, 1.0, 4.0])
    printed = 0.5 * special.erf((y - 1.0) / (2.0 * math.sqrt(2.0)))
    np.testing.assert_allclose(heights.cdf(y), 0.5 + printed, rtol=0, atol=1e-15)
    assert printed[0] < 0.0
    assert printed[1] == 0.0


def test_printed_damping_ratio() -> None:
    """(19.30) is the loss factor: a dashpot of ratio zeta loses 4 pi zeta U in a cycle."""
    a = 0.8 * BALL.slip_limit
    supplied = 4.0 * a * BALL.backbone(a)
    xi = 4.0 / math.pi * BALL.dissipated_energy(a) / supplied
    assert BALL.loss_factor(a) == pytest.approx(xi, rel=1e-14, abs=0)
    energy = 0.5 * a * BALL.backbone(a)
    zeta = BALL.dissipated_energy(a) / (4.0 * math.pi * energy)
    assert BALL.damping_ratio(a) == pytest.approx(zeta, rel=1e-14, abs=0)
    assert xi == pytest.approx(2.0 * zeta, rel=1e-14, abs=0)
