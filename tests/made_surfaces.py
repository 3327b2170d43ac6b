"""Rough surfaces, and surfaces whose summits are known exactly, for the tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import microslip as ms


def paraboloids(
    shape: tuple[int, int],
    pixel: float | tuple[float, float],
    *,
    positions: ArrayLike,
    heights: ArrayLike,
    radii: ArrayLike,
) -> ms.Scan:
    """Make paraboloids on a plane: the largest of z_i - dx^2/(2 R_ix) - dy^2/(2 R_iy) and zero.

    Positions (n, 2) are x and y [m] from the first point; radii [m] are one, (n,) or (n, 2).
    """
    dx, dy = (pixel, pixel) if isinstance(pixel, float) else pixel
    at, tops = np.asarray(positions), np.broadcast_to(heights, len(np.asarray(positions)))
    curved = np.asarray(radii, dtype=float)
    curved = np.broadcast_to(curved if curved.ndim == 2 else curved.reshape(-1, 1), at.shape)
    y, x = np.arange(shape[0])[:, None] * dy, np.arange(shape[1])[None, :] * dx
    z = np.zeros(shape)
    for (x0, y0), top, (rx, ry) in zip(at, tops, curved, strict=True):
        np.maximum(z, top - ((y - y0) ** 2 / (2.0 * ry)) - (x - x0) ** 2 / (2.0 * rx), out=z)
    return ms.Scan(z, (dx, dy), name="paraboloids")


def rough(
    shape: tuple[int, int], pixel: float, rms: float, longest: float, shortest: float, seed: int = 0
) -> ms.Scan:
    """Make a periodic Gaussian surface: waves of random phase between two wavelengths [m].

    The spectrum falls like q^-3.6, a Hurst exponent of 0.8; ``rms`` is the rms height [m].
    """
    q = np.hypot(np.fft.fftfreq(shape[0], pixel)[:, None], np.fft.rfftfreq(shape[1], pixel))
    band = (q > 1.0 / longest) & (q < 1.0 / shortest)
    waves = np.where(band, np.maximum(q, 1.0 / longest) ** -1.8, 0.0)
    turned = np.exp(2j * np.pi * np.random.default_rng(seed).random(q.shape))
    heights = np.fft.irfft2(waves * turned, s=shape)
    return ms.Scan(heights * (rms / heights.std()), pixel, name="rough")
