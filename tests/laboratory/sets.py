"""Sets of records with a known truth, of the kinds that laboratories have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import microslip as ms

from .physics import Floats, Joint, motion, places, responded, sampled

KINDS = (
    "plain",
    "summits",
    "coarse",
    "steps",
    "gaps",
    "running in",
    "moving",
    "never slid",
    "one load",
    "noisy",
    "stiff rig",
    "drifting",
)
SUMMITS = 20_000
RATE = 10.0


@dataclass(frozen=True)
class Set:
    """Records of one joint, and what made them."""

    kind: str
    records: list[ms.Record]
    truth: dict[str, float]
    options: dict[str, object]


def a_set(seed: int, kind: str | None = None) -> Set:
    """The set of a seed."""
    rng = np.random.default_rng([19, seed])
    kind = kind or KINDS[seed % len(KINDS)]
    mu = float(rng.uniform(0.15, 0.8))
    slip_scale = float(np.exp(rng.uniform(np.log(0.1e-6), np.log(1e-6))))
    loads = list(np.geomspace(*np.sort(np.exp(rng.uniform(np.log(200), np.log(5000), 2))), 3))
    if loads[2] < 3.0 * loads[0]:
        loads = [loads[1] / 2.0, loads[1], 2.0 * loads[1]]
    if kind == "one load":
        loads = loads[1:2]
    reference = float(np.exp(np.mean(np.log(loads))))
    h = float(rng.uniform(0.3, 2.2))
    own = 1.8 * mu * reference / slip_scale  # about the stiffness at rest
    rig = own * float(np.exp(rng.uniform(np.log(0.1), np.log(2.0))))
    if kind == "stiff rig":
        rig = own * 8.0
    summits = tuple(rng.normal(size=SUMMITS)) if kind == "summits" else None
    joint = Joint(mu, slip_scale, h, reference, rig, summits)
    noise = float(rng.uniform(0.002, 0.008)) * (5.0 if kind == "noisy" else 1.0)
    samples = float(rng.uniform(40, 100) if kind == "coarse" else rng.uniform(120, 300))
    cycles = int(rng.integers(8, 16))
    records = []
    for load in loads:
        backbone = joint.backbone(load)
        full = float(np.interp(0.98 * backbone[1][-1], backbone[1], backbone[0]))
        reaches = (0.25, 0.45) if kind == "never slid" else (0.35, 2.5)
        for reach in reaches:
            records.append(_record(rng, kind, backbone, reach * full, load, noise, samples, cycles))
    truth = {
        "friction_coefficient": mu,
        "slip_scale": slip_scale,
        "standardised_separation": h,
        "rig_stiffness": rig,
    }
    return Set(kind, records, truth, {"summits": SUMMITS if kind == "summits" else np.inf})


def _record(
    rng: np.random.Generator,
    kind: str,
    backbone: tuple[Floats, Floats],
    amplitude: float,
    load: float,
    noise: float,
    samples: float,
    cycles: int,
) -> ms.Record:
    size: Floats | float = amplitude
    scale: Floats | None = None
    if kind == "steps":
        cycles = 36
        size = amplitude * np.repeat([0.6, 0.8, 1.0], (6, 6, 24))
    if kind == "running in":
        cycles = 80
    if kind == "moving":
        cycles = 40
    x = motion(cycles, size, float(rng.uniform(0.0, 0.05)))
    turn = np.arange(x.size) / (x.size - 1)
    if kind == "running in":
        scale = 1.0 - 0.35 * np.exp(-turn * cycles / 4.0)
    if kind == "moving":
        scale = 1.0 + float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.03, 0.4)) * (turn - 0.5)
    phase = float(rng.uniform(0.0, 400.0))
    force = responded(x, backbone, places(x.size, samples, phase), scale)
    x = sampled(x, samples, phase)
    if kind == "drifting":
        along = np.linspace(-0.5, 0.5, x.size)
        force = force + 0.05 * backbone[1][-1] * along
        x = x + 0.02 * amplitude * along
    x = x + 0.3 * noise * amplitude * rng.normal(size=x.size)
    force = force + noise * backbone[1][-1] * rng.normal(size=x.size)
    rate = samples * RATE
    if kind != "gaps":
        return ms.Record(x, force, normal_load=load, sample_rate=rate)
    time = np.arange(x.size) / rate
    third = x.size // 3
    time[third:] += 7.013
    time[2 * third :] += 61.7
    return ms.Record(x, force, normal_load=load, time=time)
