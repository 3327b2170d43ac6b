"""A figure as data: panels, axes and what is drawn in them. Renderers make SVG or Matplotlib of it.

Lengths on paper are points (1/72 inch). Values are divided by the unit that the axis names before
they come here, so that what a figure shows can be read, and tested, without drawing it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats as Floats

Marker = Literal["o", "s", "^", "D", "v", "P"]
AxisName = Literal["x", "y"]

# The colours are those of Okabe and Ito (2008), dark to light as far as they go, for the
# colour-blind and for print in grey.
COLORS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
MARKERS: tuple[Marker, ...] = ("o", "s", "^", "D", "v", "P")
DASHED = (4.0, 2.0)
DOTTED = (1.0, 2.0)
DASHES: tuple[tuple[float, ...], ...] = (
    (),
    (6, 2),
    (1, 1),
    (6, 2, 1, 2),
    (3, 1),
    (5, 1, 1, 1, 1, 1),
)
"""Dashes and gaps, in line widths."""
WIDTH = 1.4
THIN = 0.9
GREY = "#666666"


@dataclass(frozen=True)
class Line:
    """A line through points; a value that is not finite parts it."""

    x: Floats
    y: Floats
    color: str = COLORS[0]
    width: float = WIDTH
    dash: tuple[float, ...] = ()


@dataclass(frozen=True)
class Marks:
    """A marker at each point, hollow unless filled."""

    x: Floats
    y: Floats
    color: str = COLORS[0]
    marker: Marker = "o"
    filled: bool = False
    size: float = 4.5


@dataclass(frozen=True)
class Rule:
    """A line across the whole panel at one value of an axis."""

    value: float
    axis: AxisName = "y"
    color: str = "#333333"
    width: float = THIN
    dash: tuple[float, ...] = DASHED


@dataclass(frozen=True)
class Band:
    """A stripe across the whole panel between two values of an axis."""

    low: float
    high: float
    axis: AxisName = "x"
    color: str = "#e8e8e8"


@dataclass(frozen=True)
class Area:
    """A filled area with a closed outline."""

    x: Floats
    y: Floats
    color: str = "#e8e8e8"


@dataclass(frozen=True)
class Stems:
    """Lines from zero up to each value."""

    x: Floats
    y: Floats
    color: str = COLORS[0]
    width: float = 1.0


@dataclass(frozen=True)
class Words:
    """Text at a point of the panel, on white; a fraction of it unless ``data``.

    ``align`` and ``valign`` say which edge of the text is at the point; ``angle`` turns it about
    there, in degrees.
    """

    x: float
    y: float
    text: str
    align: Literal["left", "center", "right"] = "left"
    valign: Literal["top", "middle", "bottom"] = "top"
    color: str = "#1a1a1a"
    size: float = 8.5
    angle: float = 0.0
    data: bool = False


@dataclass(frozen=True)
class LineName:
    """A name written along a line that is all but straight, near its begin or its end.

    Left out where the line is seen over less than 40 % of the panel's height.
    """

    x: Floats
    y: Floats
    text: str
    at_end: bool = False


@dataclass(frozen=True)
class Pixels:
    """A picture of red, green, blue (or one grey) bytes, first row at the top, over a rectangle."""

    values: NDArray[np.uint8]
    left: float
    right: float
    bottom: float
    top: float


Item = Line | Marks | Rule | Band | Area | Stems | Words | LineName | Pixels


@dataclass
class Axis:
    """An axis: its label, its ends (None: from what is drawn), and whether it is logarithmic."""

    label: str = ""  # with the unit in brackets; a line break is kept
    low: float | None = None  # its ends
    high: float | None = None
    log: bool = False  # whether it is logarithmic; what is not above zero is then not drawn
    margin: float = 0.05  # share of the range that stays free at an end that is not given
    ticks: Sequence[tuple[float, str]] | None = None  # places and labels, instead of round numbers
    integer: bool = False  # whether only whole numbers are labelled
    bare: bool = False  # no labels: another panel below or beside has the same axis
    opposite: bool = False  # labels at the top or at the right
    unit: float = 1.0  # what the values were divided by [SI]: figures laid over each other need it


@dataclass
class Panel:
    """One pair of axes with what is drawn in it; items are painted in their order."""

    x: Axis = field(default_factory=Axis)  # its axes
    y: Axis = field(default_factory=Axis)
    note: str = ""  # above it, at its left: what its lines are
    title: str = ""  # above it, in the middle
    second: tuple[str, float] | None = None
    """A second vertical axis at the right: its label, and what the values are multiplied by."""
    grid: bool = True  # whether lines are at the ticks
    equal: bool = False  # whether a unit is as long on both axes
    cell: tuple[int, int, int, int] = (0, 0, 0, 0)
    """First and last row, first and last column in the grid of the page."""
    items: list[Item] = field(default_factory=list)

    def line(self, x: ArrayLike, y: ArrayLike, color: str = COLORS[0], **look: Any) -> None:
        """Add a :class:`Line`; ``look`` is its width and dash."""
        self.items.append(Line(_floats(x), _floats(y), color, **look))

    def marks(self, x: ArrayLike, y: ArrayLike, color: str = COLORS[0], **look: Any) -> None:
        """Add :class:`Marks`; ``look`` is their marker, size and whether they are filled."""
        self.items.append(Marks(_floats(x), _floats(y), color, **look))

    def add(self, *items: Item) -> None:
        """Add anything."""
        self.items.extend(items)

    def cross(self) -> None:
        """Add thin lines through zero, below all else."""
        self.items[:0] = [Rule(0.0, direction, "#888888", 0.6, ()) for direction in ("y", "x")]


@dataclass(frozen=True)
class Entry:
    """A line of the legend: a name and how its curve looks."""

    label: str
    color: str = COLORS[0]
    dash: tuple[float, ...] = ()
    marker: Marker | None = None
    filled: bool = False
    line: bool = True


@dataclass
class Plot:
    """A page of panels with a legend below."""

    panels: list[Panel]  # in the cells of a grid
    height: float = 5.6  # of the page [in]; it is 7.1 in wide
    title: str = ""  # above all
    heights: tuple[float, ...] = (1.0,)
    """Relative sizes of the rows and columns of the grid."""
    widths: tuple[float, ...] = (1.0,)
    legend: tuple[Entry, ...] = ()  # below all, in as many lines as they need
    legend_title: str = ""  # above the legend


def stacked(
    panels: Sequence[Panel],
    height: float,
    heights: Sequence[float] = (),
    legend: Sequence[Entry] = (),
    title: str = "",
) -> Plot:
    """Panels below each other that share their horizontal axis, which the last one labels.

    They are as high as each other unless heights say otherwise.
    """
    for row, panel in enumerate(panels):
        panel.cell = (row, row, 0, 0)
        panel.x.bare = row < len(panels) - 1
    heights = tuple(heights) or (1.0,) * len(panels)
    return Plot(list(panels), height, title, heights, legend=tuple(legend))


def beside(
    panels: Sequence[Panel],
    height: float,
    title: str = "",
    legend: Sequence[Entry] = (),
    widths: Sequence[float] = (),
) -> Plot:
    """Panels in a row, as wide as each other unless widths say otherwise."""
    for place, panel in enumerate(panels):
        panel.cell = (0, 0, place, place)
    widths = tuple(widths) or (1.0,) * len(panels)
    return Plot(list(panels), height, title, widths=widths, legend=tuple(legend))


def _floats(values: ArrayLike) -> Floats:
    return np.atleast_1d(np.asarray(values, dtype=np.float64))
