"""A measured scan as plain values, for summary.json and the tables."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from microslip._core.parameters import parameters_of
from microslip._core.quantities import json_value, named
from microslip._core.units import SMALLEST, engineering, significant
from microslip._core.wording import joined
from microslip._version import __version__
from microslip.report.document import Column, Note, Section, Table
from microslip.report.files import csv_text, header
from microslip.report.scanned import joint_section
from microslip.scans.findings import Findings
from microslip.scans.patches import HEIGHTS, MOMENTS, SUMMITS
from microslip.scans.scan_rules import LOST_TO_PIXEL
from microslip.scans.surface_parameters import ArealParameters, ProfileParameters

KIND = "microslip-surface"
"""Kind of a folder of a measured scan in summary.json."""
FACES_KIND = "microslip-faces"
"""The same of a folder of faces."""


def summarise(findings: Findings, remarks: tuple[str, ...]) -> dict[str, Any]:
    """Content of summary.json: plain values in SI units, None for missing ones."""
    request, scan = findings.request, findings.scan
    errors = findings.errors
    units = {name: unit for name, (_, unit) in {**HEIGHTS, **MOMENTS}.items()}
    numbers = named(findings.statistics, *HEIGHTS) | named(findings.moments, *MOMENTS)
    return {
        **header(KIND, 1, findings.raw.name),
        "version": __version__,
        "name": findings.raw.name,
        **named(request, "cutoff", "cutoff_given", "long_cutoff"),
        "level": request.level or "none",
        **named(request, "outliers", "fill", "method", "area"),
        "points": list(scan.heights.shape[::-1]),
        "pixel": list(scan.pixel),
        "size": list(scan.size),
        "missing": json_value(scan.missing),
        "warnings": list(remarks),
        "parameters": {
            name: _quantity(value, errors.get(name), units[name]) for name, value in numbers.items()
        },
        "summits": {
            estimate: None
            if part is None
            else {
                name: _quantity(getattr(part, name), errors.get(f"{estimate}.{name}"), unit)
                for name, (_, unit) in SUMMITS.items()
            }
            for estimate, part in findings.estimates.items()
        },
        "count": None if findings.summits is None else findings.summits.count,
        "prominence": None if findings.summits is None else findings.summits.threshold,
        "heights": {
            "verdict": findings.fit.verdict,
            "word": findings.fit.gaussian.word,
            "fits": [json_value(named(law, *_OF_FITS)) for law in findings.fit.fits],
        },
        # A row for each cut-off; null where there is none, the first law.
        "over_cutoffs": [
            {k: (v or None) if k == "cutoff" else json_value(v) for k, v in row.items()}
            for row in findings.table.rows()
        ],
        "texture": json_value(findings.texture()),
        "joint": joint_section.summary(findings),
        "validity": [json_value(verdict._asdict()) for verdict in findings.verdicts],
        "notes": list(scan.notes if findings.summits is None else findings.summits.notes),
        "files": [],
    }


def _quantity(value: float, error: float | None, unit: str) -> dict[str, Any]:
    return {"value": json_value(value), "error": json_value(error), "unit": unit}


_OF_FITS = ("name", "shapes", "place", "scale", "mirrored", "share", "shift", "tail", "word")


def disagreements(findings: Findings) -> list[str]:
    """Nothing where counting and moments agree within a half; each cause has its own line."""
    mccool, counted = findings.estimates.get("mccool"), findings.estimates.get("counted")
    if mccool is None or counted is None or findings.summits is None:
        return []
    factors = {
        name: getattr(counted, name) / getattr(mccool, name)
        for name in ("density", "radius", "std")
        if getattr(counted, name) > 0.0
    }
    factors_apart = {
        name: factor for name, factor in factors.items() if not 1.0 / 1.5 < factor < 1.5
    }
    if not factors_apart:
        return []
    texts = [
        f"{significant(factor, 2)} times the {_NOUNS[name]}"
        for name, factor in factors_apart.items()
    ]
    if findings.summits.method == "watershed" and "radius" in factors_apart:
        # The verdict on radii compares what McCool's is, one over a mean curvature.
        alike = findings.summits.mean_radius / mccool.radius
        texts[list(factors_apart).index("radius")] += (
            " (the counted one by load; by mean curvature, as McCool's is, "
            f"{significant(alike, 2)} times)"
        )
    judged = sorted(
        (
            v
            for v in findings.verdicts
            # Waves that the pixel removes in part are missing in counting and in moments alike.
            if v.word != "ok"
            and v.name in _CAUSES
            and (v.name != LOST_TO_PIXEL or v.word == "outside")
        ),
        key=lambda verdict: (verdict.word != "outside", [*_CAUSES].index(verdict.name)),
    )
    causes = [_CAUSES[verdict.name](verdict.value or 0.0, findings) for verdict in judged]
    every = findings.summits.neighbours.density
    if counted.density < every / 1.5:
        causes.insert(
            1 if judged and judged[0].word == "outside" else 0,
            f"of all points above their eight neighbours only {100.0 * counted.density / every:.2g}"
            f" % rise {engineering(findings.summits.threshold, 'm')} above the saddle to a higher "
            "one and are round; the rest may be noise, which moments count as summits",
        )
    causes = causes[:_MOST_CAUSES] or ["heights are not Gaussian, as moments assume"]
    gappy = any(verdict.name == "missing" for verdict in judged)
    noisy = any(v.name == LOST_TO_PIXEL for v in judged)
    advice = (
        'Fill the gaps first (`fill="interpolate"`).'
        if gappy
        else "Choose a short-wave cut-off first, then use the counted summits."
        if noisy and findings.request.cutoff is None
        else "Use the counted summits, and check them in the map."
    )
    why = "".join(f"\n({number}) {cause}." for number, cause in enumerate(causes, start=1))
    return [
        (
            f"Two estimates differ: the summits counted have {joined(texts)} of McCool's "
            f"moments. Why:{why}\n{advice}"
        )
    ]


_NOUNS = {"density": "density", "radius": "radius", "std": "spread in height"}


_MOST_CAUSES = 3


def _tail_share(moment: str) -> Callable[[float, Findings], str]:
    return lambda value, findings: (
        f"one point in a thousand carries {100.0 * value:.2g} % of the {moment}"
    )


_CAUSES: dict[str, Callable[[float, Findings], str]] = {
    "kurtosis": lambda value, findings: (
        f"the kurtosis is {value:.3g} (3 if Gaussian): few points, a scratch, pits or spikes, make "
        "the variance of the heights, on which moments are built, while counting takes each summit "
        "once"
    ),
    "missing": lambda value, findings: (
        f"{100.0 * value:.2g} % of the points are missing, and a summit counts only where it and "
        "its eight neighbours are there"
    ),
    LOST_TO_PIXEL: lambda value, findings: (
        "curvatures come from waves of a few pixels and depend on noise and on the pixel"
    ),
    "anisotropy": lambda value, findings: (
        f"slopes across the lay are {value:.2g} times those along it, but moments are averaged "
        "over directions"
    ),
    "share of m0 in 0.1 % of points": _tail_share("variance of the heights"),
    "share of m2 in 0.1 % of points": _tail_share("mean square slope"),
    "share of m4 in 0.1 % of points": _tail_share("mean square curvature"),
}
"""Verdicts that tell why counting and moments differ, in words; the most telling first."""


def texture_section(findings: Findings, texture: dict[str, Any]) -> Section:
    """Texture on the page."""
    rows = []
    if texture["areal"] is not None:
        rows = [
            (f"{item.symbol}, {item.meaning}", _written(texture["areal"][item.name], item.unit))
            for item in parameters_of(ArealParameters)
        ]
    fit = texture["self_affine"]
    notes = []
    if fit is not None:
        rows.append(("Hurst exponent", f"{fit['hurst']:.3f} ± {fit['error']:.2g}"))
        law = "a power law" if fit["misfit"] < 2.0 else "not a power law, see the figure"
        notes.append(
            f"Hurst's exponent is that of the spectrum before any cut-off between wavelengths of "
            f"{engineering(fit['shortest'], 'm')} (eight pixels) and "
            f"{engineering(fit['longest'], 'm')} (a quarter of the scan). The density "
            f"departs from it by {significant(fit['misfit'], 2)} times its uncertainty: {law}."
        )
    slopes = texture["slopes"]
    if len(slopes) > 1:
        ends = [
            f"{significant(row['rms_slope'], 3)} over {engineering(row['distance'], 'm')}"
            for row in (slopes[0], slopes[-1])
        ]
        notes.append(f"The rms slope between points is {ends[0]} and {ends[1]}.")
    head = "spectrum" if texture["areal"] is None else "ISO 25178-2:2021"
    columns = (Column("quantity", head), Column("value", "value"))
    blocks = [Table("", columns, tuple(rows))] if rows else []
    if along := texture["profile"]:
        blocks.append(_of_lines(along))
    return Section("Texture", (*blocks, *(Note(" ".join(notes)) for _ in notes[:1])), brief=False)


def _of_lines(along: dict[str, dict[str, Any]]) -> Table:
    """Parameters of profiles, of an area those of its lines along both axes."""
    heads = ["value"] if along.keys() == {"x"} else [f"lines along {axis}" for axis in along]
    return Table(
        "",
        (
            Column("quantity", "ISO 21920-2:2021"),
            *(Column(f"lines_{axis}", head) for axis, head in zip(along, heads, strict=True)),
        ),
        tuple(
            (
                f"{item.symbol}, {item.meaning}",
                *(_written(values[item.name], item.unit) for values in along.values()),
            )
            for item in parameters_of(ProfileParameters)
        ),
    )


def spectrum_csv(findings: Findings) -> str:
    """The spectrum before and after the cut-offs, with the uncertainty of each ring."""
    unfiltered, filtered = findings.whole_spectrum, findings.spectrum
    unit = "m^3" if findings.scan.is_profile else "m^4"
    heads = ["wavelength [m]", "wavenumber [rad/m]", f"density [{unit}]", "relative_error [-]"]
    density = (
        filtered.density
        if filtered.density.shape == unfiltered.density.shape
        else unfiltered.density
    )
    # What filters leave far below all that was measured is nothing, and too small to be read.
    densities = [np.where(c > SMALLEST, c, 0.0) for c in (unfiltered.density, density)]
    columns = (
        unfiltered.wavelength, unfiltered.wavenumber, densities[0],
        unfiltered.relative_error, densities[1],
    )  # fmt: skip
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return csv_text([*heads, f"density_cut_off [{unit}]"], (map(repr, row) for row in rows))


def _written(value: float | None, unit: str) -> str:
    if value is None:
        return "–"
    if unit == "1/m^2":
        return f"{significant(1e-6 * value)} 1/mm²"
    if unit == "rad":
        return f"{math.degrees(value):.1f}°"
    if not unit and float(value).is_integer():
        return f"{value:.0f}"
    return engineering(value, unit) if unit == "m" else f"{significant(value)} {unit}".rstrip()
