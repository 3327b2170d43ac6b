"""Figure of the chapter: drawing, files, data and assumptions."""

from __future__ import annotations

import re
import textwrap
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rcParams, style
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure
from numpy.typing import NDArray

from microslip.figures.matplotlib_figure import STYLE
from microslip.figures.plot import COLORS, DASHES

Columns = dict[str, NDArray[np.float64]]
"""Plotted numbers: columns of equal length by heading with unit."""
MICRO, MILLI, KILO, MEGA = 1e-6, 1e-3, 1e3, 1e6

GREY, LIGHT = "#555555", "#999999"
INK, BLUE, RED, GREEN, PINK, GOLD = COLORS
"""Okabe-Ito colours of the style, by name."""
STICK, STUCK, SLIP, BACK = "#dcebf5", "#f6f6f6", "#f6d9c6", "#d4d4d4"
"""Fills of zones that stick, stick again, slip, and slip in reverse."""
HATCH = "#b98a6d"
STROKE = (0, (4, 2))
DOTS = (0, (1, 1.5))
PENS: tuple[dict[str, Any], ...] = tuple(
    {"color": color, "linestyle": (0, dash) if dash else "-"}
    for color, dash in zip(COLORS[:5], DASHES, strict=False)
)
"""Line styles of a family of curves, distinguished by colour and dashes."""


# Text as outlines, because it has subscripts in mathtext.
_LOOK: list[Any] = ["default", STYLE, {"hatch.linewidth": 0.5, "svg.fonttype": "path"}]
"""Style in addition to Matplotlib's defaults, independent of the user's matplotlibrc."""


@dataclass(frozen=True)
class Plate:
    """Figure of the chapter as drawn by this library.

    Parameters
    ----------
    number : str
        Number in the chapter, such as "19.13".
    height : float
        Height of the figure [in].
    title : str
        Heading.
    caption : str
        Caption of one or two sentences.
    parameters : str
        Assumptions, because the axes of the chapter have no numbers.
    drawing : callable
        Function that draws the figure and returns its data, empty for a sketch. Its name is that
        of the files.
    """

    number: str
    height: float
    title: str
    caption: str
    parameters: str
    drawing: Callable[[SubFigure], Columns]

    @property
    def stem(self) -> str:
        """File name without suffix."""
        return f"{self.number}-{self.drawing.__name__[1:].replace('_', '-')}"

    @property
    def command(self) -> str:
        """Command that creates the figure."""
        return f"microslip figures --only {self.number}"

    def draw(self) -> tuple[Figure, Columns]:
        """Draw the figure with its title above and its assumptions below; return also its data."""
        with style.context(_LOOK):
            figure = Figure(figsize=(float(rcParams["figure.figsize"][0]), self.height))
            FigureCanvasAgg(figure)
            # Non-breaking spaces keep numbers with their names and units.
            text = re.sub(
                r" (=) |(?<=\d) (?=\S)", lambda m: "\xa0=\xa0" if m[1] else "\xa0", self.parameters
            )
            text = textwrap.fill(text, 108)
            foot = 0.06 + 0.14 * len(text.splitlines())
            parts = figure.subfigures(2, 1, height_ratios=[self.height - foot, foot])
            body, below = np.ravel(np.asarray(parts))
            body.suptitle(f"Fig. {self.number}: {self.title}", fontsize=10)
            below.text(
                0.5, 0.5, subscripts(text), fontsize=7.5, color=GREY, ha="center", va="center"
            )
            return figure, self.drawing(body)

    def write(self, folder: Path) -> list[str]:
        """Draw the figure and write it as SVG and PNG, and its data as CSV."""
        names = [f"{self.stem}.svg", f"{self.stem}.png"]
        with style.context(_LOOK), warnings.catch_warnings():
            warnings.filterwarnings("error", "constrained_layout not applied", UserWarning)
            figure, columns = self.draw()
            _fix_layout(figure)
            figure.savefig(folder / names[0], metadata={"Date": None, "Creator": None})
            figure.savefig(folder / names[1], metadata={"Software": None})
        if columns:
            names.append(f"{self.stem}.csv")
            rows = zip(*(map(repr, column.tolist()) for column in columns.values()), strict=True)
            lines = [",".join(columns), *map(",".join, rows)]
            (folder / names[2]).write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
        return names


def _fix_layout(figure: Figure) -> None:
    """Compute the layout of a figure once and round it, so that its SVG and PNG agree."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")
    # Matplotlib hashes the corners of each clip rectangle into its id. The last digits of the
    # layout vary from run to run, in the parts of the page as well as in the axes.
    for part in figure.subfigs:
        part.bbox_relative.set_points(np.round(part.bbox_relative.get_points(), 6))
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, 6).tolist())


def as_plate(
    number: str, height: float, title: str, caption: str, parameters: str
) -> Callable[[Callable[[SubFigure], Columns]], Plate]:
    """Decorate a drawing function to make it a figure of the chapter."""
    return partial(Plate, number, height, title, caption, parameters)


def subscripts(text: str) -> str:
    """Write the indices in δL (slip limit) and δn (separation) as subscripts for Matplotlib."""
    for letter in "Ln":
        text = text.replace(f"δ{letter}", rf"$\mathregular{{δ_{letter}}}$")
    return text


def mark(axes: Axes, text: str, x: float, y: float, dx: float, dy: float) -> None:
    """Draw a point at data coordinates x and y, and its letter at an offset dx, dy [pt] from it."""
    axes.plot([x], [y], "o", color=INK, markersize=4.5, zorder=5, clip_on=False)
    axes.annotate(
        text,
        (x, y),
        (dx, dy),
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=10,
        fontweight="bold",
        zorder=6,
    )


def cross(axes: Axes) -> None:
    """Draw the horizontal and the vertical line through the origin."""
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)


def words(axes: Axes, text: str, x: float, y: float, **look: Any) -> None:
    """Draw text on a white background at data coordinates x and y."""
    ground = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"}
    options: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 8.5, "bbox": ground}
    axes.text(x, y, text, **(options | look))


def arrow(
    axes: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    double: bool = False,
    linewidth: float = 1.1,
) -> None:
    """Draw an arrow from start to end, or with two heads to mark a dimension."""
    look = {
        "arrowstyle": "<|-|>" if double else "-|>",
        "color": INK,
        "linewidth": linewidth,
        "mutation_scale": 9.0,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
    }
    axes.annotate("", end, start, arrowprops=look, annotation_clip=False)
