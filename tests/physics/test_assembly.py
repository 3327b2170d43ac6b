"""Bolts tightened in turn: what the faces hold then, and how soon motion forgets it."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from laps import DENSITY, STEEL, small_joint, small_lap

import microslip as ms

PAIR = ms.MaterialPair(STEEL, STEEL)
SURFACE = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), radius=1e-3, density=1e8, area=1e-4)
UNIT = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), radius=1e-3, density=1e8, area=1.0)
ORDERS = ((1, 2, 3), (2, 1, 3), (3, 1, 2))


@lru_cache
def strip() -> ms.ReducedJoint:
    """Three bolts in a lap that gapes a little at its ends."""
    bolts = ms.Bolts([-0.02, 0.0, 0.02], shank=0.005, hole=0.0055, washer=0.009, tension=4e3)
    lap = small_lap(length=0.25, lap=0.064, bolts=bolts)
    joint = lap.reduce(
        STEEL, DENSITY, (8, 2), element_size=0.012, sensors={"tip": ((0.125, 0, 0), "z")}
    )
    return joint.with_form(lambda x, y: 1e-2 * x**2)


@pytest.mark.slow
def test_faces_that_stick_follow_their_stiffness_at_each_load() -> None:
    """One bolt, no slip: tractions by Euler's method along the tightening, a solver of its own."""
    joint, snug = small_joint(), 0.05
    found = joint.assemble(SURFACE, 1e3, steps=40, snug=snug)
    bolt, index = 3 * joint.patches, np.arange(3 * joint.patches).reshape(-1, 3)
    loose = joint.stiffness.copy()
    loose[bolt, bolt] -= joint.bolt_stiffness[0]
    x = joint.with_tension(snug * 5e3).tightened(SURFACE, 1e3).displacement.copy()
    traction, rounds = np.zeros((joint.patches, 2)), 4000
    for _ in range(rounds):
        stiff = joint.patch_areas * UNIT.stiffness(x[index[:, 2]] + joint.patch_gaps)
        tangent = loose.copy()
        tangent[index[:, 2], index[:, 2]] += stiff
        for axis in (0, 1):
            tangent[index[:, axis], index[:, axis]] += stiff / PAIR.stiffness_ratio
        pull = np.zeros(joint.size)
        pull[bolt] = -(1.0 - snug) * 5e3 / rounds
        step = np.linalg.solve(tangent, pull)
        traction += (stiff / PAIR.stiffness_ratio)[:, None] * step[index[:, :2]]
        x += step
    np.testing.assert_allclose(found.tractions, traction, atol=5e-3 * abs(traction).max())
    np.testing.assert_allclose(found.state.displacement[index[:, 2]], x[index[:, 2]], rtol=2e-3)
    assert found.lost < 1e-9


@pytest.mark.slow
def test_what_the_bolts_pull_the_faces_bear_and_what_they_hold_is_friction() -> None:
    joint = strip()
    once = joint.assemble(SURFACE, 0.1)
    # The first two were relieved by those after them, the last has its tension.
    assert once.order == (1, 2, 3)
    np.testing.assert_allclose(once.tensions[2], 4e3, rtol=1e-9)
    assert (once.tensions[:2] < 0.998 * 4e3).all()
    np.testing.assert_allclose(once.state.normal_loads.sum(), once.tensions.sum(), rtol=1e-8)
    # The polygon of sliders lies above the load by some 1e-3.
    assert 0.5 < once.slip_share.max() < 1.002
    assert once.lost > 0.0
    again = joint.assemble(SURFACE, 0.1, passes=3)
    np.testing.assert_allclose(again.tensions, 4e3, rtol=1e-5)
    finer = joint.assemble(SURFACE, 0.1, passes=3, steps=30)
    np.testing.assert_allclose(
        finer.tractions, again.tractions, atol=0.02 * abs(again.tractions).max()
    )
    slippery = joint.assemble(SURFACE, 1e-5, passes=3).state.normal_loads
    smooth = joint.tightened(SURFACE, 1e-5).normal_loads
    np.testing.assert_allclose(slippery, smooth, atol=1e-5 * smooth.max())


def cycled(state: ms.Preload, curve: ms.ModalCurve, place: int, cycles: int) -> Any:
    """Losses of cycles along a mode [J], from what the assembly left on."""
    (faces,) = state.attachments
    shape = curve.shape[place] * curve.modal_amplitude[place]
    group = faces.group(faces.columns.T @ state.displacement, faces.columns.T @ shape.real)
    motion = np.einsum("dnk,d->nk", group.directions, shape)
    memory = group.resumed()
    lost = [float(memory.lost.sum())]
    for _ in range(cycles):
        for angle in 2.0 * np.pi * (np.arange(64) + 1) / 64:
            memory.try_((motion * np.exp(1j * angle)).real)
            memory.commit()
        lost.append(float(memory.lost.sum()))
    return np.diff(lost)


@pytest.mark.slow
def test_settled_motion_forgets_the_order_of_tightening() -> None:
    """And so scatter of assemblies comes of form, friction and tension."""
    joint, amplitudes, damping = strip(), [1e-6, 1e-5], []
    losses: list[list[Any]] = [[], []]
    for order in ORDERS:
        found = joint.assemble(SURFACE, 0.1, order=order, passes=3)
        curve = found.state.modes(0, amplitudes)
        damping.append(curve.damping_ratio)
        for place in (0, 1):
            losses[place].append(cycled(found.state, curve, place, 3))
    # Of the balance: different tractions, the same pressures but for 1e-5.
    assert (np.ptp(damping, axis=0) < 4e-5 * np.mean(damping, axis=0)).all()
    for place in (0, 1):
        scatter = np.ptp(losses[place], axis=0) / np.mean(losses[place], axis=0)
        assert scatter[2] < (5e-5, 6e-6)[place]
        assert scatter[0] > 10.0 * scatter[2]
        settled = np.mean(losses[place], axis=0)[2]
        omega = 2.0 * np.pi * curve.frequency[place]
        ratio = settled / (2.0 * np.pi * (omega * curve.modal_amplitude[place]) ** 2)
        # The first harmonic alone, in time: no harmonic balance.
        np.testing.assert_allclose(ratio, curve.damping_ratio[place], rtol=0.1)
    first = np.ptp(losses[0], axis=0)[:2]
    assert first[1] < 0.06 * first[0], "the first cycle forgets all but some hundredths"
    # Frictionless assembly, a tension 2 % lower, a friction coefficient 2 % lower.
    smooth = joint.tightened(SURFACE, 0.1).modes(0, amplitudes).damping_ratio
    assert (abs(smooth / damping[0] - 1.0) < 3e-3).all()
    other = joint.with_tension(0.98 * 4e3).tightened(SURFACE, 0.1)
    assert (abs(other.modes(0, amplitudes).damping_ratio / smooth - 1.0) > 3e-3).all()


@pytest.mark.slow
def test_motion_in_time_goes_on_from_what_the_faces_hold() -> None:
    found = strip().assemble(SURFACE, 0.1, passes=2)
    state = found.state
    time = np.arange(200) * 1e-6
    rest = state.integrate(None, time)
    assert abs(rest.displacement).max() < 1e-12
    tip = strip().sensor("tip")
    shape = state.linear_modes(1).shape[:, 0]
    pushed = state.integrate(None, time, displacement=1e-6 * shape)
    fresh = strip().tightened(SURFACE, 0.1).integrate(None, time, displacement=1e-6 * shape)
    np.testing.assert_allclose(
        pushed.displacement @ tip, fresh.displacement @ tip, atol=0.02 * abs(tip @ shape) * 1e-6
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"order": [1, 2]}, r"order must name each of the 3 bolts once, got \(1, 2\)"),
        ({"order": [1, 2, 4]}, "order must be an integer from 1 to 3, got 4"),
        ({"steps": 0}, "steps must be an integer from 1 to 1000"),
        ({"passes": 0}, "passes must be an integer from 1 to 20"),
        ({"snug": 1.0}, "snug must be between 0 and 1"),
    ],
)
def test_wrong_orders(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ms.InputError, match=message):
        strip().assemble(SURFACE, 0.1, **given)
