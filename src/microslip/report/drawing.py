"""Common base of figures drawn by Matplotlib: style, page, axes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import matplotlib
import numpy as np
from matplotlib import font_manager
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import Formatter

from microslip.report.scales import log_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLE = Path(__file__).parents[1] / "style.mplstyle"
FONT = "DejaVu Sans"
DASHES = (0, (4, 2))


def new_figure(height: float) -> Figure:
    """Page of the usual width and this height [in], with an Agg canvas."""
    width = float(matplotlib.rcParams["figure.figsize"][0])
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def settle(figure: Figure) -> None:
    """Lay a figure out once and for all, rather than anew for every file made of it."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")
    # The layout's last digits depend on what was drawn before, and with them names in the SVG.
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, 6).tolist())


def missing_glyphs(text: str) -> str:
    """Characters of a text that the font of the figures does not have, each once."""
    if text.isascii():
        return ""
    font = font_manager.get_font(font_manager.findfont(FONT))
    return "".join(c for c in dict.fromkeys(text) if not font.get_char_index(ord(c)))


class _Powers(Formatter):
    """Labels of a log axis: 0.1, 1, 10 where these are short, else 10⁻⁶; never mixed.

    Plain text, since matplotlib's mathtext costs most of the time of a figure.
    """

    def __call__(self, x: float, pos: int | None = None) -> str:
        axis: Any = self.axis
        low, high = sorted(axis.get_view_interval())
        return log_label(x, float(low), float(high))


def log_scale(axes: Axes, direction: Literal["x", "y"]) -> None:
    """Make an axis of a panel logarithmic."""
    getattr(axes, f"set_{direction}scale")("log")
    side = axes.xaxis if direction == "x" else axes.yaxis
    side.set_major_formatter(_Powers())
    side.set_minor_formatter(_Powers())
