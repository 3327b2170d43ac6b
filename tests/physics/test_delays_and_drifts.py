"""What ruins partial slip: a force that is late or filtered, and drifts; told by both commands.

The closed loops are those of one sphere by hand (Mindlin), sampled and shifted; nothing of the
package makes them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from sliders import sphere_loop

import microslip as ms
from microslip.laboratory.blocks import blocks_of
from microslip.laboratory.conditioning import lag_of

Floats = NDArray[np.float64]
LIMIT, SLIP, RATE = 50.0, 2e-6, 5000.0


def loop(phase: Floats, amplitude: float) -> Floats:
    """Force at phases of a cosine, from peak to peak."""
    turn = np.mod(phase, 2.0 * math.pi)
    return sphere_loop(amplitude * np.cos(turn), turn < math.pi, amplitude, LIMIT, SLIP)


def energy(amplitude: float) -> float:
    turn = np.linspace(0.0, 2.0 * math.pi, 400_001)
    x, force = amplitude * np.cos(turn), loop(turn, amplitude)
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))


def record(
    seed: int,
    amplitude: float = 1e-6,
    period: float = 200.3,
    late: float = 0.0,
    filtered: float = 0.0,
    cycles: float = 16.3,
    noise: float = 0.003,
    **drifts: float,
) -> ms.Record:
    """``late`` and the time constant ``filtered`` are in samples."""
    rng = np.random.default_rng([seed, round(period)])
    place = np.arange(round(period * cycles))
    phase = 2.0 * math.pi * place / period + rng.uniform(0.0, 2.0 * math.pi)
    fine = 2.0 * math.pi * np.arange(1 << 14) / (1 << 14)
    waves = np.fft.rfft(loop(fine, amplitude))
    order = np.arange(waves.size)
    # The settled response of a delay and of a first-order low-pass, harmonic by harmonic.
    angle = 2.0 * math.pi * order / period
    waves = waves * np.exp(-1j * angle * late) / (1.0 + 1j * angle * filtered)
    shape = np.fft.irfft(waves)
    turn = np.mod(phase, 2.0 * math.pi) * (1 << 14) / (2.0 * math.pi)
    force = np.interp(turn, np.arange((1 << 14) + 1), np.append(shape, shape[0]))
    along = place / place.size - 0.5
    size = float(np.ptp(shape)) / 2.0
    x = amplitude * (np.cos(phase) + 0.3 * noise * rng.normal(size=place.size))
    force = force + noise * size * rng.normal(size=place.size)
    return ms.Record(
        x + drifts.get("displacement", 0.0) * along,
        force + drifts.get("force", 0.0) * along,
        normal_load=100.0,
        sample_rate=RATE,
    )


def test_delays_are_held_by_their_intervals() -> None:
    """In partial slip and beyond, with 80 records; and they are no half a sample off."""
    held, off = 0, []
    for seed in range(80):
        late = 3.3 * (seed % 2)
        amplitude = SLIP * (0.2, 0.5, 1.0, 2.0)[seed % 4]
        period = (100.3, 400.7)[seed // 4 % 2]
        of = record(seed, amplitude, period, late)
        (block,) = blocks_of(of).having_cycles
        found = lag_of(of.displacement, of.force, block.cycles, 0.95)
        assert found is not None
        held += abs(found.value - late) <= found.half
        off.append(found.value - late)
    assert held >= 74
    assert abs(np.mean(off)) < 0.1


@pytest.mark.parametrize("wrong", [{"late": 1.2}, {"filtered": 1.2}, {"late": -1.2}])
def test_a_late_force_is_reported_with_its_remedy(wrong: dict[str, float]) -> None:
    """Two degrees: half of the energy of partial slip, more or less."""
    amplitude = 0.3 * SLIP
    bad = record(1, amplitude, **wrong)
    measured = ms.measure(bad)
    true = energy(amplitude)
    assert abs(measured.mean["dissipated_energy"].value - true) > 0.2 * abs(true)
    (note,) = [text for text in measured.notes if "by a delay or a filter" in text]
    assert "`delay=" in note
    back = ms.measure(bad, delay=float(note.split("delay=")[1].split("`")[0]))
    assert back.mean["dissipated_energy"].value == pytest.approx(true, rel=0.12)
    assert not [text for text in back.notes if "by a delay or a filter" in text]


@pytest.mark.parametrize(
    "amplitude", [0.3, *(pytest.param(a, marks=pytest.mark.slow) for a in (0.7, 1.0)), 3.0]
)
def test_nothing_is_said_of_sound_records(amplitude: float) -> None:
    for seed in range(8):
        notes = ms.measure(record(seed, amplitude * SLIP)).notes
        assert not [note for note in notes if "delay" in note or "drifts" in note]


@pytest.mark.parametrize(("channel", "size"), [("force", 0.3 * LIMIT), ("displacement", 2e-7)])
def test_a_drift_is_reported_and_leaves_the_energy(channel: str, size: float) -> None:
    bad = record(2, SLIP, **{channel: size})
    measured = ms.measure(bad)
    (note,) = [text for text in measured.notes if "drifts" in text]
    assert note.startswith(f"the {channel} drifts by")
    assert "a linear trend is removed" in note
    assert measured.mean["dissipated_energy"].value == pytest.approx(energy(SLIP), rel=0.005)
