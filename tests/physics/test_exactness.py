"""Every exported law under every kind of motion, against one plain reference, to rounding.

The reference is a memory diagram as a list of pieces, one step after the other (scalar_kernels),
with forces as sums of differences of the law's own T0 or N: no table, profile or piece of the
kernels. Sliders in two directions each follow a tractrix in closed form.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from cases import all_laws, is_elastic, reach_of
from scalar_kernels import coupled
from scipy.optimize import brentq

import microslip as ms

MOTIONS = ("history", "varying separation", "periodic", "harmonics", "two directions")
ROUNDING = 2e-13  # of the force limit
MOST_KINKS = 60  # of a law whose harmonics are integrated here
HARMONICS = [0, 1, 3]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


class Plain:
    """A law as a curve: drops of T0 over places from 0, or of N over steps from rest."""

    def __init__(self, law: ms.BackboneLaw, varies: bool = False) -> None:
        self.law, self.surface = law, law.surface if varies else None
        self.scale = law.friction_coefficient if varies else 1.0
        self.slip = law.slip_per_indentation if varies else 1.0
        self.rest = law.separation if varies else 0.0

    def drop(self, base: float, width: float) -> float:
        if self.surface is None:
            backbone = getattr(self.law, "_exact_backbone", self.law._backbone)
            first, last = backbone(np.array([base, base + width])).tolist()
            return float(last - first)
        first = self.rest + base
        return float(self.surface.load(first)) - float(self.surface.load(first + width))

    def force(self, x: Any, d: Any = None) -> np.ndarray:
        """Forces along a record from rest [N]."""
        places = np.asarray(x, dtype=float) / self.slip
        steps = np.zeros(places.size) if d is None else d - self.rest
        return self.scale * np.array(coupled(steps, places, self))  # type: ignore[arg-type]


def record(samples: int, seed: int) -> np.ndarray:
    """Noise, with places that return exactly."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=samples)
    x[7::9], x[8::9] = x[6::9][: x[7::9].size], -x[6::9][: x[8::9].size]
    return x


def history(law: ms.BackboneLaw) -> None:
    x = reach_of(law) * record(60, 1)
    wanted, atol = Plain(law).force(x), ROUNDING * law.force_limit
    np.testing.assert_allclose(law.force(x), wanted, rtol=0, atol=atol)
    state, stepped = law.start(), []
    for place in x.tolist():
        state.try_(-2.0 * place)
        stepped.append(state.try_(place)[0])
        state.commit()
    np.testing.assert_allclose(stepped, wanted, rtol=0, atol=atol)


def varying(law: ms.BackboneLaw) -> None:
    x = reach_of(law) * record(40, 2)
    if not isinstance(law, ms.Interface):
        with pytest.raises(ms.InputError, match="without a surface"):
            law.start().try_(float(x[0]), separation=0.0)
        return
    depth = law.normal_load / law.normal_stiffness
    d = law.separation + depth * np.abs(0.4 * record(40, 3))
    wanted = Plain(law, True).force(x, d)
    # Besides the rounding of forces, that of separations, which a light contact multiplies.
    nearest = float(d.min())
    rounded = np.finfo(float).eps * float(np.abs(d).max()) * float(law.surface.stiffness(nearest))
    limit = law.friction_coefficient * float(law.surface.load(nearest))
    atol = 4.0 * ROUNDING * limit + 8.0 * law.friction_coefficient * rounded
    np.testing.assert_allclose(law.coupled_force(x, separation=d), wanted, rtol=0, atol=atol)
    state, stepped = law.start(), []
    for place, separation in zip(x.tolist(), d.tolist(), strict=True):
        state.try_(-place)
        stepped.append(state.try_(place, separation=separation).force)
        state.commit()
    np.testing.assert_allclose(stepped, wanted, rtol=0, atol=atol)
    area = getattr(law.surface, "area", None)
    if area is None:
        return
    # The whole surface as one node.
    field = ms.JointField(
        law.surface, law.friction_coefficient, areas=[area], separations=[law.separation]
    )
    nodes, stepped = field.start(), []
    for i in range(x.size):
        nodes.try_(-x[i : i + 1])
        stepped.append(float(nodes.try_(x[i : i + 1], d[i : i + 1]).force[0]))
        nodes.commit()
    np.testing.assert_allclose(stepped, wanted, rtol=0, atol=atol)


def periodic(law: ms.BackboneLaw) -> None:
    x = reach_of(law) * record(24, 4)
    wanted = Plain(law).force(np.tile(x, 3))[-24:]
    np.testing.assert_allclose(
        law.periodic(x).force, wanted, rtol=0, atol=2.0 * ROUNDING * law.force_limit
    )


def waves(t: np.ndarray) -> np.ndarray:
    """Functions of the harmonics, one row per time."""
    columns = [np.ones_like(t)]
    for n in HARMONICS[1:]:
        columns += [np.cos(n * t), np.sin(n * t)]
    return np.column_stack(columns)


def harmonics(law: ms.BackboneLaw) -> None:
    """Gauss's rule between all times at which the settled force is not smooth."""
    if law._kinks.size > MOST_KINKS:
        pytest.skip("too many kinks for the reference; test_harmonics.py takes sums of samples")
    c = reach_of(law) * np.array([0.3, 1.1, 0.4, 0.5, -0.7])

    def place(t: float) -> float:
        return float((waves(np.array([t])) @ c)[0])

    def speed(t: float) -> float:
        orders = np.array(HARMONICS[1:])
        even, odd = c[1::2], c[2::2]
        return float((orders * (odd * np.cos(orders * t) - even * np.sin(orders * t))).sum())

    grid = np.linspace(0.013, 0.013 + 2.0 * math.pi, 400)
    turns = [brentq(speed, a, b, xtol=1e-15) for a, b in pairwise(grid) if speed(a) * speed(b) < 0]
    ends = [place(t) for t in turns]
    # The force bends where inner loops close and where a slider of the law begins to slip.
    levels = [*ends, *(-e for e in ends)]
    for kink in law._kinks:
        levels += [-kink, kink, *(e + s * kink for e in ends for s in (-2.0, 2.0))]
    cuts: list[float] = []
    for a, b in pairwise([*turns, turns[0] + 2.0 * math.pi]):
        low, high = sorted((place(a), place(b)))
        inside = [v for v in levels if low < v < high]
        cuts += [a, *sorted(brentq(lambda t, v=v: place(t) - v, a, b, xtol=1e-15) for v in inside)]
    begin, end = np.array(cuts), np.array([*cuts[1:], cuts[0] + 2.0 * math.pi])
    shares = np.linspace(0.0, 1.0, 5)
    edges = np.sin(0.5 * math.pi * shares) ** 2
    low = np.concatenate([begin + share * (end - begin) for share in edges[:-1]])
    high = np.concatenate([begin + share * (end - begin) for share in edges[1:]])
    # Square roots at both ends become smooth in the angle.
    angle = 0.25 * math.pi * (1.0 + NODES)
    t = low[:, None] + (high - low)[:, None] * np.sin(angle) ** 2
    w = (high - low)[:, None] * np.sin(2.0 * angle) * 0.25 * math.pi * WEIGHTS
    t, w = np.append(t.ravel(), turns), np.append(w.ravel(), np.zeros(len(turns)))
    order = np.argsort(np.mod(t, 2.0 * math.pi))
    t, w = t[order], w[order]
    functions = waves(t)
    settled = law.periodic(functions @ c).force  # itself compared above
    wanted = functions.T @ (w * settled) / math.pi
    wanted[0] *= 0.5
    np.testing.assert_allclose(
        law.harmonics(c, HARMONICS, rtol=1e-13).force, wanted, rtol=0, atol=1e-12 * law.force_limit
    )


def dragged(held: complex, step: complex, radius: float) -> complex:
    """The stretch of a slider after a straight step: free inside its circle, then a tractrix."""
    size = abs(step)
    if size == 0.0:
        return held
    way = step / size
    along, across = (held * way.conjugate()).real, (held * way.conjugate()).imag
    free = math.sqrt(max(radius * radius - across * across, 0.0)) - along
    if size <= free:
        return held + step
    angle = math.atan2(across, along + free)
    angle = 2.0 * math.atan(math.tan(0.5 * angle) * math.exp(-(size - free) / radius))
    return radius * complex(math.cos(angle), math.sin(angle)) * way


def two_directions(law: ms.BackboneLaw) -> None:
    if not is_elastic(law):
        pytest.skip("rigid friction has no sliders with springs")
    joint = ms.IsotropicJoint(law, 24)
    sliders = joint.line.sliders()
    tops, springs = sliders.yield_displacements, sliders.stiffnesses
    path = 0.8 * reach_of(law) * np.random.default_rng(5).normal(size=(20, 2))
    held, before, wanted = np.zeros(len(tops), dtype=complex), 0j, []
    for x, y in path:
        step = complex(x, y) - before
        held = np.array([dragged(h, step, r) for h, r in zip(held.tolist(), tops, strict=True)])
        before = complex(x, y)
        total = (springs * held).sum()
        wanted.append((total.real, total.imag))
    atol = 10.0 * ROUNDING * law.force_limit
    np.testing.assert_allclose(joint.force(path), wanted, rtol=0, atol=atol)


CHECKS = dict(zip(MOTIONS, (history, varying, periodic, harmonics, two_directions), strict=True))


@pytest.mark.parametrize("motion", MOTIONS)
@all_laws
def test_every_law_under_every_motion(law: ms.BackboneLaw, motion: str) -> None:
    CHECKS[motion](law)
