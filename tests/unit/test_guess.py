"""A guess of each law from loops: near, with noise and compliance, and clear where it cannot be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from cases import law_params

import microslip as ms
from microslip._core.checks import Floats
from microslip.friction.guesses import all_features

# A joint that never slips wholly does not show its limit: loops of a few reaches do.
AMPLITUDES = (4.0, 20.0)
LAW_PARAMS = law_params()


@dataclass(frozen=True)
class Plain:
    """What has displacement and force, and nothing else that a guess could lean on."""

    displacement: Floats
    force: Floats
    normal_load: Any = None


def reach(law: Any) -> float:
    if math.isinf(law.tangential_stiffness):
        return 1e-6
    return float(law.force_limit / law.tangential_stiffness)


def known(law: Any) -> dict[str, Any]:
    """What a guess of this law must be told besides loops."""
    if isinstance(law, ms.Asperity):
        return {"pair": law.pair, "normal_load": law.normal_load}
    if isinstance(law, ms.PressedJoint):
        return {"pressure": law.pressure, **known(law.laws[0]), "normal_load": law.normal_load}
    if not isinstance(law, ms.Interface):
        return {}
    told: dict[str, Any] = {"pair": law.surface.pair, "normal_load": law.normal_load}
    if isinstance(law.surface, ms.GreenwoodWilliamson):
        told["heights"] = law.surface.heights
    return told


def near(guessed: Any, law: Any, *, friction: float = 0.1) -> None:
    assert type(guessed) is type(law)
    if isinstance(law, ms.Interface | ms.PressedJoint):
        assert guessed.friction_coefficient == pytest.approx(law.friction_coefficient, rel=friction)
    assert 0.5 < guessed.force_limit / law.force_limit < 2.0
    if math.isfinite(law.tangential_stiffness):
        assert 0.5 < guessed.tangential_stiffness / law.tangential_stiffness < 2.0


def cycles(loop: ms.Loop, count: int) -> tuple[Floats, Floats]:
    return np.tile(loop.displacement[:-1], count), np.tile(loop.force[:-1], count)


@pytest.mark.parametrize("law", LAW_PARAMS)
def test_guess_of_its_own_loops_is_near(law: Any) -> None:
    loops = [law.loop(a * reach(law), 400) for a in AMPLITUDES]
    for loop in loops:
        near(type(law).guess(loop, **known(law)), law)
    guessed = type(law).guess(loops, **known(law))
    near(guessed, law)
    for loop in loops:
        energy = guessed.loop(loop.displacement_amplitude).dissipated_energy
        assert energy == pytest.approx(loop.dissipated_energy, rel=0.1)


@pytest.mark.parametrize("law", LAW_PARAMS)
def test_guess_survives_noise_transients_and_offsets(law: Any) -> None:
    loop = law.loop(5.0 * reach(law), 400)
    x, t = cycles(loop, 6)
    # From rest it begins, off the middle, and ends within a branch.
    x, t = np.append(np.linspace(0.0, x[0], 100), x[:-70]), np.append(np.zeros(100), t[:-70])
    random = np.random.default_rng(5)
    x = x + 0.002 * loop.displacement_amplitude * random.standard_normal(x.size) + 3e-6
    t = t + 0.01 * loop.force_amplitude * random.standard_normal(t.size)
    t = t + 0.3 * loop.force_amplitude
    near(type(law).guess(Plain(x, t), **known(law)), law)


@pytest.mark.parametrize("law", law_params(which=lambda law: isinstance(law, ms.Interface))[:6])
def test_guess_survives_compliance(law: ms.Interface) -> None:
    loop = law.loop(10.0 * reach(law), 400)
    soft = loop.displacement + loop.force / law.tangential_stiffness  # a rig as stiff as the joint
    guessed = type(law).guess(ms.Loop(soft, loop.force), **known(law))
    assert guessed.friction_coefficient == pytest.approx(law.friction_coefficient, rel=0.1)
    assert 0.4 < guessed.tangential_stiffness / law.tangential_stiffness < 1.1


def test_features_of_a_loop() -> None:
    law = ms.Jenkins(5e7, 100.0)
    loop = law.loop(8e-6, 2001)
    found = all_features(loop)[0]
    assert found.amplitude == pytest.approx(8e-6, rel=1e-3)
    assert found.force_amplitude == pytest.approx(100.0, rel=1e-12)
    assert found.stiffness == pytest.approx(5e7, rel=1e-6)
    # Bins are a sixteenth of a branch at most: the corner is within one.
    assert found.energy == pytest.approx(loop.dissipated_energy, rel=0.01)
    assert found.sliding_ratio == pytest.approx(loop.sliding_ratio, abs=0.01)


def test_loads_of_several_records_give_one_joint() -> None:
    truth = ms.Interface.examples()[0]
    joints = [truth.at(normal_load=load) for load in (200.0, 1000.0, 5000.0)]
    records = []
    for joint in joints:
        x, t = cycles(joint.loop(6.0 * reach(joint), 300), 3)
        records.append(ms.Record(x, t, normal_load=joint.normal_load))
    guessed = ms.Interface.guess(
        records, pair=truth.surface.pair, radius=truth.surface.radius, area=truth.surface.area
    )
    assert guessed.normal_load == pytest.approx(1000.0)
    assert guessed.friction_coefficient == pytest.approx(truth.friction_coefficient, rel=0.02)
    surface = guessed.surface
    assert surface.heights.std == pytest.approx(truth.surface.heights.std, rel=0.3)
    assert 0.5 < surface.density / truth.surface.density < 2.0
    assert surface.radius == truth.surface.radius
    for joint in joints:
        again = guessed.at(normal_load=joint.normal_load)
        assert 0.8 < again.tangential_stiffness / joint.tangential_stiffness < 1.25


def test_radius_without_one_is_the_convention() -> None:
    joint = ms.Interface.examples()[0]
    surface = ms.Interface.guess(
        joint.loop(5.0 * reach(joint)), pair=joint.surface.pair, normal_load=joint.normal_load
    ).surface
    assert surface.density * surface.radius * surface.heights.std == pytest.approx(0.05)
    assert surface.area == 1e-4


def test_normal_load_of_a_record_may_be_measured() -> None:
    joint = ms.Asperity.examples()[0]
    x, t = cycles(joint.loop(6.0 * reach(joint), 300), 3)
    load = joint.normal_load * (1.0 + 0.01 * np.sin(np.arange(x.size)))
    near(ms.Asperity.guess(ms.Record(x, t, normal_load=load), pair=joint.pair), joint)


# -- a law that somebody adds ---------------------------------------------------------------------


# -- what is no data ------------------------------------------------------------------------------

LOOP = ms.Jenkins(5e7, 100.0).loop(8e-6)
PAIR = ms.Interface.examples()[0].surface.pair


@pytest.mark.parametrize("law", [*dict.fromkeys(type(p.values[0]) for p in LAW_PARAMS)])
@pytest.mark.parametrize(
    ("data", "message"),
    [
        (7.0, "data must be a Loop, a Record or a list of these"),
        ([], "data must be one or more loops or records, got an empty list"),
        (Plain(np.zeros(9), np.arange(9.0)), "displacement must vary, got 0 m throughout"),
        (Plain(np.arange(9.0), np.ones(9)), "force must vary, got 1 N throughout"),
        (Plain(np.arange(9.0), np.arange(8.0)), "must have the same length"),
        (Plain(np.arange(9.0), np.full(9, np.nan)), "force must be finite"),
        (Plain(np.arange(9.0), np.arange(9.0)), "data must hold a closed cycle"),
        (Plain(LOOP.displacement, -LOOP.force), "reverse the sign of the force"),
    ],
    ids=["number", "none", "rest", "constant", "lengths", "nan", "one way", "sign"],
)
def test_bad_data(law: Any, data: Any, message: str) -> None:
    more: dict[str, Any] = {}
    if issubclass(law, ms.Interface | ms.PressedJoint):
        more = {"pair": PAIR, "normal_load": 500.0}
    if issubclass(law, ms.PressedJoint):
        more["pressure"] = ms.Pressure.cone(outer=0.01)
    with pytest.raises(ms.InputError, match=message):
        law.guess(data, **more)
