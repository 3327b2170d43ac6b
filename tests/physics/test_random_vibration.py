"""Random vibration against closed forms and long integrations with the joints' own states."""

from __future__ import annotations

import math

import numpy as np
import pytest
from usual import JOINT, SLIP, SURFACE

import microslip as ms

MASS = np.array([2.0, 3.0, 2.0])
STIFFNESS = 2e9 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
TIP = np.array([0.0, 0.0, 1.0])
BAND = (2000.0, 6000.0)


def bar() -> ms.Structure:
    """Three masses between two walls, with a joint between two and one to the base."""
    directions = np.array([[1.0, -1.0, 0.0], [0.0, 0.0, 1.0]]).T
    held = ms.Structure(np.diag(MASS), STIFFNESS, 2e-7 * STIFFNESS)
    return held.attach(JOINT, directions=directions)


def noise(
    seed: int, level: float, rate: float, count: int, band: tuple[float, float] = BAND
) -> np.ndarray:
    """A Gaussian acceleration of that level in the band."""
    f = np.fft.rfftfreq(count, 1.0 / rate)
    size = np.where((f >= band[0]) & (f <= band[1]), math.sqrt(0.25 * level * rate * count), 0.0)
    parts = np.random.default_rng(seed).normal(size=(2, f.size))
    return np.fft.irfft(size * (parts[0] + 1j * parts[1]), count)


def test_a_linear_mode_in_white_noise_is_the_closed_form() -> None:
    """Variance pi S f / (4 zeta omega^4) of the displacement, and absolute accelerations."""
    omega, zeta, level = 2.0 * math.pi * 100.0, 0.003, 0.5
    mass = ms.Structure([[2.0]], [[2.0 * omega**2]], [[4.0 * zeta * omega]])
    psd = ([0.01, 1e4], [level, level])
    seen = mass.random_response(psd, directions=[1.0], damping_frame="base")
    variance = level / (8.0 * zeta * omega**3)
    assert seen.standard_deviation([1.0]) == pytest.approx(math.sqrt(variance), rel=1e-3)
    # Displacement times omega^2 as a dashpot that is small leaves it (Crandall and Mark).
    acceleration = omega**2 * math.sqrt(variance * (1.0 + 4.0 * zeta**2))
    felt = seen.standard_deviation([1.0], "acceleration")
    assert felt == pytest.approx(acceleration, rel=1e-3)
    assert seen.frequency[0] == pytest.approx(100.0, rel=1e-6)
    assert seen.damping_ratio[0] == pytest.approx(zeta, rel=1e-6)
    crossings = 2.0 * 100.0 * 60.0
    factor = math.sqrt(2.0 * math.log(crossings))
    assert seen.peak([1.0], 60.0) == pytest.approx(
        (factor + 0.5772 / factor) * math.sqrt(variance), rel=1e-2
    )


def test_joints_and_modal_curves_tell_the_same_where_one_mode_moves_them() -> None:
    options = {"directions": np.ones(3), "joints_on_base": True}
    psd = (BAND, (0.1, 0.1))
    joints = bar().random_response(psd, **options)
    modes = bar().random_response(psd, **options, method="modes", modes=1)
    assert joints.verdicts[0].word == "ok"
    assert modes.frequency[0] == pytest.approx(joints.frequency[0], rel=2e-3)
    assert modes.damping_ratio[0] == pytest.approx(joints.damping_ratio[0], rel=0.08)
    deviation = joints.standard_deviation(TIP)
    assert modes.standard_deviation(TIP) == pytest.approx(deviation, rel=0.08)
    assert modes.joint_power.sum() == pytest.approx(joints.joint_power.sum(), rel=0.05)
    weak = bar().random_response((BAND, (1e-6, 1e-6)), **options)
    assert weak.verdicts[1].word == "ok"
    strong = bar().random_response((BAND, (10.0, 10.0)), **options)
    assert strong.verdicts[1].word == "outside"


@pytest.mark.slow
def test_noise_moves_and_heats_joints_as_in_integration() -> None:
    """Standard deviations within 8 %, power within 10 %; 1200 periods, slip by 1.2 scales."""
    level, rate, count = 1.0, 60000.0, 18000
    structure = bar()
    seen = structure.random_response(
        (BAND, (level, level)), directions=np.ones(3), joints_on_base=True
    )
    time = np.arange(count) / rate
    motion = structure.integrate(-np.outer(noise(1, level, rate, count), MASS), time)
    late = slice(count // 15, None)
    deviation = motion.joint_motion[late].std(axis=0)
    assert deviation[1] > SLIP
    np.testing.assert_allclose(seen.joint_deviation, deviation, rtol=0.08)
    assert seen.standard_deviation(TIP) == pytest.approx(
        motion.displacement[late, 2].std(), rel=0.08
    )
    power = np.diff(motion.joint_loss[[count // 15, -1]], axis=0)[0] / (time[-1] * 14.0 / 15.0)
    np.testing.assert_allclose(seen.joint_power, power, rtol=0.1)
    kurtosis = np.mean(motion.joint_motion[late] ** 4, axis=0) / deviation**4
    assert kurtosis[1] > 3.3  # which the verdict has said
    assert seen.verdicts[1].word == "watch"


@pytest.mark.slow
def test_fields_are_moved_as_in_integration() -> None:
    """A mass on two rough nodes, pushed along them."""
    field = ms.JointField(SURFACE, 0.4, areas=[1e-4, 1e-4], loads=[500.0, 700.0])
    structure = ms.Structure(np.eye(3), np.diag([4e8, 4e8, 4e8]), 60.0 * np.eye(3))
    directions = np.zeros((3, 2, 3))
    directions[:, 0], directions[:, 1] = np.eye(3), np.eye(3)
    structure = structure.attach(field, directions=directions)
    along = np.array([1.0, 0.0, 0.0])
    first = structure.linear_modes(3).frequency[0]
    band, level = (0.4 * first, 1.6 * first), 0.02
    seen = structure.random_response(
        (band, (level, level)), directions=along, joints_on_base=True, modes=1,
        damping_frame="base",
    )  # fmt: skip
    rate, count = 16.0 * first, 16000
    time = np.arange(count) / rate
    push = noise(3, level, rate, count, band)
    motion = structure.integrate(-np.outer(push, along), time)
    late = slice(count // 15, None)
    assert seen.standard_deviation(along) == pytest.approx(
        motion.displacement[late, 0].std(), rel=0.08
    )
    power = np.diff(motion.joint_loss[[count // 15, -1]], axis=0)[0] / (time[-1] * 14.0 / 15.0)
    np.testing.assert_allclose(seen.joint_power, power, rtol=0.15)


def test_incomplete_spectra_are_refused() -> None:
    options = {"directions": np.ones(3), "joints_on_base": True}
    for words, psd in (
        ("psd must be frequencies and levels", [1.0]),
        ("increasing frequencies", ([200.0, 100.0], [1.0, 1.0])),
        ("not all zero", ([100.0, 200.0], [0.0, 0.0])),
    ):
        with pytest.raises(ms.InputError, match=words):
            bar().random_response(psd, **options)
    flat = ([0.0, 100.0], [1.0, 1.0])
    with pytest.raises(ms.InputError, match="one motion of the base, got 3"):
        bar().random_response(flat, directions=np.eye(3), joints_on_base=True)
    free = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    hung = ms.Structure(np.eye(3), free)
    with pytest.raises(ms.InputError, match="begin above 0 Hz"):
        hung.random_response(flat, directions=[1.0, -1.0], supports=[0, 2])
