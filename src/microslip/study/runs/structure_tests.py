"""Comparison of modal tests with the bands of a prediction."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip.structures import ModalCurve, ModalTest
from microslip.structures.periodic_motion import POWERS
from microslip.study.runs.structure_prediction import (
    AmplitudeTrend,
    Mode,
    QuantityVerdict,
    TestWord,
)

_UNITS = {
    "amplitude": (
        (1e3, "multiplied by 1000"), (1e-3, "divided by 1000"), (1e6, "multiplied by 1e6"),
        (1e-6, "divided by 1e6"), (9.80665, "in g instead of m/s^2"),
        (1.0 / 9.80665, "in m/s^2 instead of g"),
    ),
    "frequency": (
        (0.5 / math.pi, "in rad/s instead of Hz"), (2.0 * math.pi, "in Hz instead of rad/s"),
        (1e3, "in kHz instead of Hz"), (1e-3, "in Hz instead of kHz"),
    ),
    "damping_ratio": (
        (0.01, "in percent"), (100.0, "as ratios instead of percent"), (0.5, "as loss factors"),
    ),
}  # fmt: skip
"""Factors on measured values, and the description of the values that need them."""
_PLURAL = {name: name.replace("_", " ") + "s" for name in _UNITS} | {"frequency": "frequencies"}


def compare_tests(
    tests: tuple[ModalTest, ...], modes: tuple[Mode, ...], quantity: str
) -> tuple[QuantityVerdict, ...]:
    """Compare frequency and damping of each test with the predicted band of its mode.

    Parameters
    ----------
    tests : tuple of ModalTest
        Tests; their mode numbers start at 0.
    modes : tuple of Mode
        Predicted modes.
    quantity : str
        Quantity of the predicted amplitudes: displacement, velocity or acceleration.
    """
    verdicts = []
    for test in tests:
        mode = next(mode for mode in modes if mode.number == test.mode + 1)
        if mode.bands is None:
            continue
        moved = test.amplitude * (2.0 * math.pi * test.frequency) ** POWERS[quantity]
        for name in ("frequency", "damping_ratio"):
            verdicts.append(_judged(test, mode, name, moved))
    return tuple(verdicts)


def _judged(test: ModalTest, mode: Mode, name: str, moved: Floats) -> QuantityVerdict:
    assert mode.bands is not None  # checked by the caller
    value, band = getattr(test, name), getattr(mode.bands, name)
    if name == "damping_ratio" and test.motion == "decay":  # convert to steady motion
        value = value * _steady_over_decay(mode.curve, moved)
    above, below, points, distance = _against(mode, band, moved, value)
    word: TestWord = "inside"
    if not points:
        word = "not compared"
    elif above and below:
        word = "on both sides"
    elif above or below:
        word = "above" if above else "below"
    unit = "" if word == "inside" else _unit(mode, band, moved, value, name)
    idle = "base damping ratio" if name == "frequency" else ""  # which moves no frequency
    slopes = [pair for pair in mode.bands.slopes[name] if pair[0] != idle]
    order = sorted(slopes, key=lambda pair: -abs(pair[1]))
    wanted = 1.0 if above >= below else -1.0
    candidates = tuple(
        (key, "more" if wanted * slope > 0.0 else "less")
        for key, slope in order
        if abs(slope) > 0.1 * abs(order[0][1])
    )
    return QuantityVerdict(
        test.name, mode.number, name, word, points, above, below, distance,
        candidates if above or below else (), unit,
    )  # fmt: skip


def _against(mode: Mode, band: Floats, moved: Floats, value: Floats) -> tuple[int, int, int, float]:
    """Return the numbers of points above a band, below it and in all, and the worst deviation.

    Points ``value`` count if their amplitudes ``moved`` are within the range of ``mode``. The
    deviation is relative to the nearest end of the band [-], and negative below it.
    """
    at, known = mode.curve.amplitude, np.isfinite(band).all(axis=0)
    if not known.any():
        return 0, 0, 0, 0.0
    at, band = at[known], band[:, known]
    within = (moved >= 0.999 * at[0]) & (moved <= 1.001 * at[-1])
    if not within.any():
        return 0, 0, 0, 0.0
    low, high = (np.exp(np.interp(np.log(moved[within]), np.log(at), np.log(end)))
                 for end in (band[0], band[-1]))  # fmt: skip
    over, under = value[within] / high - 1.0, value[within] / low - 1.0
    apart = np.where(over > 0.0, over, np.minimum(under, 0.0))
    worst = float(apart[np.argmax(abs(apart))])
    return int((over > 0.0).sum()), int((under < 0.0).sum()), int(within.sum()), worst


def _unit(mode: Mode, band: Floats, moved: Floats, value: Floats, name: str) -> str:
    """Return the unit error that would put a whole test inside the band; "" if there is none."""
    for changed in ("amplitude", name):
        for factor, word in _UNITS[changed]:
            of_amplitude, of_value = (factor, 1.0) if changed == "amplitude" else (1.0, factor)
            above, below, points, _ = _against(mode, band, of_amplitude * moved, of_value * value)
            if points == moved.size and not above + below:
                return f"{_PLURAL[changed]} {word}"
    return ""


def _steady_over_decay(curve: ModalCurve, moved: Floats) -> Floats:
    """Return damping ratio in steady vibration over that in free decay, at amplitudes ``moved``."""
    ratio = curve.damping_ratio / curve.decay_damping_ratio
    known = np.isfinite(ratio)
    if not known.any():
        return np.ones(moved.size)
    return np.interp(np.log(moved), np.log(curve.amplitude[known]), ratio[known])


def amplitude_trends(
    tests: tuple[ModalTest, ...], modes: tuple[Mode, ...]
) -> tuple[AmplitudeTrend, ...]:
    """Return changes of frequency and damping with amplitude, of predictions and tests."""
    found = []
    for mode in modes:
        known = np.flatnonzero(mode.curve.converged)
        if len(known) > 1:
            ends = mode.curve.frequency[known[[0, -1]]], mode.curve.damping_ratio[known[[0, -1]]]
            found.append(_change("prediction", mode.number, mode.curve.base_damping, *ends))
    for test in tests:
        order = np.argsort(test.amplitude)[[0, -1]]
        if test.amplitude.size > 1:
            ends = test.frequency[order], test.damping_ratio[order]
            found.append(_change(test.name or "test", test.mode + 1, math.nan, *ends))
    return tuple(found)


def _change(
    source: str, number: int, base: float, frequency: Floats, damping: Floats
) -> AmplitudeTrend:
    rise = float(damping[1] - damping[0])
    return AmplitudeTrend(
        source, number, float(base), rise, float(frequency[1] / frequency[0] - 1.0)
    )
