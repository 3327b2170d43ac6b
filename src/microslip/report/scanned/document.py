"""Document of a scan, and the files written with it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.units import engineering, significant
from microslip._core.verdicts import Remark
from microslip._core.wording import capital
from microslip.figures.kit import evenly
from microslip.figures.picture import Picture
from microslip.report.document import (
    Block,
    Column,
    Document,
    Items,
    Listing,
    Note,
    Number,
    Section,
    Table,
    Verdicts,
)
from microslip.report.files import csv_text, text_file
from microslip.report.scanned import joint_section
from microslip.report.scanned.height_pictures import (
    cutoff_plot,
    density_plot,
    height_plot,
    spectrum_plot,
    texture_plot,
)
from microslip.report.scanned.numbers import (
    KIND,
    disagreements,
    spectrum_csv,
    summarise,
    texture_section,
)
from microslip.report.scanned.surface_block import block
from microslip.scans.file_reading import SUSPECT
from microslip.scans.findings import ESTIMATES, Findings
from microslip.scans.patches import HEIGHTS, MOMENTS, SUMMITS
from microslip.scans.summits import Summits

NO_CUTOFF = "none: limited by the pixel"
NOT_GIVEN = (
    "No short-wave cut-off was given: the results depend on the pixel. Choose one from the table "
    "over cut-offs."
)
TOO_SMALL = (
    "No short-wave cut-off was given: the results depend on the pixel. The scan is too small to "
    "choose one: four pixels are more than a third of it."
)
_BRIEF_CUTOFFS = 6
"""Cut-offs that a terminal shows beside the one that was asked for."""
_GAPS = (
    " Missing points count as points on the mean, and steps at the edges of gaps add waves of "
    "every length: those beyond a cut-off are from the gaps, not from the surface."
)

Say = Callable[[str], str]


def document(findings: Findings, folder: Path | None = None, say: Say = str) -> Document:
    """Document of a scan; its study file names the scan as seen from the folder."""
    remarks = tuple(say(text) for text in _remarks(findings))
    pictures = _pictures(findings)
    notes = findings.scan.notes if findings.summits is None else findings.summits.notes
    data = summarise(findings, remarks)
    sections = [
        Section(
            "Heights and moments",
            (_parameters(findings, data), Note(_errors(data), small=True)),
            brief=False,
        ),
        Section("Summits", _summits(data)),
        Section(
            "Every parameter against the cut-off",
            (_over_cutoffs(findings, data), Note(_column_notes(findings, data), brief=False)),
        ),
        texture_section(findings, data["texture"]),
        Section("Height distribution", (Note(findings.fit.verdict),), brief=False),
        *joint_section.sections(findings, say),
        Section("Figures", pictures, brief=False),
        Section("Validity", (Verdicts(findings.verdicts, short=True),)),
    ]
    files = [
        text_file("cutoffs.csv", lambda: _cutoff_rows(findings)),
        text_file("spectrum.csv", lambda: spectrum_csv(findings)),
    ]
    if (table := findings.joint_table) is not None:
        files.append(text_file("joint_cutoffs.csv", lambda: joint_section.as_csv(table)))
    if (summits := findings.summits) is not None:
        files.append(text_file("summits.csv", lambda: _summit_rows(summits)))
    if findings.makes_surface:
        text = block(findings, folder or Path())
        files.append(text_file("surface.toml", lambda: text))
        sections.append(Section("Surface of a study", (Listing(text),), brief=False))
    sections.append(Section("Reading of the file", (Items(tuple(map(say, notes))),), brief=False))
    answer, number = _answer(findings, data), _number(data)
    return Document(
        KIND, findings.raw.name, answer, tuple(sections), data, remarks, number, "heights",
        tuple(files),
    )  # fmt: skip


def _answer(findings: Findings, data: dict[str, Any]) -> str:
    """The summits in a sentence, at which cut-off, and what was measured."""
    rms = _number(data)
    height = f"Sq {rms.value} {rms.band.partition(' (')[0]}".rstrip()
    measured = f"{_size_text(findings)}. {capital(findings.cutoff_text())}: {height}."
    for estimate in ("counted", "mccool"):
        if part := data["summits"].get(estimate):
            keys = ("density", "radius", "std")
            density, radius, std = (written(part[k]["value"], part[k]["unit"]) for k in keys)
            return (
                f"Summits by {ESTIMATES[estimate]}: {density} per mm², radius {radius}, "
                f"standard deviation of their heights {std}. {measured}"
            )
    return f"No summits. {measured}"


def _number(data: dict[str, Any]) -> Number:
    """The rms height with its error."""
    part = data["parameters"]["rms"]
    error = part["error"]
    band = "" if error is None else f"± {written(error, 'm', 2)} (standard error from patches)"
    return Number("rms height Sq", written(part["value"], "m", 4), band)


def _remarks(findings: Findings) -> list[str]:
    """Remarks at the head; empty if all is well."""
    request, laws = findings.request, findings.laws
    remarks = []
    if not request.cutoff_given:
        remarks.append(NOT_GIVEN if findings.has_cutoffs else TOO_SMALL)
    doubts = [note for note in findings.raw.notes if isinstance(note, Remark)]
    # Points that were left out are not suspected again.
    remarks += [d.words for d in doubts if d.kind == SUSPECT and request.outliers is None]
    remarks += [capital(doubt.words) for doubt in doubts if doubt.kind != SUSPECT]
    if laws is not None and request.heights not in (None, laws.recommended):
        remarks.append(f'{capital(laws.reason)}. Take `heights="{laws.recommended}"`.')
    return [*remarks, *findings.missing, *disagreements(findings)]


def _size_text(findings: Findings) -> str:
    """Size of the scan: "768 x 576 points, pixel 1.66 µm, 1.27 x 0.956 mm"."""
    scan = findings.scan
    points = " x ".join(str(n) for n in scan.heights.shape[::-1])
    pixel = " x ".join(engineering(step, "m", 4) for step in dict.fromkeys(scan.pixel))
    size = " x ".join(engineering(length, "m") for length in scan.size)
    missing = scan.missing
    lost = f", {significant(100.0 * missing, 2)} % missing" if missing else ""
    return f"{points} points, pixel {pixel}, {size}{lost}"


# -- tables ---------------------------------------------------------------------------------------


def _cutoff_text(findings: Findings) -> str:
    """The short-wave cut-off in words; there is always something to say."""
    if findings.request.cutoff is not None:
        return engineering(findings.request.cutoff, "m", 4, trim=True)
    return NO_CUTOFF if findings.request.cutoff_given else "not given: limited by the pixel"


def _parameters(findings: Findings, data: dict[str, Any]) -> Table:
    """Heights and moments with their error bars; the cut-off stands in the first row."""
    rows: list[tuple[str, str, str | None]] = [("short-wave cut-off", _cutoff_text(findings), "")]
    if findings.request.long_cutoff is not None:
        length = engineering(findings.request.long_cutoff, "m", 4)
        rows.append(("long-wave cut-off", length, ""))
    for name, (label, unit) in {**HEIGHTS, **MOMENTS}.items():
        if name == "anisotropy" and findings.scan.is_profile:
            continue
        part = data["parameters"][name]
        error = None if part["error"] is None else written(part["error"], unit, 2)
        rows.append((label, written(part["value"], unit, 4), error))
    columns = (
        Column("quantity", "quantity"),
        Column("value", "value"),
        Column("error", "± (patches)"),
    )
    return Table("", columns, tuple(rows))


def _errors(data: dict[str, Any]) -> str:
    if all(data["parameters"][name]["error"] is None for name in HEIGHTS):
        return "The scan is too small for error bars from patches of it."
    return (
        "Error bars are standard errors of the mean over nine patches of the scan. Waves longer "
        "than a patch make them too small; those of Sq, Sa and m0 are from the waves of the whole "
        "scan where that gives more, which is still 0.7 of the true scatter where one wave fills "
        "the scan."
    )


def _summits(data: dict[str, Any]) -> tuple[Block, ...]:
    """Summits by every estimate."""
    rows = tuple(
        (ESTIMATES[name], *(_with_error(part[key]) for key in SUMMITS))
        for name, part in data["summits"].items()
        if part is not None
    )
    if not rows:
        return (Note("There are none: see above."),)
    labels = ("density [1/mm²]", "radius", "std of heights", "mean height")
    columns = (
        Column("estimate", "summits by"),
        *(Column(key, label) for key, label in zip(SUMMITS, labels, strict=True)),
    )
    return (Table("", columns, rows),)


def _with_error(part: dict[str, Any]) -> str:
    value = written(part["value"], part["unit"])
    if part["error"] is None or not part["value"]:
        return value
    return f"{value} ± {significant(100.0 * part['error'] / abs(part['value']), 2)} %"


def _over_cutoffs(findings: Findings, data: dict[str, Any]) -> Table:
    """Every parameter against the cut-off; the one that was asked for is marked."""
    pixel = math.prod(findings.scan.pixel) ** (1.0 / len(findings.scan.pixel))
    kinds = (("density", "1/m^2"), ("radius", "m"), ("std", "m"))
    rows = []
    for row in data["over_cutoffs"]:
        cutoff = row["cutoff"]
        mark = " *" if cutoff == data["cutoff"] else ""
        radius = row["counted_radius"] or row["mccool_radius"]
        rows.append(
            (
                ("none" if cutoff is None else engineering(cutoff, "m")) + mark,
                row["rms"],
                row["nayak"],
                *(row[f"{by}_{name}"] for name, _ in kinds for by in ("mccool", "counted")),
                None if radius is None else radius / pixel,
            )
        )
    columns = [
        Column("cutoff", "cut-off"),
        Column("rms", "Sq", "m", 3),
        Column("nayak", "α", "", 3),
    ]
    counted = any(row[4] is not None for row in rows)
    for name, unit in kinds:
        head = "density [1/mm²]" if name == "density" else name
        write = partial(written, unit=unit) if name == "density" else None
        columns.append(Column(f"mccool_{name}", name, unit, 3, write, head, not counted))
        columns.append(Column(f"counted_{name}", "counted", unit, 3, write, head))
    columns.append(Column("radius_in_pixels", "radius/pixel", "", 3))
    brief_rows = {
        *evenly(len(rows), _BRIEF_CUTOFFS),
        *(i for i, row in enumerate(rows) if row[0].endswith("*")),
    }
    return Table("", tuple(columns), tuple(rows), noun="cut-offs", few=tuple(sorted(brief_rows)))


def _column_notes(findings: Findings, data: dict[str, Any]) -> str:
    """Meaning of the columns of the table over cut-offs."""
    counted = any(row["counted_radius"] is not None for row in data["over_cutoffs"])
    beside = ""
    if counted:
        beside = (
            ", each beside that of the counted summits; radius/pixel is that of the counted "
            "summits, where there are any"
        )
    elif not findings.scan.is_profile:
        beside = "; none were counted"
    return (
        f"Density [1/mm²], radius and std of the summits by McCool's moments{beside}. "
        "* chosen cut-off."
    )


def written(value: float | None, unit: str, digits: int = 3) -> str:
    """A number with its unit; powers of a length without prefixes, summits per mm²."""
    if value is None:
        return "–"
    if unit == "m":
        return engineering(value, unit, digits)
    if unit == "1/m^2" and digits == 3:
        return significant(value * 1e-6)
    text = significant(value, digits)
    return text if unit == "-" else f"{text} {unit.replace('^2', '²')}"


# -- pictures -------------------------------------------------------------------------------------


def _pictures(findings: Findings) -> tuple[Picture, ...]:
    """The figures; a scan with no cut-off to choose has none of parameters over them."""
    cutoff = f"{capital(findings.cutoff_text())}."
    profile = findings.scan.is_profile
    gaps = _GAPS if findings.scan.missing > 0.0 else ""
    slopes = (
        "the rms slope between points against their distance; where it does not level off towards "
        "short distances it depends on the cut-off"
    )
    figures = {
        "heights": (
            height_plot,
            f"Heights above the mean. {cutoff}"
            if profile
            else f"Heights above the mean, and the summits. {cutoff} The framed part is shown "
            "larger, with every summit; colours end where half a percent of the points is beyond "
            "them.",
            "The profile" if profile else "Map of the heights with the summits, and a part of it",
        ),
        "density": (
            density_plot,
            "Roughness in the manner of Fig. 19.6 of the chapter: a trace, the density of all "
            "heights with the distributions that fit best, and its logarithm, which shows the "
            f"tails. {cutoff} The percentages are the largest share of the points that a "
            "distribution misses. Where nearly all heights would be a spike, (b) shows those "
            "between the dotted lines.",
            "A trace of the heights, and their density with fits",
        ),
        "spectrum": (
            spectrum_plot,
            "Power spectrum: the variance of the heights by wavelength; the cut-offs remove the "
            f"grey ranges. {cutoff}{gaps}",
            "Power spectrum against wavelength, radial and along both axes",
        ),
        "texture": (
            texture_plot,
            f"{capital(slopes)}. {cutoff}"
            if profile
            else f"Autocorrelation of the heights along both axes, and {slopes}. {cutoff}",
            "Autocorrelation of the heights, and rms slope against distance",
        ),
        "cutoffs": (
            cutoff_plot,
            f"Every parameter against the short-wave cut-off. {cutoff} A parameter that does not "
            "level off depends on the cut-off as much as on the surface.",
            "Summit density, radius, spread, rms height and slope, Nayak's alpha against the "
            "cut-off",
        ),
    }
    if not findings.has_cutoffs:
        del figures["cutoffs"]
    return (
        *(
            Picture(name, caption, partial(plot, findings), alternative)
            for name, (plot, caption, alternative) in figures.items()
        ),
        *joint_section.tail_picture(findings),
        *joint_section.pictures(findings),
    )


# -- rows of files --------------------------------------------------------------------------------


def _cutoff_rows(findings: Findings) -> str:
    """Parameters against the cut-off; empty where there is no cut-off or no value."""
    units = {"cutoff": "m", "counted": "-", "m0": "m^2", "m2": "-", "m4": "1/m^2", "nayak": "-"}
    names = findings.table.names
    heads = [units.get(name) or ("1/m^2" if name.endswith("density") else "m") for name in names]
    rows = ({**row, "cutoff": row["cutoff"] or None} for row in findings.table.rows())
    return csv_text(
        (f"{name} [{unit}]" for name, unit in zip(names, heads, strict=True)),
        (row.values() for row in rows),
    )


def _summit_rows(summits: Summits) -> str:
    """The summits, one a row, highest first."""
    heads = ["x [m]", "y [m]", "height [m]", "radius [m]"]
    heads += ["curvature_1 [1/m]", "curvature_2 [1/m]", "prominence [m]"]
    parts = [summits.positions, summits.heights, summits.radii, summits.curvatures]
    columns = np.column_stack([*parts, summits.prominences])
    return csv_text(heads, columns[np.argsort(-summits.heights, kind="stable")].tolist())
