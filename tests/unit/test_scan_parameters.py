"""Parameters of scans and of ISO 25178: on small arrays and made surfaces, in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from made_surfaces import rough
from scipy import stats
from scipy.special import ellipe

import microslip as ms
from microslip.surfaces import (
    Scan,
    verdicts,
)
from microslip.surfaces.scan_rules import extreme_shares
from microslip.surfaces.surface_parameters import decay_lengths

RNG = np.random.default_rng(7)
NOISE = Scan(RNG.normal(size=(60, 80)) * 1e-7, (1e-6, 2e-6))


# Heights.


def test_height_parameters_are_those_of_scipy() -> None:
    z = RNG.gamma(3.0, 1e-7, size=(90, 110))
    z[3, 4:20] = np.nan
    there = z[~np.isnan(z)]
    found = Scan(z, 1e-6).statistics()
    assert found.mean == pytest.approx(there.mean())
    assert found.rms == pytest.approx(there.std())
    assert found.mean_deviation == pytest.approx(np.abs(there - there.mean()).mean())
    assert found.skewness == pytest.approx(stats.skew(there))
    assert found.kurtosis == pytest.approx(stats.kurtosis(there, fisher=False))
    assert found.maximum_height == pytest.approx(np.ptp(there))
    assert found.count == there.size
    assert found.missing == pytest.approx(16 / z.size)


def test_shares_of_the_extreme_points() -> None:
    shares = extreme_shares(Scan(np.random.default_rng(0).normal(size=(500, 600)), 1.0))
    # Twice the integral of x^2 phi above the quantile of 0.05 %; 300 points of extremes: 2 %.
    x = stats.norm.isf(0.0005)
    expected = 2 * (x * stats.norm.pdf(x) + stats.norm.sf(x))
    assert list(shares.values()) == pytest.approx([expected] * 3, rel=0.02)
    z = np.random.default_rng(0).normal(size=(100, 100)) * 1e-9
    z[50, 50] += 1e-6
    assert min(extreme_shares(Scan(z, 1e-6)).values()) > 0.9


def test_verdicts_on_noise_and_on_a_surface() -> None:
    noise = {verdict.name: verdict for verdict in verdicts(NOISE)}
    assert noise["fraction of m4 lost to the pixel"].word == "outside"
    assert noise["kurtosis"].word == "ok"
    fine = rough((300, 300), 1e-6, 3.5e-7, longest=4.65e-5, shortest=1.02e-5)
    assert {verdict.word for verdict in verdicts(fine)} == {"ok"}
    profile = Scan(RNG.normal(size=500).cumsum() * 1e-9, 1e-6)
    assert "anisotropy" not in {verdict.name for verdict in verdicts(profile)}


# Made surfaces.


PIXEL = 1e-6
SIDE = np.arange(400)
WAVE, HEIGHT = 50e-6, 2e-7
Q = 2.0 * math.pi / WAVE


def self_affine(points: int, hurst: float, seed: int) -> ms.Scan:
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(points), np.fft.fftfreq(points)))
    amplitude = np.divide(1.0, q, out=np.zeros_like(q), where=q > 0.0) ** (1.0 + hurst)
    noise = np.random.default_rng(seed).standard_normal((points, points))
    return ms.Scan(1e-9 * np.fft.ifft2(np.fft.fft2(noise) * amplitude).real, PIXEL)


def test_a_sine_has_its_slopes_and_its_length() -> None:
    sine = ms.Scan(np.tile(HEIGHT * np.cos(Q * PIXEL * SIDE), (400, 1)), PIXEL)
    found, m = sine.areal_parameters(), HEIGHT * Q
    area = 2.0 / math.pi * math.sqrt(1.0 + m * m) * ellipe(m * m / (1.0 + m * m)) - 1.0
    # A pixel is a fiftieth of the wave: 1/6 (q h/2)^2 of its slopes, and the ends of the rows.
    assert found.developed_area_ratio == pytest.approx(area, rel=3e-3)
    assert found.rms_gradient == pytest.approx(m / math.sqrt(2.0), rel=1.5e-3)
    across = ms.Scan(sine.heights.T, (2.0 * PIXEL, PIXEL)).areal_parameters()
    for name in ("developed_area_ratio", "rms_gradient"):
        assert getattr(across, name) == pytest.approx(getattr(found, name), rel=1e-9)
    # The 0.2 of the correlation, which begins to fall along x first; along y it never does.
    assert found.autocorrelation_length == pytest.approx(math.acos(0.2) / Q, rel=0.02)
    assert math.isnan(found.texture_aspect_ratio)
    wave = np.sin(Q * PIXEL * (SIDE + 0.5))
    box = ms.Scan(HEIGHT * wave[:, None] * wave[None, :], PIXEL).areal_parameters()
    # cos(x) cos(y) = 0.2: along an axis at acos(0.2), along the diagonal at acos(sqrt(0.2)) twice.
    ratio = math.acos(0.2) / (math.sqrt(2.0) * math.acos(math.sqrt(0.2)))
    assert box.texture_aspect_ratio == pytest.approx(ratio, rel=0.02)


def test_the_lobe_of_the_correlation_may_bend_away_from_its_rays() -> None:
    """Str is of the lobe that contains the origin, whatever leaves it along a ray on the way."""
    correlation = np.zeros((101, 101))
    correlation[50, 50:81] = correlation[50, 20:51] = 1.0  # a lobe of 30 points, bent at its ends
    correlation[50:60, 80] = correlation[41:51, 20] = 1.0
    correlation[70:75, 60:70] = 1.0  # another lobe
    shortest, longest = decay_lengths(correlation, (1.0, 1.0))
    assert shortest == pytest.approx(0.8)
    assert longest == pytest.approx(math.hypot(30.8, 9.0))


@pytest.mark.parametrize("valleys", [0.1, 0.3])
def test_the_rms_of_a_plateau_is_found_under_its_valleys(valleys: float) -> None:
    """Two Gaussian processes, the lower of both at each point, as honing leaves them."""
    rng = np.random.default_rng(4)
    plateau = 2e-7 * rng.standard_normal((300, 300))
    depth = 2e-6 * rng.standard_normal((300, 300))
    honed = np.minimum(plateau, depth - np.quantile(depth, valleys))
    scan = ms.Scan(honed, PIXEL)
    assert scan.areal_parameters().plateau_rms == pytest.approx(2e-7, rel=0.15)
    assert scan.profile_parameters().plateau_rms == pytest.approx(2e-7, rel=0.15)
    assert math.isnan(ms.Scan(plateau, PIXEL).areal_parameters().plateau_rms)


def test_the_uncertainty_of_the_spectrum_is_its_scatter() -> None:
    """Over forty surfaces of one spectrum, ring by ring."""
    found = [self_affine(64, 0.8, seed).spectrum() for seed in range(40)]
    densities = np.array([one.density for one in found])
    scatter = densities.std(axis=0) / densities.mean(axis=0)
    ratio = scatter[3:30] / found[0].relative_error[3:30]
    assert np.median(ratio) == pytest.approx(1.0, abs=0.25)
