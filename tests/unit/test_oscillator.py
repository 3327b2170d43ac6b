"""Oscillators: shapes, what is frozen, what ends early, and each error."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.structures import ring_down as module

CELL = ms.Jenkins(stiffness=5e7, force_limit=100.0)
MODE = ms.Oscillator(mass=2.0, stiffness=3e7, joint=CELL)
DAMPED = ms.Oscillator(mass=2.0, stiffness=3e7, joint=CELL, viscous_damping_ratio=0.01)
METHODS = ("frequency", "angular_frequency", "damping_ratio", "interface_damping_ratio")


def refusal(call: Any, *args: Any, **kwargs: Any) -> str:
    with pytest.raises(ms.InputError) as caught:
        call(*args, **kwargs)
    return str(caught.value)


# -- right use -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", METHODS)
def test_a_number_gives_a_float_and_an_array_its_shape(name: str) -> None:
    method = getattr(DAMPED, name)
    a = np.array([[0.0, 1e-6], [5e-6, 1e-3]])
    many = method(a)
    assert many.shape == (2, 2)
    for place in np.ndindex(2, 2):
        one = method(float(a[place]))
        assert type(one) is float
        assert one == pytest.approx(many[place], rel=1e-14, abs=0)
    assert method(a.tolist()).tolist() == many.tolist()


def test_harmonic_balance_in_blocks() -> None:
    a = np.geomspace(1e-7, 1e-3, 4001)
    whole = DAMPED.frequency(a, method="harmonic-balance", harmonics=[1])
    some = DAMPED.frequency(a[[0, 1999, 2000, 4000]], method="harmonic-balance", harmonics=[1])
    np.testing.assert_array_equal(whole[[0, 1999, 2000, 4000]], some)


def test_frequency_is_in_hertz() -> None:
    a = [1e-7, 1e-5]
    np.testing.assert_allclose(MODE.frequency(a), MODE.angular_frequency(a) / (2.0 * np.pi))


def test_the_dashpot() -> None:
    assert MODE.viscous_coefficient == 0.0
    assert DAMPED.viscous_coefficient == pytest.approx(2.0 * 0.01 * np.sqrt(2.0 * 8e7), rel=1e-15)
    # A rigid joint sets no frequency: the sliding one counts.
    dry = ms.Oscillator(2.0, 3e7, ms.Coulomb(100.0), 0.01)
    assert dry.viscous_coefficient == pytest.approx(0.02 * np.sqrt(2.0 * 3e7), rel=1e-15)


def test_dry_friction_at_rest() -> None:
    dry = ms.Oscillator(2.0, 3e7, ms.Coulomb(100.0))
    assert dry.angular_frequency(0.0) == np.inf
    assert dry.damping_ratio(0.0) == 0.0
    assert dry.damping_ratio(0.0, method="harmonic-balance") == 0.0


def test_cycles_or_duration() -> None:
    by_cycles = MODE.ring_down(5e-6, cycles=4)
    assert by_cycles.turning_time.size == 9
    assert by_cycles.amplitude.size == by_cycles.frequency.size == by_cycles.damping_ratio.size == 4
    assert by_cycles.time[-1] >= by_cycles.turning_time[-1] > by_cycles.time[-2]
    step = np.diff(by_cycles.time)
    np.testing.assert_allclose(step, 1.0 / MODE.frequency(0.0) / 100, rtol=1e-10)

    by_time = MODE.ring_down(1e-6, duration=1e-3, samples_per_cycle=20)
    assert by_time.time[-1] == pytest.approx(1e-3, rel=1e-14)
    assert np.diff(by_time.time).max() <= 1.0 / MODE.frequency(0.0) / 20 * (1.0 + 1e-9)
    assert by_time.displacement[0] == 1e-6
    assert by_time.velocity[0] == 0.0
    assert MODE.ring_down(1e-6, duration=1e-9).time.tolist() == [0.0, 1e-9]


def test_an_envelope_by_cycles_or_duration() -> None:
    joint = ms.Interface.examples()[0]
    mode = ms.Oscillator(1.0, 1e9, joint)
    by_cycles = mode.decay(1e-8, cycles=50)
    assert by_cycles.time.size == by_cycles.amplitude.size == 51
    assert by_cycles.amplitude[0] == 1e-8
    assert by_cycles.time[0] == 0.0
    by_time = mode.decay(1e-8, duration=float(by_cycles.time[20]) * 1.0001)
    np.testing.assert_allclose(by_time.amplitude, by_cycles.amplitude[:21], rtol=1e-8)
    np.testing.assert_allclose(np.diff(by_cycles.time), 1.0 / by_cycles.frequency[1:], rtol=1e-3)
    assert mode.decay(1e-8, duration=1e-9).time.tolist() == [0.0]


def test_an_envelope_that_fades_to_nothing_ends() -> None:
    fading = ms.Oscillator(1.0, 1e9, CELL, 0.06).decay(1e-6, cycles=10_000)
    assert fading.amplitude.size < 600
    assert 0.0 < fading.amplitude[-1] < 1e-6 * 1e-89


def test_a_mass_that_is_held_rests() -> None:
    dry = ms.Oscillator(2.0, 8.0, ms.Coulomb(force_limit=0.3))
    held = dry.ring_down(0.03, cycles=5)
    assert held.time.tolist() == [0.0]
    assert held.force.tolist() == [-8.0 * 0.03]
    assert held.amplitude.size == held.frequency.size == held.damping_ratio.size == 0
    slides = dry.ring_down(0.2, duration=20.0, samples_per_cycle=10)
    assert slides.time[-1] == pytest.approx(20.0, rel=1e-14)
    last = slides.time > slides.turning_time[-1] + slides.time[1]
    assert last.sum() > 40
    assert np.ptp(slides.displacement[last]) == 0.0
    assert np.all(slides.velocity[last] == 0.0)
    np.testing.assert_array_equal(slides.force[last], -8.0 * slides.displacement[last])
    assert slides.energy_error < 1e-11


def test_swings_below_rounding_end() -> None:
    """What a dashpot has left of a motion is smaller than the place it rests at is known to."""
    mode = ms.Oscillator(1.0, 1e9, ms.Interface.examples()[0], 0.3)
    motion = mode.ring_down(1e-6, cycles=1000)
    assert motion.amplitude.size < 30
    assert motion.velocity[-1] == 0.0
    assert abs(motion.displacement[-1]) > 1e-10
    assert np.all(np.isfinite(motion.frequency))


def test_everything_is_frozen() -> None:
    motion, envelope = DAMPED.ring_down(5e-6, cycles=2), DAMPED.decay(1e-6, cycles=2)
    for thing in (MODE, motion, envelope):
        for field in dataclasses.fields(thing):
            with pytest.raises(dataclasses.FrozenInstanceError):
                setattr(thing, field.name, 1.0)
    for thing in (motion, envelope, copy.deepcopy(motion), pickle.loads(pickle.dumps(envelope))):
        for field in dataclasses.fields(thing):
            assert not getattr(thing, field.name).flags.writeable
    assert not motion.amplitude.flags.writeable
    assert not motion.frequency.flags.writeable
    assert not motion.damping_ratio.flags.writeable
    again = pickle.loads(pickle.dumps(motion))
    np.testing.assert_array_equal(again.damping_ratio, motion.damping_ratio)
    assert pickle.loads(pickle.dumps(DAMPED)).damping_ratio(1e-5) == DAMPED.damping_ratio(1e-5)


def test_what_is_shown() -> None:
    assert repr(MODE) == (
        "Oscillator(mass=2.0, stiffness=30000000.0, "
        "joint=Jenkins(stiffness=50000000.0, force_limit=100.0), viscous_damping_ratio=0.0)"
    )
    motion = MODE.ring_down(1e-6, cycles=2)
    assert repr(motion) == "RingDown(201 samples in 0.00198692 s, 2 cycles, release at 1e-06 m)"
    assert repr(DAMPED.decay(1e-6, cycles=2)) == (
        "Decay(2 cycles in 0.00198702 s, amplitude from 1e-06 to 8.81906e-07)"
    )


def test_minus_zero_is_zero() -> None:
    mode = ms.Oscillator(1.0, -0.0, CELL, -0.0)
    assert repr(mode).count("-0.0") == 0


# -- errors ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mass": 0.0}, "mass must be above zero [kg], got 0"),
        ({"mass": -2}, "mass must be above zero [kg], got -2"),
        ({"mass": "2 kg"}, "mass must be a finite number in kg, got '2 kg', for example mass=1"),
        ({"mass": 1e99}, "mass must be between 1e-40 and 1e+40 [kg], got 1e+99"),
        ({"stiffness": -1.0}, "stiffness must be zero or more [N/m], got -1"),
        ({"stiffness": 1e41}, "stiffness must be at most 1e+40 [N/m], got 1e+41"),
        ({"stiffness": np.nan}, "stiffness must be a finite number in N/m, got nan"),
        (
            {"joint": 3.0},
            "joint must be a backbone law "
            f"({', '.join(law.__name__ for law in ms.friction.LAWS)}), got 3.0",
        ),
        (
            {"viscous_damping_ratio": 1.0},
            "viscous_damping_ratio must be in [0, 1) (else nothing swings), got 1",
        ),
        (
            {"viscous_damping_ratio": -0.01},
            "viscous_damping_ratio must be in [0, 1) (else nothing swings), got -0.01",
        ),
        (
            {"viscous_damping_ratio": "1 %"},
            "viscous_damping_ratio must be a finite number, got '1 %', "
            "for example viscous_damping_ratio=0.01",
        ),
    ],
)
def test_wrong_oscillators(given: dict[str, Any], message: str) -> None:
    right = {"mass": 2.0, "stiffness": 3e7, "joint": CELL}
    assert refusal(ms.Oscillator, **(right | given)) == message


@pytest.mark.parametrize("name", METHODS)
def test_wrong_amplitudes(name: str) -> None:
    method = getattr(MODE, name)
    assert refusal(method, [1e-6, -1e-6]) == "amplitude must not be negative, got -1e-06"
    assert refusal(method, []) == "amplitude must hold at least one number, got an empty array"
    assert (
        refusal(method, "1 um") == "amplitude must be a number or an array of numbers, got '1 um'"
    )
    assert refusal(method, [np.nan]) == (
        "amplitude must be finite: 1 of 1 values are not, the first is nan at index 0"
    )


@pytest.mark.parametrize("name", ["frequency", "angular_frequency", "damping_ratio"])
def test_wrong_methods(name: str) -> None:
    assert refusal(getattr(MODE, name), 1e-6, method="secant") == (
        'method must be "quasi-static" or "harmonic-balance", got \'secant\''
    )


@pytest.mark.parametrize("name", ["ring_down", "decay"])
def test_wrong_lengths(name: str) -> None:
    method = getattr(MODE, name)
    begin = f"{name} needs cycles=... or duration=... [s], one of them, got"
    assert refusal(method, 1e-6) == f"{begin} neither"
    assert refusal(method, 1e-6, cycles=1, duration=1.0) == f"{begin} both"
    for wrong in (0, -3, 2.5, True, 10**9):
        assert refusal(method, 1e-6, cycles=wrong) == (
            f"cycles must be an integer from 1 to 10000000, got {wrong}"
        )
    assert refusal(method, 1e-6, duration=0.0) == "duration must be above zero [s], got 0"
    assert refusal(method, 0.0, cycles=1) == "amplitude must be above zero [m], got 0"
    assert refusal(method, [1e-6], cycles=1) == (
        "amplitude must be a finite number in m, got [1e-06]"
    )


def test_wrong_ring_downs(monkeypatch: pytest.MonkeyPatch) -> None:
    for wrong in (7, 100.0, True, "100"):
        assert refusal(MODE.ring_down, 1e-6, cycles=1, samples_per_cycle=wrong) == (
            f"samples_per_cycle must be an integer from 8 to 1000000, got {wrong!r}"
        )
    assert refusal(MODE.ring_down, 1e-6, cycles=10_000_000) == (
        "ring_down holds at most 20000000 samples, this one would be 1e+09; "
        "ask for less, or for the envelope with decay(...)"
    )
    assert refusal(MODE.ring_down, 1e-6, duration=1e9) == (
        "ring_down holds at most 20000000 samples, this one would be 1.01e+14; "
        "ask for less, or for the envelope with decay(...)"
    )
    free = ms.Oscillator(2.0, 0.0, ms.Coulomb(force_limit=1.0))
    assert refusal(free.ring_down, 1e-6, cycles=1) == (
        "stiffness must be above zero beside a joint that is rigid at rest: nothing swings "
        "without a spring, got 0"
    )
    # While it slides the spring alone makes the period: ten times as many samples a cycle.
    monkeypatch.setattr(module, "MOST_SAMPLES", 4000)
    soft = ms.Oscillator(2.0, 5e5, CELL)
    assert refusal(soft.ring_down, 0.1, cycles=20) == (
        "ring_down holds at most 4000 samples, and 4 cycles have taken that many; "
        "ask for less, or for the envelope with decay(...)"
    )


def test_a_mass_that_creeps() -> None:
    creeping = ms.Oscillator(2.0, 5e2, CELL, 0.5)
    assert refusal(creeping.ring_down, 1.0, cycles=1, samples_per_cycle=8) == (
        "cycles cannot be counted: the mass creeps back without turning, since the dashpot is "
        "strong against the sliding joint; give duration=... [s] instead"
    )
    motion = creeping.ring_down(1.0, duration=0.1, samples_per_cycle=8)
    assert np.all(np.diff(motion.displacement) < 0.0)


def test_wrong_decays() -> None:
    fast = ms.Oscillator(2.0, 1e6, CELL)
    message = (
        "amplitude must be one that decays slowly: of 0.0001 m a cycle would lose more than half; "
        "ring_down(...) follows any motion"
    )
    assert refusal(fast.decay, 1e-4, cycles=1) == message
    # The dashpot alone would not let it swing while the joint slides.
    creeping = ms.Oscillator(2.0, 5e2, CELL, 0.5)
    assert refusal(creeping.decay, 1e-4, cycles=1) == message
    assert refusal(MODE.decay, 1e-6, duration=1e9) == (
        "duration must be at most 10000000 periods of the oscillator, "
        "got 1e+09 s, which are 1.01e+12"
    )
