"""Document of a prediction: main result, tables, figures, verdicts and the study."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from microslip._core.quantities import QUANTITIES
from microslip._core.units import engineering, significant
from microslip.figures.picture import Picture
from microslip.figures.plot import Plot
from microslip.report.document import Block, Document, Items, Note, Section
from microslip.report.predicted.figures import (
    backbone,
    contact_state,
    energy_damping,
    face,
    loops,
)
from microslip.report.predicted.history_figure import history, pressure
from microslip.report.predicted.numbers import REMINDER, driven
from microslip.report.predicted.preview import quantities, quantity_table
from microslip.report.predicted.tables import (
    cycle_table,
    history_table,
    joint_table,
    rest_section,
    scatter_sections,
    validity_verdicts,
)
from microslip.report.structure.document import structure_answer, structure_sections
from microslip.report.structure.judged import with_structure
from microslip.study.consistency import unit_warnings
from microslip.study.description import StudyDescription
from microslip.study.measured_face import MeasuredFace
from microslip.study.runs.prediction import Prediction
from microslip.study.surfaces import TableSurface

REMARK = (
    "η (loss factor) and ζ = η/2 (damping ratio) describe the interface, not a mode: in a "
    "structure ζ_mode = ΣE_d / 4πU."
)


def prediction_document(result: Prediction) -> Document:
    """Return the document of a prediction; its field ``data`` holds the content of summary.json."""
    study, summary = result.study, result.summary
    joints = summary["joints"]
    sections = [] if result.structure is None else [*structure_sections(result.structure)]
    sections += scatter_sections(result)
    if study.reports_joint:
        sections += [
            rest_section(joints),
            Section("Cycles", (cycle_table(joints, driven(result)),)),
        ]
    elif result.structure is not None:
        contact = joint_table(joints, "Contact of surface.area, mean pressure")
        sections.append(Section("Contact", (contact,), brief=False))
    if result.histories:
        sections.append(Section("History", (history_table(joints),)))
    notes = tuple(note for note in summary["notes"] if note != REMINDER)  # shown as a remark
    verdicts = validity_verdicts(study, result.joints)
    if result.structure is not None:
        verdicts = with_structure(verdicts, result.structure)
    reminder = [Note(REMARK)] if study.reports_joint else []
    sections += [
        Section("Figures", prediction_pictures(result), brief=False),
        Section("Validity", (verdicts,)),
        Section("Notes", (*([Items(notes)] if notes else []), *reminder)),
        Section("Study", tuple(_description(study)), brief=False),
    ]
    title, sentence, figure = "Joint", answer(result), "loops"
    if (structure := result.structure) is not None:
        title, figure = "Structure", "modal_curves"
        sentence = structure_answer(structure)
    title, remarks = summary["title"] or title, tuple(unit_warnings(study))
    return Document(title, sentence, tuple(sections), summary, remarks, figure)


def _description(study: StudyDescription) -> Iterator[Block]:
    if study.surface is None:
        yield Note(f"Friction law: {study.joint.law}.")
    else:
        yield Note(f"Law of the surface: {study.surface.law}.")
    if numbers := [*quantities(study)]:
        yield quantity_table(numbers)


def answer(result: Prediction) -> str:
    """Describe the energy dissipated per cycle in a sentence."""
    load, place = len(result.joints) // 2, (len(result.rows[0].amplitude) - 1) // 2
    row, by = result.rows[load], driven(result)
    case = f"±{engineering(float(getattr(row, by)[place]), QUANTITIES[by].unit, 4, trim=True)}"
    if (normal := getattr(result.joints[load], "normal_load", None)) is not None:
        case += f" and {engineering(normal, 'N', 4, trim=True)}"
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
        f"At {case} a cycle dissipates "
        f"{engineering(float(row.dissipated_energy[place]), 'J')}, "
        f"the loss factor is η = {significant(float(row.loss_factor[place]))}{band} and {reached}."
    )


# -- figures ---------------------------------------------------------------------------------------


def _drawn(result: Prediction) -> dict[Callable[[Prediction], Plot], bool]:
    """Return every figure in reading order, and whether it is drawn for a result."""
    study = result.study
    # A tabulated normal law has no contacts.
    has_contacts = study.surface is not None and not isinstance(study.surface, TableSurface)
    is_pressed = has_contacts and study.joint.pressure is not None
    alone = study.reports_joint
    return {
        **dict.fromkeys((loops, backbone, energy_damping), alone),
        contact_state: has_contacts and not is_pressed and alone,
        pressure: is_pressed,
        history: bool(result.histories),
        face: isinstance(study.surface, MeasuredFace),
    }


def prediction_pictures(result: Prediction) -> tuple[Picture, ...]:
    """Return the figures of a result, in reading order."""
    pictures = []
    for figure, is_drawn in _drawn(result).items():
        if not is_drawn:
            continue
        name = figure.__name__
        alternative, caption = _CAPTIONS[name]
        if result.scatter is not None:
            between = " to ".join(f"{100.0 * end:g}" for end in result.scatter.quantiles[[0, -1]])
            edges = "Dashed" if name == "loops" else "Shaded"
            if name in ("loops", "backbone", "energy_damping", "contact_state"):
                of = "uncertain inputs" if result.scatter.inputs else "identified law"
                caption += f" {edges}: the {between} % band of the {of}."
        pictures.append(Picture(name, caption, partial(figure, result), alternative))
    return tuple(pictures)


_PANELS = "one panel for each amplitude and one loop for each load"
_CAPTIONS = {
    "loops": (
        "Hysteresis loops, force against displacement",
        f"Closed hysteresis loops, {_PANELS}. Thin "
        "and pointed: most contacts stick (microslip). A parallelogram with flat ends: gross slip. "
        "The area is the energy dissipated per cycle.",
    ),
    "backbone": (
        "Force and stiffness of first loading against displacement",
        "First loading from rest (the backbone), which determines every loop: its initial slope "
        "is kₜ, and it ends at the force limit μN. Below, the tangent stiffness and the secant "
        "stiffness, which is the stiffness of an equivalent linear joint at that amplitude.",
    ),
    "energy_damping": (
        "Dissipated energy, loss factor and exponent against displacement amplitude",
        "Energy dissipated per cycle, loss factor η with damping ratio ζ = η/2, and local exponent "
        "of the energy, against the displacement amplitude; markers are the loops. The exponent "
        "is 3 in the microslip of a smooth backbone and 1 in gross slip.",
    ),
    "contact_state": (
        "Sticking fraction of the contact area against displacement",
        "Fraction of the contact area that sticks after a displacement from rest.",
    ),
    "face": (
        "Pressures and contacts on a piece of the face, and its loads against the separation",
        "Point-by-point solution of the face: pressures on its first piece at the tightening load, "
        "contacts at this and two lighter loads, and mean pressure against separation; the pieces "
        "of the scan lie within the grey band.",
    ),
    "pressure": (
        "Pressure over the faces, and local force over the local slip limit",
        "Distribution of the normal load over the faces; below, the local force over the local "
        "slip limit after a displacement from rest: regions of low pressure slide first, and "
        "slip spreads from there as the displacement grows.",
    ),
    "history": (
        "Displacement, force and dissipated energy along the history, and its path",
        "Response to the given history from rest: displacement, force and cumulative dissipated "
        "energy, and force against displacement.",
    ),
}
