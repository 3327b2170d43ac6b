"""Figures drawn by Matplotlib: as PNG or PDF, on new axes or on those of the user."""

from __future__ import annotations

import io
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip.figures import plot as shapes
from microslip.figures.plot import COLORS, Item, Panel, Plot

STYLE = Path(__file__).parents[1] / "style.mplstyle"
_LINE = 100  # letters in a line of a legend
_WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}
# Number of panels drawn on each Axes, and the units [SI] of its axes.
_drawn_before: WeakKeyDictionary[Axes, tuple[int, float, float]] = WeakKeyDictionary()


def rendered(plot: Plot, kind: str) -> bytes:
    """Render a figure as "png" or "pdf"; the bytes do not depend on the user's matplotlibrc."""
    file = io.BytesIO()
    with style.context(["default", STYLE]), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        dated: Any = {"metadata": {"CreationDate": None}} if kind == "pdf" else {}
        to_matplotlib(plot, Figure()).savefig(file, format=kind, **dated)
    return file.getvalue()


def to_matplotlib(plot: Plot, page: Figure, color: str | None = None, label: str = "") -> Figure:
    """Draw all panels, title and legend on an empty page; see :func:`draw`."""
    page.set_size_inches(page.get_figwidth(), plot.height)
    ratios = {"height_ratios": plot.heights, "width_ratios": plot.widths}
    grid = page.add_gridspec(len(plot.heights), len(plot.widths), **ratios)
    for panel in plot.panels:
        top, bottom, left, right = panel.cell
        axes = page.add_subplot(grid[top : bottom + 1, left : right + 1])
        _draw_panel(axes, panel, color, label if panel is plot.panels[0] else "")
        axes.set_title(_plain(panel.title))
        axes.set_title(_plain(panel.note), loc="left", size="small")
    page.align_ylabels()
    if plot.title:
        page.suptitle(_plain(plot.title), wrap=True)
    if plot.legend:
        columns = _LINE // (10 + max(len(entry.label) for entry in plot.legend))
        _legend(page, plot, loc="outside lower center", ncols=max(columns, 1))
    return page


def draw(plot: Plot, ax: Any = None, *, color: str | None = None, label: str = "") -> Any:
    """Draw a figure on a new page, or its panels on the axes of the user.

    On axes that already have a figure, the units of that figure and the next colour are used.
    ``color`` replaces black, ``label`` names the first line; see
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
                _draw_panel(axes, panel, color, label if panel is panels[0] else "")
            if len(plot.legend) > 1:
                _legend(drawn[0], plot)
    return drawn[0] if len(panels) == 1 else np.array(drawn, dtype=object)


def _draw_panel(axes: Axes, panel: Panel, color: str | None, label: str) -> None:
    count, x_unit, y_unit = _drawn_before.get(axes, (0, panel.x.unit, panel.y.unit))
    _drawn_before[axes] = (count + 1, x_unit, y_unit)
    if not count:
        _prepare(axes, panel)
    for number, item in enumerate(panel.items):
        is_curve = isinstance(item, (shapes.Line, shapes.Marks))
        if isinstance(item, (shapes.Line, shapes.Marks)) and item.color == COLORS[0]:
            item = replace(item, color=color or COLORS[count % len(COLORS)])
        paint(item, axes, panel.x.unit / x_unit, panel.y.unit / y_unit, 1.5 + 0.01 * number)
        if label and is_curve:
            axes.lines[-1].set_label(label)
            label = ""


def _prepare(axes: Axes, panel: Panel) -> None:
    axes.margins(panel.x.margin, panel.y.margin)
    for side, axis, mine in (("x", panel.x, axes.xaxis), ("y", panel.y, axes.yaxis)):
        if axis.log:
            axes.set(**{f"{side}scale": "log"})
        if axis.low is not None or axis.high is not None:
            axes.set(**{f"{side}lim": (axis.low, axis.high)})
        if axis.ticks is not None:
            mine.set_ticks([x for x, _ in axis.ticks], labels=[_plain(s) for _, s in axis.ticks])
        elif axis.integer:
            mine.set_major_locator(MaxNLocator("auto", integer=True))
        if axis.bare:
            mine.set_tick_params(which="both", labelbottom=False, labelleft=False)
        elif not mine.get_label_text():
            mine.set_label_text(_plain(axis.label))
    axes.grid(panel.grid)
    if panel.equal:
        axes.set_aspect("equal")


def _legend(owner: Figure | Axes, plot: Plot, **place: Any) -> None:
    handles = [
        Line2D(
            [], [], color=entry.color, linestyle=_dash(entry.dash) if entry.line else "none",
            marker=entry.marker or "none", label=_plain(entry.label),
            markerfacecolor=entry.color if entry.filled else "white",
        )
        for entry in plot.legend
    ]  # fmt: skip
    owner.legend(handles=handles, title=_plain(plot.legend_title) or None, **place)


def _plain(text: str) -> str:
    return text.replace("$", r"\$")  # a dollar sign would start a formula


def _dash(dash: tuple[float, ...]) -> Any:
    return (0, dash or None)  # None is solid


def paint(item: Item, axes: Axes, x: float, y: float, order: float) -> None:
    """Draw an item of a panel, its coordinates multiplied by ``x`` and ``y``, at a z-order."""
    look: dict[str, Any] = {"color": getattr(item, "color", None), "zorder": order}
    stroke = {"lw": getattr(item, "width", None), "ls": _dash(getattr(item, "dash", ()))}
    points = np.multiply(x, getattr(item, "x", 0.0)), np.multiply(y, getattr(item, "y", 0.0))
    across, side = (y, "h") if getattr(item, "axis", "x") == "y" else (x, "v")
    match item:
        case shapes.Line():
            axes.plot(*points, **look, **stroke)
        case shapes.Marks():
            face = item.color if item.filled else "white"
            axes.plot(*points, item.marker, ms=item.size, mfc=face, **look)
        case shapes.Guide():
            getattr(axes, f"ax{side}line")(across * item.value, **look, **stroke)
        case shapes.Band():
            span = getattr(axes, f"ax{side}span")
            span(across * item.low, across * item.high, lw=0.0, **look)
        case shapes.Area():
            axes.fill(*points, lw=0.0, **look)
        case shapes.Words():
            system, place = ("data", points) if item.data else ("axes fraction", (item.x, item.y))
            axes.annotate(
                _plain(item.text), place, xycoords=system, ha=item.align,
                va=item.valign.replace("middle", "center"), size=item.size, bbox=_WHITE,
                rotation=item.angle, rotation_mode="anchor", zorder=order + 1.0, color=item.color,
            )  # fmt: skip
        case shapes.Pixels():
            ends = (x * item.left, x * item.right, y * item.bottom, y * item.top)
            values = item.values if item.values.ndim == 3 else item.values[..., None].repeat(3, 2)
            axes.imshow(values, extent=ends, zorder=order, aspect=axes.get_aspect(),
                        interpolation="nearest")  # fmt: skip
