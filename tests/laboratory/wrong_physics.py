"""Records of joints and rigs that are not what a law takes them for, each in a way of its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import microslip as ms

from .physics import FINE, RATE, Floats, Joint, Set, motion, respond, respond_rate, sampled

Wrong = Callable[[np.random.Generator, Floats, Floats, tuple[Floats, Floats], float], "Pair"]
Pair = tuple[Floats, Floats]


def _cycle(x: Floats) -> Floats:
    return np.arange(x.size) / FINE


def _wear_in(rng, x, force, backbone, load):
    turn = _cycle(x)
    return x, respond(x, backbone, 0.7 + 0.3 * turn / turn[-1])


def _wear_out(rng, x, force, backbone, load):
    turn = _cycle(x)
    return x, respond(x, backbone, 1.15 - 0.3 * turn / turn[-1])


def _stribeck(rng, x, force, backbone, load):
    return x, respond_rate(x, backbone, lambda v: 1.0 + 0.15 * np.exp(-np.abs(v) / 0.2))


def _strengthening(rng, x, force, backbone, load):
    return x, respond_rate(x, backbone, lambda v: 0.85 + 0.15 * np.abs(v))


def _play(rng, x, force, backbone, load):
    gap, seen = 0.15 * np.ptp(x) / 2.0, np.empty(x.size)
    at = 0.0
    for i, place in enumerate(x):
        at = min(max(at, place - gap), place + gap)
        seen[i] = at
    return x, respond(seen, backbone)


def _asymmetric(rng, x, force, backbone, load):
    way = np.sign(np.gradient(x))
    return x, respond(x, backbone, 1.0 + 0.12 * way)


def _bouc_wen(rng, x, force, backbone, load):
    y, first = backbone
    stiff, limit = first[1] / y[1], first[-1]
    z, out = 0.0, np.empty(x.size)
    for i, step in enumerate(np.diff(x, prepend=0.0)):
        for _ in range(4):
            z += (
                0.25
                * step
                * stiff
                * (1.0 - 0.5 * (np.sign(step * z) + 1.0) * abs(z / limit) ** 0.6)
            )
        out[i] = z
    return x, out


def _clipped_force(rng, x, force, backbone, load):
    top = 0.9 * np.abs(force).max()
    return x, np.clip(force, -top, top)


def _clipped_displacement(rng, x, force, backbone, load):
    top = 0.85 * np.abs(x).max()
    return np.clip(x, -top, top), force


def _gain_jump(rng, x, force, backbone, load):
    return x, force * np.where(_cycle(x) < 0.6 * _cycle(x)[-1], 1.0, 1.2)


def _gain_jump_of_displacement(rng, x, force, backbone, load):
    return x * np.where(_cycle(x) < 0.6 * _cycle(x)[-1], 1.0, 1.15), force


def _parallel_spring(rng, x, force, backbone, load):
    return x, force + 0.15 * backbone[1][-1] / np.abs(x).max() * x


def _inertia(rng, x, force, backbone, load):
    acceleration = np.gradient(np.gradient(x)) * (FINE / 2.0 / np.pi) ** 2
    return x, force + 0.08 * backbone[1][-1] / np.abs(x).max() * acceleration


def _viscous(rng, x, force, backbone, load):
    velocity = np.gradient(x) * FINE / 2.0 / np.pi
    return x, force + 0.12 * backbone[1][-1] / np.abs(x).max() * velocity


def _delay(rng, x, force, backbone, load):
    return x, np.roll(force, FINE // 60)


def _slow_amplifier(rng, x, force, backbone, load):
    out, rate = np.empty_like(force), 1.0 / (0.012 * FINE)
    at = 0.0
    for i, value in enumerate(force):
        at += rate * (value - at)
        out[i] = at
    return x, out


def _rippling_load(rng, x, force, backbone, load):
    return x, respond(x, backbone, 1.0 + 0.15 * np.cos(4.0 * np.pi * _cycle(x)))


def _tilted(rng, x, force, backbone, load):
    return x, respond(x, backbone, 1.0 + 0.2 * x / np.abs(x).max())


def _two_patches(rng, x, force, backbone, load):
    y, first = backbone
    return x, 0.5 * respond(x, (0.3 * y, first)) + 0.5 * respond(x, (3.0 * y, first))


def _crosstalk(rng, x, force, backbone, load):
    return x + 0.15 * np.abs(x).max() / backbone[1][-1] * force, force


def _bent_sensor(rng, x, force, backbone, load):
    top = np.abs(x).max()
    return x + 0.12 * x * (x / top) ** 2, force


def _bent_force(rng, x, force, backbone, load):
    top = backbone[1][-1]
    return x, force * (1.0 - 0.12 * (force / top) ** 2)


def _hardening_rig(rng, x, force, backbone, load):
    y, first = backbone
    return x, respond(x, (y + 0.4 * y[-1] * (first / first[-1]) ** 3 * 0.3, first))


def _stick_slip(rng, x, force, backbone, load):
    limit = backbone[1][-1]
    saw = 0.12 * limit * ((_cycle(x) * 23.0) % 1.0)
    return x, force - np.sign(force) * np.where(np.abs(force) > 0.9 * limit, saw, 0.0)


def _wandering(rng, x, force, backbone, load):
    knots = rng.normal(size=int(_cycle(x)[-1]) + 2).cumsum()
    drift = np.interp(_cycle(x), np.arange(knots.size), knots)
    return x, respond(x, backbone, 1.0 + 0.04 * drift / max(np.abs(knots).max(), 1e-9))


def _coarse_converter(rng, x, force, backbone, load):
    step = 0.25 * backbone[1][-1]
    return x, step * np.round(force / step)


def _static_peak(rng, x, force, backbone, load):
    limit = backbone[1][-1]
    share = np.abs(respond(x, backbone)) / limit
    return x, force * (1.0 + 0.12 * np.exp(-(((share - 0.85) / 0.06) ** 2)))


def _changing_load(rng, x, force, backbone, load):
    return x, respond(x, backbone, 1.0 + 0.1 * np.sin(2.0 * np.pi * _cycle(x) / 7.0))


WRONG: dict[str, Wrong] = {
    function.__name__[1:].replace("_", " "): function
    for function in (
        _wear_in,
        _wear_out,
        _stribeck,
        _strengthening,
        _play,
        _asymmetric,
        _bouc_wen,
        _clipped_force,
        _clipped_displacement,
        _gain_jump,
        _gain_jump_of_displacement,
        _parallel_spring,
        _inertia,
        _viscous,
        _delay,
        _slow_amplifier,
        _rippling_load,
        _tilted,
        _two_patches,
        _crosstalk,
        _bent_sensor,
        _bent_force,
        _hardening_rig,
        _stick_slip,
        _wandering,
        _coarse_converter,
        _static_peak,
        _changing_load,
    )
}
"""What may be wrong, by name."""


def a_wrong_set(name: str, seed: int) -> Set:
    """Records at three loads and two amplitudes of a joint or rig with something wrong."""
    rng = np.random.default_rng([27, list(WRONG).index(name), seed])
    mu = float(rng.uniform(0.2, 0.7))
    slip_scale = float(np.exp(rng.uniform(np.log(0.15e-6), np.log(0.8e-6))))
    loads = (400.0, 1000.0, 2500.0)[: int(rng.choice([1, 3]))]
    reference = float(np.exp(np.mean(np.log(loads))))
    h = float(rng.uniform(0.3, 2.0))
    rig = 1.8 * mu * reference / slip_scale * float(np.exp(rng.uniform(np.log(0.2), np.log(2.0))))
    joint = Joint(mu, slip_scale, h, reference, rig)
    noise = float(rng.uniform(0.002, 0.006))
    samples = float(rng.uniform(80, 250))
    cycles = 24
    records = []
    for load in loads:
        backbone = joint.backbone(load)
        full = float(np.interp(0.98 * backbone[1][-1], backbone[1], backbone[0]))
        for reach in (0.4, 2.5):
            x = motion(cycles, reach * full)
            x, force = WRONG[name](rng, x, respond(x, backbone), backbone, load)
            x, force = sampled(x, samples), sampled(force, samples)
            if name != "clipped displacement":
                x = x + 0.3 * noise * reach * full * rng.normal(size=x.size)
            if name not in ("clipped force", "coarse converter"):
                force = force + noise * backbone[1][-1] * rng.normal(size=x.size)
            record = ms.Record(x, force, normal_load=load, sample_rate=samples * RATE)
            records.append(record)
    truth = {
        "friction_coefficient": mu,
        "slip_scale": slip_scale,
        "standardised_separation": h,
        "rig_stiffness": rig,
    }
    return Set(name, records, truth, {})
