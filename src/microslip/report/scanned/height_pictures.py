"""Heights of a scan: the map with its summits, and the density in the manner of Fig. 19.6."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering, prefix, significant
from microslip.figures.kit import (
    EDGE,
    SHORT_DASH,
    Family,
    Look,
    between,
    coarse,
    coloured,
    drawable,
    edge_of,
    families,
    length_prefix,
    logarithmic,
    marked_line,
    scale_of_colours,
    sideways_histogram,
    with_scale,
)
from microslip.figures.plot import (
    COLORS,
    DASHED,
    DOTTED,
    Axis,
    Band,
    Entry,
    Line,
    Panel,
    Pixels,
    Plot,
    Rule,
    beside,
)
from microslip.scans.figures import SHARE, trace_figure
from microslip.scans.findings import Findings
from microslip.scans.height_fit import Fit
from microslip.scans.height_map import HeightMap
from microslip.scans.summits import Summits
from microslip.scans.surface_parameters import autocorrelation, slope_over_distance

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
    bins = min(MOST_BINS, max(12, round(math.sqrt(fit.statistics.count))))
    for log, (bottom, top) in ((False, bulk or (low, high)), (True, (low, high))):
        edges = np.linspace(bottom, top, bins + 1)
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
        # On a logarithmic axis zero cannot be drawn: far below its end is used instead.
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


_MICRO = 1e-6
_REMOVED = "#e4e4e4"
_UNDER = "#8a8a8a"
_SCATTER = "#c6dbef"
_BELOW = 1e-3
"""Range of the axis below the lowest density before the cut-off."""
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
"""Level at which ISO 25178-2 defines the autocorrelation length."""


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
    plot = families([*summits, *moments], x, axis, place, 2.7, 0.0, first=1, always_log=True)
    names = ("McCool's moments", "counted")[: 1 if scan.is_profile else 2]
    legend = [how.entry(name) for how, name in zip(_ESTIMATES.values(), names, strict=False)]
    legend.append(Entry(findings.cutoff_text(), EDGE, SHORT_DASH))
    plot.title, plot.legend = findings.title("Cut-off dependence"), tuple(legend)
    return plot
