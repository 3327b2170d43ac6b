"""Figures of a scan: map of heights with summits, and power spectrum."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from microslip._core.checks import Floats
from microslip._core.quantities import Quantity
from microslip._core.units import engineering
from microslip.figures.kit import (
    EDGE,
    LineStyle,
    axis_of,
    between,
    coarse,
    coloured,
    drawable,
    length_prefix,
    map_panel,
    scale_of_colours,
    with_scale,
)
from microslip.figures.plot import (
    COLORS,
    DASHED,
    Band,
    Entry,
    Guide,
    Line,
    Panel,
    Pixels,
    Plot,
)
from microslip.surfaces.figures import HEIGHT, SHARE, trace_figure
from microslip.surfaces.findings import Findings
from microslip.surfaces.height_map import HeightMap
from microslip.surfaces.summits import Summits

MOST_MARKED = 150
IN_DETAIL = 80
_FRAME = "#D55E00"


def height_plot(findings: Findings) -> Plot:
    """Plot the height map with summits and an enlarged detail, or the trace of a profile."""
    if findings.scan.is_profile:
        return trace_figure(findings.scan, findings.title("Heights"))
    scan, summits = findings.scan, findings.summits
    scale = length_prefix(max(scan.size))
    unit = scale[0]
    heights = np.where(np.isnan(scan.unfiltered.heights), np.nan, scan.heights)
    low, high = np.nanquantile(heights, (SHARE, 1.0 - SHARE)).tolist()
    middle = float(np.nanmean(heights))
    rows, columns = _detail(scan, summits)
    dx, dy = (step / unit for step in scan.pixel)
    panels = []
    for column, (part, start) in enumerate(
        ((heights, (0, 0)), (heights[rows, columns], (rows.start, columns.start)))
    ):
        x, y = (start[1] - 0.5) * dx, (start[0] - 0.5) * dy
        ends = x, x + part.shape[1] * dx, y, y + part.shape[0] * dy
        panels.append(map_panel(ends, scale, column))
        panels[column].add(Pixels(coloured(coarse(part)[::-1], low, high), *ends))
    left, right = panels
    x, y = np.array(ends[:2])[[0, 1, 1, 0, 0]], np.array(ends[2:])[[0, 0, 1, 1, 0]]
    for panel in panels:
        panel.line(x, y, _FRAME, width=1.6)
    left.note = _mark_highest(left, summits, unit)
    right.note = "The framed part"
    if summits is not None:
        right.note += ", every summit"
        _mark(right, summits.positions / unit, 5.0)
    right.y.label = ""
    tall = scan.size[1] / scan.size[0]
    low, high = low - middle, high - middle
    axis = axis_of(HEIGHT, max(high, -low))
    axis.low, axis.high = low / axis.unit, high / axis.unit
    bar = scale_of_colours(axis, coloured(np.linspace(0.0, 1.0, 256)[None], 0.0, 1.0), (1, 1, 0, 1))
    plot = with_scale(panels, bar, min(max(3.3 * tall, 1.6), 7.0), 1.3, (1.0, 1.0))
    plot.title = findings.title("Heights")
    return plot


def _mark_highest(panel: Panel, summits: Summits | None, unit: float) -> str:
    if summits is None:
        return "No summits"
    if summits.count <= MOST_MARKED:
        _mark(panel, summits.positions / unit, 4.0)
        return f"All {summits.count} summits" if summits.count > 1 else "One summit"
    highest = np.argsort(-summits.heights, kind="stable")[:MOST_MARKED]
    _mark(panel, summits.positions[highest] / unit, 3.4)
    return f"The {MOST_MARKED} highest of {summits.count} summits"


def _mark(panel: Panel, places: Floats, size: float) -> None:
    panel.marks(places[:, 0], places[:, 1], size=size)


def _detail(scan: HeightMap, summits: Summits | None) -> tuple[slice, slice]:
    rows, columns = scan.heights.shape
    share = 0.25
    if summits is not None:
        share = min(max(math.sqrt(IN_DETAIL / summits.count), 0.02), 1.0 / 3.0)
    counts = [max(8, round(share * n)) for n in (rows, columns)]
    starts = [max((n - count) // 2, 0) for n, count in zip((rows, columns), counts, strict=True)]
    first, second = (slice(start, start + n) for start, n in zip(starts, counts, strict=True))
    return slice(first.start, min(first.stop, rows)), slice(second.start, min(second.stop, columns))


_MICRO = 1e-6
_REMOVED = "#e4e4e4"
_UNDER = "#8a8a8a"
_SCATTER = "#c6dbef"
_BELOW = 1e-3
"""Lowest density shown over the lowest density before the cut-off."""
_ALONG = (LineStyle(COLORS[1]), LineStyle(COLORS[2], DASHED))
"""Line styles along x and y."""


def spectrum_plot(findings: Findings) -> Plot:
    """Plot the spectrum of the levelled scan, and its part within the cut-offs.

    An area has a radial spectrum and one along each axis, a profile only one along its length.
    """
    unfiltered_spectrum, filtered_spectrum = findings.whole_spectrum, findings.spectrum
    profile, cut = findings.scan.is_profile, findings.request.is_filtered
    scale = length_prefix(max(findings.scan.size), min(findings.scan.pixel))
    unit, wavelength = scale[0], Quantity("m", label="Wavelength")
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
        density_axis = axis_of(Quantity("m^4", label="Density C"), (_MICRO**4, "µ"), log=True)
        panel = Panel(axis_of(wavelength, scale, log=True), density_axis)
        panel.note = "Mean of all directions"
        error = np.minimum(unfiltered_spectrum.relative_error, 0.9)
        panel.add(between(x, density * (1.0 + error), density * (1.0 - error), _SCATTER))
        legend.append(Entry("± its uncertainty", _SCATTER))
        _fill(panel, findings, unit, before, after)
        panels.append(panel)
    before = [
        _line(p.wavelength / unit, p.density / _MICRO**3, *under) for p in unfiltered_spectrum.axes
    ]
    after = []
    names = ("along the profile",) if profile else ("along x", "along y")
    for name, part, (color, dash, _) in zip(names, filtered_spectrum.axes, _ALONG, strict=False):
        after.append(_line(part.wavelength / unit, part.density / _MICRO**3, color, 1.4, dash))
        legend.append(Entry(name, color, dash))
    density_axis = axis_of(Quantity("m^3", label="Density of profiles"), (_MICRO**3, "µ"), log=True)
    panel = Panel(axis_of(wavelength, scale, log=True), density_axis)
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
    for column, panel in enumerate(panels):
        panel.cell = (0, 0, column, column)
    widths = (1.0,) * len(panels)
    return Plot(panels, 4.1, findings.title("Power spectrum"), widths=widths, legend=tuple(legend))


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
    low_x, right = 2.0 * min(findings.scan.pixel) / unit, 1.05 * max(findings.scan.size) / unit
    low, high = _ends([*before, *after], low_x, right)
    # Densities far below the original ones after a filter are not shown.
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
            panel.add(Guide(cutoff / unit, "x", EDGE, 0.9, ()))
    panel.add(*before, *after)


def _ends(lines: Iterable[Line], low_x: float, right: float) -> tuple[float, float]:
    ordinates = [
        line.y[(line.x >= low_x) & (line.x <= right) & np.isfinite(line.y)] for line in lines
    ]
    values = np.concatenate(ordinates)
    return (float(values.min()), float(values.max())) if values.size else (1.0, 1.0)
