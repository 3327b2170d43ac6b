"""The kernels against plain Python, and each against itself on another road."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest
from cases import interface_of, own_case, own_cases, reach_of, records
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.make_reference import dominant_extremes
from scalar_kernels import Curve, coupled, drag, masing, table_at
from usual import rough

import microslip as ms
from microslip._core import kernels
from microslip._core.kernels import compiled
from microslip.contact.grids import pointwise_of

ROUNDING = 1e-14  # of the force limit


def tables():
    """Tables as the library makes them, of forces and of energies, that grow past their end."""
    joints = [interface_of(case) for case in own_cases()]
    made = [table for j in joints for table in (j._table, j._energy_table) if table is not None]
    assert {table.power for table in made} == {1, 3}
    return [table.arguments for table in made]


JOINT = interface_of(own_case("gaussian-al2017"))
TABLE = JOINT._table.arguments
LIMIT, REACH = JOINT.force_limit, reach_of(JOINT)


def recorded() -> dict[str, np.ndarray]:
    """Records of every kind, in multiples of the reach of the table."""
    rng = np.random.default_rng(5)
    t = np.arange(4000)
    grid = rng.integers(-12, 13, 4000) / 8
    nest = (-1.0) ** t * np.linspace(2, 0, t.size)
    return {
        "sine": 1.7 * np.sin(2 * np.pi * t / 97),
        "sine-exact-period": np.tile(1.3 * np.sin(2 * np.pi * np.arange(64) / 64), 30),
        "beats": np.sin(t * 0.11) + 0.8 * np.sin(t * 0.1234),
        "noise": rng.normal(size=t.size),
        "walk": np.cumsum(rng.normal(size=t.size)) * 0.05,
        "zigzag-shrinking": nest,
        "zigzag-growing": nest[::-1],
        "zigzag-both": np.concatenate((nest[::2], nest[::-2], nest)),
        "zigzag-even": (-1.0) ** t,
        "plateaus": np.repeat(rng.normal(size=400), rng.integers(1, 20, 400)),
        "exact-closures": grid,
        "symmetric-closures": np.repeat(np.abs(grid), 2) * np.tile([1, -1], grid.size),
        "steps-of-one": np.cumsum(rng.choice([-1, 0, 1], t.size)) / 8,
        "rest": np.zeros(50),
        "held": np.full(50, 0.7),
        "minus-zero": np.array([-0.0, 0.0, 0.5, -0.0, 0.0, -0.5, -0.0]),
        "far-and-near": rng.normal(size=2000) * 10.0 ** rng.uniform(-14, 6, 2000),
        "neighbours": 1 + rng.integers(-3, 4, 2000) * np.finfo(float).eps,
    }


RECORDS = recorded()


@dataclass
class Memory:
    """What a kernel is handed and hands back between the pieces of a record."""

    places: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    last: float = 0.0
    value: float = 0.0
    direction: int = 0


def by_respond(x, memory):
    depth = len(memory.places)
    stack = np.full((depth + x.size + 1, 2), np.nan)
    stack[:depth, 0], stack[:depth, 1] = memory.places, memory.values
    out = np.full(x.size, np.nan)
    depth, last, value, direction = compiled.respond(
        x, out, stack, depth, memory.last, memory.value, memory.direction, *TABLE
    )
    places, values = stack[:depth].T.tolist()
    return out, Memory(places, values, last, value, direction)


def by_branches(x, memory):
    depth, base = len(memory.places), np.array([*memory.values, memory.value])
    places, codes = np.full(depth + x.size + 1, np.nan), np.zeros(depth + x.size + 1, np.int64)
    places[:depth], codes[:depth] = memory.places, -2 - np.arange(depth)
    half, sign = np.full(x.size, np.nan), np.full(x.size, np.nan)
    parent = np.full(x.size, -99, np.int64)
    depth, last, direction = compiled.branches(
        x, half, sign, parent, places, codes, depth, memory.last, memory.direction
    )
    # A parent comes before its child, or from the memory.
    assert np.all(parent < np.arange(x.size))
    assert np.all(parent >= -2 - len(memory.places))
    values = np.empty(x.size)
    compiled.evaluate(half, values, None, *TABLE)
    values *= sign
    compiled.accumulate(parent, values, base)
    kept = [float(values[c]) if c >= 0 else float(base[-2 - c]) for c in codes[:depth]]
    memory = Memory(places[:depth].tolist(), kept, last, float(values[-1]), direction)
    return values, memory, (half, sign, parent)


def by_locate(x, memory):
    depth = len(memory.places)
    stack = np.full((depth + x.size + 1, 2), np.nan)
    stack[:depth, 0], stack[:depth, 1] = memory.places, memory.values
    last, value, direction, out = memory.last, memory.value, memory.direction, []
    for v in x.tolist():
        depth, pushed, direction = compiled.locate(v, stack, depth, last, direction)
        if pushed:
            stack[depth - 1] = last, value
        if depth:
            place, start = stack[depth - 1]
            rise = 2 * compiled.evaluate_one(0.5 * abs(v - place), *TABLE)[0]
            value = start + rise if direction > 0 else start - rise
        else:
            value = float(np.copysign(compiled.evaluate_one(abs(v), *TABLE)[0], v))
        last = v
        out.append(value)
    places, values = stack[:depth].T.tolist()
    return np.array(out), Memory(places, values, last, value, direction)


ROADS = (by_respond, by_branches, by_locate)


def in_pieces(road, x, cuts):
    memory, out = Memory(), []
    for piece in np.split(x, cuts):
        if piece.size:
            values, memory, *_ = road(np.ascontiguousarray(piece), memory)
            out.append(values)
    return np.concatenate(out), memory


def alike(first, second):
    np.testing.assert_allclose(first[0], second[0], rtol=0, atol=ROUNDING * LIMIT)
    one, other = first[1], second[1]
    assert (one.places, one.last, one.direction) == (other.places, other.last, other.direction)
    np.testing.assert_allclose(one.values, other.values, rtol=0, atol=ROUNDING * LIMIT)


def check_all(x, cuts):
    x = np.ascontiguousarray(x * REACH)
    wanted = by_respond(x, Memory())
    for road in ROADS:
        alike(in_pieces(road, x, cuts), wanted)
    values, open_places, amplitudes = masing(x.tolist(), lambda u: table_at(u, *TABLE)[0])
    np.testing.assert_allclose(values, wanted[0], rtol=0, atol=ROUNDING * LIMIT)
    assert open_places == wanted[1].places
    closed = np.empty(x.size + 1)
    count = compiled.closings(x, closed, np.empty(x.size + 1), 0, 0.0, 0)
    assert closed[:count].tolist() == amplitudes
    return x, wanted


@pytest.mark.parametrize("name", RECORDS)
def test_every_path_on_every_kind_of_record(name):
    record = RECORDS[name]
    rng = np.random.default_rng(len(name))
    cuts = np.sort(rng.integers(0, record.size, 12))
    x, wanted = check_all(record, cuts)
    # And against a search of the whole past, at some places.
    path = x.tolist()
    for i in range(0, min(x.size, 300), 7):
        extremes = dominant_extremes(path[: i + 1])
        force = np.copysign(table_at(abs(extremes[0]), *TABLE)[0], extremes[0])
        for a, b in pairwise(extremes):
            rise = 2 * table_at(abs(b - a) / 2, *TABLE)[0]
            force += rise if b > a else -rise
        assert abs(wanted[0][i] - force) <= ROUNDING * LIMIT


many = settings(max_examples=5 * settings.default.max_examples)


@many
@given(x=records(max_size=80), cuts=st.lists(st.integers(0, 80), max_size=8))
def test_every_path_on_records_by_chance(x, cuts):
    check_all(x, sorted(min(c, x.size) for c in cuts))


@many
@given(past=records(max_size=30), x=records(max_size=10))
def test_from_any_memory(past, x):
    """One move from a memory with a history, on each road."""
    past, x = past * REACH, np.ascontiguousarray(x * REACH)
    memory = by_respond(past, Memory())[1]
    for v in x:
        ends = [road(np.array([v]), memory)[:2] for road in ROADS]
        for end in ends[1:]:
            alike(end, ends[0])


def test_locate_leaves_its_stack_alone():
    stack = np.array([[1.0, 10.0], [-0.5, 3.0], [0.4, 5.0], [7.0, 7.0]])
    before = stack.copy()
    for v in (-2.0, -1.0, -0.6, -0.5, -0.1, 0.1, 0.3, 0.4, 0.5, 1.0, 1.2):
        for direction, last in ((-1, 0.1), (1, 0.35)):
            compiled.locate(v, stack, 3, last, direction)
    np.testing.assert_array_equal(stack, before)


def test_the_rules_one_by_one():
    """Depth, whether the last place became a reversal, and direction, by hand."""
    stack = np.array([[1.0, 0.0], [-0.5, 0.0], [0.4, 0.0], [-0.2, 0.0]])
    moves = [
        # depth, last, direction, to -> depth, pushed, direction
        ((0, 0.0, 0, 0.0), (0, 0, 0)),  # rest
        ((0, 0.0, 0, -3.0), (0, 0, -1)),  # first loading
        ((0, 2.0, 1, 2.0), (0, 0, 1)),  # held: the direction stays
        ((0, 2.0, 1, 1.0), (1, 1, -1)),  # a turn
        ((0, 2.0, 1, -1.9), (1, 1, -1)),
        ((0, 2.0, 1, -2.0), (0, 0, -1)),  # the mirror point of the turn: first loading again
        ((1, 0.5, -1, -0.99), (1, 0, -1)),  # on the branch from the first reversal
        ((1, 0.5, -1, -1.0), (0, 0, -1)),
        ((1, 0.5, -1, 0.7), (2, 1, 1)),  # a turn on it
        ((1, 0.5, -1, 1.0), (0, 0, 1)),  # back to where it began, and on
        ((1, 0.5, -1, 1.5), (0, 0, 1)),
        ((2, 0.0, 1, 0.99), (2, 0, 1)),
        ((2, 0.0, 1, 1.0), (0, 0, 1)),  # its loop closes and with it the last memory
        ((2, 0.0, 1, -0.49), (3, 1, -1)),
        ((2, 0.0, 1, -0.5), (1, 0, -1)),  # a loop without inner samples closes
        ((2, 0.0, 1, -1.0), (0, 0, -1)),
        ((3, 0.1, -1, -0.49), (3, 0, -1)),
        ((3, 0.1, -1, -0.5), (1, 0, -1)),
        ((3, 0.1, -1, 0.4), (2, 0, 1)),
        ((3, 0.1, -1, 1.0), (0, 0, 1)),  # two loops at once
        ((4, 0.0, 1, 0.41), (2, 0, 1)),
        ((4, 0.0, 1, -0.2), (3, 0, -1)),
        ((4, 0.0, 1, -0.6), (1, 0, -1)),
        ((4, 0.0, 1, -5.0), (0, 0, -1)),
    ]
    for (depth, last, direction, to), wanted in moves:
        got = compiled.locate(to, stack, depth, last, direction)
        assert got == wanted, (depth, last, direction, to)


# Polynomials and moments


@pytest.mark.parametrize("table", tables())
def test_tables(table):
    _, inverse_width, power, _, _ = table
    panels = table[0].size // kernels.TERMS
    end = panels / inverse_width
    rng = np.random.default_rng(1)
    edges = np.arange(panels + 1) / inverse_width
    u = np.concatenate(
        (
            [0.0, 5e-324, 1e-300, np.nextafter(end, 0), end, np.nextafter(end, 1), 1e3 * end],
            edges,
            np.nextafter(edges, np.inf),
            end * rng.random(20_000),
            end * np.geomspace(1e-20, 10, 200),
        )
    )
    value, slope, alone = np.empty(u.size), np.empty(u.size), np.empty(u.size)
    compiled.evaluate(u, value, slope, *table)
    compiled.evaluate(u, alone, None, *table)
    np.testing.assert_array_equal(value, alone)
    for i in range(0, u.size, 101):
        assert compiled.evaluate_one(float(u[i]), *table) == (value[i], slope[i])
        wanted, grade = table_at(float(u[i]), *table)
        assert value[i] == pytest.approx(wanted, rel=1e-14, abs=0)
        assert slope[i] == pytest.approx(grade, rel=1e-11, abs=1e-13 * np.abs(slope).max())
    # It meets itself at the edges of its panels and where it ends.
    inner = edges[1:]
    left, right = np.empty(panels), np.empty(panels)
    compiled.evaluate(np.nextafter(inner, 0), left, None, *table)
    compiled.evaluate(np.nextafter(inner, np.inf), right, None, *table)
    np.testing.assert_allclose(left, right, rtol=1e-14)
    assert value[0] == 0
    # Towards zero it is a power: relative accuracy to the end.
    small, double = np.empty(50), np.empty(50)
    tiny = end * np.geomspace(1e-60, 1e-16, 50)
    compiled.evaluate(tiny, small, None, *table)
    compiled.evaluate(2 * tiny, double, None, *table)
    np.testing.assert_allclose(double / small, 2.0**power, rtol=1e-14)


@pytest.mark.parametrize("twice", range(-1, 6))
def test_pieces_of_moments_meet(twice):
    for seam in (-10.0, -4.0, 0.0):
        sides = np.array([np.nextafter(seam, -np.inf), seam])
        out = kernels.gaussian_moment(sides, twice)
        np.testing.assert_allclose(out[0], out[1], rtol=1e-14)
        assert kernels.gaussian_moment_at(seam, twice) == out[1]


@given(data=st.data(), size=st.integers(1, 40), open_ends=st.integers(0, 5))
def test_accumulate(data, size, open_ends):
    parent = np.array(
        [data.draw(st.integers(-2 - open_ends, max(i - 1, -1))) for i in range(size)], np.int64
    )
    rise = np.array([data.draw(st.floats(-1, 1)) for _ in range(size)])
    base = np.array([data.draw(st.floats(-1, 1)) for _ in range(open_ends + 1)])
    wanted = rise.copy()
    for i, p in enumerate(parent):
        wanted[i] += wanted[p] if p >= 0 else 0.0 if p == -1 else base[-2 - p]
    compiled.accumulate(parent, rise, base)
    np.testing.assert_array_equal(rise, wanted)


def stops_in_small_steps(x, shift, y, fine=400):
    """A stop element moved in small straight steps along two cycles; ends and means of steps."""
    state, ends, means = min(max(y + shift[0], 0.0), x[0]), np.zeros(x.size), np.zeros(x.size)
    for step in range(1, 2 * x.size + 1):
        i, before, total = step % x.size, (step - 1) % x.size, 0.0
        for part in range(fine):
            limit = y + shift[before] + (part + 1) / fine * (shift[i] - shift[before])
            moved = 0.0 if limit <= 0.0 else state + (x[i] - x[before]) / fine
            new = min(max(moved, -limit), limit) if limit > 0.0 else 0.0
            total += 0.5 * (state + new) / fine
            state = new
        ends[i], means[i] = state, total
    return ends, means


@given(seed=st.integers(0, 200), size=st.integers(3, 30), ripple=st.floats(0.0, 2.0))
@settings(max_examples=40)
def test_stops(seed, size, ripple):
    """Elements that yield, enter and leave as their limits move."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * np.arange(size) / size
    x, shift = np.cos(angle), ripple * np.sin(angle * rng.integers(1, 3) + rng.uniform(0.0, 6.0))
    y = rng.uniform(-0.5, 1.5, 5)
    values, means = np.empty((2, size, y.size))
    none = np.zeros(size)
    compiled.stops(x - np.roll(x, 1), none, shift, none, y, 1.0, values, means)
    for j, one in enumerate(y):
        ends, wanted = stops_in_small_steps(x, shift, float(one))
        np.testing.assert_allclose(values[:, j], ends, atol=0.02)
        np.testing.assert_allclose(means[:, j], wanted, atol=0.02)


@pytest.mark.parametrize(("size", "error"), [(24, 2.5e-3), (96, 2e-4)])
def test_stops_bend_within_a_step(size, error):
    """A coarse cosine with its bends has the means of a fine one, with an error of second order."""
    fine, y = 4800, np.array([0.1, 0.4, 0.9, 5.0])
    columns = []
    for n in (size, fine):
        angle = 2.0 * np.pi * np.arange(n) / n
        middle = angle - np.pi / n
        x, shift = np.cos(angle), 0.2 * np.sin(angle)
        bend = (2.0 * np.cos(middle) - x - np.roll(x, 1)) / 3.0
        shift_bend = (0.4 * np.sin(middle) - shift - np.roll(shift, 1)) / 3.0
        values, means = np.empty((2, n, y.size))
        move = x - np.roll(x, 1)
        compiled.stops(move, bend, shift, shift_bend, y, 1.0, values, means)
        columns.append(np.roll(means, -1, axis=0).reshape(size, -1, y.size).mean(axis=1))
    np.testing.assert_allclose(columns[0], columns[1], atol=error)


# Load curves and memory diagrams


def curve():
    return JOINT._load_curve.profile(-1e-6, 2e-6)


def drive(seed, size=400):
    """Separations and places of every kind: held, in leaps, beyond the curve, again and again."""
    rng = np.random.default_rng(seed)
    length = REACH / JOINT.slip_per_indentation
    d = np.where(rng.random(size) < 0.3, 0.0, rng.choice([0.01, 0.3, 1.0]) * rng.normal(size=size))
    d = np.clip(length * (np.cumsum(d) if seed % 2 else d), -9e-7, 1.9e-6)
    d[rng.random(size) < 0.01] = 1.0  # far beyond
    x = length * rng.choice([1e-6, 0.1, 1.0, 5.0]) * rng.normal(size=size)
    x[rng.random(size) < 0.2] = 0.0
    return np.ascontiguousarray(d), np.ascontiguousarray(np.cumsum(x) if seed % 3 else x)


def rows_of(n):
    return np.full((n, 3), np.nan), np.full(n, np.nan)


def test_curves():
    profile = curve()
    plain = Curve(*profile.arguments)
    rng = np.random.default_rng(3)
    edges = profile.anchor + np.arange(-5, 90) / profile.inverse_width
    d = np.concatenate((rng.uniform(profile.low, 9e-6, 5000), edges, [1.0, 1e40]))
    d = d[d >= profile.low]
    w = 10.0 ** rng.uniform(-16, -5, d.size)
    w[::7] = 0.0
    load, fall, drop, alone, excess = (np.empty(d.size) for _ in range(5))
    compiled.loads(d, load, fall, *profile.arguments)
    compiled.loads(d, alone, None, *profile.arguments)
    np.testing.assert_array_equal(load, alone)
    compiled.drops(d, w, drop, *profile.arguments)
    compiled.excesses(d, w, excess, *profile.arguments)
    most, steepest = load.max(), fall.max()
    for i in range(0, d.size, 17):
        here, steep = plain.load(float(d[i]))
        there, steep_there = plain.load(float(d[i] + w[i]))
        assert load[i] == pytest.approx(here, rel=1e-13, abs=1e-15 * most)
        assert fall[i] == pytest.approx(steep, rel=1e-12, abs=1e-14 * steepest)
        assert drop[i] == pytest.approx(here - there, rel=1e-12, abs=1e-14 * most)
        wanted = here - there - w[i] * steep_there
        assert excess[i] == pytest.approx(wanted, rel=1e-12, abs=1e-14 * most)
    # What differences of N would lose: of the smallest widths the drop is a slope.
    tiny = (w < 1e-14) & (w > 0.0) & (fall > 0.0)
    np.testing.assert_allclose(drop[tiny] / w[tiny], fall[tiny], rtol=1e-6)
    loads, found = rng.uniform(*profile.span, 5000), np.empty(5000)
    compiled.separations(loads, found, *profile.arguments, *profile._inverse)
    np.testing.assert_allclose(profile.load(found), loads, rtol=1e-13)


@pytest.mark.parametrize("seed", range(12))
def test_diagrams(seed):
    """Against plain pieces, in one go, in pieces and step by step."""
    d, x = drive(seed)
    d = np.minimum(d, 9e-6)
    arguments, n = curve().arguments, d.size
    stack, values = rows_of(n)
    value = np.empty(n)
    end = compiled.coupled(d, x, value, stack, values, 0, 0.0, 0.0, *arguments)
    scale = JOINT.surface.load(JOINT.separation - 9e-7)
    # Both round places, which grow along a record that walks away.
    reach = np.abs(x).max() + np.abs(d).max()
    atol = (1e-13 + 4e-16 * reach * JOINT.normal_stiffness / JOINT.normal_load) * scale
    np.testing.assert_allclose(value, coupled(d, x, Curve(*arguments)), rtol=0, atol=atol)
    stack, values = rows_of(n)
    state = (0, 0.0, 0.0)
    for i in range(0, n, 37):
        out = np.empty(d[i : i + 37].size)
        state = compiled.coupled(
            d[i : i + 37], x[i : i + 37], out, stack, values, *state, *arguments
        )
        np.testing.assert_allclose(out, value[i : i + 37], rtol=0, atol=1e-14 * scale)
        if state[0]:
            before = stack.copy(), values.copy()
            for to in ((state[1] - 1e-8, x[i]), (state[1] + 1e-7, x[i]), (state[1], x[0])):
                step = compiled.coupled_step(*to, stack, values, *state, *arguments)
                after, again = np.empty(1), (stack.copy(), values.copy())
                compiled.coupled(*(np.array([v]) for v in to), after, *again, *state, *arguments)
                assert step[4] == after[0]
            np.testing.assert_array_equal(stack, before[0])
            np.testing.assert_array_equal(values, before[1])
    assert state == end


@pytest.mark.parametrize("seed", range(3))
def test_losses_are_the_integrals_over_the_runs(seed):
    d, x = drive(seed)
    plain, n = Curve(*curve().arguments), 50
    d, x = np.minimum(d[:n], 4e-6), x[:n]
    loss, runs = np.empty(n), np.empty((9 * n, 8))
    compiled.losses(d, x, loss, rows_of(n)[0], 0, 0.0, 0.0, curve().loss_rules, *curve().arguments)
    count = compiled.slips(d, x, runs, rows_of(n)[0], 0, 0.0, 0.0)
    assert compiled.slips(d, x, runs[:0], rows_of(n)[0], 0, 0.0, 0.0) == count < len(runs)
    nodes, weights = np.polynomial.legendre.leggauss(10)
    parts = np.arange(24)[:, None] / 24.0
    nodes, weights = (parts + 0.5 * (1.0 + nodes) / 24.0).ravel(), np.tile(weights / 48.0, 24)
    wanted, rounding = np.zeros((2, n))
    for sample, ahead, gap, until, density, sign, first, last in runs[:count].tolist():
        for node, weight in zip(nodes, weights, strict=True):
            separation = first + node * (last - first)
            front = separation + gap + node * (until - gap)
            (here, _), (there, steep) = plain.load(separation), plain.load(front)
            lost = here - there - steep * (front - separation)
            wanted[int(sample)] += weight * ahead * (1.0 - sign * density) * lost
            rounding[int(sample)] += weight * ahead * 1e-15 * (here + steep * (front - separation))
    # Rules of 16 nodes for 16 panels have 1e-6 where a step is as long as the whole curve.
    np.testing.assert_array_less(np.abs(loss - wanted), 1e-6 * wanted + rounding + 1e-300)
    assert loss.min() >= 0.0


@pytest.mark.parametrize("seed", range(6))
def test_hold_is_the_inverse(seed):
    rng = np.random.default_rng(seed)
    arguments = curve().arguments
    d = rng.uniform(-9e-7, 1.9e-6, 200) if seed % 2 else 1e-6 * np.sin(0.1 * np.arange(200.0))
    load = np.empty(d.size)
    compiled.loads(d, load, None, *arguments)
    share = 0.999 * rng.uniform(-1, 1, d.size) if seed % 3 else 0.9 * np.sin(0.03 * np.arange(200))
    wanted = share * load
    place, out, other = np.empty(d.size), np.empty(d.size), np.empty(d.size)
    end = compiled.hold(d, wanted, place, *rows_of(d.size), 0, 0.0, 0.0, 0.0, *arguments)
    compiled.coupled(d, place, out, *rows_of(d.size), 0, 0.0, 0.0, *arguments)
    np.testing.assert_allclose(out, wanted, rtol=0, atol=1e-13 * load.max())
    assert end[1:3] == (d[-1], place[-1])
    # Any curve, asked one question at a time.
    compiled.hold(d, wanted, other, *rows_of(d.size), 0, 0.0, 0.0, 0.0, Curve(*arguments))
    compiled.coupled(d, other, out, *rows_of(d.size), 0, 0.0, 0.0, *arguments)
    np.testing.assert_allclose(out, wanted, rtol=0, atol=1e-11 * load.max())


class Panels:
    """The curve of a profile as one that is asked."""

    def __init__(self, arguments):
        self.arguments, self.calls = arguments, 0

    def drop(self, base, width):
        self.calls += 1
        out = np.empty(base.size)
        compiled.drops(base, width, out, *self.arguments)
        return out

    def load(self, separation):
        self.calls += 1
        load, fall = np.empty(separation.size), np.empty(separation.size)
        compiled.loads(separation, load, fall, *self.arguments)
        return load, fall


@pytest.mark.parametrize("seed", range(4))
def test_any_curve_answers_all_questions_at_once(seed):
    """The same numbers as from its profile, to the last bit, and the states as they should be."""
    d, x = drive(seed)
    profile, n, panels = curve().arguments, d.size, Panels(curve().arguments)
    ends = []
    for arguments in (profile, kernels.curve_arguments(panels)):
        stack, values = rows_of(n)
        out = np.empty(n)
        half = n // 2
        state = compiled.coupled(
            d[:half], x[:half], out[:half], stack, values, 0, 0.0, 0.0, *arguments
        )
        state = compiled.coupled(d[half:], x[half:], out[half:], stack, values, *state, *arguments)
        step = compiled.coupled_step(1e-7, 1e-6, stack, values, *state, *arguments)
        ends.append((out, stack[: state[0]], values[: state[0]], state, step))
    for one, other in zip(*ends, strict=True):
        np.testing.assert_array_equal(one, other)
    assert panels.calls <= 6
    nodes, samples, rows = 7, 16, 3
    rng = np.random.default_rng(seed)
    place, step = 1e-6 * rng.normal(size=(2, nodes, samples))
    rest, basis = 1e-7 * rng.normal(size=nodes), rng.normal(size=(samples, rows))
    found = []
    for arguments in (profile, kernels.curve_arguments(panels)):
        for moves in (None, step):
            out = [np.empty((nodes, samples)) for _ in range(3)]
            compiled.field_cycle(place, moves, rest, samples, *out, *arguments)
            steps = 0 if moves is None else rows
            spectra = [
                np.empty(shape)
                for shape in (
                    (nodes, rows), (nodes, rows, rows + steps), (nodes, rows), (nodes, rows, steps),
                )
            ]  # fmt: skip
            compiled.field_slopes(
                place, moves, rest, samples, basis, rows, basis[:, :steps].copy(), steps, 0, basis,
                rows, *spectra, *arguments,
            )  # fmt: skip
            found += out + spectra
    for one, other in zip(found[: len(found) // 2], found[len(found) // 2 :], strict=True):
        np.testing.assert_array_equal(one, other)


def test_errors_of_a_curve_are_raised():
    class Wrong:
        def drop(self, base, width):
            raise ZeroDivisionError("no drop")

        def load(self, separation):
            raise ZeroDivisionError("no load")

    stack, values = rows_of(4)
    out, one = np.empty(2), np.array([1e-7, 3e-7])
    for kernel, last, curves in (
        (compiled.coupled, (), kernels.curve_arguments(Wrong())),
        (compiled.hold, (0.0,), (Wrong(),)),
    ):
        with pytest.raises(ZeroDivisionError, match="no "):
            kernel(0.0 * one, one, out, stack, values, 0, 0.0, 0.0, *last, *curves)
    with pytest.raises(TypeError):  # what slip loses is asked of panels alone
        compiled.losses(
            one, one, out, stack, 0, 0.0, 0.0, curve().loss_rules, *kernels.curve_arguments(Wrong())
        )
    with pytest.raises(TypeError, match="coupled_step"):
        compiled.coupled_step(0.0)


@pytest.mark.parametrize("seed", range(20))
def test_sliders_are_dragged(seed):
    """One slider: where it ends and what it loses; first order in parts."""
    rng = np.random.default_rng(seed)
    first, last = rng.uniform(0.2, 1.0, 2)
    if seed % 2:
        last = first
    held = first * rng.uniform(0.0, 1.0) * np.array([np.cos(seed), np.sin(seed)])
    step = rng.normal(size=2) * rng.choice([0.1, 1.0, 3.0])
    new, value, tangent, loss = np.empty((1, 1, 2)), np.empty(2), np.empty((2, 3)), np.empty(1)
    place = (
        step, None if first == last else np.array([1.0 - last]), np.zeros(2),
        np.array([1.0 - first]), held, np.ones(1), np.ones(1),
    )  # fmt: skip
    compiled.vector_try(*place, None, new, value, tangent)
    end, lost = drag(tuple(held), tuple(step), first, last, 20_000)
    np.testing.assert_allclose(new.ravel(), end, rtol=0, atol=3e-4)
    np.testing.assert_array_equal(value, new.ravel())
    compiled.vector_losses(held, step, np.array([first]), np.array([last]), None, loss)
    assert loss[0] == pytest.approx(lost, abs=1e-3)
    for soft in (1.0, 1.4):  # under a lay the end is found in pieces
        axis = rng.uniform(0.0, np.pi)
        c, s = np.cos(axis), np.sin(axis)
        lay = np.array([1.0, soft, c, s])
        stiffness = (c * c + s * s / soft, c * s * (1.0 - 1.0 / soft), s * s + c * c / soft)
        end, lost = drag(tuple(held), tuple(step), first, last, 20_000, stiffness)
        compiled.vector_try(*place, lay, new, value, tangent)
        np.testing.assert_allclose(new.ravel(), end, rtol=0, atol=0.02)
        compiled.vector_losses(held, step, np.array([first]), np.array([last]), lay, loss)
        assert loss[0] == pytest.approx(lost, abs=0.01 * np.hypot(*step))


def test_short_buffers_are_refused():
    """Nothing is read or written past the end of a buffer."""
    profile = curve()
    a, d, x, out = profile.arguments, np.zeros(4), np.zeros(4), np.empty(4)
    short, stack, values = np.empty(3), np.empty((4, 3)), np.empty(4)
    none, five = (np.empty(0), *a[1:]), np.ones(5)
    pointwise, (bends, tails) = pointwise_of(rough(ms.Gaussian(1.0)))._profile
    calls = [
        lambda: compiled.loads(d, short, None, *a),
        lambda: compiled.loads(d, out, short, *a),
        lambda: compiled.loads(d, out, None, *none),
        lambda: compiled.drops(d, short, out, *a),
        lambda: compiled.drops(d, x, short, *a),
        lambda: compiled.drops(d, x, out, *none),
        lambda: compiled.separations(d, short, *a, *profile._inverse),
        lambda: compiled.separations(d, out, *a, np.empty(0), 1.0, 0.0),
        lambda: compiled.coupled(d, short, out, stack, values, 0, 0.0, 0.0, *a),
        lambda: compiled.coupled(d, x, short, stack, values, 0, 0.0, 0.0, *a),
        lambda: compiled.coupled(d, x, out, stack, values, 1, 0.0, 0.0, *a),
        lambda: compiled.coupled(d, x, out, stack, short, 0, 0.0, 0.0, *a),
        lambda: compiled.coupled(d, x, out, stack, values, -1, 0.0, 0.0, *a),
        lambda: compiled.coupled(d, x, out, stack, values, 0, 0.0, 0.0, *none),
        lambda: compiled.coupled_step(0.0, 0.0, stack, values, 5, 0.0, 0.0, *a),
        lambda: compiled.losses(d, x, out, stack, 1, 0.0, 0.0, curve().loss_rules, *a),
        lambda: compiled.losses(d, x, out, stack, 0, 0.0, 0.0, np.empty(55), *a),
        lambda: compiled.hold(d, x, short, stack, values, 0, 0.0, 0.0, 0.0, *a),
        lambda: compiled.hold(d, x, out, stack, values, 1, 0.0, 0.0, 0.0, *a),
        *(
            lambda given=given: compiled.cycle_energies(*given, out, *pointwise.arguments)
            for given in (
                (five, x, five, bends, tails),
                (five, five, x, bends, tails),
                (five, five, five, bends[1:], tails),
                (five, five, five, bends, tails[1:]),
            )
        ),
    ]
    for call in calls:
        with pytest.raises(ValueError, match="too short"):
            call()


@pytest.mark.slow
def test_long_records():
    """A million samples: what turns at every one, and what seldom turns."""
    rng = np.random.default_rng(9)
    t = np.arange(1_000_000)
    for x in (rng.normal(size=t.size), np.sin(t * 1e-3) + 0.3 * np.sin(t * 0.0173), np.sin(t)):
        x = np.ascontiguousarray(x * REACH)
        alike(by_branches(x, Memory())[:2], by_respond(x, Memory()))


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="None is immortal from Python 3.12 on")
def test_none_keeps_its_references():
    """Headers of later Pythons must not build a module that takes them away from this one."""
    value, base = np.zeros(1), np.zeros(1)
    parent = np.full(1, -1)
    before = sys.getrefcount(None)
    for _ in range(2000):
        compiled.accumulate(parent, value, base)
    assert abs(sys.getrefcount(None) - before) < 1000
