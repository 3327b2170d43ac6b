"""Document of a scan, its summary and its files."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from microslip._core.dataset import DataSet
from microslip._core.errors import InputError
from microslip._core.files import relative_path
from microslip._core.parameters import parameters_of
from microslip._core.quantities import Quantity, json_value, named
from microslip._core.units import SMALLEST, engineering, significant
from microslip._core.verdicts import Remark
from microslip._core.wording import capital
from microslip._version import __version__
from microslip.contact.figures import face_plot
from microslip.figures.picture import Picture
from microslip.report import cells
from microslip.report.document import (
    Block,
    Document,
    Items,
    Note,
    Section,
    Verdicts,
)
from microslip.report.files import csv_file, header, text_file
from microslip.report.scanned.height_pictures import height_plot, spectrum_plot
from microslip.study.toml_text import dump
from microslip.surfaces.findings import Findings, Request
from microslip.surfaces.joints import FaceJoint, contact_words
from microslip.surfaces.summits import Summits
from microslip.surfaces.surface_parameters import (
    ArealParameters,
    ProfileParameters,
    areal_parameters,
    profile_parameters,
)

_NO_CUTOFF = "none: limited by the pixel"
NOT_GIVEN = (
    "No short-wave cut-off was given, so the results depend on the pixel. Choose a cut-off of "
    "several pixels that is shorter than the contacts."
)
_GAPS = (
    " Missing points are set to the mean, and the steps at the edges of gaps add waves of every "
    "length: waves beyond a cut-off come from the gaps, not from the surface."
)
_HEIGHTS = {
    "rms": ("Sq, rms height", "m"),
    "mean_deviation": ("Sa, arithmetical mean height", "m"),
    "skewness": ("Ssk, skewness", ""),
    "kurtosis": ("Sku, kurtosis", ""),
    "maximum_height": ("Sz, maximum height", "m"),
}
_SUMMITS = {
    "density": ("density", "1/m^2"),
    "radius": ("radius", "m"),
    "std": ("standard deviation of heights", "m"),
    "mean_height": ("mean height", "m"),
}


def scan_document(
    findings: Findings, folder: Path | None = None, adapt: cells.Wording = str
) -> Document:
    """Return the document of a scan; paths in its study.toml are relative to ``folder``.

    ``adapt`` replaces argument names in messages, for example by command options.
    """
    remarks = tuple(adapt(text) for text in _remarks(findings))
    notes = findings.scan.notes if findings.summits is None else findings.summits.notes
    data = scan_summary(findings, remarks)
    sections = [
        Section("Heights", _parameters(findings, data), brief=False),
        *joint_sections(findings, adapt),
        Section("Statistics of the chapter's model", _summits(findings, data)),
        Section("Figures", _pictures(findings), brief=False),
        Section("Validity", (Verdicts(findings.verdicts, short=True),)),
    ]
    files = [csv_file("spectrum.csv", lambda: spectrum_data(findings))]
    if (summits := findings.summits) is not None:
        files.append(csv_file("summits.csv", lambda: summits_data(summits)))
    if findings.face is not None:
        text = face_study_text(findings, findings.face, folder or Path())
        files.append(text_file(STUDY_NAME, lambda: text))
    sections.append(Section("Reading of the file", (Items(tuple(map(adapt, notes))),), brief=False))
    return Document(
        findings.raw.name, _answer(findings), tuple(sections), data, remarks,
        "heights", tuple(files),
    )  # fmt: skip


def scan_summary(findings: Findings, remarks: tuple[str, ...]) -> dict[str, Any]:
    """Return the content of summary.json: plain values in SI units, None for missing ones."""
    request, scan, summits = findings.request, findings.scan, findings.summits
    statistics = findings.summit_statistics
    data = {
        **header("surface", 2, findings.raw.name),
        "version": __version__,
        "name": findings.raw.name,
        **named(request, "cutoff", "cutoff_given", "long_cutoff"),
        "level": findings.level or "none",
        "area": request.area,
        "points": scan.heights.shape[::-1],
        "pixel": scan.pixel,
        "size": scan.size,
        "missing": findings.scan.unfiltered.missing,
        "warnings": remarks,
        "parameters": named(findings.statistics, *_HEIGHTS),
        "areal": None if scan.is_profile else vars(areal_parameters(scan)),
        "profile": {axis: vars(found) for axis, found in _lines(findings)},
        "summits": None if statistics is None else named(statistics, *_SUMMITS),
        "count": None if summits is None else summits.count,
        "prominence": None if summits is None else summits.threshold,
        "joint": summary(findings),
        "validity": findings.verdicts,
        "notes": (scan if summits is None else summits).notes,
        "files": [],
    }
    return {name: json_value(value) for name, value in data.items()}


def _lines(findings: Findings) -> Iterator[tuple[str, ProfileParameters]]:
    """Yield each axis, and the roughness parameters (ISO 21920-2) of the profiles along it.

    An axis is omitted if every profile has gaps, or if the profiles are too short.
    """
    axes: tuple[Literal["x", "y"], ...] = ("x", "y")
    for axis in axes[: findings.scan.heights.ndim]:
        with suppress(InputError):
            yield axis, profile_parameters(findings.scan, axis=axis)


def _answer(findings: Findings) -> str:
    height = f"Sq {engineering(findings.statistics.rms, 'm', 4)}"
    measured = f"{_size_text(findings)}. {capital(findings.cutoff_text())}: {height}."
    face, statistics = findings.face, findings.summit_statistics
    if face is not None:
        values = face.values
        return (
            f"At {engineering(face.joint.normal_load, 'N', 4)}: k_n "
            f"{engineering(values['normal_stiffness'], 'N/m', 3)}, k_t "
            f"{engineering(values['tangential_stiffness'], 'N/m', 3)}, loss factor "
            f"{values['loss_factor']:.3g} at {engineering(face.amplitude, 'm', 3)}. {measured}"
        )
    if statistics is None:
        return f"No summits. {measured}"
    how = "by its moments" if findings.summits is None else "counted"
    return (
        f"Summits {how}: {significant(statistics.density * 1e-6)} per mm², radius "
        f"{engineering(statistics.radius, 'm')}, standard deviation of their heights "
        f"{engineering(statistics.std, 'm')}. {measured}"
    )


def _remarks(findings: Findings) -> list[str]:
    request = findings.request
    remarks = [] if request.cutoff_given else [NOT_GIVEN]
    doubts = [note for note in findings.raw.notes if isinstance(note, Remark)]
    # Removed fill values are reported by the note of the repair.
    remarks += [capital(d.words) for d in doubts if "`repaired()`" not in d.words]
    remarks += [capital(n) for n in findings.scan.notes if n.startswith(("repair:", "fill:"))]
    if findings.request.level == "auto" and findings.level != "plane":
        remarks.append(f"The scan is bowed; the form was removed with level {findings.level}.")
    return [*remarks, findings.missing] if findings.missing else remarks


def _size_text(findings: Findings) -> str:
    scan = findings.scan
    points = " x ".join(str(n) for n in scan.heights.shape[::-1])
    pixel = " x ".join(engineering(step, "m", 4) for step in dict.fromkeys(scan.pixel))
    size = " x ".join(engineering(length, "m") for length in scan.size)
    missing = findings.scan.unfiltered.missing
    lost = f", {significant(100.0 * missing, 2)} % missing" if missing else ""
    return f"{points} points, pixel {pixel}, {size}{lost}"


# -- tables ----------------------------------------------------------------------------------------


def _parameters(findings: Findings, data: dict[str, Any]) -> tuple[Block, ...]:
    request = findings.request
    cutoff = _NO_CUTOFF if request.cutoff_given else "not given: limited by the pixel"
    if request.cutoff is not None:
        cutoff = engineering(request.cutoff, "m", 4, trim=True)
    rows = [("short-wave cut-off", cutoff)]
    if request.long_cutoff is not None:
        rows.append(("long-wave cut-off", engineering(request.long_cutoff, "m", 4)))
    if data["areal"] is not None:
        for name, (label, unit) in _HEIGHTS.items():
            rows.append((label, _written(data["parameters"][name], unit)))
        for item in parameters_of(ArealParameters):
            label = f"{item.symbol}, {item.meaning}"
            rows.append((label, _written(data["areal"][item.name], item.unit)))
    head = "profile" if data["areal"] is None else "ISO 25178-2:2021"
    blocks: list[Block] = [cells.texts("", rows, (head, "value"))]
    if along := data["profile"]:
        heads = ["value"] if data["areal"] is None else [f"lines along {axis}" for axis in along]
        of_lines = [
            (
                f"{item.symbol}, {item.meaning}",
                *(_written(values[item.name], item.unit) for values in along.values()),
            )
            for item in parameters_of(ProfileParameters)
        ]
        blocks.append(cells.texts("", of_lines, ("ISO 21920-2:2021", *heads)))
    return tuple(blocks)


def _summits(findings: Findings, data: dict[str, Any]) -> tuple[Block, ...]:
    if data["summits"] is None:
        return (Note("No summits were found; see above."),)
    rows = tuple(
        (label, _written(data["summits"][name], unit)) for name, (label, unit) in _SUMMITS.items()
    )
    rows += tuple(chapter_rows(findings))
    head = "summits by the moments of the profile"
    if findings.summits is not None:
        head = f"{findings.summits.count} summits"
    return (cells.texts("", rows, (head, "value")),)


def _written(value: float | None, unit: str) -> str:
    if value is None:
        return "not determined"
    if unit == "1/m^2":
        return f"{significant(1e-6 * value)} 1/mm²"
    if not unit and float(value).is_integer():
        return f"{value:.0f}"
    return engineering(value, unit) if unit == "m" else f"{significant(value)} {unit}".rstrip()


# -- pictures and rows of files --------------------------------------------------------------------


def _pictures(findings: Findings) -> tuple[Picture, ...]:
    cutoff = f"{capital(findings.cutoff_text())}."
    profile = findings.scan.is_profile
    heights = f"Heights above the mean. {cutoff}"
    if not profile:
        heights = (
            f"Heights above the mean, and the summits. {cutoff} The framed part is enlarged, with "
            "all its summits; the colour scale omits 0.5 % of the points at each end."
        )
    waves = (
        "Power spectrum: the variance of the heights by wavelength; the cut-offs remove the grey "
        f"ranges. {cutoff}{_GAPS if findings.scan.missing > 0.0 else ''}"
    )
    return (
        Picture(
            "heights",
            heights,
            partial(height_plot, findings),
            "The profile" if profile else "Map of the heights with the summits, and a part of it",
        ),
        Picture(
            "spectrum",
            waves,
            partial(spectrum_plot, findings),
            "Power spectrum against wavelength, radial and along both axes",
        ),
        *joint_pictures(findings),
    )


def spectrum_data(findings: Findings) -> DataSet:
    """Return the spectral density with its relative error, and the density after the cut-offs."""
    unfiltered, filtered = findings.whole_spectrum, findings.spectrum
    unit = "m^3" if findings.scan.is_profile else "m^4"
    same = filtered.density.shape == unfiltered.density.shape
    density = filtered.density if same else unfiltered.density
    # Densities far below the measured ones after a filter are set to zero.
    before, after = (np.where(c > SMALLEST, c, 0.0) for c in (unfiltered.density, density))
    return DataSet.of_rows(
        {
            "wavelength": (Quantity("m"), unfiltered.wavelength),
            "wavenumber": (Quantity("rad/m"), unfiltered.wavenumber),
            "density": (Quantity(unit), before),
            "relative_error": (Quantity("-"), unfiltered.relative_error),
            "density_cut_off": (Quantity(unit), after),
        }
    )


def summits_data(summits: Summits) -> DataSet:
    """Return all summits, the highest first."""
    parts = [summits.positions, summits.heights, summits.radii, summits.curvatures]
    columns = np.column_stack([*parts, summits.prominences])
    order = np.argsort(-summits.heights, kind="stable")
    units = dict.fromkeys(("x", "y", "height", "radius"), "m")
    units |= {"curvature_1": "1/m", "curvature_2": "1/m", "prominence": "m"}
    pairs = zip(map(Quantity, units.values()), columns[order].T, strict=True)
    return DataSet.of_rows(dict(zip(units, pairs, strict=True)))


# -- the joint under a load ------------------------------------------------------------------------

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
    return {
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


# -- the joint as a study --------------------------------------------------------------------------

STUDY_NAME = "study.toml"


def face_study_text(findings: Findings, face: FaceJoint, folder: Path) -> str:
    """Return a study of the face solved point by point; paths in it are relative to ``folder``."""
    request = findings.request
    tables = {
        "surface": _surface(findings, face, folder),
        "joint": {
            "friction_coefficient": request.friction_coefficient,
            "normal_load": engineering(face.joint.normal_load, "N", 9, trim=True),
        },
        "excitation": {"amplitudes": [cells.toml_length(face.amplitude)]},
    }
    head = [
        f"# A joint of {findings.raw.name}, written by microslip surface:",
        f"#   microslip predict {STUDY_NAME}",
    ]
    if face.unresolved_amplitude is not None:
        head.append(
            "# The scan does not determine the damping of cycles up to "
            f"{engineering(face.unresolved_amplitude, 'm')} in amplitude."
        )
    study = {"schema": 1, "title": findings.raw.name, **tables}
    return "\n".join(head) + f"\n{dump(study)}"


def _surface(findings: Findings, face: FaceJoint, folder: Path) -> dict[str, Any]:
    request = findings.request
    path = request.path
    keys: dict[str, Any] = {
        "law": "face",
        "materials": list(request.materials or ()),
        "scan": os.fspath(path) if path.is_absolute() else relative_path(folder, path),
        "level": findings.level or "none",
        **_lengths(request, "cutoff", "long_cutoff", "crop"),
        "tightening_pressure": engineering(face.law.numbers.pressure, "Pa", 6, trim=True),
        "piece": face.piece or "none",
        "area": f"{face.law.area * 1e4:.6g} cm^2",
    }
    if request.direction is not None:
        keys["direction"] = f"{math.degrees(request.direction):.6g} deg"
    return keys | {key: _read(value) for key, value in request.reading.items() if value != ()}


def _lengths(request: Request, *names: str) -> dict[str, Any]:
    values = {name: getattr(request, name) for name in names}
    return {name: _read(value) for name, value in values.items() if value is not None}


def _read(value: Any) -> Any:
    """Format an option of the scan as TOML: lengths with unit, several values as a list."""
    if isinstance(value, tuple):
        return _read(value[0]) if len(value) == 1 else [_read(item) for item in value]
    return cells.toml_length(value) if isinstance(value, float) else value
