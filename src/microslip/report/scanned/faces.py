"""Two rough faces, several scans of one, or a drawing: their combined surface, and the joint."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Progress
from microslip._core.quantities import json_value, named
from microslip._core.units import engineering
from microslip.errors import InputError
from microslip.figures.kit import length_prefix
from microslip.figures.picture import Picture
from microslip.figures.plot import COLORS, Axis, Panel, Plot, beside
from microslip.friction import Interface, Verdict
from microslip.report.document import (
    Block,
    Column,
    Document,
    Listing,
    Note,
    Section,
    Table,
    Verdicts,
)
from microslip.report.files import header, text_file
from microslip.report.scanned.document import written
from microslip.report.scanned.numbers import FACES_KIND
from microslip.report.scanned.surface_block import faces_block, faces_table
from microslip.scans import SummitStatistics, combine
from microslip.scans.findings import Request
from microslip.study.faces import RoughFace
from microslip.study.readers import FAILED, Place, Reading
from microslip.study.surfaces import ANY_SURFACE

_NAMES = {"": "face", ".first": "first", ".second": "second"}
_QUANTITIES = {
    "density": ("1/m^2", "Density", Column("density", "density [1/mm²]")),
    "radius": ("m", "Radius", Column("radius", "radius")),
    "std": ("m", "Std of heights", Column("std", "std of heights")),
}
_NOTHING = "Nothing is judged without a scan, or materials and a load."


@dataclass(frozen=True)
class Faces:
    """Known properties of the faces."""

    request: Request
    faces: dict[str, RoughFace]
    """Each face by its key in a study."""
    combined: SummitStatistics
    joint: Interface | None
    """At the load, if one was given."""
    verdicts: tuple[Verdict, ...]

    @property
    def ranges(self) -> dict[str, tuple[str, dict[str, tuple[float, float]]]]:
        """Name and ranges of each drawn face, by its key."""
        return {key: (_NAMES[key], face.ranges) for key, face in self.faces.items() if face.ranges}


def analyse(request: Request, progress: Progress | None = None) -> Faces:
    """Read the faces and put them on each other."""
    report = progress or (lambda share: None)
    pair = request.pair()  # what is wrong with materials and load comes first
    reading = Reading()
    place = Place("surface", reading)
    table = faces_table(request, Path())
    part = place.attempt(lambda: ANY_SURFACE.read(table, place))
    report(0.4)
    if part is FAILED or place.attempt(lambda: part.faces) is FAILED:
        key, message = reading.errors[0]
        name = key.rpartition(".")[2].partition(",")[0]  # of an item the list
        of_all = name in ("surface", "first", "second", "scan")
        raise InputError(message if of_all else f"`{name}`: {message}")
    report(0.8)
    joint, verdicts = None, part.verdicts()
    if pair is not None and request.normal_load is not None:
        joint = Interface(part.build(pair), request.friction_coefficient, request.normal_load)
        verdicts = (*joint.validity, *verdicts)
    report(1.0)
    return Faces(request, part.faces, part.statistics, joint, verdicts)


def document(analysis: Faces, folder: Path | None = None) -> Document:
    """Faces alone and together; the study names scans as seen from the folder."""
    combined = analysis.combined
    answer = (
        f"{'The face' if len(analysis.faces) == 1 else 'Both faces together'}, as summits on a "
        f"flat: {written(combined.density, '1/m^2')} per mm², of radius "
        f"{engineering(combined.radius, 'm')}, their heights with a standard deviation of "
        f"{engineering(combined.std, 'm')}."
    )
    picture = Picture(
        "faces",
        "Summits of each face with their scatter from scan to scan or the range that a drawing "
        "leaves, and of both together.",
        lambda: _plot(analysis),
        "Density, radius and spread of the summits of each face",
    )
    text = faces_block(analysis.request, folder or Path())
    sections = (
        Section("Faces", _faces(analysis)),
        *_joint(analysis),
        Section("Figures", (picture,), brief=False),
        Section("Validity", (Verdicts(analysis.verdicts, none=_NOTHING, short=True),)),
        Section("Surface of a study", (Listing(text),), brief=False),
    )
    file = text_file("surface.toml", lambda: text)
    return Document(
        FACES_KIND, "Rough faces", answer, sections, _data(analysis), figure="faces", files=(file,)
    )


def _faces(analysis: Faces) -> tuple[Block, ...]:
    rows = [(_NAMES[key], *_summits(face.statistics, face)) for key, face in analysis.faces.items()]
    if len(rows) > 1:
        rows.append(("together", *_summits(analysis.combined)))
    columns = (Column("face", "face"), *(column for _, _, column in _QUANTITIES.values()))
    sentences = [f"{_NAMES[key].capitalize()}: {f.origin}." for key, f in analysis.faces.items()]
    note = "± is the standard deviation from scan to scan; ranges are what a drawing leaves open."
    return Table("", columns, tuple(rows)), Note(" ".join([*sentences, note]), brief=False)


def _summits(statistics: SummitStatistics, face: RoughFace | None = None) -> list[str]:
    cells = []
    for name, (unit, _, _) in _QUANTITIES.items():
        text = written(getattr(statistics, name), unit)
        if face is not None and face.ranges:
            low, high = face.ranges[name]
            text += f" ({written(low, unit)} to {written(high, unit)})"
        elif face is not None and face.spread is not None:
            text += f" ± {100.0 * getattr(face.spread, name):.2g} %"
        cells.append(text)
    return cells


# -- the joint -------------------------------------------------------------------------------------


def _joint(analysis: Faces) -> list[Section]:
    joint = analysis.joint
    if joint is None:
        return []
    rows = [("as found", *_answers(analysis, joint))]
    for key, (name, ranges) in analysis.ranges.items():
        for quantity, ends in ranges.items():
            for side, end in zip(("lowest", "highest"), ends, strict=True):
                varied_joint = _varied_joint(analysis, key, quantity, end)
                case = f"{side} {quantity}" if len(analysis.faces) == 1 else (
                    f"{side} {quantity} of the {name} face"
                )  # fmt: skip
                rows.append((case, *_answers(analysis, varied_joint)))
    columns = (Column("case", "with"), *_ANSWERS)
    title = f"The joint at {engineering(joint.normal_load, 'N', 4, trim=True)}"
    return [Section(title, (Table("", columns, tuple(rows)),))]


_ANSWERS = (
    Column("contacts", "contacts", "", 3),
    Column("real_area", "real/apparent", "", 3),
    Column("tangential_stiffness", "stiffness", "N/m", 3),
    Column("loss_factor", "η", "", 3),
)


def _answers(analysis: Faces, joint: Interface) -> tuple[float | None, ...]:
    amplitude, area = analysis.request.amplitude, joint.contact_area
    return (
        joint.contact_count,
        None if area is None else area / joint.surface.area,  # type: ignore[attr-defined]
        joint.tangential_stiffness,
        None if amplitude is None else float(joint.loss_factor(amplitude)),
    )


def _varied_joint(analysis: Faces, key: str, quantity: str, value: float) -> Interface:
    """The joint where one number of one face is another."""
    faces = {name: face.statistics for name, face in analysis.faces.items()}
    faces[key] = dataclasses.replace(faces[key], **{quantity: value})  # type: ignore[arg-type]
    joint = analysis.joint
    assert joint is not None
    surface: Any = joint.surface
    surface_with = reduce(combine, faces.values()).to_surface(surface.pair, surface.area)
    return Interface(surface_with, joint.friction_coefficient, joint.normal_load)


# -- as data and drawn ----------------------------------------------------------------------------


def _data(analysis: Faces) -> dict[str, Any]:
    joint, answers = analysis.joint, None
    if joint is not None:
        keys = (column.key for column in _ANSWERS)
        answers = {
            **named(joint, "normal_load", "friction_coefficient"),
            "amplitude": analysis.request.amplitude,
            **dict(zip(keys, _answers(analysis, joint), strict=True)),
        }
    return {
        **header(FACES_KIND, 1, "Rough faces"),
        "faces": {
            _NAMES[key]: {
                **dataclasses.asdict(face.statistics),
                "said": face.origin,
                "scatter": face.spread._asdict() if face.spread else None,
                "ranges": json_value(face.ranges) if face.ranges else None,
            }
            for key, face in analysis.faces.items()
        },
        "together": dataclasses.asdict(analysis.combined),
        "joint": answers,
        "validity": [
            {"name": v.name, "value": json_value(v.value), "limit": v.limit, "word": v.word}
            for v in analysis.verdicts
        ],
        "files": [],
    }


def _plot(analysis: Faces) -> Plot:
    summits = {_NAMES[key]: (face.statistics, face) for key, face in analysis.faces.items()}
    panels = []
    for name, (unit, head, _) in _QUANTITIES.items():
        values = [getattr(statistics, name) for statistics, _ in summits.values()]
        every = [*values, getattr(analysis.combined, name)] if len(summits) > 1 else values
        scale, letter = length_prefix(max(every))
        scale, label = (1e6, "1/mm²") if unit == "1/m^2" else (scale, f"{letter}m")
        ticks = [(float(i), text) for i, text in enumerate([*summits, "together"][: len(every)])]
        panel = Panel(
            Axis("", -0.6, len(every) - 0.4, ticks=ticks),
            Axis(log=True),
            note=f"{head} [{label}]",
        )
        for at, (value, (_, face)) in enumerate(zip(values, summits.values(), strict=True)):
            ends = face.ranges[name] if face.ranges else None
            if face.spread is not None and math.isfinite(getattr(face.spread, name)):
                share = min(getattr(face.spread, name), 0.9)
                ends = value * (1.0 - share), value * (1.0 + share)
            if ends is not None:
                panel.line([at, at], np.array(ends) / scale, COLORS[1])
            panel.marks([at], [value / scale], COLORS[0], filled=True)
        if len(every) > len(values):
            panel.marks([len(values)], [every[-1] / scale], COLORS[2], marker="s", filled=True)
        panels.append(panel)
    return beside(panels, 3.2, "Summits of rough faces")
