"""Floor 8: the map of a scan's heights with its summits, and the trace of a profile."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from microslip._core.units import prefix
from microslip.study.drawing import length_prefix, new_figure, note

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage
    from numpy.typing import NDArray

    from microslip.scans.height_map import HeightMap
    from microslip.scans.summits import Summits
    from microslip.study.scanned import Findings

MOST_PIXELS = 700
MOST_MARKED = 150
IN_DETAIL = 80
SHARE = 0.005
"""Share of the points at either end of the colour scale that are beyond it."""
_COLOURS = "cividis"  # made for the colour-blind; its lightness rises evenly
_MISSING = "#ffffff"
_MARK = "#ffffff"


def draw(found: Findings) -> Figure:
    """Draw the heights: a map with summits, and a part of it; of a profile, its trace.

    Parameters
    ----------
    found : Findings
        What was found.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    if found.scan.is_profile:
        return _trace(found)
    scan, summits = found.scan, found.summits
    unit, letter = length_prefix(max(scan.size))
    tall = scan.size[1] / scan.size[0]
    figure = new_figure(min(max(3.3 * tall, 1.6), 7.0) + 1.3, found.title("Heights"))
    left, right = figure.subplots(1, 2)
    low, high = np.nanquantile(scan.heights, (SHARE, 1.0 - SHARE)).tolist()
    middle = float(np.nanmean(scan.heights))
    h_unit, h_letter = prefix(max(high - middle, middle - low))
    ends = ((low - middle) / h_unit, (high - middle) / h_unit)
    heights = (scan.heights - middle) / h_unit
    _image(left, heights, scan, (0, 0), unit, ends)
    note(left, _marked(left, summits, unit))
    rows, columns = _detail(scan, summits)
    part = heights[rows, columns]
    image = _image(right, part, scan, (rows.start, columns.start), unit, ends)
    if summits is not None:
        _mark(right, summits.positions / unit, 22.0)
    note(right, "The framed part" + ("" if summits is None else ", every summit"))
    dx, dy = (step / unit for step in scan.pixel)
    frame: dict[str, Any] = {"edgecolor": "#D55E00", "linewidth": 1.4}
    corner = (columns.start - 0.5) * dx, (rows.start - 0.5) * dy
    sides = part.shape[1] * dx, part.shape[0] * dy
    left.add_patch(Rectangle(corner, *sides, fill=False, **frame))
    right.set_xlim(corner[0], corner[0] + sides[0])
    right.set_ylim(corner[1], corner[1] + sides[1])
    left.set_xlim(-0.5 * dx, scan.size[0] / unit - 0.5 * dx)
    left.set_ylim(-0.5 * dy, scan.size[1] / unit - 0.5 * dy)
    for spine in right.spines.values():
        spine.set(**frame)
    for axes in (left, right):
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.set_xlabel(f"x [{letter}m]")
        axes.grid(False)
    left.set_ylabel(f"y [{letter}m]")
    bar = figure.colorbar(image, ax=[left, right], location="bottom", extend="both",
                          shrink=0.6, aspect=40, pad=0.03)  # fmt: skip
    bar.set_label(f"Height above the mean [{h_letter}m]")
    return figure


def _image(
    axes: Axes,
    heights: NDArray[np.float64],
    scan: HeightMap,
    start: tuple[int, int],
    unit: float,
    ends: tuple[float, float],
) -> AxesImage:
    """Heights in colours, no more of them than a page can show."""
    dx, dy = (step / unit for step in scan.pixel)
    rows, columns = heights.shape
    left, bottom = (start[1] - 0.5) * dx, (start[0] - 0.5) * dy
    colours = matplotlib.colormaps[_COLOURS].with_extremes(bad=_MISSING)
    image = axes.imshow(
        _coarse(heights),
        extent=(left, left + columns * dx, bottom, bottom + rows * dy),
        origin="lower",
        cmap=colours,
        vmin=ends[0],
        vmax=ends[1],
        interpolation="nearest",
    )
    axes.set_aspect("equal")
    return image


def _coarse(heights: NDArray[np.float64]) -> NDArray[np.float32]:
    """Every so many points; the mean of each block would round the summits off."""
    step = max(1, math.ceil(max(heights.shape) / MOST_PIXELS))
    return heights[::step, ::step].astype(np.float32)


def _marked(axes: Axes, summits: Summits | None, unit: float) -> str:
    if summits is None:
        return "No summits"
    if summits.count <= MOST_MARKED:
        _mark(axes, summits.positions / unit, 14.0)
        return f"All {summits.count} summits" if summits.count > 1 else "One summit"
    highest = np.argsort(-summits.heights, kind="stable")[:MOST_MARKED]
    _mark(axes, summits.positions[highest] / unit, 10.0)
    return f"The {MOST_MARKED} highest of {summits.count} summits"


def _mark(axes: Axes, places: NDArray[np.float64], size: float) -> None:
    """Rings that show on dark and on light ground."""
    for colour, width in (("#000000", 1.7), (_MARK, 0.8)):
        axes.scatter(
            places[:, 0], places[:, 1], s=size, facecolors="none", edgecolors=colour,
            linewidths=width, clip_on=True,
        )  # fmt: skip


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


def _trace(found: Findings) -> Figure:
    scan = found.scan
    unit, letter = length_prefix(scan.size[0])
    heights = scan.heights - float(np.nanmean(scan.heights))
    h_unit, h_letter = prefix(float(np.nanmax(np.abs(heights))))
    figure = new_figure(3.0, found.title("Heights"))
    axes = figure.subplots()
    axes.plot(scan.pixel[0] / unit * np.arange(heights.size), heights / h_unit, linewidth=0.9)
    axes.set_xlabel(f"Position [{letter}m]")
    axes.set_ylabel(f"Height above the mean [{h_letter}m]")
    axes.margins(x=0.0)
    return figure
