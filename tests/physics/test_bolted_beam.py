"""A measured bolted beam, reduced to 30 patches, where its data lie beside the repository."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import numpy as np
import pytest
from laps import surface_of_gaps

import microslip as ms

SHARED = Path(__file__).resolve().parents[2].parent / "shared"
MODEL = SHARED / "reference" / "brb_reduced.npz"
SCAN = SHARED / "data" / "scans" / "brb_surface_data.mat"
pytestmark = pytest.mark.skipif(
    not (MODEL.is_file() and SCAN.is_file()),
    reason="no brb_reduced.npz or brb_surface_data.mat in a folder `shared` beside the repository",
)
STEEL = ms.Material(192.31e9, 0.3)


@functools.cache
def surface() -> ms.GreenwoodWilliamson:
    return surface_of_gaps(SCAN, ms.MaterialPair(STEEL, STEEL), area=1e-4)


@functools.cache
def beam(friction: float) -> ms.Preload:
    data = np.load(MODEL)
    field = ms.JointField(surface(), friction, areas=data["patch_areas"], gaps=data["patch_gaps"])
    # Its first degrees of freedom are the relative motions of the patches themselves.
    directions = np.eye(len(data["mass"]))[:, :90].reshape(-1, 30, 3)
    structure = ms.Structure(data["mass"], data["stiffness"]).attach(field, directions=directions)
    return structure.preload(data["static_force"])


def test_the_bolts_press_as_the_contact_does() -> None:
    state = beam(0.3)
    assert state.equilibrium_error < 1e-12
    # Three bolts of 12 249 N each, as the model was made.
    assert state.normal_loads.sum() == pytest.approx(3 * 12249.0, rel=1e-10)
    assert np.allclose(state.pressures * np.load(MODEL)["patch_areas"], state.normal_loads)


def test_its_first_mode_is_that_of_the_model_s_makers() -> None:
    data = np.load(MODEL)
    shape = beam(0.3).linear_modes(1).shape[:, 0]
    assert abs(shape @ data["mass"] @ data["mode_shape_stuck"]) == pytest.approx(1.0, abs=1e-10)


@pytest.mark.parametrize("friction", [0.03, 0.3, 0.6])
def test_its_modal_curve_is_solved_up_to_slip(friction: float) -> None:
    """From 1e-7 to 6e-5, converged in samples to 1 %; slow cycles lose what the balance says."""
    amplitudes = np.geomspace(1e-7, 6e-5, 8)
    curve = beam(friction).modes(0, amplitudes)
    finer = beam(friction).modes(0, amplitudes[[3, 7]], samples=256)
    assert curve.status == "solved"
    assert np.allclose(curve.damping_ratio[[3, 7]], finer.damping_ratio, rtol=0.01)
    assert np.allclose(curve.frequency[[3, 7]], finer.frequency, rtol=1e-4)
    # Loops under the loads at rest told +1 % at 0.03, +9 % at 0.3 and +35 to +220 % at 0.6.
    quick = beam(friction).modes(0, amplitudes, method="quasi-static")
    np.testing.assert_allclose(quick.damping_ratio, curve.damping_ratio, rtol=0.01)
    assert (curve.loss.min(axis=1) > -1e-3 * curve.loss.max(axis=1)).all()


def test_harmonics_that_are_left_out_are_reported() -> None:
    """One step of Newton's method against the solution with ten harmonics."""
    amplitudes = [1e-6, 6e-5]
    odd, usual, many = (
        beam(0.6).modes(0, amplitudes, harmonics=h) for h in ((1, 3), (0, 1, 2, 3), range(10))
    )
    missed = many.damping_ratio / odd.damping_ratio - 1.0
    assert missed[1] > 0.04, "faces that part excite the second"
    assert np.allclose(odd.harmonic_error, missed, atol=0.005)
    assert np.abs(usual.harmonic_error).max() < 0.002
    assert np.allclose(usual.damping_ratio, many.damping_ratio, rtol=0.005)
    quick = beam(0.6).modes(0, amplitudes, method="quasi-static")
    assert np.isnan(quick.harmonic_error).all()


@pytest.mark.slow
def test_a_motion_in_time_misses_the_second_harmonic_by_as_much() -> None:
    """Given the damping of each curve back, the beam swings on: what its amplitude still loses."""
    mass, lost, told = np.load(MODEL)["mass"], [], 0.0
    for harmonics in ((1, 3), (0, 1, 2, 3)):
        curve = beam(0.6).modes(0, [6e-5], harmonics=harmonics)
        told = told or float(curve.harmonic_error[0])
        frequency, damping = curve.frequency[0], curve.damping_ratio[0]
        omega, first = 2.0 * np.pi * frequency, 6e-5 * curve.shape[0]
        driven = dataclasses.replace(beam(0.6), damping=-2.0 * damping * omega * mass)
        motion = driven.integrate(
            None,
            np.arange(0.0, 12.0 / frequency, 1.0 / frequency / 64),
            displacement=first.real,
            velocity=-omega * first.imag,
            spectral_radius=1.0,
        )
        decay = ms.read_decay(motion.time, motion.displacement @ mass @ first.real)
        lost.append(decay.damping_ratio[4:].mean() / damping)
    assert lost[0] - lost[1] == pytest.approx(told, rel=0.2)


def test_tangents_are_the_differences_of_the_forces_where_patches_slip() -> None:
    """Of all patches at once, in a direction of their own, on the motion of a large amplitude."""
    from microslip.structures.balance import Balance
    from microslip.structures.periodic_motion import harmonic_basis

    state = beam(0.03)
    curve = state.modes(0, [6e-5], harmonics=[1, 2, 3])
    model = state.model
    shape = curve.shape[0].real
    balance = Balance(model, model.joints(model.shapes[:, 0]), harmonic_basis([0, 1, 2, 3], 64))
    q = np.zeros((model.size, 7))
    q[:, 1] = 6e-5 * model.shapes.T @ np.load(MODEL)["mass"] @ shape
    way = np.random.default_rng(1).normal(size=q.shape) * np.abs(q[:, 1:2])
    tangent = balance.by_motion(balance.joint_forces(q)[1], balance.joints.flat.T @ way)
    step = 1e-6
    ahead, behind = (balance.joint_forces(q + s * way)[0] for s in (step, -step))
    assert np.abs((ahead - behind) / (2 * step) - tangent).max() < 1e-7 * np.abs(tangent).max()


def test_patches_are_followed_as_by_the_coupled_engine() -> None:
    """Loops of a field on a table of heights, whose load curve has thousands of small kinks."""
    state = beam(0.3)
    field = state.attachments[0].field.at(separations=state.gaps)  # type: ignore[attr-defined]
    phase = 2.0 * np.pi * np.arange(64) / 64
    for node in (0, 14, 29):
        x = 2e-7 * np.sin(phase) + 5e-8 * np.sin(3 * phase)
        d = field.separations[node] + 1e-7 * np.cos(phase)
        cycle = field.periodic(
            np.tile(x, (30, 1)), separations=field.separations[:, None] + (d - d.mean())
        )
        scale = field.areas[node] / 1e-4
        joint = ms.Interface(surface(), 0.3, separation=field.separations[node])
        far = joint.coupled_force(
            np.tile(x, 3), separation=np.tile(field.separations[node] + (d - d.mean()), 3)
        )
        limit = scale * joint.force_limit
        assert np.abs(cycle.force[node] - scale * far[128:]).max() < 1e-12 * limit
