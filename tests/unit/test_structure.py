"""Structures: what goes in, what is refused, what a result looks like."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import linalg, sparse
from usual import SURFACE, rough

import microslip as ms


def spring_chain(masses: list[float], springs: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of masses in a row; the first spring is to ground (0: none)."""
    n = len(masses)
    stiffness = np.zeros((n, n))
    for i, k in enumerate(springs):
        stiffness[i, i] += k
        if i > 0:
            stiffness[i - 1, i - 1] += k
            stiffness[i, i - 1] -= k
            stiffness[i - 1, i] -= k
    return np.diag(masses), stiffness


MASS, STIFFNESS = spring_chain([2.0, 3.0, 2.0], [2e7, 1e7, 1e7])
LAW = ms.Jenkins(5e6, 100.0)
BETWEEN = [1.0, -1.0, 0.0]


@pytest.fixture
def chain() -> ms.Structure:
    return ms.Structure(MASS, STIFFNESS).attach(LAW, directions=BETWEEN)


@pytest.mark.parametrize("form", [sparse.csr_matrix, sparse.coo_array])
def test_sparse_matrices_count_as_dense_ones(chain: ms.Structure, form: type) -> None:
    thin = ms.Structure(form(MASS), form(STIFFNESS), form(1e-5 * STIFFNESS))
    thick = ms.Structure(MASS, STIFFNESS, 1e-5 * STIFFNESS)
    curves = [s.attach(LAW, directions=BETWEEN).modes(0, [1e-5, 1e-4]) for s in (thin, thick)]
    assert np.allclose(curves[0].frequency, curves[1].frequency, rtol=1e-12)
    assert np.allclose(curves[0].damping_ratio, curves[1].damping_ratio, rtol=1e-9)
    with pytest.raises(ms.InputError, match="mass must be symmetric"):
        ms.Structure(form(np.triu(MASS + 1.0)), form(STIFFNESS))
    with pytest.raises(ms.InputError, match="negative in any direction"):
        ms.Structure(form(MASS), form(STIFFNESS - 2e7 * np.eye(3)))


def test_a_sensor_at_a_node_of_the_mode_is_refused() -> None:
    mass, stiffness = spring_chain([1.0, 1.0, 1.0], [0.0, 1e6, 1e6])
    free = ms.Structure(mass, stiffness).attach(LAW, directions=[1.0, 0.0, -1.0])
    with pytest.raises(ms.InputError, match="it has a node there"):
        free.modes(1, [1e-6], at=[0.0, 1.0, 0.0])


def test_amplitudes_may_be_what_a_sensor_shows(chain: ms.Structure) -> None:
    sensor = np.array([0.0, 0.0, 1.0])
    for method in ("harmonic-balance", "quasi-static"):
        for power, quantity in enumerate(("displacement", "velocity", "acceleration")):
            modal = chain.modes(0, [1e-5, 3e-5], method=method)
            omega = 2.0 * np.pi * modal.frequency
            seen = np.abs(modal.shape @ sensor) * modal.modal_amplitude * omega**power
            same = chain.modes(0, seen, method=method, at=sensor, quantity=quantity)
            assert np.allclose(same.modal_amplitude, modal.modal_amplitude, rtol=1e-8)
            assert np.allclose(same.frequency, modal.frequency, rtol=1e-9)
            assert np.allclose(same.damping_ratio, modal.damping_ratio, rtol=1e-6)


@pytest.mark.parametrize("method", ["harmonic-balance", "quasi-static"])
def test_unreachable_targets_are_kept_and_reported(method: Any) -> None:
    """All that holds the mass is the joint: once it slides there is no mode any more."""
    loose = ms.Structure([[1.0]], [[0.0]]).attach(ms.Jenkins(1e6, 10.0), directions=[1.0])
    assert loose.preload([5.0]).displacement[0] == pytest.approx(5e-6)
    curve = loose.modes(0, [1e-6, 1e-2], method=method)
    assert curve.status == "stopped"
    assert curve.message.startswith("stopped beyond the amplitude")
    assert curve.frequency[0] == pytest.approx(1000.0 / (2.0 * np.pi), rel=1e-9)
    assert np.isnan(curve.frequency[1])


def test_static_forces_must_have_something_to_push_against(chain: ms.Structure) -> None:
    with pytest.raises(ms.InputError, match=r"must have the shape \(3,\), got \(1,\)"):
        chain.preload([1.0])
    mass, stiffness = spring_chain([1.0, 1.0], [0.0, 1e6])
    free = ms.Structure(mass, stiffness).attach(LAW, directions=[1.0, -1.0])
    with pytest.raises(ms.InputError, match=r"static_force must be balanced.*1 unrestrained"):
        free.preload([1.0, 0.0])
    assert free.preload([1.0, -1.0]).equilibrium_error < 1e-12


def test_a_structure_without_joints_is_linear_and_one_without_stiffness_has_no_mode() -> None:
    damped = ms.Structure(MASS, STIFFNESS, 1e-6 * STIFFNESS)
    squares = linalg.eigh(STIFFNESS, MASS, eigvals_only=True)
    for method in ("harmonic-balance", "quasi-static"):
        curve = damped.modes(1, [1e-6, 1e-3], method=method)
        np.testing.assert_allclose(2.0 * np.pi * curve.frequency, np.sqrt(squares[1]), rtol=1e-10)
        np.testing.assert_allclose(curve.damping_ratio, 5e-7 * np.sqrt(squares[1]), rtol=1e-9)
    loose = ms.Structure(MASS, np.zeros((3, 3)))
    for ask in (
        lambda: loose.modes(0, [1e-6]),
        lambda: loose.forced_response([1.0, 0.0, 0.0], [50.0, 60.0]),
    ):
        with pytest.raises(ms.InputError, match="the structure has no elastic mode"):
            ask()


def test_verdicts_tell_units_and_rigid_motion(chain: ms.Structure) -> None:
    def words(s: ms.Structure) -> dict[str, str]:
        return {v.name: v.word for v in s.verdicts}

    assert words(chain)["first elastic frequency"] == "ok"
    mixed = ms.Structure(1e-9 * MASS, STIFFNESS)
    assert words(mixed)["first elastic frequency"] == "outside"
    mass, stiffness = spring_chain([1.0, 1.0, 1.0], [0.0, 1e6, 1e6])
    free = ms.Structure(mass, stiffness)
    tied = free.attach(LAW, directions=[1.0, -1.0, 0.0])
    askew = free.attach(LAW, directions=[1.0, -0.999, 0.0])
    assert words(tied)["joint motion in rigid motion"] == "ok"
    assert words(askew)["joint motion in rigid motion"] == "outside"
    assert words(chain)["joint motion in rigid motion"] == "not judged"


def test_faces_must_touch() -> None:
    field = ms.JointField(SURFACE, 0.3, areas=[1e-4], gaps=[1e-5])
    plain = ms.Structure(np.eye(3), 1e6 * np.eye(3))
    lap = plain.attach(field, directions=np.eye(3).reshape(3, 1, 3))
    with pytest.raises(ms.InputError, match="all 1 nodes of a field are open"):
        lap.preload([0.0, 0.0, 500.0])
    pressed = lap.preload([0.0, 0.0, -500.0])
    assert pressed.normal_loads[0] > 300.0
    assert pressed.gaps[0] == pytest.approx(1e-5 + pressed.displacement[2])


@pytest.mark.slow
@pytest.mark.parametrize("way", [1, -1])
def test_a_folded_response_is_saved_as_a_sweep_meets_it(way: int, tmp_path: Path) -> None:
    """The chain's own stable motions, those ahead of the jump; a linear one is its closed form."""
    mass, stiff, damping = np.eye(2), 1e6 * np.array([[2.0, -1.0], [-1.0, 2.0]]), 2.0 * np.eye(2)
    frequencies = np.linspace(140.0, 180.0, 81)[::way]
    free = ms.Structure(mass, stiff, damping)
    linear = free.attach(ms.Jenkins(1e5, 1e9), directions=[1.0, 0.0])
    push, at = np.array([3.0, 0.0]), np.array([0.0, 1.0])
    told = linear.forced_response(push, frequencies, harmonics=[1]).frequency_response(
        at, 3.0, quantity="acceleration"
    )
    stuck = stiff + np.diag([1e5, 0.0])
    omega = 2.0 * np.pi * told.frequency
    wanted = [
        -(w**2) * np.linalg.solve(stuck - w**2 * mass + 1j * w * damping, [1.0, 0.0])[1]
        for w in omega
    ]
    np.testing.assert_allclose(told.value, wanted, rtol=1e-9)
    told.save(tmp_path / "one.csv")
    table = np.loadtxt(tmp_path / "one.csv", delimiter=",", skiprows=1)
    assert np.array_equal(table[:, 2] + 1j * table[:, 3], told.value)
    hard = free.with_geometry([[1.0], [0.0]], cubic=[[[0.0]]], quartic=[[[[1e12]]]])
    whole = hard.forced_response(push, frequencies, harmonics=[1])
    assert whole.turning_points.size == 2
    met = whole.frequency_response(at, 3.0)
    assert (np.diff(met.frequency) > 0.0).all()
    alike = np.isclose(whole.amplitude(at)[:, None] / 3.0, abs(met.value), rtol=1e-9)
    kept = (alike & (whole.frequency[:, None] == met.frequency)).any(axis=1)
    assert kept.sum() == met.frequency.size
    assert whole.stable[kept].all()
    largest = abs(met.value).max() * 3.0
    assert (largest < 0.99 * whole.amplitude(at).max()) == (way < 0), (
        "a hardening peak, met from below"
    )


def test_faces_that_hardly_touch_are_pressed_however_far_a_first_step_goes() -> None:
    """A gap of 1 mm on a spring of 1 mN/m: Newton's first step goes a kilometre through it."""
    steel = ms.Material(210e9, 0.3)
    surface = rough(ms.Gaussian(5e-7), ms.MaterialPair(steel, steel), 1e-4)
    field = ms.JointField(surface, 0.3, areas=[1e-4], gaps=[1e-3])
    held = ms.Structure(np.eye(3), np.diag([1.0, 1.0, 1e-3]))
    rest = held.attach(field, directions=np.eye(3)[:, None, :]).preload([0.0, 0.0, -1.0])
    assert rest.equilibrium_error < 1e-10
    load = surface.load(1e-3 + rest.displacement[2])
    assert load == pytest.approx(1.0 + 1e-3 * rest.displacement[2], rel=1e-9)


def test_joints_are_attached_to_a_new_structure(chain: ms.Structure) -> None:
    plain = ms.Structure(MASS, STIFFNESS)
    more = plain.attach(LAW, directions=BETWEEN)
    assert plain.attachments == ()
    assert len(more.attachments) == 1
    with pytest.raises(ms.InputError, match=r"shape \(3,\) or \(3, columns\).*got \(2,\)"):
        plain.attach(LAW, directions=[1.0, -1.0])
    with pytest.raises(ms.InputError, match=r"column \(1,\) is all zeros"):
        plain.attach(LAW, directions=[[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    with pytest.raises(ms.InputError, match="Coulomb friction is rigid there"):
        plain.attach(ms.Coulomb(10.0), directions=BETWEEN)
    with pytest.raises(ms.InputError, match="joint must be a backbone law"):
        plain.attach(5.0, directions=BETWEEN)  # type: ignore[arg-type]


def test_modes_refuse_what_they_cannot_answer(chain: ms.Structure) -> None:
    for message, options in (
        ("index must be below 3", {"index": 3}),
        ("harmonics must include 1, got", {"harmonics": [3]}),
        ("samples must be at least 12", {"samples": 8}),
        ('method must be "harmonic-balance" or "quasi-static"', {"method": "newmark"}),
        ('quantity="velocity" needs a sensor', {"quantity": "velocity"}),
    ):
        with pytest.raises(ms.InputError, match=message):
            chain.modes(**{"index": 0, "amplitudes": [1e-6], **options})
