"""Shocks against a closed form, the laws' own histories, and joints stepped by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from usual import BETWEEN, JOINT, MASS, SLIP, STIFFNESS, SURFACE

import microslip as ms

TIP = np.array([0.0, 0.0, 1.0])
ALL = np.ones(3)


def bar() -> ms.Structure:
    return ms.Structure(MASS, STIFFNESS, 2e-7 * STIFFNESS).attach(JOINT, directions=BETWEEN)


def test_a_linear_shock_is_duhamel_s_integral() -> None:
    """A half sine as long as a period and a half, without damping, in closed form."""
    omega = 2.0 * math.pi * 100.0
    length = 0.015
    rate = math.pi / length
    mass = ms.Structure([[2.0]], [[2.0 * omega**2]])
    seen = mass.shock(ms.Pulse.half_sine(50.0, length), directions=[1.0])
    within = seen.time <= length
    t = seen.time[within]
    factor = -50.0 / (omega**2 - rate**2)
    exact = factor * (np.sin(rate * t) - rate / omega * np.sin(omega * t))
    gap = seen.history([1.0])[within] - exact
    assert np.abs(gap).max() < 2e-3 * np.abs(exact).max()
    felt = seen.history([1.0], "acceleration")[within]
    assert np.abs(felt + omega**2 * exact).max() < 5e-3 * omega**2 * np.abs(exact).max()


def test_a_shock_obeys_newton_with_the_law_s_own_history() -> None:
    """Momentum is what forces have put in: the joint's from its history of motion alone."""
    period = 1.0 / bar().linear_modes(1).frequency[0]
    seen = bar().shock(ms.Pulse.half_sine(900.0, period), directions=ALL)
    x = np.stack([seen.history(axis) for axis in np.eye(3)], axis=1)
    v = np.stack([seen.history(axis, "velocity") for axis in np.eye(3)], axis=1)
    assert np.abs(x @ BETWEEN).max() > 5.0 * SLIP
    force = JOINT.force(x @ BETWEEN)
    pull = x @ STIFFNESS + 2e-7 * v @ STIFFNESS + np.outer(force, BETWEEN)
    pull += np.outer(seen.base_acceleration, MASS @ ALL)
    impulse = np.cumsum(0.5 * (pull[1:] + pull[:-1]) * np.diff(seen.time)[:, None], axis=0)
    gap = v[1:] @ MASS + impulse
    assert np.abs(gap).max() < 2e-3 * np.abs(v @ MASS).max()


def stepped(
    pulse: ms.Pulse, step: float, count: int, drag: np.ndarray, answer: Callable[[np.ndarray], Any]
) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations from the ground and displacements by central differences, joints by hand."""
    x, v = np.zeros(3), np.zeros(3)  # at a time, and half a step before
    places, felt = np.empty((2, count, 3))
    pushes = np.interp(step * np.arange(count), pulse.time, pulse.acceleration, right=0.0)
    for i, push in enumerate(pushes):
        felt[i] = -(answer(x) + drag @ v) / np.diag(MASS)
        places[i], a = x, felt[i] - push
        v = v + step * a
        x = x + step * v
    return felt, places


@pytest.mark.slow
@pytest.mark.parametrize(("length", "height"), [(0.3, 300.0), (0.3, 900.0), (3.0, 300.0)])
def test_peaks_and_late_ring_downs_are_those_of_cells_by_hand(length: float, height: float) -> None:
    """Jenkins cells by central differences, where joints hold six sevenths of the mode."""
    stiffnesses, limits = np.full(6, 2.8e8), 2.8e8 * np.geomspace(2e-7, 5e-6, 6)
    soft = STIFFNESS - 1.7e9 * np.outer(BETWEEN, BETWEEN)
    loose = ms.Structure(MASS, soft, 2e-7 * soft).attach(
        ms.Iwan(stiffnesses, limits), directions=BETWEEN
    )
    period = 1.0 / loose.linear_modes(1).frequency[0]
    pulse = ms.Pulse.half_sine(height, length * period)
    end = pulse.duration + 35.0 * period
    seen = loose.shock(pulse, directions=ALL, duration=end)
    slip = np.zeros(6)

    def answer(x: np.ndarray) -> np.ndarray:
        pull = np.clip(stiffnesses * (x @ BETWEEN - slip), -limits, limits)
        slip[:] = x @ BETWEEN - pull / stiffnesses
        return np.asarray(soft @ x + pull.sum() * BETWEEN)

    step = period / 1000.0
    felt, places = stepped(pulse, step, int(end / step), 2e-7 * soft, answer)
    late = np.arange(len(places)) * step > end - 3.0 * period
    assert slip.any()
    assert seen.peak(TIP) == pytest.approx(np.abs(places[:, 2]).max(), rel=5e-3)
    assert seen.peak(TIP, "acceleration") == pytest.approx(np.abs(felt[:, 2]).max(), rel=0.01)
    ringing = np.ptp(seen.history(TIP)[seen.time > end - 3.0 * period])
    assert ringing == pytest.approx(np.ptp(places[late, 2]), rel=0.03)  # three modes' phases


@pytest.mark.parametrize("height", [100.0, 1500.0])
def test_faces_that_part_are_shocked_as_by_central_differences(height: float) -> None:
    """Two nodes that open and slip; the field's state, and an integrator of its own."""
    field = ms.JointField(SURFACE, 0.5, areas=[1e-4, 1e-4], loads=[300.0, 150.0])
    ways = np.zeros((3, 2, 2))
    ways[:, 0, 0], ways[:, 1, 0] = BETWEEN, BETWEEN
    ways[:, 0, 1], ways[:, 1, 1] = 0.5 * BETWEEN, -0.3 * BETWEEN
    soft = STIFFNESS - 1.7e9 * np.outer(BETWEEN, BETWEEN)
    structure = ms.Structure(MASS, soft, 2e-7 * soft).attach(field, directions=ways)
    period = 1.0 / structure.linear_modes(1).frequency[0]
    pulse = ms.Pulse.half_sine(height, 0.5 * period)
    seen = structure.shock(pulse, directions=ALL, duration=3.0 * period)
    state = field.start()

    def answer(x: np.ndarray) -> np.ndarray:
        moved = np.einsum("npk,n->pk", ways, x)
        trial = state.try_(moved[:, 0], separations=field.separations + moved[:, 1])
        state.commit()
        pull = np.einsum("np,p->n", ways[:, :, 0], trial.force)
        return np.asarray(soft @ x + pull + ways[:, :, 1] @ (field.normal_loads - trial.load))

    step = period / 3000.0
    felt, places = stepped(pulse, step, int(3.0 * period / step), 2e-7 * soft, answer)
    assert seen.status == "solved"
    assert seen.peak(TIP) == pytest.approx(np.abs(places[:, 2]).max(), rel=5e-3)
    assert seen.peak(TIP, "acceleration") == pytest.approx(np.abs(felt[:, 2]).max(), rel=0.02)


def test_a_given_pulse_is_one_like_the_built_in() -> None:
    pulse = ms.Pulse.half_sine(100.0, 1e-3)
    one = bar().shock(pulse, directions=ALL)
    same = bar().shock((pulse.time, pulse.acceleration), directions=ALL)
    np.testing.assert_array_equal(one.history(TIP), same.history(TIP))


def test_incomplete_pulses_are_refused() -> None:
    short = ms.Pulse.half_sine(100.0, 1e-4)
    for words, pulse, options in (
        ("pulse must be ms.Pulse", 5.0, {}),
        ("must increase from 0", ([0.1, 0.2], [1.0, 0.0]), {}),
        ("one for each of the 2 times", ([0.0, 0.2], [1.0]), {}),
        ("duration must be at most", short, {"duration": 100.0}),
    ):
        with pytest.raises(ms.InputError, match=words):
            bar().shock(pulse, directions=ALL, **options)
