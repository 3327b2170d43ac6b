"""Random rough faces for the benchmarks."""

from __future__ import annotations

import numpy as np


def rough(
    points: int, pixel: float, rms: float, longest: float, shortest: float, seed: int
) -> np.ndarray:
    """Heights [m] of a square Gaussian face: waves of random phase between two wavelengths [m]."""
    q = np.hypot(np.fft.fftfreq(points, pixel)[:, None], np.fft.rfftfreq(points, pixel))
    band = (q > 1.0 / longest) & (q < 1.0 / shortest)
    waves = np.where(band, np.maximum(q, 1.0 / longest) ** -1.8, 0.0)
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, q.shape)
    heights = np.fft.irfft2(waves * np.exp(1j * phase))
    return np.asarray(heights * (rms / heights.std()))
