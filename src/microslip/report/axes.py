"""A figure on Matplotlib's axes: for a notebook, for a paper, or to edit in Python."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib import pyplot, style
from matplotlib.axes import Axes
from matplotlib.ticker import AutoLocator, LogLocator, NullFormatter, NullLocator, ScalarFormatter

from microslip._core.checks import show
from microslip.errors import InputError
from microslip.report import plot as shapes
from microslip.report.drawing import STYLE
from microslip.report.matplotlib_figure import figure, paint
from microslip.report.plot import COLORS, Axis, Item, Panel, Plot

if TYPE_CHECKING:
    from matplotlib.artist import Artist

# What was drawn on axes before: how many figures, and the units [SI] of its axes.
_drawn_before: WeakKeyDictionary[Axes, tuple[int, float, float]] = WeakKeyDictionary()


def draw(plot: Plot, ax: Any = None, *, color: str | None = None, label: str = "") -> Any:
    """Draw a figure: on a page of its own, or its panels on axes that are there.

    What is laid over an earlier figure takes its units and the next colour. ``color`` is of what
    would be black, ``label`` names the first line; see
    :class:`~microslip.report.plottable.Plottable`.
    """
    panels = plot.panels
    if ax is None:
        new_figure: Any = pyplot.figure()
        _recolour(panels, color or COLORS[0])
        all_axes = np.array(figure(plot, new_figure).axes[: len(panels)], dtype=object)
        for axes, panel in zip(all_axes, panels, strict=True):
            _drawn_before[axes] = (1, panel.x.unit, panel.y.unit)
            _release_ticks(axes)
    else:
        all_axes = np.atleast_1d(np.asarray(ax, dtype=object)).reshape(-1)
        if len(all_axes) != len(panels) or not all(isinstance(axes, Axes) for axes in all_axes):
            expected = "Matplotlib's axes" if len(panels) == 1 else f"{len(panels)} of them"
            raise InputError(f"`ax` must be {expected}, got {show(ax)}")
        with style.context(STYLE):
            for axes, panel in zip(all_axes, panels, strict=True):
                _draw_panel(axes, panel, color)
        _legend(plot, all_axes[0])
    if label:
        lines = [line for line in all_axes[0].lines if line.get_label().startswith("_child")]
        if lines:
            _newest(all_axes[0], panels[0]).set_label(label)
    return all_axes[0] if len(panels) == 1 else all_axes


def _newest(axes: Axes, panel: Panel) -> Artist:
    """The first line that a panel has added: the one that its name belongs to."""
    kinds = (shapes.Line, shapes.Marks, shapes.Rule)
    curves = [item for item in panel.items if isinstance(item, kinds)]
    lines = axes.lines[-len(curves) :]
    pairs = zip(lines, curves, strict=False)
    return next((line for line, item in pairs if not isinstance(item, shapes.Rule)), lines[0])


def _recolour(panels: list[Panel], color: str) -> None:
    """Give what would be black another colour."""
    for panel in panels:
        panel.items = [
            replace(item, color=color)
            if isinstance(item, (shapes.Line, shapes.Marks, shapes.Stems))
            and item.color == COLORS[0]
            else item
            for item in panel.items
        ]


def _draw_panel(axes: Axes, panel: Panel, color: str | None) -> None:
    """Draw one panel on axes that are there; what they say of themselves already stays."""
    count, x_unit, y_unit = _drawn_before.get(axes, (0, panel.x.unit, panel.y.unit))
    _recolour([panel], color or COLORS[count % len(COLORS)])
    ratio = panel.x.unit / x_unit, panel.y.unit / y_unit
    if not count:
        _prepare(axes, panel)
    for number, item in enumerate(panel.items):
        paint(_scaled(item, *ratio), axes, None, 1.5 + 0.01 * number)
    _drawn_before[axes] = (count + 1, x_unit, y_unit)


def _prepare(axes: Axes, panel: Panel) -> None:
    for axis, side in ((panel.x, "x"), (panel.y, "y")):
        if axis.log:
            getattr(axes, f"set_{side}scale")("log")
        if not getattr(axes, f"get_{side}label")():
            getattr(axes, f"set_{side}label")(axis.label.replace("$", r"\$"))
        _limits(axes, axis, side)
    axes.grid(panel.grid)
    if panel.equal:
        axes.set_aspect("equal")


def _limits(axes: Axes, axis: Axis, side: str) -> None:
    if axis.low is not None or axis.high is not None:
        getattr(axes, f"set_{side}lim")(axis.low, axis.high)
    if axis.ticks is not None:
        getattr(axes, f"set_{side}ticks")(
            [place for place, _ in axis.ticks], [text for _, text in axis.ticks]
        )


def _scaled(item: Item, x: float, y: float) -> Item:
    """An item in the units of the axes."""
    if x == y == 1.0:
        return item
    if isinstance(item, (shapes.Line, shapes.Marks, shapes.Area, shapes.Stems)):
        return replace(item, x=item.x * x, y=item.y * y)
    if isinstance(item, shapes.Words) and item.data:
        return replace(item, x=item.x * x, y=item.y * y)
    if isinstance(item, shapes.Rule):
        return replace(item, value=item.value * (y if item.axis == "y" else x))
    if isinstance(item, shapes.Band):
        ratio = y if item.axis == "y" else x
        return replace(item, low=item.low * ratio, high=item.high * ratio)
    if isinstance(item, shapes.Pixels):
        return replace(
            item, left=item.left * x, right=item.right * x, bottom=item.bottom * y, top=item.top * y
        )
    return item


def _legend(plot: Plot, axes: Axes) -> None:
    if len(plot.legend) < 2:
        return
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [], [], color=entry.color, marker=entry.marker or "none", label=entry.label,
            linestyle=((0, entry.dash) if entry.dash else "-") if entry.line else "none",
        )
        for entry in plot.legend
    ]  # fmt: skip
    axes.legend(handles=handles, title=plot.legend_title or None, fontsize=8)


def _release_ticks(axes: Axes) -> None:
    """Let the round numbers of the page follow as soon as somebody zooms."""

    def follow(changed: Axes) -> None:
        for side, log in (
            (changed.xaxis, changed.get_xscale() == "log"),
            (changed.yaxis, changed.get_yscale() == "log"),
        ):
            side.set_major_locator(LogLocator() if log else AutoLocator())
            if not log:
                side.set_major_formatter(ScalarFormatter())
                side.set_minor_locator(NullLocator())
            side.set_minor_formatter(NullFormatter())

    axes.callbacks.connect("xlim_changed", follow)
    axes.callbacks.connect("ylim_changed", follow)
