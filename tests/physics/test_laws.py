"""The laws that the model is compared with: references, other methods, invariants."""

from __future__ import annotations

import json
import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from cases import REFERENCE, law_params, reach_of, records
from hypothesis import given
from sliders import stops

import microslip as ms

# A few roundings; an energy next to a corner knows a - y only as well as its y.
ROUNDING = 4e-15
NEXT_TO_CORNERS = 2e-13

RIGID = ms.Coulomb(force_limit=100.0)
CASES = json.loads((REFERENCE / "laws.json").read_text(encoding="utf-8"))["cases"]


def cases_of(*laws: str) -> list[Any]:
    return [
        pytest.param(case, id=f"{case['law']}-{i}")
        for i, case in enumerate(CASES)
        if case["law"] in laws
    ]


def law_of(case: dict[str, Any]) -> Any:
    return getattr(ms, case["law"])(**case["parameters"])


# -- high precision --------------------------------------------------------------------------------


@pytest.mark.parametrize("case", cases_of("SegalmanIwan", "Iwan"))
def test_iwan_laws_against_high_precision(case):
    law, x = law_of(case), np.array(case["displacement"])
    np.testing.assert_allclose(law.backbone(x), case["backbone"], rtol=ROUNDING)
    np.testing.assert_allclose(law.backbone_stiffness(x), case["slope"], rtol=ROUNDING)
    corners = NEXT_TO_CORNERS if case["law"] == "Iwan" else ROUNDING
    np.testing.assert_allclose(law.dissipated_energy(x), case["energy"], rtol=corners)
    if case["law"] == "SegalmanIwan":
        wanted = case["slip_displacement"]
        assert law.slip_displacement == pytest.approx(wanted, rel=ROUNDING, abs=0)
    force = np.array(case["backbone"])
    below = force < 0.99 * law.force_limit
    # Where the curve is flat a rounding of the force is a large displacement.
    doubt = ROUNDING * (x[below] + force[below] / np.array(case["slope"])[below])
    back = law.backbone_displacement(force[below])
    assert np.all(np.abs(back - x[below]) <= doubt)


@pytest.mark.parametrize("case", cases_of("Iwan"))
def test_cells_one_by_one_are_jenkins(case):
    """A parallel model is the sum of its cells."""
    law, x = law_of(case), np.array(case["displacement"])
    cells = [ms.Jenkins(k, f) for k, f in zip(*case["parameters"].values(), strict=True)]
    for name in ("backbone", "dissipated_energy", "backbone_stiffness"):
        total = sum(getattr(cell, name)(x) for cell in cells)
        np.testing.assert_allclose(getattr(law, name)(x), total, rtol=NEXT_TO_CORNERS)
    record = np.array([1.0, -0.3, 0.8, 0.8, -2.5, 0.0, 1.7, -0.1]) * reach_of(law)
    total = sum(cell.force(record) for cell in cells)
    np.testing.assert_allclose(law.force(record), total, atol=1e-14 * law.force_limit)


# -- other methods ---------------------------------------------------------------------------------


def sampled(law: ms.BackboneLaw) -> tuple[np.ndarray, np.ndarray, float]:
    """Sliders of a law, those that are spread as points, and the error of that, of the limit."""
    sliders = law.sliders()
    if not isinstance(law, ms.SegalmanIwan):
        return sliders.stiffnesses, sliders.yield_displacements, 1e-14
    count, p, phi = 4000, 1 + law.chi, law.slip_displacement
    # In u^p the sliders are even.
    places = phi * ((np.arange(count) + 0.5) / count) ** (1 / p)
    spread = np.full(count, law.stiffness / (1 + law.beta) / count)
    return (
        np.append(spread, sliders.stiffnesses),
        np.append(places, sliders.yield_displacements),
        1e-5,
    )


ELASTIC_PLASTIC = law_params(which=lambda law: isinstance(law, ms.Iwan | ms.Jenkins))
SLIDERS = [
    *ELASTIC_PLASTIC,
    *law_params(which=lambda law: isinstance(law, ms.SegalmanIwan)),
]


@pytest.mark.parametrize("law", SLIDERS)
@given(x=records(max_size=25))
def test_histories_of_sliders(law, x):
    """No memory rules: every slider is followed by itself."""
    path = np.clip(x, -30, 30) * reach_of(law)
    stiffnesses, yields, error = sampled(law)
    wanted, _ = stops(path, stiffnesses, yields)
    np.testing.assert_allclose(law.force(path), wanted, rtol=0, atol=error * law.force_limit)


@pytest.mark.parametrize("law", SLIDERS)
@pytest.mark.parametrize("share", [0.3, 1.2, 4.0])
def test_energies_of_sliders(law, share):
    """Friction in the sliders over a settled cycle, and over a cycle about another mean."""
    a = share * reach_of(law)
    stiffnesses, yields, error = sampled(law)
    for mean in (0.0, 0.6 * a):
        path = mean + a * np.array([1.0, -1.0, 1.0, -1.0, 1.0])
        _, lost = stops(path, stiffnesses, yields)
        energy, size = law.dissipated_energy(a), 4 * a * law.force_limit
        assert lost[-1] - lost[-3] == pytest.approx(energy, rel=1e-12, abs=10 * error * size)


def test_many_random_cells():
    """Prefix sums of 200 000 unlike cells against plain sums."""
    rng = np.random.default_rng(11)
    stiffnesses = rng.lognormal(10, 2, 200_000)
    yields = rng.lognormal(-13, 1.5, 200_000)
    law = ms.Iwan(stiffnesses, stiffnesses * yields)
    for u in np.quantile(yields, [0.0, 0.01, 0.5, 0.9, 1.0]) * 1.0001:
        parts = stiffnesses * np.minimum(u, yields)
        assert law.backbone(u) == pytest.approx(math.fsum(parts), rel=ROUNDING, abs=0)
        sticking = math.fsum(stiffnesses[yields > u])
        assert law.backbone_stiffness(u) == pytest.approx(sticking, rel=ROUNDING, abs=0)
        lost = 4 * math.fsum(stiffnesses * yields * np.maximum(u - yields, 0))
        assert law.dissipated_energy(u) == pytest.approx(lost, rel=1e-11, abs=0)
    force = np.linspace(-0.9999, 0.9999, 4001) * law.force_limit
    np.testing.assert_allclose(law.backbone(law.backbone_displacement(force)), force, rtol=1e-14)


class SmoothStep(ms.BackboneLaw):
    """A law of a user's own with no energy of its own: cycles go like a^4 when small."""

    force_limit = 100.0

    def _backbone(self, u: np.ndarray) -> np.ndarray:
        return 100.0 * np.tanh(u * 1e6)

    def _slope(self, u: np.ndarray) -> np.ndarray:
        return 1e8 / np.cosh(np.minimum(u * 1e6, 300.0)) ** 2


def test_default_energy_ends_where_rounding_begins():
    """What it integrates is a difference of numbers that become equal: 1e-16 of T0, at best."""
    law = SmoothStep()
    for x, error in ((3.0, 1e-14), (0.1, 1e-13), (1e-2, 1e-11), (1e-3, 1e-9), (1e-5, 1e-4)):
        with mp.workdps(60):
            v = mp.mpf(1e-6 * x) * mp.mpf(1e6)
            wanted = float(8e-4 * mp.log(mp.cosh(v)) - 4e-4 * v * mp.tanh(v))
        assert law.dissipated_energy(1e-6 * x) == pytest.approx(wanted, rel=error, abs=0)
    a = 1e-6 * np.array([1e-15, 1e-12, 1e-9])
    tiny = law.dissipated_energy(a)
    assert np.all((tiny >= 0) & (tiny <= 4e-15 * a * law.backbone(a)))


# -- invariants ------------------------------------------------------------------------------------


@pytest.mark.parametrize("chi", [-0.9, -0.5, 0.0, 1.5])
def test_small_cycles_of_segalman(chi):
    """E_d goes like a^(3 + chi) up to the limit, exactly."""
    law = ms.SegalmanIwan(100.0, 1e7, chi, 0.3)
    a = law.slip_displacement * np.array([1e-30, 1e-12, 1e-4, 0.5, 1.0])
    energy = law.dissipated_energy(a)
    np.testing.assert_allclose(energy / energy[-1], (a / a[-1]) ** (3 + chi), rtol=1e-13)
    np.testing.assert_allclose(law.dissipation_exponent(a[:-1]), 3 + chi, rtol=1e-14)


def test_limits_of_segalman():
    """A heavy last slider is Jenkins' cell; none and an even density is the parabola of chi = 0."""
    jenkins = ms.Jenkins(1e7, 100.0)
    u = np.linspace(0, 3e-5, 301)
    for beta in (1e3, 1e6, 1e9):
        law = ms.SegalmanIwan(100.0, 1e7, -0.5, beta)
        assert law.slip_displacement == pytest.approx(1e-5, rel=1 / beta, abs=0)
        assert np.abs(law.backbone(u) - jenkins.backbone(u)).max() < 100 / beta
        energy = jenkins.dissipated_energy(u)
        assert np.abs(law.dissipated_energy(u) - energy).max() < 4 * 100 * 3e-5 / beta
    steep = ms.SegalmanIwan(100.0, 1e7, 1e6, 0.0)
    assert np.abs(steep.backbone(u) - jenkins.backbone(u)).max() < 1e-3


def test_stiff_cells_become_coulomb():
    coulomb, x = ms.Coulomb(100.0), 1e-6 * np.array([1.0, 3.0, -2.0, -1.0, -1.0, 0.5])
    for stiffness in (1e10, 1e13, 1e16):
        law = ms.Jenkins(stiffness, 100.0)
        np.testing.assert_array_equal(law.force(x), coulomb.force(x))
        a = 1e-6
        missing = 1 - law.dissipated_energy(a) / coulomb.dissipated_energy(a)
        assert missing == pytest.approx(100.0 / stiffness / a, rel=1e-6, abs=1e-16)


# -- Coulomb: rigid --------------------------------------------------------------------------------


def test_coulomb_backbone() -> None:
    np.testing.assert_array_equal(
        RIGID.backbone([0.0, -0.0, 1e-300, -1e-12, 5.0]), [0.0, -0.0, 100.0, -100.0, 100.0]
    )
    np.testing.assert_array_equal(RIGID.backbone_stiffness([0.0, 1e-12]), [math.inf, 0.0])
    assert RIGID.tangential_stiffness == math.inf
    np.testing.assert_array_equal(RIGID.secant_stiffness([0.0, 1e-6]), [math.inf, 1e8])


def test_coulomb_in_a_solver() -> None:
    state = RIGID.start()
    assert state.try_(0.0) == (0.0, math.inf)
    assert state.try_(1e-9) == (100.0, 0.0)
    state.commit()
    assert state.try_(1e-9) == (100.0, 0.0)
    assert state.try_(0.5e-9) == (-100.0, 0.0)
    state.commit()
    assert (state.force, state.displacement, state.open_reversals) == (-100.0, 0.5e-9, 1)
    assert state.advance([0.6e-9, 0.6e-9, 2e-9]).tolist() == [100.0] * 3
    response = RIGID.periodic([0.0, 1e-6, 0.0, -1e-6])
    assert response.force.tolist() == [100.0, 100.0, -100.0, -100.0]
    assert response.stiffness.tolist() == [0.0] * 4
