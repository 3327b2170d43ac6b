"""A study in words and units, for the reader of a result."""

from __future__ import annotations

from microslip.report.cells import quantity
from microslip.report.document import Facts
from microslip.runs.columns import in_words
from microslip.study.description import StudyDescription
from microslip.study.fields import labels_of
from microslip.study.part import Part
from microslip.study.scanned_surface import NO_CUTOFF
from microslip.study.structure import StructurePart
from microslip.study.surfaces import TableHeights

KEYS = {
    "young_modulus": ("Young’s modulus", "Pa"),
    "poisson_ratio": ("Poisson’s ratio", ""),
    "hardness": ("Hardness (only for the plasticity index)", "Pa"),
    "heights": ("Summit heights", ""),
    "kind": ("Summit heights", ""),
    "std": ("Their standard deviation", "m"),
    "mean": ("Their mean", "m"),
    "values": ("Heights", "m"),
    "height": ("Tabulated heights", "m"),
    "distribution": ("Distribution of scipy.stats", ""),
    "parameters": ("Its shape parameters", ""),
    "location": ("Its location", "m"),
    "scale": ("Their scale", "m"),
    "rms": ("Root mean square height", "m"),
    "hurst": ("Hurst exponent", ""),
    "longest": ("Longest wave", "m"),
    "roll_off": ("Roll-off", "m"),
    "shortest": ("Shortest wave", "m"),
    "wavenumber": ("Wavenumbers", "1/m"),
    "spectrum": ("Power spectral densities", "m^4"),
    "ra": ("Roughness average Ra", "m"),
    "rq": ("Root mean square height Rq", "m"),
    "rz": ("Peak-to-valley height Rz", "m"),
    "rsm": ("Mean width of profile elements RSm", "m"),
    "process": ("Made by", ""),
    "breadth": ("Nayak’s α", ""),
    "radius": ("Radius", "m"),
    "density": ("Summits per apparent area", "1/m²"),
    "area": ("Apparent area", "m²"),
    "separation": ("Tabulated separations", "m"),
    "load": ("Their loads", "N"),
    "tail": ("Beyond the table", ""),
    "scan": ("Scan", ""),
    "cutoff": ("Short-wave cut-off", "m"),
    "long_cutoff": ("Long-wave cut-off", "m"),
    "level": ("Form removed", ""),
    "outliers": ("Outliers beyond, in robust standard deviations", ""),
    "fill": ("Missing points interpolated", ""),
    "method": ("Summits by", ""),
    "prominence": ("Least prominence of a summit", "m"),
    "estimate": ("Surface by", ""),
    "format": ("Format of the scan", ""),
    "pixel": ("Distance of neighbours in the scan", "m"),
    "key": ("Array of its file", ""),
    "channel": ("Channel of its file", ""),
    "valid": ("Possible heights in it", "m"),
    "friction_coefficient": ("Friction coefficient μ", ""),
    "normal_load": ("Normal load", "N"),
    "tightening_load": ("Tightened once to", "N"),
    "yield_stress": ("Yield stress of the softer body", "Pa"),
    "tightening_model": ("Its summits yielded after", ""),
    "outer": ("Its outer radius", "m"),
    "inner": ("Its inner radius", "m"),
    "count": ("How many such", ""),
    "distance": ("At distances", "m"),
    "pressure": ("Pressures", "Pa"),
    "size": ("Bolts", ""),
    "plates": ("Plates", "m"),
    "preload": ("Tension of each", "N"),
    "angle": ("Half angle of the cone", "rad"),
    "edge": ("Edge of the plates", "m"),
    "amplitudes": ("Displacement amplitudes", "m"),
    "force_amplitudes": ("Force amplitudes", "N"),
    "mass": ("Mass", "kg"),
    "length": ("Length", "m"),
    "width": ("Width", "m"),
    "thickness": ("Thickness", "m"),
    "lap": ("Lap", "m"),
    "style": ("Style", ""),
    "patches": ("Patches", ""),
    "element_size": ("Elements in the lap", "m"),
    "modes": ("Modes", ""),
    "base_damping_ratio": ("Base damping ratio", ""),
    "harmonics": ("Harmonics", ""),
    "samples": ("Samples for bands", ""),
    "converge": ("Patches refined", ""),
    "positions": ("Bolts along the lap", "m"),
    "across": ("Bolts across the lap", "m"),
    "shank": ("Shanks", "m"),
    "hole": ("Holes", "m"),
    "washer": ("Washers", "m"),
    "head": ("Heads and nuts", "m"),
    "tension": ("Bolt tension", "N"),
    "torque": ("Tightening torque", "N m"),
    "thread": ("Thread", "m"),
    "nut_factor": ("Nut factor", ""),
    "pitch": ("Pitch", "m"),
    "thread_friction": ("Friction in the thread", ""),
    "bearing_friction": ("Friction under the head", ""),
    "at": ("Sensor at", "m"),
    "direction": ("Its direction", ""),
    "factor": ("Factor on the form", ""),
    "stiffness": ("Stiffness beside the joint", "N/m"),
    "viscous_damping_ratio": ("Viscous damping ratio", ""),
}
"""What the keys of a study stand for, and the SI units of their values."""

LAWS = {
    "greenwood-williamson": ("Greenwood–Williamson", "of a Greenwood–Williamson surface"),
    "population": ("given summits", "of a given population of summits"),
    "sphere": ("one sphere on a flat", "of one sphere on a flat"),
    "table": ("a table", "with a tabulated normal law"),
    "scan": ("summits of a scan", "of a scanned surface"),
    "elliptic-summits": ("elliptic summits", "of a surface with a lay"),
    "persson": ("Persson's, of a power spectrum", "of a surface by its power spectrum"),
    "drawing": ("a drawing", "of a surface by its drawing"),
    "two-faces": ("two rough faces", "of two rough faces"),
}
"""Normal laws by themselves, and in a sentence about their joint."""
# What is said with something else, or in the notes.
_ELSEWHERE = (
    "rigid", "materials", "law", "file", "column", "unit", "start", "to", "points", "measured",
    "x", "y", "gap", "time",
)  # fmt: skip


def study_facts(study: StudyDescription) -> tuple[Facts, ...]:
    """Materials, surface, joint, excitation and oscillator, with what is given of each."""
    groups = [
        Facts(f"Material {name}", _rows(material) or (("Body", "rigid"),))
        for name, material in study.material.items()
    ]
    joint = _rows(study.joint)
    if (surface := study.surface) is None:
        joint = (("Friction law", study.joint.law), *joint)
    else:
        law, _ = LAWS.get(surface.law, (surface.law, ""))
        bodies = (("Bodies", " on ".join(surface.materials)), ("Normal law", law))
        groups.append(Facts("Surface", bodies + _rows(surface)))
    groups += [Facts("Joint", joint), Facts("Excitation", _rows(study.excitation))]
    if study.oscillator is not None:
        groups.append(Facts("Oscillator", _rows(study.oscillator)))
    if study.structure is not None:
        groups.append(Facts("Structure", _rows(study.structure)))
    return tuple(group for group in groups if group.rows)


def _rows(part: Part) -> tuple[tuple[str, str], ...]:
    """What the keys of a part stand for and hold, those of the parts in it included."""
    rows: list[tuple[str, str]] = []
    labels = labels_of(part)
    for name in part.attributes.values():
        value = getattr(part, name)
        if name == "cutoff" and value is None:
            rows.append((KEYS[name][0], NO_CUTOFF))
        if value is None or name in _ELSEWHERE:
            continue
        if name == "curve":
            ends = " to ".join(quantity(x, "m") for x in (value.start, value.to))
            rows.append(("Amplitudes of the curves", f"{ends}, {value.points} points"))
        elif name == "history":
            text = f'{len(value.values)} {value.quantity}s, column "{value.column}"'
            if value.normal_load is not None:
                text += f', normal loads, column "{value.normal_load.column}",'
            rows.append(("Own history", f"{text} of {value.file}"))
        elif name == "load_variation":
            rows.append(("Normal load varies by", in_words(value)))
        elif name == "mesh":
            contacts = ", ".join(f"{a} on {b}" for a, b in value.contacts)
            rows += [("Mesh", value.file), ("Its bodies", ", ".join(value.bodies))]
            rows += [("Its contacts", contacts), ("Its bolts", ", ".join(value.bolts))]
        elif name in ("first", "second"):
            rows += [(f"{name.capitalize()} face: {key}", content) for key, content in _rows(value)]
        elif name == "pressure" and isinstance(value, Part):
            rows.append(("Pressure spread as", str(value.kind)))  # type: ignore[attr-defined]
            rows += [item for item in _rows(value) if item[0] != KEYS["kind"][0]]
        elif isinstance(value, Part):
            rows += _rows(value)
        else:
            meaning, unit = KEYS[name] if name in KEYS else labels[name]
            if name == "density" and isinstance(part, StructurePart):
                meaning, unit = "Mass density", "kg/m³"
            if name == "density" and isinstance(part, TableHeights):
                meaning, unit = "Their density", "1/m"
            rows.append((meaning, quantity(value, unit)))
    return tuple(rows)
