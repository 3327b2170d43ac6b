"""Records of known sliders: the generator is right, and intervals hold the true values."""

from __future__ import annotations

import numpy as np
import pytest
from laboratory import free_form
from laboratory.campaign import PARTS, Tally, tallied
from laboratory.free_form import DRIVES, LAWS, NOISES, Sliders, coverage, loops_of, sliders_of

LENGTH, LIMIT = 1e-6, 500.0


@pytest.mark.parametrize("law", LAWS)
def test_sliders_make_the_energies_that_they_state(law: str) -> None:
    """By the area of the stepped loop, alone, at a lower load and behind a rig."""
    own = sliders_of(law, np.random.default_rng(1), LENGTH, LIMIT)
    assert own.force_limit == pytest.approx(LIMIT, rel=1e-7)
    low = own.at(200.0)
    assert low.force_limit == pytest.approx(200.0, rel=1e-12)
    for joint in (own, low, own.behind(0.5 * own.stiffness)):
        a = 1.2 * joint.amplitude_at(0.98)
        u = a * np.sin(np.linspace(0.0, 6.0 * np.pi, 6001))
        force = joint.respond(u, np.full(u.size, joint.force_limit))
        area = 0.5 * (force[1:] + force[:-1]) @ np.where(np.arange(6000) < 2000, 0.0, np.diff(u))
        # The rule of trapezia on a sine of 2000 steps, whose corners are of that size.
        assert 0.5 * area == pytest.approx(joint.dissipated_energy(a), rel=1e-5)
        assert force.max() == pytest.approx(joint.force(a), rel=1e-12)


def test_a_rig_is_solved_at_every_step() -> None:
    """A load that varies by rounding alone takes the way of a varying one."""
    own = sliders_of("gaussian", np.random.default_rng(2), LENGTH, LIMIT)
    rig = 0.7 * own.stiffness
    u = 2e-6 * np.sin(np.linspace(0.0, 4.0 * np.pi, 801))
    limit = np.full(u.size, own.force_limit)
    constant = own.respond(u, limit, rig)
    limit[-1] *= 1.0 + 1e-12
    np.testing.assert_allclose(own.respond(u, limit, rig), constant, atol=1e-9 * LIMIT)


def test_a_slider_that_enters_moves_from_its_entry_on() -> None:
    """One slider whose friction vanishes and returns: it starts anew, without force."""
    one = Sliders(np.array([1e-6]), np.array([1e8]))
    u = np.array([0.0, 5e-7, 6e-7, 7e-7])
    force = one.respond(u, np.array([100.0, 0.0, 50.0, 50.0]) + np.array([0.0, 1e-9, 0.0, 0.0]))
    assert force == pytest.approx([0.0, 1e-9, 10.0, 20.0], abs=1e-6)


def test_sets_differ_in_all_that_they_vary(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(free_form, "_record", lambda *_: None)  # none is needed
    sources = [loops_of(seed).sources for seed in range(63)]
    assert {one["law"] for one in sources} == set(LAWS)
    assert {one["drive"] for one in sources} == set(DRIVES)
    assert len({one["noise"] for one in sources}) == len(NOISES)
    assert len({(one["rig"], one["loads"], one["ripple"]) for one in sources}) >= 20


@pytest.mark.slow
def test_intervals_hold_in_short() -> None:
    """Ten sets; nothing is refused. `make laboratory` has hundreds."""
    counts = coverage(range(0, 70, 7))
    assert not [text for text in counts.failures if "refused" in text]
    assert counts.given["all", "all"] > 150
    assert counts.share("all") >= LEAST_IN_SHORT, counts.failures


LEAST_IN_SHORT = 0.85
"""Of ten sets, whose intervals miss together; of hundreds it is more."""


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
def test_faults_are_held_or_seen(part: str) -> None:
    """Force limits of faulty records are in their intervals, or the fault is reported."""
    whole = Tally()
    for name in PARTS[part][0]:
        whole.add(tallied(part, name, 0))
    assert whole.sets == len(PARTS[part][0])
    assert whole.refused <= 3
    assert len(whole.unseen) <= MOST_UNSEEN[part], whole.unseen


MOST_UNSEEN = {"imperfect": 2, "wrong": 2}
"""A force clipped before its noise and a gain of 2 % are seen by nobody."""
