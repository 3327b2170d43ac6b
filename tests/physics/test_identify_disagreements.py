"""What was given and the loops disagree; rigs and laws that are taken for each other."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import stats

import microslip as ms
from microslip.contact.heights import as_heights
from microslip.identification import fit

JOINT = ms.Interface.examples()[0]
PAIR, AREA = JOINT.surface.pair, 2e-4
RIG = 5e8
TRUTH = {
    "std": JOINT.surface.heights.std,
    "slip_scale": JOINT.slip_per_indentation * JOINT.surface.heights.std,
    "radius": JOINT.surface.radius,
    "density": JOINT.surface.density,
}


def record(
    load: float, seed: int, rig: float = RIG, law: Any = None, amplitude: float = 6e-6
) -> ms.Record:
    """Six cycles of 512 samples, the sensors of force and displacement with a little noise."""
    noise = {"force": 5e-4 * load, "displacement": 5e-9, "normal_load": 0.0}
    tribometer = ms.VirtualTribometer(
        law or JOINT.at(normal_load=load), rig_stiffness=rig, noise=noise, seed=seed,
        sample_rate=5120.0,
    )  # fmt: skip
    made = tribometer.record(amplitude=amplitude, frequency=10.0, cycles=6)
    return ms.Record(made.displacement, made.force, load, sample_rate=5120.0)


@cache
def two_loads() -> tuple[ms.Record, ...]:
    """Records at two loads, which tell the spread of the heights."""
    return record(500.0, 1), record(2000.0, 2)


def identified(**options: Any) -> ms.Identification:
    """The joint at two loads, its materials and area known."""
    return ms.identify(
        two_loads(),
        pair=PAIR,
        area=AREA,
        held_back=0,
        intervals="curvature",
        summits=np.inf,
        **options,
    )


# -- given data -----------------------------------------------------------------------------------

WRONG: dict[str, dict[str, Any]] = {
    "spread": {"known": {"std": (1e-6, 1e-8)}},
    "rig": {"rig_stiffness": (4e8, 1e6)},
    "radius or density": {"known": {"radius": (1e-3, 1e-5), "density": (2e8, 1e6)}},
    "area or density": {
        "contact_area": (JOINT.at(normal_load=2000.0).contact_area, 1e-7, 2000.0),
        "known": {"density": (2e8, 1e6)},
    },
    "two that hold each other up": {"known": {"std": (1e-6, 2e-9), "slip_scale": (6.86e-7, 2e-9)}},
}


@pytest.mark.parametrize("name", WRONG)
def test_a_contradiction_is_reported(name: str) -> None:
    """The datum is named with its deviations, and what it has spoilt is in doubt."""
    found = identified(**WRONG[name])
    names = [*WRONG[name].get("known", {})]
    names += ["rig_stiffness"] if "rig_stiffness" in WRONG[name] else []
    for one in names:
        given = next(given for given in found.given if given.name == one)
        assert not given.agrees
        assert abs(given.disagreement) > 3.0
    assert "given values and the loops disagree" in found.message
    assert any("given values and the loops disagree" in note for note in found.notes)
    std = found.derived["std"]
    assert not std.low < TRUTH["std"] < std.high  # it is spoilt
    assert std.verdict == "in doubt"
    assert "disagree" in std.reason
    # Friction is the force at gross slip: it does not hang on any of these.
    assert found.parameters["friction_coefficient"].value == pytest.approx(0.55, rel=1e-3)
    assert "disagree" in found.table()
    written = found.summary()["given"]
    assert [one["name"] for one in written] == [one.name for one in found.given]
    assert written[0]["residual"] == found.given[0].residual


def test_without_it_is_the_fit_of_the_loops_alone() -> None:
    """Against an identification that never heard of it, and the deviations of two values."""
    alone = identified().derived["std"]
    for value, error in ((5.4e-7, 1.5e-8), (6.0e-7, 3e-8), (4.7e-7, 5e-9)):
        given = identified(known={"std": (value, error)}).given[0]
        # The weights are those of the fit with it, which moves them by its own pull: 1 % of std.
        assert given.without == pytest.approx(alone.value, rel=0.01)
        apart = (alone.value - value) / math.hypot(error, alone.standard_error)
        # Two normal errors; a likelihood that is not quite normal parts them by some per cent.
        assert given.disagreement == pytest.approx(apart, rel=0.15)


def test_data_that_agree_raise_no_alarm() -> None:
    """Data scattered as their uncertainty says are off by one standard deviation, mostly."""
    rng = np.random.default_rng(5)
    off = []
    for name, error in (("std", 1e-8), ("slip_scale", 7e-9)) * 8:
        found = identified(known={name: (rng.normal(TRUTH[name], error), error)})
        (given,) = found.given
        assert given.agrees
        assert "disagree" not in found.message
        off.append(given.disagreement)
    # The loops are the same in all trials, their own error shifts each; 16 trials tell a standard
    # deviation to 18 %.
    assert 0.6 < float(np.std(off)) < 1.4
    both = identified(known={"radius": (1.01e-3, 1e-5), "density": (1.01e8, 1e6)})
    assert [one.agrees for one in both.given] == [True, True]
    assert both.derived["std"].verdict == "identified"
    rig = identified(rig_stiffness=(4.98e8, 2e6))
    assert rig.given[0].agrees
    assert rig.given[0].value == 4.98e8
    assert identified().given == ()


# -- rigs and laws --------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_law_that_does_not_suit_blames_no_rig() -> None:
    """Both records are of one rig; with rigs of their own the law would answer no better."""
    for law, options in (("segalman", {}), ("jenkins", {"shared": ["stiffness"]}), ("jenkins", {})):
        found = ms.identify(
            two_loads(), law, held_back=0, intervals="curvature", **options  # type: ignore[arg-type]
        )  # fmt: skip
        assert found.status != "records differ: rigs", law
        assert "name the rig" not in found.message
        assert not any("one rig" in one.reason for one in found.parameters.values())


@pytest.mark.slow
def test_rigs_that_differ_are_reported_with_their_spread() -> None:
    """Compliances of 1/500 and 1/300 m/GN: 50 % of their mean apart."""
    found = ms.identify(
        [record(2000.0, 1), record(2000.0, 2, rig=3e8)], held_back=0, summits=np.inf
    )
    assert found.status == "records differ: rigs"
    assert "compliances that differ by 50 %" in found.message
    assert "if they are of different rigs" in found.message
    assert "which they have not" not in found.parameters["friction_coefficient"].reason


def test_the_rig_depends_on_the_law() -> None:
    """Of a law that leaves several times the noise it takes up what that lacks.

    Segalman's model leaves about five times the noise of a joint with rough surfaces: 1.2 GN/m for
    a rig of 0.5 GN/m, which it calls apparent. Several laws show it by their spread.
    """
    laws = ["interface", "segalman", "jenkins"]
    found = ms.compare(two_loads()[1], laws, held_back=0, summits=np.inf)
    assert 4.0 < found.fits["segalman"].reduced_chi_squared < 100.0
    (rigs,) = found.rigs().values()
    assert rigs["interface"].low < RIG < rigs["interface"].high
    assert rigs["interface"].verdict == "identified"
    wrong = rigs["segalman"]
    assert RIG < 0.6 * wrong.low < wrong.high < math.inf
    assert wrong.verdict == "apparent"
    assert "compare laws" in wrong.remedy
    assert not rigs["interface"].reason
    assert "rig_stiffness: of a law that does not fit" in found.fits["segalman"].table()
    (line,) = (line for line in found.table().splitlines() if line.startswith("rig_stiffness: "))
    for law in rigs:
        assert f"({law})" in line
    known = ms.compare(two_loads()[1], ["jenkins", "interface"], rig_stiffness=RIG, held_back=0)
    assert known.rigs() == {}


# -- contact areas --------------------------------------------------------------------------------


def test_impossible_contact_areas() -> None:
    """More than the apparent area; at a load far from those of the records, or none."""
    area = JOINT.at(normal_load=2000.0).contact_area
    near = identified(contact_area=(area, 0.05 * area, 2000.0))
    assert near.derived["radius"].verdict == "identified"
    far = identified(contact_area=(area, 0.05 * area, 3e4))
    assert any("far from the loads of the records, 500 N to 2.00 kN" in note for note in far.notes)
    for name in ("radius", "density", "summit_count"):
        assert far.derived[name].verdict == "in doubt", name
    assert far.derived["std"].verdict == "identified"


# -- time -----------------------------------------------------------------------------------------


def test_evaluations_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit that uses them up is not converged, says so, and identifies nothing."""
    monkeypatch.setattr(fit, "_MOST_IN_ALL", 3)
    found = identified()
    assert found.status == "not converged"
    assert "it reached its limit of evaluations" in found.message
    numbers = {**found.parameters, **found.derived}
    verdicts = {number.verdict for number in numbers.values()}
    assert verdicts.isdisjoint({"identified", "apparent", "extrapolated"})
    doubted = [n for n in numbers.values() if n.verdict == "in doubt"]
    assert "friction_coefficient" in {n.name for n in doubted}
    assert all("did not end at a minimum" in n.reason and "start=" in n.remedy for n in doubted)


@pytest.mark.parametrize("gap", [1e-9, 1e-4, 0.03, 0.24, 0.9, 3.0, 1e3])
def test_moments_below_all_heights(gap: float) -> None:
    """Of heights spread evenly over [0, 1] they are known; far below few nodes are enough."""
    heights: Any = as_heights(stats.uniform(0.0, 1.0))
    for twice in (-1, 1, 3):
        power = 1.0 + 0.5 * twice
        exact = ((1.0 + gap) ** power - gap**power) / power
        got = heights._moment(twice, np.array([-gap]))[0]
        # The closed form itself loses digits to the difference of powers, of large gaps.
        assert got == pytest.approx(exact, rel=1e-13 + 4e-16 * gap * max(power, 1.0) * 4.0)
    assert heights._cloud(1)[0].size * 8 < heights._cloud(60)[0].size
