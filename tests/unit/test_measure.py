"""Measuring: what is refused, what is noticed, what is written."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import run
from scipy.stats import ttest_1samp

import microslip as ms
from microslip.laboratory import (
    condition,
)
from microslip.laboratory.blocks import blocks_of
from microslip.laboratory.measurement import GROSS, STICK
from microslip.laboratory.settling import excess_loss_notes
from microslip.laboratory.spikes import spikes_of
from microslip.report.measured import measurement_document

JOINT = ms.Interface.examples()[0]


def virtual(amplitude: float = 5e-6, load: float = 2000.0, cycles: int = 8, **how: Any) -> Any:
    frequency = how.pop("frequency", 10.0)
    rig = ms.VirtualTribometer(JOINT.at(normal_load=load), **{"sample_rate": 5120.0, **how})
    return rig.record(amplitude=amplitude, frequency=frequency, cycles=cycles)


RECORD = virtual()
MEASURED = ms.measure(RECORD)
WAVE = np.sin(2.0 * np.pi * np.arange(801) / 100)
SOFT = ms.Record(5e-6 * WAVE, 50.0 * np.tanh(5.0 * WAVE), name="soft")

# -- cycles ----------------------------------------------------------------------------------------

SHAPES = {
    "sine": np.sin,
    "cosine": np.cos,
    "triangle": lambda p: np.arcsin(np.sin(p)),
    "plateaus": lambda p: np.clip(1.5 * np.sin(p), -1, 1),
    "long plateaus": lambda p: np.clip(4.0 * np.cos(p), -1, 1),
    "lopsided": lambda p: np.sin(p) + 0.2 * np.sin(2 * p),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("samples", [40, 1000])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_number_of_cycles(shape: str, samples: int, noise: float) -> None:
    for seed in range(1 + 20 * (noise > 0)):
        for count, offset in ((2, 0.0), (15, 3.0)):
            angle = 2 * np.pi * np.arange(count * samples + 1) / samples
            x = offset + SHAPES[shape](angle)
            x += noise * np.random.default_rng(seed).normal(size=x.size)
            cycles = blocks_of(ms.Record(x, x)).having_cycles[0].cycles
            assert cycles.cuts.size - 1 == count
            np.testing.assert_allclose(np.diff(cycles.cuts), samples, atol=0.1 * samples)


def test_a_slow_begin_is_no_cycle() -> None:
    angle = 2 * np.pi * np.arange(501) / 100
    x = np.concatenate((np.zeros(300), np.sin(angle), np.zeros(300)))
    assert sum(block.cycle_count for block in blocks_of(ms.Record(x, x)).having_cycles) == 5


# -- measuring -------------------------------------------------------------------------------------


def test_turned_around() -> None:
    turned = ms.measure(ms.Record(-RECORD.displacement, -RECORD.force, 2000.0))
    for name in ("dissipated_energy", "amplitude", "chord_stiffness", "sliding_ratio"):
        assert turned.mean[name].value == pytest.approx(MEASURED.mean[name].value, rel=1e-9)
    flipped = ms.Record(RECORD.displacement, -RECORD.force, 2000.0)
    for command in (ms.measure, ms.identify):
        with pytest.raises(ms.InputError, match=r"opposite sign .*`?sign=-1`? .* are swapped"):
            command(flipped)
    for early in (
        ms.Record(RECORD.force, RECORD.displacement, 2000.0),
        # A thin loop that a delay turns.
        ms.Record(5e-6 * WAVE, 50.0 * np.roll(np.tanh(0.1 * WAVE), 5)),
    ):
        with pytest.raises(ms.InputError, match=r"behind the displacement .* swapped"):
            ms.measure(early)


def test_cycles_that_do_not_close_are_left_out_of_the_means() -> None:
    force = RECORD.force.copy()
    force[:400] += np.linspace(3000.0, 0.0, 400)
    found = ms.measure(ms.Record(RECORD.displacement, force, 2000.0))
    assert len(found) == 8
    assert found.mean["dissipated_energy"].number == 7
    assert found.notes[0].startswith("left out of the means: 1 cycle (1) whose end forces differ")
    assert found.mean["dissipated_energy"].value == pytest.approx(
        MEASURED.mean["dissipated_energy"].value, rel=1e-6
    )
    climbing = RECORD.force + 3.0 * np.arange(len(RECORD))
    drifting = ms.measure(ms.Record(RECORD.displacement, climbing))
    assert "a linear trend is removed" in drifting.notes[0]
    assert drifting.mean["dissipated_energy"].value == pytest.approx(
        MEASURED.mean["dissipated_energy"].value, rel=1e-3
    )


# -- spikes ----------------------------------------------------------------------------------------

LOADED = np.full(len(RECORD), 2000.0)
LOADED[::3] += 20.0
CHANNELS = {"displacement": RECORD.displacement, "force": RECORD.force, "normal_load": LOADED}


def spiked(channel: str, *spikes: tuple[int, float]) -> ms.Record:
    values = CHANNELS[channel].copy()
    for place, value in spikes:
        values[place] = value
    return ms.Record(**{**CHANNELS, channel: values}, sample_rate=5120.0)


@pytest.mark.parametrize(
    ("channel", "value", "shown"),
    [
        ("force", 1e9, "force 1.00 GN"),
        ("force", -2e4, "force -20.0 kN"),
        ("displacement", 1e-3, "displacement 1.00 mm"),
        ("displacement", -5e-5, "displacement -50.0 µm"),
        ("normal_load", 1e9, "normal_load 1.00 GN"),
    ],
)
@pytest.mark.parametrize("place", [1690, 1700, 1818, 2048])  # 2048 ends a cycle, begins another
def test_a_spike_is_reported_and_its_cycle_left_out(
    channel: str, value: float, shown: str, place: int
) -> None:
    record = spiked(channel, (place, value))
    assert [(one.channel, one.first, one.last) for one in spikes_of(record)] == [
        (channel, place, place)
    ]
    found, sound = ms.measure(record), ms.measure(spiked(channel))
    assert len(found) == 8
    note = next(note for note in found.notes if "spike" in note)
    assert note.startswith("left out of the means: ")
    assert f"{shown} at sample {place} (±" in note
    for name, mean in sound.mean.items():
        assert found.mean[name].number in (6, 7)
        # What is left are the same cycles, but for the windows at a turning point.
        assert found.mean[name].value == pytest.approx(mean.value, rel=1e-3, abs=1e-9), name
    assert found.third_harmonic == pytest.approx(sound.third_harmonic, abs=1e-4)


@pytest.mark.parametrize("channel", ["displacement", "force"])
def test_a_spike_within_the_range_of_its_channel_is_found(channel: str) -> None:
    peak = 1000 + int(np.argmax(CHANNELS[channel][1000:1500]))
    (found,) = spikes_of(spiked(channel, (peak, -0.9 * CHANNELS[channel][peak])))
    assert (found.channel, found.first, found.last) == (channel, peak, peak)


def test_what_is_no_spike() -> None:
    """Noise, growing amplitudes, a burst, a step, four samples; two short ones far apart are."""
    noise = np.random.default_rng(1).normal(size=(2, 200_000))
    assert spikes_of(ms.Record(*noise)) == ()
    turns = np.arange(20_000) / 8.3
    for size in (10.0 ** (turns / 800.0), np.where(turns > 2300.0, 50.0, 1.0)):
        record = ms.Record(size * np.sin(2 * np.pi * turns), size * np.cos(2 * np.pi * turns))
        assert spikes_of(record) == ()
    assert spikes_of(spiked("force", *((i, 1e5) for i in range(700, 704)))) == ()
    step = RECORD.force + np.where(np.arange(len(RECORD)) > 2000, 1e5, 0.0)
    assert spikes_of(ms.Record(RECORD.displacement, step)) == ()
    two = spikes_of(spiked("force", (700, 1e5), (701, -1e5), (2000, 1e5)))
    assert [(one.first, one.last) for one in two] == [(700, 701), (2000, 2000)]


def test_no_loop_is_larger_than_its_rectangle() -> None:
    """Return no note on a loop that nearly fills the rectangle around its reversals."""
    angle = 2.0 * np.pi * (np.arange(2000) + 0.3) / 200.0
    square = ms.measure(
        ms.Record(1e-6 * np.arcsin(np.sin(angle)), 1e3 * np.sign(np.cos(angle - 0.05)))
    )
    assert square.mean["loss_factor"].value == pytest.approx(4.0 / np.pi, rel=0.05)
    assert not any("4/π" in note for note in square.notes)
    assert excess_loss_notes(np.array([1.27, 1.3, np.nan])) == []
    (note,) = excess_loss_notes(np.array([1.2, 357.0, -1.0]))
    assert note.startswith("the loss factor exceeds 4/π = 1.27")
    assert "it is up to 357 in 1 cycle (2);" in note


# -- conditioning ----------------------------------------------------------------------------------


def test_uneven_time() -> None:
    time = np.arange(len(RECORD)) / 5120.0
    uneven = time + 2e-5 * np.random.default_rng(0).uniform(-1, 1, time.size)
    x, force = (np.interp(uneven, time, v) for v in (RECORD.displacement, RECORD.force))
    late = np.interp(uneven - 5e-4, time, RECORD.force)
    back = condition(ms.Record(x, late, 2000.0, time=uneven), delay=5e-4)
    inner = slice(10, 4000)
    np.testing.assert_allclose(back.force[inner], force[inner], rtol=0, atol=0.02 * np.ptp(force))


# -- the command -----------------------------------------------------------------------------------


@pytest.fixture(name="folder")
def _folder(here: Path) -> Path:
    RECORD.to_csv("run.csv")
    virtual(load=500.0).to_csv("light.csv")
    return here


def test_command(folder: Path) -> None:
    outcome = run("measure", "run.csv", "light.csv", "-o", "out", "--png")
    assert outcome.exit_code == 0, outcome.output
    assert re.search(r"run +8 +gross slip", outcome.stdout)
    assert re.search(r"light +8 +gross slip", outcome.stdout)
    assert outcome.stdout.endswith("6 files in out\n")
    names = sorted(path.name for path in (folder / "out").iterdir())
    pictures = [f"loops.{kind}" for kind in ("png", "svg")]
    assert names == sorted(("campaign.csv", "cycles.csv", "report.html", "summary.json", *pictures))
    page = (folder / "out/report.html").read_text("utf-8")
    assert "2 records in gross slip: a cycle dissipates" in page
    assert page.count("<img") == 1
    assert "stiffness after reversal" in page
    rows = list(csv.DictReader((folder / "out/cycles.csv").read_text("utf-8").splitlines()))
    assert len(rows) == 16
    assert rows[0]["record"] == "run"
    assert rows[8]["record"] == "light"
    assert float(rows[0]["dissipated_energy [J]"]) == MEASURED.cycles["dissipated_energy"][0]
    summary = json.loads((folder / "out/summary.json").read_text("utf-8"))
    assert sorted(summary["files"]) == names
    assert "out: exists; replace it" in run("measure", "run.csv", "-o", "out").stderr
    assert run("measure", "run.csv", "-o", "out", "--overwrite").exit_code == 0


def test_a_rig_softer_than_the_record_is_refused(folder: Path) -> None:
    SOFT.to_csv("soft.csv")
    outcome = run("measure", "soft.csv", "--rig-stiffness", "40")
    assert (outcome.exit_code, outcome.stdout) == (2, "")
    assert outcome.stderr == (
        "error: soft.csv: --rig-stiffness 40.0 N/m deflects by 1.25 m under the force amplitude "
        "of 50.0 N, more than the whole measured amplitude of 5.00 µm; a number alone is in N/m, "
        "so 40 N/um is --rig-stiffness 4e+07\n"
    )
    # Just stiff enough for a contact that moves by a hundredth of what was measured.
    assert ms.measure(SOFT, rig_stiffness=1e7 / 0.99).mean["amplitude"].value == pytest.approx(
        5e-8, rel=0.02
    )


def test_the_headline_shows_how_likely_the_regimes_are() -> None:
    """Of thin loops in noise: Student's test, by SciPy, of the means against the thresholds."""
    shares: dict[str, int] = {}
    for seed in range(12):
        rng = np.random.default_rng(seed)
        angle = 2.0 * np.pi * np.arange(8 * 120) / 120
        x = 1e-7 * np.sin(angle)
        force = 30.0 * np.sin(angle + 0.01)
        record = ms.Record(x, force + 0.6 * rng.normal(size=x.size), sample_rate=1200.0)
        measured = ms.measure(record)
        counts = measured.cycles["closure_error"] <= 0.25
        columns = {name: values[counts] for name, values in measured.cycles.items()}
        energy, size = columns["dissipated_energy"], 4.0 * columns["force_amplitude"]
        sticks, slips = (
            ttest_1samp(away[np.isfinite(away)], 0.0, alternative="greater").pvalue
            for away in (
                energy - STICK * size * columns["amplitude"],
                energy - GROSS * size * columns["sliding_distance"],
            )
        )
        expected = {"stick": sticks, "gross slip": (1.0 - sticks) * (1.0 - slips)}
        for name, share in expected.items():
            assert measured.probability[name] == pytest.approx(share, rel=1e-9, abs=1e-12)
        headline = measurement_document([measured]).answer
        for name, share in measured.probability.items():
            if share > 0.05:
                assert (f"{name} ({100.0 * share:.0f} %)" in headline) == (share < 0.95)
        shares[headline.split(": ")[0]] = 1
    assert len(shares) > 3
    several = measurement_document(
        [ms.measure(virtual(load=load)) for load in (500.0, 700.0)]
    ).answer
    assert several.startswith("2 records in gross slip: a cycle dissipates")


def test_a_cycle_that_is_left_out_does_not_change_the_headline() -> None:
    """Of nine cycles in gross slip, the first one, of a smaller amplitude, slips partially."""
    joint = JOINT.at(normal_load=2000.0)
    turn = np.arange(0.0, 9.3, 0.005)
    x = np.where(turn < 2.25, 3e-7, 1e-6) * np.sin(2.0 * np.pi * turn)
    noise = np.random.default_rng(1).normal(size=x.size)
    found = ms.measure(ms.Record(x, joint.force(x) + noise, normal_load=2000.0, sample_rate=2000.0))
    assert set(found.regimes) == {"partial slip", "gross slip"}
    assert found.regime == "gross slip"
    assert ", gross slip: each dissipates" in measurement_document([found]).answer


# -- records that look like ring-downs -------------------------------------------------------------


TIME = np.arange(2000) / 1000.0
X = 10.0 * np.cos(2.0 * np.pi * 10.0 * TIME)
FALLING = np.mod(20.0 * np.pi * TIME, 2.0 * np.pi) < np.pi
FORCE = np.where(FALLING, np.maximum(30.0 - 10.0 * (10.0 - X), -30.0),
                 np.minimum(-30.0 + 10.0 * (10.0 + X), 30.0))  # fmt: skip
ENERGY = 4.0 * 30.0 * (10e-6 - 3e-6)
NOISE = 0.02 * np.random.default_rng(1).normal(size=TIME.size)


def written(folder: Path, **columns: np.ndarray) -> str:
    heads = {"time [s]": TIME, "displacement [um]": X, **columns}
    rows = zip(*(values.tolist() for values in heads.values()), strict=True)
    lines = [",".join(heads), *(",".join(map(repr, row)) for row in rows)]
    (folder / "r.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return "r.csv"


@pytest.mark.parametrize(
    ("columns", "options"),
    [
        ({"Reibkraft [N]": FORCE}, ()),
        ({"Friction force [g]": FORCE / 9.80665e-3}, ()),
        ({"force [g]": FORCE / 9.80665e-3}, ()),
        ({"COF": FORCE / 100.0, "normal load [N]": 100.0 + 0.0 * X}, ()),
        ({"friction coefficient [%]": FORCE}, ("--normal-load", "100 N")),
        ({"µ": FORCE / 100.0}, ("--normal-load", "100 N")),
    ],
)
def test_forces_by_other_names_are_read(
    columns: dict[str, np.ndarray], options: tuple[str, ...], here: Path
) -> None:
    outcome = run("measure", written(here, **columns), *options, "--json")
    assert outcome.exit_code == 0, outcome.stderr
    (record,) = json.loads(outcome.stdout)["records"]
    assert record["mean"]["dissipated_energy"]["value"] == pytest.approx(ENERGY, rel=3e-3)
    assert record["mean"]["force_amplitude"]["value"] == pytest.approx(30.0, rel=1e-3)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"Force A [N]": FORCE, "Force B [N]": FORCE}, "2 columns could be it"),
        ({}, "must decay"),
        ({"displacement [um]": X + NOISE}, "name its column of the force, --force"),
        ({"COF": FORCE / 100.0}, "--normal-load"),
    ],
)
def test_what_is_no_loop_is_no_decay_either(
    columns: dict[str, np.ndarray], message: str, here: Path
) -> None:
    outcome = run("measure", written(here, **columns))
    assert outcome.exit_code != 0
    assert message in outcome.stderr
    assert "damping" not in outcome.stdout
