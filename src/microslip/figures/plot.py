"""Figures as data: panels, axes and their items, rendered as SVG or by Matplotlib.

Sizes on paper are in points (1/72 inch). Values are divided by the unit of their axis before they
are stored, so that a figure can be inspected and tested without rendering.
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

# Colours of Okabe and Ito (2008), ordered from dark to light, for colour-blind readers and
# greyscale print.
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
"""Lengths of dashes and gaps, in line widths."""
WIDTH = 1.4
THIN = 0.9
GREY = "#666666"


@dataclass(frozen=True)
class Line:
    """Line through points, interrupted at values that are not finite."""

    x: Floats
    y: Floats
    color: str = COLORS[0]
    width: float = WIDTH
    dash: tuple[float, ...] = ()


@dataclass(frozen=True)
class Marks:
    """Hollow marker at each point."""

    x: Floats
    y: Floats
    color: str = COLORS[0]
    marker: Marker = "o"
    size: float = 4.5


@dataclass(frozen=True)
class Guide:
    """Straight line across the whole panel at a value on one axis."""

    value: float
    axis: AxisName = "y"
    color: str = "#333333"
    width: float = THIN
    dash: tuple[float, ...] = DASHED


@dataclass(frozen=True)
class Band:
    """Stripe across the whole panel between two values on one axis."""

    low: float
    high: float
    axis: AxisName = "x"
    color: str = "#e8e8e8"


@dataclass(frozen=True)
class Area:
    """Filled area enclosed by a line through points."""

    x: Floats
    y: Floats
    color: str = "#e8e8e8"


@dataclass(frozen=True)
class Words:
    """Text on a white background, with its upper left corner at a point of the panel.

    The point is in fractions of the size of the panel or, if ``data`` is true, in values of the
    axes.
    """

    x: float
    y: float
    text: str
    color: str = "#1a1a1a"
    data: bool = False


@dataclass(frozen=True)
class Pixels:
    """Image of RGB bytes over a rectangle of values, first row at the top."""

    values: NDArray[np.uint8]
    left: float
    right: float
    bottom: float
    top: float


Item = Line | Marks | Guide | Band | Area | Words | Pixels


@dataclass
class Axis:
    """Axis: label, lower and upper end (None: from the data) and scale."""

    label: str = ""  # with the unit in brackets; line breaks are kept
    low: float | None = None
    high: float | None = None
    log: bool = False  # logarithmic; values that are not positive are not drawn
    margin: float = 0.05  # fraction of the range left free at ends that are not given
    ticks: Sequence[tuple[float, str]] | None = None  # values and labels, instead of round numbers
    integer: bool = False  # only whole numbers are labelled
    bare: bool = False  # no labels: a neighbouring panel has the same axis
    unit: float = 1.0  # divisor of the values [SI], needed to overlay figures


@dataclass
class Panel:
    """Two axes and the items between them, painted in their order."""

    x: Axis = field(default_factory=Axis)
    y: Axis = field(default_factory=Axis)
    note: str = ""  # above the panel at the left
    grid: bool = True  # grid lines at the ticks
    equal: bool = False  # same length per unit on both axes
    cell: tuple[int, int, int, int] = (0, 0, 0, 0)
    """First and last row, first and last column in the grid of the page."""
    items: list[Item] = field(default_factory=list)

    def line(self, x: ArrayLike, y: ArrayLike, color: str = COLORS[0], **look: Any) -> None:
        """Add a :class:`Line`; ``look`` sets its width and dash."""
        self.items.append(Line(_floats(x), _floats(y), color, **look))

    def marks(self, x: ArrayLike, y: ArrayLike, color: str = COLORS[0], **look: Any) -> None:
        """Add :class:`Marks`; ``look`` sets their marker and size."""
        self.items.append(Marks(_floats(x), _floats(y), color, **look))

    def add(self, *items: Item) -> None:
        """Add items in front of all earlier ones."""
        self.items.extend(items)

    def cross(self) -> None:
        """Add thin lines at x = 0 and y = 0, behind all items."""
        self.items[:0] = [Guide(0.0, direction, "#888888", 0.6, ()) for direction in ("y", "x")]


@dataclass(frozen=True)
class Entry:
    """Legend entry: a name and the style of its line."""

    label: str
    color: str = COLORS[0]
    dash: tuple[float, ...] = ()
    marker: Marker | None = None
    line: bool = True


@dataclass
class Plot:
    """Page with a grid of panels and a legend below them."""

    panels: list[Panel]
    height: float = 5.6  # height of the page [in]; the width is 7.1 in
    title: str = ""  # above the panels
    heights: tuple[float, ...] = (1.0,)
    """Relative heights of the rows of the grid."""
    widths: tuple[float, ...] = (1.0,)  # relative widths of the columns
    legend: tuple[Entry, ...] = ()  # below the panels
    legend_title: str = ""


def stacked(
    panels: Sequence[Panel],
    height: float,
    heights: Sequence[float] = (),
    legend: Sequence[Entry] = (),
    title: str = "",
) -> Plot:
    """Return a page of panels one above the other with a common x axis, labelled at the last panel.

    Panels have equal heights unless ``heights`` are given; ``height`` is that of the page [in].
    """
    for row, panel in enumerate(panels):
        panel.cell = (row, row, 0, 0)
        panel.x.bare = row < len(panels) - 1
    heights = tuple(heights) or (1.0,) * len(panels)
    return Plot(list(panels), height, title, heights, legend=tuple(legend))


def _floats(values: ArrayLike) -> Floats:
    return np.atleast_1d(np.asarray(values, dtype=np.float64))
