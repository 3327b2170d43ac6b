"""Two rough faces, several scans of one, or a drawing: what they are together, and their joint."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.units import engineering, significant
from microslip.errors import InputError, StudyError
from microslip.friction import Interface, Verdict
from microslip.report.document import (
    Block,
    Column,
    Document,
    Listing,
    Note,
    Picture,
    Section,
    Table,
    Verdicts,
)
from microslip.report.files import Progress, header, standard_files, text_file, write_all
from microslip.report.plot import COLORS, Axis, Panel, Plot
from microslip.report.scales import length_prefix
from microslip.results.scanned.findings import Request
from microslip.results.scanned.numbers import FACES_KIND
from microslip.results.scanned.surface_block import faces_block
from microslip.scans import SummitStatistics, combine
from microslip.study.build import build_surface
from microslip.study.description import StudyDescription
from microslip.study.faces import RoughFace

_NAMES = {"": "face", ".first": "first", ".second": "second"}
_QUANTITIES = {"density": "1/m^2", "radius": "m", "std": "m"}
_HEADS = {"density": "Density", "radius": "Radius", "std": "Std of heights"}
_NOTHING = "Nothing is judged without a scan, or materials and a load."
_FLAGS = {"normal_load": "load", "friction_coefficient": "friction"}
_STUDY = """\
schema = 1
{surface}
[joint]
friction_coefficient = {friction!r}
normal_load = {load}
"""


@dataclass(frozen=True)
class Faces:
    """What is known of the faces."""

    request: Request
    known: dict[str, RoughFace]
    """Each face by its key in a study."""
    together: SummitStatistics
    joint: Interface | None
    """At the load, if one was given."""
    verdicts: tuple[Verdict, ...]

    @property
    def ranges(self) -> dict[str, tuple[str, dict[str, tuple[float, float]]]]:
        """Of each drawn face by its key what it is called and its ranges."""
        return {key: (_NAMES[key], face.ranges) for key, face in self.known.items() if face.ranges}


def analyse(request: Request, progress: Progress | None = None) -> Faces:
    """Read the faces and put them on each other."""
    report = progress or (lambda share: None)
    request.pair()  # what is wrong with materials and load comes first
    load = 1.0 if request.normal_load is None else request.normal_load
    text = _STUDY.format(
        surface=faces_block(request, Path()),
        friction=request.friction_coefficient,
        load=f'"{load!r} N"',
    )
    try:
        study = StudyDescription.from_toml(text, "surface", folder=Path())
        report(0.4)
        part: Any = study.surface
        known, together = part.faces, part.statistics
        report(0.8)
        joint, verdicts = None, part.verdicts()
        if request.normal_load is not None:
            joint = Interface(
                build_surface(study), request.friction_coefficient, request.normal_load
            )
            verdicts = (*joint.validity, *verdicts)
    except StudyError as error:
        raise InputError(_as_option(str(error))) from None
    report(1.0)
    return Faces(request, known, together, joint, verdicts)


def _as_option(message: str) -> str:
    """An error of a study as one of the command that has made it."""

    def flag(found: re.Match[str]) -> str:
        key = found[1]
        return "" if key == "scan" else f"--{_FLAGS.get(key, key).replace('_', '-')}: "

    keys = r"^surface: (?:surface|joint)(?:\.(?:first|second))?\.(\w+)(?:, item \d+)?: "
    return re.sub(keys, flag, message).replace(" in the folder of the study", "")


def document(found: Faces, folder: Path | None = None, kinds: Sequence[str] = ("svg",)) -> Document:
    """What the faces are, alone and together."""
    together = found.together
    answer = (
        f"{'The face' if len(found.known) == 1 else 'Both faces together'}, as summits on a flat: "
        f"{_per_area(together.density)} per mm², of radius {engineering(together.radius, 'm')}, "
        f"their heights with a standard deviation of {engineering(together.std, 'm')}."
    )
    picture = Picture(
        "faces",
        "Summits of each face with their scatter from scan to scan or the range that a drawing "
        "leaves, and of both together.",
        lambda: _plot(found),
        "Density, radius and spread of the summits of each face",
    )
    text = faces_block(found.request, folder or Path())
    names = ["report.html", "surface.toml", *(f"faces.{kind}" for kind in kinds), "summary.json"]
    return Document(
        FACES_KIND,
        "Rough faces",
        answer,
        (
            Section("Faces", _faces(found)),
            *_joint(found),
            Section("Figures", (picture,), brief=False),
            Section("Validity", (Verdicts(found.verdicts, none=_NOTHING, short=True),)),
            Section("Surface of a study", (Listing(text),), brief=False),
        ),
        _data(found, names if folder is not None else []),
        figure="faces",
    )


def write(document: Document, folder: Path, progress: Progress | None = None) -> None:
    """Write every file of the document into an existing folder."""
    listing = next(block for block in document.blocks() if isinstance(block, Listing))
    others = [text_file("surface.toml", lambda: listing.text)]
    write_all(standard_files(document, document.data["files"], others), folder, progress)


def _faces(found: Faces) -> tuple[Block, ...]:
    rows = [(_NAMES[key], *_summits(face.statistics, face)) for key, face in found.known.items()]
    if len(rows) > 1:
        rows.append(("together", *_summits(found.together)))
    columns = (
        Column("face", "face"),
        Column("density", "density [1/mm²]"),
        Column("radius", "radius"),
        Column("std", "std of heights"),
    )
    said = [f"{_NAMES[key].capitalize()}: {face.said}." for key, face in found.known.items()]
    return (
        Table("", columns, tuple(rows)),
        Note(
            " ".join(said) + " ± is the standard deviation from scan to scan; ranges are what a "
            "drawing leaves open.",
            brief=False,
        ),
    )


def _summits(statistics: SummitStatistics, face: RoughFace | None = None) -> list[str]:
    cells = []
    for name, unit in _QUANTITIES.items():
        text = _written(getattr(statistics, name), unit)
        if face is not None and face.ranges:
            low, high = face.ranges[name]
            text += f" ({_written(low, unit)} to {_written(high, unit)})"
        elif face is not None and face.spread is not None:
            text += f" ± {100.0 * getattr(face.spread, name):.2g} %"
        cells.append(text)
    return cells


def _written(value: float, unit: str) -> str:
    return _per_area(value) if unit == "1/m^2" else engineering(value, unit)


def _per_area(density: float) -> str:
    return significant(1e-6 * density)


# -- the joint -------------------------------------------------------------------------------------


def _joint(found: Faces) -> list[Section]:
    joint = found.joint
    if joint is None:
        return []
    rows = [("as found", *_answers(found, joint))]
    for key, (name, ranges) in found.ranges.items():
        for quantity, ends in ranges.items():
            for which, end in zip(("lowest", "highest"), ends, strict=True):
                other = _with(found, key, quantity, end)
                what = f"{which} {quantity}" if len(found.known) == 1 else (
                    f"{which} {quantity} of the {name} face"
                )  # fmt: skip
                rows.append((what, *_answers(found, other)))
    columns = (
        Column("what", "with"),
        Column("contacts", "contacts", "", 3),
        Column("real_area", "real/apparent", "", 3),
        Column("tangential_stiffness", "stiffness", "N/m", 3),
        Column("loss_factor", "η", "", 3),
    )
    title = f"The joint at {engineering(joint.normal_load, 'N', 4, trim=True)}"
    return [Section(title, (Table("", columns, tuple(rows)),))]


def _answers(found: Faces, joint: Interface) -> tuple[float | None, ...]:
    amplitude, area = found.request.amplitude, joint.contact_area
    return (
        joint.contact_count,
        None if area is None else area / joint.surface.area,  # type: ignore[attr-defined]
        joint.tangential_stiffness,
        None if amplitude is None else float(joint.loss_factor(amplitude)),
    )


def _with(found: Faces, key: str, quantity: str, value: float) -> Interface:
    """The joint where one number of one face is another."""
    faces = {name: face.statistics for name, face in found.known.items()}
    faces[key] = dataclasses.replace(faces[key], **{quantity: value})  # type: ignore[arg-type]
    joint = found.joint
    assert joint is not None
    surface: Any = joint.surface
    made = reduce(combine, faces.values()).to_surface(surface.pair, surface.area)
    return Interface(made, joint.friction_coefficient, joint.normal_load)


# -- as data and drawn ----------------------------------------------------------------------------


def _data(found: Faces, names: Sequence[str]) -> dict[str, Any]:
    joint, request = found.joint, found.request
    faces: dict[str, Any] = {
        _NAMES[key]: {
            **dataclasses.asdict(face.statistics),
            "said": face.said,
            "scatter": face.spread._asdict() if face.spread else None,
            "ranges": {k: list(ends) for k, ends in face.ranges.items()} if face.ranges else None,
        }
        for key, face in found.known.items()
    }
    answers = None
    if joint is not None:
        contacts, real, stiffness, loss = _answers(found, joint)
        answers = {
            "normal_load": joint.normal_load,
            "friction_coefficient": joint.friction_coefficient,
            "amplitude": request.amplitude,
            "contacts": contacts,
            "real_area": real,
            "tangential_stiffness": stiffness,
            "loss_factor": loss,
        }
    return {
        **header(FACES_KIND, 1, "Rough faces"),
        "faces": faces,
        "together": dataclasses.asdict(found.together),
        "joint": answers,
        "validity": [
            {"name": v.name, "value": _plain(v.value), "limit": v.limit, "word": v.word}
            for v in found.verdicts
        ],
        "files": list(names),
    }


def _plain(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _plot(found: Faces) -> Plot:
    shown = {_NAMES[key]: (face.statistics, face) for key, face in found.known.items()}
    panels = []
    for place, (name, unit) in enumerate(_QUANTITIES.items()):
        values = [getattr(statistics, name) for statistics, _ in shown.values()]
        every = [*values, getattr(found.together, name)] if len(shown) > 1 else values
        scale, letter = (1e6, "1/mm²") if unit == "1/m^2" else _length(max(every))
        ticks = [(float(i), text) for i, text in enumerate([*shown, "together"][: len(every)])]
        panel = Panel(
            Axis("", -0.6, len(every) - 0.4, ticks=ticks),
            Axis(log=True),
            note=f"{_HEADS[name]} [{letter}]",
            cell=(0, 0, place, place),
        )
        for at, (value, (_, face)) in enumerate(zip(values, shown.values(), strict=True)):
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
    return Plot(panels, 3.2, "Summits of rough faces", widths=(1.0, 1.0, 1.0))


def _length(value: float) -> tuple[float, str]:
    unit, letter = length_prefix(value)
    return unit, f"{letter}m"
