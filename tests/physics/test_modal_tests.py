"""Ring-downs, read as tests, give back the curve that made them."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

import microslip as ms

MASS = np.diag([2.0, 3.0, 2.0])
STIFF = 1e7 * np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
LARGEST = 1.2e-5  # all joints stick in part; gross slip begins at 2e-5
TIP = np.array([0.0, 0.0, 1.0])


@lru_cache
def chain() -> ms.Structure:
    """Three masses, Segalman's joint between the first and the second."""
    law = ms.SegalmanIwan(40.0, 9e6, -0.3, 1.0)
    damping = 2e-6 * STIFF
    return ms.Structure(MASS, STIFF, damping).attach(law, directions=[1.0, -1.0, 0.0])


@lru_cache
def curve() -> ms.ModalCurve:
    return chain().modes(0, np.geomspace(3e-7, 3e-5, 30), at=TIP)


def misses(test: ms.ModalTest) -> tuple[float, float]:
    """Largest errors of frequency and damping beside the curve [-]."""
    wanted, at = curve(), np.log(test.amplitude)
    grid = np.log(wanted.amplitude)
    frequency = np.interp(at, grid, wanted.frequency)
    damping = np.exp(np.interp(at, grid, np.log(wanted.damping_ratio)))
    return (
        float(abs(test.frequency / frequency - 1.0).max()),
        float(abs(test.damping_ratio / damping - 1.0).max()),
    )


def decaying(rate: float, other: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A signal whose frequency and damping follow the curve, and a higher mode on it."""
    grid = np.log(curve().amplitude)
    time = np.arange(0.0, 1.2, 1.0 / rate)
    level, phase, signal = np.log(LARGEST), 0.0, np.empty(time.size)
    for i in range(time.size):
        signal[i] = np.exp(level) * np.cos(phase)
        omega = 2.0 * np.pi * np.interp(level, grid, curve().frequency)
        zeta = np.exp(np.interp(level, grid, np.log(curve().damping_ratio)))
        level, phase = level - zeta * omega / rate, phase + omega / rate
    ring = other * LARGEST * np.exp(-20.0 * time) * np.cos(2.0 * np.pi * 1900.0 * time)
    return time, signal + ring


def test_a_ring_down_with_other_modes_needs_its_band() -> None:
    time, signal = decaying(8192.0, other=0.8)
    with pytest.raises(ms.InputError, match=r"of one mode, got .* give band=\("):
        ms.ModalTest.from_ring_down(time, signal)
    found = ms.ModalTest.from_ring_down(time, signal, points=8, band=(100.0, 300.0))
    frequency, damping = misses(found)
    assert frequency < 1e-3
    assert damping < 0.06  # means over steps of the amplitude in which the curve bends


def test_an_accelerometer_is_read_as_displacement() -> None:
    time, signal = decaying(8192.0)
    omega = 2.0 * np.pi * curve().frequency[-3]
    noise = 5e-2 * omega**2 * LARGEST * np.random.default_rng(2).standard_normal(time.size)
    direct = ms.ModalTest.from_ring_down(time, signal, points=6)
    sensed = ms.ModalTest.from_ring_down(
        time, np.gradient(np.gradient(signal, time), time) + noise, points=6,
        quantity="acceleration", band=(100.0, 300.0),
    )  # fmt: skip
    frequency, _ = misses(sensed)
    # Each is a mean over a step of the amplitude in which the frequency falls by 2 %.
    assert frequency < 3e-3  # measured 1e-3
    assert sensed.amplitude.min() > 2.0 * direct.amplitude.min()  # where the noise begins
    assert sensed.amplitude.max() == pytest.approx(direct.amplitude.max(), rel=0.15)


def test_noise_lifts_no_damping_of_a_ring_down() -> None:
    """A decay into noise with the damping 4e-4 + 60 a; four seeds: 7e-5, and 1.2 to 3.0 %."""
    rate, omega = 4096.0, 2.0 * np.pi * 174.15
    time = np.arange(0.0, 12.0, 1.0 / rate)
    # da/dt = -omega (4e-4 + 60 a) a has a closed solution.
    fallen = 3e-6 * np.exp(-4e-4 * omega * time)
    amplitude = fallen / (1.0 + 60.0 / 4e-4 * (3e-6 - fallen))
    noise = 2e-9 * np.random.default_rng(3).standard_normal(time.size)
    test = ms.ModalTest.from_ring_down(time, amplitude * np.cos(omega * time) + noise)
    np.testing.assert_allclose(test.frequency, 174.15, rtol=2e-4)
    np.testing.assert_allclose(test.damping_ratio, 4e-4 + 60.0 * test.amplitude, rtol=0.04)
    assert test.amplitude.min() < 1e-7


def test_files_tell_what_they_hold(tmp_path: Path) -> None:
    time, signal = decaying(4096.0)
    ring = tmp_path / "hammer.csv"
    rows = np.column_stack([1e3 * time, 1e6 * signal])
    np.savetxt(ring, rows, delimiter=",", header="time [ms],displacement [um]", comments="")
    read = ms.ModalTest.read(ring, points=5, mode=2)
    direct = ms.ModalTest.from_ring_down(time, signal, points=5)
    np.testing.assert_allclose(read.amplitude, direct.amplitude, rtol=1e-9)
    assert (read.mode, read.name) == (2, "hammer.csv")
    assert "ring-down" in read.notes[0]
    table = tmp_path / "curve.csv"
    table.write_text("amplitude [um],frequency [Hz],damping [%]\n1,100,0.1\n10,99,0.5\n")
    read = ms.ModalTest.read(table)
    np.testing.assert_allclose(read.amplitude, [1e-6, 1e-5])
    np.testing.assert_allclose(read.damping_ratio, [1e-3, 5e-3])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x [um],y [um]\n1,2\n2,3\n", "wanted columns of amplitude, frequency and damping"),
        ("time,velocity [m/s]\n0,1\n1,2\n", "time.*no unit; write it in the header"),
        ("time [s],velocity [m/s]\n0,1\n1,2\n", "at least six cycles"),
        ("time [s],velocity [m/s]\n0,1\n1,\n2,3\n", 'line 3, column "velocity'),
        ("amplitude [um],frequency [Hz],damping\n1,100,0\n", "damping_ratio must be above zero"),
    ],
)
def test_files_that_are_no_test(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "test.csv"
    path.write_text(text)
    with pytest.raises(ms.InputError, match=message):
        ms.ModalTest.read(path)
