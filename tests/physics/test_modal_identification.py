"""From a structure's test back to its joint: what was put in comes out, and what cannot is told."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from laps import STEEL, small_joint

import microslip as ms

AMPLITUDES = [5e-7, 3e-6, 1e-5]
TRUE = {"friction_coefficient": 0.25, "tension": 1.3, "form": 0.6}


def bowed(x: Any, y: Any) -> Any:
    """Faces that gape by 4.5 um at the ends of the lap."""
    return 2e-2 * x**2


@lru_cache
def surface() -> ms.GreenwoodWilliamson:
    pair = ms.MaterialPair(STEEL, STEEL)
    return ms.GreenwoodWilliamson(pair, ms.Gaussian(1e-6), radius=1e-3, density=5e7, area=1e-4)


@lru_cache
def measured(noise: float) -> tuple[ms.ModalTest, ...]:
    """Two bending modes by harmonic balance, of other values than the fit begins with."""
    joint = small_joint().with_form(bowed, TRUE["form"]).with_tension(5e3 * TRUE["tension"])
    state = joint.tightened(surface(), TRUE["friction_coefficient"])
    random = np.random.default_rng(1)
    made = []
    for mode in (0, 2):
        curve = state.modes(mode, AMPLITUDES, at=joint.sensor("tip"), damping_ratio=1e-4)
        scatter = np.exp(noise * random.standard_normal((2, len(AMPLITUDES))))
        made.append(
            ms.ModalTest(
                AMPLITUDES,
                curve.frequency * scatter[0] ** 0.01,
                curve.damping_ratio * scatter[1],
                mode=mode,
                sensor="tip",
                frequency_error=max(0.01 * noise, 1e-5),
                damping_error=max(noise, 1e-3),
            )
        )
    return tuple(made)


def identified(noise: float, fit: tuple[str, ...], **known: float) -> ms.ModalIdentification:
    return ms.identify_modal(
        small_joint(), surface(), measured(noise), fit, form_table=bowed, base_damping_ratio=1e-4,
        **known,
    )  # fmt: skip


def test_inputs_are_recovered_without_noise() -> None:
    found = identified(0.0, tuple(TRUE))
    for name, value in TRUE.items():
        assert found.values[name] == pytest.approx(value, rel=2e-3)
    assert found.misfit < 0.2
    for curve, test in zip(found.curves, measured(0.0), strict=True):
        np.testing.assert_allclose(curve.damping_ratio, test.damping_ratio, rtol=2e-3)


@pytest.mark.slow
def test_a_second_mode_tells_the_form_from_the_modulus() -> None:
    joint = small_joint().scaled(1.03).with_form(bowed, TRUE["form"])
    state = joint.tightened(surface(), 0.3)
    made = []
    for mode in (0, 2):
        curve = state.modes(mode, AMPLITUDES[:2], at=joint.sensor("tip"))
        made.append(
            ms.ModalTest(
                AMPLITUDES[:2],
                curve.frequency,
                curve.damping_ratio,
                mode=mode,
                sensor="tip",
                frequency_error=1e-3,
            )
        )
    one, both = (
        ms.identify_modal(
            small_joint(), surface(), tests, ("form", "young_modulus"), form_table=bowed
        )
        for tests in (made[:1], made)
    )
    assert both.values["young_modulus"] == pytest.approx(1.03, rel=1e-4)
    assert both.values["form"] == pytest.approx(TRUE["form"], rel=1e-3)
    assert abs(one.correlation[0, 1]) > 0.85 > 0.8 > abs(both.correlation[0, 1])
    assert (both.scatter < 0.7 * one.scatter).all()
    squares = state.model.squares[[0, 2]]
    np.testing.assert_allclose(
        both.linear_frequencies[:, 2], np.sqrt(squares) / (2.0 * np.pi), rtol=1e-5
    )


@pytest.mark.slow
def test_noise_widens_the_intervals_and_they_hold_the_truth() -> None:
    found = identified(0.05, tuple(TRUE))
    for name, value in TRUE.items():
        low, high = found.intervals[name]
        spread = high - low
        assert low - 0.5 * spread < value < high + 0.5 * spread
    assert 0.3 < found.misfit < 2.0
    words = {verdict.name: verdict.word for verdict in found.verdicts}
    assert words["misfit over the errors of the test"] == "ok"
    assert words["parameters at a bound"] == "ok"


def test_a_ring_down_gives_back_its_curve() -> None:
    """A signal whose frequency and damping follow the curve, read as a test reads it."""
    curve = measured(0.0)[0]
    grid = np.log(curve.amplitude)
    time = np.arange(0.0, 1.2, 5e-5)
    level, phase, signal = np.log(1e-5), 0.0, []
    for _ in time:
        signal.append(np.exp(level) * np.cos(phase))
        omega = 2.0 * np.pi * np.interp(level, grid, curve.frequency)
        zeta = np.exp(np.interp(level, grid, np.log(curve.damping_ratio)))
        level, phase = level - zeta * omega * 5e-5, phase + omega * 5e-5
    found = ms.ModalTest.from_ring_down(time, signal, points=6, sensor="tip", mode=0)
    at = np.log(found.amplitude)
    np.testing.assert_allclose(found.frequency, np.interp(at, grid, curve.frequency), rtol=1e-3)
    wanted = np.exp(np.interp(at, grid, np.log(curve.damping_ratio)))
    # Each point is a mean over an interval in which the interpolated curve has a kink.
    np.testing.assert_allclose(found.damping_ratio, wanted, rtol=0.03)
    assert found.sensor == "tip"


@pytest.mark.slow
def test_a_wrong_assumption_is_seen_in_the_misfit() -> None:
    found = identified(
        0.0, ("friction_coefficient",)
    )  # tension and form are held where they are not
    words = {verdict.name: verdict.word for verdict in found.verdicts}
    assert words["misfit over the errors of the test"] == "outside"
    assert words["correlation of two parameters"] == "not judged"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fit": ("frictoin_coefficient",)}, 'did you mean "friction_coefficient"'),
        ({"fit": ()}, "fit must name each parameter once"),
        ({"fit": ("form", "form")}, "fit must name each parameter once"),
        ({"tests": []}, "tests must be of ms.ModalTest"),
        ({"form_table": None}, "form can be fitted only where the faces are not flat"),
        ({"friction_coefficient": 0.0}, "friction_coefficient must be above zero"),
        (
            {"tests": ms.ModalTest([1e-6], [900.0], [1e-3], sensor="tip")},
            "3 parameters need as many values, the tests have 2",
        ),
    ],
)
def test_fits_that_are_none(changes: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {
        "tests": measured(0.0),
        "fit": tuple(TRUE),
        "form_table": bowed,
    } | changes
    with pytest.raises(ms.InputError, match=message):
        ms.identify_modal(small_joint(), surface(), **given)


@pytest.mark.slow
def test_the_band_of_a_fitted_curve_is_between_the_ends_of_the_interval() -> None:
    found = identified(0.05, ("friction_coefficient",), tension=1.3, form=0.6)
    low, high = found.intervals["friction_coefficient"]
    joint = small_joint().with_form(bowed, 0.6).with_tension(5e3 * 1.3)
    ends = [
        joint.tightened(surface(), friction).modes(
            0, AMPLITUDES, at=joint.sensor("tip"), damping_ratio=1e-4
        )
        for friction in (high, low)  # more friction, less slip
    ]
    wanted = np.log([end.damping_ratio for end in ends])
    width = abs(wanted[1] - wanted[0])
    assert (abs(np.log(found.bands[0][1]) - wanted) < 0.15 * width).all()
