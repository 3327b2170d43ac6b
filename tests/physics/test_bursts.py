"""Rigs that log ten cycles at cycle 1, 100, ..., 100 000: energies and numbers of the cycles.

Closed loops of an elastic and perfectly plastic contact whose limit follows the cycles by a law
that is summed here over every cycle; nothing of the package makes them.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import run
from numpy.typing import NDArray
from sliders import slider

import microslip as ms
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
    counter = first + np.floor(turn)
    begin = float(limit(np.array(float(first))))
    force = slider(x, STIFFNESS, limit(np.maximum(counter, 1.0)), begin)
    x = x + 0.001 * AMPLITUDE * rng.normal(size=x.size)
    force = force + 0.03 * rng.normal(size=x.size)
    return (first - 1 + turn) / FREQUENCY + 1.0, x, force, np.maximum(counter, 0.0)


def logged(counter: bool, seed: int = 0) -> ms.Record:
    parts = [burst(first, seed + first) for first in STARTS]
    time, x, force, number = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    return ms.Record(
        x, force, normal_load=100.0, time=time, cycle_number=number if counter else None
    )


def total() -> float:
    return float(energy(np.arange(1.0, STARTS[-1] + TEN)).sum())


def test_energies_and_counter_of_each_logged_cycle() -> None:
    """No cycle extends across a gap, and the counter of the rig numbers each cycle."""
    measured = ms.measure(logged(True))
    numbers = measured.cycles["cycle_number"]
    for first in STARTS:
        assert np.count_nonzero((numbers >= first) & (numbers < first + TEN)) >= TEN - 2
    np.testing.assert_allclose(measured.cycles["dissipated_energy"], energy(numbers), rtol=5e-3)
    assert measured.frequency == pytest.approx(FREQUENCY, rel=1e-3)
    assert any("the time has 4 gaps" in note for note in measured.notes)


def test_the_counter_cuts_a_record_without_a_time() -> None:
    made = logged(True)
    record = ms.Record(made.displacement, made.force, cycle_number=made.cycle_number)
    measured = ms.measure(record)
    assert any("the counter of cycles jumps 4 times" in note for note in measured.notes)
    numbers = measured.cycles["cycle_number"]
    np.testing.assert_allclose(measured.cycles["dissipated_energy"], energy(numbers), rtol=5e-3)


def test_the_command_reads_the_counter(here: Path) -> None:
    """The sum over all cycles is a line of NumPy from the columns of cycles.csv."""
    record = logged(True)
    assert record.time is not None
    assert record.cycle_number is not None
    columns = (record.time, record.cycle_number, 1e6 * record.displacement, record.force)
    lines = (";".join(map(repr, row)) for row in zip(*(c.tolist() for c in columns), strict=True))
    head = "Zeit [s];Zyklus;Weg [µm];Reibkraft [N]\n"
    Path("burst.csv").write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    outcome = run("measure", "burst.csv", "-o", "out")
    assert outcome.exit_code == 0, outcome.stderr
    rows = list(csv.DictReader(Path("out/cycles.csv").read_text("utf-8").splitlines()))
    number, lost = (
        np.array([float(row[key]) for row in rows])
        for key in ("cycle_number [-]", "dissipated_energy [J]")
    )
    total = float(energy(np.arange(1.0, STARTS[-1] + TEN)).sum())
    assert np.trapezoid(lost, number) == pytest.approx(total, rel=5e-3)


def test_wear_coefficient_of_all_cycles() -> None:
    """Cycles that were not logged count, with the error of a monotonic course of their energy."""
    worn = 1e-12
    wear = Campaign((ms.measure(logged(True)),), {"worn_volume": (worn,)}).wear()
    assert wear is not None
    assert wear.coefficient is not None
    assert wear.coefficient.value == pytest.approx(worn / total(), rel=5e-3)
    assert wear.coefficient.low < worn / total() < wear.coefficient.high
    unknown = Campaign((ms.measure(logged(False)),), {"worn_volume": (worn,)}).wear()
    assert unknown is not None
    assert unknown.coefficient is None
    assert "were not logged" in unknown.unknown["record"]


def test_wear_of_a_specimen_in_several_files() -> None:
    measured = []
    for first in STARTS:
        time, x, force, _ = burst(first, first)
        measured.append(ms.measure(ms.Record(x, force, time=time, name=f"stage {first}")))
    last = [None] * (len(STARTS) - 1) + [1e-12]
    runs = ["a"] * len(STARTS)
    columns: dict[str, Any] = {"run": runs, "worn_volume": last, "first_cycle": STARTS}
    wear = Campaign(tuple(measured), columns).wear()
    assert wear is not None
    assert float(wear.energy[-1]) == pytest.approx(total(), rel=5e-3)
