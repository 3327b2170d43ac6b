"""The explicit population by itself: each asperity against the equations of the chapter."""

import json
from itertools import pairwise
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from explicit_population import ExplicitPopulation, gaussian_population
from reference.make_reference import dominant_extremes

REFERENCE = Path(__file__).parents[1] / "reference" / "interfaces.json"
MU, LOAD, LIMIT = 0.55, 3.7, 2.3e-7
FRICTION = MU * LOAD


def single() -> ExplicitPopulation:
    return ExplicitPopulation([1e-7], [LOAD], [LIMIT], MU)


def many(count: int = 40) -> ExplicitPopulation:
    indentation = np.geomspace(1e-9, 1e-6, count)
    return ExplicitPopulation(indentation, 3e9 * indentation**1.5, 0.7 * indentation, MU)


def reference_case(name: str) -> dict:
    cases = json.loads(REFERENCE.read_text(encoding="utf-8"))["cases"]
    return next(case for case in cases if case["name"] == name)


def population_of(case: dict) -> ExplicitPopulation:
    heights, result = case["heights"], case["result"]
    return ExplicitPopulation.from_heights(
        heights.get("values", [0.0]),
        heights.get("radii", case.get("radius")),
        composite_modulus=result["composite_modulus"],
        composite_shear_modulus=result["composite_shear_modulus"],
        friction_coefficient=case["friction_coefficient"],
        separation=result["separation"],
    )


# The chapter's formulas as printed, misprints mended, x = delta / delta_L and t = T / mu N.


def loading(x):  # (19.19), (19.15)
    return 1 - max(0, 1 - x) ** 1.5


def unloading(x, t_max, delta_0=0.0):  # (19.20); (19.23) with its offset; (19.16)
    return 2 * (max(0, 0.5 * (x + delta_0 + (1 - t_max) ** (2 / 3) + 1)) ** 1.5 - 1) + t_max


def reloading(x, minus_t, delta_0=0.0):  # (19.21), (19.17)
    return -2 * (max(0, -0.5 * (x - delta_0 - (1 - minus_t) ** (2 / 3) - 1)) ** 1.5 - 1) - minus_t


@pytest.mark.parametrize(
    ("a", "b", "c", "d"),
    [
        (0.6, -0.3, 0.4, -0.2),
        (0.6, 0.5, 0.58, 0.51),  # T_B > 0, where the printed max|T_id| fails
        (0.8, -0.75, -0.6, -0.7),  # T_C < 0
        (-0.0 + 0.95, -0.9, 0.9, -0.85),
    ],
)
def test_path_oabcd(a, b, c, d):
    joint = single()
    expected, got = [], []

    def go(start, stop, formula):
        for x in np.linspace(start, stop, 7)[1:]:
            got.append(joint.step(x * LIMIT) / FRICTION)
            expected.append(formula(x))
        return expected[-1]

    t_a = go(0.0, a, loading)
    t_b = go(a, b, lambda x: unloading(x, t_a))
    offset_b = b - (-1 + (1 + t_b) ** (2 / 3))  # (19.22)
    t_c = go(b, c, lambda x: reloading(x, -t_b, offset_b))
    offset_c = (1 - (1 - t_c) ** (2 / 3)) - c  # (19.24)
    go(c, d, lambda x: unloading(x, t_c, offset_c))
    assert np.sign(t_b) == np.sign(0.2 - (a - b))
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("peak", [1.0, 1.4, 25.0])
def test_total_slip(peak):
    """(19.15)-(19.17): after sliding the loop shifts by delta_0 = delta_max - delta_L."""
    joint = single()
    x = np.concatenate([np.linspace(0, peak, 30), np.linspace(peak, -peak, 30)])
    x = np.concatenate([x, np.linspace(-peak, peak, 30)])
    delta_0 = peak - 1
    expected = np.concatenate(
        [
            [loading(v) for v in x[:30]],
            [unloading(v, 1.0, -delta_0) if v > delta_0 - 1 else -1 for v in x[30:60]],
            [reloading(v, 1.0, -delta_0) if v < 1 - delta_0 else 1 for v in x[60:]],
        ]
    )
    got = joint.force(x * LIMIT) / FRICTION
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-13 * peak)
    assert np.all(np.abs(got) <= 1 + 1e-15)


def test_single_asperity_against_masing_in_high_precision():
    rng = np.random.default_rng(20)
    history = LIMIT * rng.uniform(-1, 1, 300) * np.repeat([0.5, 0.95, 1.3, 0.7], 75)
    history[40:60:3] = history[38:58:3]
    with mp.workdps(30):
        exact = [mp.mpf(x) for x in history]

        def backbone(x):
            return FRICTION * (1 - max(0, 1 - x / mp.mpf(LIMIT)) ** 1.5)

        expected = []
        for i in range(len(exact)):
            memory = dominant_extremes(exact[: i + 1])
            force = mp.sign(memory[0]) * backbone(abs(memory[0]))
            for start, end in pairwise(memory):
                force += 2 * mp.sign(end - start) * backbone(abs(end - start) / 2)
            expected.append(float(force))
    np.testing.assert_allclose(single().force(history), expected, rtol=0, atol=1e-13 * FRICTION)


def test_states_differ_and_add():
    history = 1e-7 * np.array([1.0, -0.6, 0.8, -0.3, 0.5, 0.1, 0.4, 0.2, 0.35, 0.3, 0.31, -0.55, 4])
    joint = many()
    total = np.zeros_like(history)
    for load, limit in zip(joint.normal_loads, joint.slip_limits, strict=True):
        total += ExplicitPopulation([1.0], [load], [limit], MU).force(history)
    np.testing.assert_allclose(joint.force(history), total, rtol=0, atol=1e-14 * joint.force_limit)
    joint.force(history[:11])
    assert set(joint.open_reversals) >= {1, 2, 10}
    assert 0 < joint.has_slid.sum() < joint.contact_count
    assert joint.asperity_forces.sum() == pytest.approx(total[10], rel=1e-12, abs=0)


@pytest.mark.parametrize("name", ["sphere", "seven-summits"])
def test_against_reference(name):
    case = reference_case(name)
    result, joint = case["result"], population_of(case)
    assert joint.contact_count == result["contact_count"]
    assert joint.normal_load == pytest.approx(result["normal_load"], rel=1e-14, abs=0)
    for record in ("history", "settled_cycle"):
        path, forces = result[record]["displacement"], result[record]["force"]
        if record == "settled_cycle":
            path = path * 2
        got = joint.force(path)[-len(forces) :]
        np.testing.assert_allclose(got, forces, rtol=0, atol=1e-14 * joint.force_limit)
    rows = result["amplitudes"]
    np.testing.assert_allclose(
        joint.dissipated_energy(rows["displacement"]), rows["dissipated_energy"], rtol=1e-13
    )


@pytest.mark.parametrize(
    ("ratio", "tolerance"), [(1e-2, 1e-9), (0.5, 1e-12), (0.9, 1e-12), (1.0, 1e-8), (3.0, 1e-8)]
)
def test_energy_is_the_loop_area(ratio, tolerance):
    """(19.29), each branch by Gauss points, on either side of where it starts to slide."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    area = 0.0
    for sense in (-1, 1):
        slip = min(2 - ratio, ratio)
        for start, end in ((-ratio, slip), (slip, ratio)):
            half, middle = (end - start) / 2 * LIMIT, (end + start) / 2 * LIMIT
            path = [-sense * ratio * LIMIT, *(sense * (middle + half * nodes))]
            if sense > 0:
                path.insert(0, ratio * LIMIT)
            area += sense * half * (weights @ single().force(path)[-nodes.size :])
    np.testing.assert_allclose(single().dissipated_energy(ratio * LIMIT), area, rtol=tolerance)


@pytest.mark.parametrize("ratio", [1e-9, 1e-5, 0.03, 0.4, 0.999, 1.0, 1.7])
def test_energy_against_the_formula_in_high_precision(ratio):
    with mp.workdps(60):
        x = min(mp.mpf(ratio * LIMIT) / mp.mpf(LIMIT), mp.mpf(1))
        r = (1 - x) ** mp.mpf(1.5)
        brace = 1 - r ** (mp.mpf(5) / 3) - mp.mpf(5) / 6 * (1 - r) * (1 + r ** (mp.mpf(2) / 3))
        energy = mp.mpf(24) / 5 * brace + 4 * max(mp.mpf(ratio * LIMIT) / mp.mpf(LIMIT) - 1, 0)
        expected = float(energy * FRICTION * LIMIT)
    np.testing.assert_allclose(single().dissipated_energy(ratio * LIMIT), expected, rtol=2e-14)


def test_quantile_population_converges_at_first_order():
    """To the statistical law: load, force and energy of the reference interface."""
    case = reference_case("gaussian-al2017")
    result, std = case["result"], case["heights"]["std"]
    row = result["amplitudes"]["displacement"].index(1.7e-7)
    goal = [
        result["normal_load"],
        result["amplitudes"]["backbone"][row],
        result["amplitudes"]["dissipated_energy"][row],
    ]
    counts = np.array([500, 5000, 50000])
    errors = []
    for count in counts:
        heights, probability = gaussian_population(
            int(count), std=std, separation=result["separation"]
        )
        summits = case["density"] * case["area"] * probability
        assert summits == pytest.approx(result["contact_count"], rel=1e-13, abs=0)
        joint = ExplicitPopulation.from_heights(
            heights,
            case["radius"],
            composite_modulus=result["composite_modulus"],
            composite_shear_modulus=result["composite_shear_modulus"],
            friction_coefficient=case["friction_coefficient"],
            separation=result["separation"],
            summits_per_height=summits / count,
        )
        energy = joint.dissipated_energy(1.7e-7)
        got = np.array([joint.normal_load, joint.step(1.7e-7), energy])
        errors.append(np.abs(got / goal - 1))
    order = np.log(errors[0] / np.array(errors[1:])) / np.log(counts[1:] / counts[0])[:, None]
    assert np.all((order > 0.95) & (order < 1.25)), order
    assert np.all(errors[-1] < [1e-5, 1e-6, 1e-7])


def test_quantile_population_without_a_cut_is_symmetric():
    heights, probability = gaussian_population(1001, std=2e-6, mean=1e-7)
    assert probability == 1.0
    assert np.all(np.diff(heights) > 0)
    np.testing.assert_allclose(heights + heights[::-1], 2e-7, rtol=0, atol=1e-19)
