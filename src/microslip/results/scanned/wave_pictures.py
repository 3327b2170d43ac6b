"""Waves of a scan: spectrum, autocorrelation, slopes, and all parameters against the cut-off."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering, prefix
from microslip.report.plot import (
    COLORS,
    DASHED,
    Area,
    Axis,
    Band,
    Entry,
    Line,
    Marker,
    Panel,
    Plot,
    Rule,
    beside,
)
from microslip.report.scales import length_prefix
from microslip.report.ticks import logarithmic
from microslip.results.scanned.findings import Findings
from microslip.results.scanned.texture import self_affine
from microslip.scans.areal_parameters import autocorrelation, slope_over_distance
from microslip.scans.cutoffs import CutoffTable

_MICRO = 1e-6
_REMOVED = "#e4e4e4"
_EDGE = "#444444"
_UNDER = "#8a8a8a"
_SCATTER = "#c6dbef"
_BELOW = 1e-3
"""How far below the lowest density before the cut-off the axis goes."""
_AXIS_LOOKS: tuple[tuple[str, tuple[float, ...]], ...] = ((COLORS[1], ()), (COLORS[2], DASHED))


def spectrum_plot(findings: Findings) -> Plot:
    """The spectrum of the levelled scan and what the cut-offs leave of it.

    Radial and along the axes; of a profile, along it.
    """
    unfiltered_spectrum, filtered_spectrum = findings.whole_spectrum, findings.spectrum
    profile, cut = findings.scan.is_profile, findings.request.is_filtered
    unit, letter = length_prefix(max(findings.scan.size), min(findings.scan.pixel))
    under = (_UNDER, 2.4) if cut else (COLORS[0], 1.4)
    panels: list[Panel] = []
    legend: list[Entry] = []
    if not profile:
        before = [
            _line(
                unfiltered_spectrum.wavelength / unit,
                unfiltered_spectrum.density / _MICRO**4,
                *under,
            )
        ]
        legend.append(Entry("levelled", under[0]))
        after = []
        if cut:
            after = [
                _line(
                    filtered_spectrum.wavelength / unit,
                    filtered_spectrum.density / _MICRO**4,
                    COLORS[0],
                )
            ]
            legend.append(Entry("cut off", COLORS[0]))
        panel = Panel(_wavelength(letter), Axis("Density C [µm⁴]", log=True))
        panel.note = "Mean of all directions"
        part = 1.0 + np.minimum(unfiltered_spectrum.relative_error, 0.9) * np.array([[1.0], [-1.0]])
        x = unfiltered_spectrum.wavelength / unit
        edges = unfiltered_spectrum.density / _MICRO**4 * part
        panel.add(
            Area(np.concatenate([x, x[::-1]]), np.concatenate([edges[0], edges[1][::-1]]), _SCATTER)
        )
        legend.append(Entry("± its uncertainty", _SCATTER))
        if (fit := self_affine(findings)) is not None:
            at = np.array([fit.shortest, fit.longest])
            after_law = _line(at / unit, fit.density(at) / _MICRO**4, COLORS[3], 1.6, DASHED)
            legend.append(Entry(f"H = {fit.hurst:.2f}", COLORS[3], DASHED))
        _fill(panel, findings, unit, before, after)
        if fit is not None:
            panel.add(after_law)
        panels.append(panel)
    before = [
        _line(p.wavelength / unit, p.density / _MICRO**3, *under) for p in unfiltered_spectrum.axes
    ]
    after = []
    names = ("along the profile",) if profile else ("along x", "along y")
    for name, part, (color, dash) in zip(names, filtered_spectrum.axes, _AXIS_LOOKS, strict=False):
        after.append(_line(part.wavelength / unit, part.density / _MICRO**3, color, 1.4, dash))
        legend.append(Entry(name, color, dash))
    panel = Panel(_wavelength(letter), Axis("Density of profiles [µm³]", log=True))
    panel.note = "Along the profile" if profile else "Along the axes"
    panel.note += ", in grey before the cut-off" if cut else ""
    _fill(panel, findings, unit, before if cut else [], after, before)
    panels.append(panel)
    request = findings.request
    ends = [("short", request.cutoff), ("long", request.long_cutoff)]
    bounds = [
        f"{name}-wave {engineering(length, 'm', 4, trim=True)}" for name, length in ends if length
    ]
    if bounds:
        legend.append(Entry(f"cut-off{'s' * (len(bounds) > 1)}: {', '.join(bounds)}", _EDGE))
    return beside(panels, 4.1, findings.title("Power spectrum"), legend)


def _wavelength(letter: str) -> Axis:
    return Axis(f"Wavelength [{letter}m]", log=True)


def _line(
    x: Floats, y: Floats, color: str, width: float = 1.4, dash: tuple[float, ...] = ()
) -> Line:
    return Line(x, np.where(y > 0.0, y, np.nan), color, width, dash)


def _fill(
    panel: Panel,
    findings: Findings,
    unit: float,
    before: list[Line],
    after: list[Line],
    unfiltered: list[Line] | None = None,
) -> None:
    """Lines in a panel, and the waves that are removed on grey ground."""
    low_x, right = 2.0 * min(findings.scan.pixel) / unit, 1.05 * max(findings.scan.size) / unit
    low, high = _ends([*before, *after], low_x, right)
    # What the filter leaves far below all that there was is nothing to look at.
    lowest = _BELOW * _ends(unfiltered or before, low_x, right)[0]
    panel.y.low, panel.y.high = max(low, lowest) / 2.0, 4.0 * high
    panel.x.low, panel.x.high = low_x, right
    request = findings.request
    for cutoff, ends in (
        (request.cutoff, (low_x, (request.cutoff or low_x) / unit)),
        (request.long_cutoff, ((request.long_cutoff or right) / unit, right)),
    ):
        if cutoff is not None:
            panel.items[:0] = [Band(*ends, "x", _REMOVED)]
            panel.add(Rule(cutoff / unit, "x", _EDGE, 0.9, ()))
    panel.add(*before, *after)


def _ends(lines: Iterable[Line], low_x: float, right: float) -> tuple[float, float]:
    """Lowest and highest value that is seen."""
    ordinates = [
        line.y[(line.x >= low_x) & (line.x <= right) & np.isfinite(line.y)] for line in lines
    ]
    values = np.concatenate(ordinates)
    return (float(values.min()), float(values.max())) if values.size else (1.0, 1.0)


_DECAY = 0.2
"""Where ISO 25178-2 reads off the autocorrelation length."""


def texture_plot(findings: Findings) -> Plot:
    """The autocorrelation along both axes, but of a profile, and the rms slope over distance."""
    unit, letter = length_prefix(max(findings.scan.size), min(findings.scan.pixel))
    panels, legend = [], []
    if not findings.scan.is_profile:
        correlation = autocorrelation(findings.scan)
        values = correlation.values
        rows, columns = values.shape
        along = ((values[rows // 2], COLORS[1], ()), (values[:, columns // 2], COLORS[2], DASHED))
        panel = Panel(Axis(f"Lag [{letter}m]"), Axis("Autocorrelation [–]"), note="Heights")
        for lags, (line, color, dash), name in zip(correlation.lags, along, "xy", strict=True):
            ahead = lags >= 0.0
            panel.line(lags[ahead] / unit, line[ahead], color, dash=dash)
            legend.append(Entry(f"along {name}", color, dash))
        panel.add(Rule(_DECAY, "y", "#444444", 0.9, (1.0, 1.0)))
        panel.x.low = 0.0
        legend.append(Entry(f"{_DECAY:g}, where Sal is read off", "#444444", (1.0, 1.0)))
        panels.append(panel)
    distances, slopes = slope_over_distance(findings.scan)
    drawable = np.isfinite(slopes) & (slopes > 0.0)
    if drawable.any():
        panel = Panel(
            Axis(f"Distance [{letter}m]", log=True),
            Axis("Rms slope between points [–]", log=True),
            note="Slopes",
        )
        panel.line(distances[drawable] / unit, slopes[drawable], COLORS[0])
        panel.marks(distances[drawable] / unit, slopes[drawable], COLORS[0])
        panels.append(panel)
    return beside(panels, 3.6, findings.title("Texture"), legend)


_SHORT_DASH = (1.0, 1.0)


class _EstimateLook(NamedTuple):
    color: str
    marker: Marker
    dash: tuple[float, ...] = ()


_ESTIMATE_LOOKS = {
    "mccool": _EstimateLook(COLORS[1], "o"),
    "counted": _EstimateLook(COLORS[2], "s", DASHED),
    "": _EstimateLook(COLORS[0], "o"),
}


class _Content(NamedTuple):
    """What a panel shows: columns of the table by their look, and the unit."""

    quantity: str
    columns: dict[str, str]
    unit: str


_CONTENTS = (
    _Content("Summit density", {k: f"{k}_density" for k in ("mccool", "counted")}, "1/mm²"),
    _Content("Summit radius", {k: f"{k}_radius" for k in ("mccool", "counted")}, "m"),
    _Content("Std of summit heights", {k: f"{k}_std" for k in ("mccool", "counted")}, "m"),
    _Content("Rms height Sq", {"": "rms"}, "m"),
    _Content("Rms slope", {"": "m2"}, "–"),
    _Content("Nayak's α", {"": "nayak"}, "–"),
)


def cutoff_plot(findings: Findings) -> Plot:
    """Density, radius, spread and the moments against the cut-off; none is at the left."""
    table, scan = findings.table, findings.scan
    unit, letter = length_prefix(max(scan.size) / 8.0, min(scan.pixel))
    # No cut-off has its place at the left, where a pixel is.
    place_of_none = min(scan.pixel) / unit
    cutoffs = table.cutoff / unit
    x = np.where(table.cutoff > 0.0, cutoffs, place_of_none)
    high = max(1.3 * float(cutoffs[-1]), 4.0 * place_of_none)
    first = float(cutoffs[1]) if cutoffs.size > 1 else math.inf
    ticks = logarithmic(min(0.8 * first, high), high, 4)
    places = [(at, text) for at, text in (*ticks.major, *ticks.minor) if text and at >= 0.8 * first]
    place = place_of_none if findings.request.cutoff is None else findings.request.cutoff / unit
    panels = []
    for number, content in enumerate(_CONTENTS):
        row, column = divmod(number, 3)
        lines = {look: _column(table, name) for look, name in content.columns.items()}
        scale, label = _scale(list(lines.values()), content.unit)
        panel = Panel(
            Axis(
                f"Cut-off [{letter}m]",
                0.75 * place_of_none,
                high,
                log=True,
                ticks=[(place_of_none, "none"), *places],
                bare=row == 0,
            ),
            Axis(log=True),
            note=f"{content.quantity} [{label}]",
            cell=(row, row, column, column),
        )
        panel.add(Rule(place, "x", _EDGE, 0.9, _SHORT_DASH))
        for name, values in lines.items():
            look = _ESTIMATE_LOOKS[name]
            y = np.where(values > 0.0, values / scale, np.nan)
            # The step from none to the first cut-off is not to scale: no line there.
            panel.line(x[1:], y[1:], look.color, dash=look.dash)
            panel.marks(x, y, look.color, marker=look.marker)
        panels.append(panel)
    legend = [Entry("McCool's moments", COLORS[1], (), "o")]
    if not scan.is_profile:
        legend.append(Entry("counted", COLORS[2], DASHED, "s"))
    legend.append(Entry(findings.cutoff_text(), _EDGE, _SHORT_DASH))
    return Plot(
        panels,
        5.4,
        findings.title("Cut-off dependence"),
        heights=(1.0, 1.0),
        widths=(1.0, 1.0, 1.0),
        legend=tuple(legend),
    )


def _column(table: CutoffTable, name: str) -> Floats:
    values: Floats = getattr(table, name)
    return np.sqrt(values) if name == "m2" else values


def _scale(lines: list[Floats], unit: str) -> tuple[float, str]:
    """What values are divided by, and the unit that is left."""
    if unit != "m":
        return (1e6 if unit == "1/mm²" else 1.0), unit
    values = np.concatenate(lines)
    values = values[np.isfinite(values) & (values > 0.0)]
    if not values.size:
        return 1.0, unit
    factor, letter = prefix(math.sqrt(float(values.min()) * float(values.max())))
    return factor, f"{letter}m"
