"""Document of a prediction: main result, tables, figures, verdicts and the study."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering, significant
from microslip.report.document import (
    Block,
    Document,
    Items,
    Note,
    Section,
)
from microslip.report.predicted.figures import prediction_pictures
from microslip.report.predicted.numbers import KIND, REMINDER
from microslip.report.predicted.preview import quantities, quantity_table
from microslip.report.predicted.scatter_document import scatter_sections
from microslip.report.predicted.tables import (
    cycle_table,
    history_table,
    joint_table,
    rest_section,
    validity_verdicts,
)
from microslip.report.structure.document import structure_answer, structure_sections
from microslip.report.structure.judged import with_structure
from microslip.study.consistency import unit_warnings
from microslip.study.description import StudyDescription
from microslip.study.runs.prediction import Prediction

REMARK = (
    "η (loss factor) and ζ = η/2 (damping ratio) describe the interface, not a mode: in a "
    "structure ζ_mode = ΣE_d / 4πU."
)


def prediction_document(result: Prediction) -> Document:
    """Return the document of a prediction; its field ``data`` holds the content of summary.json."""
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
    elif result.structure is not None:
        contact = joint_table(joints, _law(study), "Contact of surface.area, mean pressure")
        sections.append(Section("Contact", (contact,), brief=False))
    if result.histories:
        sections.append(Section("History", (history_table(joints),)))
    notes = tuple(note for note in summary["notes"] if note != REMINDER)  # shown as a remark
    computed = [Note(subject(result))] if study.reports_joint else []
    description: list[Block] = [*computed, quantity_table(quantities(study))]
    verdicts = validity_verdicts(study, result.joints)
    if result.structure is not None:
        verdicts = with_structure(verdicts, result.structure)
    reminder = [Note(REMARK)] if study.reports_joint else []
    sections += [
        Section("Figures", prediction_pictures(result), brief=False),
        Section("Validity", (verdicts,)),
        Section("Notes", (*([Items(notes)] if notes else []), *reminder)),
        Section("Study", tuple(description), brief=False),
    ]
    title, sentence, figure = "Joint", answer(result), "loops"
    if (structure := result.structure) is not None:
        title, figure = "Structure", "modal_curves"
        sentence = structure_answer(structure)
    title, remarks = summary["title"] or title, tuple(unit_warnings(study))
    return Document(KIND, title, sentence, tuple(sections), summary, remarks, figure)


def _middle(result: Prediction) -> tuple[int, int]:
    return len(result.joints) // 2, (len(result.rows[0].amplitude) - 1) // 2


def _written(value: float, unit: str) -> str:
    return engineering(value, unit, 4, trim=True)


def _excitation(result: Prediction) -> tuple[str, str, list[Floats]]:
    if result.study.excitation.force_amplitudes is not None:
        return "force amplitude", "N", [row.force_amplitude for row in result.rows]
    return "displacement amplitude", "m", [row.amplitude for row in result.rows]


def _case(result: Prediction) -> str:
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
    band = ""
    if (scatter := result.scatter) is not None:
        ends = scatter.bands["loss_factor"].values[[0, -1], load, place]
        shares = " to ".join(f"{100.0 * share:g}" for share in scatter.quantiles[[0, -1]])
        band = " to ".join(map(significant, ends.tolist()))
        band = f" ({shares} %: {'not measured' if np.isnan(ends).any() else band})"
    reached = f"the force reaches {significant(100.0 * share)} % of the friction limit"
    if share > 0.999:
        reached = "the joint reaches gross slip"
    return (
        f"At {_case(result)} a cycle dissipates "
        f"{engineering(float(row.dissipated_energy[place]), 'J')}, "
        f"the loss factor is η = {significant(float(row.loss_factor[place]))}{band} and {reached}."
    )


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
    surface = LAW_WORDS.get(law, f"of the surface {law}")
    loads = _range_text("normal load", [*study.joint.loads], "N")
    if study.joint.pressure is not None:
        surface += f" under a pressure spread as {study.joint.pressure.kind}"
    return f"{surface}, friction coefficient {study.joint.friction_coefficient:g}, at {loads}"


def _range_text(noun: str, values: list[float], unit: str) -> str:
    if len(values) == 1:
        return f"one {noun}, {_written(values[0], unit)}"
    ends = " to ".join(_written(end, unit) for end in (min(values), max(values)))
    return f"{len(values)} {noun}s, {ends}"


def _law(study: StudyDescription) -> str:
    surface = study.surface
    return str(study.joint.law) if surface is None else surface.law


LAW_WORDS = {
    "greenwood-williamson": "of a Greenwood–Williamson surface",
    "population": "of a given population of summits",
    "sphere": "of one sphere on a flat",
    "table": "with a tabulated normal law",
    "face": "of a rough face",
}
"""Normal laws in a sentence about the joint."""
