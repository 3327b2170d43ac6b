"""How far heights and slopes of a scan hang together: autocorrelation and slope over distance."""

from __future__ import annotations

import numpy as np

from microslip.report.plot import COLORS, DASHED, Axis, Entry, Panel, Plot, Rule
from microslip.report.scales import length_prefix
from microslip.results.scanned.findings import Findings
from microslip.scans.areal_parameters import autocorrelation, slope_over_distance

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
    for place, panel in enumerate(panels):
        panel.cell = (0, 0, place, place)
    return Plot(
        panels, 3.6, findings.title("Texture"), widths=(1.0,) * len(panels), legend=tuple(legend)
    )
