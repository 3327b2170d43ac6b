"""Normal load laws given as tables: shape kept, nothing invented, exact where they can be."""

from fractions import Fraction
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from cases import reach_of, records
from hypothesis import example, given
from hypothesis import strategies as st
from sliders import stops

import microslip as ms

BODY = ms.Material(young_modulus=1e11, poisson_ratio=0.0)  # stiffness ratio 1: kappa = mu
PAIR = ms.MaterialPair(BODY, BODY)
MU = 0.5
MICRON = 2.0**-20


def table(separation, load, tail=None):
    return ms.TabulatedNormalLaw(PAIR, np.array(separation), np.array(load), tail=tail)


@st.composite
def convex_tables(draw, with_tail=True):
    """Separations and falling, convex loads, with straight runs, steps of all sizes and a tail."""
    size = draw(st.integers(2, 12))
    steps = [draw(st.sampled_from([1.0, 0.5, 2.0, 0.03, 7.0])) for _ in range(size)]
    bends = [draw(st.sampled_from([0.0, 0.0, 0.1, 1.0, 5.0, 0.01])) for _ in range(size - 1)]
    start = draw(st.sampled_from([0.0, -3.0, 100.0]))
    tail = draw(st.sampled_from([None, "exponential"])) if with_tail else None
    load, slope = [draw(st.sampled_from([0.1, 3.0])) if tail else 0.0], draw(st.floats(0.01, 1))
    for step, bend in zip(steps[::-1], [*bends, 0.0], strict=True):
        load.append(load[-1] + slope * step)
        slope += bend
    d = MICRON * (start + np.concatenate(([0.0], np.cumsum(steps))))
    return d, 100.0 * np.array(load[::-1]), tail


def within(law, count=400):
    low, high = np.asarray(law.separations)[[0, -1]]
    return np.unique(np.concatenate((np.linspace(low, high, count), law.separations)))


# The interpolation


@given(made=convex_tables())
def test_shape_is_kept(made):
    law = table(*made)
    d, n, tail = made
    # Through the points, one after another.
    np.testing.assert_allclose(law.load(d), n, rtol=1e-13, atol=1e-14 * n[0])
    t = within(law)
    load, stiffness = law.load(t), law.stiffness(t)
    assert np.all(np.diff(load) <= 0)
    assert np.all(stiffness[:-1] >= 0)
    assert np.all(np.diff(stiffness) <= 1e-12 * stiffness[0])
    # Between the points, below every chord and above every chord's extension.
    for i, (a, b) in enumerate(pairwise(d)):
        inner = np.linspace(a, b, 22)[1:-1]
        chord = n[i] + (n[i + 1] - n[i]) * (inner - a) / (b - a)
        assert np.all(law.load(inner) <= chord + 1e-13 * n[0])
        for j in (i - 1, i + 1):
            if 0 <= j < d.size - 1:
                slope = (n[j + 1] - n[j]) / (d[j + 1] - d[j])
                extension = n[j] + slope * (inner - d[j])
                assert np.all(law.load(inner) >= extension - 1e-12 * n[0])
    # No slider of negative stiffness, discrete or spread.
    joint = ms.Interface(law, MU, separation=float(d[0]))
    sliders = joint.sliders()
    spread = sliders.density(joint.slip_per_indentation * (t - d[0]))
    assert np.all(spread >= 0)
    assert np.all(sliders.stiffnesses > 0)
    if tail is None:
        assert law.load(2 * d[-1] - d[0]) == 0
    else:
        after = d[-1] + (d[-1] - d[0]) * np.array([0.01, 0.1, 0.5, 1.0])
        beyond = law.load(after)
        assert np.all((beyond > 0) & (beyond < n[-1]))
        ratios = np.log(beyond / n[-1]) / (after - d[-1])
        np.testing.assert_allclose(ratios, ratios[0], rtol=1e-9)
        # N and N' go on where the table ends.
        assert -ratios[0] * n[-1] == pytest.approx(law.stiffness(d[-1]), rel=1e-9, abs=0)


@pytest.mark.parametrize("points", [3, 4, 7, 11])
@pytest.mark.parametrize("grading", [1.0, 1.4])
def test_exact_for_parabolas(points, grading):
    """Wherever the points lie: N = c (D - d)^2, its slopes, its energy."""
    steps = grading ** np.arange(points - 1)
    share = np.concatenate(([0.0], np.cumsum(steps) / steps.sum()))
    share[-1] = 1.0
    end, top = MICRON, 640.0
    law = table(end * share, top * (1 - share) ** 2)
    t = np.linspace(0, 0.999, 500)
    np.testing.assert_allclose(law.load(end * t), top * (1 - t) ** 2, rtol=1e-9)
    np.testing.assert_allclose(law.stiffness(end * t), 2 * top / end * (1 - t), rtol=1e-11)
    joint = ms.Interface(law, MU, separation=0.25 * end)
    length = joint.slip_per_indentation * end
    x = np.array([1e-9, 1e-3, 0.1, 0.5, 0.75, 0.9, 3.0])
    left = np.maximum(0.75 - x, 0)
    forces = MU * top * np.where(x < 0.75, x * (1.5 - x), 0.75**2)
    np.testing.assert_allclose(joint.backbone(length * x), forces, rtol=1e-11)
    np.testing.assert_allclose(
        joint.backbone_stiffness(length * x), 2 * MU * top / length * left, rtol=1e-11
    )
    # 4 mu/kappa^2 int u (a - u) N'' du with N'' constant as far as contact reaches.
    reach = np.minimum(x, 0.75)
    energy = 8 * MU * top * length * (x * reach**2 / 2 - reach**3 / 3)
    np.testing.assert_allclose(joint.dissipated_energy(length * x), energy, rtol=1e-11)


def test_small_loads_keep_their_digits():
    """Close to the end of a table N is as good as its separation allows."""
    share = np.linspace(0, 1, 9)
    law = table(MICRON * share, 512.0 * (1 - share) ** 2)
    left = 2.0 ** -np.arange(4, 30)
    doubt = 4e-16 / left
    got = law.load(MICRON * (1 - left))
    assert np.all(np.abs(got / (512 * left**2) - 1) <= 1e-14 + doubt)


# What follows from it


def pieces(law, d):
    """N'' from d on as exact numbers: (start, end, curvature) and (place, jump of N')."""
    names = ("knots", "curvatures", "jumps")
    exact = (list(map(Fraction, getattr(law._spline, name).tolist())) for name in names)
    knots, curvatures, jumps = exact
    at = Fraction(d)
    bent = [
        (max(a - at, Fraction(0)), b - at, c)
        for (a, b), c in zip(pairwise(knots), curvatures, strict=False)
        if b > at and c
    ]
    corners = [(k - at, j) for k, j in zip(knots, jumps, strict=True) if k > at and j]
    return bent, corners


def integrated(law, d, u, powers):
    """Integral of a polynomial sum of c v^p times N''(d + v) over 0 <= v <= u, exactly."""
    bent, corners = pieces(law, d)
    total = Fraction(0)
    for low, high, curvature in bent:
        high = min(high, u)
        if low < high:
            for p, c in powers.items():
                total += curvature * c * (high ** (p + 1) - low ** (p + 1)) / (p + 1)
    for place, jump in corners:
        if place <= u:
            total += jump * sum(c * place**p for p, c in powers.items())
    return total


@given(made=convex_tables(), shares=st.lists(st.floats(0, 1), min_size=1))
def test_sliders_are_all_of_the_stiffness(made, shares):
    """The slope changes nowhere but by spread sliders and by discrete ones."""
    d, _, tail = made
    law = table(*made)
    for share in shares:
        at = min(float(d[0] + share * (d[-1] - d[0])), float(d[-1]))
        rest = law.stiffness(d[-1]) if tail else 0.0
        total = float(integrated(law, at, Fraction(1), {0: Fraction(1)})) + rest
        assert law.stiffness(at) == pytest.approx(total, rel=1e-11, abs=1e-12 * law.stiffness(d[0]))


@given(
    made=convex_tables(with_tail=False),
    share=st.floats(0, 0.9),
    steps=st.lists(st.floats(1e-7, 1.5)),
)
@example(
    made=(2.0**-20 * np.arange(3), np.array([200.0, 100.0, 0.0]), None), share=4.5e-7, steps=[0.5]
)  # straight
def test_differences_do_not_cancel(made, share, steps):
    """Backbone and energy against exact sums over the pieces, at amplitudes of all sizes."""
    d = made[0]
    law = table(*made)
    start = float(d[0] + share * (d[-1] - d[0]))
    joint = ms.Interface(law, MU, separation=start)
    kappa = joint.slip_per_indentation
    assert kappa == MU
    for step in [*steps, 1e-10, 1e-3]:
        x = step * float(d[-1] - d[0])
        u = Fraction(x) / Fraction(MU)
        slope = Fraction(float(law.stiffness(start)))
        fall = slope * u - integrated(law, start, u, {0: u, 1: Fraction(-1)})
        bulge = integrated(law, start, u, {1: u, 2: Fraction(-1)})
        # The slopes of a table are differences of its loads: this much of them is rounding.
        rough = 3e-11 * MU * float(slope * u)
        assert joint.backbone(x) == pytest.approx(float(fall * Fraction(MU)), rel=0, abs=rough)
        energy = float(4 * bulge * Fraction(MU) * Fraction(MU))
        # A straight table loses nothing but rounding of its slopes, of 4 k_n u (mu u).
        least = 1e-15 * 4.0 * MU * MU * float(slope * u * u)
        assert joint.dissipated_energy(x) == pytest.approx(energy, rel=1e-11, abs=least)


@given(made=convex_tables(), share=st.floats(0, 0.9), step=st.floats(1e-7, 3))
def test_drop_keeps_its_digits(made, share, step):
    """A small step's backbone relative to itself, tail or none."""
    d, n, tail = made
    law = table(d, n, tail)
    start = float(d[0] + share * (d[-1] - d[0]))
    joint = ms.Interface(law, MU, separation=start)
    for x in (1e-9 * step * MICRON, 1e-6 * step * MICRON):
        # Within so small a step the slope falls by next to nothing.
        ends = joint.backbone_stiffness(np.array([0.0, x]))
        got = joint.backbone(x) / x
        assert ends[1] * (1 - 1e-12) <= got <= ends[0] * (1 + 1e-12)


@pytest.mark.parametrize("start", [0.0, 0.3, 1.0, 1.7, 40.0])
def test_exponential_tail(start):
    """In the tail a joint is exponential; before it the differences cross over into it."""
    d = MICRON * np.array([0.0, 0.2, 0.5, 1.0])
    n = 50.0 * np.array([9.0, 6.0, 3.0, 1.0])
    law = table(d, n, "exponential")
    joint = ms.Interface(law, MU, separation=start * MICRON)
    kappa = joint.slip_per_indentation
    length = n[-1] / law.stiffness(d[-1])
    if start >= 1.0:
        x = np.array([1e-10, 1e-4, 0.3, 2.0, 20.0, 100.0])
        top = MU * n[-1] * np.exp(-(start * MICRON - d[-1]) / length)
        assert joint.force_limit == pytest.approx(top, rel=1e-14, abs=0)
        scale = kappa * length
        np.testing.assert_allclose(joint.backbone(scale * x), -top * np.expm1(-x), rtol=2e-14)
        with mp.workdps(50):
            wanted = [
                float(top * scale * (4 * v - 8 + (8 + 4 * v) * mp.exp(-v))) for v in map(mp.mpf, x)
            ]
        np.testing.assert_allclose(joint.dissipated_energy(scale * x), wanted, rtol=1e-13)
        np.testing.assert_allclose(
            joint.sliders().density(scale * x), top / scale**2 * np.exp(-x), rtol=1e-13
        )
        return
    # Across the end of the table: exact pieces, then the tail in closed form.
    begin = mp.mpf(float(d[-1])) - mp.mpf(joint.separation)
    for step in (0.4, 1.5, 3.0, 9.0, 60.0):
        x = step * MICRON * kappa
        with mp.workdps(40):
            exact = Fraction(x) / Fraction(kappa)
            inner = integrated(law, joint.separation, exact, {1: exact, 2: Fraction(-1)})
            bulge = mp.mpf(inner.numerator) / inner.denominator
            bulge += tail_share(mp.mpf(x) / mp.mpf(kappa), begin, float(n[-1]), mp.mpf(length))
            energy = float(4 * mp.mpf(MU) * mp.mpf(kappa) * bulge)
        assert joint.dissipated_energy(x) == pytest.approx(energy, rel=1e-12, abs=0)
        force = MU * (law.load(joint.separation) - law.load(joint.separation + x / kappa))
        assert joint.backbone(x) == pytest.approx(force, rel=1e-13, abs=0)


def tail_share(u, begin, load, decay):
    """Integral of v (u - v) N''(d + v) over what of 0 <= v <= u lies past the table."""
    if u <= begin:
        return 0
    return mp.quad(
        lambda v: v * (u - v) * load / decay**2 * mp.exp(-(v - begin) / decay),
        mp.linspace(begin, min(u, begin + 90 * decay), 12),
    )


# Straight runs are Jenkins elements


def test_one_straight_run_is_a_jenkins_element():
    law = table(MICRON * np.array([0.0, 0.25, 0.7, 1.0]), 80.0 * np.array([1.0, 0.75, 0.3, 0.0]))
    joint = ms.Interface(law, MU, separation=0.2 * MICRON)
    yields = joint.slip_per_indentation * 0.8 * MICRON
    sliders = joint.sliders()
    np.testing.assert_allclose(sliders.yield_displacements, [yields], rtol=1e-14)
    np.testing.assert_allclose(sliders.stiffnesses, [joint.force_limit / yields], rtol=1e-14)
    assert np.all(sliders.density(yields * np.array([0.0, 0.5, 0.99, 2.0])) == 0)
    x = yields * np.array([1e-6, 0.5, 0.999, 1.0, 1.001, 50.0])
    np.testing.assert_allclose(
        joint.backbone(x), joint.force_limit * np.minimum(x / yields, 1), rtol=1e-13
    )
    energy = 4 * joint.force_limit * np.maximum(x - yields, 0)
    np.testing.assert_allclose(
        joint.dissipated_energy(x), energy, rtol=1e-12, atol=1e-14 * joint.force_limit * yields
    )


STRAIGHT = table(
    MICRON * np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]),
    np.array([150.0, 120.0, 90.0, 75.0, 60.0, 40.0, 20.0, 15.0, 10.0, 0.0]),
)


@pytest.mark.parametrize("start", [0.0, 0.7, 1.0, 3.3])
def test_straight_runs_are_iwan(start):
    joint = ms.Interface(STRAIGHT, MU, separation=start * MICRON)
    sliders = joint.sliders()
    corners = np.array([1.0, 2.0, 4.0, 8.0])
    bends = np.array([30.0, 10.0, 15.0, 5.0]) / MICRON
    left = corners > start
    kappa = joint.slip_per_indentation
    np.testing.assert_allclose(
        sliders.yield_displacements, kappa * (corners[left] - start) * MICRON, rtol=1e-14
    )
    np.testing.assert_allclose(sliders.stiffnesses, MU / kappa * bends[left], rtol=1e-12)
    assert sliders.stiffnesses.sum() == pytest.approx(joint.tangential_stiffness, rel=1e-14, abs=0)
    assert sliders.stiffnesses @ sliders.yield_displacements == pytest.approx(
        joint.force_limit, rel=1e-14, abs=0
    )
    yields, stiffness = sliders.yield_displacements, sliders.stiffnesses
    a = kappa * MICRON * np.geomspace(0.1, 50, 40)
    each = 4 * stiffness * yields * np.maximum(a[:, None] - yields, 0)
    np.testing.assert_allclose(
        joint.dissipated_energy(a),
        each.sum(axis=1),
        rtol=1e-11,
        atol=1e-13 * joint.force_limit * a[0],
    )


@given(x=records(max_size=40))
def test_straight_runs_follow_any_history(x):
    joint = ms.Interface(STRAIGHT, MU, separation=0.7 * MICRON)
    path = x * reach_of(joint)
    sliders = joint.sliders()
    wanted, _ = stops(path, sliders.stiffnesses, sliders.yield_displacements)
    scale = max(1.0, float(np.abs(x).max()))  # a stretch is the sum of its steps
    np.testing.assert_allclose(
        joint.force(path), wanted, rtol=0, atol=1e-14 * scale * joint.force_limit
    )


def test_corner_after_a_bend():
    """A straight run beside bent ones: the corner's slider and the spread ones share the rest."""
    d = MICRON * np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    n = np.array([60.0, 40.0, 26.0, 18.0, 12.0, 6.0, 0.0])
    joint = ms.Interface(table(d, n), MU, separation=0.0)
    sliders = joint.sliders()
    kappa = joint.slip_per_indentation
    np.testing.assert_allclose(sliders.yield_displacements, [kappa * 6 * MICRON], rtol=1e-14)
    assert sliders.stiffnesses[0] == pytest.approx(MU / kappa * 6 / MICRON, rel=1e-12, abs=0)
    assert np.all(sliders.density(kappa * MICRON * np.linspace(3.01, 5.99, 20)) == 0)
    u = kappa * MICRON * (np.arange(6000) + 0.5) / 1000
    spread = sliders.density(u).sum() * (u[1] - u[0])
    assert spread + sliders.stiffnesses.sum() == pytest.approx(
        joint.tangential_stiffness, rel=1e-6, abs=0
    )


# Towards the law that a table samples


def test_convergence_to_the_law_it_samples():
    """Third order in N and T0, second in N' and k_t."""
    surface = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), radius=1e-3, density=1e8, area=2e-4)
    exact = ms.Interface(surface, MU, separation=2e-7)
    t = np.linspace(-4e-7, 2.2e-6, 777)
    x = exact.slip_per_indentation * np.array([3e-8, 2e-7, 5e-7, 1.1e-6, 1.9e-6])
    path = x[2] * np.array([0.3, 1, 0.2, 0.6, -0.8, -0.3, -0.7, 0.4, 1.4, -1.4, 0.1])
    errors = {"N": [], "N'": [], "T0": [], "E": [], "history": []}
    sizes = (21, 41, 81, 161, 321)
    for size in sizes:
        d = np.linspace(-5e-7, 2.5e-6, size)
        law = ms.TabulatedNormalLaw(PAIR, d, surface.load(d), tail="exponential")
        joint = ms.Interface(law, MU, separation=2e-7)
        errors["N"].append(np.abs(law.load(t) - surface.load(t)).max() / surface.load(t[0]))
        slope = np.abs(law.stiffness(t) - surface.stiffness(t)).max()
        errors["N'"].append(slope / surface.stiffness(t[0]))
        errors["T0"].append(np.abs(joint.backbone(x) / exact.backbone(x) - 1)[1:].max())
        errors["E"].append(
            np.abs(joint.dissipated_energy(x) / exact.dissipated_energy(x) - 1)[1:].max()
        )
        gap = np.abs(joint.force(path) - exact.force(path)).max()
        errors["history"].append(gap / exact.force_limit)
    orders = {k: np.log2(v[0] / v[-1]) / (len(sizes) - 1) for k, v in errors.items()}
    assert orders["N"] > 2.7, orders
    assert orders["N'"] > 1.7, orders
    assert orders["T0"] > 1.8, orders
    assert orders["E"] > 1.6, orders
    assert orders["history"] > 2.5, orders
    assert errors["history"][-1] < 1e-6
