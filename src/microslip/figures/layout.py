"""Layout of a figure: positions of all parts on the page, shared by all renderers."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microslip.figures import plot as shapes
from microslip.figures.kit import Ticks, linear, round_numbers
from microslip.figures.plot import AxisName, Entry, Floats, Panel, Plot

PAGE = 7.1 * 72.0
TITLE, TEXT, SMALL = 10.0, 9.0, 8.5
"""Font sizes [pt]: title of the page, axis labels, all other text."""
_LINE = 1.25  # line spacing over font size
_HANDLE, _GAP, _SPACING = 19.0, 6.0, 16.0  # legend [pt]: line, gap to label, spacing
# Widths of the printable ASCII characters of DejaVu Sans, in hundredths of the font size.
_WIDTHS = (
    *(32, 40, 46, 84, 64, 95, 78, 27, 39, 39, 50, 84, 32, 36, 32, 34, 64, 64, 64, 64, 64, 64, 64),
    *(64, 64, 64, 34, 34, 84, 84, 84, 53, 100, 68, 69, 70, 77, 63, 58, 77, 75, 29, 29, 66, 56, 86),
    *(75, 79, 60, 79, 69, 63, 61, 73, 68, 99, 69, 61, 69, 39, 34, 39, 84, 50, 50, 61, 63, 55, 63),
    *(62, 35, 63, 63, 28, 28, 58, 28, 97, 63, 61, 63, 63, 41, 52, 39, 63, 59, 82, 59, 59, 52, 64),
    *(34, 64, 84),
)


def text_width(text: str, size: float) -> float:
    """Return the width [pt] of the widest line of a text, estimated for non-ASCII letters."""
    lines = text.split("\n")
    return size * max(
        sum(_WIDTHS[ord(c) - 32] if " " <= c <= "~" else 62 for c in line) / 100 for line in lines
    )


def wrapped(text: str, size: float, width: float) -> list[str]:
    """Break a text into lines up to ``width`` [pt], within words only if they are longer."""
    lines = [""]
    for word in re.findall(r"\S+", text):
        while text_width(word, size) > width:
            letters = max(1, int(len(word) * width / text_width(word, size)) - 1)
            lines += [word[:letters]]
            word = word[letters:]
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer, size) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return [line for line in lines if line]


class AxisScale(NamedTuple):
    """Axis with its ends and ticks, which converts values to positions along it."""

    low: float
    high: float
    log: bool
    ticks: Ticks = Ticks(())

    def share(self, values: Floats) -> Floats:
        """Return positions of values: 0 at the low end, 1 at the high end, NaN if undefined."""
        if self.log:
            with np.errstate(divide="ignore", invalid="ignore"):
                shares = np.log(values / self.low) / math.log(self.high / self.low)
        else:
            shares = (values - self.low) / (self.high - self.low)
        return np.where(np.isfinite(shares), shares, np.nan)


@dataclass
class PanelFrame:
    """Panel with its axes and its inner rectangle [pt] from the upper left corner of the page."""

    panel: Panel
    x: AxisScale
    y: AxisScale
    left: float = 0.0
    top: float = 0.0
    width: float = 1.0
    height: float = 1.0
    label_left: float = 0.0
    """Centre of the label of the vertical axis [pt]."""

    @property
    def right(self) -> float:
        """Position of the right edge [pt]."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Position of the lower edge [pt]."""
        return self.top + self.height

    def across(self, share: float) -> float:
        """Return the horizontal position [pt] at a fraction of the width, from the left."""
        return self.left + share * self.width

    def down(self, share: float) -> float:
        """Return the position [pt] on the page at a fraction of the height above the bottom."""
        return self.top + (1.0 - share) * self.height

    def points(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return positions on the page [pt], from the upper left corner, for values x and y."""
        # Points far outside are invisible, and renderers fail on huge numbers.
        across = np.clip(self.x.share(x), -20.0, 21.0)
        up = np.clip(self.y.share(y), -20.0, 21.0)
        return self.left + across * self.width, self.top + (1.0 - up) * self.height


class Handle(NamedTuple):
    """Legend entry with the position [pt] of its line: left end, and middle height."""

    entry: Entry
    left: float
    middle: float


@dataclass
class Page:
    """Figure with the positions [pt] of all its parts, from the upper left corner."""

    width: float
    height: float
    title: list[str]
    frames: list[PanelFrame]
    legend: list[Handle]
    legend_title: str
    legend_top: float


def lay_out(plot: Plot) -> Page:
    """Compute the positions of all parts of a figure."""
    height = 72.0 * plot.height
    title = wrapped(plot.title, TITLE, PAGE - 30.0)
    top = 6.0 + _LINE * TITLE * len(title)
    lines = _legend_lines(plot.legend)
    below = 4.0 + _LINE * SMALL * (len(lines) + bool(plot.legend_title)) if lines else 2.0
    bottom = height - below
    frames = [
        PanelFrame(p, AxisScale(*_ends(p, "x"), p.x.log), AxisScale(*_ends(p, "y"), p.y.log))
        for p in plot.panels
    ]
    # Ticks depend on the space and the space on the tick labels: one iteration is enough.
    _place(plot, frames, top, bottom)
    for frame in frames:
        frame.x, frame.y = _scale(frame, "x"), _scale(frame, "y")
    _place(plot, frames, top, bottom)
    return Page(
        PAGE,
        height,
        title,
        frames,
        _legend(lines, bottom + 4.0 + _LINE * SMALL * bool(plot.legend_title)),
        plot.legend_title,
        bottom + 4.0,
    )


# -- axes ----------------------------------------------------------------------------------------


def _ends(panel: Panel, direction: AxisName) -> tuple[float, float]:
    axis = panel.x if direction == "x" else panel.y
    low, high = axis.low, axis.high
    if low is None or high is None:
        values = _values_drawn(panel, direction)
        fine = np.isfinite(values) & (values > 0.0) if axis.log else np.isfinite(values)
        values = values[fine]
        if not values.size:
            values = np.array([1.0, 10.0] if axis.log else [0.0, 1.0])
        smallest, largest = float(values.min()), float(values.max())
        if axis.log:
            spare = (largest / smallest) ** axis.margin
            smallest, largest = smallest / spare, largest * spare
        else:
            spare = axis.margin * (largest - smallest)
            smallest, largest = smallest - spare, largest + spare
        low, high = smallest if low is None else low, largest if high is None else high
    if low == high:  # empty range
        half = 0.5 * (abs(low) or 1.0)
        low, high = (low / 1.2, high * 1.2) if axis.log else (low - half, high + half)
    return float(low), float(high)


def _values_drawn(panel: Panel, direction: AxisName) -> Floats:
    parts: list[Floats] = []
    for item in panel.items:
        if isinstance(item, (shapes.Line, shapes.Marks, shapes.Area)):
            parts.append(item.x if direction == "x" else item.y)
        elif isinstance(item, shapes.Pixels):
            sides = (item.left, item.right) if direction == "x" else (item.bottom, item.top)
            parts.append(np.array(sides))
        elif isinstance(item, shapes.Guide) and item.axis == direction:
            parts.append(np.array([item.value]))
        elif isinstance(item, shapes.Band) and item.axis == direction:
            parts.append(np.array([item.low, item.high]))
    return np.concatenate([np.zeros(0), *parts])


def _scale(frame: PanelFrame, direction: AxisName) -> AxisScale:
    scale, axis = (frame.x, frame.panel.x) if direction == "x" else (frame.y, frame.panel.y)
    if axis.ticks is not None:
        return scale._replace(ticks=Ticks(tuple(axis.ticks)))
    low, high = min(scale.low, scale.high), max(scale.low, scale.high)
    room = frame.width if direction == "x" else frame.height
    limit = max(2, min(9, int(room / (45.0 if direction == "x" else 24.0))))
    ticks = round_numbers(low, high, limit, axis.log, axis.integer)
    if direction == "x":  # horizontal labels must not overlap
        widest = max((text_width(text, SMALL) for _, text in ticks.major), default=0.0)
        count = sum(bool(text) for _, text in ticks.major)
        if count * (widest + 8.0) > room:
            limit = max(2, int(room / (widest + 8.0)))
            ticks = round_numbers(low, high, limit, axis.log, axis.integer)
        if not axis.log and len(ticks.major) < 2:  # a single label does not define a scale
            finer = linear(low, high, 2 * limit, axis.integer)
            widest = max((text_width(text, SMALL) for _, text in finer.major), default=0.0)
            every = max(1, math.ceil(len(finer.major) * (widest + 4.0) / room))
            ticks = finer._replace(major=finer.major[::every])
    return scale._replace(ticks=ticks)


# -- panels --------------------------------------------------------------------------------------


def _place(plot: Plot, frames: list[PanelFrame], top: float, bottom: float) -> None:
    columns, rows = len(plot.widths), len(plot.heights)
    left, right = [0.0] * columns, [0.0] * columns
    above, below = [0.0] * rows, [0.0] * rows
    for frame in frames:
        row, last_row, column, last_column = frame.panel.cell
        beside, behind = _sides(frame)
        left[column] = max(left[column], beside)
        right[last_column] = max(right[last_column], behind)
        over, under = _ends_of(frame)
        above[row] = max(above[row], over)
        below[last_row] = max(below[last_row], under)
    xs = _shares(3.0, PAGE - 3.0, left, right, plot.widths)
    ys = _shares(top, bottom, above, below, plot.heights)
    for frame in frames:
        row, last_row, column, last_column = frame.panel.cell
        frame.left, frame.top = xs[column][0], ys[row][0]
        frame.width = max(xs[last_column][1] - frame.left, 1.0)
        frame.height = max(ys[last_row][1] - frame.top, 1.0)
        if frame.panel.equal:
            _equalise(frame)
        lines = frame.panel.y.label.count("\n") + 1
        half = 0.5 * _LINE * TEXT * lines
        frame.label_left = frame.left - left[column] + half


def _equalise(frame: PanelFrame) -> None:
    """Make one unit equally long on both axes, with the axes centred in the panel."""
    across = abs(frame.x.high - frame.x.low)
    up = abs(frame.y.high - frame.y.low)
    unit = min(frame.width / across, frame.height / up)
    frame.left += 0.5 * (frame.width - unit * across)
    frame.top += 0.5 * (frame.height - unit * up)
    frame.width, frame.height = unit * across, unit * up


def _shares(
    begin: float,
    end: float,
    before: Sequence[float],
    after: Sequence[float],
    ratios: Sequence[float],
) -> list[tuple[float, float]]:
    room = end - begin - sum(before) - sum(after)
    places, here = [], begin
    for ahead, behind, ratio in zip(before, after, ratios, strict=True):
        here += ahead
        length = max(room * ratio / sum(ratios), 1.0)
        places.append((here, here + length))
        here += length + behind
    return places


def _label_width(scale: AxisScale) -> float:
    texts = [text for _, text in (*scale.ticks.major, *scale.ticks.minor)]
    return max((text_width(text, SMALL) for text in texts), default=0.0)


def _sides(frame: PanelFrame) -> tuple[float, float]:
    """Return the space on the left, for labels, and on the right of a panel [pt]."""
    axis = frame.panel.y
    lines = axis.label.count("\n") + 1 if axis.label else 0
    return 4.0 if axis.bare else 9.0 + _label_width(frame.y) + _LINE * TEXT * lines, 9.0


def _ends_of(frame: PanelFrame) -> tuple[float, float]:
    """Return the space for title and labels above and below a panel [pt]."""
    panel = frame.panel
    offset = frame.y.ticks.offset and not panel.note
    over = 15.0 if panel.note else 13.0 if offset else 6.0
    if panel.x.bare:
        return over, 3.0
    lines = panel.x.label.count("\n") + 1 if panel.x.label else 0
    return over, 7.0 + _LINE * SMALL + _LINE * TEXT * lines


# -- legend --------------------------------------------------------------------------------------


def _entry_width(entry: Entry) -> float:
    """Return the width of a legend entry [pt], including its line and spacing."""
    return _HANDLE + _GAP + text_width(entry.label, SMALL) + _SPACING


def _legend_lines(entries: Sequence[Entry]) -> list[list[Entry]]:
    lines: list[list[Entry]] = []
    room = 0.0
    for entry in entries:
        width = _entry_width(entry)
        if not lines or width > room:
            lines.append([])
            room = PAGE - 20.0
        lines[-1].append(entry)
        room -= width
    return lines


def _legend(lines: list[list[Entry]], top: float) -> list[Handle]:
    handles = []
    for number, line in enumerate(lines):
        widths = [_entry_width(entry) for entry in line]
        here = 0.5 * (PAGE - sum(widths) + _SPACING)
        for entry, width in zip(line, widths, strict=True):
            handles.append(Handle(entry, here, top + _LINE * SMALL * (number + 0.5)))
            here += width
    return handles
