"""Frequency and damping of a curve beside each other, and the damping that a free decay shows.

A frequency that falls by friction adds damping in a known ratio; by geometry it does not. A decay
shows other damping ratios than steady motion.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from usual import JOINT, SLIP

import microslip as ms
from microslip.structures.modal_curve import added_damping, judge_shift


def by_swings(turning: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes and damping ratios by what a cycle takes of the swings, half ranges."""
    swings = 0.5 * np.abs(np.diff(turning))
    return np.sqrt(swings[2:] * swings[:-2]), np.log(swings[:-2] / swings[2:]) / (2.0 * np.pi)


def along(amplitude: np.ndarray, curve: ms.ModalCurve, ratio: np.ndarray) -> np.ndarray:
    return np.interp(np.log(amplitude), np.log(curve.modal_amplitude), ratio)


@pytest.mark.parametrize("chi", [-0.5, -0.1])
def test_joints_hold_what_their_tangent_does(chi: float) -> None:
    """Segalman's joint beside a spring, each swing with its exact memory."""
    law = ms.SegalmanIwan(force_limit=100.0, stiffness=1e7, chi=chi, beta=1.0)
    structure = ms.Structure([[1.0]], [[1e7]]).attach(law, directions=[1.0])
    curve = structure.modes(0, np.geomspace(5e-7, 6e-6, 24), harmonics=(0, 1, 3, 5))
    swings = ms.Oscillator(1.0, 1e7, law).ring_down(5.5e-6, cycles=40)
    amplitude, ratio = by_swings(swings.turning_displacement)
    steady = along(amplitude, curve, curve.damping_ratio)
    free = along(amplitude, curve, curve.decay_damping_ratio)
    # Four or so times the damping ratio is what theory leaves open: (pi/2)(2 + d ln zeta/d ln a).
    assert ((ratio / steady - 1.0) / steady).min() > 3.0
    np.testing.assert_allclose(free, ratio, rtol=6e-3)


def test_springs_hold_more_as_they_stiffen() -> None:
    """Cubic springs with dashpots: the action omega a^2/2 is what decays."""
    plate = ms.Structure([[1.0]], [[4e4]], [[0.8]]).with_geometry([1.0], quartic=[[[[1e10]]]])
    steady = plate.modes(0, np.geomspace(2e-4, 1.1e-3, 24))
    swung = solve_ivp(
        lambda t, y: (y[1], -0.8 * y[1] - 4e4 * y[0] - 4e10 * y[0] ** 3),
        (0.0, 0.6), (1e-3, 0.0), rtol=1e-10, atol=1e-15, events=lambda t, y: y[1],
    )  # fmt: skip
    turning = swung.y_events[0][:, 0]
    # From peaks to the fundamental, by which the curve counts: a third harmonic takes its part.
    peak = np.abs(turning)
    swings = peak * (1.0 - 4e10 * peak**2 / 32.0 / (4e4 + 3e10 * peak**2))
    amplitude, ratio = np.sqrt(swings[2:] * swings[:-2]), np.log(swings[:-2] / swings[2:])
    ratio /= 2.0 * np.pi
    wrong = along(amplitude, steady, steady.damping_ratio)
    free = along(amplitude, steady, steady.decay_damping_ratio)
    assert (wrong / ratio - 1.0)[0] > 0.15
    np.testing.assert_allclose(free, ratio, rtol=3e-3)


def test_a_test_is_held_against_its_own_kind() -> None:
    law = ms.SegalmanIwan(force_limit=100.0, stiffness=1e7, chi=-0.5, beta=1.0)
    curve = ms.Structure([[1.0]], [[1e7]]).attach(law, directions=[1.0]).modes(0, [1e-6, 3e-6])
    values = curve.modal_amplitude, curve.frequency, curve.damping_ratio
    time = np.arange(0.0, 1.0, 1e-3)
    ring = np.exp(-3.0 * time) * np.cos(300.0 * time)
    decay = ms.ModalTest.from_ring_down(time, ring)
    assert decay.motion == "decay"
    assert ms.ModalTest(*values).motion == "steady"
    np.testing.assert_array_equal(decay.damping_of(curve), curve.decay_damping_ratio)
    np.testing.assert_array_equal(ms.ModalTest(*values).damping_of(curve), curve.damping_ratio)
    assert (decay.damping_of(curve) > curve.damping_ratio).all()
    with pytest.raises(ms.InputError, match='motion must be "steady" or "decay"'):
        ms.ModalTest(*values, motion="free")


def judged(curve: ms.ModalCurve) -> tuple[float | None, str]:
    verdict = judge_shift("test", curve.amplitude, curve.frequency, curve.damping_ratio)
    return verdict.value, verdict.word


def test_microslip_adds_the_damping_of_a_bent_backbone() -> None:
    """By harmonic balance of a mass on a spring and a rough joint."""
    mass = ms.Structure([[2.0]], [[4.0 * JOINT.tangential_stiffness]])
    jointed = mass.attach(JOINT, directions=[1.0])
    curve = jointed.modes(0, SLIP * np.geomspace(0.03, 0.3, 9), at=[1.0])
    value, word = judged(curve)
    assert value == pytest.approx(1.0, abs=0.15)
    assert word == "ok"
    shift = 1.0 - curve.frequency[0] / curve.linear_frequency
    assert curve.damping_ratio[0] == pytest.approx(added_damping(shift), rel=0.1)


@pytest.mark.parametrize("quartic", [6e23, -6e23])
def test_geometry_is_distinguished(quartic: float) -> None:
    mass = ms.Structure([[2.0]], [[4.0 * JOINT.tangential_stiffness]])
    jointed = mass.attach(JOINT, directions=[1.0])
    whole = jointed.with_geometry([1.0], quartic=np.full((1,) * 4, quartic))
    curve = whole.modes(0, SLIP * np.geomspace(0.03, 0.3, 5), at=[1.0])
    value, word = judged(curve)
    assert value is not None
    assert word == "outside", (value, curve.frequency)


def test_what_does_not_move_is_not_judged() -> None:
    still = judge_shift("t", np.array([1.0, 2.0]), np.full(2, 100.0), np.array([0.01, 0.02]))
    assert still.word == "not judged"
    assert "t" in still.name
