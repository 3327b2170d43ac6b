"""Sensitivities d ln answer / d ln input of an interface."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from microslip._core.errors import InputError
from microslip.contact import DrawnFace, MeasuredContact, NormalLaw
from microslip.contact.heights import Discrete, HeightDistribution
from microslip.contact.materials import Material, MaterialPair
from microslip.contact.rough import RoughSurface
from microslip.friction.interface import Interface

_STEP = 0.02
"""Half of the logarithm over which a slope is taken: its error is of the order of its square."""

_ELASTIC = 1e15
"""Hardness [Pa] of a face that does not yield."""

_SCALED = {
    "radius": "radius",
    "radii": "radii",
    "density": "density",
    "summit_count": "density",
    "copies": "copies",
    "yield_stress": "yield_stress",
    "tightening_load": "tightening_load",
}
"""Parameters of surfaces that are numbers of their own, and as what they count: all summits of a
tightened surface are their density at the same area, which counts as the density does."""


def input_slopes(joint: Interface, amplitude: float) -> dict[str, dict[str, float]]:
    """Slopes d ln/d ln [-] of stiffness and loss factor, at an amplitude [m], over each input.

    By central differences over four per cent, the steepest first. Of a surface that is a table only
    friction and load are inputs; one that was tightened is tightened anew. Modulus, hardness and
    heights of a measured face count as those of the Gaussian face with its Rq, slope and stiffness.
    """
    slopes_of: dict[str, dict[str, float]] = {"tangential_stiffness": {}, "loss_factor": {}}
    for name, scaled in _inputs(joint).items():
        try:
            ends = [scaled(math.exp(sign * _STEP)) for sign in (-1.0, 1.0)]
        except InputError:  # such as a load beyond what the summits carry
            continue
        for quantity, values in (
            ("tangential_stiffness", [end.tangential_stiffness for end in ends]),
            ("loss_factor", [float(end.loss_factor(amplitude)) for end in ends]),
        ):
            if min(values) > 0.0 and math.isfinite(max(values)):
                slopes_of[quantity][name] = math.log(values[1] / values[0]) / (2.0 * _STEP)
    return {
        quantity: dict(sorted(slopes.items(), key=lambda pair: -abs(pair[1])))
        for quantity, slopes in slopes_of.items()
    }


def _inputs(joint: Interface) -> dict[str, Callable[[float], Interface]]:
    """Inputs by name, each with the joint in which that input is multiplied by a factor."""
    surface, mu, load = joint.surface, joint.friction_coefficient, joint.normal_load

    def on(law: NormalLaw) -> Interface:
        return Interface(law, mu, normal_load=load)

    inputs: dict[str, Callable[[float], Interface]] = {
        "friction_coefficient": lambda f: Interface(surface, mu * f, normal_load=load),
        "normal_load": lambda f: joint.at(normal_load=load * f),
    }
    if isinstance(surface, RoughSurface):
        names = {"heights": "rms", "young_modulus": "pair", "hardness": "hardness"}
        names |= {name: name for name in ("roll_off", "shortest", "hurst")}
        if surface.hardness is None:
            del names["hardness"]
        return inputs | {
            input_name: lambda f, name=name: on(_scaled(surface, name, f))
            for input_name, name in names.items()
        }
    if isinstance(surface, MeasuredContact):
        return inputs | {
            name: lambda f, name=name: Interface(_like(joint, name, f), mu, normal_load=load)
            for name in ("young_modulus", "hardness", "heights")
            if name != "hardness" or surface.numbers.hardness is not None
        }
    if isinstance(surface, DrawnFace):
        names = {"heights": "rms", "rms_slope": "slope", "tightening_load": "tightening_pressure"}
        names |= {"young_modulus": "pair", "hardness": "hardness"}
        return inputs | {
            input_name: lambda f, name=name: on(_scaled(surface, name, f))
            for input_name, name in names.items()
        }
    parameters: set[str] = set()
    if is_dataclass(surface):
        parameters = {field.name for field in fields(surface)}
    if not parameters & {"radius", "radii"}:
        return inputs

    names = {"young_modulus": "pair"} | {
        counts_as: name for name, counts_as in _SCALED.items() if name in parameters
    }
    if "heights" in parameters:
        names["heights"] = "heights"
    for input_name, name in names.items():
        inputs[input_name] = lambda f, name=name: on(_scaled(surface, name, f))  # type: ignore[misc]
    return inputs


@lru_cache(maxsize=32)
def _scaled(surface: Any, name: str, factor: float) -> NormalLaw:
    """A surface with one of its parameters times a factor; made once for all loads of a study."""
    if name == "pair":
        changes: dict[str, Any] = {"pair": _stiffer(surface.pair, factor)}
    elif name == "heights":
        changes = _higher(surface, factor)
    elif name == "hardness":
        changes = {"pair": surface.pair.with_hardness(factor * surface.pair.hardness)}
    else:
        changes = {name: getattr(surface, name) * factor}
    law: NormalLaw = replace(surface, **changes)
    return law


def _like(joint: Interface, name: str, factor: float) -> DrawnFace:
    """Return the Gaussian face like a measured one, with one of its inputs times a factor.

    It has the rms height, slope and tightening of the measured face, and by a factor its stiffness,
    so that the slopes of the measured face need no second solution of the scan.
    """
    surface: Any = joint.surface
    numbers, pair = surface.numbers, surface.pair
    pair = pair.with_hardness(numbers.hardness or _ELASTIC)
    face = DrawnFace(
        pair, numbers.rms, numbers.slope / math.sqrt(2.0), surface.area, numbers.pressure
    )
    alike = Interface(face, joint.friction_coefficient, normal_load=joint.normal_load)
    stiffness = joint.normal_stiffness / alike.normal_stiffness
    changes: dict[str, Any] = {"stiffness_factor": stiffness}
    if name == "heights":
        changes |= {"rms": face.rms * factor, "slope": face.slope * factor}
    elif name == "hardness":
        changes["pair"] = pair.with_hardness(pair.hardness * factor)
    else:
        changes["pair"] = _stiffer(pair, factor)
    return face._changed(**changes)


def _stiffer(pair: MaterialPair, factor: float) -> MaterialPair:
    bodies = (
        body
        if body.is_rigid
        else Material(factor * body.young_modulus, body.poisson_ratio, body.hardness)
        for body in (pair.first, pair.second)
    )
    return MaterialPair(*bodies)


def _higher(surface: Any, factor: float) -> dict[str, Any]:
    """All heights times a factor, their spread that is."""
    heights = surface.heights
    if isinstance(heights, Discrete):
        heights = Discrete(factor * np.asarray(heights.values))
    elif isinstance(heights, HeightDistribution):
        heights = heights._scaled(factor)
    else:
        heights = heights * factor
    changes = {"heights": heights}
    if hasattr(surface, "highest"):
        changes["highest"] = surface.highest * factor
    return changes
