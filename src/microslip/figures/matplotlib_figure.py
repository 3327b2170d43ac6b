"""Figures drawn by Matplotlib: as PNG or PDF, on new axes or on those of the user."""

from __future__ import annotations

import io
import math
import warnings
from dataclasses import replace
from functools import partial
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
from microslip.figures.kit import log_label
from microslip.figures.layout import PAGE, SMALL, TITLE, PanelFrame, entry_width, lay_out, wrapped
from microslip.figures.plot import COLORS, Item, Panel, Plot

STYLE = Path(__file__).parents[1] / "style.mplstyle"
_HOUSE: list[Any] = ["default", STYLE]
_WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}
# Number of panels drawn on each Axes, and the units [SI] of its axes.
_drawn_before: WeakKeyDictionary[Axes, tuple[int, float, float]] = WeakKeyDictionary()


def png(plot: Plot) -> bytes:
    """Render a figure as PNG; the bytes do not depend on the matplotlibrc of the user."""
    # Higher compression takes three times as long and saves a few per cent.
    return _saved(plot, "png", pil_kwargs={"compress_level": 3})


def pdf(plot: Plot) -> bytes:
    """Render a figure as one page of PDF, with selectable text and without a date."""
    return _saved(plot, "pdf", metadata={"CreationDate": None})


def _saved(plot: Plot, kind: str, **how: Any) -> bytes:
    file = io.BytesIO()
    with style.context(_HOUSE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        to_matplotlib(plot).savefig(file, format=kind, **how)
    return file.getvalue()


def to_matplotlib(
    plot: Plot, target: Figure | None = None, color: str | None = None, label: str = ""
) -> Figure:
    """Draw all panels on a Matplotlib figure, by default a new one; see :func:`draw`."""
    with style.context(_HOUSE):
        target = Figure() if target is None else target
        target.set_size_inches(PAGE / 72.0, plot.height)
        target.set_layout_engine("constrained")
        ratios = {"height_ratios": plot.heights, "width_ratios": plot.widths}
        grid = target.add_gridspec(len(plot.heights), len(plot.widths), **ratios)
        for frame in lay_out(plot).frames:
            top, bottom, left, right = frame.panel.cell
            axes = target.add_subplot(grid[top : bottom + 1, left : right + 1])
            _draw_panel(axes, frame.panel, color, label, frame)
            axes.set(xlim=(frame.x.low, frame.x.high), ylim=(frame.y.low, frame.y.high))
            label = ""
        target.align_ylabels()
        if plot.title:
            target.suptitle(_plain("\n".join(wrapped(plot.title, TITLE, PAGE - 30.0))))
        if plot.legend:
            columns = min(len(plot.legend), int(PAGE / max(map(entry_width, plot.legend))) or 1)
            _legend(target, plot, loc="outside lower center", ncols=columns)
    return target


def draw(plot: Plot, ax: Any = None, *, color: str | None = None, label: str = "") -> Any:
    """Draw a figure on a new page, or its panels on the axes of the user.

    On axes that already have a figure, the units of that figure and the next colour are used.
    ``color`` replaces black, ``label`` names the first line; see
    :class:`~microslip.figures.plottable.Plottable`.
    """
    panels = plot.panels
    if ax is None:
        from matplotlib import pyplot

        new_figure: Any = pyplot.figure()
        all_axes = np.array(to_matplotlib(plot, new_figure, color, label).axes, dtype=object)
    else:
        all_axes = np.atleast_1d(np.asarray(ax, dtype=object)).reshape(-1)
        if len(all_axes) != len(panels) or not all(isinstance(axes, Axes) for axes in all_axes):
            expected = "Matplotlib axes" if len(panels) == 1 else f"{len(panels)} Matplotlib axes"
            raise InputError(f"`ax` must be {expected}, got {show(ax)}")
        with style.context(STYLE):
            for axes, panel in zip(all_axes, panels, strict=True):
                _draw_panel(axes, panel, color, label if panel is panels[0] else "")
            if len(plot.legend) > 1:
                _legend(all_axes[0], plot)
    return all_axes[0] if len(panels) == 1 else all_axes


def _draw_panel(
    axes: Axes, panel: Panel, color: str | None, label: str, frame: PanelFrame | None = None
) -> None:
    count, x_unit, y_unit = _drawn_before.get(axes, (0, panel.x.unit, panel.y.unit))
    black = color or COLORS[count % len(COLORS)]
    if not count:
        _prepare(axes, panel, frame is not None)
    for number, item in enumerate(panel.items):
        here = _scaled(item, panel.x.unit / x_unit, panel.y.unit / y_unit)
        if isinstance(here, (shapes.Line, shapes.Marks, shapes.Stems)) and here.color == COLORS[0]:
            here = replace(here, color=black)
        paint(here, axes, frame, 1.5 + 0.01 * number)
        if label and isinstance(here, (shapes.Line, shapes.Marks)):
            axes.lines[-1].set_label(label)
            label = ""
    _drawn_before[axes] = (count + 1, x_unit, y_unit)


def _prepare(axes: Axes, panel: Panel, own_page: bool) -> None:
    """Set scales, limits, labels and ticks of axes; keep titles and labels of the user."""
    for side, axis, mine in (("x", panel.x, axes.xaxis), ("y", panel.y, axes.yaxis)):
        if axis.log:
            axes.set(**{f"{side}scale": "log"})
        if axis.low is not None or axis.high is not None:
            axes.set(**{f"{side}lim": (axis.low, axis.high)})
        if axis.ticks is not None:
            mine.set_ticks([x for x, _ in axis.ticks], labels=[_plain(s) for _, s in axis.ticks])
        elif axis.log:
            label = partial(_log_label, mine)
            mine.set_major_formatter(label)
            mine.set_minor_formatter(label)
        elif axis.integer:
            mine.set_major_locator(MaxNLocator("auto", integer=True))
        if not axis.bare and not mine.get_label_text():
            mine.set_label_text(_plain(axis.label))
    left = not panel.y.opposite
    if not left:
        axes.yaxis.tick_right()
        axes.yaxis.set_label_position("right")
    axes.tick_params(
        which="both", labelbottom=not panel.x.bare,
        labelleft=left and not panel.y.bare, labelright=not (left or panel.y.bare),
    )  # fmt: skip
    axes.grid(panel.grid)
    if panel.equal:
        axes.set_aspect("equal")
    if not own_page:
        return
    axes.set_title(_plain(panel.title))
    axes.set_title(_plain(panel.note), loc="left", size=SMALL)
    if panel.second is not None:
        name, factor = panel.second

        def scaled(y: Any) -> Any:
            return factor * y

        def unscaled(y: Any) -> Any:
            return y / factor

        right = axes.secondary_yaxis("right", functions=(scaled, unscaled))
        right.set_ylabel(_plain(name))
        if panel.y.log:
            right.yaxis.set_major_formatter(partial(_log_label, right.yaxis))


def _log_label(axis: Any, place: float, _: int = 0) -> str:
    return log_label(place, *sorted(axis.get_view_interval()))


def _scaled(item: Item, x: float, y: float) -> Item:
    if x == y == 1.0 or (isinstance(item, shapes.Words) and not item.data):
        return item
    across = y if getattr(item, "axis", "x") == "y" else x  # for rules and bands
    factors = dict.fromkeys(("x", "left", "right"), x) | dict.fromkeys(("y", "bottom", "top"), y)
    factors |= dict.fromkeys(("value", "low", "high"), across)
    there = [name for name in factors if hasattr(item, name)]
    scaled: dict[str, Any] = {name: getattr(item, name) * factors[name] for name in there}
    return replace(item, **scaled)


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
    return (0, dash) if dash else "-"


def paint(item: Item, axes: Axes, frame: PanelFrame | None, order: float) -> None:
    """Draw an item of a panel at a z-order; only with a frame are names along lines drawn."""
    look: dict[str, Any] = {"color": getattr(item, "color", None), "zorder": order}
    stroke: dict[str, Any] = {"lw": getattr(item, "width", None)}
    stroke["ls"] = _dash(getattr(item, "dash", ()))
    match item:
        case shapes.Line():
            axes.plot(item.x, item.y, **look, **stroke)
        case shapes.Marks():
            face = item.color if item.filled else "white"
            axes.plot(item.x, item.y, item.marker, ms=item.size, mfc=face, **look)
        case shapes.Guide():
            (axes.axhline if item.axis == "y" else axes.axvline)(item.value, **look, **stroke)
        case shapes.Band():
            span = axes.axhspan if item.axis == "y" else axes.axvspan
            span(item.low, item.high, lw=0.0, **look)
        case shapes.Area():
            axes.fill(item.x, item.y, lw=0.0, **look)
        case shapes.Stems():
            axes.vlines(item.x, 0.0, item.y, lw=item.width, **look)
        case shapes.Words():
            axes.annotate(
                _plain(item.text), (item.x, item.y),
                xycoords="data" if item.data else "axes fraction", ha=item.align,
                va=item.valign.replace("middle", "center"), size=item.size, bbox=_WHITE,
                rotation=item.angle, rotation_mode="anchor", zorder=order + 1.0, color=item.color,
            )  # fmt: skip
        case shapes.Pixels():
            values = item.values if item.values.ndim == 3 else item.values[..., None].repeat(3, 2)
            ends = (item.left, item.right, item.bottom, item.top)
            if "log" not in (axes.get_xscale(), axes.get_yscale()):
                how: dict[str, Any] = {"aspect": axes.get_aspect(), "interpolation": "nearest"}
                axes.imshow(values, extent=ends, zorder=order, **how)
                return
            # On logarithmic axes an image would be stretched along the values.
            spread: dict[str, Any] = {"log": np.geomspace, "linear": np.linspace}
            rows, columns = values.shape[:2]
            x = spread[axes.get_xscale()](item.left, item.right, columns + 1)
            y = spread[axes.get_yscale()](item.top, item.bottom, rows + 1)
            axes.pcolormesh(x, y, values / 255.0, zorder=order, rasterized=True)
        case shapes.LineName() if frame is not None and (place := frame.name_place(item)):
            across, down = (place[0] - frame.left) / frame.width, place[1] - frame.top
            axes.annotate(
                _plain(item.text), (across, 1.0 - down / frame.height), xycoords="axes fraction",
                ha="right" if item.at_end else "left", size=SMALL, bbox=_WHITE,
                rotation=math.degrees(place[2]), rotation_mode="anchor", zorder=order + 1.0,
            )  # fmt: skip
