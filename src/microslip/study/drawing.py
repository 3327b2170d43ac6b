"""Floor 8: what the figures share: style, page, colours and legend."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import matplotlib
from matplotlib import font_manager
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microslip.study.result import some
from microslip.study.units import engineering

if TYPE_CHECKING:
    from microslip.study.result import Result

STYLE = Path(__file__).with_name("microslip.mplstyle")
MOST_LOADS = 6
FONT = "DejaVu Sans"
_MARKERS = ("o", "s", "^", "D", "v", "P")
_LINES = ("-", (0, (6, 2)), (0, (1, 1)), (0, (6, 2, 1, 2)), (0, (3, 1)), (0, (5, 1, 1, 1, 1, 1)))
_LONG_WORD = 50  # of the widest letter, W, so many fill the page

By = Literal["marker", "linestyle"]


def new_figure(height: float, title: str) -> Figure:
    """Page of the usual width and this height [in], with an Agg canvas."""
    width = float(matplotlib.rcParams["figure.figsize"][0])
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(_literal(_broken(title)), wrap=True)
    return figure


def missing_glyphs(text: str) -> str:
    """Characters of a text that the font of the figures does not have, each once."""
    if text.isascii():
        return ""
    font = font_manager.get_font(font_manager.findfont(FONT))
    return "".join(c for c in dict.fromkeys(text) if not font.get_char_index(ord(c)))


def _broken(text: str) -> str:
    """Text whose words each fit on the page; matplotlib only breaks lines between words."""
    return re.sub(rf"\S{{{_LONG_WORD}}}(?=\S)", r"\g<0>\n", text)


def _literal(text: str) -> str:
    """Text in which a dollar sign is a dollar sign."""
    return text.replace("$", r"\$")


def drawn_loads(result: Result, by: By) -> list[tuple[int, dict[str, Any]]]:
    """Loads that are drawn: their index, and colour and marker or line style of their curve."""
    cycle = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    shown = some(len(result.joints), MOST_LOADS)
    looks: tuple[Any, ...] = _MARKERS if by == "marker" else _LINES
    return [
        (index, {"color": cycle[i % len(cycle)], by: looks[i % len(looks)]})
        for i, index in enumerate(shown)
    ]


def add_legend(figure: Figure, result: Result, by: By) -> None:
    """Name the loads below the panels."""
    loads = drawn_loads(result, by)
    handles = [
        Line2D(
            [],
            [],
            **look,
            markerfacecolor="white",
            label=engineering(result.joints[i].normal_load, "N", trim=True),
        )
        for i, look in loads
    ]
    left_out = len(result.joints) - len(loads)
    title = "Normal load" + (f" ({left_out} more in the tables)" if left_out else "")
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=len(handles),
        title=title,
        title_fontsize=8.5,
    )
