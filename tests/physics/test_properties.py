"""What every backbone law obeys, whatever its backbone: found out with records made by chance."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from cases import (
    all_laws,
    invertible_laws,
    law_params,
    moves,
    reach_of,
    records,
    settled,
    stiffness_of,
)
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from reference.make_reference import dominant_extremes

import microslip as ms

INTERFACES = law_params(which=lambda law: isinstance(law, ms.Interface))
EPS = np.finfo(float).eps
# Rounding of some values of a backbone, of the force limit. Summed over nodes or summits, a value
# depends in its last places on how many are asked for at once. What has not even that excuse is
# compared bit by bit.
ROUNDING = 1e-14


def rounding(law: ms.BackboneLaw) -> float:
    """The same with what the last place of the separation costs: h^2 of the load's, if light."""
    if not isinstance(law, ms.Interface):
        return ROUNDING
    return ROUNDING + 4 * EPS * abs(law.separation) * law.normal_stiffness / law.normal_load


def same(got: Any, wanted: Any, law: ms.BackboneLaw, tolerance: float | None = None) -> None:
    share = rounding(law) if tolerance is None else tolerance
    np.testing.assert_allclose(got, wanted, rtol=0, atol=share * law.force_limit)


fractions = st.floats(-1, 1).map(settled)


def force_at(law: ms.BackboneLaw, extremes: list[float]) -> float:
    """Masing's sum over the extremes that dominate a past."""
    total = law.backbone(extremes[0])
    for start, end in pairwise(extremes):
        total += 2 * law.backbone((end - start) / 2)
    return float(total)


# The backbone


@all_laws
@given(x=records())
def test_backbone_is_odd(law, x):
    x = x * reach_of(law)
    np.testing.assert_array_equal(law.backbone(-x), -law.backbone(x))
    np.testing.assert_array_equal(law.backbone_stiffness(-x), law.backbone_stiffness(x))


@all_laws
def test_backbone_is_monotone_concave_and_limited(law):
    x = reach_of(law) * np.concatenate(([0.0], np.geomspace(1e-9, 1e3, 4001)))
    force, stiffness = law.backbone(x), law.backbone_stiffness(x)
    assert force[0] == 0
    assert np.all(force <= law.force_limit * (1 + ROUNDING))
    assert np.all(np.diff(force) >= -ROUNDING * law.force_limit)
    assert stiffness[0] == pytest.approx(law.tangential_stiffness, rel=rounding(law), abs=0)
    assert np.all(stiffness >= 0)
    assert np.all(np.diff(stiffness) <= ROUNDING * stiffness[0])
    # Concave also by its values: secants fall.
    steps = np.diff(x[1:])
    secants = np.diff(force[1:]) / steps
    noise = rounding(law) * force[2:] / steps
    assert np.all(np.diff(secants) <= noise[1:] + noise[:-1])
    # The tangent is the slope of the values.
    middle = (stiffness[2:] + stiffness[1:-1]) / 2
    bend = np.abs(np.diff(stiffness[1:]))
    assert np.all(np.abs(secants - middle) <= 0.5 * bend + noise + ROUNDING * stiffness[0])


@invertible_laws
@given(force=st.lists(fractions.filter(lambda v: abs(v) < 1), min_size=1))
def test_backbone_inverse(law, force):
    force = np.array(force) * law.force_limit
    x = law.backbone_displacement(force)
    np.testing.assert_allclose(law.backbone(x), force, rtol=rounding(law))
    assert np.all(np.signbit(x) == np.signbit(force))


# Histories at constant normal load


@all_laws
@given(x=records())
def test_force_is_odd(law, x):
    x = x * reach_of(law)
    np.testing.assert_array_equal(law.force(-x), -law.force(x))


@all_laws
@given(x=records(max_size=60))
def test_force_is_limited(law, x):
    force = law.force(x * reach_of(law))
    assert np.all(np.abs(force) <= law.force_limit * (1 + ROUNDING))


@all_laws
@given(x=records())
def test_force_by_the_dominant_extremes(law, x):
    """Masing and Madelung by another road: no stack, the whole past is searched at each sample."""
    x = x * reach_of(law)
    path = x.tolist()
    wanted = [force_at(law, dominant_extremes(path[: i + 1])) for i in range(len(path))]
    same(law.force(x), wanted, law)


@all_laws
@given(peak=moves, shares=st.lists(st.floats(0, 1), min_size=1, max_size=8))
def test_masing(law, peak, shares):
    """After a reversal at (d, T): T - 2 T0((d - x)/2), as far as the mirror point and beyond it."""
    assume(peak != 0)
    peak *= reach_of(law)
    down = peak - 2 * peak * np.sort(shares)
    start = law.backbone(peak)
    got = law.force(np.concatenate(([peak], down)))[1:]
    same(got, start - 2 * law.backbone((peak - down) / 2), law)
    beyond = -peak * np.array([1.0, 1.1, 3.0])
    same(law.force(np.concatenate(([peak], down, beyond)))[-3:], law.backbone(beyond), law)


@all_laws
@given(
    past=records(max_size=12),
    shares=st.lists(st.one_of(st.floats(0, 1), st.integers(0, 8).map(lambda k: k / 8))),
    future=records(max_size=12),
)
def test_return_point_memory(law, past, shares, future):
    """An excursion that stays within the branch in progress and returns leaves no trace."""
    past, future = past * reach_of(law), future * reach_of(law)
    extremes = dominant_extremes(past.tolist())
    end = extremes[-1]
    turn = extremes[-2] if len(extremes) > 1 else -end
    inner = np.clip(end + np.array(shares) * (turn - end), min(turn, end), max(turn, end))
    plain, looped = law.start(), law.start()
    same(looped.advance(past), plain.advance(past), law, 0)
    for path in (inner, [end]):
        if len(path):
            looped.advance(path)
    assert looped.displacement == plain.displacement
    same(looped.force, plain.force, law)
    assert looped.open_reversals == plain.open_reversals
    same(looped.advance(future), plain.advance(future), law)


@all_laws
@given(past=records(max_size=20), sign=st.sampled_from([-1, 1]), future=records(max_size=12))
def test_wiping_out(law, past, sign, future):
    """The largest displacement yet, on either side, wipes out all that came before it."""
    past, future = past * reach_of(law), future * reach_of(law)
    for factor in (1.0, 1.25):
        largest = sign * factor * np.abs(past).max()
        wiped, fresh = law.start(), law.start()
        wiped.advance(past)
        same(wiped.advance([largest]), fresh.advance([largest]), law)
        assert wiped.open_reversals == 0
        same(wiped.advance(future), fresh.advance(future), law)


@all_laws
@given(x=records(), data=st.data())
def test_rate_independence(law, x, data):
    """Samples between, in the direction of travel, and repeated ones change nothing."""
    x = x * reach_of(law)
    path, keep, before = [], [], 0.0
    for v in x:
        shares = data.draw(st.lists(st.floats(0, 1), max_size=3))
        between = np.clip(before + (v - before) * np.sort(shares), min(before, v), max(before, v))
        path += [*between, *[v] * data.draw(st.integers(1, 3))]
        keep.append(len(path) - 1)
        before = v
    same(law.force(np.array(path))[keep], law.force(x), law)


@all_laws
@given(x=records(max_size=40), cuts=st.lists(st.integers(0, 40), max_size=8))
def test_chunks_are_the_whole(law, x, cuts):
    x = x * reach_of(law)
    cuts = sorted({c for c in cuts if 0 < c < x.size})
    state, whole = law.start(), law.start()
    parts = np.concatenate([state.advance(part) for part in np.split(x, cuts)])
    wanted = whole.advance(x)
    same(parts, wanted, law)
    same(law.force(x), wanted, law)
    if law._table is not None:
        # One pass over the samples: same operations. A law without a profile sums its parts for a
        # block of questions at a time, whose order of sums is the processor's.
        np.testing.assert_array_equal(parts, wanted)
        np.testing.assert_array_equal(law.force(x), wanted)
    assert (state.displacement, state.open_reversals) == (whole.displacement, whole.open_reversals)


@all_laws
@given(x=records())
@example(x=np.array([1.5]))  # next to full slip of listed summits
def test_trials_are_the_history(law, x):
    """try_ and commit, sample by sample, with trials elsewhere in between."""
    x = x * reach_of(law)
    state, got, slopes = law.start(), [], []
    for i, v in enumerate(x):
        for other in (-v, 3 * v, v):
            force, slope = state.try_(other)
        if i % 2:
            state.rollback()
            assert state.try_(v) == (force, slope)
        state.commit()
        assert (state.displacement, state.force) == (v, force)
        got.append(force)
        slopes.append(slope)
    wanted = law.force(x)
    same(got, wanted, law)
    if law._table is not None:
        np.testing.assert_array_equal(got, wanted)
    lengths = [
        abs(e[0]) if len(e) == 1 else abs(e[-1] - e[-2]) / 2
        for e in (dominant_extremes(x[: i + 1].tolist()) for i in range(x.size))
    ]
    top = stiffness_of(law)
    # Asked of tangent stiffnesses: 1e-12; of the first one here, since many are next to nothing.
    np.testing.assert_allclose(slopes, law.backbone_stiffness(lengths), rtol=0, atol=1e-12 * top)


@all_laws
@given(past=records(max_size=12), trials=records(max_size=6), future=records(max_size=12))
def test_rollback_leaves_no_trace(law, past, trials, future):
    scale = reach_of(law)
    tried, plain = law.start(), law.start()
    for state in (tried, plain):
        state.advance(past * scale)
    for v in trials * scale:
        tried.try_(v)
    tried.rollback()
    assert (tried.displacement, tried.force) == (plain.displacement, plain.force)
    assert tried.open_reversals == plain.open_reversals
    with pytest.raises(ms.InputError, match="needs a trial"):
        tried.commit()
    tried.try_(trials[0] * scale)  # an open trial does not touch what is committed either
    np.testing.assert_array_equal(tried.advance(future * scale), plain.advance(future * scale))


@all_laws
@given(past=records(max_size=12), first=records(max_size=12), second=records(max_size=12))
def test_copies_are_independent(law, past, first, second):
    scale = reach_of(law)
    state = law.start()
    state.advance(past * scale)
    state.try_(first[0] * scale)
    copy, wanted = state.copy(), []
    for path in (first, second):
        fresh = law.start()
        fresh.advance(past * scale)
        wanted.append(fresh.advance(path * scale))
    open_trial = state.copy()
    np.testing.assert_array_equal(state.advance(first * scale), wanted[0])
    np.testing.assert_array_equal(copy.advance(second * scale), wanted[1])
    open_trial.commit()
    assert open_trial.displacement == first[0] * scale


# Force control


@invertible_laws
@given(f=st.lists(fractions, min_size=1, max_size=20), top=st.sampled_from([0.5, 0.99, 1]))
def test_force_of_displacement(law, f, top):
    """Asked: 1e-12; also next to the force limit, where the displacement runs away."""
    force = np.array(f) * top * (1 - 1e-9) * law.force_limit
    x = law.displacement(force)
    # A tail that is algebraic goes so far that the last place of the displacement counts.
    last = np.spacing(np.abs(x).max()) * law.tangential_stiffness / law.force_limit
    same(law.force(x), force, law, rounding(law) + 4 * last)


@invertible_laws
@given(x=st.lists(fractions, min_size=1, max_size=20))
def test_displacement_of_force(law, x):
    """The other way round below 0.999 of the limit, as well as the slopes on the way allow."""
    x = np.array(x) * law.backbone_displacement(0.999 * law.force_limit)
    force = law.force(x)
    assume(np.abs(force).max() < 0.999 * law.force_limit)
    state, slopes = law.start(), []
    for v in x:
        slopes.append(state.try_(v)[1])
        state.commit()
    doubt = 2 * rounding(law) * law.force_limit / min(slopes)
    np.testing.assert_allclose(law.displacement(force), x, rtol=1e-14, atol=doubt)


@invertible_laws
@given(x=st.lists(fractions.map(abs), min_size=1))
def test_energy_measures_by_force_amplitude(law, x):
    force = np.array(x) * 0.999 * law.force_limit
    amplitude = law.backbone_displacement(force)
    for method in ("dissipated_energy", "loss_factor", "secant_stiffness", "dissipation_exponent"):
        np.testing.assert_array_equal(
            getattr(law, method)(force_amplitude=force), getattr(law, method)(amplitude)
        )


# Energy


def work(law: ms.BackboneLaw, path: np.ndarray, rate: int = 24) -> np.ndarray:
    """Work of the force along each move of a path from rest, by Gauss points.

    Forces bend where a loop closes, that is at earlier displacements and their mirror images, and
    where a discrete slider yields, so each move is cut there.
    """
    nodes, weights = np.polynomial.legendre.leggauss(rate)
    nodes, weights = 0.5 * (1 + nodes), 0.5 * weights
    # Fine towards both ends: at a turn a backbone may bend like a root.
    nodes, weights = nodes**2 * (3 - 2 * nodes), 6 * nodes * (1 - nodes) * weights
    cuts = np.concatenate((path, -path, [0.0]))
    corners = law.sliders().yield_displacements
    if corners.size < 20:  # of many none matters
        twice = 2.0 * np.concatenate((corners, -corners))
        cuts = np.concatenate((cuts, 0.5 * twice, *(place + twice for place in (*path, *-path))))
    cuts = np.unique(cuts)
    before, places, shares, ends = 0.0, [], [], []
    for v in path:
        low, high = min(before, v), max(before, v)
        marks = np.concatenate(([low], cuts[(cuts > low) & (cuts < high)], [high]))
        if v < before:
            marks = marks[::-1]
        for a, b in pairwise(marks):
            places += [*np.clip(a + (b - a) * nodes, min(a, b), max(a, b)), b]
            shares += [*((b - a) * weights), 0.0]
        ends.append(len(places))
        before = v
    total = np.cumsum(law.force(np.array(places)) * shares)
    return np.diff([0.0, *total[np.array(ends) - 1]])


@all_laws
@given(x=records(max_size=8))
def test_work_from_rest_is_never_given_back(law, x):
    """Passive: from rest, the work done so far is never negative, whatever the record."""
    path = np.clip(x, -3, 3) * reach_of(law)
    total = np.cumsum(work(law, path, rate=8))
    assert np.all(total >= -1e-6 * law.force_limit * np.ptp([0, *path]))


def closed_loops(cycle: list[float]) -> list[float]:
    """Ranges of all loops that a settled cycle closes: rainflow counting from its largest value."""
    start = max(range(len(cycle)), key=lambda i: abs(cycle[i]))
    path = [*cycle[start:], *cycle[: start + 1]]
    stack: list[float] = []
    ranges = []
    for v in path:
        stack.append(v)
        while len(stack) >= 4:
            a, b, c, d = stack[-4:]
            if (b - a) * (c - b) >= 0:  # not a turn: drop the middle one
                del stack[-3]
            elif (c - b) * (d - c) >= 0:
                del stack[-2]
            elif abs(b - a) >= abs(c - b) <= abs(d - c):
                ranges.append(abs(c - b))
                del stack[-3:-1]
            else:
                break
    low, high = min(stack), max(stack)
    return [*ranges, high - low]


@all_laws
@given(x=records(min_size=2, max_size=7))
def test_energy_of_any_closed_history(law, x):
    """The settled work is positive, and the sum over its closed loops of E_d(half range)."""
    cycle = np.clip(x, -3, 3) * reach_of(law)
    settled = work(law, np.tile(cycle, 2))[cycle.size :].sum()
    ranges = np.array(closed_loops(cycle.tolist()))
    energies = law.dissipated_energy(0.5 * ranges)
    assert np.all(energies >= 0)
    size = law.force_limit * np.ptp(cycle)
    # Populations and tables bend within a move too, there the quadrature is coarse.
    rough = 1e-11 if law._table is not None else 2e-4
    assert settled == pytest.approx(energies.sum(), rel=1e-9, abs=rough * size)
    assert settled >= -rough * size


@all_laws
@given(x=st.lists(st.floats(0, 1e3).map(settled), min_size=1))
def test_energy_is_positive_and_bounded(law, x):
    a = np.array(x) * reach_of(law)
    energy = law.dissipated_energy(a)
    assert np.all(energy >= 0)
    assert np.all(energy <= 4 * a * law.backbone(a) * (1 + ROUNDING))
    ratio = law.energy_ratio(a)
    assert np.all((ratio >= 0) & (ratio <= 1))
    np.testing.assert_allclose(4 * a * law.backbone(a) * ratio, energy, rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(law.loss_factor(a), 4 / np.pi * ratio, rtol=1e-15)
    np.testing.assert_allclose(law.damping_ratio(a), 2 / np.pi * ratio, rtol=1e-15)


# Scaling


def rescaled(joint: ms.Interface, length: float, force: float) -> ms.Interface:
    """The same joint with all lengths and all forces multiplied."""
    surface = joint.surface

    def body(material: ms.Material) -> ms.Material:
        stress = force / length**2
        hardness = None if material.hardness is None else material.hardness * stress
        return ms.Material(
            material.young_modulus * stress, material.poisson_ratio, hardness=hardness
        )

    pair = ms.MaterialPair(body(surface.pair.first), body(surface.pair.second))
    made: ms.NormalLaw
    if isinstance(surface, ms.SphereOnFlat):
        made = ms.SphereOnFlat(pair, surface.radius * length)
    elif isinstance(surface, ms.AsperityPopulation):
        made = ms.AsperityPopulation(pair, surface.heights * length, surface.radii * length)
    elif isinstance(surface, ms.DrawnFace):
        made = ms.DrawnFace(
            pair,
            surface.rms * length,
            surface.slope,
            surface.area * length**2,
            surface.tightening_pressure * force / length**2,
            plateau=None if surface.plateau is None else surface.plateau * length,
            breadth=surface.breadth,
            lay=surface.lay,
        ).along(surface.direction)
    elif isinstance(surface, ms.TabulatedNormalLaw):
        made = ms.TabulatedNormalLaw(
            pair, surface.separations * length, surface.loads * force, tail=surface.tail
        )
    else:
        heights = surface.heights
        if isinstance(heights, ms.Gaussian):
            heights = ms.Gaussian(heights.std * length, heights.mean * length)
        elif isinstance(heights, ms.Exponential):
            heights = ms.Exponential(heights.scale * length)
        else:
            heights = ms.Discrete(np.asarray(heights.values) * length)
        # Whatever else it has, such as a lay, is without a unit.
        made = replace(
            surface,
            pair=pair,
            heights=heights,
            radius=surface.radius * length,
            density=surface.density / length**2,
            area=surface.area * length**2,
        )
    return joint_on(made, joint, length)


def joint_on(surface: ms.NormalLaw, joint: ms.Interface, length: float) -> ms.Interface:
    """A joint at the same separation, multiplied."""
    return ms.Interface(surface, joint.friction_coefficient, separation=joint.separation * length)


@pytest.mark.parametrize(
    "law",
    # A measured face is made of heights: tests/unit/test_measured_contact.py scales those.
    [p for p in INTERFACES if not isinstance(p.values[0].surface, ms.MeasuredContact)],
)
# Each makes a surface and all its tables anew.
@settings(max_examples=max(4, settings.default.max_examples // 3))
@given(
    x=records(max_size=10),
    length=st.floats(1e-4, 1e4),
    force=st.floats(1e-4, 1e4),
)
def test_dimensional_scaling(law, x, length, force):
    near = {"rel": 1e-12 + 4 * rounding(law)}
    if isinstance(law.surface, ms.DrawnFace):
        length = min(length, 100.0)  # an rms above 0.2 mm is refused
        near = {"rel": 5e-12}  # logarithms of its table in other units
    other = rescaled(law, length, force)
    assert other.normal_load == pytest.approx(force * law.normal_load, **near)
    assert other.tangential_stiffness == pytest.approx(
        force / length * law.tangential_stiffness, **near
    )
    if law.contact_count is not None:
        assert other.contact_count == pytest.approx(law.contact_count, **near)
        assert other.contact_area == pytest.approx(length**2 * law.contact_area, **near)
    x = x * reach_of(law)
    same(other.force(length * x), force * law.force(x), other, 1e-11)
    # The loss is what is left of 8 integrals of T less 4 x T: twelve times the rounding of T.
    work = 4.0 * length * np.abs(x) * np.abs(other.backbone(length * np.abs(x)))
    lost = other.dissipated_energy(length * np.abs(x))
    expected = force * length * law.dissipated_energy(np.abs(x))
    share = 1e-12 + 12 * 4 * rounding(law)
    assert np.all(np.abs(lost - expected) <= 1e-11 * expected + share * work)


@pytest.mark.parametrize("law", INTERFACES)
@given(x=records(max_size=10), factor=st.floats(1e-3, 1e3))
def test_friction_only_scales(law, x, factor):
    """T/mu is a function of delta/mu: the coefficient sets two scales and no shape."""
    other = ms.Interface(law.surface, factor * law.friction_coefficient, separation=law.separation)
    x = x * reach_of(law)
    same(other.force(factor * x), factor * law.force(x), other, 1e-12)
    assert other.tangential_stiffness == pytest.approx(law.tangential_stiffness, rel=1e-15, abs=0)
