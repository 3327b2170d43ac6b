"""Building blocks of figures: unit prefixes, ticks, line styles and colour maps."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.quantities import Quantity
from microslip._core.units import prefix
from microslip.figures.plot import (
    COLORS,
    DASHES,
    MARKERS,
    Area,
    Axis,
    Entry,
    Floats,
    Marker,
    Panel,
    Pixels,
    Plot,
)


def evenly(count: int, limit: int) -> list[int]:
    """Return up to ``limit`` evenly spaced indices of ``count`` items, first and last included."""
    size = min(count, limit)
    if size < 2:
        return list(range(size))
    return sorted({round(i * (count - 1) / (size - 1)) for i in range(size)})


def length_prefix(largest: float, smallest: float = 0.0) -> tuple[float, str]:
    """Return factor and unit prefix for lengths [m]: micrometres where these are suitable."""
    return (1e-6, "µ") if largest > 1e-7 and (smallest or largest) < 1e-3 else prefix(largest)


def envelope(values: Floats) -> NDArray[np.intp]:
    """Return the indices of the samples of a record that are drawn.

    Of a long record, these are the smallest and the largest value of each of 1500 blocks.
    """
    width = -(-values.size // 1500)
    if width <= 2:
        return np.arange(values.size)
    whole = values.size // width * width
    rows = values[:whole].reshape(-1, width)
    ends = np.sort(np.stack([rows.argmin(axis=1), rows.argmax(axis=1)]), axis=0)
    places = (ends + np.arange(0, whole, width)).T.ravel()
    return np.concatenate(([0], places, np.arange(whole, values.size)))


def far_apart(values: Sequence[float], factor: float = 20.0) -> bool:
    """Return True if positive values span more than a factor, too much for a linear axis."""
    return max(values) > factor * min(values)


def axis_of(
    quantity: Quantity, scale: float | tuple[float, str] = (1.0, ""), **options: Any
) -> Axis:
    """Return the axis of a quantity, with its label and unit: "Force [kN]".

    ``scale`` is the divisor of the values, which are in SI units, and the prefix of the unit:
    (1e3, "k"), or (0.01, "%") for a dimensionless quantity; a number is the largest value, for
    which a prefix is chosen. ``options`` are fields of the axis.
    """
    if not isinstance(scale, tuple):
        is_length = quantity.unit == "m"
        scale = (length_prefix if is_length else prefix)(scale if quantity.unit != "-" else 0.0)
    factor, letter = scale
    unit = re.sub(r"\^(\d)", lambda power: power[1].translate(_SUPERSCRIPTS), quantity.unit)
    unit = letter or "–" if unit == "-" else f"{letter}{unit}"
    return Axis(f"{quantity.label} [{unit}]" if unit else quantity.label, unit=factor, **options)


def time_axis(time: Floats) -> Axis:
    """Return the axis of times [s] from zero: with a prefix if they end before one second."""
    scale = prefix(float(time[-1])) if 0.0 < float(time[-1]) < 1.0 else (1.0, "")
    return axis_of(Quantity("s", label="Time"), scale, margin=0.0)


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MINUS = str.maketrans("-", "−")


class Ticks(NamedTuple):
    """Ticks along an axis."""

    major: tuple[tuple[float, str], ...]
    """Ticks with a grid line, and their labels."""
    minor: tuple[tuple[float, str], ...] = ()
    """Ticks between the major ticks; most have no label."""
    offset: str = ""
    """Power of ten omitted from all labels."""


def round_numbers(low: float, high: float, limit: int, log: bool, integer: bool = False) -> Ticks:
    """Return ticks from ``low`` to ``high`` with at most ``limit`` labels."""
    return logarithmic(low, high, limit) if log else linear(low, high, limit, integer)


def linear(low: float, high: float, limit: int, integer: bool = False) -> Ticks:
    """Return ticks at up to ``limit`` round numbers between two ends, in either order."""
    low, high = min(low, high), max(low, high)
    rough = (high - low) / max(limit, 1)
    power = math.floor(math.log10(rough))
    step = next(
        (n * 10.0**power for n in (1, 2, 2.5, 5) if n * 10.0**power >= rough * (1.0 - 1e-9)),
        10.0 ** (power + 1),
    )
    if integer:
        step = float(max(round(step), 1))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    values = [i * step for i in range(first, last + 1)]
    largest = max(abs(low), abs(high))
    scale = math.floor(math.log10(largest)) if largest > 0.0 else 0
    exponent = 0 if -3 <= scale <= 4 else scale
    texts = [_decimal(value / 10.0**exponent, step / 10.0**exponent) for value in values]
    offset = f"×10{str(exponent).translate(_SUPERSCRIPTS)}" if exponent else ""
    return Ticks(tuple(zip(values, texts, strict=True)), (), offset)


def logarithmic(low: float, high: float, limit: int) -> Ticks:
    """Return ticks at powers of ten between two ends, with minor ticks between them.

    At most ``limit`` powers of ten are labelled; within a decade ticks are at round numbers.
    """
    first, last = math.floor(math.log10(low) - 1e-9), math.ceil(math.log10(high) + 1e-9)
    inside = [n for n in range(first, last + 1) if 0.999999 * low <= 10.0**n <= 1.000001 * high]
    every = max(1, math.ceil(len(inside) / max(limit, 1)))
    powers = [n for n in inside if n % every == 0]
    major = tuple((10.0**n, log_label(10.0**n, low, high)) for n in powers)
    if every > 1:
        return Ticks(major, tuple((10.0**n, "") for n in inside if n % every))
    minor = [
        (k * 10.0**n, log_label(k * 10.0**n, low, high))
        for n in range(first, last + 1)
        for k in range(2, 10)
        if low < k * 10.0**n < high
    ]
    labelled = sum(bool(text) for _, text in (*major, *minor))
    if labelled < 2 or labelled > 2 * limit:  # within a decade, use round numbers
        return linear(low, high, min(limit, 4))
    return Ticks(major, tuple(minor))


def log_label(x: float, low: float, high: float) -> str:
    """Return the label of a tick on a logarithmic axis, empty for a tick without label.

    All labels of an axis have one style, either 0.1, 1, 10 or powers such as 10⁻⁶, that depends on
    its ends.
    """
    power = math.floor(math.log10(x) + 1e-9)
    factor = float(f"{x / 10.0**power:.5g}")
    decades = math.log10(high / low)
    if factor not in ((1,) if decades > 1.6 else (1, 2, 5) if decades > 0.5 else (factor,)):
        return ""
    if low >= 0.9e-4 and high <= 1.2e5:
        return f"{x:.6g}"
    exponent = str(power).translate(_SUPERSCRIPTS)
    return f"10{exponent}" if factor == 1 else f"{factor:g}·10{exponent}"


def _decimal(value: float, step: float) -> str:
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    if abs(step * 10**digits - round(step * 10**digits)) > 1e-6:  # steps of 2.5
        digits += 1
    text = f"{value:.{digits}f}"
    return "0" if float(text) == 0.0 and digits == 0 else text.translate(_MINUS)


EDGE = "#444444"
"""Color of a line that marks a position on an axis."""


class LineStyle(NamedTuple):
    """Style of a line; dashes or markers distinguish lines in greyscale."""

    color: str = COLORS[0]
    dash: tuple[float, ...] = ()
    marker: Marker = "o"

    def entry(self, label: str, *, line: bool = True, marked: bool = True) -> Entry:
        """Return a legend entry; ``line`` keeps the dashes, and ``marked`` keeps the marker."""
        return Entry(label, self.color, self.dash if line else (), self.marker if marked else None)


LOOKS = tuple(map(LineStyle, COLORS, DASHES, MARKERS))


def line_style(index: int) -> LineStyle:
    """Return the style of a line by its number; styles repeat."""
    return LOOKS[index % len(LOOKS)]


def pale(color: str, strength: float = 0.3) -> str:
    """Return a lighter shade of a colour, for areas behind lines of that colour."""
    parts = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - strength * (255 - part)):02x}" for part in parts)


# -- numbers on an axis ----------------------------------------------------------------------------


def drawable(values: Floats, log: bool = True) -> Floats:
    """Replace values that an axis cannot show by NaN: infinite, or for ``log`` not above zero."""
    return np.where(np.isfinite(values) & ((values > 0.0) | (not log)), values, np.nan)


# -- items of a panel ------------------------------------------------------------------------------


def between(x: Floats, low: Floats, high: Floats, color: str) -> Area:
    """Return the filled area between two curves over x, such as two quantiles."""
    fine = np.isfinite(x) & np.isfinite(low) & np.isfinite(high)
    x, low, high = x[fine], low[fine], high[fine]
    return Area(np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]]), color)


def map_panel(
    ends: tuple[float, float, float, float], scale: tuple[float, str], column: int = 0
) -> Panel:
    """Return a panel for a map over x and y; ``ends`` are the ranges of x and y in its unit."""
    x, y = (
        axis_of(Quantity("m", label=name), scale, low=low, high=high)
        for name, low, high in (("x", *ends[:2]), ("y", *ends[2:]))
    )
    return Panel(x, y, equal=True, grid=False, cell=(0, 0, column, column))


def scale_of_colours(axis: Axis, ramp: NDArray[np.uint8], cell: tuple[int, int, int, int]) -> Panel:
    """Return a panel that shows the colour scale of maps, over an axis with both ends."""
    pixels = Pixels(ramp, axis.low or 0.0, axis.high or 0.0, 0.0, 1.0)
    across = Axis(low=0.0, high=1.0, ticks=())
    return Panel(axis, across, grid=False, cell=cell, items=[pixels])


def with_scale(
    panels: Sequence[Panel],
    scale: Panel,
    room: float,
    rest: float,
    widths: tuple[float, ...] = (1.0,),
) -> Plot:
    """Return a page of maps above their colour scale.

    It is ``room`` [in] high per row of maps, plus ``rest`` [in] for all else. ``widths`` are the
    relative widths of the columns.
    """
    rows = 1 + max(panel.cell[1] for panel in panels)
    return Plot(
        [*panels, scale],
        room * rows + rest,
        heights=(*(1.0,) * rows, 0.14 / room),
        widths=widths,
    )


# -- values on a grid as colours -------------------------------------------------------------------

_MOST_PIXELS = 700
_MISSING = 255  # white
# Equidistant steps of cividis (Nuñez, Anderton and Renslow 2018, DOI
# 10.1371/journal.pone.0199239): suitable for colour-blind readers, lightness rises evenly.
_COLOURS = np.array(
    (
        (0, 34, 78), (0, 46, 106), (26, 56, 111), (50, 67, 109), (67, 78, 108), (83, 90, 109),
        (97, 101, 111), (111, 112, 115), (125, 124, 120), (140, 136, 120), (155, 148, 118),
        (171, 160, 114), (188, 174, 108), (205, 187, 99), (222, 201, 88), (240, 216, 70),
        (254, 232, 56),
    ),
    dtype=float,
)  # fmt: skip


def coloured(heights: Floats, low: float, high: float) -> NDArray[np.uint8]:
    """Return RGB bytes for heights; those beyond the ends are clipped, missing ones are white."""
    place = np.clip((heights - low) / (high - low if high > low else 1.0), 0.0, 1.0)
    missing = np.isnan(place)
    steps = np.arange(len(_COLOURS)) / (len(_COLOURS) - 1.0)
    table = np.stack([np.interp(np.arange(256) / 255.0, steps, c) for c in _COLOURS.T], axis=1)
    result: NDArray[np.uint8] = np.rint(table).astype(np.uint8)[
        np.where(missing, 0, np.rint(255.0 * np.nan_to_num(place))).astype(np.intp)
    ]
    result[missing] = _MISSING
    return result


def coarse(heights: Floats) -> Floats:
    """Return every k-th point of a map, so that it is at most 700 points wide.

    Means of blocks would flatten the summits.
    """
    step = max(1, math.ceil(max(heights.shape) / _MOST_PIXELS))
    return heights[::step, ::step]
