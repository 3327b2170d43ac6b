"""ISO 21920-2 and more of 25178-2, and ISO's other filters, against closed forms."""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
import pytest
from scipy.integrate import quad

import microslip as ms
from microslip._core.errors import InputError
from microslip.surfaces.filters import _Regression, robust_mean, spline_mean

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


@pytest.mark.parametrize("wave", [50e-6, 100e-6, 200e-6])
def test_filters_transmit_what_their_standards_say(wave: float) -> None:
    """(1 + t) exp(-t) of a regression of second order, 1/(1 + (c/w)^4) of a smoothing spline."""
    cutoff, line = 100e-6, np.sin(2.0 * math.pi * X / wave)
    inside = slice(1000, -1000)
    regression = _Regression((1, X.size), (STEP, STEP), cutoff)

    def of_regression(wave: float) -> float:
        t = 1.6783469900166605 * (cutoff / wave) ** 2
        return (1.0 + t) * math.exp(-t)

    for through, wanted in (
        (regression(line[None], np.ones((1, X.size)))[0], of_regression),
        (spline_mean(line, (STEP,), cutoff), lambda wave: 1.0 / (1.0 + (cutoff / wave) ** 4)),
    ):
        share = float((through * line)[inside].sum() / (line * line)[inside].sum())
        assert share == pytest.approx(wanted(wave), abs=2e-4)
        assert wanted(cutoff) == pytest.approx(0.5, abs=1e-12)
    # The weights of the robust filter follow a wave a little.
    robust = robust_mean(line, (STEP,), cutoff)
    share = float((robust * line)[inside].sum() / (line * line)[inside].sum())
    assert share == pytest.approx(of_regression(wave), abs=0.03)


def test_scratches_do_not_pull_the_robust_mean_nor_do_ends() -> None:
    rng = np.random.default_rng(5)
    form = 2e-3 * X + 5.0 * (X - 4e-3) ** 2
    rough = 1e-8 * rng.standard_normal(X.size)
    scratches = np.where((X % 0.4e-3) < 0.03e-3, -2e-6, 0.0)
    scan = ms.Scan(form + rough + scratches, STEP)
    sound = scratches == 0.0
    errors = {}
    for name in ("gaussian", "robust", "spline"):
        kept = scan.condition(level="quadratic", long_cutoff="0.8 mm", filter=name).heights
        errors[name] = float(np.sqrt(np.mean((kept - rough)[sound] ** 2)))
    assert errors["robust"] < 2e-9 < 100e-9 < min(errors["gaussian"], errors["spline"])
    # Ends: a parabola passes the robust filter, a straight line the spline, unlike the Gaussian.
    clean = ms.Scan(form + rough, STEP).condition(long_cutoff="0.8 mm", filter="robust").heights
    assert np.abs(clean[:200] - rough[:200]).max() < 3e-9
    tilted = ms.Scan(2e-3 * X + rough, STEP)
    kept = tilted.condition(long_cutoff="0.8 mm", filter="spline").heights
    assert np.abs(kept[:200] - rough[:200]).max() < 5e-9
    bent = tilted.condition(long_cutoff="0.8 mm").heights
    assert np.abs(bent[:200] - rough[:200]).max() > 100e-9


def test_areas_are_filtered_alike_in_all_directions_and_around_gaps() -> None:
    x, y = np.meshgrid(STEP * np.arange(240), STEP * np.arange(200))
    plane = 3e-4 * x - 2e-4 * y
    wave = 1e-9 * np.sin(2.0 * math.pi / 40e-6 * (0.6 * x + 0.8 * y))
    inside = slice(60, 140), slice(60, 180)
    tilted = ms.Scan(plane + wave, STEP).condition(long_cutoff=40e-6, filter="spline").heights
    share = float((tilted * wave)[inside].sum() / (wave * wave)[inside].sum())
    assert share == pytest.approx(0.5, abs=1e-3)
    # A gap and deep pits: the robust surface is that of the rest.
    rough = 1e-8 * np.random.default_rng(6).standard_normal(plane.shape)
    pits = np.where((x % 30e-6 < 4e-6) & (y % 30e-6 < 4e-6), -1e-6, 0.0)
    z = plane + rough + pits
    z[90:100, 50:60] = np.nan
    kept = ms.Scan(z, STEP).condition(long_cutoff=60e-6, filter="robust").heights
    sound = (pits == 0.0) & ~np.isnan(z)
    assert np.isnan(kept[95, 55])
    assert np.sqrt(np.mean((kept - rough)[sound] ** 2)) < 1e-9


def test_rows_are_levelled_one_by_one_and_ends_cut() -> None:
    rng = np.random.default_rng(7)
    rough = 1e-8 * rng.standard_normal((60, 400))
    drift = 1e-6 * rng.standard_normal((60, 1)) + 1e-9 * rng.standard_normal((60, 1)) * range(400)
    z = rough + drift
    z[5, 100:200] = np.nan
    levelled = ms.Scan(z, STEP).condition(level="lines")
    kept = levelled.heights
    # Two numbers of 400 went with each row.
    share = np.nanmean(kept**2) / np.nanmean(rough**2)
    assert share == pytest.approx(1.0 - 2.0 / 400.0, rel=5e-3)
    assert np.abs(np.nanmean(kept, axis=1)).max() < 1e-18
    cropped = levelled.condition(crop=("30 um", "10 um"))
    np.testing.assert_array_equal(cropped.heights, kept[10:-10, 30:-30])
    assert cropped.notes[-1] == "crop: 30 µm x 10 µm removed at each end."
    with pytest.raises(InputError, match="leave four points"):
        levelled.condition(crop="29 um")
    with pytest.raises(InputError, match="filter must be"):
        levelled.condition(filter="median")  # type: ignore[arg-type]
