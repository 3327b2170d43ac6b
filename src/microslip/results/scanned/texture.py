"""Texture of a scan: parameters of ISO 25178, the self-affine fit, and the spectrum as a table."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.units import SMALLEST, engineering, significant
from microslip.report.document import Column, Note, Section, Table
from microslip.report.files import csv_text
from microslip.scans.findings import Findings

_LABELS = {
    "core_height": ("Sk, core height", "m"),
    "peak_height": ("Spk, reduced peak height", "m"),
    "valley_depth": ("Svk, reduced dale depth", "m"),
    "peak_material_ratio": ("Smr1, material ratio of peaks", ""),
    "valley_material_ratio": ("Smr2, material ratio of dales", ""),
    "autocorrelation_length": ("Sal, autocorrelation length", "m"),
    "texture_aspect_ratio": ("Str, texture aspect ratio", ""),
    "developed_area_ratio": ("Sdr, developed area ratio", ""),
    "rms_gradient": ("Sdq, rms gradient", ""),
    "peak_density": ("Spd, density of hills", "1/m^2"),
    "peak_curvature": ("Spc, curvature of hills", "1/m"),
}


def section(findings: Findings, texture: dict[str, Any]) -> Section:
    """Texture on the page."""
    rows = []
    if texture["areal"] is not None:
        for name, (label, unit) in _LABELS.items():
            value = texture["areal"][name]
            rows.append((label, _written(value, unit)))
    fit = texture["self_affine"]
    notes = []
    if fit is not None:
        rows.append(("Hurst exponent", f"{fit['hurst']:.3f} ± {fit['error']:.2g}"))
        law = "a power law" if fit["misfit"] < 2.0 else "no power law: mind the figure"
        notes.append(
            f"Hurst's exponent is that of the spectrum before any cut-off between wavelengths of "
            f"{engineering(fit['shortest'], 'm')} (eight pixels) and "
            f"{engineering(fit['longest'], 'm')} (a quarter of the scan). Its density is "
            f"{significant(fit['misfit'], 2)} times its uncertainty from the law: {law}."
        )
    slopes = texture["slopes"]
    if len(slopes) > 1:
        ends = [
            f"{significant(row['rms_slope'], 3)} over {engineering(row['distance'], 'm')}"
            for row in (slopes[0], slopes[-1])
        ]
        notes.append(f"The rms slope between points is {ends[0]} and {ends[1]}.")
    columns = (Column("quantity", "ISO 25178-2:2021"), Column("value", "value"))
    blocks = [Table("", columns, tuple(rows))] if rows else []
    return Section("Texture", (*blocks, *(Note(" ".join(notes)) for _ in notes[:1])), brief=False)


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
    return engineering(value, unit) if unit == "m" else f"{significant(value)} {unit}".rstrip()
