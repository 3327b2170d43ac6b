"""Intervals of `measure` hold the truth of records by explicit sliders, and faults are named."""

from __future__ import annotations

import pytest
from laboratory.loops import CLEAN, FAULTS
from laboratory.measured import coverage, verdict_on

QUICK = ("jenkins, 20 samples", "iwan, partial slip", "steps of the amplitude", "chirp")


@pytest.mark.parametrize("name", QUICK)
def test_intervals_hold(name: str) -> None:
    """Of 12 intervals with 95 % each at most two miss (1 in 50 by chance)."""
    held = coverage([name], [0, 1])[name]
    assert held.number.total() - held.held.total() <= 2, held.missed


@pytest.mark.slow
def test_intervals_hold_in_ordinary_kinds() -> None:
    found = coverage(CLEAN, range(4))
    assert not [name for name, held in found.items() if held.is_short]
    number = sum(held.number.total() for held in found.values())
    assert sum(held.held.total() for held in found.values()) >= 0.93 * number


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
    verdicts = {name: verdict_on(name, 1)[0] for name in FAULTS}
    assert list(verdicts.values()).count("wrong") <= 3, verdicts
    assert "silent" not in verdicts.values(), verdicts
