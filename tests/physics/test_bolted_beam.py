"""A measured bolted beam, reduced to 30 patches, where its data lie beside the repository."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

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
    return ms.read_gap_table(SCAN).to_surface(ms.MaterialPair(STEEL, STEEL), area=1e-4)


@functools.cache
def beam(friction: float) -> ms.Preload:
    data = np.load(MODEL)
    field = ms.JointField(surface(), friction, areas=data["patch_areas"], gaps=data["patch_gaps"])
    # Its first degrees of freedom are the relative motions of the patches themselves.
    directions = np.eye(len(data["mass"]))[:, :90].reshape(-1, 30, 3)
    structure = ms.Structure.load(MODEL).attach(field, directions=directions)
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


@pytest.mark.parametrize(("friction", "quick"), [(0.03, 0.02), (0.3, 0.09)])
def test_its_modal_curve_is_solved_up_to_slip(friction: float, quick: float) -> None:
    """From 1e-7 to 6e-5, converged in samples to 1 %; the quick look within what was published."""
    amplitudes = np.geomspace(1e-7, 6e-5, 8)
    curve = beam(friction).modes(0, amplitudes, harmonics=[1, 2, 3])
    finer = beam(friction).modes(0, amplitudes[[3, 7]], harmonics=[1, 2, 3], samples=256)
    assert curve.status == "solved"
    assert np.allclose(curve.damping_ratio[[3, 7]], finer.damping_ratio, rtol=0.01)
    assert np.allclose(curve.frequency[[3, 7]], finer.frequency, rtol=1e-4)
    assert np.abs(curve.damping_difference).max() < quick
    assert np.all(curve.loss > 0.0)


def test_its_modal_curve_is_converged_in_harmonics() -> None:
    few = beam(0.03).modes(0, [6e-5], harmonics=[1, 2, 3])
    more = beam(0.03).modes(0, [6e-5], harmonics=[1, 2, 3, 4, 5])
    assert few.damping_ratio[0] == pytest.approx(more.damping_ratio[0], rel=0.01)
    assert few.frequency[0] == pytest.approx(more.frequency[0], rel=1e-3)


def test_tangents_are_the_differences_of_the_forces_where_patches_slip() -> None:
    """Of all patches at once, in a direction of their own, on the motion of a large amplitude."""
    from microslip.structures.balance import Balance
    from microslip.structures.harmonic_basis import harmonic_basis

    state = beam(0.03)
    curve = state.modes(0, [6e-5], harmonics=[1, 2, 3])
    model = state.model
    shape = curve.shape[0].real
    balance = Balance(model, model.joints(model.shapes[:, 0]), harmonic_basis([0, 1, 2, 3], 64))
    q = np.zeros((model.size, 7))
    q[:, 1] = 6e-5 * model.shapes.T @ np.load(MODEL)["mass"] @ shape
    way = np.random.default_rng(1).normal(size=q.shape) * np.abs(q[:, 1:2])
    tangent = balance.tangent(balance.joint_forces(q)[1], way)
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
