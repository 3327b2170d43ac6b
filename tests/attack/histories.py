"""Histories with ties, repeats, denormals and huge values, under constant and varying loads."""

from __future__ import annotations

import math
import pickle
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from reference.make_reference import dominant_extremes

import microslip as ms
from microslip.friction import LAWS

from .campaign import Random, Tally, demand
from .joints import random_joint
from .memory_by_rule import ExactContact

HUGE = (1e-320, 1e-300, 1e-30, 1e10, 1e100, 1e300)


@lru_cache
def pool() -> tuple[ms.BackboneLaw, ...]:
    """The examples of every law."""
    return tuple(law for cls in LAWS for law in cls.examples())


def random_law(rng: Random) -> ms.BackboneLaw:
    """One of the examples, or any interface."""
    if rng.random() < 0.15:
        while True:
            try:
                return random_joint(rng)
            except ms.InputError:
                continue
    laws = pool()
    return laws[rng.integers(len(laws))]


def reach_of(law: ms.BackboneLaw) -> float:
    """Displacement at which the first tangent meets the limit; any for a rigid law."""
    stiffness = law.tangential_stiffness
    return law.force_limit / stiffness if math.isfinite(stiffness) else 1e-6


def random_moves(rng: Random, size: int) -> Any:
    """Numbers of order one: eighths that tie, any, repeats, tiny steps and huge ones."""
    kind = rng.integers(5)
    if kind == 0:
        x = rng.integers(-16, 17, size) / 8.0
    elif kind == 1:
        x = rng.uniform(-3.0, 3.0, size)
    elif kind == 2:
        x = np.repeat(rng.uniform(-2.0, 2.0, -(-size // 3)), 3)[:size]
    elif kind == 3:
        x = np.cumsum(rng.choice([1e-17, -1e-17, 1e-12, 0.25, -0.25, 0.0], size))
    else:
        x = rng.integers(-8, 9, size) / 8.0
        x = x + 1e-16 * rng.integers(-2, 3, size)
    if size and rng.random() < 0.1:
        x = x.astype(float)
        x[rng.integers(size)] = rng.choice(HUGE) * rng.choice([-1.0, 1.0])
    return x


def random_size(rng: Random) -> int:
    """Mostly short; a thousandth of them long."""
    if rng.random() < 0.001:
        return int(rng.integers(100_000, 1_000_001))
    return int(rng.choice([0, 1, 2, 3, 5, 8, 13, 40, 300]))


def attack_histories(rng: Random, tally: Tally) -> None:
    """A record at constant load: whole, in pieces, and by searching the whole past."""
    law = random_law(rng)
    x = reach_of(law) * random_moves(rng, random_size(rng))
    tally.attempt(lambda: f"{law!r:.120} force of {x.size}", lambda: answers_rightly(law, x, rng))


def answers_rightly(law: ms.BackboneLaw, x: Any, rng: Random) -> None:
    """Force finite, limited and odd; by pieces the same; short ones by the dominant extremes."""
    force = law.force(x)
    limit = law.force_limit * (1.0 + 1e-12)
    demand(force.shape == x.shape and np.isfinite(force).all(), "force", force[:9], "of", x[:9])
    demand((np.abs(force) <= limit).all(), "force over", limit, "for", x[:9])
    demand(np.array_equal(law.force(-x), -force), "not odd for", x[:9])
    if not 0 < x.size <= 300:
        return
    state = law.start()
    cuts = np.sort(rng.integers(0, x.size + 1, 3))
    pieces = [state.advance(piece) for piece in np.split(x, cuts) if piece.size]
    noise = noise_of(law) * law.force_limit
    demand(np.allclose(np.concatenate(pieces), force, rtol=0, atol=noise), "pieces of", x[:9])
    if x.size > 13:
        return
    for i in range(x.size):
        extremes = dominant_extremes(x[: i + 1].tolist())
        wanted = float(law.backbone(extremes[0]))
        for start, end in pairwise(extremes):
            wanted += 2.0 * float(law.backbone(0.5 * end - 0.5 * start))
        demand(abs(wanted - force[i]) <= 4 * x.size * noise, "force", force[i], "rule", wanted, x)


def noise_of(law: ms.BackboneLaw) -> float:
    """Rounding of a force, of the limit: a last place of the separation costs h^2 of the load."""
    if not isinstance(law, ms.Interface):
        return 1e-13
    return 1e-13 + 1e-15 * abs(law.separation) * law.normal_stiffness / law.normal_load


OPERATIONS = ("try", "try", "commit", "rollback", "copy", "pickle", "advance", "repeat")


def attack_states(rng: Random, tally: Tally) -> None:
    """Operations on a state in any order against the whole record of what was committed."""
    law = random_law(rng)
    varying = isinstance(law, ms.Interface) and rng.random() < 0.4
    tally.attempt(lambda: f"{law!r:.120} state", lambda: stays_on_record(law, varying, rng))


def stays_on_record(law: ms.BackboneLaw, varying: bool, rng: Random) -> None:
    """Force of the state after each operation is that of the record so far."""
    reach, state, open_trial = reach_of(law), law.start(), None
    moved: list[float] = []
    loads: list[float] = []

    def load_now() -> float:
        return float(law.normal_load * rng.choice([0.0, 0.5, 1.0, 1.0, 1.25]))  # type: ignore[attr-defined]

    for _ in range(int(rng.integers(1, 40))):
        operation = rng.choice(OPERATIONS)
        if operation == "try":
            open_trial = (
                float(reach * rng.integers(-16, 17) / 8.0),
                load_now() if varying else None,
            )
            try:
                state.try_(open_trial[0], normal_load=open_trial[1])
            except ms.InputError:  # a load that the surface cannot carry
                open_trial = None
                state.rollback()
        elif operation == "commit" and open_trial is not None:
            state.commit()
            moved.append(open_trial[0])
            loads.append(open_trial[1] or 0.0)
            open_trial = None
        elif operation == "rollback":
            state.rollback()
            open_trial = None
        elif operation == "copy":
            state, left = state.copy(), state
            left.rollback()
            left.try_(9.0 * reach)  # what happens to the other must not matter
            left.commit()
        elif operation == "pickle":
            state = pickle.loads(pickle.dumps(state))
        elif operation == "advance" and not varying:
            chunk = reach * rng.integers(-8, 9, 5) / 4.0
            state.advance(chunk)
            moved += chunk.tolist()
            open_trial = None
        elif operation == "repeat" and open_trial is not None:
            first = state.try_(open_trial[0], normal_load=open_trial[1])[0]
            again = state.try_(open_trial[0], normal_load=open_trial[1])[0]
            demand(first == again, "a trial gave", first, ", again", again)
    if not moved:
        demand(state.force == 0.0, "force", state.force, "at rest")
        return
    if varying:
        wanted = law.coupled_force(moved, normal_load=loads)[-1]  # type: ignore[attr-defined]
        scale = law.friction_coefficient * max(law.normal_load, *loads)  # type: ignore[attr-defined]
    else:
        wanted, scale = law.force(moved)[-1], law.force_limit
    noise = 100 * noise_of(law) * scale
    demand(abs(state.force - wanted) <= noise, "state", state.force, ", record", wanted, ":", moved)


def attack_varying_loads(rng: Random, tally: Tally) -> None:
    """Paths in (separation, displacement), proportional ones first, against the rule itself."""
    joint = varying_joint(rng)
    size = int(rng.choice([1, 2, 3, 5, 8, 20]))
    x = random_moves(rng, size)
    lift = random_moves(rng, size)
    kind = rng.integers(4)
    if kind == 0:  # proportional, so that fronts tie
        lift = x * rng.choice([-1.0, 1.0, 0.5, -2.0])
    elif kind == 1:
        lift = np.abs(lift) * rng.choice([1.0, 20.0, 1e3])
    elif kind == 2:
        lift = np.round(lift * 2.0) / 2.0
    decay = joint.normal_load / joint.normal_stiffness
    displacement = joint.slip_per_indentation * decay * np.clip(x, -1e6, 1e6)
    separation = joint.separation + decay * np.clip(lift, -0.9, 1e6)

    def label() -> str:
        return f"{joint!r:.120} x {displacement.tolist()} d {separation.tolist()}"

    tally.attempt(label, lambda: answers_by_the_rule(joint, displacement, separation))


@lru_cache
def _joints() -> tuple[ms.Interface, ...]:
    return ms.Interface.examples()


def varying_joint(rng: Random) -> ms.Interface:
    """Small sets of summits and spheres, for which the rule is quick to follow exactly."""
    aluminium = ms.Material(69e9, 0.33)
    pair = ms.MaterialPair(aluminium, aluminium)
    kind = rng.integers(3)
    if kind == 0:
        return ms.Interface(ms.SphereOnFlat(pair, 5e-3), 0.55, 10.0)
    if kind == 1:
        heights = 1e-7 * rng.integers(-4, 5, 5)
        surface: Any = ms.GreenwoodWilliamson(
            pair, ms.Discrete(heights), radius=1e-3, density=1e6, area=1e-4
        )
        return ms.Interface(surface, 0.3, separation=float(heights.max() - 3e-7))
    joints = _joints()
    return joints[rng.integers(len(joints))]


def answers_by_the_rule(joint: ms.Interface, x: Any, d: Any) -> None:
    """Forces and losses finite, the losses not negative; both those of an explicit contact."""
    response = joint.coupled_response(x, separation=d)
    force, energy = response.force, response.energy_per_step
    highest = float(np.max(joint.surface.load(np.minimum(d, joint.separation))))
    limit = joint.friction_coefficient * highest
    lengths = np.abs(np.diff(x, prepend=0.0)) + joint.slip_per_indentation * np.abs(
        np.diff(d, prepend=joint.separation)
    )
    scale = limit * np.maximum(lengths, 1e-300)
    demand(np.isfinite(force).all() and np.isfinite(energy).all(), "T", force, "E", energy)
    demand((np.abs(force) <= limit * (1.0 + 1e-12)).all(), "force", force, "over", limit)
    demand((energy >= -1e-13 * scale).all(), "energy", energy)
    demand((energy <= 2.0 * scale * (1.0 + 1e-9)).all(), "energy", energy, "over", scale)
    contact = ExactContact(joint)
    wanted = np.array([contact.step(s, v) for s, v in zip(d.tolist(), x.tolist(), strict=True)])
    worst = float(np.max(np.abs(force - wanted)))
    # After a far move the place is known to the rounding of that move only.
    decay = joint.normal_load / joint.normal_stiffness
    far = max(np.max(np.abs(x)) / joint.slip_per_indentation, np.max(np.abs(d))) / decay
    demand(worst <= (1e-11 + 1e-15 * far) * limit, "force", force, ", by the rule", wanted)
