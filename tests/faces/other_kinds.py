"""Ten more kinds of machined faces, for blind tests of the bands: none served to set an error."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .kinds import POINTS, Floats, Made, scaled

_SHORTEST = 8.0
"""Shortest wave [pixels]."""
_Y, _X = np.mgrid[:POINTS, :POINTS]


def _waves(
    rng: np.random.Generator, longest: float, hurst: float, stretch: float = 1.0, angle: float = 0.0
) -> Floats:
    """Return Gaussian heights of rms 1 whose waves are ``stretch`` times longer across an angle."""
    qx, qy = np.meshgrid(np.fft.rfftfreq(POINTS), np.fft.fftfreq(POINTS))
    along = qx * math.cos(angle) + qy * math.sin(angle)
    across = stretch * (qy * math.cos(angle) - qx * math.sin(angle))
    q = np.hypot(along, across)
    power = (1.0 + (q * longest) ** 2) ** (-1.0 - hurst)
    noise = np.fft.rfft2(rng.standard_normal((POINTS, POINTS)))
    z = np.fft.irfft2(noise * np.sqrt(power), s=(POINTS, POINTS))
    return np.asarray(z / z.std())


def _smoothed(z: Floats) -> Floats:
    """Remove waves shorter than the shortest, by a filter that falls within half an octave."""
    q = np.hypot(np.fft.rfftfreq(2 * POINTS), np.fft.fftfreq(2 * POINTS)[:, None])
    mirrored = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
    found = np.fft.irfft2(np.fft.rfft2(mirrored) * np.exp(-((q * _SHORTEST / 1.1) ** 6)))
    return np.asarray(found[:POINTS, :POINTS])


def _spots(rng: np.random.Generator, count: int, low: float, high: float) -> Floats:
    """Return round spots of height 1, quadratic, of random places and radii [pixels]."""
    z = np.zeros((POINTS, POINTS))
    for _ in range(count):
        (a, b), r = rng.uniform(0, POINTS, 2), rng.uniform(low, high)
        z = np.maximum(z, 1.0 - ((_X - a) ** 2 + (_Y - b) ** 2) / r**2)
    return z


def _planed(rng: np.random.Generator) -> Floats:
    """Asymmetric feed marks with torn flanks."""
    phase = (_X / 32.0 + 0.05 * _waves(rng, 150.0, 0.9)) % 1.0
    saw = np.where(phase < 0.7, phase / 0.7, (1.0 - phase) / 0.3)
    return np.asarray(saw / saw.std() + 0.55 * _waves(rng, 30.0, 0.7, 3.0))


def _rolled(rng: np.random.Generator) -> Floats:
    """Texture of a ground roll, transferred with a soft upper limit, and oil pits."""
    z = np.tanh(0.6 * _waves(rng, 50.0, 0.8, 5.0)) / 0.5
    return np.asarray(z - 1.2 * _spots(rng, 25, 5.0, 9.0))


def _etched(rng: np.random.Generator) -> Floats:
    """Grains at slightly different heights, with fine waves on each."""
    seeds = rng.uniform(0, POINTS, (70, 2))
    grain = np.argmin(
        (_X[..., None] - seeds[:, 0]) ** 2 + (_Y[..., None] - seeds[:, 1]) ** 2, axis=-1
    )
    return np.asarray(rng.standard_normal(70)[grain] + 0.6 * _waves(rng, 20.0, 0.8))


def _printed(rng: np.random.Generator) -> Floats:
    """Tracks of a laser, wavy, with adhering grains of powder."""
    tracks = np.cos(2.0 * np.pi * (_Y / 48.0 + 0.08 * _waves(rng, 60.0, 0.9)))
    return np.asarray(tracks + 1.0 * _waves(rng, 60.0, 0.8) + 0.8 * _spots(rng, 40, 6.0, 10.0))


def _superfinished(rng: np.random.Generator) -> Floats:
    """Shallow scratches of a stone in many directions over a smooth face."""
    z = 0.8 * _waves(rng, 60.0, 1.0)
    for _ in range(90):
        angle, at = rng.uniform(0.0, np.pi), rng.uniform(-0.4, 1.4) * POINTS
        place = _X * math.cos(angle) + _Y * math.sin(angle) - at
        z -= rng.uniform(0.3, 1.0) * np.exp(-((place / rng.uniform(3.0, 6.0)) ** 2))
    return z


def _belt_ground(rng: np.random.Generator) -> Floats:
    """Very long scratches with a slow drift of their depth."""
    return np.asarray(_waves(rng, 40.0, 0.6, 15.0) * (1.0 + 0.3 * _waves(rng, 120.0, 1.0)))


def _electropolished(rng: np.random.Generator) -> Floats:
    """Only the longer waves of a rolled face remain."""
    return np.asarray(_waves(rng, 40.0, 1.6, 1.5))


def _scraped(rng: np.random.Generator) -> Floats:
    """Strokes of a scraper, each a shallow trough turned by about 45 degrees."""
    z = 0.25 * _waves(rng, 40.0, 0.8)
    for k in range(40):
        angle = math.radians(rng.normal(45.0 if k % 2 else -45.0, 8.0))
        a, b = rng.uniform(0, POINTS, 2)
        u = (_X - a) * math.cos(angle) + (_Y - b) * math.sin(angle)
        v = (_Y - b) * math.cos(angle) - (_X - a) * math.sin(angle)
        z -= 0.7 * np.exp(-((u / 40.0) ** 4) - (v / 12.0) ** 2)
    return z


def _reamed(rng: np.random.Generator) -> Floats:
    """Rounded feed marks with chatter along them."""
    chatter = 1.0 + 0.3 * np.cos(2.0 * np.pi * _Y / 70.0 + 1.0)
    marks = np.abs(np.sin(np.pi * _X / 44.0 + 0.15 * _waves(rng, 80.0, 0.9, 0.3))) * chatter
    return np.asarray(marks / marks.std() + 0.6 * _waves(rng, 30.0, 0.8, 6.0))


def _grit_blasted(rng: np.random.Generator) -> Floats:
    """Sharp cuts of angular grit, over each other."""
    z = np.zeros((POINTS, POINTS))
    for _ in range(400):
        (a, b), angle = rng.uniform(0, POINTS, 2), rng.uniform(0.0, 2.0 * np.pi)
        x = (_X - a + 0.5 * POINTS) % POINTS - 0.5 * POINTS
        y = (_Y - b + 0.5 * POINTS) % POINTS - 0.5 * POINTS
        u, v = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
        r = np.hypot(u, 2.0 * v) / rng.uniform(8.0, 22.0)
        z -= rng.uniform(0.5, 1.0) * np.maximum(1.0 - r, 0.0) * (1.0 + 0.5 * np.sign(u))
    return np.asarray(z + 0.5 * z.std() * _waves(rng, 25.0, 0.7))


OTHER_KINDS: dict[str, tuple[Callable[[np.random.Generator], Floats], float, float]] = {
    "planed": (_planed, 2.4e-6, 0.22), "rolled": (_rolled, 6e-7, 0.11),
    "etched": (_etched, 5e-7, 0.15), "printed": (_printed, 5e-6, 0.4),
    "superfinished": (_superfinished, 1e-7, 0.05), "belt-ground": (_belt_ground, 9e-7, 0.18),
    "electropolished": (_electropolished, 3e-7, 0.06), "scraped": (_scraped, 2e-6, 0.12),
    "reamed": (_reamed, 1.2e-6, 0.16), "grit-blasted": (_grit_blasted, 3.5e-6, 0.45),
}  # fmt: skip
"""Generator, Rq [m] and rms gradient of each kind."""


def other(kind: str, seed: int) -> Made:
    """Return a face of a kind, without its mean plane."""
    generator, rms, gradient = OTHER_KINDS[kind]
    z = _smoothed(generator(np.random.default_rng([seed, 41, *kind.encode()])))
    return scaled(z, rms, gradient)
