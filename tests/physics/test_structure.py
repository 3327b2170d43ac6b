"""Structures with joints against independent methods, limits and invariants."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy import optimize

import microslip as ms

METAL = ms.Material(69e9, 0.33)
SURFACE = ms.GreenwoodWilliamson(
    ms.MaterialPair(METAL, METAL), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
JOINT = ms.Interface(SURFACE, 0.55, normal_load=2000.0)
SLIP = JOINT.force_limit / JOINT.tangential_stiffness
MASS = np.diag([2.0, 3.0, 2.0])
SPRING = 2e9
STIFFNESS = SPRING * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
BETWEEN = np.array([1.0, -1.0, 0.0])


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
    """From a thousandth of the joint's slip scale to gross slip."""
    shape = np.abs(BETWEEN @ chain().linear_modes(1).shape[:, 0])
    amplitude = slips * SLIP / shape
    curve = chain().modes(0, [amplitude], samples=4096)
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
    curve = chain().modes(0, [1e-8, 1e-7])
    assert np.abs(curve.frequency_difference).max() < 1e-6
    assert np.abs(curve.damping_difference).max() < 1e-4


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
