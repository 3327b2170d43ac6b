"""An interface as the keys of a study file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from microslip._core.checks import show
from microslip._core.units import engineering
from microslip.errors import InputError
from microslip.friction import Interface
from microslip.heights import Discrete, Exponential, Gaussian
from microslip.identification.fit_quality import RecordFit
from microslip.identification.load_levels import groups_of
from microslip.materials import Material
from microslip.normal import GreenwoodWilliamson


def loads_of(records: Sequence[RecordFit]) -> list[float]:
    """Different normal loads of the records [N], rising."""
    return _means(record.normal_load for record in records if record.normal_load)


def amplitudes_of(records: Sequence[RecordFit]) -> list[float]:
    """Different amplitudes of the joint itself [m]: those of the records less the rig's part."""
    amplitudes = []
    for record in records:
        rig = float(np.ptp(record.model)) / (record.rig_stiffness or math.inf)
        amplitudes.append(0.5 * (float(np.ptp(record.displacement)) - rig))
    return _means(amplitude for amplitude in amplitudes if amplitude > 0.0)


def _means(values: Iterable[float]) -> list[float]:
    return [float(np.mean(group)) for group in groups_of(values)]


def _written(value: float, unit: str) -> str:
    return engineering(value, unit, 4, trim=True).replace("µ", "u")


def study_of(
    joint: Interface, loads: Sequence[float], amplitudes: Sequence[float], area_known: bool
) -> dict[str, Any]:
    """A study of a joint at loads [N] and amplitudes [m]; quantities are text with their unit."""
    surface = joint.surface
    if not isinstance(surface, GreenwoodWilliamson):
        raise InputError(
            f"a study is made of a surface with a distribution of heights, got {show(surface)}"
        )
    first, second = _material(surface.pair.first), _material(surface.pair.second)
    materials = {"first": first} if first == second else {"first": first, "second": second}
    names = ["first", "first"] if first == second else ["first", "second"]
    title = "Identified joint" if area_known else "Identified joint, its area a convention"
    return {
        "schema": 1,
        "title": title,
        "material": materials,
        "surface": {
            "materials": names,
            "law": "greenwood-williamson",
            "heights": _heights(surface.heights),
            "radius": f"{surface.radius!r} m",
            "density": f"{surface.density!r} 1/m^2",
            "area": f"{surface.area!r} m^2",
        },
        "joint": {
            "friction_coefficient": float(joint.friction_coefficient),
            "normal_load": [_written(load, "N") for load in loads or [joint.normal_load]],
        },
        "excitation": {"amplitudes": [_written(a, "m") for a in amplitudes]},
    }


def _material(body: Material) -> dict[str, Any]:
    if not np.isfinite(body.young_modulus):
        return {"rigid": True}
    keys: dict[str, Any] = {
        "young_modulus": f"{body.young_modulus!r} Pa",
        "poisson_ratio": float(body.poisson_ratio),
    }
    if body.hardness is not None:
        keys["hardness"] = f"{body.hardness!r} Pa"
    return keys


def _heights(heights: Any) -> dict[str, Any]:
    if isinstance(heights, Gaussian):
        keys: dict[str, Any] = {"kind": "gaussian", "std": f"{heights.std!r} m"}
        if heights.mean:
            keys["mean"] = f"{heights.mean!r} m"
        return keys
    if isinstance(heights, Exponential):
        return {"kind": "exponential", "scale": f"{heights.scale!r} m"}
    if isinstance(heights, Discrete):
        values = [f"{float(value)!r} m" for value in np.asarray(heights.values)]
        return {"kind": "values", "values": values}
    raise InputError(
        "a study is made of Gaussian, exponential or given heights, got "
        f"{show(heights)}; joint() gives the interface itself"
    )
