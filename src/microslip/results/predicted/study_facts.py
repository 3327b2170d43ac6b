"""A study in words and units, for the reader of a result."""

from __future__ import annotations

from microslip.report.cells import quantity
from microslip.report.document import Facts
from microslip.runs.columns import in_words
from microslip.study.description import StudyDescription
from microslip.study.part import Part
from microslip.study.scanned_surface import NO_CUTOFF

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
_KIND = "Summit heights"
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
    for name, key in ((part.attributes[name], key) for name, key in part.keys.items()):
        value = getattr(part, name)
        if name == "cutoff" and value is None:
            rows.append((key.heading, NO_CUTOFF))
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
            rows += [(f"{name.capitalize()} face: {label}", text) for label, text in _rows(value)]
        elif name == "pressure" and isinstance(value, Part):
            rows.append(("Pressure spread as", str(value.kind)))  # type: ignore[attr-defined]
            rows += [item for item in _rows(value) if item[0] != _KIND]
        elif isinstance(value, Part):
            rows += _rows(value)
        else:
            rows.append((_KIND if name == "kind" else key.heading, quantity(value, key.unit)))
    return tuple(rows)
