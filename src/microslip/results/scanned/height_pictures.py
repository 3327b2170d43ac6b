"""Heights of a scan: the map with its summits, and the density in the manner of Fig. 19.6."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import prefix, significant
from microslip.report.kit import edge_of, scale_of_colours, sideways_histogram, with_scale
from microslip.report.plot import (
    COLORS,
    DASHED,
    DOTTED,
    Axis,
    Entry,
    Panel,
    Pixels,
    Plot,
    Rule,
    beside,
)
from microslip.report.scales import length_prefix
from microslip.scans.distribution_fits import Fit
from microslip.scans.figures import SHARE, coarse, coloured, trace_figure
from microslip.scans.findings import Findings
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
    frame = edge_of(*ends, _FRAME, 1.6)
    map_panel.add(frame)
    right.add(frame)
    map_panel.note = _mark_highest(map_panel, summits, unit)
    right.note = "The framed part"
    if summits is not None:
        right.note += ", every summit"
        _mark(right, summits.positions / unit, 5.0)
    right.y.bare = False
    right.y.label = ""
    tall = scan.size[1] / scan.size[0]
    low, high = low - middle, high - middle
    h_unit, h_letter = prefix(max(high, -low))
    bar = scale_of_colours(
        f"Height above the mean [{h_letter}m]",
        low / h_unit,
        high / h_unit,
        coloured(np.linspace(0.0, 1.0, 256)[None], 0.0, 1.0),
        (1, 1, 0, 1),
    )
    plot = with_scale([map_panel, right], bar, min(max(3.3 * tall, 1.6), 7.0), 1.3, (1.0, 1.0))
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


_BLUE = COLORS[1]
_SOFT = "#bcd9ea"
MOST_BINS = 160
_FINE = 301
_NARROW = 0.4
"""Share of the range below which the bulk of the heights has a range of its own."""
_FIT_LOOKS: tuple[tuple[str, tuple[float, ...]], ...]
_FIT_LOOKS = (
    (COLORS[2], DASHED),
    (COLORS[3], (1.0, 1.0)),
)
_WORDS = {"ok": "Gaussian", "watch": "roughly Gaussian", "outside": "not Gaussian"}


def density_plot(findings: Findings) -> Plot:
    """A trace and the density of all heights with its fits, in percent and its logarithm."""
    fit, scan = findings.fit, findings.scan
    mean = fit.statistics.mean
    low, high = _range(scan.heights)
    unit, letter = prefix(max(high - mean, mean - low))
    bulk = _bulk(scan.heights, low, high)
    ends = ((low - mean) / unit, (high - mean) / unit)
    trace = Panel(Axis(margin=0.0), Axis(f"Height above the mean [{letter}m]", *ends))
    row = scan.heights if scan.is_profile else scan.heights[scan.heights.shape[0] // 2]
    x_unit, x_letter = length_prefix(scan.size[0])
    trace.x.label = f"Position [{x_letter}m]"
    trace.line(scan.pixel[0] / x_unit * np.arange(row.size), (row - mean) / unit, _BLUE, width=0.8)
    beyond = np.count_nonzero((scan.heights < low) | (scan.heights > high))
    share = significant(100.0 * beyond / fit.statistics.count, 2)
    where = "(a) trace" if scan.is_profile else "(a) middle row"
    trace.note = where + (f"; {share} % beyond" if beyond else "")
    candidates = [law for law in fit.fits if law is not fit.gaussian]
    best = sorted(candidates, key=lambda law: law.share)[:2]
    looks: list[tuple[Fit, str, tuple[float, ...]]] = [(fit.gaussian, COLORS[0], ())]
    looks += [(law, *look) for law, look in zip(best, _FIT_LOOKS, strict=False)]
    panels = [trace]
    percent = 100.0 * unit
    for log, (bottom, top) in ((False, bulk or (low, high)), (True, (low, high))):
        edges = np.linspace(bottom, top, _bins(fit.statistics.count) + 1)
        counts, _ = np.histogram(scan.heights, edges)
        density = percent * counts / (fit.statistics.count * np.diff(edges))
        largest = float(density.max())
        peak = max(largest, float(fit.gaussian.density(mean)) * percent)
        steps = (edges - mean) / unit
        panel = Panel(
            Axis(f"Density [%/{letter}m]", 1e-4 * largest, 2.0 * largest, log=True)
            if log
            else Axis(f"Density [%/{letter}m]", 0.0, 1.1 * peak),
            Axis(low=float(steps[0]), high=float(steps[-1]), bare=log or bulk is None),
            note="(c) its tails (log)"
            if log
            else "(b) density"
            if bulk is None
            else "(b) density, middle part",
        )
        # On a logarithmic axis nothing is zero: far below its end will do.
        foot = 1e-6 * largest if log else 0.0
        panel.add(sideways_histogram(steps, density, foot, _SOFT))
        height = np.linspace(bottom, top, _FINE)
        for law, color, dash in looks:
            values = np.asarray(law.density(height)) * percent
            panel.line(np.maximum(values, foot), (height - mean) / unit, color, dash=dash)
        panels.append(panel)
    if bulk is not None:
        trace.add(*(Rule((at - mean) / unit, "y", "#444444", 0.7, DOTTED) for at in bulk))
    legend = [Entry("all heights", _SOFT)]
    for law, color, dash in looks:
        name = law.name.replace("weibull", "Weibull").replace("student", "Student")
        name = "mirrored " * law.mirrored + name.replace("gaussian", "Gaussian")
        suffix = " missed" if law is fit.gaussian else ""
        legend.append(Entry(f"{name} ({100.0 * law.share:.2g} %{suffix})", color, dash))
    title = findings.title("Heights and their density")
    plot = beside(panels, 3.9, title, legend, (1.9, 1.0, 1.0))
    plot.legend_title = f"Verdict: {_WORDS[fit.gaussian.word]}"
    return plot


def _bins(count: int) -> int:
    return min(MOST_BINS, max(12, round(math.sqrt(count))))


def _bulk(heights: Floats, low: float, high: float) -> tuple[float, float] | None:
    """Heights of nearly all points, if they would be a spike in the whole range; else None."""
    bottom, top = np.nanquantile(heights, (0.02, 0.98)).tolist()
    reach = 0.5 * (top - bottom)
    if 3.0 * reach > _NARROW * (high - low) or not reach > 0.0:
        return None
    return max(bottom - 0.5 * reach, low), min(top + 0.5 * reach, high)


def _range(heights: Floats) -> tuple[float, float]:
    """Heights that are drawn: all, unless a few of them would leave no room for the others."""
    low, high = np.nanquantile(heights, (0.002, 0.998)).tolist()
    reach = 0.5 * (high - low)
    return max(low - reach, float(np.nanmin(heights))), min(high + reach, float(np.nanmax(heights)))
