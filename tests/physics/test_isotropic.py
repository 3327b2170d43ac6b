"""Two tangential directions: lines, circles, turned paths, substeps, differences, energies."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from usual import slope

import microslip as ms
from microslip.friction.memory import VectorState

JOINT = ms.Interface.examples()[0]
TWO = ms.IsotropicJoint(JOINT)
RNG = np.random.default_rng(5)
ANGLE = 0.7
WAY, ACROSS = np.array([np.cos(ANGLE), np.sin(ANGLE)]), np.array([-np.sin(ANGLE), np.cos(ANGLE)])
TURN = np.array([WAY, ACROSS]).T
PATH = 2e-7 * RNG.normal(size=(40, 2))


def circle_energy(two, amplitude):
    """Energy of a settled circle: 2 pi k u sqrt(a^2 - u^2), summed over the sliders that slip."""
    sliders = two.line.sliders()
    u, k = sliders.yield_displacements, sliders.stiffnesses
    return 2.0 * np.pi * (k * u) @ np.sqrt(np.maximum(amplitude**2 - u**2, 0.0))


def circle(amplitude: float, samples: int, turns: int = 1) -> np.ndarray:
    t = 2.0 * np.pi * np.arange(1, samples * turns + 1) / samples
    return amplitude * np.stack((np.cos(t), np.sin(t)), axis=1)


def test_along_a_line_it_is_the_joint() -> None:
    x = 2e-7 * RNG.normal(size=60)
    force = TWO.force(np.outer(x, WAY))
    wanted = TWO.line.force(x)
    np.testing.assert_allclose(force @ WAY, wanted, rtol=0, atol=1e-12 * JOINT.force_limit)
    np.testing.assert_allclose(force @ ACROSS, 0.0, atol=1e-13 * JOINT.force_limit)
    errors = []
    for sliders in (16, 32, 64, 128):
        two = ms.IsotropicJoint(JOINT, sliders, smallest_amplitude=1e-8, largest_amplitude=3e-6)
        miss = two.force(np.outer(x, WAY)) @ WAY - JOINT.force(x)
        errors.append(np.abs(miss).max() / JOINT.force_limit)
    assert np.log2(errors[0] / errors[-1]) / 3.0 > 1.6, errors
    assert errors[2] < 4e-3  # reversals on reversals add the backbone's


def test_the_force_limit_is_exact_in_every_direction() -> None:
    state, angles = TWO.start(), np.linspace(0.0, 6.0, 50)
    trials = [state.try_([1e-3 * np.cos(angle), 1e-3 * np.sin(angle)]) for angle in angles]
    force, stiffness = (np.array(parts) for parts in zip(*trials, strict=True))
    np.testing.assert_allclose(np.hypot(*force.T), JOINT.force_limit, rtol=1e-13)
    along = np.einsum("ni,nij,nj->n", force, stiffness, force)
    assert np.abs(along).max() < 1e-9 * JOINT.force_limit**2 * JOINT.tangential_stiffness


@pytest.mark.parametrize("amplitude", [1e-8, 3e-7, 1e-6])
def test_a_circle_loses_its_closed_form(amplitude: float) -> None:
    """A polygon of n sides lies inside its circle: the error falls with n squared."""
    errors = []
    for samples in (50, 100, 200):
        state = TWO.start(energies=True)
        before = 0.0
        for i, x in enumerate(circle(amplitude, samples, 4)):
            state.try_(x)
            state.commit()
            if i == 3 * samples - 1:
                before = state.dissipated_energy
        lost = state.dissipated_energy - before
        errors.append(abs(lost / circle_energy(TWO, amplitude) - 1.0))
    assert errors[-1] < 3e-3
    # What is left at last are sliders close to the circle, which settle slowly.
    assert errors[0] / errors[-1] > 4.0
    # Along a line it loses less: independent laws for both directions would say 2 times that.
    assert circle_energy(TWO, amplitude) > 2.1 * JOINT.dissipated_energy(amplitude)


def test_the_exact_density_has_that_circle() -> None:
    """E = integral of w(u) u 2 pi sqrt(a^2 - u^2) du over the joint's own sliders."""
    a = 3e-7
    nodes, weights = np.polynomial.legendre.leggauss(80)
    angle = 0.25 * np.pi * (nodes + 1.0)  # u = a sin(angle) is smooth at u = a
    u = a * np.sin(angle)
    density = JOINT.sliders().density(u)
    wanted = 0.25 * np.pi * weights @ (density * u * 2.0 * np.pi * (a * np.cos(angle)) ** 2)
    fine = ms.IsotropicJoint(JOINT, 2000)
    assert circle_energy(fine, a) == pytest.approx(wanted, rel=1e-4)
    assert circle_energy(TWO, a) == pytest.approx(wanted, rel=2e-2)


def test_a_turned_path_turns_the_force() -> None:
    np.testing.assert_allclose(
        TWO.force(PATH @ TURN.T), TWO.force(PATH) @ TURN.T, rtol=0, atol=1e-12 * JOINT.force_limit
    )
    np.testing.assert_allclose(
        TWO.force(-PATH), -TWO.force(PATH), rtol=0, atol=1e-13 * JOINT.force_limit
    )


def test_one_straight_step_is_as_good_as_many() -> None:
    state = TWO.start()
    for x in PATH[:10]:
        state.try_(x)
        state.commit()
    other = state.copy()
    for share in np.linspace(0.0, 1.0, 8)[1:]:
        other.try_(PATH[9] + share * (PATH[10] - PATH[9]))
        other.commit()
    force, _ = state.try_(PATH[10])
    np.testing.assert_allclose(other.force, force, rtol=0, atol=1e-12 * JOINT.force_limit)


def test_the_tangent_is_that_of_the_step() -> None:
    state = TWO.start()
    h = 1e-13
    for x in PATH:
        _, stiffness = state.try_(x)
        slope = np.array(
            [(state.try_(x + e)[0] - state.try_(x - e)[0]) / (2.0 * h) for e in h * np.eye(2)]
        ).T
        np.testing.assert_allclose(
            stiffness / JOINT.tangential_stiffness, slope / JOINT.tangential_stiffness,
            rtol=0, atol=1e-7,
        )  # fmt: skip
        state.try_(x)
        state.commit()


def test_dissipated_energy_is_never_negative() -> None:
    """Work is what is stored and what is lost; each step loses something or nothing."""
    state = TWO.start(energies=True)
    work, last, force, lost = 0.0, np.zeros(2), np.zeros(2), 0.0
    for x in PATH[:12]:
        for share in np.linspace(0.0, 1.0, 201)[1:]:
            new, _ = state.try_(last + share * (x - last))
            work += 0.5 * (new + force) @ (x - last) / 200
            state.commit()
            assert state.dissipated_energy >= lost
            lost, force = state.dissipated_energy, new
        last = x
    assert state.stored_energy + lost == pytest.approx(work, rel=1e-4)
    big = TWO.start(energies=True)
    for x in PATH[:12]:
        big.try_(x)
        big.commit()
    assert big.dissipated_energy == pytest.approx(lost, rel=1e-10), "whatever the steps"


def test_harmonics_have_their_jacobian() -> None:
    x = 3e-7 * np.array([[0.1, 1.0, 0.3], [-0.2, 0.4, 0.9]])
    two = ms.IsotropicJoint(JOINT, 6)
    # The Jacobian is that of the settled cycle, so differences want one that is near it.
    force, jacobian = two.harmonics(x, samples=12, tolerance=1e-10)
    for k, way in enumerate(np.eye(6).reshape(6, 2, 3)):
        found = slope(
            lambda s, e=way: two.harmonics(x + s * e, samples=12, tolerance=1e-10)[0], 1e-12
        )
        off = np.abs(jacobian[:, k // 3, :, k % 3] - found) / JOINT.tangential_stiffness
        assert off.max() < 1e-7
    assert force.shape == (2, 3)
    cycle = two.periodic(circle(3e-7, 24))
    assert cycle.force.shape == (24, 2)
    slopes = cycle.derivative(np.ones((24, 1)))
    assert slopes.shape == (24, 2, 2)


# -- nodes whose separation varies

NODES, SAMPLES = 4, 32
FIELD = ms.JointField(
    JOINT.surface, [0.3, 0.5, 0.2, 0.7], areas=1e-5, pressures=[3e6, 2e7, 1e7, 6e6]
)
T = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
BASIS = np.stack((np.ones(SAMPLES), np.cos(T), np.sin(T)))
X = 3e-7 * RNG.normal(size=(NODES, 3))
D = 1e-7 * RNG.normal(size=(NODES, 3)) + np.array([1.0, 0.0, 0.0]) * FIELD.separations[:, None]
NEAREST = float((D @ BASIS).min()) - 1e-8


def test_nodes_along_a_line_are_the_coupled_joint() -> None:
    """The load curve as a polygon of chords: the error falls with the square of their number."""
    x, d = X @ BASIS, D @ BASIS
    wanted = FIELD.periodic(x, d)
    errors, told = [], []
    for sliders in (32, 64, 128, 256):
        two = FIELD.two_directions(sliders, nearest=NEAREST)
        found = two.periodic(np.multiply.outer(x, WAY), d)
        scale = (FIELD.friction[:, None] * wanted.load).max()
        np.testing.assert_allclose(found.force @ ACROSS, 0.0, atol=1e-12 * scale)
        np.testing.assert_allclose(found.load, wanted.load, rtol=1e-12)
        errors.append(np.abs(found.force @ WAY - wanted.force).max() / scale)
        told.append(two.load_error)
    assert np.log2(errors[0] / errors[-1]) / 3.0 > 1.7, errors
    assert (np.array(errors) < 2.0 * np.array(told)).all()


def test_nodes_at_held_separations_are_isotropic_joints() -> None:
    """Node by node the sliders of the polygon, as any law's."""
    two = FIELD.two_directions(60, nearest=NEAREST)
    state = two.start(energies=True)
    path = RNG.normal(size=(8, NODES, 2)) * 2e-7
    for x in path:
        force, _ = state.try_(x)
        state.commit()
    for i in range(NODES):
        ahead = two.knots[1:] > FIELD.separations[i]
        yields = (two.knots[1:][ahead] - FIELD.separations[i]) * FIELD._nodes.slips[i]
        springs = two._bank.weights[ahead] * two._bank.scales[i] / FIELD._nodes.slips[i]
        same = ms.IsotropicJoint(ms.Iwan(springs, springs * yields), 60)
        np.testing.assert_allclose(
            force[i], same.force(path[:, i])[-1], rtol=0, atol=1e-11 * same.force_limit
        )
    assert (state.dissipated_energy > 0.0).all()


def test_nodes_step_as_one_or_many() -> None:
    two = FIELD.two_directions(40, nearest=NEAREST)
    state = two.start()
    x, d = RNG.normal(size=(6, NODES, 2)) * 2e-7, (D @ BASIS)[:, ::6].T
    for i in range(5):
        state.try_(x[i], d[i])
        state.commit()
    other = state.copy()
    for share in np.linspace(0.0, 1.0, 6)[1:]:
        other.try_(x[4] + share * (x[5] - x[4]), d[4] + share * (d[5] - d[4]))
        other.commit()
    answer = state.try_(x[5], d[5])
    scale = (FIELD.friction * answer.load)[:, None]
    np.testing.assert_allclose(other.force / scale, answer.force / scale, rtol=0, atol=1e-11)
    for k, way in enumerate(np.eye(3)):

        def at(s: float, way: np.ndarray = way) -> np.ndarray:
            trial = state.try_(x[5] + s * way[:2], d[5] + s * way[2])
            return np.concatenate((trial.force, trial.load[:, None]), axis=1)

        off = np.abs(slope(at, 1e-13) - answer.tangent[:, :, k])
        assert off.max() < 1e-7 * np.abs(answer.tangent).max()


def test_few_nodes_under_long_noise_are_single_states() -> None:
    """Nodes share sliders but no rows: each is its own state bit by bit, energies too."""
    steps, nodes = 200, 3
    for seed in range(3):
        rng = np.random.default_rng(seed)
        pressures = rng.uniform(1e6, 2e7, nodes)
        mu = rng.uniform(0.2, 0.7, nodes)
        field = ms.JointField(JOINT.surface, mu, areas=1e-5, pressures=pressures)
        x = 4e-7 * rng.normal(size=(steps, nodes, 2))
        d = field.separations + 1e-7 * rng.normal(size=(steps, nodes))
        together = field.two_directions(40, nearest=float(d.min())).start(energies=True)
        bank, found = together._bank, []
        for i in range(steps):
            found.append(together.try_(x[i], d[i]))
            together.commit()
        for k in range(nodes):
            own = {
                name: getattr(bank.nodes, name)[[k]]
                for name in ("weights", "scales", "slips", "rests")
            }
            part = replace(bank, nodes=replace(bank.nodes, **own))
            single = VectorState(part, energies=True)
            for i in range(steps):
                trial = single.try_(x[i, [k]], d[i, [k]])
                single.commit()
                for name in ("force", "load", "tangent"):
                    got, wanted = getattr(found[i], name)[k], getattr(trial, name)[0]
                    np.testing.assert_array_equal(got, wanted, err_msg=f"seed {seed}, step {i}")
            for energy in ("stored_energy", "dissipated_energy"):
                # A sum over sliders as a product of matrices, whose order BLAS chooses.
                got, wanted = getattr(together, energy)[k], getattr(single, energy)[0]
                assert got == pytest.approx(wanted, rel=1e-14)


def test_harmonics_of_nodes_have_their_jacobian() -> None:
    two = FIELD.two_directions(24, nearest=NEAREST)
    x = np.stack((X, 0.7 * np.roll(X, 1, axis=0)), axis=1)
    force, load, jacobian = two.harmonics(x, separations=D, samples=SAMPLES)
    for k, way in enumerate(np.eye(9).reshape(9, 3, 3)):

        def at(s: float, e: np.ndarray = way) -> np.ndarray:
            moved, d = x + s * e[:2], D + s * e[2]
            found = two.harmonics(moved, separations=d, samples=SAMPLES, tolerance=1e-9)
            return np.concatenate((found[0], found[1][:, None]), axis=1)

        off = np.abs(slope(at, 1e-12) - jacobian[:, :, k // 3, :, k % 3])
        # A slider that at last just touches its circle has a derivative to either side.
        assert off.max() < 5e-5 * np.abs(jacobian).max()
    held, own = two.harmonics(x, samples=SAMPLES)
    assert held.shape == force.shape
    assert load.shape == (NODES, 3)
    assert own.shape == (NODES, 2, 2, 3, 3)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="glibc alone fills what is free")
def test_harmonics_do_not_hang_on_what_lies_beside_their_arrays() -> None:
    """Reading beyond an array gives numbers by chance: here what is free is full of others."""
    script = (
        "import test_isotropic as t, numpy as np, sys\n"
        "two = t.FIELD.two_directions(24, nearest=t.NEAREST)\n"
        "x = np.stack((t.X, 0.7 * np.roll(t.X, 1, axis=0)), axis=1)\n"
        "parts = two.harmonics(x, separations=t.D, samples=t.SAMPLES)\n"
        "parts += t.FIELD.harmonics(t.X, separations=t.D) + t.FIELD.harmonics(t.X)\n"
        "large = t.ms.JointField(t.JOINT.surface, 0.3, areas=1e6, pressures=[5e6] * 40)\n"
        "still = large.separations[:, None] * [1.0, 0.0, 0.0]\n"
        "parts += large.harmonics(np.zeros((40, 3)), separations=still)\n"
        "sys.stdout.write(b''.join(np.ascontiguousarray(p).tobytes() for p in parts).hex())\n"
    )
    found = {
        subprocess.run(
            [sys.executable, "-W", "error", "-c", script], capture_output=True, text=True,
            check=True, cwd=Path(__file__).parent,
            env=os.environ | {"MALLOC_PERTURB_": filling, "PYTHONPATH": os.pathsep.join(sys.path)},
        ).stdout
        for filling in ("85", "254")
    }  # fmt: skip
    assert len(found) == 1


def test_states_in_two_directions_go_through_pickles() -> None:
    joint = ms.IsotropicJoint(ms.Jenkins(5e7, 10.0), sliders=8)
    two = FIELD.two_directions(20, nearest=NEAREST)
    path = 3e-7 * np.random.default_rng(2).normal(size=(6, 2))
    for start in (joint.start, two.start):
        state = start(energies=True)
        for row in path:
            state.try_(row)
            state.commit()
        other = pickle.loads(pickle.dumps(state))
        np.testing.assert_allclose(other.force, state.force, rtol=1e-13)
        np.testing.assert_allclose(other.dissipated_energy, state.dissipated_energy, rtol=1e-14)
        for one, same in zip(other.try_([1e-7, 2e-7]), state.try_([1e-7, 2e-7]), strict=True):
            np.testing.assert_allclose(one, same, rtol=1e-12)


def test_the_tolerance_bounds_the_error_of_a_settled_cycle() -> None:
    """Sliders that hardly slip change little, and for long: that is not what ends it."""
    two = FIELD.two_directions(24, nearest=NEAREST)
    x = np.stack((X, 0.7 * np.roll(X, 1, axis=0)), axis=1)
    exact = two.harmonics(x, separations=D, samples=SAMPLES, tolerance=1e-9)[0]
    limit = FIELD.friction * FIELD.normal_loads
    for tolerance in (1e-2, 1e-4, 1e-6):
        found = two.harmonics(x, separations=D, samples=SAMPLES, tolerance=tolerance)[0]
        assert (np.abs(found - exact).max(axis=(1, 2)) / limit).max() < tolerance


def test_a_settled_cycle_is_that_of_many_periods() -> None:
    """A state stepped through 600 periods, a program of its own."""
    two = FIELD.two_directions(24, nearest=NEAREST)
    t = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    path = np.stack((3e-7 * np.cos(t), 2e-7 * np.sin(t)), axis=1) + np.zeros((NODES, 1, 1))
    d = FIELD.separations[:, None] + 5e-8 * np.sin(2.0 * t + 0.3)
    wanted = two.periodic(path, d, tolerance=1e-7).force
    state = two.start()
    for _ in range(600):
        force = []
        for k in range(SAMPLES):
            force.append(state.try_(path[:, k], d[:, k]).force)
            state.commit()
    off = np.abs(np.stack(force, axis=1) - wanted) / np.abs(wanted).max()
    assert off.max() < 3e-5  # of the inverse square of the periods


def test_cycles_that_hardly_leave_a_slider_are_those_of_many_periods() -> None:
    """Each period brings such a slider on by little, and Newton's method all the way."""
    pressed = ms.JointField(JOINT.surface, 0.3, areas=1e-5, pressures=[5e6] * 3)
    two = pressed.two_directions(8)
    t = 2.0 * np.pi * np.arange(32) / 32
    sizes = np.geomspace(1e-7, 9e-7, 60)[[13, 24, 31], None, None]
    path = sizes * np.stack((np.cos(t), 0.8 * np.sin(t)), axis=1)
    cycle = two.periodic(path, tolerance=1e-10)
    assert cycle.passes.max() < 12
    state, off = two.start(), []
    for _ in range(400):
        force = []
        for k in range(32):
            force.append(state.try_(path[:, k]).force)
            state.commit()
        off.append(np.abs(np.stack(force, axis=1) - cycle.force).max() / np.abs(cycle.force).max())
    assert off[40] > 1e-7
    assert off[-1] < 1e-10


def test_cycles_that_do_not_settle_are_told_and_not_refused() -> None:
    field = ms.JointField(JOINT.surface, 0.5, areas=[1e-5] * 40, loads=[2.0] * 40)
    law = field.two_directions(sliders=128)
    # Node 23 of these motions is still in motion after 100 000 periods.
    motion = np.random.default_rng(4).normal(size=(1000, 2, 3))[:40] * 2e-7
    found, finer = (law.harmonics(motion, tolerance=t) for t in (1e-6, 1e-9))
    assert found.converged.sum() >= 38
    assert np.isfinite(found.force).all()
    assert (found.residual[found.converged] <= 1e-6).all()  # mu N is 1 N
    assert (found.residual[~found.converged] > 1e-6).all()
    off = np.abs(found.force - finer.force).max(axis=(1, 2))
    assert (off <= 3.0 * (found.residual + finer.residual) + 1e-12).all()
    force, jacobian = found
    assert force is found.force
    assert jacobian is found.jacobian


def test_start_chooses_the_path_that_leads_to_a_cycle() -> None:
    law = ms.IsotropicJoint(ms.Jenkins(1e7, 5.0).to_iwan(1), sliders=1)
    t = np.arange(64) * 2 * np.pi / 64
    path = np.column_stack((3e-7 + 6e-7 * np.cos(t), 2e-7 * np.sin(t + 1.0)))
    state = law.start()
    for row in np.tile(path, (300, 1)):
        force, _ = state.try_(row)
        state.commit()
    first = law.periodic(path, start="first", tolerance=1e-12)
    np.testing.assert_allclose(first.force[-1], force, rtol=0, atol=1e-9 * law.force_limit)
    with pytest.raises(ms.InputError, match="farthest"):
        law.periodic(path, start="last")
