"""The joint that a scan makes under a load: its numbers, and the pictures of the solved face."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from microslip._core.quantities import json_value, named
from microslip._core.units import engineering
from microslip.contact.figures import face_plot
from microslip.figures.picture import Picture
from microslip.friction import Interface
from microslip.report.document import Column, Note, Section, Table
from microslip.surfaces.findings import Findings

_COLUMNS = (
    Column("separation", "separation", "m", 3),
    Column("contacts", "contacts", "", 3),
    Column("real_area", "real/apparent", "", 3),
    Column("tangential_stiffness", "stiffness", "N/m", 3),
    Column("loss_factor", "η", "", 3),
)
"""Numbers of the joint at rest, and its loss factor at the amplitude."""


def sections(findings: Findings, say: Callable[[str], str] = str) -> list[Section]:
    """Return the section of the joint, or none if no joint was requested."""
    joint, contact = findings.joint, findings.contact
    if joint is None and contact is None:
        return []
    notes = () if contact is None else (Note(say(contact.words())),)
    tables: tuple[Table, ...] = ()
    if joint is not None:
        values = _numbers(findings, joint)
        row = (values["law"], *(values[column.key] for column in _COLUMNS))
        tables = (Table("", (Column("law", "by"), *_COLUMNS), (row,)),)
    load = engineering(findings.request.normal_load or 0.0, "N", 4)
    return [Section(f"The joint at {load}", (*tables, *notes))]


def summary(findings: Findings) -> dict[str, Any] | None:
    """Return the joint as plain values; None if no joint was requested."""
    joint, contact = findings.joint, findings.contact
    if joint is None and contact is None:
        return None
    data: dict[str, Any] = {
        "materials": findings.request.materials or (),
        **named(findings.request, "normal_load", "friction_coefficient", "amplitude"),
        "area": findings.area,
        **({} if joint is None else _numbers(findings, joint)),
        "point_by_point": None
        if contact is None
        else {"missing": contact.missing}
        if contact.law is None
        else asdict(contact.law.numbers),
    }
    return {key: json_value(value) for key, value in data.items()}


def _numbers(findings: Findings, joint: Interface) -> dict[str, Any]:
    surface: Any = joint.surface
    solved = findings.contact is not None and findings.contact.law is not None
    amplitude, separation = findings.request.amplitude, joint.separation
    return {
        "law": "point by point" if solved else "Gaussian summits",
        "separation": separation,
        "contacts": None if solved else float(surface.contact_count(separation)),
        "real_area": float(surface.contact_area(separation)) / float(surface.area),
        "tangential_stiffness": joint.tangential_stiffness,
        "loss_factor": None if amplitude is None else float(joint.loss_factor(amplitude)),
    }


def pictures(findings: Findings) -> tuple[Picture, ...]:
    """Return the picture of the face point by point, or none if it was not solved."""
    contact = findings.contact
    if contact is None or contact.law is None:
        return ()
    law = contact.law
    return (
        Picture(
            "contact",
            "The scan point by point: pressures of its first piece under the load, its contacts "
            "under this load and two lighter ones, and the load against the separation.",
            lambda: face_plot(law),
            "Pressures, contacts and loads of the scan solved point by point",
        ),
    )
