"""The interface in closed form against asperities that each follow the chapter by themselves."""

from itertools import pairwise

import numpy as np
import pytest
from cases import reach_of, records
from explicit_population import ExplicitPopulation, gaussian_population
from hypothesis import given
from usual import rough

import microslip as ms

STEEL = ms.Material(young_modulus=208e9, poisson_ratio=0.29)
ALUMINIUM = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
PAIR = ms.MaterialPair(STEEL, ALUMINIUM)
MU = 0.37
# Of the force limit: each asperity rounds its own sum of a branch and an offset.
ROUNDING = 1e-13


def summits(count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(scale=4e-7, size=count), rng.uniform(2e-4, 3e-3, count)


def explicit_of(joint, heights, radii, each=1.0):
    pair = joint.surface.pair
    return ExplicitPopulation.from_heights(
        heights,
        radii,
        composite_modulus=pair.composite_modulus,
        composite_shear_modulus=pair.composite_shear_modulus,
        friction_coefficient=joint.friction_coefficient,
        separation=joint.separation,
        summits_per_height=each,
    )


def population(count=150, seed=0, share=0.3):
    """A joint of given summits and its explicit double, a share of the summits not touching."""
    heights, radii = summits(count, seed)
    surface = ms.AsperityPopulation(PAIR, heights, radii)
    joint = ms.Interface(surface, MU, separation=float(np.quantile(heights, share)))
    return joint, explicit_of(joint, heights, radii)


JOINT, EXPLICIT = population()
REACH = reach_of(JOINT)


def agree(got, wanted, joint=JOINT, tolerance=ROUNDING):
    np.testing.assert_allclose(got, wanted, rtol=0, atol=tolerance * joint.force_limit)


def test_at_rest():
    assert JOINT.contact_count == EXPLICIT.contact_count < 150
    assert JOINT.normal_load == pytest.approx(EXPLICIT.normal_load, rel=1e-14, abs=0)
    assert JOINT.force_limit == pytest.approx(EXPLICIT.force_limit, rel=1e-14, abs=0)
    # Of (19.12) and of kappa s: the slip limits are the same.
    indentation = np.asarray(JOINT.surface.heights) - JOINT.separation
    touching = indentation > 0
    np.testing.assert_allclose(
        EXPLICIT.slip_limits, JOINT.slip_per_indentation * indentation[touching], rtol=1e-14
    )


@pytest.mark.parametrize("size", [0.05, 0.5, 2.0, 10.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_random_history(size, seed):
    x = size * REACH * np.random.default_rng(seed).normal(size=300)
    agree(JOINT.force(x), EXPLICIT.force(x))


def test_minor_loops():
    """Nested ones, closed exactly, passed by, cut short and begun anew, with gross slip between."""
    steps = [
        *(0.2, 0.55, 0.55, 0.3, 0.35, 0.31, 0.35, 0.4, 0.1, -0.2, 0.15, -0.05, 0.15, 0.4, 0.55),
        *(0.7, 0.2, -0.7, -0.7, -0.9, -0.4, -0.4 - 2e-9, -0.4, -0.6, 0.9, 0.5, 0.8, 0.6, 0.75),
        *(0.65, 0.7, 0.95, 1.6, 1.6, -0.5, -1.3, 0.4, -1.6, -2.2, 1.0, 0.0, 0.0, 2.2, -9.0, 3.0),
        *(4.0, 0.0, -0.3, -0.1, -0.2, -0.15, -0.3, 4.0, -20.0, 20.0, 20.0, 19.9, 20.0, 0.0),
    ]
    x = REACH * np.array(steps)
    agree(JOINT.force(x), EXPLICIT.force(x))
    shrinking = REACH * (-1.0) ** np.arange(60) * np.linspace(3, 0, 60)
    path = np.concatenate((shrinking, shrinking[::-1], [0.0, 5 * REACH, -0.1 * REACH]))
    agree(JOINT.force(path), EXPLICIT.force(path))


@given(x=records(max_size=40))
def test_any_history(x):
    x = x * REACH
    agree(JOINT.force(x), EXPLICIT.force(x))


@pytest.mark.parametrize("seed", range(4))
def test_other_populations_and_loads(seed):
    joint, explicit = population(count=40 + 17 * seed, seed=seed + 10, share=0.97 - 0.3 * seed)
    x = reach_of(joint) * np.random.default_rng(seed).normal(size=120)
    agree(joint.force(x), explicit.force(x), joint)
    a = reach_of(joint) * np.geomspace(1e-9, 50, 60)
    np.testing.assert_allclose(
        joint.dissipated_energy(a), explicit.dissipated_energy(a), rtol=1e-13
    )


def test_heights_as_equal_atoms():
    """A rough surface of given heights: density x area summits shared out among them."""
    heights = summits(60, seed=3)[0]
    surface = ms.GreenwoodWilliamson(PAIR, heights, radius=7e-4, density=3e7, area=1e-4)
    joint = ms.Interface(surface, MU, normal_load=150.0)
    explicit = explicit_of(joint, heights, 7e-4, each=3000.0 / 60)
    assert joint.normal_load == pytest.approx(explicit.normal_load, rel=1e-13, abs=0)
    assert joint.contact_count == pytest.approx(explicit.contact_count * 50, rel=1e-14, abs=0)
    x = reach_of(joint) * np.random.default_rng(4).normal(size=150)
    agree(joint.force(x), explicit.force(x), joint)


def test_energy():
    a = REACH * np.concatenate((np.geomspace(1e-12, 100, 80), [1e4]))
    np.testing.assert_allclose(
        JOINT.dissipated_energy(a), EXPLICIT.dissipated_energy(a), rtol=1e-13
    )
    # Loss factor and damping ratio from the explicit loop's own peak.
    force = EXPLICIT.force(np.array([0.8 * REACH]))[0]
    energy = EXPLICIT.dissipated_energy(0.8 * REACH)
    assert JOINT.loss_factor(0.8 * REACH) == pytest.approx(
        energy / (np.pi * 0.8 * REACH * force), rel=1e-13, abs=0
    )
    assert JOINT.damping_ratio(0.8 * REACH) == pytest.approx(
        energy / (2 * np.pi * 0.8 * REACH * force), rel=1e-13, abs=0
    )


def test_energy_of_a_minor_loop_is_explicit_work():
    """Between 0.9 and 0.1: half the range counts, wherever the loop lies. Simpson in pieces."""
    loop = REACH * np.concatenate((np.linspace(0.9, 0.1, 4001), np.linspace(0.1, 0.9, 4001)[1:]))
    path = np.concatenate((REACH * np.array([2.0, -0.3]), loop))
    force = EXPLICIT.force(path)[2:]
    work = 0.0
    for part in (slice(0, 4001), slice(4000, 8001)):
        x, t = loop[part], force[part]
        work += float(np.sum(t[:-2:2] + 4 * t[1:-1:2] + t[2::2])) * (x[2] - x[0]) / 6
    assert work == pytest.approx(JOINT.dissipated_energy(0.4 * REACH), rel=1e-6, abs=0)


# Towards the statistical law

GAUSSIAN = ms.Interface(
    rough(ms.Gaussian(5e-7), PAIR),
    MU,
    normal_load=1500.0,
)
PATH = 4e-7 * np.array([0.3, 1, 0.2, 0.6, -0.8, -0.3, -0.7, 0.4, 1.4, -1.4, 0.1, -0.2, 6, 0.0])


def quantiles(count):
    """The Gaussian surface by `count` heights without chance, each for equally many summits."""
    heights, probability = gaussian_population(
        count, std=5e-7, separation=float(GAUSSIAN.separation)
    )
    return explicit_of(GAUSSIAN, heights, 1e-3, each=20_000 * probability / count)


def test_quantile_population_converges():
    """First order in the number of heights, for every sample of a history and for the energy."""
    counts = (300, 1200, 4800, 19_200)
    amplitudes = 5e-7 * np.array([0.02, 0.3, 2.0, 30.0])
    errors, energy_errors = [], []
    for count in counts:
        explicit = quantiles(count)
        got, wanted = explicit.force(PATH), GAUSSIAN.force(PATH)
        errors.append(np.abs(got - wanted).max() / GAUSSIAN.force_limit)
        ratio = explicit.dissipated_energy(amplitudes) / GAUSSIAN.dissipated_energy(amplitudes)
        energy_errors.append(np.abs(ratio[1:] - 1).max())
        assert explicit.normal_load == pytest.approx(1500.0, rel=3 / count, abs=0)
    for series in (errors, energy_errors):
        order = [np.log(a / b) / np.log(4) for a, b in pairwise(series)]
        assert all(0.9 < value < 1.5 for value in order), order
        assert series[-1] < 3e-5


def test_random_population_is_within_its_scatter():
    """Heights by chance: unbiased, with the scatter that the population itself states."""
    rng = np.random.default_rng(11)
    sizes, deviations = (400, 6400), []
    for size in sizes:
        draws = []
        for _ in range(40):
            explicit = explicit_of(
                GAUSSIAN, rng.normal(scale=5e-7, size=size), 1e-3, each=20_000 / size
            )
            draws.append([explicit.normal_load / 1500.0, *(explicit.force(PATH[:6]))])
        got = np.array(draws) - [1.0, *GAUSSIAN.force(PATH[:6])]
        scatter = got.std(axis=0, ddof=1)
        # The mean of 40 lies within four of its standard errors (one in 16 000 does not).
        assert np.all(np.abs(got.mean(axis=0)) < 4 * scatter / np.sqrt(40))
        deviations.append(scatter)
    # Sixteen times the summits, a quarter of the scatter.
    np.testing.assert_allclose(deviations[0] / deviations[1], 4, rtol=0.45)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_long_random_histories(seed):
    joint, explicit = population(count=2000, seed=seed, share=0.2 + 0.1 * seed)
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=3000) * np.repeat(rng.uniform(0.01, 5, 30), 100)
    x = reach_of(joint) * np.concatenate((noise, np.cumsum(noise) * 0.05, np.round(noise * 4) / 4))
    agree(joint.force(x), explicit.force(x), joint, 1e-12)
