"""Interfaces over the whole domain that the documentation allows, and what each must be."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from reference import make_reference

import microslip as ms

from .campaign import Random, Tally, demand

LOADS = (1e-6, 1e9)
SPREADS = (1e-12, 0.1)
FRICTION = (1e-6, 1e3)
HEIGHT = (-8.0, 37.0)
DEEPEST = -40.0
EXACT_SHARE = 0.002
"""Share of the joints that are compared with 30 digits, which takes a tenth of a second each."""


def spread_out(rng: Random, low: float, high: float) -> float:
    """A number, evenly spread by its logarithm."""
    return float(10.0 ** rng.uniform(math.log10(low), math.log10(high)))


def random_pair(rng: Random) -> ms.MaterialPair:
    """Two bodies, one of them rigid now and then."""
    first = ms.Material(spread_out(rng, 1e3, 1e13), float(rng.uniform(-0.99, 0.5)))
    if rng.random() < 0.2:
        return ms.MaterialPair(first, ms.Material.rigid())
    return ms.MaterialPair(
        first, ms.Material(spread_out(rng, 1e3, 1e13), float(rng.uniform(-0.99, 0.5)))
    )


def random_joint(rng: Random) -> ms.Interface:
    """Any interface that can be said, held by its load or by its separation."""
    pair, mu = random_pair(rng), spread_out(rng, *FRICTION)
    std = spread_out(rng, *SPREADS)
    held: dict[str, float] = {"normal_load": spread_out(rng, *LOADS)}
    kind = rng.integers(6)
    surface: ms.NormalLaw
    if kind == 0:
        surface = ms.SphereOnFlat(pair, radius=spread_out(rng, 1e-9, 1e3))
    elif kind == 1:
        count = int(rng.integers(1, 40))
        heights = std * rng.standard_normal(count)
        if count > 3:  # ties
            heights[1] = heights[0]
        surface = ms.AsperityPopulation(pair, heights, spread_out(rng, 1e-9, 1e3))
    elif kind == 2:
        count = int(rng.integers(2, 60))
        separation = std * np.cumsum(rng.uniform(0.1, 1.0, count))
        load = spread_out(rng, *LOADS) * (1.0 - separation / separation[-1]) ** rng.uniform(1.1, 4)
        surface = ms.TabulatedNormalLaw(pair, separation, load)
        held = {"normal_load": float(load[0] * rng.uniform(0.01, 0.99))}
    else:
        statistical = ms.Exponential(std) if kind == 3 else ms.Gaussian(std)
        surface = ms.GreenwoodWilliamson(
            pair,
            statistical,
            radius=spread_out(rng, 1e-9, 1e3),
            density=spread_out(rng, 1.0, 1e16),
            area=spread_out(rng, 1e-12, 1e2),
        )
        if kind == 5:
            held = {"separation": std * float(rng.uniform(*HEIGHT))}
    return ms.Interface(surface, mu, **held)


def attack_interfaces(rng: Random, tally: Tally) -> None:
    """One interface, its curves and measures; now and then against 30 digits."""
    label = f"joint of {rng.bit_generator.seed_seq.entropy}"  # type: ignore[attr-defined]
    exact = rng.random() < EXACT_SHARE
    joint = tally.attempt(label, lambda: random_joint(rng))
    if joint is not None:
        tally.attempt(label, lambda: sound(joint, rng))
        if exact:
            tally.attempt(label, lambda: as_with_thirty_digits(joint))


def sound(joint: ms.Interface, rng: Random) -> None:
    """What holds for every joint, at amplitudes from nothing to gross slip."""
    limit, stiffness = joint.force_limit, joint.tangential_stiffness
    demand(0.0 < limit < math.inf and 0.0 < stiffness < math.inf, f"limit {limit}, k {stiffness}")
    # What the last place of a separation far out costs, relative to the load.
    noise = 1e-13 + 1e-15 * abs(joint.separation) * joint.normal_stiffness / joint.normal_load
    reach = limit / stiffness
    x = reach * np.sort(10.0 ** rng.uniform(-9.0, 4.0, 12))
    force, slope = joint.backbone(x), joint.backbone_stiffness(x)
    energy, eta = joint.dissipated_energy(x), joint.loss_factor(x)
    for name, values in (("force", force), ("slope", slope), ("energy", energy), ("eta", eta)):
        demand(np.isfinite(values).all() and (values >= 0.0).all(), name, values)
    demand((force <= limit * (1.0 + noise)).all(), "force over", limit, force)
    demand((np.diff(force) >= -noise * limit).all(), "force falls", force)
    demand((slope <= stiffness * (1.0 + 1e3 * noise)).all(), "slope over", stiffness, slope)
    demand((energy <= 4.0 * x * force * (1.0 + 1e-9)).all(), "energy over its box", energy)
    demand((np.diff(energy) >= -noise * energy[1:]).all(), "energy falls", energy)
    demand((eta <= 4.0 / math.pi * (1.0 + 1e-9)).all(), "eta", eta)
    demand(np.array_equal(joint.backbone(-x), -force), "the backbone is not odd")
    middle = float(rng.uniform(0.05, 0.9)) * float(force[-1])
    place = joint.backbone_displacement(middle)
    demand(abs(joint.backbone(place) - middle) <= 1e3 * noise * limit, f"no inverse of {middle}")


def as_with_thirty_digits(joint: ms.Interface) -> None:
    """Backbone and energy against the program of the reference numbers."""
    surface = joint.surface
    if not isinstance(surface, ms.GreenwoodWilliamson):
        return
    if joint.separation < DEEPEST * surface.heights.spread:
        return  # the program of the reference sums a series there, for a minute and more
    with make_reference.mp.workdps(45):  # the energy is a difference, of small amplitudes above all
        _compare(joint, surface)


def _compare(joint: ms.Interface, surface: ms.GreenwoodWilliamson) -> None:
    """The same, at the precision of the day."""
    case = case_of(joint, surface)
    wanted = make_reference.Interface(case)
    h = abs(joint.separation) * joint.normal_stiffness / joint.normal_load
    tolerance = 1e-12 + 4e-15 * h
    reach = joint.force_limit / joint.tangential_stiffness
    for share in (1e-3, 0.3, 3.0):
        x = share * reach
        for name, got in (("backbone", joint.backbone(x)), ("energy", joint.dissipated_energy(x))):
            exact = float(getattr(wanted, name)(make_reference.mp.mpf(x)))
            demand(abs(got - exact) <= tolerance * exact, f"{name}({x}) {got}, exactly {exact}")


def case_of(joint: ms.Interface, surface: Any) -> dict[str, Any]:
    """A joint as the reference program reads it."""
    bodies = [
        {"rigid": True}
        if math.isinf(body.young_modulus)
        else {"young_modulus": body.young_modulus, "poisson_ratio": body.poisson_ratio}
        for body in (surface.pair.first, surface.pair.second)
    ]
    heights = surface.heights
    named = (
        {"kind": "gaussian", "std": heights.std}
        if isinstance(heights, ms.Gaussian)
        else {"kind": "exponential", "scale": heights.scale}
    )
    return {
        "materials": bodies,
        "heights": named,
        "radius": surface.radius,
        "density": surface.density,
        "area": surface.area,
        "friction_coefficient": joint.friction_coefficient,
        "separation": joint.separation,
    }
