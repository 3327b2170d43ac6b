"""Records of joints by brute force: sums over summits, sliders one by one; nothing of the package.

The joint is T0(v) = mu N [1 - n(h + v/k)/n(h)] with n the mean of (z - h)^(3/2) over standardised
heights z, behind a spring; its history is that of parallel sliders, stepped sample by sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import microslip as ms

Floats = NDArray[np.float64]
SUMMITS = 20_000
RATE = 10.0


@dataclass(frozen=True)
class Set:
    """Records of one joint behind a rig, and what made them."""

    kind: str
    records: list[ms.Record]
    truth: dict[str, float]
    options: dict[str, object]


FINE = 960
"""Steps a cycle of the history."""


@dataclass(frozen=True)
class Joint:
    """A joint and its rig; lengths [m], forces [N]."""

    mu: float
    slip_scale: float
    h: float
    """Standardised separation at the reference load."""
    reference: float
    rig: float
    summits: tuple[float, ...] | None = None
    """Standardised heights one by one; a continuum of Gaussian ones without."""

    def moment(self, h: Floats) -> Floats:
        """The mean of (z - h)^(3/2) above h."""
        h = np.atleast_1d(np.asarray(h, dtype=float))
        if self.summits is None:
            # z = h + s^2 takes the root out of the integrand.
            s = np.linspace(0.0, 4.2, 1401)
            z = h[:, None] + s**2
            density = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
            return np.trapezoid(2.0 * s**4 * density, s, axis=1)
        tall = np.array(self.summits)
        tall = tall[tall > h.min()]
        return np.array([np.sum(np.maximum(tall - d, 0.0) ** 1.5) for d in h]) / len(self.summits)

    def separation(self, load: float) -> float:
        """The standardised separation under a load."""
        parent = Joint(self.mu, self.slip_scale, self.h, self.reference, self.rig)
        target = float(parent.moment(np.array([self.h]))[0]) * load / self.reference
        low, high = -6.0, 9.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            if float(self.moment(np.array([middle]))[0]) > target:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def backbone(self, load: float, points: int = 321) -> tuple[Floats, Floats]:
        """Displacement at the transducer and force, rig in series, from rest to gross slip."""
        h = self.separation(load)
        x = 9.0 * np.linspace(0.0, 1.0, points) ** 2
        share = 1.0 - self.moment(h + x) / self.moment(np.array([h]))[0]
        share /= share[-1]
        force = self.mu * load * share
        return x * self.slip_scale + force / self.rig, force


def sphere(mu: float, load: float, slip_limit: float, rig: float) -> tuple[Floats, Floats]:
    """The backbone of one sphere behind a rig: Mindlin."""
    u = slip_limit * np.linspace(0.0, 1.0, 321)
    force = mu * load * (1.0 - np.maximum(1.0 - u / slip_limit, 0.0) ** 1.5)
    return u + force / rig, force


def sliders(backbone: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Stiffnesses and limits of parallel sliders that make a first loading curve."""
    y, force = backbone
    slope = np.append(np.diff(force) / np.diff(y), 0.0)
    stiffness = slope[:-1] - slope[1:]
    keep = stiffness > 0.0
    return stiffness[keep], stiffness[keep] * y[1:][keep]


def respond(x: Floats, backbone: tuple[Floats, Floats], scale: Floats | None = None) -> Floats:
    """Force along a displacement from rest; ``scale`` multiplies all limits at each step."""
    stiffness, limit = sliders(backbone)
    state, force = np.zeros_like(stiffness), np.empty(x.size)
    before = 0.0
    for i, place in enumerate(x):
        bound = limit if scale is None else limit * scale[i]
        state = np.clip(state + stiffness * (place - before), -bound, bound)
        before, force[i] = place, state.sum()
    return force


def respond_rate(x: Floats, backbone: tuple[Floats, Floats], law) -> Floats:  # type: ignore[no-untyped-def]
    """The same, the limits times ``law(velocity)`` where the velocity is a step's."""
    velocity = np.gradient(x)
    velocity /= np.abs(velocity).max()
    return respond(x, backbone, law(velocity))


def motion(cycles: int, amplitude: Floats | float, third: float = 0.0) -> Floats:
    """A history of sines from rest, in fine steps; an amplitude for each cycle, or one for all."""
    turn = np.arange(cycles * FINE + 1) / FINE
    size = np.broadcast_to(np.asarray(amplitude, dtype=float), (cycles,))
    along = np.interp(turn, np.arange(cycles + 1), np.append(size, size[-1]))
    angle = 2.0 * np.pi * turn
    return along * (np.sin(angle) + third * np.sin(3.0 * angle))


def places(size: int, samples: float, phase: float = 0.0) -> Floats:
    """Where samples are taken of a fine history, so many a cycle, from a phase on."""
    return np.arange(phase, size - 1, FINE / samples)


def sampled(values: Floats, samples: float, phase: float = 0.0) -> Floats:
    """Samples of a fine history."""
    return np.interp(places(values.size, samples, phase), np.arange(values.size), values)


def responded(
    x: Floats, backbone: tuple[Floats, Floats], at: Floats, scale: Floats | None = None
) -> Floats:
    """The force at places of a fine history: sliders only have to stop there and at the turns."""
    step = np.diff(x)
    stops = np.union1d(at, np.flatnonzero(step[1:] * step[:-1] <= 0.0) + 1.0)
    stops = stops[stops <= at[-1]]
    grid = np.arange(x.size)
    limits = None if scale is None else np.interp(stops, grid, scale)
    force = respond(np.interp(stops, grid, x), backbone, limits)
    return force[np.searchsorted(stops, at)]
