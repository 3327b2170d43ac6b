"""Consistency checks between the tables of a study, and warnings of likely unit errors."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.study.joints import Joint
from microslip.study.metals import check_described
from microslip.study.part import Part
from microslip.study.readers import KeyedError
from microslip.study.schema import StudyTables
from microslip.study.surfaces import Elastic, Rigid, TableSurface
from microslip.study.uncertain import spreads_of

MAX_LOOPS = 2000
_MAX_POINTS = 1_000_000
MAX_SAMPLES = 10_000_000


def mean_load(study: StudyTables) -> float:
    """Return surface.area times the mean pressure between the parts of a bolted structure [N]."""
    area = getattr(study.surface, "area", None)
    if study.structure is None or area is None:
        raise KeyedError(
            "joint.normal_load", 'missing; write for example normal_load = ["500 N", "2 kN"]'
        )
    part = study.structure
    return float(part.tension.sum() / part.face_area * area)


def check_consistency(study: StudyTables) -> None:
    """Raise an error for the first inconsistency between the tables of a study."""
    of_joint = (_of_bodies, _of_loads, _of_pressure, _of_structure)
    rules = of_joint if isinstance(study.joint, Joint) else (_of_law,)
    for rule in (*rules, _of_uncertainty, _of_forces, _of_amount):
        rule(study)


def _force(value: float) -> str:
    return engineering(value, "N", 6, trim=True)


def _of_bodies(study: StudyTables) -> None:
    surface = study.surface
    if surface is None:
        raise KeyedError("surface", "missing; write a table [surface]")
    names = surface.materials
    check_described("surface.materials", names, study.material)
    if all(isinstance(study.material[name], Rigid) for name in names):
        raise KeyedError("surface.materials", "wanted one body that deforms, got two rigid ones")
    # A surface has at least one summit; a smaller number is a unit error.
    if {"density", "area"} <= surface.keys.keys():
        count = surface.density * surface.area
        if count < 1.0:
            message = f"wanted at least one summit on the area, got {count:.3g}"
            raise KeyedError("surface.density", f"{message} (density times area)")
    for name, material in study.material.items():
        if isinstance(material, Elastic) and material.hardness is not None:
            modulus, hardness = (
                engineering(value, "Pa", 6, trim=True)
                for value in (material.young_modulus, material.hardness)
            )
            if material.hardness > 0.1 * material.young_modulus:
                key = f"material.{shorten(name, 40)}.hardness"
                message = "wanted at most a tenth of Young's modulus, as of all metals"
                raise KeyedError(key, f"{message}, {modulus} / 10, got {hardness}")


def _of_loads(study: StudyTables) -> None:
    """Reject normal loads above the largest load of a tabulated law."""
    surface, loads = study.surface, study.joint.normal_load
    if not isinstance(surface, TableSurface):
        return
    largest = surface.load[0]
    for index, load in enumerate(loads, start=1):
        if load > largest:
            item = f", item {index}" if len(loads) > 1 else ""
            raise KeyedError(
                f"joint.normal_load{item}",
                f"wanted at most the first load of the table, {_force(largest)}, "
                f"got {_force(load)}",
            )


def _of_pressure(study: StudyTables) -> None:
    """Reject a pressure distribution without load, or over an area larger than the surface."""
    if study.joint.pressure is None:
        return
    key = "joint.pressure"
    if (load := study.joint.pressure.load) is not None and load <= 0.0:
        raise KeyedError(
            key,
            f"wanted a clamp force above zero after embedding and axial load, got {_force(load)}",
        )
    if "area" not in study.surface.keys:
        raise KeyedError(
            key,
            f'wanted a surface with a key area, got law = "{study.surface.law}"',
        )
    area, pressed = getattr(study.surface, "area", None), study.joint.pressure.spread().area
    if area is not None and pressed > area * (1.0 + 1e-9):
        within = f"wanted a pressed area of at most surface.area, {1e4 * area:.6g} cm^2"
        raise KeyedError(key, f"{within}, got {1e4 * pressed:.6g} cm^2")


def _of_structure(study: StudyTables) -> None:
    """Reject contradictions between a structure and other tables, such as a rigid body."""
    part = study.structure
    if part is None:
        return
    if study.joint.pressure is not None:
        unlike = "wanted no pressure with a [structure], which computes the pressure of each patch"
        raise KeyedError("joint.pressure", unlike)
    if isinstance(study.material[study.surface.materials[0]], Rigid):
        raise KeyedError("surface.materials, item 1", "wanted an elastic body, got a rigid one")
    if part.mesh is not None:
        check_described("structure.mesh.materials", part.mesh.materials or (), study.material)
    if part.tension.min() <= 0.0:
        raise KeyedError(
            "structure.bolts.embedding" if part.bolts.rz is None else "structure.bolts.rz",
            "wanted a remaining tension above zero after embedding, got "
            f"{_force(float(part.tension.min()))}",
        )
    if getattr(study.surface, "area", None) is None:
        spread = "wanted a surface with a key area, which a [structure] distributes to its patches"
        raise KeyedError("surface", spread)


def _of_law(study: StudyTables) -> None:
    for name in ("structure", "surface"):
        if getattr(study, name) is not None:
            raise KeyedError(name, f"wanted no [{name}] with joint.law_file; remove one of them")


def _of_uncertainty(study: StudyTables) -> None:
    part = study.uncertainty
    if part is None:
        return
    if not any(spreads_of(study)) and not getattr(study.surface, "model_spreads", None):
        raise KeyedError(
            "uncertainty",
            "wanted an uncertain number in the study, got none; write for example "
            'normal_load = { mean = "2 kN", cv = 0.15 }',
        )


def _of_forces(study: StudyTables) -> None:
    """Reject force amplitudes that reach the friction limit at the smallest normal load."""
    excitation, joint, history = study.excitation, study.joint, study.excitation.history
    if isinstance(joint, Joint):
        load = min(joint.normal_load)
        limit, place = joint.friction_coefficient * load, f" at the load {_force(load)}"
    else:
        limit, place = joint.build().force_limit, ""
    for index, force in enumerate(excitation.force_amplitudes or (), start=1):
        if force >= limit:
            expected = f"wanted less than the force limit {_force(limit)}{place}"
            raise KeyedError(
                f"excitation.force_amplitudes, item {index}", f"{expected}, got {_force(force)}"
            )
    if history is None or history.quantity != "force":
        return
    if abs(force := max(history.values, key=abs)) >= limit:
        raise KeyedError(
            "excitation.history",
            f"{shorten(history.file, 100)}: wanted forces within ±{_force(limit)}, the force "
            f"limit{place}, got {_force(force)}",
        )


def _of_amount(study: StudyTables) -> None:
    excitation, loads = study.excitation, max(len(study.joint.loads), 1)
    key = "amplitudes" if excitation.force_amplitudes is None else "force_amplitudes"
    loops = len(excitation.amplitudes or excitation.force_amplitudes or ())
    points = excitation.curve.points if excitation.curve else 0
    samples = len(excitation.history.values) if excitation.history else 0
    for where, noun, limit, count, times in (
        (key, "loops", MAX_LOOPS, loads * loops, "amplitudes"),
        ("curve.points", "points in all", _MAX_POINTS, loads * points, "points"),
        ("history", "samples in all", MAX_SAMPLES, loads * samples, "rows"),
    ):
        if count > limit:
            message = f"wanted at most {limit} {noun}, got {count} (loads times {times})"
            raise KeyedError(f"excitation.{where}", message)


Usual = tuple[float, float, str, str]
"""Lowest and highest usual value in SI units, the unit, and where they are usual."""

_SIZE = (1e-3, 20.0, "m", "beams and plates that are bolted")
_USUAL: dict[str, Usual] = {
    "material.young_modulus": (1e9, 1.3e12, "Pa", "polymers to diamond"),
    "material.hardness": (5e7, 1e11, "Pa", "tin to diamond"),
    "surface.heights.std": (1e-9, 1e-4, "m", "polished to sand-cast faces"),
    "surface.heights.scale": (1e-9, 1e-4, "m", "polished to sand-cast faces"),
    "surface.radius": (1e-8, 1.0, "m", "summits and balls"),
    "surface.density": (1e3, 1e15, "1/m^2", "summits that a scan finds"),
    "surface.area": (1e-12, 10.0, "m^2", "joints"),
    "joint.friction_coefficient": (0.01, 2.0, "", "lubricated to clean metals"),
    "excitation.amplitudes": (1e-11, 5e-3, "m", "joints"),
    "structure.length": _SIZE,
    "structure.width": _SIZE,
    "structure.thickness": _SIZE,
    "structure.lap": _SIZE,
    "structure.density": (500.0, 2.3e4, "kg/m^3", "light polymers to tungsten"),
    "structure.base_damping_ratio": (1e-6, 0.05, "", "a string in vacuum to glue and rubber"),
    "structure.force.amplitude": (1e-4, 1e5, "N", "hammers and shakers"),
}
_PRESSURE = (1e1, 5e9, "Pa", "joints")
_BOLT = (1e7, 1.1e9, "Pa", "finger-tight to the yield of grade 12.9")


def unit_warnings(study: Any) -> list[str]:
    """Return warnings of values in a probably wrong unit."""
    found = [*_usual_values(study, "", ""), *_derived_values(study)]
    questions = [_question(key, value, usual) for key, value, usual in found]
    return [question for question in questions if question]


def _usual_values(part: Any, key: str, path: str) -> Iterator[tuple[str, float, Usual]]:
    """Yield the numbers of a study that have a usual range, by key.

    ``path`` is the key without the name of a material, by which ranges are listed.
    """
    if isinstance(part, Part):
        for name, attribute in part.attributes.items():
            inner = f"{path}.{name}".lstrip(".")
            yield from _usual_values(getattr(part, attribute), f"{key}.{name}".lstrip("."), inner)
    elif isinstance(part, dict):
        for name, value in part.items():
            yield from _usual_values(value, f"{key}.{name}", path)
    elif path in _USUAL and isinstance(part, (float, tuple)):
        for value in sorted({min(part), max(part)}) if isinstance(part, tuple) else [part]:
            yield key, float(value), _USUAL[path]


def _derived_values(study: Any) -> Iterator[tuple[str, float, Usual]]:
    """Yield numbers that follow from several keys, or whose usual range depends on others."""
    area, part = getattr(study.surface, "area", None), study.structure
    for load in study.joint.loads if area else ():
        yield "joint.normal_load over surface.area", load / area, _PRESSURE
    if part is None:
        return
    if part.quantity == "displacement":
        usual = (1e-10 * part.extent, 1e-2 * part.extent, "m", "vibration of a part of this length")
        yield "structure.amplitude.from", float(part.amplitudes[0]), usual
        yield "structure.amplitude.to", float(part.amplitudes[-1]), usual
    if part.bolts.shank is not None:
        section = 0.25 * math.pi * float(part.bolts.shank) ** 2
        for tension in sorted({float(tension) for tension in part.tension}):
            yield "structure.bolts tension over the section of a shank", tension / section, _BOLT


def _question(key: str, value: float, usual: Usual) -> str:
    low, high, unit, of = usual
    if low <= value <= high or (value == 0.0 and key == "structure.base_damping_ratio"):
        return ""

    def written(number: float) -> str:
        if unit in ("", "1/m^2", "m^2", "kg/m^3"):
            return f"{significant(number)} {unit}".rstrip()
        return engineering(number, unit, 4, trim=True)

    # Usually a wrong prefix or decimal point.
    factors = (1e3, 1e-3, 1e6, 1e-6) if unit not in ("", "1/m^2") else (0.01, 0.1, 1e6, 1e-6)
    likely = next((f * value for f in factors if low <= f * value <= high), None)
    guess = "" if likely is None else f" Was {written(likely)} meant?"
    return (
        f"{key}: is it really {written(value)}? Usual is {written(low)} to "
        f"{written(high)} ({of}).{guess}"
    )
