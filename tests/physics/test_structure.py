"""Structures with joints against independent methods, limits and invariants."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize
from usual import BETWEEN, JOINT, MASS, SLIP, SPRING, STIFFNESS, SURFACE, rough

import microslip as ms


@functools.cache
def chain() -> ms.Structure:
    return ms.Structure(MASS, STIFFNESS).attach(JOINT, directions=BETWEEN)


def balanced_by_hand(amplitude: float, guess: ms.ModalCurve, samples: int) -> tuple[float, float]:
    """Frequency [Hz] and damping of the first mode: physical coordinates, dense samples.

    The joint is followed through two cycles from rest by its history, not by its settled cycle,
    and SciPy finds the root with differences for derivatives.
    """
    phase = 2.0 * np.pi * np.arange(samples) / samples
    basis = np.stack([np.cos(phase), np.sin(phase), np.cos(3 * phase), np.sin(3 * phase)])
    first = guess.shape[0] * amplitude
    omega0 = 2.0 * np.pi * guess.frequency[0]

    def gap(z: np.ndarray) -> np.ndarray:
        x = z[:12].reshape(3, 4) * amplitude
        omega, zeta = z[12] * omega0, z[13]
        motion = (BETWEEN @ x) @ basis
        force = JOINT.force(np.concatenate([motion, motion]))[samples:]
        joint = 2.0 / samples * (basis @ force)
        rows = []
        for k, order in enumerate((1.0, 3.0)):
            c, s = x[:, 2 * k], x[:, 2 * k + 1]
            rate = -2.0 * zeta * omega * order * omega
            fixed = STIFFNESS - (order * omega) ** 2 * MASS
            rows.append(fixed @ c + rate * MASS @ s + BETWEEN * joint[2 * k])
            rows.append(fixed @ s - rate * MASS @ c + BETWEEN * joint[2 * k + 1])
        size = np.sum(x[:, :2] * (MASS @ x[:, :2])) / amplitude**2
        return np.append(np.concatenate(rows) / (SPRING * amplitude), [size - 1.0, z[1]])

    start = np.zeros((3, 4))
    start[:, 0], start[:, 1] = first.real / amplitude, -first.imag / amplitude
    solution = optimize.root(
        gap, np.append(start.reshape(-1), [1.0, guess.damping_ratio[0]]), tol=1e-13
    )
    assert np.abs(solution.fun).max() < 1e-9
    return float(solution.x[12] * omega0 / (2.0 * np.pi)), float(solution.x[13])


@pytest.mark.parametrize("slips", [1e-3, 0.1, 1.0, 30.0])
def test_a_chain_balances_as_by_hand(slips: float) -> None:
    """From a thousandth of the joint's slip scale to gross slip, by harmonics without samples."""
    shape = np.abs(BETWEEN @ chain().linear_modes(1).shape[:, 0])
    amplitude = slips * SLIP / shape
    curve = chain().modes(0, [amplitude])
    frequency, damping = balanced_by_hand(amplitude, curve, 4096)
    assert curve.frequency[0] == pytest.approx(frequency, rel=1e-6)
    assert curve.damping_ratio[0] == pytest.approx(damping, rel=1e-4)


def test_small_motion_is_linear_and_damps_by_the_cubic_law() -> None:
    """Damping in proportion to the amplitude: the energy of a cycle is cubic."""
    curve = chain().modes(0, [1e-10, 2e-10])
    stuck = chain().linear_modes(1).frequency[0]
    assert np.allclose(curve.frequency, stuck, rtol=1e-5)
    assert curve.damping_ratio[1] / curve.damping_ratio[0] == pytest.approx(2.0, rel=1e-3)


def test_what_the_joints_lose_is_what_the_mode_loses() -> None:
    """2 zeta omega M x' takes as much out of a cycle as the joints do: an invariant."""
    curve = chain().modes(0, [1e-7, 1e-6, 1e-5], harmonics=[1])
    omega = 2.0 * np.pi * curve.frequency
    stored = 2.0 * np.pi * curve.damping_ratio * omega**2 * curve.modal_amplitude**2
    assert np.allclose(curve.loss.sum(axis=1), stored, rtol=1e-9)


def test_both_methods_agree_in_microslip() -> None:
    exact = chain().modes(0, [1e-8, 1e-7])
    quick = chain().modes(0, [1e-8, 1e-7], method="quasi-static")
    np.testing.assert_allclose(quick.frequency, exact.frequency, rtol=1e-6)
    np.testing.assert_allclose(quick.damping_ratio, exact.damping_ratio, rtol=1e-4)


def test_a_damping_matrix_damps_the_mode_as_in_theory() -> None:
    """C in proportion to K: zeta = beta omega/2 for joints that stick."""
    damped = ms.Structure(MASS, STIFFNESS, 1e-7 * STIFFNESS).attach(
        ms.Jenkins(1e8, 1e3), directions=BETWEEN
    )
    linear = damped.linear_modes(1)
    shape, omega = linear.shape[:, 0], 2.0 * np.pi * linear.frequency[0]
    expected = 1e-7 * shape @ STIFFNESS @ shape / (2.0 * omega)
    for method in ("harmonic-balance", "quasi-static"):
        found = damped.modes(0, [1e-9], method=method).damping_ratio[0]
        assert found == pytest.approx(expected, rel=1e-6)


def series_bar() -> ms.Structure:
    """Four masses in a row, the joint in series between the middle ones."""
    k = 1e8
    stiffness = k * np.array(
        [[1.0, -1.0, 0, 0], [-1.0, 1.0, 0, 0], [0, 0, 1.0, -1.0], [0, 0, -1.0, 1.0]]
    )
    return ms.Structure(np.eye(4), stiffness).attach(JOINT, directions=[0.0, 1.0, -1.0, 0.0])


@pytest.mark.slow
def test_a_joint_in_series_rings_down_along_its_modal_curve() -> None:
    """Frequency and damping within 1 %; a fixed shape is wrong by factors here."""
    bar = series_bar()
    linear = bar.linear_modes(2)
    shape = linear.shape[:, 1]  # the first is rigid
    amplitude = 0.3 * SLIP / abs(shape[1] - shape[2])
    period = 1.0 / linear.frequency[1]
    motion = bar.integrate(
        None, np.arange(0.0, 14.0 * period, period / 400.0), displacement=amplitude * shape
    )
    seen = ms.read_decay(motion.time, motion.displacement @ shape)
    # The release wakes a fast mode of the joint as well, which dies out in the first cycles.
    late = [6, 8, 10]
    curve = bar.modes(0, seen.amplitude[late], samples=1024)
    assert np.allclose(seen.frequency[late], curve.frequency, rtol=1e-3)
    assert np.allclose(seen.damping_ratio[late], curve.damping_ratio, rtol=0.01)


@pytest.mark.slow
def test_a_motion_s_energies_add_up_and_its_error_is_of_second_order() -> None:
    pull = 3.0 * JOINT.force_limit
    errors, ends = [], []
    for steps in (1000, 2000, 4000):
        time = np.linspace(0.0, 5e-3, steps + 1)
        force = np.zeros((time.size, 3))
        force[:, 2] = pull * np.sin(2.0 * np.pi * 2000.0 * time)
        motion = chain().integrate(force, time, spectral_radius=0.9)
        errors.append(motion.energy_error)
        ends.append(motion.displacement[-1, 2])
    assert errors[-1] < 1e-4
    assert 3.0 < (ends[1] - ends[0]) / (ends[2] - ends[1]) < 5.0
    assert motion.joint_energy[-1] > 0.0
    # A step that loses nothing keeps the balance to rounding.
    exact = chain().integrate(force, time, spectral_radius=1.0)
    assert exact.energy_error < 1e-10


def test_what_joints_lose_is_distinguished_from_what_they_store() -> None:
    """Work in = kinetic + stored + dissipated; a spring's stored energy is T^2/(2 k), known."""
    stiffness = 1e8
    slider = ms.Structure(MASS, STIFFNESS).attach(ms.Jenkins(stiffness, 100.0), directions=BETWEEN)
    gaps = []
    for steps in (1000, 4000):
        time = np.linspace(0.0, 5e-3, steps + 1)
        force = np.zeros((time.size, 3))
        force[:, 2] = 400.0 * np.sin(2.0 * np.pi * 2000.0 * time)
        motion = slider.integrate(force, time, spectral_radius=1.0)
        stored = motion.elastic_energy + motion.joint_force[:, 0] ** 2 / (2.0 * stiffness)
        known = motion.kinetic_energy + stored + motion.dissipated_energy
        gaps.append(np.abs(known - motion.work).max() / motion.work.max())
        assert np.diff(motion.joint_loss, axis=0).min() >= 0.0
        assert np.abs(motion.stored_energy - stored).max() < 2e-3 * motion.work.max()
    assert motion.joint_loss[-1, 0] > 0.1 * motion.work.max()
    assert gaps[1] < 1e-3
    assert gaps[1] < 0.3 * gaps[0]


def test_nodes_of_a_field_lose_and_give_back_what_they_store() -> None:
    field = ms.JointField(SURFACE, 0.3, areas=[1e-4, 1e-4], loads=[400.0, 900.0])
    structure = ms.Structure(np.eye(6), 1e8 * np.diag([1.0, 2, 3, 4, 5, 6]))
    structure = structure.attach(field, directions=np.eye(6).reshape(6, 2, 3))
    time = np.linspace(0.0, 5e-3, 2001)
    force = np.zeros((time.size, 6))
    force[:, [0, 3]] = 300.0 * np.sin(2.0 * np.pi * 1500.0 * time)[:, None]
    force[:, 5] = 100.0 * np.sin(2.0 * np.pi * 900.0 * time)
    motion = structure.integrate(force, time)
    assert motion.joint_loss.shape == (time.size, 2)
    assert np.diff(motion.joint_loss, axis=0).min() >= 0.0
    assert motion.joint_loss[-1].min() > 0.0
    # What is stored is never taken out without having been put in.
    assert motion.stored_energy.min() > -1e-6 * motion.stored_energy.max()


def test_a_free_structure_flies_as_a_whole() -> None:
    bar = series_bar()
    force = np.tile([1.0, 0.0, 0.0, 0.0], (201, 1))
    time = np.linspace(0.0, 0.01, 201)
    motion = bar.integrate(force, time)
    centre = motion.displacement.mean(axis=1)
    assert np.allclose(centre, 0.5 * 0.25 * time**2, rtol=1e-3, atol=1e-12)


def test_a_decay_is_read_as_it_was_made() -> None:
    """Of a linear oscillator the reading is exact but for the sampling."""
    time = np.arange(0.0, 0.2, 2e-5)
    omega, zeta = 2.0 * np.pi * 180.0, 0.004
    damped = omega * np.sqrt(1.0 - zeta**2)
    signal = 3e-5 * np.exp(-zeta * omega * time) * np.cos(damped * time + 0.3)
    seen = ms.read_decay(time, signal)
    assert np.allclose(seen.frequency, damped / (2.0 * np.pi), rtol=1e-6)
    assert np.allclose(seen.damping_ratio, zeta, rtol=1e-3)
    assert np.allclose(
        seen.amplitude, 3e-5 * np.exp(-zeta * omega * (seen.time)), rtol=zeta * np.pi
    )


def test_a_forced_response_is_linear_where_joints_stick() -> None:
    damped = ms.Structure(MASS, STIFFNESS, 2e-7 * STIFFNESS).attach(
        ms.Jenkins(1e9, 1e9), directions=BETWEEN
    )
    force = np.array([0.0, 1.0, 2.0])
    frequencies = np.linspace(1900.0, 2300.0, 41)
    response = damped.forced_response(force, frequencies)
    held = STIFFNESS + 1e9 * np.outer(BETWEEN, BETWEEN)
    assert np.allclose(response.frequency[response.requested], frequencies, rtol=1e-12)
    for f, x in zip(response.frequency, response.displacement[:, :, 1], strict=True):
        w = 2.0 * np.pi * f
        exact = np.linalg.solve(held + 2e-7j * w * STIFFNESS - w**2 * MASS, force)
        assert np.allclose(x, exact, rtol=1e-7)


@pytest.mark.slow
def test_a_forced_response_is_what_integration_settles_at() -> None:
    structure = ms.Structure(MASS, STIFFNESS, 2e-7 * STIFFNESS).attach(JOINT, directions=BETWEEN)
    force = np.array([0.0, 0.0, 120.0])
    response = structure.forced_response(
        force, [2349.0, 2350.0], harmonics=[1, 3, 5, 7, 9], samples=256
    )
    expected = response.amplitude([0.0, 0.0, 1.0])[response.requested][-1]
    time = np.arange(0.0, 60.0 / 2350.0, 1.0 / 2350.0 / 256)
    wave = np.cos(2.0 * np.pi * 2350.0 * time)
    motion = structure.integrate(np.outer(wave, force), time)
    turn = np.exp(-2j * np.pi * 2350.0 * motion.time[-256:])
    seen = abs(turn @ motion.displacement[-256:, 2]) * 2.0 / 256
    assert seen == pytest.approx(expected, rel=2e-3)


@functools.cache
def bouncing_response() -> tuple[ms.ForcedResponse, ms.Structure]:
    """Of a mass that bounces on its rough contact, down through its resonance."""
    field = ms.JointField(SURFACE, 0.3, areas=[2e-4], loads=[500.0])
    stuck = SURFACE.stiffness(field.separations[0])
    omega = np.sqrt(stuck)
    structure = ms.Structure(np.eye(3), 1e-3 * stuck * np.eye(3), 0.02 * omega * np.eye(3))
    bouncing = structure.attach(field, directions=np.eye(3).reshape(3, 1, 3))
    frequencies = np.linspace(1.2, 0.6, 31) * omega / (2.0 * np.pi)
    return bouncing.forced_response([0.0, 0.0, 25.0], frequencies), bouncing


def test_a_response_is_followed_around_turning_points() -> None:
    """A mass that bounces on its rough contact: pressure falls with opening, so the peak leans."""
    path, _ = bouncing_response()
    assert path.status == "solved"
    turns = path.turning_points
    assert turns.size == 2
    middle = path.frequency[turns].mean()
    assert np.count_nonzero(np.diff(path.frequency > middle)) == 3  # three motions there
    # The mean opens with the motion, as a softening contact's does.
    assert path.displacement[:, 2, 0].real.max() > 0.0
    # What lies between the turning points does not last.
    places = np.arange(path.frequency.size)
    away = np.abs(places[:, None] - turns).min(axis=1) > 1  # folds lie beside points, not on them
    outside = (places < turns[0]) | (places > turns[1])
    np.testing.assert_array_equal(path.stable[away], outside[away])
    dashed, drawn = path._figure([0.0, 0.0, 1.0]).panels[0].items[:2]
    assert dashed.dash
    assert np.isnan(drawn.y[(turns[0] + turns[1]) // 2])


@pytest.mark.slow
def test_motions_in_time_stay_or_leave_as_is_reported_of_every_point() -> None:
    """A bouncing face with sliders beside it, over a fold: 208 points, pushed by 1 % both ways.

    Central differences of 192 steps a period, the law read from a table and the sliders as springs
    with limits, all points at once: nothing of this is the package's balance or integration.
    """
    field = ms.JointField(SURFACE, 0.3, areas=[2e-4], loads=[500.0])
    rest = float(field.separations[0])
    stuck = float(SURFACE.stiffness(rest))
    spring, dashpot = 1e-3 * stuck, 0.02 * math.sqrt(stuck)
    cells = stuck * np.array([[0.01], [0.02], [0.02]])
    limits = cells * [[2e-8], [1e-7], [4e-7]]
    bouncing = (
        ms.Structure(np.eye(3), spring * np.eye(3), dashpot * np.eye(3))
        .attach(field, directions=np.eye(3).reshape(3, 1, 3))
        .attach(ms.Iwan(cells[:, 0], limits[:, 0]), directions=[0.0, 0.0, 1.0])
    )
    frequencies = np.linspace(1.25, 0.6, 81) * math.sqrt(stuck) / (2.0 * math.pi)
    path = bouncing.forced_response([0.0, 0.0, 25.0], frequencies)
    amplitude, turns = path.amplitude([0.0, 0.0, 1.0]), path.turning_points
    assert turns.size == 2
    away = np.abs(np.arange(amplitude.size)[:, None] - turns).min(axis=1) > 1
    assert away.sum() > 200
    assert (~path.stable[away]).sum() > 15

    start, step = -2e-6, 1e-9
    table = SURFACE.load(rest + start + step * np.arange(6001))
    orders, periods, steps = np.array(path.harmonics), 150, 192
    omega = np.tile(2.0 * np.pi * path.frequency, 2)
    motion = np.concatenate([push * path.displacement[:, 2, :] for push in (1.01, 0.99)])

    def pulled(x: np.ndarray, ends: np.ndarray) -> np.ndarray:
        at = (x - start) / step
        place = at.astype(int)
        load = table[place] + (at - place) * (table[place + 1] - table[place])
        sliders = np.clip(cells * (x - ends), -limits, limits).sum(axis=0)
        return np.asarray(spring * x + 500.0 - load + sliders)

    ends = np.zeros((3, omega.size))
    for k in range(2 * steps + 1):  # where the sliders stand once they have settled
        x = (motion * np.exp(2j * np.pi * k / steps * orders)).sum(axis=1).real
        ends = x - np.clip(cells * (x - ends), -limits, limits) / cells
    v = (1j * omega[:, None] * orders * motion).sum(axis=1).real
    dt, late = 2.0 * np.pi / omega / steps, np.zeros(omega.size, dtype=complex)
    a = 25.0 - pulled(x, ends) - dashpot * v
    for k in range(1, periods * steps + 1):
        x = x + dt * v + 0.5 * dt**2 * a
        drive = 25.0 * math.cos(2.0 * math.pi * k / steps) - pulled(x, ends)
        ends = x - np.clip(cells * (x - ends), -limits, limits) / cells
        v = (v + 0.5 * dt * (a + drive)) / (1.0 + 0.5 * dt * dashpot)
        a = drive - dashpot * v
        if k > (periods - 1) * steps:
            late += 2.0 / steps * x * np.exp(-2j * np.pi * k / steps)
    left = np.abs(np.abs(late).reshape(2, -1) / amplitude - 1.0)
    assert (left[:, away & path.stable] < 0.01).all()
    assert (left[:, away & ~path.stable] > 0.05).all()


def test_a_nonlinear_mode_is_a_motion_in_time() -> None:
    """Given its own damping back, the mode swings on: extrapolated time steps keep both numbers.

    The net damping of that motion is what the mode's ratio is wrong by.
    """
    shape = chain().linear_modes(1).shape[:, 0]
    amplitude = 0.1 * SLIP / abs(BETWEEN @ shape)
    curve = chain().modes(0, [amplitude], harmonics=[1, 3, 5, 7, 9, 11], samples=2048)
    frequency, damping = curve.frequency[0], curve.damping_ratio[0]
    omega = 2.0 * np.pi * frequency
    driven = ms.Structure(MASS, STIFFNESS, -2.0 * damping * omega * MASS).attach(
        JOINT, directions=BETWEEN
    )
    first = curve.shape[0] * amplitude
    seen = []
    for steps in (128, 256):
        motion = driven.integrate(
            None,
            np.arange(0.0, 14.0 / frequency, 1.0 / frequency / steps),
            displacement=first.real,
            velocity=-omega * first.imag,
            spectral_radius=1.0,
        )
        decay = ms.read_decay(motion.time, motion.displacement @ MASS @ shape)
        seen.append([decay.frequency[3:].mean(), decay.damping_ratio[3:].mean()])
    coarse, fine = np.array(seen)
    limit = (4.0 * fine - coarse) / 3.0
    assert limit[0] == pytest.approx(frequency, rel=1e-6)
    assert abs(limit[1]) < 1e-4 * damping


def pulled_bar_loss(std: float, nodes: int) -> float:
    """Energy a cycle of a bar on a rough base, over Coulomb's 2/3 F^3/(EA q)."""
    length, stiffness, friction, pull = 0.1, 1e6, 5000.0, 300.0
    step = length / nodes
    spring = stiffness / step * np.array([[1.0, -1.0], [-1.0, 1.0]])
    matrix = np.zeros((nodes, nodes))
    for i in range(nodes - 1):
        matrix[i : i + 2, i : i + 2] += spring
    surface = replace(SURFACE, heights=ms.Gaussian(std), density=1e9 * (5e-7 / std) ** 1.5)
    joint = ms.Interface(surface, 0.3, normal_load=friction * step / 0.3)
    bar = ms.Structure(1e-3 * np.eye(nodes), matrix).attach(joint, directions=np.eye(nodes))
    samples = 100
    time = np.linspace(0.0, 2.25, int(2.25 * samples) + 1)
    force = np.zeros((time.size, nodes))
    force[:, -1] = pull * np.sin(2.0 * np.pi * time)
    # So slow, and so damped by the method, that it is a row of static states.
    motion = bar.integrate(force, 10.0 * time, spectral_radius=0.0)
    x, f = motion.displacement[-samples - 1 :, -1], force[-samples - 1 :, -1]
    loss = np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(x))
    return float(loss / (2.0 / 3.0 * pull**3 / (stiffness * friction)))


def test_a_pulled_bar_tends_to_coulomb_friction_as_roughness_vanishes() -> None:
    """Extrapolated in the mesh, of first order in the roughness."""

    def miss(std: float) -> float:
        return (4.0 * pulled_bar_loss(std, 24) - pulled_bar_loss(std, 12)) / 3.0 - 1.0

    rough, smooth = miss(1e-6), miss(2.5e-7)
    assert abs(smooth) < 0.01
    assert 0.8 < np.log(rough / smooth) / np.log(4.0) < 1.1


def test_harmonic_tangents_are_the_differences_of_the_forces() -> None:
    from microslip.structures.balance import Balance
    from microslip.structures.periodic_motion import harmonic_basis

    field = ms.JointField(SURFACE, 0.3, areas=[1e-4, 1e-4], loads=[400.0, 900.0])
    structure = ms.Structure(np.eye(6), 1e8 * np.diag([1.0, 2, 3, 4, 5, 6]))
    structure = structure.attach(field, directions=np.eye(6).reshape(6, 2, 3))
    structure = structure.attach(JOINT, directions=[1.0, 0.0, 0.5, 0.0, 0.0, 0.0])
    model = structure.preload().model
    balance = Balance(model, model.joints(np.ones(6)), harmonic_basis([0, 1, 2, 3], 64))
    rng = np.random.default_rng(1)
    q, way = rng.normal(size=(2, 6, 7)) * 1e-7
    tangent = balance.by_motion(balance.joint_forces(q)[1], balance.joints.flat.T @ way)
    matrix = balance.tangent_matrix(balance.joint_forces(q)[1])
    assert np.allclose(np.tensordot(matrix, way, axes=2), tangent, rtol=1e-10, atol=1e-12)
    step = 1e-5
    ahead, behind = (balance.joint_forces(q + s * way)[0] for s in (step, -step))
    assert np.abs((ahead - behind) / (2 * step) - tangent).max() < 1e-7 * np.abs(tangent).max()


def test_a_large_structure_keeps_the_motion_at_its_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forty modes and the static answers to the joint, against all modes; sparse as well."""
    from scipy import sparse

    from microslip.structures import matrices, modal_model

    n = 150
    spring = 5e9 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    stiffness = np.zeros((n, n))
    for i in range(n - 1):
        stiffness[i : i + 2, i : i + 2] += spring * (0.2 if i == 60 else 1.0)
    across = np.zeros(n)
    across[60:62] = -1.0, 1.0
    mass = 0.05 * np.eye(n)

    def curve() -> ms.ModalCurve:
        bar = ms.Structure(sparse.csc_matrix(mass), sparse.csc_matrix(stiffness))
        return bar.attach(JOINT, directions=across).modes(1, [1e-6, 3e-6])

    whole = curve()
    monkeypatch.setattr(modal_model, "LARGEST_WHOLE", 100)
    monkeypatch.setattr(matrices, "LARGEST_DENSE", 100)
    reduced = curve()
    assert np.allclose(reduced.frequency, whole.frequency, rtol=1e-6)
    assert np.allclose(reduced.damping_ratio, whole.damping_ratio, rtol=1e-4)


@pytest.mark.slow
def test_joints_that_never_part_are_integrated_as_a_ring_down_is() -> None:
    """An oscillator beside its own integrator, and a forced chain beside DOP853."""
    from scipy.integrate import solve_ivp

    spring = SPRING + 3e9
    oscillator = ms.Oscillator(mass=2.0, stiffness=spring, joint=JOINT)
    one = ms.Structure([[2.0]], [[spring]]).attach(JOINT, directions=[1.0])
    end = 20.0 * math.pi * math.sqrt(2.0 / (spring + JOINT.tangential_stiffness))
    for slips in (0.5, 3.0):
        exact = oscillator.ring_down(slips * SLIP, duration=end, samples_per_cycle=1024)
        for steps, bar in ((64, 1e-3), (256, 1e-4)):
            time, start = np.linspace(0.0, end, 10 * steps + 1), [slips * SLIP]
            wanted = exact.displacement[:: 1024 // steps]
            motion = one.integrate(None, time, displacement=start)
            error = abs(motion.displacement[:, 0] - wanted).max() / start[0]
            assert error < bar
            assert 0.5 * error < motion.step_error < 5.0 * error
            alpha = one.integrate(None, time, displacement=start, spectral_radius=0.9)
            assert error < 0.1 * abs(alpha.displacement[:, 0] - wanted).max() / start[0]

    stuck = JOINT.tangential_stiffness * np.outer(BETWEEN, BETWEEN) + STIFFNESS
    damped = ms.Structure(MASS, STIFFNESS, 1e-6 * stuck).attach(JOINT, directions=BETWEEN)
    omega, amplitude = 2.0 * math.pi * 3000.0, 1e-3 * JOINT.force_limit  # it sticks: linear

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        push = np.array([0.0, 0.0, amplitude * math.sin(omega * t)])
        pull = stuck @ y[:3] + 1e-6 * stuck @ y[3:]
        return np.append(y[3:], np.linalg.solve(MASS, push - pull))

    time = np.linspace(0.0, 5e-3, 513)
    wanted = solve_ivp(rates, (0.0, 5e-3), np.zeros(6), "DOP853", time, rtol=1e-10, atol=1e-20).y[
        :3
    ]
    force = np.zeros((time.size, 3))
    force[:, 2] = amplitude * np.sin(omega * time)
    found = damped.integrate(force, time).displacement.T
    # What is left is the force between its samples, and microslip.
    assert abs(found - wanted).max() < 2e-3 * abs(wanted).max()


@pytest.mark.slow
def test_the_error_of_the_steps_is_reported_where_faces_part() -> None:
    """A mass bouncing on its face, beside DOP853 and the normal law itself."""
    from scipy.integrate import solve_ivp

    steel = ms.Material(200e9, 0.3)
    surface = rough(ms.Gaussian(5e-7), ms.MaterialPair(steel, steel), 1e-4)
    field = ms.JointField(surface, 0.3, areas=[1e-4], loads=[200.0])
    directions = np.eye(3)[:, [1, 2, 0]].reshape(3, 1, 3)
    bouncing = ms.Structure(np.eye(3), np.diag([1e6, 1e7, 1e7])).attach(
        field, directions=directions
    )
    rest, end, start = float(surface.separation(200.0)), 0.006, 1e-6

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [y[1], float(surface.load(rest + y[0])) - 200.0 - 1e6 * y[0]]

    exact = solve_ivp(
        rates, (0.0, end), [start, 0.0], "DOP853", dense_output=True, rtol=1e-11, atol=1e-16
    )
    for steps in (1024, 4096):
        time = np.linspace(0.0, end, steps + 1)
        motion = bouncing.integrate(None, time, displacement=[start, 0.0, 0.0])
        wanted = exact.sol(time)[0]
        error = abs(motion.displacement[:, 0] - wanted).max() / abs(wanted).max()
        assert 0.9 * error < motion.step_error < 4.0 * error
        assert motion.energy_error < 0.01 * error  # which tells nothing of it


def test_curves_tell_how_their_shape_changes_and_which_multiples_meet_modes() -> None:
    """Two masses whose second mode lies 1 % above twice the first; MAC by its definition."""
    mass, law = np.diag([1.0, 0.5]), ms.SegalmanIwan(5.0, 4e4, -0.3, 1.0)

    def split(side: float) -> float:
        stiffness = np.array([[1e5 + side, -side], [-side, side]])
        stuck = stiffness + np.diag([4e4, 0.0])
        squares = np.linalg.eigvals(np.linalg.solve(mass, stuck)).real
        return float(np.sqrt(squares.max() / squares.min()))

    low, high = 1e3, 5e4  # the ratio falls between them
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if split(middle) > 2.02 else (low, middle)
    side = 0.5 * (low + high)
    pair = ms.Structure(mass, [[1e5 + side, -side], [-side, side]]).attach(
        law, directions=[1.0, 0.0]
    )
    curve = pair.modes(0, [1e-9, 3e-4])
    still = pair.linear_modes().shape[:, 0]
    wanted = [
        abs(still @ mass @ s) ** 2 / (still @ mass @ still) / (s.conj() @ mass @ s).real
        for s in curve.shape
    ]
    np.testing.assert_allclose(curve.mac, wanted, rtol=1e-9)
    assert curve.mac[0] > 1.0 - 1e-9 > curve.mac[1]
    (found,) = curve.near
    assert (found.multiple, found.mode, found.amplitude) == (2, 1, 1e-9)
    assert found.distance == pytest.approx(split(side) / 2.0 - 1.0, abs=1e-5)


def test_a_mode_goes_on_beyond_an_internal_resonance() -> None:
    """The frequency falls through half of that of mode 2, with which a cubic potential couples."""
    rate = 1000.0
    forces = np.linspace(1.0, 40.0, 20)
    joint = ms.Iwan(np.full(20, 0.5 * rate**2 / 20), forces)
    stiffness = np.diag([0.5 * rate**2, (1.97 * rate) ** 2])
    alone = ms.Structure(np.eye(2), stiffness).attach(joint, directions=[1.0, 0.0])
    potential = np.zeros((2, 2, 2))
    potential[0, 0, 1] = potential[0, 1, 0] = potential[1, 0, 0] = 3e7
    coupled = alone.with_geometry(np.eye(2), cubic=potential)
    amplitudes = np.geomspace(1e-6, 4e-4, 12)
    expected, curve = alone.modes(0, amplitudes), coupled.modes(0, amplitudes)
    assert curve.status == "solved"
    crossing = 0.5 * 1.97 * rate / (2.0 * np.pi)
    assert curve.frequency[0] > crossing > curve.frequency[-1]
    far = abs(expected.frequency / crossing - 1.0) > 0.01
    assert far.sum() > 8
    assert np.allclose(curve.frequency[far], expected.frequency[far], rtol=4e-3)
    assert np.allclose(curve.damping_ratio[far], expected.damping_ratio[far], rtol=0.1, atol=1e-9)
