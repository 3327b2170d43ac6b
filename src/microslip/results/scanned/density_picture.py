"""Roughness and its density in the manner of Fig. 19.6 of the chapter."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import prefix, significant
from microslip.report.plot import COLORS, DASHED, DOTTED, Area, Axis, Entry, Panel, Plot, Rule
from microslip.report.scales import length_prefix
from microslip.results.scanned.findings import Findings
from microslip.scans.distribution_fits import Fit

_BLUE = COLORS[1]
_SOFT = "#bcd9ea"
MOST_BINS = 160
_FINE = 301
_NARROW = 0.4
"""Share of the range below which the bulk of the heights has a range of its own."""
_LOOKS: tuple[tuple[str, tuple[float, ...]], ...] = ((COLORS[2], DASHED), (COLORS[3], (1.0, 1.0)))
_WORDS = {"ok": "Gaussian", "watch": "roughly Gaussian", "outside": "not Gaussian"}


def density_plot(findings: Findings) -> Plot:
    """A trace and the density of all heights with its fits, in percent and its logarithm."""
    fit, scan = findings.fit, findings.scan
    mean = fit.statistics.mean
    low, high = _range(scan.heights)
    unit, letter = prefix(max(high - mean, mean - low))
    bulk = _bulk(scan.heights, low, high)
    ends = ((low - mean) / unit, (high - mean) / unit)
    trace = Panel(
        Axis(margin=0.0), Axis(f"Height above the mean [{letter}m]", *ends), cell=(0, 0, 0, 0)
    )
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
    looks += [(law, *look) for law, look in zip(best, _LOOKS, strict=False)]
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
            cell=(0, 0, 1 + log, 1 + log),
            note="(c) its tails (log)"
            if log
            else "(b) density"
            if bulk is None
            else "(b) density, middle part",
        )
        # On a logarithmic axis nothing is zero: far below its end will do.
        foot = 1e-6 * largest if log else 0.0
        outline = np.maximum(np.repeat(density, 2), foot)
        panel.add(
            Area(
                np.concatenate([[foot], outline, [foot]]),
                np.concatenate([steps[:1], np.repeat(steps, 2)[1:-1], steps[-1:]]),
                _SOFT,
            )
        )
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
    return Plot(
        panels,
        3.9,
        findings.title("Heights and their density"),
        widths=(1.9, 1.0, 1.0),
        legend=tuple(legend),
        legend_title=f"Verdict: {_WORDS[fit.gaussian.word]}",
    )


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
