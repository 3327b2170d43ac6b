"""Summits that have yielded: against integrals, explicit summits, limits and published effects."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from explicit_population import ExplicitPopulation
from scipy import integrate, stats

import microslip as ms
from microslip.contact.elastic_plastic import (
    MODELS,
    flattening,
    indentation_of,
    model_of,
    recovery,
    recovery_slope,
)

ALUMINIUM = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(ALUMINIUM, ALUMINIUM)
STD = 5e-7


def surface(radius: float = 1e-3, heights: object = None) -> ms.GreenwoodWilliamson:
    return ms.GreenwoodWilliamson(
        PAIR, ms.Gaussian(STD) if heights is None else heights, radius, density=1e8, area=2e-4
    )


def yield_for(index: float, radius: float) -> float:
    """Yield stress at which the plasticity index is so large."""
    return PAIR.composite_modulus / (2.84 * index) * math.sqrt(STD / radius)


# -- one summit ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
def test_summits_meet_hertz_and_their_own_pieces(name: str) -> None:
    model = model_of(name, PAIR, 250e6)
    r = np.array([0.0, 0.3, 1.0])
    np.testing.assert_allclose(model.load_of(r), r**1.5, rtol=1e-15)
    # Fits to finite elements join within their own accuracy; a truncated sphere does not at all.
    for edge in model.edges[1:]:
        low, high = model.load_of(edge * np.array([1.0 - 1e-12, 1.0 + 1e-12]))
        assert high == pytest.approx(low, rel=0.06)
    many = model.load_of(np.geomspace(1.0 + 1e-9, 1e4, 4001))
    assert np.all(np.diff(many) > -0.002 * many[1:])


def test_jackson_and_green_by_hand() -> None:
    """Their (26)-(28), written out for steel at a hundred times the yield indentation."""
    steel = ms.Material(200e9, 0.3)
    pair, stress = ms.MaterialPair(steel, ms.Material.rigid()), 1e9
    model = model_of("jackson-green", pair, stress)
    modulus = 200e9 / (1.0 - 0.09)
    c = 1.295 * math.exp(0.736 * 0.3)
    assert model.yield_indentation == pytest.approx((math.pi * c * stress / (2 * modulus)) ** 2)
    ratio = stress / modulus
    b = 0.14 * math.exp(23 * ratio)
    contact = math.pi * c * ratio / 2 * math.sqrt(100.0 * (100.0 / 1.9) ** b)
    hardness = 2.84 * (1.0 - math.exp(-0.82 * contact**-0.7))
    wanted = (
        math.exp(-0.25 * 100 ** (5 / 12)) * 1000
        + 4 * hardness / c * (1.0 - math.exp(-(100 ** (5 / 9)) / 25)) * 100
    )
    assert float(model.load_of(np.array(100.0))) == pytest.approx(wanted, rel=1e-14)


def test_recovery_and_its_inverse() -> None:
    r = np.geomspace(1e-3, 1e6, 2001)
    residual = np.where(r > 1, r * (1 - r**-0.28) * (1 - r**-0.69), 0.0)
    np.testing.assert_allclose(recovery(r), r - residual, rtol=1e-13)
    np.testing.assert_allclose(indentation_of(recovery(r)), r, rtol=1e-13)
    step = 1e-6 * r
    slope = (recovery(r + step) - recovery(r - step)) / (2 * step)
    smooth = np.abs(r - 1.0) > 1e-2
    np.testing.assert_allclose(recovery_slope(r)[smooth], slope[smooth], rtol=1e-8)


# -- the surface -----------------------------------------------------------------------------------


def by_quadrature(law: ms.TightenedSurface, width: float) -> tuple[float, float, float]:
    """Load, contacts and area at so far above the closest separation, summit by summit."""
    model, radius = law._model, float(law.radius)
    unit, closest = model.yield_indentation * radius, law.closest_separation
    stiff = 4.0 / 3.0 * PAIR.composite_modulus * math.sqrt(radius)
    first = float(indentation_of(np.array(width / unit))) * unit
    knots = [first, *(e * unit for e in model.edges), *(k * STD - closest for k in range(-9, 10))]
    knots = sorted({k for k in knots if first <= k <= 9 * STD - closest})

    def sums(power: float, weight: int) -> float:
        def integrand(s: float) -> float:
            r = np.array(s / unit)
            depth = max(unit * float(recovery(r)) - width, 0.0)
            kept = float(flattening(model, r)) ** weight
            return float(law.heights.pdf(closest + s)) * kept * depth**power

        parts = [
            integrate.quad(integrand, a, b, epsabs=0, epsrel=1e-12, limit=200)[0]
            for a, b in pairwise(knots)
        ]
        return law.summit_count * math.fsum(parts)

    return stiff * sums(1.5, 1), sums(0.0, 0), math.pi * radius * sums(1.0, 2)


@pytest.mark.parametrize("name", MODELS)
def test_against_an_integral_over_summits(name: str) -> None:
    law = surface().tightened(5000.0, yield_stress=250e6, model=name)
    for share in (0.0, 0.2, 1.5):
        width = share * STD
        load, count, area = by_quadrature(law, width)
        d = law.closest_separation + width
        # A jump of a fit between its pieces is a root in N'', which its panels take to 1e-9.
        assert law.load(d) == pytest.approx(load, rel=1e-8)
        assert law.contact_count(d) == pytest.approx(count, rel=1e-8)
        assert law.contact_area(d) == pytest.approx(area, rel=1e-8)
    assert law.load(law.closest_separation) == pytest.approx(5000.0, rel=1e-8)


@pytest.mark.filterwarnings("ignore::scipy.integrate.IntegrationWarning")
def test_other_heights() -> None:
    for heights in (ms.Exponential(STD), stats.weibull_min(2.2, scale=1e-6)):
        law = surface(3e-4, heights).tightened(500.0, yield_stress=250e6)
        many = law.heights.span
        y = np.linspace(law.closest_separation, many[1], 500_001)
        y = 0.5 * (y[1:] + y[:-1])
        unit = law._model.yield_indentation * law.radius
        r = (y - law.closest_separation) / unit
        stiff = 4.0 / 3.0 * PAIR.composite_modulus * math.sqrt(law.radius)
        for width in (0.0, 2e-7):
            depth = np.maximum(unit * recovery(r) - width, 0.0)
            terms = law.heights.pdf(y) * flattening(law._model, r) * depth**1.5
            wanted = stiff * law.summit_count * terms.sum() * (y[1] - y[0])
            # A sum by the midpoint rule over half a million summits.
            assert law.load(law.closest_separation + width) == pytest.approx(wanted, rel=1e-7)


def test_given_summits_one_by_one() -> None:
    """Explicit asperities with the heights and radii they kept, each with a state of its own."""
    rng = np.random.default_rng(4)
    heights, radii = rng.normal(0.0, STD, 40), rng.uniform(2e-4, 2e-3, 40)
    law = ms.AsperityPopulation(PAIR, heights, radii).tightened(30.0, yield_stress=250e6)
    joint = ms.Interface(law, 0.55, normal_load=18.0)
    unit = law._model.yield_indentation * radii
    r = (heights - law.closest_separation) / unit
    kept = np.where(r > 1.0, law.closest_separation + unit * recovery(r), heights)
    flat = radii * flattening(law._model, r) ** 2
    assert np.count_nonzero(r > 1.0) > 3
    explicit = ExplicitPopulation.from_heights(
        kept,
        flat,
        composite_modulus=PAIR.composite_modulus,
        composite_shear_modulus=PAIR.composite_shear_modulus,
        friction_coefficient=0.55,
        separation=joint.separation,
    )
    assert explicit.normal_loads.sum() == pytest.approx(18.0, rel=1e-12)
    assert law.contact_count(joint.separation) == explicit.normal_loads.size
    path = 4e-7 * np.array([1.0, -0.4, 0.3, -0.4, 2.0, -3.0])
    wanted = [explicit.step(x) for x in path]
    np.testing.assert_allclose(joint.force(path), wanted, rtol=1e-11)


def test_what_never_yields_is_the_surface_itself() -> None:
    plain = surface()
    for law in (
        plain.tightened(5000.0, yield_stress=1e13),
        plain.tightened(5000.0, hardness=3e13),
    ):
        assert law.closest_separation == pytest.approx(plain.separation(5000.0), abs=1e-12 * STD)
        assert law.yielded_share == 0.0
        elastic, relieved = (ms.Interface(s, 0.55, normal_load=2000.0) for s in (plain, law))
        x = np.geomspace(1e-10, 1e-5, 30)
        np.testing.assert_allclose(relieved.backbone(x), elastic.backbone(x), rtol=1e-11)
        np.testing.assert_allclose(
            relieved.dissipated_energy(x), elastic.dissipated_energy(x), rtol=1e-9
        )


def test_effect_grows_with_the_plasticity_index() -> None:
    """k_t x1.12 at an index of 1.5 and x1.54 at 3 under the load that tightened, more relieved."""
    for index, low, high in ((1.5, 1.08, 1.16), (3.0, 1.45, 1.65)):
        plain = surface()
        law = plain.tightened(5000.0, yield_stress=yield_for(index, 1e-3))
        at = [
            ms.Interface(law, 0.55, normal_load=load).tangential_stiffness
            / ms.Interface(plain, 0.55, normal_load=load).tangential_stiffness
            for load in (5000.0, 2500.0)
        ]
        assert low < at[0] < high
        assert at[1] > 1.05 * at[0]


def test_the_engine_works_on_it() -> None:
    """A history, a varying load, cells: nothing knows that the surface was tightened."""
    law = surface().tightened(5000.0, yield_stress=250e6)
    joint = ms.Interface(law, 0.55, normal_load=2000.0)
    loop = joint.loop(1e-6, samples=4001)
    assert loop.dissipated_energy == pytest.approx(joint.dissipated_energy(1e-6), rel=1e-6)
    t = np.linspace(0.0, 4.0 * np.pi, 400)
    x, load = 3e-7 * np.sin(t), 2000.0 + 1500.0 * np.cos(t)
    force = joint.coupled_force(x, normal_load=load)
    state = joint.start()
    steps = []
    for place, now in zip(x, load, strict=True):
        steps.append(state.try_(place, normal_load=now)[0])
        state.commit()
    np.testing.assert_allclose(force, steps, rtol=0, atol=1e-9 * joint.force_limit)
    assert joint.to_iwan(30).force_limit == pytest.approx(1100.0, rel=1e-12)


def test_loads_above_the_tightening_load_tighten_anew() -> None:
    law = surface().tightened(5000.0, yield_stress=250e6)
    again = surface().tightened(5001.0, yield_stress=250e6)
    joint = ms.Interface(law, 0.55, normal_load=5001.0)
    assert (
        joint.tangential_stiffness
        == ms.Interface(again, 0.55, normal_load=5001.0).tangential_stiffness
    )
    with pytest.raises(ms.InputError, match="at most the tightening load 5000 N"):
        law.separation(5001.0)
    with pytest.raises(ms.InputError, match="that of the tightening load"):
        law.load(law.closest_separation - 1e-7)
    assert ms.Interface(law, 0.55, normal_load=5000.0).normal_load == 5000.0
