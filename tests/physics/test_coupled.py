"""Normal and tangential load together: references, springs one by one, closed forms, invariants."""

from __future__ import annotations

import json
import tracemalloc
from functools import lru_cache
from itertools import pairwise
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from cases import (
    REFERENCE,
    closest,
    ends_below,
    every_joint,
    interface_of,
    joint_params,
    own_case,
    reach_of,
    settled,
    shared_cases,
)
from hypothesis import assume, given
from hypothesis import strategies as st
from usual import PAIR, rough

import microslip as ms
from microslip._core import kernels
from microslip.contact.exact_curves import _LawCurve, _summit_means, scalar_curve
from microslip.contact.spheres import Spheres
from microslip.friction.memory import Diagram

SPHERE = ms.Interface(ms.SphereOnFlat(PAIR, 5e-3), friction_coefficient=0.55, normal_load=10.0)
WORKED = ms.Interface.examples()[0]
EPS = np.finfo(float).eps


def walk(joint: ms.Interface, moves: list[tuple[float, float]]) -> tuple[Any, Any]:
    """Separations and displacements of moves: shares of the indentation and of the reach."""
    depth = joint.force_limit / joint.normal_stiffness / joint.friction_coefficient
    d, x = np.array(moves, dtype=float).reshape(-1, 2).T
    return joint.separation + depth * d, reach_of(joint) * x


shares = st.one_of(st.integers(-4, 4).map(lambda k: k / 8), st.floats(-0.6, 0.6).map(settled))
swings = st.one_of(st.integers(-8, 8).map(lambda k: k / 8), st.floats(-2.0, 2.0).map(settled))
paths = st.lists(st.tuples(shares, swings), min_size=1, max_size=20)


def within(joint: ms.Interface, moves: list[tuple[float, float]]) -> tuple[Any, Any]:
    """The same, where a table gives no separation below its first kept out."""
    d, x = walk(joint, moves)
    assume(d.min() >= closest(joint.surface))
    return d, x


# References and the constant load


SHARED = [
    pytest.param(case, id=case["name"]) for case in shared_cases() if "coupled_history" in case
] or [pytest.param({}, id="shared", marks=pytest.mark.skip("no folder `shared` beside this one"))]


@pytest.mark.parametrize("case", SHARED)
def test_shared_histories(case) -> None:
    given, wanted = case["coupled_history"], case["result"]["coupled_history"]
    joint = interface_of(case)
    force = joint.coupled_force(given["displacement"], normal_load=given["normal_load"])
    np.testing.assert_allclose(
        force, wanted["force"], rtol=0, atol=1e-14 * np.abs(wanted["force"]).max()
    )


COUPLED = json.loads((REFERENCE / "coupled.json").read_text(encoding="utf-8"))["cases"]


@pytest.mark.parametrize("case", COUPLED, ids=[case["name"] for case in COUPLED])
def test_own_histories(case) -> None:
    """Forces of diagrams written down anew; losses as work less store, in 40 digits."""
    joint = interface_of(own_case(case["name"]))
    response = joint.coupled_response(case["displacement"], separation=case["separation"])
    peak = np.abs(case["force"]).max()
    np.testing.assert_allclose(response.force, case["force"], rtol=0, atol=2e-15 * peak)
    wanted = case["dissipated_energy"]
    np.testing.assert_allclose(response.dissipated_energy, wanted, rtol=1e-12, atol=1e-40)


@every_joint
@pytest.mark.parametrize("scale", [1e-5, 0.3, 2.0])
def test_at_its_own_load_it_is_the_engine_of_constant_load(joint, scale) -> None:
    rng = np.random.default_rng(3)
    x = np.concatenate((rng.uniform(-1, 1, 60), [0.5, -0.5, 0.5, -0.5, 1.0])) * scale
    x *= reach_of(joint)
    wanted = joint.force(x)
    got = joint.coupled_force(x, normal_load=joint.normal_load)
    np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


# Given summits, however many


def of_many(count: int, law: str = "population") -> ms.Interface:
    """So many summits, of which a third touches."""
    y = np.random.default_rng(count).normal(0.0, 5e-7, count)
    surface: Any
    if law == "population":
        surface = ms.AsperityPopulation(PAIR, heights=y, radii=1e-3)
    else:
        surface = rough(y)
    return ms.Interface(surface, 0.3, separation=float(np.sort(y)[-max(count // 3, 4)]))


@pytest.mark.parametrize("law", ["population", "rough"])
@pytest.mark.parametrize("count", [5, 64, 65, 100, 300, 5000])
def test_any_number_of_summits_dissipates_by_masings_rules(count, law) -> None:
    joint = of_many(count, law)
    a = reach_of(joint) * np.array([0.02, 0.3, 0.9])
    for x in a:
        lost = joint.coupled_response([x, -x, x], normal_load=joint.normal_load).energy_per_step
        # Two ways to the same sums, of which each cancels no digits.
        assert lost[1] + lost[2] == pytest.approx(joint.dissipated_energy(x), rel=2e-13)


@pytest.mark.parametrize("count", [5, 65, 100, 700])
def test_what_many_summits_lose_is_work_less_store(count) -> None:
    """By parts, what is lost in a run follows from N and its integral M at the run's ends."""
    joint = of_many(count)
    rng = np.random.default_rng(9)
    load = joint.normal_load * rng.uniform(0.1, 2.0, 150)
    x = reach_of(joint) * rng.uniform(-1.0, 1.0, 150)
    response = joint.coupled_response(x, normal_load=load)
    slip, origin = joint.slip_per_indentation, joint.separation
    law = joint.surface
    runs = Diagram().runs(response.separation - origin, x / slip)
    sample, ahead, gap, until, density, sign, d0, d1 = runs
    q0, q1 = d0 + gap, d1 + until
    load_, integral = (lambda d, k=k: law._derivative(d + origin, k) for k in (0, -1))
    near = np.abs(d1 - d0) < 1e-3 * ahead  # the first quotient cancels: the middle serves
    still = integral(0.5 * (d0 + d1)) * 0.0 + load_(0.5 * (d0 + d1))
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(near, still, (integral(d0) - integral(d1)) / (d1 - d0))
    lost = ahead * mean - (2.0 - (d1 - d0) / ahead) * (integral(q0) - integral(q1))
    lost += load_(q1) * (q1 - d1) - load_(q0) * (q0 - d0)
    steps = np.bincount(sample.astype(int), (1.0 - sign * density) * lost, minlength=x.size)
    steps *= joint._friction * slip
    got = response.energy_per_step
    # The differences lose some digits; the old rule was wrong by a per cent of a step.
    np.testing.assert_allclose(got, steps, rtol=1e-8, atol=1e-8 * got.max())
    assert got.sum() == pytest.approx(steps.sum(), rel=1e-8)


@pytest.mark.parametrize("count", [100, 1000])
def test_many_summits_in_one_step_or_in_many(count) -> None:
    joint = of_many(count)
    rng = np.random.default_rng(5)
    d = joint.separation + 3e-7 * rng.uniform(-1.0, 1.0, 40)
    x = reach_of(joint) * rng.uniform(-1.0, 1.0, 40)
    ends = np.column_stack((np.append(joint.separation, d), np.append(0.0, x)))
    fine = np.concatenate([a + (b - a) * np.linspace(0, 1, 6)[1:, None] for a, b in pairwise(ends)])
    fine[4::5] = ends[1:]
    whole = joint.coupled_response(x, separation=d).dissipated_energy
    parts = joint.coupled_response(fine[:, 1], separation=fine[:, 0]).dissipated_energy[4::5]
    np.testing.assert_allclose(parts, whole, rtol=1e-12)


@pytest.mark.parametrize("lifted", [0.0, 1.0])
def test_memory_of_losses_is_bounded(lifted) -> None:
    """Runs times summits are taken in blocks, those that lift off among them."""
    joint = of_many(5000)
    rng = np.random.default_rng(2)
    x = reach_of(joint) * rng.uniform(-1.0, 1.0, 400)
    d = np.full(400, joint.separation)
    d[::2] += 3e-6 * lifted
    response = joint.coupled_response(x, separation=d)
    tracemalloc.start()
    try:
        response.energy_per_step  # noqa: B018 - it is worked out when it is asked for
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most < 30e6  # all at once would be 500 runs times 1667 summits times some 20 arrays


def exact_mean(y: float, run: tuple[float, float, float, float]) -> float:
    """Mean of half the integral of v N'' for one summit, in forty digits."""
    with mp.workdps(40):
        height, q0, q1, d0, d1 = (mp.mpf(v) for v in (y, *run))

        def share(u: Any) -> Any:
            deep, rest = height - d0 - (d1 - d0) * u, height - q0 - (q1 - q0) * u
            a, b = mp.sqrt(max(deep, 0)), mp.sqrt(max(rest, 0))
            return (a - b) ** 2 * (2 * a + b) / 4

        cuts = [mp.mpf(0), mp.mpf(1)]
        for p, r in ((q0, q1), (d0, d1)):
            if p != r and 0 < (height - p) / (r - p) < 1:
                cuts.append((height - p) / (r - p))
        return float(sum(mp.quad(share, ends) for ends in pairwise(sorted(cuts))))


@pytest.mark.parametrize("seed", range(8))
def test_one_summit_in_one_run(seed) -> None:
    """Gaps and moves of nine decades, with the front or the separation next to the summit."""
    rng = np.random.default_rng(seed)
    for _ in range(8):
        first = rng.uniform(-1.0, 1.0)
        last = first + rng.choice([0.0, 1.0, -1.0]) * 10.0 ** rng.uniform(-9, 0)
        start = first + rng.choice([0.0, 1.0]) * 10.0 ** rng.uniform(-9, 0)
        end = max(last + 10.0 ** rng.uniform(-9, 0), start + 0.1 * 10.0 ** rng.uniform(-9, 0))
        run = start, end, first, last
        gaps = start - first, max(end - last, 0.0), first, last
        y = rng.choice(run) + rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-9, 0)
        spheres = Spheres(np.array([y]), np.ones(1))
        got = float(_summit_means(spheres, *(np.array([v]) for v in gaps))[0])
        assert got == pytest.approx(exact_mean(y, run), rel=1e-11, abs=1e-300)


# An independent method: springs one by one


class Springs:
    """The contact as independent springs, each with a slider of its own (Popov and Hess).

    The spring at separation eta is compressed by eta - d and held by friction up to kappa times
    that; so many of them, N'' d eta, as the normal law has. Each is followed for itself.
    """

    def __init__(self, joint: ms.Interface, top: float, bottom: float, count: int) -> None:
        law, kappa = joint.surface, joint.slip_per_indentation
        # Dense towards the top, where a sphere's N'' is singular; weights by differences of N'.
        grid = top - (top - bottom) * np.linspace(0.0, 1.0, count + 1)[::-1] ** 2
        slope = -law.stiffness(grid)
        self.weight = np.diff(slope)
        load = law.load(grid)
        # The middle of gravity of each share of N''.
        moment = np.diff(grid * slope) - np.diff(load)
        self.place = moment / self.weight
        self.shear = np.zeros(count)
        self.d, self.x = joint.separation, 0.0
        self.mu, self.kappa = joint.friction_coefficient, kappa

    def step(self, d: float, x: float) -> float:
        """One straight step; returns the force."""
        move = (x - self.x) / self.kappa
        before, after = self.place - self.d, self.place - d
        share = np.where(before > 0.0, 1.0, after / np.where(before == after, 1.0, after - before))
        shear = self.shear + np.clip(share, 0.0, 1.0) * move
        bound = np.maximum(after, 0.0)
        self.shear = np.clip(shear, -bound, bound)
        self.d, self.x = d, x
        return self.mu * float(self.weight @ self.shear)


@lru_cache
def history(kind: str) -> tuple[Any, Any]:
    """Loads (shares of the mean) and displacements (shares of the reach) of three cycles."""
    t = np.linspace(0.0, 6.0 * np.pi, 241)[1:]
    ramp = np.minimum(t / np.pi, 1.0)
    waves = {
        "in phase": (np.sin(t), np.sin(t)),
        "opposite": (-np.sin(t), np.sin(t)),
        "quadrature": (np.cos(t) * ramp, np.sin(t)),
        "double frequency": (np.sin(2.0 * t + 0.4) * ramp, np.sin(t)),
        "gross slip": (np.cos(t) * ramp, 3.0 * np.sin(t)),
    }
    load, x = waves[kind]
    return 1.0 + 0.6 * load, 0.8 * x


@pytest.mark.parametrize("kind", ["in phase", "opposite", "quadrature", "double frequency"])
@pytest.mark.parametrize("joint", [SPHERE, WORKED], ids=["sphere", "rough"])
def test_springs_one_by_one_agree(joint, kind) -> None:
    share, x = history(kind)
    load, x = share * joint.normal_load, x * reach_of(joint)
    separation = joint.surface.separation(load)
    top = 0.0 if joint is SPHERE else 4e-6
    bottom = min(separation.min(), joint.separation)
    force = joint.coupled_force(x, normal_load=load)
    errors = []
    for count in (2000, 4000):
        springs = Springs(joint, top, bottom, count)
        explicit = np.array([springs.step(d, v) for d, v in zip(separation, x, strict=True)])
        errors.append(np.abs(explicit - force).max() / np.abs(force).max())
    # The springs converge, at second order but for those half in contact, on the exact answer.
    assert errors[1] < 1e-5
    assert errors[1] < 0.5 * errors[0]


def test_springs_agree_through_lift_off() -> None:
    rng = np.random.default_rng(11)
    separation = SPHERE.separation * rng.uniform(-0.5, 1.6, 300)
    x = reach_of(SPHERE) * np.cumsum(rng.uniform(-0.5, 0.5, 300))
    force = SPHERE.coupled_force(x, separation=separation)
    springs = Springs(SPHERE, 0.0, separation.min(), 20000)
    explicit = np.array([springs.step(d, v) for d, v in zip(separation, x, strict=True)])
    np.testing.assert_allclose(explicit, force, atol=1e-6 * np.abs(force).max())
    off = separation >= 0.0
    assert off.sum() > 20
    np.testing.assert_array_equal(force[off], 0.0)


# Closed forms after Mindlin and Deresiewicz (1953), DOI 10.1115/1.4010702


def test_load_that_grows_at_rest_changes_nothing_but_stiffness() -> None:
    x = 0.5 * reach_of(SPHERE)
    force = SPHERE.coupled_force([x, x, x], normal_load=[10.0, 20.0, 40.0])
    np.testing.assert_allclose(force, SPHERE.backbone(x), rtol=1e-14)
    state = SPHERE.start()
    state.advance([x, x], normal_load=[10.0, 40.0])
    heavier = SPHERE.at(normal_load=40.0)
    # The next small move meets no slip at all: new contact sticks everywhere around the old.
    stiffness = (state.try_(x * (1 + 1e-9))[0] - force[0]) / (1e-9 * x)
    assert stiffness == pytest.approx(heavier.tangential_stiffness, rel=1e-5)


def test_proportional_loading_below_friction_does_not_slip() -> None:
    """Along delta = kappa b (d0 - d) with b < 1: T = b mu (N - N0), and nothing is lost."""
    d = np.linspace(SPHERE.separation, 3.0 * SPHERE.separation, 40)[1:]
    x = 0.4 * SPHERE.slip_per_indentation * (SPHERE.separation - d)
    response = SPHERE.coupled_response(x, separation=d)
    wanted = 0.4 * SPHERE.friction_coefficient * (response.normal_load - 10.0)
    np.testing.assert_allclose(response.force, wanted, rtol=1e-13)
    np.testing.assert_array_equal(response.dissipated_energy, 0.0)


def test_load_that_falls_under_held_force_ends_on_the_lighter_backbone() -> None:
    """Slip grows inwards as the load is lifted; what is left is first loading at that load."""
    force = 0.3 * SPHERE.force_limit
    loads = [10.0, 7.0, 5.0, 3.2]
    x = SPHERE.coupled_response(force=[force] * 4, normal_load=loads).displacement
    wanted = [SPHERE.at(normal_load=n).backbone_displacement(force) for n in loads]
    np.testing.assert_allclose(x, wanted, rtol=1e-13)


def test_unloading_after_proportional_loading() -> None:
    """N back to its start after loading at b: slip wherever the row of b was, then all of it."""
    b, kappa, mu = 0.4, SPHERE.slip_per_indentation, SPHERE.friction_coefficient
    d0, d1 = SPHERE.separation, 2.0 * SPHERE.separation
    x1 = b * kappa * (d0 - d1)
    # Displacement held while the load returns: D = 1 on [d0, d0 + x1/kappa] restores it.
    force = SPHERE.coupled_force([x1, x1], separation=[d1, d0])
    q = d0 + x1 / kappa
    wanted = mu * (SPHERE.surface.load(d0) - SPHERE.surface.load(min(q, 0.0)))
    assert force[1] == pytest.approx(wanted, rel=1e-13)


# Invariants


@every_joint
@given(moves=paths, splits=st.integers(2, 7))
def test_one_step_is_any_number_of_steps(joint, moves, splits):
    d, x = within(joint, moves)
    whole = joint.coupled_force(x, separation=d)
    ends = np.column_stack((np.append(joint.separation, d), np.append(0.0, x)))
    fine = np.concatenate(
        [a + (b - a) * np.linspace(0, 1, splits + 1)[1:, None] for a, b in pairwise(ends)]
    )
    fine[splits - 1 :: splits] = ends[1:]
    steps = joint.coupled_force(fine[:, 1], separation=fine[:, 0])[splits - 1 :: splits]
    load = np.append(joint.surface.load(d), joint.normal_load).max()
    np.testing.assert_allclose(steps, whole, rtol=0, atol=2e-12 * joint.friction_coefficient * load)
    if not isinstance(getattr(joint.surface, "heights", None), ms.Statistical):
        lost = joint.coupled_response(x, separation=d).dissipated_energy[-1]
        parts = joint.coupled_response(fine[:, 1], separation=fine[:, 0]).dissipated_energy[-1]
        # Rounding of the places of the front, of all that could be lost.
        most = joint.friction_coefficient * load * np.abs(np.diff(x, prepend=0.0)).sum()
        assert parts == pytest.approx(lost, rel=1e-9, abs=1e-12 * most)


@every_joint
@given(moves=paths)
def test_forces_stay_within_friction_and_nothing_is_gained(joint, moves):
    d, x = within(joint, moves)
    response = joint.coupled_response(x, separation=d)
    limit = joint.friction_coefficient * response.normal_load
    assert np.all(np.abs(response.force) <= limit * (1 + 1e-12) + 1e-13 * limit.max())
    assert np.all(np.diff(response.dissipated_energy, prepend=0.0) >= 0.0)


@every_joint
@given(moves=paths, cut=st.integers(0, 20))
def test_pieces_and_trials_give_the_whole(joint, moves, cut):
    d, x = within(joint, moves)
    load = joint.surface.load(d)
    assume(load.min() > 1e-9 * joint.normal_load)
    whole = joint.coupled_force(x, normal_load=load)
    state = joint.start()
    got = []
    for i, (n, v) in enumerate(zip(load, x, strict=True)):
        if i < cut:
            state.try_(v - reach_of(joint), n)  # a trial that is not committed leaves no trace
            state.copy().commit()
            force, _ = state.try_(v, n)
            state.commit()
            assert (state.force, state.displacement) == (force, v)
            got.append(force)
    if cut < x.size:
        got += list(state.advance(x[cut:], normal_load=load[cut:]))
    # With what the last place of a separation costs where the load is light.
    share = 1e-13 + 8 * EPS * abs(joint.separation) * joint.normal_stiffness / joint.normal_load
    atol = share * joint.friction_coefficient * max(load.max(), joint.normal_load)
    np.testing.assert_allclose(got, whole, rtol=0, atol=atol)


@pytest.mark.parametrize("kind", ["in phase", "opposite", "quadrature", "gross slip"])
@pytest.mark.parametrize("joint", [SPHERE, WORKED], ids=["sphere", "rough"])
def test_a_settled_cycle_does_not_drift_and_its_area_is_what_is_lost(joint, kind) -> None:
    n = 4000
    t = 2.0 * np.pi * np.arange(1, n + 1) / n
    load, x = {
        "in phase": (np.sin(t), np.sin(t)),
        "opposite": (-np.sin(t), np.sin(t)),
        "quadrature": (np.cos(t), np.sin(t)),
        "gross slip": (np.cos(t), 3.0 * np.sin(t)),
    }[kind]
    load = np.tile(joint.normal_load * (1.0 + 0.6 * load), 4)
    x = np.tile(0.8 * reach_of(joint) * x, 4)
    response = joint.coupled_response(x, normal_load=load)
    cycles = response.force.reshape(4, n)
    peak = np.abs(cycles).max()
    assert np.abs(np.diff(cycles[1:], axis=0)).max() < 1e-13 * peak
    lost = response.dissipated_energy[n - 1 :: n]
    step = np.diff(lost)
    np.testing.assert_allclose(step, step[-1], rtol=1e-10)
    force, way = cycles[-1], x[-n:]
    area = np.sum(0.5 * (force + np.roll(force, 1)) * (way - np.roll(way, 1)))
    # The area by trapezoids of the samples: second order in their distance.
    assert area == pytest.approx(step[-1], rel=3e-5)
    # The normal spring gives back what it takes.
    n_mean = 0.5 * (response.normal_load[-n:] + np.roll(response.normal_load[-n:], 1))
    d = response.separation[-n:]
    work = np.sum(n_mean * (d - np.roll(d, 1)))
    assert abs(work) < 1e-9 * joint.normal_load * np.ptp(d)


def test_in_phase_below_friction_shakes_down() -> None:
    """Where |d delta| < kappa |d d| only the first cycle loses energy."""
    t = np.linspace(0, 8 * np.pi, 801)[1:]
    d = SPHERE.separation * (1.0 + 0.4 * np.sin(t))
    x = -0.5 * SPHERE.slip_per_indentation * (d - SPHERE.separation)
    lost = SPHERE.coupled_response(x, separation=d).dissipated_energy
    assert lost[199] > 0.0
    assert lost[-1] - lost[199] < 1e-12 * lost[199]


@pytest.mark.parametrize("joint", [SPHERE, WORKED], ids=["sphere", "rough"])
def test_more_is_lost_out_of_phase(joint) -> None:
    """Putignano, Ciavarella and Barber (2011): quadrature loses most."""
    n = 1000
    t = 2.0 * np.pi * np.arange(1, 2 * n + 1) / n
    x = 0.4 * reach_of(joint) * np.sin(t)
    energies = []
    for phase in (0.0, 0.25 * np.pi, 0.5 * np.pi):
        load = joint.normal_load * (1.0 + 0.5 * np.sin(t + phase))
        lost = joint.coupled_response(x, normal_load=load).dissipated_energy
        energies.append(lost[-1] - lost[n - 1])
    assert energies[0] < energies[1] < energies[2]


@pytest.mark.parametrize("joint", [SPHERE, WORKED], ids=["sphere", "rough"])
def test_finer_steps_converge_at_second_order(joint) -> None:
    """Between samples the path is straight in (separation, displacement): a chord of the curve.

    How near a sample lies to a turning point changes with the step, so the order is that over five
    halvings and some phases.
    """

    def run(count: int, phase: float) -> tuple[Any, float]:
        t = np.linspace(0.0, 4.0 * np.pi, 2 * count + 1)
        load = joint.normal_load * (1.0 + 0.5 * np.sin(t + phase))
        response = joint.coupled_response(0.7 * reach_of(joint) * np.sin(t), normal_load=load)
        lost = response.dissipated_energy
        return response.force[count // 25 :: count // 25], lost[-1] - lost[count]

    orders = []
    for phase in (0.3, 0.7, 0.25 * np.pi, 1.2, 0.5 * np.pi, 2.4):
        force, energy = run(12800, phase)
        coarse, fine = run(50, phase), run(1600, phase)
        errors = [np.sqrt(np.mean((f - force) ** 2)) for f, _ in (coarse, fine)]
        orders.append([np.log2(errors[0] / errors[1]) / 5.0])
        orders[-1].append(np.log2(abs(coarse[1] - energy) / abs(fine[1] - energy)) / 5.0)
    assert np.mean(orders, axis=0).min() > 1.85, orders
    assert np.min(orders) > 1.5, orders


@every_joint
@given(moves=paths)
def test_force_control_is_the_inverse(joint, moves):
    d, x = within(joint, moves)
    response = joint.coupled_response(x, separation=d)
    limit = joint.friction_coefficient * response.normal_load
    assume(np.all(np.abs(response.force) < 0.999 * limit))
    back = joint.coupled_response(force=response.force, separation=d)
    again = joint.coupled_force(back.displacement, separation=d)
    scale = max(limit.max(), joint.force_limit)
    np.testing.assert_allclose(again, response.force, rtol=0, atol=1e-11 * scale)


def test_a_load_that_ripples_under_a_held_force_ratchets() -> None:
    """A joint under shear creeps while its load breathes, to an end if nothing slips wholly."""
    n = 60
    t = 2.0 * np.pi * np.arange(1, 20 * n + 1) / n
    load = SPHERE.normal_load * (1.0 + 0.5 * np.sin(t))
    force = np.full(t.size, 0.3 * SPHERE.force_limit)
    response = SPHERE.coupled_response(force=force, normal_load=load)
    x = response.displacement[n - 1 :: n]
    assert np.all(np.diff(x) >= -1e-15 * x[0])
    assert x[1] >= (1.0 - 1e-15) * x[0]


@pytest.mark.parametrize("joint", [SPHERE, WORKED], ids=["sphere", "rough"])
def test_below_gross_slip_no_periodic_force_ratchets(joint) -> None:
    """One cycle settles it; a thousandth below the limit that holds to rounding."""
    rng = np.random.default_rng(4)
    n = 40
    t = 2.0 * np.pi * np.arange(1, 4 * n + 1) / n
    for _ in range(8):
        share, phases = rng.uniform(0.1, 0.9), rng.uniform(0.0, 6.0, 3)
        load = joint.normal_load * (1.0 + share * np.sin(t + phases[0]))
        force = rng.uniform(-1, 1) + np.sin(t + phases[1]) + 0.5 * np.sin(2 * t + phases[2])
        force *= 0.999 * joint.friction_coefficient / np.abs(force / load).max()
        response = joint.coupled_response(force=force, normal_load=load)
        advance = np.diff(response.displacement[n - 1 :: n])
        assert np.abs(advance).max() < 1e-11 * np.abs(response.displacement).max()


def test_energies_per_step_and_per_cycle() -> None:
    n = 100
    t = 2.0 * np.pi * np.arange(1, 3 * n + 31) / n
    x = reach_of(WORKED) * np.sin(t)
    response = WORKED.coupled_response(x, normal_load=WORKED.normal_load * (1.0 + 0.5 * np.cos(t)))
    total = response.dissipated_energy
    cycles = response.energy_per_step[30:].reshape(3, n).sum(axis=1)
    np.testing.assert_allclose(np.cumsum(response.energy_per_step), total, rtol=1e-14)
    np.testing.assert_allclose(cycles, np.diff(total[29::n]), rtol=1e-12)
    assert cycles[2] == pytest.approx(cycles[1], rel=1e-12)
    held = WORKED.coupled_response(x, normal_load=WORKED.normal_load)
    constant = held.energy_per_step[30:].reshape(3, n).sum(axis=1)
    wanted = WORKED.dissipated_energy(np.abs(x).max())
    np.testing.assert_allclose(constant[1:], wanted, rtol=1e-12)


# The load curve as a profile


PROFILED = joint_params(which=lambda joint: joint._load_curve.profile(0.0, 0.0) is not None)


def plainly(joint: ms.Interface) -> ms.Interface:
    """The same joint, whose load curve is asked of the law itself."""
    other = joint.at(separation=joint.separation)
    other._load_curve._refused = np.inf, -np.inf
    return other


def test_smooth_laws_have_a_profile() -> None:
    assert len(PROFILED) >= 6
    assert plainly(WORKED)._load_curve.profile(0.0, 0.0) is None


@pytest.mark.parametrize("joint", PROFILED)
def test_profiles_are_the_law(joint) -> None:
    coupling = joint._load_curve
    length = joint.normal_load / joint.normal_stiffness
    profile = coupling.profile(-length, 3.0 * length)
    rng = np.random.default_rng(6)
    edges = profile.anchor + np.arange(-2, 8) / profile.inverse_width
    edges = edges[(edges > profile.low) & (edges < profile.high)]
    d = np.concatenate((rng.uniform(profile.low, profile.high, 500), edges, edges - 1e-5 * length))
    # Of small steps each digit counts, across the edges of panels, too.
    for share in (0.0, 1e-12, 3e-5, 0.1, 0.9, 2.0, 7.0, 1e4):
        width = np.full(d.size, share * length)
        drop = np.empty(d.size)
        kernels.compiled.drops(d, width, drop, *profile.arguments)
        np.testing.assert_allclose(drop, coupling.drop(d, width), rtol=1e-13, atol=0)
    load, fall = np.empty(d.size), np.empty(d.size)
    kernels.compiled.loads(d, load, fall, *profile.arguments)
    np.testing.assert_allclose(load, coupling.load(d)[0], rtol=1e-13)
    wanted = -joint.surface._derivative(d + joint.separation, 1)
    np.testing.assert_allclose(fall, wanted, rtol=1e-13)
    loads = rng.uniform(*profile.span, 500)
    wanted = joint.surface.separation(loads) - joint.separation
    np.testing.assert_allclose(profile.separations(loads), wanted, rtol=0, atol=5e-14 * length)


@pytest.mark.parametrize("joint", PROFILED)
@given(moves=paths)
def test_profiles_change_nothing(joint, moves):
    d, x = walk(joint, moves)
    other = plainly(joint)
    one, wanted = (j.coupled_response(x, separation=d) for j in (joint, other))
    limit = joint.friction_coefficient * max(wanted.normal_load.max(), joint.normal_load)
    np.testing.assert_allclose(one.force, wanted.force, rtol=0, atol=2e-14 * limit)
    lost = wanted.dissipated_energy
    # How far the front is ahead of the separation is known to the rounding of the separation only,
    # and what is lost while that moves away begins with the square of how far it is ahead.
    slip, depth = joint._load_curve.slip, joint.normal_load / joint.normal_stiffness
    moved = np.abs(d - joint.separation).max()
    unknown = x.size * EPS * moved * np.sqrt(slip * moved * joint.normal_load / depth**2)
    # The law's own way has one rule for a whole run, the profile one for each few panels: on steps
    # of several roughnesses the former is 2e-10 off.
    np.testing.assert_allclose(
        np.sqrt(one.dissipated_energy), np.sqrt(lost), rtol=5e-10, atol=unknown
    )
    held = wanted.force
    assume(np.all(np.abs(held) < 0.999 * joint.friction_coefficient * wanted.normal_load))
    one, wanted = (
        j.coupled_response(force=held, separation=d).displacement for j in (joint, other)
    )
    # Where hardly anything sticks a displacement is as uncertain as the force over its stiffness.
    atol = 1e-10 * np.abs(wanted).max() + 4.0 * EPS * moved * slip
    np.testing.assert_allclose(one, wanted, rtol=0, atol=atol)


@pytest.mark.parametrize("joint", PROFILED)
@pytest.mark.parametrize("share", [0.3, -1.5], ids=["around rest", "pressed"])
def test_cycles_of_profiles_are_those_of_the_law(joint, share) -> None:
    """Values go along the rows of the kernel's diagrams, or down the tree of a trace."""
    t = 2.0 * np.pi * np.arange(60) / 60
    depth = joint.normal_load / joint.normal_stiffness
    if share < 0.0 and ends_below(joint):
        share = 0.3
    x = reach_of(joint) * (0.3 + np.cos(t) + 0.6 * np.sin(3.0 * t))
    d = joint.separation + depth * (share + 0.4 * np.sin(t + 0.5) + 0.2 * np.cos(2.0 * t))
    directions = np.column_stack((np.ones(60), np.cos(t), np.sin(2.0 * t)))
    one, wanted = (j.periodic(x, separation=d) for j in (joint, plainly(joint)))
    limit = joint.friction_coefficient * wanted.normal_load.max()
    np.testing.assert_allclose(one.force, wanted.force, rtol=0, atol=1e-13 * limit)
    np.testing.assert_allclose(
        one.stiffness, wanted.stiffness, rtol=0, atol=1e-11 * wanted.stiffness.max()
    )
    slopes = [
        cycle.derivative(reach_of(joint) * directions, separation=depth * directions[:, ::-1])
        for cycle in (one, wanted)
    ]
    np.testing.assert_allclose(slopes[0], slopes[1], rtol=0, atol=1e-11 * limit)


def test_profiles_grow_with_what_is_asked() -> None:
    joint, other = WORKED.at(normal_load=2000.0), plainly(WORKED)
    x = 1e-7 * np.sin(np.arange(1.0, 41.0))
    for least, most in ((1900.0, 2100.0), (1000.0, 3000.0), (1e-3, 1e4), (1e-120, 2e5), (5, 6)):
        load = np.geomspace(least, most, 40)[::-1]
        force, wanted = (j.coupled_force(x, normal_load=load) for j in (joint, other))
        np.testing.assert_allclose(force, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())
    profile = joint._load_curve._profile
    assert profile.span[0] < 1e-20
    assert profile.span[1] > 2e5
    # Hardly any load from the start to the end is beyond it, and still right.
    d = WORKED.separation + np.array([1e-4, 1e-3, 1e-3])
    force = joint.coupled_force([1e-7, 2e-7, 5e-7], separation=d)
    np.testing.assert_allclose(force, other.coupled_force([1e-7, 2e-7, 5e-7], separation=d))


def test_below_the_lowest_summit_the_law_is_asked_itself() -> None:
    """There N'' of a bounded height distribution has a root: no panel resolves it."""
    joint = next(
        j for j in ms.Interface.examples() if j.surface._edge == 0.0 and j.separation > 0.0
    )
    heavy = 1.5 * joint.surface.load(0.0)
    load = [joint.normal_load, heavy, joint.normal_load]
    x = reach_of(joint) * np.array([0.3, 0.5, 0.1])
    force = joint.at(normal_load=joint.normal_load).coupled_force(x, normal_load=load)
    wanted = plainly(joint).coupled_force(x, normal_load=load)
    np.testing.assert_allclose(force, wanted, rtol=1e-13)


# Errors


TABLE = ms.Interface(
    ms.TabulatedNormalLaw(WORKED.surface.pair, [0.0, 1e-6, 2e-6, 3e-6], [3000.0, 1000.0, 300.0, 0]),
    friction_coefficient=0.5,
    normal_load=1000.0,
)
BEYOND = "normal_load must be at most 3000 N, where the table begins, got "
TINY = "normal_load must be between 1e-290 and 1e+40 [N], got 1e-300"
UNENDING = (
    "normal_load must stay above zero on this surface, whose heights are unbounded, so that "
    "contact never ends; got 0"
)


@pytest.mark.parametrize(
    ("joint", "loads", "message"),
    [
        (TABLE, [1e3, 1e4, 1e30], BEYOND + "1e+30 N at sample 2"),
        (TABLE, [1e3, 0.0, 2e3, 1e30, 1e4], BEYOND + "1e+30 N at sample 3"),
        (TABLE, [1e3, 1e3, 1e-300, 2e3], TINY + " at sample 2"),
        (TABLE, [1e-300, 1e4], BEYOND + "10000 N at sample 1"),
        (TABLE, 1e4, BEYOND + "10000 N"),
        (WORKED, [10.0, 0.0, 0.0], UNENDING + " at sample 1"),
        (WORKED, 0.0, UNENDING),
        (
            ms.Interface(
                ms.AsperityPopulation(WORKED.surface.pair, [1.0, 1.0 - 1e-6], 1e-3),
                friction_coefficient=0.5,
                normal_load=1.0,
            ),
            [1.0, 2.0, 1e-9, 1e-12],
            "normal_load must be large enough for separations in double precision on "
            "this surface, got 1e-12 N at sample 3",
        ),
    ],
)
def test_a_load_that_cannot_be_carried_is_named(joint, loads, message) -> None:
    x = np.full(np.size(loads), 1e-7)
    calls = [
        lambda: joint.coupled_force(x, normal_load=loads),
        lambda: joint.coupled_response(force=0.0 * x, normal_load=loads),
    ]
    if np.ndim(loads):
        calls.append(lambda: joint.start().advance(x, normal_load=loads))
    else:  # a trial has no samples
        calls.append(lambda: joint.start().try_(1e-7, normal_load=loads))
    for call in calls:
        with pytest.raises(ms.InputError) as caught:
            call()
        assert str(caught.value) == message


@pytest.mark.parametrize(
    "law",
    [
        *(joint.surface for joint in ms.Interface.examples() if joint._load_curve._refused is None),
        of_many(300).surface,
        of_many(20).surface,
        TABLE.surface,
        ms.TabulatedNormalLaw(
            WORKED.surface.pair, [0.0, 2e-7, 1e-6], [9.0, 4.0, 1.0], tail="exponential"
        ),
    ],
    ids=lambda law: type(law).__name__,
)
def test_curves_are_the_law(law) -> None:
    low, high = law._span
    high = min(high, low + 4e-6)
    origin = low + 0.4 * (high - low)
    curve, slow = scalar_curve(law, origin), _LawCurve(law, origin)
    rng = np.random.default_rng(7)
    for place in rng.uniform(low, high, 20) - origin:
        np.testing.assert_allclose(curve.load(place), slow.load(place), rtol=1e-9)
        for width in (0.0, 1e-14, 1e-9, 1e-7, 3e-7, 1e-6, 1.0):
            wanted = slow.drop(place, width)
            # What the last place of a height costs a summit that only just touches.
            assert curve.drop(place, width) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("joint", [WORKED, SPHERE, TABLE], ids=["rough", "sphere", "table"])
def test_displacements_beyond_all_joints_slide(joint) -> None:
    force = joint.coupled_force([1e308, -1e308, 1e300], normal_load=joint.normal_load)
    np.testing.assert_allclose(force, joint.force_limit * np.array([1, -1, 1]), rtol=1e-12)


def test_records_longer_than_a_block_are_one_record() -> None:
    """What no profile gives is asked for some thousand samples at a time."""
    rng = np.random.default_rng(0)
    x = reach_of(SPHERE) * rng.normal(size=9000)
    load = SPHERE.normal_load * rng.uniform(0.5, 1.5, x.size)
    state = SPHERE.start()
    pieces = [
        state.advance(x[i : i + 700], normal_load=load[i : i + 700]) for i in range(0, x.size, 700)
    ]
    np.testing.assert_allclose(
        SPHERE.coupled_force(x, normal_load=load), np.concatenate(pieces),
        rtol=0, atol=1e-12 * SPHERE.force_limit,
    )  # fmt: skip


def test_contact_lost_and_found() -> None:
    x = np.array([1e-7, 1e-7, 5e-7, 5e-7, 6e-7])
    force = SPHERE.coupled_force(x, normal_load=[10.0, 0.0, 0.0, 10.0, 10.0])
    assert force[0] > 0.0
    assert force[1] == force[2] == force[3] == 0.0
    assert force[4] == pytest.approx(SPHERE.backbone(1e-7), rel=1e-12)


@pytest.mark.parametrize("heights", [ms.Gaussian(std=5e-7), ms.Exponential(scale=5e-7)])
@pytest.mark.parametrize("load", [2e3, 50.0, 1e-3])
def test_forces_next_to_the_limit(heights, load):
    """A rounding below mu N the displacement is finite, and what the other engine has there.

    It goes with the logarithm of what is left of the force: a last place of mu N is 1e-4 of 1e-12,
    and moves it by less than that.
    """
    joint = ms.Interface(rough(heights), 0.3, normal_load=load)
    force = joint.force_limit
    far = joint.backbone_displacement(joint.force_limit * (1.0 - 1e-12))
    for _ in range(6):
        force = float(np.nextafter(force, 0.0))
        got = joint.coupled_response(force=[force], normal_load=load).displacement[0]
        assert far < got < 2.0 * far
    close = [joint.force_limit * (1.0 - 1e-12)]
    near = joint.coupled_response(force=close, normal_load=load).displacement[0]
    assert near == pytest.approx(far, rel=1e-4)
