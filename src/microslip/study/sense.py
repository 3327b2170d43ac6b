"""What only shows in the whole of a study, and what is more likely a slip: no computation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.study.joints import Joint
from microslip.study.metals import unknown
from microslip.study.readers import KeyedError
from microslip.study.schema import StudyTables
from microslip.study.surfaces import Elastic, Rigid, TableSurface
from microslip.study.uncertain import spreads_of

VARIATION = "excitation.load_variation"
RECORDED = "excitation.history.normal_load"
MAX_LOOPS = 2000
MAX_POINTS = 1_000_000
MAX_SAMPLES = 10_000_000

_NO_END = "this surface never lifts off: its heights, or the tail of its table, have no end"


def mean_load(study: StudyTables) -> float:
    """Normal load [N] where none is given: bolts press the surface as they do the lap."""
    area = getattr(study.surface, "area", None)
    if study.structure is None or area is None:
        raise KeyedError(
            "joint.normal_load", 'missing; write for example normal_load = ["500 N", "2 kN"]'
        )
    part = study.structure
    return float(part.tension.sum() / part.face_area * area)


def check(study: StudyTables) -> None:
    """Find what the parts of a study cannot see."""
    if isinstance(study.joint, Joint):
        if study.surface is None:
            raise KeyedError("surface", "missing; write a table [surface]")
        _check_bodies(study, study.surface)
        _check_loads(study, study.joint.normal_load)
        _check_variation(study, study.joint.normal_load)
        _check_pressure(study)
        _check_structure(study)
    else:
        _check_law(study)
    _check_uncertainty(study)
    _check_forces(study)
    _check_amount(study)


def _check_structure(study: StudyTables) -> None:
    """It needs bodies that bend, and a surface of known area."""
    part = study.structure
    if part is None:
        return
    for key in ("tightening_load", "pressure"):
        if getattr(study.joint, key) is not None:
            raise KeyedError(
                f"joint.{key}",
                "wanted none beside a [structure], whose patches bear unlike pressures",
            )
    first = study.material[study.surface.materials[0]]
    if isinstance(first, Rigid):
        raise KeyedError("surface.materials, item 1", "wanted a body that bends, got a rigid one")
    if part.mesh is not None:
        part.mesh.check_materials(study.material)
    if getattr(study.surface, "area", None) is None:
        raise KeyedError(
            "surface", "wanted a surface with an area, which a [structure] spreads over its patches"
        )


def _check_pressure(study: StudyTables) -> None:
    """A pressure that is spread needs a surface with an area, and stays as it is."""
    if study.joint.pressure is None:
        return
    if "area" not in study.surface.keys:
        raise KeyedError(
            "joint.pressure",
            f'wanted a surface with an area to spread it over, got law = "{study.surface.law}"',
        )
    area, pressed = getattr(study.surface, "area", None), study.joint.pressure.spread().area
    if area is not None and pressed > area * (1.0 + 1e-9):
        raise KeyedError(
            "joint.pressure",
            f"wanted one within the area of the surface, {1e4 * area:.6g} cm^2, got one on "
            f"{1e4 * pressed:.6g} cm^2",
        )
    for key, value in (
        (VARIATION, study.excitation.load_variation),
        (RECORDED, study.excitation.history and study.excitation.history.normal_load),
    ):
        if value is not None:
            raise KeyedError(key, "wanted none beside joint.pressure, which is at constant load")


def _check_uncertainty(study: StudyTables) -> None:
    """What is drawn is there, and drawn once."""
    part = study.uncertainty
    if part is None:
        return
    names = tuple(key for key, _ in spreads_of(study))
    part.matrix(names)
    if part.scan_patches is not None and getattr(study.surface, "law", "") != "scan":
        raise KeyedError("uncertainty.scan_patches", 'wanted only beside surface.law = "scan"')
    if part.identification is not None:
        if not isinstance(study.joint, Joint):
            raise KeyedError("uncertainty.identification", "wanted only for an interface")
        fitted = ("joint.friction_coefficient", "surface.heights", "surface.density")
        for key in names:
            if key.startswith(fitted):
                raise KeyedError(key, "wanted a number: uncertainty.identification says how far "
                                      "it is known")  # fmt: skip
    if not names and part.scan_patches is None and part.identification is None:
        raise KeyedError(
            "uncertainty",
            "wanted an uncertain number in the study, got none; write for example "
            'normal_load = { mean = "2 kN", cv = 0.15 }',
        )


def _check_law(study: StudyTables) -> None:
    """A friction law by its own parameters has no surface and no normal load."""
    law, excitation = study.joint.law, study.excitation
    because = f'the law "{law}" knows no normal load'
    if study.structure is not None:
        raise KeyedError("structure", f'wanted none beside joint.law = "{law}", got one; remove it')
    if study.surface is not None:
        raise KeyedError("surface", f'wanted none beside joint.law = "{law}", got one; remove it')
    if excitation.load_variation is not None:
        raise KeyedError(VARIATION, f"wanted none, got a table; {because}")
    if excitation.history is not None and excitation.history.loads is not None:
        raise KeyedError(RECORDED, f"wanted none, got a table; {because}")


def _check_bodies(study: StudyTables, surface: Any) -> None:
    names = surface.materials
    for index, name in enumerate(names, start=1):
        if name not in study.material:
            raise KeyedError(f"surface.materials, item {index}", unknown(name, study.material))
    if all(isinstance(study.material[name], Rigid) for name in names):
        raise KeyedError("surface.materials", "wanted one body that deforms, got two rigid ones")
    _check_summits(surface)
    for name, material in study.material.items():
        if isinstance(material, Elastic) and material.hardness is not None:
            modulus = engineering(material.young_modulus, "Pa", 6, trim=True)
            if material.hardness >= material.young_modulus:
                raise KeyedError(
                    f"material.{shorten(name, 40)}.hardness",
                    f"wanted less than Young's modulus {modulus}, "
                    f"got {engineering(material.hardness, 'Pa', 6, trim=True)}",
                )


def _check_summits(surface: Any) -> None:
    """A surface has a summit; less is a slip of a unit."""
    if {"density", "area"} <= surface.keys.keys() and surface.law != "scan":
        count = surface.density * surface.area
        if count < 1.0:
            raise KeyedError(
                "surface.density",
                f"wanted at least one summit on the area, got {count:.3g} (density times area)",
            )


def _largest_load(study: StudyTables) -> tuple[float, str, str] | None:
    """Largest load that the surface answers for, what that is, and how to have more."""
    tightening: float | None = study.joint.tightening_load
    if tightening is not None:
        words = f"the tightening load {_force(tightening)}"
        return tightening, words, "raise joint.tightening_load (above it the summits yield again)"
    if not isinstance(study.surface, TableSurface):
        return None
    load = study.surface.load[0]
    return load, f"the first load of the table, {_force(load)}", "begin the table higher"


def _check_loads(study: StudyTables, loads: Sequence[float]) -> None:
    """A table carries no more than its first load; a tightened surface is tightened further."""
    limit = _largest_load(study) if study.joint.tightening_load is None else None
    for index, load in enumerate(loads, start=1):
        if limit is not None and load > limit[0]:
            item = f", item {index}" if len(loads) > 1 else ""
            raise KeyedError(
                f"joint.normal_load{item}", f"wanted at most {limit[1]}, got {_force(load)}"
            )


def _check_variation(study: StudyTables, normal_loads: Sequence[float]) -> None:
    """A load that varies does not pull, and stays within a table."""
    variation = study.excitation.load_variation
    if variation is not None:
        load = min(normal_loads)
        if variation.amplitude is not None and variation.amplitude > load:
            raise KeyedError(
                f"{VARIATION}.amplitude",
                f"wanted at most the normal load {_force(load)}, got {_force(variation.amplitude)} "
                "(the load would go below zero)",
            )
    limit = _largest_load(study)
    if limit is None:
        return
    largest, table, remedy = limit
    if variation is not None:
        load = max(normal_loads)
        share = variation.share_of(load)
        if load * (1.0 + share) > largest:
            room = math.floor(1000.0 * (largest / load - 1.0)) / 1000.0
            name = "share" if variation.amplitude is None else "amplitude"
            size = f"{room:g}" if name == "share" else f'"{_force(room * load)}"'
            lower = f"{name} = {size} or less" if room > 0.0 else "a lower joint.normal_load"
            raise KeyedError(
                f"{VARIATION}.{name}",
                f"wanted loads up to {table}, but the load {_force(load)} grows to "
                f"{_force(load * (1.0 + share))}; write {lower}, or {remedy}",
            )
    history = study.excitation.history
    if history is not None and (loads := history.loads) is not None:
        beyond = np.flatnonzero(loads > largest)
        if beyond.size:
            row = int(beyond[0])
            raise KeyedError(
                RECORDED,
                f"{shorten(history.file, 100)}: wanted loads up to {table}, got "
                f"{_force(float(loads[row]))} in row {row + 1} of the numbers; {remedy}",
            )


def lifting(study: StudyTables, lightest: float) -> None:
    """Find loads that go down to zero on a surface on which some summit always touches."""
    variation, history = study.excitation.load_variation, study.excitation.history
    if variation is not None and variation.share_of(lightest) == 1.0:
        if variation.amplitude is None:
            name, bound, value = "share", "1, such as 0.99", "1"
        else:
            name, bound = "amplitude", f"the normal load {_force(lightest)}"
            value = _force(variation.amplitude)
        raise KeyedError(
            f"{VARIATION}.{name}",
            f"wanted less than {bound}, got {value}: the load {_force(lightest)} would go down to "
            f"0 N ({_NO_END})",
        )
    if history is not None and (loads := history.loads) is not None:
        zeros = np.flatnonzero(loads == 0.0)
        if zeros.size:
            raise KeyedError(
                RECORDED,
                f"{shorten(history.file, 100)}: wanted loads above zero, got 0 N in row "
                f"{int(zeros[0]) + 1} of the numbers ({_NO_END})",
            )


def _check_forces(study: StudyTables) -> None:
    """No force reaches the limit at the lightest load."""
    excitation, joint = study.excitation, study.joint
    if isinstance(joint, Joint):
        load = min(joint.normal_load)
        limit, place = joint.friction_coefficient * load, f" at the load {_force(load)}"
    else:
        limit, place = joint.build().force_limit, ""
    for index, force in enumerate(excitation.force_amplitudes or (), start=1):
        if force >= limit:
            raise KeyedError(
                f"excitation.force_amplitudes, item {index}",
                f"wanted less than the force limit {_force(limit)}{place}, got {_force(force)}",
            )
    history = excitation.history
    if history is not None and history.quantity == "force":
        force = max(history.values, key=abs)
        if (loads := history.loads) is not None and isinstance(joint, Joint):
            limits = joint.friction_coefficient * loads
            beyond = np.flatnonzero(np.abs(history.values) >= limits)
            if beyond.size:
                row = int(beyond[0])
                raise KeyedError(
                    "excitation.history",
                    f"{shorten(history.file, 100)}: wanted forces within the force limit, "
                    f"±{_force(float(limits[row]))} in row {row + 1} of the numbers, "
                    f"got {_force(float(history.values[row]))}",
                )
        elif abs(force) >= limit:
            raise KeyedError(
                "excitation.history",
                f"{shorten(history.file, 100)}: wanted forces within ±{_force(limit)}, the force "
                f"limit{place}, got {_force(force)}",
            )


def _check_amount(study: StudyTables) -> None:
    excitation, loads = study.excitation, max(len(study.joint.loads), 1)
    key = "amplitudes" if excitation.force_amplitudes is None else "force_amplitudes"
    loops = loads * len(excitation.amplitudes or excitation.force_amplitudes or ())
    points = loads * (excitation.curve.points if excitation.curve else 0)
    samples = loads * (len(excitation.history.values) if excitation.history else 0)
    for where, noun, limit, count, times in (
        (key, "loops", MAX_LOOPS, loops, "amplitudes"),
        ("curve.points", "points in all", MAX_POINTS, points, "points"),
        ("history", "samples in all", MAX_SAMPLES, samples, "rows"),
    ):
        if count > limit:
            raise KeyedError(
                f"excitation.{where}",
                f"wanted at most {limit} {noun}, got {count} (loads times {times})",
            )


def _force(value: float) -> str:
    return engineering(value, "N", 6, trim=True)


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
