"""Parameters of ISO 25178, autocorrelation, power laws: against closed forms on made surfaces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipe

import microslip as ms

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
    # The 0.2 of the correlation, which begins to fall along x first; along y it never does.
    assert found.autocorrelation_length == pytest.approx(math.acos(0.2) / Q, rel=0.02)
    assert found.texture_aspect_ratio == 0.0
    wave = np.sin(Q * PIXEL * (SIDE + 0.5))
    box = ms.Scan(HEIGHT * wave[:, None] * wave[None, :], PIXEL).areal_parameters()
    assert box.texture_aspect_ratio == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_hursts_exponent_is_found_within_its_error(hurst: float) -> None:
    """Of ten surfaces the mean is right and the scatter is the error told."""
    fits = [self_affine(256, hurst, seed).spectrum().self_affine_fit() for seed in range(10)]
    found = np.array([fit.hurst for fit in fits])
    error = float(np.mean([fit.error for fit in fits]))
    assert abs(found.mean() - hurst) < 3.0 * error / math.sqrt(10.0) + 0.02
    assert 0.4 < found.std() / error < 2.0
    assert np.median([fit.misfit for fit in fits]) == pytest.approx(1.0, abs=0.4)
    with pytest.raises(ms.InputError, match="five rings"):
        self_affine(64, hurst, 0).spectrum().self_affine_fit(shortest=2e-5, longest=2.1e-5)


def test_the_uncertainty_of_the_spectrum_is_its_scatter() -> None:
    """Over forty surfaces of one spectrum, ring by ring."""
    found = [self_affine(64, 0.8, seed).spectrum() for seed in range(40)]
    densities = np.array([one.density for one in found])
    scatter = densities.std(axis=0) / densities.mean(axis=0)
    ratio = scatter[3:30] / found[0].relative_error[3:30]
    assert np.median(ratio) == pytest.approx(1.0, abs=0.25)
