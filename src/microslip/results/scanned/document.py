"""What a measured scan says, as a document, and the files that it makes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.units import engineering, significant
from microslip.errors import Argument, Phrase
from microslip.report.document import (
    Block,
    Column,
    Document,
    Items,
    Listing,
    Note,
    Number,
    Picture,
    Section,
    Table,
    Verdicts,
)
from microslip.report.files import Progress, standard_files, text_file, write_all
from microslip.report.scales import evenly
from microslip.results.scanned import joint_section, texture
from microslip.results.scanned.cutoff_picture import cutoff_plot
from microslip.results.scanned.density_picture import density_plot
from microslip.results.scanned.disagreements import disagreements
from microslip.results.scanned.findings import ESTIMATES, Findings
from microslip.results.scanned.height_picture import height_plot
from microslip.results.scanned.numbers import KIND, summarise
from microslip.results.scanned.patch_scatter import HEIGHTS, MOMENTS, SUMMITS
from microslip.results.scanned.spectrum_picture import spectrum_plot
from microslip.results.scanned.surface_block import block
from microslip.results.scanned.texture_picture import texture_plot
from microslip.scans.file_reading import ASKED, SUSPECT

NO_CUTOFF = "none: the pixel decides"
NOT_GIVEN = (
    "No short-wave cut-off was given: the pixel decides. Choose one from the table over cut-offs."
)
TOO_SMALL = (
    "No short-wave cut-off was given: the pixel decides. The scan is too small to choose one: four "
    "pixels are more than a third of it."
)
_FEW = 6
"""Cut-offs that a terminal shows beside the one that was asked for."""
_GAPS = (
    " Missing points count as points on the mean, and steps at the edges of gaps make waves of "
    "every length: of such is what seems to have passed a cut-off, and not of the surface."
)

Say = Callable[[str], str]


def document(
    found: Findings, folder: Path | None = None, say: Say = str, kinds: Sequence[str] = ("svg",)
) -> Document:
    """What a measured scan says."""
    remarks = tuple(say(text) for text in _remarks(found))
    pictures = _pictures(found)
    names = () if folder is None else _names(found, pictures, kinds)
    notes = found.scan.notes if found.summits is None else found.summits.notes
    data = summarise(found, remarks, names)
    sections = [
        Section(
            "Heights and moments",
            (_parameters(found, data), Note(_errors(data), small=True)),
            brief=False,
        ),
        Section("Summits", _summits(data)),
        Section(
            "Every parameter against the cut-off",
            (_over_cutoffs(found, data), Note(_explained(found, data), brief=False)),
        ),
        texture.section(found, data["texture"]),
        Section("Height distribution", (Note(found.fit.verdict),), brief=False),
        *joint_section.sections(found),
        Section("Figures", pictures, brief=False),
        Section("Validity", (Verdicts(found.verdicts, short=True),)),
    ]
    if found.makes_surface:
        text = block(found, folder or Path())
        sections.append(Section("Surface of a study", (Listing(text),), brief=False))
    sections.append(Section("How it was read", (Items(tuple(map(say, notes))),), brief=False))
    return Document(
        KIND,
        found.raw.name,
        _answer(found, data),
        tuple(sections),
        data,
        remarks,
        _number(data),
        "heights",
    )


def _answer(found: Findings, data: dict[str, Any]) -> str:
    """Its summits in a sentence, at which cut-off, and what was measured."""
    by = next((name for name in ("counted", "mccool") if data["summits"].get(name)), None)
    rms = _number(data)
    height = f"Sq {rms.value} {rms.band.partition(' (')[0]}".rstrip()
    measured = f"{_described(found)}. {_capital(found.cutoff_text())}: {height}."
    if by is None:
        return f"No summits. {measured}"
    part = data["summits"][by]
    density, radius, std = (
        _written(part[key]["value"], part[key]["unit"]) for key in ("density", "radius", "std")
    )
    return (
        f"Its summits, by {ESTIMATES[by]}: {density} per mm², of radius {radius}, their heights "
        f"with a standard deviation of {std}. {measured}"
    )


def _number(data: dict[str, Any]) -> Number:
    """The rms height with its error."""
    part = data["parameters"]["rms"]
    error = part["error"]
    band = "" if error is None else f"± {_written(error, 'm', 2)} (standard error from patches)"
    return Number("rms height Sq", _written(part["value"], "m", 4), band)


def write(
    document: Document, found: Findings, folder: Path, progress: Progress | None = None
) -> None:
    """Write every file of the document of a scan into an existing folder."""
    listings = [
        text_file("surface.toml", lambda text=item.text: text)  # type: ignore[misc]
        for item in document.blocks()
        if isinstance(item, Listing)
    ]
    others = [*listings, text_file("cutoffs.csv", lambda: _cutoff_rows(found))]
    others.append(text_file("spectrum.csv", lambda: texture.spectrum_csv(found)))
    if (table := found.joint_table) is not None:
        others.append(text_file("joint_cutoffs.csv", lambda: joint_section.as_csv(table)))
    if found.summits is not None:
        others.append(text_file("summits.csv", lambda: _summit_rows(found)))
    write_all(standard_files(document, document.data["files"], others), folder, progress)


def _names(found: Findings, pictures: tuple[Picture, ...], kinds: Sequence[str]) -> tuple[str, ...]:
    """Names of the files, the page first."""
    names = ["report.html", "cutoffs.csv", "spectrum.csv"]
    names += ["joint_cutoffs.csv"] * (found.joint_table is not None)
    names += ["summits.csv"] * (found.summits is not None) + ["surface.toml"] * found.makes_surface
    names += [f"{picture.name}.{kind}" for picture in pictures for kind in kinds]
    return (*names, "summary.json")


def _remarks(found: Findings) -> list[str]:
    """What the reader has to know first; nothing if all is well."""
    suspects = [note for note in found.raw.notes if note.startswith(SUSPECT)]
    if found.request.outliers is not None:
        suspects = []  # what was left out is no more to be suspected
    remarks = [] if found.request.cutoff_given else [NOT_GIVEN if found.has_cutoffs else TOO_SMALL]
    remarks += [_without(note, SUSPECT) for note in suspects]
    remarks += [
        _capital(note.removeprefix(begin))
        for note in found.raw.notes
        for begin in (ASKED, "checksum: ")
        if note.startswith(begin)
    ]
    laws = found.laws
    if laws is not None and found.request.heights not in (None, laws.recommended):
        remarks.append(
            Phrase(f"{_capital(laws.reason)}. Take ", Argument("heights", laws.recommended), ".")
        )
    return [*remarks, *found.missing, *disagreements(found)]


def _without(note: str, begin: str) -> str:
    """A note without its first word, its arguments still to be spelt."""
    if not isinstance(note, Phrase):
        return note.removeprefix(begin)
    first, *others = note.parts
    return Phrase(str(first).removeprefix(begin), *others)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _described(found: Findings) -> str:
    """Size of the scan: "768 x 576 points, pixel 1.66 µm, 1.27 x 0.956 mm"."""
    scan = found.scan
    points = " x ".join(str(n) for n in scan.heights.shape[::-1])
    pixel = " x ".join(engineering(step, "m", 4) for step in dict.fromkeys(scan.pixel))
    size = " x ".join(engineering(length, "m") for length in scan.size)
    missing = scan.missing
    lost = f", {significant(100.0 * missing, 2)} % missing" if missing else ""
    return f"{points} points, pixel {pixel}, {size}{lost}"


# -- tables ---------------------------------------------------------------------------------------


def _cutoff_text(found: Findings) -> str:
    """The short-wave cut-off in words; there is always something to say."""
    if found.request.cutoff is not None:
        return engineering(found.request.cutoff, "m", 4, trim=True)
    return NO_CUTOFF if found.request.cutoff_given else "not given: the pixel decides"


def _parameters(found: Findings, data: dict[str, Any]) -> Table:
    """Heights and moments with their error bars; the cut-off stands in the first row."""
    rows: list[tuple[str, str, str | None]] = [("short-wave cut-off", _cutoff_text(found), "")]
    if found.request.long_cutoff is not None:
        length = engineering(found.request.long_cutoff, "m", 4)
        rows.append(("long-wave cut-off", length, ""))
    for name, (label, unit) in {**HEIGHTS, **MOMENTS}.items():
        if name == "anisotropy" and found.scan.is_profile:
            continue
        part = data["parameters"][name]
        error = None if part["error"] is None else _written(part["error"], unit, 2)
        rows.append((label, _written(part["value"], unit, 4), error))
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
        "than a patch make them too small; those of Sq, Sa and m0 are by the waves of the whole "
        "scan, where that is larger, and still 0.7 of the true scatter where one wave fills it."
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
    value = _written(part["value"], part["unit"])
    if part["error"] is None or not part["value"]:
        return value
    return f"{value} ± {significant(100.0 * part['error'] / abs(part['value']), 2)} %"


def _over_cutoffs(found: Findings, data: dict[str, Any]) -> Table:
    """Every parameter against the cut-off; the one that was asked for is marked."""
    pixel = math.prod(found.scan.pixel) ** (1.0 / len(found.scan.pixel))
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

    def per_area(density: float) -> str:
        return significant(density * 1e-6)

    columns = [
        Column("cutoff", "cut-off"),
        Column("rms", "Sq", "m", 3),
        Column("nayak", "α", "", 3),
    ]
    counted = any(row[4] is not None for row in rows)
    for name, unit in kinds:
        write, head = (per_area, "density [1/mm²]") if name == "density" else (None, name)
        columns.append(Column(f"mccool_{name}", name, unit, 3, write, head, not counted))
        columns.append(Column(f"counted_{name}", "counted", unit, 3, write, head))
    columns.append(Column("radius_in_pixels", "radius/pixel", "", 3))
    few = {*evenly(len(rows), _FEW), *(i for i, row in enumerate(rows) if row[0].endswith("*"))}
    return Table("", tuple(columns), tuple(rows), noun="cut-offs", few=tuple(sorted(few)))


def _explained(found: Findings, data: dict[str, Any]) -> str:
    """What the columns of the table over cut-offs are."""
    counted = any(row["counted_radius"] is not None for row in data["over_cutoffs"])
    beside = ""
    if counted:
        beside = (
            ", beside each the counted ones; radius/pixel is of the counted ones, where there are "
            "any"
        )
    elif not found.scan.is_profile:
        beside = "; none were counted"
    return (
        f"Density [1/mm²], radius and std of the summits by McCool's moments{beside}. "
        "* what was asked for."
    )


def _written(value: float | None, unit: str, digits: int = 3) -> str:
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


def _pictures(found: Findings) -> tuple[Picture, ...]:
    """The figures; a scan with no cut-off to choose has none of parameters over them."""
    cutoff = f"{_capital(found.cutoff_text())}."
    profile = found.scan.is_profile
    heights = Picture(
        "heights",
        f"Heights above the mean. {cutoff}"
        if profile
        else f"Heights above the mean, and the summits. {cutoff} The framed part is shown larger, "
        "with every summit; colours end where half a percent of the points is beyond them.",
        lambda: height_plot(found),
        "The profile" if profile else "Map of the heights with the summits, and a part of it",
    )
    density = Picture(
        "density",
        "Roughness in the manner of Fig. 19.6 of the chapter: a trace, the density of all heights "
        f"with the distributions that fit best, and its logarithm, which shows the tails. {cutoff} "
        "The percentages are the largest share of the points that a distribution misses. Where "
        "nearly all heights would be a spike, (b) shows those between the dotted lines.",
        lambda: density_plot(found),
        "A trace of the heights, and their density with fits",
    )
    spectrum = Picture(
        "spectrum",
        "Power spectrum: the variance of the heights by wavelength; grey ground is what the "
        f"cut-offs remove. {cutoff}{_GAPS if found.scan.missing > 0.0 else ''}",
        lambda: spectrum_plot(found),
        "Power spectrum against wavelength, radial and along both axes",
    )
    slopes = "the rms slope between points against their distance; where it does not level off "
    slopes += "towards short ones it is one of the cut-off"
    texture = Picture(
        "texture",
        f"{_capital(slopes)}. {cutoff}"
        if profile
        else "How far the heights hang together: their autocorrelation along both axes, and "
        f"{slopes}. {cutoff}",
        lambda: texture_plot(found),
        "Autocorrelation of the heights, and rms slope against distance",
    )
    cutoffs = Picture(
        "cutoffs",
        f"Every parameter against the short-wave cut-off. {cutoff} A parameter that does not level "
        "off is one of the cut-off as much as of the surface.",
        lambda: cutoff_plot(found),
        "Summit density, radius, spread, rms height and slope, Nayak's alpha against the cut-off",
    )
    return (
        heights,
        density,
        spectrum,
        texture,
        *((cutoffs,) if found.has_cutoffs else ()),
        *joint_section.tail_picture(found),
        *joint_section.pictures(found),
    )


# -- rows of files --------------------------------------------------------------------------------


def _cutoff_rows(found: Findings) -> str:
    """Parameters against the cut-off; empty where there is no cut-off or no value."""
    units = {"cutoff": "m", "counted": "-", "m0": "m^2", "m2": "-", "m4": "1/m^2", "nayak": "-"}
    names = found.table.names
    heads = [units.get(name) or ("1/m^2" if name.endswith("density") else "m") for name in names]
    lines = [",".join(f"{name} [{unit}]" for name, unit in zip(names, heads, strict=True))]
    for row in found.table.rows():
        cells = [
            "" if value != value or (name == "cutoff" and value == 0.0) else repr(value)
            for name, value in row.items()
        ]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def _summit_rows(found: Findings) -> str:
    """The summits, one a row, highest first."""
    assert found.summits is not None
    summits = found.summits
    head = "x [m],y [m],height [m],radius [m],curvature_1 [1/m],curvature_2 [1/m],prominence [m]"
    parts = [summits.positions, summits.heights, summits.radii, summits.curvatures]
    columns = np.column_stack([*parts, summits.prominences])
    columns = columns[np.argsort(-summits.heights, kind="stable")]
    rows = [",".join(map(repr, row)) for row in columns.tolist()]
    return "\n".join([head, *rows]) + "\n"
