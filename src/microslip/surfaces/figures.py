"""Figures of a scan: height map, profile trace and summits."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.quantities import Quantity
from microslip._core.units import engineering
from microslip.figures.kit import axis_of, coarse, coloured, length_prefix, map_panel
from microslip.figures.plot import Panel, Pixels, Plot

HEIGHT = Quantity("m", label="Height above the mean")
SHARE = 0.005
"""Fraction of the points beyond each end of the colour scale."""


def trace_figure(scan: Any, title: str = "") -> Plot:
    """Return the figure of a profile."""
    heights = scan.heights - float(np.nanmean(scan.heights))
    panel = Panel(
        axis_of(Quantity("m", label="Position"), scan.size[0], margin=0.0),
        axis_of(HEIGHT, float(np.nanmax(np.abs(heights)))),
    )
    places = scan.pixel[0] / panel.x.unit * np.arange(heights.size)
    panel.line(places, heights / panel.y.unit, width=0.9)
    return Plot([panel], 3.0, title)


def map_figure(scan: Any) -> Plot:
    """Return the figure of the heights in the colour map cividis; for a profile, its trace."""
    if scan.is_profile:
        return trace_figure(scan)
    low, high = np.nanquantile(scan.heights, (SHARE, 1.0 - SHARE)).tolist()
    middle = float(np.nanmean(scan.heights))
    panel = _map_panel(scan)
    ends = panel.x.low or 0.0, panel.x.high or 1.0, panel.y.low or 0.0, panel.y.high or 1.0
    panel.add(Pixels(coloured(coarse(scan.heights)[::-1], low, high), *ends))
    span = " to ".join(engineering(end - middle, "m") for end in (low, high))
    panel.note = f"Heights, dark to light: {span} from the mean"
    return Plot([panel], _page_height(scan))


def summit_figure(summits: Any) -> Plot:
    """Return the figure of the summits, as rings at their positions on the scan."""
    panel = _map_panel(summits.scan)
    unit = panel.x.unit
    size = 5.0 if summits.count <= 200 else 3.0
    panel.marks(*(summits.positions / unit).T, size=size)
    cut = (
        "limited by the pixel"
        if summits.cutoff is None
        else (f"cut-off {engineering(summits.cutoff, 'm', 4, trim=True)}")
    )
    panel.note = f"{summits.count} summits, {cut}"
    return Plot([panel], _page_height(summits.scan))


def _page_height(scan: Any) -> float:
    return float(min(max(6.0 * scan.size[1] / scan.size[0], 2.0), 8.0)) + 0.8


def _map_panel(scan: Any) -> Panel:
    scale = length_prefix(max(scan.size))
    dx, dy = (step / scale[0] for step in scan.pixel)
    rows, columns = scan.heights.shape
    return map_panel((-0.5 * dx, (columns - 0.5) * dx, -0.5 * dy, (rows - 0.5) * dy), scale)
