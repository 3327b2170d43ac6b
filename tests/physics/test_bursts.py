"""Rigs that log ten cycles at cycle 1, 100, ..., 100 000: energies and numbers of all cycles.

Closed loops of an elastic and perfectly plastic contact whose limit follows the cycles by a law
that is summed here over every cycle; nothing of the package makes them.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from command import run
from numpy.typing import NDArray

import microslip as ms
from microslip.laboratory.blocks import dissipated
from microslip.laboratory.campaign import Campaign

Floats = NDArray[np.float64]

STIFFNESS, AMPLITUDE, A_CYCLE, FREQUENCY = 1e7, 10e-6, 100, 10.0
STARTS = (1, 100, 1000, 10_000, 100_000)
TEN = 10


def limit(number: Floats) -> Floats:
    """Force limit [N] of a cycle: it grows with the logarithm of their number."""
    return 30.0 * (1.0 + 0.02 * np.log10(number))


def energy(number: Floats) -> Floats:
    """Of a cycle [J]: the parallelogram."""
    force = limit(number)
    return 4.0 * force * (AMPLITUDE - force / STIFFNESS)


def burst(first: int, seed: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Time, displacement, force and counter of ten whole cycles, and a little at both ends."""
    rng = np.random.default_rng(seed)
    turn = np.arange(-20, TEN * A_CYCLE + 20) / A_CYCLE
    x = AMPLITUDE * np.cos(2.0 * np.pi * turn)
    force = np.empty(x.size)
    last = float(limit(np.array(float(first))))
    counter = first + np.floor(turn)
    own = limit(np.maximum(counter, 1.0))
    for i, step in enumerate(np.diff(x, prepend=x[0])):
        last = min(max(last + STIFFNESS * step, -own[i]), own[i])
        force[i] = last
    x = x + 0.001 * AMPLITUDE * rng.normal(size=x.size)
    force = force + 0.03 * rng.normal(size=x.size)
    return (first - 1 + turn) / FREQUENCY + 1.0, x, force, np.maximum(counter, 0.0)


def logged(counter: bool, seed: int = 0, **options: float) -> ms.Record:
    parts = [burst(first, seed + first) for first in STARTS]
    time, x, force, number = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    return ms.Record(
        x, force, normal_load=100.0, time=time, cycle_number=number if counter else None, **options
    )


def total() -> float:
    return float(energy(np.arange(1.0, STARTS[-1] + TEN)).sum())


@pytest.mark.parametrize("how", ["counter", "phase", "frequency"])
def test_energy_of_all_cycles(how: str) -> None:
    options = {"frequency": FREQUENCY} if how == "frequency" else {}
    measured = ms.measure(logged(how == "counter", **options))
    assert measured.count is not None
    numbers = measured.count.numbers
    assert numbers is not None
    for first in STARTS:
        assert np.count_nonzero((numbers >= first) & (numbers < first + TEN)) >= TEN - 2
    up_to = measured.dissipated()
    assert up_to is not None
    assert up_to.energy[-1] == pytest.approx(total(), rel=5e-3)
    assert abs(up_to.energy[-1] - total()) < up_to.error < 0.01 * total()
    assert any("of the cycles" in note and "were logged" in note for note in measured.notes)


@pytest.mark.parametrize("constant", [30.0, 3e3, 1e5])
def test_any_steady_course_between_bursts_is_within_the_error(constant: float) -> None:
    """Running in by an exponential is neither straight over cycles nor over their logarithm."""
    every = 1.0 - 0.4 * np.exp(-np.arange(STARTS[-1] + TEN) / constant)
    numbers = np.concatenate([np.arange(first, first + TEN, dtype=float) for first in STARTS])
    up_to = dissipated(numbers, every[numbers.astype(int) - 1])
    exact = np.cumsum(every)[numbers.astype(int) - 1]
    assert np.all(np.abs(up_to.energy - exact) <= up_to.errors * (1.0 + 1e-9) + 1e-9)
    assert up_to.errors[-1] < 0.4 * exact[-1]


def test_wear_coefficient_and_its_energies() -> None:
    worn = 1e-12
    measured = ms.measure(logged(True))
    wear = Campaign((measured,), worn_volumes=(worn,)).wear()
    assert wear is not None
    assert wear.coefficient.value == pytest.approx(worn / total(), rel=5e-3)
    # One volume has no scatter; what was not logged bounds it all the same.
    assert wear.coefficient.low < worn / total() < wear.coefficient.high
    # What a cycle adds to the force is that of all cycles, not of those that were logged.
    rate = (limit(np.array(STARTS[-1])) - limit(np.array(STARTS[-2]))) / (STARTS[-1] - STARTS[-2])
    assert 0.0 < measured.drift("force_amplitude").value < 5.0 * rate
    # Paused, not logged on: the phase does not go on, so nothing cumulative is known.
    record = logged(False)
    time = np.array(record.time)
    for at in np.flatnonzero(np.diff(time) > 1.0):
        time[at + 1 :] += 0.37 / FREQUENCY
    paused = ms.measure(ms.Record(record.displacement, record.force, normal_load=100.0, time=time))
    assert paused.dissipated() is None
    assert math.isnan(paused.drift("force_amplitude").value)
    campaign = Campaign((paused,), worn_volumes=(worn,))
    assert campaign.wear() is None
    assert "phase" in campaign.uncounted()["record"]
    assert any("`cycle_number=...`" in note for note in paused.notes)


def test_one_pause_alone_tells_nothing() -> None:
    """A phase that agrees once may do so by chance."""
    parts = [burst(first, first) for first in (1, 100)]
    time, x, force, _ = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    measured = ms.measure(ms.Record(x, force, time=time))
    assert measured.dissipated() is None
    told = ms.measure(ms.Record(x, force, time=time, frequency=FREQUENCY))
    assert told.dissipated() is not None


def test_stages_of_a_run_in_files_of_their_own() -> None:
    measurements = []
    for first in STARTS:
        time, x, force, number = burst(first, first)
        measurements.append(
            ms.measure(ms.Record(x, force, time=time, cycle_number=number, name=f"stage {first}"))
        )
    last = [None] * (len(STARTS) - 1) + [1e-12]
    campaign = Campaign(tuple(measurements), ["a"] * len(STARTS), last)
    wear = campaign.wear()
    assert wear is not None
    assert float(wear.energy[-1]) == pytest.approx(total(), rel=5e-3)
    # Alone it does not know what was before.
    alone = Campaign((measurements[-1],), None, (1e-12,))
    assert alone.wear() is None
    assert "begins at cycle" in alone.uncounted()[f"stage {STARTS[-1]}"]


def test_specimens_do_not_run_on() -> None:
    """Without labels each record is one of its own; with those of a run they follow each other."""
    time, x, force, _ = burst(1, 1)
    one = ms.measure(ms.Record(x, force, time=time))
    apart = Campaign((one, one)).cumulative()
    np.testing.assert_array_equal(apart[0], apart[1])
    along = Campaign((one, one), ("a", "a")).cumulative()
    assert along[1][-1] == pytest.approx(2.0 * along[0][-1])


def test_the_command_reads_the_counter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    record = logged(True)
    assert record.time is not None
    assert record.cycle_number is not None
    columns = (record.time, record.cycle_number, 1e6 * record.displacement, record.force)
    lines = (";".join(map(repr, row)) for row in zip(*(c.tolist() for c in columns), strict=True))
    head = "Zeit [s];Zyklus;Weg [µm];Reibkraft [N]\n"
    Path("burst.csv").write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    Path("manifest.csv").write_text("file,worn volume\nburst.csv,0.001 mm^3\n")
    outcome = run("measure", "--manifest", "manifest.csv", "-o", "out")
    assert outcome.exit_code == 0, outcome.stderr
    assert "of the cycles 1 to 100009 were logged" in " ".join(outcome.stdout.split())
    value = float(outcome.stdout.split("Energy wear coefficient: ")[1].split()[0])
    assert value == pytest.approx(1e18 * 1e-12 / total(), rel=6e-3)
    assert math.isfinite(value)
    (told,) = json.loads(Path("out/summary.json").read_text("utf-8"))["records"]
    energy_of_all = told["cumulative_energy"]
    assert abs(energy_of_all["value"] - total()) < energy_of_all["error"] < 0.01 * total()
    assert "Cycles 1 to 100009 dissipate " in outcome.stdout
