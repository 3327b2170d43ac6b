"""A figure drawn by Matplotlib in the same layout, or on axes that are there already."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import singledispatch
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib import font_manager, rcParams, style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import (
    AutoLocator,
    FixedFormatter,
    FixedLocator,
    LogLocator,
    NullFormatter,
    NullLocator,
    ScalarFormatter,
)

from microslip._core.checks import show
from microslip.errors import InputError
from microslip.figures import plot as shapes
from microslip.figures.layout import PAGE, SMALL, TEXT, TITLE, Frame, Page, Scale, lay_out
from microslip.figures.plot import COLORS, Item, Panel, Plot

STYLE = Path(__file__).parents[1] / "style.mplstyle"
FONT = "DejaVu Sans"


def missing_glyphs(text: str) -> str:
    """Characters of a text that the font of the figures does not have, each once."""
    if text.isascii():
        return ""
    font = font_manager.get_font(font_manager.findfont(FONT))
    return "".join(c for c in dict.fromkeys(text) if not font.get_char_index(ord(c)))


_WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}
_MARK = {"linestyle": "none", "markeredgewidth": 0.8}


def png(plot: Plot) -> bytes:
    """Pixels of a figure, the same for the same plot, whatever the user's matplotlibrc says."""
    with _house_style():
        target = figure(plot)
        target.set_dpi(rcParams["savefig.dpi"])
        file = io.BytesIO()
        canvas: Any = target.canvas
        # Levels of compression beyond this take thrice the time for a few per cent.
        canvas.print_png(file, pil_kwargs={"compress_level": 3})
        return file.getvalue()


def pdf(plot: Plot) -> bytes:
    """A figure as a page of PDF, its text as text, without a date: the same for the same plot."""
    with _house_style():
        file = io.BytesIO()
        canvas: Any = FigureCanvasPdf(figure(plot))
        canvas.print_pdf(file, metadata={"CreationDate": None})
        return file.getvalue()


@contextmanager
def _house_style() -> Iterator[None]:
    with style.context(["default", STYLE]), warnings.catch_warnings():
        # The summary says it, once.
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        yield


def figure(plot: Plot, target: Figure | None = None) -> Figure:
    """A Matplotlib figure: the one given, made as large as the page, or one with an Agg canvas."""
    page = lay_out(plot)
    with style.context(["default", STYLE]):
        if target is None:
            target = Figure()
            FigureCanvasAgg(target)
        target.set_size_inches(page.width / 72.0, page.height / 72.0)
        target.set_layout_engine("none")
        for number, line in enumerate(page.title):
            y = 1.0 - (6.0 + TITLE * (0.9 + 1.25 * number)) / page.height
            target.text(0.5, y, _plain(line), size=TITLE, ha="center")
        for frame in page.frames:
            _panel(target, page, frame)
        _legend(target, page)
    return target


def _plain(text: str) -> str:
    """Text in which a dollar sign is a dollar sign."""
    return text.replace("$", r"\$")


def _panel(target: Figure, page: Page, frame: Frame) -> None:
    panel = frame.panel
    bottom = page.height - frame.top - frame.height
    axes: Axes = target.add_axes(
        (
            frame.left / page.width,
            bottom / page.height,
            frame.width / page.width,
            frame.height / page.height,
        )
    )
    if panel.x.log:
        axes.set_xscale("log")
    if panel.y.log:
        axes.set_yscale("log")
    axes.grid(panel.grid)
    for number, item in enumerate(panel.items):
        paint(item, axes, frame, 1.5 + 0.01 * number)
    axes.set_xlim(frame.x.low, frame.x.high)
    axes.set_ylim(frame.y.low, frame.y.high)
    for axis, scale in ((axes.xaxis, frame.x), (axes.yaxis, frame.y)):
        _set_ticks(axis, scale)
    axes.tick_params(which="both", labelbottom=not panel.x.bare)
    if not panel.x.bare:
        axes.set_xlabel(_plain(panel.x.label), size=TEXT)
    if panel.y.opposite:
        axes.yaxis.tick_right()
        axes.yaxis.set_label_position("right")
        axes.tick_params(which="both", labelright=not panel.y.bare)
    else:
        axes.tick_params(which="both", labelleft=not panel.y.bare)
    if not panel.y.bare:
        axes.set_ylabel(_plain(panel.y.label), size=TEXT, va="center", ha="center")
        place = (frame.label_left - frame.left) / frame.width
        axes.yaxis.set_label_coords(place, 0.5)
    shift = 0.0
    if frame.y.ticks.offset:
        shift = 0.0 if panel.y.opposite else 40.0
        edge, align = (1.0, "right") if panel.y.opposite else (0.0, "left")
        _above(axes, edge, frame.y.ticks.offset, align)
    if frame.x.ticks.offset and not panel.x.bare:
        axes.annotate(
            frame.x.ticks.offset, (1.0, 0.0), (0.0, -30.0),
            xycoords="axes fraction", textcoords="offset points", ha="right", size=SMALL,
        )  # fmt: skip
    if panel.note:
        _above(axes, shift / frame.width, panel.note, "left")
    if panel.title:
        axes.set_title(_plain(panel.title), size=TEXT, pad=5.0)
    if frame.second is not None and panel.second is not None:
        _second(axes, frame, *panel.second)


def _above(axes: Axes, x: float, text: str, align: str) -> None:
    axes.annotate(
        _plain(text), (x, 1.0), (0.0, 4.5),
        xycoords="axes fraction", textcoords="offset points", ha=align, size=SMALL,
    )  # fmt: skip


def _set_ticks(axis: Any, scale: Scale) -> None:
    major, minor = scale.ticks.major, scale.ticks.minor
    axis.set_major_locator(FixedLocator([value for value, _ in major]))
    axis.set_major_formatter(FixedFormatter([_plain(text) for _, text in major]))
    axis.set_minor_locator(FixedLocator([value for value, _ in minor]))
    axis.set_minor_formatter(FixedFormatter([_plain(text) for _, text in minor]))


def _second(axes: Axes, frame: Frame, label: str, factor: float) -> None:
    def there(y: Any) -> Any:
        return factor * y

    def back(y: Any) -> Any:
        return y / factor

    right: Any = axes.secondary_yaxis("right", functions=(there, back))
    if frame.y.log:
        right.set_yscale("log")
    if frame.second is not None:
        _set_ticks(right.yaxis, frame.second)
        if frame.second.ticks.offset:
            _above(axes, 1.0, frame.second.ticks.offset, "right")
    right.set_ylabel(_plain(label), size=TEXT)


# -- what is drawn -------------------------------------------------------------------------------


def _dash(dash: tuple[float, ...]) -> Any:
    return (0, dash) if dash else "-"


@singledispatch
def paint(item: Item, axes: Axes, frame: Frame | None, order: float) -> None:
    """Draw one item; names along lines need a frame."""
    raise TypeError(f"nothing draws a {type(item).__name__}")


@paint.register
def _(item: shapes.Line, axes: Axes, frame: Frame | None, order: float) -> None:
    look = {"color": item.color, "linewidth": item.width, "linestyle": _dash(item.dash)}
    axes.plot(item.x, item.y, zorder=order, **look)


@paint.register
def _(item: shapes.Marks, axes: Axes, frame: Frame | None, order: float) -> None:
    fill = item.color if item.filled else "white"
    look: dict[str, Any] = {**_MARK, "marker": item.marker, "markersize": item.size}
    axes.plot(item.x, item.y, color=item.color, markerfacecolor=fill, zorder=order, **look)


@paint.register
def _(item: shapes.Rule, axes: Axes, frame: Frame | None, order: float) -> None:
    look: dict[str, Any] = {"color": item.color, "linewidth": item.width}
    draw = axes.axhline if item.axis == "y" else axes.axvline
    draw(item.value, linestyle=_dash(item.dash), zorder=order, **look)


@paint.register
def _(item: shapes.Band, axes: Axes, frame: Frame | None, order: float) -> None:
    draw = axes.axhspan if item.axis == "y" else axes.axvspan
    draw(item.low, item.high, facecolor=item.color, edgecolor="none", zorder=order)


@paint.register
def _(item: shapes.Area, axes: Axes, frame: Frame | None, order: float) -> None:
    axes.fill(item.x, item.y, facecolor=item.color, edgecolor="none", zorder=order)


@paint.register
def _(item: shapes.Stems, axes: Axes, frame: Frame | None, order: float) -> None:
    axes.vlines(item.x, 0.0, item.y, color=item.color, linewidth=item.width, zorder=order)


@paint.register
def _(item: shapes.Words, axes: Axes, frame: Frame | None, order: float) -> None:
    axes.annotate(
        _plain(item.text),
        (item.x, item.y),
        xycoords="data" if item.data else "axes fraction",
        ha=item.align,
        va={"middle": "center"}.get(item.valign, item.valign),
        size=item.size,
        color=item.color,
        rotation=item.angle,
        rotation_mode="anchor",
        bbox=_WHITE,
        zorder=order + 1.0,
    )


@paint.register
def _(item: shapes.LineName, axes: Axes, frame: Frame | None, order: float) -> None:
    place = None if frame is None else frame.name_place(item)
    if frame is None or place is None:
        return
    x, y, angle = place
    axes.annotate(
        _plain(item.text),
        ((x - frame.left) / frame.width, 1.0 - (y - frame.top) / frame.height),
        xycoords="axes fraction",
        ha="right" if item.at_end else "left",
        va="baseline",
        size=SMALL,
        rotation=math.degrees(angle),
        rotation_mode="anchor",
        bbox=_WHITE,
        zorder=order + 1.0,
    )


@paint.register
def _(item: shapes.Pixels, axes: Axes, frame: Frame | None, order: float) -> None:
    if "log" in (axes.get_xscale(), axes.get_yscale()):
        # A picture would be stretched along the values, not along the axis.
        rows, columns = item.values.shape[:2]
        spread: dict[str, Any] = {"log": np.geomspace, "linear": np.linspace}
        x = spread[axes.get_xscale()](item.left, item.right, columns + 1)
        y = spread[axes.get_yscale()](item.top, item.bottom, rows + 1)
        values = item.values if item.values.ndim == 3 else item.values[..., None].repeat(3, 2)
        axes.pcolormesh(x, y, values / 255.0, zorder=order, rasterized=True)
        return
    axes.imshow(
        item.values,
        cmap="gray",
        vmin=0,
        vmax=255,
        extent=(item.left, item.right, item.bottom, item.top),
        aspect="auto",
        interpolation="nearest",
        zorder=order,
    )


def _legend(target: Figure, page: Page) -> None:
    if not page.legend:
        return
    if page.legend_title:
        y = 1.0 - (page.legend_top + 0.95 * SMALL) / page.height
        target.text(0.5, y, _plain(page.legend_title), ha="center", size=SMALL)
    for entry, left, middle in page.legend:
        y = 1.0 - middle / page.height
        ends = left / PAGE, (left + 18.7) / PAGE
        handle = Line2D(
            [ends[0], 0.5 * (ends[0] + ends[1]), ends[1]],
            [y, y, y],
            color=entry.color,
            linestyle=_dash(entry.dash) if entry.line else "none",
            linewidth=1.4,
            marker=entry.marker or "none",
            markersize=4.5,
            markeredgewidth=0.8,
            markerfacecolor=entry.color if entry.filled else "white",
            markevery=[1],
        )
        target.add_artist(handle)
        target.text((left + 25.0) / PAGE, y, _plain(entry.label), va="center_baseline", size=SMALL)


# -- on axes that are there ------------------------------------------------------------------------

# What was drawn on axes before: how many figures, and the units [SI] of its axes.
_drawn_before: WeakKeyDictionary[Axes, tuple[int, float, float]] = WeakKeyDictionary()


def draw(plot: Plot, ax: Any = None, *, color: str | None = None, label: str = "") -> Any:
    """Draw a figure: on a page of its own, or its panels on axes that are there.

    What is laid over an earlier figure takes its units and the next colour. ``color`` is of what
    would be black, ``label`` names the first line; see
    :class:`~microslip.figures.plot.Plottable`.
    """
    panels = plot.panels
    if ax is None:
        from matplotlib import pyplot

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
        _legend_on(plot, all_axes[0])
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
        if axis.low is not None or axis.high is not None:
            getattr(axes, f"set_{side}lim")(axis.low, axis.high)
        if axis.ticks is not None:
            places, texts = zip(*axis.ticks, strict=True) if axis.ticks else ((), ())
            getattr(axes, f"set_{side}ticks")(places, texts)
    axes.grid(panel.grid)
    if panel.equal:
        axes.set_aspect("equal")


def _scaled(item: Item, x: float, y: float) -> Item:
    """An item in the units of the axes."""
    if x == y == 1.0 or (isinstance(item, shapes.Words) and not item.data):
        return item
    across = y if getattr(item, "axis", "x") == "y" else x  # of what crosses the panel
    factors = dict.fromkeys(("x", "left", "right"), x) | dict.fromkeys(("y", "bottom", "top"), y)
    factors |= dict.fromkeys(("value", "low", "high"), across)
    there = [name for name in factors if hasattr(item, name)]
    scaled: dict[str, Any] = {name: getattr(item, name) * factors[name] for name in there}
    return replace(item, **scaled)


def _legend_on(plot: Plot, axes: Axes) -> None:
    if len(plot.legend) < 2:
        return
    handles = [
        Line2D(
            [], [], color=entry.color, marker=entry.marker or "none", label=entry.label,
            linestyle=_dash(entry.dash) if entry.line else "none",
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
