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
from command import run
from numpy.typing import NDArray
from sliders import slider

import microslip as ms
from microslip.identification import fold
from microslip.laboratory import condition
from microslip.laboratory.blocks import blocks_of
from microslip.laboratory.mean_cycle import all_turns
from microslip.laboratory.settling import settled

Floats = NDArray[np.float64]

STIFFNESS, LIMIT, AMPLITUDE, FREQUENCY, RATE = 1e7, 30.0, 10e-6, 7.3, 2000.0
ENERGY = 4.0 * LIMIT * (AMPLITUDE - LIMIT / STIFFNESS)


def long_run(seconds: float) -> tuple[Floats, Floats, Floats]:
    """Time, displacement and force of a run without gaps, loaded for the first time before it."""
    before = round(1.5 * RATE / FREQUENCY)
    time = np.arange(-before, round(seconds * RATE)) / RATE
    x = AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time)
    force = slider(x, STIFFNESS, LIMIT)
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
    samples = all_turns(record.time, record.displacement, blocks_of(record))[1]
    assert RATE / samples == pytest.approx(FREQUENCY, rel=2e-3 if "1.3" not in name else 4e-3)
    assert folded.amplitude == pytest.approx(AMPLITUDE, rel=5e-3)
    assert folded.cycles >= fewest_from_peaks - 1


@pytest.mark.parametrize("name", ["a pause within a way", "blocks of 3.4 cycles"])
def test_parameters_come_out_of_records_with_gaps(name: str) -> None:
    found = ms.identify(noisy(*GAPS[name][0]()))
    assert found.force_limit.value == pytest.approx(LIMIT, rel=5e-3)
    a = found.amplitudes[1]
    energy = found.dissipated_energy(a)
    assert energy.value == pytest.approx(4.0 * LIMIT * (a - LIMIT / STIFFNESS), rel=5e-3)
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


def test_nothing_is_shifted_across_a_gap() -> None:
    record = noisy(*pause(10.6))
    with pytest.raises(ms.InputError, match=r"^record: the time has a gap after 1\.45"):
        condition(record, delay=1e-4)


def test_the_command_tells_of_gaps(here: Path) -> None:
    noisy(*pause(10.6)).to_csv("paused.csv")
    outcome = run("measure", "paused.csv")
    assert outcome.exit_code == 0
    assert "frequency 7.3" in outcome.stdout
    assert "a gap of 60.0 s after 1.45 s: the record is divided there" in outcome.stdout


# -- amplitudes that step, friction that moves -----------------------------------------------------

A_CYCLE = 80


def run_of(amplitude: Floats, limit: Floats, seed: int = 3) -> ms.Record:
    """A run whose cycles have these amplitudes and force limits, from one to the next on a line."""
    phase = np.arange((amplitude.size - 1) * A_CYCLE + 1) / A_CYCLE
    place = np.arange(amplitude.size)
    x = np.interp(phase, place, amplitude) * np.sin(2.0 * np.pi * phase)
    force = slider(x, STIFFNESS, np.interp(phase, place, limit))
    rng = np.random.default_rng(seed)
    return ms.Record(
        x + 0.001 * AMPLITUDE * rng.normal(size=x.size),
        force + 0.002 * LIMIT * rng.normal(size=x.size),
        normal_load=100.0,
        sample_rate=A_CYCLE * FREQUENCY,
    )


def test_a_ramp_is_left_out_of_the_means() -> None:
    """As of a damper that is driven up, held, and driven down again."""
    amplitude = AMPLITUDE * np.concatenate(
        (np.linspace(0.5, 1.0, 30), np.ones(40), np.linspace(1.0, 0.6, 25))
    )
    measured = ms.measure(run_of(amplitude, np.full(amplitude.size, LIMIT)))
    energy = measured.mean["dissipated_energy"]
    assert energy.low <= ENERGY * 1.001
    assert energy.high >= ENERGY * 0.999
    assert energy.value == pytest.approx(ENERGY, rel=2e-3)
    assert energy.high - energy.low < 0.004 * ENERGY
    assert 30 <= energy.number <= 44
    assert [note for note in measured.notes if "as in a run-up" in note]
    # The columns stay those of all cycles.
    assert len(measured) >= 92


def test_steps_are_distinguished_block_by_block() -> None:
    levels = (0.5, 0.8, 1.2)
    amplitude = AMPLITUDE * np.repeat(levels, (20, 40, 25))
    measured = ms.measure(run_of(amplitude, np.full(amplitude.size, LIMIT)))
    (note,) = (n for n in measured.notes if n.startswith("the amplitude is not the same"))
    assert "3 amplitudes from 5.00 µm to 12.0 µm" in note
    energies = [level.mean["dissipated_energy"].value for level in measured.levels]
    assert energies == pytest.approx([240e-6, 600e-6, 1.08e-3], rel=5e-3)
    assert measured.mean["amplitude"].value == pytest.approx(0.8 * AMPLITUDE, rel=2e-3)
    assert 35 <= measured.mean["amplitude"].number <= 40


def test_an_amplitude_that_never_settles_is_called_so(here: Path) -> None:
    amplitude = AMPLITUDE * np.linspace(0.5, 1.5, 100)
    record = run_of(amplitude, np.full(amplitude.size, LIMIT))
    record.to_csv("ramp.csv")
    text = run("measure", "ramp.csv").stdout
    assert "Results by amplitude" in text
    measured = ms.measure(record)
    assert any(note.startswith("not settled: amplitude") for note in measured.notes)
    mean = measured.mean["amplitude"]
    assert mean.low < 0.55 * AMPLITUDE
    assert mean.high > 1.45 * AMPLITUDE


def test_the_end_of_running_in_is_what_counts() -> None:
    cycles = np.arange(300)
    limit = LIMIT * (1.0 - 0.4 * np.exp(-cycles / 25.0))
    measured = ms.measure(run_of(np.full(300, AMPLITUDE), limit))
    assert any(note.startswith("force or energy still moves at first") for note in measured.notes)
    friction_peak = measured.mean["friction_peak"]
    assert friction_peak.value == pytest.approx(LIMIT / 100.0, rel=0.01)
    assert friction_peak.number <= 150


def test_no_narrow_interval_stands_around_a_moving_mean() -> None:
    """A coefficient of friction from 0.33 to 0.55, which grows to the end."""
    limit = np.linspace(33.0, 55.0, 400)
    measured = ms.measure(run_of(np.full(400, AMPLITUDE), limit))
    assert any(note.startswith("not settled: force amplitude 34") for note in measured.notes)
    mean = measured.mean["friction_peak"]
    assert mean.low < 0.335
    assert mean.high > 0.545
    assert not measured.is_settled


@pytest.mark.parametrize("cycles", [20, 40, 300])
def test_nothing_is_said_of_cycles_that_are_alike(cycles: int) -> None:
    """A hundred records of noise: no stretch is sought, no trend is found."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        size = {"amplitude": 0.01, "force_amplitude": 0.02, "dissipated_energy": 0.02}
        columns = {n: 1.0 + share * rng.normal(size=cycles) for n, share in size.items()}
        found = settled(columns, np.ones(cycles, dtype=bool))
        assert found.selection.all()
        assert found.notes == ()


@pytest.mark.parametrize("growth", [0.0, 0.6, -0.3])
def test_friction_that_moves_is_reported(growth: float) -> None:
    limit = LIMIT * (1.0 + np.linspace(0.0, growth, 200))
    record = run_of(np.full(200, AMPLITUDE), limit)
    # The elastic parts of the loops do not grow along.
    assert fold(record).growth == pytest.approx(growth / (1.0 + 0.5 * growth), rel=0.15)
    found = ms.identify(record)
    said = [note for note in found.notes if "running in, wear" in note]
    assert bool(said) == (growth != 0.0)


# -- amplitudes that step --------------------------------------------------------------------------


@pytest.mark.parametrize("order", [(1.0, 0.5, 0.04), (0.04, 0.5, 1.0), (1.0, 0.04, 0.5)])
def test_each_amplitude_is_measured_by_itself(order: tuple[float, ...]) -> None:
    """Cycles far within the band that tells those of the largest amplitude count as well."""
    cycles, samples = 25, 274
    angle = 2.0 * np.pi * np.arange(cycles * samples) / samples
    x = np.concatenate([share * AMPLITUDE * np.sin(angle) for share in order])
    # The small cycles neither slip nor lose anything, up to a spring that damps.
    force = slider(x, STIFFNESS, LIMIT) + 0.02 * LIMIT * np.gradient(x) / (
        AMPLITUDE * 2.0 * np.pi / samples
    )
    measured = ms.measure(noisy(np.arange(x.size) / RATE, x, force))
    assert len(measured.levels) == 3
    for share, level in zip(order, measured.levels, strict=True):
        a = share * AMPLITUDE
        viscous = 0.02 * LIMIT * np.pi * a * share
        energy = 4.0 * LIMIT * max(a - LIMIT / STIFFNESS, 0.0) + viscous
        assert level.is_settled
        assert level.cycles.size >= cycles - 4
        assert level.mean["amplitude"].value == pytest.approx(a, rel=0.02)
        found = level.mean["dissipated_energy"]
        assert abs(found.value - energy) < max(0.02 * energy, 4.0 * found.standard_error)
    said = measured.summary()["levels"]
    assert [level["settled"] for level in said] == [True] * 3


def test_what_hums_while_the_rig_rests_is_no_cycle() -> None:
    time, x, force = long_run(4.0)
    rest = np.arange(4000) / RATE
    hum = 0.01 * AMPLITUDE * np.sin(2.0 * np.pi * 50.0 * rest)
    whole = noisy(
        np.arange(rest.size + x.size) / RATE,
        np.concatenate((hum, x)),
        np.concatenate((0.0 * hum, force)),
    )
    alone = noisy(time, x, force)
    assert abs(len(ms.measure(whole)) - len(ms.measure(alone))) <= 1
    assert ms.measure(whole).levels == ()


@pytest.mark.parametrize("cycles", [4, 6, 10, 16, 21])
@pytest.mark.parametrize("last", [0.5, 1.5])
def test_a_ramp_of_few_cycles_is_not_settled(cycles: int, last: float) -> None:
    """Its mean energy is that of no cycle; the range of the cycles is what is known."""
    amplitude = AMPLITUDE * np.linspace(1.0, last, cycles + 1)
    measured = ms.measure(run_of(amplitude, np.full(cycles + 1, LIMIT)))
    assert not measured.is_settled
    assert any(note.startswith("not settled: amplitude") for note in measured.notes)
    own = measured.cycles["dissipated_energy"][measured.cycles["closure_error"] <= 0.25]
    energy = measured.mean["dissipated_energy"]
    assert (energy.low, energy.high) == pytest.approx((own.min(), own.max()), rel=0.05)


@pytest.mark.parametrize("cycles", [5, 6, 8, 14])
@pytest.mark.parametrize("reach", [0.35, 1.0])
def test_a_ramp_of_two_per_cent_is_not_settled_to_measure_nor_to_identify(
    cycles: int, reach: float
) -> None:
    """Sliders of many limits, summed: their energies move by up to three times as much."""
    amplitude = reach * AMPLITUDE * np.linspace(0.98, 1.0, cycles + 1)
    shares = np.linspace(0.05, 1.95, 20)
    phase = np.arange(cycles * A_CYCLE + 1) / A_CYCLE
    x = np.interp(phase, np.arange(cycles + 1), amplitude) * np.sin(2.0 * np.pi * phase)
    force = np.mean([slider(x, STIFFNESS, share * LIMIT) for share in shares], axis=0)
    rng = np.random.default_rng(cycles)
    record = ms.Record(
        x + 0.001 * amplitude[-1] * rng.normal(size=x.size),
        force + 0.005 * LIMIT * rng.normal(size=x.size),
        normal_load=100.0,
        sample_rate=RATE,
    )
    measured = ms.measure(record)
    assert not measured.is_settled
    own = measured.cycles["dissipated_energy"]
    mean = measured.mean["dissipated_energy"]
    assert mean.low <= np.sort(own)[1]
    assert mean.high >= own.max() * (1.0 - 1e-12)
    if cycles > 5:  # or too few are left for a fit
        assert any("not settled: amplitude" in note for note in ms.identify(record).notes)


@pytest.mark.parametrize("jitter", [0.0, 0.003])
def test_steps_of_few_cycles_are_levels(jitter: float) -> None:
    rng = np.random.default_rng(5)
    amplitude = AMPLITUDE * np.repeat([0.6, 1.0], (8, 8)) * (1.0 + jitter * rng.normal(size=16))
    measured = ms.measure(run_of(amplitude, np.full(16, LIMIT)))
    assert len(measured.levels) == 2
    for share, level in zip((0.6, 1.0), measured.levels, strict=True):
        energy = 4.0 * LIMIT * (share * AMPLITUDE - LIMIT / STIFFNESS)
        assert level.mean["dissipated_energy"].value == pytest.approx(energy, rel=0.02)


@pytest.mark.parametrize(
    "cycles", [4, *(pytest.param(many, marks=pytest.mark.slow) for many in (8, 12))]
)
def test_few_cycles_that_jitter_are_alike(cycles: int) -> None:
    """An amplitude that a rig holds to half a per cent neither steps nor ramps."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        amplitude = AMPLITUDE * (1.0 + 0.005 * rng.normal(size=cycles + 1))
        measured = ms.measure(run_of(amplitude, np.full(cycles + 1, LIMIT), seed))
        assert measured.is_settled
        assert not measured.levels


@pytest.mark.parametrize(("samples", "noise"), [(33.3, 1e-3), (33.3, 5e-3), (300.7, 2e-2)])
@pytest.mark.parametrize("rising", [0.5, pytest.param(0.3, marks=pytest.mark.slow)])
def test_corners_in_noise_and_with_few_samples(samples: float, noise: float, rising: float) -> None:
    """The amplitude of triangles was up to 2.5 % low: a quartic rounds their corners."""
    errors = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        turn = np.arange(0.3, 14.3, 1.0 / samples) % 1.0
        x = np.where(
            turn < rising, 2.0 * turn / rising - 1.0, 1.0 - 2.0 * (turn - rising) / (1.0 - rising)
        )
        force = 50.0 * x + 8.0 * np.where(turn < rising, 1.0, -1.0)
        x = 1e-5 * (x + noise * rng.normal(size=x.size))
        mean = ms.measure(ms.Record(x, force + noise * rng.normal(size=x.size))).mean["amplitude"]
        errors.append(mean.value / 1e-5 - 1.0)
    assert abs(np.mean(errors)) < 2e-3 + 0.1 * noise
