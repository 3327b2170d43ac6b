"""Figures drawn by Matplotlib: as PNG or PDF, on new axes or on those of the user."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip.figures import plot as shapes
from microslip.figures.plot import COLORS, Panel, Plot

STYLE = Path(__file__).parents[1] / "style.mplstyle"
_WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}
# Number of panels drawn on each Axes, and the units [SI] of its axes.
_drawn_before: WeakKeyDictionary[Axes, tuple[int, float, float]] = WeakKeyDictionary()


def rendered(plot: Plot, kind: str) -> bytes:
    """Render a figure as "png" or "pdf"; the bytes do not depend on the user's matplotlibrc."""
    file, undated = io.BytesIO(), {"CreationDate": None} if kind == "pdf" else None
    with style.context(["default", STYLE]), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        to_matplotlib(plot, Figure()).savefig(file, format=kind, metadata=undated)
    return file.getvalue()


def to_matplotlib(plot: Plot, page: Figure, color: str | None = None, label: str = "") -> Figure:
    """Draw all panels, title and legend on an empty page; see :func:`draw`."""
    page.set_figheight(plot.height)
    ratios = {"height_ratios": plot.heights, "width_ratios": plot.widths}
    grid = page.add_gridspec(len(plot.heights), len(plot.widths), **ratios)
    for panel in plot.panels:
        top, bottom, left, right = panel.cell
        axes = page.add_subplot(grid[top : bottom + 1, left : right + 1])
        _draw_panel(axes, panel, color, label)
        axes.set_title(_plain(panel.note), loc="left", size="small")
    page.align_ylabels()
    if plot.title:
        page.suptitle(_plain(plot.title), wrap=True)
    if plot.legend:
        columns = 100 // (10 + max(len(entry.label) for entry in plot.legend))  # 100 letters
        _legend(page, plot, loc="outside lower center", ncols=max(columns, 1))
    return page


def draw(plot: Plot, ax: Any = None, *, color: str | None = None, label: str = "") -> Any:
    """Draw a figure on a new page, or its panels on the axes of the user.

    On axes that already have a figure, the units of that figure and the next colour are used.
    ``color`` replaces black, ``label`` names the first line of each panel; see
    :class:`~microslip.figures.plottable.Plottable`.
    """
    panels = plot.panels
    if ax is None:
        from matplotlib import pyplot

        with style.context(["default", STYLE]):
            drawn: Any = to_matplotlib(plot, pyplot.figure(), color, label).axes
    else:
        drawn = [*np.atleast_1d(np.asarray(ax, dtype=object)).flat]
        if len(drawn) != len(panels) or not all(isinstance(axes, Axes) for axes in drawn):
            expected = "Matplotlib axes" if len(panels) == 1 else f"{len(panels)} Matplotlib axes"
            raise InputError(f"`ax` must be {expected}, got {show(ax)}")
        with style.context(STYLE):
            for axes, panel in zip(drawn, panels, strict=True):
                _draw_panel(axes, panel, color, label)
            if len(plot.legend) > 1:
                _legend(drawn[0], plot)
    return drawn[0] if len(panels) == 1 else np.array(drawn, dtype=object)


def _draw_panel(axes: Axes, panel: Panel, color: str | None, label: str) -> None:
    count, x_unit, y_unit = _drawn_before.get(axes, (0, panel.x.unit, panel.y.unit))
    _drawn_before[axes] = (count + 1, x_unit, y_unit)
    hues = {COLORS[0]: color or COLORS[count % len(COLORS)]}
    x, y = panel.x.unit / x_unit, panel.y.unit / y_unit
    curves: list[Line2D] = []
    for item in panel.items:
        match item:
            case shapes.Line():
                look: Any = {"color": hues.get(item.color, item.color), "lw": item.width}
                curves += axes.plot(x * item.x, y * item.y, ls=(0, item.dash or None), **look)
            case shapes.Marks():
                look = {"color": hues.get(item.color, item.color), "mfc": "white"}
                curves += axes.plot(x * item.x, y * item.y, item.marker, ms=item.size, **look)
            case shapes.Guide():
                line, unit = (axes.axhline, y) if item.axis == "y" else (axes.axvline, x)
                line(unit * item.value, color=item.color, lw=item.width, ls=(0, item.dash or None))
            case shapes.Band():
                span, unit = (axes.axhspan, y) if item.axis == "y" else (axes.axvspan, x)
                span(unit * item.low, unit * item.high, color=item.color, lw=0.0)
            case shapes.Area():
                axes.fill(x * item.x, y * item.y, color=item.color, lw=0.0)
            case shapes.Words():
                system, place = "axes fraction", (item.x, item.y)
                if item.data:
                    system, place = "data", (x * item.x, y * item.y)
                look = {"color": item.color, "size": 8.5, "bbox": _WHITE}
                axes.annotate(item.text, place, xycoords=system, va="top", **look)
            case shapes.Pixels():
                ends = (x * item.left, x * item.right, y * item.bottom, y * item.top)
                axes.imshow(item.values, extent=ends, aspect=axes.get_aspect())
    if label and curves:
        curves[0].set_label(label)
    if not count:
        _finish(axes, panel)


def _finish(axes: Axes, panel: Panel) -> None:
    """Set scales, ends and labels; an end that is not given follows from what has been drawn."""
    axes.margins(panel.x.margin, panel.y.margin)
    side: shapes.AxisName
    for side, axis, mine in (("x", panel.x, axes.xaxis), ("y", panel.y, axes.yaxis)):
        axes.set(**{f"{side}scale": "log" if axis.log else "linear"})
        if axis.low is not None or axis.high is not None:
            axes.set(**{f"{side}lim": (axis.low, axis.high)})
        if axis.ticks is not None:
            mine.set_ticks([x for x, _ in axis.ticks], labels=[text for _, text in axis.ticks])
        elif axis.integer:
            axes.locator_params(axis=side, integer=True)
        if axis.bare:
            mine.set_tick_params(which="both", labelbottom=False, labelleft=False)
        elif not mine.get_label_text():
            mine.set_label_text(axis.label)
    axes.grid(panel.grid)
    if panel.equal:
        axes.set_aspect("equal")


def _legend(owner: Figure | Axes, plot: Plot, **place: Any) -> None:
    handles = []
    for entry in plot.legend:
        line: Any = (0, entry.dash or None) if entry.line else "none"
        look: dict[str, Any] = {"marker": entry.marker or "none", "label": _plain(entry.label)}
        handles.append(Line2D([], [], color=entry.color, mfc="white", ls=line, **look))
    owner.legend(handles=handles, title=plot.legend_title or None, **place)


def _plain(text: str) -> str:
    return text.replace("$", r"\$")  # a dollar sign would start a formula
