"""A joint in an oscillator: closed forms, and the oscillation followed in time, by other ways."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from cases import missing_share
from own_laws import LAWS
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ive
from usual import JOINT, PAIR, rough

import microslip as ms
from microslip.friction.energies import energies_along

TURN = 2.0 * np.pi
SLIP = 2.0 * JOINT.force_limit / JOINT.tangential_stiffness
EXPONENTIAL = ms.Interface(rough(ms.Exponential(5e-7)), 0.55, separation=2e-7)
EXAMPLES = [
    pytest.param(law, id=f"{cls.__name__}-{i}")
    for cls in LAWS
    for i, law in enumerate(cls.examples())
    if cls is not ms.Interface or i % 3 == 0
]
ELASTIC = [p for p in EXAMPLES if not isinstance(p.values[0], ms.Coulomb)]
# One of each kind of backbone: smooth, with a last contact, of given summits, of one sphere.
SMOOTH = {
    "gaussian": JOINT,
    "exponential": EXPONENTIAL,
    "summits": ms.Interface(
        ms.AsperityPopulation(PAIR, np.linspace(0.0, 1e-6, 40), 1e-3), 0.4, normal_load=5.0
    ),
    "segalman": ms.SegalmanIwan.examples()[0],
}


def reach(law: ms.BackboneLaw) -> float:
    """Displacement at which the first tangent meets the limit [m]."""
    return law.force_limit / law.tangential_stiffness


def oscillator(law: ms.BackboneLaw, share: float = 1.0, viscous: float = 0.0) -> ms.Oscillator:
    """Its spring a share of the joint's own stiffness."""
    stiffness = law.tangential_stiffness if np.isfinite(law.tangential_stiffness) else 1e9
    return ms.Oscillator(3.0, share * stiffness, law, viscous)


# -- the closed form -------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ELASTIC)
def test_limits(law: ms.BackboneLaw) -> None:
    mode = oscillator(law, 0.3)
    stuck = np.sqrt((mode.stiffness + law.tangential_stiffness) / mode.mass)
    for method in ("quasi-static", "harmonic-balance"):
        small, large = mode.frequency([0.0, 1e9 * reach(law)], method=method, harmonics=[1])
        assert small == pytest.approx(stuck / TURN, rel=1e-15)
        assert large == pytest.approx(np.sqrt(mode.stiffness / mode.mass) / TURN, rel=1e-8)
        assert mode.damping_ratio(0.0, method=method) == 0.0
    # In gross slip all loss is 4 mu N a, all energy the spring's.
    a = 1e6 * reach(law)
    wanted = 4.0 * law.force_limit * a / (4.0 * np.pi * 0.5 * mode.stiffness * a**2)
    assert mode.damping_ratio(a) == pytest.approx(wanted, rel=1e-5 + missing_share(law, a))


@pytest.mark.parametrize("law", EXAMPLES)
def test_damping_is_the_loss_over_the_energy_of_the_mode(law: ms.BackboneLaw) -> None:
    mode = oscillator(law, 0.3, 0.004)
    a = np.geomspace(1e-2, 1e2, 9) * (reach(law) if reach(law) > 0.0 else 1e-6)
    for method in ("quasi-static", "harmonic-balance"):
        energy = (
            0.5 * mode.mass * (TURN * mode.frequency(a, method=method, harmonics=[1])) ** 2 * a**2
        )
        joint = law.dissipated_energy(a) / (4.0 * np.pi * energy)
        seen = mode.damping_ratio(a, method=method, harmonics=[1])
        dashpot = 0.004
        if method == "harmonic-balance":
            swing = TURN * mode.frequency(a, method=method, harmonics=[1])
            dashpot = mode.viscous_coefficient / (2.0 * mode.mass * swing)
        np.testing.assert_allclose(seen, dashpot + joint, rtol=1e-13)


def test_alone_it_is_the_interface() -> None:
    """Without a spring all the energy is in the joint, and only then."""
    a = SLIP * np.geomspace(1e-3, 1e3, 7)
    alone, beside = ms.Oscillator(1.0, 0.0, JOINT), oscillator(JOINT)
    np.testing.assert_allclose(alone.damping_ratio(a), JOINT.damping_ratio(a), rtol=1e-14)
    assert np.all(beside.damping_ratio(a) < JOINT.damping_ratio(a))


def test_quasi_static_is_the_loop_of_the_whole_mode() -> None:
    """The area and the secant of the loop of spring and joint together, sampled."""
    mode, a = oscillator(JOINT, 0.7), 1.3 * SLIP
    loop = JOINT.loop(a, samples=20001)
    whole = ms.Loop(loop.displacement, loop.force + mode.stiffness * loop.displacement)
    assert mode.damping_ratio(a) == pytest.approx(whole.damping_ratio, rel=1e-7)
    assert mode.mass * (TURN * mode.frequency(a)) ** 2 == pytest.approx(
        whole.secant_stiffness, rel=1e-14
    )


def test_harmonic_balance_of_exponential_heights() -> None:
    """T0 = mu N (1 - exp(-u/c)) has the balanced stiffness 4 mu N exp(-a/2c) I1(a/2c)/a."""
    scale = EXPONENTIAL.slip_per_indentation * 5e-7
    a = scale * np.geomspace(1e-6, 1e6, 25)
    mode = ms.Oscillator(1.0, 0.0, EXPONENTIAL)
    stiffness = (TURN * mode.frequency(a, method="harmonic-balance", harmonics=[1])) ** 2
    wanted = 4.0 * EXPONENTIAL.force_limit / a * ive(1, 0.5 * a / scale)
    np.testing.assert_allclose(stiffness, wanted, rtol=3e-13)


def test_harmonic_balance_of_a_spring_and_a_slider() -> None:
    """Caughey (1960): k (theta - sin(2 theta)/2)/pi, cos(theta) = 1 - 2y/a; k below the yield y."""
    cell = ms.Jenkins(stiffness=5e7, force_limit=100.0)
    a = cell.yield_displacement * np.array([0.5, 1.0, 1.0001, 1.5, 10.0, 1e4])
    mode = ms.Oscillator(2.0, 0.0, cell)
    theta = np.arccos(np.maximum(1.0 - 2.0 * cell.yield_displacement / a, -1.0))
    wanted = cell.stiffness * (theta - 0.5 * np.sin(2.0 * theta)) / np.pi
    stiffness = 2.0 * (TURN * mode.frequency(a, method="harmonic-balance", harmonics=[1])) ** 2
    np.testing.assert_allclose(stiffness, wanted, rtol=1e-10)


@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("viscous", [0.0, 0.01])
def test_one_balance_of_harmonics_for_an_oscillator_and_a_structure(
    name: str, viscous: float
) -> None:
    """Its closed form of the fundamental is a structure's balance of it; more are that balance."""
    law = SMOOTH[name]
    mode, a = oscillator(law, 0.3, viscous), reach(law) * np.array([1e-2, 1.0, 30.0])
    dashpot = [[mode.viscous_coefficient]] if viscous else None
    single = ms.Structure([[mode.mass]], [[mode.stiffness]], dashpot).attach(law, directions=[1.0])
    for harmonics, error in (([1], 1e-11), ([0, 1, 2, 3], 0.0)):
        curve = single.modes(0, a * np.sqrt(mode.mass), harmonics=harmonics)
        options = {"method": "harmonic-balance", "harmonics": harmonics}
        np.testing.assert_allclose(mode.frequency(a, **options), curve.frequency, rtol=error)
        np.testing.assert_allclose(
            mode.damping_ratio(a, **options), curve.damping_ratio, rtol=1e2 * error
        )
    first, usual = (
        mode.damping_ratio(a, method="harmonic-balance", harmonics=h) for h in ([1], [1, 3])
    )
    assert np.abs(usual / first - 1.0).max() < 0.05
    np.testing.assert_allclose(mode.damping_ratio(a, method="harmonic-balance"), usual, rtol=1e-9)


def test_dry_friction_balances_no_stiffness() -> None:
    mode = ms.Oscillator(2.0, 8.0, ms.Coulomb(force_limit=0.3))
    a = np.array([1e-9, 0.1, 1e3])
    seen = TURN * mode.frequency(a, method="harmonic-balance", harmonics=[1])
    np.testing.assert_allclose(seen, 2.0, rtol=1e-14)
    assert mode.frequency(0.1) == pytest.approx(np.sqrt((8.0 + 3.0) / 2.0) / TURN, rel=1e-15)


@pytest.mark.parametrize("name", ["gaussian", "exponential", "summits"])
def test_both_stiffnesses_agree_to_first_order(name: str) -> None:
    """A parabola's secant is its balanced stiffness: what is left falls faster than the shift.

    Segalman's backbone leaves its tangent by u^1.5 for chi = -1/2, which is no parabola.
    """
    law = SMOOTH[name]
    mode = oscillator(law)
    a = 1e-3 * reach(law) * np.array([1.0, 0.1])
    first = mode.frequency(a)
    apart = np.abs(mode.frequency(a, method="harmonic-balance", harmonics=[1]) / first - 1.0)
    shift = 1.0 - first / mode.frequency(0.0)
    assert np.all(apart < 0.05 * shift)
    assert apart[1] / apart[0] < 0.2 * shift[1] / shift[0]


# -- followed in time ------------------------------------------------------------------------------


def turning_points(mode: ms.Oscillator, amplitude: float, count: int) -> np.ndarray:
    """Without a dashpot, exactly: where the work of the spring and of the joint are even.

    On the way 2h from a turning point (q, T) that goes in the direction w, the spring takes
    k (2whq + 2h^2), the joint 2whT + E_d(h)/2 + 2h T0(h). Nothing is integrated in time.
    """
    joint, way = mode.joint, -1
    q, force = amplitude, float(joint.backbone(amplitude))
    places = [q]
    for _ in range(count):

        def uneven(h: float, q: float = q, force: float = force, way: int = way) -> float:
            loss = 0.5 * joint.dissipated_energy(h) / h if h > 0.0 else 0.0
            spring = 2.0 * mode.stiffness * (way * q + h)
            return float(spring + 2.0 * way * force + loss + 2.0 * joint.backbone(h))

        h = brentq(uneven, 0.0, abs(places[-1]) + amplitude, xtol=1e-30, rtol=1e-15)
        force += 2.0 * way * joint.backbone(h)
        q += 2.0 * way * h
        places.append(q)
        way = -way
    return np.array(places)


@pytest.mark.parametrize("share", [0.05, 1.0])
@pytest.mark.parametrize("law", SMOOTH.values(), ids=SMOOTH)
def test_turning_points_converge_to_the_exact_ones(law: ms.BackboneLaw, share: float) -> None:
    """In fourth order, and so does the energy; given summits have kinks, of which T0'' is full."""
    mode = oscillator(law, share)
    exact = turning_points(mode, 1.5 * reach(law), 10)
    errors, energies = [], []
    for samples in (20, 40, 80, 160):
        motion = mode.ring_down(1.5 * reach(law), cycles=5, samples_per_cycle=samples)
        assert motion.turning_displacement.size == 11
        errors.append(np.abs(motion.turning_displacement - exact).max() / exact[0])
        energies.append(motion.energy_error)
    orders = np.log2([a / b for a, b in pairwise(errors)])
    if isinstance(law.surface if isinstance(law, ms.Interface) else None, ms.AsperityPopulation):
        assert errors[-1] < 2e-6
        assert orders.mean() > 2.0
    else:
        assert errors[-1] < 5e-9
        assert np.all(np.abs(orders - 4.0) < 0.35)
        assert np.all(np.abs(np.log2([a / b for a, b in pairwise(energies)]) - 4.0) < 0.35)


def test_a_kinked_backbone_converges_too() -> None:
    """A corner of T0 that a step runs over costs orders: about the second is left."""
    cell = ms.Jenkins(stiffness=5e7, force_limit=100.0)
    mode = oscillator(cell, 0.8)
    exact = turning_points(mode, 5.0 * cell.yield_displacement, 6)
    errors = [
        np.abs(
            mode.ring_down(
                5.0 * cell.yield_displacement, cycles=3, samples_per_cycle=samples
            ).turning_displacement
            - exact
        ).max()
        / exact[0]
        for samples in (20, 2000)
    ]
    assert errors[0] < 5e-3
    assert np.log(errors[0] / errors[1]) / np.log(100.0) > 1.8


def test_time_to_the_first_turning_point() -> None:
    """Half a period by quadrature of dq/v, v from the energies."""
    mode, a = oscillator(JOINT, 0.5), 2.0 * SLIP
    far = turning_points(mode, a, 1)[1]
    peak, middle, half = JOINT.backbone(a), 0.5 * (a + far), 0.5 * (a - far)

    def slowness(theta: float) -> float:
        q = middle + half * np.cos(theta)
        h = 0.5 * (a - q)
        work = -2.0 * h * peak + 0.5 * JOINT.dissipated_energy(h) + 2.0 * h * JOINT.backbone(h)
        kinetic = -work - 0.5 * mode.stiffness * (q**2 - a**2)
        return half * np.sin(theta) / np.sqrt(2.0 * kinetic / mode.mass)

    wanted = quad(slowness, 0.0, np.pi, epsrel=1e-8, limit=200)[0]
    motion = mode.ring_down(a, cycles=1, samples_per_cycle=200)
    assert motion.turning_time[1] == pytest.approx(wanted, rel=1e-7)


def test_newmark_goes_the_same_way() -> None:
    """Average acceleration with Newton's iteration and no turning points of its own: second order.

    Its error falls fourfold with each halving of the step, towards this motion.
    """
    mode, a = oscillator(JOINT, 0.5, 0.003), SLIP
    motion = mode.ring_down(a, duration=2e-3, samples_per_cycle=50)
    apart = []
    for fine in (8, 16):
        step = motion.time[1] / fine
        state = JOINT.start()
        force = state.try_(a)[0]
        state.commit()
        q, v = a, 0.0
        c = mode.viscous_coefficient
        acceleration = -(mode.stiffness * q + force) / mode.mass
        worst = 0.0
        for i in range(1, fine * (motion.time.size - 1) + 1):
            trial = q + step * v + 0.5 * step**2 * acceleration
            for _ in range(8):
                force, tangent = state.try_(trial)
                new = 4.0 / step**2 * (trial - q - step * v) - acceleration
                speed = v + 0.5 * step * (acceleration + new)
                rest = mode.mass * new + c * speed + mode.stiffness * trial + force
                trial -= rest / (
                    4.0 * mode.mass / step**2 + 2.0 * c / step + mode.stiffness + tangent
                )
                if abs(rest) < 1e-12 * JOINT.force_limit:
                    break
            force = state.try_(trial)[0]
            state.commit()
            new = 4.0 / step**2 * (trial - q - step * v) - acceleration
            q, v, acceleration = trial, v + 0.5 * step * (acceleration + new), new
            if i % fine == 0:
                worst = max(worst, abs(q - motion.displacement[i // fine]))
        apart.append(worst / a)
    assert apart[1] < 2e-4
    assert apart[0] / apart[1] == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize(("viscous", "cycles"), [(0.0, 30), (0.02, 30), (0.7, 2)])
@pytest.mark.parametrize("samples", [8, 100])
def test_while_all_sticks_it_is_the_linear_oscillator(
    viscous: float, cycles: int, samples: int
) -> None:
    """Exactly, whatever the step: a spring that yields later than the mass ever moves.

    The joint's force is known to rounding of its largest value, and no motion better than that.
    """
    cell = ms.Jenkins(stiffness=5e7, force_limit=100.0)
    mode = ms.Oscillator(0.7, 3e7, cell, viscous)
    a = 0.9 * cell.yield_displacement
    motion = mode.ring_down(a, cycles=cycles, samples_per_cycle=samples)
    swing = np.sqrt(8e7 / 0.7)
    damped = swing * np.sqrt(1.0 - viscous**2)
    t = motion.time
    wanted = np.exp(-viscous * swing * t) * (
        np.cos(damped * t) + viscous * swing / damped * np.sin(damped * t)
    )
    envelope = np.exp(-viscous * swing * t)
    assert np.all(np.abs(motion.displacement / a - wanted) <= 1e-11 * envelope + 1e-15)
    np.testing.assert_allclose(motion.damping_ratio, viscous, rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(motion.frequency, damped / (2.0 * np.pi), rtol=1e-8)
    assert np.all(motion.dissipated_energy == 0.0)


def test_dry_friction_takes_as_much_from_each_way() -> None:
    """2F/k from each half cycle, at the frequency of the spring, until the joint holds the mass."""
    limit, stiffness, mass = 0.3, 8.0, 2.0
    mode = ms.Oscillator(mass, stiffness, ms.Coulomb(force_limit=limit))
    motion = mode.ring_down(1.0, cycles=1000, samples_per_cycle=50)
    lost = 2.0 * limit / stiffness
    ways = int((1.0 - limit / stiffness) // lost) + 1
    wanted = (1.0 - lost * np.arange(ways + 1)) * (-1.0) ** np.arange(ways + 1)
    np.testing.assert_allclose(motion.turning_displacement, wanted, rtol=0, atol=1e-12)
    assert abs(motion.displacement[-1]) <= limit / stiffness
    half = np.pi * np.sqrt(mass / stiffness)
    np.testing.assert_allclose(motion.turning_time, half * np.arange(ways + 1), rtol=1e-11)
    # Held, the joint gives what the spring asks for.
    assert motion.force[-1] == -stiffness * motion.displacement[-1]
    assert motion.energy_error < 1e-11


def test_gross_slip_of_an_interface_takes_as_much_from_each_way() -> None:
    """Far above the slip scale an interface is dry friction to within that scale.

    A way loses E_d(a)/2ka = 2 mu N (1 - b/a)/k; b is about the slip scale.
    """
    mode = oscillator(JOINT, 1e-3)
    loss = 2.0 * JOINT.force_limit / mode.stiffness
    a = 400.0 * loss
    motion = mode.ring_down(a, cycles=5, samples_per_cycle=40)
    lost = -np.diff(np.abs(motion.turning_displacement))
    np.testing.assert_allclose(lost, loss, rtol=3.0 * SLIP / a + 1e-5)
    slipping = np.sqrt(mode.stiffness / mode.mass) / (2.0 * np.pi)
    np.testing.assert_allclose(motion.frequency, slipping, rtol=1e-3)
    # The secant still counts mu N/a as a stiffness of the mode; the balance does not.
    shift = JOINT.force_limit / mode.stiffness / motion.amplitude
    balanced = mode.frequency(motion.amplitude, method="harmonic-balance", harmonics=[1])
    np.testing.assert_allclose(balanced, slipping, rtol=0.2 * shift.max())
    secant = mode.frequency(motion.amplitude)
    np.testing.assert_allclose(secant, slipping * np.sqrt(1.0 + shift), rtol=1e-4)


# -- the closed form and the motion ----------------------------------------------------------------


@pytest.mark.parametrize("law", [JOINT, EXPONENTIAL, SMOOTH["summits"]], ids=str)
@pytest.mark.parametrize("viscous", [0.0, 0.005])
def test_the_closed_form_is_what_the_motion_shows(law: ms.Interface, viscous: float) -> None:
    """To first order in the shift of the frequency, epsilon, which is the closed form's own error.

    What is left of the frequency is of the order epsilon^2 (measured: up to 0.15 epsilon^2, and
    more for given summits, whose backbone is no parabola). Damping: of the order epsilon; with the
    tangent in place of the secant, of the order epsilon^2 (measured: up to 0.6), like the dashpot's
    share, which the quasi-static form takes as constant; and products of the two.
    """
    mode = oscillator(law, 1.0, viscous)
    for a in reach(law) * np.array([0.003, 0.03, 0.3]):
        motion = mode.ring_down(a, cycles=1, samples_per_cycle=200)
        (seen,), (swings,), (zeta,) = motion.amplitude, motion.frequency, motion.damping_ratio
        shift = 1.0 - mode.frequency(seen) / mode.frequency(0.0)
        natural = swings / np.sqrt(1.0 - zeta**2)
        assert abs(natural / mode.frequency(seen) - 1.0) < 0.5 * shift**2 + 1e-9
        joint = mode.damping_ratio(seen) - viscous
        assert abs(zeta / (joint + viscous) - 1.0) < 3.0 * shift + 1e-7
        held = mode.stiffness + law.backbone_stiffness(seen)
        tangent = (mode.stiffness + law.secant_stiffness(seen)) / held
        dashpot = mode.viscous_coefficient * TURN * mode.frequency(seen) / (2.0 * held)
        assert (
            abs(zeta / (joint * tangent + dashpot) - 1.0)
            < 1.5 * shift**2 + 3.0 * viscous * shift + 2e-6
        )


# -- invariants ------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", EXAMPLES)
@pytest.mark.parametrize("viscous", [0.0, 0.03])
def test_energy_goes_nowhere_else(law: ms.BackboneLaw, viscous: float) -> None:
    mode = oscillator(law, 0.4, viscous)
    a = 4.0 * reach(law) if reach(law) > 0.0 else 40.0 * law.force_limit / mode.stiffness
    motion = mode.ring_down(a, cycles=4, samples_per_cycle=60)
    # Corners of the backbone that a step runs over cost its order.
    smooth = isinstance(law, ms.Interface) and law._table is not None
    assert motion.energy_error < (2e-6 if smooth else 1e-3)
    slack = motion.energy_error * motion.mechanical_energy[0]
    assert np.all(np.diff(motion.mechanical_energy) <= slack)
    assert np.all(np.diff(motion.dissipated_energy) >= -1e-14 * motion.mechanical_energy[0])
    assert np.all(np.diff(motion.viscous_energy) >= 0.0)
    # Each way is shorter than the one before (as long, to rounding, once nothing yields).
    assert np.all(np.diff(np.abs(np.diff(motion.turning_displacement))) <= 1e-14 * a)


def test_units_scale_out() -> None:
    """Four times the mass: the same places at twice the times."""
    light, heavy = ms.Oscillator(2.0, 1e9, JOINT, 0.01), ms.Oscillator(8.0, 1e9, JOINT, 0.01)
    one, two = light.ring_down(SLIP, cycles=3), heavy.ring_down(SLIP, cycles=3)
    np.testing.assert_allclose(two.turning_displacement, one.turning_displacement, rtol=1e-12)
    np.testing.assert_allclose(two.turning_time, 2.0 * one.turning_time, rtol=1e-12)
    np.testing.assert_allclose(two.damping_ratio, one.damping_ratio, rtol=1e-11)


def test_forces_are_those_of_the_history() -> None:
    """The record of the release and of all samples and turning points, by joint.force."""
    mode = oscillator(JOINT, 0.5)
    motion = mode.ring_down(SLIP, cycles=3)
    path = np.concatenate((motion.time, motion.turning_time[1:]))
    order = np.argsort(path, kind="stable")
    x = np.concatenate((motion.displacement, motion.turning_displacement[1:]))[order]
    sampled = JOINT.force(x)[np.argsort(order, kind="stable")[: motion.time.size]]
    np.testing.assert_allclose(motion.force, sampled, rtol=0, atol=1e-12 * JOINT.force_limit)


@pytest.mark.parametrize("law", EXAMPLES)
def test_stored_and_dissipated_energy_are_the_work(law: ms.BackboneLaw) -> None:
    """Along a record full of loops that close, against the trapezoidal rule on fine samples."""
    scale = reach(law) if reach(law) > 0.0 else 1e-6
    x = scale * 1.5 * np.random.default_rng(7).normal(size=40)
    x[20:24] = scale * np.array([3.0, -1.0, 1.0, -5.0])
    stored, lost = energies_along(law, x, law.force(x))
    fine = np.concatenate(
        [np.linspace(a, b, 2000, endpoint=False) for a, b in pairwise([0.0, *x])] + [x[-1:]]
    )
    force = law.force(fine)
    work = np.cumsum(np.append(0.0, 0.5 * (force[1:] + force[:-1]) * np.diff(fine)))[2000::2000]
    # Dry friction jumps within a sample of the trapezoidal rule at each reversal.
    rough = 2e-3 if isinstance(law, ms.Coulomb) else 2e-6
    np.testing.assert_allclose(stored + lost, work, rtol=0, atol=rough * lost[-1])
    assert stored.min() >= -1e-12 * lost[-1]
    assert np.diff(lost, prepend=0.0).min() >= -1e-12 * lost[-1]
