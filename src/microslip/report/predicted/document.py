"""Document of a prediction: answer, tables, figures, verdicts and the study."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.report.cells import quantity_text
from microslip.report.document import (
    Block,
    Document,
    Facts,
    Headline,
    Items,
    Listing,
    Markup,
    Note,
    Section,
)
from microslip.report.predicted.figures import prediction_pictures
from microslip.report.predicted.numbers import KIND, REMINDER
from microslip.report.predicted.scatter_document import scatter_sections
from microslip.report.predicted.tables import (
    cycle_table,
    history_table,
    rest_section,
    validity_verdicts,
)
from microslip.report.structure.document import structure_answer, structure_sections
from microslip.report.structure.document import structure_headline as structure_number
from microslip.report.structure.judged import with_structure
from microslip.study.consistency import unit_warnings
from microslip.study.description import StudyDescription
from microslip.study.measured_face import NO_CUTOFF
from microslip.study.part import Part
from microslip.study.runs.prediction import Prediction

REMARK = (
    "η (loss factor) and ζ = η/2 (damping ratio) describe the interface, not a mode: in a "
    "structure ζ_mode = ΣE_d / 4πU."
)


def prediction_document(result: Prediction) -> Document:
    """Return the document of a prediction; its data is the summary."""
    study, summary = result.study, result.summary
    joints = summary["joints"]
    by_force = study.excitation.force_amplitudes is not None
    sections = [] if result.structure is None else [*structure_sections(result.structure)]
    sections += scatter_sections(result)
    if study.reports_joint:
        sections += [
            rest_section(joints, _law(study)),
            Section("Cycles", (cycle_table(joints, by_force=by_force),)),
        ]
    if result.histories:
        sections.append(Section("History", (history_table(joints),)))
    notes = tuple(note for note in summary["notes"] if note != REMINDER)  # shown as a remark
    computed = [Note(subject(result))] if study.reports_joint else []
    description: list[Block] = [*computed, *study_facts(study), Listing(study.text)]
    verdicts = validity_verdicts(study, result.joints)
    if result.structure is not None:
        verdicts = with_structure(verdicts, result.structure)
    reminder = [Note(REMARK)] if study.reports_joint else []
    sections += [
        Section("Figures", prediction_pictures(result), brief=False),
        Section("Validity", (verdicts,)),
        Section("Notes", (*([Items(notes)] if notes else []), *reminder)),
        Section("Study", tuple(description), brief=False),
        Section("Equations", (Markup(equations(result)),), brief=False),
    ]
    title, sentence, number, figure = "Joint", answer(result), _number(result), "loops"
    if (structure := result.structure) is not None:
        title, figure = "Structure", "modal_curves"
        sentence, number = structure_answer(structure), structure_number(structure)
    title, remarks = summary["title"] or title, tuple(unit_warnings(study))
    return Document(KIND, title, sentence, tuple(sections), summary, remarks, number, figure)


def _middle(result: Prediction) -> tuple[int, int]:
    """Return the indices of the load and amplitude in the middle, used for the headline."""
    return len(result.joints) // 2, (len(result.rows[0].amplitude) - 1) // 2


def _written(value: float, unit: str) -> str:
    return engineering(value, unit, 4, trim=True)


def _excitation(result: Prediction) -> tuple[str, str, list[Floats]]:
    """Return name and unit of the given amplitudes, and their values for each load."""
    if result.study.excitation.force_amplitudes is not None:
        return "force amplitude", "N", [row.force_amplitude for row in result.rows]
    return "displacement amplitude", "m", [row.amplitude for row in result.rows]


def _case(result: Prediction) -> str:
    """Format the amplitude and load of the headline, such as "±300 nm and 2 kN"."""
    load, place = _middle(result)
    _, unit, amplitudes = _excitation(result)
    case = f"±{_written(float(amplitudes[load][place]), unit)}"
    normal = getattr(result.joints[load], "normal_load", None)
    return case if normal is None else f"{case} and {_written(normal, 'N')}"


def answer(result: Prediction) -> str:
    """Describe the energy dissipated per cycle in a sentence."""
    load, place = _middle(result)
    row = result.rows[load]
    share = float(row.force_ratio[place])
    reached = f"the force reaches {significant(100.0 * share)} % of the friction limit"
    if share > 0.999:
        reached = "the joint reaches gross slip"
    return (
        f"At {_case(result)} a cycle dissipates "
        f"{engineering(float(row.dissipated_energy[place]), 'J')}, "
        f"the loss factor is η = {significant(float(row.loss_factor[place]))} and {reached}."
    )


def _number(result: Prediction) -> Headline:
    load, place = _middle(result)
    eta = float(result.rows[load].loss_factor[place])
    every = np.concatenate([row.loss_factor for row in result.rows])
    every = every[np.isfinite(every)]
    band = f"ζ = η/2 = {significant(0.5 * eta)}"
    if (scatter := result.scatter) is not None:
        ends = scatter.bands["loss_factor"].values[[0, -1], load, place].tolist()
        shares = " to ".join(f"{100.0 * share:g}" for share in scatter.quantiles[[0, -1]])
        ends_text = "not measured" if np.isnan(ends).any() else " to ".join(map(significant, ends))
        band = f"{shares} %: {ends_text}; {band}"
    elif every.size > 1:
        ends = [float(every.min()), float(every.max())]
        band += f"; from {' to '.join(map(significant, ends))} "
        band += "over the loads and amplitudes of the study"
    return Headline(f"loss factor η at {_case(result)}", significant(eta), band)


def subject(result: Prediction) -> str:
    """Describe what was computed in a sentence."""
    noun, unit, amplitudes = _excitation(result)
    sentence = (
        f"Hysteresis, stiffness and damping {_of(result.study)}, "
        f"cycled at {_range_text(noun, amplitudes[0].tolist(), unit)}"
    )
    if result.histories:
        sentence += f", along a history of {result.histories[0].force.size} samples"
    return sentence + "."


def _of(study: StudyDescription) -> str:
    if not study.joint.loads:
        return f"by the friction law {study.joint.law}"
    law = study.surface.law
    _, surface = LAW_WORDS.get(law, ("", f"of the surface {law}"))
    loads = _range_text("normal load", [*study.joint.loads], "N")
    if study.joint.pressure is not None:
        surface += f" under a pressure spread as {study.joint.pressure.kind}"
    return f"{surface}, friction coefficient {study.joint.friction_coefficient:g}, at {loads}"


def _range_text(noun: str, values: list[float], unit: str) -> str:
    if len(values) == 1:
        return f"one {noun}, {_written(values[0], unit)}"
    ends = " to ".join(_written(end, unit) for end in (min(values), max(values)))
    return f"{len(values)} {noun}s, {ends}"


# -- equations -----------------------------------------------------------------------------------


def equations(result: Prediction) -> str:
    """Return the equations used for this result, in MathML."""
    holds = {_law(result.study)}
    if getattr(result.joints[0], "contact_area", None) is not None:
        holds.add("contacts")
    text = Path(__file__).with_name("equations.html").read_text(encoding="utf-8")
    # Each part starts with a comment that names its condition.
    head, *parts = re.split(r"<!-- (.+?) -->\n", text)
    sections = zip(parts[::2], parts[1::2], strict=True)
    return head + "".join(part for need, part in sections if need == "always" or need in holds)


def _law(study: StudyDescription) -> str:
    surface = study.surface
    return str(study.joint.law) if surface is None else surface.law


LAW_WORDS = {
    "greenwood-williamson": ("Greenwood–Williamson", "of a Greenwood–Williamson surface"),
    "population": ("given summits", "of a given population of summits"),
    "sphere": ("one sphere on a flat", "of one sphere on a flat"),
    "table": ("a table", "with a tabulated normal law"),
    "face": ("a rough face", "of a rough face"),
}
"""Normal laws as a label, and in a sentence about the joint."""
_KIND = "Summit heights"
# Keys shown elsewhere or in the notes.
_ELSEWHERE = (
    "rigid", "materials", "law", "file", "column", "unit", "start", "to", "points", "measured",
    "x", "y", "gap", "time",
)  # fmt: skip
_BESIDE = {"interfaces": "rz"}
"""Keys that are only shown together with another key."""


def study_facts(study: StudyDescription) -> tuple[Facts, ...]:
    """Return the given values of the study: materials, surface, joint and excitation."""
    groups = [
        Facts(f"Material {name}", _rows(material) or (("Body", "rigid"),))
        for name, material in study.material.items()
    ]
    joint = _rows(study.joint)
    if not study.reports_joint:  # the bolts determine the load
        load = study.joint.keys["normal_load"].heading
        joint = tuple(row for row in joint if row[0] != load)
    if (surface := study.surface) is None:
        joint = (("Friction law", shorten(repr(study.joint.build()), 200)), *joint)
    else:
        law, _ = LAW_WORDS.get(surface.law, (surface.law, ""))
        bodies = (("Bodies", " on ".join(surface.materials)), ("Normal law", law))
        groups.append(Facts("Surface", bodies + _rows(surface)))
    groups += [Facts("Joint", joint), Facts("Excitation", _rows(study.excitation))]
    if study.structure is not None:
        groups.append(Facts("Structure", _rows(study.structure)))
    return tuple(group for group in groups if group.rows)


def _rows(part: Part) -> tuple[tuple[str, str], ...]:
    rows: list[tuple[str, str]] = []
    for name, key in ((part.attributes[name], key) for name, key in part.keys.items()):
        value = getattr(part, name)
        if name == "cutoff" and value is None:
            rows.append((key.heading, NO_CUTOFF))
        if value is None or value == () or name in _ELSEWHERE:
            continue
        if name in _BESIDE and not getattr(part, _BESIDE[name]):
            continue
        if name == "curve":
            ends = " to ".join(quantity_text(x, "m") for x in (value.start, value.to))
            rows.append(("Amplitudes of the curves", f"{ends}, {value.points} points"))
        elif name == "history":
            text = f'{len(value.values)} {value.quantity}s, column "{value.column}"'
            rows.append(("Own history", f"{text} of {value.file}"))
        elif name == "mesh":
            contacts = ", ".join(f"{a} on {b}" for a, b in value.contacts)
            rows += [("Mesh", value.file), ("Its bodies", ", ".join(value.bodies))]
            rows += [("Its contacts", contacts), ("Its bolts", ", ".join(value.bolts))]
        elif name == "pressure" and isinstance(value, Part):
            rows.append(("Pressure spread as", str(value.kind)))  # type: ignore[attr-defined]
            rows += [item for item in _rows(value) if item[0] != _KIND]
        elif isinstance(value, tuple) and isinstance(value[0], Part):
            word = name.removesuffix("s").capitalize()
            for count, item in enumerate(value, start=1):
                rows += [(f"{word} {count}: {label}", text) for label, text in _rows(item)]
        elif isinstance(value, Part):
            rows += _rows(value)
        else:
            rows.append((_KIND if name == "kind" else key.heading, quantity_text(value, key.unit)))
    return tuple(rows)
