"""Intervals of `measure` hold the truth of records by explicit sliders, and faults are named."""

from __future__ import annotations

import math

import numpy as np
import pytest
from laboratory.imperfections import an_imperfect_set
from laboratory.loops import CAUSES, CLEAN, FAULTS, Kind, drive, noisy, respond, sampled
from laboratory.measured import UNDECIDED, coverage, verdict_on

import microslip as ms

QUICK = (
    "jenkins, 20 samples",
    "iwan, partial slip",
    "two sliders",
    "saw",
    "steps of the amplitude",
    "chirp",
)


@pytest.mark.parametrize("name", QUICK)
def test_intervals_hold(name: str) -> None:
    """Of 12 intervals with 95 % each at most two miss (1 in 50 by chance)."""
    held = coverage([name], [0, 1])[name]
    assert held.number.total() - held.held.total() <= 2, held.missed


@pytest.mark.slow
def test_intervals_hold_in_ordinary_kinds() -> None:
    found = coverage(CLEAN, range(2))
    assert not [name for name, held in found.items() if held.is_short]
    number = sum(held.number.total() for held in found.values())
    assert sum(held.held.total() for held in found.values()) >= 0.93 * number


@pytest.mark.parametrize("law", ["iwan", "rough", "power", "jenkins"])
@pytest.mark.parametrize(("reach", "noise"), [(0.15, 0.03), (0.4, 0.01), (0.8, 0.03), (1.5, 0.0)])
def test_no_cause_is_named_in_a_clean_record(law: str, reach: float, noise: float) -> None:
    rng = np.random.default_rng(43)
    for samples, cycles in ((30.3, 5), (100.3, 12)):
        kind = Kind(law, reach, samples, cycles, noise)
        time, x = drive(kind)
        x, force, at = sampled(kind, time, x, respond(x, law), 0.3)
        notes = ms.measure(noisy(kind, rng, x, force, at)).notes
        certain = [note for note in notes if UNDECIDED not in note]
        named = [
            note for note in certain for words in CAUSES.values() if any(map(note.count, words))
        ]
        assert not named


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("clearance", "named"),
        ("backlash of the sensor", "named"),
        ("parallel spring", "named"),
        ("delay", "named"),
        ("spikes", "named"),
        ("white noise", "named"),
        ("converter steps of force", "named"),
        ("load at twice the frequency", "undecided"),
        ("stick-slip", "undecided"),
        ("unequal directions", "undecided"),
        ("crosstalk", "undecided"),
        ("bent sensor", "undecided"),
    ],
)
def test_faults_are_named_or_left_open(name: str, verdict: str) -> None:
    assert verdict_on(name, 0)[0] == verdict


@pytest.mark.slow
def test_hardly_a_fault_is_named_wrongly() -> None:
    # Loops of Dahl's model are those of an exponential backbone: a record does not differ.
    verdicts = {name: verdict_on(name, 1)[0] for name in FAULTS if name != "Dahl"}
    assert list(verdicts.values()).count("wrong") <= 3, verdicts
    assert "silent" not in verdicts.values(), verdicts


def test_half_a_step_is_in_the_intervals_of_measure() -> None:
    """Records without noise on the steps of a converter are known to half a step."""
    made = an_imperfect_set("converter steps", 1)
    for record in made.records[1::2]:
        found = ms.measure(record).mean["friction_peak"]
        step = float(np.diff(np.unique(record.force)).min()) / record.normal_load
        assert found.low <= made.truth["friction_coefficient"] <= found.high
        # A value of which the step alone is known has a standard deviation of step/sqrt(12).
        half = 0.5 * (found.high - found.low)
        assert half == pytest.approx(1.96 * step / math.sqrt(12.0), rel=0.2)
