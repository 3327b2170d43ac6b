"""ISO 21920-2 and more of 25178-2, against closed forms."""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
import pytest
from scipy.integrate import quad

import microslip as ms
from microslip._core.errors import InputError

STEP = 1e-6
X = STEP * np.arange(8000)
WAVE, HEIGHT = 8e-3 / 83.0, 2e-7  # no two points of 8000 are at the same phase
SINE = ms.Scan(HEIGHT * np.sin(2.0 * math.pi * X / WAVE + 0.3), STEP)


def gaussian(points: int, smooth: float, seed: int = 0) -> np.ndarray:
    """A long Gaussian profile of unit rms with correlation exp(-x^2/(4 s^2)), x in points."""
    waves = np.exp(-((2.0 * math.pi * np.fft.rfftfreq(points) * smooth) ** 2) / 2.0)
    noise = np.random.default_rng(seed).standard_normal(points)
    line = np.fft.irfft(np.fft.rfft(noise) * waves, points)
    return np.asarray(line / line.std())


def test_a_sine_after_iso_21920() -> None:
    found = SINE.profile_parameters("0.8 mm")
    assert (found.section, found.sections) == (pytest.approx(0.8e-3), 10.0)
    assert found.mean_deviation == pytest.approx(2.0 / math.pi * HEIGHT, rel=1e-4)
    assert found.rms == pytest.approx(HEIGHT / math.sqrt(2.0), rel=1e-6)
    assert (found.skewness, found.kurtosis) == (pytest.approx(0.0, abs=1e-6), pytest.approx(1.5))
    assert found.height == pytest.approx(2.0 * HEIGHT, rel=1e-3)
    assert found.spacing == pytest.approx(WAVE, rel=1e-4)
    slope = 2.0 * math.pi / WAVE * HEIGHT / math.sqrt(2.0)
    assert found.rms_gradient == pytest.approx(slope, rel=5e-4)  # all but six points


def test_gaussian_heights_after_iso_21920() -> None:
    smooth, count = 12.0, 2_000_000
    profile = ms.Scan(1e-7 * gaussian(count, smooth), STEP)
    found = profile.profile_parameters(800 * STEP)
    assert found.mean_deviation == pytest.approx(1e-7 * math.sqrt(2.0 / math.pi), rel=3e-3)
    assert found.kurtosis == pytest.approx(3.0, rel=0.01)
    assert found.rms_gradient == pytest.approx(1e-7 / (math.sqrt(2.0) * smooth * STEP), rel=3e-3)
    # Rice: mean distance of upward crossings, which small hills and dales that do not count widen.
    rice = 2.0 * math.pi * math.sqrt(2.0) * smooth * STEP
    assert 1.05 < found.spacing / rice < 1.25
    # Extremes of a section by the crossings of high levels: exp(-n exp(-u^2/2)), n waves.
    waves = 800 * STEP / rice
    mean = quad(lambda u: 1.0 - math.exp(-waves * math.exp(-0.5 * u * u)), 0.0, 9.0)[0]
    assert found.height == pytest.approx(2e-7 * mean, rel=0.03)


def test_lines_of_an_area_and_sections_that_do_not_fit() -> None:
    area = ms.Scan(np.tile(SINE.heights[:4000], (5, 1)), STEP)
    one = ms.Scan(SINE.heights[:4000], STEP).profile_parameters("0.8 mm")
    many = astuple(area.profile_parameters("0.8 mm"))
    np.testing.assert_allclose(many, astuple(one), rtol=1e-12, atol=1e-12)
    with pytest.raises(InputError, match="along y must vary"):
        area.profile_parameters("4 um", "y")
    with pytest.raises(InputError, match="no longer than the profile"):
        area.profile_parameters("8 mm")
    with pytest.raises(InputError, match="every line has gaps"):
        ms.Scan(np.where(np.arange(4000) == 7, np.nan, area.heights), STEP).profile_parameters()


def test_ends_are_cut() -> None:
    z = 1e-8 * np.random.default_rng(7).standard_normal((60, 400))
    levelled = ms.Scan(z, STEP)
    cropped = levelled.condition(crop=("30 um", "10 um"))
    np.testing.assert_array_equal(cropped.heights, z[10:-10, 30:-30])
    assert cropped.notes[-1] == "crop: 30 µm x 10 µm removed at each end."
    with pytest.raises(InputError, match="leave four points"):
        levelled.condition(crop="29 um")
