"""Harmonics under separations that vary, on laws with ends, summits and knots: without samples."""

import numpy as np
import pytest
from scipy import stats
from usual import PAIR, SURFACE, rough, slope

import microslip as ms

SUMMITS = np.random.default_rng(7).normal(size=40) * 5e-7
BETA = ms.Statistical(stats.beta(3.0, 4.0, loc=-1e-6, scale=2.5e-6))
STEPS = np.linspace(0.0, 1.5e-6, 16)

SURFACES = {
    "sphere": (ms.SphereOnFlat(PAIR, 1e-3), 3.0),
    "summits": (ms.AsperityPopulation(PAIR, SUMMITS, 1e-3), 10.0),
    "uniform": (rough(ms.TabulatedHeights([-8e-7, 8e-7], [1.0, 1.0])), 100.0),
    "beta": (rough(BETA), 100.0),
    "table": (ms.TabulatedNormalLaw(PAIR, STEPS, 400.0 * (1.0 - STEPS / 1.5e-6) ** 3), 60.0),
    # Its load falls steeply at the end: N' jumps there.
    "jump": (ms.TabulatedNormalLaw(PAIR, STEPS, 400.0 * (1.0 - STEPS / 1.5e-6)), 60.0),
    "gaussian": (SURFACE, 100.0),
}


def field_on(name):
    surface, load = SURFACES[name]
    return ms.JointField(surface, 0.5, areas=[1.0], loads=[load], surface_area=1.0)


def motions(field, seed, count=3):
    """Coefficients of (0, 1, 2) that turn, stick, slip, and part the contact now and then."""
    rng = np.random.default_rng(seed)
    top = min(field._nodes.curve.parting() + field._nodes.curve.origin, 1.0)
    load, slope = field.load(field.separations)
    length = min(float(load[0] / -slope[0]), 0.6 * (top - float(field.separations[0])))
    slip = float(field._nodes.slips[0])
    for _ in range(count):
        x = rng.normal(size=(1, 5)) * length * slip
        d = rng.normal(size=(1, 5)) * length * 0.3
        d[0, 0] = field.separations[0] + 0.1 * length * rng.normal()
        yield x, d


def waves(t):
    return np.stack([np.ones_like(t), np.cos(t), np.sin(t), np.cos(2 * t), np.sin(2 * t)], axis=-1)


def crossings(row, levels):
    """Times at which a trigonometric sum meets levels, by bisection between dense samples."""
    t = np.linspace(0.0, 2 * np.pi, 4097)
    times = []
    for level in levels:
        value = waves(t) @ row - level
        between = np.flatnonzero(value[:-1] * value[1:] < 0.0)
        low, high = t[between], t[between + 1]
        for _ in range(60):
            middle = 0.5 * (low + high)
            same = (waves(middle) @ row - level) * value[between] > 0.0
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        times += (0.5 * (low + high)).tolist()
    return times


def dense(field, x, d, parts):
    """Coefficients of the force by stepped cycles: no line of the code under test.

    Nodes in time include the turning points of d + x/kappa and d - x/kappa and the times at which
    the separation passes an end or a summit; between them they crowd towards both ends, so that
    the trapezoidal rule converges quickly.
    """
    slip = field._nodes.slips[0]
    turns = []
    for row in (d[0] + x[0] / slip, d[0] - x[0] / slip):
        rate = np.array([0.0, row[2], -row[1], 2 * row[4], -2 * row[3]])
        turns += crossings(rate, [0.0])
    surface = field.surface
    heights = np.zeros(0) if surface._spheres is None else surface._spheres.heights
    marks = np.unique(np.concatenate((surface._kinks, heights, [surface._top])))
    edges = np.unique(turns + crossings(d[0], marks[np.isfinite(marks)]))
    edges = np.append(edges, edges[0] + 2 * np.pi)
    s = np.arange(parts) / parts
    shares = s - np.sin(2 * np.pi * s) / (2 * np.pi)
    rates = (1 - np.cos(2 * np.pi * s)) / parts
    t = (edges[:-1, None] + np.diff(edges)[:, None] * shares).ravel()
    weights = (np.diff(edges)[:, None] * rates).ravel()
    cycle = field.periodic((waves(t) @ x[0])[None], (waves(t) @ d[0])[None])
    sums = (weights * cycle.force[0]) @ waves(t)
    return sums / np.where(np.arange(5) == 0, 2 * np.pi, np.pi)


@pytest.mark.parametrize("name", SURFACES)
def test_coefficients_are_those_of_a_dense_cycle(name):
    field = field_on(name)
    few = 2000 if name in ("summits", "table") else 8000
    # Where N' jumps, a front that passes within a step leaves more of an error in the dense cycle.
    most = 3e-9 if name == "jump" else 1e-9
    for x, d in motions(field, 3):
        found = field.harmonics(x, (0, 1, 2), separations=d, rtol=1e-12)
        coarse, fine = (dense(field, x, d, parts) for parts in (few, 2 * few))
        reference = (4.0 * fine - coarse) / 3.0  # steps are straight: errors of second order
        size = np.abs(reference).max()
        assert np.abs(found.force[0] - reference).max() <= most * size
        assert (found.residual <= 3e-12 * size).all()


@pytest.mark.parametrize("name", SURFACES)
def test_errors_are_below_their_estimate_and_the_tolerance(name):
    """The motion along the contact may be a thousand times smaller than that of the separation."""
    field, rng = field_on(name), np.random.default_rng(45)
    flags = []
    for _ in range(40):
        orders = tuple(range(int(rng.integers(2, 8))))
        size = 2 * len(orders) - 1
        x, d = (rng.normal(0.0, rng.choice([1e-9, 1e-8, 1e-7]), (1, size)) for _ in range(2))
        d[:, 0] = field.separations
        found, best = (
            field.harmonics(x, orders, separations=d, rtol=rtol) for rtol in (1e-10, 1e-13)
        )
        error = np.abs(found.force - best.force).max()
        t = np.arange(256) * 2.0 * np.pi / 256
        rows = [np.ones(256), *(f(k * t) for k in orders[1:] for f in (np.cos, np.sin))]
        peak = np.abs(field.periodic(x @ np.array(rows), d @ np.array(rows)).force).max()
        flags.append(found.converged[0])
        assert error <= max(found.residual[0], 1e-13 * peak)
        assert error <= 1e-10 * peak or not found.converged[0]
    assert np.mean(flags) > 0.7


@pytest.mark.parametrize("name", SURFACES)
def test_nodes_without_a_force_have_converged(name):
    """Nodes that stay open, or that move only across the contact."""
    field = field_on(name)
    apart = float(field.separations[0])
    for x, d in (([0.0, 3e-7, 0.0], [apart + 1e-5, 1e-7, 0.0]), ([0.0] * 3, [apart, 1e-7, 0.0])):
        found = field.harmonics([x], separations=[d])
        assert np.abs(found.force).max() <= found.residual[0] < 1e-10
        assert found.converged.all()


@pytest.mark.parametrize("name", SURFACES)
def test_jacobian_is_the_derivative_of_the_coefficients(name):
    field = field_on(name)
    for x, d in motions(field, 5, 2):
        found = field.harmonics(x, (0, 1, 2), separations=d, rtol=1e-13)
        sizes = np.abs(x).max(), np.abs(d[0, 1:]).max()
        for k in range(2):
            for j in range(5):

                def at(s, x=x, d=d, k=k, j=j):
                    moved = [x.copy(), d.copy()]
                    moved[k][0, j] += s
                    end = field.harmonics(moved[0], (0, 1, 2), separations=moved[1], rtol=1e-13)
                    return np.stack((end.force[0], end.load[0]))

                off = found.jacobian[0, :, k, :, j] - slope(at, 1e-5 * sizes[k])
                scale = np.abs(found.jacobian[0]).max(axis=(1, 2, 3))
                # Differences of second order, but for kinks that lie within a step.
                assert (np.abs(off).max(axis=1) <= 2e-5 * scale).all()


@pytest.mark.parametrize("name", ["summits", "uniform", "gaussian"])
def test_an_interface_has_the_harmonics_of_a_field_of_one_node(name):
    surface, load = SURFACES[name]
    joint = ms.Interface(surface, 0.5, normal_load=load)
    field = field_on(name)
    for x, d in motions(field, 9, 2):
        d[0, 0] += joint.separation - field.separations[0]
        one = joint.harmonics(x[0], (0, 1, 2), separation=d[0])
        many = field.at(separations=[joint.separation]).harmonics(x, (0, 1, 2), separations=d)
        np.testing.assert_allclose(one.force, many.force[0], rtol=0, atol=1e-9 * load)
        np.testing.assert_allclose(one.normal_load, many.load[0], rtol=0, atol=1e-9 * load)
        t = 2.0 * np.pi * np.arange(4096) / 4096
        waves = np.stack([t**0, np.cos(t), np.sin(t), np.cos(2 * t), np.sin(2 * t)], axis=1)
        dense = waves.T @ joint.periodic(waves @ x[0], separation=waves @ d[0]).force / 2048
        dense[0] *= 0.5
        np.testing.assert_allclose(one.force, dense, rtol=0, atol=1e-5 * load)


def test_harmonics_too_high_without_samples_are_refused_with_the_remedy():
    field = field_on("gaussian")
    with pytest.raises(ms.InputError, match="samples=2400"):
        field.harmonics(
            np.zeros((1, 3)), (0, 300), separations=[[float(field.separations[0]), 1e-9, 0.0]]
        )
