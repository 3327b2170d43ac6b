"""Which inputs an answer depends on: slopes d ln answer / d ln input of an interface."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from microslip.errors import InputError
from microslip.friction.interface import Interface
from microslip.heights import Discrete, HeightDistribution
from microslip.materials import Material, MaterialPair
from microslip.normal import NormalLaw
from microslip.normal.persson import PerssonSurface

_STEP = 0.02
"""Half of the logarithm over which a slope is taken: its error is of the order of its square."""

_SCALED = ("radius", "radii", "density", "copies")
"""Parameters of surfaces that are numbers of their own; the area counts as the density does."""


def input_slopes(joint: Interface, amplitude: float) -> dict[str, dict[str, float]]:
    """Slopes d ln/d ln [-] of stiffness and loss factor, at an amplitude [m], over each input.

    By central differences over four per cent, the steepest first. Of a surface that is a table or
    was tightened only friction and load are inputs.
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
    """Of each input the joint with that input multiplied by a factor."""
    surface, mu, load = joint.surface, joint.friction_coefficient, joint.normal_load

    def on(law: NormalLaw) -> Interface:
        return Interface(law, mu, normal_load=load)

    inputs: dict[str, Callable[[float], Interface]] = {
        "friction_coefficient": lambda f: Interface(surface, mu * f, normal_load=load),
        "normal_load": lambda f: joint.at(normal_load=load * f),
    }
    if isinstance(surface, PerssonSurface):
        curve = surface.curve
        inputs["heights"] = lambda f: on(
            replace(curve, spectrum=f * f * np.asarray(curve.spectrum)).to_surface()
        )
        inputs["young_modulus"] = lambda f: on(
            replace(curve, pair=_stiffer(surface.pair, f)).to_surface()
        )
    parameters: set[str] = set()
    if is_dataclass(surface):
        parameters = {field.name for field in fields(surface)}
    if not parameters & {"radius", "radii"} or "tightening_load" in parameters:
        return inputs

    def changed(**values: Any) -> NormalLaw:
        law: NormalLaw = replace(surface, **values)  # type: ignore[type-var]
        return law

    inputs["young_modulus"] = lambda f: on(changed(pair=_stiffer(surface.pair, f)))
    for name in _SCALED:
        if name in parameters:
            value = getattr(surface, name)
            inputs[name] = lambda f, name=name, value=value: on(  # type: ignore[misc]
                changed(**{name: value * f})
            )
    if "heights" in parameters:
        inputs["heights"] = lambda f: on(changed(**_higher(surface, f)))
    return inputs


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
