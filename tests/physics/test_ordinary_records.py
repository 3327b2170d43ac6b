"""Records as laboratories have them: logged in blocks, paused, stepped, running in.

They are made here by hand, an elastic and perfectly plastic contact followed sample by sample, so
that nothing of the package is in what is measured.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import microslip as ms
from microslip.identification import fold
from microslip.tribometer import condition, delay_of

Floats = NDArray[np.float64]

STIFFNESS, LIMIT, AMPLITUDE, FREQUENCY, RATE = 1e7, 30.0, 10e-6, 7.3, 2000.0
ENERGY = 4.0 * LIMIT * (AMPLITUDE - LIMIT / STIFFNESS)


def friction(x: Floats, limit: Floats) -> Floats:
    """Force of the contact along a path, from rest."""
    force, last = np.zeros(x.size), 0.0
    for i in range(1, x.size):
        last = min(max(last + STIFFNESS * (x[i] - x[i - 1]), -limit[i]), limit[i])
        force[i] = last
    return force


def long_run(seconds: float) -> tuple[Floats, Floats, Floats]:
    """Time, displacement and force of a run without gaps, loaded for the first time before it."""
    before = round(1.5 * RATE / FREQUENCY)
    time = np.arange(-before, round(seconds * RATE)) / RATE
    x = AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time)
    force = friction(x, np.full(x.size, LIMIT))
    return time[before:], x[before:], force[before:]


def noisy(time: Floats, x: Floats, force: Floats, seed: int = 1) -> ms.Record:
    rng = np.random.default_rng(seed)
    return ms.Record(
        x + 0.003 * AMPLITUDE * rng.normal(size=x.size),
        force + 0.005 * LIMIT * rng.normal(size=x.size),
        normal_load=100.0,
        time=time,
    )


def pause(cycle: float) -> tuple[Floats, Floats, Floats]:
    """The rig stands for a minute after so many cycles, and goes on where it stood."""
    time, x, force = long_run(3.0)
    time[time > cycle / FREQUENCY] += 60.0
    return time, x, force


def blocks(cycles: float, every: float, number: int) -> tuple[Floats, Floats, Floats]:
    """The rig runs on and only blocks of it are written down."""
    time, x, force = long_run(number * every / FREQUENCY)
    logged = (time * FREQUENCY + 0.3) % every < cycles
    return time[logged], x[logged], force[logged]


GAPS: dict[str, tuple[Callable[[], tuple[Floats, Floats, Floats]], int, int]] = {
    # Made how, how many whole cycles there are at least, and from peak to peak. All blocks are cut
    # alike, so that short ones may have none.
    "a pause at an upward crossing": (lambda: pause(10.0), 19, 19),
    "a pause at a peak": (lambda: pause(10.25), 19, 19),
    "a pause within a way": (lambda: pause(10.6), 19, 19),
    "blocks of 3.4 cycles": (lambda: blocks(3.4, 10.0, 12), 30, 23),
    "blocks of 5 cycles": (lambda: blocks(5.0, 20.0, 4), 16, 16),
    "blocks of 1.3 cycles": (lambda: blocks(1.3, 7.2, 30), 10, 5),
    "blocks of 0.4 and of 8 cycles": (
        lambda: tuple(  # type: ignore[return-value]
            np.concatenate((a, b + shift))
            for a, b, shift in zip(
                blocks(0.4, 5.0, 3), blocks(8.0, 20.0, 2), (9.0, 0.0, 0.0), strict=True
            )
        ),
        14,
        12,
    ),
}


@pytest.mark.parametrize("name", GAPS)
def test_cycles_are_cut_at_gaps(name: str) -> None:
    make, fewest, fewest_from_peaks = GAPS[name]
    record = noisy(*make())
    assert record.time is not None
    gaps = np.count_nonzero(np.diff(record.time) > 1.5 / RATE)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        measured, folded = ms.measure(record), fold(record)
    expected = "the time has a gap of" if gaps == 1 else f"the time has {gaps} gaps, the longest of"
    for notes in (measured.notes, folded.notes):
        assert sum(note.startswith(expected) for note in notes) == 1
    assert len(measured) >= fewest
    # No cycle holds a gap, so all are alike: by hand.
    period = RATE / FREQUENCY
    np.testing.assert_allclose(measured.cycles["period"], period, atol=0.03 * period)
    np.testing.assert_allclose(measured.cycles["dissipated_energy"], ENERGY, rtol=0.02)
    first = measured.cycles["start"].astype(int)
    last = first + measured.cycles["period"].astype(int)
    assert np.all(record.time[last] - record.time[first] < 1.1 / FREQUENCY)
    assert measured.mean["dissipated_energy"].value == pytest.approx(ENERGY, rel=2e-3)
    assert measured.frequency == pytest.approx(FREQUENCY, rel=1e-2)
    # Cuts are known to a sample; phases say more where a block has more than one cycle.
    assert folded.frequency == pytest.approx(FREQUENCY, rel=2e-3 if "1.3" not in name else 4e-3)
    assert folded.amplitude == pytest.approx(AMPLITUDE, rel=5e-3)
    assert folded.cycles >= fewest_from_peaks - 1


@pytest.mark.parametrize("name", ["a pause within a way", "blocks of 3.4 cycles"])
def test_parameters_come_out_of_records_with_gaps(name: str) -> None:
    found = ms.identify(noisy(*GAPS[name][0]()), "jenkins", rig_stiffness="rigid")
    for parameter, truth in zip(found.parameters.values(), (STIFFNESS, LIMIT), strict=True):
        assert parameter.value == pytest.approx(truth, rel=5e-3)
        assert parameter.low < truth < parameter.high
    assert any("the time has" in note for note in found.notes)


def test_steps_that_only_vary_are_no_gaps() -> None:
    """Lost samples, random times, and samples that are dense near the turns."""
    time, x, force = long_run(2.0)
    rng = np.random.default_rng(2)
    few = np.sort(rng.choice(time.size, time.size // 3, replace=False))
    dense = np.abs(np.cos(2.0 * np.pi * FREQUENCY * time)) < 0.4
    dense[:: round(RATE / FREQUENCY / 40.0)] = True
    for chosen in (few, np.flatnonzero(dense)):
        measured = ms.measure(ms.Record(x[chosen], force[chosen], time=time[chosen]))
        assert not [note for note in measured.notes if "gap" in note]
        assert len(measured) >= 12


def test_nothing_is_filtered_across_a_gap() -> None:
    record = noisy(*pause(10.6))
    for call in (lambda: condition(record, cutoff=200.0), lambda: delay_of(record)):
        with pytest.raises(ms.InputError, match=r"^record: the time has a gap after 1\.45"):
            call()


def test_the_command_tells_of_gaps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from command import run

    monkeypatch.chdir(tmp_path)
    noisy(*pause(10.6)).to_csv("paused.csv")
    outcome = run("measure", "paused.csv")
    assert outcome.exit_code == 0
    assert "frequency 7.3" in outcome.stdout
    assert "the time has a gap of 60.0 s after 1.45 s: cycles are cut there" in outcome.stdout
