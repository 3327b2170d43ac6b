"""Sensitivities d ln(output)/d ln(input) of stiffness and loss factor of an interface."""

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
from microslip.friction.interface import Interface

_STEP = 0.02
"""Step of the central difference in ln(input), whose error is of second order."""

_OF_A_FACE = ("young_modulus", "hardness", "heights")

_ELASTIC = 1e15
"""Hardness [Pa] of a face without yielding."""


def input_slopes(joint: Interface, amplitude: float) -> dict[str, dict[str, float]]:
    """Return d ln(output)/d ln(input) [-] as ``result[output][input]`` for an amplitude [m].

    Outputs are the tangential stiffness at rest and the loss factor. They are differentiated by
    central differences with steps of 2 %; inputs are sorted by decreasing magnitude. A tabulated
    surface has only friction and load as inputs. For a measured face, the changes of stiffness and
    of loss factor at equal amplitude over mu N/k_t, with modulus, hardness and heights, are those
    of a Gaussian face with equal rms height, rms slope and stiffness.
    """
    slopes_of: dict[str, dict[str, float]] = {"tangential_stiffness": {}, "loss_factor": {}}
    for name, scaled in _inputs(joint).items():
        try:
            ends = [scaled(math.exp(sign * _STEP)) for sign in (-1.0, 1.0)]
        except InputError:  # for example, a load above the largest load of the summits
            continue
        if name in _OF_A_FACE and isinstance(joint.surface, MeasuredContact):
            losses = _measured_losses(joint, amplitude, ends)
        else:
            losses = [float(end.loss_factor(amplitude)) for end in ends]
        for quantity, values in (
            ("tangential_stiffness", [end.tangential_stiffness for end in ends]),
            ("loss_factor", losses),
        ):
            if min(values) > 0.0 and math.isfinite(max(values)):
                slopes_of[quantity][name] = math.log(values[1] / values[0]) / (2.0 * _STEP)
    return {
        quantity: dict(sorted(slopes.items(), key=lambda pair: -abs(pair[1])))
        for quantity, slopes in slopes_of.items()
    }


def _measured_losses(joint: Interface, amplitude: float, ends: list[Interface]) -> list[float]:
    """Return loss factors [-] of a measured joint whose input has the values of ``ends``.

    The Gaussian ``ends`` give the displacement mu N/k_t at which the joint slips, and the change of
    the loss factor at equal amplitude over that displacement; the rest is the measured curve, whose
    slope in amplitude differs from that of a Gaussian face.
    """
    lengths = [end.force_limit / end.tangential_stiffness for end in ends]
    middle = joint.force_limit / joint.tangential_stiffness
    return [
        float(joint.loss_factor(amplitude * middle / length))
        * float(end.loss_factor(amplitude / middle * length))
        for end, length in zip(ends, lengths, strict=True)
    ]


def _inputs(joint: Interface) -> dict[str, Callable[[float], Interface]]:
    surface, mu, load = joint.surface, joint.friction_coefficient, joint.normal_load

    def on(law: NormalLaw) -> Interface:
        return Interface(law, mu, normal_load=load)

    inputs: dict[str, Callable[[float], Interface]] = {
        "friction_coefficient": lambda f: Interface(surface, mu * f, normal_load=load),
        "normal_load": lambda f: joint.at(normal_load=load * f),
    }
    if isinstance(surface, MeasuredContact):
        return inputs | {
            name: lambda f, name=name: Interface(
                _equivalent_gaussian_face(joint, name, f), mu, normal_load=load
            )
            for name in _OF_A_FACE
            if name != "hardness" or surface.numbers.hardness is not None
        }
    if isinstance(surface, DrawnFace):
        names = {"heights": "rms", "rms_slope": "slope", "young_modulus": "pair"}
        names |= {name: name for name in ("hardness", "tightening_pressure")}
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
        name: name for name in ("radius", "radii", "density", "copies") if name in parameters
    }
    if "heights" in parameters:
        names["heights"] = "heights"
    for input_name, name in names.items():
        inputs[input_name] = lambda f, name=name: on(_scaled(surface, name, f))  # type: ignore[misc]
    return inputs


@lru_cache(maxsize=32)
def _scaled(surface: Any, name: str, factor: float) -> NormalLaw:
    """Return a surface with its parameter ``name`` multiplied; cached, for use at many loads."""
    if name == "pair":
        changes: dict[str, Any] = {"pair": _scaled_moduli(surface.pair, factor)}
    elif name == "heights":
        changes = _scaled_heights(surface, factor)
    elif name == "hardness":
        changes = {"pair": surface.pair.with_hardness(factor * surface.pair.hardness)}
    else:
        changes = {name: getattr(surface, name) * factor}
    law: NormalLaw = replace(surface, **changes)
    return law


def _equivalent_gaussian_face(joint: Interface, name: str, factor: float) -> DrawnFace:
    """Return a Gaussian face equivalent to a measured one, with the input ``name`` multiplied.

    It has the rms height, rms slope and tightening pressure of the measured face, and a factor that
    makes its stiffness equal. This avoids solving the contact of the scan again.
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
        changes["pair"] = _scaled_moduli(pair, factor)
    return replace(face, **changes)


def _scaled_moduli(pair: MaterialPair, factor: float) -> MaterialPair:
    bodies = (
        body
        if body.is_rigid
        else Material(factor * body.young_modulus, body.poisson_ratio, body.hardness)
        for body in (pair.first, pair.second)
    )
    return MaterialPair(*bodies)


def _scaled_heights(surface: Any, factor: float) -> dict[str, Any]:
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
