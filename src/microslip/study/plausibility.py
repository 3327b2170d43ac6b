"""Values flagged as likely unit errors."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from microslip._core.units import engineering, significant
from microslip.study.surfaces import Elastic


class Usual(NamedTuple):
    """What a quantity usually is: its ends in SI units, its unit, and of what they are."""

    low: float
    high: float
    unit: str
    of: str


_MODULUS = Usual(1e9, 1.3e12, "Pa", "polymers to diamond")
_HARDNESS = Usual(5e7, 1e11, "Pa", "tin to diamond")
_FRICTION = Usual(0.01, 2.0, "", "lubricated to clean metals")
_AMPLITUDE = Usual(1e-11, 5e-3, "m", "joints")
_SURFACE = {
    "std": Usual(1e-9, 1e-4, "m", "polished to sand-cast faces"),
    "scale": Usual(1e-9, 1e-4, "m", "polished to sand-cast faces"),
    "radius": Usual(1e-8, 1.0, "m", "summits and balls"),
    "density": Usual(1e3, 1e15, "1/m^2", "summits that a scan finds"),
    "area": Usual(1e-12, 10.0, "m^2", "joints"),
}
_SIZE = Usual(1e-3, 20.0, "m", "beams and plates that are bolted")
_BODY = Usual(500.0, 2.3e4, "kg/m^3", "light polymers to tungsten")
_BOLT = Usual(1e7, 1.1e9, "Pa", "finger-tight to the yield of grade 12.9")
_PRESSURE = Usual(1e1, 5e9, "Pa", "joints")


def questions(study: Any) -> list[str]:
    """What to ask back of a study, a sentence each; nothing where all is usual."""
    unknown = [
        f"{key}: is this number known? The loops that the study was identified from did not tell "
        "it, and give the same for others; take the key from not_identified once it is measured."
        for key in study.not_identified or ()
    ]
    return unknown + [
        question
        for key, value, usual in _values(study)
        if (question := _question(key, float(value), usual)) is not None
    ]


def _values(study: Any) -> Iterator[tuple[str, float, Usual]]:
    for name, material in study.material.items():
        if isinstance(material, Elastic):
            yield f"material.{name}.young_modulus", material.young_modulus, _MODULUS
            if material.hardness is not None:
                yield f"material.{name}.hardness", material.hardness, _HARDNESS
    surface = study.surface
    for place, part in (("surface", surface), ("surface.heights", getattr(surface, "heights", 0))):
        for name, usual in _SURFACE.items():
            value = getattr(part, name, None)
            if isinstance(value, float) and (place, name) != ("surface.heights", "density"):
                yield f"{place}.{name}", value, usual
    friction = getattr(study.joint, "friction_coefficient", None)
    if friction is not None:
        yield "joint.friction_coefficient", float(friction), _FRICTION
    area = getattr(surface, "area", None)
    for load in study.joint.loads if area else ():
        yield "joint.normal_load over surface.area", load / area, _PRESSURE
    for amplitude in study.excitation.amplitudes or ():
        yield "excitation.amplitudes", amplitude, _AMPLITUDE
    if study.structure is not None:
        yield from _of_structure(study.structure)


def _of_structure(part: Any) -> Iterator[tuple[str, float, Usual]]:
    sizes = ("length", "width", "thickness", "lap") if part.mesh is None else ()
    for name in sizes:
        yield f"structure.{name}", getattr(part, name), _SIZE
    if part.density is not None:
        yield "structure.density", part.density, _BODY
    extent = part.extent
    usual = Usual(1e-10 * extent, 1e-2 * extent, "m", "vibration of something so long")
    yield "structure.amplitude.to", float(part.amplitudes[-1]), usual
    if part.bolts.shank is not None:
        section = 0.25 * math.pi * float(part.bolts.shank) ** 2
        for tension in sorted({float(tension) for tension in part.tension}):
            yield "structure.bolts tension over the section of a shank", tension / section, _BOLT


def _question(key: str, value: float, usual: Usual) -> str | None:
    if usual.low <= value <= usual.high:
        return None

    def written(number: float) -> str:
        if usual.unit in ("", "1/m^2", "m^2", "kg/m^3"):
            return f"{significant(number)} {usual.unit}".rstrip()
        return engineering(number, usual.unit, 4, trim=True)

    # A slip of a prefix, or of the decimal point, most of all.
    factors = (1e3, 1e-3, 1e6, 1e-6) if usual.unit not in ("", "1/m^2") else (0.01, 0.1, 1e6, 1e-6)
    likely = next((f * value for f in factors if usual.low <= f * value <= usual.high), None)
    guess = "" if likely is None else f" Was {written(likely)} meant?"
    return (
        f"{key}: is it really {written(value)}? Usual is {written(usual.low)} to "
        f"{written(usual.high)} ({usual.of}).{guess}"
    )
