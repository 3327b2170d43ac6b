"""What rigs do to records of a good joint, one imperfection a set: the law is still the law."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

import microslip as ms

from .physics import FINE, RATE, SUMMITS, Floats, Joint, Set, motion, places, responded, sampled

CYCLES = 20


@dataclass
class Signals:
    """The channels of one record on their way to the file."""

    x: Floats
    force: Floats
    load: Floats | float
    samples: float
    """A cycle."""
    time: Floats | None = None
    options: dict[str, object] = field(default_factory=dict)


def _correlated(rng: np.random.Generator, rho: float, count: int) -> Floats:
    """A first-order process of unit variance."""
    values = rng.normal(size=count)
    for i in range(1, count):
        values[i] = rho * values[i - 1] + np.sqrt(1.0 - rho**2) * values[i]
    return values


def _way(kind: str, amplitude: float, cycles: int) -> Floats:
    """The history of displacement from rest."""
    if kind == "ramp":
        return motion(cycles, amplitude * np.linspace(0.7, 1.0, cycles))
    if kind not in ("triangle", "trapezoid"):
        return motion(cycles, amplitude, 0.1 if kind == "third harmonic" else 0.0)
    turn = (np.arange(cycles * FINE + 1) / FINE + 0.25) % 1.0
    triangle = 1.0 - 4.0 * np.abs(turn - 0.5)
    way = triangle if kind == "triangle" else np.clip(1.5 * triangle, -1.0, 1.0)
    return -amplitude * (way - way[0]) if kind == "triangle" else -amplitude * way


def _limits(kind: str, rng: np.random.Generator, turn: Floats) -> Floats | None:
    """Factor on the friction along the history."""
    numbers = np.arange(int(turn[-1]) + 2)
    if kind.startswith("correlated"):
        rho = {"correlated 0.5": 0.5, "correlated 0.9": 0.9, "correlated 0.98": 0.98}[kind]
        return 1.0 + 0.01 * np.interp(turn, numbers, _correlated(rng, rho, numbers.size))
    if kind == "load ripple":
        return 1.0 + 0.02 * np.cos(4.0 * np.pi * turn)
    return None


def _spoilt(kind: str, s: Signals, rng: np.random.Generator, full: float) -> None:
    """Do to the sampled channels what the rig does; ``full`` is the force of gross slip."""
    count = s.x.size
    along, turn = np.linspace(-0.5, 0.5, count), np.arange(count) / s.samples
    size = float(np.abs(s.x).max())
    if kind == "offsets":
        s.x, s.force = s.x + 3.0 * size, s.force + 2.0 * full
    elif kind == "force drift":
        s.force = s.force + 0.1 * full * along
    elif kind == "displacement drift":
        s.x = s.x + 0.05 * size * along
    elif kind == "wandering baseline":
        walk = rng.normal(size=CYCLES + 2).cumsum()
        s.force = s.force + 0.01 * full * np.interp(turn, np.arange(walk.size), walk)
    elif kind == "hum":
        s.force = s.force + 0.01 * full * np.sin(2.0 * np.pi * 5.0173 * turn + rng.uniform(0, 6))
    elif kind == "spikes":
        s.force[rng.integers(0, count, 4)] += full * rng.choice([-3.0, 3.0], 4)
    elif kind == "converter steps":
        for name, largest in (("x", size), ("force", full)):
            step = largest / rng.uniform(200.0, 300.0)  # the plateau lies anywhere on its step
            setattr(s, name, step * np.round(getattr(s, name) / step))
    elif kind == "noisy load":
        s.load = s.load * (1.0 + 0.02 * rng.normal(size=count))
    elif kind == "load swells":
        s.load = s.load * (1.0 + 0.004 * np.sin(turn))
    elif kind == "gain of force":
        s.force = s.force * s.options.pop("gain")  # type: ignore[operator]
        s.options["known"] = {"force_gain": (1.0, 0.02)}
    elif kind == "gain of displacement":
        s.x = s.x * s.options.pop("gain")  # type: ignore[operator]
        s.options["known"] = {"displacement_gain": (1.0, 0.02)}
    elif kind == "jitter":
        step = 1.0 / (s.samples * RATE)
        s.time = step * (np.arange(count) + rng.uniform(-0.2, 0.2, count))
    elif kind in ("bursts", "stops"):
        s.time = np.arange(count) / (s.samples * RATE)
        for at in range(1, 4):
            s.time[int(at * count / 4) :] += (
                (100.0 + 900.0 * at) / RATE if kind == "bursts" else 1.0
            )


IMPERFECTIONS = (
    *("triangle", "trapezoid", "third harmonic", "ramp", "few cycles"),
    *("correlated 0.5", "correlated 0.9", "correlated 0.98", "random heights", "load ripple"),
    *("offsets", "force drift", "displacement drift", "wandering baseline", "hum", "spikes"),
    *("converter steps", "noisy load", "load swells"),
    *("gain of force", "gain of displacement", "jitter", "bursts", "stops", "quiet"),
)
"""What rigs do, by name."""


def an_imperfect_set(kind: str, seed: int) -> Set:
    """Records at three loads and two amplitudes of a good joint on a rig with one imperfection."""
    rng = np.random.default_rng([41, IMPERFECTIONS.index(kind), seed])
    mu = float(rng.uniform(0.2, 0.7))
    slip_scale = float(np.exp(rng.uniform(np.log(0.15e-6), np.log(0.8e-6))))
    loads = (400.0, 1000.0, 2500.0)
    reference = float(np.exp(np.mean(np.log(loads))))
    h = float(rng.uniform(0.3, 2.0))
    rig = 1.8 * mu * reference / slip_scale * float(np.exp(rng.uniform(np.log(0.2), np.log(2.0))))
    heights = tuple(rng.normal(size=SUMMITS)) if kind == "random heights" else None
    joint = Joint(mu, slip_scale, h, reference, rig, heights)
    noise = 0.001 if kind == "quiet" else float(rng.uniform(0.002, 0.006))
    samples = float(rng.uniform(80, 250))
    cycles = {"few cycles": 6, "correlated 0.98": 60, "correlated 0.9": 60}.get(kind, CYCLES)
    gain = float(1.0 + 0.02 * rng.normal())
    records: list[ms.Record] = []
    options: dict[str, object] = {}
    for load in loads:
        backbone = joint.backbone(load)
        full = float(backbone[1][-1])
        slid = float(np.interp(0.98 * full, backbone[1], backbone[0]))
        for reach in (0.4, 2.5):
            x = _way(kind, reach * slid, cycles)
            limits = _limits(kind, rng, np.arange(x.size) / FINE)
            at = places(x.size, samples)
            force = responded(x, backbone, at, limits)
            parts = Signals(sampled(x, samples), force, load, samples)
            if kind.startswith("gain"):
                parts.options["gain"] = gain
            size = float(np.abs(parts.x).max())
            if kind != "converter steps":
                parts.x = parts.x + 0.3 * noise * size * rng.normal(size=parts.x.size)
                parts.force = parts.force + noise * full * rng.normal(size=parts.x.size)
            _spoilt(kind, parts, rng, full)
            rate = None if parts.time is not None else samples * RATE
            record = ms.Record(
                parts.x, parts.force, normal_load=parts.load, time=parts.time, sample_rate=rate
            )
            records.append(record)
            options.update(parts.options)
    truth = {
        "friction_coefficient": mu,
        "slip_scale": slip_scale,
        "standardised_separation": h,
        "rig_stiffness": rig,
    }
    return Set(kind, records, truth, options)
