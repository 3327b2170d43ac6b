"""Ten kinds of machined faces with fixed seeds, made in the plane and not from a spectrum."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Floats = NDArray[np.float64]

POINTS = 192
_SHORT = 1.6
"""Standard deviation of the last smoothing [pixels]: 8 pixels a shortest wave."""


class Made(NamedTuple):
    """A face and the numbers of its drawing, as a profilometer gives them."""

    heights: Floats
    """Heights [m], summits upwards."""
    pixel: float
    """Distance of neighbours [m]."""
    rms: float
    """Rq [m]."""
    slope: float
    """Rdq of profiles across the lay [-]."""
    lay: float
    """Slope along the lay over that across it [-]."""
    plateau: float | None
    """Rpq of a plateau [m]."""


def _noise(
    rng: np.random.Generator, across: float, along: float = 0.0, hurst: float = 0.8
) -> Floats:
    """Sum smoothed white noise of falling lengths: correlation lengths [pixels] across, along."""
    total, along = np.zeros((POINTS, POINTS)), along or across
    length = 1.0
    while across * length > _SHORT:
        part = gaussian_filter(
            rng.standard_normal((POINTS, POINTS)),
            (max(along * length, _SHORT), across * length), mode="wrap",
        )  # fmt: skip
        total += length**hurst * part / part.std()
        length *= 0.6
    return total / total.std()


def _turned(rng: np.random.Generator) -> Floats:
    """Cusps of a round nose at a feed of 40 pixels, each a little deeper or beside, with noise."""
    x, z = np.arange(POINTS), np.full(POINTS, np.inf)
    for centre in np.arange(-20.0, POINTS + 40.0, 40.0):
        z = np.minimum(z, (x - centre - rng.normal(scale=2.0)) ** 2 + rng.normal(scale=25.0))
    z = (z - z.mean()) / z.std()
    return np.asarray(z + 0.5 * _noise(rng, 8.0, 40.0))


def _ground(rng: np.random.Generator) -> Floats:
    """Scratches of grains, long along y, cut into each other."""
    z = _noise(rng, 9.0, 90.0, 0.7)
    x = np.arange(POINTS)
    for _ in range(60):
        wide, deep, at = rng.uniform(2.0, 6.0), rng.exponential(0.5), rng.uniform(0, POINTS)
        z -= deep * np.exp(-(((x - at + 0.5 * POINTS) % POINTS - 0.5 * POINTS) ** 2) / wide**2)
    return z


def _milled(rng: np.random.Generator) -> Floats:
    """Arcs of the teeth of a cutter, with finer waves three times as long along y."""
    x = np.arange(POINTS)
    y = x[:, None]
    z = np.full((POINTS, POINTS), np.inf)
    for tooth in range(-1, 6):
        centre = 36.0 * tooth + (y - 60.0) ** 2 / 1500.0 + rng.normal(scale=2.0)
        z = np.minimum(z, (x - centre) ** 2 + rng.normal(scale=50.0))
    z = (z - z.mean()) / z.std()
    return np.asarray(z + 0.6 * _noise(rng, 8.0, 24.0))


def _honed(rng: np.random.Generator) -> Floats:
    """A fine plateau with crossed grooves of 30 degrees, three to eight plateau rms deep."""
    z = _noise(rng, 10.0)
    y, x = np.mgrid[:POINTS, :POINTS]
    for k in range(10):
        angle = math.radians(30.0 if k % 2 else -30.0)
        place = x * math.cos(angle) + y * math.sin(angle) - rng.uniform(-0.3, 1.3) * POINTS
        z -= rng.uniform(3.0, 8.0) * np.exp(-((place / rng.uniform(3.0, 5.0)) ** 2))
    return z


def _lapped(rng: np.random.Generator) -> Floats:
    """Isotropic waves whose summits are worn softly."""
    z = _noise(rng, 12.0, hurst=0.6)
    return np.asarray(-np.logaddexp(-1.2 * z, -1.2) / 1.2)


def _peened(rng: np.random.Generator) -> Floats:
    """Dimples of balls, each pressed into what was there, over fine waves."""
    z = 0.6 * _noise(rng, 10.0)
    y, x = np.mgrid[:POINTS, :POINTS]
    for _ in range(220):
        a, b, radius = *rng.uniform(0, POINTS, 2), rng.uniform(7.0, 14.0)
        u = (x - a + 0.5 * POINTS) % POINTS - 0.5 * POINTS
        v = (y - b + 0.5 * POINTS) % POINTS - 0.5 * POINTS
        z -= 0.7 * np.maximum(1.0 - (u * u + v * v) / radius**2, 0.0)
    return np.asarray(z + 0.35 * z.std() * _noise(rng, 6.0))


def _eroded(rng: np.random.Generator) -> Floats:
    """Craters of sparks with rims, of many sizes: summits stand out."""
    z = np.zeros((POINTS, POINTS))
    y, x = np.mgrid[:POINTS, :POINTS]
    for _ in range(600):
        a, b, radius = *rng.uniform(0, POINTS, 2), rng.uniform(3.0, 9.0)
        u = (x - a + 0.5 * POINTS) % POINTS - 0.5 * POINTS
        v = (y - b + 0.5 * POINTS) % POINTS - 0.5 * POINTS
        r = np.hypot(u, v) / radius
        z += 0.1 * radius * (1.3 * np.exp(-4.0 * (r - 1.0) ** 2) - np.exp(-2.0 * r * r))
    return z


def _fractal(rng: np.random.Generator) -> Floats:
    """Cosines of random directions with lengths in geometric steps, Hurst exponent 0.75."""
    y, x = np.mgrid[:POINTS, :POINTS]
    z = np.zeros((POINTS, POINTS))
    for length in np.geomspace(8.0, 50.0, 24):
        for angle, phase in rng.uniform(0.0, 2.0 * np.pi, (12, 2)):
            place = x * math.cos(angle) + y * math.sin(angle)
            z += length**0.75 * np.cos(2.0 * np.pi * place / length + phase)
    return z


def _skewed(rng: np.random.Generator) -> Floats:
    """Random waves with a part of their square: Rsk -0.7."""
    z = _noise(rng, 9.0)
    return np.asarray(z - 0.13 * z * z)


def _two_processes(rng: np.random.Generator) -> Floats:
    """A blasted face ground lightly afterwards: the sum of an isotropic face and one with a lay."""
    return np.asarray(_noise(rng, 14.0, hurst=0.9) + 0.5 * _noise(rng, 4.0, 40.0, 0.7))


KINDS: dict[str, tuple[Callable[[np.random.Generator], Floats], float, float]] = {
    "turned": (_turned, 1.6e-6, 0.16), "ground": (_ground, 4e-7, 0.12),
    "milled": (_milled, 1.2e-6, 0.2), "honed": (_honed, 8e-7, 0.2),
    "lapped": (_lapped, 1e-7, 0.06), "shot-peened": (_peened, 2e-6, 0.25),
    "eroded": (_eroded, 3e-6, 0.35), "fractal": (_fractal, 5e-7, 0.1),
    "skewed": (_skewed, 8e-7, 0.15), "blasted, ground": (_two_processes, 1e-6, 0.18),
}  # fmt: skip
"""Generator, Rq [m] and rms gradient of each kind."""


def made(kind: str, seed: int) -> Made:
    """Return a face of a kind, without its mean plane."""
    generator, rms, gradient = KINDS[kind]
    rng = np.random.default_rng([seed, *kind.encode()])
    face = scaled(gaussian_filter(generator(rng), 0.7 * _SHORT, mode="nearest"), rms, gradient)
    if kind != "honed":
        return face
    # Rms of the heights above the grooves, about their median.
    upper = face.heights[face.heights > np.quantile(face.heights, 0.4)]
    plateau = float(1.4826 * np.median(np.abs(upper - np.median(upper)))) / 0.6
    return face._replace(plateau=plateau)


def scaled(z: Floats, rms: float, gradient: float) -> Made:
    """Return heights without their mean plane, scaled to Rq [m] and an rms gradient [-]."""
    place = np.arange(POINTS) - 0.5 * (POINTS - 1)
    z = z - z.mean()
    z = z - (z.mean(0) @ place * place + (z.mean(1) @ place * place)[:, None]) / (place @ place)
    z *= rms / z.std()
    across, along = (math.sqrt(np.mean(np.diff(z, axis=axis) ** 2)) for axis in (1, 0))
    pixel = math.hypot(across, along) / gradient
    steep, lay = max(across, along), min(across, along) / max(across, along)
    return Made(z, pixel, rms, steep / pixel, 1.0 if lay > 0.85 else lay, None)
