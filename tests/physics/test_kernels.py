"""The two kernels against each other, each against itself on another road, and plain Python."""

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

from microslip import kernels
from microslip.kernels import twin, twin_profile
from microslip.kernels.profile import LOSS_RULES

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


def by_respond(module, x, memory):
    depth = len(memory.places)
    stack = np.full((depth + x.size + 1, 2), np.nan)
    stack[:depth, 0], stack[:depth, 1] = memory.places, memory.values
    out = np.full(x.size, np.nan)
    depth, last, value, direction = module.respond(
        x, out, stack, depth, memory.last, memory.value, memory.direction, *TABLE
    )
    places, values = stack[:depth].T.tolist()
    return out, Memory(places, values, last, value, direction)


def by_branches(module, x, memory):
    depth, base = len(memory.places), np.array([*memory.values, memory.value])
    places, codes = np.full(depth + x.size + 1, np.nan), np.zeros(depth + x.size + 1, np.int64)
    places[:depth], codes[:depth] = memory.places, -2 - np.arange(depth)
    half, sign = np.full(x.size, np.nan), np.full(x.size, np.nan)
    parent = np.full(x.size, -99, np.int64)
    depth, last, direction = module.branches(
        x, half, sign, parent, places, codes, depth, memory.last, memory.direction
    )
    # A parent comes before its child, or from the memory.
    assert np.all(parent < np.arange(x.size))
    assert np.all(parent >= -2 - len(memory.places))
    values = np.empty(x.size)
    module.evaluate(half, values, None, *TABLE)
    values *= sign
    module.accumulate(parent, values, base)
    kept = [float(values[c]) if c >= 0 else float(base[-2 - c]) for c in codes[:depth]]
    memory = Memory(places[:depth].tolist(), kept, last, float(values[-1]), direction)
    return values, memory, (half, sign, parent)


def by_locate(module, x, memory):
    depth = len(memory.places)
    stack = np.full((depth + x.size + 1, 2), np.nan)
    stack[:depth, 0], stack[:depth, 1] = memory.places, memory.values
    last, value, direction, out = memory.last, memory.value, memory.direction, []
    for v in x.tolist():
        depth, pushed, direction = module.locate(v, stack, depth, last, direction)
        if pushed:
            stack[depth - 1] = last, value
        if depth:
            place, start = stack[depth - 1]
            rise = 2 * module.evaluate_one(0.5 * abs(v - place), *TABLE)[0]
            value = start + rise if direction > 0 else start - rise
        else:
            value = float(np.copysign(module.evaluate_one(abs(v), *TABLE)[0], v))
        last = v
        out.append(value)
    places, values = stack[:depth].T.tolist()
    return np.array(out), Memory(places, values, last, value, direction)


def in_pieces(road, module, x, cuts):
    memory, out = Memory(), []
    for piece in np.split(x, cuts):
        if piece.size:
            values, memory, *_ = road(module, np.ascontiguousarray(piece), memory)
            out.append(values)
    return np.concatenate(out), memory


def alike(first, second):
    np.testing.assert_allclose(first[0], second[0], rtol=0, atol=ROUNDING * LIMIT)
    one, other = first[1], second[1]
    assert (one.places, one.last, one.direction) == (other.places, other.last, other.direction)
    np.testing.assert_allclose(one.values, other.values, rtol=0, atol=ROUNDING * LIMIT)


def plain_madelung(x):
    """Third witness: a list of turning points, taken up anew from the rules, branch by branch."""

    def backbone(u):
        value = twin.evaluate_one(abs(u), *TABLE)[0]
        return value if u >= 0 else -value

    turns: list[tuple[float, float]] = []
    here, force, way, out = 0.0, 0.0, 0, []
    for v in x.tolist():
        step = (v > here) - (v < here)
        if step and way and step != way:
            turns.append((here, force))
        if step:
            way = step
            # A small loop is closed where its own beginning is reached again: forget both ends.
            while len(turns) >= 2 and (v - turns[-2][0]) * way >= 0:
                del turns[-2:]
            # The first loading curve is met again opposite to where it was left.
            if len(turns) == 1 and abs(v) >= abs(turns[0][0]):
                turns.clear()
        if turns:
            place, start = turns[-1]
            force = start + 2 * backbone((v - place) / 2)
        else:
            force = backbone(v)
        here = v
        out.append(force)
    return np.array(out), [t[0] for t in turns]


def check_all(x, cuts, compiled):
    x = np.ascontiguousarray(x * REACH)
    wanted = by_respond(compiled, x, Memory())
    for module in (compiled, twin):
        for road in (by_respond, by_branches, by_locate):
            alike(in_pieces(road, module, x, cuts), wanted)
    values, open_places = plain_madelung(x)
    np.testing.assert_allclose(values, wanted[0], rtol=0, atol=ROUNDING * LIMIT)
    assert open_places == wanted[1].places
    trees = [by_branches(module, x, Memory())[2] for module in (compiled, twin)]
    for one, other in zip(*trees, strict=True):
        np.testing.assert_array_equal(one, other)
    return x, wanted


@pytest.mark.parametrize("name", RECORDS)
def test_every_road_on_every_kind_of_record(name, compiled):
    record = RECORDS[name]
    rng = np.random.default_rng(len(name))
    cuts = np.sort(rng.integers(0, record.size, 12))
    x, wanted = check_all(record, cuts, compiled)
    # And against a search of the whole past, at some places.
    path = x.tolist()
    for i in range(0, min(x.size, 300), 7):
        extremes = dominant_extremes(path[: i + 1])
        force = np.copysign(twin.evaluate_one(abs(extremes[0]), *TABLE)[0], extremes[0])
        for a, b in pairwise(extremes):
            rise = 2 * twin.evaluate_one(abs(b - a) / 2, *TABLE)[0]
            force += rise if b > a else -rise
        assert abs(wanted[0][i] - force) <= ROUNDING * LIMIT


many = settings(max_examples=5 * settings.default.max_examples)


@many
@given(x=records(max_size=80), cuts=st.lists(st.integers(0, 80), max_size=8))
def test_every_road_on_records_by_chance(x, cuts, compiled):
    check_all(x, sorted(min(c, x.size) for c in cuts), compiled)


@many
@given(past=records(max_size=30), x=records(max_size=10))
def test_from_any_memory(past, x, compiled):
    """One move from a memory with a history, on each road."""
    past, x = past * REACH, np.ascontiguousarray(x * REACH)
    for v in x:
        ends = []
        for module in (compiled, twin):
            memory = by_respond(module, past, Memory())[1]
            one = np.array([v])
            ends += [road(module, one, memory)[:2] for road in (by_respond, by_locate, by_branches)]
        for end in ends[1:]:
            alike(end, ends[0])


def test_locate_leaves_its_stack_alone(compiled):
    for module in (compiled, twin):
        stack = np.array([[1.0, 10.0], [-0.5, 3.0], [0.4, 5.0], [7.0, 7.0]])
        before = stack.copy()
        for v in (-2.0, -1.0, -0.6, -0.5, -0.1, 0.1, 0.3, 0.4, 0.5, 1.0, 1.2):
            for direction, last in ((-1, 0.1), (1, 0.35)):
                module.locate(v, stack, 3, last, direction)
        np.testing.assert_array_equal(stack, before)


def test_the_rules_one_by_one(compiled):
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
    for module in (compiled, twin):
        for (depth, last, direction, to), wanted in moves:
            got = module.locate(to, stack, depth, last, direction)
            assert tuple(int(v) for v in got) == wanted, (depth, last, direction, to)


# Polynomials and moments


@pytest.mark.parametrize("table", tables())
def test_tables_alike(table, compiled):
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
    results = []
    for module in (compiled, twin):
        value, slope, alone = np.empty(u.size), np.empty(u.size), np.empty(u.size)
        module.evaluate(u, value, slope, *table)
        module.evaluate(u, alone, None, *table)
        np.testing.assert_array_equal(value, alone)
        for i in range(0, u.size, 501):
            assert module.evaluate_one(float(u[i]), *table) == (value[i], slope[i])
        results.append((value, slope))
    (value, slope), (other, other_slope) = results
    np.testing.assert_allclose(other, value, rtol=1e-14)
    np.testing.assert_allclose(other_slope, slope, rtol=1e-11, atol=1e-13 * np.abs(slope).max())
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
def test_moments_alike(twice, compiled):
    rng = np.random.default_rng(2)
    seams = np.array([-10.0, -4.0, 0.0, 1e3])
    h = np.concatenate(
        (
            rng.uniform(-60, 37, 20_000),
            seams,
            np.nextafter(seams, -np.inf),
            np.nextafter(seams, np.inf),
            [-1e100, -1e3, 38.0, 1e6, 1e300],
        )
    )
    coefficients, results = kernels._moment_coefficients(twice), []
    for module in (compiled, twin):
        out = np.full(h.size, np.nan)
        module.gaussian_moment(h, out, coefficients, twice)
        results.append(out)
    np.testing.assert_allclose(results[1], results[0], rtol=1e-14, atol=1e-305)
    # The pieces meet.
    for seam in seams[:3]:
        sides = np.array([np.nextafter(seam, -np.inf), seam])
        out = np.empty(2)
        compiled.gaussian_moment(sides, out, coefficients, twice)
        np.testing.assert_allclose(out[0], out[1], rtol=1e-14)


@given(data=st.data(), size=st.integers(1, 40), open_ends=st.integers(0, 5))
def test_accumulate_alike(data, size, open_ends, compiled):
    parent = np.array(
        [data.draw(st.integers(-2 - open_ends, max(i - 1, -1))) for i in range(size)], np.int64
    )
    rise = np.array([data.draw(st.floats(-1, 1)) for _ in range(size)])
    base = np.array([data.draw(st.floats(-1, 1)) for _ in range(open_ends + 1)])
    wanted = rise.copy()
    for i, p in enumerate(parent):
        wanted[i] += wanted[p] if p >= 0 else 0.0 if p == -1 else base[-2 - p]
    for module in (compiled, twin):
        got = rise.copy()
        module.accumulate(parent, got, base)
        np.testing.assert_allclose(got, wanted, rtol=0, atol=ROUNDING)


# Load curves and memory diagrams


def curve():
    return JOINT._coupling.profile(-1e-6, 2e-6)


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


def test_curves_alike(compiled):
    profile = curve()
    inverse = profile._inverse
    rng = np.random.default_rng(3)
    edges = profile.anchor + np.arange(-5, 90) / profile.inverse_width
    d = np.concatenate((rng.uniform(profile.low, 9e-6, 5000), edges, [1.0, 1e40]))
    d = d[d >= profile.low]
    w = 10.0 ** rng.uniform(-16, -5, d.size)
    w[::7] = 0.0
    loads = rng.uniform(*profile.span, 5000)
    results = []
    for module in (compiled, twin):
        load, fall, drop = np.empty(d.size), np.empty(d.size), np.empty(d.size)
        alone, there = np.empty(d.size), np.empty(loads.size)
        module.loads(d, load, fall, *profile.arguments)
        module.loads(d, alone, None, *profile.arguments)
        np.testing.assert_array_equal(load, alone)
        module.drops(d, w, drop, *profile.arguments)
        module.separations(loads, there, *profile.arguments, *inverse)
        results.append((load, fall, drop, there))
    for one, other in zip(*results, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14, atol=1e-15 * np.abs(other).max())
    for i in range(0, d.size, 97):
        drop = twin_profile.drop_at(float(d[i]), float(w[i]), *profile.arguments)
        assert drop == pytest.approx(results[0][2][i], rel=1e-14, abs=0)
        load, fall = twin_profile.load_at(float(d[i]), *profile.arguments)
        assert (load, fall) == pytest.approx((results[0][0][i], results[0][1][i]), rel=1e-14)


@pytest.mark.parametrize("seed", range(12))
def test_coupled_alike(seed, compiled):
    """Both kernels, in one piece, in pieces and step by step; losses and force control."""
    d, x = drive(seed)
    arguments, n = curve().arguments, d.size
    ends = []
    for module in (compiled, twin):
        stack, values = rows_of(n)
        out = np.empty(n)
        end = module.coupled(d, x, out, stack, values, 0, 0.0, 0.0, *arguments)
        ends.append((out, end, stack[: end[0]], values[: end[0]]))
    scale = JOINT.surface.load(JOINT.separation - 9e-7)
    for one, other in zip(*ends, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-14 * scale)
    np.testing.assert_array_equal(ends[0][2], ends[1][2])  # geometry to the last bit
    value = ends[0][0]
    for module in (compiled, twin):
        stack, values = rows_of(n)
        state = (0, 0.0, 0.0)
        for i in range(0, n, 37):
            out = np.empty(d[i : i + 37].size)
            state = module.coupled(
                d[i : i + 37], x[i : i + 37], out, stack, values, *state, *arguments
            )
            np.testing.assert_allclose(out, value[i : i + 37], rtol=0, atol=1e-14 * scale)
            if state[0]:
                before = stack.copy(), values.copy()
                for to in ((state[1] - 1e-8, x[i]), (state[1] + 1e-7, x[i]), (state[1], x[0])):
                    steps = [
                        m.coupled_step(*to, stack, values, *state, *arguments)
                        for m in (compiled, twin)
                    ]
                    assert steps[0][:4] == steps[1][:4]
                    np.testing.assert_allclose(*steps, rtol=1e-12, atol=1e-14 * scale)
                np.testing.assert_array_equal(stack, before[0])
                np.testing.assert_array_equal(values, before[1])
    lost = []
    for module in (compiled, twin):
        loss = np.empty(n)
        module.losses(d, x, loss, rows_of(n)[0], 0, 0.0, 0.0, LOSS_RULES, *arguments)
        assert loss.min() >= 0.0
        lost.append(loss)
    np.testing.assert_allclose(*lost, rtol=1e-9, atol=1e-14 * lost[0].max())


@pytest.mark.parametrize("seed", range(6))
def test_hold_alike(seed, compiled):
    rng = np.random.default_rng(seed)
    profile = curve()
    d = rng.uniform(-9e-7, 1.9e-6, 200) if seed % 2 else 1e-6 * np.sin(0.1 * np.arange(200.0))
    load = np.empty(d.size)
    compiled.loads(d, load, None, *profile.arguments)
    share = 0.999 * rng.uniform(-1, 1, d.size) if seed % 3 else 0.9 * np.sin(0.03 * np.arange(200))
    wanted = share * load
    found = []
    for module in (compiled, twin):
        place, out = np.empty(d.size), np.empty(d.size)
        end = module.hold(d, wanted, place, *rows_of(d.size), 0, 0.0, 0.0, 0.0, *profile.arguments)
        module.coupled(d, place, out, *rows_of(d.size), 0, 0.0, 0.0, *profile.arguments)
        np.testing.assert_allclose(out, wanted, rtol=0, atol=1e-13 * load.max())
        assert end[1:3] == (d[-1], place[-1])
        found.append(place)
    np.testing.assert_allclose(*found, rtol=0, atol=1e-11 * np.abs(found[0]).max())


def test_short_buffers_are_refused(compiled):
    """Nothing is read or written past the end of a buffer."""
    profile = curve()
    a, d, x, out = profile.arguments, np.zeros(4), np.zeros(4), np.empty(4)
    short, stack, values = np.empty(3), np.empty((4, 3)), np.empty(4)
    none = (np.empty(0), *a[1:])
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
        lambda: compiled.losses(d, x, out, stack, 1, 0.0, 0.0, LOSS_RULES, *a),
        lambda: compiled.losses(d, x, out, stack, 0, 0.0, 0.0, np.empty(55), *a),
        lambda: compiled.hold(d, x, short, stack, values, 0, 0.0, 0.0, 0.0, *a),
        lambda: compiled.hold(d, x, out, stack, values, 1, 0.0, 0.0, 0.0, *a),
    ]
    for call in calls:
        with pytest.raises(ValueError, match="too short"):
            call()


@pytest.mark.slow
def test_long_records(compiled):
    """A million samples: what turns at every one, and what seldom turns."""
    rng = np.random.default_rng(9)
    t = np.arange(1_000_000)
    for x in (rng.normal(size=t.size), np.sin(t * 1e-3) + 0.3 * np.sin(t * 0.0173), np.sin(t)):
        x = np.ascontiguousarray(x * REACH)
        alike(by_respond(twin, x, Memory()), by_respond(compiled, x, Memory()))
        alike(by_branches(twin, x, Memory())[:2], by_respond(compiled, x, Memory()))


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="None is immortal from Python 3.12 on")
def test_none_keeps_its_references(compiled):
    """Headers of later Pythons must not build a module that takes them away from this one."""
    value, base = np.zeros(1), np.zeros(1)
    parent = np.full(1, -1)
    before = sys.getrefcount(None)
    for _ in range(2000):
        compiled.accumulate(parent, value, base)
    assert abs(sys.getrefcount(None) - before) < 1000
