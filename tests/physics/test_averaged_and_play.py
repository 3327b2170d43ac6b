"""Loops averaged before they are fitted, and the play of a rig; made without the package."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from laboratory.physics import Floats, Joint, motion, respond, sampled, sliders

import microslip as ms

MU, SLIP, SEPARATION, REFERENCE = 0.4, 0.3e-6, 1.0, 1000.0
JOINT = Joint(MU, SLIP, SEPARATION, REFERENCE, 0.9 * MU * REFERENCE / SLIP)
TRUTH = {
    "friction_coefficient": MU,
    "slip_scale": SLIP,
    "standardised_separation": SEPARATION,
    "rig_stiffness": JOINT.rig,
}
NOISE = 0.6, 1e-9
PLAY = 8e-8


@cache
def histories(play: float, ways: float = 0.0) -> list[tuple[float, Floats, Floats]]:
    """Load, displacement and force of six cycles at three loads and two amplitudes.

    The joint sees the displacement less ``play``; its limits are larger by the share ``ways`` one
    way and smaller the other.
    """
    found = []
    for load in (400.0, 1000.0, 2500.0):
        backbone = JOINT.backbone(load)
        full = float(np.interp(0.98 * backbone[1][-1], backbone[1], backbone[0]))
        for reach in (0.5, 2.5):
            x = motion(6, reach * full, 0.02)
            seen, at = np.empty(x.size), 0.0
            for i, place in enumerate(x):
                at = min(max(at, place - 0.5 * play), place + 0.5 * play)
                seen[i] = at
            found.append(
                (load, x, both_ways(seen, backbone, ways) if ways else respond(seen, backbone))
            )
    return found


def both_ways(x: Floats, backbone: tuple[Floats, Floats], share: float) -> Floats:
    """Force of sliders whose limits differ between the two ways."""
    stiffness, limit = sliders(backbone)
    state, force, before = np.zeros_like(stiffness), np.empty(x.size), 0.0
    for i, place in enumerate(x):
        moved = state + stiffness * (place - before)
        state = np.clip(moved, -limit * (1.0 - share), limit * (1.0 + share))
        before, force[i] = place, state.sum()
    return force


def records(play: float = 0.0, ways: float = 0.0) -> list[ms.Record]:
    """Whole records with noise."""
    rng = np.random.default_rng(3)
    return [
        ms.Record(
            sampled(x, 160.0) + 1e-9 * rng.normal(size=960),
            sampled(force, 160.0) + 0.6 * rng.normal(size=960),
            normal_load=load,
            sample_rate=1600.0,
        )
        for load, x, force in histories(play, ways)
    ]


def loops(closed: bool) -> list[ms.Record]:
    """One cycle each, from somewhere on; ``closed`` ones end with their first sample."""
    rng = np.random.default_rng(4)
    made = []
    for load, x, force in histories(0.0):
        phase = float(rng.integers(480, 960))
        way, pull = (sampled(values[480:], 240.0, phase)[:240] for values in (x, force))
        way = way + NOISE[1] * rng.normal(size=240) + 3e-6
        pull = pull + NOISE[0] * rng.normal(size=240)
        if closed:
            way, pull = np.append(way, way[0]), np.append(pull, pull[0])
        made.append(ms.Record(way, pull, normal_load=load))
    return made


def held(fit: ms.Identification) -> int:
    """How many of the truths lie within half a width beyond their intervals: 95 % is not all."""
    inside = 0
    for name, truth in TRUTH.items():
        fitted = fit.parameters[name]
        room = 0.5 * (fitted.high - fitted.low)
        inside += fitted.low - room <= truth <= fitted.high + room
    return inside


@pytest.mark.parametrize("closed", [False, True])
def test_averaged_loops_with_their_noise(closed: bool) -> None:
    fit = ms.identify(loops(closed), noise=NOISE, summits=np.inf)
    assert {fit.parameters[name].verdict for name in TRUTH} == {"identified"}
    assert held(fit) == 4
    assert fit.reduced_chi_squared == pytest.approx(1.0, abs=0.15)  # 1400 residuals: 0.04
    assert fit.held_back is None
    assert all(record.folded.cycles == 1 for record in fit.records)


def test_wrong_averaged_loops_are_refused() -> None:
    load, x, force = histories(0.0)[0]
    whole = ms.Record(x, force, normal_load=load)
    with pytest.raises(ms.InputError, match="an averaged loop is one cycle"):
        ms.identify(whole, noise=NOISE)
    for wrong in (2.0, "2 N", (0.0, 1e-9), (1.0, -1e-9), (1.0,)):
        with pytest.raises(ms.InputError, match="noise"):
            ms.identify(whole, noise=wrong)  # type: ignore[arg-type]


@pytest.mark.slow
def test_play_is_reported_and_removed() -> None:
    """80 nm of play: a note names it; asked for, it is found, and the joint beside it."""
    moved = records(PLAY)
    blind = ms.identify(moved, held_back=0.0, intervals="curvature")
    assert any("play of" in note and "would explain" in note for note in blind.notes)
    assert "identified" not in {blind.parameters[name].verdict for name in TRUTH}
    fit = ms.identify(moved, nuisances=["play"], summits=np.inf)
    assert 2.0 * fit.records[0].folded.play == pytest.approx(PLAY, rel=0.01)
    assert fit.reduced_chi_squared < 1.2
    assert held(fit) == 4


def test_no_play_where_there_is_none() -> None:
    fit = ms.identify(records(), nuisances=["play"], held_back=0.0, intervals="curvature")
    assert any("no play" in note for note in fit.notes) or (
        2.0 * fit.records[0].folded.play < 0.02 * PLAY
    )
    assert held(fit) == 4


def test_friction_that_differs_between_the_ways_moves_the_middle_alone() -> None:
    """Limits 12 % higher one way and lower the other: their mean is found, and all else."""
    fit = ms.identify(records(ways=0.12), held_back=0.0, intervals="curvature", summits=np.inf)
    assert fit.reduced_chi_squared < 1.2
    assert {fit.parameters[name].verdict for name in TRUTH} == {"identified"}
    assert held(fit) == 4
