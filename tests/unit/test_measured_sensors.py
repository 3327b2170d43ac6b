"""What sensors, rigs and files do to a measurement: gains, delays, stops, single loops, units."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from command import run
from sliders import slider

import microslip as ms

STIFFNESS, LIMIT, LOAD, AMPLITUDE, SIZE = 5e7, 100.0, 200.0, 1e-5, 200


def record_of(x: np.ndarray, noise: float = 0.3, lag: float = 0.0) -> ms.Record:
    """A record of the slider; its force is late by some samples."""
    rng = np.random.default_rng(3)
    place = np.arange(x.size)
    force = np.interp(place - lag, place, slider(x, STIFFNESS, LIMIT))
    force += noise * rng.normal(size=x.size)
    return ms.Record(x + 1e-9 * rng.normal(size=x.size), force, LOAD, sample_rate=2000.0)


def sine(cycles: int = 20) -> np.ndarray:
    """Displacement from rest."""
    return AMPLITUDE * np.sin(2.0 * np.pi * np.arange(cycles * SIZE) / SIZE)


ENERGY = 4.0 * LIMIT * (AMPLITUDE - LIMIT / STIFFNESS)
"""Of a cycle: the area of the parallelogram."""


@pytest.mark.slow
def test_gains_of_sensors_are_in_all_intervals(tmp_path: Path) -> None:
    errors = {"force": 0.02, "displacement": 0.01, "normal_load": 0.005}
    plain, known = (ms.measure(record_of(sine()), gain_errors=e) for e in (None, errors))
    # Force and load are ratios in friction, force and displacement a product in energy.
    for name, relative in (
        ("friction_energy", math.hypot(0.02, 0.005)),
        ("dissipated_energy", math.hypot(0.02, 0.01)),
        ("chord_stiffness", math.hypot(0.02, 0.01)),
        ("amplitude", 0.01),
        ("loss_factor", 0.0),
    ):
        before, after = plain.mean[name], known.mean[name]
        assert after.value == before.value
        error = relative * abs(before.value)
        assert after.standard_error == pytest.approx(math.hypot(before.standard_error, error))
        half = math.hypot(before.high - before.value, 1.959964 * error)
        assert after.high - after.value == pytest.approx(half, rel=1e-4)
    record_of(sine()).to_csv(tmp_path / "run.csv")
    words = ("measure", str(tmp_path / "run.csv"), "--calibration", "force=1±0.02", "--json")
    found = json.loads(run(*words).stdout)["records"][0]["mean"]["friction_peak"]
    assert found["high"] - found["low"] == pytest.approx(2.0 * 1.96 * 0.02 * 0.5, rel=0.02)
    for wrong in ({"load": 0.1}, {"force": 1.5}):
        with pytest.raises(ms.InputError, match="gain_errors"):
            ms.measure(record_of(sine()), gain_errors=wrong)


@pytest.mark.parametrize("where", [0, 37, 50, 90])
def test_a_stop_while_logging_ruins_nothing(where: int) -> None:
    """A fit to these once found 23 N for 100 N and said that it ended at a minimum."""
    x, at = sine(), 9 * SIZE + where
    record = record_of(np.concatenate((x[:at], np.full(2000, x[at]), x[at:])))
    measured = ms.measure(record)
    assert measured.mean["dissipated_energy"].value == pytest.approx(ENERGY, rel=2e-3)
    assert any("the record contains 1 pause" in note for note in measured.notes)
    limit = ms.identify(record).force_limit
    assert limit.value == pytest.approx(LIMIT, rel=2e-3)


@pytest.mark.parametrize("start", [0, 50, 71, 150])
@pytest.mark.parametrize("repeated", [False, True])
def test_one_averaged_loop_is_a_measurement(start: int, repeated: bool) -> None:
    x = sine(4)[SIZE + start :][: 2 * SIZE]
    force = slider(sine(4), STIFFNESS, LIMIT)[SIZE + start :]
    end = SIZE + repeated
    measured = ms.measure(ms.Record(x[:end], force[:end], LOAD))
    assert len(measured) == 1
    assert measured.mean["dissipated_energy"].value == pytest.approx(ENERGY, rel=2e-3)
    with pytest.raises(ms.InputError, match="no full cycle"):
        ms.measure(ms.Record(x[:130], force[:130], LOAD))


def test_sizes_beyond_all_rigs_and_wrong_signs_are_reported() -> None:
    record = record_of(sine())
    large = ms.measure(ms.Record(1e6 * record.displacement, record.force, LOAD))
    assert any("outside the range of any rig" in note for note in large.notes)
    assert not any("beyond" in note for note in ms.measure(record).notes)


LVM = """LabVIEW Measurement\t
Separator\tTab
Decimal_Separator\t.
X_Columns\t{columns}
***End_of_Header***\t

Channels\t2\t\t
Samples\t4\t4\t
Y_Unit_Label\tmN\tum\t
X_Dimension\tTime\tTime\t
Delta_X\t0.001000\t0.001000\t
***End_of_Header***\t\t\t
X_Value\tReibkraft\tWeg\tComment
"""


@pytest.mark.parametrize("columns", ["One", "No"])
def test_units_of_labview(tmp_path: Path, columns: str) -> None:
    path = tmp_path / "run.lvm"
    rows = ("1.5\t2.0", "2.5\t3.0", "3.5\t5.0", "1.5\t4.0")
    times = [f"{1e-3 * i:.6f}" if columns == "One" else "" for i in range(4)]
    body = "".join(f"{time}\t{row}\t\n" for time, row in zip(times, rows, strict=True))
    path.write_text(LVM.format(columns=columns) + body)
    record = ms.Record.read(path)
    assert np.allclose(record.force, [1.5e-3, 2.5e-3, 3.5e-3, 1.5e-3])
    assert np.allclose(record.displacement, [2e-6, 3e-6, 5e-6, 4e-6])
    if columns == "No":
        assert record.sample_rate == pytest.approx(1000.0)
    else:
        assert record.time is not None
        assert record.time[1] == pytest.approx(1e-3)
