"""Floor 8: what the figures share: style, page, colours and legend."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microslip.study.result import some
from microslip.study.units import engineering

if TYPE_CHECKING:
    from microslip.study.result import Result

STYLE = Path(__file__).with_name("microslip.mplstyle")
MOST_LOADS = 6
_MARKERS = ("o", "s", "^", "D", "v", "P")


def new_figure(height: float, title: str) -> Figure:
    """Page of the usual width and this height [in], with an Agg canvas."""
    width = float(matplotlib.rcParams["figure.figsize"][0])
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(_literal(title), wrap=True)
    return figure


def _literal(text: str) -> str:
    """Text in which a dollar sign is a dollar sign."""
    return text.replace("$", r"\$")


def drawn_loads(result: Result) -> list[tuple[int, dict[str, Any]]]:
    """Loads that are drawn: their index, and colour and marker of their curve."""
    cycle = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    shown = some(len(result.joints), MOST_LOADS)
    return [
        (index, {"color": cycle[i % len(cycle)], "marker": _MARKERS[i % len(_MARKERS)]})
        for i, index in enumerate(shown)
    ]


def add_legend(figure: Figure, result: Result) -> None:
    """Name the loads below the panels."""
    loads = drawn_loads(result)
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
