"""Waves of a scan: spectrum, autocorrelation, slopes, and all parameters against the cut-off."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.report.kit import (
    EDGE,
    SHORT_DASH,
    Family,
    Look,
    between,
    drawable,
    families,
    marked_line,
)
from microslip.report.plot import (
    COLORS,
    DASHED,
    Axis,
    Band,
    Entry,
    Line,
    Panel,
    Plot,
    Rule,
    beside,
)
from microslip.report.scales import length_prefix
from microslip.report.ticks import logarithmic
from microslip.scans.areal_parameters import autocorrelation, slope_over_distance
from microslip.scans.findings import Findings

_MICRO = 1e-6
_REMOVED = "#e4e4e4"
_UNDER = "#8a8a8a"
_SCATTER = "#c6dbef"
_BELOW = 1e-3
"""How far below the lowest density before the cut-off the axis goes."""
_ALONG = (Look(COLORS[1]), Look(COLORS[2], DASHED))
"""Along x and along y."""


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
        x = unfiltered_spectrum.wavelength / unit
        density = unfiltered_spectrum.density / _MICRO**4
        before, after = [_line(x, density, *under)], []
        legend.append(Entry("levelled", under[0]))
        if cut:
            after.append(
                _line(filtered_spectrum.wavelength / unit, filtered_spectrum.density / _MICRO**4)
            )
            legend.append(Entry("cut off", COLORS[0]))
        panel = Panel(_wavelength(letter), Axis("Density C [µm⁴]", log=True))
        panel.note = "Mean of all directions"
        error = np.minimum(unfiltered_spectrum.relative_error, 0.9)
        panel.add(between(x, density * (1.0 + error), density * (1.0 - error), _SCATTER))
        legend.append(Entry("± its uncertainty", _SCATTER))
        _fill(panel, findings, unit, before, after)
        if (fit := findings.self_affine) is not None:
            at = np.array([fit.shortest, fit.longest])
            panel.add(_line(at / unit, fit.density(at) / _MICRO**4, COLORS[3], 1.6, DASHED))
            legend.append(Entry(f"H = {fit.hurst:.2f}", COLORS[3], DASHED))
        panels.append(panel)
    before = [
        _line(p.wavelength / unit, p.density / _MICRO**3, *under) for p in unfiltered_spectrum.axes
    ]
    after = []
    names = ("along the profile",) if profile else ("along x", "along y")
    for name, part, (color, dash, _) in zip(names, filtered_spectrum.axes, _ALONG, strict=False):
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
        legend.append(Entry(f"cut-off{'s' * (len(bounds) > 1)}: {', '.join(bounds)}", EDGE))
    return beside(panels, 4.1, findings.title("Power spectrum"), legend)


def _wavelength(letter: str) -> Axis:
    return Axis(f"Wavelength [{letter}m]", log=True)


def _line(
    x: Floats,
    y: Floats,
    color: str = COLORS[0],
    width: float = 1.4,
    dash: tuple[float, ...] = (),
) -> Line:
    return Line(x, drawable(y), color, width, dash)


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
            panel.add(Rule(cutoff / unit, "x", EDGE, 0.9, ()))
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
        along = values[rows // 2], values[:, columns // 2]
        panel = Panel(Axis(f"Lag [{letter}m]"), Axis("Autocorrelation [–]"), note="Heights")
        for lags, line, how, name in zip(correlation.lags, along, _ALONG, "xy", strict=True):
            ahead = lags >= 0.0
            panel.line(lags[ahead] / unit, line[ahead], how.color, dash=how.dash)
            legend.append(how.entry(f"along {name}", marked=False))
        panel.add(Rule(_DECAY, "y", EDGE, 0.9, SHORT_DASH))
        panel.x.low = 0.0
        legend.append(Entry(f"{_DECAY:g}, where Sal is read off", EDGE, SHORT_DASH))
        panels.append(panel)
    distances, slopes = slope_over_distance(findings.scan)
    positive = np.isfinite(slopes) & (slopes > 0.0)
    if positive.any():
        panel = Panel(
            Axis(f"Distance [{letter}m]", log=True),
            Axis("Rms slope between points [–]", log=True),
            note="Slopes",
        )
        marked_line(panel, distances[positive] / unit, slopes[positive], Look())
        panels.append(panel)
    return beside(panels, 3.6, findings.title("Texture"), legend)


_ESTIMATES = {"mccool": Look(COLORS[1]), "counted": Look(COLORS[2], DASHED, "s")}


def cutoff_plot(findings: Findings) -> Plot:
    """Density, radius, spread and the moments against the cut-off; none is at the left."""
    table, scan = findings.table, findings.scan
    unit, letter = length_prefix(max(scan.size) / 8.0, min(scan.pixel))
    # No cut-off has its place at the left, where a pixel is.
    place_of_none = min(scan.pixel) / unit
    cutoffs = table.cutoff / unit
    high = max(1.3 * float(cutoffs[-1]), 4.0 * place_of_none)
    first = float(cutoffs[1]) if cutoffs.size > 1 else math.inf
    ticks = logarithmic(min(0.8 * first, high), high, 4)
    places = [(at, text) for at, text in (*ticks.major, *ticks.minor) if text and at >= 0.8 * first]
    place = place_of_none if findings.request.cutoff is None else findings.request.cutoff / unit

    def axis(bare: bool) -> Axis:
        return Axis(
            f"Cut-off [{letter}m]",
            0.75 * place_of_none,
            high,
            log=True,
            ticks=[(place_of_none, "none"), *places],
            bare=bare,
        )

    summits = [
        Family(
            name,
            of,
            [(how, getattr(table, f"{by}_{key}")) for by, how in _ESTIMATES.items()],
        )
        for name, key, of in (
            ("Summit density", "density", "1/m^2"),
            ("Summit radius", "radius", "m"),
            ("Std of summit heights", "std", "m"),
        )
    ]
    moments = [
        Family("Rms height Sq", "m", [(Look(), table.rms)]),
        Family("Rms slope", "–", [(Look(), np.sqrt(table.m2))]),
        Family("Nayak's α", "–", [(Look(), table.nayak)]),
    ]
    # The step from none to the first cut-off is not to scale: no line there.
    x = np.where(table.cutoff > 0.0, cutoffs, place_of_none)
    panels = families([*summits, *moments], x, axis, first=1, always_log=True)
    for panel in panels:
        panel.items.insert(0, Rule(place, "x", EDGE, 0.9, SHORT_DASH))
    names = ("McCool's moments", "counted")[: 1 if scan.is_profile else 2]
    legend = [how.entry(name) for how, name in zip(_ESTIMATES.values(), names, strict=False)]
    legend.append(Entry(findings.cutoff_text(), EDGE, SHORT_DASH))
    return Plot(
        panels,
        5.4,
        findings.title("Cut-off dependence"),
        heights=(1.0, 1.0),
        widths=(1.0, 1.0, 1.0),
        legend=tuple(legend),
    )
