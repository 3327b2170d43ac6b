"""Section on the joint of a scanned face under a load, with the contact solved point by point."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from microslip._core.dataset import DataSet
from microslip._core.quantities import Quantity, json_value, named
from microslip._core.units import engineering
from microslip.contact.figures import face_plot
from microslip.figures.picture import Picture
from microslip.report import cells
from microslip.report.document import Note, Section
from microslip.surfaces.findings import Findings
from microslip.surfaces.joints import contact_words

_QUANTITIES = {
    "normal_stiffness": Quantity("N/m", label="normal stiffness k_n", form="3"),
    "first_loading_stiffness": Quantity("N/m", label="normal stiffness on first loading", form="3"),
    "tangential_stiffness": Quantity("N/m", label="tangential stiffness k_t", form="3"),
    "loss_factor": Quantity("-", label="loss factor η", form=".3g"),
}


def joint_sections(findings: Findings, adapt: cells.Wording = str) -> list[Section]:
    """Return the section on the joint; empty if no joint was requested."""
    face = findings.face
    if face is None:
        return []
    intervals, unknown = face.intervals, (None, None)
    values = {**face.values, "first_loading_stiffness": face.first_loading_stiffness}
    columns = {}
    for name, quantity in _QUANTITIES.items():
        if name == "loss_factor":
            at = f"{quantity.label} at {engineering(face.amplitude, 'm')}"
            quantity = quantity._replace(label=at)
        columns[name] = quantity, [values[name], *(intervals.get(name) or unknown)]
    heads = ("of the face", "value (90 % interval)")
    table = cells.by_quantity("", DataSet.of_rows(columns), heads)
    title = f"The joint at {engineering(face.joint.normal_load, 'N', 4)}"
    notes = [
        f"The face is solved point by point: {contact_words(face.law.numbers)}.",
        "k_n is that of unloading, as ultrasound measures it; a load-deflection test measures that "
        "on first loading.",
        "The interval includes the scatter between pieces of the scan and the effect of the pixel, "
        "but not the uncertainty of load, hardness and friction coefficient."
        if intervals
        else "No interval: the scan is too small to be divided into pieces.",
    ]
    unresolved = face.unresolved_amplitude
    if unresolved is not None:
        notes.append(
            "The scan does not determine the damping of cycles up to "
            f"{engineering(unresolved, 'm')} in amplitude: their energy changes by 25 % or more "
            "if the pixel is doubled."
        )
    return [Section(title, (table, *(Note(adapt(n)) for n in notes)))]


def chapter_rows(findings: Findings) -> list[tuple[str, str]]:
    """Return a table row: normal stiffness of the summit model, and that solved point by point.

    The summit model is that of chapter 19 of *The Mechanics of Jointed Structures* (Springer,
    2018).
    """
    face, chapter = findings.face, findings.chapter
    if face is None or chapter is None:
        return []
    own = engineering(chapter.normal_stiffness, "N/m", 3)
    measured = engineering(face.values["normal_stiffness"], "N/m", 3)
    return [("normal stiffness (the measured face)", f"{own} ({measured})")]


def summary(findings: Findings) -> dict[str, Any] | None:
    """Return the numbers of the joint as plain values; None if no joint was requested."""
    face = findings.face
    if face is None:
        return None
    chapter = findings.chapter
    data: dict[str, Any] = {
        "materials": findings.request.materials,
        **named(findings.request, "normal_load", "friction_coefficient"),
        "area": face.law.area,
        "amplitude": face.amplitude,
        **face.values,
        "first_loading_stiffness": face.first_loading_stiffness,
        "intervals": face.intervals,
        "unresolved_amplitude": face.unresolved_amplitude,
        "face": asdict(face.law.numbers),
        "chapter_normal_stiffness": None if chapter is None else chapter.normal_stiffness,
    }
    return {key: json_value(value) for key, value in data.items()}


def joint_pictures(findings: Findings) -> tuple[Picture, ...]:
    """Return the figure of the face solved point by point; empty if no joint was requested."""
    if findings.face is None:
        return ()
    law = findings.face.law
    which = "" if law.numbers.pieces == 1 else f" on the first of {law.numbers.pieces} pieces"
    return (
        Picture(
            "contact",
            f"Point-by-point solution of the face: pressures{which} under the load, contacts under "
            "this and two lighter loads, and load against separation.",
            lambda: face_plot(law),
            "Pressures, contacts and loads of the scan solved point by point",
        ),
    )
