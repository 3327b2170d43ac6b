"""The map of a scan's heights with its summits, and the trace of a profile."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import prefix
from microslip.report.plot import Axis, Line, Panel, Pixels, Plot
from microslip.report.scales import length_prefix
from microslip.results.scanned.findings import Findings
from microslip.scans.figures import SHARE, coarse, coloured, trace_figure
from microslip.scans.height_map import HeightMap
from microslip.scans.summits import Summits

MOST_MARKED = 150
IN_DETAIL = 80
_FRAME = "#D55E00"


def height_plot(findings: Findings) -> Plot:
    """A map with summits, and a part of it; of a profile, its trace."""
    if findings.scan.is_profile:
        return trace_figure(findings.scan, findings.title("Heights"))
    scan, summits = findings.scan, findings.summits
    unit, letter = length_prefix(max(scan.size))
    low, high = np.nanquantile(scan.heights, (SHARE, 1.0 - SHARE)).tolist()
    middle = float(np.nanmean(scan.heights))
    rows, columns = _detail(scan, summits)
    dx, dy = (step / unit for step in scan.pixel)
    map_panel, right = (
        Panel(
            Axis(f"x [{letter}m]"),
            Axis(f"y [{letter}m]", bare=place == 1),
            equal=True,
            grid=False,
            cell=(0, 0, place, place),
        )
        for place in (0, 1)
    )
    for panel, part, start in (
        (map_panel, scan.heights, (0, 0)),
        (right, scan.heights[rows, columns], (rows.start, columns.start)),
    ):
        x, y = (start[1] - 0.5) * dx, (start[0] - 0.5) * dy
        ends = x, x + part.shape[1] * dx, y, y + part.shape[0] * dy
        panel.x.low, panel.x.high, panel.y.low, panel.y.high = ends
        panel.add(Pixels(coloured(coarse(part)[::-1], low, high), *ends))
    frame = _frame(right)
    map_panel.add(frame)
    right.add(frame)
    map_panel.note = _marked(map_panel, summits, unit)
    right.note = "The framed part"
    if summits is not None:
        right.note += ", every summit"
        _mark(right, summits.positions / unit, 5.0)
    right.y.bare = False
    right.y.label = ""
    tall = scan.size[1] / scan.size[0]
    height = min(max(3.3 * tall, 1.6), 7.0) + 1.3
    bar = _bar(low - middle, high - middle)
    return Plot(
        [map_panel, right, bar],
        height,
        findings.title("Heights"),
        heights=(1.0, 0.14 / (height - 1.3)),
        widths=(1.0, 1.0),
    )


def _frame(panel: Panel) -> Line:
    """A line around what a panel shows."""
    x, y = panel.x, panel.y
    corners = [(x.low, y.low), (x.high, y.low), (x.high, y.high), (x.low, y.high), (x.low, y.low)]
    places = np.array(corners, dtype=float)
    return Line(places[:, 0], places[:, 1], _FRAME, 1.6)


def _bar(low: float, high: float) -> Panel:
    """The scale of colours below the maps."""
    unit, letter = prefix(max(high, -low))
    ends = low / unit, high / unit
    ramp = coloured(np.linspace(0.0, 1.0, 256)[None], 0.0, 1.0)
    return Panel(
        Axis(f"Height above the mean [{letter}m]", *ends),
        Axis(low=0.0, high=1.0, ticks=()),
        grid=False,
        cell=(1, 1, 0, 1),
        items=[Pixels(ramp, *ends, 0.0, 1.0)],
    )


def _marked(panel: Panel, summits: Summits | None, unit: float) -> str:
    if summits is None:
        return "No summits"
    if summits.count <= MOST_MARKED:
        _mark(panel, summits.positions / unit, 4.0)
        return f"All {summits.count} summits" if summits.count > 1 else "One summit"
    highest = np.argsort(-summits.heights, kind="stable")[:MOST_MARKED]
    _mark(panel, summits.positions[highest] / unit, 3.4)
    return f"The {MOST_MARKED} highest of {summits.count} summits"


def _mark(panel: Panel, places: Floats, size: float) -> None:
    """Hollow rings: they show on dark and on light ground."""
    panel.marks(places[:, 0], places[:, 1], size=size)


def _detail(scan: HeightMap, summits: Summits | None) -> tuple[slice, slice]:
    """Rows and columns about the middle, with some tens of summits in them."""
    rows, columns = scan.heights.shape
    share = 0.25
    if summits is not None:
        share = min(max(math.sqrt(IN_DETAIL / summits.count), 0.02), 1.0 / 3.0)
    counts = [max(8, round(share * n)) for n in (rows, columns)]
    starts = [max((n - count) // 2, 0) for n, count in zip((rows, columns), counts, strict=True)]
    first, second = (slice(start, start + n) for start, n in zip(starts, counts, strict=True))
    return slice(first.start, min(first.stop, rows)), slice(second.start, min(second.stop, columns))
