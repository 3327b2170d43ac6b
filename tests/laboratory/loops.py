"""Records of clean rigs and of faulty ones, by sliders stepped one by one; nothing of the package.

Lengths in m, forces in N. The truth of a record is read from its own loop, noise-free and with
``FINE`` steps a cycle, by the definitions of the columns of `measure`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import microslip as ms

Floats = NDArray[np.float64]

FINE = 2000
LOAD, MU, YIELD = 500.0, 0.5, 2e-6
"""Normal load [N], friction coefficient, and the slip at which sliders yield [m]."""
RATE = 10.0
"""Cycles a second [Hz]."""


def sliders(law: str) -> tuple[Floats, Floats]:
    """Stiffnesses [N/m] and limits [N] of parallel sliders with a limit of ``MU * LOAD`` in all."""
    at = (np.arange(48) + 0.5) / 48
    slips = {
        "jenkins": np.ones(1),
        "coulomb": np.array([0.05]),
        "iwan": 2.0 * at,
        "rough": -np.log1p(-at),
        "power": at**2.5 * 3.0,
        "two": np.array([1.0, 13.5]) / 6.0,
    }[law] * YIELD
    limits = np.full(slips.size, MU * LOAD / slips.size)
    if law in ("iwan", "rough", "power"):
        limits = slips / slips.sum() * MU * LOAD
    if law == "two":
        limits = np.array([0.1, 0.9]) * MU * LOAD
    return limits / slips, limits


def respond(
    x: Floats, law: str, share: Floats | float = 1.0, state: Floats | None = None
) -> Floats:
    """Force of the sliders along a path from rest; ``share`` scales their limits at each step."""
    stiffness, limits = sliders(law)
    scale = np.broadcast_to(share, x.shape)
    force = np.zeros(stiffness.size) if state is None else state
    total = np.empty(x.size)
    steps = np.diff(x, prepend=0.0)
    for i, step in enumerate(steps):
        bound = limits * scale[i]
        force = np.minimum(np.maximum(force + stiffness * step, -bound), bound)
        total[i] = force.sum()
    return total


@dataclass(frozen=True)
class Kind:
    """How a record is made."""

    law: str = "jenkins"
    reach: float = 3.0
    """Amplitude over YIELD."""
    samples: float = 100.0
    """Samples a cycle; a whole number falls on the same phases in all cycles."""
    cycles: int = 12
    noise: float = 0.001
    """Noise of both channels over their amplitudes."""
    drive: str = "sine"
    rig: float = 0.0
    """Stiffness of a rig in series [N/m]; rigid where 0."""
    ramp: float = 0.0
    """Cycles of a run-up of the amplitude."""
    steps: tuple[float, ...] = ()
    """Relative amplitudes of a stepped program."""
    tempo: Callable[[Floats], Floats] | None = None
    """Relative frequency over the turns."""
    wander: float = 0.0
    bits: int = 0
    gap: bool = False
    options: dict[str, object] = field(default_factory=dict)


ODD = 0.37
CLEAN: dict[str, Kind] = {
    "jenkins, 20 samples": Kind(samples=20 + ODD),
    "jenkins, 20 samples in step": Kind(samples=20),
    "jenkins, 50 samples": Kind(samples=50 + ODD),
    "jenkins, 100 samples": Kind(samples=100 + ODD),
    "jenkins, 100 samples, no noise": Kind(noise=0.0),
    "jenkins, 400 samples": Kind(samples=400 + ODD),
    "jenkins, noisy": Kind(samples=100 + ODD, noise=0.02, cycles=40),
    "jenkins, far slip": Kind(reach=12.0, samples=200 + ODD),
    "jenkins, near the limit": Kind(reach=1.3),
    "coulomb": Kind("coulomb", samples=100 + ODD),
    "iwan, 20 samples": Kind("iwan", samples=20 + ODD),
    "iwan, 21 samples in step, no noise": Kind("iwan", samples=21, noise=0.0),
    "iwan, partial slip": Kind("iwan", 1.0, 50 + ODD),
    "iwan, gross slip": Kind("iwan", 5.0),
    "iwan, 300 samples": Kind("iwan", 1.5, 300 + ODD),
    "iwan, little slip": Kind("iwan", 0.3, noise=0.0003),
    "rough, partial slip": Kind("rough", 0.8, 60 + ODD),
    "rough, gross slip": Kind("rough", 6.0, 120 + ODD),
    "power, partial slip": Kind("power", 0.8),
    "two sliders": Kind("two", 9.0, 200 + ODD, noise=0.003),
    "two sliders, 60 samples": Kind("two", 9.0, 60 + ODD),
    "soft rig": Kind("iwan", 3.0, rig=MU * LOAD / (1.5 * YIELD)),
    "triangle": Kind("iwan", 2.0, 150 + ODD, drive="triangle"),
    "noisy triangle": Kind("rough", 1.0, 50 + ODD, noise=0.003, drive="triangle"),
    "saw": Kind("iwan", 2.0, 150 + ODD, drive="saw"),
    "third harmonic": Kind("rough", 3.0, 80 + ODD, drive="third"),
    "long": Kind("iwan", 2.0, 40 + ODD, cycles=200),
    "three cycles of a run-up": Kind("jenkins", 3.0, cycles=4, ramp=1.2),
    "six cycles of a run-up": Kind("iwan", 3.0, cycles=7, ramp=2.0),
    "steps of the amplitude": Kind("iwan", 4.0, cycles=12, steps=(0.2, 0.4, 0.7, 1.0)),
    "chirp": Kind("jenkins", 3.0, 120, cycles=20, tempo=lambda u: 1.0 + 0.3 * u),
    "three frequencies": Kind(
        "iwan",
        3.0,
        400,
        cycles=30,
        tempo=lambda u: np.where(u < 0.33, 0.2, 1.0) * (1 + 3 * (u > 0.66)),
    ),
    "logged in blocks": Kind("iwan", 3.0, 100 + ODD, cycles=18, gap=True),
}
"""Ordinary records: each has to hold 93 % of its intervals."""


def drive(kind: Kind) -> tuple[Floats, Floats]:
    """Time in cycles of nominal frequency, and displacement, with FINE steps a cycle, from rest."""
    turn = np.arange(int((kind.cycles + 0.3) * FINE)) / FINE
    shape = np.sin(2.0 * np.pi * turn)
    if kind.drive == "triangle":
        shape = 2.0 / np.pi * np.arcsin(np.clip(shape, -1.0, 1.0))
    if kind.drive == "saw":
        # Up in four fifths of a cycle, down in the rest.
        part = (turn + 0.4) % 1.0
        shape = np.where(part < 0.8, part / 0.4 - 1.0, 9.0 - part / 0.1)
    if kind.drive == "third":
        shape = shape + 0.05 * np.sin(6.0 * np.pi * turn)
        shape /= np.abs(shape).max()
    size = np.ones(turn.size)
    if kind.ramp:
        size = np.minimum(turn / kind.ramp, 1.0)
    if kind.steps:
        number = (turn * len(kind.steps) / kind.cycles).astype(int)
        size = np.array(kind.steps)[np.minimum(number, len(kind.steps) - 1)]
    time = turn
    if kind.tempo is not None:
        time = np.append(0.0, np.cumsum(1.0 / kind.tempo(turn / turn[-1]))[:-1] / FINE)
    return time, kind.reach * YIELD * size * shape


def truth_of(x: Floats, force: Floats) -> dict[str, float]:
    """Columns of one fine cycle from peak to peak."""
    energy = abs(float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x))))
    amplitude, pushed = 0.5 * float(np.ptp(x)), 0.5 * float(np.ptp(force))
    low = int(np.argmin(x))
    chords = []
    for way, sign in ((slice(0, low + 1), -1.0), (slice(low, None), 1.0)):
        moved, gone = sign * (x[way] - x[way][0]), sign * (force[way] - force[way][0])
        chords.append(float(np.interp(CHORD * 2.0 * pushed, gone, moved)) / (CHORD * 2.0 * pushed))
    return {
        "amplitude": amplitude,
        "force_amplitude": pushed,
        "dissipated_energy": energy,
        "loss_factor": energy / (np.pi * amplitude * pushed),
        "friction_peak": pushed / LOAD,
        "chord_stiffness": 1.0 / float(np.mean(chords)),
    }


CHORD = 0.05
"""Share of the range of the force after a reversal over which the stiffness is a chord."""


def a_record(name: str, seed: int) -> tuple[ms.Record, dict[str, float]]:
    """A record of an ordinary kind and its truth, of the largest amplitude where it steps."""
    kind = CLEAN[name]
    rng = np.random.default_rng([43, list(CLEAN).index(name), seed])
    time, x = drive(kind)
    force = respond(x, kind.law)
    if kind.rig:
        x = x + force / kind.rig
    last = (kind.cycles - 2) * FINE
    last += int(np.argmax(x[last : last + FINE]))
    truth = truth_of(x[last : last + FINE + 1], force[last : last + FINE + 1])
    x, force, at = sampled(kind, time, x, force, float(rng.uniform(0.0, 1.0)))
    return noisy(kind, rng, x, force, at), truth


def sampled(
    kind: Kind, time: Floats, x: Floats, force: Floats, phase: float
) -> tuple[Floats, Floats, Floats]:
    """Displacement, force and time in cycles at the samples."""
    at = (np.arange(int((time[-1]) * kind.samples)) + phase) / kind.samples
    at = at[at <= time[-1]]
    return np.interp(at, time, x), np.interp(at, time, force), at


def noisy(kind: Kind, rng: np.random.Generator, x: Floats, force: Floats, at: Floats) -> ms.Record:
    """The record with its noise, and gaps if it has some."""
    size = 0.5 * np.ptp(x), 0.5 * np.ptp(force)
    x = x + kind.noise * size[0] * rng.normal(size=x.size)
    force = force + kind.noise * size[1] * rng.normal(size=x.size)
    time = at / RATE
    if kind.gap:
        third = x.size // 3
        time = time + 7.3 * (np.arange(x.size) >= third) + 11.1 * (np.arange(x.size) >= 2 * third)
    return ms.Record(x, force, normal_load=LOAD, time=time)


# -- faults ---------------------------------------------------------------------------------------


def _velocity(x: Floats) -> Floats:
    """Velocity over the amplitude and the angular frequency [-]."""
    return np.gradient(x) * FINE / (2.0 * np.pi) / np.abs(x).max()


def _backlash(x: Floats, gap: float) -> Floats:
    seen, at = np.empty(x.size), 0.0
    for i, place in enumerate(x):
        at = min(max(at, place - gap), place + gap)
        seen[i] = at
    return seen


def _bristle(x: Floats, viscous: float, static: float, sigma: float) -> Floats:
    """Dahl and LuGre by small steps of their bristle."""
    z, out, limit = 0.0, np.empty(x.size), MU * LOAD
    v = np.gradient(x)
    for i, step in enumerate(v):
        g = limit * (1.0 + static * np.exp(-((abs(_V * step) / 0.1) ** 2)))
        for _ in range(8):
            z += step / 8.0 * (1.0 - sigma * z * np.sign(step) / g)
        out[i] = sigma * z + viscous * limit * _V * step
    return out


_V = FINE / (2.0 * np.pi) / (3.0 * YIELD)
_TOP = 3.0 * YIELD
TURN = np.arange(int(16.3 * FINE)) / FINE


def _saw(force: Floats, height: float) -> Floats:
    limit = np.abs(force).max()
    saw = height * limit * ((TURN[: force.size] * 23.0) % 1.0)
    return force - np.sign(force) * np.where(np.abs(force) > 0.9 * limit, saw, 0.0)


def _low_pass(force: Floats, share: float) -> Floats:
    out, at = np.empty_like(force), 0.0
    for i, value in enumerate(force):
        at += (value - at) / (share * FINE)
        out[i] = at
    return out


def _spiky(rng: np.random.Generator, force: Floats) -> Floats:
    out = force.copy()
    for place in rng.integers(FINE, force.size - FINE, 8):
        out[place - 10 : place + 11] += 2.0 * MU * LOAD
    return out


def _clearance(x: Floats, gap: float) -> Floats:
    """Sliders that a dead zone of ``2 gap`` about zero displacement of the slot separates."""
    stiffness, limit, free = 1.25e8, MU * LOAD, np.zeros(x.size)
    at = 0.0
    for i, place in enumerate(x):
        # The pin drives the slider by the walls of its slot; the slider slips at its limit.
        away = place - at
        pushed = stiffness * (abs(away) - gap) * np.sign(away) if abs(away) > gap else 0.0
        if abs(pushed) > limit:
            at += np.sign(pushed) * (abs(pushed) - limit) / stiffness
            pushed = np.sign(pushed) * limit
        free[i] = pushed
    return free


FAULTS: dict[str, tuple[Callable[..., tuple[Floats, Floats]], tuple[str, ...]]] = {
    "backlash of the sensor": (
        lambda r, x: (x, respond(_backlash(x, 0.4 * YIELD), "iwan")),
        ("lost motion",),
    ),
    "clearance": (lambda r, x: (x, _clearance(x, 0.8 * YIELD)), ("clearance",)),
    "converter steps of force": (lambda r, x: (x, respond(x, "iwan")), ("converter",)),
    "converter steps of displacement": (lambda r, x: (x, respond(x, "iwan")), ("converter",)),
    "unequal directions": (
        lambda r, x: (x, respond(x, "iwan", 1.0 + 0.2 * np.sign(np.gradient(x)))),
        ("direction",),
    ),
    "load at twice the frequency": (
        lambda r, x: (
            x,
            respond(x, "iwan", 1.0 + 0.25 * np.cos(4.0 * np.pi * TURN[: x.size] - 1.2)),
        ),
        ("load",),
    ),
    "load at the frequency": (
        lambda r, x: (x, respond(x, "iwan", 1.0 + 0.25 * x / _TOP)),
        ("load",),
    ),
    "offset of the force": (lambda r, x: (x, respond(x, "iwan") + 0.4 * MU * LOAD), ("offset",)),
    "Dahl": (lambda r, x: (x, _bristle(x, 0.0, 0.0, 1.25e8)), ()),
    "LuGre": (lambda r, x: (x, _bristle(x, 0.05, 0.3, 1.25e8)), ("rate", "viscous")),
    "stick-slip": (lambda r, x: (x, _saw(respond(x, "iwan"), 0.25)), ("stick-slip",)),
    "two specimens": (
        lambda r, x: (x, respond(x, "iwan", np.where(TURN[: x.size] < 8.1, 1.0, 1.3))),
        ("settled", "changes"),
    ),
    "viscous force": (
        lambda r, x: (x, respond(x, "iwan") + 0.4 * MU * LOAD * _velocity(x)),
        ("viscous",),
    ),
    "inertia": (lambda r, x: (x, respond(x, "iwan") - 0.5 * MU * LOAD * x / _TOP), ("inertia",)),
    "parallel spring": (
        lambda r, x: (x, respond(x, "jenkins") + 0.6 * MU * LOAD * x / _TOP),
        ("parallel",),
    ),
    "delay": (lambda r, x: (x, np.roll(respond(x, "iwan"), FINE // 50)), ("delay",)),
    "slow amplifier": (lambda r, x: (x, _low_pass(respond(x, "iwan"), 0.02)), ("delay", "filter")),
    "spikes": (lambda r, x: (x, _spiky(r, respond(x, "iwan"))), ("spike",)),
    "clipped force": (lambda r, x: (x, respond(x, "iwan")), ("clipped",)),
    "clipped displacement": (lambda r, x: (x, respond(x, "iwan")), ("clipped",)),
    "drift of the force": (
        lambda r, x: (x, respond(x, "iwan") + 0.04 * MU * LOAD * TURN[: x.size]),
        ("drift",),
    ),
    "drift of the displacement": (
        lambda r, x: (x + 0.03 * _TOP * TURN[: x.size], respond(x, "iwan")),
        ("drift",),
    ),
    "wrong sign": (lambda r, x: (x, -respond(x, "iwan")), ("sign", "wrong direction")),
    "swapped columns": (
        lambda r, x: (respond(x, "iwan") * 1e-8, x * 1e8),
        ("swapped", "wrong direction"),
    ),
    "millimetres for micrometres": (lambda r, x: (x * 1e6, respond(x, "iwan")), ("unit",)),
    "running in": (
        lambda r, x: (x, respond(x, "iwan", 0.6 + 0.4 * (1.0 - np.exp(-TURN[: x.size] / 4.0)))),
        ("settled", "moves"),
    ),
    "wear out": (
        lambda r, x: (x, respond(x, "iwan", 1.0 - 0.02 * TURN[: x.size])),
        ("settled", "moves"),
    ),
    "white noise": (lambda r, x: (_hum(r, x), _hum(r, x) * 1e8), ("cyclic",)),
    "dead force": (lambda r, x: (x, np.full(x.size, 3.0)), ("vary",)),
    "gain jump": (
        lambda r, x: (x, respond(x, "iwan") * np.where(TURN[: x.size] < 9.4, 1.0, 1.25)),
        ("settled", "changes"),
    ),
    "crosstalk": (
        lambda r, x: (x + 0.3 * _TOP * respond(x, "iwan") / (MU * LOAD), respond(x, "iwan")),
        (),
    ),
    "bent sensor": (lambda r, x: (x + 0.2 * x * (x / _TOP) ** 2, respond(x, "iwan")), ()),
    "amplitude that ramps": (
        lambda r, x: (x * TURN[: x.size] / 16.3, respond(x * TURN[: x.size] / 16.3, "iwan")),
        ("amplitude",),
    ),
}
"""What makes each fault, and the words of which one names it; none where one record cannot."""


AFTER: dict[str, Callable[[Floats, Floats], tuple[Floats, Floats]]] = {
    "converter steps of force": lambda x, f: (x, 50.0 * np.round(f / 50.0)),
    "converter steps of displacement": lambda x, f: (0.1 * _TOP * np.round(x / 0.1 / _TOP), f),
    "clipped force": lambda x, f: (x, np.clip(f, -200.0, 200.0)),
    "clipped displacement": lambda x, f: (np.clip(x, -0.85 * _TOP, 0.85 * _TOP), f),
    "dead force": lambda x, f: (x, np.full(f.size, 3.0)),
}
"""What acts on the noisy channels."""


def _hum(rng: np.random.Generator, x: Floats) -> Floats:
    """Noise of a band about the frequency, as a low-pass filter leaves it."""
    rough = rng.normal(size=x.size // 250 + 4)
    return _TOP * np.interp(np.arange(x.size) / 250, np.arange(rough.size), rough)


CAUSES = {
    "delay": ("by a delay", "delay=", "lags behind"),
    "clipped": ("a clipped sensor",),
    "drift": ("drifts by",),
    "spike": ("spike",),
    "wear": ("as in running in or wear",),
    "clearance": ("clearance",),
    "lost motion": ("lost motion",),
    "parallel": ("in parallel",),
    "viscous": ("viscous",),
    "rig": ("mostly of the rig",),
    "sign": ("opposite sign",),
    "unit": ("units right",),
    "load": ("normal load ripples",),
    "offset": ("offset",),
    "stick-slip": ("stick-slip",),
    "direction": ("directions differ",),
    "converter": ("lies on a converter",),
}
"""Words of a note by which it names a cause as certain; "cause not determined" names none."""


def a_fault(name: str, seed: int) -> tuple[ms.Record, tuple[str, ...]]:
    """A record with a fault, and the words that would name it."""
    make, words = FAULTS[name]
    rng = np.random.default_rng([34, list(FAULTS).index(name), seed])
    kind = Kind("iwan", 3.0, 100 + ODD, cycles=16)
    time, x = drive(kind)
    x, force = make(rng, x)
    x, force, at = sampled(kind, time, x, force, float(rng.uniform(0.0, 1.0)))
    x = x + 0.001 * 0.5 * np.ptp(x) * rng.normal(size=x.size)
    force = force + 0.001 * 0.5 * np.ptp(force) * rng.normal(size=x.size)
    if name in AFTER:
        x, force = AFTER[name](x, force)
    return ms.Record(x, force, normal_load=LOAD, time=at / RATE), words
