"""Preview of a study: its values in SI units and the joint at rest, without a run."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import Progress
from microslip._core.quantities import QUANTITY_UNITS
from microslip._version import __version__
from microslip.report import cells
from microslip.report.cells import si
from microslip.report.document import Document, Items, Section, Table
from microslip.report.predicted.numbers import load_notes
from microslip.report.predicted.tables import rest_section, validity_verdicts
from microslip.study.build import build_joints
from microslip.study.consistency import unit_warnings
from microslip.study.description import StudyDescription
from microslip.study.part import Part
from microslip.study.runs.prediction import with_defaults
from microslip.study.runs.rest import joint_entry
from microslip.study.runs.structure_cost import cost_of
from microslip.study.uncertain import Spread

MOST_ITEMS = 4
_WORDS = {
    "outside": "Some assumptions of the model are violated; the study can still be run.",
    "watch": "Ready to run; see the verdicts.",
    "not judged": "Ready to run; some assumptions could not be judged, see the verdicts.",
}


def preview(study: StudyDescription, progress: Progress | None = None) -> Document:
    """Return a document of the values of a study and the joint at rest, without running it."""
    joints = build_joints(study, progress)
    excited, notes = with_defaults(study, joints)
    default_notes = [] if study.structure else notes
    excitation, loads = excited.excitation, len(joints)
    amplitudes = excitation.amplitudes or excitation.force_amplitudes or ()
    points = 0 if excitation.curve is None else excitation.curve.points
    samples = len(excitation.history.values) if excitation.history else 0
    data: dict[str, Any] = {
        "kind": "microslip-check",
        "generator": {"name": "microslip", "version": __version__},
        "title": study.title,
        "study": study.plain(),
        "quantities": list(quantities(study)),
        "notes": [
            *study.notes,
            *default_notes,
            *load_notes(study, joints[0]),
        ],
        "questions": unit_warnings(study),
        "joints": [joint_entry(study, joint) for joint in joints],
        "loops": loads * len(amplitudes),
        "points": loads * points,
        "samples": loads * samples,
        "units": dict(QUANTITY_UNITS),
    }
    cost = None if study.structure is None else cost_of(study)
    if cost is not None:
        data["structure"] = cost
    numbers = data["quantities"]
    sections = [
        *(() if cost is None else [Section("Structure", (_size(cost),))]),
        *([Section("Quantities", (quantity_table(numbers),))] if numbers else []),
        # In a structure the patches, not the surface, have areas, and there is no single joint.
        *(() if cost is not None else [rest_section(data["joints"])]),
        Section("Validity", (validity_verdicts(study, joints),)),
    ]
    if data["notes"]:
        sections.append(Section("Notes", (Items(tuple(data["notes"])),)))
    return Document(study.title or "Joint", "", tuple(sections), data, tuple(data["questions"]))


def _size(cost: dict[str, Any]) -> Table:
    low, high = cost["seconds"]
    unit, name = (1.0, "s") if high < 120.0 else (60.0, "min")
    duration = f"{math.floor(low / unit)} to {math.ceil(high / unit)} {name}"
    steps = zip(("factorisation", "reduction", "balance"), cost["measured"], strict=True)
    measured = ", ".join(f"{name} {time:.2g} s" for name, time in steps)
    rows = (
        ("Finite elements", f"{cost['degrees_of_freedom']} degrees of freedom"),
        ("Patches", str(cost["patches"])),
        ("Reductions", str(cost["reductions"])),
        ("Curves of modes", str(cost["balances"])),
        ("Measured here", measured),
        ("Estimated time of a run", duration),
        ("Memory, about", f"{cost['gigabytes']:.1f} GB"),
    )
    return cells.texts("Size", rows)


def next_step(document: Document) -> str:
    """Describe what the command suggested below the preview will compute."""
    data = document.data
    parts = [f"{data['loops']} loops", f"curves of {data['points']} points in all"]
    if "structure" in data:
        parts = [f"{data['structure']['balances']} curves of modes"]
    elif data["samples"]:
        parts.append(f"histories of {data['samples']} samples in all")
    word = _WORDS.get(document.word, "Ready to run.")
    return f"{word} To compute {', '.join(parts)}:"


def quantity_table(numbers: Iterable[dict[str, Any]]) -> Table:
    """Return the table of the numbers of a study, as written and in SI units."""
    rows = []
    for quantity in numbers:
        written, unit = quantity["written"], quantity["unit"]
        if "count" in quantity:
            ends = (si(quantity[end]) for end in ("smallest", "largest"))
            value = f"{quantity['count']} values, {' to '.join(ends)}"
        else:
            value = _list(quantity["value"], si)
        text = "– (table of metals)" if written is None else _list(written, str)
        rows.append((quantity["key"], text, value if unit == "-" else f"{value} {unit}"))
    table = cells.texts("Quantities", rows, ("key", "written", "in SI units"))
    return replace(table, most=len(rows))


def _list(value: Any, write: Callable[[Any], str]) -> str:
    if not isinstance(value, list):
        return write(value)
    if len(value) <= MOST_ITEMS:
        return ", ".join(map(write, value))
    first, second, last = map(write, (value[0], value[1], value[-1]))
    return f"{first}, {second} … {last} ({len(value)})"


def quantities(study: StudyDescription) -> Iterator[dict[str, Any]]:
    """Yield each number of a study: its key, its text in the study, and its value [SI unit]."""
    source = tomllib.loads(study.text)
    values = study.by_keys()
    history = study.excitation.history
    # Materials also have the values added from the table of metals.
    materials = source.pop("material", {})
    material = {
        name: {**dict.fromkeys(keys), **materials.get(name, {})}
        for name, keys in values["material"].items()
    }
    units = dict(_units(study))
    for key, written, value in _walk({"material": material, **source}, values):
        unit = units.get(key) or "-"
        if key == "excitation.history" and history is not None:
            value, unit = history.values, "N" if history.quantity == "force" else "m"
        if isinstance(written, dict) and "file" not in written:
            written = _pairs(written)
            spread = value[0] if isinstance(value, tuple) else value
            ends = (float(spread),)
            if isinstance(spread, Spread) and (spread.values or spread.low is not None):
                ends = spread.quantiles(np.array([0.0, 1.0])).tolist()
            quantity: dict[str, Any] = {"value": list(ends) if len(ends) > 1 else ends[0]}
        elif isinstance(written, dict):
            written = f'{written.get("file")}, column "{written.get("column")}"'
            low, high = float(np.min(value)), float(np.max(value))
            quantity = {"count": len(value), "smallest": low, "largest": high}
        elif isinstance(written, list):
            written = [_pairs(item) if isinstance(item, dict) else item for item in written]
            quantity = {"value": list(value)}
        else:
            quantity = {"value": _first_item(value)}
        yield {"key": key, "written": written, **quantity, "unit": unit}


def _pairs(written: dict[str, Any]) -> str:
    texts = (f"{len(x)} values" if isinstance(x, list) else x for x in written.values())
    return ", ".join(f"{name} = {text}" for name, text in zip(written, texts, strict=True))


def _units(part: Any, path: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(part, dict):
        for name, inner in part.items():
            yield from _units(inner, f"{path}.{name}".lstrip("."))
    elif isinstance(part, Part):
        for name, key in part.keys.items():
            here = f"{path}.{name}".lstrip(".")
            yield here, key.unit
            yield from _units(getattr(part, part.attributes[name]), here)


def _walk(source: Any, values: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the keys of a study that hold numbers or a file of numbers.

    Each one comes as (key, entry as written in the file, value as read).
    """
    for key, written in source.items():
        here, value = f"{path}{key}", values.get(key)
        if isinstance(written, dict) and "file" in written and path != "structure.":
            yield here, written, value
        elif isinstance(written, dict) and isinstance(value, dict):
            yield from _walk(written, value, f"{here}.")
        elif key != "schema" and _is_number(_first_item(value)):
            yield here, written, value


def _first_item(value: Any) -> Any:
    return value[0] if isinstance(value, (list, tuple)) else value


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
